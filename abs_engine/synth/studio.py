"""The studio: films a person saying a sequence, and writes video and ground truth.

The pictures come from pyrender in a process of its own, so a tracker is never tested on pictures
from its own renderer. All draws of chance take one seed: the same call gives the same truth and,
before compression, the same pixels.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from abs_engine.assets import Speaker
from abs_engine.camera import Camera
from abs_engine.errors import ParameterError
from abs_engine.geometry import FACING, Pose
from abs_engine.synth.look import Look
from abs_engine.synth.optics import backdrop, composite
from abs_engine.synth.process import Worker
from abs_engine.synth.sequence import Sequence, deform
from abs_engine.synth.torso import Torso, dress
from abs_engine.synth.writer import TakeWriter
from abs_engine.truth import DEPTH_STEP

Progress = Callable[[int, int], None]

_REACH = 250.0
"""No point of a head is farther from its origin, mm."""


def film(
    speaker: Speaker,
    sequence: Sequence,
    camera: Camera,
    folder: Path,
    *,
    look: Look | None = None,
    seed: int = 0,
    lossless: bool = False,
    command: str = "",
    progress: Progress | None = None,
) -> Path:
    """Film a sequence and write video and ground truth (see `abs_engine.truth`).

    Parameters
    ----------
    speaker : Speaker
    sequence : Sequence
    camera : Camera
        Without distortion.
    folder : Path
        Must not exist; it appears when everything is written.
    look : Look, optional
    seed : int
        Of the sensor noise.
    lossless : bool
        Also write ``lossless.mp4``.
    command : str
        Kept in the ground truth.
    progress : callable, optional
        Called with the number of frames done and of all frames.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    ParameterError
        If the camera has lens distortion or the mesh too many facets.
    OutputError
        If the folder exists or cannot be written.
    StudioError
        If pyrender cannot draw on this machine.
    """
    check(speaker, sequence, camera)
    offsets = [deform(speaker, row) for row in sequence.weights]
    with (
        TakeWriter(folder, camera, sequence.rate, lossless=lossless) as writer,
        closing(shoot(speaker, sequence, camera, offsets, look or Look(), seed)) as shots,
    ):
        for count, (picture, ids, depth) in enumerate(shots, start=1):
            writer.add(picture, ids, depth)
            if progress is not None:
                progress(count, len(sequence))
        writer.finish(
            **record(speaker, sequence), offsets=np.array(offsets), seed=seed, command=command
        )
    return Path(folder)


def check(speaker: Speaker, sequence: Sequence, camera: Camera) -> None:
    """Raise `ParameterError` for what this studio cannot film."""
    if camera.distorted or camera.matrix[0, 1]:
        raise ParameterError(
            "the studio has no lens distortion and no skew", "film with an ideal camera"
        )
    if camera.size[0] % 2 or camera.size[1] % 2:
        raise ParameterError(
            f"H.264 has no pictures of {camera.size[0]}x{camera.size[1]}", "give even sizes"
        )
    nearest, farthest = _depth_range(sequence)
    if nearest <= 0 or farthest > 65_535 * DEPTH_STEP:
        raise ParameterError(
            f"the head is {sequence.translations[:, 2].min():.0f} mm or more from the camera",
            f"place it between {_REACH:.0f} and {65_535 * DEPTH_STEP - _REACH:.0f} mm",
        )
    if len(speaker.faces) > 65_534:
        raise ParameterError(
            f"{len(speaker.faces)} facets do not fit 16-bit ids", "film a head of fewer facets"
        )


def _depth_range(sequence: Sequence) -> tuple[float, float]:
    """Nearest and farthest depth, mm, that the head can reach."""
    depth = sequence.translations[:, 2]
    return float(depth.min()) - _REACH, float(depth.max()) + _REACH


def record(speaker: Speaker, sequence: Sequence) -> dict[str, Any]:
    """Arrays of ``truth.npz``, but for the offsets."""
    return {
        "rate": sequence.rate,
        "person": sequence.person,
        "sentence": sequence.text,
        "unit_names": speaker.unit_names,
        "unit_weights": sequence.weights,
        "identity_weights": speaker.people[sequence.person],
        "neutral": speaker.named(sequence.person),
        "faces": speaker.faces,
        "facet_class": speaker.facet_class,
        "class_names": speaker.class_names,
        "rotations": sequence.rotations,
        "translations": sequence.translations,
        "visemes": sequence.visemes,
        "closed": sequence.closed,
        **{n: speaker.landmarks[n] for n in ("outer_lip", "outer_lip_20", "inner_lip_8")},
        "mouth_corners": speaker.landmarks["mouth_corners"],
    }


Shot = tuple[NDArray[np.uint8], NDArray[np.uint32], NDArray[np.float32]]


def shoot(
    speaker: Speaker,
    sequence: Sequence,
    camera: Camera,
    offsets: list[NDArray[np.float16]],
    look: Look,
    seed: int,
) -> Generator[Shot, None, None]:
    """Pictures, facet ids + 1 and depths of every frame; the worker draws one frame ahead."""
    neutral = speaker.named(sequence.person)
    behind = backdrop(camera.size, look.top, look.bottom)
    rng = np.random.default_rng(seed)
    torso = dress(speaker, neutral)
    state_of = partial(_state, neutral, torso, Normals(speaker))

    def finish(drawn: dict[str, NDArray[Any]]) -> Shot:
        picture = look.sensor.expose(composite(drawn["rgba"], behind), rng)
        return picture, drawn["ids"], drawn["depth"]

    with Worker(_setup(speaker, sequence, torso, camera, look)) as worker:
        worker.post(state_of(sequence.pose(0), offsets[0]))
        for frame in range(1, len(sequence)):
            state = state_of(sequence.pose(frame), offsets[frame])
            drawn = worker.collect()
            worker.post(state)
            yield finish(drawn)
        yield finish(worker.collect())


def _setup(
    speaker: Speaker, sequence: Sequence, torso: Torso, camera: Camera, look: Look
) -> dict[str, NDArray[Any]]:
    nearest, farthest = _depth_range(sequence)
    return {
        "size": np.array(camera.size),
        "matrix": camera.matrix,
        "near": np.array(max(camera.near, nearest)),  # pyrender's default, 0.05, leaves no depth
        "far": np.array(farthest + 400.0),
        "faces": speaker.faces,
        "uv": speaker.uv,
        "texture": speaker.texture(sequence.person),
        "shade": inner_shade(speaker),
        "roughness": np.array(look.roughness),
        "lights": np.array([[*s.direction, s.intensity, *s.colour] for s in look.lights]),
        "ambient": np.full(3, look.ambient),
        "torso_vertices": torso.vertices,
        "torso_faces": torso.faces if look.shirt is not None else torso.faces[:0],
        "torso_normals": torso.normals,
        "torso_colour": np.array(look.shirt or (0.0, 0.0, 0.0)),
    }


def _state(
    neutral: NDArray[np.float32],
    torso: Torso,
    normals: Normals,
    pose: Pose,
    offset: NDArray[np.float16],
) -> dict[str, NDArray[Any]]:
    vertices = np.asarray(neutral + offset.astype(np.float32), np.float32)
    lean = Pose.from_vectors(0.25 * _turn(pose), np.zeros(3)).rotation
    body = Pose(lean @ FACING, pose.apply(torso.anchor))
    return {
        "vertices": vertices,
        "normals": normals(vertices),
        "pose": _matrix(pose),
        "torso_pose": _matrix(body),
    }


def _turn(pose: Pose) -> NDArray[np.float64]:
    """Rotation vector by which the head is turned away from facing the camera."""
    return Pose(pose.rotation @ FACING.T, np.zeros(3)).rotation_vector


def _matrix(pose: Pose) -> NDArray[np.float64]:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = pose.rotation, pose.translation
    return out


def inner_shade(speaker: Speaker) -> NDArray[np.float32]:
    """Factor (V,) by which vertices inside the mouth are darkened, as the lights cast no shadow."""
    inside = [speaker.class_id(n) for n in ("inner_mouth", "upper_teeth", "lower_teeth", "tongue")]
    chosen = np.unique(speaker.faces[np.isin(speaker.facet_class, inside)])
    front = speaker.vertices[speaker.landmarks["inner_lip_8"], 2].max()
    depth = np.clip(front - speaker.vertices[chosen, 2], 0, None)
    out = np.ones(len(speaker.vertices), np.float32)
    out[chosen] = 0.12 + 0.88 * np.exp(-depth / 18.0)
    return out


class Normals:
    """Vertex normals of a head, smooth across texture seams.

    Parameters
    ----------
    speaker : Speaker
    """

    def __init__(self, speaker: Speaker) -> None:
        self._faces, self._weld = speaker.faces, speaker.weld
        rows = speaker.weld[speaker.faces].ravel()
        columns = np.repeat(np.arange(len(speaker.faces)), 3)
        self._sum = sparse.csr_matrix((np.ones(len(rows), np.float32), (rows, columns)))

    def __call__(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        """Unit normals (V, 3) of vertices (V, 3)."""
        a, b, c = (vertices[self._faces[:, k]] for k in range(3))
        sums = self._sum @ np.cross(b - a, c - a)
        length = np.linalg.norm(sums, axis=1, keepdims=True)
        return np.asarray((sums / np.maximum(length, 1e-12))[self._weld], np.float32)
