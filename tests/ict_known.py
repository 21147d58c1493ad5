"""Tracked films of ICT heads (`ict_films.py`) as known heads: vertices against the truth.

Run it by hand. `python tests/ict_known.py people FILMS OUT SEED` writes the filmed people as OBJ
files, their paint as textures, by the seed of the films, and the tables that `abs-engine import ICT
--table OUT/people.toml -o ict.face` reads: `people.toml` of their shapes, `looks.toml` of their
looks, too; then
`abs-engine track FILMS/film_K.mp4 -o RUNS/film_K --model ict.face --person film_K --camera
FILMS/camera_K.json`; then `python tests/ict_known.py score RUNS FILMS`. Vertices are compared in
the head's coordinates, which a known head shares with its film: as they are, with no alignment.
Of the lips' motion, each point's mean over the film is taken out.
The recording moves brows and eyelids, too, which a run does not follow.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path

import cv2
import numpy as np
from ict_films import (
    SKIN,
    Head,
    data_folder,
    drawn_of,
    lip_rings,
    load_head,
    painted,
    planned,
    recorded,
    regions_of,
)
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
from scipy.spatial.transform import Rotation

from abs_engine.io.morphs import MorphMesh
from abs_engine.io.morphs.ict import read_ict
from abs_engine.tracking.results.run_mesh import load_mesh
from abs_engine.tracking.runs.record import load_run

FloatArray = NDArray[np.float64]
NARROW = 6706
"""Vertices from 0 that are ICT's narrow face area, without ears and neck."""


NAMES = (
    "found",
    "turn",
    "skin",
    "neck",
    "face",
    "lips",
    "lips across",
    "lips in depth",
    "lips at rest",
    "lips' motion",
    "its part across",
)
TILE, TILES = 768, 9
"""Pixels a side of a tile of ICT's texture, and their number with the eyes' own."""


def write_people(films: Path, out: Path) -> None:
    """Write each film's neutral head as an OBJ, in the model's unit, and the table of all."""
    out.mkdir(parents=True, exist_ok=True)
    names = sorted(path.stem for path in films.glob("film_*.npz"))
    for name in names:
        rows = np.load(films / f"{name}.npz")["neutral"].astype(np.float64) / 10.0
        text = "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in rows)
        (out / f"{name}.obj").write_text(text, encoding="utf-8")
    people = "".join(f'{name} = "{name}.obj"\n' for name in names)
    looks = "".join(f'{name} = "{name}.png"\n' for name in names)
    (out / "people.toml").write_text(f"[people]\n{people}", encoding="utf-8")
    (out / "looks.toml").write_text(f"[people]\n{people}\n[textures]\n{looks}", encoding="utf-8")


def write_looks(films: Path, out: Path, seed: int) -> None:
    """Write each film's paint as a texture; a film's look is drawn again by its seed."""
    data, count = data_folder(), len(list(films.glob("film_*.npz")))
    head = load_head(data / "ict")
    weights = recorded(data / "livelink_rom" / "alex_rom_3.csv", head.names)
    drawn, mesh = drawn_of(head), read_ict(data / "ict")
    regions = regions_of(head, drawn, lip_rings(head))
    uv = mesh.uv.reshape(-1, 2) * [TILES, 1]
    corner, kept = mesh.faces.ravel(), ~np.isin(mesh.part, _shells(mesh)).repeat(3)
    for k in range(count):
        frames = len(np.load(films / f"film_{k}.npz")["aperture"])
        chosen = Namespace(
            films=count,
            frames=frames,
            seed=seed,
            size=(640, 480),
            clips=1,
            motion="lively",
            tremor=False,
        )
        colours = painted(head, drawn, regions, planned(head, weights, k, chosen).look,
                          seed * 1000 + k)[: len(head.neutral)]  # fmt: skip
        tiles = []
        for tile in range(TILES):
            own = kept & (np.floor(uv[:, 0] - 1e-6) == tile)
            tiles.append(_tile(uv[own] - [tile, 0], colours[corner[own]]))
        picture = np.rint(255 * np.hstack(tiles)).astype(np.uint8)
        cv2.imwrite(str(out / f"film_{k}.png"), picture[..., ::-1])


def _shells(mesh: MorphMesh) -> list[int]:
    """Parts before the eyes, which the films leave out."""
    words = ("Iris", "Lacrimal", "Blend", "Occlusion", "Lashes")
    return [k for k, name in enumerate(mesh.part_names) if any(w in name for w in words)]


def _tile(uv: FloatArray, colours: FloatArray) -> FloatArray:
    """A picture with colours (N, 3) at places (N, 2), linear between them."""
    if len(uv) < 4:
        return np.full((TILE, TILE, 3), 0.5)
    at = np.stack(np.meshgrid(*[(np.arange(TILE) + 0.5) / TILE] * 2), axis=-1)
    places, first = np.unique(np.round(uv, 6), axis=0, return_index=True)
    found = LinearNDInterpolator(places, colours[first])(at)
    near = NearestNDInterpolator(places, colours[first])(at)
    return np.where(np.isnan(found), near, found)


def rms(away: FloatArray) -> float:
    """RMS length of vectors (..., 3)."""
    return float(np.sqrt((away**2).sum(axis=-1).mean()))


def score(head: Head, run: Path, film: Path) -> tuple[float, ...]:
    """Share of frames found, median error of rotation, degrees, and RMS in mm: see `NAMES`."""
    told, mesh, tracked = np.load(film), load_mesh(run), load_run(run)
    found = np.flatnonzero(tracked["found"])
    ours, true = Rotation.from_rotvec(tracked["rotation"][found]), told["rotation"][found]
    turn = np.median(np.degrees((ours.inv() * Rotation.from_matrix(true)).magnitude()))
    lips = np.unique(np.concatenate(list(lip_rings(head).values())))
    skull = np.setdiff1d(np.arange(SKIN), np.arange(NARROW))
    areas = (np.arange(SKIN), skull, np.arange(NARROW), lips)
    neutral, rows, apart = told["neutral"].astype(np.float64), [], []
    for t in found:
        moved = np.tensordot(told["expressions"][t], head.expressions, 1)
        off = mesh.vertices(int(t))[: len(neutral)] - neutral - moved
        own = [rms(off[at]) for at in areas]
        apart.append(off[lips])
        rows.append([*own, rms(off[lips, :2]), rms(off[lips, 2:]), rms(moved[lips])])
    means = np.sqrt((np.array(rows) ** 2).mean(axis=0))
    motion = np.array(apart) - np.mean(apart, axis=0)
    share = len(found) / len(told["aperture"])
    return share, turn, *means, rms(motion), rms(motion[..., :2])


def main(words: list[str]) -> None:
    """Do what was typed."""
    if words[0] == "people":
        write_people(Path(words[1]), Path(words[2]))
        if len(words) > 3:
            write_looks(Path(words[1]), Path(words[2]), int(words[3]))
        return
    runs, films, head = Path(words[1]), Path(words[2]), load_head(data_folder() / "ict")
    rows = []
    sys.stdout.write("  ".join(NAMES) + "\n")
    for run in sorted(runs.glob("film_*")):
        if (run / "mesh.npz").is_file():
            rows.append(score(head, run, films / f"{run.name}.npz"))
            sys.stdout.write(f"{run.name}  " + "  ".join(f"{v:.2f}" for v in rows[-1]) + "\n")
    sys.stdout.write("mean    " + "  ".join(f"{v:.2f}" for v in np.mean(rows, axis=0)) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
