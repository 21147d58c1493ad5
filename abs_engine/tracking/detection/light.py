"""A frame in the light that the clip's colours were learned in: light changes, classes do not.

The skin of the cheeks shows the light of each frame: by how much its red, green and blue have
become brighter or darker than in the frames that colours were learned from. The whole frame is
divided by that (von Kries' rule). What a cheek shows beside that, as it turns, is little, and a
change that is no larger is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.face.settings.colour import COLOURS
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.settings.frames import FRAME_LOOP

CHEEKS = (50, 280, 205, 425, 187, 411, 36, 266, 101, 330, 118, 347, 123, 352, 116, 345, 147, 376)
"""Landmarks of both cheeks, off the eyes, the mouth and the outline of the face."""
_MOST = np.log(FRAME_LOOP.light_most)


@dataclass(frozen=True, eq=False)
class SkinLight:
    """The light of a clip, by the skin of the cheeks.

    Parameters
    ----------
    cheeks : (N, 3) float64
        Logarithms of RGB at each of `CHEEKS`, NaN where it lies in no picture.
    """

    cheeks: FloatArray

    @classmethod
    def of(cls, seen: Sequence[tuple[Image, Landmarks]]) -> SkinLight:
        """The median of some frames."""
        each = np.stack([_cheeks(image, landmarks) for image, landmarks in seen])
        return cls(_median(each))

    def change(self, image: Image, landmarks: Landmarks) -> FloatArray:
        """By how much a frame is brighter than usual in R, G and B, (3,), logarithms."""
        away = _median(_cheeks(image, landmarks) - self.cheeks)
        return np.clip(np.nan_to_num(away), -_MOST, _MOST)

    def same_hue(self, image: Image, landmarks: Landmarks) -> bool:
        """Whether the skin has its usual hue in a frame, as far as its light says so."""
        change, usual = self.change(image, landmarks), np.ptp(_median(self.cheeks))
        most = min(FRAME_LOOP.light_hue, FRAME_LOOP.hue_share * float(usual))
        return bool(np.ptp(change) < most and np.abs(change).max() < _MOST)

    def too_dark(self, image: Image, landmarks: Landmarks) -> bool:
        """Whether next to nothing is seen of the face, as where the film fades, unlike usually."""
        now, usual = _median(_cheeks(image, landmarks)), _median(self.cheeks)
        darkest = np.log(FRAME_LOOP.light_dark + FRAME_LOOP.light_black)
        return bool(now.max() < darkest and (now - usual).max() < -_MOST)

    def too_bright(self, image: Image, landmarks: Landmarks) -> bool:
        """Whether the face is white, as in the flash of a camera, unlike usually."""
        white = np.log(COLOURS.limit + FRAME_LOOP.light_black)  # in all but one channel
        now, usual = (np.sort(_median(c)) for c in (_cheeks(image, landmarks), self.cheeks))
        return bool(now[1] >= white > usual[1])

    def balanced(self, image: Image, landmarks: Landmarks) -> Image:
        """A frame (H, W, 3) RGB in the usual light; itself where that has hardly changed."""
        change, none = self.change(image, landmarks), FRAME_LOOP.light_none
        share = np.clip((np.abs(change).max() - none) / (FRAME_LOOP.light_full - none), 0.0, 1.0)
        if share == 0:
            return image
        levels = np.arange(256)[:, None] * np.exp(-share * change)
        table = np.rint(np.clip(levels, 0, 255)).astype(np.uint8)
        return np.stack([table[image[..., k], k] for k in range(3)], axis=-1)


def _cheeks(image: Image, landmarks: Landmarks) -> FloatArray:
    """Logarithms of RGB about each of `CHEEKS`, (N, 3); NaN where that lies outside."""
    reach = max(1, int(np.ceil(FRAME_LOOP.light_patch * landmarks.size)))
    found = np.full((len(CHEEKS), 3), np.nan)
    for k, (x, y) in enumerate(np.rint(landmarks.pixels[list(CHEEKS)]).astype(int)):
        left, top = max(x - reach, 0), max(y - reach, 0)
        patch = image[top : max(y + reach + 1, 0), left : max(x + reach + 1, 0)]
        if patch.size:
            found[k] = np.log(patch.reshape(-1, 3).mean(axis=0) + FRAME_LOOP.light_black)
    return found


def _median(rows: FloatArray) -> FloatArray:
    """Medians over the first axis of what is there; NaN where nothing is."""
    there = np.isfinite(rows)
    out = np.full(rows.shape[1:], np.nan)
    for place in np.ndindex(out.shape):
        values = rows[(slice(None), *place)][there[(slice(None), *place)]]
        if values.size:
            out[place] = np.median(values)
    return out
