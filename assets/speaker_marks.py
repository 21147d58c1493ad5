"""Landmarks of the head, as vertex indices found from the mesh's own structure."""

from __future__ import annotations

import numpy as np
import speaker_mesh as sm
from speaker_mesh import CONTACT_RING, Head

CORNER_RING, CORNER_SPOKE = CONTACT_RING - 4, 5
"""Place of the points 60 and 64 in the lip grid: ring, and spokes from the corner on the upper lip.

There the rim of the red is seen from the front in all seven heads, closed or open: at rest 0.5 mm
from the line where the lips meet, with a dropped jaw 1.5 to 1.7 mm from the corner of the opening
(means). The ends of the contact ring lie in the fold of the corner, 1 to 6 mm behind what is seen.
"""


def lip_marks(head: Head) -> dict[str, np.ndarray]:
    """Return the lip landmarks.

    Notes
    -----
    Outer points follow the vermilion border (with its taper at the corners); inner ones are the
    ring of the lip grid on which the closed lips touch, but for the inner corners, which lie where
    they are seen (`CORNER_RING`). Twelve outer and eight inner points are numbered like 48 to 67 of
    the 68 points: the right corner first, along the upper lip.
    """
    grid, left = head.lips.vertices, head.lips.left
    spokes = np.arange(grid.shape[1])
    outer = grid[head.border, spokes]
    contact = grid[CONTACT_RING]
    upper = contact[: left + 1]
    lower = np.concatenate([contact[:1], contact[: left - 1 : -1]])
    corners = grid[CORNER_RING, [CORNER_SPOKE, left - CORNER_SPOKE]]
    return {
        "outer_lip": outer,
        "inner_lip_upper": upper,
        "inner_lip_lower": lower,
        "outer_lip_20": outer_twelve(head, outer),
        "inner_lip_8": inner_eight(head, upper, lower, corners),
        "mouth_corners": np.array([outer[0], outer[left]]),
    }


def pick_x(head: Head, candidates: np.ndarray, x: float) -> int:
    """Return the candidate whose x (mm, to the subject's left) is nearest."""
    return int(candidates[np.abs(head.vertices[candidates, 0] - x).argmin()])


def outer_twelve(head: Head, outer: np.ndarray) -> np.ndarray:
    """Pick the points 48 to 59: corners, cupid's bow, and points between."""
    left = head.lips.left
    upper, lower = outer[1:left], outer[left + 1 :]
    half = head.vertices[outer[left], 0]
    y = head.vertices[upper, 1]
    right_side = head.vertices[upper, 0] < -0.5
    peak = -head.vertices[upper[right_side][y[right_side].argmax()], 0]
    top = [pick_x(head, upper, x) for x in (-0.62 * half, -peak, 0.0, peak, 0.62 * half)]
    bottom = [
        pick_x(head, lower, x) for x in (0.65 * half, 0.3 * half, 0.0, -0.3 * half, -0.65 * half)
    ]
    return np.array([outer[0], *top, outer[left], *bottom])


def inner_eight(
    head: Head, upper: np.ndarray, lower: np.ndarray, corners: np.ndarray
) -> np.ndarray:
    """Pick the points 60 to 67: the corners, and on the line of contact those between."""
    half = head.vertices[upper[-1], 0]
    top = [pick_x(head, upper, x) for x in (-0.4 * half, 0.0, 0.4 * half)]
    bottom = [pick_x(head, lower, x) for x in (0.4 * half, 0.0, -0.4 * half)]
    return np.array([corners[0], *top, corners[1], *bottom])


def eyelid_loop(head: Head, side: int) -> np.ndarray:
    """Return the vertices where the face meets the eye socket, on one side (sign of x)."""
    skin = head.facet_class == sm.SKIN
    across, top = head.uv[head.faces].mean(1).T
    socket = np.unique(head.weld[head.faces[skin & (top > 0.90) & (across > 0.71)]])
    face = np.unique(head.faces[skin & (top < 0.71)])
    loop = face[np.isin(head.weld[face], socket)]
    return loop[np.sign(head.vertices[loop, 0]) == side]


def eye_points(head: Head, side: int) -> list[int]:
    """Return six points of an eye: outer corner, upper lid twice, inner corner, lower lid twice."""
    loop = eyelid_loop(head, side)
    place = head.vertices[loop]
    order = np.abs(place[:, 0]).argsort()
    inner, outer = loop[order[0]], loop[order[-1]]
    a, b = head.vertices[inner], head.vertices[outer]
    level = a[1] + (place[:, 0] - a[0]) / (b[0] - a[0]) * (b[1] - a[1])
    upper, lower = loop[place[:, 1] > level], loop[place[:, 1] < level]
    at = [a[0] + t * (b[0] - a[0]) for t in (2 / 3, 1 / 3)]
    return [
        int(outer),
        pick_x(head, upper, at[0]),
        pick_x(head, upper, at[1]),
        int(inner),
        pick_x(head, lower, at[1]),
        pick_x(head, lower, at[0]),
    ]


def midline(head: Head) -> np.ndarray:
    """Return the outer skin vertices in the plane x = 0, on the front of the head."""
    skin = np.unique(head.faces[head.facet_class == sm.SKIN])
    return skin[(np.abs(head.vertices[skin, 0]) < 0.05) & (head.vertices[skin, 2] > 40)]


def face_marks(head: Head) -> dict[str, np.ndarray]:
    """Return nose tip, chin (gnathion) and eye corners (right outer, inner, left inner, outer)."""
    middle = midline(head)
    place = head.vertices[middle]
    mouth = head.vertices[head.lips.vertices[0, 0]]
    nose = middle[place[:, 2].argmax()]
    low = place[:, 1] < mouth[1] - 15
    chin = middle[low][(place[low, 2] - place[low, 1]).argmax()]
    right, left = eye_points(head, -1), eye_points(head, 1)
    return {
        "nose_tip": np.array(nose),
        "chin": np.array(chin),
        "eye_corners": np.array([right[0], right[3], left[3], left[0]]),
    }


def landmarks(head: Head) -> dict[str, np.ndarray]:
    """Return all landmark lists as int32 arrays."""
    marks = {**lip_marks(head), **face_marks(head)}
    return {name: np.asarray(value, np.int32) for name, value in marks.items()}
