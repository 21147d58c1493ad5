"""What ``abs-engine synth`` was asked for, as a scene."""

from __future__ import annotations

import re
import shlex
from argparse import Namespace
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.core.errors import InputFileError, ParameterError

if TYPE_CHECKING:
    from abs_engine.studio.scenefile import SceneFile

_OPTIONS = ("person", "size", "frames", "seed", "lossless")
_NAME = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True)
class Request:
    """What is to be filmed.

    Parameters
    ----------
    scene : SceneFile
    beside : Path
        Where the files that the scene names are looked for.
    command : str
        The command that makes the same again, without the place where it is put.
    """

    scene: SceneFile
    beside: Path
    command: str


def request_of(chosen: Namespace) -> Request:
    """The scene of the command line: a scene file, or a sentence with options.

    Raises
    ------
    ParameterError
        If options are given that the scene file decides, or it is wrong.
    InputFileError, ModelFormatError
        If the scene file cannot be read.
    """
    from abs_engine.studio.scenefile import read_scene, sentence_scene

    given = {n: getattr(chosen, n) for n in _OPTIONS if getattr(chosen, n) not in (None, False)}
    path = _scene_file(chosen.what)
    if path is not None:
        if given:
            raise ParameterError(
                f"--{next(iter(given))} does not go with a scene file", "write it in the file"
            )
        return Request(
            read_scene(path), path.parent, shlex.join(["abs-engine", "synth", path.name])
        )
    if "size" in given:
        given["size"] = tuple(given["size"])
    _check_sentence(chosen.what)
    scene = sentence_scene(chosen.what, **given)
    return Request(scene, Path(), _command_line(chosen.what, given))


def _scene_file(what: str) -> Path | None:
    """A scene file by its path, or one that is shipped by its bare name; None for a sentence."""
    from abs_engine.io.assets import shipped

    path = Path(what)
    if path.suffix == ".toml" and (path.exists() or path.name != what):
        return path
    if _NAME.fullmatch(path.stem):
        try:
            return shipped(f"scenes/{path.stem}.toml")
        except InputFileError:
            pass
    return path if path.suffix == ".toml" else None


def _check_sentence(what: str) -> None:
    """Raise `ParameterError` for what is no sentence, as it may be meant for a scene."""
    from abs_engine.io.assets import shipped
    from abs_engine.studio.visemes import parse

    try:
        parse(what)
    except ParameterError as error:
        scenes = sorted(p.stem for p in shipped("scenes").glob("*.toml"))
        raise ParameterError(
            error.problem,
            f"{error.remedy}; or a scene: {', '.join(scenes)}, or the path of a .toml file",
        ) from error


def _command_line(sentence: str, given: dict[str, object]) -> str:
    words = ["abs-engine", "synth", sentence]
    for name, value in given.items():
        words.append(f"--{name}")
        if isinstance(value, tuple):
            words += map(str, value)
        elif value is not True:
            words.append(str(value))
    return shlex.join(words)
