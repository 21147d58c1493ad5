"""The bundled speaker, and model files that are wrong."""

from __future__ import annotations

import zipfile

import cv2
import numpy as np
import pytest
from runs import write_speaker

from abs_engine.core.camera import Camera
from abs_engine.core.errors import (
    InputFileError,
    MeshError,
    ModelFormatError,
    OutputError,
    ParameterError,
)
from abs_engine.core.geometry import FACING, Pose, vertex_normals
from abs_engine.core.scene import Candidates
from abs_engine.face.shape.mouth import mouth_units
from abs_engine.io.assets import load_speaker, read_image, shipped
from abs_engine.io.npz import read_npz, write_npz
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.start.blob_start import mouth_model

CLASSES = {
    "skin", "upper_lip", "lower_lip", "inner_mouth", "upper_teeth", "lower_teeth", "tongue", "eyes",
}  # fmt: skip


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


def test_every_class_has_facets(speaker):
    assert set(speaker.class_names[1:]) == CLASSES
    counts = np.bincount(speaker.facet_class, minlength=len(speaker.class_names))
    assert counts[0] == 0
    assert (counts[1:] > 20).all()


def test_a_person_who_is_not_there_has_no_texture(speaker):
    with pytest.raises(ParameterError, match="did you mean 'clara'"):
        speaker.texture("Clara")


def test_the_units_are_the_52_of_arkit(speaker):
    assert len(speaker.unit_names) == len(set(speaker.unit_names)) == 52
    assert set(mouth_units()) <= set(speaker.unit_names)
    assert {"eyeBlinkLeft", "browInnerUp", "cheekPuff", "tongueOut"} <= set(speaker.unit_names)
    assert speaker.units.shape == (52, len(speaker.vertices), 3)
    moved = np.linalg.norm(speaker.units.astype(float), axis=2).max(axis=1)
    assert (moved > 0.5).all(), "a unit moves nothing"


def test_sides_are_the_subjects_own(speaker):
    """x points to the subject's left."""
    for name in ("mouthSmile", "mouthDimple", "mouthUpperUp", "eyeBlink"):
        for side, sign in (("Left", 1), ("Right", -1)):
            delta = np.linalg.norm(speaker.unit_matrix((name + side,))[0].astype(float), axis=1)
            assert sign * (delta @ speaker.vertices[:, 0]) > 0


def test_the_jaw_opens_the_mouth(speaker):
    top, bottom = (speaker.landmarks["inner_lip_8"][k] for k in (2, 6))
    jaw = speaker.unit_matrix(("jawOpen",))[0]
    assert jaw[top, 1] - jaw[bottom, 1] > 10


PEOPLE = ["average", "clara", "kofi", "mei", "walter", "amara", "ravi"]


@pytest.mark.parametrize("person", PEOPLE)
def test_the_mouth_of_everybody_is_sealed_at_rest(speaker, person):
    """The upper lip comes down behind or before the lower one, by little."""
    vertices = speaker.vertices if person == "average" else speaker.named(person)
    top = vertices[speaker.landmarks["inner_lip_upper"]]
    bottom = vertices[speaker.landmarks["inner_lip_lower"]]
    order = np.argsort(bottom[:, 0])
    x = top[:, 0]
    under = np.interp(x, bottom[order, 0], bottom[order, 1])
    gap = top[:, 1] - under
    assert gap.max() < 0.1
    assert -1.0 < np.median(gap) < -0.5
    assert gap.min() > -1.3
    width = np.ptp(vertices[speaker.lip_ring, 0])
    assert 35 < width < 70


def test_a_facet_class_that_is_not_there_is_named(speaker):
    with pytest.raises(ParameterError, match="no facet class 'lip'; choose one of back"):
        speaker.vertices_of("lip")
    assert speaker.class_names[speaker.class_id("skin")] == "skin"


@pytest.mark.parametrize("person", PEOPLE[1:])
def test_no_light_falls_between_resting_lips(speaker, person):
    """Neither teeth nor the dark show from 15 degrees below to 15 above, but for a few pixels."""
    head = mouth_model(speaker, person).head
    mouth = head.mean[speaker.lip_ring].mean(axis=0).astype(float)
    camera = Camera(np.array([[3000, 0, 160], [0, 3000, 100], [0, 0, 1.0]]), (320, 200))
    inside = [speaker.class_id(n) for n in ("inner_mouth", "upper_teeth", "lower_teeth", "tongue")]
    for pitch in (-0.26, -0.13, 0.0, 0.13, 0.26):
        turned = Pose.from_vectors([pitch, 0, 0], np.zeros(3)).rotation @ FACING
        pose = Pose(turned, np.array([0, 0, 600.0]) - turned @ mouth)
        one = Candidates.one(np.zeros(0), pose)
        seen = CpuRenderer().draw(head, one, camera, camera.whole)[0].class_id
        assert np.isin(seen, inside).sum() < 25, pitch  # a square millimetre here


def test_facets_look_outwards(speaker):
    normals = vertex_normals(speaker.vertices.astype(float), speaker.faces)
    skin = np.unique(speaker.faces[speaker.facet_class == speaker.class_id("skin")])
    outwards = speaker.vertices[skin] - [0, 0, 0]
    assert ((normals[skin] * outwards).sum(axis=1) > 0).mean() > 0.8
    assert normals[speaker.landmarks["nose_tip"][0], 2] > 0.7


def test_the_lip_ring_goes_once_around(speaker):
    ring = speaker.vertices[speaker.lip_ring]
    x, y = (ring - ring.mean(axis=0))[:, :2].T
    turned = np.unwrap(np.arctan2(y, x))
    assert abs(turned[-1] - turned[0]) == pytest.approx(2 * np.pi, abs=0.6)
    steps = np.linalg.norm(np.diff(ring, axis=0, append=ring[:1]), axis=1)
    assert steps.max() < 8


def test_people_differ_and_have_a_texture(speaker):
    assert len(speaker.people) >= 3
    for name in speaker.people:
        assert speaker.texture(name).shape[2] == 3
    heads = [speaker.named(name) for name in speaker.people]
    for k, head in enumerate(heads):
        for other in heads[:k]:
            assert np.abs(head - other).max() > 3


def test_a_person_is_the_head_plus_its_targets(speaker):
    weights = speaker.identity_weights(mouth_scale_horiz_incr=0.5)
    assert np.count_nonzero(weights) == 1
    delta = speaker.identity[int(np.argmax(weights))].astype(np.float32)
    np.testing.assert_allclose(speaker.person(weights), speaker.vertices + 0.5 * delta, atol=1e-4)
    np.testing.assert_array_equal(speaker.person(0 * weights), speaker.vertices)


def test_nobody_of_that_name(speaker):
    with pytest.raises(ParameterError, match="choose one of"):
        speaker.named("nobody")


def test_another_version(tmp_path):
    with pytest.raises(ModelFormatError, match="version 99"):
        load_speaker(write_speaker(tmp_path / "head.npz", version=99))


def test_another_format(tmp_path):
    path = tmp_path / "some.npz"
    np.savez(path, vertices=np.zeros(3))
    with pytest.raises(ModelFormatError, match="unknown version 0"):
        load_speaker(path)


def test_an_array_that_is_missing(tmp_path):
    path = tmp_path / "head.npz"
    np.savez(path, format="abs_engine.speaker", version=1)
    with pytest.raises(ModelFormatError, match="lacks"):
        load_speaker(path)


def test_vertices_that_are_not_numbers(tmp_path, speaker):
    vertices = speaker.vertices.copy()
    vertices[7] = np.nan
    with pytest.raises(ModelFormatError, match="holds NaN or infinity"):
        load_speaker(write_speaker(tmp_path / "head.npz", vertices=vertices))


def test_a_mesh_without_area(tmp_path, speaker):
    with pytest.raises(MeshError, match="zero area"):
        load_speaker(write_speaker(tmp_path / "head.npz", vertices=0 * speaker.vertices))


def test_files_that_are_no_archive(tmp_path):
    with pytest.raises(InputFileError, match="does not exist"):
        read_npz(tmp_path / "none.npz", "k", 1)
    whole = shipped("speaker/head.npz").read_bytes()
    for name, content in (("empty", b""), ("text", b"head"), ("part", whole[: len(whole) // 2])):
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(InputFileError, match="not an NPZ"):
            read_npz(path, "k", 1)


def test_objects_are_not_unpickled(tmp_path):
    path = tmp_path / "head.npz"
    np.savez(path, format="k", version=1, code=np.array([{}], object))
    with pytest.raises(InputFileError, match="not an NPZ"):
        read_npz(path, "k", 1)


def test_what_is_written_is_read_with_its_kind_and_version(tmp_path):
    path = tmp_path / "k.npz"
    arrays = {"a": np.arange(6.0).reshape(2, 3), "n": 0.5, "text": "so", "names": ("x", "yy")}
    write_npz(path, "k", 3, arrays)
    read = read_npz(path, "k", 3)
    assert set(read) == {"format", "version", *arrays}
    np.testing.assert_array_equal(read["a"], arrays["a"])
    assert (float(read["n"]), str(read["text"]), read["names"].tolist()) == (0.5, "so", ["x", "yy"])
    with pytest.raises(ModelFormatError, match="k version 3, wanted k version 4; make it again"):
        read_npz(path, "k", 4)
    with pytest.raises(ModelFormatError, match="wanted j version 3; give a file of that kind"):
        read_npz(path, "j", 3)
    with pytest.raises(OutputError, match="exists already"):
        write_npz(path, "k", 3, arrays)
    with pytest.raises(TypeError, match="code is neither"):
        write_npz(tmp_path / "o.npz", "k", 3, {"code": np.array([{}], object)})
    for taken in ("format", "version", "file", "allow_pickle"):
        with pytest.raises(ValueError, match=f"can be called '{taken}'"):
            write_npz(tmp_path / "o.npz", "k", 3, arrays | {taken: 1})
    assert [p.name for p in tmp_path.iterdir()] == ["k.npz"]


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"format": "k", "version": "x"}, "is k version unknown"),
        ({"format": "k", "version": "1"}, "is k version unknown"),
        ({"format": "k", "version": 1.5}, "is k version unknown"),
        ({"format": "k", "version": 1 + 0j}, "is k version unknown"),
        ({"format": "k", "version": [1, 2]}, "is k version unknown"),
        ({"format": "k", "version": []}, "is k version unknown"),
        ({"format": "k"}, "is k version 0"),
        ({"format": ["k", "k"], "version": 1}, "is unknown version 1"),
        ({"format": 3, "version": 1}, "is unknown version 1"),
        ({"format": "k\nk", "version": 1}, "is unknown version 1"),
    ],
)
def test_formats_and_versions_that_are_none_are_refused_by_name(tmp_path, told, said):
    np.savez(tmp_path / "k.npz", **told)
    with pytest.raises(ModelFormatError, match=f"{said}, wanted k version 1") as caught:
        read_npz(tmp_path / "k.npz", "k", 1)
    assert "\n" not in str(caught.value)


def test_what_is_no_array_in_an_archive_is_one_of_bytes(tmp_path):
    with zipfile.ZipFile(tmp_path / "k.npz", "w") as archive:
        archive.writestr("format", "k")
        archive.writestr("version", "1")
    with pytest.raises(ModelFormatError, match="unknown version unknown"):
        read_npz(tmp_path / "k.npz", "k", 1)


def test_pictures(tmp_path):
    picture = np.zeros((4, 5, 3), np.uint8)
    picture[1, 2] = 10, 20, 30
    cv2.imwrite(str(tmp_path / "p.png"), picture[..., ::-1])
    np.testing.assert_array_equal(read_image(tmp_path / "p.png"), picture)
    (tmp_path / "t.png").write_text("no")
    for name, said in (("t.png", "not a readable picture"), ("none.png", "does not exist; check")):
        with pytest.raises(InputFileError, match=said):
            read_image(tmp_path / name)


def test_a_shipped_file_that_is_missing():
    with pytest.raises(InputFileError, match="install abs-engine again"):
        shipped("speaker/none.npz")
