"""Tracking head and articulation through a sequence of pictures (section 4), from a first pose."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray, Image, IntArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import OutOfPictureError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import parted
from abs_engine.core.scene import Renderer
from abs_engine.face.talking import TalkingFace, as_face
from abs_engine.fit.problem import Problem
from abs_engine.fit.talking import talking_problem
from abs_engine.optimise.axes import AxesSimplex
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.papers.odisio2004.frame_before import FrameBefore, TalkBinder
from abs_engine.tracking.frame.clip_setting import AGAIN, ClipSetting, FrameResult
from abs_engine.tracking.loop import at_rest
from abs_engine.tracking.loop import track as track_frames
from abs_engine.tracking.results.frame_journal import FrameJournal, fingerprint


@dataclass(frozen=True)
class Settings:
    """Settings of the search in a frame.

    Parameters
    ----------
    method : {"axes", "simplex"}
        Gauss-Newton steps and a simplex along their axes; or the paper's: Nelder-Mead from a
        simplex of the parameters' own scales, from the frame before, which is a vertex of it; in
        the paper it is the centroid.
    predict : bool
        Whether the start is predicted from the last movement. For "axes" also whether an
        unusual epsilon makes it start again.
    limit : int
        Largest number of evaluations of a frame.
    coarse, tolerance : float
        Where the descent, and where the simplex, stops; in what a wrong match costs.
    inertia : float
        See `optimise.anchored.Held`.
    unusual : float
        Times the median epsilon of the last frames.
    pose_known : bool
        Whether the head stands still before the camera, as with a head-mounted one: only the
        articulation is sought.
    printed : bool
        Whether local appearance is compared by epsilon as printed; see `talking_problem`.
    least : float
        How much of the picture a fit explains at least; else the frame is lost.
    """

    method: str = "axes"
    predict: bool = True
    limit: int = 200
    coarse: float = 1e-4
    tolerance: float = 1e-4
    inertia: float = 1e-4
    unusual: float = 1.25
    pose_known: bool = False
    printed: bool = False
    least: float = 0.0

    def __post_init__(self) -> None:
        if self.method not in ("axes", "simplex") or self.limit < 1:
            raise ParameterError(
                f"there is no search '{self.method}' of {self.limit} evaluations",
                "choose axes or simplex, and at least 1",
            )


PAPER = Settings(method="simplex", predict=False, limit=300, inertia=0.0)
"""Plain warm start, as in the paper."""
AS_PRINTED = replace(PAPER, printed=True)
"""The paper's search of its epsilon, for local appearance, too."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """Parameters of all frames of a sequence.

    Parameters
    ----------
    alpha : (T, P) float64, standard deviations
    poses : tuple of Pose, T
        Head to camera.
    value : (T,) float64
        Epsilon in what a wrong match costs.
    evaluations : (T,) int64
    restarted : (T,) bool
        Whether the search started again from the corpus' postures.
    seconds : float
        All together; NaN where an interrupted run had tracked some of it.
    """

    alpha: FloatArray
    poses: tuple[Pose, ...]
    value: FloatArray
    evaluations: IntArray
    restarted: BoolArray
    seconds: float = 0.0

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.alpha)


def track(
    face: TalkingFace,
    name: str,
    pictures: Iterable[Image],
    camera: Camera,
    pose: Pose,
    alpha: FloatArray,
    renderer: Renderer,
    settings: Settings | None = None,
    postures: FloatArray | None = None,
    kept: Path | None = None,
) -> Tracked:
    """Track a sequence.

    Parameters
    ----------
    name : str
        Of the appearance model, of `face.talking.MODELS`.
    pose : Pose
        Head to camera in the first frame, about; given, or from
        `tracking.frame.head_tracking.HeadMotion`.
    alpha : (P,) float64
        Posture in the first frame, about.
    postures : (V, P) float64, optional
        Of the corpus, from which a search may start again.
    kept : Path, optional
        Journal of the frames, of which an interrupted run did the first.

    Raises
    ------
    OutOfPictureError
        If the face leaves the picture.
    ParameterError
        If there is no such model, or no picture.
    PictureError
        If a pixel is not finite.
    """
    how, started = settings or Settings(), time.perf_counter()
    setting = clip_setting(face, name, camera, renderer, how, postures)
    rows: list[FrameResult] = []
    start = at_rest(pose, np.asarray(alpha, np.float64))
    own = kept and FrameJournal(kept, fingerprint((setting, start, face, name, how)))
    with own or nullcontext() as journal:
        for _, result in track_frames(setting, pictures, start, journal):
            if not result.found:
                raise OutOfPictureError(
                    f"frame {result.index}: {result.status}", "start where the face is"
                )
            rows.append(result)
    if not rows:
        raise ParameterError("the sequence has no picture", "give at least one")
    again = journal is not None and journal.resumed
    return _tracked(rows, float("nan") if again else time.perf_counter() - started)


def _tracked(rows: Sequence[FrameResult], seconds: float) -> Tracked:
    """Results of frames, all of which show the face."""
    return Tracked(
        np.array([parted(row.vector)[1] for row in rows]),
        tuple(row.pose for row in rows if row.pose is not None),
        np.array([row.value / row.unit for row in rows]),
        np.array([row.evaluations for row in rows], np.int64),
        np.array([row.status == AGAIN for row in rows]),
        seconds,
    )


def clip_setting(
    face: TalkingFace,
    name: str,
    camera: Camera,
    renderer: Renderer,
    how: Settings,
    postures: FloatArray | None = None,
    rate: float = 25.0,
) -> ClipSetting:
    """Values that stay the same over a sequence; parameters as of `track`."""

    def problem(image: Image, there: Pose, alpha: FloatArray) -> Problem:
        given = image, camera, there, alpha, renderer
        return talking_problem(face, name, *given, pose_known=how.pose_known, printed=how.printed)

    binder = TalkBinder(
        problem, face.shape.neutral, how.predict,
        postures if how.method == "axes" else None, how.unusual, how.least,
    )  # fmt: skip
    driver: Any = Simplex(how.tolerance, how.limit)
    if how.method == "axes":
        driver = AxesSimplex(how.limit, how.coarse, how.tolerance, how.inertia)
    return ClipSetting(
        as_face(face), camera, renderer, rate, FrameBefore(), binder, driver, charged=True
    )
