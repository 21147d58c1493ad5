"""Starts, asks and ends the process in which pyrender does the benchmark's work."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.foreign import last_words
from abs_engine.evaluate.bench_work import Work

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
