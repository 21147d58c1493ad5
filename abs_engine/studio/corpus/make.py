"""The corpus of a bundled speaker: visemes spoken by a person, and points measured on the face."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.corpus import Corpus
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.schema import Pair, Unit, by_unit
from abs_engine.io.assets import Speaker
from abs_engine.learn.choice import choose_points
from abs_engine.learn.spoken import SpokenCorpus, bite_plane_of
from abs_engine.studio.corpus.subtle import as_it_happens, subtle
from abs_engine.studio.corpus.visemes import PAPER_VISEMES, SILENT, spelled
from abs_engine.studio.speech import articulate, parse_phonemes

NOISE = 0.3
"""Error (mm) of a measured point: the root mean square of its distance from where it is."""
_PREPH = by_unit({Unit.JAW_OPEN: 0.11, Pair.MOUTH_LOWER_DOWN: 0.06})


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
    neutral : (M, 3) float32, mm, head frame
        The person at rest: one of the speaker's (`Speaker.named`), or any other of its mesh.
    visemes : sequence of str
        Of `visemes.ALL_VISEMES`.
    noise : float
        mm; see `NOISE`. The same in all directions, that along one axis is noise / sqrt(3).
    seed : int
        Of the noise, and of what differs from one utterance to the next.

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
