"""Numbers that steer results: documented with what chose them, read by the code, never changed."""

from __future__ import annotations

import inspect
import json
import re
from dataclasses import FrozenInstanceError, fields
from functools import cache
from pathlib import Path

import pytest

import abs_engine
from abs_engine.capture import settings as capturing
from abs_engine.export import settings as exporting
from abs_engine.learn import settings as learning
from abs_engine.learn.heads import settings as heads
from abs_engine.learn.measured import settings as measured
from abs_engine.tracking.settings import stages
from abs_engine.tracking.settings.stages import STAGES, stage_values

EVERY = {
    name: value
    for module in (stages, learning, heads, measured, capturing, exporting)
    for name, value in vars(module).items()
    if name.isupper() and name != "STAGES"
}
PACKAGE = Path(abs_engine.__file__).parent
CHOSEN = (
    r"\b([Cc]hosen|[Mm]easured|assumed|From [A-Z]\w+ et al|same source|[Tt]he paper's|A bound on)\b"
)


@cache
def read() -> set[str]:
    """Settings that the package reads, as `STAGE.name`, but for the settings themselves."""
    paths = [
        p for p in PACKAGE.rglob("*.py") if "settings" not in p.relative_to(PACKAGE).as_posix()
    ]
    return {one for path in paths for one in re.findall(r"\b[A-Z_]+\.\w+", path.read_text("utf-8"))}


def entries(stage) -> dict[str, str]:
    """What a stage's docstring says of each of its settings; after its name, its type and unit."""
    section = inspect.cleandoc(stage.__doc__).partition("----------\n")[2]  # 3.13 does so itself
    found = re.split(r"^(?=\w[\w, ]* : )", section, flags=re.MULTILINE)[1:]
    said = {}
    for entry in found:
        names, _, rest = entry.partition(" : ")
        said.update(dict.fromkeys(names.split(", "), " ".join(rest.split())))
    return said


@pytest.mark.parametrize("name", EVERY)
def test_every_setting_says_its_unit_and_what_chose_it(name):
    stage = EVERY[name]
    said = entries(type(stage))
    assert list(said) == [one.name for one in fields(stage)]
    for one, text in said.items():
        assert re.match(r"(tuple of )*(int\b|float, \S)", text), f"{name}.{one} has no unit"
        assert re.search(CHOSEN, text), f"{name}.{one} does not say what it was chosen by"


@pytest.mark.parametrize("name", EVERY)
def test_every_setting_is_read_by_the_code(name):
    names = [one.name for one in fields(EVERY[name])]
    unused = [one for one in names if f"{name}.{one}" not in read()]
    assert unused == []


@pytest.mark.parametrize("name", EVERY)
def test_settings_cannot_be_changed(name):
    stage = EVERY[name]
    first = fields(stage)[0].name
    with pytest.raises(FrozenInstanceError):
        setattr(stage, first, 1)
    assert not hasattr(stage, "__dict__")
    assert hash(stage) == hash(type(stage)())


def test_a_run_gathers_every_stage_of_tracking():
    gathered = [type(stage) for stage in STAGES.values()]
    paths = [p.relative_to(PACKAGE.parent).with_suffix("") for p in PACKAGE.rglob("*.py")]
    homes = [p.as_posix().replace("/", ".") for p in paths if "settings" in p.parts]
    assert {one.__module__ for one in gathered} == set(homes) - {
        "abs_engine.cli.parts.settings",  # options of a command
        learning.__name__,
        heads.__name__,
        measured.__name__,
        capturing.__name__,
        exporting.__name__,
        stages.__name__,
        *(home for home in homes if home.endswith("__init__")),
    }


def test_values_are_plain_and_come_back_from_json():
    values = stage_values()
    assert list(values) == list(STAGES)
    told = json.loads(json.dumps(values))
    for name, stage in STAGES.items():
        back = {k: tuples(v) for k, v in told[name].items()}
        assert type(stage)(**back) == stage


def tuples(value):
    return tuple(map(tuples, value)) if isinstance(value, list) else value
