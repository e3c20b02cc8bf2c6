"""`meshcore doctor`: it tells what works and the cure, and survives whatever is broken."""

from __future__ import annotations

import importlib
import json

import pytest

import meshcore as mc
from meshcore import install
from meshcore.cli import main
from meshcore.install import places


@pytest.fixture
def no_hosts(monkeypatch):
    monkeypatch.setattr(places, "pvpythons", list)
    monkeypatch.setattr(places, "blenders", list)


def by_check(findings, subject):
    return {finding.check: finding for finding in findings if finding.subject.startswith(subject)}


def test_meshcore_itself_works_here(no_hosts):
    findings = by_check(install.doctor(), "meshcore")
    assert {name: finding.state for name, finding in findings.items()} == dict.fromkeys(
        ["Python", "kernels", "kernel cache", "meshio", "h5py", "pyvista", "rich", "picture"], "ok"
    ), findings


def test_absent_hosts_are_no_fault(no_hosts, capsys):
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert "--pvpython PATH" in out and "--blender PATH" in out and "pip install pymeshlab" in out
    assert "all that is here works" in out


def test_a_paraview_without_meshcore_is_a_fault_with_its_cure(home):
    done = home.meshcore("doctor", "--json")
    assert done.returncode == 1
    rows = {row["check"]: row for row in json.loads(done.stdout) if row["subject"].startswith("ParaView")}
    assert rows["operations at start"]["state"] == rows["meshcore and numba"]["state"] == "fails"
    assert rows["operations at start"]["detail"].endswith("; meshcore install paraview")
    assert rows["Python"]["state"] == "ok" and "numpy" in rows["Python"]["detail"]


def test_a_program_that_is_no_host_is_told(no_hosts, tmp_path):
    (tmp_path / "pvpython").write_text("")
    findings = install.doctor(tmp_path / "pvpython", tmp_path / "none")
    assert by_check(findings, "ParaView")["found"].state == by_check(findings, "Blender")["found"].state == "fails"


def test_whatever_breaks_is_a_finding(no_hosts, monkeypatch):
    def broken():
        raise SystemError("llvmlite is built for another Python")

    monkeypatch.setattr(importlib.import_module("meshcore.install.doctor"), "_compiles", broken)
    found = by_check(install.doctor(), "meshcore")["kernels"]
    assert found.state == "fails" and found.detail.startswith("llvmlite is built for another Python; reinstall numba")


def test_an_unwritable_cache_is_told_with_the_cure(no_hosts, monkeypatch, tmp_path):
    monkeypatch.setattr("meshcore._numba._user_cache", lambda: tmp_path / "elsewhere")
    found = by_check(install.doctor(), "meshcore")["kernel cache"]
    assert found.state == "fails" and "MESHCORE_CACHE_DIR" in found.detail


def test_it_can_be_stopped(no_hosts):
    with pytest.raises(mc.Cancelled):
        install.doctor(progress=lambda fraction, message: False)
