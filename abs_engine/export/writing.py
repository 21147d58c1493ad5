"""Export of a run: the format by its name, smoothed or not, the output whole or not at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, OutputError, ParameterError, PluginError
from abs_engine.core.foreign import blamed, own
from abs_engine.core.geometry import Pose
from abs_engine.core.kinds import TEXT, check_kind, to_path
from abs_engine.core.registry import EXPORTERS, nearest
from abs_engine.export.exporter import Exporter, Loss, TrackedRun, read_run, rms
from abs_engine.io.files import check_free, scratch, write_new
from abs_engine.io.new_folder import NewFolder
from abs_engine.tracking.results.measures import closure_arrays, closures, cuts
from abs_engine.tracking.results.run_table import closed_frames
from abs_engine.tracking.results.smoothing import Smoothing
from abs_engine.tracking.run_in_memory import Run
from abs_engine.tracking.runs.record import TABLE

_INSTEAD = {
    "csv": f"use {TABLE} of the run itself",
    "textgrid": "use praat, which writes a TextGrid",
    "elan": "use praat, whose TextGrid ELAN imports",
}
"""Advice about formats that another name, or the run itself, stands for."""


def export_run(
    run: Path | str | Run,
    to: str,
    output: Path | str,
    speaker: Path | None = None,
    smooth: str | None = None,
) -> tuple[Loss, ...]:
    """Write a run in another program's format.

    Parameters
    ----------
    run : path or Run
        What `track` made.
    to : str
        Name of an exporter; see `EXPORTERS.names()`.
    output : path
        A file with the format's ending, or a folder; must not exist.
    speaker : Path, optional
        The head that the run was tracked with, if not the bundled one.
    smooth : str, optional
        A filter, "butterworth:HZ" or "savitzky-golay:FRAMES", by which the run is smoothed before.

    Returns
    -------
    tuple of Loss
        What reading the output back gives, beside the run; of a smoothed one, first how far the
        filter moves the lips, then what is read back beside that.

    Raises
    ------
    ParameterError
        If a value is of another kind, there is no such format or filter, or the format needs a
        package that is missing.
    InputFileError, ModelFormatError
        If the run cannot be read, or has no tracked frame.
    OutputError
        If the output exists, cannot be written, or is a folder that is named like the files in it.
    PluginError
        If a plugin's exporter fails, writes nothing, or does not return what is lost.
    """
    check_kind("the format", to, TEXT)
    if to not in EXPORTERS:
        instead = _INSTEAD.get(to.lower()) or nearest(to, EXPORTERS)
        raise ParameterError(f"there is no format '{to}'", instead)
    exporter: Exporter = EXPORTERS.get(to)
    output = check_free(to_path("output", output), exporter.suffix)
    smoothing = None if smooth is None else Smoothing.named(smooth)
    if isinstance(run, Run):
        with scratch() as aside:
            run.save(aside / "run")
            return export_run(aside / "run", to, output, speaker, smooth)
    tracked = read_run(to_path("run", run), speaker, exporter.needs)
    if not tracked.frames:
        raise InputFileError(
            "no frame of the run was tracked, so there is nothing to export",
            "look at its overlay, and track another video",
        )
    if smoothing is None:
        return _written(to, exporter, tracked, output)
    tracked, moved = smoothed(tracked, smoothing)
    return moved, *_written(to, exporter, tracked, output)


def _written(name: str, exporter: Exporter, tracked: TrackedRun, output: Path) -> tuple[Loss, ...]:
    """Write a file or a folder, whole or not at all."""
    if not exporter.suffix:
        with NewFolder(output) as folder:
            lost = _lost(name, exporter, tracked, folder.work)
            if not any(folder.work.iterdir()):
                raise PluginError(
                    f"the exporter '{name}' wrote nothing", "make it write into the given folder"
                )
            if output.suffix and output.suffix.lower() in {
                one.suffix.lower() for one in folder.work.iterdir()
            }:
                raise OutputError(
                    f"{output} is named like a file, but a folder is written",
                    f"choose a name without {output.suffix}",
                )
            folder.finish()
        return lost
    with scratch() as aside:
        made = aside / output.name
        lost = _lost(name, exporter, tracked, made)
        if not made.is_file():
            raise PluginError(
                f"the exporter '{name}' wrote no file {made.name}", "make it write that path"
            )
        content = made.read_bytes()
    write_new(output, content)
    return lost


def _lost(name: str, exporter: Exporter, tracked: TrackedRun, path: Path) -> tuple[Loss, ...]:
    """Losses that an exporter reports once it has written; `PluginError` if a plugin's fails."""
    if own(exporter.write):
        return exporter.write(tracked, path)  # an error is of the disk
    with blamed(f"the exporter '{name}'"):
        lost: object = exporter.write(tracked, path)
    if isinstance(lost, tuple) and all(isinstance(one, Loss) for one in lost):
        return lost
    raise PluginError(
        f"the exporter '{name}' does not return what is lost",
        "return a tuple of Loss, which may be empty",
    )


def smoothed(run: TrackedRun, smoothing: Smoothing) -> tuple[TrackedRun, Loss]:
    """Postures, the head's pose and all measures smoothed; and how far this moves the lips.

    The run itself stays as it is. Raises `ParameterError` if the filter cannot be used for its
    frames.
    """
    time = np.asarray(run.arrays["time"], np.float64)
    smoothing.check(run.rate, time)
    cut = cuts(run.arrays)
    mesh = replace(run.mesh, weights=smoothing(run.mesh.weights, run.rate, cut))
    measured = smoothing.measures(run.arrays)
    rotation, translation = _poses(run, smoothing)
    arrays = {
        **run.arrays, **measured, "rotation": rotation, "translation": translation,
        "parameters": smoothing(run.arrays["parameters"], run.rate, cut),
        "closed": closed_frames(measured["aperture"]),
        **closure_arrays(closures(measured["aperture"], time, cut)),
    }  # fmt: skip
    lips = run.speaker.points["lips"]
    moved = Loss(rms(mesh.points(lips) - run.mesh.points(lips)), "mm", f"lips, by {smoothing}")
    return replace(run, arrays=arrays, mesh=mesh), moved


def _poses(run: TrackedRun, smoothing: Smoothing) -> tuple[FloatArray, FloatArray]:
    """Rotation vectors and translations (T, 3); smoothed about the first pose.

    There rotation vectors do not jump, as those of a face that looks into the camera do.
    """
    turned = np.full((len(run), 3), np.nan)
    there = np.isfinite(run.arrays["rotation"]).all(axis=1)
    posed = np.flatnonzero(there).tolist()  # frames with a covered mouth among them
    first = run.pose(posed[0]).rotation
    for frame in posed:
        turned[frame] = Pose(first.T @ run.pose(frame).rotation, np.zeros(3)).rotation_vector
    cut = cuts(run.arrays)
    turned = smoothing(turned, run.rate, cut)
    rotation = np.full((len(run), 3), np.nan)
    for frame in posed:
        about = Pose.from_vectors(turned[frame], np.zeros(3)).rotation
        rotation[frame] = Pose(first @ about, np.zeros(3)).rotation_vector
    return rotation, smoothing(run.arrays["translation"], run.rate, cut)
