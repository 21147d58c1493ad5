"""Draws one scene with pyrender, in a process of its own (see `render/test_against_pyrender.py`).

Two GL stacks in one process corrupt each other, so this imports nothing of abs_engine.
Usage: pyrender_worker.py IN.npz OUT.npz
"""

from __future__ import annotations

import sys

import numpy as np
import pyrender
from OpenGL.plugins import FormatHandler

# Multisampled buffers hold depths of places beside the pixels' centres by NVIDIA's driver.
STORAGE = pyrender.renderer.glRenderbufferStorageMultisample
pyrender.renderer.glRenderbufferStorageMultisample = lambda target, _, *form: STORAGE(
    target, 0, *form
)

# PyOpenGL 3.1.0, which pyrender pins, does not know the kind of `byref` of Python 3.12.
FormatHandler.by_name("ctypesparameter").check.append("_ctypes.CArgObject")


def main(source: str, target: str) -> None:
    """Facet ids and depth, without multisampling: pyrender's segmentation of a node per facet."""
    given = np.load(source)
    width, height = (int(n) for n in given["size"])
    matrix = given["matrix"]
    scene = pyrender.Scene()
    colours = {}
    for i, facet in enumerate(given["faces"], start=1):
        # The camera frame: OpenCV's y and z turned round, as OpenGL has them.
        corners = given["vertices"][facet] * [1, -1, -1]
        primitive = pyrender.Primitive(
            positions=corners.astype(np.float32), indices=np.array([[0, 1, 2]], np.uint32)
        )
        node = scene.add(pyrender.Mesh([primitive]))
        colours[node] = (i % 256, i // 256, 0)
    camera = pyrender.IntrinsicsCamera(  # its pixel centres are at halves
        matrix[0, 0],
        matrix[1, 1],
        matrix[0, 2] + 0.5,
        matrix[1, 2] + 0.5,
        znear=float(given["near"]),
        zfar=float(given["far"]),
    )
    scene.add(camera, pose=np.eye(4))
    renderer = pyrender.OffscreenRenderer(width, height)
    seen, depth = renderer.render(scene, pyrender.RenderFlags.SEG, colours)
    ids = seen[..., 0].astype(np.int32) + 256 * seen[..., 1].astype(np.int32)
    np.savez(target, ids=ids, depth=depth)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
