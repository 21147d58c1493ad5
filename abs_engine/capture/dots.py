"""Dots in a picture: what they look like, and where they are, by normalised correlation."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import FloatArray, Image

Map = NDArray[np.float32]


def _steps(first: float, last: float, step: float) -> FloatArray:
    return np.arange(first, last + step / 2, step)


_RADII, _LARGER = _steps(*CAPTURE.radii), _steps(*CAPTURE.larger_radii)


@dataclass(frozen=True, eq=False)
class DotModel:
    """Appearance of the dots of a view.

    Parameters
    ----------
    colour : (3,) float64
        Weights of R, G and B; in their sum dots are bright.
    radius : float
        Pixels.
    """

    colour: FloatArray
    radius: float

    def picture(self, image: Image) -> Map:
        """The weighted sum of the colours, (H, W) float32, of an image (H, W, 3)."""
        weights = np.asarray(self.colour, np.float32)
        return np.asarray(cv2.transform(image.astype(np.float32), weights[None]), np.float32)

    @property
    def template(self) -> Map:
        """A bright disc with soft edge before a dark ground, (2 k + 1, 2 k + 1) float32."""
        return disc(self.radius)

    def match(self, picture: Map) -> Map:
        """Normalised correlation (H, W) float32 of the disc with each place; -1 at the border."""
        return correlate(picture, self.template)


def disc(radius: float) -> Map:
    """A disc of value 1 with a soft edge, in a window about twice as wide, (n, n) float32."""
    half = max(2, int(np.ceil(CAPTURE.surround * radius)))
    y, x = np.mgrid[-half : half + 1, -half : half + 1]
    edge = (radius - np.hypot(x, y)) / (np.sqrt(2) * CAPTURE.dot_blur)
    return np.asarray(0.5 * (1 + np.tanh(1.2 * edge)), np.float32)


def correlate(picture: Map, template: Map) -> Map:
    """Normalised correlation coefficient of a template centred at each pixel.

    Parameters
    ----------
    picture : (H, W) float32
    template : (2 k + 1, 2 k + 1) float32

    Returns
    -------
    (H, W) float32
        From -1 to 1; -1 where the template does not fit in.
    """
    half = template.shape[0] // 2
    out = np.full(picture.shape, -1.0, np.float32)
    if min(picture.shape) < template.shape[0]:
        return out
    inner = cv2.matchTemplate(picture, template, cv2.TM_CCOEFF_NORMED)
    inner[~np.isfinite(inner)] = -1.0
    out[half:-half, half:-half] = np.clip(inner, -1.0, 1.0)
    return out


def learn_dots(image: Image, places: FloatArray) -> DotModel:
    """Colour weights and radius of dots whose places are about known.

    The colours are Fisher's linear discriminant between the dots and the skin around them. Colour
    and radius depend on each other, so they are found twice in turn. Larger radii are tried only
    where those tried first leave it open whether one of them is right.

    Parameters
    ----------
    places : (N, 2) float64, px
    """
    model, score = _learned(image, places, _RADII)
    if model.radius in (_RADII[0], _RADII[-1]) or score < CAPTURE.least:
        larger, better = _learned(image, places, _LARGER)
        if better > score:
            return larger
    return model


def _learned(image: Image, places: FloatArray, radii: FloatArray) -> tuple[DotModel, float]:
    """The dots with the best of some radii, and its score."""
    model, score = DotModel(np.array([-1.0, -1.0, -1.0]) / 3, 0.0), 0.0
    for _ in range(2):
        picture = model.picture(image)
        scores = [_score(picture, places, radius) for radius in radii]
        radius, score = float(radii[int(np.argmax(scores))]), max(scores)
        model = DotModel(_discriminant(image, places, radius), radius)
    return model, score


def _score(picture: Map, places: FloatArray, radius: float) -> float:
    """Mean best correlation near the places."""
    half = disc(radius).shape[0] // 2 + 3
    best = []
    for place in places:
        part = np.asarray(cut(picture, place, half)[0], np.float32)
        best.append(float(correlate(part, disc(radius)).max()))
    return float(np.mean(best))


def _discriminant(image: Image, places: FloatArray, radius: float) -> FloatArray:
    reach = int(np.ceil(CAPTURE.bare[1] * radius)) + 1
    difference, within = np.zeros(3), np.zeros((3, 3))
    for place in places:
        part, origin = cut(image, place, reach)
        y, x = np.mgrid[: part.shape[0], : part.shape[1]]
        away = np.hypot(x + origin[0] - place[0], y + origin[1] - place[1]) / radius
        inside = part[away < CAPTURE.dot_core].astype(float)
        around = part[(away > CAPTURE.bare[0]) & (away < CAPTURE.bare[1])].astype(float)
        if len(inside) and len(around) > 3:
            difference += np.median(inside, axis=0) - np.median(around, axis=0)
            within += np.cov(around.T)
    within += (CAPTURE.colour_ridge * np.trace(within) / 3 + 1e-3) * np.eye(3)
    weights = np.linalg.solve(within, difference)
    return np.asarray(weights / max(float(np.abs(weights).sum()), 1e-12))


def cut(
    picture: NDArray[np.generic], place: FloatArray, half: int
) -> tuple[NDArray[np.generic], FloatArray]:
    """Up to 2 half + 1 pixels square around a place, within the picture, and its corner (x, y)."""
    x, y = np.rint(place).astype(int)
    left, top = max(0, x - half), max(0, y - half)
    right, bottom = max(left, x + half + 1), max(top, y + half + 1)
    return picture[top:bottom, left:right], np.array([left, top], float)


@dataclass(frozen=True, eq=False)
class Peaks:
    """Places that look like dots.

    Parameters
    ----------
    places : (M, 2) float64, px
    scores : (M,) float64
        Normalised correlation.
    """

    places: FloatArray
    scores: FloatArray


def find_peaks(match: Map, least: float) -> Peaks:
    """Local maxima of a correlation map of at least `least`, to a fraction of a pixel.

    A quadric through the nine values around the highest pixel gives the fraction.
    """
    highest = cv2.dilate(match, np.ones((3, 3), np.uint8))
    rows, columns = np.nonzero((match >= highest) & (match >= least))
    inside = (rows > 0) & (columns > 0) & (rows < match.shape[0] - 1)
    inside &= columns < match.shape[1] - 1
    rows, columns = rows[inside], columns[inside]
    places = np.column_stack([columns, rows]).astype(float)
    scores = match[rows, columns].astype(float)
    for k, (row, column) in enumerate(zip(rows, columns, strict=True)):
        shift = _vertex(match[row - 1 : row + 2, column - 1 : column + 2].astype(float))
        places[k] += shift
    return Peaks(places, scores)


def _vertex(nine: FloatArray) -> FloatArray:
    """Place (x, y) at which a quadric fitted to 3 x 3 values peaks, within half a pixel or so."""
    dx, dy = (nine[:, 2] - nine[:, 0]).mean() / 2, (nine[2] - nine[0]).mean() / 2
    dxx = (nine[:, 2] - 2 * nine[:, 1] + nine[:, 0]).mean()
    dyy = (nine[2] - 2 * nine[1] + nine[0]).mean()
    dxy = (nine[2, 2] - nine[2, 0] - nine[0, 2] + nine[0, 0]) / 4
    determinant = dxx * dyy - dxy * dxy
    if dxx >= 0 or dyy >= 0 or determinant <= 0:
        return np.zeros(2)
    shift = -np.array([dyy * dx - dxy * dy, dxx * dy - dxy * dx]) / determinant
    return np.asarray(np.clip(shift, -0.75, 0.75))
