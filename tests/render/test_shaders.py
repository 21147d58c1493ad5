"""Finding, joining and compiling shader files."""

from __future__ import annotations

import re

import pytest

from abs_engine.core.errors import OpenGLError
from abs_engine.render import shaders


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "one.glsl").write_text("float one() {\n    return 1.0;\n}\n")
    (tmp_path / "good.frag").write_text(
        '#include "one.glsl"\nout float x;\nvoid main() { x = one(); }\n'
    )
    (tmp_path / "bad.glsl").write_text("float two() {\n    return undefined_name;\n}\n")
    (tmp_path / "bad.frag").write_text(
        'out float x;\n#include "bad.glsl"\nvoid main() { x = two(); }\n'
    )
    (tmp_path / "loop.frag").write_text('#include "loop.frag"\n')
    (tmp_path / "plain.vert").write_text("void main() { gl_Position = vec4(0.0); }\n")
    return tmp_path


def test_includes_and_defines_come_in_order(folder):
    source = shaders.load("good.frag", ("LAYERED",), folder)
    lines = source.text.splitlines()
    assert lines[:3] == ["#version 430 core", "#define LAYERED 1", "float one() {"]
    assert source.origins[2:6] == ("one.glsl:1", "one.glsl:2", "one.glsl:3", "good.frag:2")
    assert len(source.origins) == len(lines)


@pytest.mark.parametrize(
    ("name", "problem"), [("absent.frag", "absent.frag is missing"), ("loop.frag", "itself")]
)
def test_files_that_cannot_be_joined(folder, name, problem):
    with pytest.raises(OpenGLError, match=problem):
        shaders.load(name, (), folder)


@pytest.mark.gl
def test_a_compile_error_names_the_included_file_and_its_line(gl, folder):
    with gl.current(), pytest.raises(OpenGLError, match=r"^bad\.glsl:2: .*undefined_name"):
        shaders.program(
            gl.ctx,
            shaders.load("plain.vert", (), folder),
            shaders.load("bad.frag", (), folder),
        )


@pytest.mark.gl
def test_a_compute_error_names_file_and_line(gl, folder):
    (folder / "bad.comp").write_text("layout(local_size_x = 1) in;\nvoid main() { y = 1; }\n")
    with gl.current(), pytest.raises(OpenGLError, match=r"^bad\.comp:2: "):
        shaders.compute(gl.ctx, shaders.load("bad.comp", (), folder))


def test_nvidia_messages_are_understood():
    source = shaders.Source("a\nb\nc\n", ("version line", "x.frag:1", "x.frag:2"))
    told = shaders.explain('0(3) : error C1503: undefined variable "q"', source)
    assert told.startswith("x.frag:2: 0(3) : error C1503")


def test_a_message_without_a_line_names_the_files():
    source = shaders.Source("a\nb\n", ("version line", "x.frag:1"))
    assert shaders.explain("Linker failed\nno more registers", source) == (
        "x.frag: Linker failed no more registers"
    )


@pytest.mark.gl
@pytest.mark.parametrize("defines", [("TERM_CLASS",), ("TERM_COLOUR",)])
def test_every_compute_shader_compiles(gl, defines):
    names = [p.name for p in shaders.shader_folder().iterdir() if p.name.endswith(".comp")]
    assert names
    with gl.current():
        for name in names:
            program = shaders.compute(gl.ctx, shaders.load(name, defines))
            assert program.glo > 0
            program.release()


def test_every_shader_says_what_it_is_for():
    for path in shaders.shader_folder().iterdir():
        first = path.read_text("utf-8").splitlines()[0]
        assert re.match(r"// .{20}", first), path.name
