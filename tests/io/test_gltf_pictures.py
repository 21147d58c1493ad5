"""Pictures of glTF files lie where the file says, and those that cannot be read are named."""

from __future__ import annotations

import json

import numpy as np
import pytest
from test_gltf_heads import UV, told

from abs_engine.core.errors import InputFileError
from abs_engine.io.morphs import read_morphs

MOVED = "KHR_texture_transform"


def textured(folder, **change):
    """The mesh, once its material's texture has more to it."""

    def add(made):
        made["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].update(change)
        made["extensionsRequired"] = [MOVED]

    return read_morphs(told(folder, add))


@pytest.mark.parametrize(
    ("moved", "places"),
    [
        ({"scale": [0.5, 0.25]}, UV * [0.5, 0.25]),
        ({"scale": [0.5, 0.5], "offset": [0.25, 0.5]}, UV / 2 + [0.25, 0.5]),
        # A quarter turn against the clock, where v runs down
        ({"rotation": np.pi / 2, "offset": [0, 1]}, np.c_[UV[:, 1], 1 - UV[:, 0]]),
    ],
)
def test_a_picture_may_be_moved_on_its_mesh(tmp_path, moved, places):
    assert np.allclose(textured(tmp_path, extensions={MOVED: moved}).uv[0], places, atol=1e-6)


@pytest.mark.parametrize(
    "change", [{"texCoord": 1}, {"texCoord": 0, "extensions": {MOVED: {"texCoord": 1}}}]
)
def test_a_picture_lies_by_the_set_of_coordinates_that_it_names(tmp_path, change):
    path = told(tmp_path, lambda made: None)
    made = json.loads(path.read_text())
    attributes = made["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"]
    made["accessors"].append({"componentType": 5126, "count": 3, "type": "VEC2"})  # zeros
    attributes["TEXCOORD_0"] = len(made["accessors"]) - 1
    path.write_text(json.dumps(made))
    assert not read_morphs(path).uv.any()
    made["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].update(change)
    path.write_text(json.dumps(made))
    assert np.allclose(read_morphs(path).uv[0], UV)


def test_a_glossy_material_has_its_picture_or_its_colour(tmp_path):
    def glossy(**look):
        def change(made):
            name = "KHR_materials_pbrSpecularGlossiness"
            made["materials"] = [{"name": "skin", "extensions": {name: look}}]

        return read_morphs(told(tmp_path, change))

    assert (glossy(diffuseTexture={"index": 0}).texture == [255, 0, 0]).all()
    assert glossy(diffuseFactor=[1, 0, 0, 1]).texture is None, "of one colour it is painted"


def test_a_facet_beyond_the_picture_is_moved_to_it_as_a_whole(tmp_path):
    beyond = {MOVED: {"offset": [1, -2]}}
    assert np.allclose(textured(tmp_path, extensions=beyond).uv[0], UV)
    across = textured(tmp_path, extensions={MOVED: {"scale": [0.5, 0.5], "offset": [0.8, 0]}})
    assert np.allclose(across.uv[0, :, 0], [0, 0.3, 0]), "it ends at the edge that it crosses"


@pytest.mark.parametrize("name", ["EXT_texture_webp", "KHR_texture_basisu"])
def test_pictures_of_other_kinds_are_named(tmp_path, name):
    def change(made):
        made["textures"] = [{"extensions": {name: {"source": 0}}}]
        made["extensionsRequired"] = [name]

    with pytest.raises(InputFileError, match=rf"kept by {name}; export it with PNG or JPEG"):
        read_morphs(told(tmp_path, change))


def test_what_a_file_needs_and_is_not_read_is_named(tmp_path):
    path = told(tmp_path, lambda made: made.update(extensionsRequired=["ACME_faces"]))
    with pytest.raises(InputFileError, match="needs ACME_faces, which is not read"):
        read_morphs(path)
