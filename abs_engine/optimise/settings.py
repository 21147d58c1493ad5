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
    usual_tolerance : float, the objective's units
        By less than which the values of a simplex, or of another method without slopes, differ when
        it stops, unless another is given. Not measured.
    squares_tolerance : float, the objective's units
        The same of steps on sums of squares. Not measured.
    squares_steps : int
        Levenberg-Marquardt steps at most. Not measured.
    squares_tries : int
        Dampings tried for each of them. Not measured.
    squares_difference : float, first steps
        Over which residuals are differentiated for them, unless another is given. Not measured.
    longer : float, times a step that helped
        The next one by local variations. Not measured.
    ascent_tolerance : float, nats
        What an iteration of a climb gains at least: less changes the odds by no more than a tenth.
        Not measured.
    ascent_limit : int, iterations
        Of a climb by forces at most. Not measured.
    gradient_limit : int, iterations
        The same of a climb by the gradient. Not measured.
    gradient_difference : float, first steps
        Over which the gradient is taken: a drawing changes by whole pixels, so that it may not be
        small. Not measured.
    longest_way : float, first steps
        That a direction moves a parameter by at most, at stride 1. Not measured.
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
    axes_limit : int, evaluations
        Of a frame by a simplex along axes at most. Not measured.
    axes_starts : int
        Best of the starts that are all descended from before it. Not measured.
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
    newton_limit : int, evaluations
        By Newton steps at most, of a frame or of a posture while a person is fitted. Measured: in
        608 such fits of p03, p12 and a GRID clip 41 at most.
    newton_gain : float, nats
        Less than which ends these steps, or is not tried for. Not measured.
    newton_more : float, nats
        From which on a step is followed by another that looks as far. Chosen with wide mouths in
        view, which were left half-way.
    newton_reaches : tuple of int, drawn pixels
        To either side of a border that are looked at, step after step: long lines see past a wrong
        border. Chosen among (8, 6, 4, 3, 2, 2), (8, 5, 3, 2) and (8, 4, 2) on p01 to p08 of the
        strangers' clips: apertures were off from gaps read by eye by 1.81, 1.81 and 1.82 mm,
        corners by 0.14, 0.18 and 0.24; on p09 to p16 apertures by 1.99, 1.91 and 1.93. On 32 films
        of other heads (seeds 5 to 8) the first two are alike.
    quick_reaches : tuple of int, drawn pixels
        The same where the next frame waits. Not measured.
    newton_tries : int
        Of a step. Not measured.
    polished : int, evaluations
        Of the simplex that has the last word after Newton steps. Measured on 40 frames each of p02,
        p05 and p07 of the strangers' clips and of lrwp9a of GRID: it gains 0 to 0.02 nats, and up
        to 0.05 with 16.
    damped : float, share of the curvature
        That is added after a step that led nowhere. Not measured.
    damped_more : float, times that
        After each further such step. Not measured.
    polish_edge : float, nats
        By which an edge of the simplex that polishes raises the value. Not measured.
    damping : float, share of the curvature
        Added to it at first by Levenberg and Marquardt. Not measured.
    least_damping : float, share of the curvature
        At least. Not measured.
    stiffer : float, ratio
        Of the damping after a step that led up, and one over that after others. Not measured.
    stiffened : float, share of the curvature
        From which damping grows after a step that led up. Not measured.
    """

    tolerance: float = 0.03
    limit: int = 400
    usual_tolerance: float = 0.02
    squares_tolerance: float = 1e-4
    squares_steps: int = 100
    squares_tries: int = 12
    squares_difference: float = 0.2
    longer: float = 1.5
    ascent_tolerance: float = 0.1
    ascent_limit: int = 15
    gradient_limit: int = 30
    gradient_difference: float = 0.5
    longest_way: float = 10.0
    strides: tuple[float, ...] = (0.4, 1.0, 2.0)
    memory: tuple[float, ...] = (0.0, 0.5, 1.0, 2.0)
    shorter: float = 0.08
    shortest: float = 0.02
    longest_edge: float = 2.0
    axes_limit: int = 200
    axes_starts: int = 2
    axes_edge: float = 0.01
    axes_difference: float = 1.0
    axes_steps: int = 4
    axes_tries: int = 3
    back: float = 0.4
    newton_limit: int = 100
    newton_gain: float = 0.05
    newton_more: float = 0.2
    newton_reaches: tuple[int, ...] = (8, 5, 3, 2)
    quick_reaches: tuple[int, ...] = (8, 4, 2)
    newton_tries: int = 2
    polished: int = 8
    damped: float = 0.3
    damped_more: float = 4.0
    polish_edge: float = 0.25
    damping: float = 1e-2
    least_damping: float = 1e-4
    stiffer: float = 8.0
    stiffened: float = 1e-3


SOLVING = SolverSettings()
