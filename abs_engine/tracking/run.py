"""From a video to a run on disk."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from abs_engine.core.camera import Camera
from abs_engine.core.kinds import to_path
from abs_engine.core.numpy_errors import as_usual
from abs_engine.core.provenance import code_digest
from abs_engine.core.registry import PLUGINS
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import one_thread
from abs_engine.core.words import counted
from abs_engine.dataset.sums import digest
from abs_engine.face.appearance.colour import ColourClasses, usable
from abs_engine.io.head_points import POINTS
from abs_engine.io.unfinished import Unfinished, kept_if_of_use
from abs_engine.io.video import Frame, VideoInfo, probe
from abs_engine.tracking.footage import footage_lines
from abs_engine.tracking.model_entry import made_ready
from abs_engine.tracking.option_checks import DEFAULTS, check_options
from abs_engine.tracking.options import Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.presets import WITH_HEAD, resolved
from abs_engine.tracking.results.frame_journal import FRAMES, FrameJournal, fingerprint
from abs_engine.tracking.results.run_warnings import GIVEN_COLOURS, OTHER_COLOURS
from abs_engine.tracking.results.smoothing import Smoothing, write_smoothed
from abs_engine.tracking.runs.output import Progress, write_run
from abs_engine.tracking.runs.poses_file import read_poses
from abs_engine.tracking.runs.record import Record
from abs_engine.tracking.settings.stages import stage_values

DISCARDED = (
    "what an interrupted command had kept is discarded: it had other options, another video or "
    "another release"
)


@as_usual()
def prepare(
    video: str | Path,
    renderer: Renderer,
    options: TrackOptions = DEFAULTS,
    stage: Callable[[str], None] | None = None,
) -> ClipTracker:
    """Make a clip ready: find the face, and learn what is to be learned of it.

    Parameters
    ----------
    video : str or Path
    renderer : Renderer
    options : TrackOptions
    stage : callable, optional
        Called with what is begun, in a few words.

    Raises
    ------
    InputFileError, VideoError
        If the video cannot be read.
    FaceNotFoundError
        If no face is found.
    TooFewPixelsError
        If too little of it is seen to learn its colours; from landmarks that is no reason.
    ParameterError
        If given poses do not fit the video, or what is chosen does not go together.
    PluginError
        If what is chosen cannot be imported, or a plugin's model fails.
    """
    video, tell = to_path("video", video), stage or silent
    tell("reading the video")
    return prepare_clip(clip_of(video, probe(video), options), renderer, options, tell)


def clip_of(
    video: Path, info: VideoInfo, options: TrackOptions, shown: tuple[Frame, ...] = ()
) -> Clip:
    """A video as it is tracked; or a camera's, which has shown some frames."""
    colours = None if options.colours is None else ColourClasses.load(options.colours)
    return Clip(video, info, options.camera or Camera.ideal(info.size), colours, shown)


def prepare_clip(clip: Clip, renderer: Renderer, options: TrackOptions, tell: Tell) -> ClipTracker:
    """Find the face, and learn what is to be learned of it; see `prepare`."""
    chosen, model = resolved(options)
    leaves = Leaves.of(chosen)
    with one_thread():
        made = made_ready(model, clip, chosen, leaves, renderer, tell)
    driver = {"name": leaves.name, **leaves.driver.settings}
    file = chosen.model_file
    head = chosen.speaker or (file if chosen.model in WITH_HEAD else None)
    facts = {
        "model": chosen.model, "model_file": file and file.name,
        "speaker": "bundled" if head is None else head.name,
        "model_sha256": file and digest(file), "terms": list(leaves.kinds), "driver": driver,
        "preset": chosen.preset,
    }  # fmt: skip
    remarks = [*footage_lines(clip.info, clip.camera), *made.remarks.splitlines()]
    classes, setting = made.setting.face.appearance.get("colour"), made.setting
    if clip.colours is not None and classes is not None:
        if usable(clip.colours, classes.chromatic) is None:
            facts["colours"] = "learned"
            remarks.append(OTHER_COLOURS.format("without" if classes.chromatic else "with"))
        else:
            setting = replace(setting, hint=GIVEN_COLOURS)
    return replace(made, setting=setting, facts={**facts, **made.facts}, remarks="\n".join(remarks))


def silent(_stage: str) -> None:
    """Tell nobody."""


@as_usual()
def track_video(
    video: str | Path,
    folder: Path,
    renderer: Renderer,
    options: TrackOptions = DEFAULTS,
    progress: Progress | None = None,
    prepared: Callable[[float], None] | None = None,
    stage: Callable[[str], None] | None = None,
    remark: Callable[[str], None] | None = None,
    recorded: Callable[[ClipTracker, Record], None] | None = None,
    beside: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, Any]:
    """Track the lips in a video and write a run; see `abs_engine.tracking.runs.record`.

    What was tracked when the process was killed, or the disk was full, is kept beside the folder:
    called again with the same choices, it goes on there.

    Parameters
    ----------
    video : Path
    folder : Path
        Must not exist; it appears when everything is written.
    renderer : Renderer
    options : TrackOptions
    progress : callable, optional
        Called after every frame with the number of frames done and of all frames.
    prepared : callable, optional
        Called before the first frame with the seconds that the preparation took.
    stage : callable, optional
        Called with what the preparation begins, in a few words.
    remark : callable, optional
        Called before the first frame with lines about the video, several faces or cuts.
    recorded : callable, optional
        Given what was prepared and recorded, once it is written.
    beside : mapping of str to str
        More files for the folder: their text by their names.

    Returns
    -------
    dict
        What ``run.json`` holds, and `timing`, what ``timing.json`` holds.

    Raises
    ------
    InputFileError, VideoError
        If the video or the speaker cannot be read, or the video breaks off.
    FaceNotFoundError
        If no face is found.
    TooFewPixelsError
        If too little of it is seen to learn its colours.
    ParameterError
        If an option does not fit the video; so of poses that are too few or too many, not finite,
        no rotations, or of another camera.
    OutputError
        If the folder exists or cannot be written; `SameOutputError` if it is this run, whole.
    """
    video, folder = to_path("video", video), to_path("folder", folder)
    check_options(options, probe(video))
    choices, by = _choices(video, options, beside), renderer.description
    say = remark or silent
    with Unfinished(folder, choices, anew="track", by=by) as made:
        if made.replaced:
            say(DISCARDED)
        with kept_if_of_use(made, made.partial / FRAMES):
            start = time.perf_counter()
            tracker = prepare(video, renderer, options, stage)
            took = time.perf_counter() - start
            if prepared is not None:
                prepared(took)
            if tracker.remarks:
                say(remark_lines(tracker))
            settings = settings_of(tracker, options) | path_of(video, folder)
            record, told = _recorded(made, tracker, settings, took, progress, say)
            if options.smooth is not None:
                smoothed = Smoothing.named(options.smooth).measures(record.arrays)
                write_smoothed(made.work, record.arrays, smoothed)
            for name, text in beside.items():
                (made.work / name).write_text(text, encoding="utf-8")
            made.finish()
    if recorded is not None:
        recorded(tracker, record)
    return told


def _recorded(
    made: Unfinished,
    tracker: ClipTracker,
    settings: dict[str, Any],
    took: float,
    progress: Progress | None,
    say: Tell,
) -> tuple[Record, dict[str, Any]]:
    """Track all frames but those that are kept, and write them; see `write_run`."""
    made.empty()
    with FrameJournal(made.partial / FRAMES, fingerprint(tracker.setting)) as journal:
        if journal.resumed:
            say(f"resuming: {counted(journal.resumed, 'frame')} already tracked")
        return write_run(
            made.work, tracker.setting, tracker.results(journal), settings, tracker.info.frames,
            progress, kept=made.partial, preparation=took, resumed=journal.resumed,
        )  # fmt: skip


def remark_lines(tracker: ClipTracker) -> str:
    """The remarks on a clip as they are printed: those that are warnings are named so."""
    warnings = tracker.setting.warnings
    return "\n".join(
        f"warning: {line}" if line in warnings else line for line in tracker.remarks.splitlines()
    )


def _choices(video: Path, options: TrackOptions, beside: Mapping[str, str]) -> str:
    """Digest of all that a run follows from; of files that options name, their content counts."""
    chosen, _ = resolved(options)
    given = {name: _content(value) for name, value in vars(chosen).items()}
    plugins = [digest(path) for path in PLUGINS]
    asked = {name: options_in(text) for name, text in beside.items()}
    return fingerprint((digest(video), code_digest(), given, plugins, asked))


def options_in(settings: str) -> str:
    """Text of a run's settings without what may differ where the options are the same.

    Comments name the release. Paths are others once the run was moved: from a new folder, all lead
    out of it.
    """
    settings = re.sub(r"^#.*\n", "", settings, flags=re.MULTILINE)
    return re.sub(r'"\.\.(?:/(?:[^"\\]|\\.)*)?"', '".."', settings)


def _content(value: object) -> object:
    """A value of the options; of a file, what it holds, and what a head's has beside it."""
    if not isinstance(value, Path):
        return value
    if value.is_dir():
        return replace(read_poses(value), path=Path())
    held = value, value.parent / POINTS, *sorted(value.parent.glob("texture_*.jpg"))
    return [digest(path) for path in held if path.is_file()]


def path_of(video: Path, folder: Path) -> dict[str, str]:
    """The setting by which a run in a folder finds its video again."""
    where = os.path.relpath(video.resolve(), folder.resolve())
    return {"video_path": Path(where).as_posix()}


def settings_of(tracker: ClipTracker, options: TrackOptions) -> dict[str, Any]:
    """Requested options, and the numbers that steer results, as JSON values."""
    return {
        "video": tracker.video.name,
        "video_sha256": digest(tracker.video),
        "size": list(tracker.info.size),
        "rate": tracker.info.rate,
        "sound": tracker.info.sound,
        "person": options.person,
        "mouth": None if options.mouth is None else list(options.mouth),
        "camera": "given" if options.camera is not None else "ideal",
        "poses": "estimated" if options.poses is None else options.poses.name,
        "physics": None if options.physics is None else options.physics.name,
        "physics_sha256": None if options.physics is None else digest(options.physics),
        "colours": "learned" if options.colours is None else options.colours.name,
        "face": options.face,
        "remarks": tracker.remarks,
        "scale": asdict(tracker.scale),
        "smoothing": None if options.smooth is None else Smoothing.named(options.smooth).told(),
        "plugins": [{"file": path.name, "sha256": digest(path)} for path in PLUGINS],
        "tuning": stage_values(),
        **tracker.facts,
    }
