"""What `abs-engine doctor` finds and says."""

from __future__ import annotations

import ctypes

import pytest

from abs_engine.core.errors import OpenGLError
from abs_engine.render import context, diagnose
from abs_engine.render.context import BACKENDS
from abs_engine.render.select import open_renderer


@pytest.mark.gl
def test_the_doctor_finds_opengl(gl):
    found = diagnose.diagnose()
    assert [a.backend for a in found.attempts] == list(BACKENDS)
    assert found.exit_status == diagnose.WORKS
    assert found.chosen == gl.backend
    assert found.remedy == ""
    times = {t.way: t.milliseconds for t in found.timings}
    assert list(times) == ["OpenGL, thin", "OpenGL, instanced", "CPU rasteriser"]
    assert all(ms is not None and 0 < ms < 1000 for ms in times.values())
    lines = diagnose.report_lines(found)
    assert any(gl.renderer in line for line in lines)
    assert not any("apt-get" in line for line in lines)


def test_the_doctor_names_the_package_where_nothing_works(monkeypatch):
    def without_libraries(name: str) -> diagnose._Probe:
        """Probe here, where the libraries can be made to be missing."""
        return diagnose.probe(name)

    def no_library(name: str, *_: object, **__: object) -> None:
        raise OSError(f"{name}: cannot open shared object file")

    monkeypatch.setattr(diagnose, "_probe_in_process", without_libraries)
    monkeypatch.setattr(context._Process, "context", None)
    monkeypatch.setattr(ctypes, "CDLL", no_library)
    found = diagnose.diagnose()
    assert found.exit_status == diagnose.CPU_ONLY
    assert found.chosen == "cpu"
    assert found.timings[-1].milliseconds is not None
    assert not any(a.ok for a in found.attempts)
    assert diagnose.report_lines(found)[-1] == (
        "to get OpenGL: apt-get install libegl1 libgl1-mesa-dri"
    )


def test_the_doctor_advises_no_package_where_opengl_is_hidden(monkeypatch):
    monkeypatch.setenv("ABS_ENGINE_HIDE_GL", "all")
    found = diagnose.diagnose()
    assert found.exit_status == diagnose.CPU_ONLY
    assert diagnose.report_lines(found)[-1] == "to get OpenGL: unset ABS_ENGINE_HIDE_GL"


def test_the_notice_names_the_package_where_no_library_loads(monkeypatch, caplog):
    def refuse(_: object) -> None:
        raise OpenGLError("libEGL cannot be loaded", "apt-get install libegl1 libgl1-mesa-dri")

    monkeypatch.setattr(context, "_OPENERS", dict.fromkeys(BACKENDS, refuse))
    monkeypatch.setattr(context._Process, "context", None)
    with open_renderer("auto") as renderer:
        assert renderer.description.startswith("cpu")
    (line,) = caplog.messages
    assert "apt-get install libegl1 libgl1-mesa-dri" in line


def test_the_doctor_survives_a_driver_that_crashes(monkeypatch):
    monkeypatch.setattr(diagnose.sys, "executable", "/bin/false")
    found = diagnose.diagnose()
    assert found.exit_status == diagnose.CPU_ONLY
    assert "crashed" in found.attempts[0].detail


def test_the_doctor_measures_the_stated_work():
    scene, _, _ = diagnose._toy()
    assert len(scene.faces) == 1280
