"""Shaders are files: found, joined by `#include`, compiled; an error names file and line."""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

import moderngl

from abs_engine.core.errors import OpenGLError

VERSION = "#version 430 core"
_INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')
_ERROR_LINE = re.compile(r"^\s*(?:ERROR:\s*)?\d+[:(](\d+)[:)(]", re.MULTILINE)
_REMEDY = "update the OpenGL driver, or use the CPU rasteriser (renderer cpu)"


@dataclass(frozen=True)
class Source:
    """A shader's text and where each of its lines comes from: "file:line" for each in `origins`."""

    text: str
    origins: tuple[str, ...]


def shader_folder() -> Traversable:
    """The folder of shader files: the package's own, or the repository's in a checkout.

    Raises `OpenGLError` if neither exists.
    """
    repository = Path(__file__).resolve().parents[2] / "shaders"
    for folder in (resources.files("abs_engine") / "_data" / "shaders", repository):
        if folder.is_dir():
            return folder
    raise OpenGLError("the shader files are missing", "install the package again")


def load(name: str, defines: tuple[str, ...] = (), folder: Traversable | None = None) -> Source:
    """Read a shader file of a folder, by default `shader_folder`, and what it includes.

    Names in `defines` are `#define`d to 1. Raises `OpenGLError` if a file is missing or includes
    itself.
    """
    lines = [(VERSION, "version line"), *((f"#define {d} 1", "defines") for d in defines)]
    lines += _read(name, folder or shader_folder(), ())
    return Source("\n".join(text for text, _ in lines) + "\n", tuple(at for _, at in lines))


def _read(name: str, folder: Traversable, inside: tuple[str, ...]) -> list[tuple[str, str]]:
    if name in inside:
        raise OpenGLError(f"shader {name} includes itself", "remove the circle of #include lines")
    try:
        text = (folder / name).read_text(encoding="utf-8")
    except OSError as error:
        raise OpenGLError(f"shader file {name} is missing", "install the package again") from error
    lines: list[tuple[str, str]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        include = _INCLUDE.match(line)
        if include:
            lines += _read(include.group(1), folder, (*inside, name))
        else:
            lines.append((line, f"{name}:{number}"))
    return lines


def program(ctx: moderngl.Context, vertex: Source, fragment: Source) -> moderngl.Program:
    """Compile and link a drawing program.

    Raises `OpenGLError`, which names file and line, if the driver refuses.
    """
    try:
        return ctx.program(vertex_shader=vertex.text, fragment_shader=fragment.text)
    except moderngl.Error as error:
        blamed = fragment if "fragment_shader" in str(error) else vertex
        raise OpenGLError(explain(str(error), blamed), _REMEDY) from error


def compute(ctx: moderngl.Context, source: Source) -> moderngl.ComputeShader:
    """Compile a compute shader; raises as `program`."""
    try:
        return ctx.compute_shader(source.text)
    except moderngl.Error as error:
        raise OpenGLError(explain(str(error), source), _REMEDY) from error


def explain(message: str, source: Source) -> str:
    """One line of a driver's message, with its line number turned into "file:line"."""
    found = _ERROR_LINE.search(message)
    if not found:
        files = sorted({origin.split(":")[0] for origin in source.origins if ":" in origin})
        return f"{', '.join(files)}: {' '.join(message.split())}"
    line = int(found.group(1))
    origin = source.origins[line - 1] if 0 < line <= len(source.origins) else f"line {line}"
    end = message.find("\n", found.end())
    text = message[found.start() : end if end >= 0 else None]
    return f"{origin}: {text.strip()}"
