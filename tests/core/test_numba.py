"""The kernel decorator and its cache."""

import ast
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import meshcore
from meshcore import _numba
from meshcore._numba import kernel

PACKAGE = Path(meshcore.__file__).parent
ALLOWED = {"numpy", "numba", "math", "__future__"}


@pytest.fixture
def copy(tmp_path):
    """A package with meshcore's decorator, two kernel files that call each other, and a program that runs them."""
    package = tmp_path / "meshcore"
    package.mkdir()
    (package / "__init__.py").write_text("")
    shutil.copy(PACKAGE / "_numba.py", package)
    (package / "_callee_kernels.py").write_text(
        "from ._numba import kernel\n\n\n@kernel\ndef callee(x):\n    return x + 1\n"
    )
    (package / "_caller_kernels.py").write_text(
        "from ._callee_kernels import callee\nfrom ._numba import kernel\n\n\n"
        "@kernel\ndef caller(x):\n    return 10 * callee(x)\n"
    )

    def run(expression: str = "print(caller(4), dict(caller.stats.cache_hits))") -> str:
        code = f"from meshcore._caller_kernels import caller; from meshcore import _numba; {expression}"
        env = {**os.environ, "PYTHONPATH": str(tmp_path), "MESHCORE_CACHE_DIR": str(tmp_path / "cache")}
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    run.package, run.cache = package, tmp_path / "cache"
    return run


def test_a_second_process_finds_the_machine_code(copy):
    assert copy() == "50 {}"
    assert copy() == "50 {(int64,): 1}"


def test_an_edited_callee_in_another_file_gives_the_new_answer(copy):
    assert copy().startswith("50")
    callee = copy.package / "_callee_kernels.py"
    callee.write_text(callee.read_text().replace("x + 1", "x + 2"))
    assert copy() == "60 {}"
    callee.write_text(callee.read_text().replace("x + 2", "x + 1"))
    assert copy() == "50 {(int64,): 1}"  # the old code's folder is still there, and right again


def test_an_edit_leaves_the_code_of_others_where_it_is(copy):
    copy("import meshcore._callee_kernels as c; print(c.callee(1), caller(4))")
    caller = copy.package / "_caller_kernels.py"
    caller.write_text(caller.read_text().replace("10 *", "20 *"))
    asked = "import meshcore._callee_kernels as c; print(c.callee(1), caller(4), dict(c.callee.stats.cache_hits))"
    assert copy(asked) == "2 100 {(int64,): 1}"


def test_imports_of_kernel_files_are_followed():
    files = {path.stem: path for path in _numba.kernel_sources()}
    found = {path.stem for path in _numba.imported_kernels(files["_front_kernels"])}
    assert found >= {"_front_kernels", "_refinement_kernels", "_half_edge_kernels", "_predicates_kernels"}
    assert "_delaunay_3d_kernels" not in found
    for path in files.values():  # the pattern misses no way of writing an import
        direct = {name for name in imports_of(path) if name.endswith("_kernels")}
        assert direct <= {p.stem for p in _numba.imported_kernels(path)}


def test_a_damaged_cache_file_means_compiling_again(copy):
    copy()
    for file in copy.cache.rglob("*.nbc"):
        file.write_bytes(b"not machine code")
    assert copy() == "50 {}"
    for file in copy.cache.rglob("*.nbi"):
        file.write_bytes(b"")
    assert copy() == "50 {}"


def test_signatures_saved_by_two_processes_at_once_do_not_mix(copy):
    copy("print(caller(4))")
    index, data = sorted(p for p in copy.cache.rglob("*caller*.nb?") if "callee" not in p.name)[::-1]
    index.rename(index.with_suffix(".kept"))  # as another process sees it that began before the first had saved
    copy("print(caller(4.5))")
    assert len(list(copy.cache.rglob("*caller*.nbc"))) == 2 and data.exists()
    index.with_suffix(".kept").replace(index)  # the first process's index comes last
    assert copy() == "50 {(int64,): 1}"
    assert copy("print(caller(4.5))") == "55.0"


def test_an_unusable_cache_folder_is_no_obstacle(copy):
    copy.cache.write_text("a file where the folder should be")
    assert copy("print(caller(4), str(_numba.cache_folder()).startswith(_numba.tempfile.gettempdir()))") == "50 True"


def test_global_configuration_of_numba_is_left_alone(copy):
    program = "import numba; print(numba.config.CACHE_DIR == '', 'NUMBA_CACHE_DIR' in __import__('os').environ)"
    assert copy(program) == "True False"


def test_stale_folders_are_cleaned_and_fresh_ones_kept(monkeypatch, tmp_path):
    monkeypatch.setenv("MESHCORE_CACHE_DIR", str(tmp_path))
    _numba.cache_folder.cache_clear()
    try:
        current = _numba.cache_folder()
        for name, age in {"kernels-old": 31, "kernels-new": 1}.items():
            (tmp_path / name).mkdir()
            then = __import__("time").time() - age * 86400
            os.utime(tmp_path / name, (then, then))
        for name, age in {"edited_kernels-old": 31, "edited_kernels-new": 1}.items():
            (current / name).mkdir()
            then = __import__("time").time() - age * 86400
            os.utime(current / name, (then, then))
        (tmp_path / "someone-elses").mkdir()
        assert _numba.clean_cache() == 2
        assert {p.name for p in current.iterdir()} == {"edited_kernels-new"}
        assert {p.name for p in tmp_path.iterdir()} == {current.name, "kernels-new", "someone-elses"}
    finally:
        _numba.cache_folder.cache_clear()


def test_kernels_run_side_by_side_without_the_gil():
    @kernel
    def wait_for(flag, mine, other, limit):
        flag[mine] = 1
        while flag[other] == 0 and flag[mine] < limit:
            flag[mine] += 1  # a store, so that the other flag is read anew
        return flag[other] > 0

    flag = np.zeros(2, np.int64)
    wait_for(np.ones(2, np.int64), 0, 1, 1)  # compile before the race
    met = []
    threads = [threading.Thread(target=lambda m=m: met.append(wait_for(flag, m, 1 - m, 10**10))) for m in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert met == [True, True]


def test_only_kernels_that_allocate_count_references():
    @kernel(inline=True)
    def element(array, k):
        return array[k]

    @kernel
    def total(array):
        found = 0.0
        for k in range(len(array)):
            if array[k] > 0.0:
                found += element(array, k)
        return found

    @kernel(allocates=True)
    def total_of_copy(array):
        own = np.empty(len(array))
        for k in range(len(array)):
            own[k] = array[k]
        return total(own)

    array = np.arange(5.0)
    assert total(array) == total_of_copy(array) == 10
    assert not any("NRT_" in text for text in total.inspect_llvm().values())
    assert any("NRT_" in text for text in total_of_copy.inspect_llvm().values())
    assert sys.getrefcount(array) == 2


def test_division_follows_ieee_and_does_not_raise():
    @kernel
    def divide(a, b):
        return a / b

    assert divide(1.0, 0.0) == np.inf and np.isnan(divide(0.0, 0.0))


def imports_of(path: Path) -> set[str]:
    """Top-level names and kernel modules that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(node.module.split(".")[0] if node.level == 0 else node.module.split(".")[-1])
    return found


@pytest.mark.parametrize("path", _numba.kernel_sources(), ids=lambda p: p.stem)
def test_a_kernel_file_imports_numbers_and_kernels_only(path):
    for name in imports_of(path) - ALLOWED:
        assert name == "_numba" or name.endswith("_kernels"), f"{path.name} imports {name}"


@pytest.mark.parametrize("path", _numba.kernel_sources(), ids=lambda p: p.stem)
def test_kernels_neither_raise_nor_print(path):
    for node in ast.walk(ast.parse(path.read_text())):
        assert not isinstance(node, (ast.Raise, ast.Assert)), f"{path.name}:{node.lineno}"
        called = getattr(getattr(node, "func", None), "id", "")
        assert called != "print", f"{path.name}:{node.lineno}"


def test_no_file_of_the_package_goes_round_the_decorator():
    for path in PACKAGE.rglob("*.py"):
        if path.name != "_numba.py" and "_hosts" not in path.parts:
            names = {a.attr for a in ast.walk(ast.parse(path.read_text())) if isinstance(a, ast.Attribute)}
            assert not names & {"njit", "jit", "vectorize", "guvectorize", "stencil"}, path
