"""What users read is in plain English: words that were misused before do not come back."""

from __future__ import annotations

import ast
import inspect
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pages import PAGES, ROOT

import abs_engine
from abs_engine.cli import main
from abs_engine.cli.program import PROGRAM

MISUSED = re.compile(
    r"\b(told|tells|mend(?:s|ed|ing)?|foret(?:old|ells?)|(?:gone|goes|go|going) on with"
    r"|choose of)\b",
    re.IGNORECASE,
)
"""Most of them stood where "reports", "shows", "correct", "refined" or "resumed" belongs."""
READ = (
    *PAGES,
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "assets" / "scenes").glob("*.toml")),
    *sorted((ROOT / "assets" / "published").glob("*/index.html")),
    *sorted((ROOT / "examples").glob("*.py")),
)
SOURCES = (ROOT / "bootstrap.py", *sorted((ROOT / "abs_engine").rglob("*.py")))


def found_in(text: str) -> list[str]:
    """Misused words, each with what stands around it."""
    return [text[max(0, m.start() - 40) : m.end() + 20] for m in MISUSED.finditer(text)]


def sentences(tree: ast.Module) -> list[str]:
    """Texts of two words and more that a module may print: no docstrings, no names."""
    bare = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
    said: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            bare |= {id(value) for value in node.values}
            parts = (v.value if isinstance(v, ast.Constant) else "{}" for v in node.values)
            said.append("".join(map(str, parts)))
    said += [
        n.value
        for n in ast.walk(tree)
        if isinstance(n, ast.Constant) and isinstance(n.value, str) and id(n) not in bare
    ]
    return [text for text in said if len(text.split()) > 1]


@pytest.mark.parametrize("path", READ, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_pages_and_files_that_users_read(path):
    assert found_in(path.read_text("utf-8")) == []


@pytest.mark.parametrize("name", ["", *PROGRAM.list_commands(None)])
def test_help(name, capsys):
    assert main([*name.split(), "--help"]) == 0
    text = capsys.readouterr().out
    assert found_in(text) == []
    assert f"Examples:\n  abs-engine {name}" in text


def test_help_of_run():
    done = subprocess.run(
        [sys.executable, str(ROOT / "bootstrap.py"), "--help"], capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    assert found_in(done.stdout) == []


def test_messages_and_reports():
    bad, count = [], 0
    for path in SOURCES[1:]:
        texts = sentences(ast.parse(path.read_text("utf-8")))
        count += len(texts)
        bad += [f"{path.relative_to(ROOT)}: {w}" for t in texts for w in found_in(t)]
    assert count > 1500
    assert bad == []


SHOWN = [
    name
    for page in sorted((ROOT / "docs").glob("*.md"))
    for name in re.findall(r"^::: (\S+)$", page.read_text("utf-8"), re.MULTILINE)
]
"""Objects whose docstrings pages show."""


def members(entry: object) -> dict[str, object]:
    """What a page shows of an object, by name: itself, and a class's public members."""
    own = vars(entry) if isinstance(entry, type) else {}
    return {"": entry, **{n: m for n, m in own.items() if n[0] != "_"}}


def parameters(entry: object) -> set[str]:
    """Names of what an object takes; none where it takes nothing or they are not known."""
    try:
        return set(inspect.signature(entry).parameters) if callable(entry) else set()
    except ValueError:
        return set()


def test_pages_show_the_public_api_and_the_settings():
    assert {f"abs_engine.{name}" for name in abs_engine.__all__} <= {*SHOWN}
    assert sum(name.endswith("Settings") for name in SHOWN) > 15


@pytest.mark.parametrize("name", SHOWN)
def test_docstrings_that_pages_show(name):
    entry = pydoc.locate(name)
    assert entry is not None
    for where, one in members(entry).items():
        assert found_in(getattr(one, "__doc__", "") or "") == [], where
        assert parameters(one).isdisjoint({"tell", "told"}), where


@pytest.mark.parametrize("text", ["as told", "The report tells", "to mend it", "gone on with"])
def test_a_misused_word_is_found(text):
    tree = ast.parse(f'raise ValueError(f"{{1}}: {text}")')
    assert [found_in(t) for t in sentences(tree)] != [[]]


ANSWERS = ("", "bool", "BoolArray", "NDArray[np.bool_]")  # compiled functions have no annotations
QUESTIONS = ("What", "Where", "Which", "How", "Who", "Whose", "When", "Why")


def questions(path: Path) -> list[str]:
    """Names of what a module defines whose docstrings ask a question; a predicate's may."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            word = re.match(r"\w*", ast.get_docstring(node) or "")[0]
            returns = getattr(node, "returns", None)
            kind = ast.unparse(returns) if returns else ""
            predicate = isinstance(node, ast.FunctionDef) and kind in ANSWERS
            if word in QUESTIONS or (word == "Whether" and not predicate):
                found.append(f"{path.relative_to(ROOT)}: {getattr(node, 'name', 'module')}")
    return found


def test_docstrings_begin_with_what_a_thing_is():
    assert len(SOURCES) > 500
    assert [name for path in SOURCES for name in questions(path)] == []


def test_a_docstring_that_asks_is_found(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    (tmp_path / "bad.py").write_text(
        '"""How it is."""\n\n\ndef f() -> str:\n    """Whether so."""\n\n\n'
        'def g() -> bool:\n    """Whether so."""\n'
    )
    assert questions(tmp_path / "bad.py") == ["bad.py: module", "bad.py: f"]
