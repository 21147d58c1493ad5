"""Real people's heads: how their average and their spread differ from an artist's head.

Components of a face model that was made after scans (Li et al., "Learning Formation of
Physically-Based Face Attributes", CVPR 2020), carried over to the bundled head's mesh. An
unknown person's lips also end where that model's do: the artist's are blunt at the corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.threads import kept
from abs_engine.face.settings.shape import SHAPE
from abs_engine.io.arrays import Layout, index, real
from abs_engine.io.assets import Speaker, load_speaker, shipped
from abs_engine.io.npz import read_npz

FORMAT, VERSION = "abs_engine.population", 2
HEADS = "population/heads.npz"
_AGAIN = "make it again with assets/make_population.py"
_LAYOUT: Layout = {
    "mean": real("V", 3, dtype=np.float16),
    "components": real("K", "V", 3, dtype=np.float16),
    "slid": index("V", "N"),
    "between": index("V", "N", 2),
    "share": real("N", low=0.0, high=1.0, dtype=np.float32),
}


@dataclass(frozen=True, eq=False)
class Slide:
    """Vertices of the bundled head that slide on its surface, so that lips end as people's.

    Parameters
    ----------
    vertices : (N,) int32
        Those that slide.
    between : (N, 2) int32
        The ends of the edge on which each lies then.
    share : (N,) float32
        How far from the first to the second, 0 to 1.
    """

    vertices: NDArray[np.int32]
    between: NDArray[np.int32]
    share: NDArray[np.float32]

    def of(self, values: NDArray[np.floating]) -> NDArray[Any]:
        """Vertices (V, 3), mm, or their displacements (..., V, 3), after sliding; of one dtype."""
        one, other = (values[..., side, :].astype(np.float32) for side in self.between.T)
        out = values.copy()
        out[..., self.vertices, :] = one + self.share[:, None] * (other - one)
        return out


@dataclass(frozen=True, eq=False)
class Population:
    """People's heads, as displacements of the bundled head's vertices, at the bundled head's size.

    Parameters
    ----------
    slide : Slide
        Where vertices of the bundled head lie before they are displaced.
    mean : (V, 3) float16, mm
        From the bundled head, its vertices slid, to people's average head, the pupils as far apart.
    components : (K, V, 3) float16, mm
        Directions in which people differ, each one standard deviation long; both sides of a face
        alike, since other modes let these differ.
    """

    slide: Slide
    mean: NDArray[np.float16]
    components: NDArray[np.float16]

    def save(self, path: Path) -> None:
        """Write an ``.npz`` that `load_population` reads."""
        slide = self.slide
        np.savez_compressed(
            path, format=FORMAT, version=VERSION, mean=self.mean, components=self.components,
            slid=slide.vertices, between=slide.between, share=slide.share,
        )  # fmt: skip

    def pooled(self, modes: Sequence[NDArray[np.float32]], factor: float) -> NDArray[np.float32]:
        """Parts of modes (M, V, 3) of an artist's heads, mm, and people's at a size, (M + K, V, 3).

        Their covariance is a share `SHAPE.scanned` people's, the rest the artist's. How far the two
        averages lie apart is not added to it. `factor` is the size over the bundled head's.
        """
        share = SHAPE.scanned
        parts: list[NDArray[np.floating]] = [*modes, self.components]
        sizes = [np.float32(np.sqrt(1.0 - share))] * len(modes)
        sizes.append(np.float32(factor * np.sqrt(share)))
        ends = np.cumsum([len(part) for part in parts])
        out = np.empty((ends[-1], *self.mean.shape), np.float32)  # filled in place: it is large
        for end, part, size in zip(ends, parts, sizes, strict=True):
            np.multiply(part, size, out=out[end - len(part) : end], dtype=np.float32)
        return out


@kept
def load_population() -> Population:
    """The population that is shipped, see ``assets/population/PROVENANCE.md``.

    Raises `InputFileError` if the file is missing, `ModelFormatError` if it has another layout.
    """
    vertices = len(load_speaker().vertices)
    data = read_npz(shipped(HEADS), FORMAT, VERSION, _LAYOUT, _AGAIN, V=vertices)
    slide = Slide(data["slid"], data["between"], data["share"])
    return Population(slide, data["mean"], data["components"])


@kept
def average_person() -> Speaker:
    """The bundled head, moved a share `SHAPE.scanned` of the way to people's average head.

    Where its lips end is wholly people's. Errors are those of `load_population`.
    """
    speaker, people = load_speaker(), load_population()
    moved = np.float32(SHAPE.scanned) * people.mean.astype(np.float32)
    return replace(
        speaker,
        vertices=people.slide.of(speaker.vertices) + moved,
        units=people.slide.of(speaker.units),
        identity=people.slide.of(speaker.identity),
    )


def expected(speaker: Speaker) -> bool:
    """Whether this is the `average_person`, the head of a person of whom nothing is known.

    Errors are those of `load_population`.
    """
    return not speaker.imported and speaker is average_person()
