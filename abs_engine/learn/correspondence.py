"""Dots of ink to points of the shell (section 4), with the person's head known or not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from abs_engine.capture.dot_annotations import LIPS16
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.dots import ShellPoints, nearest_points
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.face.shape.lip_shell import LipShell
from abs_engine.io.assets import Speaker
from abs_engine.learn.settings import LEARNING


@dataclass(frozen=True, eq=False)
class Correspondence:
    """A shell at rest on a person, and where the dots of the lips are on it.

    Parameters
    ----------
    points : ShellPoints
        Of `dot_annotations.LIPS16`, in their order: a table that is the same for everybody.
    rest : (N, 3) float64, mm, head frame
        The shell's nodes at rest: of the known person's head, or of the average one.
    home : (16, 3) float64, mm, head frame
        Where the dots are while the shell is at rest. They lie up to 1 mm off the shell, whose
        facets are larger than the head's; the displacement goal of a dot is how far it is from
        here.
    person : str
        The person whose head it is; empty where the average head was laid on the dots.
    scale : float
        How large the mouth is for the average head's; 1 where the person is known.
    turn : (3, 3) float64
        Rotation from the average head's axes to those of the dots; none where the person is known.
    shift : (3,) float64, mm
        Where the average head's origin is among the dots.
    misfit : float, mm
        Root mean square distance of the mean dots, brought to the head, from `home`. Of a known
        person it is how the mouth is held on average, otherwise also how the person differs from
        the average one: both are part of the mean displacement.
    """

    points: ShellPoints
    rest: FloatArray
    home: FloatArray
    person: str
    scale: float
    turn: FloatArray
    shift: FloatArray
    misfit: float

    @property
    def how(self) -> str:
        """Description of the head that was used."""
        if self.person:
            return f"the head of {self.person}; mean dots {self.misfit:.2f} mm from rest"
        return (
            f"the mean dots laid on the average head, {self.scale:.3f} times its size and "
            f"{_degrees(self.turn):.1f} degrees turned; they are {self.misfit:.2f} mm from its own"
        )

    def brought(self, dots: FloatArray) -> FloatArray:
        """Dots (..., 16, 3), mm, in the axes and the size of the head that the shell rests on."""
        return np.asarray((np.asarray(dots, np.float64) - self.shift) @ self.turn / self.scale)

    def goals(self, dots: FloatArray) -> FloatArray:
        """Displacement goals U_g (..., 48), mm, of dots (..., 16, 3) as they were observed."""
        away = self.brought(dots) - self.home
        return away.reshape(*away.shape[:-2], -1)


def shell_points(speaker: Speaker, shell: LipShell) -> ShellPoints:
    """Places of the dots of `dot_annotations.LIPS16` on the shell, by the average head."""
    at = lips17(speaker)[: len(LIPS16)]
    nodes = shell.nodes(speaker.vertices)
    return nearest_points(nodes, shell.faces[shell.lip], speaker.vertices[at])


def correspond(
    speaker: Speaker, shell: LipShell, seen: FloatArray, person: str | None = None
) -> Correspondence:
    """Lay a shell, cut from the speaker, on a person who wore dots.

    Parameters
    ----------
    seen : (T, 16, 3) float64, mm, head frame
        The dots of `dot_annotations.LIPS16` in frames in which all were seen.
    person : str, optional
        One of the speaker's people. By default the dots are scaled, turned and shifted as a
        whole until the mean ones are nearest to those of the average head: the modes are learned
        in that head's axes and size, in which they are used.

    Raises
    ------
    ParameterError
        If there is no such person, or the dots are another's, in another frame or another unit, or
        the names of two, or of left and right, are exchanged.
    """
    points, at = shell_points(speaker, shell), lips17(speaker)[: len(LIPS16)]
    mean = np.asarray(seen, np.float64).mean(axis=0)
    _check_depth(mean)
    _check_names(mean, speaker.vertices[at].astype(np.float64))
    head = (speaker.vertices if person is None else speaker.named(person)).astype(np.float64)
    scale, turn, shift = similarity(head[at], mean)
    _check_frame(scale, turn)
    if person is not None:
        scale, turn, shift = 1.0, np.eye(3), np.zeros(3)
    misfit = _rms((mean - shift) @ turn / scale - head[at])
    _check_misfit(misfit, person)
    rest = shell.nodes(head)
    return Correspondence(points, rest, head[at], person or "", scale, turn, shift, misfit)


def check_dots(speaker: Speaker, mean: FloatArray, crossed: FloatArray | None = None) -> None:
    """Refuse mean dots (16, 3), mm, of `dot_annotations.LIPS16` that are no lips in the head frame.

    `crossed` (16, 16, 3), mm, is where they lie if one view exchanged names, see
    `capture.exchanged.crossed`. Raises `ParameterError` if they lie in one plane, have each other's
    names, or another size or direction than lips.
    """
    home = speaker.vertices[lips17(speaker)[: len(LIPS16)]].astype(np.float64)
    _check_depth(mean)
    _check_names(mean, home, crossed)
    _check_frame(*similarity(home, mean)[:2])


def _check_frame(scale: float, turn: FloatArray) -> None:
    low, high = LEARNING.mouth_sizes
    if not low <= scale <= high:
        raise ParameterError(
            f"the dots make a mouth of {scale:.2g} times the head's size, not {low:g} to {high:g}",
            "are they in mm? give them so",
        )
    if _degrees(turn) > LEARNING.steepest:
        raise ParameterError(
            f"the dots are turned by {_degrees(turn):.0f} degrees from the head frame",
            "turn the points into the head frame: x left, y up, z out of the face",
        )


def _check_depth(mean: FloatArray) -> None:
    """Lips lie around the teeth: what lies in one plane was seen from one side only."""
    extent = np.linalg.svd(mean - mean.mean(axis=0), compute_uv=False)
    if extent[2] < LEARNING.flattest * extent[0]:
        raise ParameterError(
            f"the mean dots lie in a plane to {extent[2] / extent[0]:.1%} of their width, which "
            "lips do not",
            "give points in 3D, seen from two sides",
        )


def _check_names(mean: FloatArray, home: FloatArray, crossed: FloatArray | None = None) -> None:
    """Refuse mean dots (16, 3) that come far nearer to the average head's with names exchanged.

    Of two dots, in all views or in one, or left and right of all.
    """
    own, mirrored = _laid(mean, home), _laid(mean * [-1, 1, 1], home)
    exchanges = _exchanges(mean, crossed)
    ways = [(_laid(dots, home), where, a, b) for where, a, b, dots in exchanges]
    best, where, a, b = min(ways)
    if mirrored < min(LEARNING.exchanged * own, best):
        raise ParameterError(
            "left and right seem exchanged in the names of the dots: laid on the average head, the "
            f"mean dots are {own:.1f} mm RMS from its own, and {mirrored:.1f} if they are mirrored",
            "exchange left and right, or, if the names are right, check the order of cameras and "
            "videos, and that the axes are right-handed",
        )
    if best < LEARNING.exchanged * own:
        raise ParameterError(
            f"the dots {LIPS16[a]} and {LIPS16[b]} have each other's place{where}: laid on the "
            f"average head, the mean dots are {own:.1f} mm RMS from its own, and {best:.1f} if "
            "these two are exchanged",
            f"exchange their names{where} in the file of points or markers, and observe again",
        )


def _exchanges(
    mean: FloatArray, crossed: FloatArray | None
) -> Iterator[tuple[str, int, int, FloatArray]]:
    """Ways in which two names may be exchanged: the view, the two, and all dots with it undone."""
    for a, b in combinations(range(len(mean)), 2):
        ways = {"": (mean[b], mean[a])}
        if crossed is not None:
            ways[" in view 1"] = crossed[b, a], crossed[a, b]
            ways[" in view 2"] = crossed[a, b], crossed[b, a]
        for where, places in ways.items():
            dots = mean.copy()
            dots[[a, b]] = places
            if np.isfinite(dots).all():
                yield where, a, b, dots


def _laid(dots: FloatArray, home: FloatArray) -> float:
    """RMS distance, mm, of dots (K, 3) from others that they are laid on."""
    scale, turn, shift = similarity(home, dots)
    return _rms((dots - shift) @ turn / scale - home)


def _check_misfit(misfit: float, person: str | None) -> None:
    if misfit <= LEARNING.farthest_dots:
        return
    if person is None:
        raise ParameterError(
            f"the mean dots are {misfit:.0f} mm RMS from any place on the average head",
            f"check their names and order, at most {LEARNING.farthest_dots:g} mm make lips",
        )
    raise ParameterError(
        f"the mean dots are {misfit:.0f} mm RMS from those on the head of {person}",
        "name who wore them and give them in that head's frame (observe --reference), or leave "
        "out --person",
    )


def _degrees(turn: FloatArray) -> float:
    return float(np.degrees(Rotation.from_matrix(turn).magnitude()))


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
