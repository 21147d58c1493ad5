"""A small run and a small dataset of the bundled head, drawn and not filmed, to look at."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose
from abs_engine.dataset import (
    camera_json,
    codec,
    write_chunk,
    write_points,
    write_sums,
    write_truth,
)
from abs_engine.dataset.dataset import ClipEntry, dataset_record
from abs_engine.dataset.picture import write_picture
from abs_engine.io.assets import load_speaker
from abs_engine.io.video import VideoWriter
from abs_engine.render.cpu import CpuRenderer
from abs_engine.report.drawing.paint import paint
from abs_engine.report.drawing.view import View
from abs_engine.report.inspect.body import Body, coat, person_body, posed
from abs_engine.report.inspect.labels import LabelFrame, drawn_labels
from abs_engine.tracking.results.run_mesh import RunMesh
from abs_engine.tracking.runs.record import FORMAT, VERSION

CAMERA = Camera.ideal((96, 72))
POSE = Pose(FACING, np.array([0.0, 20.0, 600.0]))
JAW = (0.0, 0.25, 0.5)
RATE = 25.0
FLOW = np.array([1.5, -0.25])
RUN_SHIFT = np.array([0.0, 3.0, 4.0])  # 5 mm


@cache
def bodies() -> tuple[Body, ...]:
    """The head in each frame."""
    clara = person_body(load_speaker(), "clara")
    return tuple(posed(clara, {"jawOpen": weight}) for weight in JAW)


@cache
def frames() -> tuple[np.ndarray, ...]:
    """The pictures."""
    view = View(CAMERA, POSE, CAMERA.whole)
    return tuple(
        paint(CpuRenderer(), body, coat(body, "colour"), view, background=(40, 60, 80))
        for body in bodies()
    )


@cache
def labels() -> tuple[LabelFrame, ...]:
    """The labels."""
    view = View(CAMERA, POSE, CAMERA.whole)
    return tuple(drawn_labels(CpuRenderer(), body, view) for body in bodies())


def write_video(path: Path, crf: int = 18, times: int = 1) -> Path:
    """The pictures as a video, shown so many times."""
    with VideoWriter(path, CAMERA.size, RATE, crf) as writer:
        for frame in frames() * times:
            writer.write(frame)
    return path


def write_run(folder: Path) -> Path:
    """A run whose mesh is `RUN_SHIFT` away from the truth; its middle frame is lost."""
    folder.mkdir()
    rest, delta = bodies()[0].vertices, bodies()[2].vertices - bodies()[0].vertices
    found = np.array([True, False, True])
    weights = np.where(found, np.array(JAW) / JAW[2], np.nan)[:, None]
    RunMesh(
        (rest + RUN_SHIFT).astype(np.float32),
        delta[None].astype(np.float32),
        weights,
        load_speaker().faces,
    ).save(folder)
    rows = np.where(found[:, None], 1.0, np.nan)
    each = {name: np.zeros(3) for name in ("width", "aperture", "value", "score")}
    np.savez(
        folder / "results.npz",
        format=FORMAT,
        version=VERSION,
        **each,
        evaluations=np.zeros(3, int),
        index=np.arange(3),
        time=np.arange(3) / RATE,
        found=found,
        parameters=rows * np.zeros(7),
        rotation=rows * POSE.rotation_vector,
        translation=rows * POSE.translation,
        lip_points=rows[..., None] * np.zeros((1, 3)),
        lip_vertex=np.zeros(1, np.int32),
        closed=np.zeros(3, bool),
        status=np.where(found, "converged", "face not found"),
        camera_matrix=CAMERA.matrix,
        camera_distortion=CAMERA.distortion,
        camera_size=np.array(CAMERA.size),
        rate=RATE,
    )
    told = json.dumps({"settings": {"video": "video.mp4"}})
    (folder / "run.json").write_text(told, encoding="utf-8")
    return folder


def write_dataset(folder: Path) -> Path:
    """A dataset of one clip and one camera; the flow is `FLOW` at every pixel of the head."""
    clip, camera = folder / "clip", folder / "clip" / "front"
    camera.mkdir(parents=True)
    speaker, count = load_speaker(), len(JAW)
    neutral = bodies()[0].vertices.astype(np.float32)
    moved = np.array([body.vertices for body in bodies()]) - neutral
    write_chunk(clip, 0, moved.astype(np.float16))
    marks = {**speaker.landmarks, **speaker.points}
    names = ("outer_lip", "outer_lip_20", "inner_lip_8", "mouth_corners", "landmark_68")
    write_truth(
        clip,
        **{name: marks[name] for name in names},
        **dict.fromkeys(("person", "sentence", "command"), "clara"),
        **{f"phoneme_{name}": np.zeros(0) for name in ("label", "start", "end")},
        rate=RATE,
        seed=0,
        unit_names=np.array(speaker.unit_names),
        class_names=np.array(speaker.class_names),
        unit_weights=np.zeros((count, 52)),
        identity_weights=speaker.people["clara"],
        neutral=neutral,
        faces=speaker.faces,
        facet_class=speaker.facet_class,
        uv=speaker.uv,
        rotations=np.tile(POSE.rotation_vector, (count, 1)),
        translations=np.tile(POSE.translation, (count, 1)),
        phonemes=np.array(["_"] * count),
        closed=np.zeros(count, bool),
        gap=np.zeros(count),
    )
    write_points(
        camera,
        landmark_pixels=np.zeros((count, 68, 2)),
        landmark_visible=np.ones((count, 68), bool),
        in_picture=np.ones(count, bool),
    )
    (camera / "camera.json").write_text(camera_json(CAMERA), encoding="utf-8")
    write_video(camera / "video.mp4")
    _write_labels(camera)
    entry = ClipEntry("clip", "clara", "_", count, RATE, ("front",))
    record = dataset_record(
        command="", seed=0, engine="0", clips=[entry], labels=tuple(codec.LABELS)
    )
    (folder / "dataset.json").write_text(json.dumps(record), encoding="utf-8")
    write_sums(folder)
    return folder


def _write_labels(camera: Path) -> None:
    for kind in codec.LABELS:
        (camera / kind).mkdir()
    for number, frame in enumerate(labels()):
        seen = frame.ids > 0
        flow = np.broadcast_to(FLOW, (*seen.shape, 2))
        arrays = {
            "ids": frame.ids.astype(np.uint16),
            "depth": codec.encode_depth(frame.read("depth")),
            "normals": codec.encode_normals(frame.read("normals"), seen),
            "albedo": np.where(seen[..., None], frames()[number], 0).astype(np.uint8),
            "flow": codec.encode_flow(flow, seen & (number + 1 < len(JAW))),
        }
        for kind, values in arrays.items():
            write_picture(camera / kind / codec.frame_name(number), values)
