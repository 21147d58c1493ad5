"""The studio's camera: draws with pyrender, in a process of its own.

Two GL stacks in one process corrupt each other, so this file is run by its path and imports nothing
of abs_engine. It reads requests from standard input and answers on standard output until either
is closed; so it ends with the process that started it. The parent imports `send` and `receive`.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

Arrays = Mapping[str, NDArray[Any]]
UNUSED = "scipy", "tkinter"
"""What pyrender and trimesh import where they find it, at more than the cost of all the rest.

Nothing that is drawn here needs them: this process does not find them.
"""
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
    """A head and props under lights before a camera, in pyrender.

    Parameters
    ----------
    setup : mapping of str to array
        `size` (2,), `matrix` (3, 3) in OpenCV's pixel convention, `near`, `far` in mm; `faces`
        (F, 3), `uv` (V, 2) with v downwards, `texture` (H, W, 3), `shade` (V,) factor of the
        vertex's colour, `roughness`; of each prop i from 0: `prop{i}_faces` (M, 3),
        `prop{i}_colour` (N, 3) linear RGB of its vertices, `prop{i}_code`, 1 to 255.
    """

    def __init__(self, setup: Arrays) -> None:
        for name in UNUSED:
            sys.modules[name] = None  # type: ignore[assignment]
        import pyrender

        know_arguments()
        self._setup = setup
        self._nodes: list[Any] = []
        self._lamps: list[Any] = []
        self._scene = scene_with(pyrender, self._lamps)
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
        self._cloth = pyrender.MetallicRoughnessMaterial(
            baseColorFactor=[1.0, 1.0, 1.0, 1.0],
            metallicFactor=0.0,
            roughnessFactor=0.9,
            doubleSided=True,
        )
        self._renderer = open_renderer(pyrender, setup["size"])
        # pyrender's own order is that of a set: where surfaces meet, pixels would depend on chance.
        self._renderer._renderer._sorted_mesh_nodes = lambda _scene: list(self._nodes)
        shaders = Path(__file__).with_name("shaders")
        id_programs = pyrender.shader_program.ShaderProgramCache(str(shaders))
        self._id_pass = IdPass(pyrender, self._renderer._renderer, id_programs)

    def draw(self, state: Arrays) -> dict[str, NDArray[Any]]:
        """Draw one frame; everything is given in the camera frame (OpenCV's), mm.

        Parameters
        ----------
        state : mapping of str to array
            `vertices`, `normals` (V, 3) of the head; `prop{i}_vertices`, `prop{i}_normals` of the
            props that are there, `prop{i}_faces` and `prop{i}_colour` of those that are not drawn
            whole; `lights` (L, 7), direction of travel, intensity, RGB; `ambient` (3,); `flip`,
            whether facets count the other way round, as in a mirror.

        Returns
        -------
        dict
            `rgba` (H, W, 4) uint8, multisampled, alpha the coverage; `ids` (H, W) uint16, facet + 1
            or 0, `cover` (H, W) uint8, the code of the prop that is seen, or 0, and `depth` (H, W)
            float32 mm of head and props, 0 where neither is: at pixel centres, one sample;
            `seconds` of this process's processor time that it took.
        """
        import pyrender

        start = time.process_time()
        self._light(pyrender, state)
        colours = self._place(pyrender, state)
        flags = pyrender.RenderFlags
        rgba, _ = self._renderer.render(self._scene, flags.RGBA)
        with self._id_pass:
            seen, depth = self._renderer.render(self._scene, flags.SEG, colours)
        ids = seen[..., 0].astype(np.uint16) | seen[..., 1].astype(np.uint16) << 8
        cover = np.ascontiguousarray(seen[..., 2])
        drawn = {"rgba": rgba, "ids": ids, "cover": cover, "depth": depth.astype(np.float32)}
        return {**drawn, "seconds": np.array(time.process_time() - start)}

    def _place(self, pyrender: Any, state: Arrays) -> dict[Any, tuple[int, int, int]]:
        """Replace all meshes (pyrender releases the old ones' buffers); their id-pass colours."""
        for node in self._nodes:
            self._scene.remove_node(node)
        setup, uv, shade = self._setup, self._setup["uv"], self._setup["shade"]
        flip = bool(state["flip"])
        head = pyrender.Primitive(
            positions=state["vertices"],
            normals=state["normals"],
            texcoord_0=np.column_stack([uv[:, 0], 1 - uv[:, 1]]),
            color_0=np.column_stack([shade, shade, shade, np.ones_like(shade)]),
            indices=_wound(setup["faces"], flip),
            material=self._skin,
        )
        self._nodes = [self._scene.add(pyrender.Mesh([head]), pose=FLIP)]
        colours = {self._nodes[0]: (255, 255, 255)}
        number = 0
        while f"prop{number}_faces" in setup:
            name, number = f"prop{number}", number + 1
            if f"{name}_vertices" not in state:
                continue
            colour = state.get(f"{name}_colour", setup[f"{name}_colour"])
            prop = pyrender.Primitive(
                positions=state[f"{name}_vertices"],
                normals=state[f"{name}_normals"],
                color_0=np.column_stack([colour, np.ones(len(colour))]),
                indices=_wound(state.get(f"{name}_faces", setup[f"{name}_faces"]), flip),
                material=self._cloth,
            )
            self._nodes.append(self._scene.add(pyrender.Mesh([prop]), pose=FLIP))
            colours[self._nodes[-1]] = (0, 0, int(setup[f"{name}_code"]))
        return colours

    def _light(self, pyrender: Any, state: Arrays) -> None:
        """Turn the lamps, of which there are as many in every frame."""
        self._scene.ambient_light = np.asarray(state["ambient"], np.float64)
        while len(self._lamps) < len(state["lights"]):
            lamp = pyrender.DirectionalLight(color=np.ones(3), intensity=1.0)
            self._lamps.append(self._scene.add(lamp, pose=np.eye(4)))
        for node, light in zip(self._lamps, state["lights"], strict=True):
            node.light.intensity, node.light.color = float(light[3]), light[4:7]
            self._scene.set_pose(node, _shining(light[:3]))


def scene_with(pyrender: Any, lamps: list[Any]) -> Any:
    """An empty scene that is lit by these lamps in their order.

    pyrender's own order is that of a set, and the last digit of a sum depends on its order.
    """

    class Lit(pyrender.Scene):  # type: ignore[misc]
        @property
        def light_nodes(self) -> list[Any]:
            return lamps

    return Lit(bg_color=[0, 0, 0, 0])


class IdPass:
    """A context in which a renderer draws with other programs, one sample for each pixel.

    pyrender draws ids into its multisampled buffers with multisampling turned off. Ids and depth
    then belong to pixel centres by Mesa's drivers; by NVIDIA's, depth is that of the samples,
    which lie beside the centres: surfaces that meet hide each other in the wrong places.

    pyrender leaves out the backs of all facets here; what is double-sided in the picture is so
    in this pass, too. `inner` is pyrender's own renderer, `programs` a cache of its shaders.
    """

    _NAMES = "fb", "cb", "db", "fb_ms", "cb_ms", "db_ms", "fb_dims"

    def __init__(self, pyrender: Any, inner: Any, programs: Any) -> None:
        self._calls, self._inner = pyrender.renderer, inner
        self._storage = self._calls.glRenderbufferStorageMultisample
        self._enable, self._draw = self._calls.glEnable, inner._bind_and_draw_primitive
        self._both_sides = False
        none = {f"_main_{name}": None for name in self._NAMES}
        self._others = {**none, "_main_fb_dims": (None, None), "_program_cache": programs}
        self._others["_bind_and_draw_primitive"] = self._draw_sides
        vars(inner)["_bind_and_draw_primitive"] = self._draw

    def __enter__(self) -> None:
        self._swap()
        self._calls.glRenderbufferStorageMultisample = self._one_sample
        self._calls.glEnable = self._enable_sides

    def __exit__(self, *_: object) -> None:
        self._calls.glRenderbufferStorageMultisample = self._storage
        self._calls.glEnable = self._enable
        self._swap()

    def _one_sample(self, target: Any, _samples: int, *form: Any) -> None:
        self._storage(target, 0, *form)

    def _draw_sides(self, primitive: Any, *rest: Any, **named: Any) -> None:
        self._both_sides = primitive.material.doubleSided
        self._draw(primitive, *rest, **named)

    def _enable_sides(self, what: Any) -> None:
        if self._both_sides and what == self._calls.GL_CULL_FACE:
            self._calls.glDisable(what)
        else:
            self._enable(what)

    def _swap(self) -> None:
        """Exchange the renderer's framebuffers, programs and drawing for those kept here."""
        inner = vars(self._inner)
        kept = {name: inner[name] for name in self._others}
        inner.update(self._others)
        self._others = kept


def _wound(faces: NDArray[Any], flip: bool) -> NDArray[Any]:
    return np.ascontiguousarray(faces[:, ::-1]) if flip else faces


def _shining(direction: NDArray[Any]) -> NDArray[np.float64]:
    """Pose of a lamp, whose light travels along its -z, for a direction in OpenCV's frame."""
    back = FLIP[:3, :3] @ -direction / np.linalg.norm(direction)
    aside = [0.0, 1.0, 0.0] if abs(back[1]) < 0.99 else [1.0, 0.0, 0.0]
    side = np.cross(aside, back)
    side /= np.linalg.norm(side)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([side, np.cross(back, side), back])
    return pose


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


def know_arguments() -> None:
    """Name the kind of `byref` since Python 3.12 to PyOpenGL 3.1.0, which pyrender pins."""
    from OpenGL.plugins import FormatHandler

    FormatHandler.by_name("ctypesparameter").check.append("_ctypes.CArgObject")


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
