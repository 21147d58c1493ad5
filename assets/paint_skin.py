"""Paint skin, lips, brows, lids, stubble, freckles and cropped hair.

Skin is coloured as pigment over a base tone: melanin and blood darken red, green and blue
by different amounts, and both vary over the face at several scales.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import speaker_mesh as sm
from paint_look import Look
from paint_maps import Texels, bump, dense, layered, noise, step, to_points

MELANIN = np.array([0.42, 0.62, 0.85])
BLOOD = np.array([0.04, 0.50, 0.42])
HAIRLINE = (
    (0, 98),
    (20, 100),
    (38, 92),
    (52, 60),
    (64, 36),
    (74, 22),
    (80, 4),
    (90, -2),
    (110, -8),
    (130, -22),
    (155, -34),
    (180, -38),
)  # (degrees from the front, height mm)


@dataclass(frozen=True)
class Marks:
    """Places on the average head that the painter steers by (mm)."""

    lip_border: np.ndarray
    contact: np.ndarray
    lids: np.ndarray
    eyes: np.ndarray
    ear_centre: np.ndarray

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> Marks:
        """Collect them from the head's arrays."""
        vertices = arrays["vertices"].astype(float)
        lids = vertices[lid_vertices(arrays)]
        upper = dense(vertices[arrays["inner_lip_upper"]], closed=False)
        lower = dense(vertices[arrays["inner_lip_lower"]], closed=False)
        return cls(
            dense(vertices[arrays["outer_lip"]], closed=True),
            np.vstack([upper, lower]),
            lids,
            vertices[arrays["eye_corners"]],
            np.array([74.0, 12.0, -2.0]),
        )


def lid_vertices(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Return the skin vertices of the lid margins, where the chart is cut around the eyes."""
    skin = arrays["faces"][arrays["facet_class"] == sm.SKIN]
    centre = arrays["uv"][skin].mean(1)
    socket = np.unique(arrays["weld"][skin[(centre[:, 1] > 0.905) & (centre[:, 0] > 0.715)]])
    face = np.unique(skin[centre[:, 1] < 0.71])
    return face[np.isin(arrays["weld"][face], socket)]


def mix(colour: np.ndarray, other: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Blend towards another colour by a share per texel."""
    return colour + share[:, None] * (other - colour)


def srgb(values: tuple[int, int, int]) -> np.ndarray:
    """Return a colour as fractions."""
    return np.array(values) / 255.0


def skin_tone(at: Texels, look: Look, seed: int) -> np.ndarray:
    """Return the bare skin: base tone, pigment, blood, and creases that are a little darker."""
    p = at.place
    blood = 0.042 * layered(p, [26, 11, 4.5, 1.8], [0.5, 0.6, 0.6, 0.6], seed)
    blood += look.flush * (
        0.26 * bump(p, (38, -2, 78), 20)
        + 0.22 * bump(p, (0, 3, 114), 13, False)
        + 0.16 * bump(p, (10, -1, 104), 8)
        + 0.10 * bump(p, (0, -58, 93), 15, False)
        + 0.35 * step(np.abs(p[:, 0]), 74, 82)
    )
    melanin = 0.030 * layered(p, [33, 14, 6, 2.6, 1.2], [0.5, 0.6, 0.6, 0.8, 1.0], seed + 100)
    melanin += 0.10 * bump(p, (30, 27, 82), 9) + 0.05 * bump(p, (30, 45, 82), 10)
    melanin += 0.05 * step(p[:, 1], -55, -85) + look.age * 0.03 * noise(p, 8, seed + 7)
    shade = 0.16 * np.clip(at.hollow, -0.3, 1) + 0.40 * bump(p, (22.8, -29.5, 93.5), 2.6)
    lines = np.clip(noise(p * [0.35, 1, 1], 3.2, seed + 9), 0, None) * step(p[:, 1], 52, 66)
    shade += look.age * 0.05 * lines
    density = (
        np.outer(melanin, MELANIN) + np.outer(blood, BLOOD) + shade[:, None] * [0.8, 1.0, 1.05]
    )
    return srgb(look.skin) * np.exp(-density)


def add_pores(colour: np.ndarray, at: Texels, seed: int) -> np.ndarray:
    """Add the finest grain: pores of the nose and cheeks, and a soft mottle elsewhere."""
    grain = noise(at.place, 0.75, seed) + 0.7 * noise(at.place, 0.45, seed + 3)
    strength = (
        0.012
        + 0.02 * bump(at.place, (0, 5, 108), 22, False)
        + 0.014 * bump(at.place, (35, 5, 80), 26)
    )
    return colour * (1.0 - np.clip(strength * grain, -0.1, 0.1))[:, None]


def scatter(at: Texels, chance: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Draw texels at random by the given chances; return their places."""
    rng = np.random.default_rng(seed)
    chosen = rng.choice(len(chance), size=count, p=chance / chance.sum())
    return at.place[chosen]


def add_freckles(colour: np.ndarray, at: Texels, amount: float, seed: int) -> np.ndarray:
    """Add freckles over nose and cheeks."""
    p = at.place
    chance = bump(p, (0, 12, 104), 22, False) + bump(p, (34, 8, 82), 20)
    chance = chance + 0.05 * bump(p, (0, 70, 95), 40, False)
    chance = chance * ((at.kind == sm.SKIN) & (at.rows < 0.7 * at.size))
    share = np.zeros(len(p))
    for i, (radius, strength) in enumerate(((0.5, 0.35), (0.75, 0.3), (1.05, 0.25))):
        distance = to_points(p, scatter(at, chance, 260 - 70 * i, seed + i))
        share = np.maximum(share, strength * step(distance, 1.3 * radius, 0.4 * radius))
    return colour * np.exp(-amount * share[:, None] * MELANIN * 1.2)


def add_stubble(
    colour: np.ndarray, at: Texels, lip_distance: np.ndarray, look: Look, seed: int
) -> np.ndarray:
    """Darken the beard's region, with single hairs."""
    p = at.place
    x = np.abs(p[:, 0])
    top = np.interp(x, [0, 20, 34, 50, 66, 80], [-6, -12, -34, -36, -12, 10])
    region = step(top - p[:, 1], 0, 9) * step(p[:, 1], -88, -66) * step(p[:, 2], 2, 22)
    region *= step(lip_distance, 0.8, 4.0) * (1 - 0.5 * bump(p, (0, -46, 100), 6, False))
    hairs = scatter(at, region * (at.kind == sm.SKIN) + 1e-9, 9000, seed)
    dots = step(to_points(p, hairs), 0.45, 0.12)
    share = look.stubble * region * (0.22 + 0.04 * noise(p, 5, seed + 1) + 0.34 * dots)
    return mix(
        colour, 0.42 * srgb(look.hair) + 0.38 * colour * [0.90, 0.95, 1.04], np.clip(share, 0, 0.85)
    )


def add_lips(
    colour: np.ndarray, at: Texels, marks: Marks, look: Look, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Paint the vermilion, with its edge on the border of the lip facets.

    Returns
    -------
    colour : (T, 3) float64
    outside : (T,) float64
        Distance to the vermilion border, mm, negative on the lips.
    """
    p = at.place
    lip = np.isin(at.kind, (sm.UPPER_LIP, sm.LOWER_LIP))
    outside = np.where(lip, -1.0, 1.0) * to_points(p, marks.lip_border)
    contact = to_points(p, marks.contact)
    creases = noise(p * [1, 0.16, 0.12], 0.8, seed) + 0.7 * noise(p * [1, 0.2, 0.15], 1.7, seed + 1)
    density = 0.026 * creases + 0.035 * layered(p, [6, 2, 1], [1, 0.7, 0.5], seed + 2)
    density += 0.34 * step(contact, 2.6, 0.0) - 0.06 * step(-outside, 2.5, 0.3)
    density += 0.07 * (at.kind == sm.UPPER_LIP) + 0.2 * step(at.place[:, 2], 92, 84)
    tone = srgb(look.lip) * np.exp(-np.outer(density, [0.75, 1.05, 1.0]))
    edge = step(-outside + 0.08 * noise(p, 1.6, seed + 5), -0.45, 0.45)
    colour = mix(
        colour, 0.35 * tone + 0.65 * colour, 0.35 * step(outside, 2.5, 0.0) * (at.kind == sm.SKIN)
    )
    return mix(colour, tone, np.where(np.abs(outside) < 3, edge, lip * 1.0)), outside


def brow_hairs(look: Look, seed: int) -> np.ndarray:
    """Return points (x, y) along the hairs of both brows, mm."""
    rng = np.random.default_rng(seed)
    along = np.repeat(rng.uniform(0, 1, int(62 * look.brow)), 2)
    side = np.tile([-1.0, 1.0], len(along) // 2)
    taper = np.interp(along, [0, 0.12, 0.55, 1], [0.75, 1, 0.85, 0.15])
    x = 13 + 37 * along
    y = 47.5 + 6.5 * np.sin(np.pi * np.clip(along * 0.85 + 0.02, 0, 1)) - 5.0 * along**2
    y = y + rng.uniform(-0.5, 0.5, len(along)) * look.brow * 1.15 * taper
    angle = np.interp(along, [0, 0.25, 0.6, 1], [1.25, 0.75, 0.2, -0.35]) + rng.normal(
        0, 0.16, len(along)
    )
    t = np.linspace(0, 1, 9)[None] * (3.4 * taper + 1.0)[:, None]
    px = side[:, None] * (x[:, None] + t * np.cos(angle)[:, None])
    py = y[:, None] - 1.0 + t * np.sin(angle)[:, None] - 0.05 * t**2
    return np.stack([px, py], 2).reshape(-1, 2)


def add_brows(colour: np.ndarray, at: Texels, look: Look, seed: int) -> np.ndarray:
    """Paint the brows hair by hair, over a soft shade."""
    p = at.place
    front = (p[:, 2] > 45) & (p[:, 1] > 36) & (p[:, 1] < 64) & (at.kind == sm.SKIN)
    front &= at.rows < 0.7 * at.size
    hairs = brow_hairs(look, seed)
    distance = np.full(len(p), 9.0)
    distance[front] = to_points(p[front, :2], hairs)
    soft = 0.26 * step(distance, 1.7, 0.2)
    tone = srgb(look.hair) * 0.85
    return mix(mix(colour, tone, soft), tone, 0.55 * step(distance, 0.40, 0.1))


def add_lids(colour: np.ndarray, at: Texels, marks: Marks, look: Look) -> np.ndarray:
    """Paint lashes as a dark margin on the upper lid and a faint one on the lower."""
    face = (at.kind == sm.SKIN) & (at.rows < 0.7 * at.size)
    distance = np.full(len(at.place), 9.0)
    distance[face] = to_points(at.place[face], marks.lids)
    middle = np.interp(np.abs(at.place[:, 0]), [19, 41], [36.3, 37.3])
    upper = step(at.place[:, 1] - middle, -0.5, 1.0)
    rosy = mix(colour, colour * [0.92, 0.74, 0.72], 0.6 * step(distance, 3.0, 0.3))
    dark = look.lashes * (0.25 + 0.75 * upper) * step(distance, 1.5, 0.5)
    return mix(rosy, srgb(look.hair) * 0.35, dark)


def add_hair(colour: np.ndarray, at: Texels, marks: Marks, look: Look, seed: int) -> np.ndarray:
    """Paint cropped hair on the skull, leaving out face, neck and ears."""
    p = at.place
    azimuth = np.degrees(np.arctan2(np.abs(p[:, 0]), p[:, 2] + 8.0))
    line = np.interp(azimuth, *np.array(HAIRLINE, float).T)
    line = line + look.bald * np.interp(azimuth, [0, 25, 60, 90], [1.0, 1.6, 0.6, 0])
    ragged = p[:, 1] - line + 2.5 * noise(p, 7, seed) + 1.6 * noise(p, 1.8, seed + 1)
    ear = step(np.abs(p[:, 0]), 71.5, 73.5) * step(np.abs(p[:, 1] - 8), 46, 38)
    ear = ear * step(np.abs(p[:, 2]), 34, 28)
    ear = np.maximum(
        ear, step(np.linalg.norm(np.abs(p) - [68, 3, 2], axis=1), 20, 15) * (p[:, 2] > -14)
    )
    region = step(ragged, -3.0, 6.0) * (1 - ear) * (at.kind == sm.SKIN)
    strands = noise(p * [1, 0.25, 1], 0.9, seed + 2) + 0.8 * noise(p * [1, 0.25, 1], 2.1, seed + 3)
    thin = 1.0 - 0.5 * (look.bald > 0) * step(p[:, 1], 105, 130)
    tone = srgb(look.hair) * np.exp(0.11 * strands)[:, None]
    share = region * thin * np.clip(0.86 + 0.10 * strands, 0, 1)
    return mix(colour, tone, share)


def add_nostrils(colour: np.ndarray, at: Texels) -> np.ndarray:
    """Darken the insides of the nostrils."""
    p = at.place
    inside = bump(p, (6.5, -3.0, 98), 4.2) * step(at.hollow, 0.15, 0.55)
    return mix(
        colour, colour * [0.30, 0.20, 0.19], np.clip(1.2 * inside, 0, 0.95) * (at.kind == sm.SKIN)
    )


def paint(at: Texels, marks: Marks, look: Look, seed: int) -> np.ndarray:
    """Return the (T, 3) colours of everything on the outside of one person."""
    colour = add_pores(skin_tone(at, look, seed), at, seed + 20)
    if look.freckles:
        colour = add_freckles(colour, at, look.freckles, seed + 40)
    colour = add_nostrils(colour, at)
    colour, outside = add_lips(colour, at, marks, look, seed + 60)
    if look.stubble:
        colour = add_stubble(colour, at, outside, look, seed + 80)
    colour = add_brows(colour, at, look, seed + 120)
    colour = add_lids(colour, at, marks, look)
    colour = add_hair(colour, at, marks, look, seed + 140)
    socket = (at.kind == sm.SKIN) & (at.rows > 0.7 * at.size) & (at.columns > 0.71 * at.size)
    colour[socket] = colour[socket] * [0.85, 0.62, 0.60]
    return colour
