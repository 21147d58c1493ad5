"""Recordings of one person that were tracked: which of their frames are good to learn from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, evenly
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    ParameterError,
    TooFewFramesError,
)
from abs_engine.core.geometry import Pose, rotations
from abs_engine.core.words import counted
from abs_engine.dataset.sums import check_distinct, digest
from abs_engine.fit.opening import NAME as OPENING
from abs_engine.io.assets import Speaker
from abs_engine.io.video import probe
from abs_engine.learn.settings import LEARNING
from abs_engine.tracking.detection.face_choice import LARGEST, FaceChoice
from abs_engine.tracking.detection.initial_pose import FaceBox
from abs_engine.tracking.detection.shot_cuts import shots_line
from abs_engine.tracking.person.scale import Scale
from abs_engine.tracking.results.measures import cuts
from abs_engine.tracking.results.run_table import sure_frames
from abs_engine.tracking.runs.record import (
    SUMMARY,
    Record,
    camera_of,
    load_whole_run,
    stated_settings,
)
from abs_engine.tracking.settings.doubts import DOUBTS

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Recording:
    """A video and what was tracked in it.

    Parameters
    ----------
    path : Path
        What was given: the video, or the folder of its run.
    run : dict of str to array
        As ``results.npz`` has them.
    head : (V, 3) float32, mm
        The person's whole head by this video alone, in the mean posture of what tracked it.
    postures : (T, P) float64
        NaN in lost frames.
    pupils : float, mm
        Distance of the pupils that the head's size rests on; see `Scale`.
    choice : FaceChoice
        The face that was tracked.
    remarks : tuple of str
        What a user should know: that there are several shots, and of a video that was just tracked
        its several faces and warnings.
    rest : (V, 3) float32, mm, or None
        The head without expression; None in runs of earlier versions.
    """

    path: Path
    video: Path
    run: Arrays
    head: NDArray[np.float32]
    postures: FloatArray
    pupils: float
    choice: FaceChoice = LARGEST
    remarks: tuple[str, ...] = ()
    rest: NDArray[np.float32] | None = None

    @classmethod
    def of(cls, path: Path, video: Path, record: Record, scale: Scale) -> Recording:
        """Recording of the clip that was just tracked; its face is the largest."""
        mesh, arrays = record.mesh, record.copied().arrays
        return cls(
            path, video, arrays, mesh.mean, mesh.weights, scale.pupils, remarks=_shots(arrays),
            rest=mesh.rest,
        )  # fmt: skip

    def again(self, record: Record, scale: Scale) -> Recording:
        """The same recording, tracked another time."""
        return replace(self.of(self.path, self.video, record, scale), choice=self.choice)

    def choice_from(self, first: int) -> FaceChoice:
        """Its face, for those who read the video from frame `first` on.

        Numbers and boxes hold for the first frame; later, the face is where its mouth was tracked.
        """
        if first == 0 or self.choice == LARGEST:
            return self.choice
        box = mouth_box(self.run, first)
        return self.choice if box is None else FaceChoice(box=box)

    @property
    def count(self) -> int:
        """Number of frames."""
        return len(self.run["index"])

    @property
    def first_left_out(self) -> int:
        """Number of the first frame that is not learned from."""
        return max(1, round((1 - LEARNING.left_out) * self.count))

    @property
    def usable(self) -> BoolArray:
        """Frames (T,) to learn from: the mouth found and seen, and nothing throws doubt on it."""
        sure = sure_frames(self.run) & (self.run["status"] == "converged")
        return np.asarray(sure & (np.arange(self.count) < self.first_left_out))

    def spread(self, count: int) -> NDArray[np.intp]:
        """So many usable frames, spread over how open and how wide the mouth is.

        Every other one is taken by the rank of its aperture, the others by that of its width.
        """
        at, chosen = np.flatnonzero(self.usable), np.zeros(0, np.intp)
        for k, name in enumerate(("aperture", "width")):
            left = np.setdiff1d(at, chosen)
            order = left[np.argsort(self.run[name][left], kind="stable")]
            chosen = np.r_[chosen, order[evenly(len(order), (count + 1 - k) // 2)]]
        return np.unique(chosen)


def load_recording(folder: Path, speaker: Speaker) -> Recording:
    """A run of a head, and its video: where it was, beside the run, or where the command was typed.

    Raises
    ------
    InputFileError, ModelFormatError
        If the run cannot be read, is of an earlier version, of another head, or of a camera that is
        worn before the mouth, or its video is not there or has changed.
    """
    run, mesh = load_whole_run(folder, speaker, needs=("covered", "contradicted"))
    if OPENING in run.get("term_names", ()):
        raise InputFileError(
            f"{folder} was tracked with --worn", "give recordings that show the whole face"
        )
    try:
        told = stated_settings(folder)
        choice = _choice(told, run)
        name, known = str(told["video"]), str(told["video_sha256"])
        stored, pupils = str(told.get("video_path", name)), float(told["scale"]["pupils"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelFormatError(
            f"{folder / SUMMARY} does not state its video, its face or its scale",
            "track the video again",
        ) from error
    there = [p for p in (folder / stored, folder.parent / name, Path(name)) if p.is_file()]
    video = next((p for p in there if digest(p) == known), None)
    if video is not None:
        return Recording(
            folder, video, run, mesh.mean, mesh.weights, pupils, choice, _shots(run), mesh.rest
        )  # fmt: skip
    if there:
        raise InputFileError(
            f"{name}, the video of {folder}, has changed since it was tracked", "track it again"
        )
    raise InputFileError(
        f"{name}, the video of {folder}, is not there", "put it beside the run or into this folder"
    )


def _shots(run: Arrays) -> tuple[str, ...]:
    """Warning of a run with several shots."""
    begun = run["index"][cuts(run)].tolist()
    return (shots_line(begun),) if begun else ()


def _choice(told: Mapping[str, Any], run: Arrays) -> FaceChoice:
    """The face of a run by its settings; where poses were given, the one that they placed."""
    if told.get("poses", "estimated") != "estimated":
        return FaceChoice(box=mouth_box(run, 0))
    number, mouth = told.get("face"), told.get("mouth")
    if number is not None and int(number) < 1:
        raise ValueError("faces are counted from 1")
    return FaceChoice.asked(
        None if number is None else int(number),
        None if mouth is None else [float(side) for side in mouth],
    )


def mouth_box(run: Arrays, first: int) -> FaceBox | None:
    """Box of the face whose mouth was tracked in frame `first` of a run, or next after it.

    None if no later frame was tracked, or the run has no camera.
    """
    there = first + np.flatnonzero(run["found"][first:])
    if not len(there) or "camera_matrix" not in run:
        return None
    lips = pose_in(run, there[0]).apply(run["lip_points"][there[0]])
    return FaceBox.around_lips(camera_of(run).project(lips))


def pose_in(run: Arrays, frame: int) -> Pose:
    """Pose of the head in a frame of a run, head to camera."""
    return Pose(rotations(run["rotation"][frame][None])[0], run["translation"][frame])


def check_variety(recordings: Sequence[Recording]) -> None:
    """Raise `TooFewFramesError` unless the frames to learn from show the mouth open and closed."""
    aperture = np.concatenate([one.run["aperture"][one.usable] for one in recordings])
    count = len(aperture)
    lacks = [
        what
        for what, shown in (
            ("open mouth", (aperture > DOUBTS.speaker_open).any()),
            ("closed mouth", (aperture < DOUBTS.speaker_closed).any()),
        )
        if not shown
    ]
    if lacks:
        raise TooFewFramesError(
            f"no {lacks[0]} in {counted(count, 'frame')} that can be learned from",
            "give longer recordings of the person speaking",
        )


def check_videos(videos: Sequence[tuple[Path, Path]]) -> tuple[int, int]:
    """The one size (width, height) of videos that a face can be learned from.

    Each is what was given, and the video of it.

    Raises
    ------
    ParameterError
        If they are of several sizes, or one comes twice.
    """
    sizes = [probe(video).size for _, video in videos]
    (first, _), size = videos[0], sizes[0]
    for (path, _), own in zip(videos, sizes, strict=True):
        if own != size:
            raise ParameterError(
                f"{path} has {own[0]}x{own[1]} pixels, {first} {size[0]}x{size[1]}",
                "learn from recordings of one camera; the face then tracks those of others",
            )
    check_distinct(videos)
    return size
