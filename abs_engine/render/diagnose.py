"""The diagnosis of `abs-engine doctor`: renderers that work here, their speed, what is missing."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np
from scipy.spatial import ConvexHull

from abs_engine.core.camera import Camera
from abs_engine.core.errors import AbsEngineError, OpenGLError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, ColourError, FusedRenderer, Scene
from abs_engine.render.context import BACKENDS, HIDE_VARIABLE, Attempt, GLContext, remedy_of
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer, VertexPath

WORKS, CPU_ONLY = 0, 1
"""Exit statuses: OpenGL works; only the CPU rasteriser does."""

PROBE_SECONDS = 60


@dataclass(frozen=True)
class Timing:
    """Time of one evaluation: 1,280 facets, 64x64 pixels, colour error.

    The median, or None where the way does not run, and then why.
    """

    way: str
    milliseconds: float | None
    detail: str = ""


@dataclass(frozen=True)
class Diagnosis:
    """The state of the machine.

    Parameters
    ----------
    attempts : tuple of Attempt
        One for each backend, in the order they are tried.
    chosen : str
        The backend that is used, or "cpu".
    renderer, version : str
        Of the chosen backend; empty for "cpu".
    timings : tuple of Timing
    remedy : str
        What to do where no OpenGL works; empty where it does.
    """

    attempts: tuple[Attempt, ...]
    chosen: str
    renderer: str
    version: str
    timings: tuple[Timing, ...]
    remedy: str

    @property
    def exit_status(self) -> int:
        """`WORKS` or `CPU_ONLY`."""
        return CPU_ONLY if self.chosen == "cpu" else WORKS


def diagnose() -> Diagnosis:
    """Try every backend, each in a process of its own, and time the ways to evaluate.

    Returns
    -------
    Diagnosis
        Never raises for what the machine lacks.
    """
    probes = [_probe_in_process(name) for name in BACKENDS]
    attempts = tuple(p.attempt for p in probes)
    works = [p for p in probes if p.attempt.ok]
    gl_timings = works[0].timings if works else _absent("no OpenGL loads")
    cpu = _time_way("CPU rasteriser", CpuRenderer)
    return Diagnosis(
        attempts=attempts,
        chosen=works[0].attempt.backend if works else "cpu",
        renderer=works[0].renderer if works else "",
        version=works[0].version if works else "",
        timings=(*gl_timings, cpu),
        remedy="" if works else _remedy(attempts),
    )


def _remedy(attempts: tuple[Attempt, ...]) -> str:
    if all(attempt.hidden for attempt in attempts):
        return f"unset {HIDE_VARIABLE}"
    return remedy_of(attempts)


def report_lines(diagnosis: Diagnosis) -> list[str]:
    """The diagnosis as lines of text for a terminal."""
    lines = [f"{a.backend:16} {'works' if a.ok else 'no'}: {a.detail}" for a in diagnosis.attempts]
    if diagnosis.chosen == "cpu":
        lines.append("chosen: the CPU rasteriser, as no OpenGL works")
    else:
        lines.append(f"chosen: {diagnosis.chosen} ({diagnosis.renderer}, {diagnosis.version})")
        lines.append("track is fastest with --renderer cpu")
    lines.append("one evaluation (1,280 facets, 64x64 pixels):")
    for timing in diagnosis.timings:
        took = timing.detail if timing.milliseconds is None else f"{timing.milliseconds:.3f} ms"
        lines.append(f"  {timing.way:20} {took}")
    if diagnosis.remedy:
        lines.append(f"to get OpenGL: {diagnosis.remedy}")
    return lines


@dataclass(frozen=True)
class _Probe:
    attempt: Attempt
    timings: tuple[Timing, ...]
    renderer: str = ""
    version: str = ""


def _absent(why: str) -> tuple[Timing, ...]:
    return tuple(Timing(way, None, why) for way, _ in _GL_WAYS)


_GL_WAYS: tuple[tuple[str, VertexPath], ...] = (
    ("OpenGL, thin", "thin"),
    ("OpenGL, instanced", "instanced"),
)


def _probe_in_process(backend: str) -> _Probe:
    """Probe in a child, so that a driver that crashes or leaves a mess harms nobody."""
    command = [sys.executable, "-m", "abs_engine.render.diagnose", backend]
    try:
        child = subprocess.run(
            command, capture_output=True, text=True, timeout=PROBE_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return _failed(backend, f"did not answer within {PROBE_SECONDS} s")
    try:
        fields = json.loads(child.stdout.strip().splitlines()[-1])
    except (IndexError, ValueError):
        last = (child.stderr.strip().splitlines() or [""])[-1]
        return _failed(backend, f"the driver crashed (exit status {child.returncode}) {last}")
    timings = tuple(Timing(**t) for t in fields["timings"])
    return _Probe(Attempt(**fields["attempt"]), timings, fields["renderer"], fields["version"])


def _failed(backend: str, detail: str, remedy: str = "update the OpenGL driver") -> _Probe:
    return _Probe(Attempt(backend, False, detail, remedy), _absent(detail))


def probe(backend: str) -> _Probe:
    """Open one backend in this process and time both vertex paths on it."""
    try:
        with GLContext.open(backend) as gl:
            timings = tuple(
                _time_way(way, lambda path=path: OpenGLRenderer(gl, path))  # type: ignore[misc]
                for way, path in _GL_WAYS
            )
            return _Probe(gl.attempts[-1], timings, gl.renderer, gl.version)
    except OpenGLError as error:
        attempts: tuple[Attempt, ...] = getattr(error, "attempts", ())
        detail = attempts[-1].detail if attempts else error.problem
        return _failed(backend, detail, error.remedy)


def _time_way(way: str, make: Callable[[], FusedRenderer]) -> Timing:
    scene, candidates, camera = _toy()
    try:
        renderer = make()
    except AbsEngineError as error:
        return Timing(way, None, error.problem)
    try:
        window = camera.whole
        frame = renderer.draw(scene, candidates, camera, window)[0].rgb
        term = ColourError(frame)
        took = []
        for _ in range(70):
            start = time.perf_counter()
            renderer.measure(scene, candidates, camera, window, term)
            took.append(time.perf_counter() - start)
        return Timing(way, 1e3 * float(np.median(took[10:])))
    except AbsEngineError as error:
        return Timing(way, None, error.problem)
    finally:
        renderer.close()


def _toy() -> tuple[Scene, Candidates, Camera]:
    """A ball of 1,280 facets that fills 64x64 pixels."""
    k = np.arange(642)  # a closed mesh of N vertices has 2 N - 4 facets
    up, turn = 1 - (2 * k + 1) / len(k), np.pi * (1 + np.sqrt(5)) * k
    beside = np.sqrt(1 - up**2)
    unit = np.column_stack([beside * np.cos(turn), up, beside * np.sin(turn)])
    faces = ConvexHull(unit).simplices.astype(np.int32)
    a, b, c = unit[faces].transpose(1, 0, 2)
    inwards = (np.cross(b - a, c - a) * a).sum(axis=1) < 0
    faces[inwards] = faces[inwards, ::-1]
    rng = np.random.default_rng(0)
    scene = Scene(
        mean=90 * unit,
        modes=np.sin(unit @ rng.normal(0, 2, (8, 3, 3))),
        faces=faces,
        uv=(0.5 + 0.45 * unit[:, :2]).astype(np.float32),
        facet_class=(1 + np.arange(len(faces)) % 3).astype(np.int32),
        texture=rng.integers(0, 256, (64, 64, 3), np.uint8),
    )
    camera = Camera.ideal((64, 64), focal=185.0)
    return scene, Candidates.one(rng.normal(0, 1, 8), Pose.facing(600.0)), camera


if __name__ == "__main__":
    sys.stdout.write(json.dumps(asdict(probe(sys.argv[1]))) + "\n")
