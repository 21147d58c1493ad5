"""What the parts of imported heads are taken for, and whether their landmarks lie on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from imported import table, write_glb

from abs_engine.cli.commands.import_ import report
from abs_engine.core.errors import ParameterError
from abs_engine.face.rings import lip_rings
from abs_engine.face.schema import region_of
from abs_engine.io.assets import load_speaker
from abs_engine.io.morphs import read_morphs
from abs_engine.learn.heads.build import build_head
from abs_engine.learn.heads.table import read_table

HEAD = load_speaker()
EYES = HEAD.landmarks["eye_corners"].tolist()


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    """A head without teeth, as it is read."""
    return read_morphs(write_glb(tmp_path_factory.mktemp("parts") / "head.glb"))


@pytest.fixture
def built(tmp_path):
    """Makes a head of a mesh, by a table with other landmarks or some more in it."""

    def build(mesh, more="", marks=None):
        (tmp_path / "head.toml").write_text(table(HEAD, marks, more))
        return build_head(mesh, read_table(tmp_path / "head.toml"))

    return build


def called(mesh, face):
    """The mesh with another name of its skin."""
    assert mesh.part_names[0].endswith("Head")
    return replace(mesh, part_names=(face, *mesh.part_names[1:]))


@pytest.mark.parametrize(
    ("names", "region"),
    [
        ("BrownSkin M_Brown Chair Head_hairless Unbearded Philip Meyer_head Heyes Keyed_Head "
         "FaceEyeShadow Coral Temporal_Head Legum Tulip eyelid_upper M_EyeSocketLeft", "skin"),
        ("Lips_Mat Lips1 LipGloss lips", "lips"),
        ("Lip_Upper upperlip topLip LipsUpper", "upper_lip"),
        ("lowerLips Lip_Lower", "lower_lip"),
        ("hair01 Hairstyle Eyebrows lashes TShirt CC_Base_TearLine M_EyeBlendLeft glasses", "none"),
        ("EYES lefteye REye AvatarLeftEyeball Iris_L pupils eyesMesh", "eyes"),
        ("Std_Upper_Teeth teethmesh Wolf3D_Teeth", "teeth"),
        ("mouthBag Gums inner_mouth", "inner_mouth"),
    ],
)  # fmt: skip
def test_only_whole_words_say_what_a_part_is(names, region):
    assert {name: region_of(name) for name in names.split()} == dict.fromkeys(names.split(), region)


@pytest.mark.parametrize(
    ("name", "taken"),
    [("Lips_all", "is taken for lips"), ("Hair", "is not drawn"), ("Eyes", "is taken for eyes")],
)
def test_a_face_that_is_no_skin_is_refused_by_its_name(mesh, built, name, taken):
    with pytest.raises(ParameterError, match=rf"on the part '{name}' of .*{taken}") as error:
        built(called(mesh, name))
    assert f'[regions] "{name}" = "skin"' in error.value.remedy
    assert built(called(mesh, name), f'[regions]\n{name} = "skin"\n').opening > 20
    with pytest.raises(ParameterError, match="is taken for teeth"):
        built(mesh, '[regions]\nHead = "teeth"\n')


def test_parts_that_are_not_drawn_are_named(mesh, built):
    assert built(mesh).hidden == ()
    assert built(mesh, '[regions]\nEyes = "none"\n').hidden == ("Eyes",)


def test_a_landmark_that_is_on_no_facet_is_refused(mesh, built):
    kept = ~(mesh.faces == HEAD.landmarks["nose_tip"][0]).any(axis=1)
    with pytest.raises(ParameterError, match="landmark nose_tip is on no facet"):
        built(replace(mesh, faces=mesh.faces[kept], part=mesh.part[kept]))


def test_lips_are_on_facets_where_a_material_leaves_the_first_copy_of_a_vertex_unused(mesh, built):
    """As in glTF files whose materials share vertices: the facets take the second copies."""
    count, twice = len(mesh.vertices), {n: np.tile(d, (2, 1)) for n, d in mesh.targets.items()}
    copied = replace(mesh, vertices=np.tile(mesh.vertices, (2, 1)), targets=twice)
    head = built(replace(copied, faces=mesh.faces + count)).speaker
    alone = built(mesh).speaker
    for name, at in lip_rings(head).items():
        assert np.isin(at, head.faces).all()
        assert np.array_equal(head.vertices[at], alone.vertices[lip_rings(alone)[name]])


def test_facets_that_face_into_the_head_are_turned_round(mesh, built):
    """They would be left out of every drawing, and the back of the head be scored as the face."""
    inverted = built(replace(mesh, faces=mesh.faces[:, ::-1]))
    alone = built(mesh)
    assert (inverted.inside_out, alone.inside_out) == (True, False)
    assert np.array_equal(inverted.speaker.faces, alone.speaker.faces)
    assert np.array_equal(inverted.speaker.points["face"], alone.speaker.points["face"])
    said = "facets were turned round, as they faced into the head"
    assert said in report(inverted)
    assert said not in report(alone)


@pytest.mark.parametrize("copied", [False, True])
def test_facets_that_lie_on_others_are_left_out(mesh, built, copied):
    """Of a mesh that is seen from both sides, whose normals would cancel out."""
    count = len(mesh.vertices) if copied else 0
    both = replace(
        mesh,
        vertices=np.concatenate([mesh.vertices, mesh.vertices[:count]]),
        targets={name: np.concatenate([d, d[:count]]) for name, d in mesh.targets.items()},
        faces=np.concatenate([mesh.faces, mesh.faces[:, ::-1] + count]).astype(np.int32),
        part=np.tile(mesh.part, 2),
    )
    made, alone = built(both), built(mesh)
    assert (made.twice, alone.twice) == (len(mesh.faces), 0)
    corners = [m.speaker.vertices[m.speaker.faces] for m in (made, alone)]
    assert np.array_equal(*corners)
    assert len(made.speaker.points["face"]) == len(alone.speaker.points["face"])
    assert f"{len(mesh.faces)} facets were left out, as they lie on others" in report(made)


def test_a_picture_stays_on_facets_that_are_turned_round(mesh, built):
    spots = np.random.default_rng(0).random((len(mesh.vertices), 2), np.float32)
    grey = np.full((8, 8, 3), 120, np.uint8)
    pictured = replace(mesh, uv=spots[mesh.faces], texture=grey)
    inverted = replace(pictured, faces=mesh.faces[:, ::-1], uv=pictured.uv[:, ::-1])
    assert np.array_equal(built(inverted).speaker.uv, built(pictured).speaker.uv)


def test_eyes_that_lie_away_from_the_face_are_refused(mesh, built):
    eyes = np.unique(mesh.faces[mesh.part == len(mesh.part_names) - 1])
    away = mesh.vertices.copy()
    away[eyes] += [0, 0, 1.5]
    with pytest.raises(ParameterError, match=r"part 'Eyes' .* eyes, lies 1\d{3} mm away"):
        built(replace(mesh, vertices=away))


@pytest.mark.parametrize("order", [[1, 0, 3, 2], [1, 0, 2, 3], [0, 1, 3, 2]])
def test_corners_of_eyes_in_a_wrong_order_are_refused(mesh, built, order):
    with pytest.raises(ParameterError, match="lists an inner corner of an eye where the outer"):
        built(mesh, marks={"eye_corners": [EYES[k] for k in order]})


def test_a_chin_or_a_nose_on_the_lips_is_refused(mesh, built):
    ring = HEAD.landmarks["outer_lip_20"].tolist()
    with pytest.raises(ParameterError, match="landmark chin does not lie below the lips"):
        built(mesh, marks={"chin": [ring[9]]})
    with pytest.raises(ParameterError, match="landmark nose_tip does not lie above the lips"):
        built(mesh, marks={"nose_tip": [ring[3]]})
