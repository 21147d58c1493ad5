"""The state of a reproduction: how much is done, results, figures, finished stages."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from abs_engine.core.errors import InputFileError
from abs_engine.io.inputs import read_json
from abs_engine.io.naming import settle
from abs_engine.papers.results import Reproduction


@dataclass(frozen=True)
class Amount:
    """Amount of work.

    Parameters
    ----------
    size : tuple of int
        Of the pictures.
    rounds : int
        Splits of the visemes; five test each once.
    searched, stopped : int
        Visemes in the comparisons of solvers and of stopping rules.
    sentences : int or None
        How many, evenly chosen; None is all.
    frames : int or None
        Of each sentence, from its start; None is all.
    twins : int or None
        How many of the sentences the constant models are tracked on, evenly chosen; None is all.
    worn : int or None
        Frames of each sequence of the worn camera.
    practised : int
        Frames of the sentence that is kept for practice; 0 leaves it out.
    printed : int
        How many of the sentences, at most, local appearance as printed is tracked on, too;
        0 leaves it out.
    unassisted : int
        How many of the sentences, at most, are tracked with less given; 0 leaves it out.
    """

    size: tuple[int, int]
    rounds: int
    searched: int
    stopped: int
    budgets: tuple[int, ...]
    sentences: int | None = None
    frames: int | None = None
    twins: int | None = None
    worn: int | None = None
    practised: int = 0
    printed: int = 10
    unassisted: int = 6


_STAGE = ("results", "timing", "figures")
QUICK = Amount((320, 240), 1, 4, 4, (150, 300), sentences=2, frames=36, worn=24, unassisted=0)
FULL = Amount((320, 240), 5, 8, 8, (150, 300, 600), practised=24)


@dataclass
class Report(Reproduction):
    """Results collected on the way; the parts that come later add to it.

    Parameters
    ----------
    workers : int
        Processes that track sentences.
    renderer_name : str
        What they draw with; see `open_renderer`.
    timing : dict
        What they took.
    """

    person: str
    quick: bool
    amount: Amount
    workers: int = 1
    renderer_name: str = "auto"
    timing: dict[str, Any] = field(default_factory=dict)

    @property
    def command(self) -> str:
        """Command that makes it."""
        usual = QUICK if self.quick else FULL
        words = ["abs-engine reproduce 001", *(["--quick"] if self.quick else [])]
        words += [f"--seed {self.seed}", f"--person {self.person}"]
        for option, own, default in (
            ("sentences", self.amount.sentences, usual.sentences),
            ("twins", self.amount.twins, usual.twins), ("workers", self.workers, 1),
        ):  # fmt: skip
            words += [f"--{option} {own}"] if own != default else []
        return " ".join(words)

    def stage(self, name: str, make: Callable[[Report], None]) -> None:
        """Do a part, or take what an interrupted run in the same folder found of it.

        `make` adds to the results and figures of the report that it is given.
        """
        path = self.kept / f"{name}.json"
        if not path.is_file():
            own = replace(self, results={}, timing={}, figures=[])
            started = time.perf_counter()
            make(own)
            own.timing["seconds"] = round(time.perf_counter() - started, 1)
            told = {part: getattr(own, part) for part in _STAGE}
            made = path.with_suffix(".part")
            made.write_text(json.dumps(told), encoding="utf-8")
            settle(made)
            made.replace(path)
        told = _stage(path)
        self.results |= told["results"]
        self.timing[name] = told["timing"]
        self.figures += [(address, caption) for address, caption in told["figures"]]


def _stage(path: Path) -> dict[str, Any]:
    """Results of a finished stage."""
    try:
        told = read_json(path, gaps=True)
        return {name: told[name] for name in _STAGE}
    except (ValueError, LookupError, TypeError) as error:
        raise InputFileError(f"{path} is no part of a run", "remove it") from error
