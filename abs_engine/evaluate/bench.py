"""The benchmark of one evaluation: this engine beside pyrender and NumPy.

One evaluation deforms the shape by seven modes, renders it textured, compares its colours with a
frame (`core.scene.ColourError`) and returns one number. Every way does the same candidates with the
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
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import WHOLE, check_kind
from abs_engine.evaluate.bench_result import WAYS, BenchResult, WorkResult
from abs_engine.evaluate.bench_ways import Way, opened_ways
from abs_engine.evaluate.bench_work import Work, ball_work
from abs_engine.evaluate.machine import machine_facts

SIZES = ((3, 64), (4, 128))
"""Subdivisions of the ball and pixels: 1,280 facets at 64x64, 5,120 at 128x128."""

DEFAULT_ROUNDS = 50
BLOCK_SECONDS = 0.02


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
    check_kind("rounds", rounds, WHOLE)
    if rounds < 1:
        raise ParameterError(f"{rounds} rounds measure nothing", "take at least one")
    renderers: dict[str, str] = {}
    notes: dict[str, None] = {}  # in order, each once
    works = tuple(_measure(ball_work(*size), rounds, renderers, notes) for size in sizes)
    return BenchResult(works, rounds, renderers, machine_facts(), tuple(notes))


def _measure(
    work: Work, rounds: int, renderers: dict[str, str], notes: dict[str, None]
) -> WorkResult:
    with ExitStack() as stack:
        ways, gl_way = opened_ways(work, stack, renderers, notes)
        values = {way: np.array(run(len(work.candidates))[1]) for way, run in ways.items()}
        took: dict[str, list[float]] = {way: [] for way in ways}
        counts = {way: _count(ways[way]) for way in ways}
        for turn in range(rounds):  # another one begins each time
            start = turn % len(ways)
            for way in [*ways][start:] + [*ways][:start]:
                took[way].append(1e3 * ways[way](counts[way])[0] / counts[way])
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


def _count(way: Way) -> int:
    """Evaluations in one turn, so that it takes about `BLOCK_SECONDS`."""
    seconds = min(way(4)[0] for _ in range(3)) / 4
    return max(1, round(BLOCK_SECONDS / seconds)) if seconds > 0 else 1
