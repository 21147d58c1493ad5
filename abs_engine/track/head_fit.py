"""Somebody's whole head, by the landmarks of several frames; and how large it is taken to be.

One camera cannot tell a large head far away from a small one near by: shape and pose are found up
to a common factor. What sets it is a `Scale`: the distance of the pupils, given or usual.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import Speaker
from abs_engine.camera import Camera
from abs_engine.errors import ParameterError
from abs_engine.geometry import vertex_normals
from abs_engine.shape.identity import IdentityShape, identity_shape
from abs_engine.shape.linear import LinearShape
from abs_engine.shape.mouth import mouth_shape
from abs_engine.shape.upper_face import upper_face_modes
from abs_engine.track.correspondence import Correspondence
from abs_engine.track.landmark_fit import PersonLandmarks, fit_person
from abs_engine.track.landmark_shape import LandmarkShape
from abs_engine.track.landmarks import EYES, Landmarks

FloatArray = NDArray[np.float64]

USUAL_PUPILS, PUPILS_SPREAD = 63.4, 3.8
"""Distance of adults' pupils, mm, and its standard deviation (Dodgson 2004, 3,976 people)."""
_GIVEN_SPREAD = 0.5  # mm, of a distance that somebody measured
_LEAST_PUPILS, _MOST_PUPILS = 30.0, 90.0  # mm; no human's lie outside


@dataclass(frozen=True)
class Scale:
    """What millimetres rest on.

    Parameters
    ----------
    source : str
        "pupil distance" (as given), "usual pupil distance", "known head", "given poses" or
        "average head".
    pupils : float, mm
        Distance of the pupils of the head that is tracked.
    uncertainty : float
        Standard deviation of all lengths in the result, as a share of them, from the scale alone.
    """

    source: str
    pupils: float
    uncertainty: float


def pupil_scale(given: float | None) -> Scale:
    """The scale by a pupil distance that was measured, or by the usual one.

    Raises
    ------
    ParameterError
        If it is no distance that people's pupils have.
    """
    if given is None:
        return Scale("usual pupil distance", USUAL_PUPILS, PUPILS_SPREAD / USUAL_PUPILS)
    if not _LEAST_PUPILS <= given <= _MOST_PUPILS:
        raise ParameterError(
            f"{given:g} mm is not a plausible pupil distance",
            f"give millimetres, {_LEAST_PUPILS:g} to {_MOST_PUPILS:g}",
        )
    return Scale("pupil distance", given, _GIVEN_SPREAD / given)


def known_scale(pupils: float, person: bool, poses: bool) -> Scale:
    """The scale of a head that is not fitted to landmarks, whose pupils are that far apart, mm."""
    if person:
        return Scale("known head", pupils, 0.0)
    spread = PUPILS_SPREAD / USUAL_PUPILS
    return Scale("given poses" if poses else "average head", pupils, spread)


def scale_line(told: Mapping[str, Any]) -> str:
    """What a run's millimetres rest on, in a line, by its `Scale` as a mapping."""
    spread = f", ± {told['uncertainty']:.0%}" if told["uncertainty"] else ""
    return f"scale: {told['source']}, pupils {told['pupils']:.1f} mm apart{spread}"


def pupil_distance(speaker: Speaker, vertices: NDArray[np.floating]) -> float:
    """Distance of the middles of the eyes of a head (V, 3), in its unit."""
    right, left = np.split(vertices[speaker.landmarks["eye_corners"]].astype(np.float64), 2)
    return float(np.linalg.norm(left.mean(axis=0) - right.mean(axis=0)))


@dataclass(frozen=True, eq=False)
class FittedHead:
    """A person's head.

    Parameters
    ----------
    speaker : Speaker
        All of it as large as the person: its units, too.
    neutral : (V, 3) float32, mm
    expression : LinearShape
        How this head's mouth moves.
    shape : LandmarkShape
        The person's landmarks, with nothing of the identity left to fit.
    identity : (K,) float64
        Standard deviations from the average person, by the names of `identity_shape`.
    scale : Scale
    """

    speaker: Speaker
    neutral: NDArray[np.float32]
    expression: LinearShape
    shape: LandmarkShape
    identity: FloatArray
    scale: Scale


def fit_head(
    speaker: Speaker,
    correspondence: Correspondence,
    landmarks: Sequence[Landmarks],
    camera: Camera,
    scale: Scale,
    expression: LinearShape | None = None,
    modes: int = 10,
) -> FittedHead:
    """Identity over the whole head, by the landmarks of several frames, at a scale.

    Parameters
    ----------
    speaker : Speaker
    correspondence : Correspondence
    landmarks : sequence of Landmarks
    camera : Camera
    scale : Scale
    expression : LinearShape, optional
        How the average head's mouth moves; by default `mouth_shape`.
    modes : int
        Number of its modes, by default.
    """
    people = identity_shape(speaker)
    average = expression or mouth_shape(speaker, speaker.vertices, modes)
    shape = landmark_shape(speaker, correspondence, average, speaker.vertices, people)
    found = fit_person(shape, landmarks, camera)
    neutral = speaker.person(people.targets(found.identity))
    wider = _eyes_seen(found, landmarks, camera, shape)
    larger = scale.pupils / (wider * pupil_distance(speaker, neutral))
    sized, own = scaled(speaker, larger), _scaled_shape(average, neutral - speaker.vertices, larger)
    head = np.asarray(neutral * larger, np.float32)
    person = landmark_shape(sized, correspondence, own, head, None)
    return FittedHead(sized, head, own, person, found.identity, scale)


def _eyes_seen(
    person: PersonLandmarks,
    landmarks: Sequence[Landmarks],
    camera: Camera,
    shape: LandmarkShape,
) -> float:
    """How much farther apart the eyes are seen than the fitted head has them.

    The targets hardly move the eyes, and the scale rests on what is seen of them.
    """
    own = shape.person(person.identity)
    ratios = []
    for seen, frame in zip(landmarks, person.frames, strict=True):
        points = own.mean + np.tensordot(frame.posture, own.posture, 1)
        drawn = camera.project(frame.pose.apply(points))
        apart = [
            np.linalg.norm(np.subtract(*(at[pair].mean(axis=0) for pair in EYES)))
            for at in (seen.pixels, drawn)
        ]
        ratios.append(apart[0] / apart[1])
    return float(np.median(ratios))


def landmark_shape(
    speaker: Speaker,
    correspondence: Correspondence,
    expression: LinearShape,
    neutral: NDArray[np.floating],
    people: IdentityShape | None,
) -> LandmarkShape:
    """The landmarks of a head (V, 3) that moves by mouth modes and the upper face's units."""
    upper = upper_face_modes(speaker)
    identity = np.zeros((0, *neutral.shape)) if people is None else people.modes(speaker)
    vertices = expression.mean.astype(np.float64)
    return LandmarkShape.of(
        correspondence,
        vertices,
        vertex_normals(neutral.astype(np.float64), speaker.faces),
        identity,
        np.concatenate([expression.modes, upper]),
        neutral[speaker.lip_ring].astype(np.float64).mean(axis=0),
    )


def scaled(speaker: Speaker, factor: float) -> Speaker:
    """The speaker with all of its lengths times a factor."""
    return replace(
        speaker,
        vertices=np.asarray(speaker.vertices * factor, np.float32),
        units=np.asarray(speaker.units * factor, np.float16),
        identity=np.asarray(speaker.identity * factor, np.float16),
    )


def _scaled_shape(shape: LinearShape, moved: NDArray[np.floating], factor: float) -> LinearShape:
    """A mouth's motion put onto a head that is `moved` (V, 3) and larger by a factor."""
    return replace(
        shape,
        mean=np.asarray((shape.mean + moved) * factor, shape.mean.dtype),
        modes=np.asarray(shape.modes * factor, shape.modes.dtype),
    )
