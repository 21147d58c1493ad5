"""Models, evidence, drivers, renderers and presets by name; installed packages add their own.

A package adds entries through entry points of the group ``abs_engine.KIND``; a program adds one
with `Registry.add`.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from functools import cache, cached_property
from importlib import metadata
from pathlib import Path
from runpy import run_path
from typing import Any

from abs_engine.core.errors import AbsEngineError, InputFileError, ParameterError, PluginError
from abs_engine.core.foreign import FAILURES, blamed, named
from abs_engine.core.kinds import TEXT, check_kind


def nearest(name: str, known: Iterable[str]) -> str:
    """Advice about an unknown name: the nearest one is given, and all of them if few."""
    names = list(known)
    if not names:
        return "there is none to choose"
    close = difflib.get_close_matches(name, names, 1)
    every = f"choose one of {', '.join(names)}"
    if not close:
        return every
    return f"did you mean '{close[0]}'?" + (f" {every}" if len(names) <= _FEW else "")


_FEW = 6  # names that are listed beside the nearest


class Registry:
    """Entries of one kind by name, each imported when it is first asked for.

    `kind` is what they are, in the singular: "model", "driver"; `has` are attributes that all have.
    """

    def __init__(self, kind: str, has: tuple[str, ...] = ()) -> None:
        self.kind, self._has = kind, has
        self._added: dict[str, Any] = {}
        self._count = 0  # of entries that were added, also in place of others

    @property
    def group(self) -> str:
        """The group of entry points that packages use, the engine among them."""
        return f"abs_engine.{self.kind}s"

    def add(self, name: str, entry: Any) -> None:
        """Add an entry for the rest of the process; it replaces one that was added before.

        Raises
        ------
        ParameterError
            If its name is no text.
        PluginError
            If an installed package brings one of the same name, or the entry is of another kind.
        """
        check_kind(f"the name of a {self.kind}", name, TEXT)
        if name in self._installed:
            raise PluginError(f"there is a {self.kind} '{name}' already", "give another name")
        self._added[name] = self._checked(name, entry)
        self._count += 1

    def names(self) -> tuple[str, ...]:
        """All names, those of installed packages first, then those that were added."""
        return (*sorted(self._installed), *self._added)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self.names())

    def __contains__(self, name: object) -> bool:
        """Whether there is an entry of a name."""
        return name in self.names()

    def __len__(self) -> int:
        """Return the number of entries."""
        return len(self.names())

    def get(self, name: str) -> Any:
        """The entry of a name.

        Raises
        ------
        ParameterError
            If there is none; the nearest name is given.
        PluginError
            If it cannot be imported.
        """
        check_kind(self.kind, name, TEXT)
        if name in self._added:
            return self._added[name]
        if name not in self._installed:
            raise ParameterError(f"there is no {self.kind} '{name}'", nearest(name, self))
        return self._checked(name, _loaded(self.kind, self._installed[name]))

    def working(self) -> tuple[dict[str, Any], dict[str, AbsEngineError]]:
        """Entries that can be imported, and errors of those that cannot, each by its name."""
        entries: dict[str, Any] = {}
        faults: dict[str, AbsEngineError] = {}
        for name in self:
            try:
                entries[name] = self.get(name)
            except AbsEngineError as fault:
                faults[name] = fault
        return entries, faults

    def _checked(self, name: str, entry: Any) -> Any:
        lacks = [attribute for attribute in self._has if not hasattr(entry, attribute)]
        if lacks:
            raise PluginError(
                f"the {self.kind} '{name}' is a {type(entry).__name__} without '{lacks[0]}'",
                f"add a {self.kind} as the examples do",
            )
        return entry

    @cached_property
    def _installed(self) -> dict[str, metadata.EntryPoint]:
        return {point.name: point for point in _entry_points().select(group=self.group)}


@cache
def _entry_points() -> Any:
    """Entry points of all installed packages (`metadata.EntryPoints`), read once."""
    return metadata.entry_points()


PLUGINS: list[Path] = []
"""Files that were run, in their order."""
_OF_USE: set[Path] = set()
"""Files that have added an entry; a module of theirs that does it is imported only once."""


def load_plugin(path: Path) -> None:
    """Run a Python file that adds entries to the registries.

    Raises
    ------
    InputFileError
        If there is no such file.
    PluginError
        If it fails, ends the program, or adds nothing.
    """
    if path.is_dir():
        raise InputFileError(f"{path} is a folder", "give the Python file in it")
    if not path.is_file():
        raise InputFileError(f"{path} does not exist", "give a Python file")
    before = _added()
    with blamed(str(path), remedy="correct it"):
        run_path(str(path), run_name=f"abs_engine_plugin_{path.stem}")
    if _added() > before:
        _OF_USE.add(path.resolve())
    if path.resolve() not in _OF_USE:
        raise PluginError(
            f"{path} adds nothing to the engine",
            f"add an entry, as by DRIVERS.add(NAME, ENTRY), or leave out --plugin {path}",
        )
    PLUGINS.append(path)


def _added() -> int:
    """Number of entries that were added so far to all registries."""
    return sum(registry._count for registry in REGISTRIES)


def load_plugins(paths: Iterable[Path]) -> None:
    """Run Python files that add entries; errors as `load_plugin`."""
    for path in paths:
        load_plugin(path)


def _loaded(kind: str, point: metadata.EntryPoint) -> Any:
    try:
        return point.load()
    except AbsEngineError:
        raise
    except FAILURES as error:  # whatever a package does as it is imported
        raise PluginError(
            f"the {kind} '{point.name}' cannot be imported from {point.value} ({named(error)})",
            "correct or remove the package that brings it; the others work",
        ) from error


MODELS = Registry("model", ("__call__",))
"""What can be tracked: each prepares a clip for one kind of face."""
TERMS = Registry("term", ("bind", "gives", "learned", "beside", "what", "remedy"))
"""Kinds of evidence: each binds a term to a face and a view."""
DRIVERS = Registry("driver", ("minimiser", "needs", "settings"))
"""What moves the parameters."""
RENDERERS = Registry("renderer", ("__call__",))
"""What draws, of packages and plugins alone; `open_renderer` has the engine's own beside them."""
PRESETS = Registry("preset", ("model", "terms", "driver", "start"))
"""Choices of all of these together."""
EXPORTERS = Registry("exporter", ("text", "write", "suffix"))
"""Formats that runs are written in."""
METRICS = Registry("metric", ("key", "label", "unit", "definition", "measure", "root"))
"""Numbers that scores have besides the engine's own."""
REGISTRIES = (MODELS, TERMS, DRIVERS, RENDERERS, PRESETS, EXPORTERS, METRICS)
"""All of these, each of which a plugin's file may add to."""
