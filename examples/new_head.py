"""A new head: a morphable mesh of one's own; here the bundled one with a longer jaw.

Try it: abs-engine track CLIP -o RUN --plugin examples/new_head.py --model long-jawed
"""

from dataclasses import replace

import numpy as np

from abs_engine import MODELS, load_speaker, prepare_head

JAW, CHIN = 6.0, -70.0  # mm


def prepare_long_jawed(clip, options, leaves, renderer, stage):
    """Make a clip ready with another head; any mesh with a speaker's arrays would do."""
    speaker = load_speaker()
    vertices = speaker.vertices.copy()
    vertices[:, 1] -= JAW * np.clip(vertices[:, 1] / CHIN, 0, 1)
    own = replace(speaker, vertices=vertices)
    return prepare_head(clip, options, leaves, renderer, stage, own)


MODELS.add("long-jawed", prepare_long_jawed)
