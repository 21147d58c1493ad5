"""The file of a talking face: all that tracking with it needs, in one archive."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import AbsEngineError, ModelFormatError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.scene import Scene
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.region import part
from abs_engine.face.appearance.texture import TextureModel
from abs_engine.face.articulated import FaceShape, middle
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.scene_arrays import SCENE_ARRAYS, facets_of_part, scene_arrays
from abs_engine.face.shape.articulatory_model import ArticulatoryModel
from abs_engine.face.talking import Noises, TalkingFace
from abs_engine.face.talking_checks import conditions, same
from abs_engine.io.arrays import flat, part_of
from abs_engine.io.inputs import MOST, name_problem
from abs_engine.io.npz import read_npz, read_some, write_npz

T = TypeVar("T")
FORMAT, VERSION = "abs_engine.talking_face", 1
_REMEDY = "make it again"
_LEARN = "learn it again"
NEUTRAL = "own_neutral"
_LOOKS = ("tex_", "la_")
"""How the names begin of arrays that a shape alone does not have."""
_TWINS = {"tex_cst": "tex_lin", "la_cst": "la_lin"}
"""Constant models, and those that they are usually the constants of."""


@dataclass(frozen=True, eq=False)
class StoredTalker:
    """A talking face and whose it is.

    Parameters
    ----------
    shape : FaceShape
    face : TalkingFace or None
        None where nothing is known of how the shape looks.
    person : str
        Of the speaker's people, or with a `neutral` of its own by whatever name.
    speaker : str
        Checksum of the speaker's head; see `learn.training.checksum`.
    neutral : (V, 3) float32, mm, or None
        At rest, of a person who is none of the speaker's.
    """

    shape: FaceShape
    face: TalkingFace | None
    person: str
    speaker: str
    neutral: NDArray[np.float32] | None = None


def save_talking(
    path: Path,
    face: TalkingFace | FaceShape,
    person: str,
    speaker: str,
    neutral: NDArray[np.float32] | None = None,
) -> None:
    """Write an ``.npz`` that `load_talking` reads, whole or not at all.

    A face, or its shape alone, whose surface and outer parts are parts of its scene, as
    `region.part` makes them; for the rest see `StoredTalker`. Raises `OutputError` if the file
    exists or cannot be written; `ParameterError` if the face does not fit together, holds what is
    not finite, or the person has no name.
    """
    told = _arrays(face) if isinstance(face, TalkingFace) else _shape_arrays(face)
    told |= {"person": person, "speaker": speaker}
    told |= {} if neutral is None else {NEUTRAL: neutral}
    arrays = {name: np.asarray(value) for name, value in told.items()}
    _stored(_Arrays(arrays))  # what cannot be read is not written
    write_npz(path, FORMAT, VERSION, arrays)


def load_talking(path: Path) -> StoredTalker:
    """Read what `save_talking` wrote; everything comes back bit for bit.

    Raises `InputFileError` if the file is missing or no NPZ archive; `ModelFormatError` if it has
    another format or version, lacks something, holds what is not finite, or does not fit together.
    """
    data = _Arrays(read_npz(Path(path), FORMAT, VERSION))
    try:
        return _stored(data)
    except AbsEngineError as error:
        why: Exception = error
        problem = error.problem
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        why, problem = error, " ".join(str(error).split())
    raise ModelFormatError(f"{path} is not a complete talking face: {problem}", _REMEDY) from why


def read_whose(path: Path) -> tuple[str, bool]:
    """Person of a talking face, and whether it was made with pictures; no more of it is read.

    Raises `InputFileError` if the file is missing or no NPZ archive, `ModelFormatError` if it has
    another format or version.
    """
    names, told = read_some(path, FORMAT, VERSION, ("person",))
    return str(told.get("person", "")), _pictured(names)


def _pictured(names: Iterable[str]) -> bool:
    """Whether a face has arrays of how it looks."""
    return any(name.startswith(_LOOKS) for name in names)


class _Arrays(dict[str, NDArray[np.generic]]):
    """Arrays of a file, or of a part of it; one that is missing is named."""

    def __init__(self, arrays: Mapping[str, NDArray[np.generic]], within: str = "") -> None:
        super().__init__(arrays)
        self._within = within

    def __missing__(self, name: str) -> NDArray[np.generic]:
        raise ParameterError(f"there is no array '{self._within}{name}'", _REMEDY)

    def part(self, name: str) -> _Arrays:
        """Entries that begin with `name` and a dot, without that prefix."""
        return _Arrays(part_of(self, name), f"{self._within}{name}.")

    def take(self, name: str, kind: str) -> NDArray[Any]:
        """An array as it is, of a kind of number as NumPy's `dtype.kind` has it."""
        values = self[name]
        if values.dtype.kind != kind:  # NumPy would round it, or read text
            raise ParameterError(f"'{self._within}{name}' holds {values.dtype}", _REMEDY)
        return values

    def check(self, made: Mapping[str, Any]) -> None:
        """Raise `ParameterError` unless what was made of the arrays has their kinds and shapes."""
        for name, value in made.items():
            wanted = np.asarray(value)
            shape = self.take(name, wanted.dtype.kind).shape
            if shape != wanted.shape:
                raise ParameterError(f"'{self._within}{name}' has shape {shape}", _REMEDY)


def _arrays(face: TalkingFace) -> dict[str, Any]:
    """All that is in the file but whose face it is."""
    own: dict[str, Any] = {"la_scale": float(face.la_scale)}
    own |= {} if face.noises is None else asdict(face.noises)
    parts = {"tex_lin": face.tex_lin.arrays(), "la_lin": face.la_lin.arrays()}
    for name, linear in _TWINS.items():
        twin, known = getattr(face, name).arrays(), getattr(face, linear).constant().arrays()
        own[f"{name}_is_constant_{linear}"] = made = same(twin, known)
        parts |= {} if made else {name: twin}
    return _shape_arrays(face.shape) | own | flat(parts)


def _shape_arrays(shape: FaceShape) -> dict[str, Any]:
    """All that is in the file of a shape."""
    spec, penalty = shape.spec, shape.penalty
    own = {
        "vertices": shape.vertices, "lips": shape.lips, "marks": shape.marks,
        "neutral": shape.neutral,
        "regions": np.array([name or "" for name in shape.regions], np.str_),
        "surface": facets_of_part(shape.scene, shape.surface),
        "outer": facets_of_part(shape.scene, shape.outer),
    }  # fmt: skip
    parts: dict[str, Mapping[str, Any]] = {
        "model": shape.model.arrays(),
        "frame": _frame_arrays(shape.frame),
        "scene": scene_arrays(shape.scene),
        "spec": {
            "names": np.array(spec.names, np.str_), "units": np.array(spec.units, np.str_),
            "scale": spec.scale, "lower": spec.lower, "upper": spec.upper,
        },
        "penalty": {
            "mean": penalty.mean, "whitener": penalty.whitener,
            "softness": penalty.softness, "strength": penalty.strength,
        },
        "rings": shape.rings,
    }  # fmt: skip
    return own | flat(parts)


def _stored(data: _Arrays) -> StoredTalker:
    """Content of the arrays; `ParameterError` where that is not whole."""
    for name, values in data.items():
        if values.dtype.kind == "f" and not (np.abs(values) <= MOST).all():
            raise ParameterError(f"'{name}' holds what is not finite", _LEARN)
    data.check({"person": "", "speaker": ""})
    person, speaker = (str(data[name]) for name in ("person", "speaker"))
    shape, problem = _shape(data), name_problem("person", person)
    face = _face(data, shape) if _pictured(data) else None
    neutral = data.take(NEUTRAL, "f") if NEUTRAL in data else None
    met = conditions(shape, face, neutral)
    wrong = [problem] if problem else [what for what, fits in met.items() if not fits]
    if wrong:
        raise ParameterError(wrong[0], _LEARN)
    return StoredTalker(shape, face, person, speaker, neutral)


def _face(data: _Arrays, shape: FaceShape) -> TalkingFace:
    tex_lin = _model(data.part("tex_lin"), TextureModel.from_arrays, TextureModel.arrays)
    la_lin = _model(data.part("la_lin"), LocalModel.from_arrays, LocalModel.arrays)
    tex_cst, la_cst = tex_lin.constant(), la_lin.constant()
    data.check({f"{name}_is_constant_{linear}": True for name, linear in _TWINS.items()})
    if not data["tex_cst_is_constant_tex_lin"]:
        tex_cst = _model(data.part("tex_cst"), TextureModel.from_arrays, TextureModel.arrays)
    if not data["la_cst_is_constant_la_lin"]:
        la_cst = _model(data.part("la_cst"), LocalModel.from_arrays, LocalModel.arrays)
    scale = float(data.take("la_scale", "f"))
    names = [f.name for f in fields(Noises)]
    measured = any(name in data for name in names)
    noises = Noises(*(float(data.take(n, "f")) for n in names)) if measured else None
    return TalkingFace(shape, tex_lin, tex_cst, la_lin, la_cst, scale, noises)


def _shape(data: _Arrays) -> FaceShape:
    scene = _model(data.part("scene"), _scene, scene_arrays)
    rings = data.part("rings")
    surface, _ = part(scene, data.take("surface", "b"))
    outer, kept = part(scene, data.take("outer", "b"))
    vertices, lips = data.take("vertices", "i"), data.take("lips", "i")
    return FaceShape(
        scene, surface, outer, kept, data.take("marks", "i"), _spec(data.part("spec")),
        middle(scene, vertices.take(lips, mode="clip")),  # wrong ones are refused later
        _model(data.part("model"), ArticulatoryModel.from_arrays, ArticulatoryModel.arrays),
        _model(data.part("frame"), _frame, _frame_arrays), vertices, lips,
        _penalty(data.part("penalty")),
        data.take("neutral", "f"), {name: rings.take(name, "i") for name in rings},
        tuple(str(name) or None for name in data.take("regions", "U")),
    )  # fmt: skip


def _model(
    data: _Arrays,
    make: Callable[[Mapping[str, NDArray[np.generic]]], T],
    arrays: Callable[[T], Mapping[str, Any]],
) -> T:
    """A part of the face from its arrays, which are what it would be written as."""
    made = make(data)
    data.check(arrays(made))
    return made


def _frame_arrays(frame: Pose) -> dict[str, Any]:
    return {"rotation": frame.rotation, "translation": frame.translation}


def _frame(data: Mapping[str, NDArray[Any]]) -> Pose:
    return Pose(data["rotation"], data["translation"])


def _scene(data: Mapping[str, NDArray[Any]]) -> Scene:
    own: dict[str, Any] = {name: data[name] for name in SCENE_ARRAYS}
    layers = data["texture_modes"]
    own |= {"cull": bool(own["cull"]), "texture_modes": layers if layers.size else None}
    return Scene(**own)


def _spec(data: _Arrays) -> ParamSpec:
    names, units = (tuple(map(str, data.take(name, "U"))) for name in ("names", "units"))
    scale, lower, upper = (data.take(name, "f") for name in ("scale", "lower", "upper"))
    return ParamSpec(names, units, scale, lower, upper)


def _penalty(data: _Arrays) -> ImprobablePenalty:
    softness, strength = (float(data.take(name, "f")) for name in ("softness", "strength"))
    return ImprobablePenalty(data.take("mean", "f"), data.take("whitener", "f"), softness, strength)
