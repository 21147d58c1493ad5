"""Face units of heads of other programs: which morph targets make them, and which do not."""

from __future__ import annotations

import numpy as np
import pytest
from imported import FEW, OUTER_CLASSES, facets_of, table

from abs_engine.cli.commands.import_ import report
from abs_engine.core.errors import ParameterError
from abs_engine.face.schema import FACE_UNITS, HALF, PREFIXED, WHOLE, reading
from abs_engine.io.assets import load_speaker
from abs_engine.io.morphs import MorphMesh
from abs_engine.learn.heads.build import build_head
from abs_engine.learn.heads.table import read_table

HEAD = load_speaker()
USED = (*FEW, "jawLeft", "jawRight", "cheekPuff")
MOVES = dict(zip(USED, HEAD.unit_matrix(USED), strict=True))
SKIN = facets_of(HEAD, *OUTER_CLASSES)


@pytest.fixture
def built(tmp_path):
    """Makes a head whose morph targets are given, by a table with some more in it."""

    def build(targets, more=""):
        (tmp_path / "head.toml").write_text(table(HEAD, more=more))
        mesh = MorphMesh(
            "head.glb", HEAD.vertices.astype(np.float64), SKIN, np.zeros(len(SKIN), np.int32),
            ("Head",), targets,
        )  # fmt: skip
        return build_head(mesh, read_table(tmp_path / "head.toml"))

    return build


def moved(made, unit):
    """What a unit does to the head's own vertices."""
    return made.speaker.unit_matrix((unit,))[0, : len(HEAD.vertices)]


def same(made, unit, moves):
    return np.abs(moved(made, unit) - moves).max() < 0.02


@pytest.mark.parametrize(
    ("name", "unit", "how"),
    [
        ("L_mouthSmile", "mouthSmileLeft", WHOLE),
        ("right_eyeBlink", "eyeBlinkRight", WHOLE),
        ("head_jawOpen", "jawOpen", PREFIXED),
        ("01_jawOpen", "jawOpen", PREFIXED),
        ("Head_L_mouthSmile", "mouthSmileLeft", PREFIXED),
        ("L_browInnerUp", "browInnerUp", HALF),
        ("mouthSmile_L_jawOpen", None, WHOLE),
        ("jawOpen_mouthClose", None, WHOLE),
        ("L_jawOpen", None, WHOLE),
        ("mouthLeft", "mouthLeft", WHOLE),
        ("_", None, WHOLE),
    ],
)
def test_names_with_something_before_them(name, unit, how):
    assert reading(name)[:2] == (unit, how)


def test_two_names_of_one_motion_move_by_it_once(built):
    twice = {**MOVES, "mouthSmile_L": MOVES["mouthSmileLeft"]}
    assert same(built(twice), "mouthSmileLeft", MOVES["mouthSmileLeft"])


def test_two_motions_of_one_name_are_refused(built):
    other = {**MOVES, "mouthSmile_L": 0.5 * MOVES["mouthSmileLeft"]}
    with pytest.raises(ParameterError, match="'mouthSmileLeft' and 'mouthSmile_L' both mean"):
        built(other)
    chosen = built(other, '[units]\nmouthSmileLeft = "mouthSmile_L"\n')
    assert same(chosen, "mouthSmileLeft", other["mouthSmile_L"])
    assert chosen.unused == ("mouthSmileLeft",)


def test_parts_of_a_head_may_have_targets_of_their_own(built):
    """As of Maya, which puts the name of each mesh's deformer before the name."""
    high = (HEAD.vertices[:, 1] > -40)[:, None]
    jaw = MOVES["jawOpen"]
    apart = {k: v for k, v in MOVES.items() if k != "jawOpen"}
    apart |= {"head.jawOpen": np.where(high, jaw, 0), "beard.jawOpen": np.where(high, 0, jaw)}
    assert same(built(apart), "jawOpen", jaw)


def test_halves_are_added_up_where_nothing_is_the_whole(built):
    left = (HEAD.vertices[:, :1] > 0) * MOVES["cheekPuff"]
    right = MOVES["cheekPuff"] - left
    halves = {"cheekPuff_L": left, "cheekPuff_R": right}
    alone = {k: v for k, v in MOVES.items() if k != "cheekPuff"} | halves
    assert same(built(alone), "cheekPuff", MOVES["cheekPuff"])
    both = built(MOVES | halves)
    assert same(both, "cheekPuff", MOVES["cheekPuff"])
    assert both.unused == ("cheekPuff_L", "cheekPuff_R")


def test_a_surer_name_counts_alone(built):
    made = built({**MOVES, "fix_jawOpen": 0.3 * MOVES["jawOpen"]})
    assert same(made, "jawOpen", MOVES["jawOpen"])
    assert made.unused == ("fix_jawOpen",)


def test_one_target_may_make_two_units(built):
    more = '[units]\nmouthSmileLeft = "mouthSmileLeft"\nmouthSmileRight = "mouthSmileLeft"\n'
    made = built(MOVES, more)
    for unit in ("mouthSmileLeft", "mouthSmileRight"):
        assert same(made, unit, MOVES["mouthSmileLeft"])
        assert unit not in made.missing
    assert made.unused == ("mouthSmileRight",)


def test_a_target_that_is_named_twice_counts_once(built):
    made = built(MOVES, '[units]\njawOpen = ["jawOpen", "jawOpen"]\n')
    assert same(made, "jawOpen", MOVES["jawOpen"])


def test_units_that_both_move_one_side_are_not_exchanged(built):
    both = {**MOVES, "mouthSmileRight": MOVES["mouthSmileLeft"]}
    made = built(both)
    assert not made.exchanged
    assert same(made, "mouthSmileLeft", MOVES["mouthSmileLeft"])


def test_left_and_right_of_a_viewer_are_exchanged(built):
    swapped = {
        name.replace("Left", "*").replace("Right", "Left").replace("*", "Right"): moves
        for name, moves in MOVES.items()
    }
    made = built(swapped)
    assert set(made.exchanged) == {n for n in USED if n.endswith(("Left", "Right"))}
    for unit in made.exchanged:
        assert same(made, unit, MOVES[unit])
    by_hand = built(swapped, '[units]\njawLeft = "jawLeft"\n')
    assert same(by_hand, "jawLeft", swapped["jawLeft"]), "who names it may have it so"
    assert not built(MOVES).exchanged


def test_a_head_without_jaw_open_names_what_it_has(built):
    without = {k: v for k, v in MOVES.items() if k != "jawOpen"}
    with pytest.raises(ParameterError, match=r"called jawOpen; say which .* jawLeft, jawRight"):
        built(without)
    with pytest.raises(ParameterError, match="called jawOpen; export its morph targets"):
        built({})
    with pytest.raises(ParameterError, match="no morph target 'jawLetf'; did you mean 'jawLeft'"):
        built(MOVES, '[units]\nmouthLeft = "jawLetf"\n')


def test_what_is_added_to_a_head_goes_with_the_units_that_it_has(built):
    made = built(MOVES)
    assert "tongue" in made.added
    assert set(made.missing) == set(FACE_UNITS) - set(USED)
    assert not made.speaker.unit_matrix(("tongueOut",)).any(), "its lips do not part for it"


def test_the_command_says_what_is_to_be_known_of_a_head(built):
    swapped = {k: v for k, v in MOVES.items() if not k.startswith("jaw") or k == "jawOpen"}
    swapped |= {"jawLeft": MOVES["jawRight"], "jawRight": MOVES["jawLeft"]}
    swapped |= {f"own_{k}": MOVES["jawLeft"] for k in range(20)}
    said = "\n".join(report(built(swapped, '[regions]\nHead = "skin"\n')))
    assert (
        "warning: without mouthPressLeft, mouthPressRight, tracked lips cannot be pressed as they "
        "are in speech\n"
    ) in said
    bare = {k: v for k, v in MOVES.items() if k not in ("mouthClose", "mouthPucker")}
    assert (
        "without mouthClose, mouthPressLeft, mouthPressRight, mouthPucker, tracked lips cannot be "
        "rounded, pressed or closed over an open jaw as they are in speech"
    ) in "\n".join(report(built(bare)))
    assert "left and right were exchanged" in said
    assert "own_0" in said
    assert "own_19" in said, "all are named: a table needs their names"
    assert "not drawn" not in said
