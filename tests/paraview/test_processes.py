"""Two ranks, a server with its client, progress and abort, and a Python that lacks something."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from .conftest import HERE, INSIDE, PACKAGES, ROOT, assert_passed, checks_of

TWO_RANKS = ("mpirun", "--oversubscribe", "-np", "2", "pvbatch", "--sym")


@pytest.mark.parametrize("check", checks_of("parallel.py"))
def test_two_ranks(host, check):
    assert_passed(host.run("parallel.py", *TWO_RANKS, ranks=2), check)


@pytest.mark.parametrize("check", checks_of("progress.py"))
def test_progress(host, check):
    assert_passed(host.run("progress.py"), check)


@pytest.fixture(scope="module")
def port(host):
    """The port of a running pvserver."""
    with socket.socket() as free:
        free.bind(("localhost", 0))
        number = free.getsockname()[1]
    with open(host.folder / "server.log", "w+b") as log:
        command = ["pvserver", f"--server-port={number}"]
        server = subprocess.Popen(command, env=host.environment(), cwd=host.folder, stdout=log, stderr=log)
        try:
            for _ in range(300):
                log.seek(0)
                if b"Accepting connection" in log.read():
                    break
                assert server.poll() is None, "pvserver ended at once"
                time.sleep(0.1)
            yield str(number)
        finally:
            server.terminate()
            server.wait(30)


@pytest.mark.parametrize("check", checks_of("client.py"))
def test_client_and_server(host, port, check):
    assert_passed(host.run("client.py", "env", f"PORT={port}", "pvpython"), check)


def test_without_numba_the_plugin_loads_and_says_what_it_lacks(host):
    path = os.pathsep.join(map(str, [HERE / "shim", ROOT]))
    code, output = host.execute("pvpython", INSIDE / "missing.py", PYTHONPATH=path)
    assert code == 0 and "the plugin is loaded" in output, output
    assert "meshcore Model: ParaView's Python cannot import numba" in output, output
    assert "meshcore install paraview" in output and "Traceback" not in output, output


def test_without_meshcore_the_plugin_loads_and_says_what_it_lacks(host):
    path = os.pathsep.join(map(str, [HERE / "shim", PACKAGES]))
    code, output = host.execute("pvpython", INSIDE / "missing.py", PYTHONPATH=path)
    assert code == 0 and "the plugin is loaded" in output, output
    assert "meshcore Model: ParaView's Python cannot import meshcore" in output, output
    assert "meshcore Reader: ParaView's Python cannot import meshcore" in output, output
    assert "Traceback" not in output, output


def test_packages_beside_the_plugin_are_found(host, tmp_path):
    packages = tmp_path / "packages"
    shutil.copytree(PACKAGES, packages, ignore=shutil.ignore_patterns("kernels", "__pycache__"))
    (packages / "meshcore").symlink_to(ROOT / "meshcore")
    plugin = shutil.copy(host.plugin, tmp_path)
    more = {"PYTHONPATH": str(HERE / "shim"), "MESHCORE_PLUGIN": str(plugin)}
    code, output = host.execute("pvpython", INSIDE / "missing.py", **more)
    assert code == 0 and "the model has 12 cells" in output, output


def test_a_plugin_of_another_version_says_so(host, tmp_path):
    text = host.plugin.read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if line.startswith("paraview_plugin_version"))
    other = tmp_path / "meshcore_plugin.py"
    other.write_text(text.replace(line, 'paraview_plugin_version = "0.0.7"'), encoding="utf-8")
    _, output = host.execute("pvpython", INSIDE / "missing.py", MESHCORE_PLUGIN=str(other))
    assert "this plugin belongs to meshcore 0.0.7, but ParaView's Python has meshcore" in output, output
    assert "Traceback" not in output, output


def test_no_check_is_lost():
    """Every script beside the tests is run by one of them."""
    tests = "".join(path.read_text(encoding="utf-8") for path in Path(HERE).glob("test_*.py"))
    scripts = [p.name for p in INSIDE.glob("*.py") if p.name not in ("harness.py", "datasets.py")]
    assert [name for name in scripts if f'"{name}"' not in tests] == []
    assert sys.modules.get("paraview") is None  # ParaView stays out of this process
