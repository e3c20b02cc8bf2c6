"""The list of plugins in ParaView's own settings file, edited in place and nothing else touched.

ParaView keeps it as XML in one quoted line of an INI file, a line for each program that was run::

    [PluginsList]
    Local%3A\\usr\\bin\\paraview="<?xml version=\\"1.0\\" ?>\\n<Plugins>\\n  <Plugin name=... />\\n</Plugins>\\n"
"""

from __future__ import annotations

import os
import re
from pathlib import Path

SECTION = "[PluginsList]"
_EMPTY = r"<?xml version=\"1.0\" ?>\n<Plugins>\n</Plugins>\n"


def settings_key(program: Path) -> str:
    """The key of a program's plugins, in the letters of Qt's INI files.

    Examples
    --------
    >>> from pathlib import PurePosixPath
    >>> print(settings_key(PurePosixPath("/opt/Para View/bin/paraview")))
    Local%3A\\opt\\Para%20View\\bin\\paraview
    """
    key = []
    for letter in f"Local:{program.as_posix()}":
        if letter == "/":
            key.append("\\")
        elif letter.isascii() and (letter.isalnum() or letter in "_-."):
            key.append(letter)
        else:
            key.append(f"%{ord(letter):02X}" if ord(letter) < 256 else f"%U{ord(letter):04X}")
    return "".join(key)


def added(text: str, key: str, name: str, file: Path) -> str:
    """The settings with a plugin that loads at start.

    Examples
    --------
    >>> text = added("[Other]\\nx=1\\n", "Local%3Aparaview", "demo", Path("demo.py"))
    >>> removed(text, "demo") == "[Other]\\nx=1\\n"
    True
    """
    text = removed(text, name)
    entry = rf"  <Plugin name=\"{name}\" filename=\"{_quoted(file.as_posix())}\" auto_load=\"1\" />\n"
    line = re.search(rf"^{re.escape(key)}=.*$", text, flags=re.MULTILINE)
    if line and "</Plugins>" in line.group():
        changed = line.group().replace("</Plugins>", entry + "</Plugins>", 1)
        return text[: line.start()] + changed + text[line.end() :]
    if line:
        text = text[: line.start()] + text[line.end() + 1 :]
    new = f'{key}="{_EMPTY.replace("</Plugins>", entry + "</Plugins>")}"\n'
    if SECTION in text:
        return text.replace(f"{SECTION}\n", f"{SECTION}\n{new}", 1)
    gap = "\n" if text else ""
    return f"{text}{gap}{SECTION}\n{new}"


def removed(text: str, name: str) -> str:
    """The settings without a plugin, and without a line or section that held nothing else."""
    text = re.sub(rf'  <Plugin name=\\"{re.escape(name)}\\" [^>]*?/>\\n', "", text)
    text = re.sub(rf'^Local%3A[^=\n]*="{re.escape(_EMPTY)}"\n', "", text, flags=re.MULTILINE)
    return re.sub(r"\n?^\[PluginsList\]\n(?=\n*(\[|\Z))", "", text, flags=re.MULTILINE)


def read(file: Path) -> str:
    """The text of a settings file, with line ends as on Unix; empty if there is none."""
    return _bytes(file).decode("latin-1").replace("\r\n", "\n")


def write(file: Path, text: str) -> None:
    """Put a settings file in place at once; an empty one goes away."""
    if not text:
        file.unlink(missing_ok=True)
        return
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_name(file.name + ".meshcore")
    if b"\r\n" in _bytes(file):
        text = text.replace("\n", "\r\n")
    partial.write_bytes(text.encode("latin-1"))
    if file.exists():
        partial.chmod(file.stat().st_mode & 0o777)
    os.replace(partial, file)


def _bytes(file: Path) -> bytes:
    return file.read_bytes() if file.is_file() else b""


def _quoted(text: str) -> str:
    """Text for an XML attribute inside a quoted INI value, which may hold ASCII only."""
    escaped = text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return "".join(c if c.isascii() else f"&#{ord(c)};" for c in escaped)
