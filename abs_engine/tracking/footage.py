"""Lines about a video that a user should know, whatever it shows."""

from __future__ import annotations

from abs_engine.io.video import VideoInfo

_HEARD = 0.04  # seconds; a shorter gap between sound and pictures is not mentioned


def footage_lines(info: VideoInfo) -> list[str]:
    """Lines about a video before it is tracked; empty where nothing is unusual."""
    lines = []
    if info.interlaced:
        lines.append(
            "the video is marked as interlaced: fast motion may leave combs in its frames, and "
            "openings are then less exact; deinterlace it first"
        )
    if abs(info.sound) >= _HEARD:
        when, sign = ("before", "add") if info.sound < 0 else ("after", "subtract")
        lines.append(
            f"the sound begins {abs(info.sound):.3f} s {when} the first picture: a run's times "
            f"count from that picture; {sign} {abs(info.sound):.3f} s for times in the sound alone"
        )
    return lines
