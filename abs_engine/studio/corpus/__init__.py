"""A corpus of visemes of a bundled speaker, as section 2.1 of Odisio and Bailly (2003) has it."""

from abs_engine.studio.corpus.make import (
    NOISE,
    bite_plane_of,
    speak_corpus,
    upper_teeth_of,
    viseme_weights,
)
from abs_engine.studio.corpus.visemes import ALL_VISEMES, PAPER_VISEMES

__all__ = [
    "ALL_VISEMES",
    "NOISE",
    "PAPER_VISEMES",
    "bite_plane_of",
    "speak_corpus",
    "upper_teeth_of",
    "viseme_weights",
]
