"""Training (section 4): from dots in the head frame to learned physics."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.capture.dot_annotations import LIPS16
from abs_engine.capture.observations import Observations
from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ModelFormatError, ParameterError, TooFewPointsError
from abs_engine.face.shape.lip_shell import LipShell, cut_lip_shell
from abs_engine.face.shape.minimum_norm_deformation import reach
from abs_engine.face.shape.modal import LearnedPhysics, learn
from abs_engine.io.assets import Speaker
from abs_engine.learn.believed_dots import believe
from abs_engine.learn.correspondence import Correspondence, correspond
from abs_engine.learn.held_out import held_out_variances
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.sources import Source


@dataclass(frozen=True, eq=False)
class Training:
    """Learned physics and what it was learned from.

    Parameters
    ----------
    used, tested, untested, left_out : (...,) int
        Frames that were learned from, complete ones after them, later ones in which a dot is
        missing, and those with too few dots.
    jumped : (...,) int
        Frames of which a dot was left out because it jumps, see `believed_dots.believe`.
    incomplete : (...,) int
        Those of the used frames in which dots were lost or left out.
    uncertain : (...,) int
        Those of the used and tested frames in which a dot is uncertain.
    displacements : (T, N, 3) float64, mm
        Minimum-strain displacements (eq. 2) of the used frames.
    test : (m, N, 3) float64, mm
        Those of the tested frames, which nothing was learned from.
    """

    physics: LearnedPhysics
    shell: LipShell
    correspondence: Correspondence
    used: IntArray
    tested: IntArray
    untested: IntArray
    left_out: IntArray
    jumped: IntArray
    incomplete: IntArray
    uncertain: IntArray
    displacements: FloatArray
    test: FloatArray


def train(
    observations: Observations,
    speaker: Speaker,
    person: str | None = None,
    *,
    n_modes: int = LEARNING.modes,
    n_train: int = LEARNING.trained,
    shell: LipShell | None = None,
) -> Training:
    """Learn how a person's lips move.

    A dot that was lost or jumps is put where the other dots of its frame have it, as the used
    frames say (`believed_dots.believe`); frames with too few believed dots are left out. All of
    them are named in the result.

    Parameters
    ----------
    observations : Observations
        With the dots of `dot_annotations.LIPS16`.
    speaker : Speaker
        Whose head the shell is cut from; `shell`, where that was done before.
    person : str, optional
        Which of the speaker's people it is; by default somebody else, see `correspond`.
    n_train : int
        Number of frames to learn from, from the first on; the complete others are for testing.

    Raises
    ------
    TooFewPointsError
        If dots were not observed at all, or lost in so many frames that too few are left.
    ParameterError
        If the dots hardly move, the frames do not span so many modes, there is no such person, the
        dots are not his, or two of them, or left and right, have each other's place.
    """
    shell = cut_lip_shell(speaker) if shell is None else shell
    dots = observations.of(LIPS16)
    _check_asked(n_modes, n_train)
    enough = np.isfinite(dots).all(axis=2).sum(axis=1) >= LEARNING.fewest_dots
    _check_usable(int(enough.sum()), observations.frames, n_train)
    believed = believe(dots, n_train, observations.first)
    frames = np.flatnonzero(believed.usable)
    _check_usable(len(frames), observations.frames, n_train)
    used, later = frames[:n_train], frames[n_train:]
    whole = np.asarray(believed.known.all(axis=1))
    tested = later[whole[later]]
    laid = correspond(speaker, shell, believed.dots[used], person)  # it refuses other units
    _check_moved(believed.dots[used])
    both = np.concatenate([used, tested])
    goals = laid.goals(believed.dots[both])
    moved = reached(shell, laid, goals)
    sample = goals[:n_train][whole[used]]
    if len(sample) < LEARNING.frames_a_mode * n_modes:
        sample = goals[:n_train]
    physics = replace(
        _learned(shell, laid, moved[:n_train], n_modes, _noise(sample, n_modes)),
        speaker=checksum(speaker),
        source=f"{observations.source}; {laid.how}",
    )
    return Training(
        physics, shell, laid, used, tested, later[~whole[later]],
        np.flatnonzero(~believed.usable), np.flatnonzero(believed.jumped.any(axis=1)),
        used[~whole[used]],
        both[observations.doubtful(LIPS16)[both]], moved[:n_train], moved[n_train:],
    )  # fmt: skip


def reached(shell: LipShell, laid: Correspondence, goals: FloatArray) -> FloatArray:
    """Displacements (T, N, 3), mm, of a shell whose dots reach their goals (T, 48), mm (eq. 2)."""
    return reach(shell.elastic_at(laid.rest), laid.points.rows(len(shell)), goals)


def _learned(
    shell: LipShell, laid: Correspondence, moved: FloatArray, n_modes: int, noise: float
) -> LearnedPhysics:
    """Physics (eq. 3) of displacements (T, N, 3), mm, by dots with so much `noise`, mm."""
    learned = learn(laid.rest, moved, n_modes)
    return replace(
        learned,
        noise=noise,
        noise_variances=_noise_variances(learned, shell, laid, noise),
        motion_variances=held_out_variances(laid.rest, [Source(moved)], learned.variances),
        person=laid.person,
    )


def _noise_variances(
    learned: LearnedPhysics, shell: LipShell, laid: Correspondence, noise: float
) -> FloatArray:
    """Variance (P,), mm^2, that errors of the dots by `noise` mm put into the modes."""
    answer = reached(shell, laid, np.eye(3 * len(LIPS16)))
    felt = learned.matrix.T @ answer.reshape(len(answer), -1).T  # (P, n): of a dot's error
    return np.asarray(noise**2 * (felt**2).sum(axis=1))


def checksum(speaker: Speaker) -> str:
    """Checksum of a speaker's mesh: 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for part in (speaker.vertices, speaker.faces, speaker.facet_class):
        digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()[:16]


def check_speaker(physics: LearnedPhysics, speaker: Speaker) -> None:
    """Raise `ModelFormatError` for physics that was learned on another head."""
    if physics.speaker and physics.speaker != checksum(speaker):
        remedy = "give that head with --speaker"
        if speaker.imported:
            remedy = (
                "leave out this head (--model, --speaker) or give theirs in its place, or train "
                "lips with this one (train --speaker)"
            )
        raise ModelFormatError("the lips were trained with another speaker's head", remedy)


def _check_asked(n_modes: int, n_train: int) -> None:
    if n_modes < 1 or n_train < LEARNING.frames_a_mode * n_modes:
        raise ParameterError(
            f"{n_modes} modes cannot be learned from {n_train} frames",
            f"give at least one mode (--modes) and {LEARNING.frames_a_mode} frames for each "
            "(--train)",
        )
    if n_modes >= 3 * len(LIPS16):
        raise ParameterError(
            f"{n_modes} modes of {3 * len(LIPS16)} observed coordinates leave none to estimate the "
            "errors of observation from",
            f"learn {3 * len(LIPS16) - 1} modes or fewer",
        )


def _check_usable(usable: int, frames: int, n_train: int) -> None:
    if usable < n_train:
        raise TooFewPointsError(
            f"{LEARNING.fewest_dots} of the {len(LIPS16)} dots or more were found in {usable} "
            f"of {frames} frames, {n_train} are to be learned from",
            "correct the lost dots, film more frames, or learn from fewer (--train)",
        )


def _check_moved(dots: FloatArray) -> None:
    """Refuse dots (T, K, 3), mm, that stay where they are."""
    away = np.linalg.norm(dots - dots.mean(axis=0), axis=2)
    moved = float(np.sqrt((away**2).mean()))
    if moved < LEARNING.least_moved:
        raise ParameterError(
            f"the dots move by {moved:.2f} mm in the {len(dots)} frames to learn from; speech "
            "moves them by several",
            "film the person speaking, or learn from other frames (--train)",
        )


def _noise(goals: FloatArray, n_modes: int) -> float:
    """Standard deviation, mm, of a dot's coordinate about as many modes of the dots (T, n).

    The likeliest one for a linear model with so many modes (Tipping and Bishop 1999, eq. 8): the
    mean of the other variances. Nothing is kept below a thousandth of a mm, for exact data.
    """
    centred = goals - goals.mean(axis=0)
    values = np.linalg.svd(centred, compute_uv=False) ** 2 / max(1, len(goals) - 1)
    beyond = goals.shape[1] - n_modes
    spread = float(np.sqrt(values[n_modes:].sum() / beyond)) if beyond > 0 else 0.0
    return max(spread, 1e-3)
