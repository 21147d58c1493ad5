"""Smoothing where it is asked for: what the filters pass, gaps, and what cannot be."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.tracking.results.smoothing import Smoothing

RATE = 25.0
TIME = np.arange(200) / RATE
NO_CUT = np.zeros(200, bool)
MIDDLE = slice(50, 150)  # away from the ends


def wave(hertz):
    return np.sin(2 * np.pi * hertz * TIME)


def passed(smoothing, hertz):
    """Share of a wave's amplitude that is left."""
    out = smoothing(wave(hertz), RATE, NO_CUT)
    return float(out[MIDDLE] @ wave(hertz)[MIDDLE] / (wave(hertz)[MIDDLE] @ wave(hertz)[MIDDLE]))


def test_a_low_pass_leaves_half_at_its_cutoff_and_does_not_delay():
    low = Smoothing.named("butterworth:6")
    assert passed(low, 1) == pytest.approx(1, abs=0.01)
    assert passed(low, 6) == pytest.approx(0.5, abs=0.01)
    assert passed(low, 11) < 0.02


def test_a_window_leaves_a_parabola_as_it_is():
    curve = 3 + 2 * TIME - TIME**2
    out = Smoothing.named("savitzky-golay:9")(curve, RATE, NO_CUT)
    np.testing.assert_allclose(out, curve, atol=1e-9)
    assert abs(passed(Smoothing.named("savitzky-golay:9"), 11)) < 0.3


@pytest.mark.parametrize("text", ["butterworth:6", "savitzky-golay:9"])
def test_stretches_between_gaps_are_smoothed_by_themselves(text):
    curve, smoothing = wave(2) + 0.1 * wave(11), Smoothing.named(text)
    curve[[60, 64]] = np.nan
    out = smoothing(curve, RATE, NO_CUT)
    assert np.isnan(out).tolist() == np.isnan(curve).tolist()
    np.testing.assert_array_equal(out[61:64], curve[61:64])  # too short
    np.testing.assert_array_equal(out[:60], smoothing(curve[:60], RATE, NO_CUT[:60]))
    both = smoothing(np.stack([curve, 2 * curve], axis=1), RATE, NO_CUT)
    np.testing.assert_allclose(both, np.stack([out, 2 * out], axis=1))


@pytest.mark.parametrize("text", ["butterworth:6", "savitzky-golay:9"])
def test_shots_are_smoothed_by_themselves(text):
    curve, smoothing = wave(2) + np.where(TIME < 4, 0, 9), Smoothing.named(text)
    out = smoothing(curve, RATE, TIME == 4)
    np.testing.assert_array_equal(out[:100], smoothing(curve[:100], RATE, NO_CUT[:100]))
    np.testing.assert_array_equal(out[100:], smoothing(curve[100:], RATE, NO_CUT[:100]))
    assert smoothing(np.zeros(0), RATE, NO_CUT[:0]).size == 0


def test_measures_are_smoothed_and_velocities_are_those_of_smoothed_curves():
    smoothing = Smoothing.named("butterworth:6")
    aperture = 4 * np.clip(wave(2), 0, None) + 0.2 * wave(11)
    arrays = {"rate": RATE, "time": TIME, "aperture": aperture, "width": 40 + wave(2),
              "jaw_opening": np.full(len(TIME), np.nan)}  # fmt: skip
    found = smoothing.measures(arrays)
    assert found["aperture"].min() == 0
    rough, smooth = (np.abs(np.diff(one)).max() for one in (aperture, found["aperture"]))
    assert smooth < 0.9 * rough
    slope = (found["width"][2:] - found["width"][:-2]) * RATE / 2
    np.testing.assert_allclose(found["width_velocity"][1:-1], slope)
    assert np.isnan(found["jaw_velocity"]).all()


def test_angles_are_smoothed_across_half_a_turn():
    """The roll of a face that is upside down jumps from 180 to -180 degrees."""
    smoothing, roll = Smoothing.named("butterworth:6"), 180 + 3 * wave(2) + 0.2 * wave(11)
    roll[60] = np.nan
    arrays = {"rate": RATE, "time": TIME, "aperture": wave(2),
              "head_roll": np.where(roll > 180, roll - 360, roll)}  # fmt: skip
    found = smoothing.measures(arrays)["head_roll"]
    assert np.nanmax(np.abs(found)) <= 180
    np.testing.assert_allclose(found % 360, smoothing(roll, RATE, NO_CUT), atol=1e-9)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("buterworth:6", "did you mean 'butterworth'"), ("butterworth", "frequency in Hz"),
        ("butterworth:-1", "frequency in Hz"), ("butterworth:nan", "frequency in Hz"),
        ("savitzky-golay:6", "odd number of frames"), ("savitzky-golay:3", "5 or more"),
    ],
)  # fmt: skip
def test_what_is_no_filter_is_refused(text, said):
    with pytest.raises(ParameterError, match=said):
        Smoothing.named(text)


def test_what_the_frames_do_not_allow_is_refused():
    with pytest.raises(ParameterError, match=r"nothing above 12\.5 Hz"):
        Smoothing.named("butterworth:12.5").check(RATE, TIME)
    with pytest.raises(ParameterError, match="not evenly spaced"):
        Smoothing.named("savitzky-golay:5").check(RATE, np.r_[TIME, TIME[-1] + 0.1])
    with pytest.raises(ParameterError, match="not evenly spaced"):  # no lower cutoff would do
        Smoothing.named("butterworth:13").check(RATE, np.r_[TIME, TIME[-1] + 0.1])
    Smoothing.named("butterworth:12").check(RATE, TIME)


@pytest.mark.parametrize("rate", [24.0, 30000 / 1001, 30.0, 60.0, 240.0])
def test_times_in_whole_milliseconds_are_even(rate):
    times = np.round(np.arange(200) / rate, 3)
    Smoothing.named("savitzky-golay:5").check(rate, times)
    for uneven in (np.delete(times, 50), np.r_[times[:50], times[50:] + 0.5 / rate], 1.02 * times):
        with pytest.raises(ParameterError, match="not evenly spaced"):
            Smoothing.named("savitzky-golay:5").check(rate, uneven)


def test_a_clip_that_is_shorter_than_the_filter_is_refused():
    with pytest.raises(ParameterError, match="and there are 75; give a shorter window"):
        Smoothing.named("savitzky-golay:101").check(25.0, np.arange(75) / 25.0)
    Smoothing.named("savitzky-golay:75").check(25.0, np.arange(75) / 25.0)
    with pytest.raises(ParameterError, match="and there are 5; give a shorter window"):
        Smoothing.named("savitzky-golay:7").check(25.0, np.arange(5) / 25.0)
    with pytest.raises(ParameterError, match="and there are 4; give a longer run"):  # 5 is least
        Smoothing.named("savitzky-golay:5").check(25.0, np.arange(4) / 25.0)
    with pytest.raises(ParameterError, match="and there are 5; give a longer run, or leave out"):
        Smoothing.named("butterworth:8").check(25.0, np.arange(5) / 25.0)


def test_a_cutoff_below_one_wave_of_the_clip_is_refused():
    with pytest.raises(ParameterError, match=r"longer than the clip's 3\.0 s"):
        Smoothing.named("butterworth:0.3").check(25.0, np.arange(75) / 25.0)
    Smoothing.named("butterworth:0.4").check(25.0, np.arange(75) / 25.0)
