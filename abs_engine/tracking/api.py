"""A video tracked in one call."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from inspect import signature
from pathlib import Path
from typing import Any

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError, SameOutputError
from abs_engine.core.kinds import CALLED, PATH, check_kind, to_path
from abs_engine.core.numpy_errors import as_usual
from abs_engine.core.registry import nearest
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import closed_after
from abs_engine.core.words import shown
from abs_engine.dataset import load_camera
from abs_engine.io.video import probe
from abs_engine.render.select import opened_renderer
from abs_engine.render.trial import check_renderer
from abs_engine.tracking.option_checks import check_options
from abs_engine.tracking.options import ClipTracker, TrackOptions
from abs_engine.tracking.results.smoothing import Smoothing
from abs_engine.tracking.run import prepare, settings_of, track_video
from abs_engine.tracking.run_in_memory import Run
from abs_engine.tracking.runs.output import Progress
from abs_engine.tracking.runs.record import Record
from abs_engine.tracking.runs.recorder import Recorder


@as_usual()
def track(
    video: str | Path,
    output: str | Path | None = None,
    *,
    renderer: str | Renderer | None = "auto",
    camera: str | Path | Camera | None = None,
    terms: str | Sequence[str] | None = None,
    progress: Progress | None = None,
    stage: Callable[[str], None] | None = None,
    **options: Any,
) -> Run:
    """Track the lips in a video.

    Parameters
    ----------
    video : path
    output : path, optional
        Folder of a run, which must not exist, unless it is this very run, which is then read; by
        default nothing is written.
    renderer : str or Renderer, optional
        A name, of which one is opened and closed again (see `open_renderer`), or an open one.
    camera : path or Camera, optional
        Its calibration, or a `camera.json`.
    terms : str or sequence of str, optional
        Evidence: "colour", "colour+texture"; by default "colour+shading" for a head or a speaker's
        own face, "colour" with `start="blobs"` or another model.
    progress : callable, optional
        Called after every frame with the number of frames done and of all frames.
    stage : callable, optional
        Called with what the preparation begins, in a few words.
    **options
        What else `TrackOptions` has: ``preset``, ``model``, ``driver``, ``person``, ...

    Returns
    -------
    Run

    Raises
    ------
    AbsEngineError
        As `track_video`.

    Examples
    --------
    >>> run = abs_engine.track("a.mpg")  # doctest: +SKIP
    >>> run.aperture.max()  # doctest: +SKIP
    """
    path, folder = to_path("video", video), None if output is None else to_path("output", output)
    for name, called in (("progress", progress), ("stage", stage)):
        if called is not None:
            check_kind(name, called, CALLED)
    chosen = _options(options, camera, terms)
    check_options(chosen, probe(path))
    with _opened(renderer) as drawn:
        if folder is None:
            return _run(prepare(path, drawn, chosen, stage), chosen, progress)
        collected: list[Run] = []

        def keep(tracker: ClipTracker, record: Record) -> None:
            collected.append(_of(record, tracker, chosen))

        try:
            track_video(path, folder, drawn, chosen, progress, stage=stage, recorded=keep)
        except SameOutputError:
            return replace(Run.load(folder), video=path.resolve())  # it may have been moved
        return collected[0]


def _run(tracker: ClipTracker, chosen: TrackOptions, progress: Progress | None) -> Run:
    recorder, frames = Recorder(tracker.setting), tracker.info.frames
    with closed_after(tracker.results()) as results:
        for image, result in results:
            recorder.add(result, image)
            if progress is not None:
                progress(len(recorder), max(frames, len(recorder)) if frames else 0)
    return _of(recorder.record(), tracker, chosen)


def _of(record: Record, tracker: ClipTracker, chosen: TrackOptions) -> Run:
    smooth = chosen.smooth
    smoothed = {} if smooth is None else Smoothing.named(smooth).measures(record.arrays)
    settings, colours = settings_of(tracker, chosen), tracker.setting.face.appearance.get("colour")
    return Run(record.copied(), settings, smoothed, tracker.video.resolve(), colours)


def _options(
    given: dict[str, Any], camera: str | Path | Camera | None, terms: str | Sequence[str] | None
) -> TrackOptions:
    # `model_file` follows from `model`
    known = [one.name for one in fields(TrackOptions) if one.name != "model_file"]
    named = [name for name in signature(track).parameters if name not in ("video", "options")]
    for name in given:
        if name not in known:
            every = list(dict.fromkeys([*named, *known]))
            raise ParameterError(f"there is no option '{name}'", nearest(name, every))
    if camera is not None and not isinstance(camera, Camera):
        check_kind("camera", camera, (PATH[0], "a path or a Camera"))
        camera = load_camera(Path(camera))
    return TrackOptions(**{**given, "terms": terms}, camera=camera)


@contextmanager
def _opened(renderer: str | Renderer | None) -> Iterator[Renderer]:
    if renderer is not None and not isinstance(renderer, str):
        if not hasattr(renderer, "draw"):
            said = f"renderer is {shown(renderer)}"
            raise ParameterError(said, "give a name, or an open renderer")
        check_renderer(type(renderer).__name__, renderer)
        yield renderer
        return
    with opened_renderer(renderer) as opened:
        yield opened
