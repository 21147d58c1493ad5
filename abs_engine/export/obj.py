"""A sequence of OBJ files: the head of each frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from abs_engine.export.exporter import Exporter, Loss, TrackedRun, rms
from abs_engine.tracking.run_table import time_cell


def _write(run: TrackedRun, folder: Path) -> tuple[Loss, ...]:
    corners = run.mesh.faces + 1
    uv = run.speaker.uv * [1.0, -1.0] + [0.0, 1.0]  # OBJ counts v from below
    texture = "".join(f"vt {u:.6f} {v:.6f}\n" for u, v in uv)
    faces = "".join(f"f {a}/{a} {b}/{b} {c}/{c}\n" for a, b, c in corners.tolist())
    worst = [np.zeros(3)]
    for frame in run.frames:
        places = run.mesh.vertices(frame)
        rounded = np.round(places, 4)
        time = time_cell(run.arrays["time"][frame])
        head = f"# frame {frame}, {time} s; mm, x to the subject's left, y up\n"
        lines = "".join(f"v {x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in rounded.tolist())
        (folder / f"{frame:06d}.obj").write_text(head + lines + texture + faces, encoding="ascii")
        worst.append(rounded - places)
    return (Loss(rms(np.vstack(worst)), "mm", "vertices"),)


OBJ = Exporter("a folder of OBJ files, one for each frame in which the head was found", _write)
