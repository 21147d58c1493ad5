"""Opens a video file, or a still picture as one, or says what is wrong with it."""

from __future__ import annotations

import os
import re
import shlex
import stat
from collections.abc import Sequence
from pathlib import Path

import av
import av.error
from av.stream import Disposition

from abs_engine.core.errors import InputFileError, VideoError
from abs_engine.io.pictures import MOST_PIXELS
from abs_engine.io.video.truncation import is_torn

_KINDS = "MP4, MOV, AVI, MPEG, MKV or WebM"
_NOT_VIDEO = ("tty",)  # FFmpeg draws plain text as a picture of a terminal


def open_video(path: Path) -> av.container.InputContainer:
    """Open a file that holds pictures; use it in a `with` statement.

    Raises
    ------
    InputFileError
        If there is no such file, it is empty, a folder, or may not be read.
    VideoError
        If it is not a video, has sound only, or breaks off before its index.
    """
    path = Path(path)
    check_readable(path)
    try:
        container = av.open(str(path), metadata_errors="replace")
    except av.error.FFmpegError as error:
        if is_torn(path):
            raise VideoError(
                f"{path} is cut off before any picture can be read", "copy or export it again"
            ) from error
        raise VideoError(f"{path} is not a video", f"give {_KINDS}") from error
    return _usable(str(path), container)


def open_url(url: str, patience: float) -> av.container.InputContainer:
    """Open a URL that gives pictures; use it in a `with` statement.

    Parameters
    ----------
    patience : float
        Seconds without data after which opening, or reading, fails.

    Raises
    ------
    VideoError
        If there is nothing, or nothing that can be shown.
    """
    tcp = {"rtsp_transport": "tcp"}  # nothing is lost on the way
    try:
        container = av.open(url, options=tcp, timeout=patience, metadata_errors="replace")
    except (av.error.FFmpegError, ValueError) as error:
        said = f"{url} cannot be opened ({reason(error)})"
        raise VideoError(said, "check it, and what sends it") from error
    return _usable(url, container)


def reason(error: av.error.FFmpegError | ValueError) -> str:
    """Reason for which a URL cannot be read, in a few words."""
    if isinstance(error, av.error.ExitError):  # by the limit of `open_url`
        return "nothing comes any more"
    return getattr(error, "strerror", None) or "it is not a URL"


def picture_stream(container: av.container.InputContainer) -> av.VideoStream:
    """The stream that is read, and that players show: the file's default, else the largest.

    Cover pictures of sound files do not count, nor does what cannot be decoded.
    """
    return max(moving_streams(container), key=_preference)  # the first of those that are alike


def check_readable(path: Path) -> None:
    """Raise `InputFileError` if the path is no file with something in it that may be read."""
    try:
        sequence = sequence_of(path)
        if sequence and not path.is_file():
            raise InputFileError(
                f"{path} names pictures, and sequences of pictures are not read", as_video(sequence)
            )
        found = os.stat(path)
        if stat.S_ISDIR(found.st_mode):
            raise InputFileError(f"{path} is a folder", "give the video file in it")
        if not stat.S_ISREG(found.st_mode):
            raise InputFileError(f"{path} is not an ordinary file", "give a video file")
        with path.open("rb"):
            pass
    except (FileNotFoundError, NotADirectoryError, ValueError) as error:  # no name holds a NUL
        raise InputFileError(f"{path} does not exist", "check the path of the video") from error
    except OSError as error:
        raise InputFileError(
            f"{path} cannot be read ({error.strerror})", "check who may read it, and its path"
        ) from error
    if found.st_size == 0:
        raise InputFileError(f"{path} is empty", "copy or export the video again")


def moving_streams(container: av.container.InputContainer) -> list[av.VideoStream]:
    """All that are video, and no cover picture."""
    return [s for s in container.streams.video if not s.disposition & Disposition.attached_pic]


def _preference(stream: av.VideoStream) -> tuple[bool, bool, int]:
    context = getattr(stream, "codec_context", None)  # None where no decoder is known
    if context is None:
        return False, False, 0
    return True, bool(stream.disposition & Disposition.default), context.width * context.height


def _usable(name: str, container: av.container.InputContainer) -> av.container.InputContainer:
    """The same; it is closed, and refused, where nothing can be read."""
    problem = _unusable(container)
    if problem:
        container.close()
        raise VideoError(f"{name} {problem}", f"give {_KINDS} with pictures")
    return container


def _unusable(container: av.container.InputContainer) -> str:
    """Reason why nothing can be read, empty where it can."""
    if container.format.name in _NOT_VIDEO:
        return "is not a video"
    if not moving_streams(container):
        return "has no video stream"
    context = getattr(picture_stream(container), "codec_context", None)
    if context is None:
        return "is coded in a way that is not known here"
    if context.width * context.height > MOST_PIXELS:
        return f"has frames of {context.width}x{context.height} pixels, more than are read"
    return ""


_ENDINGS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
_NUMBERED = re.compile(r"%\d*d")  # as FFmpeg names the files of a sequence


def is_still(path: Path) -> bool:
    """Whether a file is named as a picture."""
    return path.suffix.lower() in _ENDINGS


def sequence_of(path: Path) -> str:
    """FFmpeg's options that read a sequence of pictures at a path; empty where it names none.

    The path may be of a folder that holds pictures alone, or a pattern such as ``%04d.png`` of
    their names.
    """
    if _NUMBERED.search(path.name) and is_still(path):
        return f"-i {shlex.quote(str(path))}"
    held = _shown(path) if path.is_dir() else []
    return all_of(held) if len(held) > 1 and all(map(is_still, held)) else ""


def all_of(pictures: Sequence[Path]) -> str:
    """FFmpeg's options that read all pictures of the first one's kind, in its folder."""
    pattern = pictures[0].with_name(f"*{pictures[0].suffix}")
    return f"-pattern_type glob -i {shlex.quote(str(pattern))}"


def as_video(sequence: str) -> str:
    """Command that makes a video of a sequence of pictures, given FFmpeg's options that read it."""
    return f"make a video of them: ffmpeg -framerate RATE {sequence} -crf 16 OUT.mp4"


def _shown(folder: Path) -> list[Path]:
    """Contents of a folder, but for hidden files, in the order of their names."""
    return sorted(held for held in folder.iterdir() if not held.name.startswith("."))
