"""The 52 face units of a mesh, by the names of its morph targets or by a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.registry import nearest
from abs_engine.core.words import listed
from abs_engine.face.schema import FACE_UNITS, HALF, SHIFTS, Pair, Unit, reading, units_of
from abs_engine.io.morphs import MorphMesh
from abs_engine.learn.heads.frame import HeadFrame
from abs_engine.learn.heads.settings import HEAD_IMPORT

_Moves = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Units:
    """Face units of a mesh, and what became of its morph targets.

    Parameters
    ----------
    moves : (52, V, 3) float32, mm, head frame
        In the order of `FACE_UNITS`.
    unused : tuple of str
        Targets that are no face unit, or mean one that surer names make.
    exchanged : tuple of str
        Units whose targets' names have left and right as a viewer sees them.
    """

    moves: _Moves
    unused: tuple[str, ...]
    exchanged: tuple[str, ...]


def face_units(mesh: MorphMesh, given: Mapping[str, tuple[str, ...]], frame: HeadFrame) -> Units:
    """Face units of a mesh; those that a table gives are the sums of the targets it names.

    Raises `ParameterError` if the table names a target that is not there, nothing is called
    jawOpen, or targets that mean the same unit move the same vertices differently.
    """
    targets = mesh.targets
    lacking = [t for names in given.values() for t in names if t not in targets]
    if lacking:
        raise ParameterError(
            f"{mesh.source} has no morph target '{lacking[0]}'",
            nearest(lacking[0], targets) if targets else "give a file with morph targets",
        )
    taken = {target for names in given.values() for target in names}
    named = _named([name for name in targets if name not in taken], given)
    if Unit.JAW_OPEN not in {*given, *named}:
        raise _unopened(mesh, given)
    out = np.zeros((len(FACE_UNITS), *mesh.vertices.shape), np.float32)
    for unit, names in given.items():
        for name in dict.fromkeys(names):
            out[FACE_UNITS.index(unit)] += frame.moves(targets[name])
    for unit, sides in named.items():
        for alike in sides.values():
            out[FACE_UNITS.index(unit)] += frame.moves(_once(unit, alike, targets))
            taken |= set(alike)
    pairs = _exchanged(out, frame.places(mesh.vertices), given)
    for one, other in pairs:
        out[[one, other]] = out[[other, one]]
    unused = tuple(name for name in targets if name not in taken)
    return Units(out, unused, tuple(FACE_UNITS[k] for pair in pairs for k in pair))


def _unopened(mesh: MorphMesh, given: Mapping[str, tuple[str, ...]]) -> ParameterError:
    """The error for a mesh whose mouth nothing opens, also as the table gives that away."""
    if not mesh.targets:
        return ParameterError(
            f"no morph target of {mesh.source} is called jawOpen",
            "export its morph targets, which are also called shape keys, with it",
        )
    which = f"say which opens the mouth, [units] jawOpen = ..., of {listed(mesh.targets)}"
    for unit, names in given.items():
        for name in names:
            if reading(name)[0] == Unit.JAW_OPEN:
                said = f"'{name}' is used for two units: {unit}, and jawOpen by its name"
                return ParameterError(said, which)
    return ParameterError(f"no morph target of {mesh.source} is called jawOpen", which)


def _exchanged(
    moves: _Moves, vertices: FloatArray, given: Mapping[str, object]
) -> list[tuple[int, int]]:
    """Pairs of units (left, right) by name, of which each moves the other side, or the other way.

    Left and right are the subject's. `given` are units that somebody chose by hand.
    """
    out = []
    for names in sorted([*SHIFTS, *map(units_of, Pair)]):
        if set(names) & set(given):
            continue
        pair = FACE_UNITS.index(names[0]), FACE_UNITS.index(names[1])
        left, right = (_side(moves[n], vertices, names in SHIFTS) for n in pair)
        if left < -HEAD_IMPORT.aside and right > HEAD_IMPORT.aside:
            out.append(pair)
    return out


def _side(moved: _Moves, vertices: FloatArray, shifts: bool) -> float:
    """Share of a unit's motion, -1 to 1, that lies on the left side, or goes there."""
    far = np.linalg.norm(moved, axis=1).astype(np.float64)
    x = moved[:, 0] if shifts else far * np.sign(vertices[:, 0])
    return float(x.sum() / max(far.sum(), 1e-12))


def _named(names: Sequence[str], given: Mapping[str, object]) -> dict[str, dict[str, list[str]]]:
    """Units by their names: of each side that is a half of one, or of all of it, the targets.

    Of names that mean a unit the surest count; those of halves, where nothing means the whole.
    """
    read = {name: reading(name) for name in names}
    best: dict[str, int] = {}
    for unit, how, _ in read.values():
        if unit and unit not in given:
            best[unit] = min(how, best.get(unit, HALF))
    out: dict[str, dict[str, list[str]]] = {unit: {} for unit in best}
    for name, (unit, how, side) in read.items():
        if unit and best.get(unit) == how:
            out[unit].setdefault(side, []).append(name)
    return out


def _once(unit: str, names: Sequence[str], targets: Mapping[str, _Moves]) -> _Moves:
    """Targets that mean the same, each of a part of the mesh or all alike, as one."""
    far = {name: np.linalg.norm(targets[name], axis=1) for name in names}
    most = max(float(d.max(initial=0.0)) for d in far.values())
    for one, other in combinations(names, 2):
        both = np.minimum(far[one], far[other]) > HEAD_IMPORT.still * most
        apart = np.abs(targets[one][both] - targets[other][both])
        if apart.max(initial=0.0) > HEAD_IMPORT.same * most:
            raise ParameterError(
                f"the morph targets '{one}' and '{other}' both mean {unit}, and differ",
                f'say which it is in the table: [units] {unit} = "{one}"',
            )
    out = targets[names[0]]
    for name in names[1:]:
        out = np.where((far[name] > np.linalg.norm(out, axis=1))[:, None], targets[name], out)
    return out
