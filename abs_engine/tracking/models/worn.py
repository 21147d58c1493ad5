"""A camera worn before the mouth: a close-up of the lower face, the head still in the picture.

As in the teleconference experiment of Odisio and Bailly's "Shape and appearance models of talking
faces". No face is needed; the mouth is found, and followed by local appearance and outlines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import Image, evenly
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.opening import MouthSpot, OpeningLooks
from abs_engine.face.head import build_mouth_model
from abs_engine.face.held_head import held_head
from abs_engine.fit.opening import NAME, Opening, sided
from abs_engine.io.arrays import Layout, real, whole
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.npz import read_model, write_npz
from abs_engine.learn.opening import LabelledMouth, disagreement, learn_opening
from abs_engine.tracking.detection.face_detection import find_face
from abs_engine.tracking.frame.clip_setting import ClipSetting
from abs_engine.tracking.frame.frame_state import Follower, HeadFrame, Memory
from abs_engine.tracking.frame.head_frame import HeadBinder
from abs_engine.tracking.frame.mouth_landmarks import MouthLandmarks
from abs_engine.tracking.model_entry import Model
from abs_engine.tracking.models.worn_fit import (
    WornHead,
    find_mouth,
    mouth_points,
    unsettled,
    upside_down,
)
from abs_engine.tracking.options import LANDMARKS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.person.scale import pupil_distance, pupil_scale
from abs_engine.tracking.settings.worn import CLOSE_UP

FORMAT, VERSION = "abs_engine.worn_mouths", 1
_WHOLE = "these frames show whole faces, which are followed better without --worn"
_UNLEARNED = (
    "without a model openings are less exact: they may be too small, and lips that seldom close "
    "may come out parted throughout: label frames, learn a model with 'mouths', and give it with "
    "--model"
)
_NO_MOUTH = (
    "no mouth is seen for sure: looked for from several places, it is found elsewhere each time; "
    "if there is none in the picture, or only a part, the lips are invented: look at the overlay"
)
_UPSIDE_DOWN = (
    "the mouth seems to be upside down, where its lips are not followed: turn the video by 180 "
    "degrees, for example with ffmpeg -vf hflip,vflip"
)
_UNLIKE = (
    "the model opens this mouth differently from the landmarks, as if it had been learned from "
    "another kind of camera: track without --model, or label frames of this camera and learn again "
    "with 'mouths'"
)
_LAYERS = 3
_LAYOUT: Layout = {
    "mean": real("width 0", dtype=np.float32),
    "spread": real("width 0", dtype=np.float32, low=1e-9),
    "layers": whole(low=_LAYERS, high=_LAYERS),
    **{
        f"weights{k}": real(f"width {k}", f"width {k + 1}", dtype=np.float32)
        for k in range(_LAYERS)
    },
    **{f"offsets{k}": real(f"width {k + 1}", dtype=np.float32) for k in range(_LAYERS)},
}


@dataclass(frozen=True, eq=False)
class StillMotion(Follower):
    """The head where it was in the frames that it was fitted to."""

    pose: Pose

    def follower(self) -> StillMotion:
        """Itself, as it carries nothing from frame to frame."""
        return self

    def step(self, image: Image, _memory: Memory | None = None) -> HeadFrame:
        """The next frame (H, W, 3) RGB with the head's pose."""
        return HeadFrame(image, self.pose)


def save_looks(looks: OpeningLooks, path: Path) -> None:
    """Write a model's file, that `load_looks` reads; raises `OutputError` if it cannot be."""
    write_npz(path, FORMAT, VERSION, looks.arrays())


def load_looks(path: Path) -> OpeningLooks:
    """Read what `save_looks` wrote; raises `InputFileError`, `ModelFormatError`."""
    return read_model(path, FORMAT, VERSION, OpeningLooks.of_arrays, "model of mouths", _LAYOUT)


def prepare_worn(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> ClipTracker:
    """Find the mouth of a close-up, and fit a head to some of its frames.

    Without a model's file, what the mouth looks like is learned from the clip itself, from where
    the landmark network puts its inner lips.

    Raises
    ------
    InputFileError, ModelFormatError, VideoError
        If the video, or the model's file, cannot be read.
    FaceNotFoundError
        If the video has no frames.
    ParameterError
        If what is chosen does not go together.
    """
    leaves.check("worn")
    looks = None if options.model_file is None else load_looks(options.model_file)
    speaker = load_speaker(options.speaker)
    images, opening, seen = found_mouth(clip, options, looks, tell)
    tell("fitting the head")
    made = fitted_clip(clip, speaker, opening, images, options, leaves, renderer)
    found = options.mouth is None
    warnings = _doubts(images, found)
    if looks is None:
        warnings = [_UNLEARNED, *warnings]
    elif found and not warnings:
        unlike = disagreement(looks, labelled_by_network(seen, opening.spot))
        warnings = [_UNLIKE] if unlike > CLOSE_UP.most_unlike else []
    setting = replace(made.setting, warnings=tuple(warnings))
    return replace(made, setting=setting, remarks="\n".join(warnings))


def found_mouth(
    clip: Clip, options: TrackOptions, looks: OpeningLooks | None, tell: Tell
) -> tuple[list[Image], Opening, list[Image]]:
    """Some frames of a clip, the place and looks of its mouth, and more frames.

    Errors as `prepare_worn`.
    """
    tell("finding the mouth")
    seen = _spread(clip)
    images = [seen[k] for k in evenly(len(seen), CLOSE_UP.fitted)]
    spot = find_mouth(images)
    if options.mouth is not None:
        x, y, width, height = options.mouth
        spot = MouthSpot(x + 0.5 * (width - 1), y + 0.5 * (height - 1), width)
    if looks is None:
        tell("learning its looks")
        looks = learn_opening(labelled_by_network(seen, spot))
    return images, Opening(looks, spot), seen


def labelled_by_network(images: Sequence[Image], spot: MouthSpot) -> list[LabelledMouth]:
    """Frames of a close-up with the landmark network's points, as if people had put them there."""
    return [LabelledMouth(image, mouth_points(image, spot), spot) for image in images]


def fitted_clip(
    clip: Clip,
    speaker: Speaker,
    opening: Opening,
    images: list[Image],
    options: TrackOptions,
    leaves: Leaves,
    renderer: Renderer,
) -> ClipTracker:
    """A clip with a head fitted to some of its frames."""
    scale = pupil_scale(options.pupil_distance)
    sized = speaker.scaled(scale.pupils / pupil_distance(speaker, speaker.vertices))
    texture = speaker.texture()
    whole = build_mouth_model(sized, sized.vertices, texture)
    model, regions = sided(whole)
    head = WornHead(model, regions, clip.camera, renderer)
    pose, person, opening = head.fitted(images, opening)
    face = replace(held_head(model, person), regions=regions).looking(**{NAME: opening})
    marks = MouthLandmarks(model.n_expression)
    binder = HeadBinder(model, face, clip.camera, renderer, clip.info.rate, marks, leaves.kinds)
    setting = ClipSetting(
        face, clip.camera, renderer, clip.info.rate, StillMotion(pose), binder,
        leaves.driver.minimiser(), times=clip.info.times,
    )  # fmt: skip
    return ClipTracker(
        clip.video, clip.info, setting, scale, facts={"start": "worn", "evidence": None}
    )


def _doubts(images: list[Image], found: bool) -> list[str]:
    """A warning that frames show no close-up, or no mouth that was found, if they do not."""
    if _whole_faces(images):
        return [_WHOLE]
    asked = [images[k] for k in evenly(len(images), CLOSE_UP.asked)]
    if upside_down(asked):
        return [_UPSIDE_DOWN]
    return [_NO_MOUTH] if found and unsettled(asked) > CLOSE_UP.most_unsettled else []


def _whole_faces(images: list[Image]) -> bool:
    """Whether most frames show a face that leaves room around it."""
    faces = [(find_face(image), min(image.shape[:2])) for image in images]
    small = [f is not None and f.size < CLOSE_UP.whole_face * side for f, side in faces]
    return bool(np.mean(small) > 0.5)


def _spread(clip: Clip) -> list[Image]:
    """Frames of a clip, spread evenly."""
    kept: list[Image] = []
    stride = 1
    for number, image in enumerate(islice(clip.frames(), CLOSE_UP.seen)):
        if number % stride == 0:
            kept.append(image)
        if len(kept) == 2 * CLOSE_UP.learned:
            kept, stride = kept[::2], 2 * stride
    if not kept:
        raise FaceNotFoundError(f"{clip.video} has no frames", "give another video")
    return kept


WORN = Model(
    prepare_worn,
    starts=(LANDMARKS,),
    without=("physics", "person", "poses", "colours", "face", "evidence"),
)
"""Found in the close-up; nothing but the mouth's opening is compared."""
