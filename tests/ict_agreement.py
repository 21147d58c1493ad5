"""How tracked films of ICT heads (`ict_films.py`) agree with their truth.

Run it by hand: `python tests/ict_agreement.py RUNS FILMS [HEAD]`, where RUNS/film_K is the folder
that `abs-engine track FILMS/film_K.mp4 -o RUNS/film_K` made, with the bundled head or with HEAD.
Frames that were not found are counted and left out.

Our head frame differs from ICT's by a convention that no run knows of. It is taken from the two
average heads, once for all films: the rotation of the similarity that lays 52 of the 68 usual
landmarks (all but the jaw line, of which only the chin) on each other. What it leaves of a
rotation's error is partly a constant of each person's: people's own faces differ from the average
one by 1 to 4 degrees of nodding. `own` is the error where the convention is each person's: the same
landmarks of the true head are laid on our average one, which is where a tracker that has only seen
the person can put the frame. `laid` is the error where the convention is the rotation that lays
the fitted head's landmarks on the true head's, of brows, eyes and nose only: no posture moves these
much, and a fitted head comes in the mean posture. `motion` is the error less each film's own mean.
Sizes and depths are compared in mm: those of a film whose camera was not given to the
tracker tell of its guessed focal length.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.io.assets import CLOSED_APERTURE, Speaker, load_speaker
from abs_engine.tracking.results.run_mesh import load_mesh
from abs_engine.tracking.runs.record import load_run

FloatArray = NDArray[np.float64]

COMMON = np.r_[8, 17:68]
"""The chin and all points but the jaw line's: jaw lines are chosen differently on each head."""
RIGID = np.arange(17, 48)
"""Brows, nose and eyes."""
EYE_CORNERS = (36, 45)
"""The outer ones: the right eye's, the left eye's."""


@dataclass(frozen=True)
class Agreement:
    """Figures of a film, or means of many; NaN where nothing was found.

    Parameters
    ----------
    found, frames : float
        Frames.
    turn, turn_rms, turn_95 : float
        Median, RMS and 95th percentile of the rotation's error, degrees.
    motion, motion_rms, motion_95 : float
        The same less the film's mean offset.
    offset : float
        That offset, degrees.
    nod : float
        How far the true person's landmarks are turned against the average head's, degrees: the
        offset of a tracker that lays each person's own face right.
    own : float
        Median of the rotation's error, the true person laid on our average head.
    own_pitch : float
        Mean error of that kind about the axis through the ears, degrees; up is positive.
    laid : float
        Median of the rotation's error, the fitted head laid on the true one.
    size : float
        Tracked distance of the outer eye corners over the true one.
    depth : float
        Median of tracked depth over true depth, of the middle between the eye corners.
    place : float
        Median error of that middle, pixels.
    r_aperture, aperture, scaled : float
        Correlation; RMS error, mm; the same after the best scale.
    precision, recall : float
        Of closed frames.
    closed : float
        Frames that are closed in truth, of those found.
    r_width : float
    r_across : float
        Correlation of how far the outer contour reaches across the face.
    score : float
        Mean.
    """

    found: float
    frames: float
    turn: float
    turn_rms: float
    turn_95: float
    motion: float
    motion_rms: float
    motion_95: float
    offset: float
    nod: float
    own: float
    own_pitch: float
    laid: float
    size: float
    depth: float
    place: float
    r_aperture: float
    aperture: float
    scaled: float
    precision: float
    recall: float
    closed: float
    r_width: float
    r_across: float
    score: float


def convention(
    speaker: Speaker, average: FloatArray, head: NDArray[np.floating] | None = None
) -> FloatArray:
    """Rotation (3, 3) from ICT's head frame to ours, of ICT's average landmarks (68, 3).

    With a fitted head (V, 3), of the landmarks of one person.
    """
    own, which = (speaker.vertices, COMMON) if head is None else (head, RIGID)
    ours = own[speaker.points["landmark_68"]].astype(np.float64)[which]
    theirs = average[which]
    turn, _ = Rotation.align_vectors(ours - ours.mean(axis=0), theirs - theirs.mean(axis=0))
    return np.asarray(turn.as_matrix())


def spread(angles: FloatArray) -> tuple[float, float, float]:
    """Median, RMS and 95th percentile."""
    rms = np.sqrt((angles**2).mean())
    return float(np.median(angles)), float(rms), float(np.percentile(angles, 95))


def turns(
    ours: FloatArray, true: FloatArray, between: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Errors (T,) of rotations, the same less their mean, and the mean, in degrees.

    Parameters
    ----------
    ours : (T, 3) rotation vectors, our head frame to the camera
    true : (T, 3, 3), ICT's head frame to the camera
    between : (3, 3), ICT's head frame to ours
    """
    tracked = Rotation.from_rotvec(ours)
    error = tracked.inv() * Rotation.from_matrix(true @ between.T)  # within our head frame
    mean = error.mean()
    left = error * mean.inv()
    return (
        *(np.degrees(e.magnitude()) for e in (error, left)),
        float(np.degrees(mean.magnitude())),
    )


def correlation(one: FloatArray, other: FloatArray) -> float:
    """Pearson's; NaN where one of them is constant."""
    if len(one) < 2 or one.std() == 0 or other.std() == 0:
        return float("nan")
    return float(np.corrcoef(one, other)[0, 1])


def ratio(part: float, whole: float) -> float:
    """A share; NaN of nothing."""
    return float(part / whole) if whole else float("nan")


def rms(error: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt((error**2).mean()))


def eye_corners(vertices: NDArray[np.floating], marks: NDArray[np.integer]) -> FloatArray:
    """The outer eye corners (2, 3) of vertices (V, 3), by the vertices of the 68 landmarks."""
    return np.asarray(vertices[marks[list(EYE_CORNERS)]], np.float64)


def middle_path(corners: FloatArray, rotation: FloatArray, translation: FloatArray) -> FloatArray:
    """The middle between the eye corners (T, 3), mm, camera frame."""
    return np.asarray(corners.mean(axis=0) @ np.swapaxes(rotation, 1, 2) + translation)


def pixels(points: FloatArray, matrix: FloatArray) -> FloatArray:
    """Pixels (T, 2) of points (T, 3)."""
    seen = points @ matrix.T
    return np.asarray(seen[:, :2] / seen[:, 2:])


def places(
    run: Mapping[str, Any], true: Mapping[str, Any], eyes: tuple[FloatArray, FloatArray]
) -> tuple[float, float]:
    """Median ratio of depths, and median distance in pixels, of the middles between the eyes."""
    ours = middle_path(
        eyes[0], Rotation.from_rotvec(run["rotation"]).as_matrix(), run["translation"]
    )
    theirs = middle_path(eyes[1], true["rotation"], true["translation"])
    apart = pixels(ours, run["camera_matrix"]) - pixels(theirs, true["camera_matrix"])
    depth = np.median(ours[:, 2] / theirs[:, 2])
    return float(depth), float(np.median(np.linalg.norm(apart, axis=1)))


def apertures(ours: FloatArray, true: FloatArray) -> tuple[float, ...]:
    """Correlation, RMS, RMS after the best scale; precision and recall of closures; closures."""
    scale = ratio(float(ours @ true), float(ours @ ours))
    shut, truly = ours < CLOSED_APERTURE, true < CLOSED_APERTURE
    met = int((shut & truly).sum())
    scaled = rms(true - scale * ours) if np.isfinite(scale) else rms(true)
    return (
        correlation(ours, true),
        rms(ours - true),
        scaled,
        ratio(met, int(shut.sum())),
        ratio(met, int(truly.sum())),
        float(truly.sum()),
    )


def nodded_up(ours: FloatArray, true: FloatArray, between: FloatArray) -> float:
    """How far tracked heads look up beyond true ones, mean, degrees; arguments as of `turns`."""
    error = Rotation.from_rotvec(ours).inv() * Rotation.from_matrix(true @ between.T)
    return float(np.degrees(error.mean().as_rotvec()[0]))


def across(points: FloatArray) -> FloatArray:
    """How far contours (T, N, 3) reach across the face, (T,), mm."""
    return np.asarray(np.ptp(points[..., 0], axis=1), np.float64)


_BOTH = ("rotation", "translation", "aperture", "width")


def agreement(folder: Path, film: Path, speaker: Speaker) -> Agreement:
    """What a run with a speaker's head makes of a film."""
    run, true = load_run(folder), np.load(film)
    frames = min(len(run["found"]), len(true["aperture"]))
    pose = np.isfinite(run["rotation"][:frames]).all(axis=1)
    at = np.flatnonzero(run["found"][:frames] & pose)
    if not len(at):
        return Agreement(0, frames, *[float("nan")] * (len(fields(Agreement)) - 2))
    ours: dict[str, Any] = {k: run[k][at] for k in (*_BOTH, "lip_points", "score")}
    theirs: dict[str, Any] = {k: true[k][at] for k in (*_BOTH, "outer")}
    ours["camera_matrix"], theirs["camera_matrix"] = run["camera_matrix"], true["camera_matrix"]
    between = convention(speaker, true["average_landmarks"])
    error, left, offset = turns(ours["rotation"], theirs["rotation"], between)
    marks, head = speaker.points["landmark_68"], load_mesh(folder).mean
    person = true["neutral"][true["landmarks"]].astype(np.float64)
    laid_on = [convention(speaker, person, fitted) for fitted in (None, head)]
    own, laid = (spread(turns(ours["rotation"], theirs["rotation"], c)[0])[0] for c in laid_on)
    pitch = nodded_up(ours["rotation"], theirs["rotation"], laid_on[0])
    nod = float(np.degrees(Rotation.from_matrix(laid_on[0] @ between.T).magnitude()))
    eyes = eye_corners(head, marks), eye_corners(true["neutral"], true["landmarks"])
    lengths = [np.linalg.norm(np.diff(e, axis=0)) for e in eyes]
    return Agreement(
        len(at), frames, *spread(error), *spread(left), offset, nod, own, pitch, laid,
        float(lengths[0] / lengths[1]), *places(ours, theirs, eyes),
        *apertures(ours["aperture"], theirs["aperture"]),
        correlation(ours["width"], theirs["width"]),
        correlation(across(ours["lip_points"]), across(theirs["outer"])),
        float(ours["score"].mean()),
    )  # fmt: skip


def line(name: str, a: Agreement) -> str:
    """A film's two lines."""
    return (
        f"{name:8} found {a.found:.0f} of {a.frames:.0f}  "
        f"rotation {a.turn:.1f} deg (rms {a.turn_rms:.1f}, 95 % {a.turn_95:.1f}), "
        f"motion {a.motion:.1f} (rms {a.motion_rms:.1f}, 95 % {a.motion_95:.1f}), "
        f"offset {a.offset:.1f}, nod {a.nod:.1f}, own {a.own:.1f} "
        f"(up {a.own_pitch:.1f}), laid {a.laid:.1f}  "
        f"size x{a.size:.3f}  depth x{a.depth:.3f}  eyes {a.place:.1f} px\n"
        f"{'':8} aperture r {a.r_aperture:.3f}, {a.aperture:.2f} mm rms (scaled {a.scaled:.2f})  "
        f"closures precision {a.precision:.2f}, recall {a.recall:.2f} of {a.closed:.0f}  "
        f"width r {a.r_width:.3f} (outline {a.r_across:.3f})  score {a.score:.3f}"
    )


def mean(found: list[Agreement]) -> Agreement:
    """Means of all films, each without its NaNs; frames and closures are summed."""
    values = np.array([astuple(a) for a in found])
    some = np.isfinite(values)
    count = np.maximum(1, some.sum(axis=0))
    total = np.where(some, values, 0).sum(axis=0)
    means = np.where(some.any(axis=0), total / count, np.nan)
    summed = [f.name in ("found", "frames", "closed") for f in fields(Agreement)]
    return Agreement(*(float(v) for v in np.where(summed, total, means)))


def table(runs: Path, films: Path, speaker: Speaker) -> str:
    """The lines of all films that were tracked, and their means."""
    names = sorted(p.stem for p in films.glob("film_*.npz") if (runs / p.stem).is_dir())
    found = [agreement(runs / name, films / f"{name}.npz", speaker) for name in names]
    lines = [line(name, a) for name, a in zip(names, found, strict=True)]
    return "\n".join([*lines, line("all", mean(found))]) + "\n"


if __name__ == "__main__":
    own = load_speaker(Path(sys.argv[3]) if len(sys.argv) > 3 else None)
    sys.stdout.write(table(Path(sys.argv[1]), Path(sys.argv[2]), own))
