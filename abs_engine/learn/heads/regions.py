"""Facet classes of a head, by what its parts are and by the contours of its lips."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.schema import CLASS_NAMES, LIPS, TEETH
from abs_engine.learn.heads.marks import Contours
from abs_engine.learn.heads.settings import HEAD_IMPORT

HIDDEN_ID = 255
_BY_NAME = {name: k for k, name in enumerate(CLASS_NAMES)}
_MOUTH = ("skin", "upper_lip", "lower_lip", "inner_mouth")
_LIP_EDGES = ("over", "upper"), ("under", "lower")
_EDGE = 2  # corners of a facet that lie on a contour when one of its edges does


def welded(vertices: FloatArray, jaw: FloatArray) -> IntArray:
    """Geometric vertex that each one is, by its place (V, 3), mm, and by how the jaw moves it.

    Copies at the seams of textures share a number; lips that touch each other do not.
    """
    both = np.round(np.hstack([vertices, jaw]), 3)
    _, first, back = np.unique(both, axis=0, return_index=True, return_inverse=True)
    order = np.empty(len(first), np.int64)
    order[np.argsort(first)] = np.arange(len(first))
    return order[back.ravel()]


def lie_on_others(corners: IntArray) -> BoolArray:
    """Whether facets (F,) have the corners (F, 3), geometric vertices, of one before them.

    Meshes that are to be seen from both sides have each facet twice, and normals that cancel out.
    """
    own = np.sort(corners, axis=1)
    out = np.ones(len(own), bool)
    out[np.unique(own, axis=0, return_index=True)[1]] = False
    flat = (own[:, 1:] == own[:, :-1]).any(axis=1)  # has no normal
    return np.asarray(out & ~flat)


def facet_classes(
    words: NDArray[np.object_],
    vertices: FloatArray,
    faces: NDArray[np.integer],
    weld: IntArray,
    contours: Contours,
    jaw: FloatArray,
    nose: int,
) -> NDArray[np.uint8]:
    """Facet classes (F,), indices into `CLASS_NAMES`; `HIDDEN_ID` of what is not drawn.

    Parameters
    ----------
    words : (F,) of str
        See `parts.Surface`; where they name lips, these end there, and not at the contours.
    vertices : (V, 3) float64, mm
    faces : (F, 3) int
    weld : (V,) int64
    jaw : (V, 3) float64, mm
        How `jawOpen` moves the head.
    nose : int
        A vertex of the face.

    Raises
    ------
    ParameterError
        If the contours do not part the lips from the face.
    """
    out = np.full(len(faces), HIDDEN_ID, np.uint8)
    for name, k in _BY_NAME.items():
        out[words == name] = k
    named = np.flatnonzero(words == LIPS)
    out[named] = _BY_NAME["skin"]
    skin = np.flatnonzero(np.isin(out, [_BY_NAME[n] for n in _MOUTH]))
    for name, own in _parted(weld[faces[skin]], weld, contours, int(weld[nose])).items():
        out[skin[own]] = _BY_NAME[name]
    named = named[~np.isin(out[named], [_BY_NAME[name] for name in ("upper_lip", "lower_lip")])]
    above = _nearer_above(vertices + HEAD_IMPORT.ajar * jaw, faces[named], contours)
    out[named] = np.where(above, _BY_NAME["upper_lip"], _BY_NAME["lower_lip"])
    teeth = np.flatnonzero(words == TEETH)
    out[teeth] = np.where(
        moving(teeth, faces, weld, jaw), _BY_NAME["lower_teeth"], _BY_NAME["upper_teeth"]
    )
    return out


def _parted(
    corners: IntArray, weld: IntArray, contours: Contours, nose: int
) -> dict[str, BoolArray]:
    """Masks (F,) of facets that the contours part, by the geometric vertices at their corners."""
    c = contours
    ways = {k: weld[getattr(c, k)] for k in ("over", "under", "upper", "lower", "right", "left")}
    labels = _pieces(corners, [np.stack([w[:-1], w[1:]], axis=1) for w in ways.values()])

    def along(*names: str) -> BoolArray:
        """Facets with an edge on some of the contours."""
        on = [np.isin(corners, ways[name]).sum(axis=1) >= _EDGE for name in names]
        return np.asarray(np.any(on, axis=0))

    face = labels[(corners == nose).any(axis=1)]
    outer = np.unique(labels[along("over", "under")])
    inner = np.unique(labels[along("upper", "lower")])
    lips, inside = np.setdiff1d(outer, face), np.setdiff1d(inner, np.r_[outer, face])
    if not len(lips) or np.isin(inner, face).any():
        raise ParameterError(
            "the contours of the lips do not part them from the face",
            "give more points of outer_lip and inner_lip, on the mesh of the face",
        )
    above, below = (np.bincount(labels[along(*n)], minlength=labels.max() + 1) for n in _LIP_EDGES)
    high = (above > below)[labels]
    lip = np.isin(labels, lips)
    return {
        "upper_lip": lip & high,
        "lower_lip": lip & ~high,
        "inner_mouth": np.isin(labels, inside),
    }


def _nearer_above(opened: FloatArray, faces: NDArray[np.integer], contours: Contours) -> BoolArray:
    """Whether facets of an open mouth are nearer to the contours of the upper lip."""
    c = contours
    away = [
        cKDTree(opened[ring[1:-1]]).query(opened[faces].mean(axis=1))[0]
        for ring in (np.r_[c.over, c.upper], np.r_[c.under, c.lower])
    ]
    return np.asarray(away[0] < away[1])


def _pieces(corners: IntArray, cut: Sequence[IntArray] = ()) -> IntArray:
    """The connected piece (F,) that each facet belongs to once edges (N, 2) are cut."""
    edges = np.sort(np.concatenate([corners[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    count = int(corners.max()) + 1
    keys = edges[:, 0] * count + edges[:, 1]
    gone = np.sort(np.concatenate([np.zeros((0, 2), np.int64), *cut]), axis=1)
    kept = ~np.isin(keys, gone[:, 0] * count + gone[:, 1])
    owner = np.tile(np.arange(len(corners)), 3)[kept]
    number = np.unique(keys[kept], return_inverse=True)[1].ravel()
    shared = csr_matrix((np.ones(len(owner)), (owner, number)))
    whole = shared @ shared.T if len(owner) else shared
    if whole.shape[0] < len(corners):
        whole.resize((len(corners), len(corners)))
    return np.asarray(connected_components(whole, directed=False)[1])


def moving(
    facets: IntArray, faces: NDArray[np.integer], weld: IntArray, jaw: FloatArray
) -> BoolArray:
    """Whether each of some facets (N,) belongs to a connected part that goes with the jaw."""
    if not len(facets):
        return np.zeros(0, bool)
    labels = _pieces(weld[faces[facets]])
    far = np.linalg.norm(jaw, axis=1)
    each = far[faces[facets]].mean(axis=1)
    mean = np.bincount(labels, each) / np.bincount(labels)
    return np.asarray(mean[labels] > HEAD_IMPORT.moved * far.max())
