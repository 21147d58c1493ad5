"""A head fitted to a corpus: who it is, where each point lies on it, and how visemes move it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError, TooFewPointsError
from abs_engine.core.geometry import Pose
from abs_engine.face.identity import head_modes
from abs_engine.face.schema import BROWS, EYES, Unit
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.io.assets import Speaker
from abs_engine.learn.articulatory import Build, rms
from abs_engine.learn.measured.identity import PlacedHead
from abs_engine.learn.measured.motion import slid, unit_weights
from abs_engine.learn.measured.settings import MEASURED_FACE
from abs_engine.learn.measured.sites import LIPS, Sites
from abs_engine.learn.spoken import bite_plane_of

REST = "rest"
"""The viseme in which the head keeps still."""
_STILL = (*EYES, *BROWS, Unit.TONGUE_OUT)  # face units that no point of speech shows


@dataclass(frozen=True, eq=False)
class MeasuredHead:
    """A head fitted to the points of a corpus.

    Parameters
    ----------
    speaker : Speaker
        Whose mesh and face units it has.
    neutral : (V, 3) float64, mm, head frame
        At rest.
    frame : Pose
        Head frame to the frame of the corpus.
    places : ShellPoints
        Of the points on the head.
    weights : (T, 52) float64
        Face-unit weights of the visemes.
    left : (T, N, 3) float64, mm, head frame
        What identity and face units leave of each point.
    """

    speaker: Speaker
    neutral: FloatArray
    frame: Pose
    places: ShellPoints
    weights: FloatArray
    left: FloatArray

    @cached_property
    def misfit(self) -> float:
        """RMS distance of the points from where identity and face units put them, mm."""
        return float(rms(np.linalg.norm(self.left, axis=2).ravel()))


def fit_head(speaker: Speaker, built: Build) -> MeasuredHead:
    """Fit a head to a corpus that has a viseme `REST`; a missing point is where the model puts it.

    Raises `ParameterError` if there is no viseme at rest, or the points are no face's;
    `TooFewPointsError` if there are too few.
    """
    corpus = built.corpus
    if REST not in corpus.visemes:
        raise ParameterError(
            f"no viseme is '{REST}', by which the head is fitted",
            f"name the frames of a closed mouth at rest in the table: viseme,{REST},0",
        )
    _check_count(built)
    points = np.where(np.isfinite(corpus.points), corpus.points, built.model.points(built.alpha))
    at_rest = corpus.visemes.index(REST)
    sites = Sites.of(speaker, corpus.names, corpus.groups)
    head, places = _by_distance(speaker, sites, points[at_rest])
    return _by_motion(speaker, sites, head, places, points, at_rest)


def _by_distance(
    speaker: Speaker, sites: Sites, points: FloatArray
) -> tuple[PlacedHead, ShellPoints]:
    """The head by the distance of points (N, 3) at rest alone."""
    mean, people = speaker.vertices.astype(np.float64), head_modes(speaker)
    frame = bite_plane_of(speaker, speaker.vertices)
    head = PlacedHead(mean, people, np.zeros(len(people)), frame)
    for across, along in MEASURED_FACE.nearing:
        places = sites.nearest(head.vertices, head.seen(points))
        head = head.fitted(points, places, across, along)
    return head, sites.nearest(head.vertices, head.seen(points))


def _by_motion(
    speaker: Speaker,
    sites: Sites,
    head: PlacedHead,
    places: ShellPoints,
    points: FloatArray,
    at_rest: int,
) -> MeasuredHead:
    """The head, and places that move as points (T, N, 3) do."""
    used = [k for k, n in enumerate(speaker.unit_names) if n not in _STILL]
    units = speaker.units[used].astype(np.float64)
    own = np.zeros((len(points), len(used)))
    moving = np.arange(len(points)) != at_rest
    for number in range(MEASURED_FACE.rounds + 1):
        seen = head.seen(points)
        moved = seen[moving] - places.at(head.vertices)
        own[moving] = unit_weights(moved, places.at(units), MEASURED_FACE.noise)
        if number == MEASURED_FACE.rounds:
            break
        moves = np.tensordot(own, units, 1)
        better = slid(
            head.vertices, moves, places, seen, at_rest, MEASURED_FACE.noise, MEASURED_FACE.sliding
        )
        places = sites.nearest(head.vertices, better)
        head = head.fitted(points[at_rest], places, MEASURED_FACE.across, MEASURED_FACE.along)
    left = seen - places.at(head.vertices) - np.tensordot(own, places.at(units), 1)
    weights = np.zeros((len(points), len(speaker.unit_names)))
    weights[:, used] = own
    made = MeasuredHead(speaker, head.vertices, head.frame, places, weights, left)
    _check_likely(made, head)
    return made


def _check_count(built: Build) -> None:
    names, groups = built.model.names, built.model.groups
    lips = sum(name in groups.get(LIPS, ()) for name in names)
    teeth = sum(name in groups.get("lower_teeth", ()) for name in names)
    others = len(names) - lips - teeth
    least = MEASURED_FACE.least, MEASURED_FACE.least_lips, MEASURED_FACE.least_others
    if len(names) < least[0] or lips < least[1] or others < least[2]:
        raise TooFewPointsError(
            f"{len(names)} points, {lips} of them about the lips and {others} elsewhere on the "
            "skin, do not make a face",
            f"measure {least[0]} or more, {least[1]} about the lips and {least[2]} elsewhere",
        )


def _check_likely(made: MeasuredHead, head: PlacedHead) -> None:
    """Raise `ParameterError` where the points are on no head that a person might have."""
    unusual = float(np.sqrt((head.identity**2).mean()))
    if not (made.misfit <= MEASURED_FACE.farthest and unusual <= MEASURED_FACE.unlikely):
        raise ParameterError(
            f"the points do not fit a head: the nearest lies {made.misfit:.1f} mm off (at most "
            f"{MEASURED_FACE.farthest:g}) and {unusual:.1f} standard deviations from the average "
            f"(at most {MEASURED_FACE.unlikely:g}; both RMS)",
            "check the groups of the points, their unit, and their frame: that of the upper teeth, "
            "x to the subject's left, y up, z forward",
        )
