"""The corpus of a bundled speaker: visemes spoken by a person, and points measured on the face."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.corpus import Corpus, bite_plane
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.io.assets import Speaker
from abs_engine.learn.choice import choose_points
from abs_engine.learn.spoken import SpokenCorpus
from abs_engine.studio.corpus.subtle import as_it_happens, subtle
from abs_engine.studio.corpus.visemes import PAPER_VISEMES, SILENT, spelled
from abs_engine.studio.speech import articulate, parse_phonemes

FloatArray = NDArray[np.float64]
NOISE = 0.3
"""Error (mm) of a measured point: the root mean square of its distance from where it is."""
_PREPH = {"jawOpen": 0.11, "mouthLowerDownLeft": 0.06, "mouthLowerDownRight": 0.06}


def speak_corpus(
    speaker: Speaker,
    neutral: NDArray[np.floating],
    visemes: Sequence[str] = PAPER_VISEMES,
    *,
    noise: float = NOISE,
    seed: int = 0,
) -> SpokenCorpus:
    """Speak visemes and measure them.

    Parameters
    ----------
    speaker : Speaker
    neutral : (M, 3) float32, mm, head frame
        The person at rest: one of the speaker's (`Speaker.named`), or any other of its mesh.
    visemes : sequence of str
        Of `visemes.ALL_VISEMES`.
    noise : float
        mm; see `NOISE`. The same in all directions, that along one axis is noise / sqrt(3).
    seed : int
        Of the noise, and of what differs from one utterance to the next.

    Returns
    -------
    SpokenCorpus

    Raises
    ------
    ParameterError
        If the noise is negative, a viseme is unknown or given twice, or the head has no landmarks.
    """
    if not 0 <= noise < float("inf"):
        raise ParameterError(f"the noise is {noise:g} mm", "give 0 or more")
    chosen = choose_points(speaker)
    weights = np.array([viseme_weights(speaker, neutral, v, seed) for v in visemes])
    frame = bite_plane_of(speaker, neutral)
    deltas = speaker.units[:, chosen.vertices].astype(np.float64)
    head = neutral[chosen.vertices].astype(np.float64) + np.tensordot(weights, deltas, 1)
    exact = frame.apply(head)
    error = np.random.default_rng(seed).normal(0.0, noise / np.sqrt(3), exact.shape)
    corpus = Corpus(
        exact + error, chosen.names, tuple(visemes), chosen.groups, frame,
        f"spoken by the bundled head; noise {noise:g} mm, seed {seed}",
    )  # fmt: skip
    return SpokenCorpus(corpus, exact, weights, np.asarray(neutral, np.float32), chosen, speaker)


def viseme_weights(
    speaker: Speaker, neutral: NDArray[np.floating], viseme: str, seed: int = 0
) -> FloatArray:
    """Face-unit weights (52,) at the middle of a viseme, coarticulated with its vowels.

    Raises
    ------
    ParameterError
        If there is no such viseme.
    """
    names = speaker.unit_names
    if viseme in SILENT:
        return np.array([_PREPH.get(n, 0.0) if viseme == "preph" else 0.0 for n in names])
    text, place = spelled(viseme)
    utterance = parse_phonemes(text)
    middle = utterance.segments[place].middle
    spoken = articulate(speaker, neutral, utterance, 1 / middle)
    weights = spoken.weights[1] + subtle(utterance, np.array([middle]), names)[0]
    rng = np.random.default_rng([seed, *map(ord, viseme)])
    return as_it_happens(weights, names, rng)


def bite_plane_of(speaker: Speaker, neutral: NDArray[np.floating]) -> Pose:
    """Head frame to bite-plane frame of a person, by `upper_teeth_of`.

    The skull of the bundled head does not move in its head frame, nor do the upper teeth, so that
    this is one rigid motion for all postures.
    """
    return bite_plane(*upper_teeth_of(speaker, neutral))


def upper_teeth_of(speaker: Speaker, neutral: NDArray[np.floating]) -> FloatArray:
    """Three points (3, 3) of a person's upper teeth, right, left and front, mm, head frame.

    The lowest vertex of the hindmost quarter of the teeth on either side, and the edge of the front
    teeth: the lowest vertex within 5 mm of the middle, moved into it.
    """
    own = np.unique(speaker.faces[speaker.facet_class == speaker.class_id("upper_teeth")])
    place = neutral[own].astype(np.float64)
    x, y, z = place.T
    behind = z < z.min() + (z.max() - z.min()) / 4
    right, left = (place[np.where(behind & side, y, np.inf).argmin()] for side in (x < 0, x > 0))
    ahead = (np.abs(x) < 5.0) & (z > (z.min() + z.max()) / 2)
    front = place[np.where(ahead, y, np.inf).argmin()] * [0.0, 1.0, 1.0]
    return np.stack([right, left, front])
