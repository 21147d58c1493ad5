"""Sources of label buffers: a posture, a run, a dataset."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.dataset import Truth
from abs_engine.evaluate.clip_views import found_truth
from abs_engine.io.assets import Speaker
from abs_engine.report.drawing.view import View
from abs_engine.report.inspect.body import Body, check_same_mesh
from abs_engine.report.inspect.labels import LabelFrame, drawn_labels
from abs_engine.report.inspect.request import Request
from abs_engine.report.inspect.runs import RunHead


class LabelSource(Protocol):
    """Frames with labels."""

    @property
    def rate(self) -> float:
        """Frames per second."""
        ...

    def __len__(self) -> int:
        """Return the number of frames."""
        ...

    def frame(self, number: int) -> LabelFrame:
        """The labels of a frame."""
        ...


class PostureSource:
    """A head in a posture, seen from several sides.

    Parameters
    ----------
    renderer : Renderer
    body : Body
    views : sequence of View
    captions : sequence of str
        One for each view.
    rate : float
        Views per second.
    """

    def __init__(
        self,
        renderer: Renderer,
        body: Body,
        views: Sequence[View],
        captions: Sequence[str],
        rate: float,
    ) -> None:
        self._renderer, self._body, self._views = renderer, body, views
        self._captions, self.rate = captions, rate

    def __len__(self) -> int:
        """Return the number of views."""
        return len(self._views)

    def frame(self, number: int) -> LabelFrame:
        """The labels of a view."""
        caption = self._captions[number]
        return drawn_labels(self._renderer, self._body, self._views[number], caption)


class RunSource:
    """The tracked head, as the run's camera saw it."""

    def __init__(self, renderer: Renderer, run: RunHead) -> None:
        self._renderer, self._run = renderer, run
        self.rate = run.rate

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._run)

    def frame(self, number: int) -> LabelFrame:
        """The labels of a frame; nothing is seen where the head was not found."""
        run = self._run
        run.check(number)
        caption = frame_caption(number, float(run.times[number]))
        if run.found(number):
            return drawn_labels(self._renderer, run.body(number), run.view(number), caption)
        none = np.zeros(run.camera.size[::-1], np.int32)
        flat = {"depth": lambda: none, "normals": lambda: np.zeros((*none.shape, 3))}
        return LabelFrame(f"{caption}   {run.arrays['status'][number]}", none, flat)


class TruthSource:
    """The labels that are stored in a dataset."""

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self.rate = truth.rate

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._truth)

    def frame(self, number: int) -> LabelFrame:
        """The labels of a frame.

        Raises
        ------
        ParameterError
            If there is no such frame.
        InputFileError
            If a picture is missing or broken.
        """
        truth = self._truth

        def flow() -> NDArray[np.generic]:
            moved, known = truth.flow(number)
            return np.where(known[..., None], moved, np.float32("nan"))

        return LabelFrame(
            frame_caption(number, number / truth.rate),
            truth.facet_ids(number),
            {
                "depth": lambda: truth.depth(number),
                "normals": lambda: truth.normals(number),
                "albedo": lambda: truth.albedo(number),
                "flow": flow,
            },
        )


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
    check_same_mesh(speaker, truth.faces, f"the dataset {folder}")
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
