"""The table of leaves: every model with every kind of evidence and every kind of driver.

Each fits five frames of a clip, or is refused by name before anything is done.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from drawn import lit, lit_picture_of
from heads import seen_at
from hurried import hurried
from runs import write_kind

from abs_engine.cli import main
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.registry import DRIVERS, MODELS, TERMS
from abs_engine.face.neutral import neutral_face
from abs_engine.face.talking_file import save_talking
from abs_engine.io.assets import load_speaker
from abs_engine.learn.articulated import face_shape
from abs_engine.learn.articulatory import build
from abs_engine.learn.talking import learn_face
from abs_engine.learn.training import checksum
from abs_engine.papers.odisio2004.filmed import VisemePictures, sightings
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.corpus import speak_corpus
from abs_engine.tracking import loop
from abs_engine.tracking.frame.clip_setting import UNLIKE
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.frame.frame_state import Memory
from abs_engine.tracking.options import Leaves, TrackOptions
from abs_engine.tracking.presets import resolved
from abs_engine.tracking.results.run_mesh import load_mesh
from abs_engine.tracking.run import prepare
from abs_engine.tracking.runs.record import load_run

PERSON = "amara"
OPEN = (0.0, 0.12, 0.25, 0.35, 0.18)
RENDERER = CpuRenderer()
MOVED = {"basu1998": 8.0, "odisio2004": 40.0}
"""mm by which a face that was lost is found again elsewhere, by preset."""
FITS = {
    ("head", "colour"): {"simplex", "forces", "newton"},
    ("shell", "colour"): {"simplex", "forces", "newton"},
    ("talking", "colour"): {"simplex", "forces", "newton"},
    ("talking", "texture"): {"simplex", "axes"},
    ("talking", "local"): {"simplex", "axes"},
}
"""What goes together; all else is refused."""
CELLS = [
    (model, term, driver)
    for model in ("head", "shell", "talking")
    for term in ("colour", "texture", "local")
    for driver in ("simplex", "forces", "newton", "axes")
]


def fits(model: str, term: str, driver: str) -> bool:
    return driver in FITS.get((model, term), set())


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    pictures = [
        lit(PERSON, seen_at([0, 0.03 * k - 0.06, 0], [0, 0, 700]), jawOpen=amount)
        for k, amount in enumerate(OPEN)
    ]
    return write_kind(tmp_path_factory.mktemp("film") / "head.mp4", "libx264", pictures)


@pytest.fixture(scope="module")
def talking(tmp_path_factory):
    """A talking face of the person, learned from every fourth viseme of its speech, drawn."""
    speaker, camera = load_speaker(), Camera.ideal((320, 240))
    spoken = speak_corpus(speaker, speaker.named(PERSON))
    built = build(spoken.corpus)
    shape = face_shape(speaker, spoken, built, PERSON)
    pose = seen_at([0, 0, 0], [0, 0, 700])
    pictures = []
    alpha, names = built.alpha[::4], spoken.corpus.visemes[::4]
    heads = np.stack([shape.scene.vertices(row) for row in alpha]).astype(np.float32)
    none, grain = np.zeros((0, *heads[0].shape), np.float32), np.random.default_rng(0)
    for head in heads:
        still = replace(shape.scene, mean=head, modes=none)
        picture = lit_picture_of(still, pose, camera, (0.3, -0.5, -1.0), 0.0)
        noisy = picture + grain.normal(0, 2, picture.shape)
        pictures.append(np.clip(noisy, 0, 255).astype(np.uint8))
    seen = VisemePictures(names, np.stack(pictures), heads, (pose,) * len(names), camera)
    face = learn_face(
        shape, sightings(shape, seen.pictures, seen.poses, alpha), camera, RENDERER, count=20
    )
    path = tmp_path_factory.mktemp("face") / "face.npz"
    save_talking(path, face, PERSON, checksum(speaker))
    return path


@pytest.fixture(scope="module")
def prepared(video, talking):
    """A clip made ready for each model, once."""
    names = {"head": "head", "shell": "shell", "talking": str(talking)}
    with hurried(frames=2, rounds=1):
        return {
            model: prepare(video, RENDERER, TrackOptions(model=name))
            for model, name in names.items()
        }


@pytest.mark.parametrize(("model", "term", "driver"), [c for c in CELLS if fits(*c)])
def test_what_goes_together_fits(model, term, driver, prepared):
    made = prepared[model]
    leaves = Leaves.of(TrackOptions(terms=(term,), driver=driver))
    binder = replace(made.setting.binder, kinds=leaves.kinds)
    minimiser = leaves.driver.minimiser()
    if driver == "axes":  # lips jump by 4 mm here: more than its usual evaluations follow
        minimiser = replace(minimiser, limit=4 * minimiser.limit)
    setting = replace(made.setting, binder=binder, driver=minimiser)
    found = [result for _, result in replace(made, setting=setting).results()]
    assert [one.found for one in found] == [True] * len(OPEN)
    aperture = np.array([one.aperture for one in found])
    assert np.corrcoef(aperture, OPEN)[0, 1] > 0.8
    assert all(len(one.vector) == len(setting.face.blocks) for one in found)


@pytest.mark.parametrize(("model", "term", "driver"), [c for c in CELLS if not fits(*c)])
def test_what_does_not_is_refused_by_name_before_anything_is_done(model, term, driver):
    leaves = Leaves.of(TrackOptions(terms=(term,), driver=driver))
    with pytest.raises(ParameterError) as caught:
        MODELS.get(model)(None, TrackOptions(), leaves, None, print)
    assert any(f"'{name}'" in caught.value.problem for name in (model, term, driver))
    assert "use --" in caught.value.remedy


@pytest.fixture(scope="module")
def lost(talking, tmp_path_factory):
    """Runs of a face, a bare wall, and the face again and elsewhere, by preset.

    It moves by as much as a blob's filter allows, or as a detector finds. Each is tracked through
    the command, from the video to the run's folder.
    """
    own = {"odisio2004": ["--model", str(talking)], "basu1998": ["--person", PERSON]}

    @cache
    def run(preset: str) -> Path:
        folder, moved = tmp_path_factory.mktemp(preset), MOVED[preset]
        back = seen_at([0, 0.0025 * moved, 0], [moved, 0, 700])
        seen = [
            lit(PERSON, seen_at([0, yaw, 0], [0, 0, 700]), jawOpen=amount)
            for yaw, amount in zip((0.0, 0.03, 0.06, 0.03, 0.0), OPEN, strict=True)
        ]
        wall = [np.full_like(seen[0], 90)] * 2
        video = write_kind(folder / "lost.mp4", "libx264", [*seen, *wall, lit(PERSON, back)])
        words = ["track", str(video), "-o", str(folder / "run"), "--renderer", "cpu"]
        with hurried(frames=2, rounds=1):
            assert main([*words, "--preset", preset, *own[preset]]) == 0
        return folder / "run"

    return run


@pytest.mark.parametrize("preset", MOVED)
def test_a_preset_tracks_a_clip(preset, lost):
    told = json.loads((lost(preset) / "run.json").read_text())
    assert told["settings"]["preset"] == preset
    run = load_run(lost(preset))
    found = run["found"]
    assert np.corrcoef(run["aperture"][: len(OPEN)], OPEN)[0, 1] > 0.8
    names = [str(name) for name in run["parameter_names"]]
    assert names[6:8] == (["shape1", "shape2"] if preset == "basu1998" else ["jaw1", "lips1"])
    assert [str(name) for name in run["term_names"]][-1] == "prior"
    sums = run["term_values"].sum(axis=1)
    np.testing.assert_allclose(sums[found], run["value"][found], rtol=1e-6)
    heads = load_mesh(lost(preset)).points(run["lip_vertex"])
    away = np.linalg.norm(run["lip_points"] - heads, axis=2)
    assert np.median(away[found]) < 1.5  # the head that is written moves with what was fitted


@pytest.mark.parametrize("preset", MOVED)
def test_a_preset_finds_a_face_again(preset, lost):
    run, moved = load_run(lost(preset)), MOVED[preset]
    assert run["found"].tolist() == [True] * 5 + [False] * 2 + [True]
    middles = [
        Pose.from_vectors(run["rotation"][k], run["translation"][k])
        .apply(run["lip_points"][k])
        .mean(axis=0)
        for k in (4, 7)
    ]
    turned = 0.0025 * moved * 90  # mm: the mouth lies before the axis that the head turns about
    assert middles[1][0] - middles[0][0] == pytest.approx(moved - turned, abs=0.3 * moved)


def test_a_head_that_leaves_the_picture_costs_its_frames_alone(prepared):
    """Of a talking face, which is compared where it is drawn."""
    made = prepared["talking"]
    leaves = Leaves.of(TrackOptions(terms=("texture",)))
    binder = replace(made.setting.binder, kinds=leaves.kinds)
    image, _ = next(iter(made.results()))
    beside = seen_at([0, 0, 0], [2000, 0, 700])
    motion = GivenMotion((beside, beside))
    setting = replace(made.setting, binder=binder, motion=motion, visibility=None)
    found = [one for _, one in loop.track(setting, [image, image])]
    assert [(one.found, one.covered) for one in found] == [(False, True)] * 2


def test_given_poses_are_held_by_every_face(video, talking, tmp_path):
    poses = tmp_path / "poses.csv"
    names = "head_rx,head_ry,head_rz,head_tx,head_ty,head_tz"
    rows = [seen_at([0, 0.03 * k - 0.06, 0], [0, 0, 700]) for k in range(len(OPEN))]
    lines = [",".join(str(v) for v in (*pose.rotation_vector, *pose.translation)) for pose in rows]
    poses.write_text("\n".join([names, *lines]))
    for chosen in (
        {"model": "shell", "person": PERSON}, {"model": str(talking)},
        {"preset": "odisio2004", "model": str(talking)},
    ):  # fmt: skip
        with hurried(frames=2, rounds=1):
            made = prepare(video, RENDERER, TrackOptions(poses=poses, **chosen))
        found = [one for _, one in made.results()]
        assert all(one.found for one in found), chosen
        assert not np.any([one.vector[:6] for one in found]), chosen
        assert np.corrcoef([one.aperture for one in found], OPEN)[0, 1] > 0.8, chosen


@pytest.mark.parametrize("model", ["head", "shell", "talking"])
def test_every_model_knows_the_persons_neutral_face(model, prepared):
    speaker, body = load_speaker(), prepared[model].setting.face.body
    marks, lips = speaker.points["landmark_68"], speaker.points["lips"]
    assert body.rest is not None
    neutral = neutral_face(body, marks)
    gaps = neutral[marks[[61, 62, 63]], 1] - neutral[marks[[67, 66, 65]], 1]
    np.testing.assert_allclose(gaps, 0, atol=1e-3)
    off = np.linalg.norm((neutral - body.rest)[lips], axis=1)
    assert off.max() < 1.5  # mm; closed from the mean, lips would move by 3 mm each
    if model != "talking":
        back = np.linalg.norm(neutral - body.mean, axis=1)[marks[66]]
        assert back > 3.0


def test_skin_alone_is_no_mouth_of_a_shell(prepared):
    """What a shell with small lips explains well, without anything that is lips."""
    made = prepared["shell"]
    image, first = next(iter(made.results()))
    skin = image[_below_the_lips(made, first)]
    motion = GivenMotion((first.pose,))
    setting = replace(made.setting, motion=motion, visibility=None)
    ((_, found),) = loop.track(setting, [np.broadcast_to(skin, image.shape).copy()])
    assert not found.found
    assert found.status == UNLIKE


def _below_the_lips(made, result) -> tuple[int, int]:
    """Row and column of a pixel below the lips, where skin is."""
    middle = result.pose.apply(result.lips).mean(axis=0)
    at = made.setting.camera.project(middle + np.array([0, 22.0, 0]))
    return int(at[1]), int(at[0])


def test_terms_add_up(prepared):
    """Two kinds of evidence in one frame: the value is their sum and the priors'."""
    made = prepared["talking"]
    leaves = Leaves.of(TrackOptions(terms=("colour", "texture", "local")))
    binder = replace(made.setting.binder, kinds=leaves.kinds)
    image, result = next(iter(made.results()))
    frame = made.setting.motion.follower().step(image, Memory())
    work = binder.work(frame, frame.pose, Memory())
    value = work.problem(work.problem.chosen(result.vector))
    assert set(value.terms) == {"colour", "texture", "local", "prior"}
    assert value.value == pytest.approx(sum(value.terms.values()))


def test_regions_that_evidence_needs_and_a_face_lacks_are_named(prepared):
    made = prepared["head"]
    bare = replace(made.setting.face, regions=(None,) * len(made.setting.face.regions))
    binder = replace(made.setting.binder, face=bare)
    image, _ = next(iter(made.results()))
    frame = made.setting.motion.follower().step(image, Memory())
    with pytest.raises(ParameterError, match="no region that shows skin or lips") as caught:
        binder.work(frame, frame.pose, Memory())
    assert "give it regions of skin and lips" in caught.value.remedy


def test_a_talking_face_is_a_speakers_own():
    chosen, prepare_own = resolved(TrackOptions(model="talking"))
    with pytest.raises(ParameterError, match="give its file"):
        prepare_own(None, chosen, Leaves.of(chosen), None, print)


def test_every_leaf_is_in_the_registry():
    assert {"head", "shell", "talking"} <= set(MODELS.names())
    assert {"colour", "texture", "local"} <= set(TERMS.names())
    assert {"simplex", "forces", "newton", "axes", "gradient"} <= set(DRIVERS.names())
