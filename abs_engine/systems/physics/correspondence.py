"""Which point of the shell each dot of ink is (section 4), with the person's head known or not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.assets import Speaker
from abs_engine.observe.marks import LIPS16
from abs_engine.shape.dots import ShellPoints, nearest_points
from abs_engine.shape.lip_shell import LipShell
from abs_engine.synth.people import Person, dots

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Correspondence:
    """A shell at rest on a person, and where the dots of the lips are on it.

    Parameters
    ----------
    points : ShellPoints
        Of `marks.LIPS16`, in their order: a table that is the same for everybody.
    rest : (N, 3) float64, mm, head frame
        The shell's nodes at rest.
    home : (16, 3) float64, mm, head frame
        Where the dots are while the shell is at rest. They lie up to 1 mm off the shell, whose
        facets are larger than the head's; the displacement goal of a dot is how far it is from
        here.
    person : str
        The person whose head it is; empty where the average head was laid on the dots.
    scale : float
        By which the average head was scaled; 1 where the person is known.
    misfit : float, mm
        Root mean square distance of the mean dots from `home`. Of a known person it is how the
        mouth is held on average, otherwise also how the person differs from the average one: both
        are part of the mean displacement.
    """

    points: ShellPoints
    rest: FloatArray
    home: FloatArray
    person: str
    scale: float
    misfit: float

    @property
    def how(self) -> str:
        """Which head was used, in words."""
        if self.person:
            return f"the head of {self.person}; mean dots {self.misfit:.2f} mm from rest"
        return (
            f"the average head laid on the mean dots, {self.scale:.3f} times its size; "
            f"they are {self.misfit:.2f} mm from its own"
        )

    def goals(self, dots: FloatArray) -> FloatArray:
        """Displacement goals U_g (..., 48), mm, of dots (..., 16, 3)."""
        away = np.asarray(dots, np.float64) - self.home
        return away.reshape(*away.shape[:-2], -1)

    def seen(self, nodes: FloatArray) -> FloatArray:
        """The dots (..., 16, 3) of a shell with nodes (..., N, 3), mm."""
        return np.asarray(self.home + self.points.at(nodes - self.rest))


def dot_vertices(speaker: Speaker) -> NDArray[np.int32]:
    """Vertices (17,) of the head at the dots of `marks.LIPS17`, in their order.

    The same for every person of the speaker: the dots are placed by structure.
    """
    somebody = next(iter(speaker.people))
    return np.asarray(dots(speaker, Person("dotted", somebody, beads="lips17")).vertices, np.int32)


def shell_points(speaker: Speaker, shell: LipShell) -> ShellPoints:
    """Where the dots of `marks.LIPS16` are on the shell, by the average head."""
    at = dot_vertices(speaker)[: len(LIPS16)]
    nodes = shell.nodes(speaker.vertices)
    return nearest_points(nodes, shell.faces[shell.lip], speaker.vertices[at])


def correspond(
    speaker: Speaker, shell: LipShell, seen: FloatArray, person: str | None = None
) -> Correspondence:
    """Lay the shell on a person who wore dots.

    Parameters
    ----------
    speaker : Speaker
    shell : LipShell
        Cut from the speaker.
    seen : (T, 16, 3) float64, mm, head frame
        The dots of `marks.LIPS16` in frames in which all were seen.
    person : str, optional
        One of the speaker's people. By default the average head is scaled, turned and shifted as
        a whole until its dots are nearest to the mean ones.

    Raises
    ------
    ParameterError
        If there is no such person.
    """
    points, at = shell_points(speaker, shell), dot_vertices(speaker)[: len(LIPS16)]
    mean = np.asarray(seen, np.float64).mean(axis=0)
    if person is not None:
        head = speaker.named(person).astype(np.float64)
        misfit = _rms(mean - head[at])
        return Correspondence(points, shell.nodes(head), head[at], person, 1.0, misfit)
    average = speaker.vertices.astype(np.float64)
    scale, turn, shift = similarity(average[at], mean)
    rest, home = (scale * p @ turn.T + shift for p in (shell.nodes(average), average[at]))
    return Correspondence(points, rest, home, "", scale, _rms(mean - home))


def similarity(points: FloatArray, wanted: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Scale, rotation (3, 3) and shift (3,) that take points (K, 3) nearest to others.

    Least squares (Umeyama 1991).
    """
    middle, centre = points.mean(axis=0), wanted.mean(axis=0)
    turn = Rotation.align_vectors(wanted - centre, points - middle)[0].as_matrix()
    turned = (points - middle) @ turn.T
    scale = float((turned * (wanted - centre)).sum() / (turned**2).sum())
    return scale, turn, centre - scale * turn @ middle


def _rms(away: FloatArray) -> float:
    return float(np.sqrt((away**2).sum(axis=-1).mean()))
