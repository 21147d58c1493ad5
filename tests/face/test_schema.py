"""Names of face units and of MakeHuman's targets, which the schema alone spells."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from abs_engine.face.schema import (
    DRAWN_TARGETS,
    FACE_UNITS,
    FORMS,
    MACRO,
    ORIGINS,
    PERSON_TARGETS,
    SEXES,
    SHIFTS,
    Pair,
    Unit,
    by_unit,
    drawn_targets,
    less_of,
    macro_targets,
    units_of,
)
from abs_engine.io.assets import load_speaker

ROOT = Path(__file__).parents[2] / "abs_engine"
SCHEMA = ROOT / "face" / "schema"
TARGETS = load_speaker().identity_names


def plain(word: str) -> str:
    """A name as it is compared: without folder, in small letters."""
    return word.lower().split("/")[-1].replace("-", "_").strip("_")


NAMES = {
    plain(name)
    for name in (
        *FACE_UNITS, *Pair, *TARGETS, *DRAWN_TARGETS, *FORMS, *ORIGINS,
        *(target for pair in PERSON_TARGETS.values() for target in pair[:2]),
    )
}  # fmt: skip


def literals(source: str) -> Iterator[tuple[int, str]]:
    """Line and text of each string of a file that is no docstring."""
    tree = ast.parse(source)
    docs = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in docs:
            yield node.lineno, node.value


def spelled(source: str) -> list[tuple[int, str]]:
    """The strings that hold names and no other word; a message may mention a name."""
    words = ((line, text, re.findall(r"[\w/-]+", text)) for line, text in literals(source))
    return [(line, text) for line, text, own in words if own and {*map(plain, own)} <= NAMES]


def test_nothing_else_spells_a_name():
    files = [path for path in ROOT.rglob("*.py") if path.parent != SCHEMA]
    assert len(files) > 500
    found = {str(path): spelled(path.read_text(encoding="utf-8")) for path in files}
    assert {path: names for path, names in found.items() if names} == {}


def test_the_schema_itself_spells_them_all():
    sources = [path.read_text(encoding="utf-8") for path in SCHEMA.glob("*.py")]
    own = {name for source in sources for _, name in spelled(source)}
    assert {*Unit, *Pair, *DRAWN_TARGETS, *FORMS, *ORIGINS} <= own


@pytest.mark.parametrize("source", [
    'x = "jawOpen"', 'x = {"mouthSmile": 0.3}', 'if "jawopen" in columns: pass',
    'x = f"{side}browOuterUpLeft"', 'x = "eyeBlinkLeft, eyeBlinkRight".split(", ")',
    'x = "mouth_scale_horiz_incr"', 'x = "chin/chin-bones-decr"', 'x = f"nose_hump_{end}"',
    'x = "head_oval"', 'x = "asian"', 'x = "asian_female_old"',
])  # fmt: skip
def test_a_name_would_be_found(source):
    assert len(spelled(source)) >= 1


@pytest.mark.parametrize("source", [
    '"""jawOpen"""', 'X = 1\n"""jawOpen"""', 'def f():\n    """jawOpen"""', "x = 1  # 'jawOpen'",
    'x = "jawOpen opens the lips by "', 'x = "jaw_opening"', 'x = ""', 'x = ", "',
])  # fmt: skip
def test_what_mentions_a_name_is_left_alone(source):
    assert spelled(source) == []


def test_pairs_have_a_unit_on_each_side():
    assert len(FACE_UNITS) == len(set(FACE_UNITS)) == 52
    assert {type(name) for name in FACE_UNITS} == {str}
    for pair in Pair:
        left, right = units_of(pair)
        assert (left, right) == (f"{pair}Left", f"{pair}Right")
        assert {left, right} <= set(FACE_UNITS)
    mirrored = [*SHIFTS, *map(units_of, Pair)]
    sided = {name for name in FACE_UNITS if name.endswith(("Left", "Right"))}
    assert {name for pair in mirrored for name in pair} == sided


def test_a_posture_moves_both_sides_alike():
    posture = {Unit.JAW_OPEN: 0.2, Pair.MOUTH_SMILE: 0.5, "mouthPressLeft": 0.1}
    assert by_unit(posture) == {
        "jawOpen": 0.2, "mouthSmileLeft": 0.5, "mouthSmileRight": 0.5, "mouthPressLeft": 0.1,
    }  # fmt: skip


def test_targets_are_those_of_the_bundled_head():
    short = {name.split("/")[-1].replace("-", "_") for name in TARGETS}
    drawn = [drawn_targets(pair, weight) for pair in DRAWN_TARGETS for weight in (-0.5, 0.5)]
    assert {weight for weights in drawn for weight in weights.values()} == {0.5}
    assert {name for weights in drawn for name in weights} <= short
    assert set(FORMS) <= short
    macros = [macro_targets(origin, sex, 0.25) for origin in ORIGINS for sex in SEXES]
    assert {plain(name) for name in TARGETS if name.startswith(MACRO)} == {
        name for weights in macros for name in weights
    }
    assert all(sum(weights.values()) == 1 for weights in macros)


def test_less_of_a_pair_is_named_after_more():
    assert less_of("nose/nose-hump-incr") == "nose/nose-hump-decr"
    assert less_of("nose/nose-hump-decr") is None
    assert less_of("head/head-oval") is None
    pairs = [name for name in TARGETS if name.endswith(("-incr", "-up", "-forward", "-out"))]
    assert len(pairs) > 40
    assert {less_of(name) for name in pairs} <= set(TARGETS)
