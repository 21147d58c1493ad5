"""What the pages say that the tests do not run, and why; its options are checked nonetheless."""

from __future__ import annotations

from collections.abc import Mapping

SETS_UP = "sets a machine up, from the network"
CAMERA = "needs a camera"
CLUSTER = "needs other machines or their software"

PROGRAMS: Mapping[str, str] = {
    "git": SETS_UP,
    "cd": "leads to what `git` fetched",
    ".": "of the shell that a reader types in",
    "./run": f"{SETS_UP}, and runs these tests; see tests/package/test_run_script.py",
    ".venv/bin/pre-commit": "changes the repository's hooks",
    "dask": CLUSTER,
    "snakemake": CLUSTER,
    "apptainer": CLUSTER,
}
"""By program."""

LINES: Mapping[str, str] = {
    ".venv/bin/python -m build --no-isolation":
        "tests/package/test_packaging.py builds the wheel and works with it",
    "abs-engine bench": "takes a minute; tests/evaluate/test_bench.py runs a round",
    "abs-engine import ICT-FaceKit/FaceXModel -o ict.face":
        "needs ICT's face model, which is not in the repository",
    "abs-engine live": CAMERA,
    "abs-engine live talk.mp4 --repeat 5 --renderer cpu":
        "plays a file for seconds; tests/live/test_live_session.py plays one",
    "abs-engine live rtsp://127.0.0.1:8554/cam -o tracked": CAMERA,
    "abs-engine live --live-link 127.0.0.1:11111": CAMERA,
    "abs-engine track talk.mp4 -o runs --scheduler tcp://10.0.0.1:8786": CLUSTER,
    "python examples/cluster/slurm.py 20 talk.mp4 -o runs --renderer cpu": CLUSTER,
    "abs-engine reproduce 000 --quick -o report-000":
        "takes three minutes; see tests/papers/test_reproduce_slow.py",
    "abs-engine reproduce 001 --quick -o report-001":
        "takes four minutes; its parts are run by tests/papers",
    "abs-engine synth session.toml -o session":
        "films for minutes; tests/studio/test_studio_session.py films its board",
    "python tests/studio_session.py --mirror":
        "takes three minutes; tests/studio/test_studio_session.py runs its parts",
}  # fmt: skip
"""By line."""


def reason(line: str) -> str | None:
    """Why a line is not run; None if it is."""
    return LINES.get(line) or PROGRAMS.get(line.split()[0])
