"""Meshes of glTF files that hang on bones, and names of morph targets in other places."""

from __future__ import annotations

import base64

import numpy as np
from test_gltf_heads import PLACES, told

from abs_engine.io.morphs import read_morphs


def skinned(folder, joints, weights, bound=None, **node):
    """The mesh on two joints, of which the second is turned and lies beside the first."""
    bound = np.tile(np.eye(4), (2, 1, 1)) if bound is None else bound
    pieces = [
        np.array(joints, np.uint8).tobytes(), np.array(weights, np.float32).tobytes(),
        np.array(bound, np.float32).transpose(0, 2, 1).tobytes(),
    ]  # fmt: skip

    def change(made):
        quarter = [0, 0, np.sqrt(0.5), np.sqrt(0.5)]
        made["nodes"] = [{"children": [1, 2, 3]}, {"mesh": 0, "skin": 0, **node},
                         {"translation": [0, 0, 1]},
                         {"translation": [5, 0, 0], "rotation": quarter}]  # fmt: skip
        first = len(made["accessors"])
        made["skins"] = [{"joints": [2, 3], "inverseBindMatrices": first + 2}]
        for piece, kind, count, shape in zip(
            pieces, (5121, 5126, 5126), (3, 3, 2), ("VEC4", "VEC4", "MAT4"), strict=True
        ):
            made["accessors"].append({"componentType": kind, "count": count, "type": shape,
                                      "bufferView": len(made["bufferViews"])})  # fmt: skip
            uri = "data:application/octet-stream;base64," + base64.b64encode(piece).decode()
            made["bufferViews"].append({"buffer": len(made["buffers"]), "byteLength": len(piece)})
            made["buffers"].append({"byteLength": len(piece), "uri": uri})
        own = made["meshes"][0]["primitives"][0]["attributes"]
        own |= {"JOINTS_0": first, "WEIGHTS_0": first + 1}

    return read_morphs(told(folder, change))


def test_a_mesh_goes_with_its_joints_and_not_with_its_node(tmp_path):
    joints = [[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]]
    mesh = skinned(tmp_path, joints, [[1, 0, 0, 0]] * 3, translation=[0, 1.5, 0], scale=[9, 9, 9])
    assert np.allclose(mesh.vertices, [[0, 0, 1], [1, 0, 1], [4, 0, 0]], atol=1e-6)
    assert np.allclose(mesh.targets["jawOpen"][2], [0, 0, 0.5], atol=1e-6)


def test_joints_share_a_vertex_by_weights_that_need_not_be_whole(tmp_path):
    mesh = skinned(tmp_path, [[0, 1, 0, 0]] * 3, [[2, 2, 0, 0]] * 3)
    first, second = (
        PLACES + np.array([0, 0, 1]),
        np.c_[5 - PLACES[:, 1], PLACES[:, 0], PLACES[:, 2]],
    )
    assert np.allclose(mesh.vertices, (first + second) / 2, atol=1e-6)


def test_joints_that_stand_as_they_were_bound_leave_the_mesh_where_it_is(tmp_path):
    first, second = np.eye(4), np.eye(4)
    first[2, 3] = 1
    second[:3, :] = [[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0]]
    bound = np.linalg.inv([first, second])
    mesh = skinned(tmp_path, [[0, 1, 0, 0]] * 3, [[0.5, 0.5, 0, 0]] * 3, bound)
    assert np.allclose(mesh.vertices, PLACES, atol=1e-6)


def test_names_of_targets_may_stand_at_the_primitive(tmp_path):
    def change(made):
        made["meshes"][0]["primitives"][0]["extras"] = made["meshes"][0].pop("extras")

    assert list(read_morphs(told(tmp_path, change)).targets) == ["jawOpen"]
