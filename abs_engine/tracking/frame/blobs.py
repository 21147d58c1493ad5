"""The face and the lips as blobs: clusters of pixels alike in place and colour (Basu et al., 5.2).

Once the colour classes of a person are known, this finds the mouth in a frame without a face
detector: the largest skin blob of sufficient size is the face, and inside it the lip blob with the
highest posterior, by colour and by where in a face lips are, is the mouth.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.face.appearance.chroma import matched
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.appearance.mixture import Mixture
from abs_engine.face.settings.colour import COLOURS
from abs_engine.tracking.settings.blobs import BLOB_START

_EDGE = np.ones((3, 3), np.uint8)  # px: between lips and teeth colours mix, and are of no class

_EXPECTED, _DEVIATION = np.array(BLOB_START.expected), np.array(BLOB_START.expected_deviation)


@dataclass(frozen=True, eq=False)
class FaceBlob:
    """The largest blob of skin.

    Parameters
    ----------
    centre : (2,) float64, px
    top : float, px
        Its upper edge.
    width : float, px
        Four standard deviations across.
    inside : (H, W) bool
        The blob with its holes filled, in the whole picture.
    """

    centre: FloatArray
    top: float
    width: float
    inside: BoolArray


@dataclass(frozen=True, eq=False)
class LipPrior:
    """Prior of the lips' place: a Gaussian over the picture.

    Parameters
    ----------
    centre : (2,) float64, px
    deviation : (2,) float64, px
    area : float, px^2
        How large lips are expected to be.
    """

    centre: FloatArray
    deviation: FloatArray
    area: float

    @classmethod
    def in_face(cls, face: FaceBlob) -> LipPrior:
        """Prior of the lips in a skin blob."""
        origin = np.array([face.centre[0], face.top])
        centre = origin + _EXPECTED * face.width
        return cls(centre, _DEVIATION * face.width, BLOB_START.mouth * face.width**2)


@dataclass(frozen=True, eq=False)
class LipBlob:
    """The blob of lip colour with the highest posterior.

    Parameters
    ----------
    centre : (2,) float64, px
    size : (2,) float64, px
        Extent along and across the mouth, four standard deviations: the axes of an even ellipse.
    area : float, px^2
        Sum of the probability of lips over its pixels.
    posterior : float
        How sure it is, 0 to 1, that this is no clutter, by its mass, and that it and no other blob
        is the mouth, by the odds of their colours and where they lie.
    """

    centre: FloatArray
    size: FloatArray
    area: float
    posterior: float


def find_face_blob(classes: ColourClasses, image: Image) -> FaceBlob | None:
    """The face in an image (H, W, 3) RGB: its largest skin blob, or None if that is too small."""
    small, scale = _shrunk(image)
    maps = classes.probabilities(small, COLOURS.smoothing)
    skin = maps[CLASSES.index("skin")] + maps[CLASSES.index("lips")] > 0.5
    mask = cv2.morphologyEx(skin.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, label, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=4)
    if count < 2:
        return None
    best = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    blob = label == best
    if blob.sum() < BLOB_START.least_face * mask.size:
        return None
    y, x = np.nonzero(blob)
    inside = cv2.resize(_filled(blob), image.shape[1::-1], interpolation=cv2.INTER_NEAREST)
    centre = (np.array([x.mean(), y.mean()]) + 0.5) / scale - 0.5
    top = (float(np.quantile(y, BLOB_START.top)) + 0.5) / scale - 0.5
    return FaceBlob(centre, top, 4 * float(x.std()) / scale, inside > 0)


def find_lips(
    classes: ColourClasses, image: Image, prior: LipPrior | None = None
) -> LipBlob | None:
    """The mouth in an image (H, W, 3) RGB by colour and place alone.

    With a prior, by a pose or by the frames before, only that neighbourhood is looked at. By
    default lips are expected where in a face they lie, and only in the face's blob. None where
    nothing has the lips' colour, or, without a prior, no face is seen.
    """
    inside = None
    if prior is None:
        face = find_face_blob(classes, image)
        if face is None:
            return None
        prior, inside = LipPrior.in_face(face), face.inside
    box = _neighbourhood(prior, image.shape)
    if box is None:
        return None
    x, y, right, bottom = box
    small, scale = _shrunk(image[y:bottom, x:right])
    maps = classes.probabilities(small, COLOURS.smoothing)
    if inside is not None:
        part = inside[y:bottom, x:right].astype(np.uint8)
        maps = maps * cv2.resize(part, small.shape[1::-1], interpolation=cv2.INTER_NEAREST)
    found = _clusters(maps, small, BLOB_START.parted * np.sqrt(prior.area) * scale)
    if found is None:
        return None
    pixels, weight, share = found
    places = (pixels + 0.5) / scale - 0.5 + np.array([x, y])
    near = np.exp(-0.5 * (((places - prior.centre) / prior.deviation) ** 2).sum(axis=1))
    strength = (share * (_evidence(weight) * near)[:, None]).sum(axis=0)
    best = int(strength.argmax())
    mass = float(share[:, best] @ (weight * near)) / scale**2
    alone = float(strength[best] / max(strength.sum(), 1e-300))  # 0 far from where lips may be
    posterior = alone * mass / (mass + BLOB_START.clutter * prior.area)
    return _blob(places, weight * share[:, best], 1 / scale**2, posterior)


def _shrunk(image: Image) -> tuple[NDArray[np.float32], float]:
    """The image's colours, at most `BLOB_START.work` pixels long, and its scale.

    `matched`, unless it is shrunk to half: chroma is as fine as luminance there.
    """
    scale = min(1.0, BLOB_START.work / max(image.shape[:2]))
    if scale == 1.0:
        return matched(image), 1.0
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return matched(small) if scale > 0.5 else np.asarray(small, np.float32), scale


def _filled(blob: BoolArray) -> Image:
    """The blob with its holes, eyes and mouth, and its bays."""
    edges, _ = cv2.findContours(blob.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    filled = np.zeros(blob.shape, np.uint8)
    hull = cv2.convexHull(np.concatenate(edges))
    return np.asarray(cv2.fillConvexPoly(filled, hull, 1), np.uint8)


def _neighbourhood(prior: LipPrior, shape: tuple[int, ...]) -> tuple[int, int, int, int] | None:
    """Left, top, right and bottom of what is looked at about the prior; None if it is nothing."""
    reach = BLOB_START.looked_deviations * prior.deviation
    reach = reach + BLOB_START.looked_lips * np.sqrt(prior.area)
    low = np.maximum(np.floor(prior.centre - reach), 0).astype(int)
    high = np.minimum(np.ceil(prior.centre + reach) + 1, shape[1::-1]).astype(int)
    if (high - low < 4).any():
        return None
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _clusters(
    maps: FloatArray, image: NDArray[np.generic], parted: float
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Lip pixels as clusters over (x, y, r, g).

    Parameters
    ----------
    maps : (4, H, W) float64
        P(class | colour).
    image : (H, W, 3), RGB 0 to 255
    parted : float, px
        Two patches no farther apart than this, over teeth and dark, are the lips of one mouth.

    Returns
    -------
    pixels : (N, 2) float64
        x and y of every pixel that may show lips.
    weight : (N,) float64
        P(lips | colour).
    share : (N, K) float64
        How far each belongs to each cluster.
    """
    lips = maps[CLASSES.index("lips")]
    mouth = lips + maps[CLASSES.index("teeth")] + maps[CLASSES.index("dark")] > 0.5
    mouth = cv2.morphologyEx(mouth.astype(np.uint8), cv2.MORPH_CLOSE, _EDGE) > 0
    seeds = lips > 0.5
    window = np.ones((2 * max(1, round(0.5 * parted)) + 1, 3), np.uint8)
    closed = cv2.morphologyEx(seeds.astype(np.uint8), cv2.MORPH_CLOSE, window) > 0
    joined = seeds | (closed & mouth)  # lips part over teeth and dark
    count, label = cv2.connectedComponents(joined.astype(np.uint8), connectivity=8)
    sizes = np.bincount(label[seeds], minlength=count)
    sizes[0] = 0
    largest = np.argsort(-sizes)[: BLOB_START.most_blobs]
    kept = [k for k in largest if sizes[k] >= BLOB_START.least_pixels]
    y, x = np.nonzero(lips > BLOB_START.least_lips)
    if not kept or not len(x):
        return None
    pixels, weight = np.stack([x, y], axis=1).astype(np.float64), lips[y, x]
    colour = image[y, x].astype(np.float64)
    chroma = (colour[:, :2] + 1) / (colour.sum(axis=1, keepdims=True) + 3)
    features = np.hstack([pixels / lips.shape[1], chroma / BLOB_START.colour_spread])
    member = np.stack([(label[y, x] == k) & (weight > 0.5) for k in kept], axis=1)
    mixture = _gaussians(features, member * weight[:, None])
    for _ in range(BLOB_START.em_steps):
        mixture = mixture.updated(features, _evidence(weight))
    parts = mixture.densities(features)
    stray = BLOB_START.stray * parts.max(axis=0).min()  # far from every blob
    return pixels, weight, parts / (parts.sum(axis=1, keepdims=True) + stray)


def _evidence(weight: FloatArray) -> FloatArray:
    """Strength of the evidence P(lips) for lips, 0 to 1: by its odds, to a limit.

    Shade may be lips by a little, over an area larger than a mouth's.
    """
    odds = weight / np.maximum(1 - weight, 1e-12)
    return np.asarray(np.log(np.clip(odds, 1.0, BLOB_START.clear)) / np.log(BLOB_START.clear))


def _gaussians(features: FloatArray, member: FloatArray) -> Mixture:
    """A Gaussian for each column of `member` (N, K)."""
    mass = member.sum(axis=0)
    means = member.T @ features / mass[:, None]
    floor = np.diag(BLOB_START.least_spread)
    covariances = []
    for k, mean in enumerate(means):
        offset = features - mean
        covariances.append((offset * member[:, k, None]).T @ offset / mass[k] + floor)
    return Mixture(mass / mass.sum(), means, np.stack(covariances))


def _blob(places: FloatArray, weight: FloatArray, pixel: float, posterior: float) -> LipBlob:
    """Moments of weighted pixels, each `pixel` px^2 large."""
    total = float(weight.sum())
    centre = weight @ places / total
    offset = places - centre
    values, _ = np.linalg.eigh((offset * weight[:, None]).T @ offset / total)
    size = 4 * np.sqrt(np.maximum(values[::-1], 0.0))
    return LipBlob(centre, size, total * pixel, posterior)
