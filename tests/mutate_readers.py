"""Gives every reader thousands of files that are wrong, and prints what came of it.

Run it by hand:

    python tests/mutate_readers.py [--count 10000] [--seed 0] [PART OF A READER'S NAME ...]

Each reader works in a process of its own. A file is refused with a named error, or accepted. One
that may not be accepted is a fault, as are any other exception, an error of two lines, more than
5 s for a file, and more than 1 GB. It ends with status 1 where there is a fault.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from mutations import mutation
from readable import READERS, Reader, came_of

SLOW, MEMORY = 5.0, 1024.0  # s, MB
_ENOUGH = 1 << 36  # bytes of address space: beyond them, the machine is protected from the reader


class TooSlowError(BaseException):
    """A reader took longer than `SLOW`; no reader takes it for a broken file."""


def _stop(_number: int, _frame: FrameType | None) -> None:
    raise TooSlowError


def one(reader: Reader, path: Path, content: bytes, rng: np.random.Generator) -> str:
    """What came of a mutation: "refused", "accepted", or the fault."""
    change = mutation(content, path.suffix[1:], rng)
    signal.setitimer(signal.ITIMER_REAL, SLOW)
    try:
        return came_of(reader, path, change)
    except TooSlowError:
        return f"longer than {SLOW:g} s ({change.what})"
    except Exception as error:  # noqa: BLE001 - that is what is looked for
        own = [f for f in traceback.extract_tb(error.__traceback__) if "abs_engine" in f.filename]
        where = f"{Path(own[-1].filename).name}:{own[-1].lineno}" if own else "the script"
        return f"{type(error).__name__} at {where} ({change.what}) {'' if own else error!r}"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def work(reader: Reader, count: int, seed: int) -> dict[str, Any]:
    """What came of `count` mutations of a reader's file."""
    signal.signal(signal.SIGALRM, _stop)
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (_ENOUGH, _ENOUGH))
    rng, tally, slowest = np.random.default_rng(seed), Counter[str](), 0.0
    with tempfile.TemporaryDirectory() as name:
        path, content = reader.put(Path(name))
        reader.read(path)
        for _ in range(count):
            started = time.perf_counter()
            tally[one(reader, path, content, rng)] += 1
            slowest = max(slowest, time.perf_counter() - started)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"tally": tally, "slowest": slowest, "memory": memory}


def row(reader: Reader, count: int, seed: int) -> tuple[str, dict[str, int]]:
    """A line of the table, and the faults with how often each came."""
    words = [sys.executable, __file__, "--one", reader.name, "--count", str(count)]
    quiet = os.environ | {"AV_LOG_LEVEL": "quiet", "OPENCV_LOG_LEVEL": "OFF"}
    done = subprocess.run(
        [*words, "--seed", str(seed)], capture_output=True, text=True, check=False, env=quiet
    )
    if done.returncode:
        return f"{reader.name:26}", {f"ended by {done.returncode}: {done.stderr[-300:]}": 1}
    told = json.loads(done.stdout.splitlines()[-1])
    tally = Counter(told["tally"])
    refused, accepted = tally.pop("refused", 0), tally.pop("accepted", 0)
    if told["memory"] > MEMORY:
        tally["more than 1 GB"] += 1
    line = f"{reader.name:26} {refused:8} {accepted:8} {tally.total():6}"
    return f"{line} {told['slowest']:7.2f} s {told['memory']:5.0f} MB", dict(tally)


def main() -> int:
    """Run the readers that are named, by default all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", nargs="*", help="part of a name")
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--one", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.one is not None:
        reader = next(r for r in READERS if r.name == chosen.one)
        sys.stdout.write(json.dumps(work(reader, chosen.count, chosen.seed)) + "\n")
        return 0
    sys.stdout.write(f"{'reader':26} {'refused':>8} {'accepted':>8} faults   slowest    peak\n")
    bad = 0
    for reader in READERS:
        if not chosen.readers or any(part in reader.name for part in chosen.readers):
            line, faults = row(reader, chosen.count, chosen.seed)
            shown = sorted(faults.items(), key=lambda item: -item[1])
            sys.stdout.write("".join([line, "\n", *(f"    {n:6} {what}\n" for what, n in shown)]))
            sys.stdout.flush()
            bad += sum(faults.values())
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
