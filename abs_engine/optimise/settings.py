"""Settings of the solvers: when they stop, and how far they step."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SolverSettings:
    """Settings of the solvers: when they stop, and how far they step.

    Attributes
    ----------
    tolerance : float, nats
        That end a search. Not measured.
    limit : int, evaluations
        Of a frame at most. Not measured.
    ascent_tolerance : float, nats
        What an iteration of a climb gains at least: less changes the odds by no more than a tenth.
        Not measured.
    strides : tuple of float, times the last stride
        That are tried; for pose and shape each, the longer of which counts. Not measured.
    memory : tuple of float, times the step before
        That are tried along with them. Not measured.
    shorter : float, times the stride
        Where none of these is better: the longest is then shorter than the shortest was. Not
        measured.
    shortest : float, times the first stride
        Below which nothing more is to be found in this direction. Not measured.
    longest_edge : float, first steps of the parameters
        Largest edge of the second simplex. Not measured.
    axes_edge : float, the objective's units
        By which an edge of a simplex along the axes raises the value. Not measured.
    axes_difference : float, first steps
        Over which residuals are differentiated before it. Not measured.
    axes_steps : int
        Levenberg-Marquardt steps before it at most. Not measured.
    axes_tries : int
        Tries of each of those. Not measured.
    back : float, times a step
        That its next try is, after one that led up. Not measured.
    newton_tries : int
        Of a step. Not measured.
    damped : float, share of the curvature
        That is added after a step that led nowhere. Not measured.
    polish_edge : float, nats
        By which an edge of the simplex that polishes raises the value. Not measured.
    damping : float, share of the curvature
        Added to it at first by Levenberg and Marquardt. Not measured.
    least_damping : float, share of the curvature
        At least. Not measured.
    stiffer : float, ratio
        Of the damping after a step that led up, and one over that after others. Not measured.
    """

    tolerance: float = 0.03
    limit: int = 400
    ascent_tolerance: float = 0.1
    strides: tuple[float, ...] = (0.4, 1.0, 2.0)
    memory: tuple[float, ...] = (0.0, 0.5, 1.0, 2.0)
    shorter: float = 0.08
    shortest: float = 0.02
    longest_edge: float = 2.0
    axes_edge: float = 0.01
    axes_difference: float = 1.0
    axes_steps: int = 4
    axes_tries: int = 3
    back: float = 0.4
    newton_tries: int = 2
    damped: float = 0.3
    polish_edge: float = 0.25
    damping: float = 1e-2
    least_damping: float = 1e-4
    stiffer: float = 8.0


SOLVING = SolverSettings()
