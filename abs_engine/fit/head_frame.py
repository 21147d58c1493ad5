"""One frame of a head as a problem: the facet likelihood of a window plus priors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.prior import ContactPrior, Prior
from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import POSE_NAMES, PoseFrame, joined, pose_and
from abs_engine.core.scene import ClassMaps, Renderer, Scene
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.appearance.mouth_area import MouthPlace
from abs_engine.face.contact import Rings, lip_gaps, lip_heights, pinching
from abs_engine.face.head import MouthModel
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import HEAD_FIT, SHELL_FIT

COLOUR = "colour"
"""Name of the evidence of colour classes."""


def mouth_window(
    model: MouthModel,
    pose: Pose,
    camera: Camera,
    person: FloatArray | None = None,
    more: tuple[float, float] = (0.0, 0.0),
) -> Window:
    """The window around a person's mouth (Q,), see `HEAD_FIT.window`.

    By default it is that of the model's neutral head. `more` mouth widths are added to its width
    and height, where the mouth is not yet found.
    """
    return lip_window(model.border(person), pose, camera, more)


def lip_window(
    border: FloatArray, pose: Pose, camera: Camera, more: tuple[float, float] = (0.0, 0.0)
) -> Window:
    """The window around the lips' outer contour at rest (R, 3), mm; see `mouth_window`."""
    pixels = camera.project(pose.apply(border))
    return window_of(pixels, float(np.ptp(pixels[:, 0])), HEAD_FIT.drawn_mouth, more)


def window_of(
    lips: FloatArray, across: float, drawn: float, more: tuple[float, float] = (0.0, 0.0)
) -> Window:
    """The window around lips (R, 2), px, of a mouth `across` px wide, drawn `drawn` px wide.

    `more` is what it is higher and wider by, in widths of the mouth.
    """
    scale = min(GENERAL.finest, drawn / across)
    size = np.ceil((np.array(HEAD_FIT.window) + more) * across * scale) / scale
    middle = 0.5 * (lips.min(axis=0) + lips.max(axis=0))
    centre = middle + np.array([0.0, HEAD_FIT.lower * across])
    x, y = np.rint(centre - 0.5 * size)
    return Window(float(x), float(y), float(size[0]), float(size[1]), scale)


def zone(window: Window) -> BoolArray:
    """The ellipse that fills a window, (H, W): pixels outside of it are not compared.

    A head that looks into the camera covers it whatever the parameters, so that a fit gains nothing
    by covering more. Turned by 15, 30 and 45 degrees the bundled one leaves 1, 8 and 23 % free,
    which count as explained by nothing; Newton steps see no border there.
    """
    width, height = window.drawn
    x = (np.arange(width) + 0.5) / width * 2 - 1
    y = (np.arange(height) + 0.5) / height * 2 - 1
    return np.asarray(x[None] ** 2 + y[:, None] ** 2 < 1)


def class_maps(
    classes: ColourClasses,
    colour_of: Sequence[str | None],
    window: Window,
    frame: Image,
    place: MouthPlace | None = None,
) -> ClassMaps:
    """Probability maps of every facet class in the window of a frame, 0 outside of its zone.

    `colour_of` is the colour class of each facet class; None is not compared. `place` is where in
    the window the mouth is known to be.
    """
    patch = sampled(window, frame)
    seen = classes.compared(patch)
    probable = seen.probabilities(HEAD_FIT.smoothing * HEAD_FIT.drawn_mouth, place) * zone(window)
    return ClassMaps(plane_maps(probable, seen.teeth_in_shade(), colour_of, window))


def plane_maps(
    probable: FloatArray, shade: FloatArray, colour_of: Sequence[str | None], window: Window
) -> NDArray[Any]:
    """Maps (C, H, W) of every facet class, of probabilities (4, H, W) over a window.

    `shade` (H, W) is how probably teeth there lie in shade.
    """
    line = max(HEAD_FIT.line * HEAD_FIT.drawn_mouth, HEAD_FIT.line_pixels * window.scale)
    shown = _shown(dict(zip(CLASSES, probable, strict=True)), shade, line)
    zero = np.zeros_like(probable[0])
    return np.stack([zero if c is None else shown[c] for c in colour_of])


def _shown(maps: dict[str, FloatArray], shade: FloatArray, line: float) -> dict[str, FloatArray]:
    """Classes that a facet of each class may show: teeth lie in shade, and lips do where they meet.

    Where in the mouth teeth stand is not known of a person: dark facets may show them. Where the
    inside is no more than `line` drawn pixels high, what is dark there, or as teeth in shade, may
    as well be closed lips; not lit teeth. What lies in the dark may be as red as lips.
    """
    inside = maps["teeth"] + maps["dark"]
    window = np.ones((2 * round(line / 2) + 1, 1), np.uint8)
    thick = cv2.morphologyEx(inside, cv2.MORPH_OPEN, window)
    dim = maps["dark"] + shade * maps["teeth"]
    dim_line = (inside - thick) * dim / np.maximum(inside, 1e-9)
    lips = (
        maps["lips"]
        + HEAD_FIT.in_shade * inside
        + (HEAD_FIT.in_line - HEAD_FIT.in_shade) * dim_line
    )
    dark = inside + HEAD_FIT.red_inside * maps["lips"]
    return {"skin": maps["skin"], "lips": lips, "teeth": inside, "dark": dark}


def head_problem(
    likelihood: FacetLikelihood, frame: PoseFrame, priors: tuple[Prior, ...], posture: ParamSpec
) -> Problem:
    """A frame of a head as a problem over its pose and posture (6 + P,), by colours and priors.

    `posture` is of the weights of the mouth's modes, P.
    """
    terms = {COLOUR: likelihood}
    return Problem(frame, pose_and(posture), terms, priors)


def likelihood_of(
    renderer: Renderer,
    scene: Scene,
    camera: Camera,
    window: Window,
    maps: ClassMaps,
    weight: float = 1.0,
    seam: tuple[tuple[int, int], int] | tuple[()] = (),
) -> FacetLikelihood:
    """The facet likelihood over the window's zone.

    An independent observation is a twentieth of the mouth's width across, but no less than the 2x2
    pixels that share their chroma in video; each counts as `weight` of one.
    """
    side = independent_side(window)
    pixels = int(zone(window).sum())
    count = weight * pixels / side**2
    return FacetLikelihood(renderer, scene, camera, window, maps, pixels, count, seam=seam)


def seam_of(regions: Sequence[str | None]) -> tuple[tuple[int, int], int] | tuple[()]:
    """Classes of the two lips and of what shows between them; none where lips are one class."""
    lips = [k for k, shown in enumerate(regions) if shown == "lips"]
    if len(lips) != 2 or "dark" not in regions:
        return ()
    return (lips[0], lips[1]), regions.index("dark")


def independent_side(window: Window) -> float:
    """Side of an independent observation in the window of a mouth, drawn pixels."""
    return (
        max(SHELL_FIT.side, window.width / HEAD_FIT.window[0] / HEAD_FIT.sides_across)
        * window.scale
    )


def best_start(problem: Problem, starts: FloatArray) -> FloatArray:
    """The start (N,) with the lowest value among (K, N), compared in one batch."""
    return np.asarray(starts[int(np.argmin(problem.values(starts)))])


def contact_prior(model: MouthModel, person: FloatArray, thick: bool = False) -> ContactPrior:
    """Contact of a person's lips (Q,) as a prior over (6 + P), see `contact_of`."""
    scene, rest = model.held(person), model.prototypes[0]
    # of a person's own postures none need be the head's at rest
    own = scene.at(model.head.mean[model.kept]) if model.known else None
    return contact_of(scene, model.rings, rest, thick, own)


def contact_of(
    scene: Scene, rings: Rings, rest: FloatArray, thick: bool = False, still: Scene | None = None
) -> ContactPrior:
    """Contact of the lips as a prior over (6 + P).

    A head's lips overlap a little in the posture at `rest` (P,), so that no light falls between
    them; only what they overlap beyond that is pressing. `still` is the scene at rest, where no
    posture is quite that. With `thick` each lip also keeps a share `HEAD_FIT.least_thickness` of
    its height at rest, so that its outline cannot turn inside out, and the mouth opens in the
    middle as far as at its sides, see `pinching`.
    """
    gap, slope = lip_gaps(scene, rings)
    at_rest = gap + slope @ rest if still is None else lip_gaps(still, rings)[0]
    gap = gap - np.minimum(at_rest, 0.0)
    if thick:
        height, change = lip_heights(scene, rings)
        usual = height + change @ rest if still is None else lip_heights(still, rings)[0]
        least = HEAD_FIT.least_thickness * usual
        pinch, move = pinching(gap, slope)
        gap, slope = np.r_[gap, height - least, pinch], np.vstack([slope, change, move])
    slope = joined(np.zeros((len(gap), len(POSE_NAMES))), slope)
    return ContactPrior(gap, slope)
