"""The `track` command."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.clips import are_many, track_clips
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened, print_hints
from abs_engine.cli.parts.given_files import check_files, track_options
from abs_engine.cli.parts.progress import Progress, say
from abs_engine.cli.parts.settings import SETTINGS, settings_option, settings_text
from abs_engine.cli.parts.summary import summary_lines, without_tuning
from abs_engine.core.registry import DRIVERS, MODELS, PRESETS, TERMS, load_plugins
from abs_engine.core.words import joined
from abs_engine.io.unfinished import check_output

if TYPE_CHECKING:
    from abs_engine.io.video import VideoInfo
    from abs_engine.optimise.drivers import Need

_POSES = """\
Head poses come from a run or filmed truth (its folder), or from a file:
  CSV   a line of names, then a row for each frame: head_rx head_ry head_rz (rotation vector,
        radians) and head_tx head_ty head_tz (mm), as results.csv of a run; empty where not known
  NPZ   rotation, (T, 3) vectors or (T, 3, 3) matrices, and translation (T, 3), as results.npz of a
        run; NaN, or False in found, where not known
x_cam = R x_head + t, from the head (x to the subject's left, y up, z out of the face) to the camera
(x right, y down, z forward): a face that looks into it is turned by half a turn about x. Poses are
taken as they are with --person; those of an unknown person are aligned with the fitted head.
Frames without a pose are not tracked.
"""


def _notes() -> str:
    """Formats of files, and what can be chosen by name."""
    kinds = ("presets", PRESETS), ("models", MODELS), ("terms", TERMS), ("drivers", DRIVERS)
    names = [f"{title + ':':<10}{', '.join(registry)}\n" for title, registry in kinds]
    return f"{_POSES}\n{''.join(names)}{''.join(_needs())}"


def _needs() -> Iterator[str]:
    """Lines about the evidence that drivers need, of those that can be imported."""
    from abs_engine.fit.terms import served

    (drivers, _), (kinds, _) = DRIVERS.working(), TERMS.working()
    by_need: dict[Need, list[str]] = {}
    for name, driver in drivers.items():
        by_need.setdefault(driver.needs, []).append(name)
    for need, names in by_need.items():
        gives, refused = served(need, kinds)
        if need == "values" or not gives:
            continue
        verb, taken = ("needs", "takes") if len(names) == 1 else ("need", "take")
        line = f"{joined(names, 'and')} {verb} {joined(gives, 'or')}"
        yield f"{line}, and {taken} no {joined(refused, 'or')}\n" if refused else f"{line}\n"


@command(
    "Track and look at the result",
    take.argument("videos", "VIDEO...", "a video of somebody who speaks to the camera, or several",
        nargs=-1, required=True),
    take.output("RUN", "folder of the results, for several videos a folder for each; after an "
        "interruption the same command resumes"),
    settings_option(),
    *take.group(
        "Who is tracked, and where",
        take.option("--face", type=take.count, metavar="N",
            text="which face to track, counted from 1, the largest first (default: the largest)"),
        take.option("--mouth", type=take.number, nargs=4, metavar="X Y W H",
            text="box around the mouth to track in the first frame, pixels (default: it is found)"),
        take.option("--worn", is_flag=True,
            text="the camera is worn in front of the mouth: a close-up of the lower face, in which "
            "the head does not move; no face is needed"),
        take.option("--pupil-distance", type=take.number, metavar="MM",
            text="distance between the person's pupils; sets the scale and is enforced "
            "(default: 63.4, the adult mean, enforced less strictly)"),
        take.person("a known head: one of the speaker's people (bundled: clara, kofi, mei, "
            "walter, amara, ravi); default: the average head, whose mouth is fitted"),
        take.file("--speaker", "head.npz of another speaker"),
        take.file("--camera", "camera.json of the camera's calibration"),
        take.file("--colours",
            "colours.npz of a run of the same person and light (default: learn them)"),
        take.file("--physics", "how the lips move, as 'train' learned it"),
        take.file("--poses",
            "known head poses, see below"),
    ),
    *take.group(
        "How it is tracked; names below",
        take.option("--preset", metavar="NAME", type=take.Named(PRESETS),
            text="a model, evidence, driver and start that belong together"),
        take.option("--model", metavar="NAME", type=take.Named(MODELS, or_file=True),
            text="what is tracked: a name, or the file of a model (default: head)"),
        take.option("--terms", metavar="NAME+NAME", type=take.Named(TERMS, join="+"),
            text="evidence that is rendered and compared, names joined by + (default: "
            "colour+shading for a head or a speaker's own face, colour with --start blobs or "
            "another model, opening for a close-up)"),
        take.option("--driver", metavar="NAME", type=take.Named(DRIVERS),
            text="what moves the parameters (default: newton for a head or a speaker's own face "
            "seen by colour, else simplex)"),
        take.option("--start", type=take.Choice(("landmarks", "blobs")),
            text="how an unknown head is placed: by a landmark network, or by colour as in the "
            "papers (default: landmarks)"),
        take.option("--evidence", type=take.Choice(("both", "rendering", "landmarks")),
            default="both", text="kinds of evidence to use in each frame (default: both)"),
        take.file("--plugin", multiple=True, metavar="FILE.py",
            text="Python file that adds models, terms, drivers or renderers of your own; may be "
            "repeated"),
        take.renderer(),
    ),
    *take.group(
        "What is written",
        take.option("--smooth", metavar="FILTER:N",
            text="also write smoothed.csv, the measures smoothed by butterworth:HZ (the cutoff) or "
            "savitzky-golay:FRAMES (the window) (default: nothing is smoothed)"),
    ),
    *take.group(
        "Many videos; a table of them is written, and one that fails stops no other",
        take.option("--workers", type=take.count, metavar="N",
            text="how many to track at once, each on one core (default: as many as there are "
            "cores)"),
        take.option("--scheduler", metavar="tcp://HOST:PORT",
            text="track with the workers of this Dask scheduler instead"),
    ),
    examples="abs-engine track talk.mp4 -o tracked\n"
    "abs-engine track talk.mp4 -o scaled --pupil-distance 61.5 --renderer cpu\n"
    "abs-engine track other.mp4 -o same-way --settings tracked/settings.toml\n"
    "abs-engine track close-up.avi -o lips --worn --model mouths.face\n"
    "abs-engine track talk.mp4 -o simplex --driver simplex --json --quiet\n"
    "abs-engine track clips/*.mp4 -o runs --workers 4",
    notes=_notes,
)  # fmt: skip
def track(chosen: Chosen) -> Done:
    """Track the lips in a video, or in many."""
    if are_many(chosen):
        return _many(chosen)
    from abs_engine.io.video import probe

    (video,) = chosen.videos
    check_output(chosen.output)
    info = probe(video)  # says what is wrong before anything slow is loaded

    from abs_engine.core.threads import begin
    from abs_engine.tracking.detection.face_choice import FaceChoice
    from abs_engine.tracking.detection.first_look import first_look
    from abs_engine.tracking.start import beforehand

    usual = chosen.model is None and chosen.preset is None and chosen.start != "blobs"
    usual &= not chosen.worn
    begin(beforehand.load, chosen.pupil_distance, usual and not (chosen.person or chosen.speaker))
    bundled = chosen.person and not chosen.speaker  # found by its texture
    if not usual or bundled or chosen.poses is not None:
        return _tracked(chosen, info)
    with first_look(video, FaceChoice.asked(chosen.face, chosen.mouth)):
        return _tracked(chosen, info)


def _tracked(chosen: Chosen, info: VideoInfo) -> Done:
    from abs_engine.tracking.option_checks import check_options
    from abs_engine.tracking.person.scale import scale_line
    from abs_engine.tracking.run import track_video
    from abs_engine.tracking.runs.output import OVERLAY, SHEET

    load_plugins(chosen.plugin)
    options = track_options(chosen)
    check_options(options, info)  # what cannot be is said before a renderer is opened
    check_files(options)
    with opened(chosen.renderer) as renderer, Progress("tracking") as progress:
        print_hints(renderer)
        run = track_video(
            chosen.videos[0],
            chosen.output,
            renderer,
            options,
            progress,
            progress.restart,
            progress.announce,
            progress.remark,
            beside={SETTINGS: settings_text(track, vars(chosen), chosen.output)},
        )
    lines = [
        *summary_lines(run["summary"], run["timing"], run["settings"]["remarks"]),
        scale_line(run["settings"]["scale"]),
        f"wrote {chosen.output}; look at {chosen.output / SHEET} or {chosen.output / OVERLAY}",
    ]
    return Done(lines, {"output": chosen.output, **without_tuning(run)})


def _many(chosen: Chosen) -> Done:
    from abs_engine.io.video.source import all_of, as_video, is_still
    from abs_engine.tracking.option_checks import check_choices

    load_plugins(chosen.plugin)
    options = track_options(chosen)
    check_choices(options)  # what cannot be for any of them
    check_files(options)
    if len(chosen.videos) > 1 and all(map(is_still, chosen.videos)):
        say(
            "each picture is tracked as a clip of its own; if they are the frames of one, "
            + as_video(all_of(chosen.videos))
        )
    return track_clips(track, chosen, options)
