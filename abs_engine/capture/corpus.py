"""A corpus of visemes: named 3D points of a speaker's face in a frame of the upper teeth.

Odisio and Bailly (2003), section 2.1.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ModelFormatError, ParameterError, TooFewPointsError
from abs_engine.core.geometry import Pose
from abs_engine.io.arrays import Layout, real, text
from abs_engine.io.inputs import name_problem, parse_json
from abs_engine.io.npz import read_npz, write_npz

FORMAT, VERSION = "abs_engine.corpus", 1
_LAYOUT: Layout = {
    "points": real("V", "N", 3, gaps=True),
    "names": text("N"),
    "visemes": text("V"),
    "groups": text(),
    "rotation": real(3, 3),
    "translation": real(3),
    "source": text(),
}
_NO_MOTION = Pose(np.eye(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Corpus:
    """V visemes of N points.

    Parameters
    ----------
    points : (V, N, 3) float64, mm, bite-plane frame
        Right-handed: the origin at the edge of the upper front teeth, x to the subject's left,
        y up from the plane on which the upper teeth stand, z forward in it. NaN where a point is
        missing.
    names : tuple of str, N
    visemes : tuple of str, V
        Such as ``a``, ``ipi``, ``rest``; in X-SAMPA for bundled speakers.
    groups : mapping of str to tuple of str
        Names of points by group. The paper's predictors ask for ``jaw_line``, ``lower_teeth``,
        ``lips``, ``upper_lip``, ``lower_lip`` and ``face``.
    frame : Pose
        Head frame to bite-plane frame; no motion where there is no head.
    source : str
        Where it comes from.

    Raises
    ------
    ParameterError
        If shapes or names do not fit, a viseme or group has a name that cannot be printed, or a
        group names a point that is not there.
    """

    points: FloatArray
    names: tuple[str, ...]
    visemes: tuple[str, ...]
    groups: Mapping[str, tuple[str, ...]]
    frame: Pose = field(default=_NO_MOTION)
    source: str = ""

    def __post_init__(self) -> None:
        if self.points.shape != (len(self.visemes), len(self.names), 3):
            raise ParameterError(
                f"{len(self.visemes)} visemes of {len(self.names)} points have the shape "
                f"{self.points.shape}",
                "give (V, N, 3)",
            )
        for what, given in (("point", self.names), ("viseme", self.visemes)):
            twice = sorted({n for n in given if given.count(n) > 1})
            if twice:
                raise ParameterError(f"two {what}s are named '{twice[0]}'", "name each once")
        for what, given in (("viseme", self.visemes), ("group", tuple(self.groups))):
            problems = [p for p in (name_problem(what, name) for name in given) if p]
            if problems:
                raise ParameterError(problems[0], "give it another name")
        for group, members in self.groups.items():
            lacking = sorted(set(members) - set(self.names))
            if lacking:
                raise ParameterError(
                    f"group '{group}' names '{lacking[0]}', which is not a point",
                    "correct the table of points",
                )

    def __len__(self) -> int:
        """Return the number of visemes, V."""
        return len(self.visemes)

    def without(self, names: Collection[str]) -> Corpus:
        """The corpus without the visemes and points of some names.

        Raises
        ------
        ParameterError
            If there is neither a viseme nor a point of that name.
        """
        for name in names:
            if name not in self.visemes and name not in self.names:
                raise ParameterError(
                    f"there is neither a viseme nor a point '{name}'",
                    f"the visemes are {', '.join(self.visemes)}",
                )
        rows, columns = (
            [k for k, name in enumerate(own) if name not in names]
            for own in (self.visemes, self.names)
        )
        groups = {g: tuple(n for n in own if n not in names) for g, own in self.groups.items()}
        return Corpus(
            self.points[np.ix_(rows, columns)], tuple(self.names[k] for k in columns),
            tuple(self.visemes[k] for k in rows), groups, self.frame, self.source,
        )  # fmt: skip

    @property
    def roleless(self) -> tuple[str, ...]:
        """Points that are in no group."""
        known = {name for own in self.groups.values() for name in own}
        return tuple(name for name in self.names if name not in known)

    def save(self, path: Path) -> None:
        """Write an ``.npz``, whole or not at all.

        Raises
        ------
        OutputError
            If it exists or cannot be written.
        """
        fields: dict[str, Any] = {
            "points": self.points,
            "names": np.array(self.names), "visemes": np.array(self.visemes),
            "groups": json.dumps({g: list(n) for g, n in self.groups.items()}),
            "rotation": self.frame.rotation, "translation": self.frame.translation,
            "source": self.source,
        }  # fmt: skip
        write_npz(path, FORMAT, VERSION, fields)


def load_corpus(path: Path) -> Corpus:
    """Read what `Corpus.save` wrote.

    Raises
    ------
    InputFileError
        If it is missing or cannot be read.
    ModelFormatError
        If it has another format or version, or does not hold a whole corpus.
    """
    data = read_npz(Path(path), FORMAT, VERSION, _LAYOUT)
    try:
        groups = {g: tuple(map(str, n)) for g, n in parse_json(str(data["groups"])).items()}
        frame = Pose(data["rotation"], data["translation"])
        return Corpus(
            data["points"], tuple(map(str, data["names"])),
            tuple(map(str, data["visemes"])), groups, frame, str(data["source"]),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError, AttributeError, ParameterError) as error:
        raise ModelFormatError(
            f"{path} is not a complete corpus ({error})", "make it again"
        ) from error


def bite_plane(right: FloatArray, left: FloatArray, front: FloatArray) -> Pose:
    """The bite-plane frame of three points of the upper teeth.

    Parameters
    ----------
    right, left : (3,) float64, mm
        On a molar of the subject's right and left side.
    front : (3,) float64, mm
        On the edge between the front teeth: the origin.

    Returns
    -------
    Pose
        From the frame of the points to that of the bite plane, as `Corpus.points` defines it.

    Raises
    ------
    TooFewPointsError
        If a point is missing, or the three lie on a line.
    """
    right, left, front = (np.asarray(p, np.float64) for p in (right, left, front))
    across = left - right
    forward = front - (left + right) / 2
    up = np.cross(forward, across)
    size = float(np.linalg.norm(up))
    if not size > 1e-6 * float(np.linalg.norm(across) * np.linalg.norm(forward)):
        raise TooFewPointsError(
            "three points of the upper teeth do not span a plane",
            "mark a molar on each side and the front teeth",
        )
    y = up / size
    z = np.cross(across, y)
    z /= np.linalg.norm(z)
    rotation = np.stack([np.cross(y, z), y, z])
    return Pose(rotation, -rotation @ front)
