# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the extension's zip for one Python and one platform.

Plain Python beside meshcore, no bpy: ``python blender_addon/build.py --python 3.11 --platform linux-x64``.
The zip carries the wheels of meshcore, numba, llvmlite and scipy, never numpy, which Blender has of its own.
The same inputs give the same bytes.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import json
import shutil
import string
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable
from pathlib import Path
from platform import machine
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
MODULES = (
    "__init__.py",
    "convert.py",
    "inputs.py",
    "jobs.py",
    "operators.py",
    "overrides.py",
    "panels.py",
    "preferences.py",
    "properties.py",
    "results.py",
    "selection.py",
    "volume.py",
)
LIBRARIES = ("numba", "llvmlite", "scipy")
_EPOCH = (1980, 1, 1, 0, 0, 0)


class Target(NamedTuple):
    """The Blender versions of one Python: first one, first one after, and the oldest numpy among them."""

    version_min: str
    version_max: str
    numpy: str


TARGETS = {"3.11": Target("4.5.0", "5.1.0", "1.26.4"), "3.13": Target("5.1.0", "", "2.3.4")}
"""Blender 4.5 is the first with numpy 1.26, which today's scipy needs."""

PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
    "macos-x64": ("macosx_12_0_x86_64", "macosx_11_0_x86_64", "macosx_10_15_x86_64"),
}


def build(folder: str | Path, *, python: str = "3.11", platform: str = "linux-x64", wheels: bool = True) -> Path:
    """Write the extension's zip into a folder.

    Parameters
    ----------
    folder : path
        Where the zip goes; made if need be.
    python : str
        Python of the Blender that it is for: "3.11" (Blender 4.5 to 5.0) or "3.13" (5.1 on).
    platform : str
        "linux-x64", "windows-x64", "macos-arm64" or "macos-x64".
    wheels : bool
        False leaves the wheels out, for a Blender whose Python has meshcore already.

    Returns
    -------
    Path
        The zip.

    Raises
    ------
    ValueError
        If no Blender has that Python or runs on that platform.
    RuntimeError
        If pip cannot download the wheels; the message is pip's.
    """
    import meshcore

    if python not in TARGETS:
        raise ValueError(f"no Blender that is supported has Python {python}; known are {', '.join(TARGETS)}")
    if platform not in PLATFORMS:
        raise ValueError(f"platform {platform!r} is not one of {', '.join(PLATFORMS)}")
    if platform == "macos-x64" and python != "3.11":
        raise ValueError(f"no Blender with Python {python} runs on macos-x64; Blender 4.5, with 3.11, was the last")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        bundled = _wheels(Path(scratch), python, platform) if wheels else []
        files = {name: (HERE / name).read_bytes() for name in MODULES}
        files["LICENSE"] = (HERE / "LICENSE").read_bytes()
        files["operations.json"] = declarations().encode()
        files["blender_manifest.toml"] = _manifest(meshcore.__version__, python, platform, bundled).encode()
        files.update({f"wheels/{wheel.name}": wheel.read_bytes() for wheel in bundled})
    tag = f"cp{python.replace('.', '')}-{platform.replace('-', '_')}"
    target = folder / f"meshcore-{meshcore.__version__}-{tag}{'' if wheels else '-without-wheels'}.zip"
    _write_zip(target, files.items())
    return target


def declarations() -> str:
    """All that the extension must know of meshcore before it may import it, as JSON."""
    import meshcore
    from meshcore import quality

    operations = {identifier: op.declaration() for identifier, op in meshcore.operations().items()}
    return json.dumps(
        {"version": meshcore.__version__, "operations": operations, "measures": list(quality.measures())}, indent=1
    )


def this_platform() -> str:
    """The platform that this runs on, in the words of Blender's manifests."""
    system = {"win32": "windows", "darwin": "macos"}.get(sys.platform, "linux")
    return f"{system}-{'arm64' if machine().lower() in ('arm64', 'aarch64') else 'x64'}"


def _manifest(version: str, python: str, platform: str, wheels: list[Path]) -> str:
    target = TARGETS[python]
    template = string.Template((HERE / "blender_manifest.toml").read_text(encoding="utf-8"))
    return template.substitute(
        version=version,
        version_min=target.version_min,
        version_max=f'blender_version_max = "{target.version_max}"' if target.version_max else "",
        platforms=json.dumps([platform]),
        wheels=json.dumps([f"./wheels/{wheel.name}" for wheel in wheels], indent=2),
    )


def _wheels(scratch: Path, python: str, platform: str) -> list[Path]:
    """meshcore's wheel and those of the libraries that Blender lacks, as their makers published them."""
    _download(scratch, python, platform)
    for numpy in scratch.glob("numpy-*.whl"):
        numpy.unlink()
    _meshcore_wheel(scratch)
    return sorted(scratch.glob("*.whl"))


def _download(scratch: Path, python: str, platform: str) -> None:
    """Let pip choose versions that fit each other and that Blender's numpy."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    command += ["--only-binary=:all:", "--implementation", "cp", "--python-version", python, "--dest", str(scratch)]
    for tag in PLATFORMS[platform]:
        command += ["--platform", tag]
    done = subprocess.run([*command, *LIBRARIES, f"numpy=={TARGETS[python].numpy}"], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"pip could not download {', '.join(LIBRARIES)} for Python {python}:\n{done.stderr.strip()}")


def _meshcore_wheel(folder: Path) -> Path:
    """A wheel of the meshcore that runs this, from a checkout or installed, without its host adapters."""
    import meshcore

    package = Path(meshcore.__file__).parent
    files = {
        f"meshcore/{path.relative_to(package).as_posix()}": path.read_bytes()
        for path in sorted(package.rglob("*"))
        if path.is_file() and not {"__pycache__", "_hosts"} & set(path.relative_to(package).parts)
    }
    info = f"meshcore-{meshcore.__version__}.dist-info"
    summary = "Structured, unstructured and adaptive mesh generation"
    about = {"Metadata-Version": "2.1", "Name": "meshcore", "Version": meshcore.__version__, "Summary": summary}
    files[f"{info}/METADATA"] = "".join(f"{key}: {value}\n" for key, value in about.items()).encode()
    files[f"{info}/WHEEL"] = b"Wheel-Version: 1.0\nGenerator: meshcore\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    files[f"{info}/licenses/LICENSE"] = _licence(package)
    record = [f"{name},sha256={_digest(content)},{len(content)}" for name, content in files.items()]
    files[f"{info}/RECORD"] = ("\n".join([*record, f"{info}/RECORD,,"]) + "\n").encode()
    wheel = folder / f"meshcore-{meshcore.__version__}-py3-none-any.whl"
    _write_zip(wheel, files.items())
    return wheel


def _licence(package: Path) -> bytes:
    """meshcore's own licence: at the root of a checkout, or in the installed distribution."""
    places = [package.parent / "LICENSE", *package.parent.glob("meshcore-*.dist-info/licenses/LICENSE")]
    found = next((place for place in places if place.is_file()), None)
    return found.read_bytes() if found else b"BSD-3-Clause\n"


def _digest(content: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def _write_zip(target: Path, files: Iterable[tuple[str, bytes]]) -> None:
    """A zip with fixed times and modes; written beside its place first, so that no half a zip is left."""
    partial = target.with_suffix(".partial")
    with zipfile.ZipFile(partial, "w") as archive:
        for name, content in sorted(files):
            entry = zipfile.ZipInfo(name, date_time=_EPOCH)
            entry.external_attr = 0o644 << 16
            entry.create_system = 3
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".whl") else zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    shutil.move(partial, target)


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description="Build the extension's zip.")
    parser.add_argument("--python", default="3.11", choices=list(TARGETS), help="Python of that Blender")
    parser.add_argument("--platform", default=this_platform(), choices=list(PLATFORMS), help="default: %(default)s")
    parser.add_argument("--without-wheels", action="store_true", help="only the add-on itself")
    parser.add_argument("folder", nargs="?", default="dist", help="where the zip goes (default: %(default)s)")
    given = parser.parse_args(arguments)
    zip_path = build(given.folder, python=given.python, platform=given.platform, wheels=not given.without_wheels)
    print(f"{zip_path}  {zip_path.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
