"""Landmarks in the picture, and the COCO keypoints made of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.dataset import Truth
from abs_engine.dataset.coco import box_and_area, keypoint_names, keypoints
from abs_engine.evaluate.check.finding import Finding
from abs_engine.evaluate.check.visibility import Reflection, Sight, in_mirror, reflection
from abs_engine.io.inputs import read_json

PLACE = 0.02
"""px by which a landmark may be off its projection."""

JUMP = 5.0
"""mm in depth that make something clearly nearer."""

UNSURE = 0.04
"""Share of the landmarks whose visibility may differ: some lie at the very edge."""


def point_findings(truth: Truth, name: str) -> Iterator[Finding]:
    """Landmark pixels that are not where the vertices project to."""
    mirror = reflection(truth)
    points = truth.points(truth.landmarks["landmark_68"])
    told: list[tuple[str, FloatArray, Reflection | None]] = [
        ("landmark_pixels", truth.landmark_pixels, None)
    ]
    if mirror is not None:
        if truth.mirror_pixels is None:
            yield Finding(name, "mirror_landmark_pixels is missing")
        else:
            told.append(("mirror_landmark_pixels", truth.mirror_pixels, mirror))
        if truth.mirror_visible is None:
            yield Finding(name, "mirror_landmark_visible is missing")
    for label, pixels, through in told:
        yield from _projected(truth, points, label, pixels, through, name)


def _projected(
    truth: Truth,
    points: FloatArray,
    label: str,
    pixels: FloatArray,
    mirror: Reflection | None,
    name: str,
) -> Iterator[Finding]:
    for frame in range(len(truth)):
        place = truth.pose(frame).apply(points[frame])
        place = place if mirror is None else mirror.points(place)
        before = place[:, 2] > truth.camera.near
        if not before.any():
            continue
        away = np.linalg.norm(truth.camera.project(place) - pixels[frame], axis=1)[before]
        if not away.max() <= PLACE:
            how = f"up to {away.max():.2f} px"
            yield Finding(name, f"{label} are not where the vertices project to", how, frame)


def mark_classes(truth: Truth) -> NDArray[np.bool_]:
    """Classes of the facets at each of the 68 landmarks, (68, C)."""
    marks, corners = truth.weld[truth.landmarks["landmark_68"]], truth.weld[truth.faces]
    found = [np.isin(marks, corners[truth.facet_class == k]) for k in range(len(truth.class_names))]
    return np.stack(found, axis=1)


def visible_findings(
    truth: Truth, sight: Sight, classes: NDArray[np.bool_], name: str
) -> Iterator[Finding]:
    """Landmarks that are said to be hidden where the picture shows them, or the reverse.

    Parameters
    ----------
    classes : (68, C) bool
        See `mark_classes`.
    """
    told: list[tuple[str, NDArray[np.bool_], Reflection | None]] = [
        ("landmark_visible", truth.landmark_visible, None)
    ]
    mirror, seen_there = sight.reflection, truth.mirror_visible
    if mirror is not None and seen_there is not None and seen_there.shape == (len(truth), 68):
        told.append(("mirror_landmark_visible", seen_there, mirror))
    for label, marks, through in told:
        yield from _seen(truth, sight, classes, (label, marks[sight.frame], through), name)
    direct = bool((~sight.mirrored).any())
    if bool(truth.in_picture[sight.frame]) not in {direct, bool(len(sight))}:
        how = f"{len(sight)} pixels of it are seen"
        yield Finding(name, "in_picture does not agree with the ids", how, sight.frame)


def _seen(
    truth: Truth,
    sight: Sight,
    classes: NDArray[np.bool_],
    told: tuple[str, NDArray[np.bool_], Reflection | None],
    name: str,
) -> Iterator[Finding]:
    """Marks that are told otherwise than the ids show them, directly or in the mirror."""
    label, marks, mirror = told
    seen, hidden = certain(truth, sight, classes, mirror)
    wrong = int((seen & ~marks).sum() + (hidden & marks).sum())
    sure = int(seen.sum() + hidden.sum())
    if wrong > max(UNSURE * sure, 2):
        how = f"{wrong} of {sure} that are clear"
        yield Finding(name, f"{label} does not agree with the ids", how, sight.frame)


def certain(
    truth: Truth, sight: Sight, classes: NDArray[np.bool_], mirror: Reflection | None = None
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of the landmarks (68,) that are certainly seen, and of those that are certainly hidden.

    What is seen shows a facet of its own, with nothing around it that is clearly nearer or of
    another class: where lips touch, each lies before the other by less than this can tell. What
    is hidden is outside of the picture, or has something clearly nearer all around it, even a pixel
    further down its slope. In a mirror, what is seen lies in it, and what lies well outside of it
    is hidden.
    """
    vertex = truth.landmarks["landmark_68"]
    points = truth.pose(sight.frame).apply(truth.vertices(sight.frame)[vertex].astype(np.float64))
    points = points if mirror is None else mirror.points(points)
    pixels, depth = truth.camera.project(points), points[:, 2]
    height, width = sight.ids.shape
    drawn = np.full((height, width), np.inf)
    drawn[sight.y, sight.x] = np.where(sight.mirrored == (mirror is None), np.inf, sight.depth)
    nearest = drawn.copy()
    if mirror is not None:
        nearest[sight.y, sight.x] = sight.depth  # the head itself stands before its image
    deepest = nearest.copy()
    deepest[sight.y, sight.x] += sight.slope
    for edge in (nearest, deepest):
        edge[truth.cover(sight.frame) > 0] = -np.inf
    kinds = truth.class_ids(sight.frame)
    seen, hidden = np.zeros(68, np.bool_), np.zeros(68, np.bool_)
    for i, (pixel, z) in enumerate(zip(pixels, depth, strict=True)):
        if (pixel < -0.5).any() or pixel[0] >= width - 0.5 or pixel[1] >= height - 0.5 or z <= 0:
            hidden[i] = True
            continue
        x, y = (int(v) for v in np.clip(np.rint(pixel), 0, (width - 1, height - 1)))
        around = slice(max(y - 1, 0), y + 2), slice(max(x - 1, 0), x + 2)
        looks = _looks(truth, mirror, *around)
        hidden[i] = bool((deepest[around] < z - JUMP).all()) or not looks.any()
        if np.isfinite(drawn[y, x]) and looks.all() and (nearest[around] > z - JUMP).all():
            own = truth.weld[truth.faces[sight.ids[y, x] - 1]] == truth.weld[vertex[i]]
            seen[i] = bool(own.any() and classes[i, kinds[around]].all())
    return seen, hidden


def _looks(
    truth: Truth, mirror: Reflection | None, rows: slice, columns: slice
) -> NDArray[np.bool_]:
    """Mask of the pixels that look into the mirror; all of them where none is asked for."""
    y, x = np.mgrid[rows, columns].reshape(2, -1)
    return np.ones(len(x), np.bool_) if mirror is None else in_mirror(truth, x, y)


Boxes = dict[int, tuple[Any, Any]]


def coco_findings(truth: Truth, path: Path, name: str, boxes: Boxes) -> Iterator[Finding]:
    """COCO keypoints that are not those of ``points.npz``.

    Parameters
    ----------
    boxes : dict
        Filled with the box and the area of every frame that has an annotation.
    """
    try:
        data = read_json(path)
        flat = {a["image_id"]: np.array(a["keypoints"], np.float64) for a in data["annotations"]}
        boxes |= {a["image_id"]: (list(a["bbox"]), a["area"]) for a in data["annotations"]}
        names, images = data["categories"][0]["keypoints"], len(data["images"])
    except (OSError, ValueError, LookupError, TypeError, AttributeError, OverflowError) as error:
        yield Finding(name, "is not a COCO keypoints file", str(error)[:80])
        return
    if images != len(truth) or names != keypoint_names():
        yield Finding(name, "has other pictures or keypoints than the clip", f"{images} pictures")
        return
    if set(flat) != set(np.flatnonzero(truth.in_picture).tolist()):
        yield Finding(name, "has annotations of other frames than those that show the head")
    pixels, visible = truth.landmark_pixels, truth.landmark_visible
    for frame in sorted(set(flat) & set(range(len(truth)))):
        wanted = np.array(keypoints(pixels[frame], visible[frame], truth.camera.size))
        if flat[frame].shape != wanted.shape or np.abs(flat[frame] - wanted).max() > 0.01:
            yield Finding(name, "keypoints are not those of points.npz", "", frame)


def box_findings(sight: Sight, boxes: Boxes, name: str) -> Iterator[Finding]:
    """A box and an area must be those of the head's pixels, with or without its mirror image."""
    if sight.frame not in boxes:
        return
    direct = np.zeros(sight.ids.shape, np.bool_)
    direct[sight.y, sight.x] = ~sight.mirrored
    wanted = [box_and_area(sight.ids > 0), box_and_area(direct)]
    if boxes[sight.frame] not in wanted:
        how = f"{boxes[sight.frame]}, not {wanted[0]}"
        yield Finding(name, "a box or an area is not that of the ids", how, sight.frame)
