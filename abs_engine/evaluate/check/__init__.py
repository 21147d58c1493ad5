"""The checker of datasets: files as they were written, and labels that are true to each other.

`check_dataset` needs nothing but the dataset. Geometry is worked out anew from the vertices, the
poses and the cameras; nothing of the studio is used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from abs_engine.core.arrays import FloatArray, evenly
from abs_engine.core.errors import AbsEngineError
from abs_engine.core.kinds import to_path
from abs_engine.dataset import ClipEntry, Dataset, Truth, codec, load_clip
from abs_engine.dataset.camera_file import load_camera
from abs_engine.dataset.dataset import read_record
from abs_engine.dataset.view import load_view
from abs_engine.evaluate.check import (
    classes,
    files,
    footage,
    head,
    ids,
    marks,
    motion,
    order,
    speech,
)
from abs_engine.evaluate.check import surface as labels
from abs_engine.evaluate.check.finding import Finding, merged
from abs_engine.evaluate.check.visibility import look
from abs_engine.render.cpu import CpuRenderer

__all__ = ["Finding", "check_dataset"]

FRAMES = 40
"""Frames of each view whose pictures are looked into."""

COMPARED = 1000
"""Frames of each view that are compared with each other, at most: their pairs grow faster."""

CONTACTS = 400
"""Frames of each clip whose lips are measured."""

Progress = Callable[[int, int], None]


def check_dataset(
    folder: Path, *, frames: int | None = FRAMES, progress: Progress | None = None
) -> list[Finding]:
    """Verify a dataset.

    Parameters
    ----------
    frames : int, optional
        How many frames of each view are looked into, evenly spread; None for all. Checksums,
        presence and kind of files, and everything in arrays are checked for all frames.
    progress : callable, optional
        Called with the number of frames that were looked into and that will be.

    Returns
    -------
    list of Finding
        Empty where nothing is wrong.

    Raises
    ------
    InputFileError
        If the folder holds no dataset.
    ModelFormatError
        If its ``dataset.json`` has another format or version.
    """
    dataset = read_record(to_path("folder", folder))
    found = [*files.sum_findings(dataset), *files.presence_findings(dataset)]
    count = _Count(dataset, frames, progress)
    for entry in dataset.clips:
        found += _tried(entry.name, _clip_findings(dataset, entry, frames))
        for camera in entry.cameras:
            view = _view_findings(dataset, entry, camera, frames, count)
            found += _tried(f"{entry.name}/{camera}", view)
    return merged(found)


class _Count:
    """Counts the frames that were looked into, of all views."""

    def __init__(self, dataset: Dataset, frames: int | None, progress: Progress | None) -> None:
        views = (len(chosen(c.frames, frames)) * len(c.cameras) for c in dataset.clips)
        self._total, self._done, self._progress = sum(views), 0, progress

    def one(self) -> None:
        """One more."""
        self._done += 1
        if self._progress is not None:
            self._progress(self._done, self._total)


def _tried(name: str, findings: Iterator[Finding]) -> Iterator[Finding]:
    """The findings; what cannot be read is one of them, and the last."""
    try:
        yield from findings
    except AbsEngineError as error:
        yield Finding(name, "cannot be read", error.problem)


def chosen(total: int, wanted: int | None) -> list[int]:
    """Frames that are looked into, evenly spread, with the first and the last."""
    return evenly(total, total if wanted is None else max(wanted, 2))


def _clip_findings(dataset: Dataset, entry: ClipEntry, frames: int | None) -> Iterator[Finding]:
    """Faults of a clip, whichever camera looks."""
    clip = load_clip(dataset.folder / entry.name)
    name = f"{entry.name}/{codec.TRUTH}"
    wrong = list(motion.length_findings(clip, entry, name))
    yield from wrong
    if wrong:
        return
    yield from head.head_findings(clip, name)
    yield from classes.class_findings(clip, name)
    yield from motion.pose_findings(clip, name)
    yield from speech.interval_findings(clip, name)
    measured = chosen(len(clip), None if frames is None else CONTACTS)
    for frame in measured:
        yield from motion.offset_findings(clip, frame, f"{entry.name}/{codec.VERTICES}")
    yield from speech.contact_findings(clip, measured, name)


def _view_findings(
    dataset: Dataset, entry: ClipEntry, camera: str, frames: int | None, count: _Count
) -> Iterator[Finding]:
    """Faults of a clip as a camera saw it."""
    clip, name = load_clip(dataset.folder / entry.name), f"{entry.name}/{camera}"
    folder = dataset.folder / entry.name / camera
    size = load_camera(folder / codec.CAMERA).size
    yield from files.picture_findings(dataset, entry, camera, size)
    truth = load_view(clip, folder)
    yield from motion.camera_findings(truth, f"{name}/{codec.CAMERA}")
    points, coco, video = (f"{name}/{n}" for n in (codec.POINTS, codec.COCO, codec.VIDEO))
    yield from _tried(points, marks.point_findings(truth, points))
    boxes: marks.Boxes = {}
    yield from _tried(coco, marks.coco_findings(truth, folder / codec.COCO, coco, boxes))
    kinds = [kind for kind in dataset.labels if kind in codec.LABELS]
    looker = _Looker(truth, name, kinds, boxes)
    for frame in chosen(len(clip), frames):
        yield from _tried(name, looker.findings(frame))
        count.one()
    yield from _tried(video, footage.video_findings(truth, video))
    compared = chosen(len(clip), min(frames or COMPARED, COMPARED))
    sources = {
        video: order.of_video(truth, compared),
        f"{name}/{codec.FRAMES}": order.before_compression(truth, compared),
    }
    yield from _tried(video, order.order_findings(truth, sources))


class _Looker:
    """Looks into one frame of a view after the other."""

    def __init__(self, truth: Truth, name: str, kinds: list[str], boxes: marks.Boxes) -> None:
        self._truth, self._name, self._kinds, self._boxes = truth, name, kinds, boxes
        self._colours: dict[int, FloatArray] = {}
        self._renderer, self._classes = CpuRenderer(), marks.mark_classes(truth)

    def findings(self, frame: int) -> Iterator[Finding]:
        """Faults in the pictures of a frame."""
        truth, folder, points = self._truth, self._name, f"{self._name}/{codec.POINTS}"
        sight = look(truth, frame)
        yield from ids.id_findings(truth, sight, f"{folder}/ids")
        yield from ids.cover_findings(truth, sight, f"{folder}/ids", self._renderer)
        yield from marks.visible_findings(truth, sight, self._classes, points)
        yield from marks.box_findings(sight, self._boxes, f"{folder}/{codec.COCO}")
        yield from labels.depth_findings(truth, sight, f"{folder}/depth")
        if "normals" in self._kinds:
            yield from labels.normal_findings(truth, sight, f"{folder}/normals")
        if "flow" in self._kinds:
            yield from labels.flow_findings(truth, sight, f"{folder}/flow")
        if "albedo" in self._kinds:
            yield from labels.albedo_findings(truth, sight, f"{folder}/albedo", self._colours)
