"""Dots followed through a filmed session, by the command line, against where they truly were."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from observe_session import RIGID, Session, authored, observe, recorded
from observed import NAMES

from abs_engine.capture.dot_annotations import LIPS17, read_marks
from abs_engine.capture.dot_tracking import DotFollower
from abs_engine.capture.observations import Observations, read_observations
from abs_engine.cli import main
from abs_engine.dataset import camera_json, load_camera
from abs_engine.io.video import VideoWriter, probe, read_frames

FRAMES = 10
NOSE = NAMES.index("nose")

pytestmark = pytest.mark.skipif(
    not os.environ.get("ABS_ENGINE_SLOW"),
    reason="two minutes of filming and following; ABS_ENGINE_SLOW=1 runs it",
)


def motion(start: int, frames: int) -> np.ndarray:
    """Face units of the recording where it is there, else authored ones."""
    data = Path(os.environ.get("ABS_ENGINE_DATA") or Path(__file__).parents[3] / "shared" / "data")
    recording = data / "livelink_rom" / "alex_rom_3.csv"
    return recorded(recording, start, frames) if recording.is_file() else authored(frames)


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Two cameras; the motion is the recording's from where the mouth begins to open."""
    return Session(tmp_path_factory.mktemp("session"), motion(1997, FRAMES))


@pytest.fixture(scope="module")
def observed(filmed: Session) -> Observations:
    options = ("--overlay", str(filmed.folder / "overlay.mp4"))
    return read_observations(observe(filmed, *options))


def run(session: Session, *arguments: str) -> int:
    """Observe with what the fixture calibrated."""
    folder = session.folder
    calibration = [str(folder / f"camera{k}.json") for k in (1, 2)]
    return main(["observe", *arguments, "--calibration", *calibration])


def test_the_dots_are_within_a_third_of_a_millimetre(filmed: Session, observed: Observations):
    assert observed.names == NAMES
    assert observed.rate == pytest.approx(30)
    assert observed.found.mean() > 0.98
    assert filmed.rms(observed) < 0.3
    assert np.sqrt(np.nanmean(observed.error**2)) < 0.3
    motion = filmed.points[:, : len(LIPS17)]
    assert np.linalg.norm(np.ptp(motion, axis=0), axis=1).max() > 3  # the mouth did move


def test_the_heads_pose_is_found(filmed: Session, observed: Observations):
    true = np.stack([p.rotation_vector for p in filmed.heads])
    # pi about x is where rotation vectors turn over: compare what they do to an arm of 100 mm
    from abs_engine.core.geometry import rotations

    arm = rotations(observed.rotations) @ [0, 0, 100.0] - rotations(true) @ [0, 0, 100.0]
    assert np.linalg.norm(arm, axis=1).max() < 1.0
    assert observed.rigid_error.max() < 0.2


def test_the_overlay_marks_every_dot(filmed: Session, observed: Observations):
    path = filmed.folder / "overlay.mp4"
    assert probe(path).frames == FRAMES
    assert probe(path).size == (1280, 640)
    drawn, plain = next(read_frames(path)), next(read_frames(filmed.videos[0]))
    x, y = np.rint(observed.pixels[0, 0, NOSE]).astype(int)
    changed = np.abs(drawn[:, :640].astype(int) - plain).max(axis=2) > 60
    assert changed[y - 6 : y + 7, x - 6 : x + 7].sum() >= 6
    assert not changed[300:380, 20:60].any()  # bare wall


def test_a_covered_dot_is_flagged_and_a_person_can_correct_it(
    filmed: Session, observed: Observations, tmp_path: Path
):
    """The nose's dot is painted over in camera 1 from frame 4 to 7."""
    hidden = tmp_path / "hidden.mp4"
    with VideoWriter(hidden, (640, 640), 30.0, 0) as video:
        for frame, image in enumerate(read_frames(filmed.videos[0])):
            x, y = np.rint(filmed.pixels(frame)[0, NOSE]).astype(int)
            if 4 <= frame <= 7:
                image[y - 9 : y + 10, x - 9 : x + 10] = image[y - 14, x]
            video.write(image)
    common = [str(hidden), str(filmed.videos[1]), *RIGID]
    common += ["--reference", str(filmed.folder / "reference.csv")]
    common += ["--points", str(filmed.folder / "points.csv")]
    look = tmp_path / "look.csv"
    assert run(filmed, *common, "--review", str(look), "-o", str(tmp_path / "a.npz")) == 0
    lost = read_observations(tmp_path / "a.npz")
    assert lost.found[:, NOSE].tolist() == [True] * 4 + [False] * 4 + [True] * 2
    assert np.isnan(lost.points[4:8, NOSE]).all()
    rows = [r for r in csv.DictReader(look.open()) if r["point"] == "nose" and r["view"] == "1"]
    assert [r["frame"] for r in rows[:4]] == ["4", "5", "6", "7"]
    assert all(r["why"] == "lost" and r["x"] == "" for r in rows[:4])

    mended = tmp_path / "mended.csv"
    with mended.open("w") as file:
        file.write("frame,view,point,x,y\n")
        for frame in range(4, 8):
            x, y = filmed.pixels(frame)[0, NOSE]
            file.write(f"{frame},1,nose,{x:.2f},{y:.2f}\n")
        file.write("9,2,nose,,\n")  # and in frame 9 a person sees that it is hidden
    again = [*common, "--corrections", str(mended)]
    assert run(filmed, *again, "-o", str(tmp_path / "b.npz")) == 0
    done = read_observations(tmp_path / "b.npz")
    assert done.found[:, NOSE].tolist() == [True] * 9 + [False]
    off = np.linalg.norm(done.points[4:8, NOSE] - filmed.points[4:8, NOSE], axis=1)
    assert off.max() < 0.6
    assert not done.uncertain[4:8, NOSE].any()  # nothing there looks like a dot; a person looked
    others = np.arange(len(NAMES)) != NOSE
    assert done.points[:, others] == pytest.approx(
        observed.points[:, others], abs=0.05, nan_ok=True
    )


def test_a_correction_is_gone_on_from(filmed: Session):
    """A dot is pointed at on a neighbour at first; from the correction on it is the right one."""
    images = list(read_frames(filmed.videos[0]))
    true = np.stack([filmed.pixels(t)[0] for t in range(FRAMES)])
    nose, ear = NOSE, NAMES.index("ear_lower")
    start = true[0].copy()
    start[nose] += [40, 30]  # bare cheek
    follower = DotFollower(images[0], start)
    away = [np.linalg.norm(follower.start.places[nose] - true[0, nose])]
    for t in range(1, FRAMES):
        given = {nose: tuple(true[t, nose] + 1.0)} if t == 5 else {}
        seen = follower.step(images[t], given)
        away.append(np.linalg.norm(seen.places[nose] - true[t, nose]))
        assert np.linalg.norm(seen.places[ear] - true[t, ear]) < 2
        assert seen.corrected.tolist() == [i in given for i in range(len(NAMES))]
    assert not np.nanmin(away[:5]) < 10
    assert max(away[5:]) < 1.0


def test_a_mirror_in_the_picture_is_the_second_view(filmed: Session, tmp_path: Path):
    """The true calibration is given; the head's pose is read from a file."""
    session = Session(tmp_path, motion(1920, 5), mirror=True)
    (tmp_path / "camera.json").write_text(
        camera_json(session.camera, mirror=session.glass.corners)  # type: ignore[union-attr]
    )
    command = ["observe", str(session.videos[0]), "--calibration", str(tmp_path / "camera.json")]
    command += ["--points", str(session.write_points(tmp_path / "points.csv"))]
    command += ["--pose", str(session.write_poses(tmp_path / "poses.csv"))]
    assert main([*command, "-o", str(tmp_path / "o.npz")]) == 0
    seen = read_observations(tmp_path / "o.npz")
    off = np.linalg.norm(seen.of(LIPS17) - session.points[:, :17], axis=2)
    assert seen.found.mean() > 0.95
    assert np.sqrt(np.nanmean(off**2)) < 0.3


def test_bad_sessions_are_one_line(
    filmed: Session, observed: Observations, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    videos = [str(v) for v in filmed.videos]
    points, out = ["--points", str(filmed.folder / "points.csv")], ["-o", str(tmp_path / "o.npz")]
    few = tmp_path / "few.csv"
    lines = (filmed.folder / "points.csv").read_text().splitlines()
    few.write_text("\n".join(line for line in lines if ",lower_" not in line))
    late = tmp_path / "late.csv"
    late.write_text("frame,view,point,x,y\n99,1,nose,3,4\n")
    short = tmp_path / "short.mp4"
    with VideoWriter(short, (640, 640), 30.0, 0) as video:
        for _, image in zip(range(5), read_frames(filmed.videos[1]), strict=False):
            video.write(image)
    same = filmed.folder / "camera1.json"
    moved = tmp_path / "moved.json"
    near = [[3.0, 0, 0]]
    moved.write_text(camera_json(load_camera(same), [[0.0, 0, 0]], near))
    cases = [
        ([*videos, *points, *out], "nose alone"),
        ([*videos, "--points", str(few), *RIGID, *out], "14 places are missing in frame 0"),
        ([videos[0], str(short), *points, *RIGID, *out], "10 and 5 frames"),
        ([*videos, *points, *RIGID, "--corrections", str(late), *out], "frame 99"),
        ([videos[0], *points, *RIGID, *out], "1 videos and 2 calibrations"),
        ([*videos, *RIGID, *out], "--points is missing"),
        ([*videos, *points, "--rigid", "nose,chin,ear_lower", *out], "no point 'chin'"),
    ]
    for arguments, expected in cases:
        assert run(filmed, *arguments) == 2
        told = capsys.readouterr().err.strip().splitlines()[-1]
        assert expected in told
        assert not (tmp_path / "o.npz").exists()
    together = ["observe", *videos, "--calibration", str(same), str(moved), *points, *RIGID, *out]
    assert main(together) == 2
    assert "leaves depth open" in capsys.readouterr().err
    assert main(["observe", videos[0], "--calibration", str(same), *points, *RIGID, *out]) == 2
    assert "has no mirror" in capsys.readouterr().err
    assert not (tmp_path / "o.npz").exists()
    assert read_marks(few)
