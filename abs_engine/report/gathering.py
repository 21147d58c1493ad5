"""Gathers what a report shows, of runs and other results, with their truth or without."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ModelFormatError, ParameterError
from abs_engine.core.kinds import Kind, check_kind, is_of, to_path
from abs_engine.core.provenance import caution
from abs_engine.core.words import counted, legible
from abs_engine.dataset import Truth
from abs_engine.dataset.sums import digest
from abs_engine.evaluate.catalogue import warn_of_faults
from abs_engine.evaluate.clip_views import shown_view
from abs_engine.evaluate.estimate import of_run
from abs_engine.evaluate.same_clip import video_sum
from abs_engine.evaluate.score import error_map, measure, summary, truth_curves
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.files import check_free, write_new
from abs_engine.io.video import probe, read_frames
from abs_engine.report.data import Head, ReportData, System, TrueClip
from abs_engine.report.drawing.colours import clay_colours
from abs_engine.report.estimate_parts import (
    Loops,
    lip_loops,
    projected,
    speaker_loops,
    system_of,
    with_protrusion,
)
from abs_engine.report.facts import made_facts, origins, run_facts, truth_facts
from abs_engine.report.film import filmed, shorten
from abs_engine.report.inspect.run_video import check_video, find_video
from abs_engine.report.inspect.runs import RunHead, load_run_head
from abs_engine.report.motion import compress
from abs_engine.report.page import report_page
from abs_engine.report.quantities import SURENESS, error_rows, error_series, sureness_series
from abs_engine.report.scoring import landmarks_of, notes_of, read_result, same_mesh
from abs_engine.tracking.results.run_mesh import load_mesh

MOST_PLAYED = 1000
"""Frames that the page's player shows at most, so that the page stays of a size to be sent."""
_PATHS: Kind = (lambda x: isinstance(x, Sequence) and not isinstance(x, str), "a list of paths")


@dataclass(frozen=True)
class ReportOptions:
    """Options of a report.

    Parameters
    ----------
    truth : Path, optional
        A dataset, DATASET/CLIP or DATASET/CLIP/CAMERA; without it the report only shows.
    clip, camera : str, optional
        Which view of the dataset, if its path leaves that open.
    video : Path, optional
        The video that was tracked; by default the truth's, or where the first run says.
    seed : int
        Of the confidence intervals.
    command : str
        Kept in the report.
    speaker : Path, optional
        The head that runs without a truth were tracked with, if not the bundled one.
    """

    truth: Path | None = None
    clip: str | None = None
    camera: str | None = None
    video: Path | None = None
    seed: int = 0
    command: str = ""
    speaker: Path | None = None


DEFAULTS = ReportOptions()


def write_report(
    results: Sequence[Path],
    output: Path,
    options: ReportOptions = DEFAULTS,
    stage: Callable[[str], None] | None = None,
) -> None:
    """Write one HTML file that shows results side by side.

    Parameters
    ----------
    results : sequence of Path
        Runs of this engine; with a truth also CSV files of other systems, as `evaluate` reads
        them.
    output : Path
        Must not exist.
    stage : callable, optional
        Called with what is begun.

    Raises
    ------
    InputFileError, VideoError
        If a result, the truth or the video cannot be read.
    ParameterError
        If a value is of another kind, the results are not all of the same frames, or several views
        are left to choose from.
    OutputError
        If the file exists or cannot be written.
    """
    check_kind("options", options, (is_of(ReportOptions), "ReportOptions"))
    check_kind("results", results, _PATHS)
    paths = [to_path("a result", path) for path in results]
    if not paths:
        raise ParameterError("there is no result to report", "give the folder of a run")
    output = check_free(to_path("output", output))
    if options.video is not None:
        probe(options.video)  # refused before anything is scored
    tell = stage or (lambda _: None)
    if options.truth is None:
        if options.clip is not None or options.camera is not None:
            raise ParameterError("without a dataset there is no clip or camera", "give --truth")
        if options.seed:
            raise ParameterError("a seed is for scores, which need a dataset", "give --truth")
        data = _without_truth(paths, options, tell)
    elif options.speaker is not None:
        raise ParameterError("a dataset brings its own head", "leave out --speaker, or --truth")
    else:
        data = _with_truth(paths, Path(options.truth), options, tell)
    tell("writing the page")
    write_new(output, report_page(data).encode("utf-8"))


def _with_truth(
    paths: Sequence[Path], folder: Path, options: ReportOptions, tell: Callable[[str], None]
) -> ReportData:
    tell("scoring")
    truth, others = shown_view(folder, options.clip, options.camera, paths)
    speaker = load_speaker()
    if options.video is not None:
        wanted = digest(truth.video) if truth.video.is_file() else None
        check_video(options.video, truth.camera.size, len(truth), wanted)
    played = min(len(truth), MOST_PLAYED)
    loops = lip_loops(truth, speaker)
    warn_of_faults()
    named = dict(zip(_names(paths), paths, strict=True))
    scored = [
        _scored(name, path, truth, speaker, loops, options.seed) for name, path in named.items()
    ]
    tell("reading the vertices of the truth")
    true = TrueClip(
        truth_curves(truth),
        projected(truth, truth.rotations, truth.translations, truth.camera, loops),
        Head(compress(truth.vertices, played), truth.rotations, truth.translations),
        np.asarray(truth.closed, bool),
        tuple(truth.intervals),
    )
    tell("reading the video")
    pictures = truth.pictures() if options.video is None else read_frames(options.video)
    shown, systems = filmed(pictures, truth, scored, true, played)
    return ReportData(
        title=f"{truth.person}, '{truth.sentence or truth.name}': tracked and true",
        subtitle=_subtitle(len(truth), truth.rate, truth.camera),
        rate=truth.rate,
        times=np.arange(len(truth)) / truth.rate,
        systems=tuple(systems),
        faces=truth.faces,
        colours=clay_colours(truth.faces, truth.facet_class, truth.class_names, len(truth.neutral)),
        true=true,
        film=shown,
        played=played,
        focus=_focus(truth.neutral[loops["outer"]]),
        area=speaker.points.get("face") if same_mesh(truth, speaker) else None,
        errors=error_rows([system.errors for system in scored]),
        facts=truth_facts(truth, folder) | made_facts(options.command, options.seed),
        view="/".join(truth.folder.parts[-2:]),
        others=others,
        caution=caution(origins(named, folder)) or "",
    )


def _scored(
    name: str, path: Path, truth: Truth, speaker: Speaker, loops: Loops, seed: int
) -> System:
    """Report's view of a result, but for pictures."""
    marks = landmarks_of(truth, speaker)
    estimate = replace(read_result(path, truth, speaker, marks), name=name)
    estimate = with_protrusion(estimate, truth.landmarks)
    clip = measure(estimate, truth, marks)
    errors = error_map(estimate, truth)
    scores = summary([clip], seed=seed)
    return replace(
        system_of(estimate, truth.camera, loops, min(len(truth), MOST_PLAYED)),
        errors=error_series(clip.means),
        scores=scores,
        notes=notes_of(clip, scores),
        error_map=errors if np.isfinite(errors).any() else None,
        facts=run_facts(path),
    )


def _heads(paths: Sequence[Path], speaker: Speaker) -> list[RunHead]:
    """The runs' heads; `ParameterError` if they are of several, as a page has one."""
    try:
        return [load_run_head(path, speaker) for path in paths]
    except ModelFormatError as error:
        if len({load_mesh(path).faces.tobytes() for path in paths}) > 1:
            raise ParameterError(
                f"the runs {', '.join(map(str, paths))} were tracked with different heads",
                "write a report for each head, with its --speaker",
            ) from error
        raise


def _without_truth(
    paths: Sequence[Path], options: ReportOptions, tell: Callable[[str], None]
) -> ReportData:
    tell("reading the runs")
    _check_same_video(paths)
    speaker = load_speaker(options.speaker)
    heads = _heads(paths, speaker)
    if len({len(head) for head in heads}) > 1:
        raise ParameterError(
            f"the runs have {', '.join(str(len(h)) for h in heads)} frames",
            "report runs of the same video",
        )
    first = heads[0]
    video = find_video(first, options.video)
    played = min(len(first), MOST_PLAYED)
    loops = speaker_loops(speaker)
    systems, named = [], dict(zip(_names(paths), paths, strict=True))
    for name, head in zip(named, heads, strict=True):
        estimate = of_run(name, head.arrays, head.mesh, {})
        estimate = with_protrusion(estimate, speaker.landmarks)
        system = system_of(estimate, head.camera, loops, played)
        sureness = sureness_series(head.arrays)
        systems.append(replace(system, sureness=sureness, facts=run_facts(head.folder)))
    tell("reading the video")
    uneven = first.uneven_times
    shown, _ = shorten(read_frames(video), first.rate, played, (), uneven)
    told = _subtitle(len(first), first.rate, first.camera, "" if uneven is None else " on average")
    return ReportData(
        title=f"{video.name}: tracked",
        subtitle=f"{told}; no ground truth",
        rate=first.rate,
        times=first.times,
        systems=tuple(systems),
        faces=speaker.faces,
        colours=clay_colours(
            speaker.faces, speaker.facet_class, speaker.class_names, len(speaker.vertices)
        ),
        film=shown,
        played=played,
        focus=_focus(first.mesh.mean[loops["outer"]]),
        sureness=SURENESS,
        facts=made_facts(options.command, None),
        caution=caution(origins(named)) or "",
    )


def _check_same_video(runs: Sequence[Path]) -> None:
    """Refuse runs that are of different videos, by their checksums."""
    known = [(path, checksum) for path in runs if (checksum := video_sum(path)) is not None]
    for path, checksum in known[1:]:
        if checksum != known[0][1]:
            raise ParameterError(
                f"{path} is of another video than {known[0][0]}", "report runs of the same video"
            )


def _subtitle(frames: int, rate: float, camera: Camera, even: str = "") -> str:
    width, height = camera.size
    return f"{counted(frames, 'frame')} at {rate:g} a second{even}, {width}x{height} pixels"


def _focus(lips: NDArray[Any]) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in np.asarray(lips, np.float64).mean(axis=0))
    return x, y, z


def _names(paths: Sequence[Path]) -> list[str]:
    """The names of the results, with their parent folder where two would be the same."""
    plain = [legible(p.resolve().name if p.is_dir() else p.stem) for p in paths]
    names: list[str] = []
    for path, name in zip(paths, plain, strict=True):
        longer = f"{legible(path.resolve().parent.name)}/{name}" if plain.count(name) > 1 else name
        while longer in (*names, "truth"):
            longer += "'"
        names.append(longer)
    return names
