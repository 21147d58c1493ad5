"""Numbers that steer results: documented with what chose them, read by the code, never changed."""

from __future__ import annotations

import json
import re
from dataclasses import FrozenInstanceError, fields
from functools import cache
from pathlib import Path

import pytest

import abs_engine
from abs_engine.tracking.settings import stages
from abs_engine.tracking.settings.stages import SETTINGS, Settings

STAGES = [one.name for one in fields(Settings)]
PACKAGE = Path(abs_engine.__file__).parent
CHOSEN = (
    r"\b([Cc]hosen|[Mm]easured|assumed|From [A-Z]\w+ et al|same source|the paper's|A bound on)\b"
)


@cache
def sources() -> str:
    """The package's code, but for the settings themselves."""
    paths = [
        p for p in PACKAGE.rglob("*.py") if "settings" not in p.relative_to(PACKAGE).as_posix()
    ]
    return "\n".join(path.read_text("utf-8") for path in paths)


def entries(stage) -> dict[str, str]:
    """What a stage's docstring says of each of its settings; after its name, its type and unit."""
    section = stage.__doc__.partition("----------\n")[2]
    found = re.split(r"^    (?=\w[\w, ]* : )", section, flags=re.MULTILINE)[1:]
    said = {}
    for entry in found:
        names, _, rest = entry.partition(" : ")
        said.update(dict.fromkeys(names.split(", "), " ".join(rest.split())))
    return said


@pytest.mark.parametrize("name", STAGES)
def test_every_setting_says_its_unit_and_what_chose_it(name):
    stage = getattr(SETTINGS, name)
    said = entries(type(stage))
    assert list(said) == [one.name for one in fields(stage)]
    for one, text in said.items():
        assert re.match(r"(int\b|(tuple of )*float, \S)", text), f"{name}.{one} has no unit"
        assert re.search(CHOSEN, text), f"{name}.{one} does not say what it was chosen by"


@pytest.mark.parametrize("name", STAGES)
def test_every_setting_is_read_by_the_code(name):
    stage = getattr(SETTINGS, name)
    instance = next(k for k, v in vars(stages).items() if v is stage)
    unused = [
        one.name
        for one in fields(stage)
        if not re.search(rf"\b{instance}\.{one.name}\b", sources())
    ]
    assert unused == []


@pytest.mark.parametrize("name", STAGES)
def test_settings_cannot_be_changed(name):
    stage = getattr(SETTINGS, name)
    first = fields(stage)[0].name
    with pytest.raises(FrozenInstanceError):
        setattr(stage, first, 1)
    assert not hasattr(stage, "__dict__")
    assert hash(stage) == hash(type(stage)())


def test_values_are_plain_and_come_back_from_json():
    values = SETTINGS.values()
    assert list(values) == STAGES
    told = json.loads(json.dumps(values))
    for name in STAGES:
        stage = getattr(SETTINGS, name)
        back = {k: tuples(v) for k, v in told[name].items()}
        assert type(stage)(**back) == stage


def tuples(value):
    return tuple(map(tuples, value)) if isinstance(value, list) else value
