"""The one decorator for compiled kernels, and the cache they are kept in.

numba notices a change of a kernel's own file only, not of a callee in another file: an old machine code would be
run. So each kernel file has a cache folder of its own, named by a hash of its source and of all kernel files that it
imports, inside one named by the versions beneath. An edit compiles anew what depends on it, and nothing else.
The folder is the user's own; numba's global configuration stays as it is, since the host may use numba too.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import pickle
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core import caching, config

STALE_DAYS = 30
_PACKAGE = Path(__file__).parent


def kernel_sources() -> list[Path]:
    """All kernel files of the package, in a fixed order."""
    return sorted(_PACKAGE.rglob("_*_kernels.py"))


_KERNEL_IMPORT = re.compile(r"^from (\.+)([\w.]*_kernels) import", re.MULTILINE)


def imported_kernels(path: Path) -> set[Path]:
    """The kernel files that a kernel file imports, directly or through others, and itself."""
    found, ahead = set(), [path]
    while ahead:
        file = ahead.pop()
        if file not in found:
            found.add(file)
            for dots, module in _KERNEL_IMPORT.findall(file.read_text(encoding="utf-8")):
                ahead.append(file.parents[len(dots) - 1].joinpath(*module.split(".")).with_suffix(".py"))
    return found


@functools.cache
def kernel_hash(path: Path) -> str:
    """Hash of a kernel file and of all kernel files that it imports."""
    digest = hashlib.sha256()
    for file in sorted(imported_kernels(path)):
        digest.update(file.relative_to(_PACKAGE).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def _version_hash() -> str:
    """Hash of what compiles the kernels."""
    digest = hashlib.sha256(f"{sys.version_info[:2]} {numba.__version__} {np.__version__}".encode())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()[:16]


def _user_cache() -> Path:
    if folder := os.environ.get("MESHCORE_CACHE_DIR"):
        return Path(folder)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "meshcore" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "meshcore"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "meshcore"


@functools.cache
def cache_folder() -> Path:
    """A writable folder for compiled kernels: ``MESHCORE_CACHE_DIR``, the user's cache, or a temporary one."""
    uid = os.getuid() if hasattr(os, "getuid") else "user"
    for root in (_user_cache, lambda: Path(tempfile.gettempdir()) / f"meshcore-{uid}"):
        # A home that is unknown, read-only or full is no reason to fail: the next folder will do.
        with contextlib.suppress(OSError, RuntimeError):
            folder = root() / f"kernels-{_version_hash()}"
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
            os.utime(folder)
            return folder
    return Path(tempfile.mkdtemp(prefix="meshcore-"))


def clean_cache() -> int:
    """Remove what was not used for `STALE_DAYS`: folders of other versions, and of kernel files as they were."""
    removed = 0
    for folder in [*cache_folder().parent.glob("kernels-*"), *cache_folder().iterdir()]:
        if folder != cache_folder() and time.time() - folder.stat().st_mtime > STALE_DAYS * 86400:
            shutil.rmtree(folder, ignore_errors=True)
            removed += 1
    return removed


@functools.cache
def _folder_of(path: Path) -> Path:
    """Where the machine code of a kernel file is kept; marked as used."""
    folder = cache_folder() / f"{path.stem.strip('_')}-{kernel_hash(path)}"
    with contextlib.suppress(OSError):  # numba makes the folder when it saves
        os.utime(folder)
    return folder


class _Locator(caching._CacheLocator):
    """Tells numba to keep a kernel in its file's folder, fresh as long as `kernel_hash` stands."""

    def __init__(self, py_func: Callable[..., Any]):
        self._path = Path(py_func.__code__.co_filename)
        place = f"{py_func.__module__}:{py_func.__code__.co_firstlineno}"
        self._disambiguator = hashlib.sha256(place.encode()).hexdigest()[:12]

    def get_cache_path(self) -> str:
        return str(_folder_of(self._path))

    def get_source_stamp(self) -> str:
        return kernel_hash(self._path)

    def get_disambiguator(self) -> str:
        return self._disambiguator

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> _Locator:
        return cls(py_func)


class _CacheFile(caching.IndexDataCacheFile):
    """An index whose data files are named by what they hold.

    numba numbers them in the order of saving, so that two processes at work at once, such as two MPI ranks, may write
    the code of different signatures to one file, and a third would run the wrong one. Now they can only lose an
    entry of the index, which means compiling again.
    """

    def save(self, key: Any, data: Any) -> None:
        number = int.from_bytes(hashlib.sha256(repr(key).encode()).digest()[:6], "big")
        self._save_data(self._data_name(number), data)
        self._save_index({**self._load_index(), key: self._data_name(number)})


class _CacheImpl(caching.CompileResultCacheImpl):
    _locator_classes = [_Locator]


class _Cache(caching.FunctionCache):
    """A cache that is a convenience only: a damaged or unwritable file means compiling again."""

    _impl_class = _CacheImpl

    def __init__(self, py_func: Callable[..., Any]):
        super().__init__(py_func)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _CacheFile(self.cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a damaged pickle raises anything at all
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with contextlib.suppress(OSError):  # a full or read-only disk
            try:
                super().save_overload(sig, data)
            except (pickle.UnpicklingError, EOFError, ValueError, AttributeError, ImportError):  # a damaged index
                self.flush()
                super().save_overload(sig, data)


def kernel(function: Callable[..., Any] | None = None, *, inline: bool = False, allocates: bool = False) -> Any:
    """Compile ``function`` at its first call, without the GIL, and keep the machine code for the next process.

    Parameters
    ----------
    function : callable
        Works on numbers and arrays only, never raises, and returns a status.
    inline : bool
        Inline into each caller; for helpers of a few lines on a hot path.
    allocates : bool
        Whether it makes arrays of its own, and so needs numba's counts of references. All others do without: arrays
        belong to the caller, who holds them while the kernel runs, and counting, atomic as it is, at every inlined
        helper took more than half of the time of the kernels of Delaunay refinement.

    Returns
    -------
    numba dispatcher

    Notes
    -----
    Never fastmath: exact predicates rely on IEEE arithmetic. Never parallel: two host threads inside numba's
    parallel layer abort the process. ``MESHCORE_BOUNDSCHECK=1`` compiles with checked subscripts, for tests.

    Examples
    --------
    >>> @kernel
    ... def double(x):
    ...     return 2 * x
    >>> double(21)
    42
    """
    if function is None:
        return functools.partial(kernel, inline=inline, allocates=allocates)
    check = os.environ.get("MESHCORE_BOUNDSCHECK") == "1"
    options: dict[str, Any] = {"inline": "always"} if inline else {}
    # Said outright in both cases: a callee would inherit it from its caller.
    options["_nrt"] = allocates
    dispatcher = numba.njit(nogil=True, error_model="numpy", boundscheck=check, **options)(function)
    from_a_kernel_file = _PACKAGE in Path(function.__code__.co_filename).parents
    if not config.DISABLE_JIT and not check and not inline and from_a_kernel_file:
        dispatcher._cache = _Cache(dispatcher.py_func)
    return dispatcher
