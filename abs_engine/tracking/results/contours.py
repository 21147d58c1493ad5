"""Lip contours drawn on pictures, for people to look at."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult

Colour = tuple[int, int, int]

OUTER: Colour = (60, 255, 120)
UPPER: Colour = (255, 230, 0)
LOWER: Colour = (80, 190, 255)
LOST: Colour = (255, 70, 60)
WHITE: Colour = (235, 235, 235)
GREY: Colour = (120, 120, 120)
LEGEND: tuple[tuple[str, Colour], ...] = (
    ("outer contour", OUTER),
    ("upper lip, inner", UPPER),
    ("lower lip, inner", LOWER),
)

OTHERWISE = "landmarks say otherwise"
"""On a picture of a frame whose aperture they contradict, in the colour of `LOST`."""

_DOWN = np.array([[0.0, -5.0, 0.0], [0.0, 5.0, 0.0]])  # mm
_UPRIGHT = 0.7  # cosine between across the corners' line and down the head
_TURNED = 0.6  # quarters, from which on another one is turned
_FRACTION = 4  # bits of OpenCV's sub-pixel coordinates


@dataclass(frozen=True, eq=False)
class LipDrawing:
    """Draws what was found on windows of the frame.

    Parameters
    ----------
    sizes : tuple of int
        Number of points of the outer, upper inner and lower inner contour in `FrameResult.lips`.
    mouth : (M, 3) float64, mm, head frame
        Outer lip contour of the head at rest: it says where the mouth is, whatever it does.
    """

    camera: Camera
    sizes: tuple[int, int, int]
    mouth: FloatArray

    @classmethod
    def of(cls, setting: ClipSetting) -> LipDrawing:
        """Drawer of the results of a clip."""
        face = setting.face
        return cls(setting.camera, face.ring_sizes, face.border)

    def contours(self, result: FrameResult) -> list[tuple[FloatArray, bool, Colour]]:
        """Image points (K, 2) of each contour, whether it is closed, and its colour."""
        if result.pose is None or not result.found:
            return []
        pixels = self.camera.project(result.pose.apply(result.lips))
        outer, upper, lower = np.split(pixels, np.cumsum(self.sizes)[:2])
        middle = result.pose.apply(result.lips.mean(axis=0) + _DOWN)
        upper, lower = _meeting(upper, lower, np.subtract(*self.camera.project(middle)))
        return [(upper, False, UPPER), (lower, False, LOWER), (outer, True, OUTER)]

    def draw(self, picture: Image, window: Window, result: FrameResult) -> None:
        """Draw the contours on the picture of a window, in place."""
        for points, closed, colour in self.contours(result):
            fixed = np.rint(window.to_drawn(points) * 2**_FRACTION).astype(np.int32)
            cv2.polylines(picture, [fixed], closed, colour, 1, cv2.LINE_AA, _FRACTION)

    def view(
        self, pose: Pose, size: tuple[int, int], across: float, last: MouthView | None = None
    ) -> MouthView:
        """The mouth, upright to 45 degrees, `across` mouth widths wide, at `size` pixels.

        After a `last` view, it is turned by another quarter only where the head is tilted farther.
        """
        pixels = self.camera.project(pose.apply(self.mouth))
        down = np.subtract(*self.camera.project(pose.apply(self.mouth.mean(axis=0) + _DOWN)))
        tilt = float(np.arctan2(*down)) / (np.pi / 2)
        turns = round(tilt)  # of a face on its side
        if last is not None and abs((tilt + last.turns + 2) % 4 - 2) < _TURNED:
            turns = -last.turns
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        wide = float((high - low)[turns % 2])
        scale = size[0] / (across * max(1.0, wide))
        width, height = (side / scale for side in (size[::-1] if turns % 2 else size))
        below = np.rint([np.sin(turns * np.pi / 2), np.cos(turns * np.pi / 2)])
        left, top = 0.5 * (low + high - [width, height] + 1) + 0.08 * wide * below
        return MouthView(self, Window(float(left), float(top), width, height, scale), -turns)


@dataclass(frozen=True, eq=False)
class MouthView:
    """The mouth in a frame, enlarged and upright.

    Parameters
    ----------
    turns : int
        Quarter turns, against the clock, after which it is upright.
    """

    drawing: LipDrawing
    window: Window
    turns: int

    def of(self, image: Image, result: FrameResult) -> tuple[Image, Image]:
        """The part of a frame (H, W, 3) as it is, and with the contours of a result."""
        plain = cut(self.window, image)
        drawn = plain.copy()
        self.drawing.draw(drawn, self.window, result)
        return self._upright(plain), self._upright(drawn)

    def _upright(self, picture: Image) -> Image:
        return np.ascontiguousarray(np.rot90(picture, self.turns))


def _meeting(
    upper: FloatArray, lower: FloatArray, down: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Lines (K, 2) and (L, 2) px, from corner to corner, that do not cross.

    Closed lips reach a little into each other; there, both are drawn halfway. `down` (2,) px is the
    head's own direction; seen from the side, where corners lie along it, lines stay as they are.
    """
    along = upper[-1] - upper[0] if len(upper) else np.zeros(2)
    across = along / max(float(np.linalg.norm(along)), 1e-9)
    below = np.array([-across[1], across[0]])
    side = float(below @ down) / max(float(np.linalg.norm(down)), 1e-9)
    if abs(side) < _UPRIGHT:
        return upper, lower
    axes = np.stack([across, np.sign(side) * below])
    (s, h), (t, k) = (axes @ (line - upper[0]).T for line in (upper, lower))
    low, high = np.interp(s, *_rising(t, k)), np.interp(t, *_rising(s, h))
    h, k = np.where(low < h, 0.5 * (low + h), h), np.where(high > k, 0.5 * (high + k), k)
    one, other = (upper[0] + np.stack(line, axis=1) @ axes for line in ((s, h), (t, k)))
    return one, other


def _rising(along: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
    order = np.argsort(along)
    return along[order], height[order]


def cut(window: Window, image: Image) -> Image:
    """The window of a frame, a picture of its own to draw on; black beyond the frame's borders."""
    picture = np.ascontiguousarray(window.sample(image), np.uint8)
    (x, y), (height, width) = window.places, image.shape[:2]
    picture[:, (x < -0.5) | (x > width - 0.5)] = 0
    picture[(y < -0.5) | (y > height - 0.5)] = 0
    return picture


def write_text(
    picture: Image, text: str, at: tuple[int, int], colour: Colour = WHITE, size: float = 0.45
) -> None:
    """Write a line with its lower left corner at `at`, in place."""
    font = cv2.FONT_HERSHEY_SIMPLEX
    for shift, ink in ((1, (0, 0, 0)), (0, colour)):
        place = at[0] + shift, at[1] + shift
        cv2.putText(picture, text, place, font, size, ink, 1, cv2.LINE_AA)
