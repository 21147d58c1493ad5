"""The file of a talking face: everything comes back bit for bit, and a bad file is named."""

from __future__ import annotations

from dataclasses import astuple, fields, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import shapes
from talkers import CAMERA, PARAMETERS, POSE, RENDERER, learned_face

from abs_engine.core.errors import InputFileError, ModelFormatError, OutputError, ParameterError
from abs_engine.core.scene import Candidates, Scene
from abs_engine.face.appearance.region import part
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.face.talking import MODELS, TalkingFace, as_face, shape_as_face
from abs_engine.face.talking_file import StoredTalker, load_talking, save_talking
from abs_engine.fit.talking import talking_problem
from abs_engine.io.npz import write_npz

FACE = "face.npz"
NOISES = {"tex_noise", "tex_observations", "la_own_share"}


@pytest.fixture(scope="module")
def face() -> TalkingFace:
    return learned_face()


@pytest.fixture(scope="module")
def path(face: TalkingFace, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("talking") / FACE
    save_talking(made, face, "clara", "0123456789abcdef")
    return made


@pytest.fixture(scope="module")
def whole(path: Path) -> dict[str, np.ndarray]:
    """The arrays of the file."""
    with np.load(path) as archive:
        return dict(archive)


def same(one: object, two: object, where: str = "face") -> None:
    """Check that two values are of the same kind and hold the same, bit for bit."""
    assert type(one) is type(two), where
    if is_dataclass(one):
        for field in fields(one):
            same(getattr(one, field.name), getattr(two, field.name), f"{where}.{field.name}")
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (two.dtype, two.shape), where
        assert one.tobytes() == two.tobytes(), where
    elif isinstance(one, dict):
        assert list(one) == list(two), where
        for key in one:
            same(one[key], two[key], f"{where}.{key}")
    else:
        assert one == two, where


def _told(found: StoredTalker) -> tuple[str, str]:
    return found.person, found.speaker


def test_everything_comes_back_bit_for_bit(face, path):
    back = load_talking(path)
    same(back.face, face)
    assert _told(back) == ("clara", "0123456789abcdef")
    same(as_face(back.face).body, as_face(face).body)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("pose_known", [True, False])
def test_a_picture_costs_exactly_the_same(face, path, name, pose_known):
    alpha = np.array([0.4, -0.7])
    one = Candidates.one(alpha, POSE)
    picture = RENDERER.draw(face.shape.scene, one, CAMERA, CAMERA.whole)[0].rgb
    values = []
    for own in (face, load_talking(path).face):
        start = own.shape.neutral
        asked = talking_problem(
            own, name, picture, CAMERA, POSE, start, RENDERER, pose_known=pose_known
        )
        x = start if pose_known else np.concatenate([np.full(6, 1e-3), start])
        values.append([asked(x).value, asked(x + 0.1).value])
    assert values[0] == values[1]
    assert values[0][0] != values[0][1]


def test_a_shape_comes_back_without_appearance(face, tmp_path):
    neutral = face.shape.scene.mean + np.float32(0.25)
    save_talking(tmp_path / FACE, face.shape, "me", "", neutral)
    back = load_talking(tmp_path / FACE)
    assert back.face is None
    same(back.shape, face.shape)
    same(back.neutral, neutral)
    assert shape_as_face(back.shape).appearance == {}


def test_a_head_at_rest_of_another_mesh_is_refused(face, tmp_path):
    with pytest.raises(ParameterError, match="other vertices"):
        save_talking(tmp_path / FACE, face, "me", "", face.shape.scene.mean[:-1])
    assert not (tmp_path / FACE).exists()


def test_noise_is_measured_and_compared_by(face):
    looks = as_face(face).appearance
    found = looks["texture"].noise, looks["texture"].observations, looks["local"].own_share
    assert found == astuple(face.noises)
    assert 0 < face.noises.tex_noise < 0.05
    assert 1 < face.noises.tex_observations < 1000
    assert face.noises.la_own_share in APPEARANCE.alone_tried


def test_a_file_of_an_earlier_version_has_the_noise_of_then(face, whole, tmp_path):
    earlier = {name: values for name, values in whole.items() if name not in NOISES}
    np.savez(tmp_path / FACE, **earlier)
    back = load_talking(tmp_path / FACE).face
    same(replace(back, noises=face.noises), face)
    looks = as_face(back).appearance
    assert (looks["local"].own_share, looks["texture"].observations) == (APPEARANCE.alone, 0)
    spread = face.tex_lin.leftover.spread
    assert looks["texture"].noise == pytest.approx(np.sqrt(np.mean(spread**2)))
    save_talking(tmp_path / "again.npz", back, "clara", "")
    assert load_talking(tmp_path / "again.npz").face.noises is None


def test_parts_and_constant_models_are_not_stored_twice(whole):
    assert not {name for name in whole if name.startswith(("tex_cst.", "la_cst."))}
    assert whole["surface"].dtype == whole["outer"].dtype == np.bool_
    assert whole["tex_lin.modes"].dtype == np.float32


def test_other_constant_models_are_stored(face, tmp_path):
    tex, la = (model.constant() for model in (face.tex_lin, face.la_lin))
    other = replace(
        face, tex_cst=replace(tex, base=tex.base + 1), la_cst=replace(la, base=la.base + 1)
    )
    save_talking(tmp_path / FACE, other, "clara", "")
    same(load_talking(tmp_path / FACE).face, other)


def test_a_texture_that_depends_on_the_head_s_weights_is_stored(face, tmp_path):
    shape = face.shape
    layers = np.ones((PARAMETERS, *shape.scene.texture.shape), np.float32)
    own = {n: replace(getattr(shape, n), texture_modes=layers) for n in ("scene", "surface")}
    other = replace(face, shape=replace(shape, outer=replace(shape.outer, texture_modes=layers),
                                        **own))  # fmt: skip
    save_talking(tmp_path / FACE, other, "clara", "")
    same(load_talking(tmp_path / FACE).face, other)


def test_facets_that_look_alike_are_told_apart_by_their_order(face, tmp_path):
    """A facet that a head has twice is in a part once, or twice."""
    scene = face.shape.scene
    faces, classes = (np.concatenate([a, a[-5:]]) for a in (scene.faces, scene.facet_class))
    twice = replace(scene, faces=faces, facet_class=classes)
    every = np.ones(len(faces), np.bool_)
    outer, kept = part(twice, every)
    once = part(twice, np.arange(len(faces)) < len(faces) - 5)[0]
    shape = replace(face.shape, scene=twice, surface=once, outer=outer, kept=kept)
    save_talking(tmp_path / FACE, replace(face, shape=shape), "clara", "")
    same(load_talking(tmp_path / FACE).face.shape, shape)


def _moved(scene: Scene) -> Scene:
    return replace(scene, mean=scene.mean + np.float32(1))


REFUSED = {
    "not a part of its head": lambda f: {
        "shape": replace(f.shape, surface=_moved(f.shape.surface))
    },
    "is not a part": lambda f: {"shape": replace(f.shape, outer=shapes.ball(shapes.LARGE, 1))},
    "not finite": lambda f: {"la_scale": np.nan},
    "has no region": lambda f: {"shape": replace(f.shape, regions=(None, "skin"))},
}


@pytest.mark.parametrize("why", REFUSED)
def test_a_face_that_could_not_be_read_is_not_written(face, tmp_path, why):
    wrong = replace(face, **REFUSED[why](face))
    with pytest.raises(ParameterError, match=why):
        save_talking(tmp_path / FACE, wrong, "clara", "")
    assert not list(tmp_path.iterdir())


def test_a_face_needs_a_name_and_nothing_is_written_over(face, path, tmp_path):
    with pytest.raises(ParameterError, match="empty name"):
        save_talking(tmp_path / FACE, face, "", "")
    with pytest.raises(OutputError, match="exists already"):
        save_talking(path, face, "clara", "")


def _refused(folder: Path, arrays: dict[str, object]) -> ModelFormatError:
    bad = folder / "bad.npz"
    np.savez(bad, **arrays)
    with pytest.raises(ModelFormatError) as raised:
        load_talking(bad)
    assert "bad.npz" in raised.value.problem
    assert "\n" not in str(raised.value)
    assert raised.value.remedy
    return raised.value


def test_another_version_or_format_is_named(whole, tmp_path):
    assert "version 9, wanted" in str(_refused(tmp_path, whole | {"version": 9}))
    other = _refused(tmp_path, whole | {"format": "abs_engine.texture"})
    assert "abs_engine.texture version 1, wanted abs_engine.talking_face" in str(other)


def test_every_missing_array_is_named(whole, tmp_path):
    for name in whole.keys() - {"format", "version"}:
        rest = {key: values for key, values in whole.items() if key != name}
        told = str(_refused(tmp_path, rest))
        assert name in told or name.startswith("rings."), name


def test_every_number_that_is_not_finite_is_named(whole, tmp_path):
    floats = [name for name, values in whole.items() if values.dtype.kind == "f"]
    assert len(floats) > 30
    for name in floats:
        for wrong in (np.nan, np.inf):
            values = whole[name].copy()
            if values.size:
                values.flat[-1] = wrong
                told = str(_refused(tmp_path, whole | {name: values}))
                assert f"'{name}' holds what is not finite" in told


SHORTER = {"marks", "lips", "scene.texture", "tex_lin.common", "la_lin.left_out"}
"""Arrays that may have one row less, beside the lips' contours."""
NONE = {"tex_lin.common", "tex_lin.modes"}
"""Arrays that may have no row at all."""


def test_every_array_of_another_shape_is_refused(whole, tmp_path):
    for name, values in whole.items():
        if values.ndim == 0 or not values.size:
            continue
        wrong = [values[None], values.astype("S")]
        wrong += [] if name in NONE else [values[:0]]
        wrong += [] if name in SHORTER or name.startswith("rings.") else [values[:-1]]
        for changed in wrong:
            _refused(tmp_path, whole | {name: changed})


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("vertices", 10**6, "vertices are not one for each point"),
        ("lips", 20, "points of the lips"),
        ("marks", -1, "marks are not on the head"),
        ("rings.upper", 10**6, "contours are not on the part"),
        ("la_lin.vertices", 10**6, "points of local appearance are not on"),
        ("scene.faces", 10**6, "not a complete talking face"),
        ("scene.facet_class", 7, "a facet has no region"),
        ("penalty.softness", -1, "the penalty is not positive"),
        ("la_scale", 0, "scale of local appearance is not positive"),
        ("tex_noise", 0, "noise of the appearance is not positive"),
        ("la_own_share", 1.1, "a share is above 1"),
        ("spec.lower", 100, "a bound is empty"),
    ],
)
def test_numbers_that_cannot_be_are_told(whole, tmp_path, name, value, why):
    values = whole[name].copy()
    values.flat[-1] = value
    assert why in str(_refused(tmp_path, whole | {name: values}))


def test_indices_that_are_no_integers_are_refused(whole, tmp_path):
    for name in ("vertices", "la_lin.vertices", "scene.faces", "rings.outer", "surface"):
        told = str(_refused(tmp_path, whole | {name: whole[name].astype(np.float64)}))
        assert f"'{name}' holds float64" in told


def test_what_is_no_archive_or_another_file_is_named(face, tmp_path):
    (tmp_path / "text.npz").write_text("no")
    for name in ("text.npz", "none.npz"):
        with pytest.raises(InputFileError, match=name):
            load_talking(tmp_path / name)
    write_npz(tmp_path / "local.npz", "abs_engine.local", 2, face.la_lin.arrays())
    with pytest.raises(ModelFormatError, match=r"abs_engine\.local version 2, wanted"):
        load_talking(tmp_path / "local.npz")


def test_text_that_is_no_json_is_refused(whole, tmp_path):
    for wrong in ("{", "[]", '{"predictors": [{}], "groups": {}}', '{"predictors": 3}'):
        assert "not a complete" in str(_refused(tmp_path, whole | {"model.told": wrong}))
