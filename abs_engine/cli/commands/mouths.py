"""The `mouths` command."""

from __future__ import annotations

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.words import counted
from abs_engine.io.files import check_free

_NOTES = """\
LABELS is a CSV file with a row for each labelled frame, of any number of videos and speakers:
  video   path of the video, relative to the file's folder
  frame   counted from 0
  left_x left_y right_x right_y             corners of the mouth, on the picture's left and right
  upper_left_x upper_left_y upper_x upper_y upper_right_x upper_right_y      upper inner lip
  lower_left_x lower_left_y lower_x lower_y lower_right_x lower_right_y      lower inner lip
in pixels, whose centres are at integers. Where lips are closed, upper and lower points coincide.
"""


@command(
    "Learn faces and lips",
    take.argument("labels", "LABELS", "a CSV file of points on the inner lips, see below",
        type=take.INPUT),
    take.output("FILE", "what mouths look like in close-ups, for 'track --worn --model'"),
    take.seed("the choice of pixels to learn from, and of their order"),
    examples="abs-engine mouths labels.csv -o mouths.face\n"
    "abs-engine track close-up.avi -o tracked --worn --model mouths.face",
    notes=_NOTES,
)  # fmt: skip
def mouths(chosen: Chosen) -> Done:
    """Learn how mouths open in close-ups, from labelled frames."""
    check_free(chosen.output, take.FACE)
    from abs_engine.learn.opening import doubt, learn_opening
    from abs_engine.tracking.models.worn import save_looks
    from abs_engine.tracking.models.worn_labels import read_mouths

    with Progress("learning") as progress:
        progress.announce("reading the labelled frames")
        labelled = read_mouths(chosen.labels)
        progress.announce(f"learning from {counted(len(labelled), 'frame')}")
        looks = learn_opening(labelled, chosen.seed)
    save_looks(looks, chosen.output)
    return Done(
        [
            f"learned from {counted(len(labelled), 'frame')}",
            *doubt(labelled),
            f"wrote {chosen.output}",
        ],
        {"output": chosen.output, "frames": len(labelled)},
    )
