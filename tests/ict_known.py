"""Tracked films of ICT heads (`ict_films.py`) as known heads: vertices against the truth.

Run it by hand. `python tests/ict_known.py people FILMS OUT` writes the filmed people as OBJ files
and the table that `abs-engine import ICT --table OUT/people.toml -o ict.face` reads; then
`abs-engine track FILMS/film_K.mp4 -o RUNS/film_K --model ict.face --person film_K --camera
FILMS/camera_K.json`; then `python tests/ict_known.py score RUNS FILMS`. Vertices are compared in
the head's coordinates, which a known head shares with its film: as they are, with no alignment.
The recording moves brows and eyelids, too, which a run does not follow; `rest` is the error of the
head at rest, for comparison.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from ict_films import Head, data_folder, lip_rings, load_head
from numpy.typing import NDArray

from abs_engine.tracking.record import load_run
from abs_engine.tracking.run_mesh import load_mesh

FloatArray = NDArray[np.float64]
NARROW = 6706
"""Vertices from 0 that are ICT's narrow face area, without ears and neck."""


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
    """RMS, mm, over frames that were found: all vertices, the face, the lips; the same at rest."""
    told, mesh = np.load(film), load_mesh(run)
    found = np.flatnonzero(load_run(run)["found"])
    lips = np.unique(np.concatenate(list(lip_rings(head).values())))
    areas = {"head": np.arange(len(head.neutral)), "face": np.arange(NARROW), "lips": lips}
    neutral = told["neutral"].astype(np.float64)
    out = [len(found) / len(told["aperture"])]
    for frames in (mesh, None):
        sums = dict.fromkeys(areas, 0.0)
        for t in found:
            moved = np.tensordot(told["expressions"][t], head.expressions, 1)
            own = mesh.vertices(int(t))[: len(neutral)] - neutral if frames else 0.0
            for name, at in areas.items():
                sums[name] += rms((own - moved)[at]) ** 2
        out += [float(np.sqrt(total / max(1, len(found)))) for total in sums.values()]
    return tuple(out)


def main(words: list[str]) -> None:
    """Do what was typed."""
    if words[0] == "people":
        write_people(Path(words[1]), Path(words[2]))
        return
    runs, films, head = Path(words[1]), Path(words[2]), load_head(data_folder() / "ict")
    rows = []
    names = ("found", "head", "face", "lips", "head at rest", "face at rest", "lips at rest")
    sys.stdout.write("  ".join(names) + "\n")
    for run in sorted(runs.glob("film_*")):
        if (run / "mesh.npz").is_file():
            rows.append(score(head, run, films / f"{run.name}.npz"))
            sys.stdout.write(f"{run.name}  " + "  ".join(f"{v:.2f}" for v in rows[-1]) + "\n")
    sys.stdout.write("mean    " + "  ".join(f"{v:.2f}" for v in np.mean(rows, axis=0)) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
