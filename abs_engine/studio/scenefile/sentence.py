"""The scene of one sentence, whose values are checked as those of a scene file are."""

from __future__ import annotations

from typing import Any

import numpy as np

from abs_engine.studio.scenefile.reader import build
from abs_engine.studio.scenefile.scene import Label, SceneFile


def sentence_scene(
    sentence: str,
    *,
    person: str = "clara",
    size: tuple[int, int] = (320, 240),
    frames: int | None = None,
    seed: int = 0,
    lossless: bool = False,
    labels: tuple[Label, ...] = ("normals", "albedo", "flow"),
) -> SceneFile:
    """The scene of one person who says one built-in sentence before one ideal camera.

    Parameters
    ----------
    sentence : str
        Its name, or viseme symbols between spaces.
    lossless : bool
        Keep every picture as it was before compression.

    Raises
    ------
    ParameterError
        If a value is of another kind, or there is no such label.
    """
    clip = {"name": "clip", "speaker": person, "sentence": sentence, "frames": frames}
    if frames is None:
        del clip["frames"]
    given = {"seed": seed, "size": size, "labels": labels, "frames": lossless, "clip": [clip]}
    scene: SceneFile = build(SceneFile, _plain(given), "the film")
    return scene


def _plain(value: Any) -> Any:
    """A value as TOML would give it: lists for tuples, Python's numbers for NumPy's."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
