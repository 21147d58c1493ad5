"""Films a session, observes it by the command line, and compares with where the dots were.

The head is moved by the recorded face units, or by authored ones without them. Run as a script it
films 150 frames at 30 Hz:  python tests/observe_session.py --frames 150 [--mirror] [--start 2100]
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import numpy as np
from observed import (
    FINER,
    NAMES,
    SKULL,
    before_cameras,
    board_picture,
    dotted_head,
    film,
    mirror_room,
    nodding,
    seen_from,
    two_cameras,
)
from scipy.spatial.transform import Rotation
from session_files import film_folder, write_csv

from abs_engine.capture.board import Board
from abs_engine.capture.dot_annotations import LIPS17
from abs_engine.capture.observations import Observations, read_observations
from abs_engine.cli import main
from abs_engine.core.geometry import Pose
from abs_engine.io.assets import load_speaker
from abs_engine.io.files import png, write_new
from abs_engine.io.video import VideoWriter
from abs_engine.papers.basu1998.motion import RECORDED_FROM
from abs_engine.studio.speech.livelink import play_recording, read_livelink

RATE = 30.0
BOARD = Board("charuco", 7, 5, 18.0)
BOARD_OPTIONS = ("--squares", "7", "5", "--square", "18")
RIGID = ("--rigid", ",".join(SKULL))


def recorded(path: Path, start: int, frames: int) -> np.ndarray:
    """Face units (T, 52) of the recording at 30 Hz, from a frame in which the mouth is at rest."""
    played = play_recording(read_livelink(path), load_speaker().unit_names, RATE)
    return played.weights[start : start + frames]


def authored(frames: int) -> np.ndarray:
    """Face units (T, 52) of a mouth that opens, rounds and spreads."""
    names, t = load_speaker().unit_names, np.arange(frames) / RATE
    out = np.zeros((frames, len(names)))
    out[:, names.index("jawOpen")] = 0.3 * np.sin(5 * t) ** 2
    out[:, names.index("mouthPucker")] = 0.5 * np.sin(3 * t) ** 2
    for side in ("Left", "Right"):
        out[:, names.index(f"mouthSmile{side}")] = 0.4 * np.sin(2.2 * t) ** 2
    return out


class Session:
    """What was filmed into a folder, and the truth of it.

    Parameters
    ----------
    folder : Path
    units : (T, 52)
    mirror : bool
        One camera and a mirror, or two cameras.
    crf : int
        Of the videos; 0 is lossless.
    noise : float
        Grey values.
    finer : int
        Than the speaker's texels; 1, which is quicker, if the dots of the skull do not matter.
    """

    def __init__(
        self,
        folder: Path,
        units: np.ndarray,
        mirror: bool = False,
        crf: int = 0,
        noise: float = 2.0,
        finer: int = FINER,
    ) -> None:
        self.folder, self.units, head = folder, units, dotted_head(finer=finer)
        if mirror:
            camera, glass, start = mirror_room()
            places = (Pose(np.eye(3), np.zeros(3)),)
        else:
            (camera, places), glass, start = two_cameras(), None, before_cameras()
        self.heads, self.places = nodding(start, len(units)), places
        self.camera, self.glass, self.points = camera, glass, head.dots(units)
        self.videos = [folder / f"camera{k + 1}.mp4" for k in range(len(places))]
        for k, (path, place) in enumerate(zip(self.videos, places, strict=True)):
            with VideoWriter(path, camera.size, RATE, crf) as video:
                for t, (row, pose) in enumerate(zip(units, self.heads, strict=True)):
                    seen = seen_from(place, pose)
                    video.write(film(head, row, seen, camera, noise, 2 * t + k, glass))

    def pixels(self, frame: int) -> np.ndarray:
        """Where the dots (2, N, 2) truly are in both views."""
        world = self.heads[frame].apply(self.points[frame])
        seen = [place.apply(world) for place in self.places]
        if self.glass is not None:
            seen.append(self.glass.reflect(world))
        return np.stack([self.camera.project(s) for s in seen])

    def write_points(self, path: Path, careless: float = 0.7, seed: int = 0) -> Path:
        """Where a person points at in frame 0, off by `careless` px (standard deviation)."""
        names = NAMES if self.glass is None else LIPS17  # the mirror shows no more
        off = np.random.default_rng(seed).normal(0, careless, (2, len(names), 2))
        rows = [
            (0, view + 1, name, *self.pixels(0)[view, i] + off[view, i])
            for view in range(2)
            for i, name in enumerate(names)
        ]
        return write_csv(path, ("frame", "view", "point", "x", "y"), rows)

    def write_reference(self, path: Path) -> Path:
        """Where the dots of the skull are in the head frame."""
        rest = self.points[0]
        return write_csv(
            path, ("point", "x", "y", "z"), [(n, *rest[NAMES.index(n)]) for n in SKULL]
        )

    def write_poses(self, path: Path) -> Path:
        """The head's true pose in each frame."""
        rows = [(t, *p.rotation_vector, *p.translation) for t, p in enumerate(self.heads)]
        return write_csv(path, ("frame", "rx", "ry", "rz", "tx", "ty", "tz"), rows)

    def calibrate(self, pictures: int = 8) -> list[Path]:
        """Film a board and calibrate by the command line; the files of the calibration."""
        poses = board_poses(self.heads[0], pictures)
        names: list[list[str]] = []
        for k, place in enumerate(self.places):
            names.append([str(self.folder / f"board{k + 1}_{i:02d}.png") for i in range(pictures)])
            for i, (name, pose) in enumerate(zip(names[k], poses, strict=True)):
                seen = seen_from(place, pose)
                drawn = board_picture(BOARD, seen, self.camera, self.glass, 100 * k + i)
                write_new(Path(name), png(drawn))
        files = [self.folder / f"camera{k + 1}.json" for k in range(len(self.places))]
        second = ["--second", *names[1], "--second-output", str(files[1])] if names[1:] else []
        kind = ["--mirror"] if self.glass is not None else second
        command = ["observe", "calibrate", *names[0], *BOARD_OPTIONS, *kind, "-o", str(files[0])]
        if main(command) != 0:
            raise RuntimeError("the calibration failed")
        return files

    def rms(self, observed: Observations) -> float:
        """Root mean square distance (mm) of the 17 points from the truth, where found.

        With a mirror the head's pose is given in the true camera's frame, from which that of the
        calibrated camera is some mm off; one rigid motion for the whole clip takes this away.
        """
        seen, true = observed.of(LIPS17), self.points[:, : len(LIPS17)]
        if self.glass is not None:
            known = np.isfinite(seen).all(axis=2)
            middle, centre = true[known].mean(axis=0), seen[known].mean(axis=0)
            turn, _ = Rotation.align_vectors(true[known] - middle, seen[known] - centre)
            seen = (seen - centre) @ turn.as_matrix().T + middle
        return float(np.sqrt(np.nanmean(((seen - true) ** 2).sum(axis=2))))


def board_poses(head: Pose, count: int, seed: int = 0) -> list[Pose]:
    """A board held before where the face is, tilted to all sides; board to world."""
    rng, out = np.random.default_rng(seed), []
    middle = np.array([BOARD.columns, BOARD.rows, 0]) * BOARD.square / 2
    away = head.rotation @ np.diag([1.0, -1.0, -1.0])  # the print looks where the face does
    for _ in range(count):
        tilt = Pose.from_vectors(rng.uniform(-0.45, 0.45, 3), np.zeros(3)).rotation
        turn = away @ tilt
        place = head.apply(np.array([0, 20.0, 90.0]) + rng.uniform([-15, -40, -40], [15, 40, 40]))
        out.append(Pose(turn, place - turn @ middle))
    return out


def run() -> None:
    """Film, observe, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=150)
    parser.add_argument("--start", type=int, default=RECORDED_FROM)
    parser.add_argument("--crf", type=int, default=0)
    parser.add_argument("--mirror", action="store_true")
    parser.add_argument("--keep", type=Path, help="folder for the films; must not exist")
    chosen = parser.parse_args()
    data = Path(os.environ.get("ABS_ENGINE_DATA") or Path(__file__).parents[2] / "shared" / "data")
    recording = data / "livelink_rom" / "alex_rom_3.csv"
    known = recording.is_file()
    units = recorded(recording, chosen.start, chosen.frames) if known else authored(chosen.frames)
    with film_folder(chosen.keep) as folder:
        session = Session(folder, units, chosen.mirror, chosen.crf)
        observed = read_observations(observe(session))
    sys.stdout.write(
        f"{'recorded' if known else 'authored'} motion, crf {chosen.crf}: "
          f"3D error {session.rms(observed):.3f} mm RMS in head coordinates; "
          f"{observed.found[:, :17].mean():.1%} of the points found")  # fmt: skip


def observe(session: Session, *options: str) -> Path:
    """Calibrate and observe by the command line; the observation file."""
    folder = session.folder
    files = [str(f) for f in session.calibrate()]
    if session.glass is None:
        reference = str(session.write_reference(folder / "reference.csv"))
        head = [*RIGID, "--reference", reference]
    else:  # the ear is seen in the mirror only
        head = ["--pose", str(session.write_poses(folder / "poses.csv"))]
    points = str(session.write_points(folder / "points.csv"))
    out = folder / "observed.npz"
    videos = [str(v) for v in session.videos]
    command = ["observe", *videos, "--calibration", *files, "--points", points, *head, *options]
    if main([*command, "-o", str(out)]) != 0:
        raise RuntimeError("observing failed")
    return out


if __name__ == "__main__":
    run()
