"""The `evaluate` command."""

from __future__ import annotations

import json

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.core.errors import OutputError

_FORMATS = """\
CSV files, with the column names in the first line:
  landmarks, a row per point  frame,point,x,y,unit, optionally time,z,space: point 0 to 67 in the
                              order of 300-W, unit px or mm, space camera (default) or head
  landmarks, a row per frame  frame, x_0 to y_67 in px and/or X_0 to Z_67 in mm, camera coordinates;
                              optionally timestamp, success, pose_Tx to pose_Rz (as OpenFace 2)
  ARKit, a row per frame      the 52 face units; optionally Timecode, HeadYaw, HeadPitch, HeadRoll
                              (as Live Link Face)
Every frame of the clip must be there, counted from 0 or 1; cells of lost frames are empty.
Numbers in brackets are 95 % confidence intervals.
"""


@command(
    "Film ground truth and score against it",
    take.argument("results", "RUN...", nargs=-1, required=True,
        text="what 'track -o' made, or a CSV file of another system"),
    take.file("--truth", many=True, metavar="DIR...", required=True,
        text="what 'synth -o' made, or DATASET/CLIP/CAMERA; one for all, or one for each RUN, "
        "which are then also pooled as clips"),
    *take.view(),
    take.metrics(),
    take.output("DIR", "folder of the scores, must not exist (default: RUN/evaluation; "
        "FILE-evaluation beside a file; ./evaluation for several)", False),
    take.seed("the confidence intervals"),
    examples="abs-engine evaluate tracked --truth clip\n"
    "abs-engine evaluate tracked other.csv --truth clip -o scores --json",
    notes=_FORMATS,
)  # fmt: skip
def evaluate(chosen: Chosen) -> Done:
    """Score results, ours or others', against ground truth."""
    from abs_engine.core.registry import load_plugins
    from abs_engine.report.scoring import SCORES, default_folder
    from abs_engine.report.scoring import evaluate as score

    load_plugins(chosen.plugin)
    folder = chosen.output or default_folder(chosen.results)
    view = chosen.clip, chosen.camera
    try:
        done = score(chosen.results, chosen.truth, folder, seed=chosen.seed, view=view)
    except OutputError as error:
        if chosen.output is not None:
            raise
        raise OutputError(error.problem, f"{error.remedy} (-o gives another place)") from error
    scores = json.loads((done.folder / SCORES).read_text(encoding="utf-8"))
    return Done([*done.lines(), f"wrote {done.folder}"], {"output": done.folder, **scores})
