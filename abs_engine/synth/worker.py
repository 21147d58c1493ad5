"""The studio's camera: draws with pyrender, in a process of its own.

Two GL stacks in one process corrupt each other, so this file is run by its path and imports nothing
of abs_engine. It reads requests from standard input and answers on standard output until either
is closed; so it ends with the process that started it. The parent imports `send` and `receive`.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

Arrays = Mapping[str, NDArray[Any]]
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
"""OpenCV's camera frame to OpenGL's: y and z turned round."""


def send(pipe: BinaryIO, arrays: Arrays) -> None:
    """Write named arrays: one line of JSON (name, dtype, shape), then their bytes."""
    data = {name: np.asarray(value, order="C") for name, value in arrays.items()}
    head = [[name, value.dtype.str, value.shape] for name, value in data.items()]
    pipe.write(json.dumps(head).encode() + b"\n")
    for value in data.values():
        pipe.write(value.tobytes())
    pipe.flush()


def receive(pipe: BinaryIO) -> dict[str, NDArray[Any]]:
    """Read what `send` wrote.

    Raises
    ------
    EOFError
        If the other side has closed the pipe.
    """
    line = pipe.readline()
    if not line.endswith(b"\n"):
        raise EOFError("the pipe was closed")
    out = {}
    for name, kind, shape in json.loads(line):
        dtype = np.dtype(kind)
        size = dtype.itemsize * int(np.prod(shape))
        block = pipe.read(size)
        if len(block) < size:
            raise EOFError("the pipe was closed")
        out[name] = np.frombuffer(block, dtype).reshape(shape)
    return out


class Stage:
    """A head, and perhaps a torso, under lights before a camera, in pyrender.

    Parameters
    ----------
    setup : mapping of str to array
        `size` (2,), `matrix` (3, 3) in OpenCV's pixel convention, `near`, `far` in mm; `faces`
        (F, 3), `uv` (V, 2) with v downwards, `texture` (H, W, 3), `shade` (V,) factor of the
        vertex's colour, `roughness`; `lights` (L, 7) direction of travel in the OpenCV camera
        frame, intensity, RGB; `ambient` (3,); `torso_vertices` and `torso_normals` (N, 3),
        `torso_faces` (M, 3), which may be empty, `torso_colour` (3,).
    """

    def __init__(self, setup: Arrays) -> None:
        import pyrender

        self._setup = setup
        self._scene = pyrender.Scene(bg_color=[0, 0, 0, 0], ambient_light=setup["ambient"])
        self._torso = self._add_torso(pyrender)
        self._head: Any = None
        for light in setup["lights"]:
            self._add_light(pyrender, light)
        matrix = setup["matrix"]
        lens = pyrender.IntrinsicsCamera(  # its pixel centres are at halves, OpenCV's at integers
            matrix[0, 0],
            matrix[1, 1],
            matrix[0, 2] + 0.5,
            matrix[1, 2] + 0.5,
            znear=float(setup["near"]),
            zfar=float(setup["far"]),
        )
        self._scene.add(lens, pose=np.eye(4))
        source = np.ascontiguousarray(setup["texture"])
        texture = pyrender.Texture(source=source, source_channels="RGB")
        self._skin = pyrender.MetallicRoughnessMaterial(
            baseColorTexture=texture, metallicFactor=0.0, roughnessFactor=float(setup["roughness"])
        )
        self._renderer = open_renderer(pyrender, setup["size"])
        shaders = Path(__file__).with_name("shaders")
        self._programs = self._renderer._renderer._program_cache
        self._id_programs = pyrender.shader_program.ShaderProgramCache(str(shaders))

    def draw(self, state: Arrays) -> dict[str, NDArray[Any]]:
        """Draw `vertices` (V, 3) with `normals`, head frame, under `pose` (4, 4), `torso_pose`.

        Returns
        -------
        dict
            `rgba` (H, W, 4) uint8, multisampled, alpha the coverage; `ids` (H, W) uint32, facet + 1
            or 0, and `depth` (H, W) float32 mm, 0 where `ids` is: at pixel centres, one sample.
        """
        import pyrender

        self._place_head(pyrender, state)
        flags = pyrender.RenderFlags
        if self._torso is not None:
            self._scene.set_pose(self._torso, FLIP @ state["torso_pose"])
        rgba, _ = self._renderer.render(self._scene, flags.RGBA)
        colours = {self._head: (255, 255, 255)}
        if self._torso is not None:
            colours[self._torso] = (0, 0, 0)
        inner = self._renderer._renderer
        inner._program_cache = self._id_programs
        seen, depth = self._renderer.render(self._scene, flags.SEG, colours)
        inner._program_cache = self._programs
        red, green, blue = np.moveaxis(seen.astype(np.uint32), 2, 0)
        ids = red | green << 8 | blue << 16
        return {"rgba": rgba, "ids": ids, "depth": np.where(ids > 0, depth, 0).astype(np.float32)}

    def _place_head(self, pyrender: Any, state: Arrays) -> None:
        """Replace the head's mesh; pyrender releases the old one's buffers."""
        uv, shade = self._setup["uv"], self._setup["shade"]
        primitive = pyrender.Primitive(
            positions=state["vertices"],
            normals=state["normals"],
            texcoord_0=np.column_stack([uv[:, 0], 1 - uv[:, 1]]),
            color_0=np.column_stack([shade, shade, shade, np.ones_like(shade)]),
            indices=self._setup["faces"],
            material=self._skin,
        )
        if self._head is not None:
            self._scene.remove_node(self._head)
        self._head = self._scene.add(pyrender.Mesh([primitive]), pose=FLIP @ state["pose"])

    def _add_light(self, pyrender: Any, light: NDArray[Any]) -> None:
        back = FLIP[:3, :3] @ -light[:3] / np.linalg.norm(light[:3])  # lights shine along -z
        side = np.cross([0.0, 1.0, 0.0], back)
        side /= np.linalg.norm(side)
        pose = np.eye(4)
        pose[:3, :3] = np.column_stack([side, np.cross(back, side), back])
        lamp = pyrender.DirectionalLight(color=light[4:7], intensity=float(light[3]))
        self._scene.add(lamp, pose=pose)

    def _add_torso(self, pyrender: Any) -> Any:
        faces = self._setup["torso_faces"]
        if not len(faces):
            return None
        cloth = pyrender.MetallicRoughnessMaterial(
            baseColorFactor=[*self._setup["torso_colour"], 1.0],
            metallicFactor=0.0,
            roughnessFactor=0.9,
            doubleSided=True,
        )
        primitive = pyrender.Primitive(
            positions=self._setup["torso_vertices"],
            normals=self._setup["torso_normals"],
            indices=faces,
            material=cloth,
        )
        return self._scene.add(pyrender.Mesh([primitive]))


def open_renderer(pyrender: Any, size: NDArray[Any]) -> Any:
    """An offscreen renderer on the first EGL device that works, or on OSMesa."""
    width, height = (int(n) for n in size)
    if os.environ["PYOPENGL_PLATFORM"] == "osmesa":
        mend_osmesa()
        return pyrender.OffscreenRenderer(width, height)
    from pyrender.platforms.egl import query_devices

    for device in range(max(1, len(query_devices()))):
        os.environ["EGL_DEVICE_ID"] = str(device)
        try:
            return pyrender.OffscreenRenderer(width, height)
        except (AssertionError, RuntimeError) as error:  # pyrender asserts what EGL returns
            reason = error
    raise RuntimeError(f"no EGL device works: {reason!r}")


def mend_osmesa() -> None:
    """Supply what pyrender asks of OSMesa and PyOpenGL 3.1.0, which pyrender pins, does not name.

    Framebuffer objects work on OSMesa's core contexts, so pyrender may use them as on EGL.
    """
    import ctypes

    from OpenGL import osmesa, platform
    from pyrender.platforms.osmesa import OSMesaPlatform

    OSMesaPlatform.supports_framebuffers = lambda _self: True
    osmesa.OSMesaContext.__hash__ = lambda self: hash(self.address)  # PyOpenGL keeps it as a key
    if hasattr(osmesa, "OSMesaCreateContextAttribs"):
        return
    create = platform.PLATFORM.OSMesa.OSMesaCreateContextAttribs
    create.restype = osmesa.OSMesaContext
    create.argtypes = [ctypes.POINTER(ctypes.c_int), osmesa.OSMesaContext]
    osmesa.OSMesaCreateContextAttribs = create
    osmesa.OSMESA_DEPTH_BITS = 0x30
    osmesa.OSMESA_PROFILE, osmesa.OSMESA_CORE_PROFILE = 0x33, 0x34
    osmesa.OSMESA_CONTEXT_MAJOR_VERSION, osmesa.OSMESA_CONTEXT_MINOR_VERSION = 0x36, 0x37


def main() -> None:
    """Serve requests: the first sets the stage, each further one is a frame to draw."""
    requests = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints must not end up among the pixels
    stage = None
    while True:
        try:
            given = receive(requests)
        except EOFError:
            return
        if stage is None:
            stage = Stage(given)
            send(answers, {"ready": np.ones(1)})
        else:
            send(answers, stage.draw(given))


if __name__ == "__main__":
    main()
