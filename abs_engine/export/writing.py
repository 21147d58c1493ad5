"""Export of a run: the format by its name, the output whole or not at all."""

from __future__ import annotations

from pathlib import Path

from abs_engine.core.kinds import to_path
from abs_engine.core.registry import EXPORTERS
from abs_engine.export.exporter import Exporter, Loss, TrackedRun, read_run
from abs_engine.export.smoothed import smoothed
from abs_engine.io.files import check_free, scratch, write_new
from abs_engine.io.unfinished import NewFolder
from abs_engine.tracking.smoothing import Smoothing


def export_run(
    run: Path | str,
    to: str,
    output: Path | str,
    speaker: Path | None = None,
    smooth: str | None = None,
) -> tuple[Loss, ...]:
    """Write a run in another program's format.

    Parameters
    ----------
    run : path
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
        If the run cannot be read.
    OutputError
        If the output exists or cannot be written.
    """
    exporter: Exporter = EXPORTERS.get(to)
    output = check_free(to_path("output", output), exporter.suffix)
    smoothing = None if smooth is None else Smoothing.named(smooth)
    tracked = read_run(to_path("run", run), speaker, exporter.needs)
    if smoothing is None:
        return _written(exporter, tracked, output)
    tracked, moved = smoothed(tracked, smoothing)
    return moved, *_written(exporter, tracked, output)


def _written(exporter: Exporter, tracked: TrackedRun, output: Path) -> tuple[Loss, ...]:
    """Write a file or a folder, whole or not at all."""
    if not exporter.suffix:
        with NewFolder(output) as folder:
            lost = exporter.write(tracked, folder.work)
            folder.finish()
        return lost
    with scratch() as aside:
        made = aside / output.name
        lost = exporter.write(tracked, made)
        content = made.read_bytes()
    write_new(output, content)
    return lost
