"""Changes of what is measured when a setting is halved or doubled.

Run it by hand: `python tests/settings_sensitivity.py -o FILE.csv [STAGE | STAGE.NAME ...]`. Each
setting is tried on the first frames of a few clips of the data folder (`ABS_ENGINE_DATA`, by
default ../shared/data): GRID's by how many frames differ from the labels of closed lips, people's
by r of the aperture with an independent detector's, and all by how far the apertures move. A share
between 0.5 and 1 is changed by its odds. Settings that such a run never reads are left out; those
that only frames read share one preparation, all others have a process of their own. What FILE.csv
has already is not measured again; `--table` prints it. Few frames can show that a setting counts,
never that it does not.
"""

from __future__ import annotations

import argparse
import csv
import inspect
import json
import multiprocessing
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from abs_engine.core.errors import AbsEngineError

if TYPE_CHECKING:
    from abs_engine.core.scene import Renderer

DATA = Path(os.environ.get("ABS_ENGINE_DATA", "../shared/data"))
CLIPS = ("p05", "brbk7n")
FACTORS = (0.5, 2.0)
SHARES = ("share", "probability", "cosine", "correlation", "overlap", "posterior", "agreement")
COLUMNS = ("setting", "value", "factor", "clip", "found", "measure", "moved", "refused")
FAILURES = (AbsEngineError, ArithmeticError, ValueError, IndexError)
SAME = 0.01  # mm: what moves apertures by less (RMS) is rounding


@dataclass(frozen=True)
class Seen:
    """Apertures (T,) of a clip's first frames, mm; NaN where nothing was found."""

    aperture: np.ndarray
    refused: str = ""


@dataclass(frozen=True)
class Trial:
    """A setting by stage and name, its value, and the one that is tried."""

    setting: str
    usual: Any
    value: Any
    factor: float


def scaled(value: Any, factor: float, unit: str) -> Any:
    """A setting's value, halved or doubled; a share of more than a half by its odds."""
    if isinstance(value, tuple):
        return tuple(scaled(part, factor, unit) for part in value)
    if isinstance(value, int):
        return max(1, round(value * factor))
    if 0.5 <= value < 1 and any(word in unit for word in SHARES):
        odds = factor * value / (1 - value)
        return odds / (1 + odds)
    return value * factor


def unit_of(stage: type, name: str) -> str:
    """Unit of a setting, by its stage's docstring."""
    text = inspect.cleandoc(stage.__doc__ or "")
    found = re.search(rf"^(?=\w)[\w, ]*\b{name}\b[\w, ]* : (.*)$", text, re.MULTILINE)
    return found[1] if found else ""


def path_of(clip: str) -> Path:
    """The video of a clip."""
    people = DATA / "people" / f"{clip}.mp4"
    return people if people.is_file() else DATA / "grid" / f"{clip}.mpg"


class Clips:
    """Clips that are prepared as a whole, of which the first frames are tracked.

    Parameters
    ----------
    names : sequence of str
    frames : int
    renderer : Renderer
    """

    def __init__(self, names: Sequence[str], frames: int, renderer: Renderer) -> None:
        from abs_engine.tracking.run import prepare

        self._frames, self._made, self._refused = frames, {}, {}
        for name in names:
            try:
                self._made[name] = prepare(path_of(name), renderer)
            except FAILURES as error:
                self._refused[name] = f"{type(error).__name__}: {error}"

    def tracked(self) -> dict[str, Seen]:
        """What is found in each clip."""
        nothing = np.full(self._frames, np.nan)
        seen = {name: Seen(nothing, why) for name, why in self._refused.items()}
        for name, made in self._made.items():
            results = made.results()
            try:
                seen[name] = Seen(np.array([r.aperture for _, r in islice(results, self._frames)]))
            except FAILURES as error:
                seen[name] = Seen(nothing, f"{type(error).__name__}: {error}")
            finally:
                results.close()
        return seen


def from_child(work: Callable[..., Iterator[Any]], *given: Any) -> Iterator[Any]:
    """What a generator yields in a process of its own, which may change settings."""
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)

    def run() -> None:
        for one in work(*given):
            there.send(one)

    process = context.Process(target=run)
    process.start()
    there.close()
    try:
        while True:
            yield here.recv()
    except EOFError:
        process.join()


def put(setting: str, value: Any) -> None:
    """Change a setting of this process, past `frozen`."""
    from abs_engine.tracking.settings.stages import STAGES

    stage, _, name = setting.partition(".")
    object.__setattr__(STAGES[stage], name, value)


def afresh(
    setting: str, value: Any, names: Sequence[str], frames: int
) -> Iterator[dict[str, Seen]]:
    """Clips tracked with another value, set before anything that reads it is imported."""
    put(setting, value)
    from abs_engine.render.select import open_renderer

    with open_renderer("auto") as renderer:
        yield Clips(names, frames, renderer).tracked()


def read_in(names: Sequence[str], frames: int, todo: Sequence[Trial]) -> Iterator[Any]:
    """Clips tracked as it is, what that reads, and each trial that frames alone read.

    Yields
    ------
    dict, set of str, set of str
        What is found; all settings that are read; and those that are read for each frame, neither
        by an import nor in the preparation.
    Trial, dict
        One of the latter, and what is found with it.
    """
    from abs_engine.render.select import open_renderer

    read: set[str] = set()
    spy_on(read)
    with open_renderer("auto") as renderer:
        clips = Clips(names, frames, renderer)
        before = set(read)
        usual = clips.tracked()
        every = set(read)
        read.clear()
        again = clips.tracked()
        same = all(np.array_equal(usual[n].aperture, again[n].aperture, True) for n in names)
        alone = read - before if same else set()
        yield usual, every, alone
        for one in todo:
            if one.setting in alone:
                put(one.setting, one.value)
                yield one, clips.tracked()
                put(one.setting, one.usual)


def spy_on(read: set[str]) -> None:
    """Note in `read` which settings are read from now on."""
    from abs_engine.tracking.settings.stages import STAGES

    for stage, value in STAGES.items():
        own = frozenset(one.name for one in fields(value))

        def spy(self: Any, name: str, stage: str = stage, own: frozenset[str] = own) -> Any:
            if name in own:
                read.add(f"{stage}.{name}")
            return object.__getattribute__(self, name)

        spied = type("Spied", (type(value),), {"__slots__": (), "__getattribute__": spy})
        object.__setattr__(value, "__class__", spied)


def measure(clip: str, aperture: np.ndarray) -> float:
    """Frames that differ from GRID's labels, or r with the detector's aperture."""
    if path_of(clip).parent.name == "grid":
        from abs_engine.io.assets import CLOSED_APERTURE
        from abs_engine.papers.basu1998.real_clips import closure_labels

        labels = closure_labels()[clip]
        closed, sure = labels.closed[: len(aperture)], labels.sure[: len(aperture)]
        return float(((aperture < CLOSED_APERTURE) != closed)[sure].sum())
    detector = json.loads((DATA / "people" / "mediapipe.json").read_text())["clips"][clip]
    told = np.array(detector["aperture"], float)[: len(aperture)]
    both = np.isfinite(told) & np.isfinite(aperture)
    return float(np.corrcoef(told[both], aperture[both])[0, 1]) if both.sum() > 2 else float("nan")


def rows_of(
    trial: Trial, seen: dict[str, Seen], usual: dict[str, Seen]
) -> Iterator[tuple[Any, ...]]:
    """Rows of the file, one for each clip."""
    for clip, one in seen.items():
        before = usual[clip].aperture
        size = min(len(before), len(one.aperture))
        off = one.aperture[:size] - before[:size]
        moved = float(np.sqrt(np.nanmean(off**2))) if np.isfinite(off).any() else float("nan")
        found = int(np.isfinite(one.aperture).sum())
        by = f"{measure(clip, one.aperture):.4f}"
        which = trial.setting, trial.value, trial.factor
        yield (*which, clip, found, by, f"{moved:.4f}", one.refused)


def table(path: Path) -> str:
    """The settings of a file, those that move apertures most first."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    usual = {r["clip"]: float(r["measure"]) for r in rows if r["setting"] == "as it is"}
    by: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        if row["setting"] != "as it is":
            by.setdefault(row["setting"], []).append(row)

    def moved(setting: str) -> float:
        return max(np.inf if r["refused"] else float(r["moved"]) for r in by[setting])

    lines = [f"as it is: {', '.join(f'{clip} {value:g}' for clip, value in usual.items())}"]
    for setting in sorted(by, key=moved, reverse=True):
        parts = [
            f"x{r['factor']} {r['clip']} "
            + (r["refused"] or f"{float(r['measure']):g} ({float(r['moved']):.2f} mm)")
            for r in by[setting]
        ]
        lines.append(f"{moved(setting):8.3f}  {setting:36}  {'; '.join(parts)}")
    still = sum(moved(one) < SAME for one in by)
    lines.append(f"{len(by)} settings, {still} of which move apertures by less than {SAME} mm")
    return "\n".join(lines) + "\n"


def trials(
    wanted: Sequence[str], factors: Sequence[float], done: set[tuple[str, float]]
) -> list[Trial]:
    """Settings with the values that they are to have, without those that were tried."""
    from abs_engine.tracking.settings.stages import STAGES

    found = []
    for one in wanted or STAGES:
        stage, _, key = one.partition(".")
        values = STAGES[stage]
        for name in [key] if key else [field.name for field in fields(values)]:
            value = getattr(values, name)
            for factor in factors:
                other = scaled(value, factor, unit_of(type(values), name))
                trial = Trial(f"{stage}.{name}", value, other, factor)
                if trial.value != value and (trial.setting, factor) not in done:
                    found.append(trial)
    return found


def main() -> None:
    """Measure what is not measured yet."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("settings", nargs="*", metavar="STAGE[.NAME]")
    asked.add_argument("-o", "--output", type=Path, required=True)
    asked.add_argument("--clips", nargs="+", default=CLIPS)
    asked.add_argument("--frames", type=int, default=25)
    asked.add_argument("--factors", nargs="+", type=float, default=FACTORS)
    asked.add_argument("--table", action="store_true", help="print the file, and measure nothing")
    given = asked.parse_args()
    if given.table:
        sys.stdout.write(table(given.output))
        return
    done: set[tuple[str, float]] = set()
    if given.output.exists():
        with given.output.open(encoding="utf-8", newline="") as file:
            done = {(r["setting"], float(r["factor"])) for r in csv.DictReader(file)}
    todo = trials(given.settings, given.factors, done)
    within = from_child(read_in, given.clips, given.frames, todo)
    usual, read, alone = next(within)
    with given.output.open("a", encoding="utf-8", newline="") as file:
        out = csv.writer(file)

        def add(rows: Iterator[tuple[Any, ...]]) -> None:
            out.writerows(rows)
            file.flush()

        if not done:
            out.writerow(COLUMNS)
            add(rows_of(Trial("as it is", "", "", 1.0), usual, usual))
        sys.stderr.write(f"{len(read)} settings are read, {len(alone)} of them in frames alone\n")
        for one, seen in within:
            add(rows_of(one, seen, usual))
        for one in todo:
            if one.setting in read - alone:
                found = list(from_child(afresh, one.setting, one.value, given.clips, given.frames))
                stopped = Seen(np.full(given.frames, np.nan), "stopped")
                add(rows_of(one, found[0] if found else dict.fromkeys(usual, stopped), usual))


if __name__ == "__main__":
    main()
