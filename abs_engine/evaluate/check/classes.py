"""Facet classes: whether they lie where their names say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.dataset import Clip
from abs_engine.evaluate.check.finding import Finding

_MARKS: dict[str, Sequence[int]] = {
    "skin": range(36), "upper_lip": range(49, 54), "lower_lip": range(55, 60),
}  # fmt: skip
"""Landmarks of the 68 whose vertices must belong to a facet of the class."""


def class_findings(clip: Clip, name: str) -> Iterator[Finding]:
    """Facet classes that lie where their name does not belong; unknown names are left alone."""
    classes = clip.facet_class
    if classes.shape != (len(clip.faces),) or classes.min() < 1:
        yield Finding(name, "facet_class has not a class for every facet", f"{classes.shape}")
        return
    if classes.max() >= len(clip.class_names):
        yield Finding(name, "facet_class names classes that do not exist", f"{classes.max()}")
        return
    for label, marks in _MARKS.items():
        if label in clip.class_names:
            share = _share_of_marks(clip, label, marks)
            if share < 0.8:
                how = f"{1 - share:.0%} of its landmarks are of other classes"
                yield Finding(name, f"class '{label}' is not where it should be", how)
    areas = _areas(clip)
    for what, holds in _relations(areas):
        if not holds:
            yield Finding(name, f"classes are mixed up: {what}")


def _share_of_marks(clip: Clip, label: str, marks: Sequence[int]) -> float:
    """Share of some landmarks that are a corner of a facet of the class."""
    vertex = clip.landmarks["landmark_68"][list(marks)]
    own = clip.faces[clip.facet_class == clip.class_names.index(label)]
    places = clip.neutral[np.unique(own)]  # copies of a vertex at texture seams share a place
    near = [np.abs(places - clip.neutral[v]).max(axis=1).min(initial=np.inf) < 1e-3 for v in vertex]
    return float(np.mean(near))


def _areas(clip: Clip) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Mean and half extent (3,) each, mm, of the facets of every class that has some."""
    middles = clip.neutral[clip.faces].astype(np.float64).mean(axis=1)
    out = {}
    for index, label in enumerate(clip.class_names):
        own = middles[clip.facet_class == index]
        if len(own):
            out[label] = own.mean(axis=0), np.ptp(own, axis=0) / 2
    marks = clip.neutral[clip.landmarks["landmark_68"]].astype(np.float64)
    out["mouth"] = marks[48:].mean(axis=0), np.ptp(marks[48:], axis=0) / 2
    out["lids"] = marks[36:48].mean(axis=0), np.ptp(marks[36:48], axis=0) / 2
    return out


def _relations(areas: dict[str, tuple[FloatArray, FloatArray]]) -> Iterator[tuple[str, bool]]:
    """Conditions on the places and sizes of the classes, and whether they hold."""
    at = {label: mean for label, (mean, _) in areas.items()}
    half = {label: size for label, (_, size) in areas.items()}
    if "eyes" in at:
        near = np.abs(at["eyes"][:2] - at["lids"][:2]).max() < 8
        yield "the eyes are not at the lids", bool(near and half["eyes"][0] > 15)
    if {"upper_teeth", "lower_teeth"} <= set(at):
        yield "upper and lower teeth", bool(at["upper_teeth"][1] > at["lower_teeth"][1] + 3)
        mouth = (at["upper_teeth"] + at["lower_teeth"]) / 2
        inside = abs(mouth[1] - at["mouth"][1]) < 12 and mouth[2] < at["mouth"][2]
        yield "the teeth are not in the mouth", bool(inside)
    if {"tongue", "lower_teeth"} <= set(at):
        behind = (
            at["tongue"][2] < at["lower_teeth"][2] and half["tongue"][0] < half["lower_teeth"][0]
        )
        yield "the tongue is not between the teeth", bool(behind)
    if {"inner_mouth", "tongue"} <= set(at):
        around = half["inner_mouth"] >= half["tongue"]
        yield "the tongue is not in the mouth", bool(around.all())
    if {"inner_mouth", "upper_teeth"} <= set(at):
        around = half["inner_mouth"][1:] > half["upper_teeth"][1:]
        yield "the teeth are outside of the inner mouth", bool(around.all())
