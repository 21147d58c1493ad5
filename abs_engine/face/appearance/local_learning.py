"""Learns the local appearance of points of the surface from frames (Odisio & Bailly, 3.2)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer, Scene
from abs_engine.face.appearance.descriptors import DescriptorMaps
from abs_engine.face.appearance.local import N_D, LocalModel, in_common, inverse_spread
from abs_engine.face.appearance.patches import Patches
from abs_engine.face.appearance.regression import Fitted, Frames, LinearFits
from abs_engine.face.appearance.visibility import Sighting, sighted
from abs_engine.face.appearance.windows import Windows
from abs_engine.face.settings.appearance import APPEARANCE

FEWEST = 3
"""Recordings that noise is measured on, at least: each is predicted by others, these by others."""


def learn_local(
    sightings: Iterable[Sighting],
    scene: Scene,
    vertices: NDArray[np.integer],
    camera: Camera,
    renderer: Renderer,
    scale: float = 1.0,
    unit: float = 0.0,
) -> LocalModel:
    """Learn d_0 and M_D of some points by least squares, from the frames that show them.

    Parameters
    ----------
    sightings : iterable of Sighting
        Read once, one after the other; all with the same number of parameters.
    scene, camera, renderer
        Of the sightings; what is hidden in them is found by drawing.
    vertices : (N,) int
        The points; see `point_selection.choose_points` for which of them to keep.
    scale : float
        Drawn pixels per image pixel; frames are compared at the same.
    unit : float, drawn pixels per mm
        0 for the paper's rigid windows; else see `windows.Windows`.

    Raises
    ------
    NothingSeenError
        If no point is visible in any frame.
    PictureError
        If a picture holds NaN or has another size than the camera's.
    ParameterError
        If there are no frames, or shapes or numbers of parameters differ.
    """
    return learn_local_frames(sightings, scene, vertices, camera, renderer, scale, unit)[0]


def learn_local_frames(
    sightings: Iterable[Sighting],
    scene: Scene,
    vertices: NDArray[np.integer],
    camera: Camera,
    renderer: Renderer,
    scale: float = 1.0,
    unit: float = 0.0,
    recordings: IntArray | None = None,
) -> tuple[LocalModel, Frames, float]:
    """The same with the descriptors that it was learned from, and the ridge.

    With `recordings` (T,), which frames were recorded together, the ridge is that with which
    recordings foretell others best, and what is left out is so by whole recordings.
    """
    patches = Patches.around(scene, vertices)
    windows = Windows(patches, np.full(len(vertices), APPEARANCE.sigma, np.float64), unit)
    window = Window(0, 0, *camera.size, scale)
    fits: LinearFits | None = None
    rows, shown, values = [], [], []
    facing = np.zeros(len(vertices))
    for sighting in sightings:
        if fits is None:
            fits = LinearFits(len(vertices), N_D, len(sighting.parameters))
        weights, flat = sighted(sighting, patches, scene, camera, window, renderer)
        image = window.sample(np.asarray(sighting.image, np.float32))
        found = windows.read(DescriptorMaps.of(image, windows.scales), flat)
        fits.add(found, (weights > 0).astype(np.float64), sighting.parameters)
        rows.append(sighting.parameters)
        shown.append(weights > 0)
        values.append(found.astype(np.float32))
        facing += weights
    if fits is None:
        raise ParameterError("there are no frames to learn appearance from", "give some")
    frames = Frames(np.stack(values), np.stack(shown), np.stack(rows), recordings)
    ridge = frames.ridge
    at = np.asarray(vertices, np.int64)
    return _model(fits.solve(ridge), windows, at, facing, frames, ridge), frames, ridge


def own_share(frames: Frames, ridge: float) -> float:
    """The share for `AppearanceSettings.alone` by which recordings predict others' noise best.

    Of descriptors of the points that are compared, and of the ridge of their fits; each frame is a
    recording of its own where none are known. Of less than three recordings it is
    `AppearanceSettings.alone`.
    """
    alone, given = np.arange(len(frames.seen)), frames.recordings
    recordings = alone if given is None else given
    if len(np.unique(recordings)) < FEWEST:
        return APPEARANCE.alone
    missed, gained = frames.left_out(ridge), np.zeros(len(APPEARANCE.alone_tried))
    for name in np.unique(recordings):
        others = frames.recorded(recordings != name)
        off = others.left_out(ridge)
        count = np.maximum(others.seen.sum(axis=0), 1)
        scale = inverse_spread(np.sqrt((off**2).sum(axis=0) / count[:, None]))
        values, axes = np.linalg.eigh(in_common(off * scale, others.seen))
        out = missed[recordings == name] * scale
        along = (out.reshape(len(out), -1) @ axes) ** 2
        for k, share in enumerate(APPEARANCE.alone_tried):
            wide = (1 - share) * np.maximum(values, 0.0) + share
            gained[k] -= 0.5 * float((along / wide + np.log(wide)).sum())
    return APPEARANCE.alone_tried[int(np.argmax(gained))]


def _model(
    fitted: Fitted,
    windows: Windows,
    vertices: IntArray,
    facing: FloatArray,
    frames: Frames,
    ridge: float,
) -> LocalModel:
    """Fits of the points; `facing` is summed over the frames."""
    missed = frames.left_out(ridge)
    count = np.maximum(fitted.frames, 1)
    return LocalModel(
        vertices=vertices,
        base=fitted.base,
        modes=fitted.modes,
        mean=fitted.mean,
        sigma=windows.sigma,
        spread=np.sqrt((missed**2).sum(axis=0) / count[:, None]),
        left_out=missed.astype(np.float32),
        seen=fitted.frames / len(frames.parameters),
        facing=facing / count,
        reach=np.sqrt((frames.parameters**2).mean(axis=0)),
        explained=fitted.explained,
        unit=windows.unit,
    )
