"""From a mesh with morph targets and a table to a head."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ModelFormatError, ParameterError
from abs_engine.core.geometry import check_mesh, vertex_normals
from abs_engine.face.base import lip_gap
from abs_engine.face.schema import (
    CLASS_NAMES,
    COMPONENT,
    FACE_UNITS,
    ICT_68,
    PERSON,
    Pair,
    Unit,
    units_of,
)
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.morphs import MorphMesh
from abs_engine.io.morphs.mesh import displacement
from abs_engine.io.morphs.obj import read_places
from abs_engine.io.pictures import read_image
from abs_engine.learn.heads.checks import check_marks, check_person, check_rings, check_units
from abs_engine.learn.heads.frame import HeadFrame, head_frame
from abs_engine.learn.heads.interior import TEETH, has, is_hollow, mouth_interior
from abs_engine.learn.heads.marks import Contours, Marks, find_marks, lip_contours
from abs_engine.learn.heads.paint import laid, paint
from abs_engine.learn.heads.parts import Surface, hidden_parts
from abs_engine.learn.heads.regions import HIDDEN_ID, facet_classes, welded
from abs_engine.learn.heads.settings import HEAD_IMPORT
from abs_engine.learn.heads.table import SIXTY_EIGHT, HeadTable
from abs_engine.learn.heads.units import face_units

NEUTRAL = "neutral"
"""The name of the person that the file itself shows."""


@dataclass(frozen=True, eq=False)
class ImportedHead:
    """A head, and what is to be said of how it was made.

    Parameters
    ----------
    speaker : Speaker
        Without the landmark network's points; only the three areas and, where they were given, the
        68 landmarks are among its lists.
    unused : tuple of str
        Morph targets that are no face unit, or mean one that others make.
    missing : tuple of str
        Face units that no morph target makes: they move nothing.
    added : tuple of str
        Facet classes that were added.
    opening : float, mm
        How far `jawOpen` opens the lips.
    hidden : tuple of str
        Parts that are not drawn.
    exchanged : tuple of str
        Face units whose names have left and right as a viewer sees them: they were exchanged.
    inside_out : bool
        Whether the facets of the file face into the head: they were turned round.
    twice : int
        Facets that lie on others: they were left out.
    """

    speaker: Speaker
    unused: tuple[str, ...]
    missing: tuple[str, ...]
    added: tuple[str, ...]
    opening: float
    hidden: tuple[str, ...]
    exchanged: tuple[str, ...]
    inside_out: bool
    twice: int


def build_head(mesh: MorphMesh, table: HeadTable) -> ImportedHead:
    """Make a head of a mesh.

    Raises
    ------
    InputFileError, ModelFormatError
        If a person's file cannot be read, or is another mesh.
    ParameterError
        If the table lacks a landmark or names what is not there, lists lips in the wrong order, no
        target opens the mouth, one moves eyes or nose far, or the head or a person is of no human
        size, or a person's face lies elsewhere.
    MeshError
        If the mesh cannot be drawn.
    """
    check_mesh(mesh.vertices, mesh.faces)
    textures = _textures(mesh, table.textures, (NEUTRAL, *table.people))
    origin = np.arange(len(mesh.vertices))
    if textures:
        mesh, origin = mesh.at_seams()
    given = {SIXTY_EIGHT: list(ICT_68)} if mesh.model == "ict" else {}
    marks = find_marks({**given, **table.landmarks}, mesh.vertices, mesh.source)
    frame = head_frame(mesh.vertices, marks, table.length)
    vertices = frame.places(mesh.vertices)
    check_marks(marks, vertices)
    moved = face_units(mesh, table.units, frame)
    units = moved.moves
    check_units(units, vertices, marks)
    jaw = units[FACE_UNITS.index(Unit.JAW_OPEN)].astype(np.float64)
    check_rings(marks, vertices + jaw)
    weld = welded(vertices, jaw)
    surface = Surface.of(mesh, table.regions, marks, vertices, weld)
    mesh, words = surface.mesh, surface.words
    face = mesh.faces[words != "none"]
    contours = lip_contours(marks, vertices, face, weld)
    opening = float(lip_gap(jaw[contours.points]))
    if opening < HEAD_IMPORT.least_opening:
        raise ParameterError(
            f"jawOpen opens the lips of {mesh.source} by {opening:.1f} mm",
            "give a mesh whose mouth opens, or name its target: [units] jawOpen = ...",
        )
    classes = facet_classes(
        words, vertices, mesh.faces, weld, contours, jaw, int(marks.nose_tip[0])
    )
    whole = _Parts(vertices, mesh.faces, weld, classes, units)
    whole, added = _completed(whole, contours, float(np.linalg.norm(jaw[marks.chin[0]])))
    missing = tuple(n for n, d in zip(FACE_UNITS, units, strict=True) if not d.any())
    identity = _identity(mesh, table.people, frame, origin, marks)
    uv, painted = paint(whole.vertices, whole.faces, whole.classes, marks, _blinked(whole.units))
    looks = {NEUTRAL: painted}
    if textures:
        uv, looks = laid(mesh.uv_of_vertices(), textures, uv, painted)
    speaker = replace(
        _speaker(whole, marks, contours, identity),
        uv=uv,
        own_texture=next(iter(looks.values())),
        looks={name: looks[name] for name in table.textures},
    )
    hidden = hidden_parts(mesh, words)
    return ImportedHead(
        speaker, moved.unused, missing, added, opening, hidden, moved.exchanged,
        surface.inside_out, surface.twice,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Parts:
    """A mesh in the making, in the head frame."""

    vertices: FloatArray
    faces: NDArray[np.int32]
    weld: IntArray
    classes: NDArray[np.uint8]
    units: NDArray[np.float32]


def _completed(parts: _Parts, contours: Contours, jaw: float) -> tuple[_Parts, tuple[str, ...]]:
    """The mesh with teeth and the mouth's inside, and what was added of them."""
    drawn = parts.classes != HIDDEN_ID
    faces, classes = parts.faces[drawn], parts.classes[drawn]
    wanted: tuple[str, ...] = ()
    if not all(has(classes, name) for name in TEETH[:2]):
        keep = ~np.isin(classes, [CLASS_NAMES.index(name) for name in TEETH[:2]])
        faces, classes = faces[keep], classes[keep]  # teeth that do not part with the jaw
        wanted += TEETH[: 2 if has(classes, "tongue") else 3]
    if not is_hollow(parts.vertices, faces, classes, contours.points):
        wanted += ("inner_mouth",)
    if not wanted:
        return replace(parts, faces=faces, classes=classes), ()
    new = mouth_interior(load_speaker(), wanted, parts.vertices[contours.points], jaw)
    # a tongue that comes out needs lips that let it
    moves = np.abs(parts.units).max(axis=(1, 2)) > 0
    count = len(parts.vertices)
    return (
        _Parts(
            np.concatenate([parts.vertices, new.vertices]),
            np.concatenate([faces, new.faces + count]).astype(np.int32),
            np.concatenate([parts.weld, np.arange(len(new.vertices)) + parts.weld.max() + 1]),
            np.concatenate([classes, new.classes]),
            np.concatenate([parts.units, new.units * moves[:, None, None]], axis=1),
        ),
        wanted,
    )


def _identity(
    mesh: MorphMesh, people: Mapping[str, Path], frame: HeadFrame, origin: IntArray, marks: Marks
) -> dict[str, NDArray[np.float32]]:
    """Differences between people, by name of target, (V, 3), mm."""
    out = {f"{COMPONENT}{name}": frame.moves(d) for name, d in mesh.components.items()}
    for name, path in people.items():
        if name == NEUTRAL:
            raise ParameterError(f"'{NEUTRAL}' is the head as its file is", "name people otherwise")
        try:
            first = mesh.vertices[: origin.max() + 1]  # without copies at seams
            moved = displacement(name, read_places(path), first, kind="person")[origin]
        except ModelFormatError as error:
            raise ModelFormatError(
                f"{path} is another mesh: {error.problem}", error.remedy
            ) from error
        check_person(path, frame.places(mesh.vertices + moved), frame.places(mesh.vertices), marks)
        out[f"{PERSON}{name}"] = frame.moves(moved)
    return out


def _blinked(units: NDArray[np.float32]) -> FloatArray:
    """Distances (V,), mm, by which blinks move the vertices, by units (K, V, 3)."""
    blinks = units[[FACE_UNITS.index(unit) for unit in units_of(Pair.EYE_BLINK)]]
    return np.asarray(np.linalg.norm(blinks.astype(np.float64), axis=2).max(axis=0))


def _textures(
    mesh: MorphMesh, given: Mapping[str, Path], people: tuple[str, ...]
) -> dict[str, NDArray[np.uint8]]:
    """Pictures by the name of the person who looks so; none where the head is to be painted."""
    strangers = [name for name in given if name not in people]
    if strangers:
        raise ParameterError(
            f"there is a texture but no shape of '{strangers[0]}'", f"people: {', '.join(people)}"
        )
    if given and mesh.uv is None:
        raise ParameterError(
            f"{mesh.source} does not say where a texture lies on it", "leave out [textures]"
        )
    own = {} if mesh.texture is None or NEUTRAL in given else {NEUTRAL: mesh.texture}
    return own | {name: read_image(path) for name, path in given.items()}


def _speaker(
    parts: _Parts, marks: Marks, contours: Contours, identity: Mapping[str, NDArray[np.float32]]
) -> Speaker:
    count = len(parts.vertices)
    targets = np.zeros((len(identity), count, 3), np.float16)
    for k, moved in enumerate(identity.values()):
        targets[k, : len(moved)] = moved
    names = tuple(identity)
    own = [name.removeprefix(PERSON) for name in names if name.startswith(PERSON)]
    weights = {name: np.array([n == f"{PERSON}{name}" for n in names], np.float32) for name in own}
    points = contours.points
    landmarks = {
        "outer_lip": contours.outer, "inner_lip_upper": contours.upper,
        "inner_lip_lower": contours.lower, "outer_lip_20": points[:12], "inner_lip_8": points[12:],
        "mouth_corners": points[[0, 6]], "nose_tip": marks.nose_tip[:1], "chin": marks.chin[:1],
        "eye_corners": marks.eye_corners[:4],
    }  # fmt: skip
    lists = _areas(parts, marks)
    if marks.all_68 is not None:
        lists[SIXTY_EIGHT] = marks.all_68
    return Speaker(
        vertices=parts.vertices.astype(np.float32),
        faces=parts.faces.astype(np.int32),
        uv=np.zeros((count, 2), np.float32),
        weld=parts.weld.astype(np.int32),
        facet_class=parts.classes,
        class_names=CLASS_NAMES,
        unit_names=FACE_UNITS,
        units=parts.units.astype(np.float16),
        identity_names=names,
        identity=targets,
        people={NEUTRAL: np.zeros(len(names), np.float32), **weights},
        landmarks={name: np.asarray(at, np.int32) for name, at in landmarks.items()},
        folder=Path(),
        points={name: np.asarray(at, np.int32) for name, at in lists.items()},
    )


def _areas(parts: _Parts, marks: Marks) -> dict[str, IntArray]:
    """The vertices of the areas that are scored: face, lips and jaw."""
    v = parts.vertices
    of = {
        name: np.unique(parts.faces[np.isin(parts.classes, [CLASS_NAMES.index(n) for n in names])])
        for name, names in {"skin": ("skin",), "lips": ("upper_lip", "lower_lip")}.items()
    }
    eyes, chin = v[marks.eye_corners], v[marks.chin[0]]
    front = vertex_normals(v, parts.faces)[:, 2] > 0
    before = front & (v[:, 2] > eyes[[0, 3], 2].mean() - HEAD_IMPORT.behind_eyes)
    face = (
        before
        & (v[:, 1] > chin[1] - HEAD_IMPORT.under_chin)
        & (v[:, 1] < eyes[:, 1].mean() + HEAD_IMPORT.forehead)
    )
    far = np.linalg.norm(parts.units[FACE_UNITS.index(Unit.JAW_OPEN)], axis=1)
    skin = of["skin"][face[of["skin"]]]
    jaw = np.setdiff1d(skin, of["lips"])
    found = {
        "face": np.union1d(skin, of["lips"]), "lips": of["lips"],
        "jaw": jaw[far[jaw] >= HEAD_IMPORT.jaw_share * far[skin].max()],
    }  # fmt: skip
    each = zip(found.items(), HEAD_IMPORT.spacing, strict=True)
    return {name: _thinned(at, v, spacing) for (name, at), spacing in each}


def _thinned(at: IntArray, vertices: FloatArray, spacing: float) -> IntArray:
    """One vertex of each cube of a grid."""
    cubes = np.floor(vertices[at] / spacing).astype(int)
    return at[np.sort(np.unique(cubes, axis=0, return_index=True)[1])]
