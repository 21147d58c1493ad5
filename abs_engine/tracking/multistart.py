"""Calibrating from several starts: what is learned on the way may be wrong, and stay so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError, TooFewPixelsError
from abs_engine.core.pose import PoseFrame, no_correction
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import class_maps, likelihood_of, mouth_window
from abs_engine.tracking.identity_fit import Calibration, calibrate
from abs_engine.tracking.model_selection import log_evidence
from abs_engine.tracking.mouth_search import CalibrationFrame, moved, shift_of_faces, shifted
from abs_engine.tracking.settings.preparation import PREPARATION

FULLER = {
    "upper lip height": PREPARATION.fuller_upper_lip,
    "lower lip height": PREPARATION.fuller_lower_lip,
}
"""With what lips, too, if it is not good, standard deviations: the lower one of full lips that
catches the light is else taken for skin, and learned so."""


def calibrate_well(
    model: MouthModel,
    frames: Sequence[CalibrationFrame],
    camera: Camera,
    renderer: Renderer,
    colours: ColourClasses | None = None,
    placed: bool = False,
) -> Calibration:
    """Fit the person's mouth and the colours, from two starts, and from more if that is no good.

    Colours are learned unless they are given. `placed` is whether somebody told where the mouth is;
    by default the faces that are found tell it. In either case it is then looked for by colour,
    about there. The calibration is that which makes its frames' colours most probable.

    Raises
    ------
    FaceNotFoundError, TooFewPixelsError
        If the frames do not show enough of skin and lips to learn from.
    """
    faces = None if model.known or placed else shift_of_faces(model, frames, camera)
    begin, seen = no_correction() if faces is None else faces, faces is not None
    frames = moved(frames, begin, model.pivot)
    first = calibrate(model, frames, camera, renderer, known=colours, seen=seen)
    if model.known:
        return replace(first, shift=first.shift + begin)
    score = explained(model, frames, camera, renderer, first)
    starts: list[tuple[float, float, NDArray[np.float64] | None]] = [(*PREPARATION.higher, None)]
    if score < PREPARATION.good_score:
        starts += [(0.0, 0.0, model.person(FULLER)), (*PREPARATION.lower, None)]
    if score < PREPARATION.poor_score:
        starts += [(*move, None) for move in PREPARATION.nearer_and_farther]
    tried = [first]
    depth = float(np.median([frame.pose.translation[2] for frame in frames]))
    for down, away, person in starts:
        move = np.array([0.0, 0.0, 0.0, 0.0, down, away * depth])
        there = moved(frames, move, model.pivot)
        try:
            found = calibrate(model, there, camera, renderer, colours, person, seen)
        except (FaceNotFoundError, TooFewPixelsError):
            continue  # nothing to learn from there; the first attempt stands
        tried.append(replace(found, shift=found.shift + move))
    best = tried[int(np.argmax(log_evidence(model, frames, tried, camera, renderer)))]
    return replace(best, shift=best.shift + begin)


def explained(
    model: MouthModel,
    frames: Sequence[CalibrationFrame],
    camera: Camera,
    renderer: Renderer,
    calibration: Calibration,
) -> float:
    """Mean probability of the drawn classes over the frames, 0 to 1; see `FrameResult.score`."""
    scores: list[NDArray[np.float64]] = []
    scene = model.held(calibration.person)
    for frame, vector in zip(frames, calibration.expressions, strict=True):
        base = PoseFrame(shifted(frame.pose, calibration.shift, model.pivot), model.pivot)
        window = mouth_window(model, base.base, camera, calibration.person)
        maps = class_maps(calibration.classes, model.colour_classes, window, frame.image)
        term = likelihood_of(renderer, scene, camera, window, maps)
        value = term.negative_log(base.candidates(vector[None]))
        scores.append(np.exp(-value / term.observations))
    return float(np.mean(scores))
