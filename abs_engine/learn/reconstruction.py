"""Reconstruction (section 6.2): table 1, and which camera would say most about the shape."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ParameterError, TooFewPointsError
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.face.shape.posterior import Posterior, expected_posterior, reconstruct
from abs_engine.learn.training import Training

UNITS = (2.35, 2.83, 5.05)
"""Size of the paper's model across, wide and deep, in its normalised coordinates."""
_EVERYTHING = slice(None)


@dataclass(frozen=True)
class Part:
    """Measured part of the dots of `dot_annotations.LIPS16`.

    `paper` is the mean-squared error for each degree of freedom in the paper's table 1.
    """

    key: str
    label: str
    dots: slice
    coordinates: str
    paper: float


TABLE_1 = (
    Part("xyz8", "xyz (8 points)", slice(8), "xyz", 1.10e-3),
    Part("yz16", "yz (16 points)", _EVERYTHING, "yz", 7.13e-4),
    Part("xy16", "xy (16 points)", _EVERYTHING, "xy", 6.70e-3),
)


@dataclass(frozen=True)
class Row:
    """A row of table 1.

    Parameters
    ----------
    error : float
        Mean-squared error for each degree of freedom, in the paper's units (see `unit_scale`).
    rms : float, mm
        Root mean square distance of a node from where it should be.
    expected : float, mm
        What `rms` should be by the training frames: the trace of the posterior covariance, and the
        variance that the modes do not hold.
    """

    part: Part
    error: float
    rms: float
    expected: float


def unit_scale(rest: FloatArray) -> FloatArray:
    """Paper's units for a mm, (3,), along x, y and z of the head frame, by nodes (N, 3) at rest.

    Notes
    -----
    The paper's model is "2.35 units across, 2.83 units wide, and 5.05 units deep", which fits no
    lips in one scale (ours are 64 x 43 x 19 mm); the coordinates are called normalised. So each
    axis gets a scale of its own, taken in the order of the paper's coordinates: the box around
    the shell at rest is 2.35 in x (from one corner of the mouth to the other), 2.83 in y (up) and
    5.05 in z (out of the face). Errors in depth then weigh most, which fits the paper's table,
    whose frontal row is the worst by ten times.
    """
    return np.asarray(np.array(UNITS) / np.ptp(rest, axis=0))


def reconstruct_part(training: Training, part: Part, shapes: FloatArray) -> Posterior:
    """Reconstruction by the modes of a part of the dots of shapes (..., N, 3), mm."""
    rows = training.correspondence.points.subset(part.dots).rows(
        len(training.shell), part.coordinates
    )
    flat = np.reshape(shapes, (-1, 3 * len(training.shell)))
    return reconstruct(training.physics, rows, (rows @ flat.T).T)


def table_1(training: Training) -> list[Row]:
    """Errors of reconstruction on the frames that were not learned from.

    Raises
    ------
    TooFewPointsError
        If no frame was left for testing.

    Notes
    -----
    As in the paper, a frame's truth is its whole minimum-strain displacement, which may leave the
    ten modes, and the part is taken of the same dots. The noise is that of the physics, estimated
    on the training frames.
    """
    if len(training.test) == 0:
        raise TooFewPointsError(
            "no frame is left to test on", "observe more frames, or learn from fewer"
        )
    physics = training.physics
    truth = physics.rest + training.test
    scale = unit_scale(physics.rest)
    beyond = np.sqrt(max(0.0, physics.total - physics.variances.sum()) / len(physics.rest))
    out = []
    for part in TABLE_1:
        found = reconstruct_part(training, part, truth)
        away = found.shapes - truth
        error = float(((away * scale) ** 2).mean())
        rms = float(np.sqrt((away**2).sum(axis=-1).mean()))
        out.append(Row(part, error, rms, float(np.hypot(found.deviation, beyond))))
    return out


@dataclass(frozen=True)
class CameraGain:
    """Gain in knowledge from a camera.

    Parameters
    ----------
    expected : float, mm
        Root mean square distance by which a node is expected to be off with this camera: from the
        trace of the posterior covariance.
    before : float, mm
        The same without it.
    points : int
        How many points it sees.
    """

    name: str
    expected: float
    before: float
    points: int = 0


def rank_cameras(
    physics: LearnedPhysics,
    points: ShellPoints,
    directions: Mapping[str, FloatArray],
    *,
    noise: float | None = None,
    have: tuple[FloatArray, ...] = (),
    seen: Callable[[FloatArray], BoolArray] | None = None,
) -> list[CameraGain]:
    """Ranking of several cameras by what they would reveal of the shape; the best comes first.

    Parameters
    ----------
    points : ShellPoints
        What the cameras see of the shell.
    directions : mapping of str to (3,) float64
        From the head towards each camera, head frame: (0, 0, 1) is frontal, (1, 0, 0) the profile
        seen from the subject's left. A camera is far away, and tells the two coordinates of each
        point across its direction.
    noise : float, mm, optional
        Of such a coordinate; by default that of the physics.
    have : tuple of (3,) float64
        Directions of cameras that there are already.
    seen : callable, optional
        Which of the points (K,) bool a camera in a direction sees; by default all.

    Raises
    ------
    ParameterError
        If a direction is none, no camera is given, or the noise is below 1e-6 mm.
    """
    if not directions:
        raise ParameterError("there is no camera to choose", "give one or more directions")
    nodes = len(physics.rest)

    def rows_of(direction: FloatArray) -> sparse.csr_matrix:
        shown = points if seen is None else points.subset(np.flatnonzero(seen(direction)))
        return _across(shown, direction, nodes)

    known = [rows_of(direction) for direction in have]
    before = _left(physics, known, noise)
    gains = []
    for name, direction in directions.items():
        rows = rows_of(direction)
        left = _left(physics, [*known, rows], noise)
        gains.append(CameraGain(name, left, before, rows.shape[0] // 2))
    return sorted(gains, key=lambda gain: gain.expected)


def _left(physics: LearnedPhysics, rows: list[sparse.csr_matrix], noise: float | None) -> float:
    """Root mean square distance, mm, that a node is expected to be off once `rows` are observed."""
    if sum(part.shape[0] for part in rows) == 0:
        return float(np.sqrt(physics.variances.sum() / len(physics.rest)))
    return expected_posterior(physics, sparse.vstack(rows), noise).deviation


def _across(points: ShellPoints, direction: FloatArray, nodes: int) -> sparse.csr_matrix:
    """W of the points' two coordinates across a direction."""
    length = float(np.linalg.norm(direction))
    if np.shape(direction) != (3,) or not length > 0:
        raise ParameterError(f"{direction} is not a direction", "give three numbers, not all 0")
    basis = np.linalg.svd(np.asarray(direction, np.float64)[None] / length)[2][1:]
    return points.projected(nodes, basis)
