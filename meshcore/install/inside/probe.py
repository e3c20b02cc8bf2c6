"""Runs inside a host's Python: tells, as one line of JSON, what that Python is and has."""

import importlib
import inspect
import json
import platform
import site
import sys
import sysconfig


def version_of(name):
    """Version of a library as it imports here, None if it is absent, the error's text if it is broken."""
    try:
        return str(importlib.import_module(name).__version__)
    except ModuleNotFoundError as error:
        return None if error.name == name else f"broken: {error}"
    except Exception as error:  # a library that was built for another numpy raises anything at all
        return f"broken: {error}"


def host():
    """Name and version of the program around this Python."""
    try:
        import paraview

        return "paraview", getattr(paraview, "__version_full__", paraview.__version__)
    except ImportError:
        pass
    try:
        import bpy

        return "blender", bpy.app.version_string.split()[0]
    except ImportError:
        return "", ""


def facts():
    """Everything that an installer wants to know."""
    name, version = host()
    return {
        "host": name,
        "version": version,
        "python": list(sys.version_info[:3]),
        "implementation": sys.implementation.name,
        "abi": sysconfig.get_config_var("SOABI") or "",
        "platform": sysconfig.get_platform(),
        "glibc": platform.libc_ver()[1] if platform.libc_ver()[0] == "glibc" else "",
        "machine": platform.machine(),
        "macos": platform.mac_ver()[0],
        "executable": sys.executable or "",
        "user_site": site.getusersitepackages() if site.ENABLE_USER_SITE else "",
        "getargspec": hasattr(inspect, "getargspec"),
        "libraries": {library: version_of(library) for library in ("numpy", "scipy", "numba", "llvmlite", "meshcore")},
    }


if __name__ == "__main__":
    print("MESHCORE " + json.dumps(facts()))
