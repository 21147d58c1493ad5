"""Tracked films of ICT heads (`ict_films.py`) as known heads: vertices against the truth.

Run it by hand. `python tests/ict_known.py people FILMS OUT` writes the filmed people as OBJ files
and the table that `abs-engine import ICT --table OUT/people.toml -o ict.face` reads; then
`abs-engine track FILMS/film_K.mp4 -o RUNS/film_K --model ict.face --person film_K --camera
FILMS/camera_K.json`; then `python tests/ict_known.py score RUNS FILMS`. Vertices are compared in
the head's coordinates, which a known head shares with its film: as they are, with no alignment.
The recording moves brows and eyelids, too, which a run does not follow.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from ict_films import SKIN, Head, data_folder, lip_rings, load_head
from numpy.typing import NDArray

from abs_engine.tracking.record import load_run
from abs_engine.tracking.run_mesh import load_mesh

FloatArray = NDArray[np.float64]
NARROW = 6706
"""Vertices from 0 that are ICT's narrow face area, without ears and neck."""


NAMES = (
    "found", "skin", "neck and back", "face", "lips", "across", "in depth", "lips of a head at rest",
)  # fmt: skip


def write_people(films: Path, out: Path) -> None:
    """Write each film's neutral head as an OBJ, in the model's unit, and the table of all."""
    out.mkdir(parents=True, exist_ok=True)
    names = sorted(path.stem for path in films.glob("film_*.npz"))
    for name in names:
        rows = np.load(films / f"{name}.npz")["neutral"].astype(np.float64) / 10.0
        text = "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in rows)
        (out / f"{name}.obj").write_text(text, encoding="utf-8")
    lines = ["[people]", *(f'{name} = "{name}.obj"' for name in names), ""]
    (out / "people.toml").write_text("\n".join(lines), encoding="utf-8")


def rms(away: FloatArray) -> float:
    """RMS length of vectors (..., 3)."""
    return float(np.sqrt((away**2).sum(axis=-1).mean()))


def score(head: Head, run: Path, film: Path) -> tuple[float, ...]:
    """Share of frames found, and over these RMS in mm: see `NAMES`."""
    told, mesh = np.load(film), load_mesh(run)
    found = np.flatnonzero(load_run(run)["found"])
    lips = np.unique(np.concatenate(list(lip_rings(head).values())))
    skull = np.setdiff1d(np.arange(SKIN), np.arange(NARROW))
    areas = (np.arange(SKIN), skull, np.arange(NARROW), lips)
    neutral, rows = told["neutral"].astype(np.float64), []
    for t in found:
        moved = np.tensordot(told["expressions"][t], head.expressions, 1)
        off = mesh.vertices(int(t))[: len(neutral)] - neutral - moved
        own = [rms(off[at]) for at in areas]
        rows.append([*own, rms(off[lips, :2]), rms(off[lips, 2:]), rms(moved[lips])])
    return len(found) / len(told["aperture"]), *np.sqrt((np.array(rows) ** 2).mean(axis=0))


def main(words: list[str]) -> None:
    """Do what was typed."""
    if words[0] == "people":
        write_people(Path(words[1]), Path(words[2]))
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
