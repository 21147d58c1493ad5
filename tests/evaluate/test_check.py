"""The checker: silent on a true dataset, and each planted fault is found where it was planted.

All planted datasets are signed anew, unless the test says otherwise, so that the checksums cannot
give the fault away.
"""

from __future__ import annotations

import itertools
import json
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
from datasets import SIZE, Shot, Take, make_dataset

from abs_engine import cli
from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.core.geometry import Pose
from abs_engine.dataset import Phoneme, load_clip, load_dataset, write_sums
from abs_engine.dataset.camera_file import camera_json, load_placed_camera
from abs_engine.dataset.codec import frame_name
from abs_engine.dataset.picture import read_picture, write_picture
from abs_engine.dataset.view import load_view
from abs_engine.evaluate.check import Finding, check_dataset
from abs_engine.evaluate.check.finding import merged
from abs_engine.evaluate.check.footage import time_findings, watched
from abs_engine.evaluate.check.ids import shift
from abs_engine.evaluate.check.marks import certain, mark_classes
from abs_engine.evaluate.check.motion import camera_findings, length_findings, vector_findings
from abs_engine.evaluate.check.order import order_findings
from abs_engine.evaluate.check.speech import contact_findings, interval_findings
from abs_engine.evaluate.check.visibility import look
from abs_engine.io.video import VideoWriter, read_frames

FRAMES = 5
HALF_PIXEL = np.array([[0, 0, 0.5], [0, 0, 0], [0, 0, 0]])


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("check") / "clean", FRAMES)


@pytest.fixture(scope="module")
def front(tmp_path_factory):
    """As the clean dataset, by one of its cameras."""
    return make_dataset(tmp_path_factory.mktemp("check") / "front", FRAMES, side=False)


@pytest.fixture
def planted(front, tmp_path):
    """A copy of a clean dataset to plant a fault in, and the checker's words for it."""

    def check(plant, *, sign=True, frames=2, source=front):
        folder = tmp_path / "planted"
        shutil.copytree(source, folder)
        plant(folder)
        if sign:
            write_sums(folder)
        return [str(finding) for finding in check_dataset(folder, frames=frames)]

    return check


def arrays(change, file="talk/truth.npz"):
    """Plant: change a dict of arrays in place."""

    def plant(folder):
        with np.load(folder / file) as archive:
            data = dict(archive)
        change(data)
        np.savez_compressed(folder / file, **data)

    return plant


def both(*plants):
    def plant(folder):
        for part in plants:
            part(folder)

    return plant


def vertices(change):
    """Plant: change neutral and offsets, (..., V, 3) each."""
    return both(
        arrays(lambda d: d.update(neutral=change(d["neutral"]).astype(np.float32))),
        arrays(
            lambda d: d.update(offsets=change(d["offsets"]).astype(np.float16)),
            "talk/vertices/000000.npz",
        ),
    )


def pictures(kind, change, camera="front"):
    """Plant: change every picture of a kind; `change` gets them all, in order."""

    def plant(folder):
        paths = [folder / "talk" / camera / kind / frame_name(t) for t in range(FRAMES)]
        changed = change([read_picture(path, kind, SIZE) for path in paths])
        for path, image in zip(paths, changed, strict=True):
            write_picture(path, np.ascontiguousarray(image))

    return plant


def each(function):
    return lambda images: [function(image) for image in images]


def camera(camera="front", **changes):
    """Plant: another camera.json; a change is a function of what the file says."""

    def plant(folder):
        path = folder / "talk" / camera / "camera.json"
        data = json.loads(path.read_text())
        for key, change in changes.items():
            data[key] = change(np.array(data[key])).tolist()
        path.write_text(json.dumps(data))

    return plant


def footage(change, camera="front"):
    """Plant: another video; `change` gets its frames."""

    def plant(folder):
        path = folder / "talk" / camera / "video.mp4"
        frames = change(list(read_frames(path)))
        with VideoWriter(path, SIZE, 25.0, 10) as video:
            for frame in frames:
                video.write(frame)

    return plant


def redrawn(kind):
    """Plant: ids or depth taken half a pixel beside the centres of the pixels."""

    def plant(folder):
        truth = load_dataset(folder).view("talk", "front")
        matrix = truth.camera.matrix + HALF_PIXEL
        beside = type(truth.camera)(matrix, SIZE, truth.camera.distortion)
        for frame in range(FRAMES):
            points = truth.pose(frame).apply(truth.vertices(frame).astype(np.float64))
            labels = Shot(take_of(truth), beside, points, points, None).labels
            write_labels(folder, kind, frame, labels, truth)

    return plant


def take_of(truth):
    from abs_engine.io.assets import load_speaker

    return Take(load_speaker(), truth.neutral, [], [], 0)


def write_labels(folder, kind, frame, labels, truth):
    from abs_engine.dataset.codec import encode_depth

    path = folder / "talk/front" / kind / frame_name(frame)
    if kind == "ids":
        write_picture(path, labels["ids"].astype(np.uint16))
        return
    seen = truth.facet_ids(frame) > 0  # only the depth is off, not the outline
    depth = np.where(labels["depth"] > 0, labels["depth"], truth.depth(frame))
    write_picture(path, encode_depth(np.where(seen, depth, 0)))


def range_instead_of_depth(images):
    """Distance from the camera's centre instead of along its axis."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    longer = np.sqrt(1 + ((x - 81.3) / 260) ** 2 + ((y - 57.8) / 262) ** 2)
    return [np.rint(image * longer).astype(np.uint16) for image in images]


def inverted(vectors):
    return -vectors


def flipped_normals(image):
    return np.where(image.any(axis=2, keepdims=True), 65536 - image.astype(int), 0).astype(
        np.uint16
    )


def other_way(image):
    """Flow with its direction turned round."""
    out = image.astype(int)
    out[..., :2] = np.where(image[..., 2:] > 0, 65536 - out[..., :2], 0)
    return out.astype(np.uint16)


def exchanged(images):
    """The first and the last in each other's place."""
    return [images[-1], *images[1:-1], images[0]]


def first_mirrored(images):
    return [np.ascontiguousarray(images[0][:, ::-1]), *images[1:]]


def later(images):
    """Every label one frame late."""
    return [images[0], *images[:-1]]


def points(change):
    return arrays(change, "talk/front/points.npz")


def mirrored_marks(data):
    """Left and right of the eyes exchanged."""
    marks = data["landmark_68"].copy()
    marks[36:42], marks[42:48] = data["landmark_68"][42:48], data["landmark_68"][36:42]
    data["landmark_68"] = marks


def coco(change):
    def plant(folder):
        path = folder / "talk/front/coco.json"
        data = json.loads(path.read_text())
        for annotation in data["annotations"]:
            change(annotation)
        path.write_text(json.dumps(data))

    return plant


def remove(name):
    return lambda folder: (folder / name).unlink()


FAULTS = {
    "y and z of the vertices swapped": (vertices(lambda v: v[..., [0, 2, 1]]), "y does not point"),
    "x of the vertices mirrored": (vertices(lambda v: v * [-1, 1, 1]), "x does not point"),
    "ids half a pixel off": (redrawn("ids"), "a shift of (-0.5"),
    "depth half a pixel off": (redrawn("depth"), "depth does not agree"),
    "principal point half a pixel off": (
        camera(matrix=lambda m: m + HALF_PIXEL),
        "ids do not lie on their facets",
    ),
    "vertices in metres": (vertices(lambda v: v / 1000), "not as far apart as in mm"),
    "positions in metres": (
        both(
            arrays(lambda d: d.update(translations=d["translations"] / 1000)),
            camera(translations=lambda t: t / 1000),
        ),
        "the camera is inside the head",
    ),
    "angles in degrees": (
        arrays(lambda d: d.update(rotations=np.degrees(d["rotations"]))),
        "not in radians",
    ),
    "depth in steps of 0.1 mm": (pictures("depth", each(lambda i: i // 2)), "ratio 0.5"),
    "depth one per cent too large": (
        pictures("depth", each(lambda i: np.rint(i * 1.01).astype(np.uint16))),
        "ratio 1.01",
    ),
    "distance for depth": (pictures("depth", range_instead_of_depth), "depth does not agree"),
    "camera to head for head to camera": (
        arrays(lambda d: d.update(rotations=inverted(d["rotations"]))),
        "ids do not lie on their facets",
    ),
    "camera pose inverted": (camera(rotations=inverted), "ids do not lie on their facets"),
    "landmarks of the eyes exchanged": (arrays(mirrored_marks), "landmark_68 is not in its order"),
    "landmarks shuffled": (
        arrays(
            lambda d: d.update(landmark_68=np.random.default_rng(0).permutation(d["landmark_68"]))
        ),
        "landmark_68 is not in its order",
    ),
    "outer lip shuffled": (
        arrays(lambda d: d.update(outer_lip=np.sort(d["outer_lip"]))),
        "outer_lip is not a ring",
    ),
    "corners of the mouth in one place": (
        arrays(lambda d: d.update(mouth_corners=d["mouth_corners"][[0, 0]])),
        "gap is not that of the mesh",
    ),
    "ids one frame late": (pictures("ids", later), "ids do not lie on their facets"),
    "normals one frame late": (pictures("normals", later), "talk/front/normals"),
    "albedo one frame late": (pictures("albedo", later), "talk/front/albedo"),
    "vertices one frame late": (
        arrays(
            lambda d: d.update(offsets=np.concatenate([d["offsets"][:1], d["offsets"][:-1]])),
            "talk/vertices/000000.npz",
        ),
        "gap is not that of the mesh",
    ),
    "video one frame late": (footage(later), "is not in step with the labels"),
    "a frame of the video missing": (footage(lambda f: f[:-1]), "another number of frames"),
    "first and last frame of the video exchanged": (footage(exchanged), "looks like another frame"),
    "a frame of the video mirrored": (footage(first_mirrored), "video.mp4: frame 0: is mirrored"),
    "first and last picture before compression exchanged": (
        pictures("frames", exchanged),
        "front/frames: frame 0 and 1 more: looks like another frame (as in frame 4",
    ),
    "a picture before compression mirrored": (
        pictures("frames", first_mirrored),
        "front/frames: frame 0: is mirrored",
    ),
    "video of something else": (
        footage(each(lambda f: np.random.default_rng(1).integers(0, 255, f.shape, np.uint8))),
        "does not look like its labels",
    ),
    "ids without the + 1": (
        pictures("ids", each(lambda i: np.where(i > 1, i - 1, i).astype(np.uint16))),
        "ids do not lie on their facets",
    ),
    "ids of another mesh": (
        pictures("ids", each(lambda i: np.where(i > 0, i + 30_000, 0).astype(np.uint16))),
        "ids name facets that do not exist",
    ),
    "flow turned round": (pictures("flow", each(other_way)), "flow does not agree"),
    "flow with x and y exchanged": (
        pictures("flow", each(lambda i: i[..., [1, 0, 2]])),
        "flow does not agree",
    ),
    "flow from the frame before": (pictures("flow", later), "flow of the last frame leads nowhere"),
    "normals turned inwards": (pictures("normals", each(flipped_normals)), "normals do not agree"),
    "normals in BGR order": (
        pictures("normals", each(lambda i: i[..., ::-1])),
        "normals do not agree",
    ),
    "albedo empty": (pictures("albedo", each(np.zeros_like)), "albedo is empty"),
    "a hole in the face": (
        both(*(pictures(k, each(lambda i: punched(i))) for k in ("ids", "depth"))),
        "ids lack a part of the head",
    ),
    "closed turned round": (
        arrays(lambda d: d.update(closed=~d["closed"])),
        "closed does not follow from gap",
    ),
    "gap in metres": (arrays(lambda d: d.update(gap=d["gap"] / 1000)), "gap is not that"),
    "phonemes of frames one late": (
        arrays(lambda d: d.update(phonemes=np.roll(d["phonemes"], 2))),
        "another phoneme than its time",
    ),
    "phonemes overlapping": (
        arrays(lambda d: d.update(phoneme_end=d["phoneme_end"] + 0.05)),
        "phonemes overlap",
    ),
    "p said to be elsewhere": (
        arrays(
            lambda d: d.update(
                phonemes=np.where(d["closed"], "a", "p"),
                phoneme_label=np.where(d["phoneme_label"] == "p", "a", "p"),
            )
        ),
        "the lips do not meet",
    ),
    "landmarks in the picture half a pixel off": (
        points(lambda d: d.update(landmark_pixels=d["landmark_pixels"] + 0.5)),
        "landmark_pixels are not where",
    ),
    "visible for hidden": (
        points(lambda d: d.update(landmark_visible=~d["landmark_visible"])),
        "landmark_visible does not agree",
    ),
    "in_picture turned round": (
        points(lambda d: d.update(in_picture=~d["in_picture"])),
        "in_picture does not agree",
    ),
    "COCO with boxes of two corners": (
        coco(lambda a: a.update(bbox=[*a["bbox"][:2], sum(a["bbox"][::2]), sum(a["bbox"][1::2])])),
        "a box or an area is not that of the ids",
    ),
    "COCO of one corner at (1, 1)": (
        coco(lambda a: a.update(keypoints=[v + (i % 3 < 2) for i, v in enumerate(a["keypoints"])])),
        "keypoints are not those",
    ),
    "too few arrays": (arrays(lambda d: d.pop("gap")), "lacks gap"),
    "arrays of other frames": (arrays(lambda d: d.update(gap=d["gap"][1:])), "'gap' of"),
    "NaN": (arrays(lambda d: d["rotations"].__setitem__((2, 1), np.nan)), "NaN or infinity"),
    "a frame missing": (remove("talk/front/ids/000003.png"), "ids: frame 3: a picture is missing"),
    "a card missing": (remove("README.md"), "README.md: the file is missing"),
    "a video missing": (remove("talk/front/video.mp4"), "front/video.mp4: the file is missing"),
    "a picture of 8 bits": (
        lambda folder: cv2.imwrite(
            str(folder / "talk/front/depth/000002.png"), np.zeros(SIZE[::-1], np.uint8)
        ),
        "a wrong size or depth (160x120, 8 bits, 1 channels)",
    ),
}
SIDE_FAULTS = {
    "camera path one frame late": (
        camera("side", translations=lambda t: np.vstack([t[:1], t[:-1]])),
        "talk/side/ids: frame 4:",
    ),
    "distortion left out": (camera("side", distortion=np.zeros_like), "talk/side/ids: frame 0"),
}


def punched(image):
    out = image.copy()
    out[35:45, 78:88] = 0
    return out


def test_a_true_dataset_is_clean(clean):
    steps = []
    assert check_dataset(clean, progress=lambda *step: steps.append(step)) == []
    assert steps == [(i + 1, 2 * FRAMES) for i in range(2 * FRAMES)]


def test_a_true_dataset_of_one_camera_is_clean_in_all_its_frames(front):
    assert check_dataset(front, frames=None) == []


@pytest.fixture(scope="module")
def mirrored(tmp_path_factory):
    """By one camera, before a mirror."""
    folder = tmp_path_factory.mktemp("check") / "mirror"
    return make_dataset(folder, 3, mirror=True, lossless=False, side=False)


def test_a_true_dataset_with_a_mirror_is_clean_and_a_moved_mirror_is_not(mirrored, tmp_path):
    folder = shutil.copytree(mirrored, tmp_path / "mirror")
    assert check_dataset(folder) == []
    path = folder / "talk/front/camera.json"
    placed = load_placed_camera(path)
    moved = placed.mirror + np.array([0, 0, 3.0])
    path.write_text(camera_json(placed.camera, placed.rotations, placed.translations, moved))
    write_sums(folder)
    said = "\n".join(map(str, check_dataset(folder)))
    assert "ids do not lie on their facets" in said
    assert "mirror_landmark_pixels are not where the vertices project to" in said


def test_landmarks_that_the_mirror_shows_are_held_against_the_ids(mirrored, tmp_path):
    points = "talk/front/points.npz"
    faults = {
        "all": (lambda seen: np.ones_like(seen), "mirror_landmark_visible does not agree"),
        "none": (lambda seen: np.zeros_like(seen), "mirror_landmark_visible does not agree"),
        "other": (lambda seen: ~seen, "mirror_landmark_visible does not agree"),
        "short": (lambda seen: seen[:-1], "'mirror_landmark_visible' of"),
    }
    for fault, (change, words) in faults.items():
        broken = tmp_path / fault
        shutil.copytree(mirrored, broken)
        key = "mirror_landmark_visible"
        arrays(lambda d, change=change, key=key: d.update({key: change(d[key])}), points)(broken)
        write_sums(broken)
        said = [str(finding) for finding in check_dataset(broken)]
        assert said
        assert all(words in line and points in line for line in said), said


@pytest.mark.parametrize(("rate", "found"), [(12.5, False), (25.0, True), (120.0, True)])
def test_a_turn_is_too_fast_by_the_second(rate, found):
    vectors = np.zeros((3, 3))
    vectors[2, 1] = 0.7  # 8.75, 17.5 and 84 radians per second
    poses = [Pose.from_vectors(row, np.zeros(3)) for row in vectors]
    said = [str(finding) for finding in vector_findings(vectors, poses, rate, "x")]
    assert ["rotations jump" in line for line in said] == ([True] if found else [])


@pytest.mark.parametrize("off", [-0.2, 0.2])
def test_a_gap_may_be_neither_smaller_nor_larger_than_on_the_mesh(clean, off):
    clip = load_dataset(clean).clip("talk")
    said = [str(f) for f in contact_findings(replace(clip, gap=clip.gap + off), [1], "x")]
    assert sum("gap is not that of the mesh" in line for line in said) == 1


@pytest.mark.parametrize(("late", "found"), [(0.9, False), (1.1, True)])
def test_phonemes_end_with_the_clip_or_a_frame_later(clean, late, found):
    clip = load_dataset(clean).clip("talk")
    last = Phoneme("_", 0.0, (len(clip) + late) / clip.rate)
    said = [str(f) for f in interval_findings(replace(clip, intervals=(last,)), "x")]
    assert any("lies outside of the clip" in line for line in said) == found


def test_a_camera_is_inside_the_head_if_it_is_in_one_frame(clean):
    truth = load_dataset(clean).view("talk", "front")
    assert not list(camera_findings(truth, "x"))
    near = truth.translations.copy()
    near[1] = [0, 20, 40]
    (said,) = camera_findings(replace(truth, translations=near), "x")
    assert "the camera is inside the head" in str(said)


@pytest.mark.parametrize(("length", "found"), [(6.2, False), (6.4, True)])
def test_a_rotation_of_more_than_a_whole_turn_is_not_in_radians(length, found):
    vectors = np.array([[length, 0, 0]])
    poses = [Pose.from_vectors(row, np.zeros(3)) for row in vectors]
    said = [str(finding) for finding in vector_findings(vectors, poses, 25.0, "x")]
    assert ["not in radians" in line for line in said] == ([True] if found else [])


@pytest.mark.parametrize(
    ("rate", "sense"), [(0.5, True), (25.0, True), (1000.0, True), (1001.0, False), (0.0, False)]
)
def test_every_rate_of_a_scene_makes_sense(front, rate, sense):
    dataset = load_dataset(front)
    clip = replace(load_clip(front / "talk"), rate=rate)
    found = length_findings(clip, replace(dataset.clips[0], rate=rate), "x")
    assert sense != any("the rate makes no sense" in str(finding) for finding in found)


def test_label_frames_that_are_held_against_a_video_are_spread_over_it_and_named_once():
    assert watched(2) == []
    assert watched(5) == [1, 2, 3]
    assert watched(102) == [1, 21, 41, 60, 80, 100]


def test_light_that_changes_and_a_mirror_do_not_put_a_video_out_of_step(tmp_path):
    folder = make_dataset(tmp_path / "dim", 6, mirror=True, lossless=False, side=False)
    for kind in ("albedo", "normals", "flow"):
        shutil.rmtree(folder / "talk" / "front" / kind)
    truth = load_view(load_clip(folder / "talk"), folder / "talk" / "front")
    frames = list(read_frames(truth.video))
    sights = [look(truth, frame) for frame in range(1, 5)]
    for gains in ((1.0, 0.7, 0.5, 0.7, 1.0, 0.7), (0.4, 0.6, 0.8, 1.0, 0.8, 0.6)):
        lit = {k: np.uint8(frame * gains[k]) for k, frame in enumerate(frames)}
        assert list(time_findings(truth, sights, lit, "video")) == []
        for late in (1, -1):
            moved = {k: lit[min(max(k - late, 0), 5)] for k in lit}
            (said,) = time_findings(truth, sights, moved, "video")
            assert "is not in step" in said.what
    black = {k: np.zeros_like(frame) for k, frame in enumerate(frames)}
    (said,) = time_findings(truth, sights, black, "video")
    assert "does not look like its labels" in said.what


@pytest.fixture
def watching(front):
    """A true view, its pictures, and its label frames that are held against them."""
    truth = load_view(load_clip(front / "talk"), front / "talk" / "front")
    pictures = dict(enumerate(frame.copy() for frame in read_frames(truth.video)))
    return truth, pictures, [look(truth, frame) for frame in range(1, FRAMES - 1)]


def test_what_is_a_little_nearer_hides_for_certain_unless_it_is_steep(watching):
    """A silhouette may pass between a landmark and the centres of the pixels around it."""
    truth, _, sights = watching
    classes = mark_classes(truth)
    seen, beyond = certain(truth, sights[0], classes)
    assert seen.sum() > 10
    nearer = replace(sights[0], depth=sights[0].depth - 10)
    level, steep = (replace(nearer, slope=np.full(len(nearer), by)) for by in (0.0, 15.0))
    assert (certain(truth, level, classes)[1] & seen).sum() > 10
    assert not (certain(truth, steep, classes)[1] & seen).any()
    assert (certain(truth, steep, classes)[1] >= beyond).all()


@pytest.mark.parametrize("lit", [0, FRAMES - 1])
def test_darkness_does_not_put_a_video_out_of_step(watching, lit):
    truth, pictures, sights = watching
    rng = np.random.default_rng(2)
    dark = {k: rng.integers(0, 2, shown.shape, np.uint8) for k, shown in pictures.items()}
    seen = {**dark, lit: pictures[lit]}
    assert list(time_findings(truth, sights, seen, "video")) == []


@pytest.mark.parametrize("flash", [1, FRAMES - 2])
def test_highlights_in_one_frame_do_not_put_a_video_out_of_step(watching, flash):
    truth, pictures, sights = watching
    x, y = sights[flash - 1].x[::3], sights[flash - 1].y[::3]
    pictures[flash][y, x] = 255
    assert list(time_findings(truth, sights, pictures, "video")) == []


def test_neighbours_in_each_others_place_are_found_and_highlights_do_not_count(watching):
    truth, pictures, sights = watching
    pictures[2], pictures[3] = pictures[3], pictures[2]
    said = [one.frame for one in order_findings(truth, {"video": pictures.items()})]
    assert said == [2, 3]
    pictures[2], pictures[3] = pictures[3], pictures[2] // 4
    pictures[1][sights[0].y[::3], sights[0].x[::3]] = 255
    assert list(order_findings(truth, {"video": pictures.items()})) == []


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(planted, fault):
    plant, words = FAULTS[fault]
    said = planted(plant)
    assert any(words in line for line in said), said


@pytest.mark.parametrize("fault", SIDE_FAULTS)
def test_a_fault_of_one_of_two_cameras_is_found(planted, clean, fault):
    plant, words = SIDE_FAULTS[fault]
    said = planted(plant, source=clean)
    assert any(words in line for line in said), said


CLASSES = (
    "skin", "upper_lip", "lower_lip", "inner_mouth", "upper_teeth", "lower_teeth", "tongue", "eyes",
)  # fmt: skip


@pytest.mark.parametrize("pair", list(itertools.combinations(CLASSES, 2)), ids="-".join)
def test_exchanged_classes_are_found(clean, pair):
    from abs_engine.dataset import load_clip
    from abs_engine.evaluate.check.classes import class_findings

    clip = load_clip(clean / "talk")
    assert not list(class_findings(clip, "x"))
    a, b = (clip.class_names.index(name) for name in pair)
    swap = np.arange(len(clip.class_names), dtype=np.uint8)
    swap[[a, b]] = b, a
    assert list(class_findings(replace(clip, facet_class=swap[clip.facet_class]), "x"))


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        (
            lambda f: (f / "talk/front/ids/000001.png").write_bytes(
                (f / "talk/front/ids/000002.png").read_bytes()
            ),
            "talk/front/ids/000001.png: the file was altered",
        ),
        (remove("talk/front/flow/000001.png"), "000001.png: the file is listed, but missing"),
        (lambda f: (f / "more.txt").write_text("x"), "more.txt: the file has no checksum"),
        (remove("SHA256SUMS"), "SHA256SUMS: the list of checksums is missing"),
    ],
)
def test_checksums_give_files_away(planted, plant, words):
    assert any(words in line for line in planted(plant, sign=False))


def test_one_wrong_frame_is_named(planted):
    def plant(folder):
        path = folder / "talk/front/depth/000004.png"
        write_picture(path, read_picture(path, "depth", SIZE) + np.uint16(40))

    said = planted(plant, frames=None)
    assert len(said) == 2
    assert all(line.startswith("talk/front/depth: frame 4: ") for line in said)
    assert "labels lie beside the ids" in said[0]


def test_the_shift_is_measured():
    """Right triangles below the diagonals of a grid of 10 px, looked up at (0.4, -0.3) px."""
    rng = np.random.default_rng(2)
    corner = rng.integers(0, 9, (4000, 2)) * 10.0
    inside = rng.uniform(0, 10, (4000, 2))
    inside = np.where(inside.sum(axis=1, keepdims=True) > 10, 10 - inside, inside)
    here = corner + inside - [0.4, -0.3]
    normals = np.array([[-1, 0], [0, -1], [np.sqrt(0.5), np.sqrt(0.5)]])
    outside = (here - corner) @ normals.T - [0, 0, 10 * np.sqrt(0.5)]
    edges = np.tile(normals, (4000, 1, 1))
    np.testing.assert_allclose(shift(edges, outside), (0.4, -0.3), atol=0.02)


def test_findings_are_lines():
    twice = [
        Finding("a", "is off", "1 px", 3),
        Finding("b", "is missing"),
        Finding("a", "is off", "9", 5),
    ]
    assert [str(f) for f in merged(twice)] == [
        "a: frame 3 and 1 more: is off (1 px)",
        "b: is missing",
    ]


def test_what_is_no_dataset(tmp_path):
    with pytest.raises(InputFileError, match="is not ground truth"):
        check_dataset(tmp_path)
    (tmp_path / "dataset.json").write_text('{"format": "abs_engine.dataset", "version": 9}')
    with pytest.raises(ModelFormatError, match="version 9"):
        check_dataset(tmp_path)


def test_the_command(front, planted, tmp_path, capsys):
    assert cli.main(["check", str(front)]) == 0
    assert "nothing wrong" in capsys.readouterr().out
    planted(remove("README.md"))
    assert cli.main(["check", str(tmp_path / "planted"), "--frames", "1"]) == 1
    assert "README.md: the file is missing\n" in capsys.readouterr().out
    assert cli.main(["check", str(tmp_path)]) == 2
    assert "is not ground truth" in capsys.readouterr().err


def test_phonemes_are_tuples(clean):
    first = load_dataset(clean).clip("talk").intervals[0]
    assert isinstance(first, Phoneme)
    assert first.start < first.end


@pytest.mark.parametrize(
    ("start", "end", "closed", "found"),
    [
        (1.2, 1.4, 1, False),
        (1.2, 1.4, 2, False),  # the nearest frame may belong to an f or v
        (1.2, 1.4, 3, True),
        (4.3, 4.4, 3, True),
        (4.6, 4.7, 3, False),  # after the last frame, and not near
        (2.9, 3.2, 3, False),
        (2.9, 3.2, 2, True),
    ],
)
def test_a_closure_between_two_frames_is_held_against_those_beside_it(
    clean, start, end, closed, found
):
    clip = load_dataset(clean).clip("talk")
    lips = np.arange(FRAMES) == closed
    said = Phoneme("p", start / clip.rate, end / clip.rate)
    labels = tuple("p" if start <= f < end else "a" for f in range(FRAMES))
    gap = np.where(lips, -1.0, 3.0)
    clip = replace(clip, intervals=(said,), phonemes=labels, closed=lips, gap=gap)
    findings = [f for f in contact_findings(clip, [], "talk") if "do not meet" in str(f)]
    assert bool(findings) == found
