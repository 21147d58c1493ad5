"""How real people's heads differ, on the bundled head's mesh: by a model made after scans.

Usage: ``abs-engine import FOLDER -o ict.face``, with the folder that ``population/PROVENANCE.md``
names, then ``python assets/make_population.py ict.face [OUTPUT_FOLDER]``. The bundled head is laid
on the model's average head, and the model's components go along as smooth fields; lips end where
the model's do (`lip_border.py`). It writes ``heads.npz``, and with ``--sheet PICTURE`` both heads
from three sides. It takes a minute.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from lip_border import slid_border
from numpy.typing import NDArray
from scipy import sparse
from scipy.interpolate import RBFInterpolator
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.scene import Scene
from abs_engine.face.schema import COMPONENT
from abs_engine.face.shape.population import HEADS, Population
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.landmark.rendered_landmarks import Light, lit_picture, pose_of
from abs_engine.tracking.person.scale import pupil_distance, pupil_vertices

SKIN = ("skin", "upper_lip", "lower_lip")
INNER = np.r_[8, 17:68]
"""The chin and all but the jaw line of the 68 usual landmarks."""
ROUNDS = (
    *((200.0, 30.0, 25.0),) * 3,
    *((60.0, 10.0, 25.0),) * 4,
    *((20.0, 10.0, 10.0),) * 4,
    *((8.0, 10.0, 10.0),) * 6,
)
"""Stiffness, weight of a landmark, and how far a surface is looked for, mm, of each round."""
COMPONENTS, LEAST = 50, 0.1
"""How many are looked at, and the RMS, mm, of one that is kept: some are asymmetry alone."""
CENTRES, SMOOTHING = 1400, 3.0
SAMPLES = 600_000
NECK = -85.0  # mm, y of the bundled head: below it, people's necks are cut in another way


@dataclass(frozen=True, eq=False)
class Surface:
    """Points that lie closely on the skin of a head, with the facets and weights that they have."""

    points: FloatArray
    normals: FloatArray
    corners: NDArray[np.integer]
    weights: FloatArray

    @classmethod
    def of(cls, head: Speaker, vertices: FloatArray) -> Surface:
        """Of the skin of a head with vertices (V, 3)."""
        faces, rng = head.faces[_skin(head)], np.random.default_rng(0)
        corners = vertices[faces]
        area = np.linalg.norm(np.cross(*(corners[:, k] - corners[:, 0] for k in (1, 2))), axis=1)
        drawn = rng.choice(len(faces), SAMPLES, p=area / area.sum())
        weights = rng.dirichlet(np.ones(3), SAMPLES)
        normals = vertex_normals(vertices, head.faces)[faces[drawn]]
        at, facing = (
            np.einsum("nk,nkd->nd", weights, values) for values in (corners[drawn], normals)
        )
        return cls(
            at, facing / np.linalg.norm(facing, axis=1, keepdims=True), faces[drawn], weights
        )

    def moved(self, deltas: NDArray[np.floating], at: NDArray[np.integer]) -> FloatArray:
        """Displacements (N, 3) of some points (N,), by those of the head's vertices (V, 3)."""
        return np.einsum("nk,nkd->nd", self.weights[at], deltas[self.corners[at]])


@dataclass(frozen=True, eq=False)
class Laid:
    """Our head laid on the average head of scans, in our head's frame and at the other's size.

    Parameters
    ----------
    moved : (V, 3) float64, mm
        Our vertices, there.
    theirs : (W, 3) float64, mm
        The other head's, the middle of its landmarks on that of ours.
    turn : (3, 3) float64
        From the other head's frame to ours.
    larger : float
        Our size over theirs, by the distance of the pupils.
    skin : Surface
        The other head's.
    """

    moved: FloatArray
    theirs: FloatArray
    turn: FloatArray
    larger: float
    skin: Surface

    @classmethod
    def of(cls, ours: Speaker, scans: Speaker) -> Laid:
        """Our head, laid on another."""
        vertices, theirs = ours.vertices.astype(np.float64), scans.vertices.astype(np.float64)
        marks, others = (
            v[head.points["landmark_68"][INNER]] for head, v in ((ours, vertices), (scans, theirs))
        )
        turn, larger = similarity(marks, others)
        middle = marks.mean(axis=0)
        theirs = (theirs - others.mean(axis=0)) @ turn.T + middle
        skin = Surface.of(scans, theirs)
        start = (vertices - middle) / larger + middle
        moved = registered(ours, start, theirs[scans.points["landmark_68"][INNER]], skin)
        (right, _), (left, _) = eye_middles(scans, theirs)
        apart = float(np.linalg.norm(right - left))
        return cls(moved, theirs, turn, pupil_distance(ours, vertices) / apart, skin)


def _skin(head: Speaker) -> BoolArray:
    return np.isin(head.facet_class, [head.class_id(name) for name in SKIN])


def similarity(ours: FloatArray, theirs: FloatArray) -> tuple[FloatArray, float]:
    """Rotation (3, 3) that lays their landmarks on ours, and how much larger ours are."""
    ours, theirs = ours - ours.mean(axis=0), theirs - theirs.mean(axis=0)
    turn = Rotation.align_vectors(ours, theirs)[0].as_matrix()
    return turn, float((ours * (theirs @ turn.T)).sum() / (theirs**2).sum())


def registered(head: Speaker, start: FloatArray, marks: FloatArray, skin: Surface) -> FloatArray:
    """The head's vertices (V, 3), laid on a surface and its landmarks (L, 3) as smoothly as may be.

    Non-rigid ICP (Amberg et al., CVPR 2007) with the Laplacian of the head as it was.
    """
    own, count = np.unique(head.faces[_skin(head)]), len(start)
    smoothing = laplacian(head.faces, count)
    bending, tree = smoothing.T @ smoothing, cKDTree(skin.points)
    moved, landmarks = start, head.points["landmark_68"][INNER]
    for stiffness, held, reach in ROUNDS:
        away, at = tree.query(moved[own])
        normals = skin.normals[at]
        alike = (vertex_normals(moved, head.faces)[own] * normals).sum(axis=1) > 0.6
        weight = np.where(alike & (away < reach) & (start[own, 1] > NECK), 1.0, 0.0)
        blocks = 0.95 * normals[:, :, None] * normals[:, None] + 0.05 * np.eye(3)
        each = weight[:, None, None] * blocks
        matrix = sparse.block_diag([stiffness * bending] * 3) + _placed(each, own, count)
        right = stiffness * (bending @ start)
        right[own] += np.einsum("nij,nj->ni", each, skin.points[at])
        right[landmarks] += held * marks
        on = np.zeros(count)
        on[landmarks] = held
        matrix = matrix + sparse.block_diag([sparse.diags(on + 1e-6)] * 3)
        moved = spsolve(matrix.tocsc(), right.T.ravel()).reshape(3, count).T
    return moved


def laplacian(faces: NDArray[np.integer], count: int) -> sparse.csr_matrix:
    """Mean of a vertex's neighbours, less the vertex."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    one = sparse.coo_matrix((np.ones(len(edges)), edges.T), (count, count))
    joined = ((one + one.T) > 0).astype(float)
    degree = np.maximum(np.asarray(joined.sum(axis=1)).ravel(), 1.0)
    return (sparse.diags(1 / degree) @ joined - sparse.identity(count)).tocsr()


def _placed(blocks: FloatArray, at: NDArray[np.integer], count: int) -> sparse.coo_matrix:
    """Blocks (N, 3, 3) of some vertices in a matrix over all coordinates, axis after axis."""
    i, j = (np.arange(3) * count + at[:, None] for _ in range(2))
    rows, columns = np.broadcast_arrays(i[:, :, None], j[:, None, :])
    return sparse.coo_matrix(
        (blocks.ravel(), (rows.ravel(), columns.ravel())), (3 * count, 3 * count)
    )


def trusted(head: Speaker, moved: FloatArray, skin: Surface) -> tuple[FloatArray, FloatArray]:
    """Vertices (N,) of the head's skin that lie on a surface, and the points there (N,)."""
    own = np.unique(head.faces[_skin(head)])
    away, at = cKDTree(skin.points).query(moved[own])
    alike = (vertex_normals(moved, head.faces)[own] * skin.normals[at]).sum(axis=1) > 0.5
    good = alike & (away < 2.0) & (head.vertices[own, 1] > NECK)
    return own[good], at[good]


def spread_out(points: FloatArray) -> NDArray[np.integer]:
    """Some points, each as far from the others as may be, more of them on the face."""
    chosen = [0]
    away = np.linalg.norm(points - points[0], axis=1)
    dense = np.where((points[:, 2] > 30) & (points[:, 1] < 75), 1.0, 0.45)
    for _ in range(CENTRES):
        chosen.append(int(np.argmax(away * dense)))
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen)


def eye_middles(
    head: Speaker, vertices: FloatArray
) -> list[tuple[FloatArray, NDArray[np.integer]]]:
    """Pupils (3,) of eyes that look ahead, the right one first, and the vertices of each eye."""
    found = []
    eyes = np.unique(head.faces[head.facet_class == head.class_id("eyes")])
    for side in (-1.0, 1.0):
        own = eyes[side * head.vertices[eyes, 0] > 0]
        ball = vertices[own]
        system = np.c_[2 * ball, np.ones(len(ball))]
        centre = np.linalg.lstsq(system, (ball**2).sum(axis=1), rcond=None)[0][:3]
        found.append((np.array([*centre[:2], ball[:, 2].max()]), own))
    return found


def population(ours: Speaker, scans: Speaker) -> Population:
    """The average head of scans, as ours is meshed, and the components of how people differ."""
    vertices, laid = ours.vertices.astype(np.float64), Laid.of(ours, scans)
    moved, skin = laid.moved, laid.skin
    own, at = trusted(ours, moved, skin)
    chosen = spread_out(vertices[own])
    own, at = own[chosen], at[chosen]
    parts = [k for k, name in enumerate(scans.identity_names) if name.startswith(COMPONENT)]
    deltas = scans.identity[parts[:COMPONENTS]].astype(np.float64) @ laid.turn.T
    values = [moved[own] - vertices[own], *(skin.moved(one, at) for one in deltas)]
    field = RBFInterpolator(vertices[own], np.hstack(values), kernel="linear", smoothing=SMOOTHING)
    fields = field(vertices).reshape(len(vertices), -1, 3).swapaxes(0, 1)
    seen = eye_middles(scans, laid.theirs)
    for (pupil, there), near, (_, eye) in zip(
        seen, pupil_vertices(ours), eye_middles(ours, vertices), strict=True
    ):
        fields[0, eye] = pupil - vertices[near].mean(axis=0)
        fields[1:, eye] = deltas[:, there].mean(axis=1)[:, None]
    fields = mirrored(vertices, fields, fields)
    some = np.sqrt((fields[1:] ** 2).sum(axis=2).mean(axis=1)) > LEAST
    slide = slid_border(ours, moved, scans, laid.theirs)
    return _as_large(ours, Population(slide, fields[0], fields[1:][some]))


def mirrored(vertices: FloatArray, fields: FloatArray, others: FloatArray) -> FloatArray:
    """What fields (K, V, 3) over a head whose sides are alike share with others' mirror images.

    Lips that meet on one side alone would be closed by a grimace.
    """
    other_side = np.array([-1.0, 1.0, 1.0])
    across = cKDTree(vertices).query(vertices * other_side)[1]
    return 0.5 * (fields + others[:, across] * other_side)


def _as_large(ours: Speaker, found: Population) -> Population:
    """People whose average has its pupils as far apart as our head, about its lips."""
    vertices = ours.vertices.astype(np.float64)
    average = vertices + found.mean
    factor = pupil_distance(ours, vertices) / pupil_distance(ours, average)
    lips = average[ours.lip_ring].mean(axis=0)
    sized = (average - lips) * factor + vertices[ours.lip_ring].mean(axis=0)
    mean, components = (
        found.slide.of(x).astype(np.float16) for x in (sized - vertices, found.components * factor)
    )
    return Population(found.slide, mean, components)


def pictures(
    ours: Speaker, vertices: FloatArray, poses: Iterable[Pose], camera: Camera
) -> list[NDArray[np.uint8]]:
    """Our head with these vertices (V, 3), lit, in each of some poses."""
    none = np.zeros((0, *vertices.shape), np.float32)
    classes, paint = ours.facet_class.astype(np.int32), ours.texture(next(iter(ours.people)))
    scene = Scene(vertices.astype(np.float32), none, ours.faces, ours.uv, classes, paint)
    light = Light(np.array([0.5, -0.5, -1.0]), 0.3, 0.8)
    return [lit_picture(scene, pose, camera, CpuRenderer(), light) for pose in poses]


def sheet(ours: Speaker, found: Population) -> NDArray[np.uint8]:
    """Our head and the average of the scans, each from three sides."""
    rows, camera, away = [], Camera.ideal((400, 400)), np.array([0.0, 0.0, 700.0])
    for vertices in (ours.vertices, found.slide.of(ours.vertices) + found.mean):
        head = vertices.astype(np.float64)
        poses = [pose_of(ours, head, (0.0, 0.0, yaw), away) for yaw in (0.0, 0.6, 1.4)]
        rows.append(np.hstack(pictures(ours, head, poses, camera)))
    return np.vstack(rows)


def arguments(doc: str) -> argparse.Namespace:
    """Arguments of a script that makes a file of a model made after scans, and a sheet of it."""
    parser = argparse.ArgumentParser(description=doc.splitlines()[0])
    parser.add_argument("face", type=Path, help="ICT's model, imported")
    parser.add_argument(
        "output", nargs="?", type=Path, default=Path(__file__).resolve().parent / "population"
    )
    parser.add_argument("--sheet", type=Path, metavar="PICTURE", help="what was made, to look at")
    return parser.parse_args()


def main() -> int:
    """Write the file and the sheet."""
    args = arguments(__doc__)
    ours, scans = load_speaker(), load_speaker(args.face)
    if not any(name.startswith(COMPONENT) for name in scans.identity_names):
        print(f"make_population: {args.face} has no components of people", file=sys.stderr)
        return 2
    found = population(ours, scans)
    args.output.mkdir(parents=True, exist_ok=True)
    found.save(args.output / Path(HEADS).name)
    if args.sheet is not None:
        cv2.imwrite(str(args.sheet), sheet(ours, found)[..., ::-1])
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
