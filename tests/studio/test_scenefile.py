"""Scene files: what they may say, and what is answered to those that say something else."""

from __future__ import annotations

import json
import re
from argparse import Namespace
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest

from abs_engine.cli import main
from abs_engine.cli.commands.synth import request_of
from abs_engine.core.errors import AbsEngineError, InputFileError, ModelFormatError, ParameterError
from abs_engine.dataset.codec import BOARD, CLOSED_BELOW, HAND, OTHER
from abs_engine.io.assets import load_speaker
from abs_engine.studio import filming
from abs_engine.studio.appearance.look import Light, LightKey
from abs_engine.studio.appearance.optics import Sensor
from abs_engine.studio.cameras import check_view, glass, lens, stand
from abs_engine.studio.cast import Cast, person_of
from abs_engine.studio.finish import clip_entry
from abs_engine.studio.motion import head_poses, keyed, ramp
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.resolve import lights_at, plan_clip
from abs_engine.studio.scenefile import (
    CameraEntry,
    ClipEntry,
    EventEntry,
    HeadKey,
    MirrorEntry,
    MotionEntry,
    OccluderEntry,
    SceneFile,
    SpeakerEntry,
    complete,
    parse_scene,
    read_scene,
    scene_text,
    sentence_scene,
)
from abs_engine.studio.sequence import deform

NOTHING = {"person": None, "size": None, "frames": None, "seed": None, "lossless": False}
HEAD = 'format = "abs_engine.scene"\nversion = 1\n'
SCENES = sorted((Path(__file__).parents[2] / "assets" / "scenes").glob("*.toml"))


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


def plan(speaker, text, **changes):
    scene = complete(replace(parse_scene(HEAD + text), **changes))
    return plan_clip(scene, 0, speaker, Cast(speaker, scene.speaker), Path(), "")


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.name)
def test_shipped_scenes_are_read_and_written_and_read_again(path):
    scene = complete(read_scene(path))
    assert parse_scene(scene_text(scene)) == scene
    assert complete(scene) == scene


def test_a_shipped_scene_has_two_cameras_three_lights_and_an_occluder(speaker):
    scene = complete(read_scene(next(p for p in SCENES if p.name == "speech.toml")))
    assert (len(scene.camera), len(scene.light), len(scene.occluder)) == (2, 3, 1)
    assert scene.clip[0].frames == 10 * scene.rate


def test_a_scene_of_three_lines_films_somebody(speaker):
    made = plan(speaker, "[[clip]]\nframes = 5\n")
    assert (len(made), made.person, made.name, made.sentence) == (5, "clara", "clip-1", "demo")
    assert made.views[0].camera.size == (320, 240)
    assert made.lights.shape == (5, 2, 7)


def test_a_board_is_held_where_its_keys_say(speaker):
    made = plan(
        speaker,
        """shirt = false
[[occluder]]
kind = "board"
start = -0.4
end = 2.0
sway = 0
board = { kind = "chessboard", columns = 6, rows = 5, square = 20 }
keys = [
    { time = 0.0, offset = [0, 0, 90] },
    { time = 0.4, offset = [20, 0, 90], turn_degrees = [0, 30, 0] },
]
[[clip]]
frames = 16
motion = { amount = 0.0 }
""",
    )
    (board,) = made.props
    assert board.code == BOARD
    assert board.present.all()
    assert np.ptp(board.vertices, axis=0) == pytest.approx([140, 120, 2])
    assert board.translations[10] - board.translations[0] == pytest.approx([20, 0, 0])
    turned = np.degrees(board.rotations[[0, 10, 15]])
    assert turned == pytest.approx(np.array([[0, 0, 0], [0, 30, 0], [0, 30, 0]]))
    assert made.occluders


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("kind = 'board'\nkeys = [{ time = 1.9 }, { time = 1, turn_degrees = [0, 0, 0] }]", None),
        ("kind = 'board'\nkeys = [{ time = 2.5, turn_degrees = [0, 0, 0] }]", "'board': the board"),
        ("kind = 'hand'\nboard = { kind = 'charuco', columns = 7, rows = 5, square = 18 }",
         "'hand': the hand is not a board"),
    ],
)  # fmt: skip
def test_what_an_occluder_may_not_say(speaker, keys, words):
    text = f"[[occluder]]\nstart = 0\nend = 2\n{keys}\n[[clip]]\nframes = 2\n"
    if words is None:  # a key without anything to say does nothing
        assert plan(speaker, text).occluders
        return
    with pytest.raises(ParameterError, match=words):
        plan(speaker, text)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"labels": "normals"}, "the film, labels is 'normals'; give a list in [ ]"),
        ({"labels": ("normal",)}, "labels 1 is 'normal' (nearest: 'normals'); give one of"),
        ({"size": (64.0, 48)}, "the film, size 1 is 64.0; give a whole number"),
        ({"size": (64, 48, 3)}, "the film, size has 3 entries; give 2"),
        ({"frames": 2.0}, "the film, clip 'clip', frames is 2.0; give a whole number"),
        ({"seed": "1"}, "the film, seed is '1'; give a whole number"),
        ({"person": 3}, "the film, clip 'clip', speaker is 3; give text in quotes"),
    ],
)
def test_a_sentence_is_checked_as_a_file_is(given, said):
    with pytest.raises(ParameterError) as caught:
        sentence_scene("demo", **given)
    assert said in str(caught.value)


def test_the_scene_of_a_sentence_takes_numpy_s_numbers():
    plain = {"size": (64, 48), "frames": 2, "seed": 5, "lossless": True, "labels": ("flow",)}
    scene = sentence_scene("demo", **plain)
    ours = {"size": np.array([64, 48]), "frames": np.int64(2), "seed": np.uint8(5)}
    assert repr(sentence_scene("demo", **(plain | ours | {"labels": ["flow"]}))) == repr(scene)
    assert parse_scene(scene_text(scene)) == scene


def test_text_in_quotes_and_odd_characters_comes_back():
    scene = sentence_scene('_ "a" \\ é \x7f \t_', seed=4, frames=9, lossless=True)
    assert parse_scene(scene_text(scene)) == scene


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sed = 1", "no key 'sed' (nearest: 'seed')"),
        ("framerate = 25", "no key 'framerate' (nearest: 'rate')"),
        ("frame_rate = 25", "no key 'frame_rate' (nearest: 'rate')"),
        ("fps = 25", "no key 'fps' (nearest: 'rate')"),
        ("resolution = [64, 48]", "no key 'resolution' (nearest: 'size')"),
        ("cameras = 1", "no key 'cameras' (nearest: 'camera')"),
        ('[[clip]]\nperson = "mei"', "no key 'person' (nearest: 'speaker')"),
        ('[[clip]]\ntext = "m a"', "no key 'text' (nearest: 'say')"),
        ("[[clip]]\nduration = 3", "no key 'duration' (nearest: 'frames')"),
        ("[[camera]]\nfov = 40", "no key 'fov' (nearest: 'field_of_view_degrees')"),
        ("[[camera]]\nfocal_length = 400", "no key 'focal_length' (nearest: 'focal')"),
        ("[[camera]]\nroll = 3", "no key 'roll' (nearest: 'roll_degrees')"),
        ("[[camera]]\nlook_at = [0, 0, 0]", "no key 'look_at' (nearest: 'target')"),
        ("[[camera]]\nxyzzy = 3", "no key 'xyzzy'; keys:"),
        ("[[camera]]\nfocl = 3.0", "camera 1 has no key 'focl' (nearest: 'focal')"),
        ('[[camera]]\nname="side"\nsensor={blurr=1}', "camera 'side', sensor has no key 'blurr'"),
        ('labels = ["normals", "albdo"]', "labels 2 is 'albdo' (nearest: 'albedo')"),
        ("[[speaker]]\nbase='mei'", "speaker 1 lacks the key 'name'"),
        ("rate = 'fast'", "rate is 'fast'; give a number"),
        ("seed = 1.5", "seed is 1.5; give a whole number"),
        ("size = [320]", "size has 1 entries; give 2"),
        ("size = 320", "size is 320; give a list"),
        ("size = { x = 320 }", "give a list in"),
        ("[clip]\nframes = 1", "clip is {'frames': 1}; write its name in [[ ]]"),
        ("background = 3", "background is not a table"),
        ("seed = true", "seed is True"),
        ("rate = nan", "rate is nan"),
        (
            "[[occluder]]\nkind = 'board'\nstart = 0\nend = 1\nboard = { kind = 'charuco' }",
            "occluder 1, board lacks the key 'columns'",
        ),
        (
            "[[occluder]]\nkind='board'\nstart=0\nend=1\n"
            "board={kind='charuco',columns=3,rows=5,square=9}",
            "occluder 1, board: a board of 3 x 5 squares of 9 mm cannot be",
        ),
        ("[[camera]]\nsensor = { read = -1 }", "sensor: blur, noise and bands cannot be negative"),
    ],
)
def test_what_a_scene_may_not_say(text, words):
    with pytest.raises(ParameterError) as caught:
        parse_scene(HEAD + text)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("size = [321, 240]", "even sizes"),
        ("size = [8, 8]", "16 to 8192"),
        ("[[camera]]\nsize = [10000, 64]", "16 to 8192"),
        ("rate = 0", "rate of 0 frames per second; give a rate above 0, of 1000 at most"),
        ("rate = 1001", "rate of 1001 frames per second; give a rate above 0, of 1000 at most"),
        ("seed = -1", "seed is -1"),
        ("shirt = true", "no colour"),
        ("[[camera]]\n[[camera]]", "2 [[camera]] named 'camera'"),
        ('[[clip]]\nname = "../up"', "[[clip]] has the name '../up'"),
        ('[[camera]]\nname = "truth.npz"', "'truth.npz', which a file of the dataset has"),
        ('[[camera]]\nname = "Vertices"', "'Vertices', which a file of the dataset has"),
        ('[[clip]]\nname = "README.md"', "'README.md', which a file of the dataset has"),
        ('[[clip]]\nname = "SHA256SUMS"', "'SHA256SUMS', which a file of the dataset has"),
        ('[[clip]]\nspeaker = "klara"', "no person 'klara' (nearest: 'clara')"),
        ('[[clip]]\ncameras = ["cam"]', "camera 'cam', which does not exist (nearest: 'camera')"),
        ('[[clip]]\nlights = ["kee"]', "light 'kee', which does not exist (nearest: 'key')"),
        ('[[clip]]\noccluders = ["hand"]', "known: none"),
        ("[[clip]]\ncameras = []", "has no camera"),
        ('[[clip]]\nsay = "_ q^w"', "clip 'clip-1'"),
        ('[[clip]]\nsentence = "a zz"', "clip 'clip-1': there is no viseme 'zz'"),
        ('[[clip]]\nsentence = "demo"\nsay = "a"', "has sentence and say; give one"),
        ("[[clip]]\nrepeat = 0", "no frames"),
        ("[[clip]]\nrepeat = 1000000000000", "too many; give 1000000 at most"),
        ("[[clip]]\nframes = 1000000000000", "too many; give 1000000 at most"),
        ('[[clip]]\ntextgrid = "none.TextGrid"', "none.TextGrid"),
        ('[[clip]]\narkit = "none.csv"', "none.csv"),
        ("[[clip]]\nmotion = { keys = [{ time = 2 }, { time = 1 }] }", "not in order of time"),
        ('[[event]]\nkind = "blur"\nstart = 2\nend = 1', "from 2 to 1 s"),
        ('[[event]]\nkind = "leave"\nstart = 0\nend = 1\ndirection = [0,0,0]', "give an amount"),
        ('[[event]]\nkind = "blur"\nstart = -1\nend = 1', "let it start at 0 or later"),
        ('[[event]]\nkind = "blur"\nstart = 0\nend = 1\ncameras = ["b"]', "camera 'b'"),
        ('[[light]]\nname = "a"\ndirection = [0, 0, 0]', "no direction"),
        (
            '[[light]]\nname="a"\ndirection=[0,0,-1]\nkeys=[{time=1},{time=1}]',
            "keys of light 'a' are not in order",
        ),
        ('[[occluder]]\nkind = "hand"\nstart = 1\nend = 1.2', "occluder 'hand'"),
        ("[[camera]]\nposition = [0, 0, 40]", "camera 'camera' is inside the head"),
        ('[[camera]]\nmount = "head"\nposition = [0, 20, 118]', "is inside the head, or touches"),
        ("[[camera]]\nposition = [0, -200, 60]", "camera 'camera' is inside the shirt"),
        ("[[camera]]\nposition = [0, 0, 4000]", "farther than depth labels go"),
        ("[[camera]]\nposition = [0, 0, 900]\ntarget = [0, 0, 900]", "looks at the place"),
        ("[[camera]]\nfocal = 300\nfocal_mm = 50", "focal length twice"),
        ("[[camera]]\nfield_of_view_degrees = 170", "sees 170 degrees"),
        ("[[camera]]\nfocal = -3", "the focal length of camera 'camera' is -3 px"),
        ("[[camera]]\ndistortion = [-3.0]", "folds the picture over itself"),
        (
            "size = [640, 480]\n[[camera]]\nfield_of_view_degrees = 70\ndistortion = [-0.2]",
            "leaves its corners without rays",
        ),
        (
            "size = [640, 480]\n[[camera]]\nfield_of_view_degrees = 110\n"
            "distortion = [-0.25, 0.06, 0, 0, -0.005]",
            "leaves its corners without rays",
        ),
        ("[[camera]]\ndistortion = [0,0,0,0,0,0,0,0,0]", "9 distortion coefficients"),
        ("[[camera]]\ncrf = 80", "the crf of camera 'camera' is 80; give 0 to 51"),
        ("[[camera]]\nmirror = {}", "both corners and a centre, or neither"),
        ("[[camera]]\nmirror = { centre = [0, 0, 400], yaw_degrees = 20 }", "behind the mirror"),
        ("[[camera]]\nmirror = { centre = [0, 0, -400] }", "camera 'camera': a corner"),
        ("ambient = -1.0", "ambient is -1; give 0 or more"),
        ("roughness = 5.0", "roughness is 5; give 0 to 1"),
        ("shirt = [2.0, 0, 0]", "the colour of the shirt is 2, 0, 0; give 0 to 1"),
        ("[background]\ntop = [300, -5, 0]", "a colour of the background is not 0 to 255"),
        ("[background]\nbottom = [0, 0, -1]", "a colour of the background is not 0 to 255"),
        ("[background]\nclutter = -2", "its clutter is negative"),
        ("[[camera]]\nexposure = -1.0", "the exposure of camera 'camera' is -1"),
        (
            '[[light]]\nname = "a"\ndirection = [0, 0, -1]\ncolour = [0, -1, 0]',
            "negative intensity",
        ),
        (
            '[[light]]\nname="a"\ndirection=[0,0,-1]\nkeys=[{time=1,intensity=-1}]',
            "light 'a' has a negative intensity or colour",
        ),
        ("[[clip]]\nmotion = { seed = -3 }", "the motion's seed of clip 'clip-1' is -3"),
        (
            "[[clip]]\nmotion = { amount = -0.5 }",
            "the motion's amount of clip 'clip-1' is -0.5; give 0 or more",
        ),
        ('[[speaker]]\nname = "x"\nseed = -1', "the seed of speaker 'x' is -1"),
        ('[[occluder]]\nkind = "hand"\nstart = 1\nend = 2\nseed = -1', "seed of occluder 'hand'"),
        (
            '[[occluder]]\nkind = "hand"\nstart = 1\nend = 2\ncolour = [300, 0, 0]',
            "the colour of occluder 'hand' is 300, 0, 0; give 0 to 255",
        ),
        (
            '[[occluder]]\nkind = "board"\nstart = 1\nend = 2\n'
            'board = { kind = "charuco", columns = 20, rows = 20, square = 5.0 }',
            "a board of 20 x 20 squares has 200 markers, 4X4_50 has only 50",
        ),
        ('[[speaker]]\nname = "x"\nskin = "pink"\n[[clip]]\nspeaker = "x"', "skin tone 'pink'"),
        ('[[speaker]]\nname = "x"\nrandom = -1\n[[clip]]\nspeaker = "x"', "negative seed"),
    ],
)
def test_what_cannot_be_filmed_is_one_line(speaker, text, words):
    with pytest.raises(AbsEngineError) as caught:
        plan(speaker, text if "[[clip]]" in text else f"{text}\n[[clip]]\nframes = 3\n")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_people_are_asked_for_before_anything_is_worked_out(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(filming, "plan_clip", lambda *_: pytest.fail("a clip was worked out"))
    for text, words in (
        ('[[clip]]\n[[clip]]\nspeaker = "klara"', "clip 'clip-2': there is no person 'klara' "),
        ("[[clip]]\n[[speaker]]\nname = 'a'\nbase = 'b'", "a: there is no person 'b' to start"),
        ("[[clip]]\n[[speaker]]\nname = 'a'\nidentity = { chin = 1.0 }", "no shape target 'chin'"),
        (
            "[[clip]]\n[[speaker]]\nname = 'a'\nidentity = { head_oval = 500.0 }",
            "the weight of 'head_oval' is 500.0; give a number from -3 to 3",
        ),
        ("[[clip]]\n[[speaker]]\nname = 'a'\nskin = 'blue'", "no skin tone 'blue'"),
    ):
        scene = tmp_path / "scene.toml"
        scene.write_text(HEAD + text)
        assert main(["synth", str(scene), "-o", str(tmp_path / "out")]) == 2
        assert words in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["scene.toml"]


@pytest.mark.parametrize(
    ("say", "told"),
    [
        ("_ hello _ world", ["'hello' as h e l l o", "'world' as w o r l d"]),
        ("the cat sat", ["'the' as t h e", "'cat' as c a t"]),
        ("Bob met a few wolves", ["'few' as f e w", " and 1 more"]),
        ("h @ l @U _ m A: m A: _", []),
        ('"b{d pul f(0.2)', []),
        ("m a p a", []),
    ],
)
def test_words_in_ordinary_spelling_are_not_read_in_silence(speaker, caplog, say, told):
    plan(speaker, f"[[clip]]\nsay = '{say}'")
    said = "\n".join(record.getMessage() for record in caplog.records)
    assert bool(said) == bool(told)
    assert all(words in said for words in told), said
    assert len(caplog.records) <= 1
    assert not told or "clip 'clip-1' reads" in said


def test_the_command_line_says_it_in_one_line_with_status_2(tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    scene.write_text(HEAD + "[[camera]]\nfocl = 3\n")
    assert main(["synth", str(scene), "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.strip() == (
        f"abs-engine: error: {scene}, camera 1 has no key 'focl' (nearest: 'focal'); keys: name, "
        "size, focal, focal_mm, sensor_width_mm, field_of_view_degrees, centre, distortion, mount, "
        "position, target, roll_degrees, sensor, exposure, crf, mirror"
    )
    assert main(["synth", str(scene), "-o", str(tmp_path / "out"), "--seed", "2"]) == 2
    assert "--seed does not go with a scene file" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["scene.toml"]


@pytest.mark.parametrize(
    ("text", "lacking"),
    [
        ("version = 1", "format"),
        ('format = "abs_engine.scene"', "version"),
        ("seed = 1", "format or version"),
    ],
)
def test_a_scene_without_its_first_lines_names_those_that_it_lacks(text, lacking):
    with pytest.raises(ModelFormatError, match=f"has no line {lacking}; begin it with format = "):
        parse_scene(text)


def test_files_that_are_no_scenes(tmp_path):
    for content, error in (
        (b"seed = = 1", InputFileError),
        (b"\xff\xfe", InputFileError),
        (b"seed = 1", ModelFormatError),
        (b'format = "abs_engine.scene"\nversion = 9', ModelFormatError),
    ):
        (tmp_path / "scene.toml").write_bytes(content)
        with pytest.raises(error) as caught:
            read_scene(tmp_path / "scene.toml")
        assert "\n" not in str(caught.value)
    with pytest.raises(InputFileError, match="does not exist; check the path"):
        read_scene(tmp_path / "none.toml")


def test_focal_lengths_in_pixels_millimetres_and_degrees_agree():
    # A 36 mm sensor behind 27 mm: half the width is 18/27 of the focal length, 33.69 degrees.
    for given in ({"focal": 240.0}, {"focal_mm": 27.0}, {"field_of_view_degrees": 67.380135}):
        camera = lens(CameraEntry(**given), (320, 240))
        np.testing.assert_allclose(np.diag(camera.matrix), [240, 240, 1], rtol=1e-7)
        np.testing.assert_array_equal(camera.matrix[:2, 2], [159.5, 119.5])


@pytest.mark.parametrize("size", [(640, 480), (160, 120)])
def test_a_lens_that_turns_back_just_outside_of_the_picture_may_film(size):
    bent = (-0.32, 0.12, 0.0, 0.0, -0.02)  # up to 1.65; the corners are at 1.63
    camera = lens(CameraEntry(field_of_view_degrees=78.0, distortion=bent), size)
    assert camera.radius_limit < 1.66**2


def test_a_camera_looks_where_it_is_told_with_its_picture_upright(speaker):
    entry = CameraEntry(position=(300.0, 0.0, 400.0), target=(0.0, 0.0, 0.0), focal=500.0)
    camera = lens(entry, (320, 240))
    pose = stand(entry, camera, speaker, speaker.vertices)
    np.testing.assert_allclose(pose.apply(np.zeros(3)), [0, 0, 500], atol=1e-9)
    # From a camera to the subject's left, what is nearer to it lies farther left in the picture.
    points = np.array([[0.0, 10, 0], [0.0, 0, 50], [50.0, 0, 0]])
    x, y = camera.project(pose.apply(points)).T
    np.testing.assert_allclose(x - 159.5, [0, -500 * 30 / 460, 500 * 40 / 470], atol=1e-9)
    np.testing.assert_allclose(y - 119.5, [-10, 0, 0], atol=1e-9)
    rolled = stand(replace(entry, roll_degrees=90.0), camera, speaker, speaker.vertices)
    np.testing.assert_allclose(rolled.apply(points[:1]), [[10, 0, 500]], atol=1e-9)


def test_a_worn_camera_sees_a_head_that_stands_still(speaker):
    made = plan(speaker, '[[camera]]\nmount="head"\nposition=[0,-30,300]\n[[clip]]\nframes=12\n')
    view = made.views[0]
    assert view.rotations.shape == (12, 3)
    first = made.pose(view, 0)
    for frame in range(12):
        pose = made.pose(view, frame)
        np.testing.assert_allclose(pose.rotation, first.rotation, atol=1e-12)
        np.testing.assert_allclose(pose.translation, first.translation, atol=1e-9)
    assert np.ptp(made.translations, axis=0).max() > 0.5


def test_lights_change_as_their_keys_say():
    lamp = Light("a", (0.0, 0.0, -1.0), 2.0, keys=(LightKey(1.0), LightKey(3.0, 4.0)))
    np.testing.assert_allclose(lamp.at(np.array([0.0, 1, 2, 3, 9]))[:, 3], [2, 2, 3, 4, 4])
    assert Light("a", (0.0, 0.0, -1.0), 2.0).at(np.zeros(4)).shape == (4, 7)


def test_events_fade_in_and_out(speaker):
    share = ramp(np.arange(0, 2.01, 0.25), 0.5, 1.5, 0.5)
    np.testing.assert_allclose(share, [0, 0, 0, 0.5, 1, 0.5, 0, 0, 0])
    made = plan(
        speaker,
        '[[event]]\nkind="exposure"\nstart=0.1\nend=0.5\nramp=0.1\namount=3\n'
        '[[event]]\nkind="leave"\nstart=0.1\nend=0.5\nramp=0.1\n'
        '[[event]]\nkind="blur"\nstart=0.1\nend=0.5\nramp=0.1\ncameras=["b"]\n'
        '[[camera]]\nname="a"\nexposure=0.5\n[[camera]]\nname="b"\n'
        "[[clip]]\nframes=20\nmotion={amount=0}\n",
    )
    first, second = made.views
    assert (first.gain[0], first.gain[7], first.gain[19]) == (0.5, 1.5, 0.5)
    assert (second.gain[7], first.blur.max(), second.blur[7]) == (3.0, 0.0, 2.5)
    np.testing.assert_array_equal(
        made.translations[[0, 7, 19]], [[0, 0, 0], [420, 0, 0], [0, 0, 0]]
    )


def test_keys_move_the_head(speaker):
    keys = (HeadKey(0.0), HeadKey(1.0, (0.0, 90.0, 0.0), (5.0, 0.0, 0.0)))
    turns, shifts = keyed(keys, np.array([0.0, 1.0, 2.0]))
    np.testing.assert_allclose(turns[:, 1], [0, np.pi / 2, np.pi / 2])
    np.testing.assert_allclose(shifts[:, 0], [0, 5, 5])
    still = head_poses(
        MotionEntry(amount=0.0, keys=keys), np.array([0.0, 1.0]), np.random.default_rng(0), None,
        np.zeros((2, 3)),
    )  # fmt: skip
    np.testing.assert_allclose(still[1].rotation @ [0, 0, 1], [1, 0, 0], atol=1e-12)  # to its left


def test_a_sentence_of_several_lines_is_a_cell_of_the_card(speaker):
    assert plan(speaker, '[[clip]]\nsentence = """\n_ m a\n p _"""\n').sentence == "_ m a p _"


def test_speech_sentences_recordings_and_repetition(speaker, tmp_path):
    said = plan(speaker, "[[clip]]\nsay = '''_ m A:\n p a _'''\nrepeat = 2\n")
    assert said.sentence == "_ m A: p a _"
    half = len(said) // 2
    np.testing.assert_array_equal(said.weights[:half, 24:], said.weights[half:, 24:])
    labels = [label for label, _, _ in said.intervals]
    assert labels[: len(labels) // 2] == labels[len(labels) // 2 :]
    assert all(
        a[2] <= b[1] + 1e-9 for a, b in zip(said.intervals, said.intervals[1:], strict=False)
    )
    cut = plan(speaker, "[[clip]]\nsay = '_ m A: p a _'\nframes = 4\n")
    assert len(cut) == len(cut.phonemes) == 4
    assert max(end for _, _, end in cut.intervals) <= 4 / 25
    held = plan(speaker, "[[clip]]\nsay = 'm A:'\nframes = 100\nblinks = false\n")
    np.testing.assert_array_equal(held.weights[-1], held.weights[-10])


@pytest.mark.parametrize(
    ("says", "last"),
    [
        ("say = 'm a'", ("a", "_")),
        ("say = 'm a _'", ("a", "_")),
        ("say = '_ m a'\nrepeat = 2", ("a", "_")),
        ("sentence = 'm a'\nrepeat = 7", ("a", "rest")),
    ],
)
def test_frames_that_are_held_are_a_pause(speaker, says, last):
    held = plan(speaker, f"[[clip]]\n{says}\nframes = 100\n")
    (said, _, end), (label, start, until) = held.intervals[-2:]
    assert (said, label) == last
    assert start == end < until == 4.0
    assert held.phonemes[-1] == label
    for frame in range(100):
        near = {
            name for name, a, b in held.intervals
            if a - 0.02 <= frame / 25 <= b + 0.02
        }  # fmt: skip
        assert held.phonemes[frame] in near, frame


def test_speech_that_is_cut_is_told_of(speaker, caplog):
    cut = plan(speaker, "[[clip]]\nname = 'talk'\nsay = '_(0.1) m(0.1) i(0.1) p a _'\nframes = 8\n")
    assert caplog.messages == ["clip 'talk': the last 2 of 4 sounds lie after its last frame"]
    assert cut.sentence == "_(0.1) m(0.1) i(0.1) p a _ (cut: without the last 2 of 4 sounds)"
    assert clip_entry(cut).sentence == cut.sentence  # which the card shows
    assert [label for label, _, _ in cut.intervals] == ["_", "m", "i"]
    assert max(start for _, start, _ in cut.intervals) <= 7 / 25
    caplog.clear()
    whole = plan(speaker, "[[clip]]\nsay = '_ m A: p a _'\nframes = 40\n")
    assert whole.sentence == "_ m A: p a _"
    assert not caplog.messages


def test_a_closure_shorter_than_a_frame_is_told_of(speaker, caplog):
    say = "_(0.03) a(0.1) p(0.01) a(0.1) m(0.1) b(0.01) a(0.1) _"
    made = plan(speaker, f"[[clip]]\nsay = '{say}'\n")
    assert "p" not in made.phonemes
    assert caplog.messages == [
        "clip 'clip-1': 2 of 3 p, b, m are shorter than a frame, and no frame is labelled with them"
    ]


def test_visemes_squeezed_into_few_frames_close_the_lips(speaker):
    made = plan(speaker, "[[clip]]\nsentence = 'closures'\nframes = 8\n")
    ends = [(start, end) for label, start, end in made.intervals if label in "pbm"]
    between = [(a, b) for a, b in ends if np.ceil(a * 25) == np.ceil(b * 25)]
    assert len(between) >= 4
    for a, b in between:
        frame = int(np.abs(np.arange(len(made)) - 25 * (a + b) / 2).argmin())
        moved = made.neutral + deform(speaker, made.weights[frame])
        assert widest_gap(speaker, moved) < CLOSED_BELOW


def test_people_by_chance_and_by_hand(speaker):
    entry = SpeakerEntry("x", random=3, skin="very_dark", beads=5)
    person = person_of(entry, speaker)
    assert (person.name, person.beads) == ("x", 5)
    assert person == person_of(entry, speaker)
    assert max(person.skin) < 90
    drawn = person_of(SpeakerEntry("x", random=3), speaker)
    assert drawn.identity == person.identity
    by_hand = person_of(SpeakerEntry("y", base="mei", identity={"head_fat_incr": 0.5}), speaker)
    assert (by_hand.base, dict(by_hand.identity)) == ("mei", {"head_fat_incr": 0.5})


def test_a_view_from_the_side_is_checked_in_all_frames(speaker):
    keys = (HeadKey(0.0), HeadKey(0.3, shift=(0.0, 0.0, 380.0)))
    scene = SceneFile(
        camera=(CameraEntry(position=(0.0, 0.0, 500.0)),),
        clip=(ClipEntry(frames=10, motion=MotionEntry(0.0, keys=keys)),),
    )
    with pytest.raises(ParameterError, match=r"inside the head, or touches it, at 0\.\d\d s"):
        plan_clip(complete(scene), 0, speaker, Cast(speaker, ()), Path(), "")
    calm = replace(scene, clip=(ClipEntry(frames=10),))
    made = plan_clip(complete(calm), 0, speaker, Cast(speaker, ()), Path(), "")
    check_view(made, made.views[0])


def test_a_head_behind_its_mirror_for_a_moment_is_refused(speaker):
    keys = (0.0, 2.08, 2.12, 2.16)
    moved = tuple(HeadKey(t, shift=(260.0 if t == 2.12 else 0.0, 0.0, 0.0)) for t in keys)
    mirror = MirrorEntry(centre=(190.0, 0.0, 640.0), yaw_degrees=-50.0, size=(260.0, 300.0))
    camera = CameraEntry(position=(60.0, 30.0, 700.0), target=(60.0, 0.0, 60.0), mirror=mirror)
    clip = ClipEntry(frames=401, motion=MotionEntry(0.0, keys=moved))
    scene = SceneFile(rate=25.0, camera=(camera,), clip=(clip,))
    with pytest.raises(ParameterError, match=r"reaches 129 mm behind the mirror"):
        plan_clip(complete(scene), 0, speaker, Cast(speaker, ()), Path(), "")


def keys_of(kind):
    """Names of a table's keys, by its dataclass; those of tables within it under their own."""
    found = {kind: {field.name for field in fields(kind)}}
    for hint in get_type_hints(kind).values():
        for part in [hint, *get_args(hint)]:
            if is_dataclass(part):
                found |= keys_of(part)
    return found


def test_the_reference_names_every_key_and_its_default():
    lines = next(p for p in SCENES if p.name == "reference.toml").read_text().splitlines()
    text = "\n".join(line.removeprefix("# ") for line in lines)
    known = keys_of(SceneFile)
    assert len(known) == 15  # as many tables
    for kind, names in known.items():
        for name in names:
            assert re.search(rf"(^|[\[{{., ]){name}(\]| = )", text, re.MULTILINE), (kind, name)
    plain = (int, float, str, bool)
    for kind in (CameraEntry, ClipEntry, MotionEntry, OccluderEntry, EventEntry, Sensor):
        table = section(text, kind)
        for field in fields(kind):
            if type(field.default) in plain and field.default not in ("", True, False):
                note = re.search(rf"^(# )?{field.name} = .*((\n +# .*)*)", table, re.MULTILINE)
                value = field.default if isinstance(field.default, str) else f"{field.default:g}"
                assert re.search(rf"default \"?{value}\"?\b", note[0]), (kind, field.name)


def section(text, kind):
    """The part of the reference that is about a table."""
    heads = {
        CameraEntry: "[[camera]]", ClipEntry: "[[clip]]", MotionEntry: "[clip.motion]",
        OccluderEntry: "[[occluder]]", EventEntry: "[[event]]", Sensor: "[camera.sensor]",
    }  # fmt: skip
    return re.split(r"\n\[", text.split(f"\n{heads[kind]}\n", 1)[1], maxsplit=1)[0]


def test_the_reference_can_be_filmed(speaker):
    scene = complete(read_scene(next(p for p in SCENES if p.name == "reference.toml")))
    made = plan_clip(scene, 0, speaker, Cast(speaker, scene.speaker), Path(), "")
    assert len(made) == 12
    assert [view.mirror is not None for view in made.views] == [False, True, False]
    assert len(made.dots) == 17
    assert {prop.code for prop in made.props} == {OTHER, HAND}


def test_all_that_the_reference_may_show_can_be_filmed(speaker):
    read = read_scene(next(p for p in SCENES if p.name == "reference.toml"))
    names = tuple(one.name or one.kind for one in read.occluder)
    scene = complete(replace(read, clip=(replace(read.clip[0], occluders=names),)))
    made = plan_clip(scene, 0, speaker, Cast(speaker, scene.speaker), Path(), "")
    assert (
        len(made.props)
        == len(
            plan_clip(complete(read), 0, speaker, Cast(speaker, scene.speaker), Path(), "").props
        )
        + len(names)
        - 1
    )


def test_the_references_mirror_is_the_same_by_its_corners():
    text = next(p for p in SCENES if p.name == "reference.toml").read_text()
    standing = parse_scene(text).camera[1].mirror
    corners = tuple(map(tuple, json.loads(re.search(r"^# corners = (.*)$", text, re.M)[1])))
    np.testing.assert_allclose(
        glass(MirrorEntry(corners=corners), "glass"), glass(standing, "glass"), atol=1
    )


@pytest.mark.parametrize("name", ["short", "short.toml"])
def test_a_shipped_scene_is_found_by_its_name(name):
    asked = request_of(Namespace(**{**NOTHING, "what": name}))
    assert asked.scene == read_scene(next(p for p in SCENES if p.name == "short.toml"))
    assert asked.command == "abs-engine synth short.toml"


def test_the_command_of_a_scene_whose_name_is_no_utf_8_can_be_written(tmp_path):
    path = tmp_path / "s\udcff.toml"
    path.write_bytes(next(p for p in SCENES if p.name == "short.toml").read_bytes())
    asked = request_of(Namespace(**{**NOTHING, "what": str(path)}))
    assert asked.command.encode() == rb"abs-engine synth 's\udcff.toml'"


def test_a_word_that_is_nothing_is_answered_with_scenes_too():
    with pytest.raises(
        ParameterError, match=r"no viseme 'speach'.*sentence's name.*or a scene: .*speech"
    ):
        request_of(Namespace(**{**NOTHING, "what": "speach"}))
    with pytest.raises(ParameterError, match="--seed does not go with a scene"):
        request_of(Namespace(**{**NOTHING, "what": "short", "seed": 3}))
    assert request_of(Namespace(**{**NOTHING, "what": "demo"})).scene.clip[0].sentence == "demo"


def test_the_help_names_every_shipped_scene(capsys):
    assert main(["synth", "--help"]) == 0
    told = capsys.readouterr().out
    assert [path.name for path in SCENES if path.name not in told] == []


def test_lamps_that_were_not_in_a_file_are_checked_too():
    with pytest.raises(ParameterError, match="light 'dark' has no direction"):
        lights_at([Light("dark", (0.0, 0.0, 0.0))], np.zeros(1))


def test_a_lamp_that_turns_right_round_has_no_direction_on_the_way():
    ends = LightKey(0.0, direction=(1.0, 0.0, 0.0)), LightKey(2.0, direction=(-1.0, 0.0, 0.0))
    lamp = Light("turning", (0.0, 0.0, -1.0), keys=ends)
    with pytest.raises(ParameterError, match="light 'turning' has no direction at 1 s"):
        lights_at([lamp], np.arange(3.0))
    assert lights_at([lamp], np.array([0.0, 0.96, 1.04])).shape == (3, 1, 7)
