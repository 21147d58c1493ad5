"""What `abs-engine doctor` finds and says."""

from __future__ import annotations

import pytest

from abs_engine.render import diagnose
from abs_engine.render.context import BACKENDS


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
    monkeypatch.setenv("ABS_ENGINE_HIDE_GL", "all")
    found = diagnose.diagnose()
    assert found.exit_status == diagnose.CPU_ONLY
    assert found.chosen == "cpu"
    assert found.timings[-1].milliseconds is not None
    assert diagnose.report_lines(found)[-1] == (
        "to get OpenGL: apt-get install libegl1 libgl1-mesa-dri"
    )


def test_the_doctor_survives_a_driver_that_crashes(monkeypatch):
    monkeypatch.setattr(diagnose.sys, "executable", "/bin/false")
    found = diagnose.diagnose()
    assert found.exit_status == diagnose.CPU_ONLY
    assert "crashed" in found.attempts[0].detail


def test_the_doctor_measures_the_stated_work():
    scene, _, _ = diagnose._toy()
    assert len(scene.faces) == 1280
