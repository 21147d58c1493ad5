"""Heads as other programs would write them: GLB and OBJ files of the bundled head's parts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pygltflib as gl
from numpy.typing import NDArray

from abs_engine.io.assets import Speaker, load_speaker

PARTS = {
    "Head": ("skin",),
    "Lips": ("upper_lip", "lower_lip"),
    "Mouth_inside": ("inner_mouth",),
    "Teeth": ("upper_teeth", "lower_teeth"),
    "Tongue": ("tongue",),
    "Eyes": ("eyes",),
}
"""Materials of the written heads, by the facet classes of the bundled one."""
FEW = ("jawOpen", "mouthClose", "mouthFunnel", "mouthPucker", "mouthSmileLeft", "mouthSmileRight",
       "mouthUpperUpLeft", "mouthUpperUpRight", "mouthLowerDownLeft", "mouthLowerDownRight",
       "eyeBlinkLeft", "eyeBlinkRight", "browInnerUp")  # fmt: skip
"""Face units that the written heads have."""


OUTER_CLASSES = ("skin", "upper_lip", "lower_lip", "eyes")


def facets_of(head: Speaker, *names: str) -> NDArray[np.int32]:
    """Facets (F, 3) of some classes."""
    ids = [head.class_id(name) for name in names]
    return head.faces[np.isin(head.facet_class, ids)]


def table(head: Speaker, marks: dict[str, list[object]] | None = None, more: str = "") -> str:
    """The TOML table that names a head's landmarks by its vertices."""
    own = head.landmarks
    found = {
        "outer_lip": own["outer_lip_20"].tolist(), "inner_lip": own["inner_lip_8"].tolist(),
        "nose_tip": own["nose_tip"].tolist(), "chin": own["chin"].tolist(),
        "eye_corners": own["eye_corners"].tolist(),
    } | (marks or {})  # fmt: skip
    return more + "[landmarks]\n" + "".join(f"{name} = {at}\n" for name, at in found.items())


def write_obj(path: Path, vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> Path:
    """Write an OBJ."""
    rows = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices.tolist()]
    rows += ["f " + " ".join(str(n + 1) for n in face) for face in faces.tolist()]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


class _Buffer:
    """Arrays one behind the other."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.views: list[gl.BufferView] = []
        self.accessors: list[gl.Accessor] = []

    def add(self, values: NDArray[np.generic], columns: int) -> int:
        """Append float32 or uint32 values; the accessor's number."""
        kinds = {1: gl.SCALAR, 3: gl.VEC3}
        self.views.append(
            gl.BufferView(buffer=0, byteOffset=len(self.content), byteLength=values.nbytes)
        )
        whole = values.dtype == np.uint32
        self.accessors.append(
            gl.Accessor(
                bufferView=len(self.views) - 1,
                count=values.size // columns,
                type=kinds[columns],
                componentType=gl.UNSIGNED_INT if whole else gl.FLOAT,
            )
        )
        self.content += values.tobytes()
        return len(self.accessors) - 1


def write_glb(
    path: Path,
    parts: Sequence[str] = ("Head", "Lips", "Eyes"),
    units: Sequence[str] = FEW,
    short: str = "",
    head: Speaker | None = None,
) -> Path:
    """Write the bundled head in metres, z up, moved aside by its node; each part a material.

    Of the target `short`, vertices are missing. All vertices are written, used or not.
    """
    head = load_speaker() if head is None else head
    buffer = _Buffer()

    def lying(values: NDArray[np.floating]) -> NDArray[np.float32]:
        """In metres, with z up and the face looking along -y."""
        return np.ascontiguousarray(
            (values.astype(np.float64) * 1e-3)[:, [0, 2, 1]] * [1, -1, 1], np.float32
        )

    place = buffer.add(lying(head.vertices), 3)
    targets = []
    for name in units:
        moved = lying(head.unit_matrix((name,))[0])
        targets.append(
            gl.Attributes(POSITION=buffer.add(moved[: -5 if name == short else None], 3))
        )
    primitives = [
        gl.Primitive(
            attributes=gl.Attributes(POSITION=place),
            material=k,
            targets=targets,
            indices=buffer.add(facets_of(head, *PARTS[part]).astype(np.uint32).ravel(), 1),
        )
        for k, part in enumerate(parts)
    ]
    mesh = gl.Mesh(primitives=primitives, extras={"targetNames": list(units)})
    document = gl.GLTF2(
        scene=0, scenes=[gl.Scene(nodes=[0])],
        nodes=[gl.Node(mesh=0, translation=[0.0, 1.7, 0.2])], meshes=[mesh],
        materials=[gl.Material(name=part) for part in parts],
        accessors=buffer.accessors, bufferViews=buffer.views,
        buffers=[gl.Buffer(byteLength=len(buffer.content))],
    )  # fmt: skip
    document.set_binary_blob(bytes(buffer.content))
    document.save_binary(str(path))
    return path
