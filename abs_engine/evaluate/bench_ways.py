"""The ways to evaluate that a benchmark compares: this engine's renderers, and pyrender's."""

from __future__ import annotations

import math
import time
from contextlib import ExitStack
from typing import Protocol

import numpy as np

from abs_engine.core.errors import AbsEngineError
from abs_engine.core.scene import FusedRenderer
from abs_engine.evaluate.bench_work import Work
from abs_engine.evaluate.bench_worker import PyrenderWorker, WorkerError
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer


class Way(Protocol):
    """One way to evaluate a work."""

    def run(self, count: int) -> tuple[float, list[float]]:
        """Evaluate the first `count` candidates, round and round; seconds and values."""
        ...


class _Ours:
    """A renderer of this engine; `batched` takes all candidates in one call."""

    def __init__(self, renderer: FusedRenderer, work: Work, batched: bool) -> None:
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


def open_ours(
    work: Work,
    stack: ExitStack,
    ways: dict[str, Way],
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


def open_theirs(
    work: Work,
    stack: ExitStack,
    ways: dict[str, Way],
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
