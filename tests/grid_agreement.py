"""How the lips tracked in the GRID clips agree with frames labelled by eye.

Run it by hand: `python tests/grid_agreement.py RUNS`, where RUNS holds one run of
`abs-engine track` for each clip, named as the clip. The labels are in
`assets/labels/grid_closures.json`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from abs_engine.papers.basu1998.real_clips import Agreement, agreement, closure_labels
from abs_engine.tracking.runs.record import load_run


def line(clip: str, folder: Path, found: Agreement) -> str:
    """A line for one clip."""
    labels, run = closure_labels()[clip], load_run(folder)
    aperture, sure = np.asarray(run["aperture"]), labels.sure
    lost = int(np.isnan(aperture).sum())
    return (
        f"{clip}  precision {found.precision:.2f}  recall {found.recall:.2f}  "
        f"closures {found.met} of {found.closures}  "
        f"aperture closed {np.nanmean(aperture[labels.closed & sure]):.1f} mm, "
        f"open {np.nanmedian(aperture[~labels.closed & sure]):.1f} mm  "
        f"spikes {found.spikes}  lost {lost}"
    )


def table(folder: Path) -> str:
    """The lines of all clips whose runs are in `folder`, and their sum."""
    labels = closure_labels()
    clips = [c for c in labels if (folder / c).is_dir()]
    found = {c: agreement(labels[c], load_run(folder / c)) for c in clips}
    total = sum(found.values(), Agreement(0, 0, 0, 0, 0, 0))
    last = (
        f"all     precision {total.precision:.2f}  recall {total.recall:.2f}  "
        f"closures {total.met} of {total.closures}"
    )
    return "\n".join([*(line(c, folder / c, found[c]) for c in clips), last]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(table(Path(sys.argv[1])))
