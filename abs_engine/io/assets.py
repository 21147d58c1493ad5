"""The only reader of mesh and model files; finds the files that are shipped with the package."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.geometry import check_mesh
from abs_engine.core.kinds import to_path
from abs_engine.core.registry import nearest
from abs_engine.core.threads import kept
from abs_engine.io.arrays import Layout, check_arrays, index, real, text
from abs_engine.io.head_points import POINTS, load_points
from abs_engine.io.npz import read_kind, read_npz
from abs_engine.io.pictures import read_image

FORMAT, VERSION = "abs_engine.speaker", 1
FACE = "abs_engine.speaker_face"
"""Format of a face that was learned on a head, and is none."""
LIPS_OF_68 = slice(48, 68)
"""The lips among the 68 landmarks of `Speaker.points`: 12 outer points, then 8 inner ones."""
CLOSED_APERTURE = 1.0
"""Lips are closed below this aperture, mm, in result and truth alike: about a pixel of video."""

_PACKAGE = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, eq=False)
class Speaker:
    """A head: mesh, facet classes, face units, and the people that it can be.

    Lengths in mm, head frame (x to the subject's left, y up, z out of the face), origin midway
    between the ear canals.

    Parameters
    ----------
    vertices : (V, 3) float32
        The average person, mouth closed.
    faces : (F, 3) int32
    uv : (V, 2) float32, v down from the top of the texture
    weld : (V,) int32
        Index of the geometric vertex; copies at texture seams share one.
    facet_class : (F,) uint8, index into `class_names`
    class_names : tuple of str; the first is the background
    unit_names : tuple of str; the 52 ARKit face units
    units : (52, V, 3) float16, mm at weight 1
    identity_names : tuple of str
    identity : (K, V, 3) float16, mm at weight 1
    people : mapping of str to (K,) float32, identity weights
    landmarks : mapping of str to int32 vertex indices
    folder : Path
        Where the textures lie.
    points : mapping of str to int32 vertex indices
        The frozen lists of ``points.json``: `landmark_68` and the areas `face`, `lips` and `jaw`,
        each described in the file; empty for a head without that file.
    own_texture : (H, W, 3) uint8 RGB, optional
        That of an imported head, see `io.head_file`, for people of whom there is no other.
    looks : mapping of str to (H, W, 3) uint8 RGB
        Textures of those of its people whose looks are known.
    network : mapping of str to array
        Where the landmark network sees its points, of an imported head; others have that beside.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    uv: NDArray[np.float32]
    weld: NDArray[np.int32]
    facet_class: NDArray[np.uint8]
    class_names: tuple[str, ...]
    unit_names: tuple[str, ...]
    units: NDArray[np.float16]
    identity_names: tuple[str, ...]
    identity: NDArray[np.float16]
    people: Mapping[str, NDArray[np.float32]]
    landmarks: Mapping[str, NDArray[np.int32]]
    folder: Path
    points: Mapping[str, NDArray[np.int32]] = field(default_factory=dict)
    own_texture: NDArray[np.uint8] | None = None
    looks: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    network: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    @property
    def imported(self) -> bool:
        """Whether it is somebody's own head, whose texture may be nobody's who is filmed."""
        return self.own_texture is not None

    def class_id(self, name: str) -> int:
        """Id of a facet class by its name; `ParameterError` where there is none."""
        if name not in self.class_names:
            known = nearest(name, self.class_names)
            raise ParameterError(f"there is no facet class '{name}'", known)
        return self.class_names.index(name)

    def facets_of(self, *classes: str) -> BoolArray:
        """Mask (F,) of the facets of some classes."""
        return np.isin(self.facet_class, [self.class_id(name) for name in classes])

    def vertices_of(self, *classes: str) -> NDArray[np.int32]:
        """Vertices (N,) of the facets of some classes, ascending."""
        return np.asarray(np.unique(self.faces[self.facets_of(*classes)]), np.int32)

    def identity_weights(self, **weights: float) -> NDArray[np.float32]:
        """Identity weights (K,) from target names without their folder, '-' written as '_'."""
        short = {n.split("/")[-1].replace("-", "_"): i for i, n in enumerate(self.identity_names)}
        out = np.zeros(len(self.identity_names), np.float32)
        for name, value in weights.items():
            out[short[_known(name, short)]] = value
        return out

    def person(self, weights: NDArray[np.float32]) -> NDArray[np.float32]:
        """Neutral vertices (V, 3), mm, of the person with identity weights (K,)."""
        used = np.flatnonzero(weights)
        deltas = self.identity[used].astype(np.float32)
        return np.asarray(self.vertices + np.tensordot(weights[used], deltas, 1), np.float32)

    def named(self, person: str) -> NDArray[np.float32]:
        """Neutral vertices (V, 3), mm, of a person by name.

        Raises
        ------
        ParameterError
            If there is no such person.
        """
        return self.person(self.people[self._checked(person)])

    def _checked(self, person: str) -> str:
        if person not in self.people:
            raise ParameterError(f"there is no person '{person}'", nearest(person, self.people))
        return person

    def scaled(self, factor: float) -> Speaker:
        """The speaker with all of its lengths multiplied by a factor."""
        return replace(
            self,
            vertices=np.asarray(self.vertices * factor, np.float32),
            units=np.asarray(self.units * factor, np.float16),
            identity=np.asarray(self.identity * factor, np.float16),
        )

    def texture(self, person: str | None = None) -> NDArray[np.uint8]:
        """The painted texture of a person, by default the first, (H, W, 3) uint8 RGB.

        Raises as `named`.
        """
        person = person or next(iter(self.people))
        if self.own_texture is not None:
            return self.looks.get(person, self.own_texture)
        return read_image(self.folder / f"texture_{self._checked(person)}.jpg")

    def unit_matrix(self, names: tuple[str, ...]) -> NDArray[np.float32]:
        """Deltas (N, V, 3), mm, of the named face units."""
        known = [self.unit_names.index(_known(n, self.unit_names)) for n in names]
        return self.units[known].astype(np.float32)

    @cached_property
    def lip_ring(self) -> NDArray[np.int32]:
        """Outer lip contour, an ordered closed loop of vertex indices."""
        return np.asarray(self.landmarks["outer_lip"])


_LANDMARKS: Layout = {
    **{name: index("V", name) for name in ("outer_lip", "inner_lip_upper", "inner_lip_lower")},
    "outer_lip_20": index("V", 12),
    "inner_lip_8": index("V", 8),
    "mouth_corners": index("V", 2),
    "nose_tip": index("V", 1),
    "chin": index("V", 1),
    "eye_corners": index("V", 4),
}


_AGAIN = "make it again with assets/make_speaker.py"
_LAYOUT: Layout = {
    "vertices": real("V", 3, dtype=np.float32),
    "faces": index("V", "F", 3),
    "uv": real("V", 2, dtype=np.float32),
    "weld": index("V", "V"),
    "facet_class": index("C", "F", dtype=np.uint8),
    "class_names": text("C"),
    "unit_names": text("U"),
    "units": real("U", "V", 3, dtype=np.float16),
    "identity_names": text("K*"),
    "identity": real("K*", "V", 3, dtype=np.float16),
    "people_names": text("P*"),
    "people": real("P*", "K*", dtype=np.float32),
    **_LANDMARKS,
}


_AS_THEY_ARE = ("vertices", "faces", "uv", "weld", "facet_class", "units", "identity")


def _known(name: str, names: Container[str]) -> str:
    """The name, if the speaker has it."""
    if name not in names:
        raise ModelFormatError(f"the speaker has no shape target '{name}'", _AGAIN)
    return name


def shipped(name: str) -> Path:
    """Path of a file in `assets/`: the package's own copy, or the repository's.

    Raises
    ------
    InputFileError
        If it is in neither.
    """
    for folder in (_PACKAGE / "_data" / "assets", _PACKAGE.parent / "assets"):
        if (folder / name).exists():
            return folder / name
    raise InputFileError(f"the shipped file {name} is missing", "install abs-engine again")


def load_speaker(path: Path | None = None) -> Speaker:
    """Read a speaker.

    Parameters
    ----------
    path : Path, optional
        A `head.npz`; by default the bundled head, which is read once and shared: do not write
        to its arrays.

    Raises
    ------
    InputFileError
        If the file is missing or cannot be read.
    ModelFormatError
        If it has another format or version.
    MeshError
        If the mesh cannot be drawn.
    """
    if path is None:
        return _bundled()
    path = to_path("speaker", path)
    try:
        return _read(path)
    except ModelFormatError as error:
        if read_kind(path) != FACE:
            raise
        raise ModelFormatError(
            f"{path} is a learned face", "give it to --model, and leave out --speaker"
        ) from error


@kept
def _bundled() -> Speaker:
    return _read(shipped("speaker/head.npz"))


def _read(path: Path) -> Speaker:
    given = read_npz(path, FORMAT, VERSION)
    given |= {k: np.atleast_1d(given[k]) for k in ("nose_tip", "chin") if k in given}
    embedded = "own_texture" in given
    layout = {**_LAYOUT, **_embedded_layout(given)} if embedded else _LAYOUT
    data = check_arrays(path, given, layout, _AGAIN)
    own: dict[str, Any] = {k: data[k] for k in _AS_THEY_ARE}
    if embedded:
        own |= _embedded(given | data)
    else:
        own["points"] = load_points(path.parent / POINTS, len(own["vertices"]), len(own["faces"]))
    speaker = Speaker(
        class_names=tuple(map(str, data["class_names"])),
        unit_names=tuple(map(str, data["unit_names"])),
        identity_names=tuple(map(str, data["identity_names"])),
        people=dict(zip(map(str, data["people_names"]), data["people"], strict=True)),
        landmarks={k: data[k] for k in _LANDMARKS},
        folder=path.parent,
        **own,
    )
    check_mesh(speaker.vertices.astype(np.float64), speaker.faces)
    return speaker


def _embedded_layout(data: Mapping[str, NDArray[Any]]) -> Layout:
    """Layout of an imported head's own arrays; `load_correspondence` checks the rest."""
    own = {"own_texture": index(255, "tall", "wide", 3, dtype=np.uint8)}
    own |= {k: index("V", k) for k in data if k.startswith("points_")}
    looks = (k for k in data if k.startswith("looks_"))
    return own | {k: index(255, f"{k} tall", f"{k} wide", 3, dtype=np.uint8) for k in looks}


def _embedded(data: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """Arrays of its own in the file of an imported head."""
    parts = {
        part: {k.removeprefix(f"{part}_"): v for k, v in data.items() if k.startswith(f"{part}_")}
        for part in ("points", "looks", "network")
    }
    return {"own_texture": data["own_texture"], **parts}
