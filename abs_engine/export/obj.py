"""A sequence of OBJ files: the head of each frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from abs_engine.export.exporter import Exporter, Loss, TrackedRun, rms
from abs_engine.export.reading import compared, differs
from abs_engine.tracking.results.run_table import time_cell


def _write(run: TrackedRun, folder: Path) -> tuple[Loss, ...]:
    corners = run.mesh.faces + 1
    uv = run.speaker.uv * [1.0, -1.0] + [0.0, 1.0]  # OBJ counts v from below
    texture = "".join(f"vt {u:.6f} {v:.6f}\n" for u, v in uv)
    faces = "".join(f"f {a}/{a} {b}/{b} {c}/{c}\n" for a, b, c in corners.tolist())
    for frame in run.frames:
        time = time_cell(run.arrays["time"][frame])
        head = f"# frame {frame}, {time} s; mm, x to the subject's left, y up\n"
        places = run.mesh.vertices(frame).tolist()
        lines = "".join(f"v {x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in places)
        (folder / f"{frame:06d}.obj").write_text(head + lines + texture + faces, encoding="ascii")
    return _read_back(run, folder)


def _read_back(run: TrackedRun, folder: Path) -> tuple[Loss, ...]:
    times, apart = [], []
    files = sorted(folder.iterdir())
    if len(files) != len(run.frames):
        raise differs("frames")
    for frame, path in zip(run.frames, files, strict=True):
        head, _, body = path.read_text(encoding="ascii").partition("\n")
        numbers = body.partition("vt ")[0].replace("v ", "")
        places = np.fromstring(numbers, sep=" ").reshape(-1, 3)
        apart.append(compared(places, run.mesh.vertices(frame), "mm", "vertices").value)
        times.append(head.split()[3])
    return (
        compared(times, run.arrays["time"][run.frames], "s", "times"),
        Loss(rms(np.array(apart)), "mm", "vertices"),  # as many in every frame
    )


OBJ = Exporter("a folder of OBJ files, one for each frame in which the head was found", _write)
