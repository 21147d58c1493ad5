"""A run against its ground truth: scores of its arrays, and a picture of the curves."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from abs_engine.core.kinds import WHOLE, check_kind, is_of, to_path
from abs_engine.dataset import Truth, load_truth
from abs_engine.evaluate.catalogue import warn_of_faults
from abs_engine.evaluate.closing import narrow
from abs_engine.evaluate.estimate import check_run, of_run, run_arrays
from abs_engine.evaluate.metrics import Mean, squared_distance, value, without_constant_offset
from abs_engine.evaluate.score import Score, measure, summary
from abs_engine.io.assets import CLOSED_APERTURE
from abs_engine.tracking.runs.record import load_run

RunArrays = Mapping[str, NDArray[Any]]


class Tracked(Protocol):
    """A run that holds its arrays."""

    @property
    def arrays(self) -> RunArrays:
        """Arrays of a run by their names."""
        ...


CURVES = "truth_curves.png"


def score(
    run: RunArrays | Tracked | Path | str, truth: Truth | Path | str, *, seed: int = 0
) -> dict[str, Score]:
    """Scores of a run against the truth, by the names that ``scores.json`` has.

    Of a path, only the arrays are read: `evaluate` on the command line also scores the mesh.

    Parameters
    ----------
    run : mapping of str to array, an object with one as `arrays`, or the path of a run
        `lip_points` (T, N, 3), mm, head frame; `lip_vertex` (N,), their vertex indices in the
        truth's mesh; `rotation` (T, 3), rotation vectors, and `translation` (T, 3), mm, head
        to camera; `aperture` and `width` (T,), mm, defined as `Truth.aperture` and `Truth.width`.
        What it says itself of closed lips does not count.
    truth : Truth, or its path
    seed : int
        Of the resamples that confidence intervals are taken from; 0 or more.

    Returns
    -------
    dict
        A `Score` (`value`, `low`, `high`) by the name of each metric: ``lip_points_rms_head_mm``,
        ``aperture_correlation``, ...

    Raises
    ------
    InputFileError
        If the run lacks an array, or a path leads to no run or truth.
    ParameterError
        If the run is of other frames or of another mesh than the truth, has tracked no frame, or a
        value is of another kind.
    """
    check_kind("seed", seed, WHOLE)
    given = {k: v for k, v in _arrays(run).items() if k != "closed"}
    truth = truth if isinstance(truth, Truth) else load_truth(to_path("truth", truth))
    arrays = run_arrays(given)
    check_run(arrays, len(truth), len(truth.neutral))
    marks = truth.landmarks.get("landmark_68")
    warn_of_faults()
    return summary([measure(of_run("the run", arrays, None, {}), truth, marks)], seed=seed)


def _arrays(run: RunArrays | Tracked | Path | str) -> RunArrays:
    if isinstance(run, str | Path):
        return load_run(Path(run))
    arrays: Any = getattr(run, "arrays", run)
    check_kind("run", arrays, (is_of(Mapping), "a run, its arrays, or its path"))
    return dict(arrays)


def draw(run: RunArrays, truth: Truth, folder: Path) -> None:
    """Write ``truth_curves.png``: aperture, width and lip error over time.

    Frames in which the true aperture counts as closed are shaded, as they are scored.
    """
    figure = Figure(figsize=(9, 7.5), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    seconds = np.arange(len(truth)) / truth.rate
    for axes, name, true in ((top, "aperture", truth.aperture), (middle, "width", truth.width)):
        axes.plot(seconds, true, color="black", label="truth")
        axes.plot(seconds, run[name], ".-", markersize=4, color="tab:red", label="tracked")
        axes.set_ylabel(f"lip {name} (mm)")
        _above(axes)
    found, true = run["lip_points"], truth.points(run["lip_vertex"])
    aligned = without_constant_offset(found, true)
    for points, label in ((found, "raw"), (aligned, "constant rigid offset removed")):
        squared = squared_distance(points, true)
        rms = value([Mean.of(squared, root=True)])
        bottom.plot(seconds, np.sqrt(squared), ".-", markersize=4, label=f"{label}: {rms:.2f} mm")
    bottom.set(ylabel="lip points, RMS\n(mm, head frame)", xlabel="time (s)", ylim=(0, None))
    _above(bottom)
    half = 0.5 / truth.rate
    for axes in (top, middle, bottom):
        for at in seconds[narrow(truth.aperture)]:
            axes.axvspan(at - half, at + half, color="0.9", lw=0)
    shaded = f"shaded: true aperture below {CLOSED_APERTURE:g} mm"
    figure.suptitle(f"{truth.person}: {truth.sentence} ({shaded})")
    figure.savefig(folder / CURVES, dpi=100)


def _above(axes: Axes) -> None:
    """Put a legend where it hides no curve: in one line above its axes, on the right."""
    place = (1.0, 1.0)
    axes.legend(loc="lower right", bbox_to_anchor=place, borderaxespad=0.2, ncols=2, frameon=False)
