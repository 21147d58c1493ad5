"""A corpus of visemes of a bundled speaker, as section 2.1 of Odisio and Bailly (2003) has it."""

from abs_engine.studio.corpus.make import NOISE, speak_corpus, viseme_weights
from abs_engine.studio.corpus.visemes import ALL_VISEMES, PAPER_VISEMES

__all__ = ["ALL_VISEMES", "NOISE", "PAPER_VISEMES", "speak_corpus", "viseme_weights"]
