"""Pictures in another frame's place, or mirrored, in the video or among those before compression.

The labels of two frames, see `footage`, leave clearly less of pictures that changed places if these
change back. A highlight or other light makes a picture fit less well in both places, so that it
does not count.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import AbsEngineError
from abs_engine.dataset import Truth
from abs_engine.dataset.codec import FRAMES
from abs_engine.dataset.picture import read_picture
from abs_engine.evaluate.check.finding import Finding
from abs_engine.evaluate.check.footage import PIXELS, features
from abs_engine.evaluate.check.visibility import Sight, look
from abs_engine.io.video import read_frames

CLEARLY = 0.9
"""Share of what is left otherwise. True films at x264's lowest quality (51) come down to 0.92."""

COLUMNS = 320
"""About so many of wide pictures are compared, and as few rows."""

Pictures = Iterable[tuple[int, NDArray[np.uint8]]]


def of_video(truth: Truth, frames: Collection[int]) -> Pictures:
    """Pictures of some frames of the video, up to where it cannot be read: `footage` says that."""
    with suppress(AbsEngineError):
        for frame, picture in enumerate(read_frames(truth.video)):
            if frame in frames and picture.shape[1::-1] == truth.camera.size:
                yield frame, picture


def before_compression(truth: Truth, frames: Collection[int]) -> Pictures:
    """Those that were kept, and can be read: `files` says if one cannot."""
    for frame in frames:
        path = truth.frame_path(frame)
        if path is not None:
            with suppress(AbsEngineError):
                yield frame, read_picture(path, FRAMES, truth.camera.size)


def order_findings(truth: Truth, sources: Mapping[str, Pictures]) -> Iterator[Finding]:
    """Pictures that changed places with one of another frame, or are mirrored, in each source."""
    step = max(1, truth.camera.size[0] // COLUMNS)
    shown = {
        name: {k: one[::step, ::step].mean(axis=2, dtype=np.float32) for k, one in pictures}
        for name, pictures in sources.items()
    }
    rows: dict[str, dict[int, FloatArray]] = {name: {} for name in shown}
    for frame in sorted(set().union(*shown.values())):
        sight = look(truth, frame)
        if len(sight) >= PIXELS * step**2:
            labels = _labels(truth, sight, step)
            for name, each in shown.items():
                if frame in each:
                    compared = [*each.values(), each[frame][:, ::-1]]
                    rows[name][frame] = _left(*labels, compared)
    for name, left in rows.items():
        if left:
            yield from _judged(name, list(shown[name]), left)


def _judged(name: str, shown: list[int], rows: Mapping[int, FloatArray]) -> Iterator[Finding]:
    """Findings by what labels of frames leave of each frame shown, and of their mirror images."""
    left, frames = np.array(list(rows.values())), list(rows)
    mirrored, left = left[:, -1], left[:, [k for k, frame in enumerate(shown) if frame in rows]]
    own = left.diagonal()
    exchanged, as_is = left + left.T, np.add.outer(own, own)
    gain = CLEARLY * as_is - exchanged
    best = gain.argmax(axis=1)
    for k, other in enumerate(best):
        if gain[k, other] > 0 and best[other] == k:
            how = f"as in frame {frames[other]}, and the other way round: labels explain "
            how += f"{1 - exchanged[k, other] / 2:.1%} then, now {1 - as_is[k, other] / 2:.1%}"
            yield Finding(name, "looks like another frame", how, frames[k])
        elif mirrored[k] < CLEARLY * own[k]:
            how = f"labels explain {1 - mirrored[k]:.1%} of its mirror image, of it "
            yield Finding(name, "is mirrored", how + f"{1 - own[k]:.1%}", frames[k])


def _labels(truth: Truth, sight: Sight, step: int) -> tuple[FloatArray, BoolArray]:
    """Orthonormal features (K, F) of a frame's labels, and a mask of the pixels (h, w) they are of.

    Of every so many pixels.
    """
    model, near = features(truth, sight)
    seen = np.zeros_like(near)
    seen[::step, ::step] = near[::step, ::step]
    return np.linalg.qr(model[seen[near]])[0], seen[::step, ::step]


def _left(base: FloatArray, seen: BoolArray, pictures: Sequence[NDArray[np.float32]]) -> FloatArray:
    """Share (P,) that a frame's labels leave unexplained of pictures."""
    levels = np.stack([one[seen] for one in pictures], axis=1)
    levels -= levels.mean(axis=0)
    total = np.square(levels).sum(axis=0)
    left = total - np.square(base.T @ levels).sum(axis=0)
    shares: FloatArray = np.divide(left, total, out=np.ones(len(pictures)), where=total > 0)
    return shares
