"""Findings of a benchmark: milliseconds and ratios, as JSON and as a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

FORMAT, VERSION = "abs_engine.bench", 1
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


@dataclass(frozen=True)
class WorkResult:
    """Result of one piece of work.

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


def _row(title: str, cells: list[str]) -> str:
    return f"  {title:18}" + "".join(f"{cell:>16}" for cell in cells)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
