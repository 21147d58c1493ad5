"""A second opinion on a mouth that is drawn, for heads that are placed without landmarks.

A head that is followed by its texture or by the lips' colour may lie beside the face and explain
much of the picture there, as cheeks explain cheeks. Some frames are shown to the landmark network.

So are those of learned lips, wherever the head is placed: landmarks are fitted by the lips' own
modes there, and where these cannot open, or close, neither measure is of a mouth that does.
"""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.words import counted
from abs_engine.fit.opening import NAME as OPENING
from abs_engine.tracking.detection.face_choice import faces_seen
from abs_engine.tracking.detection.landmarks import OUTER_RING, Landmarks
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.results.run_table import closed_frames
from abs_engine.tracking.settings.doubts import DOUBTS

ELSEWHERE = (
    "in {} of {} in which a landmark network sees the mouth, it is drawn {}: look at the overlay; "
    "without --preset, --model, --start and --person, landmarks place the head"
)
NEVER_OPEN = (
    "in {} of {} that were looked at, of those in which the mouth is drawn closed, a landmark "
    "network sees it open: look at the overlay; the learned lips may be unable to open as this "
    "mouth does; track without them (--physics, --model, --preset)"
)
HARDLY_MOVES = (
    "in {} that were looked at the aperture varies by {:.1f} mm; by how a landmark network sees "
    "the mouth, it should by about {:.0f} mm: look at the overlay; the learned lips may be unable "
    "to move as this mouth does; track without them (--physics, --model, --preset)"
)


class MouthCheck:
    """Compares drawn mouths with those that a landmark network sees, in some frames of a clip.

    Parameters
    ----------
    setting : ClipSetting
        Of a head that landmarks place, only learned lips are looked at; of a mouth in a close-up,
        none.
    """

    def __init__(self, setting: ClipSetting) -> None:
        self._setting = setting
        self._placed = setting.landmarks is not None
        asked = setting.learned_lips or not self._placed
        self._asked = asked and OPENING not in setting.face.appearance
        self._next, self._step = 0, max(1, round(DOUBTS.look_apart * setting.rate))
        self._elsewhere: list[bool] = []
        self._apertures: list[float] = []
        self._openness: list[tuple[float, ...]] = []  # of each face that is seen

    def add(self, image: Image, result: FrameResult) -> None:
        """Look at the next frame (H, W, 3) RGB, or leave it out."""
        pose, setting = result.pose, self._setting
        if not self._asked or not result.found or pose is None:
            return
        if result.index < self._next:
            return
        self._next = result.index + self._step
        seen = [marks for _, marks in faces_seen(image)]
        self._apertures.append(result.aperture)
        self._openness.append(tuple(one.openness for one in seen))
        if len(self._openness) % DOUBTS.looks == 0:  # a long clip is looked at less often
            self._step *= 2
        if seen and not self._placed:
            drawn = setting.camera.project(pose.apply(result.lips[: setting.face.ring_sizes[0]]))
            self._elsewhere.append(all(_elsewhere(drawn, k) for k in seen))

    def warnings(self) -> list[str]:
        """Those of mouths that lie elsewhere, or are drawn otherwise than seen, in many frames."""
        apertures = np.array(self._apertures)
        least = np.array([min(one, default=np.nan) for one in self._openness])
        closed = closed_frames(apertures)
        shut = int((closed & (least > DOUBTS.parted)).sum())
        if self._placed:
            seen = int((closed & np.isfinite(least)).sum())
            many = 2 * seen >= closed.sum() and _many(shut, seen)
            said = [NEVER_OPEN.format(shut, counted(seen, "frame"))] if many else []
        else:
            elsewhere, seen = sum(self._elsewhere), len(self._elsewhere)
            said = mouth_otherwise(elsewhere, shut, seen, len(apertures))
        if said or not self._setting.learned_lips:
            return said
        sole = np.array([len(one) == 1 for one in self._openness], np.bool_)
        return hardly_moves(apertures[sole], least[sole])


def _elsewhere(drawn: FloatArray, seen: Landmarks) -> bool:
    """Whether a drawn outer contour (N, 2), px, is not that of a face's mouth."""
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    ring = seen.pixels[OUTER_RING]
    least, most = ring.min(axis=0), ring.max(axis=0)
    face = float(np.ptp(seen.pixels @ seen.axes[1]))
    away = float(np.linalg.norm(low + high - least - most)) / 2
    across = float(np.linalg.norm(high - low) / np.linalg.norm(most - least))
    narrow, wide = DOUBTS.mouth_sizes
    return away > DOUBTS.mouth_away * face or not narrow < across < wide


def mouth_otherwise(elsewhere: int, shut: int, seen: int, looked_at: int) -> list[str]:
    """Warnings that mouths are drawn otherwise than they are seen in some frames, if they are.

    The counts are of frames in which one lies beside the face's, in which it is closed and seen
    open, in which a face is seen, and of all. Where hardly one is seen, nothing is known.
    """
    if 2 * seen < looked_at:
        return []
    frames, told = counted(seen, "frame"), []
    if elsewhere > DOUBTS.most_elsewhere * seen:
        told.append(ELSEWHERE.format(elsewhere, frames, "elsewhere"))
    if _many(shut, seen):
        told.append(ELSEWHERE.format(shut, frames, "closed, and seen open"))
    return told


def hardly_moves(apertures: FloatArray, openness: FloatArray) -> list[str]:
    """Warning that learned lips hardly open and close where the mouth is seen to, if they do not.

    Both are of the same frames (N,): apertures as drawn, mm, and `Landmarks.openness`.
    """
    if len(openness) < DOUBTS.fewest_looks or openness.std() < DOUBTS.openness_varies:
        return []
    moved, seen = float(apertures.std()), DOUBTS.openness_mm * float(openness.std())
    if moved > DOUBTS.least_following * seen:
        return []
    return [HARDLY_MOVES.format(counted(len(openness), "frame"), moved, seen)]


def _many(shut: int, seen: int) -> bool:
    """Whether so many frames, of those in which a face is seen, are no chance."""
    return shut > max(1.0, DOUBTS.most_contradicted * seen)
