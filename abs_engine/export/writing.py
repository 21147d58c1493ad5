"""Export of a run: the format by its name, the output whole or not at all."""

from __future__ import annotations

from pathlib import Path

from abs_engine.core.registry import EXPORTERS
from abs_engine.export.exporter import Exporter, Loss, read_run
from abs_engine.io.files import check_free, scratch, write_new
from abs_engine.io.unfinished import NewFolder


def export_run(
    run: Path | str, to: str, output: Path | str, speaker: Path | None = None
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

    Returns
    -------
    tuple of Loss
        What reading the output back gives, beside the run.

    Raises
    ------
    ParameterError
        If there is no such format, or it needs a package that is missing.
    InputFileError, ModelFormatError
        If the run cannot be read.
    OutputError
        If the output exists or cannot be written.
    """
    exporter: Exporter = EXPORTERS.get(to)
    output = check_free(Path(output), exporter.suffix)
    tracked = read_run(Path(run), speaker)
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
