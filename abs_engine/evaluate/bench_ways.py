"""The ways to evaluate that a benchmark compares: this engine's renderers, and pyrender's.

Those of pyrender run in a process of their own, which is started, asked and ended here.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.errors import AbsEngineError
from abs_engine.core.foreign import last_words
from abs_engine.core.scene import FusedRenderer
from abs_engine.evaluate.bench_work import Work
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer

PLATFORMS = ("egl", "osmesa")
"""What PyOpenGL is told to draw with, in the order in which they are tried."""


class WorkerError(Exception):
    """pyrender does not run here."""


class PyrenderWorker:
    """A process that evaluates one work with pyrender. Use it in a `with` statement.

    Raises
    ------
    WorkerError
        If pyrender draws on no platform, or, later, if the process ends.
    """

    def __init__(self, work: Work) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="abs_engine-bench-")
        path = Path(self._folder.name) / "work.npz"
        np.savez(path, **work.as_arrays())  # type: ignore[arg-type]
        reasons = []
        for name in PLATFORMS:
            self._start(path, name)
            try:
                self.renderer = str(self._answer()["renderer"])
            except WorkerError as error:
                reasons.append(f"{name}: {error}")
                self._end()
            else:
                return
        self._folder.cleanup()
        raise WorkerError("; ".join(reasons))

    def __enter__(self) -> PyrenderWorker:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()
        self._folder.cleanup()

    def run(self, way: str, count: int) -> tuple[float, list[float]]:
        """Evaluate `count` candidates by `way`: seconds and values.

        Raises
        ------
        WorkerError
            If the process has ended.
        """
        try:
            self._stdin.write(f"{way} {count}\n")
            self._stdin.flush()
        except OSError as error:
            raise WorkerError(str(error)) from error
        answer = self._answer()
        return float(answer["seconds"]), list(answer["values"])

    def _start(self, path: Path, name: str) -> None:
        env = {"LP_NUM_THREADS": "0", **os.environ, "PYOPENGL_PLATFORM": name}
        env["PYGLET_HEADLESS"] = "1"
        env.pop("LD_LIBRARY_PATH", None)  # OpenCV's wheel leaves an empty entry behind
        script = Path(__file__).with_name("bench_pyrender.py")
        self._complaints = tempfile.TemporaryFile()  # noqa: SIM115 - `_end` closes it
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(script), str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            text=True,
            env=env,
        )
        self._stdin: Any = self._process.stdin
        self._stdout: Any = self._process.stdout

    def _answer(self) -> dict[str, Any]:
        line = self._stdout.readline()
        if line:
            answer: dict[str, Any] = json.loads(line)
            return answer
        raise WorkerError(last_words(self._process, self._complaints))

    def _end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._stdout.close()
        with suppress(BrokenPipeError):  # a request was still in the buffer
            self._stdin.close()
        self._complaints.close()


Way = Callable[[int], tuple[float, list[float]]]
"""Evaluates so many candidates of a work, from the first, round and round: seconds and values."""


def _ours(renderer: FusedRenderer, work: Work, batched: bool = False) -> Way:
    """The way of this engine's renderer; `batched` takes all candidates in one call."""
    batches = [work.candidates] if batched else work.singles
    step, window = len(batches[0]), work.camera.whole

    def run(count: int) -> tuple[float, list[float]]:
        calls, values = -(-count // step), []
        start = time.perf_counter()
        for i in range(calls):
            batch = batches[i % len(batches)]
            values.append(renderer.measure(work.scene, batch, work.camera, window, work.term).total)
        took = time.perf_counter() - start
        return took * count / (calls * step), np.concatenate(values).tolist()

    return run


def _theirs(worker: PyrenderWorker, way: str, notes: dict[str, None]) -> Way:
    """One of pyrender's ways, in its worker; NaN once that has ended."""

    def run(count: int) -> tuple[float, list[float]]:
        try:
            return worker.run(way, count)
        except WorkerError as error:
            notes[f"pyrender broke off: {error}"] = None
            return math.nan, [math.nan] * count

    return run


def opened_ways(
    work: Work, stack: ExitStack, renderers: dict[str, str], notes: dict[str, None]
) -> tuple[dict[str, Way], str]:
    """All ways that run here by their names, and the one that OpenGL takes by itself."""
    ways: dict[str, Way] = {}
    gl_way = "gl_thin"
    try:
        with OpenGLRenderer() as chosen:
            gl_way = f"gl_{chosen.vertex_path}"
        thin = stack.enter_context(OpenGLRenderer(vertex_path="thin"))
        ways["gl_thin"], renderers["gl_thin"] = _ours(thin, work), thin.description
        instanced = stack.enter_context(OpenGLRenderer(vertex_path="instanced"))
        for way, batched in (("gl_instanced", False), ("gl_batched", True)):
            ways[way], renderers[way] = _ours(instanced, work, batched), instanced.description
    except AbsEngineError as error:
        notes[f"not all of OpenGL runs here: {error}"] = None
    cpu = stack.enter_context(CpuRenderer())
    ways["cpu"], renderers["cpu"] = _ours(cpu, work), cpu.description
    try:
        worker = stack.enter_context(PyrenderWorker(work))
        for way in ("pyrender_numpy", "pyrender_tuned"):
            ways[way], renderers[way] = _theirs(worker, way, notes), worker.renderer
    except WorkerError as error:
        notes[f"pyrender does not run here: {error}"] = None
    return ways, gl_way
