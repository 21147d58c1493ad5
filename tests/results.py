"""A clip of the bundled head with known truth, and what perfect systems would say about it."""

from __future__ import annotations

import csv
import json
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, rotations
from abs_engine.dataset import (
    ClipEntry,
    Truth,
    camera_json,
    dataset_record,
    write_chunk,
    write_points,
    write_sums,
    write_truth,
)
from abs_engine.dataset.clip import LANDMARKS
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.evaluate.estimate import Estimate, of_run
from abs_engine.evaluate.landmark_csv import Reference
from abs_engine.evaluate.metrics import to_camera
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.tracking.results.run_mesh import LinearSurface, RunMesh

FRAMES, RATE = 60, 25.0


@cache
def speaker() -> Speaker:
    return load_speaker()


@cache
def clip(frames: int = FRAMES) -> Truth:
    """A head that nods and turns while its mouth opens three times and purses once."""
    head = speaker()
    time = np.arange(frames) / RATE
    weights = np.zeros((frames, 52))
    weights[:, head.unit_names.index("jawOpen")] = 0.5 * np.sin(4 * time) ** 2 * (time > 0.4)
    weights[:, head.unit_names.index("mouthPucker")] = 0.4 * np.sin(1.3 * time) ** 2
    offsets = np.tensordot(weights, head.units.astype(np.float64), 1)
    turns = rotations(np.stack([0.1 * np.sin(time), 0.2 * np.sin(2 * time), 0 * time], 1))
    vectors = np.array([cv2.Rodrigues(FACING @ turn)[0].ravel() for turn in turns])
    truth = Truth(
        folder=Path("nowhere"),
        camera=Camera.ideal((640, 480)),
        rate=RATE,
        person="kofi",
        sentence="",
        command="",
        seed=0,
        unit_names=head.unit_names,
        unit_weights=weights,
        identity_weights=head.people["kofi"],
        neutral=head.named("kofi"),
        offsets=offsets,
        faces=head.faces,
        facet_class=head.facet_class,
        class_names=head.class_names,
        uv=head.uv,
        rotations=vectors,
        translations=np.tile([5.0, -10, 900], (frames, 1)),
        closed=np.zeros(frames, bool),
        landmarks={**head.landmarks, "landmark_68": head.points["landmark_68"]},
    )
    gaps = [widest_gap(head, truth.vertices(t)) for t in range(frames)]
    truth.closed[:] = np.array(gaps) < CLOSED_BELOW
    return truth


def areas() -> dict[str, np.ndarray]:
    return {k: v for k, v in speaker().points.items() if k != "landmark_68"}


def surface(truth: Truth) -> LinearSurface:
    units = speaker().units.astype(np.float64)
    return LinearSurface(truth.neutral.astype(np.float64), units, truth.unit_weights)


def run_arrays(truth: Truth) -> dict[str, np.ndarray]:
    """A run that found the truth."""
    vertex = np.concatenate([truth.landmarks["outer_lip"], truth.landmarks["inner_lip_8"]])
    return {
        "lip_points": truth.points(vertex),
        "lip_vertex": vertex,
        "rotation": truth.rotations.copy(),
        "translation": truth.translations.copy(),
        "aperture": truth.aperture.copy(),
        "width": truth.width.copy(),
        "closed": truth.closed.copy(),
    }


def perfect(truth: Truth) -> Estimate:
    return of_run("perfect", run_arrays(truth), surface(truth), areas())


def true_landmarks(truth: Truth) -> tuple[np.ndarray, np.ndarray]:
    """The 68 in the picture (T, 68, 2) and in camera coordinates (T, 68, 3)."""
    points = truth.points(truth.landmarks["landmark_68"])
    points = to_camera(points, truth.rotations, truth.translations)
    return truth.camera.project(points), points


def write_csv(path: Path, heading: list[str], rows: list[list]) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([heading, *rows])
    return path


def wide_rows(truth: Truth, pixels: np.ndarray, points: np.ndarray) -> tuple[list, list]:
    """Heading and rows as OpenFace writes them, without pose."""
    heading = ["frame", "timestamp", "success"]
    heading += [f"{axis}_{k}" for axis in "xy" for k in range(68)]
    heading += [f"{axis}_{k}" for axis in "XYZ" for k in range(68)]
    rows = [
        [t + 1, t / truth.rate, 1, *pixels[t].T.ravel().tolist(), *points[t].T.ravel().tolist()]
        for t in range(len(pixels))
    ]
    return heading, rows


def reference_of(truth: Truth) -> Reference:
    """What files of other systems are read against."""
    neutral = truth.neutral.astype(np.float64)
    return Reference(len(truth), truth.rate, neutral, truth.landmarks["landmark_68"])


def arkit_rows(truth: Truth) -> tuple[list, list]:
    """Heading and rows as Live Link Face writes them, a row for each frame."""
    heading = ["Timecode", "BlendShapeCount", *(n[0].upper() + n[1:] for n in truth.unit_names)]
    heading += ["HeadYaw", "HeadPitch", "HeadRoll"]
    head = Rotation.from_matrix(FACING.T @ rotations(truth.rotations)).as_euler("YXZ")
    head *= [-1, 1, -1]  # Unreal's axes are left-handed
    rows = [
        [f"01:02:{t // 25:02d}:{t % 25:02d}.000", 61, *truth.unit_weights[t].tolist(), *head[t]]
        for t in range(len(truth))
    ]
    return heading, rows


def write_dataset(folder: Path, truth: Truth) -> Path:
    """The clip as a dataset without pictures."""
    camera = folder / "clip" / "camera"
    camera.mkdir(parents=True)
    names = ("rate", "seed", "person", "sentence", "command", "unit_names", "class_names", "uv")
    names += ("unit_weights", "identity_weights", "neutral", "faces", "facet_class", "closed")
    pixels, _ = true_landmarks(truth)
    shown = {name: getattr(truth, name) for name in names}
    marks = {name: truth.landmarks[name] for name in LANDMARKS}
    spoken = {"phoneme_label": np.zeros(0, str), "phoneme_start": [], "phoneme_end": []}
    write_truth(
        camera.parent,
        **shown | marks | spoken,
        rotations=truth.rotations,
        translations=truth.translations,
        phonemes=np.array(["_"] * len(truth)),
        gap=np.zeros(len(truth)),
    )
    (camera.parent / "vertices").mkdir()
    write_chunk(camera.parent, 0, np.asarray(truth.offsets, np.float16))
    seen = np.ones((len(truth), 68), bool)
    write_points(camera, landmark_pixels=pixels, landmark_visible=seen, in_picture=seen[:, 0])
    (camera / "camera.json").write_text(camera_json(truth.camera))
    (camera / "video.mp4").write_bytes(b"no pictures are needed here")
    entry = ClipEntry("clip", truth.person, "", len(truth), truth.rate, ("camera",))
    record = dataset_record(command="", seed=0, engine="", clips=[entry], labels=())
    (folder / "dataset.json").write_text(json.dumps(record))
    write_sums(folder)
    return folder


def write_run(folder: Path, truth: Truth, **changed: np.ndarray) -> Path:
    """A run that found the truth, but for what is changed."""
    folder.mkdir()
    arrays = run_arrays(truth)
    frames = len(truth)
    rest = {k: np.zeros(frames) for k in ("value", "score")}
    rest |= {"status": np.full(frames, "converged"), "evaluations": np.zeros(frames, int)}
    rest |= {"index": np.arange(frames), "time": np.arange(frames) / truth.rate}
    rest |= {"found": np.ones(frames, bool), "parameters": np.zeros((frames, 6))}
    kept = rest | arrays | changed
    np.savez(folder / "results.npz", format="abs_engine.run", version=1, **kept)
    shape = surface(truth)
    mesh = RunMesh(shape.mean, shape.modes, shape.weights, truth.faces)
    mesh.save(folder)
    return folder
