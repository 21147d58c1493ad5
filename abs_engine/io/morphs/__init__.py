"""Meshes with morph targets, as files of other programs hold them."""

from __future__ import annotations

from pathlib import Path

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.io.inputs import check_file
from abs_engine.io.morphs.ict import NEUTRAL, read_ict
from abs_engine.io.morphs.mesh import MorphMesh, check_numbers
from abs_engine.io.morphs.obj import read_obj

__all__ = ["MorphMesh", "read_morphs"]


def read_morphs(path: Path, deltas: Path | None = None) -> MorphMesh:
    """Read a GLB or glTF file, an OBJ file with a folder of others, or ICT's folder.

    Parameters
    ----------
    deltas : Path, optional
        The folder of an OBJ's morph targets.

    Raises
    ------
    InputFileError
        If a file is missing, damaged or of another kind.
    ModelFormatError
        If a morph target has another number of vertices, or a number is not finite.
    ParameterError
        If `deltas` is missing for an OBJ, or given beside another file.
    """
    kind = path.suffix.lower()
    if (kind == ".obj") != (deltas is not None):
        raise ParameterError(
            f"{path} {'needs' if kind == '.obj' else 'takes no'} --deltas",
            "a folder of OBJ files, one for each morph target, goes with an OBJ file",
        )
    mesh = _read(path, kind, deltas)
    check_numbers(mesh)
    return mesh


def _read(path: Path, kind: str, deltas: Path | None) -> MorphMesh:
    if path.is_dir():
        if not (path / NEUTRAL).exists():
            raise InputFileError(
                f"{path} is a folder without {NEUTRAL}",
                "give a GLB, an OBJ, or the folder of ICT's face model",
            )
        return read_ict(path)
    check_file(path)
    if kind == ".obj":
        mesh = read_obj(path, deltas)
        if not mesh.targets:
            raise InputFileError(
                f"no OBJ file of a morph target was found in {deltas}",
                "give the folder that holds one for each, such as jawOpen.obj",
            )
        return mesh
    if kind in (".glb", ".gltf"):
        from abs_engine.io.morphs.gltf import read_gltf  # not for every head: slow to import

        return read_gltf(path)
    raise InputFileError(f"{path} is neither GLB, glTF nor OBJ", "export the head as one of them")
