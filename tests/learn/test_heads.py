"""Heads from meshes of other programs: what is made of them, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from imported import FEW, OUTER_CLASSES, PARTS, facets_of, table, write_glb, write_obj
from scipy.spatial.transform import Rotation

from abs_engine.cli import main
from abs_engine.core.errors import (
    FaceNotFoundError,
    InputFileError,
    ModelFormatError,
    ParameterError,
)
from abs_engine.face.schema import FACE_UNITS, reading, region_of
from abs_engine.io.assets import load_speaker
from abs_engine.io.morphs import read_morphs
from abs_engine.io.morphs.obj import read_obj, tiled
from abs_engine.learn.heads.build import build_head
from abs_engine.learn.heads.frame import head_frame
from abs_engine.learn.heads.marks import Marks
from abs_engine.learn.heads.paint import _from_pupil
from abs_engine.learn.heads.table import read_table
from abs_engine.tracking.landmark.rendered_landmarks import with_network

HEAD = load_speaker()
VERTICES = len(HEAD.vertices)
OUTER = facets_of(HEAD, *OUTER_CLASSES)
MARKS = Marks(
    *(np.asarray(HEAD.landmarks[name], np.int64)
      for name in ("outer_lip_20", "inner_lip_8", "nose_tip", "chin", "eye_corners"))
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A GLB without teeth, and its table."""
    found = tmp_path_factory.mktemp("heads")
    write_glb(found / "head.glb")
    (found / "head.toml").write_text(table(HEAD))
    return found


@pytest.fixture(scope="module")
def made(folder):
    """The head that is made of the GLB."""
    return build_head(read_morphs(folder / "head.glb"), read_table(folder / "head.toml"))


def facets(head, *names):
    """Facets of some classes as a set of their corners."""
    return {tuple(sorted(face)) for face in facets_of(head, *names).tolist()}


def test_a_head_in_metres_with_z_up_comes_into_the_head_frame(made):
    """It was written 1.7 m above the floor, and is moved to the origin."""
    head = made.speaker
    away = head.vertices[:VERTICES] - HEAD.vertices
    assert np.ptp(away, axis=0).max() < 0.01
    assert np.abs(away).max() < 20
    for name in FEW:
        same = head.unit_matrix((name,))[0, :VERTICES] - HEAD.unit_matrix((name,))[0]
        assert np.abs(same).max() < 0.05, name
    assert made.opening == pytest.approx(35.5, abs=1)
    assert set(made.missing) == set(FACE_UNITS) - set(FEW)


def test_painted_brows_lie_above_the_lids(made):
    """Closed eyes were black patches: the upper lids had been painted with the brows."""
    head = made.speaker
    across = head.uv[:, 0] * head.texture("neutral").shape[1]
    colour = head.texture("neutral")[0, np.clip(across.astype(int), 0, None)].astype(float)
    skin = np.unique(facets_of(head, "skin"))
    dark = skin[colour[skin].sum(axis=1) < 300]
    moved = np.linalg.norm(head.unit_matrix(("eyeBlinkLeft", "eyeBlinkRight")), axis=2).max(axis=0)
    assert moved[dark].max() < 0.35 * moved.max()
    eyes = head.vertices[head.landmarks["eye_corners"]]
    for side in (-1, 1):
        brow = head.vertices[dark[side * head.vertices[dark, 0] > 0]]
        assert len(brow) > 20
        assert np.ptp(brow[:, 0]) > 0.8 * np.linalg.norm(eyes[0] - eyes[1])
        assert 6 < brow[:, 1].mean() - eyes[:, 1].mean() < 20


@pytest.mark.parametrize("deep", [0.0, 12.0])
def test_eyes_have_a_pupil_an_iris_and_a_white_also_where_they_are_flat(deep):
    x, y = np.mgrid[-12:13, -12:13].reshape(2, -1)
    away = np.hypot(x, y)
    disc, away = np.column_stack([x, y, 70.0 + 0 * x])[away <= 12], away[away <= 12]
    disc[:, 2] += deep * np.sqrt(1 - (away / 12) ** 2)
    at = _from_pupil(disc)
    assert set(at[away < 2]) == {0.0}
    assert set(at[(away > 4) & (away < 6)]) == {1.0}
    assert set(at[away > 7]) == {2.0}


def test_lips_are_found_between_their_contours(folder):
    bare = "[regions]\nLips = 'skin'\n"
    (folder / "bare.toml").write_text(table(HEAD, more=bare))
    head = build_head(read_morphs(folder / "head.glb"), read_table(folder / "bare.toml")).speaker
    for lip, other in (("upper_lip", "lower_lip"), ("lower_lip", "upper_lip")):
        found = facets(head, lip)
        assert len(found & facets(HEAD, lip)) / len(found) > 0.9, lip
        assert len(found & facets(HEAD, other)) < 0.03 * len(found)
        assert len(found) > 0.5 * len(facets(HEAD, lip)), "the rest lies behind where lips meet"


def test_lips_that_are_named_are_kept_whole(made):
    both = "upper_lip", "lower_lip"
    assert facets(made.speaker, *both) == facets(HEAD, *both)
    for lip in both:
        assert len(facets(made.speaker, lip) & facets(HEAD, lip)) > 0.85 * len(facets(HEAD, lip)), (
            "but for the corners"
        )


def test_teeth_tongue_and_the_inside_are_added_where_they_are_missing(made, folder):
    assert set(made.added) == {"upper_teeth", "lower_teeth", "tongue", "inner_mouth"}
    head = made.speaker
    jaw = head.unit_matrix(("jawOpen",))[0]

    def moved(name):
        own = np.unique(facets_of(head, name))
        own = own[own >= VERTICES]
        assert len(own) > 50, name
        return np.linalg.norm(jaw[own], axis=1).mean()

    assert moved("upper_teeth") < 0.5
    assert moved("lower_teeth") > 10
    lips = head.vertices[head.landmarks["inner_lip_8"]]
    teeth = head.vertices[np.unique(facets_of(head, "upper_teeth"))]
    assert teeth[:, 2].max() < lips[2, 2], "the teeth lie behind the upper lip"
    whole = write_glb(folder / "whole.glb", list(PARTS))
    assert not build_head(read_morphs(whole), read_table(folder / "head.toml")).added


def test_lower_teeth_are_those_that_go_with_the_jaw(folder):
    whole = write_glb(folder / "teeth.glb", list(PARTS))
    head = build_head(read_morphs(whole), read_table(folder / "head.toml")).speaker
    assert facets(head, "lower_teeth") == facets(HEAD, "lower_teeth")
    assert facets(head, "upper_teeth") == facets(HEAD, "upper_teeth")


def test_an_obj_keeps_its_vertices_and_knows_its_people(tmp_path):
    shapes = tmp_path / "shapes"
    shapes.mkdir()
    write_obj(tmp_path / "head.obj", HEAD.vertices, OUTER)
    write_obj(tmp_path / "clara.obj", HEAD.named("clara"), OUTER)
    for name in ("jawOpen", "mouthFunnel"):
        write_obj(shapes / f"{name}.obj", HEAD.vertices + HEAD.unit_matrix((name,))[0], OUTER)
    (tmp_path / "head.toml").write_text(table(HEAD) + '[people]\nclara = "clara.obj"\n')
    mesh = read_morphs(tmp_path / "head.obj", shapes)
    head = build_head(mesh, read_table(tmp_path / "head.toml")).speaker
    assert np.abs(head.vertices[:VERTICES] - HEAD.vertices).max() < 1e-4
    assert set(head.people) == {"neutral", "clara"}
    clara = head.named("clara")[:VERTICES]
    assert np.abs(clara - HEAD.named("clara")).max() < 0.02


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("jawOpen", "jawOpen"),
        ("JawOpen", "jawOpen"),
        ("mouthSmile_L", "mouthSmileLeft"),
        ("head_blend.mouth_smile_right", "mouthSmileRight"),
        ("mouthSmile.R", "mouthSmileRight"),
        ("cheekPuff_L", "cheekPuff"),
        ("browInnerUp_R", "browInnerUp"),
        ("mouthLeft", "mouthLeft"),
        ("PupilDilate_L", None),
        ("mouthClosed", None),
    ],
)
def test_names_of_morph_targets(name, unit):
    assert reading(name)[0] == unit


def test_names_of_parts():
    told = {"M_Teeth": "teeth", "Wolf3D_Teeth / x": "teeth", "EyeLeft": "eyes", "Eyelashes": "none",
            "head / Skin": "skin", "tongue_low": "tongue", "MouthBag / Mouth_inside": "skin",
            "Eyebrows": "none", "upper_lip": "upper_lip"}  # fmt: skip
    assert {name: region_of(name) for name in told} | {"MouthBag / Mouth_inside": "skin"} == told


def refused(error, says, *, glb=None, told=None, folder=None, mesh=None):
    """Check that a head is refused."""
    path = folder / "bad.toml"
    path.write_text(table(HEAD) if told is None else told)
    with pytest.raises(error, match=says):
        build_head(read_morphs(glb or folder / "head.glb") if mesh is None else mesh,
                   read_table(path))  # fmt: skip


def test_a_mouth_that_does_not_open_is_refused(folder):
    told = table(HEAD, more="[units]\njawOpen = 'browInnerUp'\n")
    refused(ParameterError, "jawOpen opens the lips of .* by 0.0 mm", told=told, folder=folder)


def test_a_target_of_another_vertex_count_is_refused(folder, tmp_path):
    glb = write_glb(folder / "short.glb", units=FEW[:3], short="mouthClose")
    with pytest.raises(ModelFormatError, match=f"'mouthClose' has {VERTICES - 5} vertices"):
        read_morphs(glb)
    write_obj(tmp_path / "head.obj", HEAD.vertices, OUTER)
    shapes = tmp_path / "shapes"
    shapes.mkdir()
    write_obj(shapes / "jawOpen.obj", HEAD.vertices[:-1], OUTER[:5])
    with pytest.raises(ModelFormatError, match=f"has {VERTICES - 1} vertices, the head"):
        read_morphs(tmp_path / "head.obj", shapes)


@pytest.mark.parametrize(
    ("told", "error", "says"),
    [
        ("", ParameterError,
         "does not say where these lie: outer_lip, inner_lip, nose_tip"),
        ("[landmarks", InputFileError, "is not TOML"),
        ("[landmark]\n", ParameterError, "no section 'landmark'"),
        ("[units]\njawOpn = 'x'\n", ParameterError, "no face unit 'jawOpn'"),
        ("[regions]\nHead = 'face'\n", ParameterError, "no region 'face'"),
        (table(HEAD, more="[regions]\nheads = 'skin'\n"), ParameterError,
         "no part 'heads', which .* did you mean 'Head'"),
        ("length = 'ft'\n", ParameterError, "no length 'ft'"),
        (table(HEAD, {"chin": [10**6]}), ParameterError, "chin: 1000000 is no vertex"),
        (table(HEAD, {"chin": [[0.0, -64.0, 92.0]]}), ParameterError,
         r"chin: no vertex is near \[0.0, -64.0, 92.0\]; .* reaches from .*1.5.* to "),
        (table(HEAD, more="length = 'mm'\n"), ParameterError,
         "eyes' outer corners are 0.08.*; correct length = \"mm\" in the table, or leave it out"),
        (table(HEAD, more="[units]\njawOpen = 'Mouth_Open'\n"), ParameterError, "no morph target"),
        (table(HEAD, more="[units]\njawForward = 'jawOpen'\n"), ParameterError,
         "'jawOpen' is used for two units: jawForward, and jawOpen by its name; .* jawOpen = "),
        (table(HEAD, {"outer_lip": HEAD.landmarks["outer_lip_20"][::-1].tolist()}),
         ParameterError, "outer_lip goes over the lower lip first"),
        (table(HEAD, {"inner_lip": np.roll(HEAD.landmarks["inner_lip_8"], 4).tolist()}),
         ParameterError, "inner_lip does not begin at the right corner"),
        (table(HEAD, {"inner_lip": HEAD.landmarks["outer_lip_20"].tolist(),
                      "outer_lip": HEAD.landmarks["inner_lip_8"].tolist()}),
         ParameterError, "inner_lip is wider than outer_lip"),
        (table(HEAD, {"eye_corners": HEAD.landmarks["eye_corners"][:1].tolist() * 4}),
         ParameterError, "do not lie as a face's do"),
        (table(HEAD, {"eye_corners": HEAD.landmarks["eye_corners"][::-1].tolist()}),
         ParameterError, "do not lie as a face's do"),
    ],
)  # fmt: skip
def test_tables_that_are_wrong(folder, told, error, says):
    refused(error, says, told=told, folder=folder)


@pytest.mark.parametrize(
    ("sign", "says"),
    [(-1, "its file seems to hold differences"), (1, "seems to hold positions")],
)
def test_targets_that_are_no_motion_are_refused(folder, sign, says):
    mesh = read_morphs(folder / "head.glb")
    jaw = mesh.targets["jawOpen"] + sign * np.float32(mesh.vertices)
    mesh = replace(mesh, targets={**mesh.targets, "jawOpen": jaw})
    refused(ParameterError, f"jawOpen moves the corners of the eyes .* {says}", folder=folder,
            mesh=mesh)  # fmt: skip


@pytest.mark.parametrize("times", [0.001, 0.01, 1000])
def test_targets_in_another_unit_than_the_head_are_said_to_be(folder, times):
    mesh = read_morphs(folder / "head.glb")
    own = np.float32(mesh.vertices)
    jaw = np.float32(times) * (mesh.targets["jawOpen"] + own) - own
    mesh = replace(mesh, targets={**mesh.targets, "jawOpen": jaw})
    refused(ParameterError, "jawOpen .* seems to be in another unit than the head", folder=folder,
            mesh=mesh)  # fmt: skip


def test_a_head_that_is_mirrored_is_said_to_be_perhaps():
    with pytest.raises(ParameterError, match="or the mesh may be mirrored, as by a scale of -1"):
        head_frame(HEAD.vertices.astype(float) * [-1, 1, 1], MARKS, None)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("times", [1e-18, 0])
def test_a_head_in_a_tiny_unit_is_said_to_be_small(times):
    with pytest.raises(ParameterError, match="the eyes' outer corners are"):
        head_frame(HEAD.vertices.astype(float) * times, MARKS, None)
    with pytest.raises(ParameterError, match="the eyes' outer corners are"):
        head_frame(np.round(HEAD.vertices.astype(float) * 1e-7, 5), MARKS, None)


@pytest.mark.parametrize(
    ("degrees", "shift"),
    [((0, 30, 0), (0, 0, 0)), ((10, 12, 8), (0, 0, 0)), ((50, 40, -30), (900, 0, 20)),
     ((0, 0, 0), (0, 0, 150)), ((90, 0, 0), (0, 0, 0))],
)  # fmt: skip
def test_a_head_that_is_turned_or_shifted_is_brought_into_the_head_frame(degrees, shift):
    turn = Rotation.from_euler("xyz", degrees, degrees=True)
    moved = turn.apply(HEAD.vertices.astype(np.float64)) + shift
    frame = head_frame(moved, MARKS, None)
    assert np.abs(frame.places(moved) - HEAD.vertices).max() < 1.0
    smile = HEAD.unit_matrix(("mouthSmileLeft",))[0]
    back = frame.moves(turn.apply(smile.astype(np.float64)))
    assert np.abs(back - smile).max() < 0.1


def test_people_s_own_faces_are_not_laid_on_the_average_one():
    """Nor is a head that lies hardly beside its usual place."""
    for name in ("clara", "walter"):
        frame = head_frame(HEAD.named(name) + np.array([0.0, 9, 9]), MARKS, None)
        assert frame.matrix.tolist() == np.eye(3).tolist(), name
        assert not frame.origin.any(), name


def test_landmarks_that_are_not_on_the_mouth_are_refused_at_once():
    behind = np.full(12, HEAD.vertices[:, 2].argmin(), np.int32)
    head = replace(HEAD, landmarks={**HEAD.landmarks, "outer_lip_20": behind})
    with pytest.raises(ModelFormatError, match="landmarks points are not on the facets"):
        with_network(head, None)


def test_a_head_in_which_no_face_is_seen_has_a_remedy_that_import_knows(monkeypatch):
    def unseen(head, renderer):
        raise FaceNotFoundError("the network sees no face", "--start blobs")

    monkeypatch.setattr("abs_engine.tracking.landmark.rendered_landmarks.correspondence_of", unseen)
    with pytest.raises(FaceNotFoundError, match="sees no face; check that its faces point out"):
        with_network(HEAD, None)


def test_a_person_of_another_mesh_is_refused(folder):
    write_obj(folder / "other.obj", HEAD.vertices[:100], [[0, 1, 2]] * np.ones((1, 1), int))
    told = table(HEAD) + '[people]\nanna = "other.obj"\n'
    says = r"other.obj is another mesh: person 'anna' has 100 vertices"
    refused(ModelFormatError, says, told=told, folder=folder)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda v: v / 10, r"corners are 7\..* mm apart; scale it to the head's unit"),
        (
            lambda v: np.add(v, [0, 1600, 0]),
            r"up to 16.. mm from the head's; export it as the head was",
        ),
        (lambda v: v[:, [0, 2, 1]] * [1, -1, 1], r"up to 1.. mm from the head's; export it as"),
        (lambda v: np.random.default_rng(0).permutation(v), "the same vertices in their order"),
    ],
)
def test_people_whose_faces_are_not_where_the_head_has_its_own_are_refused(tmp_path, change, says):
    write_obj(tmp_path / "head.obj", HEAD.vertices, OUTER)
    write_obj(tmp_path / "mei.obj", change(HEAD.named("mei")), OUTER)
    shapes = tmp_path / "shapes"
    shapes.mkdir()
    opened = HEAD.vertices + HEAD.unit_matrix(("jawOpen",))[0]
    write_obj(shapes / "jawOpen.obj", opened, OUTER)
    told = table(HEAD) + '[people]\nmei = "mei.obj"\n'
    refused(ParameterError, r"mei.obj is no face like the head's: .*" + says, told=told,
            mesh=read_morphs(tmp_path / "head.obj", shapes), folder=tmp_path)  # fmt: skip


def test_files_that_are_no_heads(tmp_path):
    for name in ("head.glb", "head.obj", "head.stl"):
        (tmp_path / name).write_bytes(b"nothing of use")
    with pytest.raises(InputFileError, match="no whole glTF"):
        read_morphs(tmp_path / "head.glb")
    with pytest.raises(InputFileError, match="no vertices"):
        read_morphs(tmp_path / "head.obj", tmp_path)
    write_obj(tmp_path / "some.obj", HEAD.vertices[:3], np.array([[0, 1, 2]]))
    (tmp_path / "empty").mkdir()
    for folder in ("empty", "head.glb"):
        with pytest.raises(InputFileError, match=f"no OBJ file .* was found in .*{folder}"):
            read_morphs(tmp_path / "some.obj", tmp_path / folder)
    with pytest.raises(InputFileError, match="neither GLB, glTF nor OBJ"):
        read_morphs(tmp_path / "head.stl")
    with pytest.raises(ParameterError, match="needs --deltas"):
        read_morphs(tmp_path / "head.obj")
    with pytest.raises(InputFileError, match=r"is a folder without generic_neutral_mesh.obj"):
        read_morphs(tmp_path)


def test_the_command_refuses_in_a_line_and_writes_nothing(folder, tmp_path, capsys):
    words = ["import", str(folder / "head.glb"), "-o", str(tmp_path / "head.face")]
    assert main([*words, "--renderer", "cpu"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--table head.toml" in line
    assert not list(tmp_path.iterdir())


def test_a_texture_is_laid_by_the_corners_of_facets(tmp_path):
    """Vertices at its seams get copies, which come behind all others."""
    skin = facets_of(HEAD, *OUTER_CLASSES)
    seamed = HEAD.uv[skin].copy()
    seamed[0] = 0.5  # the first facet lies elsewhere on the texture than its neighbours
    rows = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in HEAD.vertices.tolist()]
    rows += [f"vt {u:.6f} {1 - v:.6f}" for u, v in seamed.reshape(-1, 2).tolist()]
    rows += [
        "f " + " ".join(f"{n + 1}/{3 * k + c + 1}" for c, n in enumerate(face))
        for k, face in enumerate(skin.tolist())
    ]
    (tmp_path / "head.obj").write_text("\n".join(rows) + "\n")
    shapes = tmp_path / "shapes"
    shapes.mkdir()
    opened = HEAD.vertices + HEAD.unit_matrix(("jawOpen",))[0]
    write_obj(shapes / "jawOpen.obj", opened, skin[:1])
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:, :, 2] = 200  # red, as OpenCV writes it
    cv2.imwrite(str(tmp_path / "red.png"), picture)
    (tmp_path / "head.toml").write_text(table(HEAD) + '[textures]\nneutral = "red.png"\n')
    mesh = read_morphs(tmp_path / "head.obj", shapes)
    head = build_head(mesh, read_table(tmp_path / "head.toml")).speaker
    assert np.abs(head.vertices[:VERTICES] - HEAD.vertices).max() < 1e-4
    whole, origin = mesh.at_seams()
    copies = len(origin) - VERTICES
    assert copies >= 3
    assert np.abs(whole.vertices[whole.faces] - mesh.vertices[mesh.faces]).max() == 0
    assert np.abs(whole.uv_of_vertices()[whole.faces] - mesh.uv).max() < 1e-4
    jaw = head.unit_matrix(("jawOpen",))[0]
    assert np.abs(jaw[VERTICES:][:copies] - jaw[origin[VERTICES:]]).max() == 0
    texture = head.texture("neutral")
    at = head.uv[head.faces[head.facet_class == head.class_id("skin")]].mean(axis=1)
    seen = texture[(at[:, 1] * 63).astype(int), (at[:, 0] * texture.shape[1]).astype(int)]
    assert (seen == [200, 0, 0]).all(), "the face lies on the picture"
    teeth = head.uv[np.unique(facets_of(head, "upper_teeth"))]
    assert (teeth[:, 0] > 64 / texture.shape[1]).all(), "what was added lies beside it"


def test_a_corner_a_little_beyond_the_texture_makes_no_second_tile():
    one = np.array([[[0, 0], [1.002, 0], [0.5, 1]]], np.float32)
    assert np.allclose(tiled(one), [[[0, 0], [1, 0], [0.5, 1]]])
    two = np.concatenate([one, one + np.float32([1, 0])])
    assert np.allclose(tiled(two)[1], [[0.5, 0], [1, 0], [0.75, 1]])


def test_an_obj_counts_backwards_from_the_polygon_and_may_be_spaced_freely(tmp_path):
    shapes = tmp_path / "shapes"
    shapes.mkdir()
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "  vt 0 0", "vt 1 0", "vt 0 1", "f -3/-3 -2/-2 -1/-1"]
    more = ["v\t0 0 1", "\tv 1 0 1", "v 0 \\\n1 1", "vt 0.5 1", "f\t-3/-1 -2/-2 3/3"]
    (tmp_path / "head.OBJ").write_text("\n".join([*lines, "o\tteeth", *more]))
    (shapes / "jawOpen.OBJ").write_text("\n".join([*lines, *more]).replace("1 1", "1 5"))
    mesh = read_morphs(tmp_path / "head.OBJ", shapes)
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 2]]
    assert mesh.uv[1].tolist() == [[0.5, 0], [0, 0], [0, 0]]
    assert mesh.part_names == ("", "teeth")
    assert mesh.targets["jawOpen"].tolist() == [[0, 0, 0]] * 5 + [[0, 0, 4]]


@pytest.mark.parametrize("place", [-3, -4, -5])
def test_an_obj_that_counts_back_beyond_the_places_above_is_refused(tmp_path, place):
    above = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "vt 0.1 0.1", "vt 0.2 0.2"]
    below = [f"f 1/{place} 2/-1 3/-2", "vt 0.9 0.9", "vt 0.8 0.8"]
    (tmp_path / "head.obj").write_text("\n".join([*above, *below]))
    with pytest.raises(InputFileError, match=r"head\.obj has a wrong place on its texture"):
        read_obj(tmp_path / "head.obj", None)


def test_textures_of_nobody_are_refused(folder):
    told = table(HEAD) + '[textures]\nanna = "anna.png"\n'
    refused(ParameterError, "a texture but no shape of 'anna'", told=told, folder=folder)
    told = table(HEAD) + '[textures]\nneutral = "anna.png"\n'
    refused(ParameterError, "does not say where a texture lies", told=told, folder=folder)
