"""The studio: its pictures against projection, its labels against the mesh, its bad days."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from said import closed_in, film, say

from abs_engine.core.camera import Camera
from abs_engine.core.errors import OutputError, ParameterError, StudioError
from abs_engine.core.geometry import Pose
from abs_engine.dataset import SUMS, load_truth
from abs_engine.io.assets import load_speaker
from abs_engine.io.video import probe
from abs_engine.studio.appearance.look import Look
from abs_engine.studio.filming import plan_of
from abs_engine.studio.geometry import smooth_normals
from abs_engine.studio.process import Worker, worker_environment
from abs_engine.studio.take import Take

CAMERA = Camera(np.array([[410.0, 0, 121.3], [0, 415.0, 84.6], [0, 0, 1]]), (240, 180))
FRAMES = 6


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


@pytest.fixture(scope="module")
def sequence(speaker):
    return say("p a p i", speaker, "clara", CAMERA, frames=FRAMES, seed=5)


@pytest.fixture(scope="module")
def clip(speaker, sequence, tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio") / "clip"
    steps = []
    made = film(
        speaker,
        sequence,
        CAMERA,
        folder,
        seed=9,
        lossless=True,
        command="a command",
        progress=lambda done, all_frames: steps.append((done, all_frames)),
    )
    assert made == folder
    assert steps == [(i + 1, FRAMES) for i in range(FRAMES)]
    return folder


@pytest.fixture(scope="module")
def truth(clip):
    return load_truth(clip, verify=True)


def one_triangle(corners):
    """A stage with one triangle in the camera frame (OpenCV), given as a head that stands there."""
    return {
        "size": np.array(CAMERA.size),
        "matrix": CAMERA.matrix,
        "near": np.array(100.0),
        "far": np.array(2000.0),
        "faces": np.array([[0, 1, 2]]),
        "uv": np.zeros((3, 2)),
        "texture": np.full((2, 2, 3), 255, np.uint8),
        "shade": np.ones(3),
        "roughness": np.array(0.9),
    }, {
        "vertices": corners,
        "normals": np.tile([0.0, 0, -1], (3, 1)),
        "lights": np.zeros((0, 7)),
        "ambient": np.ones(3),
        "flip": np.array(False),
    }


def first_shot(speaker, sequence, look=None, camera=CAMERA):
    plan = plan_of(speaker, sequence, camera, look or Look())
    with Take(speaker, plan, 0, ()) as take:
        return next(take.film(0, 1))[1]


@pytest.fixture(scope="module")
def worker():
    """Draws one triangle, wherever it is put."""
    with Worker(one_triangle(np.eye(3))[0]) as started:
        yield started


@pytest.mark.parametrize("corner", [(4, 4), (232, 4), (4, 172), (232, 172)])
def test_pixel_centres_lie_at_integers_as_in_the_camera_model(worker, corner):
    pixels = np.array(corner) + np.array([[-3.3, -2.9], [-2.77, 3.63], [4.1, 0.4]])
    rays = np.column_stack([pixels, np.ones(3)]) @ np.linalg.inv(CAMERA.matrix).T
    corners = rays * np.array([[500.0], [640.0], [820.0]])
    np.testing.assert_allclose(CAMERA.project(corners), pixels, atol=1e-9)
    drawn = worker.exchange(one_triangle(corners)[1])
    y, x = np.mgrid[:180, :240]
    inside = np.ones((180, 240), bool)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        edge = pixels[b] - pixels[a]
        inside &= edge[0] * (y - pixels[a, 1]) - edge[1] * (x - pixels[a, 0]) < 0
    np.testing.assert_array_equal(drawn["ids"], inside.astype(np.uint32))
    coverage = drawn["rgba"][..., 3] / 255.0  # four samples a pixel
    middle = np.array([(coverage * x).sum(), (coverage * y).sum()]) / coverage.sum()
    assert np.abs(middle - pixels.mean(axis=0)).max() < 0.1
    plane = np.linalg.solve(corners, np.ones(3))  # n . x = 1, so depth = 1 / (n . ray)
    rays_all = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(CAMERA.matrix).T
    depth = 1 / (rays_all @ plane)
    np.testing.assert_allclose(drawn["depth"][inside], depth[inside], atol=0.02)


def test_files_and_their_kinds(clip, truth):
    names = {p.relative_to(clip).as_posix() for p in clip.iterdir()}
    assert names == {"clip", "dataset.json", "README.md", "timing.json", SUMS}
    view = clip / "clip" / "camera"
    kinds = ("ids", "depth", "normals", "albedo", "flow", "frames")
    assert {p.name for p in view.iterdir() if p.is_dir()} == set(kinds)
    assert all(len(list((view / kind).iterdir())) == FRAMES for kind in kinds)
    info = probe(truth.video)
    assert (info.size, info.rate, info.frames) == (CAMERA.size, 25, FRAMES)
    assert (truth.person, truth.sentence, truth.seed) == ("clara", "p a p i", 9)
    assert truth.command == "a command"
    np.testing.assert_array_equal(truth.camera.matrix, CAMERA.matrix)
    done = subprocess.run(["sha256sum", "-c", "--quiet", SUMS], cwd=clip, check=False)
    assert done.returncode == 0
    assert not [p for p in clip.parent.iterdir() if p.name.startswith(".")]


def test_truth_is_what_was_asked_for(speaker, sequence, truth):
    np.testing.assert_array_equal(truth.unit_weights, sequence.weights)
    np.testing.assert_array_equal(truth.closed, closed_in(speaker, sequence))
    assert truth.phonemes == sequence.visemes
    assert tuple(truth.intervals) == sequence.intervals
    for frame in range(FRAMES):
        np.testing.assert_allclose(
            truth.pose(frame).rotation, sequence.pose(frame).rotation, atol=1e-12
        )
    np.testing.assert_allclose(truth.translations, sequence.translations, atol=1e-9)
    units = speaker.units.astype(np.float64)
    for frame in range(FRAMES):
        exact = speaker.named("clara") + np.tensordot(sequence.weights[frame], units, 1)
        assert np.abs(truth.vertices(frame) - exact).max() < 0.02
        np.testing.assert_array_equal(
            truth.vertices(frame)[truth.landmarks["outer_lip"]],
            truth.points(truth.landmarks["outer_lip"])[frame].astype(np.float32),
        )
    assert truth.aperture[truth.closed].max() < 0.25
    assert truth.aperture.max() > 8


def test_ids_and_depth_agree_with_the_vertices(truth):
    for frame in range(FRAMES):
        ids, depth = truth.facet_ids(frame), truth.depth(frame)
        y, x = np.nonzero(ids)
        facets = truth.faces[ids[y, x].astype(int) - 1]
        corners = truth.pose(frame).apply(truth.vertices(frame).astype(np.float64))[facets]
        rays = np.column_stack([x, y, np.ones_like(x)]) @ np.linalg.inv(CAMERA.matrix).T
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        hit = (normal * corners[:, 0]).sum(axis=1) / (normal * rays).sum(axis=1)
        flat = np.abs((normal * rays).sum(axis=1)) / np.linalg.norm(normal, axis=1) > 0.1
        assert np.abs(hit - depth[y, x])[flat].max() < 0.1  # of which 0.025 is rounding
        assert (depth[ids == 0] == 0).all()
        seen = CAMERA.project(corners)
        assert (seen.min(axis=1) <= np.column_stack([x, y]) + 0.01).all()
        assert (seen.max(axis=1) >= np.column_stack([x, y]) - 0.01).all()


def test_the_inner_mouth_shows_exactly_when_the_lips_are_open(truth):
    inside = [truth.class_names.index(n) for n in ("inner_mouth", "tongue")]
    teeth = [truth.class_names.index(n) for n in ("upper_teeth", "lower_teeth")]
    for frame in range(FRAMES):
        shown = np.isin(truth.class_ids(frame), inside + teeth).sum()
        assert shown == 0 if truth.closed[frame] else shown > 0
    assert set(truth.closed) == {True, False}


def test_the_picture_shows_what_the_labels_say(truth):
    for frame, picture in enumerate(truth.pictures()):
        classes = truth.class_ids(frame)
        colour = picture.astype(np.float64)
        redness = colour[..., 0] / colour.sum(axis=2)
        lips = np.isin(classes, [truth.class_names.index(n) for n in ("upper_lip", "lower_lip")])
        skin = classes == truth.class_names.index("skin")
        assert redness[lips].mean() > redness[skin].mean() + 0.02
        assert colour[skin].mean() > 1.2 * colour[classes == 0].mean()
        half = skin & (
            np.arange(240) < truth.pixels(frame, truth.landmarks["outer_lip"])[:, 0].mean()
        )
        assert colour[half].mean() > 1.05 * colour[skin & ~half].mean()  # the key light's side


def test_the_same_seed_gives_the_same_clip(speaker, sequence, clip, truth, tmp_path):
    again = film(
        speaker, sequence, CAMERA, tmp_path / "a", seed=9, lossless=True, command="a command"
    )
    names = [p.relative_to(clip) for p in clip.rglob("*") if p.suffix in (".png", ".json", ".mp4")]
    assert len(names) > 6 * FRAMES
    for name in names:
        if name.name != "timing.json":
            assert (clip / name).read_bytes() == (again / name).read_bytes(), name
    for name in ("truth.npz", "vertices/000000.npz", "camera/points.npz"):
        a, b = (np.load(f / "clip" / name) for f in (clip, again))
        assert all((a[k] == b[k]).all() for k in a.files)
    other = film(speaker, sequence, CAMERA, tmp_path / "b", seed=10, lossless=True, labels=())
    assert not (other / "clip" / "camera" / "flow").exists()
    noise = np.array(list(load_truth(other).pictures()), float) - list(truth.pictures())
    assert 1.0 < noise.std() < 4.0


def test_the_head_can_be_filmed_without_a_shirt(speaker, sequence):
    short = replace(sequence, weights=sequence.weights[:1])
    bare, dressed = (
        first_shot(speaker, short, Look(shirt=shirt)) for shirt in (None, (0.1, 0.1, 0.1))
    )
    covered = bare.ids != dressed.ids
    assert covered.any()
    assert (dressed.ids[covered] == 0).all()  # the shirt hides neck, and has no id
    assert (dressed.cover[covered] == 3).all()
    assert not bare.cover.any()
    assert np.abs(bare.picture.astype(int) - dressed.picture).max() > 30


def test_smooth_normals_are_unit_and_welded(speaker):
    normals = smooth_normals(speaker, speaker.named("clara"))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)
    first = np.unique(speaker.weld, return_index=True)[1]
    np.testing.assert_array_equal(normals, normals[first][speaker.weld])
    assert normals[speaker.landmarks["nose_tip"][0], 2] > 0.7


def test_an_existing_folder_is_left_alone(speaker, sequence, tmp_path):
    (tmp_path / "mine").mkdir()
    with pytest.raises(OutputError, match="exists already"):
        film(speaker, sequence, CAMERA, tmp_path / "mine")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        film(speaker, sequence, CAMERA, tmp_path / "file" / "clip")
    assert not list((tmp_path / "mine").iterdir())


def test_nothing_is_left_when_filming_stops_in_the_middle(speaker, sequence, tmp_path):
    def stop(done, _all_frames):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        film(speaker, sequence, CAMERA, tmp_path / "clip", progress=stop)
    assert not list(tmp_path.iterdir())


def test_a_worker_that_dies_is_one_line(speaker, sequence, tmp_path, monkeypatch):
    def kill(worker, arrays):
        if "lights" in arrays:
            os.kill(worker.pid, 9)
            worker._process.wait()
        original(worker, arrays)

    original = Worker.post
    monkeypatch.setattr(Worker, "post", kill)
    with pytest.raises(StudioError) as caught:
        film(speaker, sequence, CAMERA, tmp_path / "clip")
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_no_opengl_is_one_line_that_names_both_platforms():
    with pytest.raises(StudioError) as caught:
        Worker(one_triangle(np.eye(3))[0], platforms=("nothing", "nowhere"))
    assert "\n" not in str(caught.value)
    assert "nothing: " in str(caught.value)
    assert "nowhere: " in str(caught.value)


def test_the_worker_dies_with_its_parent():
    code = (
        "import sys; sys.path[:0] = sys.argv[1:]\n"
        "import numpy as np, time, test_filming as t\n"
        "from abs_engine.studio.process import Worker\n"
        "w = Worker(t.one_triangle(np.eye(3) * 500)[0])\n"
        "print(w.pid, flush=True); time.sleep(60)\n"
    )
    here = Path(__file__).resolve().parent
    parent = subprocess.Popen(
        [sys.executable, "-c", code, *map(str, (here, *here.parents[:2]))], stdout=subprocess.PIPE
    )
    with parent:
        worker = int(parent.stdout.readline())
        assert Path(f"/proc/{worker}").exists()
        parent.kill()
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline and alive(worker):
        time.sleep(0.05)
    assert not alive(worker)


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_the_environment_of_the_worker(monkeypatch):
    monkeypatch.setenv("LD_LIBRARY_PATH", "/somewhere::/else:")
    env = worker_environment("egl")
    assert env["LD_LIBRARY_PATH"] == "/somewhere:/else"
    assert (env["PYOPENGL_PLATFORM"], env["PYGLET_HEADLESS"]) == ("egl", "1")
    monkeypatch.setenv("LD_LIBRARY_PATH", ":")
    assert "LD_LIBRARY_PATH" not in worker_environment("osmesa")


@pytest.mark.parametrize(
    ("camera", "words"),
    [
        (Camera(CAMERA.matrix, (241, 180)), "even sizes"),
        (Camera(CAMERA.matrix, (240, 8)), "sides of 16 to 8192"),
    ],
)
def test_cameras_that_it_cannot_use(speaker, sequence, tmp_path, camera, words):
    with pytest.raises(ParameterError, match=words):
        film(speaker, sequence, camera, tmp_path / "clip")


@pytest.mark.parametrize(
    ("depth", "words"), [(100.0, "inside the head"), (3200.0, "place it within 3027 mm")]
)
def test_a_camera_inside_the_head_or_too_far(speaker, sequence, tmp_path, depth, words):
    away = replace(sequence, translations=sequence.translations * [1, 1, 0] + [0, 0, depth])
    with pytest.raises(ParameterError, match=words):
        film(speaker, away, CAMERA, tmp_path / "clip")


def test_a_pose_far_from_the_axis_still_projects_onto_the_ids(speaker, sequence):
    """Lip landmarks, projected, fall on pixels of the lips' own facets or their neighbours."""
    turned = Pose.from_vectors([2.9, 0.5, -0.4], [60.0, -40.0, 620.0])
    wide = replace(
        sequence,
        weights=sequence.weights[:1],
        rotations=turned.rotation_vector[None],
        translations=turned.translation[None],
    )
    plan = plan_of(speaker, wide, CAMERA, Look())
    with Take(speaker, plan, 0, ()) as take:
        now, shot = next(take.film(0, 1))
    points = speaker.named("clara") + now.offsets.astype(np.float32)
    ring = speaker.landmarks["outer_lip"]
    pixels = CAMERA.project(turned.apply(points[ring].astype(np.float64)))
    x, y = np.rint(pixels).astype(int).T
    facets = speaker.faces[shot.ids[y, x].astype(int) - 1]
    near = CAMERA.project(turned.apply(points[facets].astype(np.float64)))
    away = np.linalg.norm(near - pixels[:, None], axis=2).min(axis=1)
    assert np.median(away) < 1.0
