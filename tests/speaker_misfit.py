"""How far the heads in clips are from that of a speaker's face: `python tests/speaker_misfit.py
FACE CLIPS...`.

Prints for each clip the misfit by which a run warns of another person, standard deviations of the
landmarks; see `most_speaker_misfit` in `tracking/settings/frames.py`.
"""

from __future__ import annotations

import sys
from pathlib import Path

from abs_engine.core.errors import AbsEngineError
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.run import prepare


def main(face: str, *clips: str) -> None:
    """Print a line for each clip."""
    for clip in clips:
        try:
            made = prepare(Path(clip), CpuRenderer(), TrackOptions(model=face))
        except AbsEngineError as error:
            sys.stdout.write(f"{clip} {error}\n")
        else:
            sys.stdout.write(f"{clip} {made.facts['head_misfit']}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
