"""Faces of a speaker by how much of them is given: see `GIVEN`, `MEASURED` and `TRACKED`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from abs_engine.capture.viseme_pictures import VisemePicture
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import (
    CalibrationError,
    DegenerateViewsError,
    FaceNotFoundError,
    NothingSeenError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.face.talking_file import save_talking
from abs_engine.io.files import png
from abs_engine.io.naming import made_before
from abs_engine.learn.articulatory import Build, build
from abs_engine.learn.measured.face import measured_face
from abs_engine.learn.training import checksum
from abs_engine.papers.odisio2004.gathered import Report
from abs_engine.papers.odisio2004.reproduce import FACE
from abs_engine.papers.odisio2004.tracked_beads import tracked_corpus
from abs_engine.papers.odisio2004.visemes import Speech
from abs_engine.tracking.models.measured_looks import with_looks

GIVEN, MEASURED, TRACKED = "given", "measured", "tracked beads"
"""Faces: of the true head and the true poses of its pictures; of points with drawn errors, poses
estimated; of dots that two cameras saw and the project followed, poses estimated."""


@dataclass(frozen=True, eq=False)
class KnownFace:
    """Knowledge of a speaker whose sentences are tracked.

    Parameters
    ----------
    path : Path or None
        File of the face; None where none could be made.
    postures : (V, P) float64
        Parameters of the corpus' visemes, as the face has them.
    """

    path: Path | None
    postures: FloatArray


def faces_of(report: Report, bare: Speech, folder: Path) -> dict[str, KnownFace]:
    """Each of the faces, made in a folder if need be; appearance is learned from `bare`."""
    tracked = _tracked(report, bare, folder)
    return {
        GIVEN: KnownFace(report.folder / FACE, bare.built.alpha),
        MEASURED: _made(report, bare, bare.built, folder / f"{MEASURED}.face"),
        TRACKED: _made(report, bare, tracked, folder / f"{TRACKED}.face"),
    }


def _tracked(report: Report, bare: Speech, folder: Path) -> Build | None:
    """The model of the visemes' tracked dots, if they can be observed."""
    report.tell("a session of tracked dots")
    try:
        corpus = tracked_corpus(bare.spoken, bare.person, report.seed, folder, report.command)
        return build(corpus, missing="impute")
    except (CalibrationError, DegenerateViewsError, ParameterError, TooFewPointsError) as error:
        report.tell(f"no tracked dots: {error}")
        return None


def _made(report: Report, bare: Speech, built: Build | None, path: Path) -> KnownFace:
    """The face of points and what their model says of the pictures' postures."""
    if built is None:
        return KnownFace(None, bare.built.alpha)
    try:
        if not made_before(path):
            report.tell(f"a face: {path.stem}")
            _write(report, bare, built, path)
    except (FaceNotFoundError, NothingSeenError, ParameterError, TooFewPointsError) as error:
        report.tell(f"no face '{path.stem}': {error}")
        return KnownFace(None, built.alpha)
    return KnownFace(path, built.alpha)


def _write(report: Report, bare: Speech, built: Build, path: Path) -> None:
    table = []
    seen = bare.pictures
    for k, (viseme, picture) in enumerate(zip(seen.visemes, seen.pictures, strict=True)):
        own = path.parent / f"viseme_{k:03d}.png"
        own.write_bytes(png(picture))
        table.append(VisemePicture(own, viseme, None))
    made = measured_face(report.speaker, built)
    looks = with_looks(made, built, table, seen.camera, report.renderer, report.tell)
    save_talking(path, looks, path.stem, checksum(report.speaker), made.neutral)
