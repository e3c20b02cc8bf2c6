# SPDX-License-Identifier: GPL-3.0-or-later
"""One call of an operation, run at once or in a thread of its own; it never touches Blender's data."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

COMPILING = "compiling (at the first call only)"


class Job:
    """A call that tells how far it is and can be stopped.

    Parameters
    ----------
    call : callable
        Called with ``progress=``, a function of fraction and message that returns False to stop it.
    watch : callable, optional
        Told of each progress, in the thread that runs the call.

    Attributes
    ----------
    fraction, message
        How far the call is.
    result, error
        What it returned or raised.
    """

    def __init__(self, call: Callable[..., Any], watch: Callable[[float, str], None] | None = None):
        self.fraction, self.message = 0.0, COMPILING
        self.result: Any = None
        self.error: Exception | None = None
        self._call, self._watch = call, watch
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def progress(self, fraction: float, message: str) -> bool:
        """What the call reports to; False once it is to stop."""
        self.fraction, self.message = fraction, message
        if self._watch:
            self._watch(fraction, message)
        return not self._stop.is_set()

    def run(self) -> None:
        """Call, here and now."""
        try:
            self.result = self._call(progress=self.progress)
        except Exception as error:  # a thread's exception would be lost; whoever waits for the job handles it
            self.error = error

    def start(self) -> None:
        """Call in a thread."""
        self._thread = threading.Thread(target=self.run, daemon=True)
        self._thread.start()

    def wait(self, seconds: float) -> bool:
        """Whether the call has ended, within some time."""
        if self._thread is not None:
            self._thread.join(seconds)
        return self._thread is None or not self._thread.is_alive()

    def stop(self) -> None:
        """Ask the call to stop; it does so at its next progress."""
        self._stop.set()
        self.message = "stopping"

    @property
    def status(self) -> str:
        """One line for the status bar."""
        hint = "" if self._stop.is_set() else "   Esc: cancel"
        return f"meshcore: {self.message}  {100 * self.fraction:.0f} %{hint}"
