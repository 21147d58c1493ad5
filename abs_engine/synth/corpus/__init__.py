"""A corpus of visemes of a bundled speaker, as section 2.1 of Odisio and Bailly (2003) has it."""

from abs_engine.synth.corpus.choice import COUNT, Points, choose_points
from abs_engine.synth.corpus.make import (
    NOISE,
    SpokenCorpus,
    bite_plane_of,
    speak_corpus,
    spoken_heads,
    upper_teeth_of,
    viseme_weights,
)
from abs_engine.synth.corpus.visemes import ALL_VISEMES, PAPER_VISEMES

__all__ = [
    "ALL_VISEMES",
    "COUNT",
    "NOISE",
    "PAPER_VISEMES",
    "Points",
    "SpokenCorpus",
    "bite_plane_of",
    "choose_points",
    "speak_corpus",
    "spoken_heads",
    "upper_teeth_of",
    "viseme_weights",
]
