"""People for the studio: shapes of their own, and skin that is painted when it is needed."""

from abs_engine.studio.people.cast import random_person
from abs_engine.studio.people.dots import DOT_SETS, Dots, dots
from abs_engine.studio.people.paint import paint
from abs_engine.studio.people.person import Person, identity_vector, neutral
from abs_engine.studio.people.tones import SKIN_TONES, lip_colour, skin_tone

__all__ = [
    "DOT_SETS", "SKIN_TONES", "Dots", "Person", "dots", "identity_vector", "lip_colour",
    "neutral", "paint", "random_person", "skin_tone",
]  # fmt: skip
