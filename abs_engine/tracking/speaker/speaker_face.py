"""The face of a user's own speaker: all that tracking needs to know beforehand, and its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import WIDEST_SIDE, Camera
from abs_engine.core.errors import ModelFormatError
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.scene import Renderer
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.colour import LAYOUT as COLOURS
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance_file import LAYOUT as APPEARANCE
from abs_engine.face.appearance_file import appearance_arrays, appearance_of, has_appearance
from abs_engine.face.head import build_mouth_model
from abs_engine.face.learned_appearance import Appearance
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.upper_face import upper_face_modes
from abs_engine.io.arrays import Layout, real, text, whole
from abs_engine.io.assets import Speaker
from abs_engine.io.npz import read_model, read_some, write_npz
from abs_engine.learn.posture_space import PostureSpace
from abs_engine.learn.training import checksum
from abs_engine.render.cpu import for_threads
from abs_engine.tracking.detection.landmarks import COUNT
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.frame.mouth_visibility import MouthLook
from abs_engine.tracking.head.head_fit import landmark_shape
from abs_engine.tracking.head.head_pose import TexturedHead
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark.landmark_noise import LAYOUT as NOISE
from abs_engine.tracking.landmark.landmark_noise import LandmarkNoise
from abs_engine.tracking.person.scale import Scale, pupil_distance
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.start.person_fit import FittedPerson
from abs_engine.tracking.texture.head_texture import HeadBody, HeadView

FORMAT, VERSION = "abs_engine.speaker_face", 1
_SHAPE = ("mean", "modes", "mixing", "offset", "variance")
_LAYOUT: Layout = {
    "head": text(),
    "neutral": real("V", 3, dtype=np.float32),
    "names": text("P"),
    "lower": real("P"),
    "upper": real("P"),
    "steps": real("P", low=0.0),
    "seen": real("K*", "P"),
    "bias": real(COUNT, 2),
    "deviation": real(COUNT, 3, low=1e-9),
    "shift": real(6),
    "camera_matrix": real(3, 3),
    "camera_distortion": real(8),
    "camera_size": whole(2, low=1, high=WIDEST_SIDE),
    "cheeks": real("cheeks", 3, gaps=True),
    "look": real("L*"),
    "view_gray": whole("W", "height", "width", dtype=np.uint8),
    "view_vertices": real("W", "V", 3),
    "view_rotation": real("W", 3, 3),
    "view_translation": real("W", 3),
    "expression_mean": real("V", 3, dtype=np.float32),
    "expression_modes": real("P", "V", 3, dtype=np.float32),
    "expression_mixing": real("P", "M"),
    "expression_offset": real("M"),
    "expression_variance": real("P"),
    "scale_source": text(),
    "scale_pupils": real(low=1e-9),
    "scale_uncertainty": real(low=0.0),
    **NOISE,
    **{f"colours_{name}": array for name, array in COLOURS.items()},
    **APPEARANCE,
}


@dataclass(frozen=True, eq=False)
class SpeakerFace:
    """A person's head, colours and postures, learned from recordings.

    Parameters
    ----------
    head : str
        Checksum of the head that it is made of; see `learn.training.checksum`.
    neutral : (V, 3) float32, mm
        The person at rest.
    steps : (P,) float64
        How far each moves in 40 ms, standard deviations.
    seen : (K, P) float64
        Postures that were seen; none where anybody's may come.
    bias : (468, 2) float64, mm
        By how much the landmark network sees this person's points off.
    deviation : (468, 3) float64, mm
        How far it errs beside that.
    views : tuple of HeadView
        Frames that show the head's texture.
    shift : (6,) float64
        Correction of poses by the mouth, radians and mm.
    camera : Camera
        Of the views.
    appearance : Appearance or None
        Texture and local appearance by this person's postures, where they were learned.
    """

    head: str
    scale: Scale
    neutral: NDArray[np.float32]
    expression: LinearShape
    posture: ParamSpec
    steps: FloatArray
    seen: FloatArray
    bias: FloatArray
    deviation: FloatArray
    noise: LandmarkNoise
    views: tuple[HeadView, ...]
    shift: FloatArray
    camera: Camera
    classes: ColourClasses
    light: SkinLight
    look: MouthLook | None
    appearance: Appearance | None = None

    @classmethod
    def of(cls, fitted: FittedPerson, scale: Scale, head: str) -> SpeakerFace:
        """Head fitted to frames, the mouth made part of the head."""
        model, textured, shape = fitted.model, fitted.textured, fitted.shape
        moved = np.tensordot(fitted.person, model.person_modes, 1)
        mean = model.whole(fitted.person)
        return cls(
            head, scale, np.asarray(model.head.mean + moved, np.float32),
            replace(model.expression, mean=mean),
            model.posture, np.full(model.n_expression, FRAME_LOOP.step_deviation),
            np.zeros((0, model.n_expression)),
            shape.bias, shape.deviation, textured.noise, _spread_views(textured.views),
            np.zeros(6) if textured.shift is None else textured.shift, textured.camera,
            fitted.classes, fitted.light, fitted.look,
        )  # fmt: skip

    def moving(self, space: PostureSpace) -> SpeakerFace:
        """The same face with postures of its own."""
        return replace(
            self,
            expression=space.expression,
            posture=space.spec,
            steps=space.steps,
            seen=space.seen,
            appearance=None,
        )

    def coloured(self, classes: ColourClasses, light: SkinLight) -> SpeakerFace:
        """The same face in other colours, and in their light; how it looks in them is not known."""
        return replace(self, classes=classes, light=light, look=None)

    def fitted(
        self, speaker: Speaker, correspondence: Correspondence, camera: Camera, renderer: Renderer
    ) -> FittedPerson:
        """The person as frames of a camera are tracked.

        The face is made of the head `speaker`, with its landmarks' correspondence.
        """
        sized = speaker.scaled(self.scale.pupils / pupil_distance(speaker, speaker.vertices))
        texture = speaker.texture()
        model = build_mouth_model(
            sized, self.neutral, texture, free_person=False, expression=self.expression
        )
        plain = landmark_shape(sized, correspondence, self.expression, self.neutral, None)
        shape = replace(plain, bias=self.bias, deviation=self.deviation)
        mean, modes = self.expression.mean, self.expression.modes
        body = HeadBody.of(sized, mean, modes[:0], modes, upper_face_modes(sized))
        body = replace(body, pivot=plain.pivot)
        views = tuple(replace(view, camera=self.camera) for view in self.views)
        textured = TexturedHead(
            body, plain, self.noise, views, camera, for_threads(renderer), self.shift
        )
        return FittedPerson(
            model, np.zeros(0), textured, shape, plain.deviation, self.classes, self.light,
            self.look, self.posture, self.steps, self.seen if len(self.seen) else None,
        )  # fmt: skip

    def arrays(self) -> dict[str, Any]:
        """As they are kept in a file."""
        look = [] if self.look is None else [self.look.inside, self.look.around, self.look.lips]
        own = {
            "head": self.head, "neutral": self.neutral,
            "names": np.array(self.posture.names, np.str_),
            "lower": self.posture.lower, "upper": self.posture.upper, "steps": self.steps,
            "seen": self.seen,
            "bias": self.bias, "deviation": self.deviation, "shift": self.shift,
            "camera_matrix": self.camera.matrix, "camera_distortion": self.camera.distortion,
            "camera_size": np.array(self.camera.size), "cheeks": self.light.cheeks,
            "look": np.array(look, np.float64),
            "view_gray": np.stack([v.gray for v in self.views]),
            "view_vertices": np.stack([v.vertices for v in self.views]).astype(np.float32),
            "view_rotation": np.stack([v.pose.rotation for v in self.views]),
            "view_translation": np.stack([v.pose.translation for v in self.views]),
        }  # fmt: skip
        own |= {f"expression_{name}": getattr(self.expression, name) for name in _SHAPE}
        own |= {f"scale_{name}": value for name, value in asdict(self.scale).items()}
        own |= {f"colours_{name}": value for name, value in self.classes.arrays().items()}
        return own | self.noise.arrays() | appearance_arrays(self.appearance)

    def save(self, path: Path) -> None:
        """Write an ``.npz`` that `load_speaker_face` reads, whole or not at all.

        Raises
        ------
        OutputError
            If it exists or cannot be written.
        """
        write_npz(path, FORMAT, VERSION, self.arrays())


def load_speaker_face(path: Path, speaker: Speaker) -> SpeakerFace:
    """Read what `SpeakerFace.save` wrote; `speaker` is the head that it is made of.

    Raises
    ------
    InputFileError
        If the file is missing or no NPZ archive.
    ModelFormatError
        If it has another format or version, is of another head, or is not complete.
    """

    def made(data: Mapping[str, Any]) -> SpeakerFace:
        if str(data["head"]) != checksum(speaker):
            raise ModelFormatError(
                f"{path} is made of another head",
                "give that head with --speaker, or learn it again",
            )
        return _of_arrays(data, speaker)

    return read_model(path, FORMAT, VERSION, made, "face of a speaker", _LAYOUT)


def has_looks(path: Path) -> bool:
    """Whether an appearance was learned of the face in a file, of which no more is read.

    Raises
    ------
    InputFileError
        If the file is missing or no NPZ archive.
    ModelFormatError
        If it has another format or version.
    """
    return has_appearance(read_some(path, FORMAT, VERSION)[0])


def _of_arrays(data: Mapping[str, Any], speaker: Speaker) -> SpeakerFace:
    """The face that arrays hold; `KeyError` or `ValueError` where they do not fit together."""
    size = tuple(int(side) for side in data["camera_size"])
    camera = Camera(data["camera_matrix"], (size[0], size[1]), data["camera_distortion"])
    poses = zip(data["view_rotation"], data["view_translation"], strict=True)
    seen = zip(data["view_gray"], poses, data["view_vertices"], strict=True)
    if data["neutral"].shape != speaker.vertices.shape or data["view_gray"].shape[1:] != size[::-1]:
        raise ValueError("its shapes do not fit together")
    faces = speaker.faces
    views = tuple(HeadView.of(gray, Pose(*pose), at, faces) for gray, pose, at in seen)
    expression = LinearShape(*(data[f"expression_{name}"] for name in _SHAPE))
    names = tuple(str(name) for name in data["names"])
    scale = Scale(
        str(data["scale_source"]), float(data["scale_pupils"]), float(data["scale_uncertainty"])
    )
    own = {key.removeprefix("colours_"): v for key, v in data.items() if key.startswith("colours_")}
    look = MouthLook(*map(float, data["look"])) if len(data["look"]) else None
    first = np.full(len(names), GENERAL.mode_step)
    spec = ParamSpec(names, ("sd",) * len(names), first, data["lower"], data["upper"])
    return SpeakerFace(
        str(data["head"]), scale, data["neutral"], expression, spec, data["steps"], data["seen"],
        data["bias"], data["deviation"], LandmarkNoise.of_arrays(data), views, data["shift"],
        camera, ColourClasses.of_arrays(own), SkinLight(data["cheeks"]), look,
        appearance_of(data, len(names)),
    )  # fmt: skip


def _spread_views(views: tuple[HeadView, ...]) -> tuple[HeadView, ...]:
    """The first view, and then again and again the one that faces most differently."""
    chosen = [0]
    away = np.full(len(views), np.inf)
    while len(chosen) < min(PREPARATION.speaker_views, len(views)):
        last = views[chosen[-1]].pose
        away = np.minimum(away, [view.pose.angle_to(last) for view in views])
        chosen.append(int(np.argmax(away)))
    return tuple(views[k] for k in chosen)
