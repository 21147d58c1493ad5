"""Faces learned from three clips, tried on two more, by another camera in another light.

Run it by hand, on films of ICT heads or of people drawn by chance:

    python tests/ict_films.py FILMS --films 20 --clips 5 --frames 50 --seed 7
    python tests/speaker_films.py FILMS WORK
    abs-engine synth tests/data/speakers.toml -o DATASET
    python tests/speaker_films.py DATASET WORK

WORK gets PERSON.face, and runs of the last two clips: without it, with it, and with it in the
colours of the run without it (`--colours`). Cameras are given, and so is the distance of the
pupils, where faces are learned and where strangers are tracked. Lips are compared in the head's
coordinates, less one rigid motion for each clip, as by `evaluate`: of ICT heads, which share no
vertices with ours, at the places of `ict_motion.py`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np
from ict_agreement import apertures
from ict_motion import lips_of
from numpy.typing import NDArray

from abs_engine.dataset import load_dataset
from abs_engine.evaluate.metrics import without_constant_offset
from abs_engine.io.assets import load_speaker
from abs_engine.tracking.person.scale import pupil_distance
from abs_engine.tracking.runs.record import load_run

FloatArray = NDArray[np.float64]
CLIPS, LEARNED = 5, 3
WAYS = ("stranger", "face", "face, its colours")


@dataclass(frozen=True)
class Clip:
    """A clip and its truth.

    Parameters
    ----------
    name : str
    video, camera : Path
    pupils : float, mm
    truth : Path
        A film's, or the view of a dataset.
    """

    name: str
    video: Path
    camera: Path
    pupils: float
    truth: Path


@dataclass(frozen=True)
class Score:
    """Figures of a run.

    Parameters
    ----------
    found : float, share of the frames
    lips, across : float, mm
        RMS of lip points, less one rigid motion; NaN of `across` where it is not measured.
    r, aperture : float, and mm
        Correlation and RMS of apertures.
    precision, recall : float
        Of closed frames.
    frame : float, s
        Wall time of one.
    """

    found: float
    lips: float
    across: float
    r: float
    aperture: float
    precision: float
    recall: float
    frame: float


def people(folder: Path) -> Iterator[tuple[str, list[Clip]]]:
    """Each person's clips, of films or of a dataset."""
    clips = list(_filmed(folder) if list(folder.glob("film_*.npz")) else _dataset(folder))
    for k in range(0, len(clips), CLIPS):
        yield clips[k].name, clips[k : k + CLIPS]


def _filmed(folder: Path) -> Iterator[Clip]:
    for k in range(len(list(folder.glob("film_*.npz")))):
        truth = folder / f"film_{k}.npz"
        pupils = float(np.load(truth)["pupil_distance"])
        yield Clip(
            truth.stem, truth.with_suffix(".mp4"), folder / f"camera_{k}.json", pupils, truth
        )


def _dataset(folder: Path) -> Iterator[Clip]:
    for view in sorted(load_dataset(folder), key=lambda v: v.folder.parent.name):
        pupils = pupil_distance(load_speaker(), view.neutral)
        camera = view.folder / "camera.json"
        yield Clip(view.folder.parent.name, view.video, camera, pupils, view.folder)


def command(*words: object) -> None:
    """Run one of ours."""
    subprocess.run([sys.executable, "-m", "abs_engine", *map(str, words), "--quiet"], check=True)


def learned(clips: list[Clip], work: Path) -> Path:
    """The face of the first clips of a person."""
    face, first = work / f"{clips[0].name}.face", clips[0]
    if not face.exists():
        videos = [c.video for c in clips[:LEARNED]]
        given = ("--camera", first.camera, "--pupil-distance", first.pupils, "--renderer", "cpu")
        command("speaker", *videos, "-o", face, *given)
    return face


def tracked(clip: Clip, face: Path, work: Path) -> list[Path]:
    """Runs of a clip in all ways."""
    outs = [work / f"{clip.name}-{k}" for k in range(len(WAYS))]
    given = ("--camera", clip.camera, "--renderer", "cpu")
    own = ("--model", face)
    more = (("--pupil-distance", clip.pupils), own, (*own, "--colours", outs[0] / "colours.npz"))
    for out, options in zip(outs, more, strict=True):
        if not out.exists():
            command("track", clip.video, "-o", out, *given, *options)
    return outs


def ict_lips(folder: Path, truth: Path) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Errors of the lips (T, N, 3), less one rigid motion, and apertures (T,), ours and true."""
    run, true = load_run(folder), np.load(truth)
    ours, theirs = lips_of(run, true, load_speaker())
    off = without_constant_offset(ours, theirs) - theirs
    at = np.flatnonzero(run["found"])
    return off, run["aperture"][at], true["aperture"][at]


def score(folder: Path, truth: Path) -> Score:
    """What a run of a clip is worth."""
    run, timing = load_run(folder), json.loads((folder / "timing.json").read_text())
    found, frame = float(np.mean(run["found"])), timing["seconds_per_frame"]
    if truth.suffix == ".npz":
        off, ours, true = ict_lips(folder, truth)
        r, aperture, _, precision, recall, _ = apertures(ours, true)
        lips, across = (float(np.sqrt((o**2).sum(axis=-1).mean())) for o in (off, off[..., :2]))
        return Score(found, lips, across, r, aperture, precision, recall, frame)
    scores = folder / "evaluation" / "scores.json"
    if not scores.exists():
        command("evaluate", folder, "--truth", truth)
    s = {k: v["value"] for k, v in json.loads(scores.read_text())["systems"][folder.name].items()}
    return Score(
        found, s["lip_points_rms_head_offset_removed_mm"], float("nan"),
        s["aperture_correlation"], s["aperture_rms_mm"], s["closure_precision_frames"],
        s["closure_recall_frames"], frame,
    )  # fmt: skip


def line(name: str, scores: list[Score]) -> str:
    """The mean of some scores."""
    rows = np.array([astuple(s) for s in scores], float)
    means = zip(fields(Score), np.nanmean(rows, axis=0), strict=True)
    return f"{name:34} " + "  ".join(f"{f.name} {value:.3f}" for f, value in means) + "\n"


def main(folder: Path, work: Path) -> None:
    """Print the scores of each person, each way, and of all."""
    work.mkdir(parents=True, exist_ok=True)
    every: dict[str, list[Score]] = {way: [] for way in WAYS}
    for name, clips in people(folder):
        face = learned(clips, work)
        runs = {c: tracked(c, face, work) for c in clips[LEARNED:]}
        for k, way in enumerate(WAYS):
            own = [score(outs[k], clip.truth) for clip, outs in runs.items()]
            every[way] += own
            sys.stdout.write(line(f"{name} {way}", own))
        sys.stdout.flush()
    for way, scores in every.items():
        sys.stdout.write(line(f"all {way}", scores))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:3]))
