"""Options of tracking a clip, as a user chooses them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.registry import DRIVERS
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.fit.terms import TermKind, check_leaves, term_kinds
from abs_engine.io.video import VideoInfo, read_frames
from abs_engine.optimise.drivers import Driver
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.frame.mouth_landmarks import BOTH
from abs_engine.tracking.loop import track
from abs_engine.tracking.option_kinds import check_kinds, kept
from abs_engine.tracking.person.scale import Scale
from abs_engine.tracking.results.frame_journal import FrameJournal

LANDMARKS, BLOBS = STARTS = "landmarks", "blobs"


@dataclass(frozen=True)
class TrackOptions:
    """Options that a user may choose.

    Parameters
    ----------
    person : str or None
        A person of the speaker whose head is known; by default the average head, whose mouth is
        fitted to the clip.
    mouth : tuple of float or None
        Left, top, width and height of the mouth in the first frame, pixels.
    camera : Camera or None
        Its calibration; by default an ideal camera of a usual field of view.
    speaker : Path or None
        A `head.npz`; by default the bundled head.
    colours : Path or None
        The `colours.npz` of another run; by default colours are learned from the clip.
    physics : Path or None
        Lips that `train` learned from dots; by default the mouth moves in components of face units.
    poses : Path or None
        Head poses of all frames (see `tracking.runs.poses_file`); by default they are estimated.
        With a known head they are taken as they are, with the average head as a first guess.
    start : str or None
        "landmarks", the default: a network's landmarks place the whole head, and are one soft term
        in each frame; "blobs": as in the papers, by colour about a face that was detected. A known
        head is found by its texture, and given poses place it.
    face : int or None
        Which face, where there are several, counted from 1, the largest first.
    pupil_distance : float or None
        Of the person, mm: it sets the scale.
    evidence : str
        What counts: "both", or "rendering" or "landmarks" alone, to see what each adds.
    model : str or None
        What is tracked, of `core.registry.MODELS`, or the file of a model; by default a head.
    model_file : Path or None
        Its file, once `model` says its kind: see `presets.resolved`.
    terms : tuple of str or None
        The evidence that is rendered and compared, of `core.registry.TERMS`; by default colour,
        with shading for a head or a speaker's own face, unless an unknown head is found by blobs.
    driver : str or None
        What moves the parameters, of `core.registry.DRIVERS`; by default "newton" for a head or a
        speaker's own face seen by colour, else "simplex".
    preset : str or None
        A choice of all of these together, of `core.registry.PRESETS`.
    worn : bool
        Whether the camera is worn before the mouth: the lower face alone, the head still.
    smooth : str or None
        A filter of the measures beside those that are as they were found; see
        `smoothing.Smoothing.named`.
    """

    person: str | None = None
    mouth: tuple[float, float, float, float] | None = None
    camera: Camera | None = None
    speaker: Path | None = None
    colours: Path | None = None
    physics: Path | None = None
    poses: Path | None = None
    start: str | None = None
    face: int | None = None
    pupil_distance: float | None = None
    evidence: str = BOTH
    model: str | None = None
    model_file: Path | None = None
    terms: tuple[str, ...] | None = None
    driver: str | None = None
    preset: str | None = None
    worn: bool = False
    smooth: str | None = None

    def __post_init__(self) -> None:
        """Take what is given as it is kept, see `option_kinds.kept`, and None for the default.

        Raises
        ------
        ParameterError
            If an option is of another kind, a name is empty, or a length too large for a number.
        """
        check_kinds(vars(self))
        for one in fields(self):
            given = getattr(self, one.name)
            object.__setattr__(
                self, one.name, one.default if given is None else kept(one.name, given)
            )

    @property
    def from_landmarks(self) -> bool:
        """Whether the person's head is fitted to landmarks: none is known."""
        return self.start == LANDMARKS and self.person is None


@dataclass(frozen=True, eq=False)
class Clip:
    """A video as it is tracked.

    Parameters
    ----------
    video : Path
    info : VideoInfo
    camera : Camera
    colours : ColourClasses or None
        Those learned before.
    shown : tuple of (H, W, 3) uint8 RGB
        Frames of a camera that are learned from; those that are tracked come after them.
    """

    video: Path
    info: VideoInfo
    camera: Camera
    colours: ColourClasses | None
    shown: tuple[Image, ...] = ()

    def frames(self) -> Iterable[Image]:
        """Frames that are learned from."""
        return self.shown or read_frames(self.video)

    def first(self, found: Sequence[Landmarks | None]) -> Sequence[Landmarks | None]:
        """Landmarks found in what was learned from, as far as they are of frames to be tracked."""
        return () if self.shown else found


COMPARED = {
    "head": ("colour", "shading"),
    "shell": ("colour",),
    "talking": ("colour", "texture", "local"),
    "speaker": ("colour", "texture", "local", "shading"),
    "worn": ("opening",),
}
"""Evidence that the face of each of the engine's models has, or can have, an appearance for."""


@dataclass(frozen=True, eq=False)
class Leaves:
    """The evidence and the driver that were chosen.

    Parameters
    ----------
    kinds : dict of str to TermKind
    driver : Driver
    name : str
        Of the driver.
    """

    kinds: dict[str, TermKind]
    driver: Driver
    name: str

    @classmethod
    def of(cls, options: TrackOptions) -> Leaves:
        """Those of some options.

        Raises
        ------
        ParameterError
            If there is no evidence or driver of such a name.
        PluginError
            If one cannot be imported.
        """
        name = options.driver or "simplex"
        driver: Driver = DRIVERS.get(name)
        return cls(term_kinds(options.terms or ()), driver, name)

    def without(self, name: str) -> Leaves:
        """The same without evidence of some name."""
        return replace(self, kinds={one: kind for one, kind in self.kinds.items() if one != name})

    def check(self, model: str) -> None:
        """Refuse what does not go together; see `fit.terms.check_leaves`.

        What a plugin's model has an appearance for is not known before it has made one.
        """
        has, others = COMPARED.get(model), model != "worn"  # no other model tracks a close-up
        check_leaves(model, has, self.kinds, self.driver, self.name, others)


@dataclass(frozen=True, eq=False)
class ClipTracker:
    """A clip made ready: iterate `results` for the frames.

    Parameters
    ----------
    video : Path
    info : VideoInfo
    setting : ClipSetting
    scale : Scale
        What millimetres rest on.
    remarks : str
        What is said of the video, of several faces, of cuts, or of a box in which no face was seen;
        else empty.
    facts : dict
        What else `run.json` says of how it was prepared, JSON values.
    """

    video: Path
    info: VideoInfo
    setting: ClipSetting
    scale: Scale
    remarks: str = ""
    facts: dict[str, Any] = field(default_factory=dict)

    def results(self, journal: FrameJournal | None = None) -> Iterator[tuple[Image, FrameResult]]:
        """Each frame with what was found in it; those of a journal were found before."""
        return track(self.setting, read_frames(self.video), journal=journal)


Tell = Callable[[str], None]
