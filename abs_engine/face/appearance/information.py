"""Points of local appearance chosen by what they say of all parameters, those of pose among them.

The paper ranks points by how much the articulatory parameters change their descriptors
(`point_selection.choose_points`). Such points lie around the mouth and say little of where the head
is. Here a point counts by how well the parameters are determined by its descriptors together with
those of the points that were chosen before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.face.appearance.descriptors import DescriptorMaps
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.patches import Patches
from abs_engine.face.appearance.point_selection import usable_points
from abs_engine.face.appearance.visibility import Sighting, sighted
from abs_engine.face.appearance.windows import Windows

Moved = Callable[[Sighting], Candidates]
"""Of a frame: its own place and posture, then one for each parameter moved by a step."""


def information(
    model: LocalModel,
    sightings: Iterable[Sighting],
    scene: Scene,
    camera: Camera,
    renderer: Renderer,
    moved: Moved,
    scale: float = 1.0,
) -> FloatArray:
    """Information of each point's descriptor about n parameters: J' J, the mean over the frames.

    (N, n, n) float64, per squared step of the parameters. Differences are divided by the spread
    that the model, of all points, leaves unexplained. `moved` makes 1 + n candidates of a frame;
    all else is as for `local_learning.learn_local`. Raises `ParameterError` if there are no frames.
    """
    patches = Patches.around(scene, model.vertices)
    windows = Windows(patches, model.sigma, model.unit)
    window = Window(0, 0, *camera.size, scale)
    total, count = np.zeros((len(model), 1, 1)), 0
    for sighting in sightings:
        shown = sighted(sighting, patches, scene, camera, window, renderer)[0] > 0
        image = window.sample(np.asarray(sighting.image, np.float32))
        maps, many = DescriptorMaps.of(image, windows.scales), moved(sighting)
        places = (patches.placed(many, k) for k in range(len(many)))
        found = np.array([windows.read(maps, window.to_drawn(camera.project(p))) for p in places])
        differ = (found - model.at(many.weights)) * model.inverse
        slopes = (differ[1:] - differ[0]) * shown[:, None]
        total = total + np.einsum("pnc,qnc->npq", slopes, slopes)
        count += 1
    if count == 0:
        raise ParameterError("there are no frames to choose points on", "give some")
    return np.asarray(total / count)


def choose_informative(
    model: LocalModel,
    known: FloatArray,
    about: FloatArray,
    count: int,
    places: FloatArray,
    spacing: float = 0.0,
) -> IntArray:
    """Choose points one by one, each that which makes the parameters' volume smallest.

    A D-optimal design (Fedorov, "Theory of optimal experiments", 1972), greedily: of the points
    that are often and squarely seen, the one with the largest determinant of the sum. What comes
    back are indices of the points of the model, which has all of them, in the order of the choice.

    Parameters
    ----------
    known : (N, n, n) float64
        Of `information`.
    about : (n,) float64
        What is known of the parameters without any point: 1 / variance, per squared step.
    count : int
        How many points to choose; fewer come back if there are no more.
    places : (N, 3) float64, mm
    spacing : float, mm
        Least distance of chosen points.

    Raises
    ------
    ParameterError
        If no point is often and squarely seen.
    """
    free = usable_points(model)
    sum_ = np.diag(np.asarray(about, np.float64))
    chosen: list[int] = []
    while free.any() and len(chosen) < count:
        left = np.flatnonzero(free)
        best = int(left[np.linalg.slogdet(sum_ + known[left])[1].argmax()])
        chosen.append(best)
        sum_ = sum_ + known[best]
        free[best] = False
        free &= np.linalg.norm(places - places[best], axis=1) >= spacing
    return np.array(chosen, np.int64)
