"""An imported head runs through everything: tracked, inspected, exported."""

from __future__ import annotations

import json

import numpy as np
import pytest
from drawn import lit, vertices_of
from heads import seen_at
from imported import FEW, OUTER_CLASSES, facets_of, table, write_glb, write_obj
from runs import write_kind

from abs_engine.cli import main
from abs_engine.core.registry import EXPORTERS
from abs_engine.export.exporter import read_run
from abs_engine.io.assets import load_speaker
from abs_engine.tracking.landmark.landmark_correspondence import load_correspondence

FRAMES = 4
OPEN = np.linspace(0.0, 0.5, FRAMES)
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("soon_ready")]


def run(*words):
    """Exit status of the command."""
    return main([*map(str, words), "--quiet", "--renderer", "cpu"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A drawn clip of amara, and an imported head that knows her shape but not her looks."""
    found = tmp_path_factory.mktemp("imported")
    pictures = [
        lit("amara", seen_at([0, 0.1 * np.sin(k), 0], [0, 0, 700]), jawOpen=OPEN[k])
        for k in range(FRAMES)
    ]
    write_kind(found / "amara.mp4", "libx264", pictures)
    head = load_speaker()
    outer = facets_of(head, *OUTER_CLASSES)
    amara = head.named("amara").astype(float)
    lying = amara[:, [0, 2, 1]] * [1e-3, -1e-3, 1e-3] + [0.0, 1.7, 0.2]
    write_obj(found / "amara.obj", lying, outer)
    write_glb(found / "head.glb", units=(*FEW, "mouthPressLeft", "mouthPressRight"))
    (found / "head.toml").write_text(table(head) + '[people]\namara = "amara.obj"\n')
    words = found / "head.glb", "--table", found / "head.toml", "-o", found / "head.face"
    assert run("import", *words) == 0
    return found


@pytest.fixture(scope="module")
def tracked(folder):
    """The clip tracked with her own shape."""
    words = folder / "amara.mp4", "-o", folder / "run", "--model", folder / "head.face"
    assert run("track", *words, "--person", "amara") == 0
    return folder / "run"


def test_the_network_sees_the_head_where_it_sees_the_bundled_one(folder):
    """It is painted by regions alone; the bundled head has pictures of people."""
    head, bundled = load_speaker(folder / "head.face"), load_speaker()
    found, known = load_correspondence(head), load_correspondence(bundled)
    places = found.of(head.vertices), known.of(bundled.vertices)
    away = places[0] - places[1]
    assert np.linalg.norm(away - np.median(away, axis=0), axis=1).mean() < 4
    marks = [h.vertices[h.points["landmark_68"][17:]] for h in (head, bundled)]  # no jaw line
    off = marks[0] - marks[1]
    assert np.median(np.linalg.norm(off - np.median(off, axis=0), axis=1)) < 4


def test_a_known_shape_is_tracked_by_any_looks(tracked):
    run_ = read_run(tracked, tracked.parent / "head.face")
    truth = vertices_of("amara")
    assert run_.arrays["found"].all()
    shape = run_.mesh.mean[: len(truth)]
    assert np.ptp(shape[:, 0]) == pytest.approx(np.ptp(truth[:, 0]), abs=0.5)
    true = [
        np.ptp(vertices_of("amara", jawOpen=w)[load_speaker().landmarks["inner_lip_8"][[2, 6]], 1])
        for w in OPEN
    ]
    off = run_.arrays["aperture"][1:] - np.array(true[1:])
    assert np.abs(off).max() < 3, off


def test_its_run_names_the_head_and_is_exported_with_it(tracked, tmp_path):
    head = tracked.parent / "head.face"
    settings = json.loads((tracked / "run.json").read_text())["settings"]
    assert settings["model_file"] == settings["speaker"] == "head.face"
    for kind in ("gltf", "arkit", "fap", "obj"):
        out = tmp_path / EXPORTERS.get(kind).suffix.replace(".", f"{kind}.", 1)
        out = out if out != tmp_path else tmp_path / kind
        words = "--to", kind, "-o", str(out), "--speaker", str(head), "--quiet"
        assert main(["export", str(tracked), *words]) == 0
        assert out.exists()
    words = "report", tracked, "-o", tmp_path / "report.html", "--speaker", head, "--quiet"
    assert main([*map(str, words)]) == 0
    words = "render", "postures", "-o", tmp_path / "sheet.png", "--speaker", head
    assert run(*words, "--person", "amara", "--rows", "jawOpen", "mouthFunnel") == 0


def test_anybody_is_tracked_with_a_head_that_has_no_targets_of_people(folder):
    words = folder / "amara.mp4", "-o", folder / "anybody", "--model", folder / "head.face"
    assert run("track", *words) == 0
    found = read_run(folder / "anybody", folder / "head.face")
    assert found.arrays["found"].all()
    assert np.corrcoef(found.arrays["aperture"], OPEN)[0, 1] > 0.95
