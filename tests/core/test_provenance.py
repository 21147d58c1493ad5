"""Which commit results come from, by a checkout, a wheel, or not at all."""

from __future__ import annotations

import json
import subprocess

import pytest

from abs_engine.core import provenance
from abs_engine.core.provenance import FIGURES, caution, described, made_by

COMMIT = "0123456789abcdef0123456789abcdef01234567"


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package in a folder of its own."""
    inner = tmp_path / "abs_engine"
    inner.mkdir()
    (inner / "a.py").write_text("1\n")
    monkeypatch.setattr(provenance, "_PACKAGE", inner)
    monkeypatch.setattr(provenance, "_BUILT", inner / "commit.json")
    made_by.cache_clear()
    provenance.code_digest.cache_clear()
    yield inner
    made_by.cache_clear()
    provenance.code_digest.cache_clear()


def git(folder, *words):
    who = ("-c", "user.name=a", "-c", "user.email=a@b.c")
    subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True)


def test_a_checkout_names_its_commit_and_changes_of_code_alone(package):
    root = package.parent
    git(root, "init", "-q")
    git(root, "add", ".")
    git(root, "commit", "-qm", "first")
    made = made_by()
    assert len(made["commit"]) == 40
    assert made["dirty"] is False
    assert caution({FIGURES: made}) is None
    (root / "README.md").write_text("a page")
    made_by.cache_clear()
    assert made_by()["dirty"] is False
    (package / "a.py").write_text("2\n")
    made_by.cache_clear()
    assert made_by()["dirty"] is True
    assert "the code that made these figures had changes" in caution({FIGURES: made_by()})


def test_a_wheel_says_what_it_was_built_from(package):
    (package / "commit.json").write_text(json.dumps({"commit": COMMIT, "dirty": False}))
    assert (made_by()["commit"], made_by()["dirty"]) == (COMMIT, False)
    assert described(made_by()).endswith("commit 0123456789ab")


def test_without_either_the_commit_is_unknown_and_nothing_is_published(package):
    assert (made_by()["commit"], made_by()["dirty"]) == (None, None)
    assert "not known" in caution({FIGURES: made_by()})
    assert "not known" in caution({FIGURES: {"engine_version": "0.1.0"}})  # of an older release


def test_every_source_that_may_not_be_published_is_named():
    made = {
        "the page": {"commit": COMMIT, "dirty": False},
        "a run": {"commit": COMMIT, "dirty": True},
        "another": {"commit": COMMIT, "dirty": None},
        "the film": {"dirty": False},
    }
    assert caution(made) == (
        "Not for publication: it is not known which commit made the film; the code that made "
        "a run, another had changes that are in no commit."
    )


@pytest.mark.parametrize(
    "file",
    [
        "b.py",
        "../assets/speaker/head.npz",
        "../assets/population/heads.npz",
        "_data/shaders/a.glsl",
    ],
)
def test_the_digest_of_the_code_changes_with_it_and_with_its_data(package, file):
    before = provenance.code_digest()
    (package / file).parent.mkdir(parents=True, exist_ok=True)
    (package / file).write_text("")
    provenance.code_digest.cache_clear()
    assert provenance.code_digest() != before
