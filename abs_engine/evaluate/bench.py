"""What `abs-engine bench` measures: one evaluation by this engine, and by pyrender and NumPy.

One evaluation deforms the shape by seven modes, renders it textured, compares its colours with a
frame (`scene.ColourError`) and returns one number. Every way does the same candidates with the
same geometry, texture, camera and frame. The ways take turns, round after round, so that a load on
the machine hits all of them alike.

| way | what it is |
|---|---|
| `gl_thin`, `gl_instanced` | `OpenGLRenderer.measure`, one candidate in each call |
| `gl_batched` | the instanced path, 64 candidates in each call |
| `cpu` | `CpuRenderer.measure`, one thread, one candidate in each call |
| `pyrender_numpy` | as pyrender's documentation has it: `trimesh.Trimesh` with `TextureVisuals`, `Mesh.from_trimesh`, a light, `OffscreenRenderer.render`, compared in NumPy |
| `pyrender_tuned` | the fastest that we could make of pyrender: a `Primitive` from arrays, its texture kept, unlit |

In both of pyrender's ways scene, camera and renderer are made once and only the mesh is replaced,
and trimesh is told not to process it; what is left out makes them faster than most code.
"""  # noqa: E501

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from abs_engine.errors import AbsEngineError, ParameterError
from abs_engine.evaluate.bench_work import Work, ball_work
from abs_engine.evaluate.bench_worker import PyrenderWorker, WorkerError
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer
from abs_engine.scene import Renderer

FORMAT, VERSION = "abs_engine.bench", 1
SIZES = ((3, 64), (4, 128))
"""Subdivisions of the ball and pixels: 1,280 facets at 64x64, 5,120 at 128x128."""

WAYS = ("gl_thin", "gl_instanced", "gl_batched", "cpu", "pyrender_numpy", "pyrender_tuned")
RATIOS = {
    "ratio_gl": ("gl", "pyrender_numpy"),
    "ratio_cpu": ("cpu", "pyrender_numpy"),
    "ratio_gl_tuned": ("gl", "pyrender_tuned"),
    "ratio_cpu_tuned": ("cpu", "pyrender_tuned"),
    "ratio_gl_batched": ("gl_batched", "pyrender_numpy"),
    "ratio_gl_batched_tuned": ("gl_batched", "pyrender_tuned"),
}
"""How many times faster the first way is than the second."""

DEFAULT_ROUNDS = 50
BLOCK_SECONDS = 0.02
_PACKAGES = ("abs-engine", "numpy", "numba", "moderngl", "pyrender", "trimesh")


@dataclass(frozen=True)
class WorkResult:
    """What came of one work.

    Parameters
    ----------
    name : str
        Facets and pixels, as in '1280x64'.
    ms : mapping of str to float or None
        Milliseconds of one evaluation for each of `WAYS`: the median over the rounds; None where
        the way does not run here.
    best_ms : mapping of str to float or None
        The same of the fastest round.
    gl_way : str
        The way that `OpenGLRenderer` takes by itself; `ratio_gl` is about it.
    difference : mapping of str to float or None
        Largest relative difference of a way's values from those of `cpu`, over all candidates.
        `pyrender_tuned` has 8-bit colours and smoothed edges, `pyrender_numpy` a light as well.
    """

    name: str
    ms: Mapping[str, float | None]
    best_ms: Mapping[str, float | None]
    gl_way: str
    difference: Mapping[str, float | None]

    @property
    def ratios(self) -> dict[str, float | None]:
        """Quotients of `ms`, see `RATIOS`; None where one of the ways does not run."""
        return {name: self._ratio(*pair) for name, pair in RATIOS.items()}

    def _ratio(self, way: str, against: str) -> float | None:
        mine = self.ms[self.gl_way if way == "gl" else way]
        theirs = self.ms[against]
        return None if mine is None or theirs is None else theirs / mine


@dataclass(frozen=True)
class BenchResult:
    """The whole benchmark.

    Parameters
    ----------
    works : tuple of WorkResult
    rounds : int
    renderers : mapping of str to str
        What draws, for each way that runs.
    machine : mapping of str to str or int
        Processor, cores, system, versions.
    notes : tuple of str
        What does not run here, and why.
    """

    works: tuple[WorkResult, ...]
    rounds: int
    renderers: Mapping[str, str]
    machine: Mapping[str, str | int]
    notes: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """The result as plain values that `json.dump` takes."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "works": {
                work.name: {
                    "ms": dict(work.ms),
                    "best_ms": dict(work.best_ms),
                    **work.ratios,
                    "gl_way": work.gl_way,
                    "difference": dict(work.difference),
                }
                for work in self.works
            },
            "rounds": self.rounds,
            "renderers": dict(self.renderers),
            "machine": dict(self.machine),
            "notes": list(self.notes),
        }

    def as_lines(self) -> list[str]:
        """The result as a small table."""
        lines = ["milliseconds of one evaluation (deform, render, compare), median of the rounds"]
        lines.append(_row("facets x pixels", [work.name for work in self.works]))
        lines += [_row(way, [_number(w.ms[way], 3) for w in self.works]) for way in WAYS]
        lines.append("times faster than pyrender and NumPy as most would write it / as tuned")
        for title, name in (("OpenGL", "gl"), ("CPU", "cpu"), ("OpenGL, batched", "gl_batched")):
            pairs = [
                (w.ratios[f"ratio_{name}"], w.ratios[f"ratio_{name}_tuned"]) for w in self.works
            ]
            lines.append(_row(title, [f"{_number(a, 1)} / {_number(b, 1)}" for a, b in pairs]))
        lines += [f"{way}: {what}" for way, what in self.renderers.items()]
        lines.append(f"on {self.machine['cpu']}, {self.machine['cores']} cores")
        return [*lines, *self.notes]


def run_bench(
    rounds: int = DEFAULT_ROUNDS, sizes: Sequence[tuple[int, int]] = SIZES
) -> BenchResult:
    """Measure all ways on all works, side by side. Takes about half a minute.

    Parameters
    ----------
    rounds : int
        How often every way has its turn.
    sizes : sequence of (int, int)
        Subdivisions of the ball and pixels of each work.

    Returns
    -------
    BenchResult
        A way that does not run on this machine is None in it, with a note.

    Raises
    ------
    ParameterError
        If there are no rounds.
    """
    if rounds < 1:
        raise ParameterError(f"{rounds} rounds measure nothing", "take one at least")
    renderers: dict[str, str] = {}
    notes: dict[str, None] = {}  # in order, each once
    works = tuple(_measure(ball_work(*size), rounds, renderers, notes) for size in sizes)
    return BenchResult(works, rounds, renderers, machine_facts(), tuple(notes))


def machine_facts() -> dict[str, str | int]:
    """Processor, cores that this process may use, system, and versions of what takes part."""
    facts: dict[str, str | int] = {
        "cpu": _cpu_model(),
        "cores": len(os.sched_getaffinity(0)),
        "system": platform.platform(),
        "python": platform.python_version(),
    }
    for name in _PACKAGES:
        try:
            facts[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            facts[name] = "not installed"
    return facts


class _Way(Protocol):
    """One way to evaluate a work."""

    def run(self, count: int) -> tuple[float, list[float]]:
        """Evaluate the first `count` candidates, round and round; seconds and values."""
        ...


class _Ours:
    """A renderer of this engine; `batched` takes all candidates in one call."""

    def __init__(self, renderer: Renderer, work: Work, batched: bool) -> None:
        self._renderer, self._work = renderer, work
        self._batches = [work.candidates] if batched else work.singles
        self._step = len(self._batches[0])

    def run(self, count: int) -> tuple[float, list[float]]:
        work, window, values = self._work, self._work.camera.whole, []
        measure, batches = self._renderer.measure, self._batches
        calls = -(-count // self._step)
        start = time.perf_counter()
        for i in range(calls):
            sums = measure(work.scene, batches[i % len(batches)], work.camera, window, work.term)
            values.append(sums.total)
        took = time.perf_counter() - start
        return took * count / (calls * self._step), np.concatenate(values).tolist()


class _Theirs:
    """One of pyrender's ways, in its worker; NaN once that has ended."""

    def __init__(self, worker: PyrenderWorker, way: str, notes: dict[str, None]) -> None:
        self._worker, self._way, self._notes = worker, way, notes

    def run(self, count: int) -> tuple[float, list[float]]:
        try:
            return self._worker.run(self._way, count)
        except WorkerError as error:
            self._notes[f"pyrender broke off: {error}"] = None
            return math.nan, [math.nan] * count


def _measure(
    work: Work, rounds: int, renderers: dict[str, str], notes: dict[str, None]
) -> WorkResult:
    with ExitStack() as stack:
        ways: dict[str, _Way] = {}
        gl_way = _open_ours(work, stack, ways, renderers, notes)
        _open_theirs(work, stack, ways, renderers, notes)
        values = {way: np.array(ways[way].run(len(work.candidates))[1]) for way in ways}
        took: dict[str, list[float]] = {way: [] for way in ways}
        counts = {way: _count(ways[way]) for way in ways}
        for way in _turns(list(ways), rounds):
            took[way].append(1e3 * ways[way].run(counts[way])[0] / counts[way])
    ours = values["cpu"]
    return WorkResult(
        name=work.name,
        ms={w: _finite(np.median(took.get(w, [math.nan]))) for w in WAYS},
        best_ms={w: _finite(np.min(took.get(w, [math.nan]))) for w in WAYS},
        gl_way=gl_way,
        difference={w: _finite(np.abs(values.get(w, math.nan) / ours - 1).max()) for w in WAYS},
    )


def _finite(value: np.floating[Any]) -> float | None:
    return float(value) if np.isfinite(value) else None


def _turns(ways: list[str], rounds: int) -> Iterator[str]:
    """Every way once a round, beginning with another one each time."""
    for i in range(rounds):
        start = i % len(ways)
        yield from ways[start:] + ways[:start]


def _count(way: _Way) -> int:
    """Evaluations in one turn, so that it takes about `BLOCK_SECONDS`."""
    seconds = min(way.run(4)[0] for _ in range(3)) / 4
    return max(1, round(BLOCK_SECONDS / seconds)) if seconds > 0 else 1


def _open_ours(
    work: Work,
    stack: ExitStack,
    ways: dict[str, _Way],
    renderers: dict[str, str],
    notes: dict[str, None],
) -> str:
    """Add this engine's ways; returns the one that OpenGL takes by itself."""
    gl_way = "gl_thin"
    try:
        with OpenGLRenderer() as chosen:
            gl_way = f"gl_{chosen.vertex_path}"
        thin = stack.enter_context(OpenGLRenderer(vertex_path="thin"))
        ways["gl_thin"], renderers["gl_thin"] = _Ours(thin, work, False), thin.description
        instanced = stack.enter_context(OpenGLRenderer(vertex_path="instanced"))
        for way, batched in (("gl_instanced", False), ("gl_batched", True)):
            ways[way] = _Ours(instanced, work, batched)
            renderers[way] = instanced.description
    except AbsEngineError as error:
        notes[f"not all of OpenGL runs here: {error}"] = None
    cpu = stack.enter_context(CpuRenderer())
    ways["cpu"], renderers["cpu"] = _Ours(cpu, work, False), cpu.description
    return gl_way


def _open_theirs(
    work: Work,
    stack: ExitStack,
    ways: dict[str, _Way],
    renderers: dict[str, str],
    notes: dict[str, None],
) -> None:
    """Add pyrender's ways."""
    try:
        worker = stack.enter_context(PyrenderWorker(work))
    except WorkerError as error:
        notes[f"pyrender does not run here: {error}"] = None
        return
    for way in ("pyrender_numpy", "pyrender_tuned"):
        ways[way], renderers[way] = _Theirs(worker, way, notes), worker.renderer


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def _row(title: str, cells: list[str]) -> str:
    return f"  {title:18}" + "".join(f"{cell:>16}" for cell in cells)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
