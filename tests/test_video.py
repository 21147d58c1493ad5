"""Video: what was written comes back; files that are wrong say so."""

from __future__ import annotations

import av
import numpy as np
import pytest
from runs import noise, write_broken, write_noise

from abs_engine.errors import InputFileError, VideoError
from abs_engine.video import VideoWriter, probe, read_frames


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
        with pytest.raises(InputFileError, match="does not exist"):
            read(tmp_path)

    def test_empty(self, read, tmp_path):
        (tmp_path / "empty.mp4").touch()
        with pytest.raises(InputFileError, match="is empty"):
            read(tmp_path / "empty.mp4")

    def test_text(self, read, tmp_path):
        (tmp_path / "text.mp4").write_text("no video\n" * 50)
        with pytest.raises(VideoError, match="is not a video"):
            read(tmp_path / "text.mp4")

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
    with pytest.raises(VideoError, match="breaks off after") as caught:
        seen.extend(read_frames(write_broken(tmp_path / "v.mp4", 20)))
    assert 5 <= len(seen) < 20
    assert f"after {len(seen)} " in str(caught.value)


def test_a_video_without_its_end_cannot_be_opened(tmp_path):
    whole = write_noise(tmp_path / "v.mp4").read_bytes()
    (tmp_path / "cut.mp4").write_bytes(whole[: len(whole) // 2])  # its index is at the end
    with pytest.raises(VideoError, match="is not a video"):
        list(read_frames(tmp_path / "cut.mp4"))
