"""A video tracked in one call, and what comes of it as arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import CALLED, PATH, check_kind, to_path
from abs_engine.core.registry import nearest
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import closed_after
from abs_engine.dataset import load_camera
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.io.unfinished import NewFolder
from abs_engine.io.video import probe
from abs_engine.render.select import open_renderer
from abs_engine.render.trial import check_renderer
from abs_engine.tracking.option_checks import check_options
from abs_engine.tracking.options import ClipTracker, TrackOptions
from abs_engine.tracking.output import COLOURS, Progress
from abs_engine.tracking.record import Record, Recorder
from abs_engine.tracking.run import path_of, prepare, settings_of, track_video
from abs_engine.tracking.run_mesh import RunMesh
from abs_engine.tracking.run_table import OF_LIPS
from abs_engine.tracking.smoothing import Smoothing, write_smoothed

if TYPE_CHECKING:
    from pandas import DataFrame

_INTERNAL = ("model_file",)  # follows from `model`


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """Results of tracking a video of T frames.

    Parameters
    ----------
    record : Record
        What the files of a run hold.
    settings : dict
        What was asked for.
    smoothed : dict of str to (T,) float64
        The measures, filtered as ``smooth`` asks, as ``smoothed.csv`` has them; empty
        without one. All else is as it was found.
    video : Path
    colours : ColourClasses, optional
        Those that frames were compared by.
    """

    record: Record
    settings: dict[str, Any]
    smoothed: dict[str, FloatArray]
    video: Path
    colours: ColourClasses | None = None

    def __repr__(self) -> str:
        """Return a line that names the video and counts the frames."""
        video, found = self.settings.get("video"), int(self.found.sum())
        return f"<Run of {video}: {len(self)} frames, {found} found>"

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.arrays["index"])

    def __getitem__(self, name: str) -> NDArray[Any]:
        """An array by its name.

        Raises
        ------
        ParameterError
            If there is none; the nearest name is given.
        """
        if not isinstance(name, str):
            raise ParameterError("a run's arrays have names", "write, for example, run['aperture']")
        if name not in self.arrays:
            raise ParameterError(f"there is no array '{name}'", nearest(name, self.arrays))
        return np.asarray(self.arrays[name])

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the arrays."""
        return iter(self.arrays)

    @property
    def arrays(self) -> dict[str, Any]:
        """As ``results.npz`` has them, see `Record`; the most used are attributes, too."""
        return self.record.arrays

    @property
    def mesh(self) -> RunMesh:
        """The whole head in every frame."""
        return self.record.mesh

    @property
    def summary(self) -> dict[str, Any]:
        """Counts, means and warnings."""
        return self.record.summary

    @property
    def time(self) -> FloatArray:
        """Time at which each frame is shown, (T,), seconds."""
        return self["time"]

    @property
    def found(self) -> BoolArray:
        """Whether the lips were followed, (T,)."""
        return self["found"]

    @property
    def aperture(self) -> FloatArray:
        """Height between the inner lips at their middle, (T,), mm; NaN where they were lost."""
        return self["aperture"]

    @property
    def width(self) -> FloatArray:
        """Distance of the mouth's corners, (T,), mm."""
        return self["width"]

    @property
    def aperture_sd(self) -> FloatArray:
        """Standard deviation of the aperture, (T,), mm; NaN where the evidence cannot say."""
        return self["aperture_sd"]

    @property
    def width_sd(self) -> FloatArray:
        """Standard deviation of the width, (T,), mm; NaN where the evidence cannot say."""
        return self["width_sd"]

    @property
    def closed_probability(self) -> FloatArray:
        """Probability that the lips are closed, (T,); NaN where the evidence cannot say."""
        return self["closed_probability"]

    @property
    def closed(self) -> BoolArray:
        """Whether the lips are closed, (T,); False where they were lost: mask it with `found`."""
        return self["closed"]

    @property
    def closures(self) -> FloatArray:
        """Onset and release of each closure, (C, 2), seconds; NaN where they are not seen."""
        return self["closure_times"]

    @property
    def lip_points(self) -> FloatArray:
        """The lips' contours, (T, N, 3), mm, head frame."""
        return self["lip_points"]

    @property
    def rotation(self) -> FloatArray:
        """Head to camera as rotation vectors, (T, 3), radians."""
        return self["rotation"]

    @property
    def translation(self) -> FloatArray:
        """Head to camera, (T, 3), mm."""
        return self["translation"]

    @property
    def parameters(self) -> dict[str, FloatArray]:
        """The parameters of pose and posture by their names, (T,) each."""
        names, values = self["parameter_names"], self["parameters"]
        return {str(name): values[:, k] for k, name in enumerate(names)}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons to doubt the results."""
        return tuple(self.summary.get("warnings", ()))

    def save(self, folder: str | Path) -> None:
        """Write the folder that `track` writes, as far as it holds data.

        ``overlay.mp4``, ``contact_sheet.png`` and ``head.png``, which need the video's pictures,
        are left out; so are ``timing.json`` and ``.choices``. Everything that reads runs reads it.

        Parameters
        ----------
        folder : path
            Must not exist.

        Raises
        ------
        OutputError
            If the folder exists or cannot be written.
        """
        target = to_path("folder", folder)
        with NewFolder(target) as made:
            self.record.write(made.work, {"settings": self.settings | path_of(self.video, target)})
            if self.colours is not None:
                self.colours.save(made.work / COLOURS)
            if self.smoothed:
                write_smoothed(made.work, self.arrays, self.smoothed)
            made.finish()

    def to_pandas(self) -> DataFrame:
        """The table of ``results.csv``, a row for each frame; booleans are 0, 1 or, if lost, NA.

        Raises
        ------
        ParameterError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise ParameterError("pandas is not installed", "pip install pandas") from error
        names, *rows = self.record.table()
        table = pandas.DataFrame(rows, columns=names)
        return table.astype(dict.fromkeys(OF_LIPS, "Int8"))


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
        Folder of a run, which must not exist; by default nothing is written.
    renderer : str or Renderer, optional
        A name, of which one is opened and closed again (see `open_renderer`), or an open one.
    camera : path or Camera, optional
        Its calibration, or a `camera.json`.
    terms : str or sequence of str, optional
        Evidence: "colour", "colour+texture".
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
        collected: list[Run] = []
        if folder is None:
            tracker = prepare(path, drawn, chosen, stage)
            return _run(tracker, chosen, progress)

        def keep(tracker: ClipTracker, record: Record) -> None:
            collected.append(_of(record, tracker, chosen))

        track_video(path, folder, drawn, chosen, progress, stage=stage, recorded=keep)
        return collected[0]


def _run(tracker: ClipTracker, chosen: TrackOptions, progress: Progress | None) -> Run:
    recorder, frames = Recorder(tracker.setting), tracker.info.frames
    with closed_after(tracker.results()) as results:
        for _, result in results:
            recorder.add(result)
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
    known = [one.name for one in fields(TrackOptions) if one.name not in _INTERNAL]
    for name in given:
        if name not in known:
            raise ParameterError(f"there is no option '{name}'", nearest(name, known))
    if camera is not None and not isinstance(camera, Camera):
        check_kind("camera", camera, (PATH[0], "a path or a Camera"))
        camera = load_camera(Path(camera))
    return TrackOptions(**{**given, "terms": terms}, camera=camera)


@contextmanager
def _opened(renderer: str | Renderer | None) -> Iterator[Renderer]:
    if renderer is not None and not isinstance(renderer, str):
        if not hasattr(renderer, "draw"):
            raise ParameterError(f"renderer is {renderer!r}", "give a name, or an open renderer")
        check_renderer(type(renderer).__name__, renderer)
        yield renderer
        return
    with open_renderer(renderer) as opened:
        yield opened
