"""ICT's face model, from the folder of its own files or from one archive of them.

Li et al., "Learning Formation of Physically-Based Face Attributes", CVPR 2020; the light version
of ICT-FaceKit: ``generic_neutral_mesh.obj``, an OBJ for each expression, ``identityNNN.obj`` for
each principal component. ``ict_face_model.npz`` may stand for these OBJs: `neutral`,
`expression_names` and `expression_deltas`, `identity_deltas`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError
from abs_engine.io.arrays import check_arrays, real, text
from abs_engine.io.morphs.mesh import MorphMesh, displacement
from abs_engine.io.morphs.obj import read_obj, tiled
from abs_engine.io.npz import read_arrays

NEUTRAL, ARCHIVE = "generic_neutral_mesh.obj", "ict_face_model.npz"
_IDENTITY = "identity"
_SINGLE = np.float32
_TILES, _EYES = 7, ("M_ScleraLeft", "M_ScleraRight")


def read_ict(folder: Path) -> MorphMesh:
    """Read the model's folder.

    Raises
    ------
    InputFileError
        If a file is missing or cannot be read.
    ModelFormatError
        If a target has another number of vertices.
    """
    if (folder / ARCHIVE).is_file():
        mesh = read_obj(folder / NEUTRAL, None)
        expressions, identity = _of_archive(folder / ARCHIVE, mesh.vertices)
    else:
        mesh = read_obj(folder / NEUTRAL, folder)
        own = {name: name.startswith(_IDENTITY) for name in mesh.targets}
        expressions = {name: d for name, d in mesh.targets.items() if not own[name]}
        identity = {name: d for name, d in mesh.targets.items() if own[name]}
    if not expressions:
        raise InputFileError(
            f"{folder} has no expressions of ICT's face model",
            f"it should hold jawOpen.obj and so on beside {NEUTRAL}",
        )
    return replace(
        mesh, source=str(folder), targets=expressions, components=identity, model="ict",
        uv=_parted(mesh),
    )  # fmt: skip


def _parted(mesh: MorphMesh) -> NDArray[np.float32] | None:
    """Places (F, 3, 2) on a texture of nine tiles, of which the eyes get the last two."""
    if mesh.uv is None:
        return None
    places = mesh.uv * [_TILES, 1.0]
    for beyond, eye in enumerate(_EYES):
        own = [k for k, name in enumerate(mesh.part_names) if eye in name]
        places[np.isin(mesh.part, own), :, 0] += _TILES + beyond
    return tiled(np.asarray(places, np.float32))


_Targets = dict[str, NDArray[np.float32]]


def _of_archive(path: Path, neutral: NDArray[np.float64]) -> tuple[_Targets, _Targets]:
    v = len(neutral)
    layout = {
        "expression_names": text("names"), "expression_deltas": real("names", v, 3, dtype=_SINGLE),
        "identity_deltas": real("people*", v, 3, dtype=_SINGLE),
    }  # fmt: skip
    data = check_arrays(path, read_arrays(path), layout, "leave it out and give the OBJ files")
    people = data["identity_deltas"]
    pairs = zip(data["expression_names"].tolist(), data["expression_deltas"], strict=True)
    none = np.zeros_like(neutral)
    named = [(f"{_IDENTITY}{k:03d}", d) for k, d in enumerate(people)]
    expressions, identity = (
        {name: displacement(name, d, none) for name, d in group} for group in (pairs, named)
    )
    return expressions, identity
