"""Warnings about a run: in its summary, and printed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, IntArray
from abs_engine.core.words import counted, each_counted
from abs_engine.face.appearance.colour import shows_lips
from abs_engine.face.appearance.exposure import USUAL, Exposure
from abs_engine.tracking.frame.blob_visibility import COVERED
from abs_engine.tracking.frame.clip_setting import GREY
from abs_engine.tracking.settings.doubts import DOUBTS

NO_COLOUR = (
    "the video has no colour, so skin, lips and teeth are distinguished by brightness alone; "
    "results are less exact"
)
SOME_GREY = (
    "{} of {} have no colour, while the others do: there landmarks alone are reported, and the "
    "result is less exact; give the clip as it was filmed"
)
TOO_DARK = (
    "the face is too dark for its colours to be seen, so skin, lips and teeth are distinguished by "
    "brightness alone; results are less exact"
)
EXCHANGED = (
    "the skin is more blue than red: unless the light is blue, red and blue are exchanged, as in "
    "pictures of OpenCV, and apertures may be off; give RGB"
)
BURNT_OUT = (
    "{:.0%} of the face is overexposed: lips, teeth and skin merge in white, and parted lips may "
    "come out closed; look at the overlay before you use it"
)

NO_LIPS = (
    "no lips can be distinguished from what is around them (separability: {}): if a mask or a hand "
    "hides the mouth throughout, the lips are invented; look at the overlay"
)
SAME_COLOUR = (
    "lips and skin have nearly the same colour here (separability: {}); the result rests more on "
    "landmarks and the prior"
)

LITTLE = "the drawn mouth explains only {:.0%} of the picture around it: look at the overlay"
GIVEN_COLOURS = (
    "the colours are another run's: leave them out unless they are of this person in this light"
)
OTHER_COLOURS = "--colours are of a video {} colour, unlike this one, and are not used"
FACE_COLOURS = (
    "colours come from the recordings that the face was learned from; in another light, give "
    "--colours from a run in that light"
)
FACE_LOOKS = (
    "how the face looks comes from the recordings that it was learned from; in another light, use "
    "--terms colour, whose colours are then learned from the clip"
)
UNCOVERED = (
    "in the light of --colours it is not known how this mouth usually looks: none counts as covered"
)
OTHER_HEAD = (
    "the head in this video does not match the learned face (landmarks lie {:.1f} standard "
    "deviations off, its own speaker's less than {:.1f}): is it the same speaker? If so, "
    "learn the face from more recordings"
)
OTHERS = "the face explains only {:.0%} of the picture: is it this speaker's?"
OTHER_TALKER = (
    "the talking face explains only {:.0%} of the picture: if it is another person's, or was "
    "learned in other light, track without --model and --preset"
)
SMALL_MOUTH = (
    "the mouth is only {} wide in the picture: below {:.0f} its openings are hardly followed; give "
    "the video at its full size, or film from nearer"
)
CLOSE_UP = (
    "the face reaches far beyond the picture: for a close-up of the mouth by a worn camera, use "
    "--worn"
)
NO_EYES = (
    "the eyes are outside the picture: the head's size follows from the rest of the face, and all "
    "lengths may be off by about {:.0%}; film the whole face"
)
UNSEEN_SKIN = "too little skin is seen to compare its shading, which is left out"
STRETCHED = (
    "the face is much {} for its height than most: if the video was stretched, as where 4:3 is "
    "shown as 16:9, widths and apertures are off; give it with its right proportions"
)
OTHER_TIMES = (
    "{} could be read, but the file gives times of {}: the times in the results follow from the "
    "mean rate, and may be off; convert the video, for example with ffmpeg"
)
UNLIKE_SHOT = (
    "no frame of the shot from frame {} to {} is tracked, as its mouth looks unlike that of the "
    "other shots: if it is another person's, or in another light, track that shot by itself"
)
ALL_CLOSED = (
    "the lips are closed in all {} that were tracked: if the person speaks there, look at the "
    "overlay before you use it"
)


def other_head(misfit: float) -> tuple[str, ...]:
    """Warning that a speaker's face is not that of the person in the clip, if it is not.

    The misfit, in standard deviations, is that of landmarks from its head: see `speakers.misfit`.
    """
    most = DOUBTS.most_speaker_misfit
    return (OTHER_HEAD.format(misfit, most),) if misfit > most else ()


def stretched(proportion: float) -> tuple[str, ...]:
    """Warning that a video may have been stretched, if a face is too wide or narrow for a person's.

    The proportion is its width over its height; NaN where that is not known.
    """
    wider = proportion / DOUBTS.face_proportion
    narrowest, widest = DOUBTS.face_proportions
    if wider < narrowest:
        return (STRETCHED.format("narrower"),)
    return (STRETCHED.format("wider"),) if wider > widest else ()


def reasons_lost(found: NDArray[np.bool_], status: NDArray[np.str_]) -> dict[str, int]:
    """Reasons why frames (T,) were lost, and how many were for each, the commonest first."""
    return dict(Counter(status[~found].tolist()).most_common())


def mostly_lost(found: NDArray[np.bool_], status: NDArray[np.str_]) -> list[str]:
    """Warning that most frames (T,) were lost, and why, the commonest reason first."""
    lost = len(found) - int(found.sum())
    if lost <= DOUBTS.most_lost * len(found):
        return []
    why = each_counted(reasons_lost(found, status))
    many = (
        "no frame was tracked"
        if lost == len(found)
        else f"only {len(found) - lost} of {counted(len(found), 'frame')} were tracked"
    )
    return [f"{many} ({why}): look at the overlay"]


def little_explained(source: str, score: float | None) -> list[str]:
    """Warning that the run explains too little of the picture, if it does.

    The score is the mean, None where it is not known; the source is what scores are of, such as
    colour: see ``score_of`` in ``run.json``.
    """
    if score is None:
        return []
    if source in ("colour", "talking: colour") and score < DOUBTS.least_score:
        return [LITTLE.format(score)]
    if source in ("texture", "local") and score < DOUBTS.least_face_score:
        return [OTHERS.format(score)]
    talking = source in ("talking: texture", "talking: local")
    if talking and score < DOUBTS.least_talking_score:
        return [OTHER_TALKER.format(score)]
    return []


def unlike_shots(
    found: BoolArray, status: NDArray[np.str_], cut: BoolArray, index: IntArray
) -> list[str]:
    """Warnings of shots of which no frame is found and most count as covered, while others are.

    All are of frames (T,); `cut` says which of them begin another shot, `index` their numbers.
    """
    ends = [0, *np.flatnonzero(cut).tolist(), len(found)]
    shots = [slice(a, b) for a, b in pairwise(ends) if b - a >= DOUBTS.fewest]
    gone = [s for s in shots if found.any() and not found[s].any()]
    unlike = [s for s in gone if 2 * (status[s] == COVERED).sum() > s.stop - s.start]
    return [UNLIKE_SHOT.format(*index[s][[0, -1]]) for s in unlike]


def all_closed(closed: NDArray[np.bool_], time: NDArray[np.float64]) -> list[str]:
    """Warning that lips are closed in every tracked frame (N,) of some seconds, if they are."""
    if not (len(closed) and closed.all() and np.ptp(time) > DOUBTS.longest_closed):
        return []
    return [ALL_CLOSED.format(counted(len(closed), "frame"))]


def untimed(count: int, times: int) -> list[str]:
    """Warning that a video's times are of another number of frames than were read, if they are.

    `times` is 0 where the file gives none.
    """
    if not times or count == times:
        return []
    return [OTHER_TIMES.format(counted(count, "frame"), f"{times:,}")]


def without_colour(status: NDArray[np.str_]) -> list[str]:
    """Warning that some frames (T,) have no colour, while the clip has, if some do."""
    grey = int(np.count_nonzero(status == GREY))
    return [SOME_GREY.format(grey, counted(len(status), "frame"))] if grey else []


def small_mouth(width: float) -> list[str]:
    """Warning that the tracked mouth is too small, if it is.

    The width, px, is that of the median frame; NaN without any.
    """
    if not width < DOUBTS.least_mouth:
        return []
    return [SMALL_MOUTH.format(f"{width:.1f} pixels", DOUBTS.least_mouth)]


def close_up(pixel: float, size: tuple[int, int]) -> list[str]:
    """Warning that a picture of some size, px, shows a part of the face alone, if it does.

    `pixel` is how many mm one covers of the face in the median frame; NaN without any.
    """
    high, (width, height) = DOUBTS.face_height / pixel, size
    share = max(high / height, DOUBTS.face_width * high / width)
    return [CLOSE_UP] if share > DOUBTS.most_face else []


def disagreement(aperture: float, deviation: float, by_landmarks: float) -> float:
    """Distance of an aperture from that of the landmarks, in their joint standard deviations.

    All are in mm: as found, its standard deviation, and by the landmarks alone; NaN where not
    known.
    """
    unsure = DOUBTS.landmark_unsure
    own = unsure if math.isnan(deviation) else deviation
    spread = math.hypot(own, unsure, DOUBTS.landmark_share * by_landmarks)
    return abs(aperture - by_landmarks) / spread


def doubts(
    against: NDArray[np.bool_],
    held: NDArray[np.bool_],
    separability: Mapping[str, float],
    agreement: float = 1.0,
    chromatic: bool = True,
    exposure: Exposure = USUAL,
    small: bool = False,
    blue: bool = False,
) -> list[str]:
    """Doubts that a user should know before believing a run, a line each.

    The frames (T,) are those `against` which landmarks speak, see `FrameResult.contradicted`, and
    those that were `held` to them; separability, agreement and chromatic are of `ColourClasses`,
    the exposure of the face. Colours of a `small` mouth need not agree with landmarks; `blue` is
    whether its skin is more blue than red.
    """
    lines = [] if chromatic else [TOO_DARK if exposure.dark else NO_COLOUR]
    if blue and chromatic:
        lines.append(EXCHANGED)
    if exposure.burnt:
        lines.append(BURNT_OUT.format(exposure.saturated))
    if separability and np.mean(list(separability.values())) < DOUBTS.least_separability:
        told = ", ".join(f"{k.replace('_', ' ')} {v:.0%}" for k, v in separability.items())
        lines.append((SAME_COLOUR if shows_lips(separability) else NO_LIPS).format(told))
    if agreement < DOUBTS.least_agreement and not small:
        lines.append(
            f"by colours alone the mouth opens {max(agreement, 0.0):.0%} as far as by landmarks: "
            "teeth or tongue may be taken for lips. So colours count less, and aperture_sd is "
            "larger; look at the overlay before you use it"
        )
    if len(against) >= DOUBTS.fewest and against.mean() > DOUBTS.most_contradicted:
        lines.append(
            f"in {against.mean():.0%} of the frames the mouth is open farther, or less, than "
            "landmarks say, by more than either may be off: look at the overlay before you use it"
        )
    share = float(np.mean(held)) if len(held) else 0.0
    if share > DOUBTS.most_held:
        lines.append(
            f"in {share:.0%} of the frames what is drawn led off the lips; there landmarks alone "
            "are reported"
        )
    return lines
