"""A video's results as arrays: what `track` returns, and what can be saved and loaded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import to_path
from abs_engine.core.registry import nearest
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.io.inputs import is_there
from abs_engine.io.new_folder import NewFolder
from abs_engine.tracking.results.run_mesh import RunMesh
from abs_engine.tracking.results.run_table import OF_LIPS
from abs_engine.tracking.results.smoothing import Smoothing, write_smoothed
from abs_engine.tracking.run import path_of
from abs_engine.tracking.runs.output import COLOURS
from abs_engine.tracking.runs.record import Record, load_record, run_settings

if TYPE_CHECKING:
    from pandas import DataFrame


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

    @classmethod
    def load(cls, folder: str | Path) -> Run:
        """Read the folder that `track` or `save` wrote.

        Parameters
        ----------
        folder : path

        Raises
        ------
        InputFileError, ModelFormatError
            If it is no run, or its files cannot be read or do not fit together.
        """
        path = to_path("folder", folder)
        record, settings = load_record(path), run_settings(path)
        smoothing = settings.get("smoothing")
        smoothed = Smoothing.of_told(smoothing).measures(record.arrays) if smoothing else {}
        colours = path / COLOURS
        return cls(
            record, settings, smoothed, (path / str(settings.get("video_path", ""))).resolve(),
            ColourClasses.load(colours) if is_there(colours) else None,
        )  # fmt: skip

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
        are left out; so are ``timing.json``, ``.choices`` and ``settings.toml``. Everything that
        reads runs reads it.

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
