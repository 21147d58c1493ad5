"""Mistakes of a user who observes: each is named, or warned of where the result may still do."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from observed import before_cameras, mirror_room, two_cameras

from abs_engine.capture.dot_annotations import LIPS17, Mark
from abs_engine.capture.head import HeadChoice, head_motion
from abs_engine.capture.head_points import points_of_head
from abs_engine.capture.session import Tracks, check_together, follow_videos
from abs_engine.capture.view import View
from abs_engine.cli import main
from abs_engine.core.errors import ParameterError, TooFewPointsError, VideoError
from abs_engine.core.geometry import Pose
from abs_engine.dataset import camera_json
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.io.assets import load_speaker
from abs_engine.io.video import VideoInfo, VideoWriter

FRAMES = 3
HEAD = before_cameras()
CAMERA, PLACES = two_cameras()
SPEAKER = load_speaker()
DOTS = SPEAKER.vertices[lips17(SPEAKER)].astype(np.float64)


def mirrored_names() -> tuple[str, ...]:
    """Names of the same dots by who takes left for right."""
    where = DOTS * [-1, 1, 1]
    away = np.linalg.norm(where[:, None] - DOTS, axis=2)
    return tuple(LIPS17[k] for k in away.argmin(axis=1))


def followed(dots: np.ndarray = DOTS) -> Tracks:
    """Tracks of a head that stands still before both cameras."""
    views = [View(CAMERA, place) for place in PLACES]
    pixels = np.stack([view.project(HEAD.apply(dots)) for view in views])
    every = np.repeat(pixels[:, None], FRAMES, axis=1)
    shape = every.shape[:3]
    return Tracks(LIPS17, every, np.ones(shape), np.zeros(shape, bool), 25.0)


@dataclass
class Files:
    """Two videos of nothing, and what goes with them."""

    folder: Path

    def __post_init__(self) -> None:
        self.videos = [self.folder / "left.mp4", self.folder / "right.mp4"]
        for k, path in enumerate(self.videos):
            with VideoWriter(path, CAMERA.size, 25.0, 0) as video:
                for _ in range(FRAMES):
                    video.write(np.full((*CAMERA.size[::-1], 3), 90 + 9 * k, np.uint8))
        self.cameras = [self.folder / "left.json", self.folder / "right.json"]
        for path, place in zip(self.cameras, PLACES, strict=True):
            at = [place.rotation_vector], [place.translation]
            path.write_text(camera_json(CAMERA, *at))
        self.points = self.folder / "points.csv"
        self.write_points(followed().pixels[:, 0])
        self.pose = self.folder / "pose.csv"
        self.write_pose()

    def write_points(self, pixels: np.ndarray) -> None:
        """Where the dots are in frame 0, (V, N, 2)."""
        lines = [
            f"0,{view + 1},{name},{x:.2f},{y:.2f}"
            for view, places in enumerate(pixels)
            for name, (x, y) in zip(LIPS17, places, strict=True)
        ]
        self.points.write_text("\n".join(["frame,view,point,x,y", *lines]))

    def write_pose(self, turn: float = 1.0, shift: float = 1.0, head: Pose = HEAD) -> None:
        turned, shifted = turn * head.rotation_vector, shift * head.translation
        cells = ",".join(map(repr, np.r_[turned, shifted].tolist()))
        lines = [f"{k},{cells}" for k in range(FRAMES)]
        self.pose.write_text("\n".join(["frame,rx,ry,rz,tx,ty,tz", *lines]))

    def observe(self) -> int:
        parts = [*self.videos, "--calibration", *self.cameras, "--points", self.points]
        parts += ["--pose", self.pose, "-o", self.folder / "o.npz"]
        return main(["observe", *map(str, parts)])

    def refused(self, capsys: pytest.CaptureFixture[str]) -> str:
        """The one line with which it is refused."""
        assert self.observe() == 2
        assert not (self.folder / "o.npz").exists()
        *_, line = capsys.readouterr().err.splitlines()
        assert line.startswith("abs-engine: error: ")
        return line


@pytest.fixture
def files(tmp_path: Path) -> Files:
    return Files(tmp_path)


@pytest.fixture
def tracks(monkeypatch: pytest.MonkeyPatch) -> list[Tracks]:
    """What following the dots is to give; the last one counts."""
    given = [followed()]
    monkeypatch.setattr("abs_engine.capture.session.follow_videos", lambda *_, **__: given[-1])
    return given


@pytest.mark.parametrize(
    ("what", "option", "use"),
    [
        ("markers.csv", ("--review", "review.csv"), "videos"),
        ("markers.c3d", ("--overlay", "overlay.mp4"), "videos"),
        ("markers.csv", ("--corrections", "corrections.csv"), "videos"),
        ("markers.csv", ("--points", "points.csv"), "videos"),
        ("markers.csv", ("--calibration", "camera.json"), "videos"),
        ("markers.csv", ("--largest-error", "3"), "videos"),
        ("markers.csv", ("--squares", "7", "5"), "calibrate"),
        ("markers.csv", ("--mirror",), "calibrate"),
        ("left.mp4", ("--rename", "a=b"), "marker files"),
        ("left.mp4", ("--rate", "60"), "marker files"),
        ("left.mp4", ("--unit", "mm"), "marker files"),
        ("left.mp4", ("--board", "charuco"), "calibrate"),
        ("calibrate", ("--rigid", "a,b,c"), "videos and marker files"),
        ("calibrate", ("--rate", "60"), "marker files"),
        ("calibrate", ("--review", "review.csv"), "videos"),
    ],
)
def test_options_for_something_else_are_refused(tmp_path, monkeypatch, capsys, what, option, use):
    monkeypatch.chdir(tmp_path)
    for name in (n for n in option if n in ("corrections.csv", "points.csv", "camera.json")):
        (tmp_path / name).touch()
    there = sorted(tmp_path.iterdir())
    output = "o.json" if what == "calibrate" else "o.npz"
    assert main(["observe", what, *option, "-o", output]) == 2
    said = capsys.readouterr().err
    assert said == f"abs-engine: error: {option[0]} is for {use}; leave it out\n"
    assert sorted(tmp_path.iterdir()) == there


def test_calibrations_are_in_the_order_of_their_pair(files, capsys):
    files.cameras.reverse()
    said = files.refused(capsys)
    assert "left.json is the first camera of its pair" in said
    assert "exchange the two" in said


def test_calibrations_of_two_single_cameras_are_no_pair(files, capsys):
    for path in files.cameras:
        path.write_text(camera_json(CAMERA))
    said = files.refused(capsys)
    assert "left.json and " in said
    assert "right.json are both of a first or single camera; calibrate the two together" in said


@pytest.mark.parametrize("error", ["nan", "0", "-1", "inf"])
def test_a_largest_error_that_is_none_is_refused(files, capsys, error):
    words = [*files.videos, "--largest-error", error, "-o", files.folder / "o.npz"]
    assert main(["observe", *map(str, words)]) == 2
    assert f"{error} is not a number above 0" in capsys.readouterr().err


def test_view_1_is_the_direct_one_and_view_2_the_mirrors(files, tracks, capsys):
    """Exchanged, the pixels are those of a mirrored head behind the glass, to the last digit."""
    camera, glass, pose = mirror_room()
    with VideoWriter(files.folder / "both.mp4", camera.size, 25.0, 0) as video:
        for _ in range(FRAMES):
            video.write(np.full((*camera.size[::-1], 3), 90, np.uint8))
    files.videos, files.cameras = [files.folder / "both.mp4"], files.cameras[:1]
    files.cameras[0].write_text(camera_json(camera, mirror=glass.corners))
    dots = pose.apply(DOTS)
    pixels = np.stack([camera.project(dots), camera.project(glass.reflect(dots))])
    files.write_pose(head=pose)
    files.write_points(pixels[::-1])
    tracks.append(replace(tracks[0], pixels=np.repeat(pixels[::-1, None], FRAMES, axis=1)))
    said = files.refused(capsys)
    assert "behind the mirror; exchange the views: view 1 is the direct one, view 2 the" in said
    files.write_points(pixels)
    tracks.append(replace(tracks[0], pixels=np.repeat(pixels[:, None], FRAMES, axis=1)))
    assert files.observe() == 0


def test_a_calibration_is_for_pictures_of_the_videos_size(files, capsys):
    other = replace(CAMERA, size=(1600, 900))
    files.cameras[0].write_text(camera_json(other))
    said = files.refused(capsys)
    assert "left.json is for pictures of 1600x900 pixels" in said
    assert "left.mp4 has 640x640" in said


def test_a_video_is_not_given_twice(files, capsys):
    files.videos[1].write_bytes(files.videos[0].read_bytes())
    assert "right.mp4 come from the same video; give the other camera's" in files.refused(capsys)


def write_timed(path: Path, times: list[float]) -> None:
    """A video of nothing with frames at these moments, seconds."""
    with VideoWriter(path, CAMERA.size, 25.0, 0, uneven=True) as video:
        for time in times:
            video.write(np.full((*CAMERA.size[::-1], 3), 90, np.uint8), time)


def test_videos_that_lost_different_frames_are_named(files):
    """Their numbers of frames and their rates agree, as each lost one."""
    follow = [Mark(0, v, "nose", (300.0, 300.0)) for v in range(2)]
    write_timed(files.videos[0], [k / 25 + 0.004 * (k % 2) for k in range(11) if k != 7])
    write_timed(files.videos[1], [k / 25 for k in range(11) if k != 4])
    with pytest.raises(VideoError, match=r"frame 4 comes 0\.160 s .* and 0\.200 s in the other"):
        follow_videos(files.videos, follow)
    write_timed(files.videos[1], [k / 25 for k in range(11) if k != 7])
    assert follow_videos(files.videos, follow).pixels.shape[1] == 10


def test_clocks_that_drift_and_stamps_that_jitter_lose_no_frame():
    ntsc, times = 30 / 1.001, np.arange(900) / 30
    one = VideoInfo((640, 480), 30.0, 900, tuple(times))
    check_together(one, VideoInfo((640, 480), ntsc, 900, tuple(times * 1.001)))
    jitter = np.random.default_rng(0).normal(0, 0.004, 900)
    jitter[[0, -1]] = 0
    check_together(one, VideoInfo((640, 480), 30.0, 900, tuple(times + jitter)))
    lost = np.r_[times[:400], times[401:], 30.0]
    with pytest.raises(VideoError, match=r"frame 400 comes 13\.33"):
        check_together(one, VideoInfo((640, 480), 30.0, 900, tuple(lost + jitter / 4)))


@pytest.mark.parametrize("place", [(-30.0, 200.0), (200.0, -4.0), (640.0, 200.0)])
@pytest.mark.parametrize("view", [0, 1])
def test_corrections_outside_of_the_picture_are_named(files, view, place):
    marks = [Mark(0, v, "nose", (300.0, 300.0)) for v in range(2)]
    wrong = [Mark(2, view, "nose", place)]
    said = f"'nose' of view {view + 1} is outside of the picture in frame 2; give pixels"
    for points, corrections in ((marks, wrong), ([*marks, *wrong], [])):
        with pytest.raises(ParameterError, match=said):
            follow_videos(files.videos, points, corrections)


def test_points_that_count_frames_from_1_are_named(files, capsys):
    files.points.write_text(files.points.read_text().replace("\n0,", "\n1,"))
    assert "no place is given for frame 0 (frames count from 0); give every dot" in files.refused(
        capsys
    )


@pytest.mark.parametrize("name", ["points", "pose"])
def test_tables_with_semicolons_are_named(files, capsys, name):
    path = getattr(files, name)
    path.write_text(path.read_text().replace(",", ";"), encoding="utf-8-sig")
    said = files.refused(capsys)
    assert f"{name}.csv has semicolons between its columns; separate columns with commas" in said


@pytest.mark.parametrize("name", ["points", "pose"])
def test_columns_may_have_capitals(files, tracks, name, capsys):
    path = getattr(files, name)
    first, _, rest = path.read_text().partition("\n")
    path.write_text(f"{first.title()}\n{rest}")
    assert files.observe() == 0
    assert len(tracks) == 1
    assert "without the head" not in capsys.readouterr().out  # as none is


def test_numbers_with_decimal_commas_are_not_read_as_others(files, capsys):
    files.points.write_text(files.points.read_text().replace(".", ","))
    assert "line 2: 7 cells under 5 names; use commas only between" in files.refused(capsys)


def test_a_pose_in_degrees_is_named(files, capsys):
    files.write_pose(turn=np.degrees(1.0))
    said = files.refused(capsys)
    assert "frame 0: the head is turned by 180 radians, more than a full turn" in said
    assert "not degrees" in said


def test_a_pose_in_centimetres_is_named(files, tracks, capsys):
    files.write_pose(shift=0.1)
    assert "mm from its origin; give poses in radians and mm" in files.refused(capsys)


def test_a_rig_that_was_calibrated_in_centimetres_is_named(files, tracks, capsys):
    for path, place in zip(files.cameras, PLACES, strict=True):
        path.write_text(camera_json(CAMERA, [place.rotation_vector], [place.translation / 10]))
    said = files.refused(capsys)
    assert "mm from end to end; calibrate again with the side of the board's squares" in said


def test_left_and_right_exchanged_are_warned_of(files, tracks, capsys):
    assert files.observe() == 0
    assert "warning" not in capsys.readouterr().out
    (files.folder / "o.npz").unlink()
    tracks.append(replace(tracks[0], names=mirrored_names()))
    assert files.observe() == 0
    assert "warning: left and right seem exchanged in the names" in capsys.readouterr().out


@pytest.mark.parametrize("view", [0, 1])
@pytest.mark.parametrize(
    "names", [("upper_outer_1", "upper_outer_3"), ("corner_left", "lower_inner_2")]
)
def test_names_exchanged_in_one_view_are_named_as_such(files, tracks, capsys, names, view):
    """Of dots of one height, which both views agree on even so, at a wrong depth."""
    pixels, pair = tracks[0].pixels.copy(), [LIPS17.index(name) for name in names]
    pixels[view][:, pair] = pixels[view][:, pair[::-1]]
    tracks.append(replace(tracks[0], pixels=pixels))
    assert files.observe() == 0
    said = capsys.readouterr().out
    assert " 0 of 51 not found" in said
    assert f"warning: the dots {' and '.join(sorted(names, key=LIPS17.index))} have each" in said
    assert f"have each other's place in view {view + 1}: laid" in said
    assert f"exchange their names in view {view + 1} in the file" in said


def test_points_that_are_mostly_not_found_are_warned_of(files, tracks, capsys):
    pixels = tracks[0].pixels.copy()
    pixels[0, :, ::2] += [0.0, 40.0]
    tracks.append(replace(tracks[0], pixels=pixels))
    assert files.observe() == 0
    assert "check the order of videos, views and calibrations, and of x" in capsys.readouterr().out


def test_a_point_that_views_never_agree_on_is_not_said_to_lack():
    tracks = followed()
    tracks.pixels[0, :, LIPS17.index("corner_left")] += [0.0, 40.0]
    views = [View(CAMERA, place) for place in PLACES]
    with pytest.raises(
        TooFewPointsError, match=r"within 1\.5 px in no frame on corner_left; check"
    ):
        points_of_head(tracks, views, HeadChoice(unturned="nose"))


def test_a_point_that_was_lost_is_named_and_not_another_that_views_disagree_on():
    tracks = followed()
    tracks.pixels[0, :, LIPS17.index("upper_outer_1")] += [0.0, 40.0]
    tracks.pixels[:, :, LIPS17.index("corner_left")] = np.nan
    views = [View(CAMERA, place) for place in PLACES]
    with pytest.raises(TooFewPointsError, match="the axes of the head need 'corner_left', which"):
        points_of_head(tracks, views, HeadChoice(unturned="nose"))


def test_frames_without_a_pose_are_not_blamed_on_the_order(files, tracks, capsys):
    first, given, *others = files.pose.read_text().splitlines()
    gaps = [f"{line.partition(',')[0]},,,,,," for line in others]
    files.pose.write_text("\n".join([first, given, *gaps]))
    assert files.observe() == 0
    said = capsys.readouterr().out
    assert "2 frames without the head" in said
    assert "warning" not in said


def test_columns_without_a_name_are_as_if_they_were_not_there(files, tracks):
    lines = files.points.read_text().splitlines()
    files.points.write_text("\n".join(f"{line},," for line in lines))
    assert files.observe() == 0


def test_a_line_with_too_few_cells_is_named(files, capsys):
    files.points.write_text(files.points.read_text() + "\n1,1,nose")
    assert "3 cells under 5 names; give a cell for every name, empty" in files.refused(capsys)


def test_the_axes_are_of_a_frame_that_has_their_points():
    points = np.stack([DOTS, DOTS, DOTS])
    points[0, LIPS17.index("corner_left")] = np.nan
    points[1:, -3:-1] = np.nan  # fewer points in all, but the four of the axes
    motion = head_motion(points, LIPS17, HeadChoice(unturned="nose"))
    assert motion.found.all()
