"""One person's face, learned from several recordings of them that were tracked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import closed_after, one_thread
from abs_engine.core.words import counted
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.video import probe, read_frames
from abs_engine.learn.choice import choose_points
from abs_engine.learn.posture_space import PostureSpace, learn_postures
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.training import checksum
from abs_engine.tracking.detection.face_choice import FOLLOWS
from abs_engine.tracking.detection.shot_cuts import ASSUMED
from abs_engine.tracking.head.head_fit import AverageHead
from abs_engine.tracking.landmark.rendered_landmarks import correspondence_of
from abs_engine.tracking.loop import track
from abs_engine.tracking.options import Clip, Leaves, TrackOptions
from abs_engine.tracking.person.expected_person import anybody
from abs_engine.tracking.person.scale import pupil_scale
from abs_engine.tracking.run import prepare, silent
from abs_engine.tracking.runs.record import Record
from abs_engine.tracking.runs.recorder import Recorder
from abs_engine.tracking.runs.recordings import Recording, check_variety, check_videos
from abs_engine.tracking.runs.same_person import check_same
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.speaker.recorded_frames import camera_used, pictures, turned
from abs_engine.tracking.speaker.speaker_face import SpeakerFace
from abs_engine.tracking.speaker.speaker_looks import can_look, with_appearance
from abs_engine.tracking.speaker.speakers import SpeakerClip
from abs_engine.tracking.start.person_fit import fit_person

Tell = Callable[[str], None]

_SPOKEN = {"lar1": " (larynx)"}
_MOST_DIGITS = 6  # of a share in percent
_OWN = TrackOptions(terms=("colour",), driver="newton")


@dataclass(frozen=True, eq=False)
class Learned:
    """A speaker's face, and how it was learned.

    Parameters
    ----------
    frames : int
        That postures were learned from.
    explained : tuple of float
        How much of the left-out frames' pictures each round's face explains, 0 to 1.
    kept : int
        Number of the round whose face it is, from 1.
    """

    face: SpeakerFace
    space: PostureSpace
    frames: int
    explained: tuple[float, ...]
    kept: int

    def lines(self) -> list[str]:
        """Lines that a user should know."""
        shares = ", ".join(
            f"{name}{_SPOKEN.get(name, '')} {share:.1%}"
            for name, share in zip(
                self.face.posture.names, self.space.expression.variance, strict=True
            )
        )
        told = [
            f"postures: {self.frames} frames; share of the variance: {shares}"
            if self.space.own
            else f"postures: generic, as {self._lack}"
        ]
        if self.space.left_out:
            told.append(f"left out, below the noise: {', '.join(self.space.left_out)}")
        told.append(
            f"share of the picture that the face explains in frames left out: {self._rounds}; "
            f"kept: round {self.kept}"
        )
        return [*told, self._appearance_line]

    @property
    def _rounds(self) -> str:
        """Rounds and how much the face of each explains, with as many digits as they differ in."""
        for digits in range(1, _MOST_DIGITS):
            said = [f"{share:.{digits}%}" for share in self.explained]
            if len(set(said)) == len(said):
                break
        return ", ".join(f"{share} in round {number}" for number, share in enumerate(said, 1))

    @property
    def _lack(self) -> str:
        """The reason that postures are not the speaker's own."""
        if self.frames < LEARNING.least_frames:
            return (
                f"only {self.frames} frames show the mouth well; the speaker's own need "
                f"{LEARNING.least_frames}"
            )
        return "the speaker's own explain left-out frames clearly worse"

    @property
    def _appearance_line(self) -> str:
        own = self.face.appearance
        if own is None:
            return "no texture or local appearance: the head has no texture coordinates"
        return (
            f"appearance that depends on the postures: texture, {own.texture.explained:.0%} of its "
            f"variance explained; local, {len(own.local)} points, {own.local.explained:.0%}"
        )


@dataclass(frozen=True, eq=False)
class Learner:
    """Values that stay the same while a speaker's face is learned.

    Parameters
    ----------
    speaker : Speaker
        The head that the face is made of.
    tell : callable
        Called with what is begun, in a few words.
    """

    speaker: Speaker
    average: AverageHead
    camera: Camera
    renderer: Renderer
    tell: Tell

    def head(self, recordings: Sequence[Recording]) -> SpeakerFace:
        """One head and one set of colours, fitted to frames of all recordings together.

        The head is fitted to fewer frames, those in which it faces most differently; the mouth and
        colours to frames spread over its postures.
        """
        each = max(PREPARATION.speaker_least_each, PREPARATION.speaker_most // len(recordings))
        chosen = [found for one in recordings for found in pictures(one, list(one.spread(each)))]
        if not chosen:
            raise FaceNotFoundError("no frame shows the mouth well", "give recordings of a face")
        few = max(1, round(PREPARATION.speaker_turned / len(recordings)))
        facing = [found for one in recordings for found in turned(one, few)]
        self.tell(
            f"fitting one head to {len(facing)} frames, its mouth and colours to {len(chosen)}, of "
            f"{counted(len(recordings), 'recording')}"
        )
        fitted = fit_person(self.average, chosen, self.camera, self.renderer, None, silent, facing)
        return SpeakerFace.of(fitted, self.average.scale, checksum(self.speaker))

    def followed(self, recording: Recording, face: SpeakerFace, first: int = 0) -> Record:
        """A recording tracked with a face, from a frame on."""
        video, choice = recording.video, recording.choice_from(first)
        clip = Clip(video, probe(video), self.camera, None)
        made = SpeakerClip(clip, choice, face, self.speaker, first).tracker(
            _OWN, Leaves.of(_OWN), self.renderer
        )
        recorder = Recorder(made.setting)
        images: Iterable[Image] = islice(read_frames(video), first, None)
        with one_thread(), closed_after(track(made.setting, images)) as results:
            for _, result in results:
                recorder.add(result)
        return recorder.record()

    def tracked_again(
        self, recordings: Sequence[Recording], head: SpeakerFace
    ) -> Iterator[Recording]:
        """The recordings tracked with one head."""
        for number, one in enumerate(recordings, 1):
            self.tell(f"tracking recording {number} of {len(recordings)} with it")
            yield one.again(self.followed(one, head), head.scale)

    def round(
        self, recordings: Sequence[Recording]
    ) -> tuple[SpeakerFace, PostureSpace, list[Recording], float]:
        """A face of what was tracked, that tracked again with its head, and what it explains.

        The share is that of the frames that were left out. Where the speaker's own postures explain
        them clearly worse than anybody's, or there are none, the face moves by anybody's.
        """
        head = self.head(recordings)
        again = list(self.tracked_again(recordings, head))
        check_variety(again)
        self.tell("learning the postures")
        space = self.postures(head, again)
        usual = self.explained(again, head)
        if space is not None:
            face = head.moving(space)
            own = self.explained(again, face)
            if own >= usual - LEARNING.worse:
                return face, space, again, own
        space = PostureSpace.of_anybody(head.expression, head.posture, head.steps)
        return head, space, again, usual

    def postures(self, head: SpeakerFace, recordings: Sequence[Recording]) -> PostureSpace | None:
        """The speaker's own postures; None where too few frames show them, or all are noise."""
        if _usable(recordings) < LEARNING.least_frames:
            return None
        clips = [np.where(r.usable[:, None], r.postures, np.nan) for r in recordings]
        rates = [float(r.run["rate"]) for r in recordings]
        space = learn_postures(head.expression, choose_points(self.speaker), clips, rates)
        usual = np.where(np.isfinite(space.steps), space.steps, FRAME_LOOP.step_deviation)
        return replace(space, steps=usual) if len(space.spec) else None

    def looks(self, learned: Learned, recordings: Sequence[Recording]) -> Learned:
        """The same with texture and local appearance, from recordings of the round it is of."""
        if not can_look(self.speaker):
            return learned
        self.tell("learning texture and local appearance")
        given = self.speaker, learned.space, recordings, self.camera, self.renderer
        return replace(learned, face=with_appearance(learned.face, *given))

    def explained(self, recordings: Sequence[Recording], face: SpeakerFace) -> float:
        """Mean share of the picture that a face explains in frames left out; 0 where it is lost."""
        each = []
        for number, one in enumerate(recordings, 1):
            self.tell(f"tracking frames left out of recording {number} of {len(recordings)}")
            try:
                scores = self.followed(one, face, one.first_left_out).arrays["score"]
            except FaceNotFoundError:
                scores = np.zeros(one.count - one.first_left_out)
            each.append(np.nan_to_num(np.asarray(scores, np.float64)))
        return float(np.mean(np.concatenate(each)))


def learn_speaker(
    recordings: Sequence[Recording],
    renderer: Renderer,
    options: TrackOptions = _OWN,
    rounds: int = 2,
    tell: Tell | None = None,
) -> Learned:
    """One head, colours and postures of a person, from recordings that were tracked.

    Each round fits the head to frames of all recordings, tracks them with it, and learns the
    postures; the next begins from what that found. A later one is kept if it explains the frames
    that were left out better. Of the options `camera`, `speaker` and `pupil_distance` count. `tell`
    is called with what is begun, in a few words.

    Raises
    ------
    OtherPersonError
        If a recording shows another person.
    TooFewFramesError
        If they show too little: no open mouth, or no closed one.
    ParameterError
        If the videos are of several sizes, or one comes twice, or a camera is another's.
    """
    size = check_videos([(one.path, one.video) for one in recordings])
    speaker = load_speaker(options.speaker)
    check_same(recordings, speaker)
    check_variety(recordings)
    camera = camera_used(recordings, options.camera, size)
    expected = anybody(speaker, correspondence_of(speaker, renderer))
    average = AverageHead.of(*expected, pupil_scale(options.pupil_distance))
    learner = Learner(speaker, average, camera, renderer, tell or silent)
    learned: list[Learned] = []
    tracked_then: list[Sequence[Recording]] = []
    for number in range(1, rounds + 1):
        face, space, recordings, share = learner.round(recordings)
        explained = (*(one.explained[-1] for one in learned), share)
        learned.append(Learned(face, space, _usable(recordings), explained, number))
        tracked_then.append(recordings)
    best = int(np.argmax(learned[-1].explained))
    done = learner.looks(learned[best], tracked_then[best])
    return replace(done, explained=learned[-1].explained)


def tracked(video: Path, renderer: Renderer, options: TrackOptions) -> Recording:
    """A video tracked as a stranger's, to learn from."""
    tracker = prepare(video, renderer, options, silent)
    recorder = Recorder(tracker.setting)
    with closed_after(tracker.results()) as results:
        for image, result in results:
            recorder.add(result, image)
    record, remarks = recorder.record(), tracker.remarks.splitlines()
    told = [*remarks, *(f"warning: {w}" for w in record.summary["warnings"] if w not in remarks)]
    said = [line for line in told if ASSUMED not in line]  # `Recording.of` warns of all shots
    several = [f"{line}: give its run in place of the video" for line in said if FOLLOWS in line]
    others = [line for line in said if FOLLOWS not in line]
    recording = Recording.of(video, video, record, tracker.scale)
    return replace(recording, remarks=(*several, *recording.remarks, *others))


def _usable(recordings: Sequence[Recording]) -> int:
    """Number of frames of all recordings that are learned from."""
    return int(sum(one.usable.sum() for one in recordings))
