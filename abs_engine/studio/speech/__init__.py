"""Speech: phonemes or recordings to face-unit weights, frame by frame."""

from abs_engine.studio.speech.articulate import Speech, articulate
from abs_engine.studio.speech.livelink import play_recording, read_livelink
from abs_engine.studio.speech.notation import doubtful
from abs_engine.studio.speech.textgrid import read_textgrid
from abs_engine.studio.speech.utterance import Segment, Utterance, parse_phonemes

__all__ = [
    "Segment", "Speech", "Utterance", "articulate", "doubtful", "parse_phonemes",
    "play_recording", "read_livelink", "read_textgrid",
]  # fmt: skip
