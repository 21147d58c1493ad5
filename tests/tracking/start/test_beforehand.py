"""What is loaded beside the imports is what is used, and what is wrong is left for later."""

from __future__ import annotations

import subprocess
import sys

import pytest

from abs_engine.face import identity
from abs_engine.face.shape.population import average_person
from abs_engine.tracking.landmark import landmark_jacobian
from abs_engine.tracking.person.scale import pupil_distance, pupil_scale
from abs_engine.tracking.start import beforehand


def modes_kept():
    return identity._anybody.__wrapped__.cache_info().misses


@pytest.mark.parametrize("pupils", [None, 61.5])
def test_the_head_is_there_when_it_is_needed(pupils):
    identity._anybody.__wrapped__.cache_clear()
    beforehand.load(pupils, unknown=True)
    speaker = average_person()
    before = modes_kept()
    size = pupil_scale(pupils).pupils / pupil_distance(speaker, speaker.vertices)
    identity.sized_head(speaker, size)
    assert modes_kept() == before == 1


def test_of_a_known_person_no_modes_are_made():
    identity._anybody.__wrapped__.cache_clear()
    beforehand.load(None, unknown=False)
    assert modes_kept() == 0


def test_a_distance_that_is_none_is_left_to_whoever_needs_it():
    beforehand.load(3.0, unknown=True)


def test_scipy_is_left_to_clips_that_need_it():
    landmark_jacobian.load()  # compiled now, if it never was
    said = (
        "import sys\nfrom abs_engine.tracking import loop, run\n"
        "from abs_engine.tracking.landmark import landmark_jacobian\n"
        "from abs_engine.tracking.models import heads\n"
        "landmark_jacobian.load()\n"
        "print({'scipy.linalg', 'scipy.optimize', 'scipy.spatial'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
