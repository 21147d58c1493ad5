"""Parquet: the table of ``results.csv`` with its types, for data frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.reading import compared, differs
from abs_engine.io.assets import LIPS_OF_68
from abs_engine.tracking.results.run_table import columns_of


def _write(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    try:
        from pyarrow import parquet, table
    except ImportError as error:
        raise ParameterError(
            "Parquet needs pyarrow", "pip install 'abs-engine[parquet]'"
        ) from error
    columns = columns_of(run.arrays, run.landmarks[:, LIPS_OF_68])
    written = table({k: v.tolist() if v.dtype.kind == "U" else v for k, v in columns.items()})
    with path.open("wb") as file:  # Arrow takes no names that are not UTF-8
        parquet.write_table(written, file)
    with path.open("rb") as file:
        back = parquet.read_table(file)
    exact = [k for k, v in columns.items() if v.dtype.kind == "U" or np.ma.isMaskedArray(v)]
    if any(back[name].to_pylist() != columns[name].tolist() for name in exact):
        raise differs(f"columns {', '.join(exact)}")
    numbers = columns.keys() - exact
    read, true = (np.concatenate([one[k] for k in numbers]) for one in (back, columns))
    return (compared(read, true, "", "numbers of the table (each in its own unit)"),)


PARQUET = Exporter(
    "Parquet: a row for each frame, as results.csv, with types", _write, ".parquet",
    needs=("parameter_names",),
)  # fmt: skip
