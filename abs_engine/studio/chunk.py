"""A chunk of frames, filmed and written: what one job of a film process is.

Pictures go to where they stay; what is gathered into one file for a whole clip waits in a file of
the chunk, whose appearing says that the chunk is done.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.dataset import write_chunk
from abs_engine.dataset.coco import box_and_area
from abs_engine.dataset.codec import (
    CHUNK,
    COVER,
    FRAMES,
    encode_depth,
    encode_flow,
    encode_normals,
    frame_name,
)
from abs_engine.dataset.picture import write_picture
from abs_engine.io.assets import Speaker
from abs_engine.io.naming import WHOLE, rename_new, settle
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.plan import load
from abs_engine.studio.take import Shot, Take

FORMAT, VERSION = "abs_engine.chunk", 1


@dataclass(frozen=True, order=True)
class Job:
    """A chunk of a clip by one camera.

    Parameters
    ----------
    clip, view, chunk : int
        Numbers from 0.
    """

    clip: int
    view: int
    chunk: int

    @property
    def name(self) -> str:
        """Of the file in which the chunk's numbers wait."""
        return f"{self.clip:05d}-{self.view:03d}-{self.chunk:05d}.npz"


def jobs_of(plans: list[tuple[int, int]]) -> list[Job]:
    """All jobs of clips with (frames, cameras), in the order in which they are filmed."""
    return [
        Job(clip, view, chunk)
        for clip, (frames, views) in enumerate(plans)
        for view in range(views)
        for chunk in range(-(-frames // CHUNK))
    ]


class Filmer:
    """Films chunks into a journal's folder, the last one's camera kept running.

    Labels are those of normals, albedo and flow that are wanted.
    """

    def __init__(self, work: Path, speaker: Speaker, labels: tuple[str, ...]) -> None:
        self._work, self._speaker, self._labels = work, speaker, labels
        self._takes = ExitStack()
        self._at: tuple[int, int] | None = None

    def film(self, job: Job, advance: Callable[[], None]) -> None:
        """Film a chunk and write it; `advance` is called after every frame.

        Raises `OSError` if something cannot be written, `StudioError` if the drawing process ends.
        """
        if self._at != (job.clip, job.view):
            self._takes.close()
            self._plan = load(self._work / "plans" / f"{job.clip:05d}.npz")
            self._take = self._takes.enter_context(
                Take(self._speaker, self._plan, job.view, self._labels)
            )
            self._at = job.clip, job.view
        take, plan, first = self._take, self._plan, job.chunk * CHUNK
        clip = self._work / WHOLE / plan.name
        camera = clip / plan.views[job.view].name
        make_folders(camera, self._labels, cover=plan.occluders)
        before = take.clock.seconds.copy()
        rows, offsets = [], []
        shots = take.film(first, min(first + CHUNK, len(plan)))
        written: list[Path] = []
        for frame, (now, shot) in enumerate(shots, start=first):
            with take.clock.part("png"):
                written += write_shot(camera, frame, shot, cover=plan.occluders)
            with take.clock.part("gap"):
                rows.append(_row(shot))
                if job.view == 0:
                    head = plan.neutral + now.offsets.astype(np.float32)
                    rows[-1]["gap"] = widest_gap(self._speaker, head)
                    offsets.append(now.offsets)
            advance()
        with take.clock.part("vertices"):
            if job.view == 0:
                written.append(write_chunk(clip, first, np.array(offsets)))
        for path in written:
            settle(path)
        parts = {k: v - before[k] for k, v in take.clock.seconds.items()}
        arrays = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        _leave(self._work / "chunks" / job.name, arrays, parts)

    def __enter__(self) -> Filmer:
        return self

    def __exit__(self, *_: object) -> None:
        self._takes.close()


def make_folders(camera: Path, labels: tuple[str, ...], *, cover: bool) -> None:
    """Make the folders of a camera's pictures."""
    for kind in ("ids", "depth", FRAMES, *labels, *((COVER,) if cover else ())):
        (camera / kind).mkdir(parents=True, exist_ok=True)


def write_shot(camera: Path, frame: int, shot: Shot, *, cover: bool) -> list[Path]:
    """Write the pictures of a frame, and return their paths."""
    depth = encode_depth(shot.depth)
    pictures: dict[str, Any] = {FRAMES: shot.picture, "ids": shot.ids, "depth": depth}
    if shot.normals is not None:
        pictures["normals"] = encode_normals(shot.normals, shot.ids > 0)
    if shot.albedo is not None:
        pictures["albedo"] = shot.albedo
    if shot.flow is not None:
        pictures["flow"] = encode_flow(*shot.flow)
    if cover:
        pictures[COVER] = shot.cover
    written = {camera / kind / frame_name(frame): values for kind, values in pictures.items()}
    for path, values in written.items():
        write_picture(path, values)
    return list(written)


def _row(shot: Shot) -> dict[str, Any]:
    """The small things of a frame, whose pictures are elsewhere."""
    box, area = box_and_area((shot.ids > 0) & ~shot.glass)  # the landmarks' own head
    row: dict[str, Any] = {
        "landmark_pixels": shot.pixels,
        "landmark_visible": shot.seen,
        "boxes": box,
        "areas": area,
    }
    if shot.mirror_pixels is not None:
        row["mirror_landmark_pixels"] = shot.mirror_pixels
        row["mirror_landmark_visible"] = shot.mirror_seen
    return row


def _leave(path: Path, arrays: dict[str, Any], seconds: dict[str, float]) -> None:
    """Write a chunk's numbers, whole or not at all."""
    made = path.with_name(f".{path.name}")
    parts = {f"seconds_{name}": value for name, value in seconds.items()}
    told: dict[str, Any] = {"format": FORMAT, "version": VERSION, **arrays, **parts}
    np.savez(made, **told)
    rename_new(made, path)


def seconds_of(numbers: dict[str, Any]) -> dict[str, float]:
    """Cost of a chunk, in seconds by part."""
    parts = {k: float(v) for k, v in numbers.items() if k.startswith("seconds_")}
    return {name.removeprefix("seconds_"): value for name, value in parts.items()}
