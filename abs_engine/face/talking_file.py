"""The file of a talking face: all that tracking with it needs, in one archive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
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
from abs_engine.face.articulated import FaceShape
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.shape.articulatory_model import ArticulatoryModel
from abs_engine.face.talking import TalkingFace
from abs_engine.face.talking_checks import conditions, same
from abs_engine.io.inputs import MOST, name_problem
from abs_engine.io.npz import read_npz, write_npz

T = TypeVar("T")
FORMAT, VERSION = "abs_engine.talking_face", 1
_REMEDY = "make it again"
_LEARN = "learn it again"
_SCENE = ("mean", "modes", "faces", "uv", "facet_class", "texture", "cull")
_TWINS = {"tex_cst": "tex_lin", "la_cst": "la_lin"}
"""Constant models, and those that they are usually the constants of."""


@dataclass(frozen=True, eq=False)
class StoredTalker:
    """A talking face and whose it is.

    Parameters
    ----------
    face : TalkingFace
    person : str
        Of the speaker's people.
    speaker : str
        Checksum of the speaker's head; see `learn.training.checksum`.
    """

    face: TalkingFace
    person: str
    speaker: str


def save_talking(path: Path, face: TalkingFace, person: str, speaker: str) -> None:
    """Write an ``.npz`` that `load_talking` reads, whole or not at all.

    Parameters
    ----------
    path : Path
        Must not exist.
    face : TalkingFace
        Its surface and outer parts are parts of its scene, as `region.part` makes them.
    person, speaker : str
        See `StoredTalker`.

    Raises
    ------
    OutputError
        If it exists or cannot be written.
    ParameterError
        If the face does not fit together, holds what is not finite, or the person has no name.
    """
    told = _arrays(face) | {"person": person, "speaker": speaker}
    arrays = {name: np.asarray(value) for name, value in told.items()}
    _stored(_Arrays(arrays))  # what cannot be read is not written
    write_npz(path, FORMAT, VERSION, arrays)


def load_talking(path: Path) -> StoredTalker:
    """Read what `save_talking` wrote; everything comes back bit for bit.

    Raises
    ------
    InputFileError
        If the file is missing or no NPZ archive.
    ModelFormatError
        If it has another format or version, lacks something, holds what is not finite, or does
        not fit together.
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


class _Arrays(dict[str, NDArray[np.generic]]):
    """Arrays of a file, or of a part of it; one that is missing is named."""

    def __init__(self, arrays: Mapping[str, NDArray[np.generic]], within: str = "") -> None:
        super().__init__(arrays)
        self._within = within

    def __missing__(self, name: str) -> NDArray[np.generic]:
        raise ParameterError(f"there is no array '{self._within}{name}'", _REMEDY)

    def part(self, name: str) -> _Arrays:
        """Entries that begin with `name` and a dot, without that prefix."""
        start = f"{name}."
        own = {key.removeprefix(start): at for key, at in self.items() if key.startswith(start)}
        return _Arrays(own, self._within + start)

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
    shape, spec, penalty = face.shape, face.shape.spec, face.shape.penalty
    own = {
        "vertices": shape.vertices, "lips": shape.lips, "marks": shape.marks,
        "neutral": shape.neutral, "la_scale": float(face.la_scale),
        "regions": np.array([name or "" for name in shape.regions], np.str_),
        "surface": _facets(shape.scene, shape.surface),
        "outer": _facets(shape.scene, shape.outer),
    }  # fmt: skip
    parts: dict[str, Mapping[str, Any]] = {
        "model": shape.model.arrays(),
        "frame": _frame_arrays(shape.frame),
        "scene": _scene_arrays(shape.scene),
        "spec": {
            "names": np.array(spec.names, np.str_), "units": np.array(spec.units, np.str_),
            "scale": spec.scale, "lower": spec.lower, "upper": spec.upper,
        },
        "penalty": {
            "mean": penalty.mean, "whitener": penalty.whitener,
            "softness": penalty.softness, "strength": penalty.strength,
        },
        "rings": shape.rings, "tex_lin": face.tex_lin.arrays(), "la_lin": face.la_lin.arrays(),
    }  # fmt: skip
    for name, linear in _TWINS.items():
        twin, known = getattr(face, name).arrays(), getattr(face, linear).constant().arrays()
        own[f"{name}_is_constant_{linear}"] = made = same(twin, known)
        parts |= {} if made else {name: twin}
    return own | {f"{p}.{name}": v for p, values in parts.items() for name, v in values.items()}


def _stored(data: _Arrays) -> StoredTalker:
    """Content of the arrays; `ParameterError` where that is not whole."""
    for name, values in data.items():
        if values.dtype.kind == "f" and not (np.abs(values) <= MOST).all():
            raise ParameterError(f"'{name}' holds what is not finite", _LEARN)
    data.check({"person": "", "speaker": ""})
    person, speaker = (str(data[name]) for name in ("person", "speaker"))
    face, problem = _face(data), name_problem("person", person)
    wrong = [problem] if problem else [what for what, fits in conditions(face).items() if not fits]
    if wrong:
        raise ParameterError(wrong[0], _LEARN)
    return StoredTalker(face, person, speaker)


def _face(data: _Arrays) -> TalkingFace:
    tex_lin = _model(data.part("tex_lin"), TextureModel.from_arrays, TextureModel.arrays)
    la_lin = _model(data.part("la_lin"), LocalModel.from_arrays, LocalModel.arrays)
    tex_cst, la_cst = tex_lin.constant(), la_lin.constant()
    data.check({f"{name}_is_constant_{linear}": True for name, linear in _TWINS.items()})
    if not data["tex_cst_is_constant_tex_lin"]:
        tex_cst = _model(data.part("tex_cst"), TextureModel.from_arrays, TextureModel.arrays)
    if not data["la_cst_is_constant_la_lin"]:
        la_cst = _model(data.part("la_cst"), LocalModel.from_arrays, LocalModel.arrays)
    scale = float(data.take("la_scale", "f"))
    return TalkingFace(_shape(data), tex_lin, tex_cst, la_lin, la_cst, scale)


def _shape(data: _Arrays) -> FaceShape:
    scene = _model(data.part("scene"), _scene, _scene_arrays)
    rings = data.part("rings")
    surface, _ = part(scene, data.take("surface", "b"))
    outer, kept = part(scene, data.take("outer", "b"))
    return FaceShape(
        _model(data.part("model"), ArticulatoryModel.from_arrays, ArticulatoryModel.arrays),
        _model(data.part("frame"), _frame, _frame_arrays),
        scene, data.take("vertices", "i"), data.take("lips", "i"), surface, outer, kept,
        data.take("marks", "i"), _spec(data.part("spec")), _penalty(data.part("penalty")),
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


def _scene_arrays(scene: Scene) -> dict[str, Any]:
    """All of a scene; where its texture does not depend on the weights, that is empty."""
    layers = scene.texture_modes
    own = {name: getattr(scene, name) for name in _SCENE}
    return own | {"texture_modes": np.zeros(0, np.float32) if layers is None else layers}


def _scene(data: Mapping[str, NDArray[Any]]) -> Scene:
    own: dict[str, Any] = {name: data[name] for name in _SCENE}
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


def _facets(whole: Scene, some: Scene) -> NDArray[np.bool_]:
    """Mask of the facets (F,) of a scene that `region.part` takes to make a part of it.

    Raises
    ------
    ParameterError
        If it is no such part.
    """
    chosen = np.zeros(len(whole.faces), np.bool_)
    if some.n_modes == whole.n_modes:
        corners = np.concatenate([_corners(whole), _corners(some)])
        ids = np.unique(corners, axis=0, return_inverse=True)[1].ravel()
        left = iter(ids[len(chosen) :])
        wanted = next(left)
        for facet, own in enumerate(ids[: len(chosen)]):
            if own == wanted:  # a part has its facets in the scene's order
                chosen[facet] = True
                wanted = next(left, -1)
    if not chosen.any() or not same(_scene_arrays(part(whole, chosen)[0]), _scene_arrays(some)):
        raise ParameterError(
            "what is compared of the face is not a part of its head", "take it by region.part"
        )
    return chosen


def _corners(scene: Scene) -> NDArray[np.int32]:
    """All that is known of each facet and its corners, bit for bit, (F, K)."""
    moved = scene.modes.transpose(1, 0, 2).reshape(len(scene.mean), -1)
    bits = np.concatenate([scene.mean, scene.uv, moved], axis=1).view(np.int32)
    known = bits[scene.faces].reshape(len(scene.faces), -1)
    return np.column_stack([known, scene.facet_class])
