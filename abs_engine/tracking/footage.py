"""Lines about a video that a user should know, whatever it shows."""

from __future__ import annotations

from abs_engine.core.camera import Camera
from abs_engine.io.video import VideoInfo

_CENTRED = 0.2  # of a side: a lens's axis lies nearer to the middle unless the picture was cut out
_HEARD = 0.04  # seconds; a shorter gap between sound and pictures is not mentioned


def footage_lines(info: VideoInfo, camera: Camera | None = None) -> list[str]:
    """Lines about a video and its camera before it is tracked; empty if nothing is unusual."""
    lines = [] if camera is None or _central(camera) else [_axis_line(camera)]
    if info.streams > 1:
        width, height = info.size
        lines.append(
            f"the file holds {info.streams} videos: its default is read, or else the largest, here "
            f"{width}x{height} pixels; export the one that you want if it is another"
        )
    if info.interlaced:
        lines.append(
            "the video is marked as interlaced: fast motion may leave combs in its frames, and "
            "openings are then less exact; deinterlace it first"
        )
    if info.clock != "file" and info.frames > 1:
        why = "its stream states" if info.clock == "stream" else "no rate is stated"
        lines.append(
            f"the file holds no times: {info.rate:g} frames a second are assumed, as {why}; if "
            "that is wrong, put it in MP4 at the right rate (ffmpeg -r RATE -i IN -crf 16 OUT.mp4)"
        )
    if info.askew:
        lines.append(
            "the file asks for a rotation that is not a multiple of 90 degrees; the nearest "
            "multiple is used; turn it upright and export it first"
        )
    if abs(info.sound) >= _HEARD:
        lines.append(sound_line(info.sound, "a run's times"))
    return lines


def _central(camera: Camera) -> bool:
    """Whether the optical axis meets the picture near its middle."""
    sides = zip(camera.matrix[:2, 2], camera.size, strict=True)
    return all(abs(at - (side - 1) / 2) <= _CENTRED * side for at, side in sides)


def _axis_line(camera: Camera) -> str:
    (x, y), (width, height) = camera.matrix[:2, 2], camera.size
    return (
        f"the camera's axis is at {x:.0f}, {y:.0f} in pictures of {width}x{height} pixels: unless "
        "these are cut out of larger ones, it was calibrated at another size; scale its matrix"
    )


def sound_line(sound: float, times: str) -> str:
    """Line about sound that begins so many seconds after the first picture, and some times."""
    when, sign = ("before", "add") if sound < 0 else ("after", "subtract")
    return (
        f"the sound begins {abs(sound):.3f} s {when} the first picture: {times} count from that "
        f"picture; {sign} {abs(sound):.3f} s for times in the sound alone"
    )
