"""Parts of a mesh, by their names or by a table: the face must be skin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import vertex_normals
from abs_engine.core.registry import nearest
from abs_engine.face.schema import HIDDEN, ICT_PARTS, LIPS, region_of
from abs_engine.io.morphs import MorphMesh
from abs_engine.learn.heads.marks import Marks
from abs_engine.learn.heads.regions import lie_on_others
from abs_engine.learn.heads.settings import HEAD_IMPORT

_SKIN = ("skin",)


@dataclass(frozen=True, eq=False)
class Surface:
    """A head's facets, each once and facing out of it, and the regions that their parts name.

    Parameters
    ----------
    words : (F,) str
        Of `schema.REGION_WORDS`.
    inside_out : bool
        Whether the facets of the file face into the head: they were turned round.
    twice : int
        Facets that lie on others: they were left out.
    """

    mesh: MorphMesh
    words: NDArray[np.object_]
    inside_out: bool
    twice: int

    @classmethod
    def of(
        cls,
        mesh: MorphMesh,
        given: Mapping[str, str],
        marks: Marks,
        vertices: FloatArray,
        weld: IntArray,
    ) -> Surface:
        """The surface of a mesh at vertices (V, 3), mm, head frame, whose seams `weld` (V,) joins.

        Raises `ParameterError` if a region that is `given` is of no part, if nose or chin are on no
        skin, or if other parts lie away from the face.
        """
        double = lie_on_others(weld[mesh.faces])
        mesh = mesh.of_facets(~double) if double.any() else mesh
        words = _named_regions(mesh, given)
        _check_face(mesh, words, marks, weld)
        _check_places(mesh, words, vertices, int(marks.nose_tip[0]))
        inside_out = _is_inside_out(mesh, words, marks, vertices)
        mesh = mesh.turned() if inside_out else mesh
        return cls(mesh, words, inside_out, int(double.sum()))


def _named_regions(mesh: MorphMesh, given: Mapping[str, str]) -> NDArray[np.object_]:
    """Region of each facet (F,) by the name of its part, one of `schema.REGION_WORDS`.

    `given` are regions by pieces of names; they count more than what names say themselves. Raises
    `ParameterError` if one of them is in no part's name.
    """
    _check_given(mesh, given)
    known = ICT_PARTS if mesh.model == "ict" else {}
    words = []
    for name in mesh.part_names:
        told = [v for k, v in (*given.items(), *known.items()) if k.lower() in name.lower()]
        words.append(told[0] if told else region_of(name))
    return np.array(words, object)[mesh.part]


def _check_given(mesh: MorphMesh, given: Mapping[str, str]) -> None:
    """Raise `ParameterError` for a piece of a name that no part has; the nearest is named."""
    lacking = [k for k in given if not any(k.lower() in name.lower() for name in mesh.part_names)]
    if not lacking:
        return
    pieces = dict.fromkeys(p for name in mesh.part_names for p in name.split(" / ") if p)
    raise ParameterError(
        f"{mesh.source} has no part '{lacking[0]}', which [regions] names",
        nearest(lacking[0], pieces) if pieces else "leave out [regions]: its parts have no names",
    )


def hidden_parts(mesh: MorphMesh, words: NDArray[np.object_]) -> tuple[str, ...]:
    """Names of the parts that are not drawn."""
    return _of(mesh, words == HIDDEN)


def _of(mesh: MorphMesh, facets: NDArray[np.bool_]) -> tuple[str, ...]:
    """Names of the parts that facets (F,) belong to, without what they say twice."""
    names = [mesh.part_names[k] for k in np.unique(mesh.part[facets])]
    apart = (dict.fromkeys(piece for piece in name.split(" / ") if piece) for name in names)
    return tuple(" / ".join(pieces) or "without a name" for pieces in apart)


def _check_face(mesh: MorphMesh, words: NDArray[np.object_], marks: Marks, weld: IntArray) -> None:
    """Raise `ParameterError` where the tip of the nose or the chin (V,) is on no skin."""
    corners = weld[mesh.faces]
    for name, at in (("nose_tip", marks.nose_tip), ("chin", marks.chin)):
        on = (corners == weld[at[0]]).any(axis=1)
        if not on.any():
            raise ParameterError(
                f"landmark {name} is on no facet of {mesh.source}", "give a vertex of the face"
            )
        if np.isin(words[on], _SKIN).any():
            continue
        (part, *_), word = _of(mesh, on), words[on][0]
        taken = "is not drawn" if word == HIDDEN else f"is taken for {word.replace('_', ' ')}"
        raise ParameterError(
            f"landmark {name} is on the part '{part}' of {mesh.source}, which {taken}",
            f'if it is the face, say so in the table: [regions] "{part.split(" / ")[-1]}" = "skin"',
        )


def _is_inside_out(
    mesh: MorphMesh, words: NDArray[np.object_], marks: Marks, vertices: FloatArray
) -> bool:
    """Whether the skin at nose, chin and lips faces into the head (V, 3), head frame."""
    skin = mesh.faces[np.isin(words, (*_SKIN, LIPS, "upper_lip", "lower_lip"))]
    at = np.r_[marks.nose_tip, marks.chin, marks.outer_lip]
    return bool(np.median(vertex_normals(vertices, skin)[at, 2]) < 0)


def _check_places(
    mesh: MorphMesh, words: NDArray[np.object_], vertices: FloatArray, nose: int
) -> None:
    """Raise `ParameterError` where eyes, teeth or tongue lie away from the face (V, 3), mm."""
    away = np.linalg.norm(vertices - vertices[nose], axis=1)[mesh.faces].min(axis=1)
    for k in np.unique(mesh.part[~np.isin(words, [*_SKIN, HIDDEN])]):
        nearest_mm = float(away[mesh.part == k].min())
        if nearest_mm > HEAD_IMPORT.part_near:
            (part,) = _of(mesh, mesh.part == k)
            raise ParameterError(
                f"part '{part}' of {mesh.source}, taken for {words[mesh.part == k][0]}, lies "
                f"{nearest_mm:.0f} mm away from the face",
                "export the head with all its parts in place, or leave the part out: "
                f'[regions] "{part.split(" / ")[-1]}" = "none"',
            )
