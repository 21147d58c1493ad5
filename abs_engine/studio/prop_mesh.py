"""Meshes of a hand and of a microphone, made from simple solids.

Both in mm, in a frame whose axes are the head's when the prop is not turned: x to the subject's
left, y up, z away from the face.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import map_coordinates
from skimage.measure import marching_cubes

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import vertex_normals

Colour = tuple[int, int, int]

_GRID = 3.0  # mm between the points at which the hand's surface is looked for
_SLEEVE_FROM = -118.0  # mm, where the cuff covers the wrist
_CLOTH = (46, 54, 74)

# Fingers of a flat right hand, palm towards the face, as seen by the camera that films the face:
# knuckle (x, y, z), lengths of three phalanges (mm), radii at both ends (mm), spread (degrees).
_FINGERS = (
    ((6.0, 31.0, 1.0), (42.0, 25.0, 20.0), (9.6, 7.2), 5.0),
    ((10.0, 11.0, 3.0), (46.0, 29.0, 21.0), (9.8, 7.4), 1.0),
    ((6.0, -9.0, 2.0), (42.0, 27.0, 21.0), (9.2, 7.0), -4.0),
    ((-3.0, -28.0, -1.0), (33.0, 20.0, 18.0), (8.2, 6.2), -11.0),
)
_FLEX = (8.0, 12.0, 9.0)  # degrees by which each phalanx bends towards the face
_WRIST = (-92.0, 0.0, 0.0)
_THUMB = ((-78.0, 24.0, -4.0), (-40.0, 50.0, -10.0), (-8.0, 62.0, -12.0), (16.0, 66.0, -15.0))
_THUMB_RADII = (14.0, 11.5, 10.0, 8.2)


@dataclass(frozen=True, eq=False)
class Prop:
    """A coloured mesh.

    Parameters
    ----------
    vertices : (N, 3) float32, mm
    faces : (M, 3) int32, counter-clockwise from outside
    normals : (N, 3) float32, unit length
    colours : (N, 3) uint8, sRGB
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32]
    colours: NDArray[np.uint8]


@dataclass(frozen=True)
class _Limb:
    """A rod with round ends whose radius changes evenly."""

    start: FloatArray
    end: FloatArray
    radii: tuple[float, float]

    def distance(self, points: FloatArray) -> FloatArray:
        """Signed distance (...) of points (..., 3), nearly; below zero inside."""
        along = self.end - self.start
        share = np.clip((points - self.start) @ along / (along @ along), 0, 1)
        radius = self.radii[0] + share * (self.radii[1] - self.radii[0])
        return np.asarray(
            np.linalg.norm(points - self.start - share[..., None] * along, axis=-1) - radius
        )


@lru_cache(maxsize=4)
def hand(skin: Colour) -> Prop:
    """A right hand with its forearm in a sleeve, palm towards the face, fingers to the left.

    The origin lies in the palm at the knuckles. The surface is the zero level of the smoothed
    union of tapered rods, one for each bone.
    """
    thumb = zip(_THUMB, _THUMB[1:], _THUMB_RADII, _THUMB_RADII[1:], strict=False)
    fingers = _finger_limbs()
    rest = [_limb(np.add(_WRIST, (4, 0.42 * at[1], 0)), at, 14.0, 11.5) for at, *_ in _FINGERS]
    rest += [_limb(*joint) for joint in thumb]
    arm = [
        _limb(_WRIST, (-200, -4, 0), 23, 30),
        _limb((_SLEEVE_FROM - 20, -2, 0), (-200, -4, 0), 31, 37),
    ]
    low, high = np.array([-245.0, -52, -50]), np.array([125.0, 92, 50])
    shape = tuple(np.ceil((high - low) / _GRID).astype(int) + 1)
    points = low + _GRID * np.moveaxis(np.indices(shape), 0, -1)
    whole = _union([_union([f.distance(points) for f in bones], 2.0) for bones in fingers], 1.2)
    whole = _union([whole, _union([b.distance(points) for b in rest], 7.0)], 6.0)
    whole = np.minimum(_union([whole, arm[0].distance(points)], 10.0), arm[1].distance(points))
    at, faces, _, _ = marching_cubes(whole, 0.0)
    vertices = low + _GRID * at.astype(np.float64)
    faces = faces.astype(np.int32)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    if (a * np.cross(b, c)).sum() < 0:  # six times the volume
        faces = faces[:, ::-1]
    uphill = [map_coordinates(part, at.T, order=1) for part in np.gradient(whole)]
    normals = np.column_stack(uphill)
    return _prop(vertices, faces, normals, _hand_colours(vertices, fingers, skin))


def _limb(start: ArrayLike, end: ArrayLike, first: float, last: float) -> _Limb:
    return _Limb(np.asarray(start, np.float64), np.asarray(end, np.float64), (first, last))


def _finger_limbs() -> list[list[_Limb]]:
    """Three rods for each of four fingers."""
    out = []
    for knuckle, lengths, (thick, thin), spread in _FINGERS:
        at, bend, turn = np.array(knuckle), 0.0, np.radians(spread)
        radii, bones = np.linspace(thick, thin, 4), []
        for number, (length, flex) in enumerate(zip(lengths, _FLEX, strict=True)):
            bend += np.radians(flex)
            way = np.array([np.cos(bend) * np.cos(turn), np.sin(turn), -np.sin(bend)])
            bones.append(_limb(at, at + length * way, radii[number], radii[number + 1]))
            at = at + length * way
        out.append(bones)
    return out


def _union(distances: list[FloatArray], blend: float) -> FloatArray:
    """Union of solids by their distances, rounded where they meet within `blend` mm."""
    out = distances[0]
    for other in distances[1:]:
        near = np.clip(1 - np.abs(out - other) / blend, 0, 1)
        out = np.minimum(out, other) - near * near * blend / 4
    return out


def _hand_colours(vertices: FloatArray, fingers: list[list[_Limb]], skin: Colour) -> FloatArray:
    """Skin that is redder at tips and knuckles and darker between fingers; nails; a sleeve."""
    near = np.stack([np.min([b.distance(vertices) for b in bones], axis=0) for bones in fingers])
    between = np.exp(-np.diff(np.sort(near, axis=0)[:2], axis=0)[0] / 3.5) * (vertices[:, 0] > 4)
    shade, red = 1 - 0.35 * between, np.zeros(len(vertices))
    nail = np.zeros(len(vertices))
    for bones in fingers:
        tip = bones[-1].end
        red += 0.16 * np.exp(-((np.linalg.norm(vertices - tip, axis=1) / 11) ** 2))
        for bone in bones[:2]:  # creases over the joints, on the back of the hand
            back = vertices[:, 2] > bone.end[2]
            away = np.linalg.norm(vertices - bone.end, axis=1)
            red += 0.10 * back * np.exp(-((away / 10) ** 2))
        bed = np.add(tip, (-2.0, 0, bones[-1].radii[1]))
        offset = (vertices - bed) / [7.0, 4.6, 4.0]
        nail = np.maximum(nail, np.clip(1.6 - 1.6 * (offset**2).sum(axis=1), 0, 1))
    colour = np.array(skin) * shade[:, None] * (1 - red[:, None] * [0.15, 0.9, 0.8])
    pale = np.array(skin) * [1.02, 0.98, 1.0] + [10, 8, 8]
    colour += nail[:, None] * (pale - colour)
    return np.where(vertices[:, :1] < _SLEEVE_FROM, np.array(_CLOTH), colour)


@lru_cache(maxsize=4)
def microphone(body: Colour) -> Prop:
    """A hand microphone: a grille of 50 mm with a ring, on a tapered stick that hangs down.

    The origin is the middle of the ball.
    """
    from trimesh.creation import revolve  # slow to import

    turn = np.linspace(0, np.radians(152), 48)
    ball = np.column_stack([25 * np.sin(turn), 25 * np.cos(turn)])
    stick = [(14.5, -24.0), (18.5, -25), (18.5, -34), (17, -36), (15, -60), (11.5, -200), (0, -202)]
    profile = np.concatenate([ball, stick])
    made = revolve(profile[::-1], sections=64)
    x, y, z = np.asarray(made.vertices).T
    vertices = np.column_stack([x, z, -y])  # from trimesh's axis, z, to ours, y
    on_ball, on_ring = vertices[:, 1] > -24.5, vertices[:, 1] > -34.5
    metal = np.full((len(vertices), 3), 150.0)
    wires = np.rint(np.arctan2(x, y) * 32 / np.pi) + np.rint(np.degrees(np.arccos(
        np.clip(vertices[:, 1] / 25, -1, 1))) * 47 / 152)  # fmt: skip
    metal[wires % 2 == 0] = 78.0
    colour = np.where(on_ball[:, None], metal, np.where(on_ring[:, None], 176.0, np.array(body)))
    faces = np.asarray(made.faces, np.int32)
    return _prop(vertices, faces, vertex_normals(vertices, faces), colour)


def _prop(
    vertices: FloatArray, faces: NDArray[np.int32], normals: FloatArray, colours: FloatArray
) -> Prop:
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return Prop(
        vertices.astype(np.float32), np.ascontiguousarray(faces), normals.astype(np.float32),
        np.clip(np.rint(colours), 0, 255).astype(np.uint8),
    )  # fmt: skip
