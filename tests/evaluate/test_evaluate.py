"""A tracker fed the truth scores 0, and fed noise it scores the noise; by area and coordinates."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from results import FRAMES, areas, clip, perfect, run_arrays, speaker, surface, true_landmarks

from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError, PluginError
from abs_engine.core.registry import METRICS
from abs_engine.evaluate import score_table
from abs_engine.evaluate.catalogue import BUILT_IN, BY_KEY, Metric, catalogue
from abs_engine.evaluate.derived_rows import complete
from abs_engine.evaluate.estimate import Estimate, PointTrack, check_run, of_run
from abs_engine.evaluate.metrics import to_camera
from abs_engine.evaluate.score import error_map, in_picture, measure, summary
from abs_engine.io.head_points import load_points

AREAS = ("face", "lips", "jaw")
NOISE = 0.7  # mm or px, for each coordinate


@pytest.fixture(scope="module")
def truth():
    return clip()


@pytest.fixture(scope="module")
def marks(truth):
    return truth.landmarks["landmark_68"]


def values(estimate, truth, marks=None):
    return {key: s.value for key, s in summary([measure(estimate, truth, marks)]).items()}


def noisy(points, rng):
    return points + rng.normal(size=points.shape) * NOISE


def test_the_truth_scores_nothing(truth, marks):
    scores = values(perfect(truth), truth, marks)
    share = ("failure_share", "precision", "recall", "correlation", "frames", "given")
    errors = {k: v for k, v in scores.items() if not any(word in k for word in share)}
    assert {f"{area}_rms_{space}_mm" for area in AREAS for space in ("head", "camera")} < set(
        errors
    )
    assert max(abs(v) for v in errors.values()) < 1e-5  # degrees, mm, ms
    lengths = [v for k, v in errors.items() if k.endswith("_mm")]
    assert max(abs(v) for v in lengths) < 1e-6
    assert scores["failure_share"] == scores["frames_lost"] == 0
    assert scores["frames"] == FRAMES
    assert scores["protrusion_rms_mm"] == 0
    assert all(scores[k] == 1 for k in scores if "precision" in k or "recall" in k)


def test_the_truth_in_the_picture_scores_nothing(truth, marks):
    pixels, points = true_landmarks(truth)
    said = Estimate(
        "l",
        np.ones(FRAMES, bool),
        {"landmarks": PointTrack(marks, points, "camera")},
        pixels=pixels,
    )
    scores = values(said, truth, marks)
    for key in ("landmarks_rms_px", "landmarks_nme", "lips_rms_px", "landmarks_rms_camera_mm"):
        assert scores[key] == 0
    assert "landmarks_rms_head_mm" not in scores  # nobody said where the head is
    assert scores["failure_share"] == 0


@pytest.mark.parametrize("area", AREAS)
@pytest.mark.parametrize("space", ["head", "camera"])
def test_noise_scores_itself_within_five_per_cent(truth, area, space):
    rng = np.random.default_rng(11)
    vertex = areas()[area]
    found = noisy(truth.points(vertex), rng)
    said = replace(perfect(truth), tracks={area: PointTrack(vertex, found)})
    scores = values(said, truth)
    expected = NOISE * np.sqrt(3)
    assert scores[f"{area}_rms_{space}_mm"] == pytest.approx(expected, rel=0.05)
    assert scores[f"{area}_rms_head_offset_removed_mm"] == pytest.approx(expected, rel=0.05)
    assert scores[f"{area}_jitter_mm"] == pytest.approx(expected, rel=0.05)


def test_noise_given_in_camera_coordinates_scores_itself(truth, marks):
    rng = np.random.default_rng(12)
    pixels, points = true_landmarks(truth)
    track = PointTrack(marks, noisy(points, rng), "camera")
    said = replace(
        perfect(truth), tracks={"landmarks": track}, pixels=noisy(pixels, rng), surface=None
    )
    scores = values(said, truth, marks)
    assert scores["landmarks_rms_camera_mm"] == pytest.approx(NOISE * np.sqrt(3), rel=0.05)
    assert scores["landmarks_rms_head_mm"] == pytest.approx(NOISE * np.sqrt(3), rel=0.05)
    assert scores["landmarks_rms_px"] == pytest.approx(NOISE * np.sqrt(2), rel=0.05)
    assert scores["lips_rms_px"] == pytest.approx(NOISE * np.sqrt(2), rel=0.05)
    # the mean length of a plane Gaussian is sqrt(pi / 2) standard deviations (Rayleigh)
    eyes = np.linalg.norm(pixels[:, 36] - pixels[:, 45], axis=1)
    expected = NOISE * np.sqrt(np.pi / 2) * (1 / eyes).mean()
    assert scores["landmarks_nme"] == pytest.approx(expected, rel=0.05)


def test_lips_alone_that_are_off_in_the_picture(truth, marks):
    pixels = true_landmarks(truth)[0]
    eyes = np.linalg.norm(pixels[:, 36] - pixels[:, 45], axis=1)
    pixels[:, 48:] += np.array([3.0, 4])
    scores = values(Estimate("l", np.ones(FRAMES, bool), pixels=pixels), truth, marks)
    assert scores["lips_nme"] == pytest.approx((5 / eyes).mean())
    assert scores["landmarks_nme"] == pytest.approx((20 / 68) * (5 / eyes).mean())
    assert scores["lips_rms_px"] == pytest.approx(5)


def test_a_head_that_is_put_behind_the_camera_is_nowhere_in_the_picture(truth, marks):
    run = run_arrays(truth)
    run["translation"][7] *= -1
    pixels = complete(of_run("n", run, surface(truth), {}), truth, marks).pixels
    assert np.isnan(pixels[7]).all()
    assert np.isfinite(np.delete(pixels, 7, axis=0)).all()


def test_landmarks_of_a_mesh_are_lost_where_the_system_gave_up(truth, marks):
    said = replace(perfect(truth), found=np.arange(FRAMES) != 7)
    tracks = complete(said, truth, marks).tracks
    for name in ("landmarks", "lip_landmarks"):
        lost = np.isnan(tracks[name].points).all(axis=(1, 2))
        np.testing.assert_array_equal(np.flatnonzero(lost), [7])


def test_noise_of_pose_and_curves_scores_itself(truth):
    rng = np.random.default_rng(13)
    run = run_arrays(truth)
    run["translation"] = noisy(run["translation"], rng)
    run["aperture"], run["width"] = noisy(run["aperture"], rng), run["width"] + 2.0
    scores = values(of_run("n", run, None, {}), truth)
    assert scores["lip_points_rms_head_mm"] == 0
    moved = np.linalg.norm(run["translation"] - truth.translations, axis=1)
    assert scores["head_position_rms_mm"] == pytest.approx(np.sqrt((moved**2).mean()))
    assert scores["lip_points_rms_camera_mm"] == pytest.approx(scores["head_position_rms_mm"])
    assert scores["aperture_rms_mm"] == pytest.approx(NOISE, rel=0.2)  # 60 draws only
    assert scores["width_rms_mm"] == pytest.approx(scores["width_bias_mm"]) == pytest.approx(2)


def test_intervals_of_the_right_size_cover_the_truth_as_often_as_they_say(truth):
    rng = np.random.default_rng(14)
    run = run_arrays(truth)
    run["lip_points"] = noisy(run["lip_points"], rng)
    run["lip_points_sd"] = np.full(run["lip_points"].shape, NOISE)
    run["width_sd"] = np.ones(run["width"].shape)
    scores = values(of_run("n", run, None, {}), truth)
    assert scores["lip_points_coverage_95"] == pytest.approx(0.95, abs=0.01)
    assert scores["width_coverage_95"] == 1
    run["lip_points_sd"] = run["lip_points_sd"] / 2  # 1.96 / 2 standard deviations hold 67.3 %
    scores = values(of_run("n", run, None, {}), truth)
    assert scores["lip_points_coverage_95"] == pytest.approx(0.673, abs=0.015)
    assert "aperture_coverage_95" not in scores


def test_late_and_missed_closures(truth):
    run = run_arrays(truth)
    begun = np.flatnonzero(np.diff(truth.closed.astype(int)) == 1) + 1
    assert len(begun) >= 2
    assert truth.closed[0]
    late = run["closed"].copy()
    late[begun[0]] = False  # the first onset in the clip comes a frame late: 40 ms
    scores = values(of_run("n", run | {"closed": late}, None, {}), truth)
    assert scores["closure_onset_error_ms"] == pytest.approx(40 / len(begun))
    assert scores["closure_onset_bias_ms"] == pytest.approx(40 / len(begun))
    assert scores["closure_recall_events"] == 1
    assert scores["closure_recall_frames"] == pytest.approx(1 - 1 / truth.closed.sum())
    late[: begun[0] + 1] = False  # the closure that begins the clip is missed
    scores = values(of_run("n", run | {"closed": late}, None, {}), truth)
    assert scores["closure_recall_events"] == pytest.approx(len(begun) / (len(begun) + 1))
    assert scores["closure_precision_events"] == 1


def test_lost_frames_and_large_errors_are_failures(truth):
    run = run_arrays(truth)
    for key in ("lip_points", "rotation", "translation", "aperture", "width"):
        run[key][3:6] = np.nan
    run["lip_points"][10] += [0, 6, 0]
    scores = values(of_run("n", run, None, {}), truth)
    assert scores["frames_lost"] == 3
    assert scores["failure_share"] == pytest.approx(4 / FRAMES)
    assert scores["lip_points_rms_head_mm"] == pytest.approx(6 / np.sqrt(FRAMES - 3))


def test_every_system_fails_by_the_same_lip_landmarks(truth, marks):
    """Lips 6 mm too low in frame 10, the rest of the face 50 mm off in all others."""
    moved = truth.points(marks)
    moved[:, :48] += [50.0, 0, 0]
    moved[10, 48:] -= [0, 6, 0]
    camera = to_camera(moved, truth.rotations, truth.translations)
    found, pixels = np.ones(FRAMES, bool), true_landmarks(truth)[0]
    pixels[:, :48] += 300.0
    eyes = np.linalg.norm(pixels[10, 36] - pixels[10, 45])
    pixels[10, 48:] += [0.081 * eyes, 0]
    shares = [
        values(Estimate("x", found, **said), truth, marks)["failure_share"]
        for said in (
            {"tracks": {"landmarks": PointTrack(marks, moved)}},
            {"tracks": {"landmarks": PointTrack(marks, camera, "camera")}},
            {"pixels": pixels},
        )
    ]
    assert shares == pytest.approx([1 / FRAMES] * 3)


def test_closures_of_a_mesh_are_measured_as_the_truth_s(truth, marks):
    assert 5 < truth.closed.sum() < FRAMES - 5
    run = run_arrays(truth) | {"closed": np.ones(FRAMES, bool)}  # its own word does not count
    scores = values(of_run("n", run, surface(truth), {}), truth, marks)
    assert scores["closure_precision_frames"] == scores["closure_recall_frames"] == 1


def test_frames_without_the_face_in_the_picture_do_not_count(truth, marks):
    moved = truth.translations.copy()
    moved[20:30] = [0, 0, 900]
    moved[20:30, 0] = 2000.0  # far to the right of the picture
    away = replace(truth, translations=moved)
    np.testing.assert_array_equal(np.flatnonzero(~in_picture(away, marks)), np.arange(20, 30))
    run = run_arrays(away)
    run["lip_points"][20:25], run["lip_points"][25:30] = np.nan, 99.0
    scores = values(of_run("n", run, None, {}), away, marks)
    assert scores["frames"] == FRAMES - 10
    assert scores["frames_lost"] == scores["failure_share"] == 0
    assert scores["lip_points_rms_head_mm"] == 0


@pytest.mark.parametrize(("edge", "counts"), [(-0.4, True), (-0.6, False)])
def test_a_face_is_in_the_picture_up_to_the_border_of_its_outermost_pixels(
    truth, marks, edge, counts
):
    """Centres of pixels are whole numbers: the picture begins half a pixel before 0."""
    camera, translations = truth.camera, truth.translations.copy()
    points = true_landmarks(truth)[1][0]
    last = points[np.argmax(camera.project(points)[:, 0])]
    focal, centre = camera.matrix[0, 0], camera.matrix[0, 2]
    translations[0, 0] += (edge - centre) * last[2] / focal - last[0]
    moved = replace(truth, translations=translations)
    assert true_landmarks(moved)[0][0, :, 0].max() == pytest.approx(edge, abs=0.05)
    assert in_picture(moved, marks)[0] == counts


def test_error_maps(truth):
    shifted = surface(truth)
    shifted = replace(shifted, mean=shifted.mean + np.array([0, 0, 2.0]))
    run = of_run("n", run_arrays(truth), shifted, {})
    np.testing.assert_allclose(error_map(run, truth), 2.0, atol=1e-5)
    half = replace(run, found=np.arange(FRAMES) % 2 == 0)
    np.testing.assert_allclose(error_map(half, truth), 2.0, atol=1e-5)
    points_only = error_map(of_run("n", run_arrays(truth), None, {}), truth)
    known = np.isfinite(points_only)
    assert set(np.flatnonzero(known)) == set(run_arrays(truth)["lip_vertex"].tolist())
    assert points_only[known].max() == 0


def test_clips_are_pooled_by_frame(truth):
    short = clip(20)
    run, other = run_arrays(truth), run_arrays(short)
    run["width"] += 1.0
    other["width"] += 3.0
    clips = [measure(of_run("n", r, None, {}), t, None) for r, t in ((run, truth), (other, short))]
    pooled = summary(clips)
    assert pooled["width_bias_mm"].value == pytest.approx((60 * 1 + 20 * 3) / 80)
    assert (pooled["width_bias_mm"].low, pooled["width_bias_mm"].high) == pytest.approx((1, 3))
    assert pooled["frames"].value == 80


def test_a_constant_curve_leaves_the_correlation_of_other_clips(truth):
    run, still = run_arrays(truth), run_arrays(truth)
    run["width"] = -run["width"]
    still["width"][:] = 50.0
    clips = [measure(of_run("n", r, None, {}), truth, None) for r in (run, still)]
    assert summary(clips)["width_correlation"].value == pytest.approx(-1)
    assert np.isnan(summary(clips[1:])["width_correlation"].value)


def test_every_mean_has_an_interval_that_holds_it(truth, marks):
    said = perfect(truth)
    rng = np.random.default_rng(15)
    tracks = {k: replace(v, points=noisy(v.points, rng)) for k, v in said.tracks.items()}
    clips = [measure(replace(said, tracks=tracks), truth, marks)]
    scores = summary(clips)
    assert set(scores) <= {metric.key for metric in catalogue()}
    for key in clips[0].means:
        assert scores[key].low <= scores[key].value <= scores[key].high
    assert scores["lips_rms_head_mm"].low < scores["lips_rms_head_mm"].high


def test_the_table_shows_systems_side_by_side(truth):
    scores = summary([measure(perfect(truth), truth, None)])
    few = {"frames": scores["frames"]}
    lines = score_table.lines({"one": scores, "another": few})
    assert "one" in lines[0]
    assert "another" in lines[0]
    row = next(line for line in lines if line.startswith("face, head coordinates, RMS (mm)"))
    assert row.rstrip().endswith("-")
    assert len({len(line) for line in lines}) == 1


def test_the_catalogue_is_complete():
    assert len(BY_KEY) == len(BUILT_IN)
    assert all(metric.definition and metric.label for metric in BUILT_IN)


def test_results_of_something_else_are_refused(truth):
    said = perfect(truth)
    with pytest.raises(ParameterError, match="60 frames, the truth 20"):
        measure(said, clip(20), None)
    wrong = {"lips": PointTrack(np.array([99999]), np.zeros((FRAMES, 1, 3)))}
    with pytest.raises(ParameterError, match="not among the truth's"):
        measure(replace(said, tracks=wrong), truth, None)
    with pytest.raises(ParameterError, match="tracked no frame"):
        measure(replace(said, found=np.zeros(FRAMES, bool)), truth, None)
    with pytest.raises(InputFileError, match="lacks width"):
        check_run({k: v for k, v in run_arrays(truth).items() if k != "width"}, FRAMES, 9)


def test_the_published_lists():
    points, head = speaker().points, speaker()
    assert {k: len(v) for k, v in points.items()} == {
        "landmark_68": 68, "face": 817, "lips": 309, "jaw": 110,
    }  # fmt: skip
    marks = points["landmark_68"]
    assert len(set(head.weld[marks].tolist())) == 68
    np.testing.assert_array_equal(marks[48:60], head.landmarks["outer_lip_20"])
    np.testing.assert_array_equal(marks[60:68], head.landmarks["inner_lip_8"])
    at = head.vertices[marks]
    # iBUG's mirror pairs: right and left lie opposite each other
    pairs = [(k, 16 - k) for k in range(8)] + [(17 + k, 26 - k) for k in range(5)]
    pairs += [(31, 35), (32, 34), (36, 45), (37, 44), (38, 43), (39, 42), (40, 47), (41, 46)]
    for right, left in pairs:
        np.testing.assert_allclose(at[right] * [-1, 1, 1], at[left], atol=1e-3)
        assert at[right, 0] < 0
    assert (np.diff(at[:9, 1]) < 0).all()  # the jaw line goes down to the chin
    assert (np.diff(at[27:31, 1]) < 0).all()
    assert at[30, 2] == head.vertices[head.landmarks["nose_tip"][0], 2]


def test_the_areas_lie_where_they_say():
    head, points = speaker(), speaker().points
    lip_facets = np.isin(head.facet_class, [head.class_id("upper_lip"), head.class_id("lower_lip")])
    assert set(points["lips"].tolist()) <= set(np.unique(head.faces[lip_facets]).tolist())
    skin = set(np.unique(head.faces[head.facet_class == head.class_id("skin")]).tolist())
    assert set(points["jaw"].tolist()) <= skin
    for name, spacing in (("face", 4.0), ("lips", 1.5), ("jaw", 3.0)):
        at = head.vertices[points[name]]
        away = np.linalg.norm(at[:, None] - at[None], axis=2) + np.eye(len(at)) * 99
        assert away.min() >= spacing * 0.999
        mirrored = np.linalg.norm(at[:, None] * [-1, 1, 1] - at[None], axis=2).min(axis=1)
        assert mirrored.max() < 1e-3
    moved = np.linalg.norm(head.unit_matrix(("jawOpen",))[0], axis=1)
    assert moved[points["jaw"]].min() > 0.5 * 0.9 * moved[points["jaw"]].max()


def test_lists_of_another_mesh_are_refused(tmp_path):
    path = tmp_path / "points.json"
    assert load_points(path, 5, 2) == {}
    path.write_text("[]")
    with pytest.raises(InputFileError, match="not a list of points"):
        load_points(path, 5, 2)
    told = {"format": "abs_engine.points", "version": 1, "vertices": 5, "faces": 2}
    path.write_text(json.dumps(told | {"lists": {"a": {"vertices": [0, 4]}}}))
    np.testing.assert_array_equal(load_points(path, 5, 2)["a"], [0, 4])
    with pytest.raises(ModelFormatError, match="another mesh"):
        load_points(path, 6, 2)
    path.write_text(json.dumps(told | {"lists": {"a": {"vertices": [0, 5]}}}))
    with pytest.raises(ModelFormatError, match="from 0 to 5, not 0 to 4"):
        load_points(path, 5, 2)


@pytest.fixture
def own_metric():
    """Adds a metric of one's own, and takes it out again."""

    def add(measured, key="own_mm"):
        METRICS.add("own_mm", Metric(key, "own", "mm", "as the test says", measured, root=True))

    yield add
    METRICS._added.pop("own_mm")


def test_a_metric_of_one_s_own_has_a_row(truth, own_metric):
    own_metric(lambda said, true: np.where(np.arange(len(true)) < 2, [4.0], np.nan))
    scores = {"a": summary([measure(perfect(truth), truth, None)])}
    assert scores["a"]["own_mm"].value == 2
    assert score_table.lines(scores)[-1].split()[:3] == ["own", "(mm)", "2"]
    assert json.loads(score_table.as_json(scores, {}))["metrics"]["own_mm"]["label"] == "own"


def test_a_metric_of_one_s_own_that_measures_nothing_has_no_row(truth, own_metric):
    own_metric(lambda said, true: np.full(len(true), np.nan))
    assert "own_mm" not in values(perfect(truth), truth)


@pytest.mark.parametrize(
    ("measured", "problem"),
    [
        (lambda said, true: 1 / 0, "ZeroDivisionError"),
        (lambda said, true: [1.0], r"shape \(1,\)"),
        (lambda said, true: np.r_[np.inf, np.ones(len(true) - 1)], "returns infinite values"),
        (lambda said, true: np.full(len(true), -4.0), "takes the root of a mean below 0"),
    ],
)
def test_a_metric_that_fails_is_named(truth, own_metric, measured, problem):
    own_metric(measured)
    with pytest.raises(PluginError, match=f"'own_mm'.*{problem}"):
        measure(perfect(truth), truth, None)


@pytest.mark.parametrize("key", ["aperture_rms_mm", "frames", "other_mm"])
def test_a_metric_replaces_no_other(truth, own_metric, key):
    own_metric(lambda said, true: np.full(len(true), 77.0), key)
    with pytest.raises(PluginError, match=f"'{key}'"):
        measure(perfect(truth), truth, None)
