"""From an utterance to face-unit weights, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.io.assets import Speaker
from abs_engine.studio.speech.contact import ContactSolver
from abs_engine.studio.speech.dominance import Score, blend
from abs_engine.studio.speech.gestures import Contact, contacts
from abs_engine.studio.speech.lips import Lips
from abs_engine.studio.speech.targets import ARTICULATORS, goals, hold, pace
from abs_engine.studio.speech.utterance import Utterance


@dataclass(frozen=True, eq=False)
class Speech:
    """Motion of the face during speech, T frames.

    Parameters
    ----------
    weights : (T, 52) float64
        Face-unit weights from 0 to 1, in the speaker's order; frame k is at k / rate seconds.
    phonemes : tuple of str
        Label of each frame, T; '_' for a pause and for a recording without labels. Of a sentence of
        visemes, the nearest one.
    intervals : tuple of (str, float, float)
        Labels in the IPA, '_' for a pause, with start and end in seconds; empty for a recording.
    rate : float
        Frames per second.
    head : (T, 3) float64, optional
        Rotation vectors, radians, of the head about its own axes away from facing straight on.
    text : str
        What is said, as the scene file has it, and whether it is cut.
    """

    weights: FloatArray
    phonemes: tuple[str, ...]
    intervals: tuple[tuple[str, float, float], ...]
    rate: float
    head: FloatArray | None = None
    text: str = ""

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.weights)


def articulate(
    speaker: Speaker, neutral: NDArray[np.floating], utterance: Utterance, rate: float
) -> Speech:
    """Face-unit weights of an utterance as a person says it.

    Dominance functions blend the phonemes' targets. Then the contacts are made on the person's
    mesh: the lips seal in every frame of a hold of p, b or m, and in f and v the lower lip goes to
    the upper front teeth, as near as the units bring it.

    Parameters
    ----------
    neutral : (V, 3) float32, mm, head frame
        The person's neutral vertices.

    Raises
    ------
    ParameterError
        If the rate is not positive.
    """
    times = frame_times(utterance.seconds, rate)
    blended = _blended(utterance, times, speaker.unit_names)
    held = contacts(utterance.segments, times)
    solver = ContactSolver(Lips.of(speaker, neutral), speaker.unit_names)
    weights = _with_closures(_with_bites(blended, held, times, solver), held, times, solver)
    ends = [segment.end for segment in utterance.segments[:-1]]
    index = np.searchsorted(ends, times, side="right")
    labels = tuple(utterance.segments[i].phoneme.label for i in index)
    intervals = tuple((s.phoneme.label, float(s.start), float(s.end)) for s in utterance.segments)
    return Speech(weights, labels, intervals, rate)


def frame_times(seconds: float, rate: float) -> FloatArray:
    """Times (T,), seconds, of the frames of a clip; the first at 0, the last before its end."""
    check_rate(rate)
    return np.arange(max(1, int(np.ceil(seconds * rate - 1e-6)))) / rate


def check_rate(rate: float) -> None:
    """Refuse a frame rate that is not positive."""
    if not 0 < rate < float("inf"):
        raise ParameterError(f"the frame rate is {rate:g}", "give frames per second, such as 25")


def _blended(utterance: Utterance, times: FloatArray, unit_names: tuple[str, ...]) -> FloatArray:
    """Weights (T, 52) of the blended targets."""
    score = _score(utterance)
    curves = blend(score, times)
    weights = np.zeros((len(times), len(unit_names)))
    for column, units in enumerate(ARTICULATORS.values()):
        for unit in units:
            weights[:, unit_names.index(unit)] = curves[:, column]
    return weights


def _score(utterance: Utterance) -> Score:
    start, end, target, magnitude, rise, fall = [], [], [], [], [], []
    for segment in utterance.segments:
        first, last = hold(segment.phoneme)
        length = segment.end - segment.start
        start.append(segment.start + first * length)
        end.append(segment.start + last * length)
        wanted = goals(segment.phoneme)
        target.append([wanted[name].target for name in ARTICULATORS])
        magnitude.append([wanted[name].magnitude for name in ARTICULATORS])
        rise.append([pace(segment.phoneme, name)[0] for name in ARTICULATORS])
        fall.append([pace(segment.phoneme, name)[1] for name in ARTICULATORS])
    return Score(*map(np.array, (start, end, target, magnitude, rise, fall)))


def _with_bites(
    weights: FloatArray, held: tuple[Contact, ...], times: FloatArray, solver: ContactSolver
) -> FloatArray:
    """Weights with the lower lip at the teeth in labiodentals.

    The posture is solved once for each, in the middle of its hold, and stands still.
    """
    out = weights.copy()
    for contact in held:
        if contact.kind != "teeth":
            continue
        middle = int(np.abs(times - (contact.start + contact.end) / 2).argmin())
        bitten = solver.bite(weights[middle])
        used = solver.biting_units
        share = contact.activation(times)[:, None]
        out[:, used] += share * (bitten[used] - out[:, used])
    return out


def _with_closures(
    weights: FloatArray, held: tuple[Contact, ...], times: FloatArray, solver: ContactSolver
) -> FloatArray:
    """Weights with the lips sealed in bilabials, solved for each frame on its way there."""
    shares = [c.activation(times) for c in held if c.kind == "lips"]
    share = np.max([np.zeros(len(times)), *shares], axis=0)
    out = weights.copy()
    for frame in np.flatnonzero(share > 0):
        closed = solver.close(weights[frame])
        out[frame] += share[frame] * (closed - weights[frame])
    return np.asarray(np.clip(out, 0.0, 1.0), np.float64)
