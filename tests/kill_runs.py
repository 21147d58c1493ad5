"""What is left of a command that is killed at random moments and started again.

Run it by hand, with `{out}` where the command names its output:

    python tests/kill_runs.py 60 abs-engine track talk.mp4 -o {out} --renderer cpu --quiet

The command first runs undisturbed. Then it is killed (SIGKILL, it and its children) at moments
drawn uniformly from the seconds that it took, and started again, until it ends; then all over
again, until it was killed often enough. Every end must have the bytes of the undisturbed one in
every file but `timing.json`, with nothing beside it. Of many clips, `--workers` is to be given.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

DURATIONS = "timing.json"  # differ from run to run by their nature


def contents(path: Path) -> dict[str, str]:
    """SHA-256 of each file of a command's output, which is a folder or a single file."""
    files = (f for f in ([path] if path.is_file() else path.rglob("*")) if f.is_file())
    return {
        str(f.relative_to(path.parent)): sha256(f.read_bytes()).hexdigest()
        for f in files
        if f.name != DURATIONS
    }


def runs_through(command: Sequence[str], seconds: float | None) -> bool:
    """Whether a command ended well before it was killed.

    Raises
    ------
    RuntimeError
        If it ended by itself with another status than 0.
    """
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdout=said, stderr=said, start_new_session=True)
        try:
            status = process.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return False
        if status != 0:
            said.seek(0)
            raise RuntimeError(f"exit status {status}: {said.read().decode()[-2000:]}")
    return True


def killed_until_done(
    command: Sequence[str], out: Path, longest: float, kills: int, chance: random.Random
) -> int:
    """Start a command until its output is there; how often it was killed, at most `kills` times.

    A kill can strike after the output got its name: it is whole then, and the command would say
    that it exists already. But the folder of many clips is there from the beginning.
    """
    for done in range(kills):
        if runs_through(command, chance.uniform(0.0, longest)):
            return done
        if out.exists() and "--workers" not in command:
            return done + 1
    runs_through(command, None)
    return kills


def trial(command: Sequence[str], kills: int, seed: int = 0) -> Counter[str]:
    """Count kills and ends, and the ends that are not as they should be."""
    chance, count = random.Random(seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "place"
        out = place / "out"
        filled = [part.replace("{out}", str(out)) for part in command]
        place.mkdir()
        started = time.monotonic()
        runs_through(filled, None)
        longest, whole = time.monotonic() - started, contents(out)
        while count["kills"] < kills:
            shutil.rmtree(place)
            place.mkdir()
            try:
                count["kills"] += killed_until_done(
                    filled, out, longest, kills - count["kills"], chance
                )
            except RuntimeError as error:
                count["failed"] += 1
                sys.stderr.write(f"{error}\n")
                continue
            count["ends"] += 1
            count["other bytes"] += contents(out) != whole
            count["something left beside"] += [p.name for p in place.iterdir()] != ["out"]
    return count


if __name__ == "__main__":
    found = trial(sys.argv[2:], int(sys.argv[1]))
    named = ("kills", "ends", "other bytes", "something left beside", "failed")
    sys.stdout.write(", ".join(f"{name} {found[name]}" for name in named) + "\n")
    sys.exit(any(found[name] for name in named[2:]))
