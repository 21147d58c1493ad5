"""Files: whether all are there, as they were written, and of the right kind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abs_engine.core.errors import InputFileError
from abs_engine.dataset import codec
from abs_engine.dataset.dataset import ClipEntry, Dataset
from abs_engine.dataset.picture import picture_header
from abs_engine.dataset.sums import SUMS, file_names, read_sums, wrong_sums
from abs_engine.evaluate.check.finding import Finding

_TOP = (codec.SCENE, codec.README)
_VIEW = (codec.CAMERA, codec.VIDEO, codec.POINTS, codec.COCO)


def sum_findings(dataset: Dataset) -> Iterator[Finding]:
    """Files that are missing, altered, or not on the list of checksums."""
    try:
        sums = read_sums(dataset.folder)
    except InputFileError:
        yield Finding(SUMS, "the list of checksums is missing")
        return
    names = dict.fromkeys([*sums, *file_names(dataset.folder)])
    for name, problem in wrong_sums(dataset.folder, sums, names):
        what = {
            "missing": "the file is listed, but missing",
            "altered": "the file was altered after it was written",
            "not listed": "the file has no checksum",
        }[problem]
        yield Finding(name, what)


def presence_findings(dataset: Dataset) -> Iterator[Finding]:
    """Files that the layout asks for and that are not there."""
    wanted = list(_TOP)
    for clip in dataset.clips:
        chunks = range(0, clip.frames, codec.CHUNK)
        wanted.append(f"{clip.name}/{codec.TRUTH}")
        wanted += [f"{clip.name}/{codec.VERTICES}/{codec.chunk_name(i)}" for i in chunks]
        wanted += [f"{clip.name}/{camera}/{name}" for camera in clip.cameras for name in _VIEW]
    for name in wanted:
        if not (dataset.folder / name).is_file():
            yield Finding(name, "the file is missing")


def picture_findings(
    dataset: Dataset, clip: ClipEntry, camera: str, size: tuple[int, int]
) -> Iterator[Finding]:
    """Pictures of a camera that are missing, too many, or of another size or depth.

    Only the first bytes of each are read.
    """
    view = dataset.folder / clip.name / camera
    more = [kind for kind in (codec.COVER, codec.FRAMES) if (view / kind).is_dir()]
    for kind in (*dict.fromkeys(("ids", "depth", *dataset.labels)), *more):
        folder = view / kind
        name = f"{clip.name}/{camera}/{kind}"
        dtype, channels = codec.PICTURES[kind]
        wanted = (*size, 8 * np.dtype(dtype).itemsize, channels)
        for frame in range(clip.frames):
            try:
                found = picture_header(folder / codec.frame_name(frame))
            except InputFileError:
                yield Finding(name, "a picture is missing or no PNG", "", frame)
                continue
            if found != wanted:
                how = "{}x{}, {} bits, {} channels".format(*found)
                yield Finding(name, "a picture has a wrong size or depth", how, frame)
        extra = len(list(folder.glob("*"))) - clip.frames if folder.is_dir() else 0
        if extra > 0:
            yield Finding(name, "there are more pictures than frames", f"{extra} more")
