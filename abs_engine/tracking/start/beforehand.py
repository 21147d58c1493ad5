"""Head, modes, tables and the code's digest: what any video needs, made while imports go on."""

from __future__ import annotations

from contextlib import suppress

import cv2
import numpy as np


def load(pupils: float | None, unknown: bool) -> None:
    """Load OpenCV's tables, the head, for an `unknown` person its modes, and the code's digest.

    This takes half a second. The modes are those of a head whose `pupils` are so far apart (mm).
    Errors of the head or that distance are ignored here: whoever needs the head raises them again.
    """
    load_tables()
    # only now, so that the tables are made while others import them
    from abs_engine.core.errors import AbsEngineError
    from abs_engine.core.provenance import code_digest
    from abs_engine.core.threads import one_thread
    from abs_engine.face.identity import sized_head
    from abs_engine.face.shape.population import average_person
    from abs_engine.tracking.person.scale import pupil_distance, pupil_scale

    code_digest()  # which is asked for first
    with suppress(AbsEngineError):
        apart = pupil_scale(pupils).pupils
        if unknown:
            with one_thread():
                speaker = average_person()
                sized_head(speaker, apart / pupil_distance(speaker, speaker.vertices))


def load_tables() -> None:
    """Make OpenCV's tables for L*a*b*, which otherwise delay the first picture."""
    cv2.cvtColor(np.zeros((1, 1, 3), np.uint8), cv2.COLOR_RGB2LAB)
