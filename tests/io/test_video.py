"""Video: what was written comes back; files that are wrong say so."""

from __future__ import annotations

import os
import re
from pathlib import Path

import av
import numpy as np
import pytest
from av.stream import Disposition
from runs import drift, noise, turned, write_broken, write_kind, write_noise

from abs_engine.core.errors import InputFileError, VideoError
from abs_engine.io.video import VideoWriter, probe, read_frames
from abs_engine.io.video.truncation import is_torn


@pytest.mark.parametrize("size", [(96, 80), (97, 81)])
def test_lossless_video_comes_back_bit_for_bit(tmp_path, size):
    pictures = noise(7, size)
    with VideoWriter(tmp_path / "v.mp4", size, 29.97, crf=0) as writer:
        for picture in pictures:
            writer.write(picture)
    np.testing.assert_array_equal(list(read_frames(tmp_path / "v.mp4")), pictures)
    info = probe(tmp_path / "v.mp4")
    assert info.size == size
    assert info.rate == pytest.approx(29.97, abs=0.01)
    assert info.frames == 7


def test_ordinary_video_is_close_and_in_order(tmp_path):
    ramp = np.mgrid[:80, :97][1][..., None] * np.array([1.0, 0.5, 0.2])
    pictures = [np.uint8(np.clip(ramp + 20 * k, 0, 255)) for k in range(5)]
    with VideoWriter(tmp_path / "v.mp4", (97, 80), 25.0) as writer:
        for picture in pictures:
            writer.write(picture)
    back = list(read_frames(tmp_path / "v.mp4"))
    assert probe(tmp_path / "v.mp4").size == (96, 80)
    for ours, picture in zip(back, pictures, strict=True):
        assert np.abs(ours.astype(float) - picture[:, :96]).mean() < 4


@pytest.mark.parametrize("read", [probe, lambda path: list(read_frames(path))])
class TestWrongFiles:
    def test_missing(self, read, tmp_path):
        with pytest.raises(InputFileError, match="does not exist"):
            read(tmp_path / "none.mp4")

    def test_a_folder(self, read, tmp_path):
        with pytest.raises(InputFileError, match="is a folder"):
            read(tmp_path)

    @pytest.mark.parametrize(
        ("name", "options"),
        [("", r"-pattern_type glob -i '.*/it'.*'s/\*\.JPG'"), ("%04d.png", r"-i '.*%04d\.png'")],
    )
    def test_a_sequence_of_pictures(self, read, name, options, tmp_path):
        folder = tmp_path / "it's"
        folder.mkdir()
        for picture in ("0001.JPG", "0002.JPG", "._0001.xmp"):
            (folder / picture).touch()
        with pytest.raises(InputFileError, match="sequences of pictures are not read") as caught:
            read(folder / name)
        assert re.search(f"ffmpeg -framerate RATE {options} -crf 16", str(caught.value))

    @pytest.mark.parametrize("held", [("a.mp4", "b.png", "c.png"), ("cover.jpg",), ()])
    def test_a_folder_with_a_picture_is_no_sequence(self, read, held, tmp_path):
        for name in held:
            (tmp_path / name).touch()
        with pytest.raises(InputFileError, match="is a folder"):
            read(tmp_path)

    def test_a_file_in_place_of_a_folder(self, read, tmp_path):
        (tmp_path / "file").touch()
        with pytest.raises(InputFileError, match="does not exist"):
            read(tmp_path / "file" / "v.mp4")

    def test_a_pipe(self, read, tmp_path):
        os.mkfifo(tmp_path / "pipe")
        with pytest.raises(InputFileError, match="is not an ordinary file"):
            read(tmp_path / "pipe")

    def test_one_that_may_not_be_read(self, read, tmp_path, monkeypatch):
        def refuse(*_: object) -> None:  # root may read everything, so that chmod shows nothing
            raise PermissionError(13, "Permission denied")

        path = write_noise(tmp_path / "v.mp4")
        monkeypatch.setattr(Path, "open", refuse)
        with pytest.raises(InputFileError, match=r"cannot be read \(Permission denied\)"):
            read(path)

    def test_a_name_too_long(self, read, tmp_path):
        with pytest.raises(InputFileError, match=r"cannot be read \(File name too long\)"):
            read(tmp_path / ("v" * 300))

    def test_empty(self, read, tmp_path):
        (tmp_path / "empty.mp4").touch()
        with pytest.raises(InputFileError, match="is empty"):
            read(tmp_path / "empty.mp4")

    def test_text(self, read, tmp_path):
        (tmp_path / "text.mp4").write_text("no video\n" * 50)
        with pytest.raises(VideoError, match="is not a video"):
            read(tmp_path / "text.mp4")

    def test_text_that_ffmpeg_would_draw(self, read, tmp_path):
        (tmp_path / "notes.txt").write_text("no video\n" * 50)
        with pytest.raises(VideoError, match="is not a video"):
            read(tmp_path / "notes.txt")

    def test_sound_only(self, read, tmp_path):
        path = tmp_path / "sound.wav"
        with av.open(str(path), "w") as container:
            stream = container.add_stream("pcm_s16le", rate=8000, layout="mono")
            sound = av.AudioFrame.from_ndarray(np.zeros((1, 800), np.int16), "s16", "mono")
            sound.rate = 8000
            container.mux(stream.encode(sound))
        with pytest.raises(VideoError, match="no video stream"):
            read(path)


def test_a_video_that_breaks_off_gives_its_frames_and_then_says_so(tmp_path):
    seen = []
    with pytest.raises(VideoError, match="is cut off after") as caught:
        seen.extend(read_frames(write_broken(tmp_path / "v.mp4", 20)))
    assert 5 <= len(seen) < 20
    assert f"after {len(seen)} " in str(caught.value)


def test_a_video_without_its_end_cannot_be_opened(tmp_path):
    whole = write_noise(tmp_path / "v.mp4").read_bytes()
    (tmp_path / "cut.mp4").write_bytes(whole[: len(whole) // 2])  # its index is at the end
    with pytest.raises(VideoError, match="is cut off before"):
        list(read_frames(tmp_path / "cut.mp4"))


KINDS = {
    "mpeg2video": (".mpg", ".ts", ".mkv"),
    "libx264": (".mp4", ".mkv", ".ts", ".avi"),
    "mpeg4": (".avi", ".mov"),
    "mjpeg": (".avi", ".mkv"),
    "libvpx": (".webm",),
    "flv1": (".flv",),
}


@pytest.mark.parametrize(
    ("codec", "suffix"), [(codec, suffix) for codec, all_of in KINDS.items() for suffix in all_of]
)
def test_a_cut_is_noticed_in_every_container_and_no_whole_video_is_refused(tmp_path, codec, suffix):
    path = write_kind(tmp_path / f"v{suffix}", codec, drift(40))
    assert probe(path).frames == len(list(read_frames(path))) == 40
    whole = path.read_bytes()
    for part in (0.31, 0.55, 0.78, 0.9):
        path.write_bytes(whole[: int(part * len(whole))])
        for read in (probe, lambda p: list(read_frames(p))):
            with pytest.raises(VideoError, match="is cut off"):
                read(path)


def test_the_real_clips_are_whole_and_cut_ones_are_not(tmp_path, data_dir):
    clips = sorted((data_dir / "grid").glob("*.mpg"))
    assert clips
    for clip in clips:
        assert probe(clip).frames == 75
        whole = clip.read_bytes()
        for part in (0.3, 0.55, 0.8, 0.95):
            (tmp_path / "cut.mpg").write_bytes(whole[: int(part * len(whole))])
            with pytest.raises(VideoError, match="is cut off after"):
                probe(tmp_path / "cut.mpg")


def test_a_cut_between_two_frames_is_noticed_by_the_pack_it_tears(tmp_path):
    path = write_kind(tmp_path / "v.mpg", "mpeg2video", drift(40))
    whole = path.read_bytes()
    packs = [m.start() for m in re.finditer(b"\x00\x00\x01\xba", whole)]
    torn = tmp_path / "torn.mpg"
    for start in packs[1:]:
        torn.write_bytes(whole[: start + 40])  # within the pack's first packet
        assert is_torn(torn)
        torn.write_bytes(whole[:start])  # before it
        assert not is_torn(torn)
    assert not is_torn(path)


def test_damage_in_the_middle_is_no_break(tmp_path):
    path = write_kind(tmp_path / "v.ts", "mpeg2video", drift(40))
    damaged = bytearray(path.read_bytes())
    middle = len(damaged) // 2 // 188 * 188
    damaged[middle : middle + 188] = bytes(188)
    path.write_bytes(damaged)
    assert len(list(read_frames(path))) == pytest.approx(40, abs=1)


def damaged(path: Path, packets: range) -> Path:
    """A copy of a video with noise in place of some packets, counted as they are decoded."""
    whole = bytearray(path.read_bytes())
    with av.open(str(path)) as container:
        found = [p for p in container.demux(video=0) if p.size]
        for number in packets:
            packet = found[number]
            noise = np.random.default_rng(number).bytes(packet.size)
            whole[packet.pos : packet.pos + packet.size] = noise
    out = path.with_name(f"damaged_{path.name}")
    out.write_bytes(whole)
    return out


@pytest.mark.parametrize("gop", [10, 250])
def test_frames_that_are_damaged_in_the_middle_are_left_out(tmp_path, gop):
    path = damaged(write_kind(tmp_path / "v.mp4", "libx264", drift(60), gop=gop), range(22, 26))
    assert 30 < len(list(read_frames(path))) < 60
    assert probe(path).frames == 60


@pytest.mark.parametrize("count", [1, 4])
def test_damage_at_the_end_is_a_break(tmp_path, count):
    whole = write_kind(tmp_path / "v.mp4", "libx264", drift(40), gop=250)
    path = damaged(whole, range(40 - count, 40))
    for read in (probe, lambda path: list(read_frames(path))):
        with pytest.raises(VideoError, match="cut off"):
            read(path)


def test_two_recordings_in_one_file_are_both_counted(tmp_path):
    """The second has the earlier times, as of a recorder whose clock was set anew."""
    stamps = [90 * k + 9000 for k in range(40)]
    late = write_kind(tmp_path / "late.ts", "libx264", drift(40), stamps=stamps)
    early = write_kind(tmp_path / "early.ts", "libx264", drift(40))
    path = tmp_path / "both.ts"
    path.write_bytes(late.read_bytes() + early.read_bytes())
    assert probe(path).frames == len(list(read_frames(path))) == 80


def test_a_recording_may_begin_between_key_frames(tmp_path):
    path = write_kind(tmp_path / "v.ts", "libx264", drift(40), gop=10)
    whole = path.read_bytes()
    path.write_bytes(whole[len(whole) // 5 // 188 * 188 :])
    shown, info = len(list(read_frames(path))), probe(path)
    assert 25 <= shown < 40
    assert info.frames == len(info.times) == shown


def test_pictures_that_nobody_is_shown_are_not_counted(tmp_path):
    """As alternate reference frames of VP8 are, which have packets and times of their own."""
    shown = write_kind(tmp_path / "shown.webm", "libvpx", drift(30))
    path = tmp_path / "hidden.webm"
    with av.open(str(shown)) as source, av.open(str(path), "w") as copy:
        stream = copy.add_stream_from_template(source.streams.video[0])
        for number, packet in enumerate(p for p in source.demux() if p.size):
            data, stamp = bytearray(bytes(packet)), packet.pts
            twice = number % 10 == 5 and data[0] & 1  # not of a key frame
            for hidden in (False, True)[: 1 + twice]:
                data[0] = data[0] & ~0x10 if hidden else data[0]
                one = av.Packet(bytes(data))
                one.pts = one.dts = stamp + 20 * hidden
                one.time_base, one.stream = packet.time_base, stream
                one.is_keyframe = packet.is_keyframe
                copy.mux(one)
    info = probe(path)
    assert info.frames == len(list(read_frames(path))) == 30
    assert info.rate == pytest.approx(probe(shown).rate, rel=0.01)


def test_a_picture_an_hour_can_be_written(tmp_path):
    with VideoWriter(tmp_path / "v.mp4", (96, 80), 1 / 3600) as writer:
        for picture in drift(3):
            writer.write(picture)
    assert len(list(read_frames(tmp_path / "v.mp4"))) == 3
    assert probe(tmp_path / "v.mp4").rate == pytest.approx(1 / 3600)


@pytest.mark.parametrize(
    ("matrix", "size", "corner"),
    [
        ((1, 0, 0, 1), (96, 64), (0, 0)),
        ((0, 1, -1, 0), (64, 96), (0, -1)),  # shown a quarter turn clockwise: its top is right
        ((-1, 0, 0, -1), (96, 64), (-1, -1)),
        ((0, -1, 1, 0), (64, 96), (-1, 0)),  # counter-clockwise: its top is left
        ((-1, 0, 0, 1), (96, 64), (0, -1)),  # mirrored, as some front cameras record
        ((1, 0, 0, -1), (96, 64), (-1, 0)),
        ((0, 1, 1, 0), (64, 96), (0, 0)),  # mirrored about a diagonal
        ((0, -1, -1, 0), (64, 96), (-1, -1)),
    ],
)
def test_frames_are_turned_and_mirrored_as_they_are_shown(tmp_path, matrix, size, corner):
    picture = np.zeros((64, 96, 3), np.uint8)
    picture[:16, :24] = 255  # white at the top left
    with VideoWriter(tmp_path / "v.mp4", (96, 64), 25.0) as writer:
        for _ in range(3):
            writer.write(picture)
    path = turned(tmp_path / "v.mp4", matrix)
    frames = list(read_frames(path))
    assert probe(path).size == size
    assert {frame.shape for frame in frames} == {(size[1], size[0], 3)}
    corners = frames[0][[0, 0, -1, -1], [0, -1, 0, -1], 0].reshape(2, 2) > 128
    assert corners[corner]
    assert corners.sum() == 1


def test_frames_at_uneven_times_are_all_read_and_their_times_are_told(tmp_path):
    stamps = [33 * k + (300 if k >= 7 else 0) for k in range(20)]
    path = write_kind(tmp_path / "v.mkv", "libx264", drift(20), stamps=stamps)
    info = probe(path)
    assert len(list(read_frames(path))) == info.frames == 20
    np.testing.assert_allclose(info.times, np.array(stamps) / 1000, atol=1e-3)
    assert info.rate == pytest.approx(19 / (stamps[-1] / 1000), rel=0.01)


def test_ten_bits_are_read_as_eight(tmp_path):
    pictures = drift(5)
    path = write_kind(tmp_path / "v.mkv", "ffv1", pictures, pixels="yuv444p10le")  # lossless
    for ours, picture in zip(read_frames(path), pictures, strict=True):
        assert ours.dtype == np.uint8
        assert np.abs(ours.astype(float) - picture).max() <= 3  # rounded to limited range and back


def test_the_cover_of_a_song_is_no_video(tmp_path):
    path = tmp_path / "song.mp3"
    with av.open(str(path), "w") as container:
        sound = container.add_stream("libmp3lame", rate=44100, layout="mono")
        cover = container.add_stream("mjpeg", rate=1)
        cover.width, cover.height, cover.pix_fmt = 96, 80, "yuvj420p"
        cover.disposition = Disposition.attached_pic
        picture = av.VideoFrame.from_ndarray(drift(1)[0], format="rgb24")
        container.mux([*cover.encode(picture), *cover.encode()])
        silence = av.AudioFrame.from_ndarray(np.zeros((1, 4410), np.float32), "fltp", "mono")
        silence.rate = 44100
        container.mux([*sound.encode(silence), *sound.encode()])
    with av.open(str(path)) as container:
        assert container.streams.video[0].disposition & Disposition.attached_pic
    with pytest.raises(VideoError, match="no video stream"):
        probe(path)


@pytest.mark.parametrize("crf", [0, 16])
def test_the_same_pictures_give_the_same_file(tmp_path, crf):
    pictures = np.random.default_rng(2).integers(0, 256, (20, 64, 96, 3), np.uint8)
    for name in ("a.mp4", "b.mp4"):
        with VideoWriter(tmp_path / name, (96, 64), 29.97, crf=crf) as writer:
            for picture in pictures:
                writer.write(picture)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    assert len(list(read_frames(tmp_path / "a.mp4"))) == 20
