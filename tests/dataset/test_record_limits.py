"""The list of clips of a dataset cannot lead out of its folder, nor nest without end."""

from __future__ import annotations

import json

import pytest

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.dataset.codec import DATASET, FORMAT, VERSION
from abs_engine.dataset.dataset import read_record
from abs_engine.evaluate.same_clip import video_sum
from abs_engine.report.facts import run_facts


def _record(name: str, camera: str) -> str:
    clip = {"name": name, "person": "x", "sentence": "a", "frames": 2, "rate": 25.0}
    told = {"format": FORMAT, "version": VERSION, "command": "made", "engine": "0.1"}
    return json.dumps(told | {"seed": 0, "clips": [clip | {"cameras": [camera]}], "labels": []})


def test_a_name_within_the_folder_is_read(tmp_path):
    (tmp_path / DATASET).write_text(_record("talk", "front"))
    assert read_record(tmp_path).clips[0].name == "talk"


@pytest.mark.parametrize("name", ["../secret", "/etc", "..", "", "a\\b"])
def test_names_of_clips_and_cameras_stay_in_their_folder(tmp_path, name):
    for text in (_record(name, "front"), _record("talk", name)):
        (tmp_path / DATASET).write_text(text)
        with pytest.raises(ModelFormatError, match="names no folder within it"):
            read_record(tmp_path)


def test_json_that_nests_too_deep_is_no_record_and_no_run(tmp_path):
    for name in (DATASET, "run.json"):
        (tmp_path / name).write_text("[" * 200_000)
    with pytest.raises(InputFileError, match="not a list of clips"):
        read_record(tmp_path)
    assert video_sum(tmp_path) is None
    assert run_facts(tmp_path) == (("results", str(tmp_path)),)


@pytest.mark.parametrize("text", ["[]", "3", '{"settings": 3, "summary": []}'])
def test_a_run_that_says_nothing_is_shown_by_its_name(tmp_path, text):
    (tmp_path / "run.json").write_text(text)
    assert run_facts(tmp_path) == (("results", str(tmp_path)),)
