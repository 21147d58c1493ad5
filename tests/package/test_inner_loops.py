"""Loops that are compiled for others alone: the process would end where Python called them."""

from __future__ import annotations

import ast
from pathlib import Path

import abs_engine

ROOT = Path(abs_engine.__file__).parent


def decorated(source: ast.Module, *words: str) -> dict[str, ast.FunctionDef]:
    """Functions whose decorators mention one of these words."""
    return {
        one.name: one
        for one in ast.walk(source)
        if isinstance(one, ast.FunctionDef)
        and any(word in ast.unparse(d) for d in one.decorator_list for word in words)
    }


def used_outside(source: ast.Module, names: set[str]) -> set[str]:
    """Those of the names that a module uses where Python runs."""
    compiled = decorated(source, "njit", "_inlined", "_compiled").values()
    within = {id(node) for one in compiled for node in ast.walk(one)}
    return {
        node.id
        for node in ast.walk(source)
        if isinstance(node, ast.Name) and id(node) not in within and node.id in names
    }


def imported(source: ast.Module, inner: dict[str, set[str]]) -> set[str]:
    """Those that a module takes from others, `inner` of each."""
    return {
        one.name
        for node in ast.walk(source)
        if isinstance(node, ast.ImportFrom)
        for one in node.names
        if one.name in inner.get(str(node.module), set())
    }


def test_only_compiled_loops_call_them():
    sources = {
        ".".join(path.relative_to(ROOT.parent).with_suffix("").parts): ast.parse(
            path.read_text("utf-8")
        )
        for path in ROOT.rglob("*.py")
    }
    inner = {name: set(decorated(one, "INNER", "_inlined")) for name, one in sources.items()}
    assert sum(map(len, inner.values())) > 25
    for name, one in sources.items():
        assert not used_outside(one, inner[name] | imported(one, inner)), name


def test_loops_sum_for_themselves():
    """For an array's own sum numba imports SciPy's linear algebra as it loads the loop."""
    slow = {"sum", "mean", "prod", "any", "all", "argmin", "argmax", "dot"}
    calls = [
        (path.name, one.name, node.attr)
        for path in ROOT.rglob("*.py")
        for one in decorated(ast.parse(path.read_text("utf-8")), "njit", "_compiled").values()
        for node in ast.walk(one)
        if isinstance(node, ast.Attribute) and node.attr in slow
    ]
    assert calls == []


def test_a_call_by_python_is_seen():
    source = ast.parse(
        "@numba.njit(**INNER)\ndef inner(): pass\n"
        "@numba.njit(cache=True)\ndef outer(): inner()\n"
        "def python(): outer(); inner()\n"
    )
    assert used_outside(source, {"inner"}) == {"inner"}
    del source.body[2]
    assert not used_outside(source, {"inner"})
