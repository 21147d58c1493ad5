"""The `synth` command."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.io.unfinished import check_output

if TYPE_CHECKING:
    from abs_engine.studio.scenefile import SceneFile

_OPTIONS = ("person", "size", "frames", "seed", "lossless")
_NAME = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True)
class Request:
    """Clip that is to be filmed.

    Parameters
    ----------
    beside : Path
        Where the files that the scene names are looked for.
    command : str
        The command that makes the same again, without the place where it is put.
    """

    scene: SceneFile
    beside: Path
    command: str


@command(
    "Film ground truth and score against it",
    take.argument(
        "what", "SCENE", type=take.Named(take.scene_names, or_file=True),
        text="a scene file, NAME.toml (bundled: short.toml, speech.toml, session.toml, "
        "ten_thousand.toml, and reference.toml, which has every key); or demo, wolves, vowels, "
        "closures, or viseme symbols in quotes: '_ m a p i _'",
    ),
    take.output("DIR", "folder of the dataset; after an interruption the same command resumes"),
    take.option("--processes", type=take.count, metavar="N",
        text="how many processes film at once (default: one for each core)"),
    *take.group(
        "For a sentence; a scene file has its own",
        take.person("who is filmed (default: clara)"),
        take.option("--size", type=take.count, nargs=2, metavar="WIDTH HEIGHT",
            text="size of the picture, even numbers of pixels (default: 320 240)"),
        take.option("--frames", type=take.count, metavar="N",
            text="length (default: that of the sentence)"),
        take.option("--seed", type=int, metavar="N",
            text="seed of head motion and noise (default: 0)"),
        take.option("--lossless", is_flag=True,
            text="keep every picture before compression, as PNG"),
    ),
    examples="abs-engine synth wolves -o clip --person mei\nabs-engine synth short.toml -o data",
)  # fmt: skip
def synth(chosen: Chosen) -> Done:
    """Film a scene, or a person who says a sentence, with ground truth."""
    from abs_engine.core.clock import cost_lines
    from abs_engine.studio.filming import film_scene
    from abs_engine.studio.make import Crew

    check_output(chosen.output)
    request = request_of(chosen)
    with Progress("filming") as filming, Progress("encoding") as encoding:

        def stage(name: str) -> None:
            filming.finish()
            encoding.announce(name)
            encoding.restart()

        done = film_scene(
            request.scene,
            chosen.output,
            beside=request.beside,
            command=request.command,
            crew=Crew(chosen.processes or 0, True, stage, filming, encoding),
        )
    lines = ["what a frame cost, by part:", *cost_lines(done.seconds, done.frames)]
    if done.resumed:
        lines.insert(0, f"{done.resumed} of {done.frames} frames were there from before")
    facts = {"output": done.folder, "frames": done.frames, "seconds": done.seconds}
    return Done([*lines, f"wrote {done.folder}"], facts)


def request_of(chosen: Chosen) -> Request:
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
        name = path.name.encode("utf-8", "backslashreplace").decode("utf-8")
        return Request(read_scene(path), path.parent, shlex.join(["abs-engine", "synth", name]))
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
