"""A small dataset with true labels, drawn by the engine's CPU rasteriser instead of the studio.

Labels come from the rasteriser's buffers (ids, depth, barycentric weights, texture) and, for the
mirror, from the studio's geometry; the checker under test uses none of them.
"""

from __future__ import annotations

import json

import numpy as np
from said import say

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.scene import Candidates, Scene
from abs_engine.dataset import (
    LABELS,
    ClipEntry,
    camera_json,
    codec,
    dataset_record,
    write_chunk,
    write_points,
    write_sums,
    write_truth,
)
from abs_engine.dataset.card import card_text
from abs_engine.dataset.coco import box_and_area, coco
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.dataset.picture import write_picture
from abs_engine.io.assets import load_speaker
from abs_engine.io.video import VideoWriter
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.mirror import Mirror
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.sequence import deform

SIZE = (160, 120)
FRONT = Camera(np.array([[260.0, 0, 81.3], [0, 262.0, 57.8], [0, 0, 1]]), SIZE)
SIDE = Camera(
    np.array([[240.0, 0, 78.2], [0, 240.0, 61.1], [0, 0, 1]]),
    SIZE,
    np.array([-0.25, 0.08, 0.002, -0.003, 0.0]),
)
GLASS = Mirror.standing((-125.0, 0.0, 620.0), 0.75, (260.0, 320.0))
LISTS = ("outer_lip", "outer_lip_20", "inner_lip_8", "mouth_corners")


def make_dataset(folder, frames=6, *, seed=4, mirror=False, lossless=True, side=True):
    """One clip, "talk", by a camera "front" that stands and a camera "side" that moves."""
    speaker = load_speaker()
    sequence = say("p a m i", speaker, "clara", FRONT, frames=frames, seed=seed)
    scene = {name: getattr(sequence, name) for name in ("weights", "visemes", "intervals")}
    offsets = [deform(speaker, row) for row in scene["weights"]]
    neutral = speaker.named("clara")
    stands = Pose.from_vectors([0.1, 0.35, -0.05], [40.0, -25.0, 30.0])
    heads = [inverse_after(stands, sequence.pose(t)) for t in range(frames)]
    walks = [
        Pose.from_vectors([0.08, 0.35 + 0.35 + 0.01 * t, -0.05], [-130.0 + 3 * t, -10.0, 85.0])
        for t in range(frames)
    ]
    clip = folder / "talk"
    clip.mkdir(parents=True)
    gap = np.array([widest_gap(speaker, neutral + o.astype(np.float32)) for o in offsets])
    write_truth(
        clip,
        rate=sequence.rate, seed=seed, person="clara", sentence="p a m i", command="a test",
        unit_names=speaker.unit_names, unit_weights=scene["weights"],
        identity_weights=speaker.people["clara"], neutral=neutral, faces=speaker.faces,
        facet_class=speaker.facet_class, class_names=speaker.class_names, uv=speaker.uv,
        rotations=np.array([p.rotation_vector for p in heads]),
        translations=np.array([p.translation for p in heads]),
        phonemes=np.array(scene["visemes"]),
        phoneme_label=np.array([i[0] for i in scene["intervals"]]),
        phoneme_start=np.array([i[1] for i in scene["intervals"]]),
        phoneme_end=np.array([i[2] for i in scene["intervals"]]),
        closed=gap < CLOSED_BELOW, gap=gap, landmark_68=speaker.points["landmark_68"],
        **{name: speaker.landmarks[name] for name in LISTS},
    )  # fmt: skip
    for first in range(0, frames, codec.CHUNK):
        write_chunk(clip, first, np.array(offsets[first : first + codec.CHUNK]))
    take = Take(speaker, neutral, offsets, heads, seed)
    take.film(clip / "front", FRONT, [stands], GLASS if mirror else None, lossless)
    if side:
        take.film(clip / "side", SIDE, walks, None, lossless)
    cameras = ("front", "side") if side else ("front",)
    entry = ClipEntry("talk", "clara", "p a m i", frames, sequence.rate, cameras)
    record = dataset_record(
        command="a test", seed=seed, engine="test", clips=[entry], labels=LABELS
    )
    (folder / codec.DATASET).write_text(json.dumps(record))
    (folder / codec.SCENE).write_text("format = 'abs_engine.scene'\n")
    (folder / codec.README).write_text(card_text(record))
    write_sums(folder)
    return folder


def inverse_after(outer, inner):
    """The pose `outer`^-1 after `inner`: head to world, from head and world to camera."""
    back = outer.rotation.T
    return Pose(back @ inner.rotation, back @ (inner.translation - outer.translation))


class Take:
    """A clip before it has cameras."""

    def __init__(self, speaker, neutral, offsets, heads, seed):
        self.speaker, self.neutral, self.offsets, self.heads = speaker, neutral, offsets, heads
        self.rng = np.random.default_rng(seed)
        self.texture = speaker.texture("clara")

    def points(self, frame, pose):
        """Vertices (V, 3) in the camera frame."""
        vertices = np.float32(self.neutral + self.offsets[frame].astype(np.float32))
        world = self.heads[frame].apply(vertices.astype(np.float64))
        return pose.apply(world)

    def film(self, folder, camera, poses, mirror, lossless):
        for kind in (*LABELS, *([codec.FRAMES] if lossless else [])):
            (folder / kind).mkdir(parents=True)
        rows = {}
        with VideoWriter(folder / codec.VIDEO, camera.size, 25.0, 10) as video:
            for frame in range(len(self.offsets)):
                later = min(frame + 1, len(self.offsets) - 1)
                now, then = (self.points(t, poses[min(t, len(poses) - 1)]) for t in (frame, later))
                shot = Shot(self, camera, now, then, mirror)
                picture = shot.picture(self.rng)
                shot.write(folder, frame, last=frame == later)
                if lossless:
                    write_picture(folder / codec.FRAMES / codec.frame_name(frame), picture)
                video.write(picture)
                for name, value in shot.row(mirror).items():
                    rows.setdefault(name, []).append(value)
        text = camera_json(
            camera,
            [p.rotation_vector for p in poses],
            [p.translation for p in poses],
            None if mirror is None else mirror.corners,
        )
        (folder / codec.CAMERA).write_text(text)
        rows = {name: np.array(value) for name, value in rows.items()}
        boxes, areas = rows.pop("boxes"), rows.pop("areas")
        write_points(folder, **rows, in_picture=areas > 0)
        names = [f"{codec.FRAMES}/{codec.frame_name(i)}" for i in range(len(areas))]
        marks = rows["landmark_pixels"], rows["landmark_visible"]
        (folder / codec.COCO).write_text(json.dumps(coco(names, camera.size, *marks, boxes, areas)))


class Shot:
    """One frame of one camera: what the rasteriser draws of the head, and of its mirror image."""

    def __init__(self, take, camera, now, then, mirror):
        self.take, self.camera = take, camera
        speaker = take.speaker
        self.now, self.marks, self.mirror = now, speaker.points["landmark_68"], mirror
        parts = [(now, then, welded_normals(speaker, now), speaker.faces, None)]
        if mirror is not None:
            turned = mirror.reflect_directions(welded_normals(speaker, now))
            flipped = speaker.faces[:, [0, 2, 1]]
            image = mirror.reflect(now), mirror.reflect(then), turned, flipped, mirror.mask(camera)
            parts.append(image)
        for part in parts:
            self.draw(*part)

    def draw(self, now, then, normals, faces, mask):
        speaker = self.take.speaker
        scene = Scene(
            mean=now.astype(np.float32), modes=np.zeros((0, len(now), 3), np.float32), faces=faces,
            uv=speaker.uv, facet_class=speaker.facet_class, texture=self.take.texture,
        )  # fmt: skip
        one = Candidates.one(np.zeros(0), Pose(np.eye(3), np.zeros(3)))
        with CpuRenderer() as renderer:
            (drawn,) = renderer.draw(scene, one, self.camera, self.camera.whole)
        seen = drawn.facet_id > 0
        corner = faces[np.maximum(drawn.facet_id, 1) - 1]
        weights = drawn.barycentrics.astype(np.float64)[..., None]
        turned = (weights * normals[corner]).sum(axis=2)
        turned /= np.maximum(np.linalg.norm(turned, axis=2, keepdims=True), 1e-9)
        place = self.camera.project(
            np.where(seen[..., None], (weights * then[corner]).sum(axis=2), 1)
        )
        y, x = np.mgrid[: seen.shape[0], : seen.shape[1]]
        flow = place - np.stack([x, y], axis=-1)
        labels = {
            "ids": drawn.facet_id, "depth": drawn.depth, "normals": turned,
            "albedo": np.maximum(drawn.image, 1), "flow": flow,
        }  # fmt: skip
        if mask is None:
            self.seen = seen
            self.labels = {k: on(v, seen) for k, v in labels.items()}
            self.direct = seen
            return
        through = mask & seen & ~self.direct
        for kind, value in labels.items():
            keep = through.reshape(through.shape + (1,) * (value.ndim - 2))
            self.labels[kind] = np.where(keep, value, self.labels[kind])
        self.seen = self.direct | through

    def picture(self, rng):
        """The albedo under a light, before a grey wall, with noise."""
        light = np.array([-0.4, -0.5, -0.77])
        normals = self.labels["normals"]
        if self.mirror is not None:  # the light falls on the head, not on its image
            through = (self.seen & ~self.direct)[..., None]
            normals = np.where(through, self.mirror.reflect_directions(normals), normals)
        shade = 0.35 + 0.75 * np.clip(normals @ light, 0, None)
        lit = self.labels["albedo"] * shade[..., None]
        picture = np.where(self.seen[..., None], lit, 90.0) + rng.normal(
            0, 2, (*self.seen.shape, 3)
        )
        return np.clip(np.rint(picture), 0, 255).astype(np.uint8)

    def write(self, folder, frame, *, last):
        name, labels = codec.frame_name(frame), self.labels
        values = {
            "ids": labels["ids"].astype(np.uint16),
            "depth": codec.encode_depth(labels["depth"]),
            "normals": codec.encode_normals(labels["normals"], self.seen),
            "albedo": labels["albedo"].astype(np.uint8),
            "flow": codec.encode_flow(labels["flow"], self.seen & (not last)),
        }
        for kind, value in values.items():
            write_picture(folder / kind / name, value)

    def row(self, mirror):
        box, area = box_and_area(self.direct)
        pixels, visible = self.landmarks(self.now, self.direct)
        row = {
            "landmark_pixels": pixels, "landmark_visible": visible, "lip_pixels": pixels[48:],
            "lip_visible": visible[48:], "boxes": box, "areas": area,
        }  # fmt: skip
        if mirror is not None:
            marks = self.landmarks(mirror.reflect(self.now), self.seen & ~self.direct)
            for prefix, part in (("landmark", slice(None)), ("lip", slice(48, None))):
                row[f"mirror_{prefix}_pixels"] = marks[0][part]
                row[f"mirror_{prefix}_visible"] = marks[1][part]
        return row

    def landmarks(self, points, shown):
        """Pixels, and whether the depth there is the landmark's own or its facet is seen."""
        points = points[self.marks]
        pixels = self.camera.project(points)
        x, y = np.rint(pixels).astype(int).T
        width, height = self.camera.size
        inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
        depth, ids = self.labels["depth"][y, x], self.labels["ids"][y, x].astype(int)
        speaker = self.take.speaker
        corner = speaker.weld[speaker.faces[np.maximum(ids, 1) - 1]]
        own = (corner == speaker.weld[self.marks][:, None]).any(axis=1)
        near = depth > points[:, 2] - 4.0
        return pixels, inside & shown[y, x] & (own | near)


def on(values, seen):
    """Values where the head is seen, else 0."""
    return np.where(seen.reshape(seen.shape + (1,) * (values.ndim - 2)), values, 0)


def welded_normals(speaker, points):
    """Vertex normals, smooth across texture seams."""
    places = np.zeros((speaker.weld.max() + 1, 3))
    places[speaker.weld] = points
    return vertex_normals(places, speaker.weld[speaker.faces])[speaker.weld]
