"""Closures in real clips, where they are at hand, against frames labelled by eye."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError
from abs_engine.core.scene import Renderer
from abs_engine.evaluate.metrics import spikes
from abs_engine.io.assets import shipped
from abs_engine.io.naming import made_before
from abs_engine.papers.basu1998.motion import data_folder
from abs_engine.tracking.options import BLOBS, TrackOptions
from abs_engine.tracking.run import track_video
from abs_engine.tracking.runs.record import load_run

SPIKE_MM = 4.0
FOLDER = "grid"


@dataclass(frozen=True, eq=False)
class ClosureLabels:
    """Intervals of closed lips in a clip, as seen by eye.

    Parameters
    ----------
    closed : (T,) bool
    sure : (T,) bool
        Where that could be told.
    runs : list of [int, int]
        First and last frame of each closure.
    """

    closed: NDArray[np.bool_]
    sure: NDArray[np.bool_]
    runs: list[list[int]]


def closure_labels() -> dict[str, ClosureLabels]:
    """The labels of all clips, by name."""
    told = json.loads(shipped("labels/grid_closures.json").read_text())
    labels = {}
    for name, entry in told["clips"].items():
        closed, sure = np.zeros(entry["n_frames"], bool), np.ones(entry["n_frames"], bool)
        for first, last in entry["closed"]:
            closed[first : last + 1] = True
        sure[entry["unsure"]] = False
        labels[name] = ClosureLabels(closed, sure, entry["closed"])
    return labels


@dataclass(frozen=True)
class Agreement:
    """Agreement of a run with the labels, in frames that could be told.

    Parameters
    ----------
    hits, found, labelled : int
        Frames closed in both, in the run, by the labels.
    met, closures : int
        Closures that have a closed frame in the run, and all.
    spikes : int
        Single-frame spikes of the aperture above 4 mm.
    """

    hits: int
    found: int
    labelled: int
    met: int
    closures: int
    spikes: int

    def __add__(self, other: Agreement) -> Agreement:
        """Both together."""
        return Agreement(**{name: own + getattr(other, name) for name, own in vars(self).items()})

    @property
    def precision(self) -> float:
        """Share of the run's closed frames that are closed."""
        return self.hits / max(1, self.found)

    @property
    def recall(self) -> float:
        """Share of the closed frames that are closed in the run."""
        return self.hits / max(1, self.labelled)


def agreement(labels: ClosureLabels, run: dict[str, Any]) -> Agreement:
    """Agreement of the arrays of a run with labels."""
    found, sure = np.asarray(run["closed"], bool), labels.sure
    met = sum(bool(found[first : last + 1].any()) for first, last in labels.runs)
    return Agreement(
        int((found & labels.closed & sure).sum()), int((found & sure).sum()),
        int((labels.closed & sure).sum()), met, len(labels.runs),
        int(spikes(np.asarray(run["aperture"]), SPIKE_MM)),
    )  # fmt: skip


def labelled_clips() -> list[Path]:
    """The labelled clips that are at hand; none of them is shipped."""
    try:
        folder = data_folder(FOLDER)
    except InputFileError:
        return []
    return [path for name in closure_labels() if (path := folder / f"{name}.mpg").is_file()]


def grid_agreement(
    renderer: Renderer, tell: Callable[[str], None], kept: Path
) -> dict[str, Any] | None:
    """Track the labelled clips and compare; None where they are not at hand.

    The folder `kept` gets the runs, and has those of an interrupted one.
    """
    labels, clips = closure_labels(), labelled_clips()
    if not clips:
        return None
    total = Agreement(0, 0, 0, 0, 0, 0)
    kept.mkdir(parents=True, exist_ok=True)
    for clip in clips:
        tell(f"tracking {clip.stem}")
        out = kept / clip.stem
        if not made_before(out):
            track_video(clip, out, renderer, TrackOptions(start=BLOBS))
        total += agreement(labels[clip.stem], load_run(out))
    return {
        "closure_precision": total.precision, "closure_recall": total.recall,
        "closures_met": total.met, "closures": total.closures,
        "closures_missed": total.closures - total.met, "spikes": total.spikes,
        "clips": [clip.stem for clip in clips],
    }  # fmt: skip
