"""Bad input: one line that says what is wrong and what to do, status 2, nothing left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import whole_files
from results import clip, write_dataset
from runs import write_broken, write_noise, write_speaker

from abs_engine.__main__ import run
from abs_engine.capture.dot_annotations import read_marks
from abs_engine.capture.head import read_reference
from abs_engine.cli import main
from abs_engine.cli.parts import drawing
from abs_engine.cli.parts import progress as progress_module
from abs_engine.cli.parts.progress import Progress, progress_text
from abs_engine.cli.parts.summary import summary_lines
from abs_engine.core.errors import InputFileError
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer
from abs_engine.studio.journal import Journal


@pytest.fixture(scope="module")
def noise_video(tmp_path_factory) -> Path:
    return write_noise(tmp_path_factory.mktemp("noise") / "noise.mp4")


@pytest.fixture
def fails(capsys, tmp_path):
    """Run a command that is to fail; its line."""

    def run(*words: object) -> str:
        before = sorted(tmp_path.rglob("*"))
        status = main([str(word) for word in words])
        lines = capsys.readouterr().err.splitlines()
        assert status == 2
        assert len(lines) == 1, lines
        assert lines[0].startswith("abs-engine: error: ")
        assert "; " in lines[0], "what to do is missing"
        assert sorted(tmp_path.rglob("*")) == before
        return lines[0]

    return run


def track(video: object, output: Path, *more: object) -> list[object]:
    return ["track", video, "-o", output, "--renderer", "cpu", "--quiet", *more]


def test_a_missing_video(fails, tmp_path):
    assert "does not exist" in fails(*track(tmp_path / "none.mp4", tmp_path / "run"))


def test_a_film_that_was_interrupted_is_not_tracked_over(fails, noise_video, tmp_path):
    with Journal(tmp_path / "run", "scene") as journal:
        (journal.chunks / "00000-000-00000.npz").touch()
    line = fails(*track(noise_video, tmp_path / "run"))
    assert f"{journal.partial} holds what an interrupted command had kept; finish it by" in line


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["track", "a.mp4", "-o", "run", "--rendrer", "cpu"], "track"),
        (["synth", "closures", "-o", "clip", "--bogus"], "synth"),
        (["check", "clip", "--bogus"], "check"),
        (["evaluate", "a", "--truth", "b", "--bogus"], "evaluate"),
    ],
)
def test_an_unknown_option_names_its_own_commands_help(words, named, fails):
    line = fails(*words)
    assert "there is no option '--" in line
    assert line.endswith(f"see 'abs-engine {named} --help'")


def test_a_seed_below_0(fails, tmp_path):
    line = fails("evaluate", tmp_path, "--truth", tmp_path, "--seed", -1)
    assert "'--seed': -1 is not in the range" in line


def test_an_address_in_place_of_a_file(fails, tmp_path):
    line = fails(*track("http://example.org/talk.mp4", tmp_path / "run"))
    assert "http://example.org/talk.mp4 is an address, not a file" in line
    assert "is an address" in fails("check", "https://example.org/clip")


def test_a_tilde_that_the_shell_left_is_the_home(fails, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert f"{tmp_path}/none.mp4 does not exist" in fails(*track("~/none.mp4", tmp_path / "run"))
    line = fails(*track(write_noise(tmp_path / "v.mp4"), "~/none/run"))
    assert f"there is no folder {tmp_path}/none" in line
    assert f"{tmp_path}/none.face" in fails(
        *track(tmp_path / "v.mp4", tmp_path / "run", "--model", "~/none.face")
    )
    assert "~nobody-of-that-name/v.mp4 does not exist" in fails(
        *track("~nobody-of-that-name/v.mp4", tmp_path / "run")
    )


def test_an_empty_video(fails, tmp_path):
    (tmp_path / "empty.mp4").touch()
    assert "is empty" in fails(*track(tmp_path / "empty.mp4", tmp_path / "run"))


def test_a_file_that_is_no_video(fails, tmp_path):
    (tmp_path / "text.mp4").write_text("no video\n" * 100)
    assert "is not a video" in fails(*track(tmp_path / "text.mp4", tmp_path / "run"))


def test_a_folder_in_place_of_a_video(fails, tmp_path):
    assert "is a folder" in fails(*track(tmp_path, tmp_path / "run"))


def test_a_video_that_breaks_off(fails, tmp_path):
    line = fails(*track(write_broken(tmp_path / "cut.mp4"), tmp_path / "run"))
    assert "is cut off after" in line


def test_a_video_that_breaks_off_before_its_index(fails, tmp_path, noise_video):
    content = noise_video.read_bytes()
    (tmp_path / "cut.mp4").write_bytes(content[: len(content) // 2])
    assert "is cut off before" in fails(*track(tmp_path / "cut.mp4", tmp_path / "run"))


def test_a_real_clip_without_an_index_that_breaks_off(fails, tmp_path, data_dir):
    clip = next(iter(sorted((data_dir / "grid").glob("*.mpg")))).read_bytes()
    (tmp_path / "cut.mpg").write_bytes(clip[: int(0.55 * len(clip))])
    assert "is cut off after 42 frames" in fails(*track(tmp_path / "cut.mpg", tmp_path / "run"))


def test_a_demo_that_fails_leaves_no_folder_for_runs(fails, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ABS_ENGINE_HIDE_GL", "all")
    assert "hidden by" in fails("demo", "--renderer", "egl-surfaceless")


def test_a_video_without_a_face(fails, tmp_path, noise_video):
    line = fails(*track(noise_video, tmp_path / "run"))
    assert "no face was found" in line
    assert "needs --mouth" in line
    longer = write_noise(tmp_path / "longer.mp4", 30)
    line = fails(*track(longer, tmp_path / "run", "--mouth", 20, 20, 40, 30))
    assert "no face was found" in line
    assert "check that --mouth holds the whole mouth" in line


def test_a_mouth_outside_of_the_picture(fails, tmp_path, noise_video):
    for box in ((0, 0, 0, 10), (90, 10, 20, 10), ("nan", 0, 10, 10)):
        assert "not in the picture" in fails(*track(noise_video, tmp_path / "run", "--mouth", *box))


def test_an_output_that_exists(fails, tmp_path, noise_video):
    (tmp_path / "run").mkdir()
    (tmp_path / "file.png").touch()
    (tmp_path / "link").symlink_to("nowhere")
    for name in ("run", "file.png", "link"):
        assert "exists already" in fails(*track(noise_video, tmp_path / name))
    assert "exists already" in fails("demo", "-o", tmp_path / "run")
    assert "exists already" in fails("synth", "demo", "-o", tmp_path / "run")
    assert "exists already" in fails("render", "-o", tmp_path / "file.png")
    assert "exists already" in fails("bench", "--json", tmp_path / "file.png")


@pytest.mark.parametrize(
    ("words", "ending"),
    [
        (("report", "run", "-o", "r.pdf"), ".html"),
        (("train", "dots.npz", "-o", "lips.txt"), ".npz"),
        (("train", "dots.npz", "-o", ".."), ".npz"),
        (("observe", "film.mp4", "-o", "dots.csv"), ".npz"),
        (("speaker", __file__, "-o", "me.npz"), ".face"),
        (("import", __file__, "-o", "head"), ".face"),
        (("mouths", __file__, "-o", "mouths.npz"), ".face"),
        (("articulate", "mine.csv", "-o", "mine", "--face", "me"), ".face"),
        (("observe", "calibrate", "a.png", "-o", "camera.npz"), ".json"),
    ],
)
def test_an_output_that_is_named_like_something_else(fails, words, ending):
    assert f"does not end in {ending}" in fails(*words)


@pytest.mark.parametrize("read", [read_marks, read_reference])
def test_missing_points(read, tmp_path):
    with pytest.raises(InputFileError, match=r"points\.csv does not exist"):
        read(tmp_path / "points.csv")


def test_an_output_that_cannot_be_written(fails, tmp_path, noise_video):
    (tmp_path / "file").touch()
    for place in (tmp_path / "none" / "run", tmp_path / "file" / "run", Path("/proc/run")):
        assert "cannot be written" in fails(*track(noise_video, place))
    assert "cannot be written" in fails("synth", "demo", "-o", tmp_path / "none" / "clip")
    assert "cannot be written" in fails("bench", "--json", tmp_path / "none" / "bench.json")


def test_a_model_of_another_version(fails, tmp_path, noise_video):
    speaker = write_speaker(tmp_path / "head.npz", version=99)
    line = fails(*track(noise_video, tmp_path / "run", "--speaker", speaker))
    assert "version 99" in line


def test_a_face_that_was_learned_on_another_head(fails, tmp_path, noise_video):
    """Its vertices are fewer than the facets of the head that is given point to."""
    face = tmp_path / "me.face"
    face.write_bytes(whole_files.speaker_face(face))
    line = fails(*track(noise_video, tmp_path / "run", "--model", face))
    assert "me.face is made of another head; give that head with --speaker" in line


def test_a_learned_face_in_place_of_a_head(fails, tmp_path, noise_video):
    face = tmp_path / "me.face"
    face.write_bytes(whole_files.speaker_face(face))
    line = fails(*track(noise_video, tmp_path / "run", "--speaker", face))
    assert "me.face is a learned face; give it to --model, and leave out --speaker" in line


def test_a_file_that_is_no_model(fails, tmp_path, noise_video):
    (tmp_path / "head.npz").write_text("no model")
    for name, text in (("head.npz", "is not an NPZ file"), ("none.npz", "does not exist")):
        line = fails(*track(noise_video, tmp_path / "run", "--speaker", tmp_path / name))
        assert text in line
    line = fails(*track(noise_video, tmp_path / "run", "--model", noise_video))
    assert "is not an NPZ file; if it is a model, check" in line
    assert "else give a face that 'speaker' learned" in line


def test_a_mesh_with_nan_or_without_area(fails, tmp_path, noise_video):
    vertices = load_speaker().vertices
    broken = vertices.copy()
    broken[7] = np.nan
    for values, text in ((broken, "NaN"), (np.zeros_like(vertices), "zero area")):
        speaker = write_speaker(tmp_path / "head.npz", vertices=values)
        assert text in fails(*track(noise_video, tmp_path / "run", "--speaker", speaker))


def test_names_that_no_file_can_have(fails, tmp_path, noise_video):
    long = tmp_path / ("x" * 300)
    words = track(noise_video, tmp_path / "run", "--camera", long)
    assert "cannot be read (File name too long)" in fails(*words)
    assert "cannot be written" in fails(*track(noise_video, long / "run"))


def test_a_wrong_camera(fails, tmp_path, noise_video):
    camera = tmp_path / "camera.json"
    words = track(noise_video, tmp_path / "run", "--camera", camera)
    assert "does not exist" in fails(*words)
    camera.write_text('{"format": "abs_engine.camera", "version": 7}')
    assert "version 7" in fails(*words)
    camera.write_text(
        '{"format": "abs_engine.camera", "version": 2, "size": [32, 24], "near": 10, "far": 9000,'
        ' "matrix": [[50, 0, 16], [0, 50, 12], [0, 0, 1]], "distortion": [0, 0, 0, 0]}'
    )
    assert "32x24 pixels, the video 96x80" in fails(*words)


def test_unknown_names(fails, tmp_path, noise_video):
    assert "no person 'nobody'" in fails(*track(noise_video, tmp_path / "r", "--person", "nobody"))
    assert "no person" in fails("synth", "demo", "-o", tmp_path / "c", "--person", "nobody")
    assert "no viseme 'zz'" in fails("synth", "a zz", "-o", tmp_path / "c")
    assert "even sizes" in fails("synth", "demo", "-o", tmp_path / "c", "--size", 321, 240)
    words = "render", "-o", tmp_path / "p.png", "--renderer", "cpu"
    assert "no face unit 'smirk'" in fails(*words, "--unit", "smirk=1")
    assert "NAME=WEIGHT" in fails(*words, "--unit", "smirk")


def test_an_argument_that_an_option_took(fails, tmp_path):
    line = fails("evaluate", "--truth", tmp_path, tmp_path)
    assert "missing argument 'RUN...' before --truth, which takes all words up to an" in line
    assert "before" not in fails("evaluate", "--truth", tmp_path)


def test_an_option_that_is_missing_is_explained(fails, tmp_path):
    line = fails("evaluate", tmp_path)
    assert "missing option '--truth', what 'synth -o' made, or DATASET/CLIP/CAMERA; see" in line


def test_metrics_of_a_report_that_scores_nothing(fails, tmp_path):
    plugin = Path(__file__).parents[2] / "examples/new_metric.py"
    line = fails("report", tmp_path, "-o", tmp_path / "page.html", "--plugin", plugin)
    assert "--plugin adds metrics, which need a dataset; give --truth" in line


def test_a_video_is_no_result(tmp_path, capsys):
    video = write_noise(tmp_path / "talk.mp4")
    truth = write_dataset(tmp_path / "truth", clip(4))
    assert main(["evaluate", str(video), "--truth", str(truth)]) == 2
    assert "talk.mp4 is not text; give a run's folder or a CSV" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"talk.mp4", "truth"}


def test_what_is_no_run_or_no_truth(fails, tmp_path):
    assert "is not a run" in fails("evaluate", tmp_path, "--truth", tmp_path)
    np.savez(tmp_path / "results.npz", format="abs_engine.run", version=9)
    assert "version 9" in fails("evaluate", tmp_path, "--truth", tmp_path)


def test_a_command_typed_wrongly(fails):
    assert "see 'abs-engine track --help'" in fails("track")
    said = fails("dance")
    assert "there is no command 'dance'; choose one of articulate, " in said
    assert "see 'abs-engine --help'" in said
    assert "there is no command 'trak'; did you mean 'track'?" in fails("trak")
    assert "is not 1 or more" in fails("demo", "--frames", "0")


def test_opengl_that_is_not_there(fails, tmp_path, noise_video, monkeypatch):
    monkeypatch.setenv("ABS_ENGINE_HIDE_GL", "all")
    words = "track", noise_video, "-o", tmp_path / "run", "--renderer", "egl-surfaceless"
    assert "libegl1" in fails(*words)


def test_ctrl_c_leaves_nothing(capsys, tmp_path, noise_video, monkeypatch):
    def interrupt(*_: object) -> None:
        assert list(tmp_path.iterdir())  # something was begun
        raise KeyboardInterrupt

    monkeypatch.setattr("abs_engine.tracking.run.prepare", interrupt)
    assert main([str(word) for word in track(noise_video, tmp_path / "run")]) == 130
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_ctrl_c_in_a_compiled_loop_is_an_interruption(capsys, tmp_path, noise_video, monkeypatch):
    def interrupt(*_: object) -> None:
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    monkeypatch.setattr("abs_engine.tracking.run.prepare", interrupt)
    words = [str(word) for word in track(noise_video, tmp_path / "run")]
    assert main(words) == 130
    assert capsys.readouterr().err.splitlines()[-1] == "abs-engine: interrupted"


def test_ctrl_c_while_the_command_loads_is_an_interruption(capsys, monkeypatch):
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("abs_engine.cli.main", interrupt)
    assert run() == 130
    assert capsys.readouterr().err == "abs-engine: interrupted\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_in_a_callback_whose_errors_are_dropped_is_an_interruption(
    number, capsys, monkeypatch
):
    class Gone:
        def __del__(self) -> None:
            signal.raise_signal(number)

    def loading(*_: object) -> int:
        gone = Gone()
        del gone
        time.sleep(20)
        return 0

    monkeypatch.setattr("sys.unraisablehook", sys.unraisablehook)
    monkeypatch.setattr("sys.argv", ["abs-engine", "doctor"])
    monkeypatch.setattr("abs_engine.cli._command", loading)
    usual = signal.getsignal(signal.SIGINT)
    try:
        # ignored as where a shell runs it beside others, the tests, too
        other = number != signal.SIGINT
        signal.signal(signal.SIGINT, signal.SIG_IGN if other else signal.default_int_handler)
        assert run() == 130
    finally:
        signal.signal(signal.SIGINT, usual)
    assert capsys.readouterr().err == "abs-engine: interrupted\n"


@pytest.mark.parametrize("words", [("track", ""), ("train", "dots.npz", "-o", "")])
def test_an_empty_path_is_refused(words, fails):
    assert "a path is empty" in fails(*words)


@pytest.mark.parametrize("value", ['"maybe"', "1"])
def test_a_flag_of_a_settings_file_is_true_or_false(value, fails, tmp_path, noise_video):
    (tmp_path / "s.toml").write_text(f"worn = {value}")
    words = *track(noise_video, tmp_path / "run"), "--settings", tmp_path / "s.toml"
    assert "give true or false" in fails(*words)


def test_another_system_error_is_none(tmp_path, noise_video, monkeypatch):
    def fail(*_: object) -> None:
        raise SystemError("a bug")

    monkeypatch.setattr("abs_engine.tracking.run.prepare", fail)
    with pytest.raises(SystemError, match="a bug"):
        main([str(word) for word in track(noise_video, tmp_path / "run")])


def test_errors_come_at_once():
    code = (
        "import sys\nfrom abs_engine.cli import main\n"
        "status = main(['track', 'none.mp4', '-o', 'none'])\n"
        "print(status, sorted({'numba', 'moderngl', 'pyrender', 'skimage'} & set(sys.modules)))"
    )
    folders = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=folders
    )
    assert done.stdout.strip() == "2 []"


def test_progress_says_how_far_it_is(capsys):
    assert progress_text(30, 75, 3.0) == "30 of 75 frames, 10.0 frames/s, 4 s left"
    assert progress_text(30, 0, 3.0) == "30 frames, 10.0 frames/s"
    with Progress("tracking") as progress:
        progress.announce("fitting")
        progress.restart(1.0)
        for done in range(1, 4):
            progress(done, 3)
    assert capsys.readouterr().err == ""  # too quick for a line in a log


def test_a_remark_is_part_of_the_answer_and_ends_the_line(capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    with Progress("tracking") as progress:
        progress.announce("fitting")
        progress.remark("2 faces: the first is followed")
        told = capsys.readouterr()
        assert told.out == "2 faces: the first is followed\n"
        assert told.err.startswith("\rtracking: fitting")
        assert told.err.endswith("\n")


def test_a_log_names_each_stage_that_takes_long(capsys, monkeypatch):
    monkeypatch.setattr(progress_module, "INTERVAL", 0.02)
    with Progress("tracking") as progress:
        for stage in ("finding", "fitting"):
            progress.announce(stage)
            time.sleep(0.2)
        progress.restart(11.2)
        time.sleep(0.05)
    lines = capsys.readouterr().err.splitlines()
    assert lines == ["tracking: finding", "tracking: fitting", "tracking: prepared in 11 s"]


def test_a_terminal_sees_a_clock_that_stops(capsys, monkeypatch):
    monkeypatch.setattr(progress_module, "_TICK", 0.02)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    with Progress("tracking") as progress:
        progress.announce("fitting")
        time.sleep(0.2)
        progress.restart(0.2)
        told = capsys.readouterr().err
        time.sleep(0.1)
        assert capsys.readouterr().err == ""
        progress(3, 3)
    assert told.startswith("\rtracking: fitting ")
    assert "\rtracking: fitting, 0 s" in told
    last = capsys.readouterr().err
    assert last.startswith("\rtracking: 3 of 3 frames")
    assert last.endswith("\n")


@pytest.mark.parametrize(("hardware", "said"), [(True, ""), (False, "--renderer cpu")])
def test_track_hints_at_slow_opengl(capsys, hardware, said):
    renderer = object.__new__(OpenGLRenderer)
    renderer.gl = SimpleNamespace(hardware=hardware)
    drawing.print_hints(renderer)
    told = capsys.readouterr().out
    assert said in told
    assert bool(told) == bool(said)


def test_track_has_no_hint_for_the_cpu_rasteriser(capsys):
    drawing.print_hints(CpuRenderer())
    assert not capsys.readouterr().out


def test_lost_frames_are_printed_with_their_reasons():
    told = {"frames": 40, "lost_frames": 16, "closed_frames": 1, "mean_evaluations": 300.0}
    told |= {"lost_reasons": {"mouth covered": 14, "face not found": 2}}
    (line,) = summary_lines(told, {"seconds_per_frame": 0.1})
    assert line.startswith("40 frames, 16 lost (mouth covered in 14, face not found in 2), 1 with")


@pytest.mark.parametrize(("count", "said"), [(0, "lips; "), (3, "lips, 3 contradicted by ")])
def test_frames_that_landmarks_contradict_are_counted(count, said):
    told = {"frames": 40, "lost_frames": 0, "closed_frames": 1, "mean_evaluations": 300.0}
    (line,) = summary_lines({**told, "contradicted_frames": count}, {"seconds_per_frame": 0.1})
    assert line.startswith(f"40 frames, 0 lost, 1 with closed {said}")


def test_the_warnings_printed_are_those_of_the_run():
    told = {"frames": 5, "lost_frames": 0, "closed_frames": 1, "mean_evaluations": 300.0}
    told |= {"mean_score": 0.6, "warnings": ["look at it"]}
    assert list(summary_lines(told, {"seconds_per_frame": 0.1}))[1:] == ["warning: look at it"]


def test_a_warning_that_was_printed_before_is_not_printed_again():
    told = {"frames": 5, "lost_frames": 0, "closed_frames": 1, "mean_evaluations": 300.0}
    told |= {"mean_score": 0.9, "warnings": ["the film is cut", "look at it"]}
    lines = list(summary_lines(told, {"seconds_per_frame": 0.1}, "2 faces\nthe film is cut"))
    assert lines[1:] == ["warning: look at it"]
