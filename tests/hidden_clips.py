"""Clips in parts of which the mouth is hidden, and how their runs take that.

What hides it is painted where the landmark network puts the mouth of each frame. Run it by hand,
first to make the clips, then to compare the runs that `abs-engine track` made of both:

    python tests/hidden_clips.py make CLIPS HIDDEN
    python tests/hidden_clips.py compare RUNS HIDDEN_RUNS

The first and last frame of what hides the mouth may count as either.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from altered_clips import clips_in, rate_of, write
from numpy.typing import NDArray

from abs_engine.io.video import read_frames
from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.detection.landmarks import OUTER_RING, Landmarks
from abs_engine.tracking.runs.record import load_run

Image = NDArray[np.uint8]
CHEEK = 50
JAW = (234, 93, 132, 58, 172, 136, 150, 149, 176, 148, 152, 377, 400, 378, 379, 365, 397, 288, 361)
NOSE = (323, 454, 4)
WORDS = ("REALLY", "WHAT", "HE SAID", "NO WAY", "THEN")
LETTER = 22.0
"""Height of OpenCV's capital letters, px, at size 1."""


def _blended(image: Image, mask: Image, paint: Image) -> Image:
    soft = cv2.GaussianBlur(mask, (0, 0), 1.5)[..., None] / 255.0
    return np.uint8(np.rint(soft * paint + (1 - soft) * image))


def hand(image: Image, seen: Landmarks) -> Image:
    """The person's own cheek, enlarged, over the mouth and as much again around it."""
    ring = seen.pixels[OUTER_RING]
    wide, (x, y) = float(np.ptp(ring[:, 0])), ring.mean(axis=0)
    reach = max(2, round(0.06 * seen.size))
    left, top = np.rint(seen.pixels[CHEEK]).astype(int) - reach
    patch = image[max(top, 0) : top + 2 * reach, max(left, 0) : left + 2 * reach]
    if not patch.size:
        patch = np.uint8([[[150, 110, 90]]])
    paint = cv2.resize(patch, image.shape[1::-1], interpolation=cv2.INTER_CUBIC)
    mask, axes = np.zeros(image.shape[:2], np.uint8), (round(0.95 * wide), round(0.75 * wide))
    cv2.ellipse(mask, (round(x), round(y)), axes, 0, 0, 360, 255, -1)
    return _blended(image, mask, paint)


def mask(image: Image, seen: Landmarks) -> Image:
    """A pale blue mask from the nose to the chin."""
    cover = np.zeros(image.shape[:2], np.uint8)
    outline = np.rint(seen.pixels[[*JAW, *NOSE]]).astype(np.int32)
    cv2.fillPoly(cover, [cv2.convexHull(outline)], 255)
    return _blended(image, cover, np.full_like(image, (110, 160, 205)))


def microphone(image: Image, seen: Landmarks) -> Image:
    """A dark ball before the mouth."""
    ring = seen.pixels[OUTER_RING]
    (x, y), cover = ring.mean(axis=0), np.zeros(image.shape[:2], np.uint8)
    cv2.circle(cover, (round(x), round(y)), round(0.8 * float(np.ptp(ring[:, 0]))), 255, -1)
    return _blended(image, cover, np.full_like(image, (32, 32, 36)))


def caption(image: Image, seen: Landmarks) -> Image:
    """A word in white, whose upper half lies over the lower lip."""
    ring, inked = seen.pixels[OUTER_RING], image.copy()
    wide, low = float(np.ptp(ring[:, 0])), float(ring[:, 1].max())
    word = WORDS[int(ring[0, 0]) // 4 % len(WORDS)]  # another one as the head moves
    size, thick = 0.4 * wide / LETTER, max(1, round(0.05 * wide))
    width = cv2.getTextSize(word, cv2.FONT_HERSHEY_SIMPLEX, size, thick)[0][0]
    at = round(float(ring[:, 0].mean()) - 0.5 * width), round(low + 0.12 * wide)
    white = (255, 255, 255)
    cv2.putText(inked, word, at, cv2.FONT_HERSHEY_SIMPLEX, size, white, thick, cv2.LINE_AA)
    return inked


@dataclass(frozen=True)
class Way:
    """What hides the mouth, and from which to which share of a clip."""

    paint: Callable[[Image, Landmarks], Image]
    first: float
    last: float

    def frames(self, count: int) -> slice:
        """The frames in which it does, of so many."""
        return slice(round(self.first * count), round(self.last * count))


WAYS = {
    "caption": Way(caption, 0.6, 0.9),
    "hand": Way(hand, 0.35, 0.68),
    "mask": Way(mask, 0.5, 0.9),
    "microphone": Way(microphone, 0.2, 0.45),
}


def rewrite(source: Path, target: Path, way: Way) -> None:
    """Write a video with the mouth hidden in some frames."""
    images = list(read_frames(source))
    follower = FaceFollower(FaceChoice())
    seen = [follower.step(image) for image in images]
    for k in range(*way.frames(len(images)).indices(len(images))):
        if seen[k] is not None:
            images[k] = way.paint(images[k], seen[k])
    write(target, images, rate_of(source))


def scored(plain: Path, folder: Path, way: Way) -> list[float]:
    """Counts of a run's frames, and how far its apertures are off.

    Hidden ones: all, lost, marked (`less_explained`), and apertures held by their 90 % intervals;
    bare ones: all, lost, marked; RMS of their apertures, mm. Those that are lost are not marked.
    """
    whole, other = load_run(plain), load_run(folder)
    count = len(other["found"])
    hidden, edge, at = np.zeros(count, bool), np.zeros(count, bool), way.frames(count)
    hidden[at] = True
    edge[[at.start, at.stop - 1]] = True
    lost = ~other["found"]
    bare = ~hidden & whole["found"]
    inside = hidden & ~edge & whole["found"]
    less = other["less_explained"]
    off = np.abs(other["aperture"] - whole["aperture"])
    within = off < 1.645 * other["aperture_sd"]
    rms = float(np.sqrt(np.mean(off[bare & ~lost] ** 2))) if (bare & ~lost).any() else float("nan")
    return [
        inside.sum(), (inside & lost).sum(), (inside & ~lost & less).sum(),
        (inside & ~lost & within).sum(), bare.sum(), (bare & lost).sum(),
        (bare & ~lost & less).sum(), rms,
    ]  # fmt: skip


def compared(runs: Path, hidden: Path) -> Iterator[str]:
    """A line for each run that has a run of the clip as it is, then one for each way and half."""
    rows: dict[tuple[str, str], list[list[float]]] = {}
    for folder in sorted(hidden.iterdir()):
        name, _, kind = folder.name.rpartition("-")
        if kind not in WAYS or not folder.is_dir() or not (runs / name).is_dir():
            continue
        row = scored(runs / name, folder, WAYS[kind])
        rows.setdefault((kind, "p01 to p08" if name < "p09" else "others"), []).append(row)
        yield f"{folder.name:16} {_line(np.array([row]))}"
    for (kind, half), each in sorted(rows.items()):
        yield f"{kind}, {half}: {_line(np.array(each))}"


def _line(rows: NDArray[np.float64]) -> str:
    inside, flagged, marked, held, bare, lost, less = rows[:, :7].sum(axis=0).astype(int)
    return (
        f"hidden {inside}: lost {flagged}, marked {marked}, intervals hold {held} of "
        f"{inside - flagged}; bare {bare}: lost {lost}, marked {less}, apertures "
        f"{np.nanmean(rows[:, 7]):.2f} mm RMS from those of the clip as it is"
    )


def main(what: str, first: Path, second: Path) -> None:
    """Do what the command says."""
    if what == "compare":
        sys.stdout.write("\n".join(compared(first, second)) + "\n")
        return
    second.mkdir(parents=True, exist_ok=True)
    for name, way in WAYS.items():
        for clip in clips_in(first):
            rewrite(clip, second / f"{clip.stem}-{name}.mp4", way)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
