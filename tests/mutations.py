"""Ways in which a file comes to be wrong: bytes, values, arrays and their headers."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

Rng = np.random.Generator


@dataclass(frozen=True)
class Mutation:
    """A file that was changed.

    Parameters
    ----------
    what : str
    content : bytes
    part : str
        Array or key that was changed; empty where it was the file as a whole.
    wrong : bool
        Whether no reader that looks at the part may take it. Otherwise it may have become another
        file that is just as good.
    """

    what: str
    content: bytes
    part: str = ""
    wrong: bool = False


def mutation(content: bytes, ending: str, rng: Rng) -> Mutation:
    """One mutation of a file, of the kinds that go with the ending of its name."""
    ways: dict[str, tuple[Callable[[bytes, Rng], Mutation], ...]] = {
        "npz": (of_bytes, of_arrays, of_arrays, of_headers),
        "face": (of_bytes, of_arrays, of_arrays, of_headers),
        "json": (of_bytes, of_json, of_json),
        "gltf": (of_bytes, of_json, of_json),
        "glb": (of_bytes, of_head, of_head),
        "obj": (of_bytes, of_words),
        "csv": (of_bytes, of_cells, of_cells),
        "toml": (of_bytes, of_words),
        "TextGrid": (of_bytes, of_words),
    }
    way = ways.get(ending, (of_bytes, of_head))
    return way[rng.integers(len(way))](content, rng)


def of_bytes(content: bytes, rng: Rng) -> Mutation:
    """Bytes that are changed, lost, doubled, added, or set to zero; or a file that is cut."""
    data, size = bytearray(content), len(content)
    at = int(rng.integers(size))
    more = at + int(rng.integers(1, 1 + min(64, size)))
    way = int(rng.integers(7))
    if way == 0:
        for place in rng.integers(size, size=rng.integers(1, 4)):
            data[place] ^= 1 << int(rng.integers(8))
    elif way == 1:
        for place in rng.integers(size, size=rng.integers(1, 9)):
            data[place] = int(rng.integers(256))
    elif way == 2:
        del data[at:]
    elif way == 3:
        del data[at:more]
    elif way == 4:
        data[at:at] = rng.bytes(int(rng.integers(1, 33)))
    elif way == 5:
        data[at:at] = data[at:more]
    else:
        data[at:more] = bytes(len(data[at:more]))
    names = ("a bit", "a byte", "cut", "lost", "added", "doubled", "zeros")
    return Mutation(names[way], bytes(data))


def of_head(content: bytes, rng: Rng) -> Mutation:
    """Numbers near the beginning of a binary file, where it says what follows."""
    data, at = bytearray(content), int(rng.integers(min(len(content), 600) - 8))
    size = int(rng.choice([1, 2, 4, 8]))
    value = [b"\x00", b"\xff", b"\x7f", b"\x80"][rng.integers(4)] * size
    if rng.random() < 0.5:
        value = rng.bytes(size)
    data[at : at + size] = value
    return Mutation("head", bytes(data))


# ---- archives ---------------------------------------------------------------------------------


def _saved(arrays: dict[str, Any]) -> bytes:
    made = io.BytesIO()
    np.savez(made, **arrays)
    return made.getvalue()


def _members(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _packed(members: dict[str, bytes]) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, member in members.items():
            archive.writestr(name, member)
    return made.getvalue()


def of_arrays(content: bytes, rng: Rng) -> Mutation:
    """An array of another kind, shape or range, or with NaN or infinity in it."""
    with np.load(io.BytesIO(content)) as archive:
        arrays: dict[str, Any] = dict(archive)
    names = [name for name in arrays if name not in ("format", "version") and arrays[name].size]
    name = names[rng.integers(len(names))]
    changed = list(_array_changes(arrays[name], rng))
    what, value, wrong = changed[rng.integers(len(changed))]
    if value is None:
        del arrays[name]
    else:
        arrays[name] = value
    return Mutation(f"{what}: {name}", _saved(arrays), name, wrong)


def _array_changes(old: Any, rng: Rng) -> Iterator[tuple[str, Any, bool]]:
    yield "missing", None, True
    yield "an axis more", old[None], True
    yield "complex", np.full(old.shape, 1 + 2j), True
    yield "dates", np.full(old.shape, np.datetime64("2020-01-01")), True
    yield "records", np.zeros(old.shape, [("a", "f4"), ("b", "i4")]), True
    yield "bytes", np.full(old.shape, b"x"), True
    if old.ndim:
        axis = int(rng.integers(old.ndim))
        yield "an axis fewer", old.ravel()[0], True
        yield "empty", old[:0], True
        yield "longer", np.concatenate([old, old.take([-1], axis)], axis), True
        yield "shorter", old.take(range(1, old.shape[axis]), axis), True
    if old.dtype.kind != "U":
        yield "text", np.full(old.shape, "1.0"), True
    if old.dtype.kind in "iub":
        yield "fractions", np.full(old.shape, 0.5), True
    if old.dtype.kind == "U":
        yield "numbers", np.zeros(old.shape), True
    if old.dtype.kind in "iu":
        yield "huge", np.full(old.shape, np.iinfo(np.int64).max), True
    if old.dtype.kind in "iu" and old.ndim:
        yield "negative", np.full(old.shape, -1), True
    if old.dtype.kind == "f":
        some = np.array(old, np.float64)
        place = np.unravel_index(rng.integers(old.size), old.shape) if old.ndim else ()
        value = [np.nan, np.inf, -np.inf, 1e300][rng.integers(4)]
        some[place] = value
        yield f"{value}", some, True
        yield "truth values", np.ones(old.shape, bool), True


def of_headers(content: bytes, rng: Rng) -> Mutation:
    """An array whose header is unclosed, lies about its length, or asks for what is not read."""
    members = _members(content)
    names = [name for name in members if name != "version.npy"]
    name = names[rng.integers(len(names))]
    old = members[name]
    length = int.from_bytes(old[8:10], "little")
    text, body = old[10 : 10 + length].decode("latin-1").strip(), old[10 + length :]
    ways = (
        ("unclosed", text[: int(rng.integers(len(text)))]),
        ("unclosed list", "(" * int(rng.integers(1, 400)) + text),
        ("object", "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }"),
        ("long", "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }"),
        ("longest", f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({10**40},), }}"),
        ("negative", "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,), }"),
        ("deep", f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({'1, ' * 70}), }}"),
        ("no width", "{'descr': '<U0', 'fortran_order': False, 'shape': (1000000000000,), }"),
        ("nested", "{'descr': " + "[" * 2000 + "]" * 2000 + ", 'shape': ()}"),
        ("code", "__import__('os').abort()"),
    )
    what, made = ways[rng.integers(len(ways))]
    head = (made + "\n").encode("latin-1")
    version = bytes([int(rng.choice([1, 1, 1, 2, 3, 9])), 0])
    size = len(head).to_bytes(2 if version[0] == 1 else 4, "little")
    members[name] = b"\x93NUMPY" + version + size + head + body
    return Mutation(f"header {what}", _packed(members), name.removesuffix(".npy"), True)


# ---- texts ------------------------------------------------------------------------------------

_VALUES: tuple[tuple[str, str], ...] = (
    ("null", "null"), ("true", "bool"), ('"text"', "str"), ("[]", "list"), ("{}", "dict"),
    ("NaN", "nan"), ("Infinity", "nan"), ("-Infinity", "nan"), ("1e999", "nan"), ("-1", "number"),
    ("0", "number"), ("1e300", "number"), ("1.5", "number"), ("9" * 30, "number"),
    ("[" * 3000 + "]" * 3000, "deep"), ('{"a":' * 3000 + "1" + "}" * 3000, "deep"),
    ('"\\ud800"', "surrogate"), ('"../x"', "path"), ('""', "str"), ("[[1,2],[3]]", "list"),
)  # fmt: skip


def of_json(content: bytes, rng: Rng) -> Mutation:
    """A value of another kind somewhere, or one that is missing or there twice."""
    told = json.loads(content)
    places = list(_places(told))
    path = places[rng.integers(len(places))]
    keys = [step for step in path if isinstance(step, str)]
    part, old = keys[-1] if keys else "", _at(told, path)
    if rng.random() < 0.15 and isinstance(path[-1], str):
        del _at(told, path[:-1])[path[-1]]
        return Mutation(f"missing: {part}", json.dumps(told).encode(), part, True)
    text, kind = _VALUES[rng.integers(len(_VALUES))]
    _at(told, path[:-1])[path[-1]] = "@@"
    made = json.dumps(told).replace('"@@"', text)
    own = "number" if isinstance(old, (int, float)) else type(old).__name__
    alike = kind == own or (own == "str" and kind in ("path", "surrogate"))
    wrong = kind in ("nan", "deep") or not alike
    return Mutation(f"{text[:12]} for {own}: {part}", made.encode(), part, wrong)


def _places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if path:
        yield path
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _places(inner, (*path, key))
    if isinstance(value, list):
        for number, inner in enumerate(value):
            yield from _places(inner, (*path, number))


def _at(value: Any, path: tuple[Any, ...]) -> Any:
    for step in path:
        value = value[step]
    return value


_CELLS = (
    "nan", "inf", "-inf", "1e999", "-1e308", "", "text", "1.5.2", "0x10", "1_0", '"', '"a', " ",
    "\u0663", "-1", "1e12", "9" * 40, "\x00", "true", "1;2",
)  # fmt: skip


def of_cells(content: bytes, rng: Rng) -> Mutation:
    """A cell of a table that is something else, or rows and cells lost, doubled or swapped."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    row, way = int(rng.integers(len(rows))), int(rng.integers(6))
    cell = int(rng.integers(len(rows[row])))
    if way <= 2:
        rows[row][cell] = _CELLS[rng.integers(len(_CELLS))]
    elif way == 3:
        del rows[row][cell]
    elif way == 4:
        rows.insert(row, rows[rng.integers(len(rows))])
    else:
        rows[row] = rows[row][::-1]
    names = ("cell", "cell", "cell", "cell lost", "row doubled", "row turned")
    return Mutation(names[way], "\n".join(map(",".join, rows)).encode())


def of_words(content: bytes, rng: Rng) -> Mutation:
    """A word of a text that is something else."""
    words = content.decode().split(" ")
    at = int(rng.integers(len(words)))
    values = [text for text, _ in _VALUES] + ["nan", "inf", "1e999", "'''", "=", "[[", "]]"]
    words[at] = str(values[rng.integers(len(values))])
    return Mutation("word", " ".join(words).encode())
