"""Pictures are read as they are shown: square pixels, edit lists, fields, sound beside them."""

from __future__ import annotations

import struct
import subprocess
import sys
from fractions import Fraction
from types import SimpleNamespace

import av
import cv2
import numpy as np
import pytest
from av.stream import Disposition
from PIL import Image, ImageCms, ImageOps
from runs import drift, turned, write_kind

from abs_engine.core.camera import Camera
from abs_engine.io.video import probe, read_frames
from abs_engine.io.video.shown import Pictures, Turn, shown_size
from abs_engine.tracking.footage import footage_lines

SIZE = (96, 80)


def turn_by(a, b, c, d):
    """The turn of a display matrix as FFmpeg has it, see its libavutil/display.h."""
    entries = [round(v * 65536) for v in (a, b, 0, c, d, 0, 0, 0, 16384)]
    return Turn.by(np.array(entries, np.int32))


def write(path, pictures, aspect=None, options=None, sound=None, begins=0.0, heard=0.0):
    """A video with pixels of an aspect, x264's options, and a sound from 0 s on."""
    with av.open(str(path), "w") as container:
        pitch = container.add_stream("aac", rate=48000, layout="mono") if sound else None
        stream = container.add_stream("libx264", rate=25)
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt, stream.options = "yuv420p", options or {}
        stream.codec_context.time_base = Fraction(1, 1000)
        if aspect is not None:
            stream.codec_context.sample_aspect_ratio = aspect
        packets = []
        for k in range(round((sound or 0) * 48000) // 1024):
            silence = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), "fltp", "mono")
            silence.sample_rate, silence.pts = 48000, 1024 * k + round(48000 * heard)
            silence.time_base = Fraction(1, 48000)
            packets += pitch.encode(silence)
        for k, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            frame.pts, frame.time_base = round(1000 * begins) + 40 * k, Fraction(1, 1000)
            packets += stream.encode(frame)
        packets += stream.encode() + (pitch.encode() if pitch else [])
        for packet in sorted(packets, key=lambda p: float((p.dts or 0) * p.time_base)):
            container.mux(packet)
    return path


@pytest.mark.parametrize(
    ("aspect", "size"),
    [
        (None, (96, 80)), (Fraction(1), (96, 80)), (Fraction(4, 3), (128, 80)),
        (Fraction(2, 3), (96, 120)), (Fraction(389, 388), (96, 80)), (Fraction(9), (96, 80)),
    ],
)  # fmt: skip
def test_pixels_are_square(tmp_path, aspect, size):
    coded = [cv2.GaussianBlur(p, (0, 0), 3) for p in drift(3)]
    path = write(tmp_path / "v.mp4", coded, aspect)
    assert probe(path).size == size
    for frame, picture in zip(read_frames(path), coded, strict=True):
        assert frame.shape == (size[1], size[0], 3)
        assert np.abs(cv2.resize(frame, SIZE).astype(float) - picture).mean() < 4


@pytest.mark.parametrize(("aspect", "size"), [(4 / 3, (128, 80)), (2 / 3, (96, 120))])
def test_pixels_are_stretched_before_the_picture_is_turned(aspect, size):
    coded = cv2.GaussianBlur(drift(1)[0], (0, 0), 2)
    turn = turn_by(0, -1, 1, 0)  # a quarter turn counter-clockwise
    frame = av.VideoFrame.from_ndarray(coded, format="rgb24")
    assert shown_size(frame, aspect, turn) == size
    found = Pictures().shown(frame, aspect, turn)
    np.testing.assert_array_equal(found, np.rot90(cv2.resize(coded, size)))


def test_one_converter_does_for_all_kinds_of_frames():
    """As a converter of its own for each, and leaves what it made before as it was."""
    kinds = ("yuv420p", "yuv444p10le", "rgb24", "gray", "nv12", "yuv420p")
    coded = [av.VideoFrame.from_ndarray(p, format="rgb24") for p in drift(len(kinds))]
    frames = [frame.reformat(format=kind) for frame, kind in zip(coded, kinds, strict=True)]
    frames.append(frames[0].reformat(width=64, height=48))
    pictures = Pictures()
    found = [pictures.shown(frame, 1.0, Turn()) for frame in frames]
    for frame, picture in zip(frames, found, strict=True):
        np.testing.assert_array_equal(picture, frame.to_ndarray(format="rgb24"))


def test_stretched_pictures_have_even_sides():
    frame = SimpleNamespace(height=480, width=720)
    assert shown_size(frame, 32 / 27, Turn()) == (480, 854)


@pytest.mark.parametrize(
    ("angle", "turn", "askew"),
    [
        (0.0, 0, False), (0.5, 0, False), (10.0, 0, True), (80.0, -1, True), (90.4, -1, False),
        (170.0, 2, True), (-90.0, 1, False),
    ],
)  # fmt: skip
def test_another_angle_is_read_as_the_nearest_quarter_turn(angle, turn, askew):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    found = turn_by(c, s, -s, c)
    picture = drift(1)[0]
    np.testing.assert_array_equal(found(picture), np.rot90(picture, turn))
    assert found.askew == askew


def read_apart(path):
    """Frames (T, H, W, 3) of a file as another process reads them, which may die of it."""
    read = (
        "import sys, numpy as np; from pathlib import Path; from abs_engine.io.video import *; "
        "path = Path(sys.argv[1]); probe(path); np.save(sys.argv[2], [*read_frames(path)])"
    )
    kept = path.with_suffix(".npy")
    done = subprocess.run(
        [sys.executable, "-c", read, path, kept], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return np.load(kept)


def with_profile():
    """Bytes of a colour profile, which has a name."""
    return ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


@pytest.mark.parametrize(
    ("kind", "orientation"),
    [("png", None), ("png", 6), ("tiff", 4), ("webp", 5), ("jpeg", 1), ("jpeg", 2)],
)
def test_a_picture_with_a_profile_is_read_as_its_exif_says(tmp_path, kind, orientation):
    picture = Image.fromarray(drift(1)[0])
    if orientation is not None:
        picture.getexif()[0x112] = orientation
    path = tmp_path / f"v.{kind}"
    exactly = {"webp": {"lossless": True, "exact": True}, "jpeg": {"quality": 95, "subsampling": 0}}
    picture.save(path, icc_profile=with_profile(), exif=picture.getexif(), **exactly.get(kind, {}))
    (frame,) = read_apart(path)
    upright = np.asarray(ImageOps.exif_transpose(picture))
    assert np.abs(frame.astype(float) - upright).mean() < 4  # WebP is read by way of YUV


def test_a_film_of_pictures_with_a_profile_is_read(tmp_path):
    Image.fromarray(drift(1)[0]).save(tmp_path / "v.png", icc_profile=with_profile())
    with av.open(str(tmp_path / "v.mov"), "w") as container:
        stream = container.add_stream("png", rate=10)
        (stream.width, stream.height), stream.pix_fmt = SIZE, "rgb24"
        for k in range(3):
            packet = av.Packet((tmp_path / "v.png").read_bytes())
            packet.pts = packet.dts = k
            packet.stream, packet.time_base = stream, Fraction(1, 10)
            packet.is_keyframe = True
            container.mux(packet)
    np.testing.assert_array_equal(read_apart(tmp_path / "v.mov"), [drift(1)[0]] * 3)


def test_a_video_that_is_shown_askew_is_named(tmp_path):
    path = write(tmp_path / "v.mp4", drift(3))
    assert not probe(path).askew
    c, s = np.cos(0.5), np.sin(0.5)
    info = probe(turned(path, (c, s, -s, c)))
    assert info.askew
    (line,) = footage_lines(info)
    assert "not a multiple of 90 degrees" in line


def test_frames_that_an_edit_list_leaves_out_are_not_counted(tmp_path):
    stamps = [70 * k for k in range(10)] + [700 + 30 * k for k in range(20)]
    path = write_kind(tmp_path / "v.mp4", "libx264", drift(30), stamps=stamps)
    held = bytearray(path.read_bytes())
    at = held.find(b"elst") + 12
    duration, begins = struct.unpack(">Ii", held[at : at + 8])
    with av.open(str(path)) as container:
        skipped = round(0.7 / container.streams.video[0].time_base)
    held[at : at + 8] = struct.pack(">Ii", round(duration * 0.6 / 1.3), begins + skipped)
    path.write_bytes(held)
    info = probe(path)
    assert info.frames == len(info.times) == sum(1 for _ in read_frames(path)) == 20
    np.testing.assert_allclose(info.times, 0.03 * np.arange(20), atol=1e-3)


def test_interlaced_video_is_named(tmp_path):
    fields = {"flags": "+ilme+ildct", "x264-params": "tff=1"}
    info = probe(write(tmp_path / "v.mp4", drift(4), options=fields))
    assert info.interlaced
    assert "deinterlace it first" in footage_lines(info)[0]
    assert not probe(write(tmp_path / "w.mp4", drift(4))).interlaced


@pytest.mark.parametrize(
    ("codec", "suffix", "rate", "clock"),
    [
        ("libx264", "h264", 50, "stream"), ("mpeg2video", "m2v", 50, "stream"),
        ("mjpeg", "mjpeg", 25, "nothing"),
    ],
)  # fmt: skip
def test_a_raw_stream_has_the_rate_that_it_states(tmp_path, codec, suffix, rate, clock):
    info = probe(write_kind(tmp_path / f"v.{suffix}", codec, drift(10), rate=50))
    assert (info.rate, info.frames, info.times, info.clock) == (rate, 10, (), clock)
    (line,) = footage_lines(info)
    assert line.startswith(f"the file holds no times: {rate} frames a second are assumed")
    assert ("its stream states" in line) == (clock == "stream")


def test_a_file_whose_pictures_all_have_one_time_has_the_rate_that_it_states(tmp_path):
    kept = write_kind(tmp_path / "v.mp4", "libx264", drift(10), rate=50)
    with av.open(str(kept)) as whole, av.open(str(tmp_path / "w.mkv"), "w") as container:
        stream = container.add_stream_from_template(whole.streams.video[0])
        for packet in whole.demux():
            if packet.size:
                packet.stream, packet.pts, packet.dts = stream, 0, 0
                container.mux(packet)
    info = probe(tmp_path / "w.mkv")
    assert (info.rate, info.frames, info.times, info.clock) == (50, 10, (), "stream")
    assert footage_lines(info)[0].startswith("the file holds no times: 50 frames a second")


def test_a_file_that_holds_times_is_not_named(tmp_path):
    info = probe(write_kind(tmp_path / "v.mp4", "libx264", drift(10), rate=50))
    assert (info.rate, info.clock) == (50, "file")
    assert footage_lines(info) == []


def test_a_camera_calibrated_at_another_size_is_named(tmp_path):
    info = probe(write_kind(tmp_path / "v.mp4", "libx264", drift(2), rate=50))
    own = Camera.ideal(info.size)
    assert footage_lines(info, own) == []
    for scale in (0.5, 1.5):
        (line,) = footage_lines(info, Camera(np.diag([scale, scale, 1]) @ own.matrix, own.size))
        assert line.endswith("calibrated at another size; scale its matrix")


def write_two(path, default):
    """A small and a large video in one file, and whether each is its default."""
    with av.open(str(path), "w") as container:
        streams = [container.add_stream("libx264", rate=25) for _ in range(2)]
        for stream, size, chosen in zip(streams, ((48, 40), SIZE), default, strict=True):
            stream.width, stream.height = size
            stream.pix_fmt = "yuv420p"
            stream.disposition = Disposition.default if chosen else Disposition(0)
        for picture in drift(5):
            for stream in streams:
                small = cv2.resize(picture, (stream.width, stream.height))
                container.mux(stream.encode(av.VideoFrame.from_ndarray(small, format="rgb24")))
        for stream in streams:
            container.mux(stream.encode())
    return path


@pytest.mark.parametrize(
    ("default", "size"),
    [
        ((False, False), SIZE), ((True, True), SIZE), ((False, True), SIZE),
        ((True, False), (48, 40)),
    ],
)  # fmt: skip
def test_of_several_videos_the_default_or_the_largest_is_read(tmp_path, default, size):
    path = write_two(tmp_path / "v.mkv", default)
    info = probe(path)
    assert (info.size, info.frames, info.streams) == (size, 5, 2)
    assert {frame.shape for frame in read_frames(path)} == {(size[1], size[0], 3)}
    (line,) = footage_lines(info)
    assert line.startswith("the file holds 2 videos")
    assert f"here {size[0]}x{size[1]} pixels" in line


@pytest.mark.parametrize("kind", ["mp4", "mkv"])
def test_sound_that_begins_before_the_pictures_is_named(tmp_path, kind):
    info = probe(write(tmp_path / f"v.{kind}", drift(5), sound=1.0, begins=0.5))
    assert info.times[0] == 0
    assert info.sound == pytest.approx(-0.5, abs=0.03)
    (line,) = footage_lines(info)
    assert line.startswith("the sound begins 0.")
    assert "s before the first picture" in line
    assert "add 0." in line
    together = probe(write(tmp_path / f"w.{kind}", drift(5), sound=1.0))
    assert abs(together.sound) < 0.04
    assert footage_lines(together) == []


@pytest.mark.parametrize("kind", ["mp4", "mkv", "ts"])
def test_sound_that_begins_later_is_named(tmp_path, kind):
    info = probe(write(tmp_path / f"v.{kind}", drift(40), sound=1.0, heard=0.5))
    assert info.sound == pytest.approx(0.5, abs=0.03)
    (line,) = footage_lines(info)
    assert "s after the first picture" in line
    assert "subtract 0." in line
