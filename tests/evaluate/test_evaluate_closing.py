"""Closed lips of landmarks: the truth is measured as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from results import FRAMES, RATE, clip, run_arrays, true_landmarks, wide_rows, write_csv

from abs_engine.evaluate.catalogue import BY_KEY
from abs_engine.evaluate.estimate import of_run
from abs_engine.evaluate.landmark_csv import Reference, read_landmarks
from abs_engine.evaluate.score import measure, summary
from abs_engine.io.assets import CLOSED_APERTURE

KEYS = [
    f"closure_{part}_{unit}" for part in ("precision", "recall") for unit in ("frames", "events")
]


@pytest.fixture(scope="module")
def truth():
    return clip()


def closure_of(estimate, truth):
    scores = summary([measure(estimate, truth, truth.landmarks["landmark_68"])])
    return [scores[key].value for key in KEYS]


def read(path, truth, unit, noise=0.0, seed=0):
    """Landmarks of the truth with noise (mm or px), written to three digits and read again."""
    rng = np.random.default_rng(seed)
    pixels, points = (a + noise * rng.normal(size=a.shape) for a in true_landmarks(truth))
    nothing = np.full_like(pixels, np.nan), np.full_like(points, np.nan)
    heading, rows = wide_rows(
        truth, *((pixels, nothing[1]) if unit == "px" else (nothing[0], points))
    )
    kept = [k for k, name in enumerate(heading) if unit == "both" or not _empty(name, unit)]
    cells = [[round(row[k], 3) for k in kept] for row in rows]
    path = write_csv(path, [heading[k] for k in kept], cells)
    marks = truth.landmarks["landmark_68"]
    return read_landmarks(path, Reference(FRAMES, RATE, truth.neutral.astype(float), marks))


def _empty(name, unit):
    return name[:2] in (("X_", "Y_", "Z_") if unit == "px" else ("x_", "y_"))


@pytest.mark.parametrize("unit", ["px", "mm"])
def test_perfect_landmarks_are_perfect(truth, tmp_path, unit):
    found = read(tmp_path / "a.csv", truth, unit)
    assert found.closed_by == {"px": "picture", "mm": "aperture"}[unit]
    assert closure_of(found, truth) == [1, 1, 1, 1]
    narrow = truth.aperture < CLOSED_APERTURE
    assert (narrow != truth.closed).any(), "the landmarks alone do not show what the mesh shows"


@pytest.mark.parametrize("unit", ["px", "mm"])
def test_nothing_is_won_by_noise(truth, tmp_path, unit):
    quality = []
    for noise in (0.0, 0.5, 2.0):
        runs = [
            closure_of(read(tmp_path / f"{noise}-{k}.csv", truth, unit, noise, k), truth)[0::2]
            for k in range(3)
        ]
        quality.append(np.mean(runs))
    assert quality[0] == 1
    assert quality[0] > quality[1] > quality[2]


def test_a_run_without_a_mesh_that_does_not_say(truth):
    run = run_arrays(truth)
    del run["closed"]
    assert closure_of(of_run("n", run, None, {}), truth) == [1, 1, 1, 1]
    wide = of_run("n", run | {"aperture": truth.aperture + 2 * CLOSED_APERTURE}, None, {})
    assert closure_of(wide, truth)[2:] == [0, 0]


def test_its_own_word_is_held_against_the_mesh(truth):
    said = of_run("n", run_arrays(truth), None, {})
    assert closure_of(said, truth) == [1, 1, 1, 1]
    never = replace(said, closed=np.zeros(FRAMES, bool))
    assert np.isnan(closure_of(never, truth)[0])


def test_the_definition_tells_both_measures():
    for key in ("closure_precision_frames", "closure_recall_frames"):
        assert "62 and 66" in BY_KEY[key].definition
        assert "measured alike" in BY_KEY[key].definition
