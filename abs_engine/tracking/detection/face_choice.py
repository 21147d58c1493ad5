"""The choice of the face that is followed, where there are several, and a first look at it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.words import counted
from abs_engine.tracking.detection.face_detection import (
    Face,
    faces_about,
    faces_any_way_up,
    faces_beside,
    faces_turned,
)
from abs_engine.tracking.detection.face_looks import FaceLooks
from abs_engine.tracking.detection.initial_pose import FaceBox
from abs_engine.tracking.detection.landmarks import Landmarks, landmarks_again, landmarks_of
from abs_engine.tracking.detection.shot_cuts import ShotCuts, anew_line, cut_line
from abs_engine.tracking.settings.detection import DETECTION

FOLLOWS = "'track --face N' follows another"
"""End of a line about several faces, by which such a line is recognised."""


@dataclass(frozen=True)
class FaceChoice:
    """Face that a user means.

    Parameters
    ----------
    number : int or None
        Counted from 1, the largest first, in the first frame that shows a face; None for the
        largest.
    box : FaceBox or None
        By where its mouth is in the first frame.
    about : bool
        Whether it may also lie beside the box: the nearest face is meant.
    """

    number: int | None = None
    box: FaceBox | None = None
    about: bool = False

    @classmethod
    def asked(cls, number: int | None, mouth: Sequence[float] | None) -> FaceChoice:
        """The face of a number, or the one whose mouth is in a box: left, top, width, height."""
        return cls(number, None if mouth is None else FaceBox.around_mouth(*mouth))

    def first(self, image: Image) -> tuple[Landmarks | None, list[Face]]:
        """The face that is meant in a first frame, and all of its faces, the largest first.

        Raises
        ------
        FaceNotFoundError
            If there are fewer faces than the number.
        """
        if self.box is not None:
            near = self.box.shown(faces_about(image, self.box.centre, self.box.size))
            if near is None:
                faces = faces_any_way_up(image)
                near = self.box.nearest(faces) if self.about else self.box.shown(faces)
            return (None, []) if near is None else (_believed(landmarks_of(image, near)), [near])
        seen = faces_seen(image, small=True)
        if not seen:
            return None, []
        number = self.number or 1
        if number > len(seen):
            count = counted(len(seen), "face")
            raise FaceNotFoundError(
                f"there is no face {number}: the first frame with a face shows {count}",
                f"give --face 1{f' to {len(seen)}' if len(seen) > 1 else ', or leave it out'}",
            )
        return seen[number - 1][1], [f for f, _ in seen]


def faces_seen(image: Image, *, small: bool = False) -> list[tuple[Face, Landmarks]]:
    """The faces of a picture (H, W, 3) RGB with their landmarks, the largest first.

    Asked for, small ones are looked for beside large ones, too.
    """
    faces = faces_any_way_up(image)
    beside = faces_beside(image, faces) if small and faces else []
    pairs = [(face, _believed(landmarks_of(image, face))) for face in by_size([*faces, *beside])]
    return [(f, m) for f, m in pairs if m is not None]  # what the second network denies is none


LARGEST = FaceChoice()
"""The face that is followed where a user chooses none."""


def by_size(faces: Sequence[Face]) -> list[Face]:
    """Faces, the largest first."""
    return sorted(faces, key=lambda face: -face.size)


def face_lines(faces: Sequence[Face], chosen: int) -> str:
    """Lines about several faces: where each is, and which one is followed."""
    where = "; ".join(
        f"{k} at {f.centre[0]:.0f} {f.centre[1]:.0f}, {f.size:.0f} pixels"
        for k, f in enumerate(faces, 1)
    )
    why = " (the largest)" if chosen == 1 else ""
    return f"{len(faces)} faces: {where}; following face {chosen}{why}; {FOLLOWS}"


def _believed(seen: Landmarks | None) -> Landmarks | None:
    """The landmarks, unless the mirror image shows that they are no face's."""
    return seen if seen is not None and seen.unlike < DETECTION.wrong else None


class FaceFollower:
    """Finds one face in frame after frame, by where its landmarks were last.

    After a cut of the film it may be anywhere at once, unless a user has chosen among several.
    While somebody passes before it, it is lost; elsewhere it is known by its look.

    Parameters
    ----------
    known : sequence of Landmarks or None
        What it found in the first frames, when they were looked at before.
    faces : sequence of Face
        All that the first frame with a face showed then.

    Attributes
    ----------
    faces : list of Face
        All that the first frame with a face shows, the largest first.
    found : list of Landmarks or None
        What was found in the first frames, as many as a first look at a clip may take.
    cut : bool
        Whether the last frame began another shot, or may show another person.
    cuts : list of int
        All frames that began another shot, counted from 0.
    anew : list of int
        Frames that show, after a while without any, a face elsewhere.
    """

    def __init__(
        self, choice: FaceChoice, known: Sequence[Landmarks | None] = (), faces: Sequence[Face] = ()
    ) -> None:
        self._choice, self._known = choice, known
        self._last: Landmarks | None = None
        self._lost = self._count = self._steady = 0
        self._anywhere = self.cut = False
        self._shots, self._looks = ShotCuts(), FaceLooks()
        self.cuts: list[int] = []
        self.anew: list[int] = []
        self.found: list[Landmarks | None] = []
        self.faces: list[Face] = [*faces]

    def step(self, image: Image) -> Landmarks | None:
        """The landmarks in the next frame (H, W, 3) RGB; None where the face is not seen."""
        self.cut = self._shots.step(image)
        self.cuts += [self._count] if self.cut else []
        if self.cut and self._choice == LARGEST:
            self._anywhere, self._steady = True, 0
        if self.cut:
            self._looks.forget_others()
        again = self._count < len(self._known)
        found = self._known[self._count] if again else self._next(image)
        if not self.cut and self._perhaps_another(image, found):
            self.cut = True
            self.anew.append(self._count)
            self._looks.forget_others()
        if found is not None:
            self._looks.step(image, found, look=self._count % DETECTION.looks_every == 0)
        self._count += 1
        if len(self.found) < DETECTION.faces_kept:
            self.found.append(found)
        self._lost = 0 if found is not None else self._lost + 1
        self._steady = 0 if found is None else self._steady + 1
        self._anywhere &= self._steady < DETECTION.settled
        self._last = found or self._last
        return found

    def _next(self, image: Image) -> Landmarks | None:
        last = self._last
        if last is None:
            found, faces = self._choice.first(image)
            self.faces = faces or self.faces
            return found
        found = landmarks_again(image, last) if self._lost == 0 and not self.cut else None
        found = self._own(image, found)
        if found is not None and found.unlike < DETECTION.doubtful:
            return found
        caught = self._again(image, last)
        seen = [m for m in (found, caught) if m is not None]
        return min(seen, key=lambda m: m.unlike, default=None)

    def remarks(self) -> str:
        """Lines about several faces, and about cuts; empty without either."""
        several = [face_lines(self.faces, self._choice.number or 1)] if len(self.faces) > 1 else []
        shots = [cut_line(self.cuts)] if self.cuts else []
        return "\n".join(several + shots + ([anew_line(self.anew)] if self.anew else []))

    def _again(self, image: Image, last: Landmarks) -> Landmarks | None:
        """The face near where it was, or the same elsewhere; in time, or after a cut, any one."""
        any_face = self._anywhere or self._lost > DETECTION.patience
        faces = by_size(faces_any_way_up(image) if any_face else faces_turned(image, last.quarters))
        near = self._near(faces, last)
        elsewhere = any_face or self._lost >= DETECTION.settled
        others = [face for face in faces if face not in near] if elsewhere else []
        for face in [*near, *others]:
            found = self._own(image, landmarks_of(image, face))
            if found is None:
                continue
            if any_face or face in near or self._looks.same(image, found):
                return found
        return None

    def _own(self, image: Image, seen: Landmarks | None) -> Landmarks | None:
        """The landmarks, if they are believed, and not those of a face nearby."""
        found = _believed(seen)
        if found is None or self._lost > DETECTION.patience:
            return found
        return None if self._looks.of_another(image, found) else found

    def _perhaps_another(self, image: Image, found: Landmarks | None) -> bool:
        """Whether a face that is found after a while without any may be another person's."""
        if found is None or self._last is None or self._anywhere:
            return False
        if self._lost <= DETECTION.patience:
            return False
        elsewhere = self._away(found.pixels.mean(axis=0), found.size, self._last) is None
        return elsewhere or self._looks.of_another(image, found)

    def _near(self, faces: Sequence[Face], last: Landmarks) -> list[Face]:
        """Those that may be the face that was last seen, the nearest first."""
        away = [(self._away(f.centre, DETECTION.of_box * f.size, last), f) for f in faces]
        near = [(pixels, f) for pixels, f in away if pixels is not None]
        return [f for _, f in sorted(near, key=lambda one: one[0])]

    def _away(self, centre: FloatArray, size: float, last: Landmarks) -> float | None:
        """Distance, px, of a face from where it was last seen; None if it is another one."""
        slack = 1 + DETECTION.widening * min(self._lost, DETECTION.patience)
        away = float(np.linalg.norm(centre - last.pixels.mean(axis=0)))
        ratio = min(DETECTION.size_ratio**slack, DETECTION.most_size_ratio)
        alike = last.size / ratio < size < last.size * ratio
        return away if alike and away < DETECTION.apart * last.size * slack else None
