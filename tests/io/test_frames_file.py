"""Frames in memory become a video without loss; what cannot be one is refused, and nothing left."""

from __future__ import annotations

import numpy as np
import pytest

import abs_engine
from abs_engine.io.video import probe, read_frames

NOISE = np.random.default_rng(0).integers(0, 256, (5, 35, 49, 3), np.uint8)


def test_every_pixel_of_any_size_comes_back(tmp_path):
    path = tmp_path / "noise.mp4"
    abs_engine.write_video(path, iter(NOISE), 29.97)
    np.testing.assert_array_equal(list(read_frames(path)), NOISE)
    info = probe(path)
    assert (info.frames, info.size) == (5, (49, 35))
    assert info.rate == pytest.approx(29.97, abs=1e-3)


def test_frames_are_shown_at_their_times(tmp_path):
    path, times = tmp_path / "uneven.mp4", np.array([7.0, 7.04, 7.1, 7.5, 7.54])
    abs_engine.write_video(str(path), NOISE, 25, times)
    np.testing.assert_array_equal(list(read_frames(path)), NOISE)
    np.testing.assert_allclose(probe(path).times, times - 7, atol=2e-5)


@pytest.mark.parametrize(
    ("frames", "rate", "times", "said"),
    [
        ([], 25, None, "there are no frames"),
        (NOISE / 255, 25, None, "frame 0 is float64 of the shape (35, 49, 3); give uint8 RGB"),
        (NOISE[..., 0], 25, None, "frame 0 is uint8 of the shape (35, 49)"),
        ([NOISE[0], NOISE[1, :-1]], 25, None, "frame 1 is 49 x 34, the first 49 x 35"),
        ([NOISE[0], None], 25, None, "frame 1 is NoneType"),
        (NOISE, 0, None, "the rate is 0; give frames per second"),
        (NOISE, float("nan"), None, "the rate is nan"),
        (NOISE, "25", None, "the rate is '25'"),
        (NOISE, 25, [0, 0.1, 0.1, 0.2, 0.3], "the times do not increase"),
        (NOISE, 25, [0, 0.1, float("nan"), 0.2, 0.3], "the times do not increase"),
        (NOISE, 25, [0, 0.1, 0.2, 0.3, float("inf")], "two frames are inf s apart; give seconds"),
        (NOISE, 25, [0, 4e7, 8e7, 1.2e8, 1.6e8], "two frames are 4e+07 s apart"),  # nanoseconds
        (NOISE, 25, [0, 1e-9, 1, 2, 3], "two frames are 1e-09 s apart"),
        (NOISE, 25, list("abcde"), "the times are not numbers; give seconds"),
        (NOISE, 1e-9, None, "the rate is 1e-09; give frames per second"),
        (NOISE, 1e12, None, "the rate is 1000000000000.0"),
        ([np.zeros((1, 17000, 3), np.uint8)], 25, None, "frame 0 is 17000 x 1, more than a video"),
        (NOISE, 25, [0, 0.1, 0.2, 0.3], "4 times were given for another number of frames"),
        (NOISE, 25, np.arange(6), "6 times were given for another number of frames"),
    ],
)
def test_what_is_no_video_is_refused_and_nothing_is_left(frames, rate, times, said, tmp_path):
    with pytest.raises(abs_engine.AbsEngineError) as caught:
        abs_engine.write_video(tmp_path / "out.mp4", frames, rate, times)
    assert said in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_another_ending_or_a_file_that_is_there_is_refused(tmp_path):
    (tmp_path / "there.mp4").touch()
    for name in ("there.mp4", "out.avi"):
        with pytest.raises(
            abs_engine.AbsEngineError, match=r"exists already|does not end in \.mp4"
        ):
            abs_engine.write_video(tmp_path / name, NOISE, 25)
