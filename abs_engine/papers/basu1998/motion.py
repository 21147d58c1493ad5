"""Motion to learn from without filming: recorded or spoken, and the exact dots of it."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.dot_annotations import LIPS17
from abs_engine.capture.observations import Observations
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.io.assets import Speaker
from abs_engine.studio.speech import (
    Segment,
    Utterance,
    articulate,
    parse_phonemes,
    play_recording,
    read_livelink,
)

FRAMES, RATE = 150, 30.0
"""Section 3: 150 frames at 30 Hz."""
AUTHORED = "authored speech"
"""Source of motion that is not recorded."""
RECORDING = Path("livelink_rom") / "alex_rom_3.csv"
RECORDED_FROM = 2100
"""Frame at 30 Hz: of the recording known to the project, here the lips move in the most ways."""
SENTENCES = (
    "f i: l D I s v e t",  # feel this vet
    "b { T f A: D @ S Q p s O: f U t",  # bath, father, shop, saw, foot
    "z u: V v h 3: m e Z @",  # zoo, of, her, measure
    "D eI S aI v OI s h aU D @U z",  # they shy, voice, how, those
)
"""Utterances in X-SAMPA with all vowels and fricatives of (British) English."""
SLOWLY = 15.0
"""Seconds for `SENTENCES`, three times as many as said at the pace of speech."""
HARVARD = (
    "D @ b 3: tS k @ n u: s l I d Q n D @ s m u: D p l { N k s",
    "g l u: D @ S i: t t @ D @ d A: k b l u: b { k g r aU n d",
    "I t s i: z i t @ t e l D @ d e p T Q v @ w e l",
    "D i: z d eI z @ tS I k I n l e g I z @ r e@ d I S",
    "r aI s I z Q f @ n s 3: v d I n r aU n d b @U l z",
    "D @ dZ u: s Q v l e m @ n z m eI k s f aI n p V n tS",
    "D @ b Q k s w Q z T r @U n b I s aI d D @ p A: k t t r V k",
    "D @ h Q g z w 3: f e d tS Q p t k O: n @ n d g A: b I dZ",
    "f O: r aU @ z Q v s t e d i w 3: k f eI s t V s",
    "@ l A: dZ s aI z I n s t Q k I N z I z h A: d t @ s e l",
)
"""The first list of the Harvard sentences, phonetically balanced (IEEE 1969), in British English:
"The birch canoe slid on the smooth planks." and so on."""
UNROUNDED = ("a p a", "i: b i:", "E t E", "A: m A:", "s I s", "e d e")
"""Utterances that leave the rounded vowels out."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a person's face, T frames at `RATE`.

    Parameters
    ----------
    person : str
        Of the speaker.
    weights : (T, 52) float64
        Face units in the speaker's order.
    source : str
        What moves it, in words.
    """

    person: str
    weights: FloatArray
    source: str

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.weights)

    def vertices(self, speaker: Speaker) -> NDArray[np.float32]:
        """The whole head in each frame, (T, V, 3), mm, head frame."""
        units = speaker.unit_matrix(speaker.unit_names)
        moved = np.tensordot(self.weights.astype(np.float32), units, 1)
        return np.asarray(speaker.named(self.person) + moved, np.float32)


def data_folder(name: str) -> Path:
    """A folder of recordings that are not shipped.

    Raises
    ------
    InputFileError
        If neither ABS_ENGINE_DATA nor the folder beside the checkout holds it.
    """
    beside = Path(__file__).resolve().parents[4] / "shared" / "data"
    path = Path(os.environ.get("ABS_ENGINE_DATA") or beside) / name
    if not path.is_dir():
        raise InputFileError(f"{path} does not exist", "name its folder in ABS_ENGINE_DATA")
    return path


def recording_path() -> Path:
    """The recording of a real face, which is not shipped.

    Raises
    ------
    InputFileError
        If it is not at hand, see `data_folder`.
    """
    path = data_folder(RECORDING.parent.name) / RECORDING.name
    if not path.is_file():
        raise InputFileError(f"{path} does not exist", "name its folder in ABS_ENGINE_DATA")
    return path


def recorded_motion(speaker: Speaker, person: str, path: Path) -> Motion:
    """A person moved by `FRAMES` of a Live Link Face recording, from `RECORDED_FROM` on.

    Raises
    ------
    InputFileError
        If the file is no recording.
    ParameterError
        If it has not so many frames.
    """
    played = play_recording(read_livelink(path), speaker.unit_names, RATE).weights
    start, end = RECORDED_FROM, RECORDED_FROM + FRAMES
    if end > len(played):
        raise ParameterError(
            f"frames {start} to {end - 1} are not in the recording",
            f"it has {len(played)}",
        )
    what = f"recording {path.name}, frames {start} to {end - 1} at {RATE:g} Hz"
    return Motion(person, played[start:end], what)


def authored_motion(
    speaker: Speaker,
    person: str,
    *,
    frames: int | None = FRAMES,
    sentences: tuple[str, ...] = SENTENCES,
) -> Motion:
    """A person who says some utterances in the time of so many frames.

    Parameters
    ----------
    frames : int or None
        None for the pace of speech.
    sentences : tuple of str
        X-SAMPA.
    """
    said = parse_phonemes(" _(0.1) ".join(["", *sentences]))
    frames = math.ceil(RATE * said.seconds) if frames is None else frames
    scale = frames / RATE / said.seconds
    slower = Utterance(
        tuple(Segment(s.phoneme, s.start * scale, s.end * scale) for s in said.segments)
    )
    speech = articulate(speaker, speaker.named(person), slower, RATE)
    return Motion(person, speech.weights[:frames], AUTHORED)


def recorded_or_authored(
    speaker: Speaker, person: str, sentences: tuple[str, ...] = SENTENCES
) -> Motion:
    """The recording if it is there, or else sentences in X-SAMPA."""
    try:
        return recorded_motion(speaker, person, recording_path())
    except InputFileError:
        return authored_motion(speaker, person, sentences=sentences)


def spoken_motion(speaker: Speaker, person: str) -> Motion:
    """A person who speaks for some 40 seconds: what the lips that are tracked are learned from.

    `HARVARD` at the pace of speech, as one sound goes over into the next; then `SENTENCES` so
    slowly (`SLOWLY`) that every vowel and fricative is reached.
    """
    fast = authored_motion(speaker, person, frames=None, sentences=HARVARD)
    slow = authored_motion(speaker, person, frames=math.ceil(SLOWLY * RATE))
    return replace(fast, weights=np.concatenate([fast.weights, slow.weights]))


def observed_motion(
    speaker: Speaker, motion: Motion, *, noise: float = 0.0, seed: int = 0
) -> Observations:
    """The dots of a motion as if they had been observed.

    Parameters
    ----------
    noise : float, mm
        Standard deviation that is added to every coordinate.
    seed : int
        Of the noise.

    Returns
    -------
    Observations
        Of `dot_annotations.LIPS17`, in the head frame, without views.
    """
    at = lips17(speaker)
    units = speaker.unit_matrix(speaker.unit_names)[:, at].astype(np.float64)
    points = speaker.named(motion.person)[at] + np.tensordot(motion.weights, units, 1)
    points = points + noise * np.random.default_rng(seed).normal(size=points.shape)
    shape = points.shape[:2]
    told = f" with {noise:g} mm of noise" if noise else ""
    return Observations(
        points=points,
        names=LIPS17,
        found=np.ones(shape, np.bool_),
        uncertain=np.zeros(shape, np.bool_),
        error=np.zeros(shape),
        score=np.ones(shape),
        rate=RATE,
        rotations=np.zeros((len(points), 3)),
        translations=np.zeros((len(points), 3)),
        rigid_error=np.zeros(len(points)),
        source=f"{motion.person}, {motion.source}{told}",
    )
