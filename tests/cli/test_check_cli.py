"""What `abs-engine check` says of a part of a dataset."""

from __future__ import annotations

import pytest
from inspected import write_dataset

from abs_engine.cli import main


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return write_dataset(tmp_path_factory.mktemp("check") / "data")


@pytest.mark.parametrize(
    ("here", "typed", "root"),
    [
        ("..", "data/clip", "data"),
        ("..", "data/clip/front", "data"),
        ("clip", ".", ".."),
        ("clip/front", "../front", "../.."),
        (".", "clip", "."),
    ],
)
def test_a_part_of_a_dataset_leads_to_the_whole(data, monkeypatch, capsys, here, typed, root):
    monkeypatch.chdir(data / here)
    assert main(["check", typed]) == 2
    line = capsys.readouterr().err
    assert line == (
        f"abs-engine: error: {typed} is a part of the dataset {root}, which is checked as a "
        f"whole; type 'abs-engine check {root}'\n"
    )


def test_what_is_no_dataset_is_no_part_of_one(tmp_path, capsys):
    assert main(["check", str(tmp_path)]) == 2
    assert "is not ground truth: dataset.json is missing" in capsys.readouterr().err
