"""Make ``speaker/points.json``: the frozen vertex lists that metrics and labels use.

Usage: ``python assets/speaker_points.py [SPEAKER_FOLDER]``. Everything is found on the average head
of ``head.npz``, on its right side (x < 0), and mirrored. mm, head frame.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import speaker_mesh as sm
from scipy.spatial import cKDTree
from speaker_marks import eyelid_loop

FORMAT, VERSION = "abs_engine.points", 2
"""Version 2: points 60 and 64 of `landmark_68`, the inner corners, lie where they are seen."""

BROW = ((52.0, 45.5), (45.0, 48.5), (33.0, 52.0), (25.0, 52.0), (14.0, 48.5))
"""(-x, y) of points 17 to 21, on the painted brow, outer end first."""

JAW_SIDE = ((31.0, 23.0), (15.0, 30.0), (2.0, 30.0), (-14.0, 30.0), (-31.0, 33.0))
"""(y, z) of points 0 to 4: from the level of the eyes down in front of the ear."""

JAW_BORDER = ((75.0, 35.0), (50.0, 35.0), (20.0, 50.0), (0.0, 50.0))
"""Points 5 to 8: azimuth about the vertical line x = 0, z = 45, and direction, degrees down from
level, in which the border of the jaw is the outermost point of the section."""

BRIDGE = (36.1, 25.7, 12.9)
"""y of points 27 to 29 in the middle plane; 30 is the tip of the nose."""

WING, NOSTRIL, BELOW = (-13.8, -5.0, 98.2), (-6.5, -6.0, 103.4), (0.0, -7.7, 105.7)
"""Points 31 to 33: where the wing meets the lip, under the nostril, under the septum."""

UPPER_RIM, LOWER_RIM = 3, 2
"""Rings of vertices out from the edge of the eye socket that are the rims of the lids."""

HAIRLINE = ((31.0, -66.0), (60.0, -60.0), (85.0, -48.0), (100.0, -30.0), (104.0, 0.0))
"""(y, x) of the upper border of `face`, from the temple to the middle of the forehead."""

SPACING = {"face": 4.0, "lips": 1.5, "jaw": 3.0}
JAW_SHARE = 0.5

DESCRIPTIONS = {
    "landmark_68": "the 68 points of the iBUG 300-W scheme in its order (Sagonas et al. 2016): jaw "
    "line 0-16, brows 17-26, nose 27-35, eyes 36-47, outer lip 48-59, inner lip 60-67; the "
    "subject's right first",
    "face": "skin and lips inside of the jaw line and below the hairline, without ears, neck, eyes "
    "and nostrils; thinned to 4 mm",
    "lips": "upper and lower vermilion up to the seam inside the mouth; thinned to 1.5 mm",
    "jaw": "skin of the face, without lips, that jawOpen moves by at least half of its largest "
    "displacement; thinned to 3 mm",
}


class Head(SimpleNamespace):
    """The arrays of ``head.npz`` as attributes."""

    @property
    def skin(self) -> np.ndarray:
        """Vertices of the face's own skin, without the walls of the eye sockets."""
        of_face = (self.facet_class == sm.SKIN) & (self.uv[self.faces][..., 1].mean(1) < 0.71)
        return np.unique(self.faces[of_face])

    def nearest(self, place: tuple[float, ...], axes: list[int], among: np.ndarray) -> int:
        """Return the vertex among some that is nearest to a place, along some axes."""
        away = np.linalg.norm(self.vertices[among][:, axes] - place, axis=1)
        return int(among[away.argmin()])

    def mirrored(self, chosen: list[int]) -> list[int]:
        """Return the counterparts of vertices on the other side of the head."""
        other = self.vertices[chosen] * [-1, 1, 1]
        return [int(self.skin[k]) for k in cKDTree(self.vertices[self.skin]).query(other)[1]]


def jaw_line(head: Head) -> list[int]:
    """Return points 0 to 8."""
    skin, place = head.skin, head.vertices
    side = skin[(place[skin, 0] < -40) & (place[skin, 2] > 20)]
    points = [head.nearest(at, [1, 2], side) for at in JAW_SIDE]
    radius = np.hypot(place[:, 0], place[:, 2] - 45)
    azimuth = np.degrees(np.arctan2(-place[:, 0], place[:, 2] - 45))
    low = skin[(place[skin, 1] < -35) & (place[skin, 1] > -75)]
    for at, down in JAW_BORDER:
        near = low[np.abs(azimuth[low] - at) < (5 if at else 0.1)]
        outward = np.cos(np.radians(down)) * radius - np.sin(np.radians(down)) * place[:, 1]
        points.append(int(near[outward[near].argmax()]))
    return points


def both_sides(head: Head, right: list[int]) -> list[int]:
    """Return points that run from the right side to the middle, and on to the left side.

    The last one given is the middle.
    """
    return [*right, *head.mirrored(right[-2::-1])]


def eye(head: Head) -> list[int]:
    """Return points 36 to 41 on the rims of the lids."""
    rings = lid_rings(head)
    low, high = rings[LOWER_RIM], rings[UPPER_RIM]
    place = head.vertices
    outer = low[place[low, 0].argmin()]
    inner = low[place[low, 0].argmax()]
    a, b = place[outer], place[inner]

    def at(ring: np.ndarray, share: float, up: int) -> int:
        level = np.interp(place[ring, 0], [a[0], b[0]], [a[1], b[1]])
        half = ring[np.sign(place[ring, 1] - level) == up]
        return head.nearest((a[0] + share * (b[0] - a[0]),), [0], half)

    upper = [at(high, 1 / 3, 1), at(high, 2 / 3, 1)]
    lower = [at(low, 2 / 3, -1), at(low, 1 / 3, -1)]
    return [int(outer), *upper, int(inner), *lower]


def lid_rings(head: Head) -> list[np.ndarray]:
    """Return rings of vertices around the right eye; the first is where the socket begins."""
    of_face = (head.facet_class == sm.SKIN) & (head.uv[head.faces][..., 1].mean(1) < 0.71)
    faces = head.faces[of_face]
    rings = [np.unique(eyelid_loop(head, -1))]
    for _ in range(UPPER_RIM):
        touching = np.unique(faces[np.isin(faces, rings[-1]).any(1)])
        rings.append(np.setdiff1d(touching, np.concatenate(rings)))
    return rings


def landmark_68(head: Head) -> list[int]:
    """Return the 68 points."""
    skin, place = head.skin, head.vertices
    front = skin[place[skin, 2] > 45]
    middle = front[np.abs(place[front, 0]) < 0.05]
    brow = [head.nearest((-x, y), [0, 1], front) for x, y in BROW]
    bridge = [head.nearest((y,), [1], middle[place[middle, 1] > 5]) for y in BRIDGE]
    base = [head.nearest(at, [0, 1, 2], front) for at in (WING, NOSTRIL, BELOW)]
    right = eye(head)
    left = head.mirrored(right)
    return [
        *both_sides(head, jaw_line(head)),
        *brow,
        *head.mirrored(brow[::-1]),
        *bridge,
        int(head.nose_tip),
        *both_sides(head, base),
        *right,
        *(left[k] for k in (3, 2, 1, 0, 5, 4)),
        *head.outer_lip_20.tolist(),
        *head.inner_lip_8.tolist(),
    ]


def within(head: Head, vertices: np.ndarray, jaw: list[int]) -> np.ndarray:
    """Choose vertices inside the jaw line and below the hairline, seen around a vertical axis."""
    border = head.vertices[jaw]
    angle = np.degrees(np.arctan2(-border[:, 0], border[:, 2] - 20))
    at = head.vertices[vertices]
    azimuth = np.degrees(np.arctan2(np.abs(at[:, 0]), at[:, 2] - 20))
    lowest = np.interp(azimuth, angle[::-1], border[::-1, 1])
    heights, sides = zip(*HAIRLINE, strict=True)
    edge = -np.interp(at[:, 1], heights, sides)
    upper = np.where(at[:, 1] > HAIRLINE[0][0], np.abs(at[:, 0]) <= edge, azimuth <= angle[0])
    return vertices[(at[:, 1] >= lowest) & upper & (at[:, 1] < HAIRLINE[-1][0]) & (at[:, 2] > 20)]


def outside_nostrils(head: Head, vertices: np.ndarray) -> np.ndarray:
    """Leave out vertices around which the skin faces backwards or straight up into the nose."""
    a, b, c = (head.vertices[head.faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    normal = np.zeros_like(head.vertices)
    for corner in range(3):
        np.add.at(normal, head.faces[:, corner], cross)
    welded = np.zeros_like(normal)
    np.add.at(welded, head.weld, normal)
    normal = welded[head.weld] / np.linalg.norm(welded[head.weld], axis=1, keepdims=True)
    at, to = head.vertices[vertices], normal[vertices]
    nose = (np.abs(at[:, 0]) < 14) & (at[:, 1] > -6) & (at[:, 1] < 3)
    return vertices[~(nose & ((to[:, 2] < 0.1) | (to[:, 1] < -0.75)))]


def thinned(head: Head, vertices: np.ndarray, spacing: float) -> list[int]:
    """Choose vertices no two of which are closer than `spacing`, alike on both sides."""
    right = vertices[head.vertices[vertices, 0] < 0.05]
    chosen: list[int] = []
    for k in right[np.lexsort((head.vertices[right, 1], -head.vertices[right, 0]))].tolist():
        here = head.vertices[k]
        if -spacing / 2 < here[0] < -0.05:
            continue  # its mirror image would be too near
        if not chosen or np.linalg.norm(head.vertices[chosen] - here, axis=1).min() >= spacing:
            chosen.append(k)
    off = [k for k in chosen if head.vertices[k, 0] < -0.05]
    tree = cKDTree(head.vertices[vertices])
    other = vertices[tree.query(head.vertices[off] * [-1, 1, 1])[1]]
    return sorted({*chosen, *other.tolist()})


def areas(head: Head, jaw: list[int]) -> dict[str, list[int]]:
    """Return the lists `face`, `lips` and `jaw`."""
    of_lips = np.isin(head.facet_class, (sm.UPPER_LIP, sm.LOWER_LIP))
    lips = np.unique(head.faces[of_lips])
    skin = np.setdiff1d(head.skin, lips)
    skin = outside_nostrils(head, within(head, skin, jaw))
    opened = head.units[head.unit_names.tolist().index("jawOpen")].astype(float)
    moved = np.linalg.norm(opened, axis=1)
    low = skin[moved[skin] >= JAW_SHARE * moved[skin].max()]
    whole = {"face": np.union1d(skin, lips), "lips": lips, "jaw": low}
    return {name: thinned(head, chosen, SPACING[name]) for name, chosen in whole.items()}


def main(folder: Path) -> None:
    """Read ``head.npz`` and write ``points.json`` beside it."""
    with np.load(folder / "head.npz", allow_pickle=False) as data:
        head = Head(**{name: data[name] for name in data.files})
    head.vertices = head.vertices.astype(np.float64)
    marks = landmark_68(head)
    lists = {"landmark_68": marks, **areas(head, marks[:9])}
    told = {
        "format": FORMAT,
        "version": VERSION,
        "vertices": len(head.vertices),
        "faces": len(head.faces),
        "lists": {
            name: {"description": DESCRIPTIONS[name], "vertices": indices}
            for name, indices in lists.items()
        },
    }
    (folder / "points.json").write_text(json.dumps(told) + "\n", encoding="utf-8")
    print(", ".join(f"{name} {len(indices)}" for name, indices in lists.items()))


if __name__ == "__main__":
    default = Path(__file__).resolve().parent / "speaker"
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else default)
