"""Visemes filmed for the appearance models: the corpus as pictures, with the head's motion known.

The studio's pictures (`abs_engine.studio`) have lamps, shading, blur and noise that the tracker's
own renderer does not have.
"""

from __future__ import annotations

from collections.abc import Sequence as Several
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.dataset import load_truth
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.articulated import FaceShape
from abs_engine.io.assets import Speaker
from abs_engine.learn.spoken import SpokenCorpus
from abs_engine.studio.appearance.look import Look
from abs_engine.studio.filming import plan_of
from abs_engine.studio.make import Crew, Order, make
from abs_engine.studio.people import Person, dots, paint
from abs_engine.studio.plan import ClipPlan
from abs_engine.studio.sequence import Sequence, portrait, wander

SIZE = (320, 240)
BEADS = 230
"""Coloured beads on the face, as the paper's speaker wears a few hundred (figure 1); none lie on
the lips."""
COMMAND = "abs-engine reproduce 001"
_LONG = 600.0  # seconds of head motion of which each picture shows a moment


@dataclass(frozen=True, eq=False)
class VisemePictures:
    """A picture of each viseme of a corpus.

    Parameters
    ----------
    visemes : tuple of str, V
    pictures : (V, H, W, 3) uint8 RGB
        As the camera took them, without compression.
    vertices : (V, M, 3) float32, mm, head frame
        The whole head as it was filmed.
    poses : tuple of Pose, V
        Head to camera.
    """

    visemes: tuple[str, ...]
    pictures: NDArray[np.uint8]
    vertices: NDArray[np.float32]
    poses: tuple[Pose, ...]
    camera: Camera

    def __len__(self) -> int:
        """Return the number of visemes, V."""
        return len(self.visemes)


def film_visemes(
    speaker: Speaker,
    spoken: SpokenCorpus,
    person: str,
    folder: Path,
    *,
    size: tuple[int, int],
    beads: int,
    seed: int,
) -> VisemePictures:
    """Film each viseme of a corpus once, from the front, the head moved a little each time.

    `size` is the pictures' (width, height), px.

    Parameters
    ----------
    folder : Path
        Gets the data set; must not exist.
    beads : int
        How many are on the face; see `BEADS`.
    seed : int
        Of the head's motion and the sensor's noise.

    Raises
    ------
    ParameterError
        If the corpus is another person's; other errors as `make`.
    """
    neutral = speaker.named(person)
    if not np.array_equal(neutral, spoken.neutral):
        raise ParameterError(f"the corpus is not spoken by {person}", "speak it by the same person")
    camera = Camera.ideal(size)
    rng = np.random.default_rng([seed, 1])
    times = rng.uniform(0.0, _LONG, len(spoken.weights))
    rotations, shifts = wander(times, portrait(camera, speaker, neutral), rng)
    names = spoken.corpus.visemes
    act = Sequence(person, "visemes", 25.0, spoken.weights, rotations, shifts, names)
    plan = plan_of(speaker, act, camera, Look(), seed, COMMAND)
    order = Order(COMMAND, seed, (), keep_frames=True)
    make([with_beads(speaker, plan, beads)], 1, folder, speaker, order, Crew())
    return read_visemes(folder, names)


def with_beads(speaker: Speaker, plan: ClipPlan, beads: int | str) -> ClipPlan:
    """A plan whose person wears so many coloured beads, or a set of dots; itself for 0."""
    if not beads:
        return plan
    worn = Person(plan.person, plan.person, beads=beads)
    return replace(plan, texture=paint(speaker, worn), dots=dots(speaker, worn).vertices)


def read_visemes(folder: Path, visemes: Several[str]) -> VisemePictures:
    """Visemes filmed by `film_visemes`; errors as `load_truth`.

    Raises
    ------
    ParameterError
        If there are not as many pictures as visemes.
    """
    truth = load_truth(folder)
    if len(truth) != len(visemes):
        raise ParameterError(
            f"{len(truth)} pictures for {len(visemes)} visemes", "film the same corpus"
        )
    count = range(len(truth))
    heads = np.stack([truth.vertices(t) for t in count])
    return VisemePictures(
        tuple(visemes), np.stack(list(truth.pictures())), heads,
        tuple(truth.pose(t) for t in count), truth.camera,
    )  # fmt: skip


def sightings(
    shape: FaceShape, pictures: NDArray[np.uint8], poses: Several[Pose], alpha: FloatArray
) -> list[Sighting]:
    """Pictures with the geometry that the articulatory model gives them at parameters (V, P)."""
    return [
        Sighting(picture, shape.scene.vertices(row), pose, row)
        for picture, pose, row in zip(pictures, poses, alpha, strict=True)
    ]
