"""The `speaker` command."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from abs_engine.cli.commands import _renderer
from abs_engine.cli.progress import Progress
from abs_engine.cli.track import count
from abs_engine.io.files import check_free


def add_speaker(command: ArgumentParser) -> None:
    """Add what is typed after `speaker`."""
    add = command.add_argument
    add("recordings", type=Path, nargs="+", metavar="VIDEO|RUN",
        help="videos of one person who speaks, by one camera; or runs of such videos, which spares "
        "tracking them first (the video lies beside its run, or in this folder)")  # fmt: skip
    add("-o", "--output", type=Path, metavar="FILE", required=True,
        help="the face, for 'track --model'; must not exist")  # fmt: skip
    add("--rounds", type=count, default=2, metavar="N",
        help="how often it is learned, each time from what the face before found; the one that "
        "explains frames that were left out best is kept (default: 2)")  # fmt: skip
    add("--camera", type=Path, metavar="FILE", help="camera.json of the camera's calibration")
    add("--pupil-distance", type=float, metavar="MM",
        help="distance between the person's pupils; sets the scale (default: 63.4)")  # fmt: skip
    add("--speaker", type=Path, metavar="FILE", help="head.npz of another head")


def speaker(chosen: Namespace) -> int:
    """Learn a person's face from recordings."""
    check_free(chosen.output)
    from abs_engine.dataset import load_camera
    from abs_engine.io.video import probe
    from abs_engine.tracking.options import TrackOptions
    from abs_engine.tracking.recordings import check_one_camera, load_recording
    from abs_engine.tracking.speaker_learning import learn_speaker, tracked

    options = TrackOptions(
        camera=None if chosen.camera is None else load_camera(chosen.camera),
        pupil_distance=chosen.pupil_distance,
        speaker=chosen.speaker,
    )
    paths = list(dict.fromkeys(chosen.recordings))
    runs = {path: load_recording(path) for path in paths if path.is_dir()}
    videos = {path: runs[path].video if path in runs else path for path in paths}
    check_one_camera([(video, probe(video).size) for video in videos.values()])
    with _renderer(chosen.renderer) as renderer, Progress("learning") as progress:
        recordings = []
        for number, path in enumerate(paths, 1):
            if path not in runs:
                progress.announce(f"tracking recording {number} of {len(paths)}, {path.name}")
                runs[path] = tracked(path, renderer, options, lambda _stage: None)
            recordings.append(runs[path])
        done = learn_speaker(recordings, renderer, options, chosen.rounds, progress.announce)
        done.face.save(chosen.output)
    print("\n".join([*done.lines(), f"wrote {chosen.output}"]))
    return 0
