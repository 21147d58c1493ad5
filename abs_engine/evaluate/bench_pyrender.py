"""The same evaluation with pyrender and NumPy, in a process of its own (see `bench.py`).

Two OpenGL stacks in one process corrupt each other, so this imports nothing of abs_engine.
Usage: bench_pyrender.py WORK.npz. It answers each line `WAY COUNT` on its input with a line of
JSON: the seconds that COUNT evaluations took, and their values.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

WAYS = ("pyrender_numpy", "pyrender_tuned")

Evaluate = Callable[[int], float]


class Bench:
    """One work, done by pyrender.

    Parameters
    ----------
    work : mapping of str to array
        See `bench_work.Work.as_arrays`.
    """

    def __init__(self, work: Mapping[str, NDArray[Any]]) -> None:
        import pyrender  # only here: importing it chooses the OpenGL platform of the process
        from OpenGL.plugins import FormatHandler

        # PyOpenGL 3.1.0, which pyrender pins, does not know the kind of `byref` of Python 3.12.
        FormatHandler.by_name("ctypesparameter").check.append("_ctypes.CArgObject")
        self.given = {name: work[name] for name in work}
        self.given["modes"] = self.given["modes"].astype(np.float32)
        u, v = self.given["uv"].T
        self.texcoords = np.stack([u, 1 - v], axis=1)  # pyrender counts from the bottom
        self.poses = [
            _pose(r, t)
            for r, t in zip(self.given["rotations"], self.given["translations"], strict=True)
        ]
        self.lit, self.plain = self._scene(pyrender), self._scene(pyrender)
        self.lit.add(pyrender.DirectionalLight(color=np.ones(3), intensity=3.0), pose=np.eye(4))
        width, height = (int(n) for n in self.given["size"])
        self.renderer = pyrender.OffscreenRenderer(width, height)
        visuals: Any = trimesh.visual.TextureVisuals
        self.visual = visuals(uv=self.texcoords, image=Image.fromarray(self.given["texture"]))
        sampler = pyrender.Sampler(minFilter=_LINEAR, magFilter=_LINEAR)
        self.material = pyrender.MetallicRoughnessMaterial(
            baseColorTexture=pyrender.Texture(
                source=np.ascontiguousarray(self.given["texture"]),
                source_channels="RGB",
                sampler=sampler,
            )
        )

    def _scene(self, pyrender: Any) -> Any:
        matrix, (near, far) = self.given["matrix"], self.given["depth_range"]
        scene = pyrender.Scene(bg_color=np.zeros(4), ambient_light=np.full(3, 0.3))
        camera = pyrender.IntrinsicsCamera(  # its pixel centres are at halves
            matrix[0, 0],
            matrix[1, 1],
            matrix[0, 2] + 0.5,
            matrix[1, 2] + 0.5,
            znear=float(near),
            zfar=float(far),
        )
        scene.add(camera, pose=np.eye(4))
        return scene

    def pyrender_numpy(self, index: int) -> float:
        """As the documentation of pyrender does it; renderer, scene and texture image are kept."""
        import pyrender

        vertices = self._vertices(index)
        mesh = trimesh.Trimesh(vertices, self.given["faces"], visual=self.visual, process=False)
        node = self.lit.add(pyrender.Mesh.from_trimesh(mesh), pose=self.poses[index])
        colour, depth = self.renderer.render(self.lit)
        self.lit.remove_node(node)
        return self._compare(colour, depth)

    def pyrender_tuned(self, index: int) -> float:
        """Without trimesh, normals and lights; the texture stays on the GPU."""
        import pyrender

        primitive = pyrender.Primitive(
            positions=self._vertices(index),
            indices=self.given["faces"],
            texcoord_0=self.texcoords,
            material=self.material,
        )
        node = self.plain.add(pyrender.Mesh([primitive]), pose=self.poses[index])
        colour, depth = self.renderer.render(self.plain, pyrender.RenderFlags.FLAT)
        self.plain.remove_node(node)
        return self._compare(colour, depth)

    def _vertices(self, index: int) -> NDArray[np.float32]:
        weights = self.given["weights"][index].astype(np.float32)
        modes = self.given["modes"]
        moved = weights @ modes.reshape(len(modes), -1)
        return np.asarray(self.given["mean"] + moved.reshape(-1, 3))

    def _compare(self, colour: NDArray[np.uint8], depth: NDArray[Any]) -> float:
        seen = depth > 0
        shifted = colour[seen].astype(np.float32) + 1
        normalised = shifted / shifted.sum(axis=1, keepdims=True)
        difference = normalised - self.given["target"][seen]
        return float(np.vdot(difference, difference))

    def describe(self) -> str:
        """The OpenGL that draws."""
        from OpenGL import GL

        names = [GL.glGetString(what) for what in (GL.GL_RENDERER, GL.GL_VERSION)]
        return ", ".join(name.decode() for name in names if name)


_LINEAR = 9729  # GL_LINEAR; pyrender's default would build mipmaps


def _pose(rotation: NDArray[Any], translation: NDArray[Any]) -> NDArray[np.float64]:
    """Head to the OpenGL camera frame, whose y and z are OpenCV's turned round."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation
    return np.diag([1.0, -1.0, -1.0, 1.0]) @ pose


def _run(evaluate: Evaluate, count: int, candidates: int) -> dict[str, Any]:
    start = time.perf_counter()
    values = [evaluate(i % candidates) for i in range(count)]
    return {"seconds": time.perf_counter() - start, "values": values}


def main(path: str) -> None:
    """Answer requests until the input ends."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a driver writes to stdout shall not get between the answers
    vars(np).setdefault("infty", np.inf)  # pyrender 0.1.45 knows only NumPy 1
    with np.load(path) as work:
        bench = Bench(dict(work))
    for way in WAYS:
        getattr(bench, way)(0)
    answers.write(json.dumps({"renderer": bench.describe()}) + "\n")
    answers.flush()
    for line in sys.stdin:
        way, count = line.split()
        answer = _run(getattr(bench, way), int(count), len(bench.poses))
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main(sys.argv[1])
