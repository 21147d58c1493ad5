"""Clips made worse or otherwise changed, and how far their runs agree with those of the clips.

No truth is needed: a mirrored mouth opens as far, and a darker picture shows the same lips. Run it
by hand, first to make the clips, then to compare the runs that `abs-engine track` made of both; or
to see in how many turned first frames the face is found the right way up:

    python tests/altered_clips.py make CLIPS ALTERED [WAY ...]
    python tests/altered_clips.py compare RUNS ALTERED_RUNS
    python tests/altered_clips.py turn CLIPS
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.io.video import read_frames
from abs_engine.tracking.detection.face_choice import FaceChoice
from abs_engine.tracking.runs.record import load_run

Image = NDArray[np.uint8]
GRAIN = np.random.default_rng(0)
BLACK = (0, 0, 0)


@dataclass(frozen=True)
class Way:
    """How a clip is changed: each picture, how well it is compressed, and which frames are kept."""

    change: Callable[[Image], Image] = lambda image: image
    crf: int = 18
    every: int = 1


def halved(image: Image) -> Image:
    """The picture at half its width and height."""
    return np.asarray(cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))


def toned(
    image: Image, gain: float | list[float], offset: float = 0.0, noise: float = 0.0
) -> Image:
    """The picture with other levels, clipped, and with grain."""
    grain = GRAIN.normal(0, noise, image.shape)
    return np.uint8(np.rint(np.clip(image * np.asarray(gain) + offset + grain, 0, 255)))


def grey(image: Image) -> Image:
    """The picture without colour."""
    return np.repeat(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)[..., None], 3, 2)


def infrared(image: Image) -> Image:
    """The red channel, in the violet tint of a camera without an infrared filter.

    A stand-in: of what a colour camera records, red is nearest to near infrared. Lips and skin
    differ least there, and skin is smooth.
    """
    return toned(np.repeat(image[..., :1], 3, 2), [1.0, 0.8, 1.0])


def tinted(image: Image, *colours: tuple[int, int, int]) -> Image:
    """The picture in colours that its luminance alone decides, from dark to light at even steps."""
    levels, steps = np.arange(256), np.linspace(0, 255, len(colours))
    table = np.stack([np.interp(levels, steps, one) for one in zip(*colours, strict=True)], 1)
    return np.uint8(np.rint(table))[cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)]


def rolled(image: Image) -> Image:
    """The picture turned by 28 degrees, whole."""
    height, width = image.shape[:2]
    side = int(np.hypot(height, width))
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), 28, 1)
    turn[:, 2] += [(side - width) / 2, (side - height) / 2]
    return np.asarray(cv2.warpAffine(image, turn, (side, side)))


WAYS = {
    "mirrored": Way(lambda image: np.ascontiguousarray(image[:, ::-1])),
    "half": Way(halved),
    "rolled": Way(rolled),
    "slow": Way(every=3),
    "blurred": Way(lambda image: cv2.GaussianBlur(image, (0, 0), max(image.shape) / 260)),
    "compressed": Way(crf=38),
    "dim": Way(lambda image: toned(image, 0.22, noise=4.0)),
    "flat": Way(lambda image: toned(image, 0.35, 83.0)),
    "bright": Way(lambda image: toned(image, 1.7, 10.0)),
    "blue": Way(lambda image: toned(image, [0.7, 0.95, 1.25])),
    "warm": Way(lambda image: toned(image, [1.25, 0.95, 0.6])),
    "grey": Way(grey),
    "infrared": Way(infrared),
    "night": Way(lambda image: tinted(image, BLACK, (20, 150, 30), (60, 255, 80), (190, 255, 190))),
    "duotone": Way(lambda image: tinted(image, (10, 20, 80), (255, 160, 60))),
    "blued": Way(lambda image: tinted(image, BLACK, (60, 110, 255))),
    "darkroom": Way(lambda image: toned(np.repeat(image[..., :1], 3, 2), [1.0, 0.15, 0.1])),
    "amber": Way(lambda image: tinted(image, BLACK, (255, 176, 10))),
}


def write(target: Path, images: Iterable[Image], rate: Fraction, crf: int = 18) -> None:
    """Write a video of pictures."""
    with av.open(str(target), "w") as written:
        stream = None
        for image in images:
            height, width = (n - n % 2 for n in image.shape[:2])
            if stream is None:
                stream = written.add_stream("libx264", rate=rate, options={"crf": str(crf)})
                stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            picture = np.ascontiguousarray(image[:height, :width])
            written.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        written.mux(stream.encode() if stream else [])


def rate_of(video: Path) -> Fraction:
    """Frames per second of a video."""
    with av.open(str(video)) as read:
        return Fraction(read.streams.video[0].average_rate)


def rewrite(source: Path, target: Path, way: Way) -> None:
    """Write a video whose pictures are changed."""
    with av.open(str(source)) as read:
        kept = islice(read.decode(video=0), 0, None, way.every)
        images = (way.change(frame.to_ndarray(format="rgb24")) for frame in kept)
        write(target, images, rate_of(source) / way.every, way.crf)


def compared(runs: Path, altered: Path) -> Iterator[str]:
    """A line for each altered run that has a run of the clip as it is, then one for each way."""
    told: dict[str, list[float]] = {}
    for folder in sorted(altered.iterdir()):
        name, _, way = folder.name.rpartition("-")
        if way not in WAYS or not folder.is_dir() or not (runs / name).is_dir():
            continue
        whole, other = load_run(runs / name), load_run(folder)
        names, frames = ("found", "aperture", "width", "closed"), len(other["found"])
        plain = {n: whole[n][:: WAYS[way].every][:frames] for n in names}
        both = plain["found"] & other["found"]
        one, two = (run["aperture"][both] for run in (plain, other))
        off = np.sqrt(np.mean((one - two) ** 2))
        wide = np.corrcoef(plain["width"][both], other["width"][both])[0, 1]
        told.setdefault(way, []).append(float(np.corrcoef(one, two)[0, 1]))
        yield (
            f"{folder.name:14} found {other['found'].sum()} of {plain['found'].sum()}  aperture r "
            f"{told[way][-1]:.3f}, {off:.2f} mm rms of {one.std():.1f} sd  "
            f"width r {wide:.2f}  closed {plain['closed'].sum()} and {other['closed'].sum()}, "
            f"both {(plain['closed'] & other['closed']).sum()}"
        )
    for way, values in sorted(told.items()):
        good = int(np.sum(np.array(values) >= 0.9))
        yield (
            f"{way}: {len(values)} clips, r median {np.median(values):.3f}, least "
            f"{min(values):.3f}, 0.9 or more in {good}"
        )


def turned(clips: list[Path]) -> Iterator[str]:
    """A line for each quarter turn of the first frames: in how many the face is right way up."""
    images = [next(iter(read_frames(clip))) for clip in clips]
    for quarters in range(4):
        seen = [FaceChoice().first(np.ascontiguousarray(np.rot90(i, -quarters)))[0] for i in images]
        right = sum(m is not None and m.quarters == quarters for m in seen)
        yield f"turned by {90 * quarters} degrees: {right} of {len(images)} right way up"


def clips_in(folder: Path) -> list[Path]:
    """The videos of a folder."""
    return sorted(p for p in folder.iterdir() if p.suffix in (".mp4", ".mpg"))


def main(what: str, first: Path, *more: str) -> None:
    """Do what the command says."""
    if what == "turn":
        sys.stdout.write("\n".join(turned(clips_in(first))) + "\n")
        return
    second, *chosen = Path(more[0]), *more[1:]
    if what == "compare":
        sys.stdout.write("\n".join(compared(first, second)) + "\n")
        return
    second.mkdir(parents=True, exist_ok=True)
    for way in chosen or WAYS:
        if way not in WAYS:
            sys.exit(f"no way '{way}'; there are {', '.join(WAYS)}")
        for clip in clips_in(first):
            rewrite(clip, second / f"{clip.stem}-{way}.mp4", WAYS[way])


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), *sys.argv[3:])
