"""Small glTF files as exporters write them: sparse targets, interleaved rows, pictures, nodes."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import cv2
import numpy as np
import pygltflib as gl
import pytest

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.io.morphs import read_morphs
from abs_engine.io.morphs.gltf import _facets
from abs_engine.io.morphs.gltf_arrays import GltfArrays
from abs_engine.io.morphs.gltf_file import GltfFile

FLOAT, SHORT = 5126, 5123
PLACES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
UV = np.array([[0, 0], [1, 0], [0.25, 1]], np.float32)


def document(extra=None, node=None):
    """A triangle with a sparse target, its places and texture coordinates interleaved."""
    red = cv2.imencode(".png", np.full((4, 4, 3), (0, 0, 255), np.uint8))[1].tobytes()
    pieces = [
        np.hstack([PLACES, UV]).tobytes(),  # rows of 20 bytes
        np.array([0, 1, 2, 0], np.uint16).tobytes(),
        np.array([2, 0], np.uint16).tobytes(),  # the vertex that moves
        np.array([0, 0, 0.5], np.float32).tobytes(),
        red,
    ]
    starts = np.cumsum([0, *map(len, pieces)]).tolist()
    views = [
        {"buffer": 0, "byteOffset": s, "byteLength": len(p)}
        for s, p in zip(starts, pieces, strict=False)
    ]
    views[0]["byteStride"] = 20
    sparse = {"count": 1, "indices": {"bufferView": 2, "componentType": SHORT},
              "values": {"bufferView": 3}}  # fmt: skip
    made = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [2, 2, 2]}, {"mesh": 0, **(node or {})}],
        "meshes": [{
            "primitives": [{
                "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0,
                "targets": [{"POSITION": 3}],
            }],
            "extras": {"targetNames": ["jawOpen"]},
        }],
        "materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": FLOAT, "count": 3, "type": "VEC3"},
            {"bufferView": 0, "byteOffset": 12, "componentType": FLOAT, "count": 3, "type": "VEC2"},
            {"bufferView": 1, "componentType": SHORT, "count": 3, "type": "SCALAR"},
            {"componentType": FLOAT, "count": 3, "type": "VEC3", "sparse": sparse},
        ],
        "bufferViews": views,
    }  # fmt: skip
    return {**made, **(extra or {})}, b"".join(pieces)


def write(folder, extra=None, node=None, cut=None):
    """Write it as a glTF file with its numbers beside it."""
    made, content = document(extra, node)
    made["buffers"] = [{"byteLength": len(content), "uri": "head.bin"}]
    (folder / "head.bin").write_bytes(content[:cut])
    (folder / "head.gltf").write_text(json.dumps(made))
    return folder / "head.gltf"


def test_what_a_file_holds_is_read(tmp_path):
    turned = {"rotation": [0, 0, np.sqrt(0.5), np.sqrt(0.5)], "translation": [0, 0, 3]}
    mesh = read_morphs(write(tmp_path, node=turned))
    assert np.allclose(mesh.vertices, [[0, 0, 6], [0, 2, 6], [-2, 0, 6]], atol=1e-6)
    assert np.allclose(mesh.targets["jawOpen"], [[0, 0, 0], [0, 0, 0], [0, 0, 1]], atol=1e-6)
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert "skin" in mesh.part_names[0]
    assert (mesh.texture == [255, 0, 0]).all()
    assert np.allclose(mesh.uv[0], UV)


def test_bytes_that_stand_for_shares_go_from_minus_one_to_one():
    numbers, path = np.array([-128, -127, 0, 127], np.int8), Path("head.glb")
    shares = gl.Accessor(
        bufferView=0, componentType=gl.BYTE, count=4, type=gl.SCALAR, normalized=True
    )
    view, buffer = gl.BufferView(buffer=0, byteLength=4), gl.Buffer(byteLength=4)
    document = gl.GLTF2(accessors=[shares], bufferViews=[view], buffers=[buffer])
    arrays = GltfArrays(path, GltfFile(path, document, numbers.tobytes()))
    assert arrays.read(0).ravel().tolist() == [-1, -1, 0, 1]


def test_a_node_that_mirrors_turns_its_facets_round(tmp_path):
    assert read_morphs(write(tmp_path, node={"scale": [-1, 1, 1]})).faces.tolist() == [[2, 1, 0]]


@pytest.mark.parametrize(
    ("extra", "cut", "says"),
    [
        ({"meshes": []}, None, "no whole glTF"),
        ({"nodes": [{}]}, None, "no triangles"),
        ({}, 40, "no whole glTF"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, None, "compressed by KHR_draco"),
        ({"accessors": []}, None, "no whole glTF"),
    ],
)
def test_damaged_files_are_refused(tmp_path, extra, cut, says):
    with pytest.raises(InputFileError, match=says):
        read_morphs(write(tmp_path, extra, cut=cut))


def compress(made):
    del made["accessors"][0]["bufferView"]
    made["extensionsUsed"] = ["KHR_draco_mesh_compression"]
    made["meshes"][0]["primitives"][0]["extensions"] = {
        "KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}
    }


def test_a_compressed_mesh_is_refused_where_the_file_does_not_require_it(tmp_path):
    with pytest.raises(InputFileError, match="is compressed by KHR_draco_mesh_compression"):
        read_morphs(told(tmp_path, compress))


def test_a_mesh_beside_its_compressed_copy_is_read(tmp_path):
    def change(made):
        compress(made)
        made["accessors"][0]["bufferView"] = 0

    assert np.ptp(read_morphs(told(tmp_path, change)).vertices, axis=0).tolist() == [2, 2, 0]


def twice(places):
    """A change that gives a target of the same name a second time, with these places."""

    def change(made):
        primitive = made["meshes"][0]["primitives"][0]
        primitive["targets"].append({"POSITION": places})
        made["meshes"][0]["extras"]["targetNames"] *= 2

    return change


@pytest.mark.parametrize("note", ["by hand", [1, 2], 7, None])
def test_notes_of_any_kind_stand_in_a_file(tmp_path, note):
    """`extras` may be any JSON (glTF 2.0, 3.2)."""

    def change(made):
        primitive = made["meshes"][0]["primitives"][0]
        primitive["extras"] = made["meshes"][0].pop("extras")
        for holder in (made, made["asset"], made["meshes"][0], *made["nodes"], *made["materials"]):
            holder["extras"] = note

    assert list(read_morphs(told(tmp_path, change)).targets) == ["jawOpen"]


@pytest.mark.parametrize("names", ["jawOpen", {"jawOpen": 0}])
def test_names_that_are_no_list_name_nothing(tmp_path, names):
    def change(made):
        made["meshes"][0]["extras"]["targetNames"] = names

    assert list(read_morphs(told(tmp_path, change)).targets) == ["target 0"]


@pytest.mark.parametrize(
    ("mode", "corners", "faces"),
    [(4, [0, 1, 2, 2, 1, 3], [[0, 1, 2], [2, 1, 3]]), (5, [0, 1, 2, 3], [[0, 1, 2], [1, 3, 2]]),
     (5, [0, 1, 2, 2, 3, 3, 2, 1], [[0, 1, 2], [3, 1, 2]]),
     (6, [0, 1, 2, 3], [[1, 2, 0], [2, 3, 0]]), (5, [0, 1], []), (6, [], [])],
)  # fmt: skip
def test_triangles_may_be_strips_or_fans(mode, corners, faces):
    assert _facets(np.array(corners, np.int64), mode).tolist() == faces


def test_a_strip_is_read_as_triangles(tmp_path):
    def change(made):
        made["meshes"][0]["primitives"][0]["mode"] = 5

    assert read_morphs(told(tmp_path, change)).faces.tolist() == [[0, 1, 2]]


def test_a_target_that_a_mesh_has_twice_moves_it_once(tmp_path):
    once = read_morphs(write(tmp_path)).targets["jawOpen"]
    assert np.abs(once).max() == 1
    assert np.array_equal(read_morphs(told(tmp_path, twice(3))).targets["jawOpen"], once)


def test_targets_of_one_name_that_differ_are_refused(tmp_path):
    with pytest.raises(ModelFormatError, match="of one mesh are called 'jawOpen', and differ"):
        read_morphs(told(tmp_path, twice(0)))


def test_a_missing_buffer_is_refused(tmp_path):
    path = write(tmp_path)
    (tmp_path / "head.bin").unlink()
    with pytest.raises(InputFileError, match=r"head\.bin does not exist"):
        read_morphs(path)


def told(folder, change):
    """Write the file with a change of what its JSON says."""
    path = write(folder)
    made = json.loads(path.read_text())
    change(made)
    path.write_text(json.dumps(made))
    return path


@pytest.mark.parametrize(
    "change",
    [
        lambda made: made["nodes"][1].update(children=[0]),
        lambda made: made["nodes"][0].update(children=[1, 1]),
        lambda made: made["accessors"][3].update(count=-1),
        lambda made: made["bufferViews"][0].update(byteOffset=-1),
        lambda made: made["bufferViews"][0].update(byteLength=10**6),
        lambda made: made["accessors"][2].update(componentType=FLOAT),
        lambda made: made["accessors"][1].update(count=2),
        lambda made: made["nodes"][1].update(translation=[float("nan"), 0, 0]),
        lambda made: made["buffers"][0].update(uri="data:,text"),
    ],
)
def test_files_that_mean_harm_are_refused(tmp_path, change):
    (tmp_path / "head.bin").write_bytes(document()[1])
    folder = tmp_path / "own"
    folder.mkdir()
    with pytest.raises(InputFileError, match="no whole glTF"):
        read_morphs(told(folder, change))


@pytest.mark.parametrize("uri", ["/dev/zero", "../head.bin", "http://x.org/head.bin"])
def test_files_that_lie_elsewhere_are_named(tmp_path, uri):
    with pytest.raises(InputFileError, match=f"names '{uri}'; files that it names must lie beside"):
        read_morphs(told(tmp_path, lambda made: made["buffers"][0].update(uri=uri)))


@pytest.mark.parametrize("count", [10**10, 1 << 25])
def test_numbers_that_would_fill_the_memory_are_refused(tmp_path, count):
    with pytest.raises(InputFileError, match="more than 34 million numbers"):
        read_morphs(told(tmp_path, lambda made: made["accessors"][3].update(count=count)))


def test_a_head_of_too_many_parts_is_refused(tmp_path):
    def change(made):
        made["meshes"][0]["primitives"] *= 257

    with pytest.raises(InputFileError, match="more than 256 parts"):
        read_morphs(told(tmp_path, change))


def test_a_mesh_that_stands_at_several_places_is_there_several_times(tmp_path):
    def change(made):
        del made["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]
        made["nodes"] = [{"children": [1, 2, 3, 4]}]
        made["nodes"] += [{"mesh": 0, "translation": [10 * k, 0, 0]} for k in range(4)]

    mesh = read_morphs(told(tmp_path, change))
    assert np.allclose(mesh.vertices[::3, 0], [0, 10, 20, 30])
    assert mesh.faces.max() == 11


def test_numbers_may_lie_in_the_text_or_beside_it_by_an_escaped_name(tmp_path):
    content = document()[1]
    inside = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    (tmp_path / "my head.bin").write_bytes(content)
    for uri in (inside, "my%20head.bin"):
        mesh = read_morphs(told(tmp_path, lambda made, uri=uri: made["buffers"][0].update(uri=uri)))
        assert mesh.faces.tolist() == [[0, 1, 2]]
