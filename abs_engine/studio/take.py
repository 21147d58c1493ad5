"""Films frames of a clip with one camera: the picture and all labels of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, Float32Array, FloatArray
from abs_engine.core.clock import Clock
from abs_engine.core.geometry import Pose
from abs_engine.io.assets import Speaker
from abs_engine.studio.appearance.optics import backdrop, composite
from abs_engine.studio.geometry import inner_shade, smooth_normals
from abs_engine.studio.labels import Cover, Geometry, Skin, Surface, visible
from abs_engine.studio.mirror import Drawn, Glass, Mirror, joined
from abs_engine.studio.plan import ClipPlan, Prop
from abs_engine.studio.plane_cut import cut_off
from abs_engine.studio.process import Worker
from abs_engine.studio.sequence import deform


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame: the picture and its labels.

    Parameters
    ----------
    picture : (H, W, 3) uint8
    ids : (H, W) uint16, facet + 1
    depth : (H, W) float64, mm; 0 where ids is
    cover : (H, W) uint8
        See `abs_engine.dataset.codec.COVER_NAMES`.
    normals : (H, W, 3) float32, camera frame, or None
    albedo : (H, W, 3) uint8, or None
    flow : (H, W, 2) float32, px, and whether it is valid (H, W), or None
    pixels, seen : (68, 2) float64 and (68,) bool
        Landmarks.
    mirror_pixels, mirror_seen : the same in the mirror, or None
    glass : (H, W) bool
        Pixels that show what is in the mirror.
    """

    picture: NDArray[np.uint8]
    ids: NDArray[np.uint16]
    depth: FloatArray
    cover: NDArray[np.uint8]
    normals: Float32Array | None
    albedo: NDArray[np.uint8] | None
    flow: tuple[Float32Array, BoolArray] | None
    pixels: FloatArray
    seen: BoolArray
    mirror_pixels: FloatArray | None
    mirror_seen: BoolArray | None
    glass: BoolArray


@dataclass(frozen=True, eq=False)
class Posed:
    """The head in a frame, and its reflection.

    Parameters
    ----------
    offsets : (V, 3) float16, mm, head frame
    """

    offsets: NDArray[np.float16]
    direct: Geometry
    mirrored: Geometry | None


class Take:
    """Films a clip with one camera; a context manager that owns the drawing process.

    Parameters
    ----------
    number : int
        Which of the plan's views.
    labels : tuple of str
        Which of normals, albedo and flow are wanted.
    """

    def __init__(
        self, speaker: Speaker, plan: ClipPlan, number: int, labels: tuple[str, ...]
    ) -> None:
        self._speaker, self._plan, self._labels = speaker, plan, labels
        self._number, self._view = number, plan.views[number]
        self._camera = self._view.camera
        self._skin = Skin(speaker, plan.texture) if "albedo" in labels else None
        self._behind = backdrop(self._camera, self._view.background, plan.seed)
        self._mirror = None if self._view.mirror is None else Mirror(self._view.mirror)
        self._glass = None if self._mirror is None else Glass(self._mirror, self._camera)
        self._vertex = speaker.points["landmark_68"]
        self.clock = Clock()
        self._worker = Worker(self._setup())

    def __enter__(self) -> Take:
        return self

    def __exit__(self, *_: object) -> None:
        self._worker.close()

    def posed(self, frame: int) -> Posed:
        """The head in a frame."""
        plan, camera = self._plan, self._camera
        offsets = deform(self._speaker, plan.weights[frame])
        vertices = np.asarray(plan.neutral + offsets.astype(np.float32), np.float32)
        pose = plan.pose(self._view, frame)
        points = pose.apply(vertices.astype(np.float64))
        normals = np.asarray(
            smooth_normals(self._speaker, vertices) @ pose.rotation.T.astype(np.float32)
        )
        direct = Geometry.of(camera, points, normals)
        if self._mirror is None:
            return Posed(offsets, direct, None)
        turned = self._mirror.reflect_directions(normals).astype(np.float32)
        return Posed(offsets, direct, Geometry.of(camera, self._mirror.reflect(points), turned))

    def film(self, first: int, last: int) -> Iterator[tuple[Posed, Shot]]:
        """Frames from `first` up to, not including, `last`; the worker draws one frame ahead."""
        with self.clock.part("geometry"):
            now = self.posed(first)
        self._worker.post(self._state(first, now, mirrored=False))
        for frame in range(first, last):
            drawn = self._collect(frame, now)
            with self.clock.part("geometry"):
                beyond = min(frame + 1, len(self._plan) - 1)
                following = self.posed(beyond) if beyond > frame else now
            if frame + 1 < last:
                self._worker.post(self._state(beyond, following, mirrored=False))
            yield now, self._shot(frame, now, following if beyond > frame else None, drawn)
            now = following

    def _collect(self, frame: int, now: Posed) -> Drawn:
        """Buffers drawn of a frame, what the mirror shows laid over it."""
        direct = self._answer()
        if self._glass is None:
            return direct
        self._worker.post(self._state(frame, now, mirrored=True))
        return joined(direct, self._answer(), self._glass)

    def _answer(self) -> Drawn:
        answer = self._worker.collect()
        self.clock.seconds["draw"] += float(answer["seconds"])
        ids = np.array(answer["ids"])
        return Drawn(
            answer["rgba"], ids, answer["cover"], answer["depth"], np.zeros(ids.shape, bool)
        )

    def _setup(self) -> dict[str, NDArray[Any]]:
        plan = self._plan
        setup = {
            "size": np.array(self._camera.size),
            "matrix": self._camera.matrix,
            "near": np.array(self._camera.near),  # pyrender's default, 0.05, leaves no depth
            "far": np.array(self._camera.far),
            "faces": self._speaker.faces,
            "uv": self._speaker.uv,
            "texture": plan.texture,
            "shade": inner_shade(self._speaker),
            "roughness": np.array(plan.roughness),
        }
        for number, prop in enumerate(plan.props):
            setup[f"prop{number}_faces"] = prop.faces
            setup[f"prop{number}_colour"] = prop.colour
            setup[f"prop{number}_code"] = np.array(prop.code)
        return setup

    def _state(self, frame: int, now: Posed, *, mirrored: bool) -> dict[str, NDArray[Any]]:
        """State that the worker draws; see `worker.Stage.draw`."""
        plan, to_camera = self._plan, self._view.pose(frame).rotation
        lights = plan.lights[frame].copy()
        lights[:, :3] = lights[:, :3] @ to_camera.T
        head = now.mirrored if mirrored and now.mirrored is not None else now.direct
        if mirrored and self._mirror is not None:
            lights[:, :3] = self._mirror.reflect_directions(lights[:, :3])
        state = {
            "vertices": head.drawn.astype(np.float32),
            "normals": head.normals,
            "lights": lights,
            "ambient": np.full(3, plan.ambient),
            "flip": np.array(mirrored),
        }
        for number, prop in enumerate(plan.props):
            placed = self._placed(prop, frame, mirrored=mirrored) if prop.present[frame] else {}
            for name, value in placed.items():
                kind = np.int32 if name == "faces" else np.float32
                state[f"prop{number}_{name}"] = value.astype(kind)
        return state

    def _placed(self, prop: Prop, frame: int, *, mirrored: bool) -> dict[str, NDArray[Any]]:
        """Vertices, moved by the lens, and normals of a prop, camera frame.

        In the mirror also its facets and colours, if not all of it is before the mirror's plane;
        nothing, if none of it is.
        """
        own = Pose.from_vectors(prop.rotations[frame], prop.translations[frame])
        view = self._view.pose(frame)
        points = view.apply(own.apply(prop.vertices.astype(np.float64)))
        normals = prop.normals @ (view.rotation @ own.rotation).T
        further: dict[str, NDArray[Any]] = {}
        if mirrored and self._mirror is not None:
            height = self._mirror.height(points)
            if height.min() < 0:
                part = cut_off(prop.faces, height)
                if not len(part.faces):
                    return {}
                points, normals = part.of(points), part.of(normals)
                further = {"faces": part.faces, "colour": part.of(prop.colour)}
            points = self._mirror.reflect(points)
            normals = self._mirror.reflect_directions(normals)
        return {"vertices": self._camera.distort(points), "normals": normals, **further}

    def _covers(self, frame: int, *, mirrored: bool) -> tuple[Cover, ...]:
        """Objects that may hide landmarks."""
        objects = [p for p in self._plan.props if p.present[frame]]
        placed = [(p, self._placed(p, frame, mirrored=mirrored)) for p in objects]
        return tuple(Cover(d["vertices"], d.get("faces", p.faces)) for p, d in placed if d)

    def _shot(self, frame: int, now: Posed, following: Posed | None, drawn: Drawn) -> Shot:
        with self.clock.part("picture"):
            picture = self._expose(frame, drawn)
        with self.clock.part("labels"):
            labels = self._label(now, following, drawn)
        with self.clock.part("landmarks"):
            covers = self._covers(frame, mirrored=False)
            pixels = now.direct.pixels[self._vertex]
            seen = visible(self._vertex, now.direct, self._speaker, self._camera, covers)
            mirror_pixels = mirror_seen = None
            if self._glass is not None and now.mirrored is not None:
                seen &= ~self._glass.hides(now.direct.drawn[self._vertex], pixels)
                mirror_pixels = now.mirrored.pixels[self._vertex]
                mirror_seen = visible(
                    self._vertex, now.mirrored, self._speaker, self._camera,
                    self._covers(frame, mirrored=True), mirrored=True,
                ) & self._glass.shows(mirror_pixels, drawn.glass)  # fmt: skip
        return Shot(
            picture, drawn.ids, cover=drawn.cover, **labels, pixels=pixels, seen=seen,
            mirror_pixels=mirror_pixels, mirror_seen=mirror_seen, glass=drawn.glass,
        )  # fmt: skip

    def _expose(self, frame: int, drawn: Drawn) -> NDArray[np.uint8]:
        view, plan = self._view, self._plan
        rng = np.random.default_rng([plan.seed, plan.number, self._number, frame])
        ideal = np.asarray(composite(drawn.rgba, self._behind) * view.gain[frame], np.float32)
        return view.sensor.expose(ideal, rng, frame, float(view.blur[frame]))

    def _label(self, now: Posed, following: Posed | None, drawn: Drawn) -> dict[str, Any]:
        """Depth, normals, albedo and flow; in the mirror, of what is reflected."""
        beside = np.where(drawn.glass, 0, drawn.ids).astype(np.uint16)
        nexts = None if following is None else following.direct
        out = self._label_of(beside, now.direct, nexts)
        if self._glass is None or now.mirrored is None:
            return out
        within = np.where(drawn.glass, drawn.ids, 0).astype(np.uint16)
        nexts = None if following is None else following.mirrored
        inside = self._label_of(within, now.mirrored, nexts)
        merged: dict[str, Any] = {"depth": out["depth"] + inside["depth"]}
        for name in ("normals", "albedo"):
            merged[name] = None if out[name] is None else out[name] + inside[name]
        merged["flow"] = out["flow"]
        if out["flow"] is not None:
            merged["flow"] = tuple(a + b for a, b in zip(out["flow"], inside["flow"], strict=True))
        return merged

    def _label_of(
        self, ids: NDArray[np.uint16], head: Geometry, nexts: Geometry | None
    ) -> dict[str, Any]:
        seen = Surface(ids, head, self._speaker.faces, self._camera)
        nothing = np.zeros((*ids.shape, 2), np.float32), np.zeros(ids.shape, np.bool_)
        moved = nothing if nexts is None or "flow" not in self._labels else seen.flow(nexts)
        return {
            "depth": seen.depth,
            "normals": seen.normals() if "normals" in self._labels else None,
            "albedo": None if self._skin is None else seen.albedo(self._skin),
            "flow": moved if "flow" in self._labels else None,
        }
