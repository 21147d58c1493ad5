"""The benchmark of a whole clip: this engine beside MediaPipe's face mesh.

Both are whole processes: start, imports, preparation and every frame; ours writes the run with its
overlay, too. They take turns, so that a load on the machine hits both alike.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.clock import cost_lines
from abs_engine.core.errors import AbsEngineError, ParameterError
from abs_engine.evaluate import peer_worker
from abs_engine.evaluate.machine import machine_facts
from abs_engine.io.video import probe
from abs_engine.render.select import opened_renderer

FORMAT, VERSION = "abs_engine.bench_clip", 1
TURNS = 3
_FIRST = 1.0  # seconds after the first result, whose frames do not count for the rate
_BESIDE = 2  # drawings of a frame that its fit does not count: what it is worth, and how sure it is
_PEER_IS_THERE = "import mediapipe, cv2; print('{}')"
_WORKER = "abs_engine.evaluate.clip_worker"


class BenchError(AbsEngineError):
    """A process that is timed does not run."""


@dataclass(frozen=True, eq=False)
class ClipBench:
    """Result of a benchmark: medians over the turns.

    Parameters
    ----------
    seconds, seconds_peer : float
        Of the whole processes; the peer's is None where none was asked for.
    fps : float
        Frames a second, those after the first second.
    first_result_seconds : float
        From the process's start to its first frame.
    drawings_per_frame : float
        Of the mouth: those of the fit, and what is drawn once it has ended.
    parts : mapping of str to float
        Milliseconds of one core that a frame took, by part.
    peer : str
        Its version; empty without.
    """

    clip: str
    frames: int
    seconds: float
    seconds_peer: float | None
    fps: float
    first_result_seconds: float
    drawings_per_frame: float
    parts: Mapping[str, float]
    preparation_seconds: float
    draws: str
    peer: str
    turns: int
    machine: Mapping[str, str | int]

    @property
    def ratio(self) -> float | None:
        """Our time divided by the other's."""
        return None if self.seconds_peer is None else self.seconds / self.seconds_peer

    def as_json(self) -> dict[str, Any]:
        """The result as plain values that `json.dump` takes."""
        return {
            "format": FORMAT, "version": VERSION, "ratio": self.ratio, **vars(self),
            "parts": dict(self.parts), "machine": dict(self.machine),
        }  # fmt: skip

    def as_lines(self) -> list[str]:
        """The result as a small table."""
        beside = f"MediaPipe {self.peer}: {self.seconds_peer:.2f} s; " if self.peer else ""
        ratio = "" if self.ratio is None else f"ratio {self.ratio:.1f}"
        seconds = {part: ms * self.frames / 1e3 for part, ms in self.parts.items()}
        return [
            f"{self.clip}, {self.frames} frames: {self.seconds:.2f} s, median of {self.turns}",
            *([beside + ratio] if beside else []),
            f"first result after {self.first_result_seconds:.2f} s, "
            f"of which {self.preparation_seconds:.2f} s preparation",
            f"then {self.fps:.1f} frames/s, {self.drawings_per_frame:.0f} drawings a frame",
            "what a frame cost, by part:",
            *cost_lines(seconds, self.frames),
            self.draws,
            f"on {self.machine['cpu']}, {self.machine['cores']} cores",
        ]


def bench_clip(
    video: Path, renderer: str, peer_python: Path | None, turns: int = TURNS
) -> ClipBench:
    """Time a clip.

    Parameters
    ----------
    renderer : str
        As `open_renderer` takes it.
    peer_python : Path, optional
        A Python that can import mediapipe, which brings another OpenCV.

    Raises
    ------
    ParameterError
        If there are no turns, no such renderer, or the peer's Python is no file.
    VideoError, InputFileError
        If the video cannot be read.
    BenchError
        If a process fails; its last line says why.
    """
    if turns < 1:
        raise ParameterError(f"{turns} turns measure nothing", "take at least one")
    if peer_python is not None and not peer_python.is_file():
        raise ParameterError(
            f"{peer_python} is not a file", "give the path of a Python interpreter"
        )
    probe(video)
    with opened_renderer(renderer):  # an unknown name, or OpenGL that does not load, fails at once
        pass
    if peer_python is not None:
        _timed([str(peer_python), "-c", _PEER_IS_THERE], "MediaPipe")
    found: list[dict[str, Any]] = []
    ours: list[float] = []
    theirs: list[float] = []
    peer: dict[str, Any] = {}
    for _ in range(turns):
        told, took = _ours(video, renderer)
        found.append(told)
        ours.append(took)
        if peer_python is not None:
            command = [str(peer_python), peer_worker.__file__, str(video)]
            peer, took = _timed(command, "MediaPipe")
            theirs.append(took)
    return _summed(video, found, ours, theirs, str(peer.get("version", "")))


def _ours(video: Path, renderer: str) -> tuple[dict[str, Any], float]:
    with tempfile.TemporaryDirectory(prefix="abs_engine-bench-") as folder:
        begun = repr(time.monotonic())
        run = str(Path(folder) / "run")
        command = [sys.executable, "-m", _WORKER, str(video), run, renderer, begun]
        return _timed(command, "the tracker")


def _timed(command: Sequence[str], who: str) -> tuple[dict[str, Any], float]:
    """The last line of a process, and the seconds that it took."""
    if shutil.which(command[0]) is None:
        raise BenchError(f"{command[0]} cannot be run", "give the path of a Python interpreter")
    # with the variable a checkout would be compiled at each start; what is installed was before
    environment = {
        name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"
    }
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    took = time.perf_counter() - start
    if done.returncode:
        said = (done.stderr.strip() or "it said nothing").splitlines()[-1]
        raise BenchError(f"{who} does not run: {said}", "correct that, or leave it out")
    try:
        told: dict[str, Any] = json.loads((done.stdout.strip() or "nothing").splitlines()[-1])
    except json.JSONDecodeError as error:
        raise BenchError(f"{who} ends without a result", "give another Python") from error
    return told, took


def _summed(
    video: Path,
    found: Sequence[dict[str, Any]],
    ours: Sequence[float],
    theirs: Sequence[float],
    peer: str,
) -> ClipBench:
    times = [np.array(told["done"]) for told in found]
    summary = found[0]["summary"]
    each = [told["timing"]["processor_ms_per_frame"] for told in found]
    return ClipBench(
        clip=video.name,
        frames=len(times[0]),
        seconds=float(np.median(ours)),
        seconds_peer=float(np.median(theirs)) if theirs else None,
        fps=float(np.median([_rate(t) for t in times])),
        first_result_seconds=float(np.median([t[0] for t in times])),
        drawings_per_frame=float(summary["mean_evaluations"]) + _BESIDE,
        parts={part: float(np.median([one[part] for one in each])) for part in each[0]},
        preparation_seconds=float(
            np.median([told["timing"]["preparation_seconds"] for told in found])
        ),
        draws=found[0]["draws"],
        peer=peer,
        turns=len(ours),
        machine=machine_facts(),
    )


def _rate(times: np.ndarray) -> float:
    """Frames a second of those after the first second, of the times when they were done."""
    later = times[times > times[0] + _FIRST]
    late = later if len(later) > 1 else times
    return float((len(late) - 1) / max(late[-1] - late[0], 1e-9)) if len(late) > 1 else 0.0
