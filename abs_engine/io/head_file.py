"""The file of an imported head: all of a `Speaker` in one archive, nothing beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.io.assets import FORMAT, VERSION, Speaker
from abs_engine.io.npz import write_npz

_ARRAYS = (
    "vertices", "faces", "uv", "weld", "facet_class", "class_names", "unit_names", "units",
    "identity_names", "identity", "own_texture",
)  # fmt: skip


def write_head(path: Path, head: Speaker) -> None:
    """Write an imported head as `load_speaker` reads it, whole or not at all.

    Raises
    ------
    OutputError
        If the file exists or cannot be written.
    """
    own: dict[str, Any] = {name: np.asarray(getattr(head, name)) for name in _ARRAYS}
    for name in ("class_names", "unit_names", "identity_names"):
        own[name] = own[name].astype(np.str_)
    own["people_names"] = np.array(list(head.people), np.str_)
    own["people"] = np.stack(list(head.people.values())).astype(np.float32)
    own |= dict(head.landmarks)
    own |= {f"points_{name}": at for name, at in head.points.items()}
    own |= {f"looks_{name}": texture for name, texture in head.looks.items()}
    own |= {f"network_{name}": values for name, values in head.network.items()}
    write_npz(path, FORMAT, VERSION, own)
