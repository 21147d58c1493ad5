"""Recorded ARKit streams."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.dataset.timecode import seconds_since_first, timecodes
from abs_engine.io.assets import load_speaker
from abs_engine.studio.speech import play_recording, read_livelink

UNITS = ("jawOpen", "mouthClose")
HEADER = "Timecode,BlendShapeCount,MouthClose,JawOpen,HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw"


def written(tmp_path, *rows, header=HEADER):
    path = tmp_path / "take.csv"
    path.write_text("\n".join([header, *rows]) + "\n", "utf-8")
    return path


def test_samples_are_joined_by_straight_lines(tmp_path):
    # Three samples at 0, 1/10 and 3/10 s of a 60 Hz timecode; frames at 0, 0.05, ... 0.3 s.
    path = written(
        tmp_path,
        "10:00:00:33.000,61,0.0,0.2,0,0,0,9",
        "10:00:00:39.000,61,0.4,0.4,0.1,0,0,9",
        "10:00:00:51.000,61,0.0,1.4,0.1,0,0,9",
    )
    recording = read_livelink(path)
    np.testing.assert_allclose(recording.times, [0, 0.1, 0.3], atol=1e-9)
    assert recording.unit_names == ("mouthClose", "jawOpen")
    speech = play_recording(recording, UNITS, 20.0)
    np.testing.assert_allclose(speech.weights[:, 0], [0.2, 0.3, 0.4, 0.65, 0.9, 1, 1], atol=1e-6)
    np.testing.assert_allclose(speech.weights[:, 1], [0, 0.2, 0.4, 0.3, 0.2, 0.1, 0], atol=1e-6)
    np.testing.assert_allclose(speech.head[[1, 6]], [[0, -0.05, 0], [0, -0.1, 0]], atol=1e-6)
    assert len(speech) == 7
    assert set(speech.phonemes) == {"_"}


def test_lost_frames_of_an_export_are_bridged(tmp_path):
    path = written(
        tmp_path,
        "1:0:0:0,61,0,0,0,0,0,0", "1:0:0:15,61,,,,,,", "1:0:0:30,61,1,0.5,0,0,0,0",
        "1:0:0:59,61,,,,,,",
    )  # fmt: skip
    recording = read_livelink(path)  # whose rate the last, lost frame tells
    np.testing.assert_allclose(recording.times, [0, 0.25, 0.5, 59 / 60])
    speech = play_recording(recording, UNITS, 4.0)
    expected = [[0, 0], [0.25, 0.5], [0.5, 1], [0.5, 1], [0.5, 1]]
    np.testing.assert_allclose(speech.weights, expected, atol=1e-9)
    with pytest.raises(InputFileError, match="every frame"):
        read_livelink(written(tmp_path, "1:0:0:0,61,,,,,,"))
    with pytest.raises(InputFileError, match="has 2 values"):
        read_livelink(written(tmp_path, "1:0:0:0,61,0,0,0,0,0,0", "1:0:0:9,61"))


def test_yaw_turns_first_then_pitch_then_roll(tmp_path):
    path = written(tmp_path, "1:0:0:0,61,0,0,0.5,0.3,0.2,0", "1:0:0:1,61,0,0,0.5,0.3,0.2,0")
    head = play_recording(read_livelink(path), UNITS, 10.0).head[0]

    def about(axis, angle):
        c, s = np.cos(angle), np.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
        return turn

    expected = about(1, -0.5) @ about(0, 0.3) @ about(2, -0.2)
    angle = np.arccos((np.trace(expected) - 1) / 2)
    skew = (expected - expected.T) / (2 * np.sin(angle)) * angle
    np.testing.assert_allclose(head, [skew[2, 1], skew[0, 2], skew[1, 0]], atol=1e-12)


def test_the_timecode_counts_at_the_smallest_usual_rate(tmp_path):
    codes = [*(f"23:59:59:{frame}" for frame in (0, 12, 23)), "00:00:00:12"]  # past midnight
    path = written(tmp_path, *(f"{code},61,0,0,0,0,0,0" for code in codes))
    np.testing.assert_allclose(read_livelink(path).times, [0, 0.5, 23 / 24, 1.5])
    np.testing.assert_allclose(seconds_since_first(codes, path, 30)[1:3], [0.4, 23 / 30])


@pytest.mark.parametrize(("rate", "code"), [
    (25.0, "00:00:02:08.000"), (12.5, "00:00:02:07.680"), (30000 / 1001, "00:00:02:09.600"),
    (24.96, "00:00:02:08.000"), (240.0, "00:00:02:38.400"),
])  # fmt: skip
def test_timecodes_are_written_as_they_are_read(rate, code, tmp_path):
    """They had counted rounded frames: at 12.5 frames a second they ran 4 % slow."""
    assert timecodes(np.array([2.32]), rate) == [code]
    assert timecodes(np.array([3661.0]), rate) == ["01:01:01:00.000"]
    for times in (np.arange(0, 3, 1 / rate), np.cumsum(np.tile([0.5, 1.7, 0.8], 50)) / rate):
        read = seconds_since_first(timecodes(times, rate), tmp_path)
        np.testing.assert_allclose(read, times - times[0], atol=1e-4)


def test_timecodes_by_hand(tmp_path):
    got = seconds_since_first(["01:00:00:00.000", "01:00:01:30.500"], tmp_path)
    np.testing.assert_allclose(got, [0, 1 + 30.5 / 48])  # 48: the least rate above 30.5
    got = seconds_since_first([" 1:0:0:0", "1:0:0:150 ", "1:0:1:0"], tmp_path)
    np.testing.assert_allclose(got, [0, 150 / 151, 1])  # of no usual rate
    night = seconds_since_first(["23:59:59:0", "00:00:00:0"], tmp_path)
    np.testing.assert_allclose(night, [0, 1])
    with pytest.raises(
        InputFileError, match=r"line 3 .*'1:2:3' is not a timecode.*hh:mm:ss:ff\.fff"
    ):
        seconds_since_first(["1:2:3:4", "1:2:3"], tmp_path)
    with pytest.raises(InputFileError, match=r"line 2 .*is not a timecode"):
        seconds_since_first([f"{'9' * 400}:0:0:0"], tmp_path)  # no finite time


@pytest.mark.parametrize(
    ("rows", "named"),
    [
        ([], "no samples"),
        (["1:0:0:0,61,0,0,0,0,0"], "line 2"),
        (["1:0:0:0,61,0,0,0,0,0,0", "1:0:0:1,61,0,x,0,0,0,0"], "convert"),
        (["1:0:0:0,61,0,0,0,0,0,0", "1:0:0:1,61,0,nan,0,0,0,0"], "line 3"),
        (["noon,61,0,0,0,0,0,0"], "'noon' is not a timecode"),
        (["1:0:0:4,61,0,0,0,0,0,0", "1:0:0:2,61,0,0,0,0,0,0"], "line 3"),
        (["", "1:0:0:4,61,0,0,0,0,0,0", "", "1:0:0:2,61,0,0,0,0,0,0"], "line 5"),
        (["", "1:0:0:4,61,0,0,0,0,0"], "line 3"),
        (["", "noon,61,0,0,0,0,0,0"], "line 3"),
    ],
)
def test_bad_recordings_are_refused_in_one_line(tmp_path, rows, named):
    path = written(tmp_path, *rows)
    with pytest.raises(InputFileError, match="; ") as caught:
        read_livelink(path)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_other_files_and_missing_units_are_named(tmp_path):
    with pytest.raises(InputFileError, match="does not exist"):
        read_livelink(tmp_path / "none.csv")
    with pytest.raises(InputFileError, match="does not begin with Timecode"):
        read_livelink(written(tmp_path, "1,2", header="a,b"))
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe\x00")
    with pytest.raises(InputFileError, match="is not text; give a Live Link"):
        read_livelink(tmp_path / "picture.csv")
    path = written(tmp_path, "1:0:0:0,61,0,0,0,0,0,0", "1:0:0:9,61,0,0,0,0,0,0")
    with pytest.raises(ParameterError, match="no 'tongueOut'"):
        play_recording(read_livelink(path), ("jawOpen", "tongueOut"), 25.0)
    with pytest.raises(ParameterError, match="frame rate"):
        play_recording(read_livelink(path), UNITS, 0.0)
    path = written(tmp_path, "0:0:0:0,61,0,0,0,0,0,0", "999999999:0:0:0,61,0,0,0,0,0,0")
    with pytest.raises(ParameterError, match="correct its timecodes"):
        play_recording(read_livelink(path), UNITS, 25.0)


def test_a_real_recording_drives_the_head(data_dir):
    path = data_dir / "livelink_rom" / "alex_rom_3.csv"
    if not path.is_file():
        pytest.skip(f"the recording {path.name} is missing")
    recording = read_livelink(path)
    names = load_speaker().unit_names
    assert recording.weights.shape == (4030, 52)
    # From 13:13:04:31.652 to 13:15:18:54.561, of 60 frames a second.
    assert recording.times[-1] == pytest.approx(134 + 22.909 / 60, abs=1e-3)
    speech = play_recording(recording, names, 25.0)
    assert speech.weights.shape == (3360, 52)
    jaw = recording.weights[:, recording.unit_names.index("jawOpen")]
    at = int(jaw.argmax())
    near = round(recording.times[at] * 25)
    assert speech.weights[near - 1 : near + 2, names.index("jawOpen")].max() > 0.95 * jaw[at]


@pytest.mark.parametrize("last", ["59.600", "59.999", "60.020"])
def test_the_last_frame_is_there_though_its_timecode_is_early_or_late(tmp_path, last):
    rows = "09:59:59:60.000,61,0,0.2,0,0,0,0", f"10:00:00:{last},61,0,0.4,0,0,0,0"  # of 120
    recording = read_livelink(written(tmp_path, *rows))
    assert len(play_recording(recording, UNITS, 60.0)) == 61


@pytest.mark.parametrize(("hours", "begins"), [("00:00", 0.04), ("01:02", 0.0)])
def test_first_rows_that_are_missing_leave_the_others_where_they_were(tmp_path, hours, begins):
    """Where timecodes count from 0; those of a clock begin with the first row."""
    codes = [f"{hours}:{k // 25:02d}:{k % 25:02d}.000" for k in range(1, 40)]
    rows = [f"{code},1,{k / 100:.2f}" for k, code in enumerate(codes, start=1)]
    path = tmp_path / "own.csv"
    path.write_text("\n".join(["Timecode,BlendShapeCount,JawOpen", *rows]))
    recording = read_livelink(path)
    assert recording.times[0] == pytest.approx(begins)
    speech = play_recording(recording, ("jawOpen",), 25.0)
    assert speech.weights[10, 0] == pytest.approx(0.1 if begins else 0.11)
