"""Many clips whose workers are killed: all are done, and the table has the bytes it would have.

Run it by hand, with a folder of clips:

    python tests/kill_workers.py CLIPS 100 60

It cuts that many clips of 12 frames out of those in the folder, tracks them with two workers while
one of these is killed (SIGKILL) every so many seconds, and compares the table with that of the
same runs, read again by the same command: nothing may have failed or be left beside them.
"""

from __future__ import annotations

import csv
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import av
import psutil

FRAMES = 12


def cuts(source: Path, count: int, folder: Path) -> Iterator[Path]:
    """Pieces of the clips of a folder, no two alike."""
    videos = sorted(source.glob("*.mpg"))
    for number in range(count):
        round_, which = divmod(number, len(videos))
        path = folder / f"{videos[which].stem}{round_}.mp4"
        with av.open(str(videos[which])) as read, av.open(str(path), "w") as written:
            stream = written.add_stream("libx264", rate=25, options={"crf": "12"})
            for k, frame in enumerate(read.decode(video=0)):
                if k == 0:
                    stream.width, stream.height, stream.pix_fmt = (
                        frame.width,
                        frame.height,
                        "yuv420p",
                    )
                if round_ * FRAMES <= k < (round_ + 1) * FRAMES:
                    picture = frame.reformat(format="yuv420p")
                    picture.pts = None
                    written.mux(stream.encode(picture))
            written.mux(stream.encode())
        yield path


def workers_of(process: psutil.Process) -> list[psutil.Process]:
    """The processes of a command that track."""
    return [p for p in process.children(recursive=True) if "spawn_main" in " ".join(p.cmdline())]


def tracked(command: list[str], interval: float, chance: random.Random) -> int:
    """Run a command whose workers are killed; how often one was.

    Raises
    ------
    RuntimeError
        If the command fails.
    """
    running, kills = subprocess.Popen(command), 0
    while running.poll() is None:
        try:
            running.wait(interval)
        except subprocess.TimeoutExpired:
            found = workers_of(psutil.Process(running.pid))
            if found:
                os.kill(chance.choice(found).pid, signal.SIGKILL)
                kills += 1
    if running.returncode:
        raise RuntimeError(f"exit status {running.returncode}")
    return kills


def main() -> int:
    source, count, interval = Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    with tempfile.TemporaryDirectory() as made:
        folder, runs = Path(made), Path(made) / "runs"
        clips = [str(path) for path in cuts(source, count, folder)]
        command = ["abs-engine", "track", *clips, "-o", str(runs)]
        command += ["--renderer", "cpu", "--workers", "2"]
        start = time.monotonic()
        kills = tracked(command, interval, random.Random(0))
        took = time.monotonic() - start
        table = (runs / "clips.csv").read_bytes()
        subprocess.run([*command, "--quiet"], check=True)
        rows = list(csv.DictReader(table.decode().splitlines()))
        done = sum(row["status"] == "done" and row["frames"] == str(FRAMES) for row in rows)
        same = table == (runs / "clips.csv").read_bytes()
        inside = {path.name for path in runs.iterdir()}
        beside = inside - {row["clip"] for row in rows} - {"clips.csv", "timing.json"}
    sys.stdout.write(
        f"{count} clips, {done} done, {kills} kills, {took:.0f} s; "
        f"table {'the same' if same else 'another'} afterwards; left beside: {sorted(beside)}\n"
    )
    return int(done != count or not same or bool(beside))


if __name__ == "__main__":
    sys.exit(main())
