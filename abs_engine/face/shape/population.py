"""Real people's heads: how their average and their spread differ from an artist's head.

Components of a face model that was made after scans (Li et al., "Learning Formation of
Physically-Based Face Attributes", CVPR 2020), carried over to the bundled head's mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.threads import kept
from abs_engine.face.settings.shape import SHAPE
from abs_engine.io.arrays import Layout, real
from abs_engine.io.assets import Speaker, load_speaker, shipped
from abs_engine.io.npz import read_npz

FORMAT, VERSION = "abs_engine.population", 1
HEADS = "population/heads.npz"
_AGAIN = "make it again with assets/make_population.py"
_LAYOUT: Layout = {
    "mean": real("V", 3, dtype=np.float16),
    "components": real("K", "V", 3, dtype=np.float16),
}


@dataclass(frozen=True, eq=False)
class Population:
    """People's heads, as displacements of the bundled head's vertices, at the bundled head's size.

    Parameters
    ----------
    mean : (V, 3) float16, mm
        From the bundled head to people's average head, the pupils as far apart.
    components : (K, V, 3) float16, mm
        Directions in which people differ, each one standard deviation long; both sides of a face
        alike, since other modes let these differ.
    """

    mean: NDArray[np.float16]
    components: NDArray[np.float16]

    def save(self, path: Path) -> None:
        """Write an ``.npz`` that `load_population` reads."""
        np.savez_compressed(path, format=FORMAT, version=VERSION, **vars(self))

    def pooled(self, modes: NDArray[np.float32], factor: float) -> NDArray[np.float32]:
        """Modes (M, V, 3) of an artist's heads, mm, and people's at a size, (M + K, V, 3).

        Their covariance is a share `SHAPE.scanned` people's, the rest the artist's. How far the two
        averages lie apart is not added to it. `factor` is the size over the bundled head's.
        """
        share = SHAPE.scanned
        scans = self.components.astype(np.float32) * np.float32(factor * np.sqrt(share))
        return np.concatenate([modes * np.float32(np.sqrt(1.0 - share)), scans])


@kept
def load_population() -> Population:
    """The population that is shipped, see ``assets/population/PROVENANCE.md``.

    Raises
    ------
    InputFileError
        If the file is missing.
    ModelFormatError
        If it has another layout.
    """
    vertices = len(load_speaker().vertices)
    data = read_npz(shipped(HEADS), FORMAT, VERSION, _LAYOUT, _AGAIN, V=vertices)
    return Population(data["mean"], data["components"])


@kept
def average_person() -> Speaker:
    """The bundled head, moved a share `SHAPE.scanned` of the way to people's average head.

    Raises
    ------
    InputFileError, ModelFormatError
        As `load_population`.
    """
    speaker = load_speaker()
    moved = np.float32(SHAPE.scanned) * load_population().mean.astype(np.float32)
    return replace(speaker, vertices=speaker.vertices + moved)


def expected(speaker: Speaker) -> bool:
    """Whether this is the `average_person`, the head of a person of whom nothing is known.

    Raises
    ------
    InputFileError, ModelFormatError
        As `load_population`.
    """
    return not speaker.imported and speaker is average_person()
