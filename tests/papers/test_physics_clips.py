"""Clips of the reproduction: closures of real ones counted by hand, the scenes of filmed ones."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import TooFewPixelsError
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.head import COLOUR_CLASSES
from abs_engine.io.assets import load_speaker
from abs_engine.papers.basu1998 import real_clips
from abs_engine.papers.basu1998.filmed import (
    FRONT,
    FULL,
    QUICK,
    RATES,
    SAID,
    SAID_FOR_COLOURS,
    YAWS,
    camera_name,
    learn_colours,
    scene_of,
)
from abs_engine.papers.basu1998.motion import SENTENCES
from abs_engine.papers.basu1998.real_clips import (
    SPIKE_MM,
    Agreement,
    ClosureLabels,
    agreement,
    closure_labels,
    grid_agreement,
)
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.scenefile import parse_scene

# ---- closures ------------------------------------------------------------------------------------


def frames(*closed: int, count: int = 12) -> np.ndarray:
    out = np.zeros(count, bool)
    out[list(closed)] = True
    return out


LABELS = ClosureLabels(
    closed=frames(0, 1, 4, 5, 6, 9), sure=~frames(1, 8), runs=[[0, 1], [4, 6], [9, 9]]
)


def test_agreement_by_hand():
    """Of the sure frames 0 4 5 6 9 are closed; the run has 0 5 6 7, and 1 8 that nobody knows."""
    aperture = np.array([0, 0, 2, 7, 2, 0, 0, 1, 1, 5, 9.5, 5.1])
    found = agreement(LABELS, {"closed": frames(0, 1, 5, 6, 7, 8), "aperture": aperture})
    # frame 3 stands out by 5 mm, frame 10 by 4.4
    assert SPIKE_MM == 4
    assert found == Agreement(hits=3, found=4, labelled=5, met=2, closures=3, spikes=2)
    assert found.precision == 3 / 4
    assert found.recall == 3 / 5


def test_agreements_add_up_by_frames_and_not_by_clips():
    both = Agreement(3, 4, 5, 2, 3, 2) + Agreement(1, 8, 1, 1, 1, 0)
    assert both == Agreement(4, 12, 6, 3, 4, 2)
    assert both.precision == pytest.approx(1 / 3)
    assert both.recall == pytest.approx(2 / 3)


def test_a_run_without_closures_is_no_division_by_zero():
    found = agreement(LABELS, {"closed": frames(), "aperture": np.full(12, np.nan)})
    assert found == Agreement(0, 0, 5, 0, 3, 0)
    assert (found.precision, found.recall) == (0, 0)


def test_a_closure_is_met_by_any_of_its_frames():
    for frame, met in ((4, 1), (6, 1), (3, 0), (7, 0)):
        run = {"closed": frames(frame), "aperture": np.zeros(12)}
        assert agreement(LABELS, run).met == met


def test_the_labels_that_are_shipped_are_sound():
    labels = closure_labels()
    assert len(labels) >= 1
    for name, clip in labels.items():
        assert clip.closed.shape == clip.sure.shape, name
        assert clip.closed.sum() == sum(last - first + 1 for first, last in clip.runs)
        assert all(0 <= a <= b < len(clip.closed) for a, b in clip.runs)
        ends = [b for _, b in clip.runs[:-1]]
        assert all(b + 1 < a for b, (a, _) in zip(ends, clip.runs[1:], strict=True))
        assert clip.sure.mean() > 0.8


def test_without_the_clips_there_is_no_agreement(tmp_path, monkeypatch):
    told = []
    monkeypatch.setenv("ABS_ENGINE_DATA", str(tmp_path))
    assert grid_agreement(CpuRenderer(), told.append, tmp_path / "kept") is None
    (tmp_path / real_clips.FOLDER).mkdir()
    assert grid_agreement(CpuRenderer(), told.append, tmp_path / "kept") is None
    assert not told


def test_clips_that_are_there_are_tracked_and_summed(tmp_path, monkeypatch):
    names = [*closure_labels(), "another"][:2]
    folder = tmp_path / real_clips.FOLDER
    folder.mkdir()
    for name in names:
        (folder / f"{name}.mpg").touch()
    labels = dict.fromkeys(names, LABELS)
    monkeypatch.setenv("ABS_ENGINE_DATA", str(tmp_path))
    monkeypatch.setattr(real_clips, "closure_labels", lambda: {**labels, "not here": LABELS})
    tracked = []
    monkeypatch.setattr(real_clips, "track_video", lambda video, *_: tracked.append(video.name))
    run = {"closed": frames(0, 5, 7), "aperture": np.zeros(12)}
    monkeypatch.setattr(real_clips, "load_run", lambda _out: run)
    told = []
    found = grid_agreement(CpuRenderer(), told.append, tmp_path / "kept")
    assert tracked == [f"{name}.mpg" for name in names]
    assert told == [f"tracking {name}" for name in names]
    assert found["clips"] == names
    assert found["closure_precision"] == 2 / 3
    assert found["closure_recall"] == 2 / 5
    assert (found["closures_met"], found["closures"], found["spikes"]) == (4, 6, 0)


# ---- filmed heads --------------------------------------------------------------------------------


@pytest.mark.parametrize("amount", [QUICK, FULL])
def test_heads_that_keep_still_are_seen_from_every_side(amount):
    scene = parse_scene(scene_of(amount, 7, "still"))
    assert (scene.seed, scene.rate, scene.size, scene.labels) == (7, RATES["still"], (640, 480), ())
    assert [c.name for c in scene.clip] == [
        f"{person}-{kind}" for person in amount.people for kind in ("colours", "test")
    ]
    for clip in scene.clip:
        person, kind = clip.name.rsplit("-", 1)
        assert clip.speaker == person
        said, count, yaws = {
            "colours": (SAID_FOR_COLOURS, amount.colours, (-45, 0, 45)),
            "test": (SAID, amount.test, YAWS),
        }[kind]
        assert (clip.say, clip.frames) == (said, count)
        assert clip.cameras == tuple(camera_name(yaw) for yaw in yaws)
        assert clip.motion.amount < 1
        assert not clip.motion.keys


@pytest.mark.parametrize("amount", [QUICK, FULL])
def test_heads_that_move_turn_to_both_sides_before_one_camera(amount):
    scene = parse_scene(scene_of(amount, 0, "moving"))
    assert scene.rate == 25
    assert [c.name for c in scene.clip] == [f"{person}-moving" for person in amount.people]
    for clip in scene.clip:
        assert clip.cameras == (FRONT,)
        assert clip.frames == amount.moving
        yaws = [key.turn_degrees[1] for key in clip.motion.keys]
        assert min(yaws) <= -30
        assert max(yaws) >= 30


def test_cameras_stand_where_their_names_say():
    scene = parse_scene(scene_of(QUICK, 0, "still"))
    assert [c.name for c in scene.camera] == ["yaw_45", "yaw_22", "yaw0", "yaw22", "yaw45"]
    for camera, yaw in zip(scene.camera, YAWS, strict=True):
        x, _, z = np.subtract(camera.position, camera.target)
        assert np.degrees(np.arctan2(x, z)) == pytest.approx(yaw, abs=0.1)
        assert np.hypot(x, z) == pytest.approx(560, abs=0.2)
    assert len(scene.light) == 2


def test_people_and_classes_are_those_of_the_head():
    speaker = load_speaker()
    assert set(FULL.people) <= set(speaker.people)
    assert set(QUICK.people) <= set(FULL.people)
    assert tuple(COLOUR_CLASSES) == CLASSES
    assert {name for names in COLOUR_CLASSES.values() for name in names} <= set(speaker.class_names)


def test_what_is_tested_was_not_learned_from():
    assert SAID != SAID_FOR_COLOURS
    for sentence in SENTENCES:
        assert sentence not in SAID
        assert SAID not in sentence


COLOURS = {"skin": (196, 148, 122), "lips": (168, 88, 88), "teeth": (176, 160, 140),
           "dark": (38, 16, 16)}  # fmt: skip
NAMES = ("background", "skin", "upper_lip", "lower_lip", "upper_teeth", "inner_mouth")
FAR = (60, 190, 90)
"""Colour of skin that is far from the lips."""


class View:
    """A view of a mouth whose classes and colours are known; the wall is nobody's colour."""

    class_names = NAMES

    def __init__(self, lips: bool = True) -> None:
        ids = np.zeros((120, 160), np.int64)
        ids[:, 20:140] = 1
        if lips:
            ids[40:52, 50:110], ids[66:78, 50:110] = 2, 3
            ids[52:58, 50:110], ids[58:66, 50:110] = 4, 5
        self.ids = ids
        of_class = [(0, 0, 255)] + [COLOURS[c] for c in ("skin", "lips", "lips", "teeth", "dark")]
        picture = np.array(of_class, float)[ids]
        picture[:6, 20:140] = FAR
        self.picture = picture
        self.asked: list[int] = []

    def pictures(self):
        rng = np.random.default_rng(0)
        for _ in range(6):
            yield np.uint8(np.clip(self.picture + rng.normal(0, 3, self.picture.shape), 0, 255))

    def class_ids(self, frame: int) -> np.ndarray:
        self.asked.append(frame)
        return self.ids


def test_colours_are_learned_near_the_lips_of_every_fourth_frame():
    view = View()
    learned = learn_colours([view, View(lips=False)])
    assert view.asked == [0, 4]
    squares = np.stack([np.full((2, 2, 3), COLOURS[c], np.uint8) for c in CLASSES])
    for k, square in enumerate(squares):
        assert (learned.probabilities(square).argmax(axis=0) == k).all(), CLASSES[k]
    far = learned.probabilities(np.full((2, 2, 3), FAR, np.uint8))
    assert far.sum(axis=0).max() < 0.05  # the reach was too short for it
    wall = learned.probabilities(np.full((2, 2, 3), (0, 0, 255), np.uint8))
    assert wall.sum(axis=0).max() < 0.05


def test_lips_in_shade_beside_the_opening_are_lips_but_what_meets_skin_is_left_out():
    view, shaded = View(), (70, 34, 34)
    view.picture[50:52, 50:110] = shaded  # of the upper lip, above the teeth
    view.picture[40:41, 50:110] = FAR  # of the upper lip, below the skin
    learned = learn_colours([view])
    shown = learned.probabilities(np.full((2, 2, 3), shaded, np.uint8))
    assert shown[CLASSES.index("lips")].min() > 0.6
    assert learned.probabilities(np.full((2, 2, 3), FAR, np.uint8)).sum(axis=0).max() < 0.05


def test_views_without_lips_teach_no_colours():
    with pytest.raises(TooFewPixelsError):
        learn_colours([View(lips=False)])
