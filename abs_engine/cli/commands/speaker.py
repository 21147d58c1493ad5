"""The `speaker` command."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened, print_hints
from abs_engine.cli.parts.given_files import track_options
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.words import counted
from abs_engine.io.files import check_free

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from abs_engine.io.assets import Speaker
    from abs_engine.tracking.runs.recordings import Recording
    from abs_engine.tracking.speaker.speaker_learning import Learned

_FEWEST, _SHORTEST = 5, 15.0  # recordings and seconds in all: the fewest that were measured


@command(
    "Learn faces and lips",
    take.argument("recordings", "VIDEO|RUN...",
        "videos of one person speaking, by one camera, or runs of such videos (a run's video must "
        "lie beside it, or in this folder)",
        nargs=-1, required=True, type=take.INPUT),
    take.output("FILE", "the face, for 'track --model'"),
    take.option("--rounds", type=take.count, default=2, metavar="N",
        text="how many times to learn it, each time from what the last face found; the one that "
        "best explains the left-out frames is kept (default: 2)"),
    take.option("--pupil-distance", type=take.number, metavar="MM",
        text="distance between the person's pupils; sets the scale (default: 63.4, adults' mean)"),
    take.file("--speaker", "head.npz of another head"),
    take.file("--camera", "camera.json of the camera's calibration"),
    take.renderer(),
    examples="abs-engine speaker monday.mp4 tuesday.mp4 -o me.face\n"
    "abs-engine track wednesday.mp4 -o tracked --model me.face\n"
    "abs-engine speaker run-1 run-2 run-3 -o me.face --rounds 1 --renderer cpu",
)  # fmt: skip
def speaker(chosen: Chosen) -> Done:
    """Learn a person's face from recordings."""
    check_free(chosen.output, take.FACE)
    from abs_engine.io.assets import load_speaker
    from abs_engine.tracking.detection.face_choice import LARGEST
    from abs_engine.tracking.runs.recordings import check_videos, load_recording
    from abs_engine.tracking.speaker.recorded_frames import camera_used, check_colours
    from abs_engine.tracking.speaker.speaker_learning import learn_speaker, tracked

    options = track_options(chosen)
    head = load_speaker(options.speaker)
    paths = list(chosen.recordings)
    runs = {path: load_recording(path, head) for path in paths if path.is_dir()}
    videos = [runs[path].video if path in runs else path for path in paths]
    choices = [runs[path].choice if path in runs else LARGEST for path in paths]
    size = check_videos(list(zip(paths, videos, strict=True)))
    camera_used(runs.values(), options.camera, size)
    check_colours(list(zip(paths, videos, choices, strict=True)))
    with opened(chosen.renderer) as renderer, Progress("learning") as progress:
        print_hints(renderer)
        for number, path in enumerate(paths, 1):
            if path not in runs:
                progress.announce(f"tracking recording {number} of {len(paths)}, {path.name}")
                runs[path] = tracked(path, renderer, options)
            for line in runs[path].remarks:
                progress.remark(f"{path.name}: {line}")
        _doubt(runs, paths, head, progress)
        recordings = [runs[path] for path in paths]
        few = _few(recordings)
        if few:
            progress.remark(few)
        done = learn_speaker(recordings, renderer, options, chosen.rounds, progress.announce)
        done.face.save(chosen.output)
    facts = {
        "remarks": {str(path): list(runs[path].remarks) for path in paths if runs[path].remarks},
        **_facts(chosen, done),
    }
    return Done([*done.lines(), f"wrote {chosen.output}"], facts)


def _doubt(
    runs: dict[Path, Recording], paths: list[Path], head: Speaker, progress: Progress
) -> None:
    """Remark on a recording that may show another person; refuse one that does."""
    from abs_engine.tracking.runs.same_person import check_same, doubt_same

    recordings = [runs[path] for path in paths]
    check_same(recordings, head)
    doubt = doubt_same(recordings, head)
    if doubt is not None:
        path, line = paths[doubt[0]], doubt[1]
        progress.remark(f"{path.name}: {line}")
        runs[path] = replace(runs[path], remarks=(*runs[path].remarks, line))


def _few(recordings: Sequence[Recording]) -> str:
    """Warning of fewer and shorter recordings than any that were measured; empty where enough."""
    seconds = sum(len(one.postures) / float(one.run["rate"]) for one in recordings)
    if len(recordings) >= _FEWEST or seconds >= _SHORTEST:
        return ""
    return (
        f"warning: {counted(len(recordings), 'recording')} of {seconds:.2g} s in all; {_FEWEST} "
        f"recordings of {_SHORTEST / _FEWEST:.0f} s are enough; with one of 2 s, people who change "
        "their expression are often tracked worse than without a face"
    )


def _facts(chosen: Chosen, done: Learned) -> dict[str, object]:
    shares = zip(done.face.posture.names, done.space.expression.variance, strict=True)
    own = done.face.appearance
    appearance = None
    if own is not None:
        explained = {"texture": own.texture.explained, "local": own.local.explained}
        appearance = {**explained, "points": len(own.local)}
    return {
        "output": chosen.output,
        "frames": done.frames,
        "postures": {name: float(share) for name, share in shares},
        "own_postures": done.space.own,
        "left_out": list(done.space.left_out),
        "appearance": appearance,
        "explained": list(done.explained),
        "round": done.kept,
    }
