"""`abs_engine.track`: paths as text, a renderer of its own, arrays, nothing written unasked."""

from __future__ import annotations

import csv
import json
import shutil
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from drawn import lit
from heads import seen_at
from runs import write_kind

import abs_engine
from abs_engine.core.errors import (
    AbsEngineError,
    InputFileError,
    OutputError,
    ParameterError,
    PluginError,
)
from abs_engine.core.registry import DRIVERS
from abs_engine.io.assets import shipped
from abs_engine.optimise.base import Solution
from abs_engine.optimise.drivers import Driver
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking import loop
from abs_engine.tracking.models.shells import BUNDLED
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.start import shaded_skin

OPEN = (0.0, 0.12, 0.25, 0.35, 0.18)
pytestmark = pytest.mark.usefixtures("soon_ready")


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    pictures = [lit("amara", seen_at([0, 0, 0], [0, 0, 700]), jawOpen=amount) for amount in OPEN]
    return write_kind(tmp_path_factory.mktemp("film") / "head.mp4", "libx264", pictures)


@pytest.fixture(scope="module")
def run(video):
    done = []
    found = abs_engine.track(
        str(video), renderer="cpu", terms="colour+shading",
        progress=lambda k, n: done.append((k, n)),
    )  # fmt: skip
    assert done == [(k, len(OPEN)) for k in range(1, len(OPEN) + 1)]
    return found


@pytest.fixture(scope="module")
def written(video, tmp_path_factory):
    """The same run, by default, in a folder."""
    folder = tmp_path_factory.mktemp("written") / "run"
    return abs_engine.track(str(video), str(folder), renderer="cpu"), folder


SMOOTHED = {"renderer": "cpu", "terms": "colour+shading", "smooth": "savitzky-golay:5"}


@pytest.fixture(scope="module")
def smoothed(video):
    """The same, smoothed; options that are None are as if they were not there."""
    none = dict.fromkeys(("evidence", "progress", "worn", "face"))
    return abs_engine.track(video, **SMOOTHED, **none)


@pytest.fixture(scope="module")
def written_smoothed(video, tmp_path_factory):
    """That in a folder."""
    folder = tmp_path_factory.mktemp("smoothed") / "run"
    return abs_engine.track(video, folder, **SMOOTHED), folder


def test_a_run_has_arrays_and_writes_nothing(run, video):
    assert len(run) == len(OPEN)
    assert run.found.all()
    assert np.corrcoef(run.aperture, OPEN)[0, 1] > 0.95
    assert (run.aperture_sd[run.found] > 0).all()
    assert (run.width_sd[run.found] > 0).all()
    assert ((run.closed_probability > 0.5) == run.closed)[run.found].all()
    assert run.lip_points.shape[0] == run.rotation.shape[0] == len(OPEN)
    assert list(run.parameters)[:7] == ["rx", "ry", "rz", "tx", "ty", "tz", "shape1"]
    assert run.settings["terms"] == ["colour", "shading"]
    assert sorted(path.name for path in Path(video).parent.iterdir()) == ["head.mp4"]
    with pytest.raises(ParameterError, match="did you mean 'aperture'"):
        run["apertur"]
    assert "aperture" in run
    assert list(run) == list(run.arrays)
    with pytest.raises(ParameterError, match=r"run\['aperture'\]"):
        run[3]


@pytest.mark.parametrize("person", [None, "amara"])
def test_where_too_little_skin_is_seen_colours_are_compared_alone(video, monkeypatch, person):
    monkeypatch.setattr(shaded_skin, "with_shading", lambda *_: None)
    plain = abs_engine.track(str(video), renderer="cpu", person=person)
    assert [line for line in plain.warnings if line.startswith("too little skin is seen")]
    assert "shading" not in plain["term_names"]
    assert plain.settings["terms"] == ["colour"]
    assert plain.found.all()


def test_landmarks_alone_are_no_second_measure_of_themselves(video, monkeypatch):
    monkeypatch.setattr(loop, "disagreement", None)  # is not asked
    alone = abs_engine.track(str(video), renderer="cpu", evidence="landmarks")
    assert alone.found.all()
    assert not alone["contradicted"].any()


def test_the_table_is_that_of_the_file(run, written, video):
    kept, folder = written
    np.testing.assert_array_equal(kept.aperture, run.aperture)
    with (folder / "results.csv").open() as file:
        heading, *rows = csv.reader(file)
    frame = run.to_pandas()
    assert list(frame.columns) == heading
    assert len(frame) == len(rows)
    assert str(frame["closed"].dtype) == "Int8"
    assert (frame["closed"] == run.closed).all()
    column = [float(row[heading.index("aperture")]) for row in rows]
    np.testing.assert_allclose(frame["aperture"], column, rtol=1e-5)
    assert kept.summary["frames"] == len(OPEN)


def test_numbers_of_numpy_are_written_as_python_s_own():
    given = {"pupil_distance": np.float32(62), "face": np.int64(1), "worn": np.bool_(False)}
    options = TrackOptions(**given, mouth=np.array([95, 150, 60, 40]))
    kinds = [type(v) for v in (options.pupil_distance, options.face, options.worn)]
    assert kinds == [float, int, bool]
    assert json.loads(json.dumps(options.mouth)) == [95, 150, 60, 40]
    with pytest.raises(ParameterError, match="pupil_distance is too large"):
        TrackOptions(pupil_distance=10**400)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"face": "1"}, "face is '1'; give a whole number"),
        ({"face": 1.0}, "face is 1.0; give a whole number"),
        ({"pupil_distance": "60"}, "pupil_distance is '60'; give a number"),
        ({"mouth": (1, 2, 3)}, "give four numbers"),
        ({"mouth": 5}, "give four numbers"),
        ({"worn": "yes"}, "give True or False"),
        ({"preset": 3}, "give text"),
        ({"face": True}, "face is True; give a whole number"),
        ({"mouth": iter((1, 2, 3, 4))}, "give four numbers"),
        ({"terms": 5}, "terms is 5; give text, or a sequence of text"),
        ({"terms": b"colour"}, "give text, or a sequence of text"),
        ({"terms": [1]}, "give text, or a sequence of text"),
        ({"camera": 5}, "camera is 5; give a path or a Camera"),
        ({"renderer": 5}, "renderer is 5; give a name, or an open renderer"),
        ({"poses": b"x"}, "give a path"),
        ({"output": 7}, "output is 7; give a path"),
        ({"model_file": "/nope"}, "there is no option 'model_file'; did you mean 'model'?"),
        ({"progress": 3}, "progress is 3; give a function"),
        ({"stage": 3}, "stage is 3; give a function"),
        ({"rendrer": "cpu"}, "there is no option 'rendrer'; did you mean 'renderer'?"),
        ({"modell": "head"}, "there is no option 'modell'; did you mean 'model'?"),
        ({"terms": "color"}, "there is no term 'color'; did you mean 'colour'?"),
        ({"renderer": "cppu"}, "there is no renderer 'cppu'; did you mean 'cpu'?"),
        ({"preset": "odisio"}, "did you mean 'odisio2004'?"),
    ],
)
def test_what_cannot_be_is_said(video, options, said):
    with pytest.raises(ParameterError) as caught:
        abs_engine.track(str(video), **{"renderer": "cpu", **options})
    assert said in str(caught.value)


@pytest.mark.parametrize("video", [None, 5, b"head.mp4"])
def test_what_is_no_path_of_a_video(video):
    with pytest.raises(ParameterError, match=r"^video is .*; give a path$"):
        abs_engine.track(video, renderer="cpu")


def test_a_video_that_is_not_there():
    with pytest.raises(InputFileError, match=r"nowhere\.mp4 does not exist"):
        abs_engine.track("nowhere.mp4")


def test_paths_may_be_text_wherever_a_video_is_tracked(video, tmp_path):
    told = abs_engine.track_video(str(video), str(tmp_path / "run"), CpuRenderer())
    assert (tmp_path / "run" / told["settings"]["video_path"]).resolve() == video.resolve()
    assert (tmp_path / "run" / "results.csv").is_file()


def test_a_run_states_the_checksum_of_its_physics(video, tmp_path):
    options = TrackOptions(physics=shipped(BUNDLED))
    told = abs_engine.track_video(video, tmp_path / "run", CpuRenderer(), options)["settings"]
    assert told["physics_sha256"] == sha256(shipped(BUNDLED).read_bytes()).hexdigest()


@pytest.mark.parametrize(
    ("chosen", "learned"),
    [({}, False), ({"physics": shipped(BUNDLED)}, True), ({"model": "shell"}, True)],
)
def test_mouths_of_learned_lips_are_compared_with_those_seen(video, chosen, learned):
    setting = abs_engine.prepare(video, CpuRenderer(), TrackOptions(**chosen)).setting
    assert setting.landmarks is not None
    assert setting.learned_lips == learned


def test_how_a_caller_has_numpy_treat_tiny_numbers_is_left_outside(video, run, recwarn):
    with np.errstate(all="raise"):
        found = abs_engine.track(video, renderer="cpu")
        results = abs_engine.prepare(video, CpuRenderer()).results()
        seen = []
        for _, one in results:
            assert np.geterr() == dict.fromkeys(("divide", "over", "under", "invalid"), "raise")
            seen.append(one.aperture)
    np.testing.assert_array_equal(found.aperture, run.aperture)
    np.testing.assert_array_equal(seen, run.aperture)
    with np.errstate(all="warn"):
        abs_engine.track(video, renderer="cpu")
    assert not [one for one in recwarn if issubclass(one.category, RuntimeWarning)]


def test_an_address_in_place_of_a_video():
    with pytest.raises(InputFileError, match=r"http://a\.org/b\.mp4 is an address, not a file"):
        abs_engine.track("http://a.org/b.mp4")


def test_a_run_is_read_by_its_folder_or_its_file(written, tmp_path):
    kept, folder = written
    for path in (folder, folder / "results.npz"):
        np.testing.assert_array_equal(abs_engine.load_run(path)["time"], kept.time)
    for path in (folder, folder / "mesh.npz"):
        read = abs_engine.load_mesh(path)
        with pytest.raises(ParameterError, match=f"no frame {len(read)}; give 0 to"):
            read.vertices(len(read))
        assert repr(read).startswith(f"<RunMesh of {len(OPEN)} frames: {len(read.mean)} vertices, ")
    with pytest.raises(InputFileError, match="nowhere does not exist; give the folder"):
        abs_engine.load_run(tmp_path / "nowhere" / "results.npz")


def test_none_is_the_default(smoothed, run):
    np.testing.assert_array_equal(smoothed.aperture, run.aperture)
    with abs_engine.open_renderer(None) as usual, abs_engine.open_renderer() as auto:
        assert usual.description == auto.description


def test_what_follows_from_an_option_is_not_offered(video):
    with pytest.raises(ParameterError) as caught:
        abs_engine.track(video, zzz=1)
    assert "choose one of" in str(caught.value)
    assert "model_file" not in str(caught.value)


def test_a_smoothed_run_has_its_curves_in_memory_as_on_disk(run, smoothed, written_smoothed):
    written, folder = written_smoothed
    assert not np.allclose(smoothed.smoothed["aperture"], run.aperture)
    np.testing.assert_array_equal(smoothed.aperture, run.aperture)
    with (folder / "smoothed.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["index", "time", *smoothed.smoothed]
    on_disk = [float(row["aperture"]) for row in rows]
    np.testing.assert_allclose(on_disk, smoothed.smoothed["aperture"], atol=1e-3)
    for name, curve in smoothed.smoothed.items():
        np.testing.assert_array_equal(curve, written.smoothed[name])
    assert run.smoothed == {}


@pytest.mark.parametrize(
    ("in_memory", "on_disk"), [("run", "written"), ("smoothed", "written_smoothed")]
)
def test_a_run_in_memory_is_saved_as_it_would_have_been_written(
    request, tmp_path, in_memory, on_disk
):
    run, (_, folder) = map(request.getfixturevalue, (in_memory, on_disk))
    run.save(str(tmp_path / "saved"))
    saved, written = ({p.name: p.read_bytes() for p in path.iterdir()}
                      for path in (tmp_path / "saved", folder))  # fmt: skip
    left_out = {".choices", "contact_sheet.png", "head.png", "overlay.mp4", "timing.json"}
    assert saved == {name: content for name, content in written.items() if name not in left_out}
    assert ("smoothed.csv" in saved) == (in_memory == "smoothed")
    again = abs_engine.Run.load(tmp_path / "saved")
    assert set(again) == set(run)
    for name in run:
        np.testing.assert_array_equal(again[name], run[name])
    np.testing.assert_equal(again.smoothed, run.smoothed)
    again.save(tmp_path / "again")
    for path in (tmp_path / "again").iterdir():  # arrays are in another order
        assert path.name == "results.npz" or path.read_bytes() == saved.pop(path.name)
    assert list(saved) == ["results.npz"]
    with pytest.raises(OutputError, match="saved exists already"):
        run.save(tmp_path / "saved")
    with pytest.raises(ParameterError, match="folder is 5; give a path"):
        run.save(5)


def test_the_call_of_a_whole_run_reads_it(video, written):
    run, folder = written
    kept = {path.name: path.read_bytes() for path in folder.iterdir()}
    again = abs_engine.track(video, folder, renderer="cpu", progress=None)
    np.testing.assert_array_equal(again.aperture, run.aperture)
    assert again.summary == run.summary
    assert again.video == run.video == video.resolve()
    assert kept == {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(OutputError, match="exists"):
        abs_engine.track(video, folder, renderer="cpu", driver="newton-quick")


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("results.csv", "index,time\n0,0.0\n", "results.csv lacks the columns lip48_x"),
        ("run.json", "[]", "run.json states no summary"),
        ("run.json", "{", "run.json states no summary"),
    ],
)
def test_a_run_whose_files_are_damaged_is_not_loaded(written, tmp_path, name, content, said):
    folder = tmp_path / "run"
    shutil.copytree(written[1], folder)
    (folder / name).write_text(content)
    with pytest.raises(AbsEngineError, match=said):
        abs_engine.Run.load(folder)


def test_a_run_of_files_of_two_runs_is_not_loaded(written, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(written[1], folder)
    lines = (folder / "results.csv").read_text().splitlines()
    (folder / "results.csv").write_text("\n".join(lines[:-1]) + "\n")
    with pytest.raises(AbsEngineError, match="are of different runs"):
        abs_engine.Run.load(folder)


def test_a_driver_that_says_a_better_value_than_it_found_is_refused(video):
    class Boasting:
        def minimise(self, objective, start, spec):
            return Solution(start, "stayed", -1e9, {}, 1)

    DRIVERS.add("boasting", Driver(Boasting))
    try:
        with pytest.raises(PluginError, match=r"'Boasting' returns the value -1e\+09"):
            abs_engine.track(video, renderer="cpu", driver="boasting")
    finally:
        DRIVERS._added.pop("boasting")
