"""The lines that are printed at the end of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

_DOUBTFUL = 0.78
"""Mean score below which a run is most likely wrong; those that were right had 0.86 and more."""
_OTHERS = 0.8
"""The same of a talking face: its own speaker's have 0.94, another's 0.64 to 0.88."""


def summary_lines(summary: dict[str, Any], timing: dict[str, Any], said: str = "") -> Iterator[str]:
    """Counts, speed and warnings of a run, of its ``run.json`` and ``timing.json``.

    Warnings among the lines of `said`, which were printed before, are left out.
    """
    yield (
        f"{summary['frames']} frames, {summary['lost_frames']} lost, "
        f"{summary['closed_frames']} with closed lips; "
        f"{summary['mean_evaluations']:.0f} evaluations and "
        f"{timing['seconds_per_frame']:.3f} s a frame"
    )
    kind, score = summary.get("score_of", "colour"), summary["mean_score"]
    if kind == "colour" and score is not None and score < _DOUBTFUL:
        yield (
            f"warning: the drawn mouth explains only {score:.0%} of the picture around it: look at "
            "the overlay"
        )
    if kind in ("texture", "local") and score is not None and score < _OTHERS:
        yield f"warning: the face explains only {score:.0%} of the picture: is it this speaker's?"
    left = (line for line in summary.get("warnings", ()) if line not in said.splitlines())
    yield from (f"warning: {line}" for line in left)
