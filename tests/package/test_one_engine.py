"""The engine is one: one loop over frames, one layout of parameters, papers in their own rooms."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2] / "abs_engine"
OUTSIDE = [path for path in ROOT.rglob("*.py") if "papers" not in path.relative_to(ROOT).parts]


def functions(path: Path) -> Iterator[ast.FunctionDef]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef):
            yield node


def calls(node: ast.AST, name: str) -> bool:
    """Whether a method or function of this name is called within."""
    found = [n.func for n in ast.walk(node) if isinstance(n, ast.Call)]
    return any(getattr(f, "attr", getattr(f, "id", None)) == name for f in found)


def test_one_function_goes_over_the_frames_and_fits_them():
    """Where the head is, is it seen, where to start, fit, believe: the loop asks for it all."""
    asking = [
        (path.relative_to(ROOT).as_posix(), function.name)
        for path in ROOT.rglob("*.py")
        for function in functions(path)
        if calls(function, "work") and not path.name.startswith("bench")
    ]
    assert asking == [("tracking/loop.py", "_step")]
    loop = ROOT / "tracking" / "loop.py"
    looping = [
        function.name
        for function in functions(loop)
        if calls(function, "_step") and any(isinstance(n, ast.For) for n in ast.walk(function))
    ]
    assert looping == ["track_shots"]


def test_only_papers_names_a_paper():
    """By the name of its preset, in code or in text; sources of equations are cited anywhere."""
    named = {
        path.relative_to(ROOT).as_posix()
        for path in OUTSIDE
        if re.search(r"basu1998|odisio2004|[Ss]eed 00[01]", path.read_text())
        and path.parts[-2:] != ("commands", "reproduce.py")
    }
    assert named == set()


def test_only_solvers_and_the_layout_itself_cut_parameter_vectors():
    cut = {
        path.relative_to(ROOT).as_posix()
        for path in ROOT.rglob("*.py")
        if re.search(r"\[(:6|6:)\]|, :6\]|, 6:\]", path.read_text())
    }
    newton = {
        f"tracking/{name}.py"
        for name in (
            "head/head_joint",
            "head/head_pose",
            "landmark/landmark_fit",
            "texture/feature_matching",
        )
    }
    pictures = {"dataset/dataset.py"}  # the first six of something else
    assert cut - newton - pictures - {"tracking/texture/head_texture.py", "core/pose.py"} == set()
