"""Face units that were made after scans: how they move a face otherwise than an artist's do.

Units of a face model (Li et al., "Learning Formation of Physically-Based Face Attributes", CVPR
2020), carried over to the bundled head's mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.face.shape.population import average_person
from abs_engine.io.arrays import Layout, places_of, real, text
from abs_engine.io.assets import load_speaker, shipped
from abs_engine.io.npz import read_npz

FORMAT, VERSION = "abs_engine.units", 1
UNITS = "population/units.npz"
_AGAIN = "make it again with assets/make_units.py"
_LAYOUT: Layout = {"unit_names": text("N"), "differences": real("N", "V", 3, dtype=np.float16)}


def save_units(path: Path, names: Sequence[str], differences: NDArray[np.floating]) -> None:
    """Write an ``.npz`` of units (N,) and their differences (N, V, 3), mm, at half precision."""
    half = np.asarray(differences, np.float16)
    np.savez_compressed(
        path, format=FORMAT, version=VERSION, unit_names=np.array(names), differences=half
    )


def unit_differences(names: Sequence[str]) -> NDArray[np.float32]:
    """Differences (N, V, 3), mm at weight 1, of units of scans from the `average_person`'s.

    See ``assets/population/PROVENANCE.md``. The file has them from the bundled head's: its border
    of the lips moves there as that of the scans, on which the average person's lies. `names` are
    ARKit's. Raises as `load_population`, and `ModelFormatError` if the file lacks a unit.
    """
    artist = load_speaker()
    path = shipped(UNITS)
    data = read_npz(path, FORMAT, VERSION, _LAYOUT, _AGAIN, V=len(artist.vertices))
    places = places_of(path, data["unit_names"], names, _AGAIN)
    differences = np.asarray(data["differences"][places], np.float32)
    asked = tuple(names)
    return differences + (artist.unit_matrix(asked) - average_person().unit_matrix(asked))
