"""glTF 2.0 (GLB): the head with morph targets, moved as in the video, before the video's camera."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pygltflib as gl
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.geometry import seamless_normals
from abs_engine.core.release import engine_version
from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.face_units import shape_loss, unit_weights, weights_of
from abs_engine.export.reading import compared

METRES = 1e-3  # glTF's unit, of a millimetre
_COLOURS = {
    "upper_lip": (0.45, 0.12, 0.11), "lower_lip": (0.45, 0.12, 0.11),
    "inner_mouth": (0.11, 0.03, 0.03), "tongue": (0.25, 0.07, 0.07),
    "upper_teeth": (0.9, 0.89, 0.8), "lower_teeth": (0.9, 0.89, 0.8), "eyes": (0.68, 0.66, 0.62),
}  # fmt: skip
"""Linear RGB of facet classes; all others are skin."""
_SKIN = (0.63, 0.53, 0.45)

_SEEN = 0.5  # px; less is not mentioned
_KINDS = {1: gl.SCALAR, 3: gl.VEC3, 4: gl.VEC4}


class _Buffer:
    """Arrays one behind the other, each with its view and accessor."""

    def __init__(self) -> None:
        self.content, self.views = bytearray(), list[gl.BufferView]()
        self.accessors = list[gl.Accessor]()

    def add(self, array: NDArray[np.generic], target: int | None = None) -> int:
        """Append a float32 or uint32 array (N,) or (N, 2 to 4); the accessor's number."""
        rows = array.reshape(len(array), -1)
        whole = array.dtype == np.uint32
        view = gl.BufferView(
            buffer=0, byteOffset=len(self.content), byteLength=array.nbytes, target=target
        )
        self.views.append(view)
        accessor = gl.Accessor(
            bufferView=len(self.views) - 1, count=len(rows), type=_KINDS[rows.shape[1]],
            componentType=gl.UNSIGNED_INT if whole else gl.FLOAT,
            max=rows.max(0).tolist(), min=rows.min(0).tolist(),
        )  # fmt: skip
        self.accessors.append(accessor)
        self.content += np.ascontiguousarray(array).tobytes()
        return len(self.accessors) - 1


def _write(run: TrackedRun, path: Path, arkit: bool) -> tuple[Loss, ...]:
    names, targets, weights = _units(run) if arkit else _modes(run)
    buffer = _Buffer()
    base = run.neutral if arkit else run.mesh.mean.astype(np.float64)
    mesh = _mesh(run, base, names, targets, buffer)
    mesh.weights = [0.0] * len(names)
    camera = gl.Camera(type="perspective", perspective=_perspective(run))
    head = gl.Node(name="head", mesh=0)
    turned = gl.Node(name="video camera", camera=0)  # glTF's look along -z, with y up
    look = gl.PbrMetallicRoughness(metallicFactor=0.0, roughnessFactor=0.7)
    clay = gl.Material(name="clay", pbrMetallicRoughness=look, doubleSided=True, alphaCutoff=None)
    document = gl.GLTF2(
        asset=gl.Asset(version="2.0", generator=f"abs_engine {engine_version()}"),
        scene=0, scenes=[gl.Scene(nodes=[0, 1])], nodes=[head, turned], meshes=[mesh],
        cameras=[camera], materials=[clay],
        animations=_animations(run, weights, buffer),
        accessors=buffer.accessors, bufferViews=buffer.views,
        buffers=[gl.Buffer(byteLength=len(buffer.content))],
    )  # fmt: skip
    document.set_binary_blob(bytes(buffer.content))
    document.save_binary(str(path))
    return _read_back(run, path, weights_of(run.speaker) if arkit else "")


def _units(run: TrackedRun) -> tuple[list[str], FloatArray, FloatArray]:
    return list(run.speaker.unit_names), run.speaker.units.astype(np.float64), unit_weights(run)


def _modes(run: TrackedRun) -> tuple[list[str], FloatArray, FloatArray]:
    count = len(run.mesh.modes)  # the pose comes first
    names = [str(name) for name in run.arrays["parameter_names"][-count:]]
    return names, run.mesh.modes.astype(np.float64), run.mesh.weights


def _mesh(
    run: TrackedRun, base: FloatArray, names: list[str], targets: FloatArray, buffer: _Buffer
) -> gl.Mesh:
    places = (base * METRES).astype(np.float32)
    normals = seamless_normals(base, run.mesh.faces, run.speaker.weld)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 0.5, normals / np.maximum(lengths, 0.5), [0.0, 0.0, 1.0])
    attributes = gl.Attributes(
        POSITION=buffer.add(places, gl.ARRAY_BUFFER),
        NORMAL=buffer.add(normals.astype(np.float32), gl.ARRAY_BUFFER),
        COLOR_0=buffer.add(_colours(run), gl.ARRAY_BUFFER),
    )
    moved = [(one * METRES).astype(np.float32) for one in targets]
    primitive = gl.Primitive(
        attributes=attributes, material=0,
        indices=buffer.add(run.mesh.faces.astype(np.uint32).ravel(), gl.ELEMENT_ARRAY_BUFFER),
        targets=[{"POSITION": buffer.add(one, gl.ARRAY_BUFFER)} for one in moved],
    )  # fmt: skip
    return gl.Mesh(name="head", primitives=[primitive], extras={"targetNames": names})


def _colours(run: TrackedRun) -> NDArray[np.float32]:
    """Linear RGB of the vertices, (V, 3), by the last facet that each belongs to."""
    head = run.speaker
    classes = np.array([_COLOURS.get(name, _SKIN) for name in head.class_names], np.float32)
    out = np.tile(np.array(_SKIN, np.float32), (len(head.vertices), 1))
    out[head.faces.ravel()] = np.repeat(classes[head.facet_class], 3, axis=0)
    return out


def _perspective(run: TrackedRun) -> gl.Perspective:
    width, height = run.camera.size
    upright = 2 * np.arctan(height / (2 * float(run.camera.matrix[1, 1])))
    return gl.Perspective(aspectRatio=width / height, yfov=float(upright), znear=0.05, zfar=100.0)


_TURN = np.diag([1.0, -1.0, -1.0])  # OpenCV's camera to glTF's


def _animations(run: TrackedRun, weights: FloatArray, buffer: _Buffer) -> list[gl.Animation]:
    """Keys at the times of the frames in which the head was found."""
    frames = run.frames
    times = buffer.add(run.arrays["time"][frames].astype(np.float32))
    poses = [run.pose(frame) for frame in frames]
    quaternions = Rotation.from_matrix([_TURN @ pose.rotation for pose in poses]).as_quat()
    steps = np.cumsum(np.r_[1, np.sign((quaternions[1:] * quaternions[:-1]).sum(1))] < 0) % 2
    quaternions *= np.where(steps, -1, 1)[:, None]  # the short way round
    shifts = np.array([_TURN @ pose.translation for pose in poses]) * METRES
    tracks = {"weights": weights[frames].ravel(), "rotation": quaternions, "translation": shifts}
    samplers, channels = [], []
    for number, (path, values) in enumerate(tracks.items()):
        keys = buffer.add(values.astype(np.float32))
        samplers.append(gl.AnimationSampler(input=times, output=keys, interpolation="LINEAR"))
        target = gl.AnimationChannelTarget(node=0, path=path)
        channels.append(gl.AnimationChannel(sampler=number, target=target))
    return [gl.Animation(name="video", samplers=samplers, channels=channels)]


def _read_back(run: TrackedRun, path: Path, by: str) -> tuple[Loss, ...]:
    file = _File(path)
    mesh = file.document.meshes[0].primitives[0]
    base = file.numbers(mesh.attributes.POSITION) / METRES
    targets = np.array([file.numbers(one["POSITION"]) for one in mesh.targets]) / METRES
    times, weights = file.keys("weights", run.shown, len(targets))
    seen = _before_camera(run, file)
    picture, wanted = _in_picture(run, file, seen), run.landmarks_in_picture
    return (
        compared(times, np.where(run.shown, run.arrays["time"], np.nan), "s", "times"),
        *shape_loss(run, base, targets, weights, by),
        compared(seen, run.landmarks_in_camera, "mm", "68 landmarks before the camera"),
        compared(picture, wanted, "px", "68 landmarks in the picture", _note(picture - wanted)),
    )


def _note(apart: FloatArray) -> str:
    """Line about what the file's camera leaves out, of differences (T, 68, 2), px; or empty."""
    off = np.linalg.norm(apart[np.isfinite(apart).all(axis=2)], axis=1).max(initial=0.0)
    if off <= _SEEN:
        return ""
    return (
        "glTF cameras have no principal point, second focal length or distortion: seen by the "
        f"file's camera, the face is up to {off:.1f} px off"
    )


def _before_camera(run: TrackedRun, file: _File) -> FloatArray:
    """The 68 landmarks where a file's animation moves the head, (T, 68, 3) mm, camera frame."""
    _, quaternions = file.keys("rotation", run.shown, 4)
    _, shifts = file.keys("translation", run.shown, 3)
    out = np.full((len(run), 68, 3), np.nan)
    for frame in np.flatnonzero(np.isfinite(quaternions[:, 0])):
        turned = Rotation.from_quat(quaternions[frame]).apply(run.landmarks[frame])
        out[frame] = (turned + shifts[frame] / METRES) @ _TURN
    return out


def _in_picture(run: TrackedRun, file: _File, seen: FloatArray) -> FloatArray:
    """Points (T, 68, 3) before the file's camera in its picture, (T, 68, 2) px."""
    size, camera = np.array(run.camera.size), file.document.cameras[0].perspective
    upright = np.tan(camera.yfov / 2)
    focal = size / (2 * upright * np.array([camera.aspectRatio, 1.0]))
    return np.asarray(focal * seen[..., :2] / seen[..., 2:] + (size - 1) / 2)


class _File:
    """A file that is read back."""

    def __init__(self, path: Path) -> None:
        self.document = gl.GLTF2().load_binary(str(path))
        self._content = self.document.binary_blob()

    def numbers(self, number: int) -> FloatArray:
        """Numbers of a float32 accessor, (N, K)."""
        accessor = self.document.accessors[number]
        width = next(width for width, kind in _KINDS.items() if kind == accessor.type)
        at = self.document.bufferViews[accessor.bufferView].byteOffset
        found = np.frombuffer(self._content, np.float32, accessor.count * width, at)
        return found.reshape(-1, width).astype(np.float64)

    def keys(self, path: str, shown: BoolArray, width: int) -> tuple[FloatArray, FloatArray]:
        """Times (T,), s, and values (T, width) of keys, one for each shown frame; NaN elsewhere."""
        times, values = np.full(len(shown), np.nan), np.full((len(shown), width), np.nan)
        for animation in self.document.animations:
            for channel in animation.channels:
                if channel.target.path == path:
                    sampler = animation.samplers[channel.sampler]
                    times[shown] = self.numbers(sampler.input)[:, 0]
                    values[shown] = self.numbers(sampler.output).reshape(-1, width)
        return times, values


GLTF = Exporter("glTF 2.0 with ARKit's 52 morph targets", partial(_write, arkit=True), ".glb")
GLTF_MODES = Exporter(
    "glTF 2.0 with the tracker's own modes", partial(_write, arkit=False), ".glb",
    needs=("parameter_names",),
)  # fmt: skip
