"""Somebody's whole head, by landmarks, pupils, texture and outline of some frames, at a scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import vertex_normals
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import one_thread
from abs_engine.face.identity import sized_head
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.mouth import mouth_shape
from abs_engine.face.shape.population import expected
from abs_engine.face.shape.upper_face import upper_face_modes
from abs_engine.io.assets import Speaker
from abs_engine.render.cpu import for_threads
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.detection.pupils import pupils_of
from abs_engine.tracking.head.head_joint import fit_jointly
from abs_engine.tracking.head.head_pose import TexturedHead
from abs_engine.tracking.head.head_problem import HeadFrameSeen, HeadProblem, views_of
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.person.scale import Scale, pupil_distance, pupil_vertices
from abs_engine.tracking.texture.head_texture import HeadBody, gray_of


@dataclass(frozen=True, eq=False)
class FittedHead:
    """A person's head.

    Parameters
    ----------
    speaker : Speaker
        All of it as large as the person: its units, too.
    neutral : (V, 3) float32, mm
    identity : (K,) float64
        Standard deviations from the average person, along `head_modes`.
    """

    speaker: Speaker
    neutral: NDArray[np.float32]
    expression: LinearShape
    identity: FloatArray
    scale: Scale
    textured: TexturedHead


@dataclass(frozen=True, eq=False)
class AverageHead:
    """A head before anything was seen of a person, and how people differ from it.

    Parameters
    ----------
    speaker : Speaker
        As large as `scale` says.
    people : (K, V, 3) float32
        See `head_modes`.
    shape : LandmarkShape
        With identity modes, those of the body at the landmarks.
    """

    speaker: Speaker
    expression: LinearShape
    people: NDArray[np.float32]
    body: HeadBody
    shape: LandmarkShape
    correspondence: Correspondence
    scale: Scale

    @property
    def known(self) -> bool:
        """Whether this is the person's own head, with nothing of the person left to fit."""
        return len(self.people) == 0

    @classmethod
    def of(
        cls,
        speaker: Speaker,
        correspondence: Correspondence,
        scale: Scale,
        expression: LinearShape | None = None,
        known: bool = False,
    ) -> AverageHead:
        """Of a speaker at a scale; by default the mouth moves as `mouth_shape` has it.

        A `known` one is the person's own head.
        """
        average = expression or mouth_shape(
            speaker,
            speaker.vertices,
            SHAPE.expression_modes,
            anybody=not known and expected(speaker),
        )
        larger = scale.pupils / pupil_distance(speaker, speaker.vertices)
        sized, people = sized_head(speaker, larger, known)
        moves = replace(
            average,
            mean=np.asarray(average.mean * larger, average.mean.dtype),
            modes=np.asarray(average.modes * larger, average.modes.dtype),
        )
        upper = upper_face_modes(sized)
        body = HeadBody.of(sized, moves.mean, people, moves.modes, upper)
        if known:
            body = body.without_scalp()
        shape = landmark_shape(sized, correspondence, moves, sized.vertices, people)
        return cls(sized, moves, people, body, shape, correspondence, scale)

    def fitted(
        self, frames: Sequence[HeadFrameSeen], camera: Camera, renderer: Renderer
    ) -> FittedHead:
        """The head of a person whom several frames show; `renderer` carries their texture along."""
        sized, scale, pupils = self.speaker, self.scale, pupil_vertices(self.speaker)
        noise = self.correspondence.noise.beside(self.shape.posture[: len(self.expression.modes)])
        drawn_with = for_threads(renderer)
        problem = HeadProblem(
            self.body, self.shape, noise, pupils, scale.pupils, scale.held, camera
        )
        with one_thread():
            found = fit_jointly(problem, frames, drawn_with)
        moved, mean = np.tensordot(found.identity, self.people, 1), self.expression.mean
        neutral = np.asarray(sized.vertices + moved, np.float32)
        own = replace(self.expression, mean=np.asarray(mean + moved, mean.dtype))
        shape = landmark_shape(sized, self.correspondence, own, neutral, None)
        body = self.body
        known = replace(
            body, mean=own.mean.astype(np.float64), identity=body.identity[:0], pivot=shape.pivot
        )
        views = tuple(views_of(body, frames, found))
        textured = TexturedHead(known, shape, noise.person(found.error), views, camera, drawn_with)
        return FittedHead(sized, neutral, own, found.identity, scale, textured)


def seen_in(image: NDArray[np.uint8], landmarks: Landmarks) -> HeadFrameSeen:
    """Observations that a frame (H, W, 3) gives of the head that has these landmarks."""
    return HeadFrameSeen(gray_of(image), landmarks, pupils_of(image, landmarks), image)


def landmark_shape(
    speaker: Speaker,
    correspondence: Correspondence,
    expression: LinearShape,
    neutral: NDArray[np.floating],
    people: NDArray[np.floating] | None,
) -> LandmarkShape:
    """The landmarks of a head (V, 3) that moves by mouth modes and the upper face's units.

    `people` are modes (K, V, 3) of who it may be.
    """
    upper = upper_face_modes(speaker)
    identity = np.zeros((0, *neutral.shape)) if people is None else people
    vertices = expression.mean.astype(np.float64)
    return LandmarkShape.of(
        correspondence,
        vertices,
        vertex_normals(neutral.astype(np.float64), speaker.faces),
        identity,
        np.concatenate([expression.modes, upper]),
        neutral[speaker.lip_ring].astype(np.float64).mean(axis=0),
    )
