"""The dataset format: encodings, files, checksums, and the reader."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
from datasets import FRONT, SIDE, SIZE, make_dataset

from abs_engine.core.camera import Camera
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.dataset import (
    SUMS,
    ClipEntry,
    camera_json,
    check_sums,
    codec,
    dataset_record,
    load_camera,
    load_dataset,
    load_placed_camera,
    load_truth,
    write_chunk,
    write_sums,
)
from abs_engine.dataset.card import card_text
from abs_engine.dataset.coco import box_and_area, coco, keypoint_names, skeleton
from abs_engine.dataset.offsets import StoredOffsets
from abs_engine.dataset.picture import picture_header, read_picture, write_picture
from abs_engine.studio.labels import CLEARANCE

FRAMES = 4


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("truth") / "made", FRAMES)


@pytest.fixture
def copy(made, tmp_path):
    shutil.copytree(made, tmp_path / "copy")
    return tmp_path / "copy"


# ---- encodings --------------------------------------------------------------------------------


def test_depth_is_kept_to_half_a_step():
    depth = np.array([[0.0, 512.374], [0.025001, 3276.75]])
    words = codec.encode_depth(depth)
    np.testing.assert_array_equal(words, [[0, 10247], [1, 65535]])
    assert words.dtype == np.uint16
    np.testing.assert_allclose(codec.decode_depth(words), depth, atol=0.0251)
    with pytest.raises(ParameterError, match="within 3277 mm"):
        codec.encode_depth(np.array([[3277.0]]))


def test_normals_are_kept_to_a_fifteen_thousandth():
    normals = np.array([[[0, 0, -1.0], [0.6, -0.8, 0], [1, 0, 0]]])
    seen = np.array([[True, True, False]])
    words = codec.encode_normals(normals, seen)
    np.testing.assert_array_equal(words[0], [[32768, 32768, 1], [52428, 6554, 32768], [0, 0, 0]])
    back = codec.decode_normals(words)
    np.testing.assert_allclose(back[0, :2], normals[0, :2], atol=2e-5)
    assert not back[0, 2].any()


def test_flow_is_kittis():
    flow = np.array([[[1.5, -2.25], [511.98, 0], [512, 0], [3, 3]]])
    words = codec.encode_flow(flow, np.array([[True, True, True, False]]))
    np.testing.assert_array_equal(
        words[0], [[32864, 32624, 1], [65535, 32768, 1], [0, 0, 0], [0, 0, 0]]
    )
    back, valid = codec.decode_flow(words)
    np.testing.assert_array_equal(valid, [[True, True, False, False]])
    np.testing.assert_allclose(back[0, :2], flow[0, :2], atol=1 / 128)
    assert not back[0, 2:].any()


def test_names_of_frames_and_chunks():
    assert codec.frame_name(12) == "000012.png"
    assert [codec.chunk_name(i) for i in (0, 99, 100, 12345)] == [
        "000000.npz", "000000.npz", "000100.npz", "012300.npz",
    ]  # fmt: skip


# ---- pictures ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "shape"), [("ids", (3, 5)), ("albedo", (3, 5, 3)), ("flow", (3, 5, 3))]
)
def test_pictures_come_back_and_are_rgb(tmp_path, kind, shape):
    dtype, channels = codec.PICTURES[kind]
    values = np.arange(np.prod(shape)).reshape(shape).astype(dtype) + 200
    path = tmp_path / "a.png"
    write_picture(path, values)
    np.testing.assert_array_equal(read_picture(path, kind, (5, 3)), values)
    assert picture_header(path) == (5, 3, 8 * np.dtype(dtype).itemsize, channels)
    if channels == 3:
        np.testing.assert_array_equal(
            cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[..., ::-1], values
        )


def test_pictures_come_back_from_a_path_that_is_no_utf_8(tmp_path):
    """In a process of its own, which OpenCV ends at such a path."""
    code = f"""
import numpy as np
from pathlib import Path
from abs_engine.dataset.picture import read_picture, write_picture
path = Path({str(tmp_path)!r}) / "\\udcff.png"
write_picture(path, np.full((3, 5), 7, np.uint16))
assert (read_picture(path, "ids", (5, 3)) == 7).all()
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_pictures_of_another_kind_are_refused(tmp_path):
    path = tmp_path / "a.png"
    with pytest.raises(InputFileError, match=r"a\.png is missing"):
        read_picture(path, "ids", (5, 3))
    with pytest.raises(InputFileError, match="is missing"):
        picture_header(path)
    path.write_bytes(b"GIF89a" + bytes(40))
    with pytest.raises(InputFileError, match="is not a PNG"):
        read_picture(path, "ids", (5, 3))
    with pytest.raises(InputFileError, match="is not a PNG"):
        picture_header(path)
    write_picture(path, np.zeros((3, 5), np.uint8))
    with pytest.raises(ModelFormatError, match=r"\(3, 5\) uint8, wanted \(3, 5\) uint16"):
        read_picture(path, "ids", (5, 3))
    with pytest.raises(FileNotFoundError, match=r"none/a\.png"):
        write_picture(tmp_path / "none" / "a.png", np.zeros((3, 5), np.uint8))


# ---- checksums --------------------------------------------------------------------------------


def test_checksums_are_those_of_coreutils(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/a b.txt").write_text("abc")
    (tmp_path / "z").write_text("")
    write_sums(tmp_path)
    abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert (tmp_path / SUMS).read_text().startswith(f"{abc}  sub/a b.txt\n")
    check_sums(tmp_path)
    done = subprocess.run(["sha256sum", "-c", "--quiet", SUMS], cwd=tmp_path, check=False)
    assert done.returncode == 0


def test_missing_altered_and_unlisted_files_are_told_apart(tmp_path):
    with pytest.raises(InputFileError, match="SHA256SUMS is missing"):
        check_sums(tmp_path)
    (tmp_path / "a").write_text("1")
    write_sums(tmp_path)
    (tmp_path / "b").write_text("1")
    check_sums(tmp_path)
    with pytest.raises(ModelFormatError, match="b is not listed"):
        check_sums(tmp_path, ["b"])
    (tmp_path / "a").write_text("2")
    with pytest.raises(ModelFormatError, match="a was altered"):
        check_sums(tmp_path)
    (tmp_path / "a").unlink()
    with pytest.raises(InputFileError, match="a does not exist"):
        check_sums(tmp_path)


# ---- cameras ----------------------------------------------------------------------------------


def test_a_camera_comes_back(tmp_path):
    path = tmp_path / "camera.json"
    path.write_text(camera_json(SIDE))
    alone = load_placed_camera(path)
    np.testing.assert_array_equal(alone.pose(7).rotation, np.eye(3))
    assert alone.mirror is None
    turns, moves = np.arange(6.0).reshape(2, 3) / 10, np.arange(6.0).reshape(2, 3)
    corners = np.arange(12.0).reshape(4, 3)
    path.write_text(camera_json(SIDE, turns, moves, corners))
    placed, camera = load_placed_camera(path), load_camera(path)
    np.testing.assert_array_equal(camera.distortion, SIDE.distortion)
    np.testing.assert_array_equal(camera.matrix, SIDE.matrix)
    assert (camera.size, camera.near, camera.far) == (SIZE, SIDE.near, SIDE.far)
    np.testing.assert_allclose(placed.pose(1).rotation_vector, turns[1])
    np.testing.assert_array_equal(placed.pose(1).translation, moves[1])
    np.testing.assert_array_equal(placed.mirror, corners)


GOOD = json.loads(camera_json(SIDE))


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("{", InputFileError, "is not a camera file"),
        ("[1]", ModelFormatError, "wrong value"),
        ('{"format": "abs_engine.camera", "version": 1}', ModelFormatError, "version 1"),
        ('{"format": "abs_engine.camera", "version": 2}', ModelFormatError, "size"),
        (json.dumps({**GOOD, "matrix": [[1, 2], [3, 4]]}), ModelFormatError, "has shape"),
        (json.dumps({**GOOD, "rotations": []}), ModelFormatError, "has shape"),
        (json.dumps({**GOOD, "distortion": ["0.1"]}), ModelFormatError, "not real numbers"),
        (json.dumps({**GOOD, "near": 1e400}), InputFileError, "is not a camera file"),
        (json.dumps({**GOOD, "near": 2, "far": 1}), ParameterError, "far beyond"),
        (json.dumps({**GOOD, "mirror": {}}), ModelFormatError, "rectangle"),
        (json.dumps({**GOOD, "near": -1}), ParameterError, "must be positive"),
    ],
)
def test_bad_camera_files(tmp_path, text, error, words):
    path = tmp_path / "camera.json"
    path.write_text(text)
    with pytest.raises(error, match=words) as caught:
        load_camera(path)
    assert str(path) in caught.value.problem
    assert "dataset again" not in caught.value.remedy  # the user may have written it
    path.unlink()
    with pytest.raises(InputFileError, match="does not exist"):
        load_camera(path)


# ---- vertex offsets ---------------------------------------------------------------------------


def test_offsets_are_read_chunk_by_chunk_and_few_are_kept(tmp_path, monkeypatch):
    rng = np.random.default_rng(0)
    whole = rng.normal(size=(520, 3, 3)).astype(np.float16)
    for first in range(0, 520, 100):
        write_chunk(tmp_path, first, whole[first : first + 100])
    stored, reads = StoredOffsets(tmp_path, 520, 3), []
    original = StoredOffsets._read
    monkeypatch.setattr(
        StoredOffsets, "_read", lambda *given: reads.append(given[1]) or original(*given)
    )
    assert len(stored) == 520
    for frame in range(520):
        np.testing.assert_array_equal(stored[frame], whole[frame])
    assert len(reads) == 6
    assert len(stored._kept) == 3
    with pytest.raises(ParameterError, match="give 0 to 519"):
        stored[520]
    with pytest.raises(ModelFormatError, match=r"not \(20, 4, 3\)"):
        StoredOffsets(tmp_path, 520, 4)[510]
    (tmp_path / "vertices/000100.npz").unlink()
    with pytest.raises(InputFileError, match=r"000100\.npz"):
        StoredOffsets(tmp_path, 520, 3)[150]
    with pytest.raises(ParameterError, match="are not a chunk"):
        write_chunk(tmp_path, 50, whole[:1])


def test_threads_may_share_offsets(tmp_path, monkeypatch):
    monkeypatch.setattr(StoredOffsets, "_read", lambda _, name, first: np.full((100, 1), first))
    stored, before = StoredOffsets(tmp_path, 1000, 1), sys.getswitchinterval()

    def read(seed: int) -> bool:
        frames = np.random.default_rng(seed).integers(0, 1000, 4000).tolist()
        return all(stored[frame] == frame // 100 * 100 for frame in frames)

    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as threads:
            assert all(threads.map(read, range(8)))
    finally:
        sys.setswitchinterval(before)


# ---- COCO -------------------------------------------------------------------------------------


def test_coco_by_hand():
    pixels = np.full((2, 68, 2), 3.0)
    pixels[0, 0], pixels[0, 1] = [-0.6, 2], [9.4994, -0.5]
    visible = np.zeros((2, 68), bool)
    visible[0, :2] = True
    made = coco(
        ["a.png", "b.png"], (10, 8), pixels, visible, np.array([[1, 2, 3, 4], [0] * 4]), [7, 0]
    )
    assert [i["file_name"] for i in made["images"]] == ["a.png", "b.png"]
    (found,) = made["annotations"]
    assert found["keypoints"][:9] == [0, 0, 0, 9.499, -0.5, 2, 3.0, 3.0, 1]
    assert (found["image_id"], found["bbox"], found["area"]) == (0, [1, 2, 3, 4], 7)
    assert found["num_keypoints"] == 67
    assert json.loads(json.dumps(made)) == made


def test_names_and_edges_of_the_68():
    names, edges = keypoint_names(), skeleton()
    assert len(set(names)) == 68
    assert (names[0], names[36], names[48], names[67]) == (
        "jaw_1", "right_eye_1", "outer_lip_1", "inner_lip_8",
    )  # fmt: skip
    assert len(edges) == 68 - 9 + 4  # nine parts, four of which are rings
    assert {min(e) for e in edges} | {max(e) for e in edges} == set(range(1, 69))
    assert [60, 49] in edges


def test_boxes():
    seen = np.zeros((6, 8), bool)
    assert box_and_area(seen) == ([0, 0, 0, 0], 0)
    seen[2:4, 3], seen[3, 6] = True, True
    assert box_and_area(seen) == ([3, 2, 4, 2], 3)


# ---- the reader -------------------------------------------------------------------------------


def test_a_dataset_is_iterated_view_by_view(made):
    dataset = load_dataset(made, verify=True)
    assert dataset.views == (("talk", "front"), ("talk", "side"))
    assert dataset.clips[0].frames == FRAMES
    front, side = dataset
    assert (front.name, front.folder.name, len(front)) == ("talk", "front", FRAMES)
    assert front.offsets is side.offsets  # read once for both
    assert (front.person, front.sentence, front.seed) == ("clara", "p a m i", 4)
    assert front.phonemes[0] == front.intervals[0].label
    assert front.video.is_file()
    assert front.frame_path(1).name == "000001.png"
    assert len(list(front.pictures())) == FRAMES
    assert front.mirror is None
    assert front.mirror_pixels is None
    assert not front.cover(0).any()
    assert not front.has("cover")


def test_a_view_of_a_dataset_has_a_number(made):
    dataset = load_dataset(made)
    assert [dataset[k].folder.name for k in range(len(dataset))] == ["front", "side"]
    assert dataset[np.int64(1)].folder.name == "side"
    for number in (2, -1, "front", 0.0):
        with pytest.raises(ParameterError, match=f"has no view {number!r}; count its 2 from 0"):
            dataset[number]


def test_poses_lead_from_head_to_world_to_camera(made):
    for truth in load_dataset(made):
        for frame in range(FRAMES):
            point = truth.vertices(frame)[truth.landmarks["landmark_68"][30]].astype(np.float64)
            world = truth.world_pose(frame).apply(point)
            seen = truth.camera.project(truth.placed.pose(frame).apply(world))
            np.testing.assert_allclose(truth.landmark_pixels[frame, 30], seen, atol=1e-3)
            np.testing.assert_allclose(
                truth.pixels(frame, truth.landmarks["landmark_68"][30:31])[0], seen, atol=1e-6
            )


def test_labels_of_a_pixel(made):
    """The pixel of the nose's tip: its facet, class, depth, normal, flow."""
    truth = load_truth(made / "talk" / "front")
    tip = truth.landmarks["landmark_68"][30:31]
    x, y = np.rint(truth.pixels(1, tip)[0]).astype(int)
    point = truth.pose(1).apply(truth.vertices(1)[tip].astype(np.float64))[0]
    assert truth.class_names[truth.class_ids(1)[y, x]] == "skin"
    corners = truth.vertices(1)[truth.faces[truth.facet_ids(1)[y, x] - 1]]
    assert np.linalg.norm(corners - truth.vertices(1)[tip], axis=1).min() < 4
    assert truth.depth(1)[y, x] == pytest.approx(point[2], abs=2.5)
    assert truth.normals(1)[y, x, 2] < -0.7
    assert np.linalg.norm(truth.normals(1)[y, x]) == pytest.approx(1, abs=1e-4)
    flow, valid = truth.flow(1)
    assert valid[y, x]
    moved = truth.pixels(2, tip)[0] - truth.pixels(1, tip)[0]
    np.testing.assert_allclose(flow[y, x], moved, atol=0.1)
    assert not truth.flow(FRAMES - 1)[1].any()
    assert truth.albedo(1)[y, x].min() > 60
    assert truth.albedo(1)[0, 0].max() == 0


def test_curves_of_the_lips(made):
    truth = load_truth(made / "talk" / "front")
    marks = truth.landmarks["landmark_68"]
    for frame in range(FRAMES):
        face = truth.vertices(frame)[marks].astype(np.float64)
        opening = max(face[62, 1] - face[66, 1], 0)
        assert truth.aperture[frame] == pytest.approx(opening, abs=1e-4)
        wide = np.linalg.norm(face[48] - face[54])
        assert truth.width[frame] == pytest.approx(wide, abs=1e-4)
    np.testing.assert_array_equal(truth.lip_pixels, truth.landmark_pixels[:, 48:])
    np.testing.assert_array_equal(truth.lip_visible, truth.landmark_visible[:, 48:])
    assert truth.in_picture.all()
    assert truth.weld.max() + 1 < len(truth.neutral)


def test_a_hand_made_truth_needs_no_files():
    from abs_engine.dataset import Truth

    truth = Truth(
        folder=None, camera=FRONT, rate=25.0, person="", sentence="", command="", seed=0,
        unit_names=(), unit_weights=np.zeros((2, 0)), identity_weights=np.zeros(0, np.float32),
        neutral=np.ones((3, 3), np.float32), offsets=np.zeros((2, 3, 3), np.float16),
        faces=np.array([[0, 1, 2]]), facet_class=np.ones(1, np.uint8), class_names=("", "skin"),
        rotations=np.zeros((2, 3)), translations=np.tile([0, 0, 99.0], (2, 1)),
        closed=np.zeros(2, bool), landmarks={},
    )  # fmt: skip
    np.testing.assert_array_equal(truth.points(np.array([2])), np.ones((2, 1, 3)))
    np.testing.assert_allclose(truth.pixels(1, np.array([0]))[0], [83.9, 60.42])
    with pytest.raises(ParameterError, match="give 0 to 1"):
        truth.vertices(-1)


@pytest.mark.parametrize("part", ["", "talk"])
def test_of_several_cameras_one_must_be_named(made, part):
    with pytest.raises(ParameterError, match="name one: talk/front, talk/side"):
        load_truth(made / part)


def test_the_path_of_a_truth(made, monkeypatch):
    assert load_truth(made / "talk/side", verify=True).folder.name == "side"
    monkeypatch.chdir(made / "talk")
    assert load_truth("front").camera.matrix[0, 0] == FRONT.matrix[0, 0]
    with pytest.raises(InputFileError, match="is not a clip of"):
        load_truth(made / "talk/back")
    with pytest.raises(ParameterError, match="no camera 'back'"):
        load_dataset(made).view("talk", "back")
    with pytest.raises(ParameterError, match="no clip 'song'"):
        load_dataset(made).clip("song")


def test_a_dataset_of_one_view_is_its_truth(copy):
    record = json.loads((copy / "dataset.json").read_text())
    record["clips"][0]["cameras"] = ["side"]
    (copy / "dataset.json").write_text(json.dumps(record))
    write_sums(copy)
    assert load_truth(copy).folder == copy / "talk/side"
    assert load_truth(copy / "talk").folder == copy / "talk/side"


@pytest.mark.parametrize(
    "name",
    ["dataset.json", "talk/truth.npz", "talk/front/camera.json", "talk/front/points.npz", SUMS,
     "talk/front/video.mp4"],
)  # fmt: skip
def test_a_missing_file_is_named(copy, name):
    (copy / name).unlink()
    with pytest.raises(InputFileError, match=name):
        load_truth(copy / "talk/front")


@pytest.mark.parametrize(
    "name", ["talk/truth.npz", "talk/front/camera.json", "talk/front/points.npz"]
)
def test_altered_numbers_are_always_found(copy, name):
    (copy / name).write_bytes((copy / name).read_bytes() + b" ")
    with pytest.raises(ModelFormatError, match=f"{name} was altered"):
        load_dataset(copy)
    with pytest.raises(ModelFormatError, match=f"{name} was altered"):
        load_truth(copy / "talk/front")


@pytest.mark.parametrize("name", ["talk/front/ids/000001.png", "talk/vertices/000000.npz"])
def test_altered_pictures_are_found_when_asked(copy, name):
    (copy / name).write_bytes((copy / name).read_bytes() + b" ")
    load_truth(copy / "talk/side")
    for read in (
        lambda: load_dataset(copy, verify=True),
        lambda: load_truth(copy / "talk/front", verify=True),
    ):
        with pytest.raises(ModelFormatError, match=f"{name} was altered"):
            read()


def test_a_frame_may_be_one_of_numpy_s_numbers(made):
    truth, nose = load_truth(made / "talk/front"), np.array([30])
    for kind in (np.int64, np.uint8):  # before the file is read, and after it
        fresh = load_truth(made / "talk/front")
        np.testing.assert_array_equal(fresh.vertices(kind(1)), truth.vertices(1))
        np.testing.assert_array_equal(fresh.pixels(kind(1), nose), truth.pixels(1, nose))
        for pose in ("pose", "world_pose"):
            ours, plain = (getattr(truth, pose)(frame) for frame in (kind(1), 1))
            np.testing.assert_array_equal(ours.rotation, plain.rotation)
            np.testing.assert_array_equal(ours.translation, plain.translation)


@pytest.mark.parametrize("frame", [FRAMES, -1])
def test_no_frame_is_counted_from_the_end(made, frame):
    truth, nose = load_truth(made / "talk/front"), np.array([30])
    for read in (truth.vertices, truth.pose, truth.world_pose, lambda k: truth.pixels(k, nose)):
        with pytest.raises(ParameterError, match=f"there is no frame {frame}; give 0 to 3"):
            read(frame)


def test_a_frame_that_is_not_there(copy):
    truth = load_truth(copy / "talk/front")
    with pytest.raises(ParameterError, match="give 0 to 3"):
        truth.depth(4)
    with pytest.raises(ParameterError, match="give 0 to 3"):
        truth.cover(-1)
    (copy / "talk/front/flow/000001.png").unlink()
    with pytest.raises(InputFileError, match=r"flow/000001\.png is missing"):
        truth.flow(1)


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("{", InputFileError, "is not a list of clips"),
        ("[]", ModelFormatError, "wrong one"),
        ('{"format": "abs_engine.dataset", "version": 1}', ModelFormatError, "wanted"),
        ('{"format": "abs_engine.dataset", "version": 2}', ModelFormatError, "lacks command"),
    ],
)
def test_bad_lists_of_clips(tmp_path, text, error, words):
    (tmp_path / "dataset.json").write_text(text)
    with pytest.raises(error, match=words):
        load_dataset(tmp_path)


def test_what_is_no_ground_truth(tmp_path):
    for read in (load_dataset, load_truth):
        with pytest.raises(InputFileError, match="is not ground truth"):
            read(tmp_path)


# ---- the card ---------------------------------------------------------------------------------


def test_the_card_tells_what_there_is():
    clip = ClipEntry("talk", "clara", "a|b", 7, 29.97, ("front", "left"))
    record = dataset_record(
        command="abs-engine synth x", seed=3, engine="0.1", clips=[clip], labels=("ids", "flow")
    )
    card = card_text(record)
    assert f"more than {CLEARANCE:g} mm" in " ".join(card.split())
    assert "`dots`" in card
    assert "| talk | clara | a\\|b | 7 | 29.97 | front, left |" in card
    assert "7 frames in 2 views" in card
    assert "abs-engine synth x\n\nwith seed 3" in card
    assert "- `flow`: 16-bit RGB" in card
    assert "- `normals`" not in card
    assert "CC0" in card
    assert "{" not in card
    assert f"\n`{codec.TRUTH}`: `rate`" in card


def test_the_snippet_of_the_card_runs(made, monkeypatch):
    card = (made / "README.md").read_text()
    code = card.split("## Reading and checking\n\n")[1].split("\n\n`abs-engine check")[0]
    monkeypatch.chdir(made)
    scope = {}
    exec("\n".join(line[4:] for line in code.splitlines()), scope)
    assert scope["truth"].folder.name == "side"
    assert scope["frame"] == FRAMES - 1


def test_a_pose_in_the_world(made):
    truth = load_truth(made / "talk/front")
    joined = truth.placed.pose(0).apply(truth.world_pose(0).translation)
    np.testing.assert_allclose(joined, truth.translations[0])
    assert isinstance(truth.pose(0), Pose)
    assert isinstance(truth.camera, Camera)
