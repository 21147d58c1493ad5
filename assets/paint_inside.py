"""Paint what shows through the openings: eyes, teeth, gums, tongue and the inner mouth."""

from __future__ import annotations

import numpy as np
import speaker_mesh as sm
from paint_look import Look
from paint_maps import Texels, layered, noise, step, to_points
from paint_skin import mix, srgb

TOOTH_WIDTHS = {
    sm.UPPER_TEETH: (8.6, 6.8, 7.8, 7.0, 6.8, 10.0),
    sm.LOWER_TEETH: (5.4, 5.9, 6.9, 7.0, 7.1, 11.0),
}  # mm, from the middle outwards
ENAMEL = np.array([232, 225, 211]) / 255.0
LUMA = np.array([0.299, 0.587, 0.114])
RED_BROWN = np.array([1.75, 0.70, 0.62])  # hue of the inner mouth, at a luma of one
TONGUE_RED = np.array([1.60, 0.76, 0.76])
GUM_SHARE, CHEEK_SHARE = 0.19, 0.13  # luma of gums and inner mouth over that of the skin
TONGUE_SHARE = 0.50  # luma of the tongue's tip over that of the lips
IRIS_RADIUS, PUPIL_RADIUS = 5.9, 2.1  # mm


def toned(hue: np.ndarray, reference: tuple[int, int, int], share: float) -> np.ndarray:
    """Return a hue at `share` of the luma of a reference colour (0 to 255)."""
    return hue / (hue @ LUMA) * (share * (srgb(reference) @ LUMA))


def depth_shade(z: np.ndarray, front: float, back: float, least: float) -> np.ndarray:
    """Return the factor by which the mouth darkens inwards, from 1 at `front` to `least`."""
    return least + (1.0 - least) * step(z, back, front)


def arch_length(place: np.ndarray) -> np.ndarray:
    """Return the unsigned distance (mm) along the dental arch from its middle."""
    back = place[:, 2].min()
    angle = np.abs(np.arctan2(place[:, 0], place[:, 2] - back + 1e-6))
    bins = np.linspace(0, np.pi / 2, 40)
    index = np.digitize(angle, bins)
    radius = np.array(
        [
            np.hypot(place[index == i, 0], place[index == i, 2] - back).max(initial=0.0)
            for i in range(1, len(bins) + 1)
        ]
    )
    radius = np.where(radius > 0, radius, radius.max())
    curve = np.stack([radius * np.sin(bins), radius * np.cos(bins)], 1)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    return np.interp(angle, bins, length)


def paint_teeth(at: Texels, chosen: np.ndarray, kind: int, look: Look, seed: int) -> np.ndarray:
    """Return the colours of one row of teeth: enamel, gaps, gums, and shade towards the back."""
    p = at.place[chosen]
    along = arch_length(p)
    edges = np.concatenate([[0.0], np.cumsum(TOOTH_WIDTHS[kind])])
    number = np.clip(np.searchsorted(edges, along, side="right") - 1, 0, len(edges) - 2)
    to_gap = np.minimum(along - edges[number], np.abs(edges[number + 1] - along))
    half = np.diff(edges)[number] / 2.0
    height = (p[:, 1] - p[:, 1].min()) / np.ptp(p[:, 1])
    height = height if kind == sm.UPPER_TEETH else 1.0 - height
    gum_line = 0.56 + 0.10 * np.sqrt(np.clip(to_gap / half, 0, 1)) - 0.02 * number
    enamel = ENAMEL * (1.0 + 0.03 * noise(p, 5, seed) + 0.02 * noise(p, 1.2, seed + 1))[:, None]
    enamel = enamel * (1.0 - 0.04 * number)[:, None]
    enamel = enamel * (1 - 0.06 * step(height, 0.2, 0.6)[:, None] * [0, 0.6, 1.6])
    enamel = mix(enamel, enamel * [0.62, 0.52, 0.48], 0.85 * step(to_gap, 0.5, 0.08))
    gum = toned(RED_BROWN, look.skin, GUM_SHARE) * (1.0 + 0.08 * noise(p, 3, seed + 2))[:, None]
    colour = mix(enamel, gum, step(height - gum_line, -0.03, 0.04))
    front = p[:, 2].max()
    return colour * depth_shade(p[:, 2], front - 5, front - 34, 0.38)[:, None]


def paint_tongue(at: Texels, chosen: np.ndarray, look: Look, seed: int) -> np.ndarray:
    """Return the colours of the tongue: dimmer than the lips, and nearly black at its root."""
    p = at.place[chosen]
    grain = layered(p, [7, 2.2, 1.0], [0.5, 0.6, 0.6], seed)
    groove = np.exp(-((p[:, 0] / 1.6) ** 2)) * step(p[:, 2], 88, 76)
    tone = toned(TONGUE_RED, look.lip, TONGUE_SHARE)
    tone = tone * np.exp(-np.outer(0.06 * grain + 0.28 * groove, [0.7, 1.1, 1.0]))
    return tone * depth_shade(p[:, 2], p[:, 2].max() - 4, p[:, 2].max() - 46, 0.22)[:, None]


def paint_mouth(
    at: Texels, chosen: np.ndarray, lips: np.ndarray, look: Look, seed: int
) -> np.ndarray:
    """Return the colours of the inner mouth: dark behind the lips, nearly black at the back."""
    p = at.place[chosen]
    grain = layered(p, [9, 3, 1.2], [0.6, 0.6, 0.4], seed)
    cheek = toned(RED_BROWN, look.skin, CHEEK_SHARE)
    cheek = cheek * depth_shade(p[:, 2], 94, 54, 0.15)[:, None]
    tone = mix(cheek, 0.55 * srgb(look.lip), step(to_points(p, lips), 3.0, 0.0))
    return tone * np.exp(-np.outer(0.09 * grain, [0.7, 1.0, 1.0]))


def paint_eye(
    at: Texels, chosen: np.ndarray, centre: np.ndarray, look: Look, seed: int
) -> np.ndarray:
    """Return the colours of one eyeball that looks straight ahead."""
    p = at.place[chosen] - centre
    across = np.hypot(p[:, 0], p[:, 1])
    front = p[:, 2] > 0
    veins = np.clip(noise(p * [0.4, 1.6, 1], 1.6, seed), 0, None) * step(across, 6, 11)
    blood = np.outer(0.09 * veins + 0.12 * step(across, 7, 12.5), [0.2, 1, 0.9])
    white = np.array([0.86, 0.84, 0.81]) * np.exp(-blood)
    white = white * (1 - 0.28 * step(p[:, 1], 1.0, 6.5))[:, None]
    turn = np.arctan2(p[:, 1], p[:, 0])
    ring = np.stack([3.5 * np.cos(turn), 3.5 * np.sin(turn), across * 0.25], 1)
    spokes = noise(ring, 0.35, seed + 1)
    iris = srgb(look.iris) * np.exp(0.20 * spokes + 0.25 * step(across, 4.6, 2.4))[:, None]
    iris = mix(iris, iris * 0.35, step(across, IRIS_RADIUS - 1.5, IRIS_RADIUS - 0.2))
    iris = mix(iris, np.zeros(3) + 0.03, step(across, PUPIL_RADIUS + 0.25, PUPIL_RADIUS - 0.25))
    iris = iris * (1 - 0.30 * step(p[:, 1], 0.5, 5.5))[:, None]
    glint = np.exp(-((p[:, 0] + 1.5) ** 2 + (p[:, 1] - 1.9) ** 2) / 0.55)
    iris = mix(iris, np.array([0.93, 0.95, 0.97]), 0.8 * glint)
    return mix(white, iris, step(across, IRIS_RADIUS + 0.35, IRIS_RADIUS - 0.35) * front)


def paint(
    colour: np.ndarray, at: Texels, arrays: dict[str, np.ndarray], look: Look, seed: int
) -> None:
    """Paint over the texels of teeth, tongue, inner mouth and eyes, in place."""
    for kind in (sm.UPPER_TEETH, sm.LOWER_TEETH):
        chosen = at.kind == kind
        colour[chosen] = paint_teeth(at, chosen, kind, look, seed + kind)
    chosen = at.kind == sm.TONGUE
    colour[chosen] = paint_tongue(at, chosen, look, seed + 20)
    chosen = at.kind == sm.INNER_MOUTH
    lip_facets = np.isin(arrays["facet_class"], (sm.UPPER_LIP, sm.LOWER_LIP))
    lips = arrays["vertices"][np.unique(arrays["faces"][lip_facets])].astype(float)
    colour[chosen] = paint_mouth(at, chosen, lips, look, seed + 30)
    ball = np.unique(arrays["faces"][arrays["facet_class"] == sm.EYES])
    place = arrays["vertices"][ball].astype(float)
    for side in (-1, 1):
        points = place[np.sign(place[:, 0]) == side]
        centre = (points.min(0) + points.max(0)) / 2.0
        chosen = (at.kind == sm.EYES) & (np.sign(at.place[:, 0]) == side)
        colour[chosen] = paint_eye(at, chosen, centre, look, seed + 40)
