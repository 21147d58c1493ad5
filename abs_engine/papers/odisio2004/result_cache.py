"""Tracked sequences in a folder, so that work which was cut off is not done again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.core.geometry import Pose
from abs_engine.io.files import unwritable
from abs_engine.io.naming import settle
from abs_engine.io.npz import read_npz
from abs_engine.papers.odisio2004.sequence import Settings, Tracked
from abs_engine.tracking.results.frame_journal import fingerprint

FORMAT, VERSION = "abs_engine.tracked", 1
_DIGITS = 12


class Kept:
    """Parameters of tracked sequences in files, each named with what it depends on.

    A file is ``NAME-MODEL-DIGEST.npz``. Where anything that a result depends on has changed, its
    file has another name, and a stale one is not taken.

    Parameters
    ----------
    folder : Path
        Made where it does not exist; its parent must.
    basis : mapping of str to str, int, float or None
        What all results depend on, such as the seed, the person, a digest of the face that is
        tracked, and the engine's version.
    aside : Path
        Folder of what is no result: sequences under way, and the seconds that each took; made
        with the first of them.

    Raises
    ------
    OutputError
        If the folder cannot be made.
    """

    def __init__(self, folder: Path, basis: Mapping[str, Any], aside: Path) -> None:
        self.folder, self._basis, self._aside = folder, dict(basis), aside
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise unwritable(folder, error) from error

    def path(self, name: str, model: str, settings: Settings) -> Path:
        """The file of a sequence that is tracked with a model, whether it is there or not."""
        told = {**self._basis, "name": name, "model": model, "settings": asdict(settings)}
        text = json.dumps(told, sort_keys=True)
        digest = hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]
        return self.folder / f"{name}-{model}-{digest}.npz"

    def journal(self, name: str, model: str, settings: Settings) -> Path:
        """The frames of a sequence under way."""
        return self._aside / f"{self.path(name, model, settings).stem}.journal"

    def load(self, name: str, model: str, settings: Settings) -> Tracked | None:
        """Stored value; None where nothing was, or the file is not whole."""
        path = self.path(name, model, settings)
        try:
            data = read_npz(path, FORMAT, VERSION)
            poses = zip(data["rotations"], data["translations"], strict=True)
            return Tracked(
                np.asarray(data["alpha"], np.float64),
                tuple(Pose(np.asarray(r), np.asarray(t)) for r, t in poses),
                np.asarray(data["value"], np.float64),
                np.asarray(data["evaluations"], np.int64),
                np.asarray(data["restarted"], np.bool_),
                self._seconds(path),
            )
        except (InputFileError, ModelFormatError, KeyError, ValueError):
            return None

    def save(self, name: str, model: str, settings: Settings, tracked: Tracked) -> None:
        """Keep a result, and forget its journal; the file appears whole or not at all.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        path = self.path(name, model, settings)
        made = self._aside / path.name
        try:
            self._aside.mkdir(exist_ok=True)
            made.with_suffix(".seconds").write_text(repr(tracked.seconds), encoding="utf-8")
            with made.open("wb") as file:
                np.savez_compressed(
                    file, format=FORMAT, version=VERSION, alpha=tracked.alpha,
                    rotations=np.array([pose.rotation for pose in tracked.poses]),
                    translations=np.array([pose.translation for pose in tracked.poses]),
                    value=tracked.value, evaluations=tracked.evaluations,
                    restarted=tracked.restarted,
                )  # fmt: skip
            settle(made)
            made.replace(path)
            self.journal(name, model, settings).unlink(missing_ok=True)
        except OSError as error:
            raise unwritable(path, error) from error

    def _seconds(self, path: Path) -> float:
        """Duration of a result; NaN where that is not known."""
        try:
            return float((self._aside / path.name).with_suffix(".seconds").read_text())
        except (OSError, ValueError):
            return float("nan")


def digest(value: Any) -> str:
    """Short digest of nested dataclasses, arrays and numbers, by their content."""
    return fingerprint(value)[:_DIGITS]
