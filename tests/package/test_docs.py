"""The README and the documentation: code blocks work, and the site is built without warnings."""

from __future__ import annotations

import csv
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import click
import numpy as np
import pytest
from pages import PAGES, ROOT, Block, PageError, Reader, blocks_of, check
from unrun import LINES, PROGRAMS

from abs_engine import __all__ as public
from abs_engine import load_articulatory
from abs_engine.cli.program import PROGRAM
from abs_engine.face.shape.predictors import PAPER_PREDICTORS
from abs_engine.papers.basu1998.summary import REMARKS
from abs_engine.papers.odisio2004.goals import GOALS
from abs_engine.report.articulation.predictor_file import read_predictors

MEASURED, TRACK = ROOT / "docs" / "measured.md", ROOT / "docs" / "track.md"


@pytest.fixture(scope="module")
def reader(tmp_path_factory) -> Reader:
    return Reader(tmp_path_factory.mktemp("kept"))


def test_the_changelog_s_page_is_the_changelog():
    page = ROOT / "docs" / "changelog.md"
    assert page.is_symlink(), "a copy grows old"
    assert page.samefile(ROOT / "CHANGELOG.md")


def _prose(page: Path) -> str:
    """A page without its blocks."""
    text = page.read_text(encoding="utf-8")
    return re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def followed(reader, tmp_path_factory) -> Callable[[Path], Path]:
    """The folder in which somebody did all that a page says, once."""

    @cache
    def follow(page: Path) -> Path:
        folder = tmp_path_factory.mktemp(page.stem)
        reader.provide(folder, page)
        assert reader.follow(page, folder) == len(blocks_of(page))
        return folder

    return follow


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_code_block_of_a_page_works(page, followed):
    followed(page)


@pytest.mark.slow
@pytest.mark.gl
def test_a_bundled_corpus_makes_its_model_again(followed):
    """What `articulate --person` writes is an example to start from."""
    folder = followed(ROOT / "docs" / "talking.md")
    one, two = (load_articulatory(folder / name / "model.npz") for name in ("clara", "model"))
    np.testing.assert_allclose(one.modes, two.modes, atol=1e-3)
    facts = [json.loads((folder / n / "results.json").read_text()) for n in ("clara", "model")]
    for name in ("variance", "left_out_error_mm_median"):
        assert facts[0][name] == pytest.approx(facts[1][name], abs=1e-3)
    assert read_predictors(folder / "clara" / "predictors.toml") == PAPER_PREDICTORS


def test_what_is_not_run_stands_on_a_page():
    """No line is left on the list that no page has any more; programs as well."""
    blocks = [block for page in PAGES for block in blocks_of(page) if block.language == "sh"]
    typed = [words for block in blocks for _, words in block.commands()]
    assert set(LINES) <= {shlex.join(words) for words in typed}
    assert set(PROGRAMS) <= {words[0] for words in typed}


def test_the_scene_of_the_page_is_the_shipped_one():
    """So that `synth short.toml` films it."""
    page = ROOT / "docs" / "ground-truth.md"
    (scene,) = [block.text for block in blocks_of(page) if block.language == "toml"]
    shipped = (ROOT / "assets" / "scenes" / "short.toml").read_text("utf-8")
    assert tomllib.loads(scene) == tomllib.loads(shipped)


def test_no_block_is_overlooked():
    for page in PAGES:
        text = page.read_text("utf-8")
        fences = len(re.findall(r"^\s*(?:```|~~~)", text, re.MULTILINE))
        assert fences == 2 * len(blocks_of(page)), page.name
        assert not re.search(r"\n\n {4,}\S", _prose(page)), f"{page.name}: indented code"


@pytest.mark.parametrize(
    ("language", "text", "said"),
    [
        ("sh", "abs-engine doctor --no-such-option\n", "no option '--no-such-option'"),
        ("sh", "# Takes long\nabs-engine train\n", "missing argument"),
        ("sh", "abs-engine live --delay\n", "'--delay' requires"),
        ("sh", "# Takes long\nabs-engine track talk.mp4 -o r --terms color\n", "did you mean"),
        ("sh", "rm -r everything\n", "'rm' is not run here"),
        ("python", "import abs_engine\nabs_engine.no_such_name\n", "no_such_name"),
        ("toml", "a = \n", "Invalid value"),
        ("", "abs-engine doctor\n", "there is no language"),
    ],
)
@pytest.mark.gl
def test_a_block_that_fails_is_named(
    language, text, said, reader, tmp_path, tmp_path_factory, monkeypatch
):
    reader.provide(tmp_path, TRACK)
    number = 2 if text.startswith("# Takes") else 1
    page = tmp_path_factory.mktemp("page") / "page.md"
    page.write_text(f"# Page\n\n```{language}\n{text}```\n", encoding="utf-8")
    monkeypatch.setattr("pages.ROOT", page.parent)
    with pytest.raises(PageError) as caught:
        reader.follow(page, tmp_path)
    assert re.match(rf"page\.md:{3 + number}: ", str(caught.value))
    assert said in str(caught.value)


def test_commands_named_in_the_text_are_those_of_the_program():
    """Inline `abs-engine ...`: the command and each option that is named exist."""
    for page in PAGES:
        for found in re.findall(r"`abs-engine ([^`]+)`", _prose(page)):
            words = shlex.split(found)
            command = PROGRAM.get_command(None, words[0])
            assert command is not None, f"{page.name}: {found}"
            known = {"--help", *(name for param in command.params for name in param.opts)}
            given = {word.strip("[]") for word in words if re.match(r"\[?-", word)}
            assert given <= set(known), f"{page.name}: {found}"


def test_every_option_is_named_on_a_page_about_its_command():
    """Those of all commands apart, and `-o`, which the blocks have."""
    pages = [page.read_text("utf-8") for page in PAGES if page != MEASURED]
    lacking = []
    for name in PROGRAM.list_commands(None):
        about = "\n".join(text for text in pages if re.search(rf"(?:abs-engine |`){name}\b", text))
        for param in PROGRAM.get_command(None, name).params:
            if isinstance(param, click.Option) and not param.hidden:
                found = (rf"(?<![\w-]){re.escape(option)}(?![\w-])" for option in param.opts)
                if not any(re.search(pattern, about) for pattern in found):
                    lacking.append((name, param.opts[-1]))
    assert lacking == []


def test_every_script_that_measures_is_there():
    found = set(re.findall(r"`(?:python|pytest) (tests/\w+\.py)", MEASURED.read_text("utf-8")))
    assert len(found) >= 6
    assert [name for name in found if not (ROOT / name).is_file()] == []


def test_the_readme_takes_five_minutes():
    assert (ROOT / "README.md").stat().st_size <= 8 * 1024
    tens = [b for b in blocks_of(ROOT / "README.md") if b.language == "python"]
    assert len([line for line in tens[0].text.splitlines() if line.strip()]) <= 10


def test_figures_of_the_readme_are_those_that_were_measured():
    """Each number of its table of figures is on the page that has them all."""
    table = (ROOT / "README.md").read_text("utf-8").partition("## Figures that matter")[2]
    rows = [line for line in table.partition("What to keep in mind")[0].splitlines()[6:] if line]
    assert len(rows) >= 6
    everything = set(re.findall(r"\d[\d.]*\d|\d", MEASURED.read_text("utf-8")))
    for row in rows:
        assert set(re.findall(r"\d[\d.]*\d|\d", row)) <= everything, row


def test_links_of_the_readme_lead_somewhere():
    text = (ROOT / "README.md").read_text("utf-8")
    links = [link for link in re.findall(r"\]\(([^)]+)\)", text) if "://" not in link]
    assert len(links) > 8
    for link in links:
        path, _, heading = link.partition("#")
        assert (ROOT / path).is_file(), link
        if heading:
            headings = re.findall(r"^#+ (.*)$", (ROOT / path).read_text("utf-8"), re.MULTILINE)
            assert heading in {re.sub(r"\W+", "-", h.lower()) for h in headings}, link


PUBLISHED = sorted((ROOT / "assets" / "published").glob("*/index.html"))


@pytest.mark.parametrize("page", PUBLISHED, ids=lambda page: page.parent.name)
def test_what_a_published_page_names_lies_beside_it(page):
    named = re.findall(r'(?:href|src)="([^"#]+)"', page.read_text(encoding="utf-8"))
    assert named
    assert [name for name in named if not (page.parent / name).is_file()] == []


SHARE = re.compile(r"\d ?%|\bone in \w+")


def test_remarks_of_reproductions_hold_no_measured_share():
    """What was measured stands in tables, from results.json; a remark cannot follow it."""
    said = [*REMARKS, *(goal.why for goal in GOALS)]
    page = (ROOT / "assets/published/000/index.html").read_text(encoding="utf-8")
    said.append(page.partition("</h1>")[2].partition("<h2>")[0])
    assert len(said) > 10
    assert [text for text in said if SHARE.search(text)] == []


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """The built site; a warning ends the build."""
    folder = tmp_path_factory.mktemp("site") / "site"
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(folder)],
        cwd=ROOT, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_the_site_is_built_without_warnings(site):
    for page in (ROOT / "docs").glob("*.md"):
        assert (site / page.with_suffix(".html").name).is_file()
    assert (site / "demo.jpg").read_bytes() == (ROOT / "assets" / "demo.jpg").read_bytes()


def test_every_public_name_is_documented(site):
    page = (site / "api.html").read_text("utf-8")
    for name in public:
        home = f'id="abs_engine.{name}"'
        assert home in page or f'id="{name}"' in page, name


def _documented(heading: str) -> set[str]:
    """The names in the first column of a table of the page on runs."""
    text = (ROOT / "docs" / "run.md").read_text("utf-8")
    section = text.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    cells = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
    names: set[str] = set()
    for cell in cells:
        given = re.findall(r"`([^`]+)`", cell)
        names.update(given)
        if " to " in cell and not given[-1].endswith("z"):  # shape1 to shape10
            stem = given[0].rstrip("0123456789")
            names.update(f"{stem}{k}" for k in range(1, int(given[-1].removeprefix(stem)) + 1))
        elif " to " in cell:  # lip48_x ... to lip67_z
            names.update(f"lip{k}_{axis}" for k in range(48, 68) for axis in "xyz")
    return names


@pytest.mark.slow
@pytest.mark.gl
def test_the_page_on_runs_names_what_a_run_holds(followed):
    run = followed(TRACK) / "tracked"
    optional = {"recording.mkv", "smoothed.csv"}  # of live, and of --smooth
    assert {path.name for path in run.iterdir()} == _documented("Files") - optional
    with (run / "results.csv").open(encoding="utf-8") as file:
        heading = next(csv.reader(file))
    assert set(heading) == _documented("Columns of results.csv")
    for name in ("results.npz", "mesh.npz"):
        with np.load(run / name) as arrays:
            assert set(arrays.files) == _documented(f"Arrays of {name}")
    kept = json.loads((run / "run.json").read_text("utf-8"))
    parts = "settings", "summary"
    inner = {f"{part}.{name}" for part in parts for name in kept[part]}
    elsewhere = {"settings.head_misfit", "settings.live"}  # of a speaker's own face, of live
    assert inner | (set(kept) - set(parts)) == _documented("run.json") - elsewhere


def test_a_command_is_checked_without_being_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check(["abs-engine", "demo", "-o", "d"])
    assert not list(tmp_path.iterdir())
    assert Block("a.md", 4, "sh", "# Takes long\na && b c # d\n").commands() == [
        (5, ["a"]),
        (5, ["b", "c"]),
    ]
