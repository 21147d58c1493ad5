"""A dataset: clips, each seen by one or more cameras."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.kinds import WHOLE, to_path
from abs_engine.dataset import codec
from abs_engine.dataset.clip import Clip, load_clip
from abs_engine.dataset.picture import AGAIN
from abs_engine.dataset.sums import check_sums, read_sums
from abs_engine.dataset.view import Truth, load_view
from abs_engine.io.arrays import Layout, check_arrays, of_json, plain, real, text, whole
from abs_engine.io.inputs import check_file, read_json

_DEPTH = 2  # DATASET/CLIP/CAMERA
_MOST_NAMED = 6

LONGEST = 10_000_000
"""Frames of a clip: no clip has more."""
_LAYOUT: Layout = {
    **dict.fromkeys(("command", "engine"), text()),
    "seed": whole(),
    "labels": text("L*"),
}
_ENTRY: Layout = {
    **dict.fromkeys(("name", "person", "sentence"), text()),
    "frames": whole(low=0, high=LONGEST),
    "rate": real(low=1e-9),
    "cameras": text("C*"),
}


@dataclass(frozen=True)
class ClipEntry:
    """A clip as ``dataset.json`` lists it.

    Parameters
    ----------
    rate : float
        Frames per second.
    """

    name: str
    person: str
    sentence: str
    frames: int
    rate: float
    cameras: tuple[str, ...]


@dataclass(frozen=True)
class Dataset:
    """A dataset on disk. Iterating gives the `Truth` of every clip by every camera.

    Parameters
    ----------
    folder : Path
    command, engine : str
        What made it, and which version of this package that was.
    seed : int
    clips : tuple of `ClipEntry`
    labels : tuple of str
        Which label pictures there are, of `codec.LABELS`.
    record : dict
        All that ``dataset.json`` holds.
    """

    folder: Path
    command: str
    engine: str
    seed: int
    clips: tuple[ClipEntry, ...]
    labels: tuple[str, ...]
    record: dict[str, Any] = field(repr=False, compare=False)

    @property
    def views(self) -> tuple[tuple[str, str], ...]:
        """Names of clip and camera of every view, in the order of iteration."""
        return tuple((clip.name, camera) for clip in self.clips for camera in clip.cameras)

    def __len__(self) -> int:
        """Return the number of views."""
        return len(self.views)

    def __iter__(self) -> Iterator[Truth]:
        """Yield every view; those of one clip share its vertices."""
        for entry in self.clips:
            clip = self.clip(entry.name)
            for camera in entry.cameras:
                yield load_view(clip, self.folder / entry.name / camera)

    def __getitem__(self, number: int) -> Truth:
        """View of a number, in the order of `views`; `ParameterError` where there is none."""
        if not WHOLE[0](number) or number not in range(len(self)):
            raise ParameterError(
                f"{self.folder} has no view {number!r}", f"count its {len(self)} from 0"
            )
        return self.view(*self.views[number])

    def clip(self, name: str) -> Clip:
        """Read what is true of a clip for all its cameras."""
        return load_clip(self.folder / self._entry(name).name)

    def view(self, clip: str, camera: str) -> Truth:
        """The truth of a clip as one camera sees it.

        Raises
        ------
        ParameterError
            If there is no such clip or camera.
        """
        cameras = self._entry(clip).cameras
        if camera not in cameras:
            raise ParameterError(
                f"clip '{clip}' has no camera '{camera}'", f"choose one of {', '.join(cameras)}"
            )
        return load_view(self.clip(clip), self.folder / clip / camera)

    def _entry(self, name: str) -> ClipEntry:
        for entry in self.clips:
            if entry.name == name:
                return entry
        names = ", ".join(entry.name for entry in self.clips)
        raise ParameterError(f"{self.folder} has no clip '{name}'", f"choose one of {names}")


def dataset_record(
    *,
    command: str,
    seed: int,
    engine: str,
    clips: list[ClipEntry],
    labels: tuple[str, ...],
    **more: object,
) -> dict[str, Any]:
    """Content of a ``dataset.json``; `more` is kept beside it, such as the commit."""
    return {
        "format": codec.FORMAT,
        "version": codec.VERSION,
        "command": command,
        "seed": seed,
        "engine": engine,
        "clips": [{**vars(clip), "cameras": list(clip.cameras)} for clip in clips],
        "labels": list(labels),
        **more,
    }


def load_dataset(folder: Path, *, verify: bool = False) -> Dataset:
    """Read a dataset's list of clips; the clips themselves are read when wanted.

    Parameters
    ----------
    folder : Path
    verify : bool
        Check every file against its checksum; otherwise only ``dataset.json`` and, of each clip
        and camera, the files that hold numbers.

    Raises
    ------
    InputFileError
        If it is no dataset or a file is missing.
    ModelFormatError
        If a file was altered, or has another format or version.
    """
    folder = to_path("folder", folder)
    dataset = read_record(folder)
    check_sums(folder, None if verify else _number_files(dataset.views))
    return dataset


def read_record(folder: Path) -> Dataset:
    """Read ``dataset.json`` without looking at any other file.

    Raises
    ------
    InputFileError
        If it is missing or no JSON.
    ModelFormatError
        If it has another format or version, or lacks a field.
    """
    path = folder / codec.DATASET
    if not path.is_file():
        raise InputFileError(
            f"{folder} is not ground truth: {codec.DATASET} is missing", "check the path"
        )
    check_file(path)
    try:
        record = read_json(path)
        kind = record["format"], record["version"]
        if kind != (codec.FORMAT, codec.VERSION):
            raise ModelFormatError(
                f"{path} is {kind[0]} version {kind[1]}, wanted {codec.FORMAT} "
                f"version {codec.VERSION}",
                AGAIN,
            )
        given = {name: of_json(record[name]) for name in _LAYOUT if name in record}
        own = plain(check_arrays(path, given, _LAYOUT, AGAIN))
        clips = tuple(_entry(path, item) for item in record["clips"])
        if not isinstance(record["clips"], list) or set(own["labels"]) - set(codec.LABELS):
            raise TypeError("clips or labels")
    except (KeyError, TypeError, AttributeError, OverflowError) as error:
        raise ModelFormatError(
            f"{path} lacks a field or has a wrong one ({error})", AGAIN
        ) from error
    except ValueError as error:
        raise InputFileError(f"{path} is not a list of clips", AGAIN) from error
    return Dataset(folder=folder, clips=clips, record=record, **own)


def _entry(path: Path, item: dict[str, Any]) -> ClipEntry:
    given = {name: of_json(item[name]) for name in _ENTRY if name in item}
    entry = ClipEntry(**plain(check_arrays(path, given, _ENTRY, AGAIN)))
    for part in (entry.name, *entry.cameras):
        if part in ("", ".", "..") or set(part) & set("/\\\0"):
            raise TypeError(f"{part!r} names no folder within it")
    return entry


def load_truth(path: Path, *, verify: bool = False) -> Truth:
    """Read the ground truth of one clip by one camera.

    Parameters
    ----------
    path : Path
        A dataset of one clip and camera, DATASET/CLIP of one camera, or DATASET/CLIP/CAMERA.
    verify : bool
        As in `load_dataset`, for the files of this clip and camera.

    Raises
    ------
    ParameterError
        If there are several clips or cameras to choose from; other errors as `load_dataset`.
    """
    folder, given = dataset_root(to_path("path", path))
    dataset = read_record(folder)
    found = [view for view in dataset.views if view[: len(given)] == given]
    if not found:
        raise InputFileError(
            f"{path} is not a clip of {folder}", f"choose {choices(dataset.views)}"
        )
    if len(found) > 1:
        raise ParameterError(
            f"{path} holds {len(found)} clips by cameras", f"name one: {choices(found)}"
        )
    names = _all_files(dataset, found[0]) if verify else _number_files(tuple(found))
    check_sums(folder, names)
    return dataset.view(*found[0])


def dataset_root(path: Path) -> tuple[Path, tuple[str, ...]]:
    """The dataset's folder, and the names of clip and camera that the path gives.

    Raises
    ------
    InputFileError
        If neither the path nor what is above it is a dataset.
    """
    whole = path.resolve()
    for depth, folder in enumerate((path, *whole.parents[:_DEPTH])):
        if (folder / codec.DATASET).is_file():
            return folder, whole.parts[len(whole.parts) - depth :] if depth else ()
    raise InputFileError(
        f"{path} is not ground truth: {codec.DATASET} is missing", "check the path"
    )


def choices(views: Sequence[tuple[str, str]]) -> str:
    """Names of some of the views of a dataset, for an error."""
    shown = ["/".join(view) for view in views[:_MOST_NAMED]]
    return ", ".join(shown) + (", ..." if len(views) > len(shown) else "")


def _number_files(views: tuple[tuple[str, str], ...]) -> list[str]:
    """``dataset.json`` and what holds numbers but no pictures and no vertices."""
    clips = dict.fromkeys(clip for clip, _ in views)
    return [
        codec.DATASET,
        *(f"{clip}/{codec.TRUTH}" for clip in clips),
        *(f"{c}/{v}/{name}" for c, v in views for name in (codec.CAMERA, codec.POINTS)),
    ]


def _all_files(dataset: Dataset, view: tuple[str, str]) -> list[str]:
    clip, camera = view
    shared = f"{clip}/{codec.TRUTH}", codec.DATASET
    starts = f"{clip}/{codec.VERTICES}/", f"{clip}/{camera}/"
    listed = [n for n in read_sums(dataset.folder) if n in shared or n.startswith(starts)]
    return list(dict.fromkeys([*_number_files((view,)), *listed]))
