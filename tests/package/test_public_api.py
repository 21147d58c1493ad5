"""The public names are there, and importing the package costs nothing."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import abs_engine


def test_every_public_name_can_be_imported():
    for name in abs_engine.__all__:
        assert getattr(abs_engine, name).__doc__
    assert dir(abs_engine) == sorted(abs_engine.__all__)
    assert set(abs_engine._HOME) == set(abs_engine.__all__)
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = abs_engine.no_such_name


@pytest.mark.parametrize(("name", "values", "said"), [
    ("export_run", ("run", None, "out.csv"), "the format is None; give text"),
    ("export_run", ("run", "landmarks", None), "output is None; give a path"),
    ("export_run", (3, "landmarks", "out.csv"), "run is 3; give a path"),
    ("export_run", ({"found": "x" * 99}, "landmarks", "out.csv"), "run is {'found': '"
     + "x" * 69 + " ...; give a path"),
    ("export_run", ("run", "landmarks", "out.csv", None, 8), "smooth is 8; give text"),
    ("load_run", (3,), "folder is 3; give a path"),
    ("load_run", ("",), "folder is empty; give a path"),
    ("track", ("",), "video is empty; give a path"),
    ("write_video", (3, [], 25), "path is 3; give a path"),
    ("score", (3, "truth"), "run is 3; give a run, its arrays, or its path"),
    ("score", ({}, 3), "truth is 3; give a path"),
    ("score", ("none", "truth"), "none does not exist; give the folder that 'track -o' "
     "made"),
    ("film_scene", ("x", "y"), "scene is 'x'; give a SceneFile, as read_scene returns"),
    ("run_bench", ("x",), "rounds is 'x'; give a whole number"),
    ("Pose", ([0, 0, 0], [0, 0, 1]), "a pose is a 3x3 rotation matrix and a translation of "
     "3 numbers; give these, or a rotation vector to Pose.from_vectors"),
    ("TrackOptions", (3,), "person is 3; give text"),
    ("load_mesh", (3,), "folder is 3; give a path"),
    ("load_speaker", (3,), "speaker is 3; give a path"),
    ("load_dataset", (3,), "folder is 3; give a path"),
    ("load_truth", (3,), "path is 3; give a path"),
    ("check_dataset", (None,), "folder is None; give a path"),
    ("load_articulatory", (None,), "path is None; give a path"),
    ("read_scene", (3,), "path is 3; give a path"),
    ("read_corpus", (None,), "path is None; give a path"),
    ("write_report", (["run"], "x.html", None), "options is None; give ReportOptions"),
    ("prepare", (3, None), "video is 3; give a path"),
    ("track_video", ("x.mp4", None, None), "folder is None; give a path"),
])  # fmt: skip
def test_values_of_another_kind_are_refused_by_name(name, values, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(abs_engine.AbsEngineError) as caught:
        getattr(abs_engine, name)(*values)
    assert str(caught.value) == said
    assert list(tmp_path.iterdir()) == []


def test_what_public_functions_take_is_public_too(tmp_path):
    assert inspect.signature(abs_engine.write_report).parameters["options"].default == (
        abs_engine.ReportOptions()
    )
    scene = tmp_path / "scene.toml"
    scene.write_text('format = "abs_engine.scene"\nversion = 1\n')
    assert isinstance(abs_engine.read_scene(scene), abs_engine.SceneFile)


def test_what_solvers_and_the_demo_take_is_public_too():
    spec = abs_engine.ParamSpec(("a",), ("mm",), np.ones(1), -np.ones(1), np.ones(1))
    found = abs_engine.Simplex().minimise(
        lambda x: abs_engine.Evaluation(float(x @ x), {"x": 0.0}), np.array([0.5]), spec
    )
    assert abs(found.x[0]) < 0.1
    demo = inspect.signature(abs_engine.run_demo).parameters["options"].default
    assert demo == abs_engine.DemoOptions()


def test_importing_the_package_imports_nothing_heavy():
    code = "import sys, abs_engine; print({'numpy', 'moderngl', 'cv2'} & set(sys.modules))"
    folders = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=folders
    )
    assert done.stdout.strip() == "set()"
