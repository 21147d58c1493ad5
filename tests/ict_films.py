"""Films heads of another topology (ICT-FaceKit), with the truth.

No model of ours knows the people. How people of this model differ, and how its face units move
them, is part of what is expected of anybody (`assets/population`).

Each film has another random person, skin, lip colour, light, camera and stretch of a recorded
face. Run it by hand: `python tests/ict_films.py OUT [--films 6] [--frames 75] [--seed 0]
[--size 640 480] [--clips 1] [--tremor]`. With more `--clips`, that many films in a row are of one
person, the last two of them by another camera in another, coloured light; with `--tremor` heads
tremble. It writes `film_K.mp4`, `camera_K.json`, the truth `film_K.npz` (see `truth`) and
`sheet.png`, a frame of each film with the lip contours drawn beside it. The data are looked for in
the folder that ABS_ENGINE_DATA names, or in `../shared/data` beside the checkout.

pyrender draws, so nothing here may import moderngl: two GL stacks in a process corrupt each other.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, gaussian_filter1d
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING
from abs_engine.dataset.camera_file import camera_json
from abs_engine.studio.worker import know_arguments
from abs_engine.tracking.detection.face_detection import find_face

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

MM = 10.0  # ICT's unit is the centimetre
FACE, SKIN, SOCKET, EYE_SOCKETS, GUMS = 9409, 11248, 13294, 14062, 17039  # where parts end
TEETH, EYES = (17039, 21451), ((21451, 22221), (23021, 23791))  # vertices, first and past last
DRAWN_FACES, EYE_FACES = 21496, ((21496, 22296), (23094, 23894))
TONES = {
    "very light": (244, 216, 200),
    "light": (229, 190, 165),
    "medium": (205, 158, 126),
    "olive": (176, 128, 94),
    "brown": (128, 86, 62),
    "dark": (84, 56, 44),
}
"""Skin, sRGB, from very light to very dark."""
CONTRASTS = {
    "pale": ((0.93, 0.86, 0.87), (0.96, 0.87, 0.88)),
    "natural": ((0.83, 0.66, 0.68), (0.88, 0.70, 0.71)),
    "rosy": ((0.84, 0.52, 0.56), (0.87, 0.56, 0.60)),
    "lipstick": ((0.80, 0.25, 0.32), (0.82, 0.27, 0.34)),
    "brownish": ((0.70, 0.55, 0.54), (0.82, 0.62, 0.60)),
    "even": ((0.88, 0.76, 0.77), (0.84, 0.68, 0.69)),
}
"""Upper and lower lip by the skin's colour, in each channel of sRGB."""
RECORDED_FROM = 2100
"""Before it the recording hardly moves (as in `abs_engine.papers.basu1998.motion`)."""
RECORDED_RATE = 30.0
DROWSY = 0.3
"""Blink weight of the recorded person's open eyes."""
REST_GAP = 0.2
"""Between the middles of the lips of everybody's neutral head, mm."""
LIP_UNITS = ("mouth", "jaw")
RESTING = 20.0
"""Percentile of a lip unit's weight that counts as the recorded person's rest, %."""
PUPIL = 2.4  # mm, radius of a painted pupil
TRIES = 40  # stretches of the recording among which each film takes the liveliest
MOVING = 1.0
"""Least standard deviation of the aperture in a stretch drawn by chance, mm; at most 15 count."""
UPPER_UNITS = ("brow", "eye", "nose", "cheekSquint")


def data_folder() -> Path:
    """Where the data are."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    return Path(os.environ.get("ABS_ENGINE_DATA", beside))


# What is known of ICT's head.


@dataclass(frozen=True, eq=False)
class Head:
    """ICT's head, in mm: x to the subject's left, y up, z out of the face.

    Parameters
    ----------
    neutral : (V, 3) float64
    identity : (100, V, 3) float32
    names : tuple of str
    expressions : (E, V, 3) float32
    quads : (F, 4) int64, the last -1 in triangles
    landmarks : (68,) int64
    """

    neutral: FloatArray
    identity: NDArray[np.float32]
    names: tuple[str, ...]
    expressions: NDArray[np.float32]
    quads: IntArray
    landmarks: IntArray

    def person(self, weights: FloatArray) -> FloatArray:
        """Neutral vertices (V, 3)."""
        return np.asarray(self.neutral + np.tensordot(weights, self.identity, 1), np.float64)


def load_head(folder: Path) -> Head:
    """Read `ict_face_model.npz` and make it millimetres."""
    data = np.load(folder / "ict_face_model.npz")
    return Head(
        data["neutral"].astype(np.float64) * MM,
        data["identity_deltas"] * np.float32(MM),
        tuple(map(str, data["expression_names"])),
        data["expression_deltas"] * np.float32(MM),
        data["faces"].astype(np.int64),
        data["landmarks68"].astype(np.int64),
    )


def triangles(quads: IntArray) -> IntArray:
    """Two triangles for each quad, one for each that lacks the fourth corner."""
    whole = quads[quads[:, 3] >= 0]
    return np.concatenate([quads[:, :3], whole[:, [0, 2, 3]]])


def edges_of(quads: IntArray) -> IntArray:
    """The edges (E, 2) of quads that have four corners."""
    return np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])


def path_through(head: Head, marks: IntArray) -> IntArray:
    """Vertices along the shortest way over the face through some of them, in order."""
    edges = edges_of(head.quads[:9230])
    length = np.linalg.norm(np.diff(head.neutral[edges], axis=1)[:, 0], axis=1)
    graph = csr_matrix((length, tuple(edges.T)), shape=(FACE, FACE))
    path = [int(marks[0])]
    for start, end in pairwise(marks):
        _, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
        leg = [int(end)]
        while before[leg[-1]] >= 0:
            leg.append(int(before[leg[-1]]))
        path += leg[-2::-1]
    return np.array(path)


def left_corner(rings: dict[str, IntArray]) -> int:
    """Where along the outer ring the left corner is."""
    return int(np.flatnonzero(rings["outer"] == rings["corners"][1])[0])


def lip_rings(head: Head) -> dict[str, IntArray]:
    """Contours of the lips as ordered vertices.

    `outer` is a closed loop from the right corner over the upper lip; `upper` and `lower` run
    along the inner lips from the right to the left; `corners` are right and left.
    """
    marks = head.landmarks
    outer = path_through(head, marks[[*range(48, 60), 48]])[:-1]
    upper = path_through(head, marks[60:65])
    lower = path_through(head, marks[[60, 67, 66, 65, 64]])
    return {"outer": outer, "upper": upper, "lower": lower, "corners": marks[[48, 54]]}


def smoothed(ring: FloatArray, half: int) -> FloatArray:
    """The outer contours (..., N, 3) without the mesh's steps; the painted lips end there.

    The corners, the points 0 and `half`, stay where they are.
    """
    out = np.array(ring, np.float64)
    for arc in (np.arange(half + 1), np.r_[half : ring.shape[-2], 0]):
        path = out[..., arc, :]
        soft = gaussian_filter1d(path, 2.0, axis=-2, mode="nearest")
        edge = np.minimum(1.0, np.minimum(np.arange(len(arc)), np.arange(len(arc))[::-1]) / 3)
        out[..., arc, :] = path + edge[:, None] * (soft - path)
    return out


def middle_profiles(head: Head) -> tuple[IntArray, IntArray]:
    """Vertices in the plane x = 0 of the upper and of the lower lip, where they may touch."""
    at = np.flatnonzero(np.abs(head.neutral[:FACE, 0]) < 1e-3)
    _, y, z = head.neutral[at].T
    inner = (z > 107) & (y > -40) & (y < -28)
    seam = head.neutral[head.landmarks[[62, 66]], 1].mean()
    return at[inner & (y > seam)], at[inner & (y < seam)]


def aperture_of(vertices: FloatArray, profiles: tuple[IntArray, IntArray]) -> FloatArray:
    """Height (T,) between the middles of the lips in (T, V, 3), mm, 0 where they touch."""
    upper, lower = profiles
    gap = vertices[:, upper, 1].min(axis=1) - vertices[:, lower, 1].max(axis=1)
    return np.maximum(0.0, gap)


def moved_lips(head: Head, person: FloatArray, weights: FloatArray) -> FloatArray:
    """Apertures (T,) of a person, mm."""
    upper, lower = middle_profiles(head)
    at = np.concatenate([upper, lower])
    path = person[at] + np.tensordot(weights, head.expressions[:, at].astype(np.float64), 1)
    own = np.arange(len(at))
    return aperture_of(path, (own[: len(upper)], own[len(upper) :]))


def with_closed_lips(head: Head, person: FloatArray) -> FloatArray:
    """A person (V, 3) whose jaw is shut so far that the lips just touch at rest."""
    jaw = head.expressions[head.names.index("jawOpen")].astype(np.float64)
    upper, lower = middle_profiles(head)
    at = np.linspace(-0.3, 0.3, 601)[:, None]
    gap = [(person[k] + at[..., None] * jaw[k])[..., 1] for k in (upper, lower)]
    rest = gap[0].min(axis=1) - gap[1].max(axis=1) - REST_GAP
    return person + at[np.argmin(np.abs(rest)), 0] * jaw


def eye_centres(person: FloatArray) -> FloatArray:
    """Centres (2, 3) of the spheres that fit the backs of the eyeballs, mm; the left eye first."""
    centres = []
    for first, end in EYES:
        ball = person[first:end]
        back = ball[ball[:, 2] < np.median(ball[:, 2])]
        system = np.c_[2 * back, np.ones(len(back))]
        centres.append(np.linalg.lstsq(system, (back**2).sum(axis=1), rcond=None)[0][:3])
    return np.array(centres)


def drawn_pupils(head: Head, person: FloatArray) -> FloatArray:
    """Middles (2, 3) of the painted pupils of a person who looks ahead, mm; the left eye first.

    Eyes are painted about the axis of the average head's eyeballs, and go with their vertices to
    each person. An eyeball's vertices lie closer together on one side of its pupil, so that their
    mean is not its middle.
    """
    found = []
    for centre, (first, end) in zip(eye_centres(head.neutral), EYES, strict=True):
        away = head.neutral[first:end].astype(np.float64) - centre
        front = np.flatnonzero((np.hypot(away[:, 0], away[:, 1]) < PUPIL) & (away[:, 2] > 0))
        mesh = Delaunay(away[front, :2])
        simplex = mesh.find_simplex(np.zeros(2))
        corners = front[mesh.simplices[simplex]]
        two = mesh.transform[simplex, :2] @ -mesh.transform[simplex, 2]
        found.append(np.r_[two, 1 - two.sum()] @ person[first:end][corners])
    return np.array(found)


# How it moves.


def recorded(path: Path, names: tuple[str, ...]) -> FloatArray:
    """Weights (T, E) of ICT's expressions in a recording of ARKit's units at 30 Hz."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        header, *rows = list(csv.reader(file))
    column = {name.lower(): k for k, name in enumerate(header)}
    values = np.array([[float(v) for v in row[1:]] for row in rows])
    out = np.zeros((len(rows), len(names)))
    for k, name in enumerate(names):
        wide = name.replace("_L", "Left").replace("_R", "Right").lower()
        both = name.split("_")[0].lower()  # ARKit has one of browInnerUp and cheekPuff
        found = column.get(wide, column.get(both))
        if found is not None:
            out[:, k] = values[:, found - 1]
        if name.startswith(LIP_UNITS):
            out[:, k] = np.maximum(0, out[:, k] - np.percentile(out[:, k], RESTING))
        elif name.startswith("eyeBlink"):  # the recorded person's eyes are half closed
            out[:, k] = np.clip((out[:, k] - DROWSY) / (1 - DROWSY), 0, 1)
        elif name.startswith("eyeLook"):
            out[:, k] *= 0.5
    return out


def stretch(
    weights: FloatArray, apertures: FloatArray, share: slice, time: FloatArray
) -> tuple[FloatArray, int]:
    """The liveliest stretch in a part of the recording, at given times, and where it starts.

    Of stretches that start in part `share.start` of `share.stop` equal ones: lively is where the
    average head's aperture (mm, each recorded frame) changes much and lips close at times.
    """
    at = time * RECORDED_RATE
    length = int(np.ceil(at[-1])) + 2
    room = len(weights) - length - RECORDED_FROM
    starts = RECORDED_FROM + (0.75 * np.arange(TRIES) / TRIES + share.start) * room / share.stop
    starts = starts.astype(int)
    seen = [apertures[s : s + length] for s in starts]
    closed = np.array([(a < 1.0).mean() for a in seen])
    lively = np.array([np.minimum(a, 15.0).std() for a in seen])
    start = int(starts[np.argmax(lively * np.sqrt(np.minimum(closed, 0.3) + 0.02))])
    return between(weights, start + at), start


def between(weights: FloatArray, at: FloatArray) -> FloatArray:
    """Weights (T, E) between recorded frames, at times (T,) in frames."""
    low, part = np.floor(at).astype(int), (at % 1.0)[:, None]
    return np.asarray((1 - part) * weights[low] + part * weights[low + 1])


def drawn_stretch(
    weights: FloatArray, apertures: FloatArray, rng: np.random.Generator, time: FloatArray
) -> tuple[FloatArray, int]:
    """A stretch in which the mouth moves, drawn by chance, and where it starts."""
    at = time * RECORDED_RATE
    length = int(np.ceil(at[-1])) + 2
    while True:
        start = int(rng.integers(RECORDED_FROM, len(weights) - length))
        if np.minimum(apertures[start : start + length], 15.0).std() > MOVING:
            return between(weights, start + at), start


def mirrored_units(names: Sequence[str]) -> IntArray:
    """For each expression, the same on the other side."""
    sides = {"_L": "_R", "_R": "_L", "Left": "Right", "Right": "Left"}
    other = {n: n.removesuffix(a) + b for n in names for a, b in sides.items() if n.endswith(a)}
    return np.array([names.index(other.get(n, n)) for n in names])


def performed(
    head: Head, weights: FloatArray, number: int, chosen: argparse.Namespace, time: FloatArray
) -> tuple[FloatArray, int]:
    """Weights (T, E) of a film of a number, and the first recorded frame of its mouth's motion."""
    apertures = moved_lips(head, with_closed_lips(head, head.neutral), weights)
    if chosen.motion == "lively":
        return stretch(weights, apertures, slice(number, chosen.films), time)
    rng = np.random.default_rng([chosen.seed, number, 3])
    mouth, start = drawn_stretch(weights, apertures, rng, time)
    if chosen.motion == "chance":
        return mouth, start
    upper = [n.startswith(UPPER_UNITS) for n in head.names]
    face = np.where(upper, drawn_stretch(weights, apertures, rng, time)[0], mouth)
    return face[:, mirrored_units(head.names)], start


def smooth_noise(rng: np.random.Generator, frames: int, rate: float, reach: float) -> FloatArray:
    """A slow motion (T,) that stays within `reach`: three waves of 3 to 8 seconds or so."""
    time = np.arange(frames) / rate
    waves = [
        np.sin(2 * np.pi * (time / rng.uniform(2.0, 7.0) + rng.uniform())) * share
        for share in (0.6, 0.3, 0.1)
    ]
    return np.asarray(reach * np.sum(waves, axis=0))


TREMOR = ((1.0, 6.0, 0), (0.7, 4.8, 1))
"""Of heads that tremble: degrees, Hz, and the axis of the head, x across it and y up."""


def trembling(frames: int, rate: float) -> FloatArray:
    """Rotation vectors (T, 3), radians, of a head that trembles as `TREMOR` says."""
    time, turns = np.arange(frames) / rate, np.zeros((frames, 3))
    for degrees, hertz, axis in TREMOR:
        turns[:, axis] = np.radians(degrees) * np.sin(2 * np.pi * hertz * time)
    return turns


def head_motion(
    rng: np.random.Generator, frames: int, rate: float, distance: float, tremor: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Rotations (T, 3, 3) and translations (T, 3) in mm from the head to the camera."""
    angles = [smooth_noise(rng, frames, rate, reach) for reach in (20.0, 10.0, 10.0)]
    turn = Rotation.from_euler("YXZ", np.stack(angles, axis=1), degrees=True).as_matrix()
    if tremor:
        turn = turn @ Rotation.from_rotvec(trembling(frames, rate)).as_matrix()
    shift = [smooth_noise(rng, frames, rate, reach) for reach in (20.0, 10.0, 25.0)]
    away = np.array([0.0, 0.0, distance])
    return FACING @ turn, away + np.stack(shift, axis=1)


# How it is painted.


@dataclass(frozen=True, eq=False)
class Drawn:
    """What is drawn of the head: its triangles, the face's and the eyes' each cut in four.

    Parameters
    ----------
    pairs : (N, 2) int64
        Each drawn vertex lies midway between two of the head's (often the same).
    matte, glossy : (F, 3) int64
        Triangles of drawn vertices.
    smoother : (N, N) sparse
        Means over each vertex and its neighbours.
    """

    pairs: IntArray
    matte: IntArray
    glossy: IntArray
    smoother: csr_matrix

    def at(self, vertices: FloatArray) -> FloatArray:
        """Places of the drawn vertices."""
        return np.asarray((vertices[self.pairs[:, 0]] + vertices[self.pairs[:, 1]]) / 2)


def cut_in_four(faces: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Triangles with new corners midway of their edges, numbered from `count`, and the edges."""
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    unique, index = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    ab, bc, ca = (index.reshape(-1, 3) + count).T
    a, b, c = faces.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(corner, axis=1) for corner in corners]), unique


def drawn_of(head: Head) -> Drawn:
    """The parts that are drawn: no lashes, tear fluid, nor the shells before the eyes."""
    count = len(head.neutral)
    face = triangles(head.quads[:9230])
    eyes = np.concatenate([triangles(head.quads[a:b]) for a, b in EYE_FACES])
    rest = triangles(head.quads[9230:17006])
    teeth = triangles(head.quads[17006:DRAWN_FACES])
    fine, middles = cut_in_four(np.concatenate([face, eyes]), count)
    pairs = np.concatenate([np.repeat(np.arange(count)[:, None], 2, axis=1), middles])
    faces = np.concatenate([fine, rest, teeth])
    shiny = np.zeros(len(faces), bool)
    old = pairs[faces[:, 0]][:, 0]
    shiny |= (old >= TEETH[0]) | ((old >= EYE_SOCKETS) & (old < GUMS))
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1], np.repeat(np.arange(len(pairs))[:, None], 2, 1)])
    near = coo_matrix((np.ones(len(edges)), tuple(edges.T)), (len(pairs), len(pairs))).tocsr()
    near.data[:] = 1.0
    weight = np.asarray(near.sum(axis=1)).ravel()
    return Drawn(pairs, faces[~shiny], faces[shiny], csr_matrix(near.multiply(1 / weight[:, None])))


def normals_of(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Unit normals (N, 3) at vertices; +z where there is no face."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    out = np.stack(
        [
            np.bincount(faces.ravel(), np.repeat(flat[:, k], 3), minlength=len(vertices))
            for k in range(3)
        ],
        axis=1,
    )
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return np.where(length > 0, out / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])


def step(value: FloatArray, low: float, high: float) -> FloatArray:
    """From 0 at `low` to 1 at `high`, smoothly."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t))


@dataclass(frozen=True, eq=False)
class Regions:
    """How much (N,) of each drawn vertex is lip, upper lip, brow, hair; and its hollowness.

    Parameters
    ----------
    lip, upper, brow, hair : (N,) float64, 0 to 1
    hollow : (N,) float64, mm
        How far a vertex lies below its neighbourhood.
    """

    lip: FloatArray
    upper: FloatArray
    brow: FloatArray
    hair: FloatArray
    hollow: FloatArray


def regions_of(head: Head, drawn: Drawn, rings: dict[str, IntArray]) -> Regions:
    """Regions of the average head; they go with the vertices to each person."""
    at = drawn.at(head.neutral)
    face = drawn.pairs[:, 1] < FACE
    around = smoothed(head.neutral[rings["outer"]], left_corner(rings))[:, :2]
    lip = _inside(at, around, face & (at[:, 2] > 95)) * 1.0
    upper, lower = (head.neutral[rings[k]] for k in ("upper", "lower"))
    seam = (np.interp(at[:, 0], *upper[:, :2].T) + np.interp(at[:, 0], *lower[:, :2].T)) / 2
    brows = [head.neutral[head.landmarks[k], :2] for k in (range(17, 22), range(22, 27))]
    near = np.min([_to_line(at[:, :2], line - [0, 1.5]) for line in brows], axis=0)
    brow = (1 - step(near, 2.5, 5.0)) * (face & (at[:, 2] > 40))
    normals = normals_of(at, np.concatenate([drawn.matte, drawn.glossy]))
    smooth = at
    for _ in range(6):
        smooth = drawn.smoother @ smooth
    hollow = ((smooth - at) * normals).sum(axis=1)
    return Regions(lip, step(at[:, 1] - seam, -0.4, 0.4), brow, _hair(at, drawn), hollow)


def _inside(at: FloatArray, around: FloatArray, candidates: NDArray[np.bool_]) -> FloatArray:
    """1 within a contour (K, 2) seen from the front, 0 outside, over about a millimetre."""
    out = np.zeros(len(at))
    contour = around.astype(np.float32)[:, None]
    for k in np.flatnonzero(candidates & (np.abs(at[:, :2] - around.mean(0)).max(1) < 40)):
        x, y = (float(v) for v in at[k, :2])
        out[k] = cv2.pointPolygonTest(contour, (x, y), measureDist=True)
    return step(out, -0.7, 0.7) * candidates * (out != 0)


def _to_line(points: FloatArray, line: FloatArray) -> FloatArray:
    """Distance (N,) of points (N, 2) from a line through (K, 2)."""
    out = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        along = np.clip((points - a) @ (b - a) / ((b - a) ** 2).sum(), 0, 1)
        out = np.minimum(out, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return out


def _hair(at: FloatArray, drawn: Drawn) -> FloatArray:
    """A cap above a hairline that falls behind the ears, which stay bare."""
    x, y, z = at.T
    line = np.interp(z, [-90, -40, -25, 0, 30, 55, 75, 110], [-60, -45, 45, 42, 55, 85, 100, 106])
    ear = (np.abs(x) > 74) & (y < 48) & (z > -32) & (z < 25)
    return step(y - line, -3.0, 5.0) * (drawn.pairs[:, 1] < SKIN) * ~ear


@dataclass(frozen=True)
class Look:
    """How a person is painted, sRGB from 0 to 1.

    Parameters
    ----------
    tone, contrast : str
        Of `TONES` and `CONTRASTS`.
    skin, upper, lower, hair, iris, shirt : (3,) float64
    """

    tone: str
    contrast: str
    skin: FloatArray
    upper: FloatArray
    lower: FloatArray
    hair: FloatArray
    iris: FloatArray
    shirt: FloatArray


def look_of(rng: np.random.Generator, tone: str, contrast: str) -> Look:
    """A person of a skin tone and a contrast of lips."""
    skin = np.array(TONES[tone]) / 255 * rng.uniform(0.95, 1.03, 3)
    upper, lower = (np.clip(skin * c, 0, 1) for c in CONTRASTS[contrast])
    if contrast == "lipstick":  # it covers the skin's own colour
        paint = np.array([0.62, 0.10, 0.17])
        upper, lower = 0.4 * upper + 0.6 * paint, 0.4 * lower + 0.6 * paint
    dark = tone in ("brown", "dark", "olive")
    hair = (
        np.array([0.07, 0.05, 0.045])
        if dark
        else rng.uniform(0.5, 1.6) * np.array([0.22, 0.15, 0.10])
    )
    iris = np.array([0.22, 0.13, 0.08]) if dark else rng.uniform(0.25, 0.5, 3)
    return Look(tone, contrast, skin, upper, lower, hair, iris, rng.uniform(0.08, 0.75, 3))


def painted(head: Head, drawn: Drawn, regions: Regions, look: Look, seed: int) -> FloatArray:
    """Colours (N, 3) of the drawn vertices, sRGB."""
    rng = np.random.default_rng(seed)
    at, part = drawn.at(head.neutral), drawn.pairs[:, 1]
    blotch = rng.normal(0, 1, (len(at), 1))
    fine = 0.025 * blotch
    for _ in range(10):
        blotch = drawn.smoother @ blotch
    grain = 1 + fine + 0.05 * blotch / max(blotch.std(), 1e-9)
    colour = look.skin * grain * _blush(at)
    lips = regions.upper[:, None] * look.upper + (1 - regions.upper[:, None]) * look.lower
    inner = 1 - 0.45 * step(111.5 - at[:, 2], 0.0, 5.0)[:, None] * (np.abs(at[:, :1]) < 20)
    colour = _mixed(colour, lips * (1 + 2 * fine) * inner, regions.lip)
    colour = _mixed(colour, look.hair * (1 + 6 * fine), 0.75 * regions.brow)
    colour = _mixed(colour, look.hair * (1 + 10 * fine), regions.hair)
    colour *= 1 - np.clip(0.35 * regions.hollow, -0.05, 0.6)[:, None]
    deep = step(at[:, 2], 60.0, 108.0)[:, None]
    colour = np.where((part >= SKIN)[:, None], np.array([0.30, 0.08, 0.08]) * deep, colour)
    sockets = (part >= SOCKET) & (part < EYE_SOCKETS)
    colour[sockets] = 0.6 * look.skin
    gums = (part >= EYE_SOCKETS) & (part < GUMS)
    colour[gums] = (np.array([0.62, 0.27, 0.27]) * deep)[gums]
    teeth = (part >= TEETH[0]) & (part < TEETH[1])
    white = np.array([0.86, 0.82, 0.74]) * step(at[:, 2], 68.0, 106.0)[:, None]
    colour[teeth] = white[teeth]
    for centre, (first, end) in zip(eye_centres(head.neutral), EYES, strict=True):
        eye = (part >= first) & (part < end)
        colour[eye] = _eye(at[eye] - centre, look.iris)
    return np.clip(colour, 0, 1)


def _mixed(under: FloatArray, over: FloatArray, share: FloatArray) -> FloatArray:
    """Colours with a share (N,) of others over them."""
    return np.asarray((1 - share[:, None]) * under + share[:, None] * over)


def _blush(at: FloatArray) -> FloatArray:
    """Cheeks and nose a little redder, (N, 3)."""
    spots = [((45, -2, 85), 22), ((-45, -2, 85), 22), ((0, 5, 128), 12)]
    near = sum(np.exp(-((at - c) ** 2).sum(axis=1) / (2 * r**2)) for c, r in spots)
    return np.asarray(1 + np.asarray(near)[:, None] * [0.03, -0.09, -0.08])


def _eye(from_centre: FloatArray, iris: FloatArray) -> FloatArray:
    """Colours of an eyeball: white, iris with a dark rim, pupil."""
    away = np.hypot(from_centre[:, 0], from_centre[:, 1])
    away = np.where(from_centre[:, 2] > 0, away, 99.0)[:, None]
    colour = np.where(away < 6.0, iris, np.array([0.84, 0.81, 0.79]))
    colour = np.where((away > 5.0) & (away < 6.0), 0.5 * iris, colour)
    return np.asarray(np.where(away < PUPIL, np.full(3, 0.015), colour))


# How it is filmed.


@dataclass(frozen=True, eq=False)
class Set:
    """Camera, light and background of a film.

    Parameters
    ----------
    camera : Camera
    lights : list of (direction (3,), strength)
        From where light falls, camera frame with y up and z to the viewer.
    ambient : float
    background : (H, W, 3) float64, 0 to 255
    noise : float
        Standard deviation, grey levels.
    tint : (3,) float64
        Colour of the lights, linear RGB.
    """

    camera: Camera
    lights: list[tuple[FloatArray, float]]
    ambient: float
    background: FloatArray
    noise: float
    tint: FloatArray = field(default_factory=lambda: np.ones(3))


def set_of(rng: np.random.Generator, size: tuple[int, int]) -> Set:
    """A random set."""
    camera = Camera.ideal(size, rng.uniform(1.2, 2.0) * size[0])
    side = rng.choice([-1.0, 1.0])
    key, fill = (
        _direction(side * sign * rng.uniform(*wide), rng.uniform(*high))
        for sign, wide, high in ((1, (10, 55), (10, 50)), (-1, (20, 70), (-10, 35)))
    )
    lights = [(key, rng.uniform(2.2, 3.4)), (fill, rng.uniform(0.5, 1.6))]
    return Set(camera, lights, rng.uniform(0.15, 0.35), backdrop(rng, size), rng.uniform(1.5, 4))


def _direction(azimuth: float, elevation: float) -> FloatArray:
    """A unit vector at angles in degrees from the axis to the viewer."""
    a, e = np.radians([azimuth, elevation])
    return np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])


def backdrop(rng: np.random.Generator, size: tuple[int, int]) -> FloatArray:
    """An uneven wall with things before it, out of focus: (H, W, 3)."""
    width, height = size
    picture = np.ones((height, width, 3)) * (rng.uniform(70, 180) + rng.uniform(-25, 25, 3))
    for _ in range(7):
        x, y = rng.uniform(-0.1, 1.0, 2) * [width, height]
        w, h = rng.uniform(0.08, 0.4, 2) * [width, height]
        corner = (int(x), int(y)), (int(x + w), int(y + h))
        grey = rng.uniform(40, 210)
        colour = [float(v) for v in grey + rng.uniform(-30, 30, 3)]
        cv2.rectangle(picture, *corner, colour, -1)
    rough = rng.normal(0, 1, (height, width, 1))
    rough = gaussian_filter(rough, (width / 20, width / 20, 0))
    picture *= 1 + 0.1 * rough / rough.std()
    slope = np.linspace(-1, 1, width)[None, :, None] * rng.uniform(-0.3, 0.3)
    return np.clip(gaussian_filter(picture * (1 + slope), (2.5, 2.5, 0)), 5, 250)


class Stage:
    """Draws a painted head before a set.

    Parameters
    ----------
    place : Set
    drawn : Drawn
    colours : (N, 3) float64, sRGB
    shirt : (3,) float64, sRGB
    """

    def __init__(self, place: Set, drawn: Drawn, colours: FloatArray, shirt: FloatArray) -> None:
        os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
        import pyrender
        import trimesh

        know_arguments()
        self._gl, self._place, self._drawn = pyrender, place, drawn
        self._colours = np.c_[colours**2.2, np.ones(len(colours))].astype(np.float32)
        width, height = place.camera.size
        self._renderer = pyrender.OffscreenRenderer(width, height)
        ball = trimesh.creation.icosphere(subdivisions=4)
        self._shirt = ball.vertices * [205, 120, 105] + [0, -268, -35], np.asarray(ball.faces)
        self._cloth = np.tile(np.r_[shirt**2.2, 1.0].astype(np.float32), (len(ball.vertices), 1))

    def close(self) -> None:
        """Give up the GL context."""
        self._renderer.delete()

    def picture(self, vertices: FloatArray, turn: FloatArray, shift: FloatArray) -> FloatArray:
        """The head (drawn vertices in mm) in a pose, (H, W, 3), 0 to 255, without noise."""
        drawn = self._drawn
        scene = self._empty()
        seen = (vertices @ turn.T + shift) * [1, -1, -1]
        normals = normals_of(seen, np.concatenate([drawn.matte, drawn.glossy]))
        for faces, rough in ((drawn.matte, 0.62), (drawn.glossy, 0.35)):
            self._add(scene, seen, normals, faces, self._colours, rough)
        cloth, faces = self._shirt
        cloth = (cloth @ FACING.T + shift) * [1, -1, -1]
        self._add(scene, cloth, normals_of(cloth, faces), faces, self._cloth, 0.9)
        colour, _ = self._renderer.render(scene, self._gl.RenderFlags.RGBA)
        colour = colour.astype(np.float64)
        return colour[..., :3] + (1 - colour[..., 3:] / 255) * self._place.background

    def _empty(self) -> Any:
        """A scene with camera and lights."""
        place, gl = self._place, self._gl
        scene = gl.Scene(bg_color=[0, 0, 0, 0], ambient_light=place.ambient * place.tint)
        matrix = place.camera.matrix  # whose pixel centres are at integers, pyrender's at halves
        centre = matrix[0, 2] + 0.5, matrix[1, 2] + 0.5
        camera = gl.IntrinsicsCamera(matrix[0, 0], matrix[1, 1], *centre, znear=50, zfar=5000)
        scene.add(camera, pose=np.eye(4))
        for direction, strength in place.lights:
            pose = np.eye(4)
            pose[:3, :3] = Rotation.align_vectors([direction], [[0, 0, 1]])[0].as_matrix()
            scene.add(gl.DirectionalLight(color=place.tint, intensity=strength), pose=pose)
        return scene

    def _add(
        self,
        scene: Any,
        vertices: FloatArray,
        normals: FloatArray,
        faces: IntArray,
        colours: NDArray[np.float32],
        rough: float,
    ) -> None:
        """Put a mesh into the scene."""
        material = self._gl.MetallicRoughnessMaterial(
            metallicFactor=0.0, roughnessFactor=rough, doubleSided=True
        )
        primitive = self._gl.Primitive(
            positions=vertices.astype(np.float32),
            normals=normals.astype(np.float32),
            indices=faces.astype(np.uint32),
            color_0=colours,
            material=material,
        )
        scene.add(self._gl.Mesh([primitive]))


def noisy(rng: np.random.Generator, picture: FloatArray, noise: float) -> NDArray[np.uint8]:
    """A picture as a sensor with a small lens takes it."""
    soft = gaussian_filter(picture, (0.5, 0.5, 0))
    return np.clip(np.round(soft + rng.normal(0, noise, soft.shape)), 0, 255).astype(np.uint8)


def write_video(path: Path, pictures: list[NDArray[np.uint8]], rate: int) -> None:
    """H.264 of good quality."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", rate=rate, options={"crf": "16"})
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        for picture in pictures:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        file.mux(stream.encode())


# A film and its truth.


@dataclass(frozen=True, eq=False)
class Film:
    """A person, how they move and where they are filmed.

    Parameters
    ----------
    person : (V, 3) float64, mm
    identity : (100,) float64
    weights : (T, E) float64
    start : int
        First frame of the recording.
    rotation, translation : (T, 3, 3), (T, 3) float64, mm
    look : Look
    place : Set
    rate : int
    """

    person: FloatArray
    identity: FloatArray
    weights: FloatArray
    start: int
    rotation: FloatArray
    translation: FloatArray
    look: Look
    place: Set
    rate: int


ELSEWHERE = 2
"""How many of a person's last clips another camera films, in another light; but not all."""


def chance(chosen: argparse.Namespace, number: int) -> tuple[np.random.Generator, ...]:
    """What draws the person, the set and the head's motion of a film of a number.

    One generator where each film has a person of its own.
    """
    if chosen.clips == 1:
        return (np.random.default_rng([chosen.seed, number]),) * 3
    person, clip = divmod(number, chosen.clips)
    elsewhere = int(clip >= max(1, chosen.clips - ELSEWHERE))
    parts = ([chosen.seed, person, *more] for more in ([0], [1, elsewhere], [2, clip]))
    return tuple(np.random.default_rng(part) for part in parts)


def tinted(rng: np.random.Generator) -> FloatArray:
    """The colour of a lamp or of a cloudy sky, linear RGB, as bright as white."""
    warm = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.0)
    colour = np.exp(warm * np.array([0.25, 0.0, -0.35]))
    return np.asarray(colour / colour.mean())


def planned(head: Head, weights: FloatArray, number: int, chosen: argparse.Namespace) -> Film:
    """The film of a number."""
    count, clips = chosen.films, chosen.clips
    who, where, rng = chance(chosen, number)
    person_number, people = number // clips, -(-count // clips)
    order = np.random.default_rng(chosen.seed).permutation(len(CONTRASTS))
    tone = list(TONES)[round(person_number * (len(TONES) - 1) / max(1, people - 1))]
    look = look_of(who, tone, list(CONTRASTS)[order[person_number % len(CONTRASTS)]])
    identity = who.normal(0, 0.7, len(head.identity))
    place = set_of(where, tuple(chosen.size))
    rate = int(where.choice([25, 30]))
    high = 240 / where.uniform(0.62, 0.8)  # mm that the picture shows
    if clips > 1 and number % clips >= max(1, clips - ELSEWHERE):
        place = replace(place, tint=tinted(where))
    distance = place.camera.matrix[1, 1] * high / chosen.size[1]
    time = np.arange(chosen.frames) / rate
    part, start = performed(head, weights, number, chosen, time)
    turn, shift = head_motion(rng, chosen.frames, rate, distance, chosen.tremor)
    person = with_closed_lips(head, head.person(identity))
    return Film(person, identity, part, start, turn, shift, look, place, rate)


def moved(head: Head, film: Film, frame: int) -> FloatArray:
    """Vertices (V, 3) in a frame, mm, head frame."""
    return film.person + np.tensordot(film.weights[frame], head.expressions, 1)


def truth(head: Head, film: Film, rings: dict[str, IntArray]) -> dict[str, Any]:
    """What is known of a film, T frames.

    `camera_matrix` and `size`; `rotation` (T, 3, 3), `translation` (T, 3) mm, head to camera as
    OpenCV has it; `expressions` (T, E) and `expression_names`, `identity`; `neutral` (V, 3) mm;
    `outer`, `upper`, `lower`, `corners` (T, N, 3) mm, head frame, and the vertices they are,
    `outer_vertex` and so on (`outer` is smoothed along the ring); `aperture` and `width` (T,) mm;
    `eye_centres` (2, 3), `pupil_distance` between the painted pupils, `landmarks` (68,) and where
    they are on the average head, `average_landmarks` (68, 3); `tone`, `contrast`, `rate` and
    `recorded_from`.
    """
    profiles = middle_profiles(head)
    needed = np.unique(np.concatenate([*rings.values(), *profiles]))
    path = np.zeros((len(film.weights), len(head.neutral), 3), np.float32)
    path[:, needed] = film.person[needed] + np.tensordot(
        film.weights, head.expressions[:, needed].astype(np.float64), 1
    )
    corners = path[:, rings["corners"]]
    eyes, pupils = eye_centres(film.person), drawn_pupils(head, film.person)
    return {
        "camera_matrix": film.place.camera.matrix,
        "size": np.array(film.place.camera.size),
        "rotation": film.rotation,
        "translation": film.translation,
        "expressions": film.weights,
        "expression_names": np.array(head.names),
        "identity": film.identity,
        "neutral": film.person.astype(np.float32),
        **{name: path[:, ring] for name, ring in rings.items()},
        "outer": smoothed(path[:, rings["outer"]], left_corner(rings)),
        **{f"{name}_vertex": ring for name, ring in rings.items()},
        "aperture": aperture_of(path, profiles),
        "width": np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1),
        "eye_centres": eyes,
        "pupil_distance": np.linalg.norm(pupils[0] - pupils[1]),
        "landmarks": head.landmarks,
        "average_landmarks": head.neutral[head.landmarks],
        "tone": film.look.tone,
        "contrast": film.look.contrast,
        "rate": film.rate,
        "recorded_from": film.start,
    }


def sunk_eyes(vertices: FloatArray) -> FloatArray:
    """Vertices (V, 3) with eyeballs 3 % smaller, so that they stay behind the lids."""
    out = vertices.copy()
    for centre, (first, end) in zip(eye_centres(vertices), EYES, strict=True):
        out[first:end] = centre + 0.97 * (out[first:end] - centre)
    return out


def shoot(
    head: Head, film: Film, drawn: Drawn, regions: Regions, paint: int, seed: int
) -> list[NDArray[np.uint8]]:
    """The pictures of a film, by the seeds of its person's paint and of its noise."""
    rng = np.random.default_rng([seed, 1])
    colours = painted(head, drawn, regions, film.look, paint)
    stage = Stage(film.place, drawn, colours, film.look.shirt)
    out = drawn.at(film.person)
    thick = normals_of(out, drawn.matte) * 7.0 * regions.hair[:, None]
    pictures = []
    for t in range(len(film.weights)):
        vertices = drawn.at(sunk_eyes(moved(head, film, t))) + thick
        clean = stage.picture(vertices, film.rotation[t], film.translation[t])
        pictures.append(noisy(rng, clean, film.place.noise))
    stage.close()
    return pictures


def with_contours(
    picture: NDArray[np.uint8], told: dict[str, Any], frame: int, times: int = 2
) -> NDArray[np.uint8]:
    """A frame enlarged, with the lip contours of the truth drawn on it."""
    out = cv2.resize(picture, None, fx=times, fy=times, interpolation=cv2.INTER_CUBIC)
    colours = {"outer": (255, 255, 0), "upper": (0, 255, 0), "lower": (0, 160, 255)}
    for name, colour in colours.items():
        seen = told[name][frame] @ told["rotation"][frame].T + told["translation"][frame]
        pixels = seen @ told["camera_matrix"].T
        pixels = (pixels[:, :2] / pixels[:, 2:] + 0.5) * times - 0.5
        line = [np.round(pixels * 16).astype(np.int32)]
        cv2.polylines(out, line, name == "outer", colour, 1, cv2.LINE_AA, 4)
    return np.asarray(out, np.uint8)


def tile(pictures: list[NDArray[np.uint8]], told: dict[str, Any]) -> NDArray[np.uint8]:
    """The frame in which the mouth is widest open, and its mouth enlarged with the contours."""
    frame = int(np.argmax(told["aperture"]))
    height = pictures[0].shape[0]
    seen = told["outer"][frame] @ told["rotation"][frame].T + told["translation"][frame]
    pixels = seen @ told["camera_matrix"].T
    x, y = ((pixels[:, :2] / pixels[:, 2:]).mean(axis=0) * 4).astype(int)
    large = with_contours(pictures[frame], told, frame, 4)
    half = height // 2
    large = cv2.copyMakeBorder(large, half, half, half, half, cv2.BORDER_CONSTANT)
    return np.hstack([pictures[frame], large[y : y + height, x : x + height]])


def parsed() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--films", type=int, default=6)
    parser.add_argument("--frames", type=int, default=75)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--size", type=int, nargs=2, default=(640, 480))
    parser.add_argument("--clips", type=int, default=1, help="of each person")
    parser.add_argument("--only", type=int, help="the number of the one film to make")
    parser.add_argument("--motion", choices=("lively", "chance", "mixed"), default="lively")
    parser.add_argument("--tremor", action="store_true", help="heads tremble, see TREMOR")
    return parser.parse_args()


def run() -> None:
    """Film all, and say in how many frames a face is found."""
    chosen = parsed()
    chosen.out.mkdir(parents=True, exist_ok=True)
    data = data_folder()
    head = load_head(data / "ict")
    weights = recorded(data / "livelink_rom" / "alex_rom_3.csv", head.names)
    rings, drawn = lip_rings(head), drawn_of(head)
    regions, tiles = regions_of(head, drawn, rings), []
    for k in range(chosen.films) if chosen.only is None else [chosen.only]:
        film = planned(head, weights, k, chosen)
        told = truth(head, film, rings)
        seeds = (chosen.seed * 1000 + n for n in (k // chosen.clips, k))
        pictures = shoot(head, film, drawn, regions, *seeds)
        write_video(chosen.out / f"film_{k}.mp4", pictures, film.rate)
        np.savez_compressed(chosen.out / f"film_{k}.npz", **told)
        text = camera_json(film.place.camera)
        (chosen.out / f"camera_{k}.json").write_text(text, encoding="utf-8")
        found = sum(find_face(picture) is not None for picture in pictures[::5])
        tiles.append(tile(pictures, told))
        sys.stdout.write(
            f"film_{k}  {film.look.tone} skin, {film.look.contrast} lips, {film.rate} fps, "
            f"recording from {film.start}, pupils {told['pupil_distance']:.1f} mm apart, "
            f"aperture {told['aperture'].min():.1f} to {told['aperture'].max():.1f} mm, closed in "
            f"{(told['aperture'] < 1).mean():.0%}; "
            f"face found in {found} of {len(pictures[::5])} frames\n"
        )
        sys.stdout.flush()
    sheet = cv2.cvtColor(np.vstack(tiles), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(chosen.out / "sheet.png"), sheet)


if __name__ == "__main__":
    run()
