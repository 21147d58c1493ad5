"""The person who is expected before anything was seen: their head, and how the network errs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.threads import kept
from abs_engine.face.shape.population import average_person
from abs_engine.io.assets import Speaker, load_speaker, shipped
from abs_engine.io.npz import read_npz
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark.landmark_noise import LAYOUT, LandmarkNoise

FORMAT, VERSION = "abs_engine.landmark_noise", 1
NOISE = "population/landmark_noise.npz"
_AGAIN = "make it again with assets/make_landmarks.py"


def anybody(speaker: Speaker, correspondence: Correspondence) -> tuple[Speaker, Correspondence]:
    """The head and the landmarks of a person of whom nothing is known.

    Of the head that is given by default, the average person and the network's errors on such heads:
    the landmark network was trained on people, and its errors differ on heads unlike any of theirs.
    Any other head is returned unchanged. Close-ups, starts from colours and measured points do not
    begin here, but with the bundled head.

    Raises
    ------
    InputFileError, ModelFormatError
        As `load_population`.
    """
    if speaker is not load_speaker():
        return speaker, correspondence
    return average_person(), replace(correspondence, noise=people_noise())


def save_noise(path: Path, noise: LandmarkNoise) -> None:
    """Write an ``.npz`` that `people_noise` reads."""
    arrays: dict[str, Any] = {**noise.arrays()}
    np.savez_compressed(path, format=FORMAT, version=VERSION, **arrays)


@kept
def people_noise() -> LandmarkNoise:
    """The network's errors on drawings of expected people, by ``assets/make_landmarks.py``.

    Raises
    ------
    InputFileError, ModelFormatError
        As `load_population`.
    """
    return LandmarkNoise.of_arrays(read_npz(shipped(NOISE), FORMAT, VERSION, LAYOUT, _AGAIN))
