"""Settings of all stages of tracking, gathered: the numbers that steer results.

Each stage keeps its own in a frozen value beside its code, and reads them from there. They are
values of the engine, not options of a user: none is changed while it runs. What was measured of
each stands in its docstring; what was not, says so.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from abs_engine.compare.settings import COMPARISON, CompareSettings
from abs_engine.core.settings import GENERAL, GeneralSettings
from abs_engine.face.settings.appearance import (
    APPEARANCE,
    SHADING,
    AppearanceSettings,
    ShadingSettings,
)
from abs_engine.face.settings.colour import COLOURS, ColourSettings
from abs_engine.face.settings.shape import SHAPE, ShapeSettings
from abs_engine.face.settings.tint import TINT, TintSettings
from abs_engine.fit.settings import (
    BELIEF,
    HEAD_FIT,
    SHELL_FIT,
    TALKING_FIT,
    BeliefSettings,
    HeadFitSettings,
    ShellFitSettings,
    TalkingFitSettings,
)
from abs_engine.optimise.settings import SOLVING, SolverSettings
from abs_engine.tracking.settings.blobs import BLOB_START, BlobSettings
from abs_engine.tracking.settings.detection import DETECTION, DetectionSettings
from abs_engine.tracking.settings.doubts import DOUBTS, DoubtSettings
from abs_engine.tracking.settings.frames import FRAME_LOOP, FrameSettings
from abs_engine.tracking.settings.head import HEAD_POSE, HeadSettings
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE, LandmarkSettings
from abs_engine.tracking.settings.outline import OUTLINE, OutlineSettings
from abs_engine.tracking.settings.preparation import PREPARATION, PreparationSettings
from abs_engine.tracking.settings.registration import REGISTRATION, RegistrationSettings
from abs_engine.tracking.settings.worn import CLOSE_UP, WornSettings


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of every stage.

    Attributes
    ----------
    general : GeneralSettings
        What all of them share.
    detection : DetectionSettings
        Finding a face, and following it.
    landmarks : LandmarkSettings
        Landmarks as evidence.
    head : HeadSettings
        The head's poses and shape, by landmarks, pupils and texture.
    outline : OutlineSettings
        The head's outline.
    registration : RegistrationSettings
        Heads that are followed by their texture.
    blobs : BlobSettings
        A start without landmarks.
    preparation : PreparationSettings
        Whose mouth it is, and where.
    shape : ShapeSettings
        How people differ, and how mouths move.
    colours : ColourSettings
        Colour classes.
    tint : TintSettings
        Pictures in one strong tint.
    appearance : AppearanceSettings
        Textures and local appearance.
    shading : ShadingSettings
        Shaded skin, where it is compared.
    comparison : CompareSettings
        Terms and priors.
    head_fit, shell_fit, talking_fit : HeadFitSettings, ShellFitSettings, TalkingFitSettings
        The fit of a frame, by face.
    solvers : SolverSettings
        When they stop, and how far they step.
    frames : FrameSettings
        The loop over frames.
    doubts : DoubtSettings
        What a run warns of, and which recordings are of one speaker.
    belief : BeliefSettings
        Standard deviations.
    worn : WornSettings
        Close-ups by a camera worn before the mouth.
    """

    general: GeneralSettings = GENERAL
    detection: DetectionSettings = DETECTION
    landmarks: LandmarkSettings = LANDMARK_EVIDENCE
    head: HeadSettings = HEAD_POSE
    outline: OutlineSettings = OUTLINE
    registration: RegistrationSettings = REGISTRATION
    blobs: BlobSettings = BLOB_START
    preparation: PreparationSettings = PREPARATION
    shape: ShapeSettings = SHAPE
    colours: ColourSettings = COLOURS
    tint: TintSettings = TINT
    appearance: AppearanceSettings = APPEARANCE
    shading: ShadingSettings = SHADING
    comparison: CompareSettings = COMPARISON
    head_fit: HeadFitSettings = HEAD_FIT
    shell_fit: ShellFitSettings = SHELL_FIT
    talking_fit: TalkingFitSettings = TALKING_FIT
    solvers: SolverSettings = SOLVING
    frames: FrameSettings = FRAME_LOOP
    doubts: DoubtSettings = DOUBTS
    belief: BeliefSettings = BELIEF
    worn: WornSettings = CLOSE_UP

    def values(self) -> dict[str, dict[str, Any]]:
        """The values by stage and name, as JSON writes them."""
        return asdict(self)


SETTINGS = Settings()
