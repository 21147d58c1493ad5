"""Assemble the head: classes, triangles, units, identity targets and people."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import speaker_mesh as sm
from speaker_chart import lay_out
from speaker_inside import settle
from speaker_people import MACROS, identity_targets
from speaker_refine import Refined, refine, refine_grid
from speaker_seal import OVERLAP, Seal
from speaker_source import TARGETS, UNITS, QuadMesh, Source

MILLIMETRES = 100.0  # per decimetre
TAPER = 5  # refined rings that the vermilion loses at the mouth's corners
LARGE = 0.105  # dm, quads of the skull with a longer mean side are refined
OUTER_RINGS, INNER_RINGS = 3, 4  # rings of skin and of inner mouth that are refined too


def average_points(source: Source, base: QuadMesh) -> np.ndarray:
    """Return the average person over the base mesh: base + mean of the macro targets in use."""
    n = len(base.points)
    total = sum(
        w * source.target(TARGETS + f"macrodetails/{name}.target.gz", n)
        for name, w in MACROS.items()
    )
    return base.points + total


def sample_mask(mask: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Read a UV mask at chart positions (v up)."""
    height, width = mask.shape
    rows = np.clip(((1.0 - uv[:, 1]) * height).astype(int), 0, height - 1)
    return mask[rows, np.clip((uv[:, 0] * width).astype(int), 0, width - 1)]


def find_ear_canals(source: Source, base: QuadMesh) -> np.ndarray:
    """Return the base points deepest in the right and the left ear (smallest ``|x|``)."""
    centre = base.uv[base.uv_quads].mean(1)
    ear = (sample_mask(source.mask("mpfb_ears.jpg"), centre) > 100) & (base.group == "body")
    points = np.unique(base.quads[ear])
    depth = np.abs(base.points[points, 0])
    right = base.points[points, 0] < 0
    pick = [points[side][depth[side].argmin()] for side in (right, ~right)]
    return np.array(pick)


def border_rings(n_spokes: int, left: int) -> np.ndarray:
    """Return the ring of the vermilion border at each spoke: 0, but tapering at the corners."""
    spokes = np.arange(n_spokes)
    distance = np.minimum.reduce([spokes, np.abs(spokes - left), n_spokes - spokes])
    return np.maximum(TAPER - distance, 0)


def grid_places(lips: sm.LipGrid) -> dict[int, tuple[int, int]]:
    """Return (ring, spoke) of every vertex of the grid."""
    rings, spokes = lips.vertices.shape
    return {int(lips.vertices[r, s]): (r, s) for r in range(rings) for s in range(spokes)}


def on_border(a: tuple[int, int], b: tuple[int, int], border: np.ndarray) -> bool:
    """Tell whether two grid places follow each other on the vermilion border."""
    apart = (a[1] - b[1]) % len(border)
    return apart in (1, len(border) - 1) and border[a[1]] == a[0] and border[b[1]] == b[0]


def triangulate(polygons: list, points: np.ndarray, places: dict, border: np.ndarray) -> list:
    """Cut polygons into triangles, as corner numbers (i, j, k) of each polygon.

    A quad is cut along the vermilion border where that crosses it, else along
    its shorter diagonal; a longer polygon is a fan from its first corner.
    """
    result = []
    for polygon in polygons:
        if len(polygon) > 4:
            result.append([(0, i, i + 1) for i in range(1, len(polygon) - 1)])
            continue
        at = [places.get(v) for v in polygon]
        first = np.linalg.norm(points[polygon[0]] - points[polygon[2]])
        second = np.linalg.norm(points[polygon[1]] - points[polygon[3]])
        cut_first = round(first, 7) <= round(second, 7)
        if None not in at:
            if on_border(at[0], at[2], border):
                cut_first = True
            elif on_border(at[1], at[3], border):
                cut_first = False
        result.append([(0, 1, 2), (0, 2, 3)] if cut_first else [(1, 2, 3), (1, 3, 0)])
    return result


def classify(
    faces: np.ndarray, kind: np.ndarray, places: dict, border: np.ndarray, left: int
) -> np.ndarray:
    """Name the lips among triangles that are skin: those of the grid inside the border."""
    kind = kind.copy()
    n = len(border)
    for f, corners in enumerate(faces.tolist()):
        at = [places.get(v) for v in corners]
        if None in at or kind[f] != sm.SKIN:
            continue
        rings = np.array([a[0] for a in at])
        spokes = np.array([a[1] for a in at], float)
        if np.ptp(spokes) > n / 2:
            spokes[spokes < n / 2] += n
        spoke = spokes.mean() % n
        edge = np.interp(spoke, np.arange(n + 1), np.append(border, border[0]))
        if rings.mean() > edge:
            kind[f] = sm.UPPER_LIP if spoke < left else sm.LOWER_LIP
    return kind


def near_mouth(mesh: sm.EdgeMap, kind: np.ndarray, lips: sm.LipGrid) -> np.ndarray:
    """Choose the quads to refine: lips, skin and inner mouth around them, and all teeth."""
    lip = np.zeros(len(kind), bool)
    lip[lips.quads.ravel()] = True
    chosen, grown = lip.copy(), lip.copy()
    for step in range(max(OUTER_RINGS, INNER_RINGS)):
        grown = mesh.neighbours(grown)
        reach = np.where(kind == sm.INNER_MOUTH, INNER_RINGS, OUTER_RINGS)
        chosen |= grown & (step < reach)
    return chosen | np.isin(kind, (sm.UPPER_TEETH, sm.LOWER_TEETH))


def on_skull(quads: np.ndarray, points: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Choose the large quads of the skull, so that its outline is round (not those at the cut)."""
    corners = points[quads]
    sides = np.linalg.norm(corners - np.roll(corners, -1, 1), axis=2).mean(1)
    return (sides > LARGE) & (height[quads].min(1) > 0.3)


def split_vertices(made: Refined, corners: list) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Number the distinct (vertex, chart point) pairs.

    Returns
    -------
    faces : (F, 3) int
    geometric, chart : (V,) int
        Refined point and chart point of each vertex.
    """
    pairs = np.array(
        [
            [(p[i], u[i]) for i in t]
            for p, u, ts in zip(made.polygons, made.uv_polygons, corners, strict=True)
            for t in ts
        ]
    )
    unique, inverse = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    return inverse.reshape(-1, 3), unique[:, 0], unique[:, 1]


def build_head(source: Source) -> sm.Head:
    """Cut, refine, name and lay out the head of the average person."""
    base = source.base()
    points = average_points(source, base)
    canals = find_ear_canals(source, base)
    origin = points[canals].mean(0) * [0, 1, 1]
    height = sm.above_neck(points - origin)
    rows, kind = sm.keep_head(base, height)
    quads, uv_quads = base.quads[rows], base.uv_quads[rows]
    centre = base.uv[uv_quads].mean(1)
    inner = (sample_mask(source.mask("mpfb_inside-mouth.jpg"), centre) > 100) & (kind == sm.SKIN)
    mesh = sm.EdgeMap(quads)
    coarse = sm.lip_grid(mesh, base.points, inner, (kind == sm.SKIN) & ~inner)
    kind[inner] = sm.INNER_MOUTH
    chosen = near_mouth(mesh, kind, coarse) | on_skull(quads, points, height)
    made = refine(quads, uv_quads, len(base.points), len(base.uv), chosen)
    grid = refine_grid(coarse, made)
    border = border_rings(grid.vertices.shape[1], grid.left)
    places = grid_places(grid)
    refined = made.matrix @ points
    corners = triangulate(made.polygons, refined, places, border)
    faces, geometric, chart = split_vertices(made, corners)
    kind = np.repeat(kind[made.parent], [len(t) for t in corners])
    kind = classify(geometric[faces], kind, places, border, grid.left)
    operator = (made.matrix @ sm.trim(quads, quads, len(points), height))[geometric] * MILLIMETRES
    full = np.zeros(base.uv.shape)
    used = np.unique(uv_quads)
    full[used] = lay_out(sm.trim(quads, uv_quads, len(base.uv), height)[used] @ base.uv)
    first = {int(g): v for v, g in reversed(list(enumerate(geometric)))}
    lips = sm.LipGrid(np.vectorize(first.get)(grid.vertices), grid.left, grid.quads)
    weld = np.unique(geometric, return_inverse=True)[1]
    head = sm.Head(
        operator @ points - origin * MILLIMETRES,
        faces,
        (made.uv_matrix @ full)[chart],
        weld,
        kind,
        lips,
        border,
        operator,
        points,
        origin,
        canals,
    )
    sealed = Seal(head).seal(head.vertices, -OVERLAP)
    return replace(head, vertices=settle(sealed, faces, kind))


def unit_deltas(source: Source, head: sm.Head) -> tuple[list[str], np.ndarray]:
    """Return the names of the face units and their displacements, (52, V, 3) mm."""
    files = source.list(UNITS, ".target")
    names = [f.rsplit("/", 1)[1].removesuffix(".target") for f in files]
    n = len(head.points)
    return names, np.stack([head.operator @ source.target(f, n) for f in files])


def identity_deltas(source: Source, head: sm.Head) -> tuple[list[str], np.ndarray]:
    """Return names and displacements, (K, V, 3) mm, that change the person.

    The lips stay sealed, and the ear canals keep their midpoint at the origin. A macro target is
    given as the step from the average person to the person of that target alone.
    """
    n = len(head.points)
    average = head.points - source.base().points
    names, deltas = [], []
    seal = Seal(head)
    for name, file in identity_targets(source):
        delta = source.target(file, n) - (average if name.startswith("macro/") else 0.0)
        shift = delta[head.canals].mean(0) * [0, 1, 1]
        names.append(name)
        deltas.append(seal.seal(head.operator @ (delta - shift), 0.0))
    return names, np.stack(deltas)
