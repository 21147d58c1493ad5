"""A new export: WebVTT, which shows the lips' aperture as subtitles of the video.

Try it: abs-engine export RUN --to vtt -o lips.vtt --plugin examples/new_exporter.py
"""

from pathlib import Path

import numpy as np

from abs_engine import EXPORTERS, Exporter, Loss, TrackedRun


def stamp(seconds: float) -> str:
    """Hours, minutes and seconds, rounded before they are counted: no stamp says 60 seconds."""
    minutes, rest = divmod(round(1000 * seconds), 60_000)
    return f"{minutes // 60:02d}:{minutes % 60:02d}:{rest / 1000:06.3f}"


def write(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    """A cue for each frame in which the lips were found."""
    aperture, lines = run.arrays["aperture"], ["WEBVTT", ""]
    for frame in np.flatnonzero(np.isfinite(aperture)):
        begin = run.arrays["time"][frame]
        span = f"{stamp(begin)} --> {stamp(begin + 1 / run.rate)}"
        lines += [span, f"lips {aperture[frame]:.1f} mm apart", ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    off = np.round(aperture, 1) - aperture
    return (Loss(float(np.sqrt(np.nanmean(off**2))), "mm", "aperture"),)


EXPORTERS.add("vtt", Exporter("WebVTT: the aperture as subtitles", write, ".vtt"))
