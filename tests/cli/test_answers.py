"""What every command has: JSON on stdout, quiet, a settings file, completion, no abbreviations."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib

import numpy as np
import pytest
from drawn import lit
from heads import seen_at
from hurried import PROGRAM as HURRIED
from runs import full, write_kind, write_noise

from abs_engine.cli import COMPLETE, main
from abs_engine.cli.commands.live import live
from abs_engine.cli.commands.track import track
from abs_engine.cli.parts.settings import settings_text
from abs_engine.cli.program import PROGRAM
from abs_engine.core.errors import ParameterError
from abs_engine.core.registry import DRIVERS
from abs_engine.live import feed


@pytest.fixture(scope="module")
def tracked(tmp_path_factory):
    """A clip of two frames in a folder, and what the command that tracked it said."""
    folder = tmp_path_factory.mktemp("clip")
    poses = [seen_at([0, 0.05 * k, 0], [0, 0, 700]) for k in range(2)]
    write_kind(folder / "talk.mp4", "libx264", [lit("amara", p, jawOpen=0.2) for p in poses])
    words = "track talk.mp4 -o run --renderer cpu --pupil-distance 60 --terms colour --json --quiet"
    return folder, subprocess.run(
        [sys.executable, "-c", HURRIED, *words.split()], cwd=folder, capture_output=True, text=True,
        check=True,
    )  # fmt: skip


def test_stdout_is_json_and_nothing_else(tracked):
    folder, said = tracked
    answer = json.loads(said.stdout)
    assert answer["summary"]["frames"] == 2
    assert answer.pop("output") == "run"
    timing = json.loads((folder / "run" / "timing.json").read_text())
    assert answer.pop("timing").items() <= timing.items()
    kept = json.loads((folder / "run" / "run.json").read_text())
    assert kept["settings"].pop("tuning")  # too long to print
    assert answer == kept
    assert said.stderr == ""


def test_a_run_keeps_its_settings(tracked):
    settings = tomllib.loads((tracked[0] / "run" / "settings.toml").read_text())
    assert settings == {
        "pupil-distance": 60.0, "terms": "colour", "evidence": "both", "renderer": "cpu"
    }  # fmt: skip


def test_the_video_of_a_run_is_found_from_elsewhere(tracked, tmp_path, monkeypatch, capsys):
    folder, _ = tracked
    monkeypatch.chdir(tmp_path)
    assert main(["report", str(folder / "run"), "-o", "page.html", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"output": "page.html"}


def test_a_run_that_does_not_fit_on_the_disk_gets_no_name(tracked, tmp_path, capsys):
    video, run = tracked[0] / "talk.mp4", tmp_path / "run"
    with full(2000):
        assert main(["track", str(video), "-o", str(run), "--renderer", "cpu", "--quiet"]) == 2
    assert capsys.readouterr().err.splitlines() == [
        f"abs-engine: error: {run} cannot be written (File too large); choose a place of yours, "
        "with space left"
    ]
    assert not run.exists()


def given(*words: str) -> dict[str, object]:
    return track.make_context("track", ["talk.mp4", "-o", "new", *words]).params


@pytest.fixture
def settings(tmp_path, monkeypatch):
    """A settings file beside a camera, seen from another folder."""
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "camera.json").touch()
    (tmp_path / "plugin.py").touch()
    monkeypatch.chdir(tmp_path / "own")

    def write(text: str) -> str:
        (tmp_path / "settings.toml").write_text(text)
        return str(tmp_path / "settings.toml")

    return write


def test_settings_are_taken_and_what_is_typed_has_precedence(settings):
    file = settings(
        'face = 2\nmouth = [1, 2, 3, 4]\ndriver = "simplex"\ncamera = "own/camera.json"'
    )
    found = given("--settings", file, "--driver", "newton")
    assert found["face"] == 2
    assert found["mouth"] == (1.0, 2.0, 3.0, 4.0)
    assert found["driver"] == "newton"
    assert found["camera"].samefile("camera.json")


def test_settings_come_back_as_they_were_given(settings, tmp_path):
    words = "--mouth 1 2 3.5 4 --plugin ../plugin.py --camera camera.json --start blobs --face 3"
    typed = given(*words.split())
    file = settings(settings_text(track, typed, tmp_path))
    again = given("--settings", file)
    assert {path.resolve() for path in again["plugin"]} == {tmp_path / "plugin.py"}
    assert again["camera"].samefile(typed["camera"])
    for name in set(typed) - {"plugin", "camera", "settings"}:
        assert again[name] == typed[name], name


def test_paths_of_settings_lead_there_from_where_a_link_to_the_folder_leads(settings, tmp_path):
    deep = tmp_path / "deep" / "place"
    deep.mkdir(parents=True)
    (tmp_path / "link").symlink_to(deep)
    text = settings_text(track, given("--camera", "camera.json"), tmp_path / "link" / "run")
    assert 'camera = "../../../own/camera.json"' in text


def test_a_path_that_is_no_utf_8_cannot_be_a_setting(settings, tmp_path, capsys):
    (tmp_path / "c\udcff.json").write_text("{}")
    words = ["--camera", str(tmp_path / "c\udcff.json")]
    with pytest.raises(ParameterError, match=r"c.\.json is not UTF-8, and settings.toml cannot"):
        settings_text(track, given(*words), tmp_path / "run")


def test_settings_of_a_live_session_come_back(settings, tmp_path):
    words = ["1", "-o", "new", "--delay", "90", "--repeat", "3", "--camera", "camera.json"]
    words += ["--live-link", "[::1]:11111"]
    typed = live.make_context("live", words).params
    file = settings(settings_text(live, typed, tmp_path))
    again = live.make_context("live", ["1", "-o", "new", "--settings", file]).params
    assert again["camera"].samefile(typed["camera"])
    for name in set(typed) - {"camera", "settings"}:
        assert again[name] == typed[name], name


@pytest.mark.parametrize(
    ("words", "played"),
    [(["a.mp4"], 3), (["a.mp4", "--repeat", "2"], 2), (["1"], 1), (["1", "--repeat", "2"], 2)],
)
def test_settings_of_a_session_that_played_a_file_are_those_of_a_camera_too(
    words, played, settings, monkeypatch, capsys
):
    """A camera is not played again; that is refused where it is typed."""

    def opened(_source, repeat):
        raise ParameterError(f"played {repeat} times", "stop")

    monkeypatch.setattr(feed, "open_feed", opened)
    assert main(["live", *words, "--settings", settings("repeat = 3")]) == 2
    assert f"played {played} times" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("pupil_distance = 60", "has the key 'pupil_distance', which is no option of track; did "
         "you mean 'pupil-distance'?"),
        ('output = "run"', "which is no option of track"),
        ("face = 0", "'--face': 0 is not 1 or more"),
        ('evidence = "all"', "there is no choice 'all'"),
        ("mouth = [1, 2]", "'--mouth'"),
        ('camera = "none.json"', "none.json does not exist"),
        ("camera = 3", "3 does not exist"),
        ("face = 2.7", "'--face'"),
        ('pupil-distance = "wide"', "'--pupil-distance'"),
        ('driver = ["newton", "simplex"]', "more than one value for 'driver'"),
        ("[model]\na = 1", "more than one value for 'model'"),
        ("mouth = 3", "'--mouth'"),
        ("face = ", "is not TOML"),
    ],
)  # fmt: skip
def test_settings_that_are_wrong(text, said, settings, capsys):
    words = ["track", "talk.mp4", "-o", "new", "--settings", settings(text)]
    assert main(words) == 2
    line = capsys.readouterr().err
    assert said in line
    assert line.count("\n") == 1


def test_options_with_several_values(capsys):
    command = PROGRAM.get_command(None, "cameras")
    lips = __file__
    found = command.make_context("cameras", [lips, "--yaw", "-30", "0", "--have", "90"]).params
    assert (found["yaw"], found["have"], found["noise"]) == ((-30, 0), (90,), None)
    found = command.make_context("cameras", ["--yaw", "-30", "--noise", "1", lips]).params
    assert (found["yaw"], found["physics"].name) == ((-30,), "test_answers.py")
    assert main(["cameras", lips, "--have"]) == 2
    line = capsys.readouterr().err
    assert "'--have' requires an argument; see 'abs-engine cameras --help'" in line


@pytest.mark.parametrize(
    "words",
    [
        ["--smooth", "-o", "run"],
        ["-o", "--smooth", "butterworth:8"],
        ["--terms", "--quiet"],
        ["-o", "--help"],
    ],
)
def test_an_option_without_its_value_does_not_take_the_next_one(words, capsys):
    assert main(["track", "talk.mp4", *words]) == 2
    assert f"option '{words[0]}' needs a value before '{words[1]}'" in capsys.readouterr().err


def test_an_option_whose_value_may_be_left_out_is_followed_by_others(capsys):
    assert main(["bench", "--json", "--renderer", "nosuch"]) == 2
    assert "--renderer goes with --clip" in capsys.readouterr().err


def test_options_are_not_abbreviated(capsys):
    assert main(["track", "talk.mp4", "-o", "new", "--colour", "y"]) == 2
    assert "there is no option '--colour'; did you mean '--colours'?" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--colours", "--physics", "--poses", "--speaker"])
def test_files_are_read_before_a_renderer_is_opened(option, tmp_path, capsys, monkeypatch):
    def opened(_name: str) -> None:
        raise AssertionError("a renderer was opened")

    monkeypatch.setattr("abs_engine.cli.commands.track.opened", opened)
    video, file = write_noise(tmp_path / "noise.mp4"), tmp_path / "file.npz"
    words = ["track", str(video), "-o", str(tmp_path / "run"), option, str(file)]
    assert main(words) == 2
    assert "file.npz does not exist" in capsys.readouterr().err
    np.savez(file, format="something", version=1)
    assert main(words) == 2
    assert "file.npz" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("abs-engine tr", {"track", "train"}),
        ("abs-engine track --pup", {"--pupil-distance"}),
        ("abs-engine track --driver ", set(DRIVERS.names())),
        ("abs-engine track --terms colour+te", {"colour+texture"}),
        ("abs-engine track --person wal", {"walter"}),
        ("abs-engine synth wol", {"wolves"}),
        ("abs-engine render --rows jawO", {"jawOpen"}),
        ("abs-engine bench --renderer cp", {"cpu"}),
    ],
)
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_completes(shell, typed, completed, monkeypatch, capsys):
    words = typed.split(" ")
    last = words[-1] if shell == "fish" else str(len(words) - 1)
    monkeypatch.setenv(COMPLETE, f"{shell}_complete")
    monkeypatch.setenv("COMP_WORDS", typed)
    monkeypatch.setenv("COMP_CWORD", last)
    assert main([]) == 0
    out = capsys.readouterr().out
    if shell == "zsh":
        found = set(out.splitlines()[1::3])
    else:
        found = {line.split(",", 1)[1].partition("\t")[0] for line in out.splitlines()}
    assert found - {""} >= completed
    assert all(word.startswith(words[-1]) for word in found - {""})


@pytest.mark.parametrize("name", PROGRAM.list_commands(None))
def test_every_option_says_what_it_does(name):
    command = PROGRAM.get_command(None, name)
    assert [p.name for p in command.params if not p.help] == []
    assert {"quiet", "json"} <= {p.name for p in command.params}


def test_the_program_starts_without_heavy_modules():
    code = (
        "import sys\nfrom abs_engine.cli.program import PROGRAM\n"
        "[PROGRAM.get_command(None, name) for name in PROGRAM.list_commands(None)]\n"
        "print(sorted({'scipy', 'numba', 'rich', 'av', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ
    )
    assert done.stdout.strip() == "[]"
