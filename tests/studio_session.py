"""Observes a session that the studio filmed, by the command line, against where the dots were.

The head says what `assets/scenes/session.toml` has it say, or is moved by a real recording from
frame `--start` on. Run as a script it films with two cameras, or with one and a mirror:
python tests/studio_session.py [--recording FILE.csv] [--mirror] [--frames 75]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from session_files import film_folder, write_csv

from abs_engine.capture.dot_annotations import LIPS17
from abs_engine.capture.observations import Observations, read_observations
from abs_engine.cli import main
from abs_engine.core.geometry import Pose
from abs_engine.dataset import Dataset, Truth, load_dataset
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.io.assets import load_speaker, shipped
from abs_engine.papers.basu1998.motion import RECORDED_FROM
from abs_engine.studio.filming import film_scene
from abs_engine.studio.make import Crew
from abs_engine.studio.scenefile import SceneFile, read_scene

PLACES = 12
"""Places in which the scene holds the board, one every 0.2 s."""
RECORDED_RATE = 30.0
"""Frames per second at which a recording is filmed: its own."""
BOTH, GLASS = ("left", "right"), ("glass",)
BOARD_OPTIONS = ("--squares", "7", "5", "--square", "18")


def session_scene(
    cameras: Sequence[str], frames: int = 75, recording: str | None = None
) -> SceneFile:
    """The shipped scene by some of its cameras, the second clip of `frames` frames.

    It has the shipped rate, or that of a recording.
    """
    scene = read_scene(shipped("scenes/session.toml"))
    board, speech = scene.clip
    speech, rate = replace(speech, frames=frames), scene.rate
    if recording is not None:
        speech, rate = replace(speech, sentence=None, arkit=recording), RECORDED_RATE
    board = replace(board, frames=round(board.frames * rate / scene.rate))
    kept = tuple(c for c in scene.camera if c.name in cameras)
    return replace(scene, rate=rate, camera=kept, clip=(board, speech))


def hurried(scene: SceneFile) -> SceneFile:
    """The board in a new place in each picture, no longer in each fifth: for tests."""
    (board,), (shown, *others) = scene.occluder, scene.clip
    board = replace(board, keys=tuple(replace(key, time=key.time / 5) for key in board.keys))
    return replace(scene, occluder=(board,), clip=(replace(shown, frames=PLACES), *others))


def board_alone(cameras: Sequence[str]) -> SceneFile:
    """The board alone, in small pictures without labels that are not looked at: for tests."""
    scene = hurried(session_scene(cameras))
    small = tuple(replace(c, size=(480, 480), focal=0.75 * (c.focal or 0)) for c in scene.camera)
    return replace(scene, camera=small, clip=scene.clip[:1], labels=())


@dataclass(frozen=True)
class StudioSession:
    """A data set of the session's scene, and what is made of it.

    Parameters
    ----------
    folder : Path
        Of all files.
    data : Dataset
    cameras : tuple of str
        `BOTH` or `GLASS`.
    """

    folder: Path
    data: Dataset
    cameras: tuple[str, ...]

    def calibrate(self) -> list[Path]:
        """Calibrate by the command line from the pictures of the board; the files."""
        boards = [self.data.view("board", name) for name in self.cameras]
        step = len(boards[0]) // PLACES
        pictures = [[str(b.frame_path(step * k)) for k in range(PLACES)] for b in boards]
        files = [self.folder / f"{name}.json" for name in self.cameras]
        kind = ["--mirror"]
        if len(files) > 1:
            kind = ["--second", *pictures[1], "--second-output", str(files[1])]
        command = ["observe", "calibrate", *pictures[0], *BOARD_OPTIONS, *kind]
        if main([*command, "-o", str(files[0])]) != 0:
            raise RuntimeError("the calibration failed")
        return files

    def observe(self, files: Sequence[Path]) -> Observations:
        """Follow the dots by the command line; the head's true poses are given."""
        points, head = self._write_points(), ["--pose", str(self._write_poses())]
        out = self.folder / "observed.npz"
        videos = [str(view.video) for view in self.speech]
        command = ["observe", *videos, "--calibration", *map(str, files), "--points", str(points)]
        if main([*command, *head, "-o", str(out)]) != 0:
            raise RuntimeError("observing failed")
        return read_observations(out)

    @property
    def speech(self) -> list[Truth]:
        """The clip in which the head speaks, as each camera sees it."""
        return [self.data.view("speech", name) for name in self.cameras]

    def dots(self) -> np.ndarray:
        """True places (T, 17, 3) of the dots, mm, head frame."""
        return self.speech[0].points(lips17(load_speaker())).astype(np.float64)

    def pixels(self, frame: int) -> np.ndarray:
        """True places (2, 17, 2) of the dots in both views."""
        at = lips17(load_speaker())
        seen = [view.pixels(frame, at) for view in self.speech]
        mirror = self.speech[0].mirror
        if mirror is not None:
            seen.append(self._reflected(frame, mirror))
        return np.stack(seen)

    def _reflected(self, frame: int, corners: np.ndarray) -> np.ndarray:
        from abs_engine.studio.mirror import Mirror

        view = self.speech[0]
        world = view.pose(frame).apply(self.dots()[frame])
        return view.camera.project(Mirror(corners).reflect(world))

    def rms(self, observed: Observations, sure: bool = False) -> float:
        """Root mean square distance (mm) of the dots from the truth, where found (and `sure`).

        Less one rigid motion for the whole clip: a camera that was calibrated lies some mm beside
        the true one, in whose frame the poses are given.
        """
        seen, true = observed.of(LIPS17), self.dots()
        known = np.isfinite(seen).all(axis=2) & ~(sure & observed.uncertain)
        middle, centre = true[known].mean(axis=0), seen[known].mean(axis=0)
        turn, _ = Rotation.align_vectors(true[known] - middle, seen[known] - centre)
        moved = (seen[known] - centre) @ turn.as_matrix().T + middle
        return float(np.sqrt(((moved - true[known]) ** 2).sum(axis=1).mean()))

    def _write_points(self, careless: float = 0.7, seed: int = 0) -> Path:
        """Where a person points at in frame 0, off by `careless` px (standard deviation)."""
        at = self.pixels(0)
        at += np.random.default_rng(seed).normal(0, careless, at.shape)
        rows = [(0, v + 1, n, *at[v, i]) for v in range(len(at)) for i, n in enumerate(LIPS17)]
        return write_csv(self.folder / "points.csv", ("frame", "view", "point", "x", "y"), rows)

    def _write_poses(self) -> Path:
        """The head's true pose in each frame, in the first camera's frame."""
        poses: list[Pose] = [self.speech[0].pose(t) for t in range(len(self.speech[0]))]
        rows = [(t, *p.rotation_vector, *p.translation) for t, p in enumerate(poses)]
        header = ("frame", "rx", "ry", "rz", "tx", "ty", "tz")
        return write_csv(self.folder / "poses.csv", header, rows)


def filmed(
    folder: Path, scene: SceneFile, cameras: tuple[str, ...], processes: int = 1
) -> StudioSession:
    """Film a scene into `folder`/data; a recording is looked for in `folder`."""
    film_scene(scene, folder / "data", beside=folder, crew=Crew(processes))
    return StudioSession(folder, load_dataset(folder / "data"), cameras)


def cut(recording: Path, into: Path, start: int) -> Path:
    """The recording from a frame on."""
    header, *rows = recording.read_text(encoding="utf-8-sig").splitlines()
    into.write_text("\n".join([header, *rows[start:]]))
    return into


def run() -> None:
    """Film, observe, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=75)
    parser.add_argument("--recording", type=Path, help="a Live Link Face CSV")
    parser.add_argument("--start", type=int, default=RECORDED_FROM)
    parser.add_argument("--mirror", action="store_true")
    parser.add_argument("--processes", type=int, default=0)
    parser.add_argument("--data", type=Path, help="a data set that was filmed before")
    parser.add_argument("--keep", type=Path, help="folder for the films; must not exist")
    chosen = parser.parse_args()
    cameras = GLASS if chosen.mirror else BOTH
    with film_folder(chosen.keep) as folder:
        if chosen.data:
            session = StudioSession(folder, load_dataset(chosen.data), cameras)
        else:
            moved = None
            if chosen.recording:
                moved = cut(chosen.recording, folder / "recording.csv", chosen.start).name
            scene = session_scene(cameras, chosen.frames, moved)
            session = filmed(folder, scene, cameras, chosen.processes)
        observed = session.observe(session.calibrate())
        sys.stdout.write(
            f"3D error {session.rms(observed):.3f} mm RMS of {observed.frames} frames, "
            f"{observed.found.mean():.1%} of the points found; without those that a person is to "
            f"look at {session.rms(observed, sure=True):.3f} mm\n"
        )


if __name__ == "__main__":
    run()
