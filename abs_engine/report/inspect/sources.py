"""Sources of label buffers: a posture, a run, a dataset."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.kinds import checked_frame
from abs_engine.core.scene import Renderer
from abs_engine.dataset import Truth
from abs_engine.evaluate.clip_views import found_truth
from abs_engine.io.assets import Speaker
from abs_engine.report.inspect.labels import LabelFrame, drawn_labels
from abs_engine.report.inspect.request import Request
from abs_engine.report.inspect.runs import RunHead


@dataclass(frozen=True, eq=False)
class LabelSource:
    """Frames with labels.

    Parameters
    ----------
    rate : float
        Frames per second.
    times : (T,) float64 or None
        When each is shown, s, where that is not at even steps.
    """

    rate: float
    count: int
    frame: Callable[[int], LabelFrame]
    times: FloatArray | None = None


def run_labels(renderer: Renderer, run: RunHead) -> LabelSource:
    """Labels of the tracked head, as the run's camera saw it; none where it was not found."""

    def frame(number: int) -> LabelFrame:
        caption = frame_caption(number, float(run.times[checked_frame(number, len(run))]))
        if run.found(number):
            return drawn_labels(renderer, run.body(number), run.view(number), caption)
        none = np.zeros(run.camera.size[::-1], np.int32)
        flat = {"depth": lambda: none, "normals": lambda: np.zeros((*none.shape, 3))}
        return LabelFrame(f"{caption}   {run.arrays['status'][number]}", none, flat)

    return LabelSource(run.rate, len(run), frame, run.uneven_times)


def truth_labels(truth: Truth) -> LabelSource:
    """Labels that are stored in a dataset; `InputFileError` if one is missing or broken."""

    def flow(number: int) -> NDArray[np.generic]:
        moved, known = truth.flow(number)
        return np.where(known[..., None], moved, np.float32("nan"))

    kinds: dict[str, Callable[[int], NDArray[np.generic]]] = {
        "depth": truth.depth, "normals": truth.normals, "albedo": truth.albedo, "flow": flow,
    }  # fmt: skip

    def frame(number: int) -> LabelFrame:
        read = {name: partial(get, number) for name, get in kinds.items()}
        caption = frame_caption(number, number / truth.rate)
        return LabelFrame(caption, truth.facet_ids(number), read)

    return LabelSource(truth.rate, len(truth), frame)


def open_truth(request: Request, folder: Path, speaker: Speaker, kind: str | None = None) -> Truth:
    """Read a dataset of the speaker, and see that it has a kind of label.

    Of several views that fit, the one that the request's run tracked.

    Raises
    ------
    InputFileError
        If it cannot be read, or does not hold such labels.
    ParameterError
        If it was filmed with another speaker, or holds several views that fit.
    """
    runs = [] if request.run is None else [request.run]
    truth = found_truth(folder, request.clip, request.camera, runs)
    if not np.array_equal(speaker.faces, truth.faces):
        raise ParameterError(
            f"the dataset {folder} has another mesh than the speaker",
            "give its head.npz with --speaker",
        )
    stored = "ids" if kind == "classes" else kind
    if stored is not None and not truth.has(stored):
        raise InputFileError(
            f"{folder} holds no {stored} pictures", "film it again with them among the labels"
        )
    return truth


def check_pair(run: RunHead, truth: Truth) -> None:
    """Raise `ParameterError` unless a run and a dataset have the same frames."""
    if len(run) != len(truth):
        raise ParameterError(
            f"the run has {len(run)} frames, the dataset {len(truth)}",
            "give the dataset whose video was tracked",
        )


def frame_caption(number: int, seconds: float) -> str:
    """Such as 'frame 12   0.48 s'."""
    return f"frame {number}   {seconds:.2f} s"
