"""How face units that were made after scans move a face, on the bundled head's mesh.

Usage: ``abs-engine import FOLDER -o ict.face``, with the folder that ``population/PROVENANCE.md``
names, then ``python assets/make_units.py ict.face [OUTPUT_FOLDER]``. The bundled head is laid on
the model's average head; skin goes along with the skin that it lies on, and contours of lips with
those at the same share of their lengths. The unit that closes lips is made as large as an open jaw
needs. It writes ``units.npz``, and with ``--sheet PICTURE`` postures by both heads' units. It takes
a minute.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from make_population import NECK, Laid, arguments, laplacian, mirrored, pictures, trusted
from make_postures import twins
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.face.rings import lip_rings
from abs_engine.face.shape.mouth import mouth_units
from abs_engine.face.shape.scanned_units import UNITS, save_units
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.tracking.landmark.rendered_landmarks import pose_of

STIFF, ON_CONTOUR = 3.0, 300.0
"""Weight of smoothness, and of a point of a contour or of a tooth, beside a point of the skin."""
MIDDLE = 10.0
"""From the middle of the face, mm, where lips must meet."""
INSIDE = ("upper_teeth", "lower_teeth", "tongue", "eyes")
"""What moves as before."""
SHOWN: tuple[dict[str, float], ...] = (
    {"jawOpen": 0.5},
    {"jawOpen": 0.5, "mouthClose": 0.5},
    {"mouthFunnel": 0.8, "jawOpen": 0.15},
    {"mouthPucker": 0.9},
    {"mouthSmileLeft": 0.7, "mouthSmileRight": 0.7, "jawOpen": 0.2},
    {"mouthRollLower": 0.7, "mouthRollUpper": 0.6},
    {f"mouth{way}{side}": 0.7 for way in ("UpperUp", "LowerDown") for side in ("Left", "Right")},
    {"mouthLeft": 0.5},
)


def contours(head: Speaker, vertices: FloatArray) -> list[NDArray[np.integer]]:
    """The outer contour's upper and lower way, and the inner contours, each from -x to x."""
    rings = lip_rings(head)
    first, last = rings["corners"]
    outer = np.roll(rings["outer"], -int(np.flatnonzero(rings["outer"] == first)[0]))
    there = int(np.flatnonzero(outer == last)[0])
    halves = [outer[: there + 1], np.r_[outer[there:], outer[:1]]]
    halves.sort(key=lambda way: -float(vertices[way, 1].mean()))
    ways = [*halves, rings["upper"], rings["lower"]]
    return [way if vertices[way[0], 0] < vertices[way[-1], 0] else way[::-1] for way in ways]


def shares(vertices: FloatArray, way: NDArray[np.integer]) -> FloatArray:
    """Shares of a contour's length, 0 to 1, up to each of its vertices."""
    lengths = np.linalg.norm(np.diff(vertices[way], axis=0), axis=1).cumsum()
    return np.asarray(np.r_[0.0, lengths] / lengths[-1])


def on_contours(
    ours: Speaker, scans: Speaker, laid: Laid, deltas: FloatArray
) -> Iterator[tuple[NDArray[np.integer], FloatArray]]:
    """Vertices (N,) of each contour of our lips, and how units (U, W, 3) move them (U, N, 3)."""
    own = ours.vertices.astype(np.float64)
    for way, other in zip(contours(ours, own), contours(scans, laid.theirs), strict=True):
        at, known = shares(own, way), shares(laid.theirs, other)
        moves = [[np.interp(at, known, one[other, d]) for d in range(3)] for one in deltas]
        yield way, np.array(moves).swapaxes(1, 2)


def differences(ours: Speaker, scans: Speaker, names: tuple[str, ...]) -> FloatArray:
    """By how much their units move our vertices otherwise than our own do, (U, V, 3), mm."""
    laid, units = Laid.of(ours, scans), ours.unit_matrix(names).astype(np.float64)
    deltas = scans.unit_matrix(names).astype(np.float64) @ laid.turn.T * laid.larger
    wanted, weight = units.copy(), np.zeros(len(ours.vertices))
    lips = np.concatenate([ours.vertices_of(name) for name in ("upper_lip", "lower_lip")])
    skin, at = trusted(ours, laid.moved, laid.skin)
    plain = ~np.isin(skin, lips)
    wanted[:, skin[plain]] = np.stack([laid.skin.moved(one, at[plain]) for one in deltas])
    weight[skin[plain]] = 1.0
    weight[ours.vertices[:, 1] < NECK] = 1.0
    for way, moves in on_contours(ours, scans, laid, deltas):
        wanted[:, way], weight[way] = moves, ON_CONTOUR
    for name in INSIDE:
        weight[ours.vertices_of(name)] = ON_CONTOUR
    found = _smooth(ours, weight, wanted - units)
    twin = found[[names.index(one) for one in twins(names)]]
    found = mirrored(ours.vertices.astype(np.float64), found, twin)
    jaw, closing = (names.index(name) for name in ("jawOpen", "mouthClose"))
    closes = units[closing] + found[closing]
    found[closing] = closes * _enough(ours, units[jaw] + found[jaw], closes) - units[closing]
    return found


def _enough(ours: Speaker, opens: FloatArray, closes: FloatArray) -> float:
    """How much of a motion (V, 3) that closes lips makes up for one (V, 3) that parts them.

    The model's own goes farther, so that lips would pass through each other.
    """
    rings = lip_rings(ours)
    middle = [k[np.abs(ours.vertices[k, 0]) < MIDDLE] for k in (rings["upper"], rings["lower"])]
    parted, met = (
        float(move[middle[0], 1].mean() - move[middle[1], 1].mean()) for move in (opens, closes)
    )
    return -parted / met


def _smooth(ours: Speaker, weight: FloatArray, wanted: FloatArray) -> FloatArray:
    """The smoothest fields (U, V, 3) over the mesh that are nearly as wanted where that has weight.

    Copies of a vertex at seams of the texture are one, so that the skin does not tear; upper and
    lower lip are joined by their corners alone.
    """
    _, one = np.unique(ours.weld, return_inverse=True)
    count = int(one.max()) + 1
    uneven = laplacian(one[ours.faces], count)
    total = np.bincount(one, weight, count)
    pulled = np.zeros((count, wanted.shape[0] * 3))
    np.add.at(pulled, one, (wanted * weight[:, None]).swapaxes(0, 1).reshape(len(one), -1))
    held = sparse.diags(total + 1e-6) + STIFF * uneven.T @ uneven
    found = splu(held.tocsc()).solve(pulled)
    return np.asarray(found[one].reshape(len(one), -1, 3).swapaxes(0, 1))


def sheet(ours: Speaker, other: FloatArray, names: tuple[str, ...]) -> NDArray[np.uint8]:
    """Postures, by our units (above) and by those of the scans, each from two sides."""
    own, rows = ours.unit_matrix(names).astype(np.float64), []
    rest, away = ours.vertices.astype(np.float64), np.array([0.0, 0.0, 420.0])
    poses = [pose_of(ours, rest, (0.0, 0.0, yaw), away) for yaw in (0.0, 1.0)]
    for units in (own, own + other):
        shown = []
        for posture in SHOWN:
            moved = rest + sum(w * units[names.index(name)] for name, w in posture.items())
            views = pictures(ours, moved, poses, Camera.ideal((420, 420)))
            shown.append(np.vstack([one[190:400, 90:330] for one in views]))
        rows.append(np.hstack(shown))
    return np.vstack(rows)


def main() -> int:
    """Write the file and the sheet."""
    args = arguments(__doc__)
    ours, scans, names = load_speaker(), load_speaker(args.face), mouth_units()
    missing = [name for name in names if name not in scans.unit_names]
    if missing:
        print(f"make_units: {args.face} lacks the unit {missing[0]}", file=sys.stderr)
        return 2
    found = differences(ours, scans, names)
    args.output.mkdir(parents=True, exist_ok=True)
    save_units(args.output / Path(UNITS).name, names, found)
    if args.sheet is not None:
        cv2.imwrite(str(args.sheet), sheet(ours, found, names)[..., ::-1])
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
