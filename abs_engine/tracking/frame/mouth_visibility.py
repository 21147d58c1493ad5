"""Visibility of the mouth where landmarks put it.

A landmark network goes on to say where a mouth is behind a hand. The colours within the lips' outer
edge and around it tell: within it a mouth shows lips, teeth or dark, in whatever proportion, and
around it skin. A microphone shows what is no skin around, a hand skin within; or, where it is as
red as the lips, some of both: so the two likenesses are multiplied.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Window
from abs_engine.core.geometry import Pose
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.settings.colour import COLOURS
from abs_engine.tracking.detection.landmarks import OUTER_RING, Landmarks
from abs_engine.tracking.frame.blob_visibility import BRIGHT, COVERED, DARK, OUTSIDE
from abs_engine.tracking.frame.cut_faces import MouthInPicture
from abs_engine.tracking.frame.frame_state import HeadFrame
from abs_engine.tracking.frame.mouth_place import within
from abs_engine.tracking.settings.frames import FRAME_LOOP


@dataclass(frozen=True)
class MouthLook:
    """Colours about a mouth.

    Parameters
    ----------
    inside : float
        Mean probability of lips, teeth or dark within the lips' outer edge, 0 to 1.
    around : float
        Mean probability of skin around it.
    lips : float
        Mean probability of lips within the edge: few in a wide mouth, none behind a microphone.
    """

    inside: float
    around: float
    lips: float

    @classmethod
    def of(cls, classes: ColourClasses, image: Image, seen: Landmarks) -> MouthLook | None:
        """The look of a mouth by its landmarks; None where it lies outside of the picture."""
        ring = seen.pixels[OUTER_RING]
        height, width = image.shape[:2]
        shown = (ring > -0.5).all(axis=1) & (ring < [width - 0.5, height - 0.5]).all(axis=1)
        if shown.mean() < FRAME_LOOP.least_in_picture:
            return None
        centre = ring.mean(axis=0)
        across = max(float(np.ptp(ring[:, 0])), float(np.ptp(ring[:, 1])), 2.0)
        side, scale = 2 * across, min(GENERAL.finest, FRAME_LOOP.look_across / across)
        low = centre - side / 2
        window = Window(float(low[0]), float(low[1]), side, side, scale)
        maps = classes.probabilities(sampled(window, image), COLOURS.smoothing)
        skin = maps[CLASSES.index("skin")]
        mouth = maps.sum(axis=0) - skin
        inside, near, far = (
            within(window, window.to_drawn(centre + times * (ring - centre))) > 0
            for times in (1.0, FRAME_LOOP.look_near, FRAME_LOOP.look_far)
        )
        ring_around = far & ~near
        if not (inside.any() and ring_around.any()):
            return None
        lips = maps[CLASSES.index("lips")][inside].mean()
        return cls(float(mouth[inside].mean()), float(skin[ring_around].mean()), float(lips))

    @classmethod
    def usual(cls, looks: Sequence[MouthLook | None]) -> MouthLook | None:
        """The usual look of a clip: lower quartiles over some frames; None if none shows the mouth.

        Lips that nearly have the skin's colour look like a mouth where they part, less where they
        meet. Where lower quartiles with less skin around the mouth, or that hardly look like it,
        would count as hidden beside the medians, something hides it in more than a quarter of the
        frames: the medians are usual.
        """
        each = [(look.inside, look.around, look.lips) for look in looks if look is not None]
        if not each:
            return None
        shares = FRAME_LOOP.usual_look, 0.5
        lower, median = (cls(*map(float, q)) for q in np.quantile(each, shares, axis=0))
        less_skin = lower.around < FRAME_LOOP.usual_around * median.around
        unlike = lower.likeness < FRAME_LOOP.usual_like * median.likeness
        return median if (less_skin or unlike) and median.hidden(lower) else lower

    @property
    def likeness(self) -> float:
        """Likeness to a mouth in skin, 0 to 1."""
        return self.inside * self.around

    def hidden(self, now: MouthLook) -> bool:
        """Whether something is before the mouth, where this look is usual."""
        return (
            now.likeness < FRAME_LOOP.least_like * self.likeness
            or now.lips < FRAME_LOOP.least_lips * self.lips
        )


@dataclass(frozen=True, eq=False)
class ByLook:
    """By the colours within and around the lips where landmarks put them, and by their place.

    Parameters
    ----------
    usual : MouthLook or None
        Without it no mouth counts as covered.
    place : MouthInPicture, optional
        Of the person; without it only the landmarks of lips say whether they are in the picture.
    """

    classes: ColourClasses
    usual: MouthLook | None
    place: MouthInPicture | None = None

    def hidden(self, frame: HeadFrame, pose: Pose) -> str:
        """Reason why the mouth cannot be seen; empty where it can."""
        if frame.face is None:  # its pose is given
            return "" if self.place is None or self.place.shown(pose) else OUTSIDE
        seen, fit = frame.face.landmarks, frame.face.fit
        if self.place is not None and not self.place.whole(seen, fit):
            return OUTSIDE
        if frame.dark:
            return DARK
        if self.usual is None or frame.grey:
            return ""
        look = MouthLook.of(self.classes, frame.in_usual_light, seen)
        if look is None:
            return OUTSIDE
        if not self.usual.hidden(look):
            return ""
        return BRIGHT if frame.bright else COVERED
