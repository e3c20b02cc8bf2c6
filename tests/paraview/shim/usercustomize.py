"""ParaView 5.11 on Python 3.11 asks for a function that Python 3.11 dropped; Python runs this file at its start."""

import inspect

if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec
