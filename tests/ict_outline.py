"""How far the outlines of tracked heads lie off those of the films' heads (`ict_films.py`).

Run it by hand: `python tests/ict_outline.py RUNS FILMS`, on what `ict_agreement.py` takes. In every
twelfth frame both heads at rest are drawn from the camera, and on each row of pixels between brows
and chin the ends of both are compared, in mm at the head's distance.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from ict_agreement import pixels
from ict_films import DRAWN_FACES, SKIN, data_folder, load_head, triangles
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.tracking.results.run_mesh import load_mesh
from abs_engine.tracking.runs.record import load_run

FloatArray = NDArray[np.float64]

FIRST, EVERY = 3, 12  # frames
BANDS = {"ears": (0.0, 0.45), "cheeks": (0.45, 0.75), "jaw": (0.75, 1.0)}
"""Shares of the way from the brows to the chin."""


def covered(
    at: FloatArray, faces: NDArray[np.integer], size: NDArray[np.integer]
) -> NDArray[np.uint8]:
    """Pixels (H, W), 0 or 1, that triangles (F, 3) of points (V, 2) cover."""
    drawn = np.zeros((int(size[1]), int(size[0])), np.uint8)
    for corners in np.rint(at).astype(np.int32)[faces]:
        cv2.fillConvexPoly(drawn, corners, 1)
    return drawn


def ends(row: NDArray[np.uint8]) -> FloatArray:
    """The first and the last covered pixel of a row (W,)."""
    return np.flatnonzero(row)[[0, -1]].astype(np.float64)


def off_outline(ours: FloatArray, theirs: FloatArray, first: int, last: int) -> FloatArray:
    """Height (N,), 0 to 1, and how much too far out both ends of rows lie, pixels: (N, 3)."""
    rows = []
    for y in range(max(first, 0), min(last, len(ours))):
        if ours[y].any() and theirs[y].any():
            (left, right), (true_left, true_right) = ends(ours[y]), ends(theirs[y])
            rows.append([(y - first) / (last - first), true_left - left, right - true_right])
    return np.array(rows).reshape(-1, 3)


def of_film(run: Path, film: Path, speaker: Speaker, faces: NDArray[np.integer]) -> FloatArray:
    """`off_outline` of a film's frames, mm."""
    tracked, true = load_run(run), np.load(film)
    own, person = load_mesh(run).mean.astype(np.float64), true["neutral"].astype(np.float64)
    skin = speaker.faces[speaker.facet_class == speaker.class_id("skin")]
    return np.concatenate(
        [
            of_frame(tracked, true, t, (own, skin), (person, faces))
            for t in np.flatnonzero(tracked["found"])[FIRST::EVERY]
        ]
    )


def of_frame(
    tracked: Any, true: Any, t: int, ours: tuple[Any, Any], theirs: tuple[Any, Any]
) -> FloatArray:
    """The same of a frame, in which both heads are vertices and facets."""
    turned = Rotation.from_rotvec(tracked["rotation"][t]).as_matrix()
    here = ours[0] @ turned.T + tracked["translation"][t]
    there = theirs[0] @ true["rotation"][t].T + true["translation"][t]
    camera, size = true["camera_matrix"], true["size"]
    mm = float(there[:, 2].mean() / camera[0, 0])
    marks = pixels(there[true["landmarks"]], camera)
    first, last = int(marks[17:27, 1].max()), int(marks[8, 1] - 3 / mm)
    masks = [covered(pixels(x, camera), f, size) for x, f in ((here, ours[1]), (there, theirs[1]))]
    return off_outline(masks[0], masks[1], first, last) * [1.0, mm, mm]


def line(name: str, rows: FloatArray) -> str:
    """Mean distances in each band, and by how much heads are too wide on each side."""
    off = np.abs(rows[:, 1:])
    each = []
    for band, (low, high) in BANDS.items():
        inside = (rows[:, 0] >= low) & (rows[:, 0] < high)
        each.append(f"{band} {off[inside].mean():.1f}")
    return f"{name:8} {off.mean():.2f} mm ({', '.join(each)}); too wide by {rows[:, 1:].mean():.1f}"


if __name__ == "__main__":
    runs, films = Path(sys.argv[1]), Path(sys.argv[2])
    triangle = triangles(load_head(data_folder() / "ict").quads[:DRAWN_FACES])
    skin = triangle[(triangle < SKIN).all(axis=1)]
    names = sorted(p.stem for p in films.glob("film_*.npz") if (runs / p.stem).is_dir())
    found = [of_film(runs / n, films / f"{n}.npz", load_speaker(), skin) for n in names]
    sys.stdout.write("\n".join(map(line, names, found)) + "\n")
    sys.stdout.write(line("all", np.concatenate(found)) + "\n")
