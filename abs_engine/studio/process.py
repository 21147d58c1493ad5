"""Starts, feeds and ends the worker process that draws with pyrender."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from abs_engine.core.errors import StudioError
from abs_engine.core.foreign import last_words
from abs_engine.studio.worker import Arrays, receive, send

PLATFORMS = ("egl", "osmesa")
"""What PyOpenGL is told to draw with, in the order in which they are tried."""

_REMEDY = "run 'abs-engine doctor'; on Debian or Ubuntu install libegl1 and libgl1-mesa-dri"


class Worker:
    """A process with a stage in it; a context manager.

    Parameters
    ----------
    setup : mapping of str to array
        See `worker.Stage`.
    platforms : tuple of str
        Tried in this order.

    Raises
    ------
    StudioError
        If no platform works, or, later, if the process ends; its last line is quoted.
    """

    def __init__(self, setup: Arrays, platforms: tuple[str, ...] = PLATFORMS) -> None:
        reasons = []
        for platform in platforms:
            self._start(platform)
            try:
                self.exchange(setup)
            except StudioError as error:
                reasons.append(f"{platform}: {error.problem}")
                self.close()
            except BaseException:
                self.close()
                raise
            else:
                return
        raise StudioError(f"pyrender cannot draw here ({'; '.join(reasons)})", _REMEDY)

    @property
    def pid(self) -> int:
        """Process id of the worker."""
        return self._process.pid

    def exchange(self, arrays: Arrays) -> dict[str, NDArray[Any]]:
        """Send a request and wait for its answer."""
        self.post(arrays)
        return self.collect()

    def post(self, arrays: Arrays) -> None:
        """Send a request; `collect` its answer before the next one."""
        try:
            send(self._requests, arrays)
        except OSError as error:
            raise self._failure() from error

    def collect(self) -> dict[str, NDArray[Any]]:
        """Wait for the answer to what was posted."""
        try:
            return receive(self._answers)
        except (OSError, EOFError) as error:
            raise self._failure() from error

    def close(self) -> None:
        """End the process and wait for it."""
        self._process.kill()
        self._process.wait()
        with suppress(BrokenPipeError):  # a request was still in the buffer
            self._requests.close()
        self._answers.close()
        self._files.close()

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _start(self, platform: str) -> None:
        self._files = ExitStack()
        self._complaints = self._files.enter_context(tempfile.TemporaryFile())  # noqa: SIM115
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(Path(__file__).with_name("worker.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            env=worker_environment(platform),
        )
        self._requests: Any = self._process.stdin
        self._answers: Any = self._process.stdout

    def _failure(self) -> StudioError:
        """Error to raise once the process does not answer any more."""
        last = last_words(self._process, self._complaints)
        return StudioError(f"the studio's worker ended ({last})", _REMEDY)


def worker_environment(platform: str) -> dict[str, str]:
    """Environment in which pyrender imports without a screen and draws with `platform`."""
    env = {**os.environ, "PYOPENGL_PLATFORM": platform, "PYGLET_HEADLESS": "1"}
    # OpenCV's wheel leaves an empty entry behind, which means the current folder to the linker.
    folders = [folder for folder in env.pop("LD_LIBRARY_PATH", "").split(":") if folder]
    return env | ({"LD_LIBRARY_PATH": ":".join(folders)} if folders else {})
