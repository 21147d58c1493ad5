"""Calibrating from several starts: what is learned on the way may be wrong, and stay so.

The calibration is chosen that explains the clip's pictures best.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import FaceNotFoundError, TooFewPixelsError
from abs_engine.core.pose import no_correction
from abs_engine.core.scene import Renderer
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, features
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import class_maps, likelihood_of
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.tracking.detection.mouth_search import CalibrationFrame, moved, shift_of_faces
from abs_engine.tracking.person.calibration_views import Stand
from abs_engine.tracking.person.identity_fit import Calibration, calibrate
from abs_engine.tracking.settings.preparation import PREPARATION

FULLER = {
    "upper lip height": PREPARATION.fuller_upper_lip,
    "lower lip height": PREPARATION.fuller_lower_lip,
}
"""With what lips, too, if it is not good, standard deviations: the lower one of full lips that
catches the light is else taken for skin, and learned so."""


def learning(known: ColourClasses | None) -> str:
    """Next step of the preparation, in a few words."""
    return "fitting the mouth" if known else "learning the clip's colours, fitting the mouth"


def calibrate_well(
    model: MouthModel,
    frames: Sequence[CalibrationFrame],
    camera: Camera,
    renderer: Renderer,
    tell: Callable[[str], None],
    colours: ColourClasses | None = None,
    placed: bool = False,
) -> Calibration:
    """Fit the person's mouth and the colours, from two starts, and from more if that is no good.

    Colours are learned unless they are given. `placed` is whether somebody told where the mouth is;
    by default the faces that are found tell it. In either case it is then looked for by colour,
    about there. The calibration is that which makes its frames' colours most probable. `tell` is
    called with what is begun, in a few words.

    Raises
    ------
    FaceNotFoundError, TooFewPixelsError
        If the frames do not show enough of skin and lips to learn from.
    """
    faces = None if model.known or placed else shift_of_faces(model, frames, camera)
    begin, seen = no_correction() if faces is None else faces, faces is not None
    frames, nobody = moved(frames, begin, model.pivot), np.zeros(model.n_person)
    stand = Stand(model, frames, camera, renderer, no_correction(), nobody)

    def telling(doing: str) -> Callable[[str], None]:
        return lambda turn: tell(f"{doing}, {turn}")

    first = calibrate(stand, colours, seen, telling(learning(colours)))
    if model.known:
        return replace(first, shift=first.shift + begin)
    score = explained(stand, first)
    starts: list[tuple[float, float, FloatArray]] = [(*PREPARATION.higher, nobody)]
    if score < PREPARATION.good_score:
        starts += [(0.0, 0.0, model.person(FULLER)), (*PREPARATION.lower, nobody)]
    if score < PREPARATION.poor_score:
        starts += [(*move, nobody) for move in PREPARATION.nearer_and_farther]
    tried = [first]
    for number, (down, away, person) in enumerate(starts, start=1):
        elsewhere = telling(f"fitting the mouth from elsewhere, {number} of {len(starts)}")
        move = np.array([0.0, 0.0, 0.0, 0.0, down, away * stand.depth])
        there = replace(stand, frames=moved(frames, move, model.pivot), person=person)
        try:
            found = calibrate(there, colours, seen, elsewhere)
        except (FaceNotFoundError, TooFewPixelsError):
            continue  # nothing to learn from there; the first attempt stands
        tried.append(replace(found, shift=found.shift + move))
    best = tried[int(np.argmax(log_evidence(stand, tried)))]
    return replace(best, shift=best.shift + begin)


def _by(stand: Stand, found: Calibration) -> Stand:
    """Places of the mouths as a calibration has them."""
    return replace(stand, shift=found.shift, person=found.person)


def explained(stand: Stand, found: Calibration) -> float:
    """Mean probability of the drawn classes over the frames, 0 to 1; see `FrameResult.score`."""
    model, placed, scores = stand.model, _by(stand, found), list[NDArray[np.float64]]()
    scene = model.held(found.person)
    each = zip(stand.frames, placed.windows, placed.bases, found.expressions, strict=True)
    for frame, window, base, vector in each:
        maps = class_maps(found.classes, model.colour_classes, window, frame.image)
        term = likelihood_of(stand.renderer, scene, stand.camera, window, maps)
        value = term.negative_log(base.candidates(vector[None]))
        scores.append(np.exp(-value / term.observations))
    return float(np.mean(scores))


def log_evidence(stand: Stand, tried: Sequence[Calibration]) -> FloatArray:
    """Mean log density (K,) of a pixel about all mouths under each calibration of their poses.

    The probability of a class given a colour (eq. 6) compares the classes of one calibration, and
    classes that were learned from the wrong places may explain these well: a smile's teeth as skin
    between lips and chin. Here the same pixels are explained by all of the calibrations: by the
    density of their colours, in units of `features`, in the class that is drawn there, and by
    skin's where none is.
    """
    placed = [(_by(stand, found), found) for found in tried]
    each = [_of_frame(k, placed) for k in range(len(stand.frames))]
    return np.asarray(np.mean(each, axis=0), np.float64)


def _of_frame(k: int, placed: Sequence[tuple[Stand, Calibration]]) -> FloatArray:
    """Mean log densities (K,) of the frame with this number."""
    window = _around([stand.windows[k] for stand, _ in placed])
    patch, values = sampled(window, placed[0][0].frames[k].image), []
    for stand, found in placed:
        posture = stand.bases[k].candidates(found.expressions[k][None])
        scene = stand.model.held(found.person)
        drawn = stand.renderer.draw(scene, posture, stand.camera, window)[0]
        density = _density(stand.model, found.classes, drawn, patch)
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
