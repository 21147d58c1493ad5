"""Model selection: the calibration of a clip that explains its pictures best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.core.pose import PoseFrame
from abs_engine.core.scene import Renderer
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, features
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import mouth_window
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.tracking.identity_fit import Calibration
from abs_engine.tracking.mouth_search import CalibrationFrame, shifted
from abs_engine.tracking.settings.preparation import PREPARATION


def log_evidence(
    model: MouthModel,
    frames: Sequence[CalibrationFrame],
    calibrations: Sequence[Calibration],
    camera: Camera,
    renderer: Renderer,
) -> FloatArray:
    """Mean log density (K,) of a pixel about all mouths under each calibration of their poses.

    The probability of a class given a colour (eq. 6) compares the classes of one calibration, and
    classes that were learned from the wrong places may explain these well: a smile's teeth as skin
    between lips and chin. Here the same pixels are explained by all of the calibrations: by the
    density of their colours, in units of `features`, in the class that is drawn there, and by
    skin's where none is.
    """
    of_frames = [
        _of_frame(model, frame, k, calibrations, camera, renderer) for k, frame in enumerate(frames)
    ]
    return np.asarray(np.mean(of_frames, axis=0), np.float64)


def _of_frame(
    model: MouthModel,
    frame: CalibrationFrame,
    number: int,
    calibrations: Sequence[Calibration],
    camera: Camera,
    renderer: Renderer,
) -> FloatArray:
    """Mean log densities (K,) of the frame with this number."""
    pivot = model.pivot
    bases = [PoseFrame(shifted(frame.pose, c.shift, pivot), pivot) for c in calibrations]
    window = _around(
        [
            mouth_window(model, b.base, camera, c.person)
            for b, c in zip(bases, calibrations, strict=True)
        ]
    )
    patch = sampled(window, frame.image)
    values = []
    for base, found in zip(bases, calibrations, strict=True):
        posture = base.candidates(found.expressions[number][None])
        drawn = renderer.draw(model.held(found.person), posture, camera, window)[0]
        density = _density(model, found.classes, drawn, patch)
        values.append(np.log((1 - PREPARATION.strange) * density + PREPARATION.strange).mean())
    return np.array(values, np.float64)


def _around(windows: Sequence[Window]) -> Window:
    """The window that holds all of these, a mouth drawn about as large as in the first."""
    low = np.min([(w.x, w.y) for w in windows], axis=0)
    high = np.max([(w.x + w.width, w.y + w.height) for w in windows], axis=0)
    scale = min(GENERAL.finest, HEAD_FIT.window[0] * HEAD_FIT.drawn_mouth / windows[0].width)
    size = np.ceil((high - low) * scale) / scale
    return Window(float(low[0]), float(low[1]), float(size[0]), float(size[1]), scale)


def _density(
    model: MouthModel, classes: ColourClasses, drawn: Buffers, patch: NDArray[np.generic]
) -> FloatArray:
    """Density (H, W) of each pixel's colour in the class that is drawn there."""
    samples = features(patch, classes.reference).reshape(-1, 3)
    shape = drawn.class_id.shape
    of = {name: classes.mixtures[name].density(samples).reshape(shape) for name in CLASSES}
    teeth, dark = classes.priors[2:] / classes.priors[2:].sum()
    inside = teeth * of["teeth"] + dark * of["dark"]  # where teeth stand is not known
    of |= {"teeth": inside, "dark": inside}
    of["skin"] = classes.priors[0] * of["skin"]  # more than 1 where it mixes with lips
    density = of["skin"].copy()
    for k, name in enumerate(model.colour_classes):
        if name is not None:
            shown = drawn.class_id == k
            density[shown] = of[name][shown]
    return density
