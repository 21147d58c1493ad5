"""What is left of a command that is killed at random moments and started again.

Run it by hand, with `{out}` where the command names its output:

    python tests/kill_runs.py 60 abs-engine track talk.mp4 -o {out} --renderer cpu --quiet

The command first runs undisturbed. Then it is killed (SIGKILL, it and its children) at moments
drawn uniformly from the processor's seconds that it took, which do not depend on what else the
machine does, or once its output has its name, which is every fourth time, and started again, until
it ends with exit status 0; then all over again, until it was killed often enough. Every end must
have the bytes of the undisturbed one in every file but `timing.json`, with nothing beside it.
"""

from __future__ import annotations

import math
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import psutil

DURATIONS = "timing.json"  # differ from run to run by their nature
LOOK = 0.02  # seconds between looks at what a command has taken so far, and made
AIMED = 4  # kills of which the last strikes once the output has its name
FAULTS = ("other bytes", "something left beside", "failed")


def contents(path: Path) -> dict[str, str]:
    """SHA-256 of each file of a command's output, which is a folder or a single file."""
    files = (f for f in ([path] if path.is_file() else path.rglob("*")) if f.is_file())
    return {
        str(f.relative_to(path.parent)): sha256(f.read_bytes()).hexdigest()
        for f in files
        if f.name != DURATIONS
    }


def spent(process: psutil.Process) -> float:
    """Processor's seconds of a process and all that it started."""
    seconds = 0.0
    with suppress(psutil.NoSuchProcess):
        for one in (process, *process.children(recursive=True)):
            with suppress(psutil.NoSuchProcess):
                seconds += sum(one.cpu_times()[:4])  # with those of children that ended
    return seconds


def runs_through(command: Sequence[str], seconds: float, out: Path | None = None) -> bool:
    """Whether a command ended well before it took so many seconds, or `out` was there.

    It is killed then.

    Raises
    ------
    RuntimeError
        If it ended by itself with another status than 0.
    """
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdout=said, stderr=said, start_new_session=True)
        watched = psutil.Process(process.pid)
        while process.poll() is None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(LOOK)
            made = out is not None and out.exists()
            if process.returncode is None and (made or spent(watched) >= seconds):
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                return False
        if process.returncode != 0:
            said.seek(0)
            words = said.read().decode()[-2000:]
            raise RuntimeError(f"exit status {process.returncode}: {words}")
    return True


def until_done(
    command: Sequence[str], out: Path, longest: float, kills: int, chance: random.Random,
    count: Counter[str],
) -> None:  # fmt: skip
    """Start a command until it ends with status 0, killed as long as there are kills left."""
    while True:
        left, aimed = count["kills"] < kills, count["kills"] % AIMED == AIMED - 1
        seconds = chance.uniform(0.0, longest) if left and not aimed else math.inf
        if runs_through(command, seconds, out if left and aimed else None):
            return
        count["kills"] += 1
        count["once it was there"] += out.exists()


def seconds_of_children() -> float:
    """Processor's seconds of all processes that this one has waited for, and of theirs."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def trial(command: Sequence[str], kills: int, seed: int = 0) -> Counter[str]:
    """Count kills and ends, and the ends that are not as they should be."""
    chance, count = random.Random(seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "place"
        out = place / "out"
        filled = [part.replace("{out}", str(out)) for part in command]
        place.mkdir()
        runs_through(filled, math.inf)
        longest, whole = seconds_of_children(), contents(out)
        while count["kills"] < kills:
            shutil.rmtree(place)
            place.mkdir()
            try:
                until_done(filled, out, longest, kills, chance, count)
            except RuntimeError as error:
                count["failed"] += 1
                sys.stderr.write(f"{error}\n")
                continue
            count["ends"] += 1
            count["other bytes"] += contents(out) != whole
            count["something left beside"] += [p.name for p in place.iterdir()] != ["out"]
            sys.stderr.write(f"{told(count)}\n")
    return count


def told(count: Counter[str]) -> str:
    """A line of what was counted so far."""
    names = "kills", "once it was there", "ends", *FAULTS
    return ", ".join(f"{name} {count[name]}" for name in names)


if __name__ == "__main__":
    found = trial(sys.argv[2:], int(sys.argv[1]))
    sys.stdout.write(f"{told(found)}\n")
    sys.exit(any(found[name] for name in FAULTS))
