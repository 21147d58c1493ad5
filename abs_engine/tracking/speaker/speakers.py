"""A clip of a speaker whose face was learned from other recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.colour import usable
from abs_engine.face.appearance.colourless import in_colour
from abs_engine.face.appearance.exposure import Exposure, colourless
from abs_engine.fit.terms import LOOKS
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.head.head_pose import placed_fit
from abs_engine.tracking.landmark.rendered_landmarks import correspondence_of
from abs_engine.tracking.model_entry import Model, own_file
from abs_engine.tracking.models.heads import head_setting, stated
from abs_engine.tracking.options import LANDMARKS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.person.frame_choice import Brightness, Sighted
from abs_engine.tracking.results.run_warnings import FACE_COLOURS, FACE_LOOKS, UNCOVERED, other_head
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.speaker.clip_looks import ANEW, known_head, looks_alike, with_looks_of_clip
from abs_engine.tracking.speaker.speaker_face import SpeakerFace, has_looks, load_speaker_face
from abs_engine.tracking.speaker.speaker_looks import compared, looking
from abs_engine.tracking.start.person_fit import FittedPerson
from abs_engine.tracking.start.shaded_skin import with_shaded_skin


def prepare_speaker(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> ClipTracker:
    """Make a clip ready for the face of its speaker, which has to be found.

    Its looks are learned from the clip where they are not those of its recordings.

    Raises
    ------
    InputFileError, ModelFormatError
        If the face's file cannot be read, or is of another head.
    FaceNotFoundError
        If no face is found.
    ParameterError
        If no file is given, or the clip has no colour but the face was learned in colour.
    """
    check_speaker_face(options, leaves)
    speaker = load_speaker(options.speaker)
    face = load_speaker_face(_path(options), speaker)
    tell("finding the face")
    choice, looked = FaceChoice.asked(options.face, options.mouth), PREPARATION.speaker_looked
    found = SpeakerClip(clip, choice, face, speaker, looked=looked)
    return stated(found.tracker(options, leaves, renderer, tell))


def _path(options: TrackOptions) -> Path:
    return own_file(options, "a speaker's face is learned", "me.face")


def check_speaker_face(options: TrackOptions, leaves: Leaves) -> None:
    """Refuse evidence that does not go with a speaker's face, or with other choices.

    Raises
    ------
    InputFileError, ModelFormatError
        If the face's file cannot be read.
    ParameterError
        If no file is given, or it has nothing for the evidence.
    """
    path = _path(options)
    asked = [leaves.kinds[name].what for name in LOOKS if name in leaves.kinds]
    if asked and not has_looks(path):
        raise ParameterError(
            f"{path} has no {asked[0]} to compare",
            "use --terms colour, or learn it again: with an earlier release, or of a head without "
            "texture coordinates, none is learned",
        )
    if asked and options.colours is not None:
        raise ParameterError(
            f"{asked[0]} is compared in the light that the face was learned in, not in that of "
            "--colours",
            "leave out --colours, or use --terms colour",
        )
    leaves.check("speaker")


@dataclass(frozen=True, eq=False)
class SpeakerClip:
    """A clip of a speaker, and the face that was learned of them.

    Parameters
    ----------
    choice : FaceChoice
        Which face of the clip is the speaker's.
    speaker : Speaker
        The head that the face is made of.
    first : int
        Frame that tracking begins with.
    looked : int
        Frames, from the first one with a face on, by which it is judged whether the face is the
        speaker's.
    """

    clip: Clip
    choice: FaceChoice
    face: SpeakerFace
    speaker: Speaker
    first: int = 0
    looked: int = 1

    def tracker(
        self, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell | None = None
    ) -> ClipTracker:
        """The clip made ready; errors as `prepare_speaker`.

        With `tell`, the looks of a face that are not those of its recordings are learned from the
        clip.
        """
        clip, follower = self.clip, FaceFollower(self.choice)
        seen = self._seen(follower)
        face = self._in_light_of(seen[0])
        fitted = face.fitted(
            self.speaker, correspondence_of(self.speaker, renderer), clip.camera, renderer
        )
        off, looks = misfit(fitted, seen), face.appearance
        if looks is not None and not any(name in leaves.kinds for name in LOOKS):
            looks = None
        anew = None
        if tell is not None and looks is None and not looks_alike(self.face, seen, off):
            head = known_head(face, fitted.textured, self.speaker)
            anew = with_looks_of_clip(clip, self.choice, face, head, renderer, tell)
        fitted = anew or fitted
        posed = fitted.posed or fitted.posed_in(seen, renderer)
        leaves, own, unseen = with_shaded_skin(leaves, fitted.face, clip.camera, posed)
        if looks is not None:
            own = looking(own, looks, compared(face, self.speaker))
        found = clip.first(follower.found)
        made = head_setting(clip, fitted, renderer, options, leaves, self.choice, found, own)
        warned = (*unseen, *other_head(off))
        facts = {"start": LANDMARKS, "evidence": options.evidence, "head_misfit": round(off, 2)}
        remarks, hint = follower.remarks().splitlines(), ""
        if anew is not None:
            remarks.append(ANEW)
        else:
            hint = FACE_COLOURS if looks is None else FACE_LOOKS
            known = face.light is self.face.light
            if known:
                facts["colours"] = "the face's"
            else:
                remarks.append(UNCOVERED)
        setting = replace(made, warnings=warned, hint=hint)
        said = "\n".join([*remarks, *warned])
        return ClipTracker(clip.video, clip.info, setting, face.scale, said, facts)

    def _seen(self, follower: FaceFollower) -> list[Sighted]:
        """Some of the frames looked at that show the face, beginning with the first that does."""
        seen, begun, light = list[Sighted](), None, Brightness()
        stride = max(1, self.looked // PREPARATION.learn_from)
        for k, image in enumerate(islice(self.clip.frames(), self.first, None)):
            if k == (PREPARATION.look_at if begun is None else begun + self.looked):
                break
            marks = follower.step(image)
            if marks is None:
                light.add(image)
                continue
            begun = k if begun is None else begun
            if (k - begun) % stride == 0:
                seen.append((image, marks))
        if not seen:
            raise FaceNotFoundError(
                f"no face was found in {len(follower.found)} frames of {self.clip.video}"
                f"{light.fault()}",
                "give a video with a whole frontal face, or the mouth's box in the first frame "
                "with --mouth",
            )
        return seen

    def _in_light_of(self, first: Sighted) -> SpeakerFace:
        """The face in the clip's colours, if such are given, and as exposed as in a first frame."""
        clip, face = self.clip, self.face
        shown = [(first[0], first[1].pixels)]
        exposure = Exposure.of(shown)
        chromatic = in_colour(shown)
        if face.classes.chromatic and not chromatic:
            raise ParameterError(
                f"{colourless(clip.video, exposure)}, but the face was learned in colour",
                "track it without --model, or learn a face from recordings without colour",
            )
        colours = usable(clip.colours, chromatic)
        if colours is not None:
            face = face.coloured(colours, SkinLight.of([first]))
        return replace(face, classes=replace(face.classes, exposure=exposure))


def misfit(fitted: FittedPerson, seen: Sequence[Sighted]) -> float:
    """Median distance of landmarks from a person's head in some frames, in standard deviations.

    A frame in which the head does not fit counts with the most that any fit may have.
    """
    fits = [placed_fit(fitted.textured, fitted.shape, image, marks) for image, marks in seen]
    most = LANDMARK_EVIDENCE.most_misfit
    return float(np.median([most if fit is None else fit.misfit for fit in fits]))


SPEAKER = Model(
    prepare_speaker,
    starts=(LANDMARKS,),
    without=("physics", "person", "poses", "pupil_distance"),
    check=check_speaker_face,
)
"""Found from landmarks, as a stranger is; of the clip, its looks are learned if they are others."""
