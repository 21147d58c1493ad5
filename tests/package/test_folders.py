"""The folders of the package import one another in one direction only: no cycle, however long.

A folder imports another if one of its own modules imports a module of that one, or its package,
be it at the top, in a function, or for types alone. A folder and one within it are two.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib.util import resolve_name
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2] / "abs_engine"
Links = dict[tuple[str, str], set[str]]


def dotted(path: Path, root: Path) -> str:
    """The name of a module or folder, from the package on."""
    return ".".join(path.relative_to(root.parent).with_suffix("").parts)


def modules_of(root: Path) -> dict[str, Path]:
    """Files of the package by the name under which they are imported."""
    return {dotted(p, root).removesuffix(".__init__"): p for p in root.rglob("*.py")}


def imported(path: Path, root: Path) -> Iterator[tuple[str, ...]]:
    """Names that a module imports: of `from a import b` that of module `a.b`, or else `a`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name,) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            named = "." * node.level + (node.module or "")
            home = resolve_name(named, dotted(path.parent, root))
            yield from ((f"{home}.{alias.name}", home) for alias in node.names)


def links_of(root: Path) -> Links:
    """By importing and imported folder: the modules that import."""
    modules = modules_of(root)
    links: Links = {}
    for name, path in modules.items():
        for names in imported(path, root):
            found = next((modules[one] for one in names if one in modules), path)
            if found.parent != path.parent:
                ends = dotted(path.parent, root), dotted(found.parent, root)
                links.setdefault(ends, set()).add(name)
    return links


def reached(start: str, links: Links) -> set[str]:
    """Folders that one imports, and those that these import, and so on."""
    found: set[str] = set()
    ahead = [start]
    while ahead:
        here = ahead.pop()
        new = {there for home, there in links if home == here} - found
        found |= new
        ahead += new
    return found


def on_cycles(links: Links) -> Links:
    """Links to a folder from which the one that imports it is reached again."""
    return {ends: by for ends, by in links.items() if ends[0] in reached(ends[1], links)}


def test_no_folders_import_each_other():
    links = links_of(ROOT)
    assert len(links) > 100
    assert on_cycles(links) == {}


@pytest.mark.parametrize(("files", "cycle"), [
    ({"a/one.py": "from toy.b import two", "b/two.py": ""}, set()),
    ({"a/one.py": "import toy.b.two", "b/two.py": "", "b/three.py": "import toy.a.one"},
     {("toy.a", "toy.b"), ("toy.b", "toy.a")}),
    ({"a/one.py": "from toy.a.c.two import x", "a/c/two.py": "x = 1", "a/three.py": "",
      "a/c/four.py": "def f():\n    from toy.a import three"},
     {("toy.a", "toy.a.c"), ("toy.a.c", "toy.a")}),
    ({"a/one.py": "from ..b import two", "b/two.py": "", "b/__init__.py": "from toy import c",
      "c/__init__.py": "", "c/four.py": "if TYPE_CHECKING:\n    from toy.a.one import x",
      "d/five.py": "import toy.a.one"},
     {("toy.a", "toy.b"), ("toy.b", "toy.c"), ("toy.c", "toy.a")}),
])  # fmt: skip
def test_a_cycle_would_be_found(files, cycle, tmp_path):
    for name, text in files.items():
        path = tmp_path / "toy" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    assert set(on_cycles(links_of(tmp_path / "toy"))) == cycle
