"""Marker files as other systems write them: C3D, and CSV with a row a frame or a row a point."""

from __future__ import annotations

import io
from pathlib import Path

import c3d
import numpy as np


def write_c3d(
    path: Path,
    names: tuple[str, ...],
    points: np.ndarray,
    unit: str = "mm",
    further: tuple[tuple[str, ...], ...] = (),
    rate: float = 60.0,
) -> Path:
    """Points (T, N, 3), NaN where missing; scale of the file: mm as floats.

    `further` labels go into LABELS2, LABELS3 and so on.
    """
    writer = c3d.Writer(point_rate=rate, analog_rate=0)
    writer.set_point_labels(list(names))
    for k, labels in enumerate(further, 2):
        packed, width = c3d.Writer.pack_labels(list(labels))
        writer.point_group.add_str(f"LABELS{k}", "", packed, width, len(labels))
    for places in points:
        lacks = np.isnan(places[:, :1])
        rows = np.concatenate(
            [np.nan_to_num(places), np.where(lacks, -1.0, 0.0), 0 * lacks], axis=1
        )
        writer.add_frames([(rows.astype(np.float32), np.zeros((0, 0), np.float32))])
    made = io.BytesIO()
    writer.write(made)
    path.write_bytes(made.getvalue().replace(b"mm  ", unit.ljust(4).encode()))
    return path


def write_analog(path: Path) -> Path:
    """A C3D file of an analog channel, without points, as of a recording of forces."""
    writer, made = c3d.Writer(point_rate=60.0, analog_rate=60.0), io.BytesIO()
    writer.set_point_labels(["a", "b"])
    writer.set_analog_labels(["force"])
    writer.add_frames([(np.zeros((2, 5), np.float32), np.zeros((1, 1), np.float32))])
    writer.write(made)
    content = bytearray(made.getvalue())
    used = content.rindex(b"USED") + 8  # of POINT, behind ANALOG's
    for place in (2, used):  # the header's number, too
        content[place : place + 2] = bytes(2)
    path.write_bytes(content)
    return path


def write_wide(path: Path, names: tuple[str, ...], points: np.ndarray, time: bool = True) -> Path:
    head = ["time" if time else "frame", *(f"{n}_{c}" for n in names for c in "xyz")]
    lines = [",".join(head)]
    for t, places in enumerate(points):
        cells = ["" if np.isnan(v) else repr(float(v)) for v in places.ravel()]
        lines.append(",".join([repr(t / 60) if time else str(t), *cells]))
    path.write_text("\n".join(lines))
    return path


def write_long(path: Path, names: tuple[str, ...], points: np.ndarray, first: int = 0) -> Path:
    lines = ["frame,point,x,y,z"]
    for t, places in enumerate(points):
        for name, place in zip(names, places, strict=True):
            if np.isfinite(place).all():
                lines.append(f"{t + first},{name},{','.join(repr(float(v)) for v in place)}")
    path.write_text("\n".join(lines))
    return path
