"""A small whole file for each reader of the package."""

from __future__ import annotations

import io
import itertools
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np

from abs_engine.dataset.codec import FORMAT as TRUTH


def npz(kind: str, version: int, **arrays: Any) -> bytes:
    """An archive of arrays, with its format and version."""
    made = io.BytesIO()
    np.savez_compressed(made, **arrays, format=kind, version=version)
    return made.getvalue()


def rng() -> np.random.Generator:
    return np.random.default_rng(7)


VERTICES = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9], [9, 9, 0]], np.float32)
FACES = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]], np.int32)
V, F, T = len(VERTICES), len(FACES), 4


def speaker_arrays() -> dict[str, Any]:
    draw, names = rng(), np.array([f"unit{k}" for k in range(52)])
    lists = {"outer_lip": 5, "inner_lip_upper": 3, "inner_lip_lower": 3, "outer_lip_20": 12,
             "inner_lip_8": 8, "mouth_corners": 2, "eye_corners": 4, "nose_tip": 1,
             "chin": 1}  # fmt: skip
    return dict(
        vertices=VERTICES, faces=FACES,
        uv=draw.random((V, 2), np.float32), weld=np.arange(V, dtype=np.int32),
        facet_class=np.ones(F, np.uint8), class_names=np.array(["background", "skin"]),
        unit_names=names, units=draw.normal(size=(52, V, 3)).astype(np.float16),
        identity_names=np.array(["a", "b"]), identity=np.ones((2, V, 3), np.float16),
        people_names=np.array(["x"]), people=np.ones((1, 2), np.float32),
        **{name: np.arange(n, dtype=np.int32) % V for name, n in lists.items()},
    )  # fmt: skip


def speaker(_: Path) -> bytes:
    return npz("abs_engine.speaker", 1, **speaker_arrays())


def imported(_: Path) -> bytes:
    own = {"own_texture": np.full((6, 8, 3), 9, np.uint8), "points_lips": np.arange(3)}
    own["looks_x"] = np.full((4, 4, 3), 7, np.uint8)
    return npz("abs_engine.speaker", 1, **speaker_arrays(), **own)


def imported_and_seen(_: Path) -> bytes:
    network = {f"network_{name}": value for name, value in correspondence_arrays().items()}
    texture = np.full((6, 8, 3), 9, np.uint8)
    return npz("abs_engine.speaker", 1, **speaker_arrays(), own_texture=texture, **network)


def mouths(_: Path) -> bytes:
    from abs_engine.face.appearance.opening import PLACES, SIDES

    draw, widths = rng(), (len(PLACES) + 3, 6, 5, len(SIDES))
    layers: dict[str, Any] = {"layers": len(widths) - 1}
    for k, (m, n) in enumerate(itertools.pairwise(widths)):
        layers[f"weights{k}"] = draw.normal(size=(m, n)).astype(np.float32)
        layers[f"offsets{k}"] = np.zeros(n, np.float32)
    flat = np.ones(widths[0], np.float32)
    return npz("abs_engine.worn_mouths", 1, mean=flat, spread=flat, **layers)


def points(_: Path) -> bytes:
    lists = {"lips": {"what": "the lips", "vertices": [0, 1, 2]}}
    told = {"format": "abs_engine.points", "version": 1, "vertices": V, "faces": F, "lists": lists}
    return json.dumps(told).encode()


def physics(_: Path) -> bytes:
    draw = rng()
    return npz(
        "abs_engine.learned_physics", 2, rest=VERTICES.astype(float), mean=np.zeros((V, 3)),
        modes=draw.normal(size=(2, V, 3)), variances=np.array([2.0, 1.0]), total=3.5, noise=0.1,
        person="x", speaker="0123", source="made", noise_variances=np.array([0.1, 0.2]),
    )  # fmt: skip


def articulatory(_: Path) -> bytes:
    predictors = [{"name": "jaw1", "points": ["p0"], "coordinates": "y", "positive": "+y"}]
    told = json.dumps({"predictors": predictors, "groups": {"lips": ["p0", "p1"]}})
    return npz(
        "abs_engine.articulatory_model", 1, names=np.array(["p0", "p1"]), mean=np.zeros((2, 3)),
        modes=np.ones((1, 2, 3)), variance=np.array([0.5]), told=told, source="made",
    )  # fmt: skip


def corpus(_: Path) -> bytes:
    return npz(
        "abs_engine.corpus", 1, points=rng().normal(size=(3, 2, 3)), names=np.array(["p0", "p1"]),
        visemes=np.array(["a", "i", "u"]), groups=json.dumps({"lips": ["p0"]}),
        rotation=np.eye(3), translation=np.zeros(3), source="made",
    )  # fmt: skip


def observations(_: Path) -> bytes:
    found, flat = np.ones((T, 2), bool), np.full((T, 2), 0.2)
    return npz(
        "abs_engine.observations", 1, points=rng().normal(size=(T, 2, 3)), found=found,
        names=np.array(["p0", "p1"]), uncertain=~found, error=flat, score=flat, rate=25.0,
        rotations=np.zeros((T, 3)), translations=np.zeros((T, 3)), rigid_error=np.zeros(T),
        pixels=np.ones((2, T, 2, 2)), source="made",
    )  # fmt: skip


def colour_arrays() -> dict[str, Any]:
    parts: dict[str, Any] = {}
    for name in ("skin", "lips", "teeth", "dark"):
        parts[f"{name}_weights"] = np.array([0.25, 0.75])
        parts[f"{name}_means"] = rng().random((2, 3))
        parts[f"{name}_covariances"] = np.tile(np.eye(3), (2, 1, 1))
    return {
        "priors": np.array([1.0, 1.0, 0.5, 0.5]), "reference": 100.0, "agreement": 1.0,
        "chromatic": True, "mixed": 1, **parts,
    }  # fmt: skip


def colours(_: Path) -> bytes:
    classes = np.array(["skin", "lips", "teeth", "dark"])
    return npz("abs_engine.colours", 2, classes=classes, **colour_arrays())


COLOURS_SPARE = ("colours_agreement", "colours_chromatic", "colours_mixed")


def truth(_: Path) -> bytes:
    marks = {"outer_lip": 4, "outer_lip_20": 20, "inner_lip_8": 8, "mouth_corners": 2}
    marks["landmark_68"] = 68
    return npz(
        TRUTH, 2, rate=25.0, seed=0, person="x", sentence="a", command="made",
        unit_names=np.array([f"unit{k}" for k in range(52)]), unit_weights=np.zeros((T, 52)),
        class_names=np.array(["background", "skin"]), phonemes=np.array(["a"] * T),
        identity_weights=np.ones(2, np.float32), neutral=VERTICES, faces=FACES,
        facet_class=np.ones(F, np.uint8), uv=np.zeros((V, 2), np.float32),
        rotations=np.zeros((T, 3)), translations=np.zeros((T, 3)),
        phoneme_label=np.array(["a"]), phoneme_start=np.array([0.0]), phoneme_end=np.array([0.1]),
        closed=np.zeros(T, bool), gap=np.ones(T),
        **{name: np.arange(n, dtype=np.int32) % V for name, n in marks.items()},
    )  # fmt: skip


def offsets(_: Path) -> bytes:
    return npz("abs_engine.offsets", 2, offsets=np.ones((T, V, 3), np.float16))


def camera(_: Path) -> bytes:
    told = {
        "format": "abs_engine.camera", "version": 2, "size": [64, 48],
        "matrix": [[100.0, 0, 31.5], [0, 100.0, 23.5], [0, 0, 1]],
        "distortion": [0.1, 0.0, 0.0, 0.0], "near": 10.0, "far": 5000.0,
        "rotations": [[0.0, 0.1, 0.0]], "translations": [[0.0, 0.0, 600.0]],
        "mirror": {"rectangle": [[0.0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]},
    }  # fmt: skip
    return json.dumps(told).encode()


def dataset_record(_: Path) -> bytes:
    clip = {
        "name": "talk", "person": "x", "sentence": "a", "frames": T, "rate": 25.0,
        "cameras": ["front"],
    }  # fmt: skip
    told = {
        "format": "abs_engine.dataset", "version": 2, "command": "made", "engine": "0.1",
        "seed": 0, "clips": [clip], "labels": ["ids", "depth"],
    }  # fmt: skip
    return json.dumps(told).encode()


def run_arrays(frames: int = T, lips: int = 3) -> dict[str, Any]:
    """The arrays of a run."""
    draw = rng()
    one, three = draw.random(frames), draw.normal(size=(frames, 3))
    names = ("width", "aperture", "protrusion", "value", "score", "landmark_distance",
             "landmark_aperture", "width_sd", "aperture_sd", "protrusion_sd",
             "closed_probability")  # fmt: skip
    yes = np.ones(frames, bool)
    return {
        "engine_version": "0.1", "renderer": "cpu", "index": np.arange(frames), "time": one,
        "found": yes, "covered": ~yes, "contradicted": ~yes, "closed": ~yes,
        "evaluations": np.arange(frames), "status": np.array(["tracked"] * frames),
        "value_unit": np.ones(frames), "parameters": draw.normal(size=(frames, 8)),
        "parameter_names": np.array([f"p{k}" for k in range(8)]), "rotation": three,
        "translation": three, "rotation_sd": abs(three), "translation_sd": abs(three),
        "lip_points": draw.normal(size=(frames, lips, 3)),
        "lip_points_sd": draw.random((frames, lips, 3)),
        "lip_vertex": np.arange(lips, dtype=np.int32), "term_names": np.array(["colour"]),
        "term_values": draw.random((frames, 1)), "person_weights": np.ones(2),
        "camera_matrix": np.array([[100.0, 0, 31.5], [0, 100.0, 23.5], [0, 0, 1]]),
        "camera_distortion": np.zeros(8), "camera_size": np.array([64, 48]), "rate": 25.0,
        **dict.fromkeys(names, one),
    }  # fmt: skip


def run(_: Path) -> bytes:
    return npz("abs_engine.run", 1, **run_arrays())


def mesh(_: Path) -> bytes:
    return npz(
        "abs_engine.run_mesh", 1, mean=VERTICES, modes=np.ones((2, V, 3), np.float32),
        weights=rng().normal(size=(T, 2)), faces=FACES, rest=VERTICES,
    )  # fmt: skip


def summary(_: Path) -> bytes:
    told = {
        "engine_version": "0.1", "renderer": "cpu",
        "settings": {"video": "a.mp4", "video_sha256": "00", "scale": {"eye": 63.0}, "seeds": [1]},
        "summary": {"frames": T, "mean_score": 0.9, "warnings": ["none"]},
    }  # fmt: skip
    return json.dumps(told).encode()


def pose_arrays(_: Path) -> bytes:
    made = io.BytesIO()
    turns = np.tile([np.pi, 0.0, 0.0], (T, 1))
    np.savez(made, rotation=turns, translation=np.full((T, 3), 600.0), found=np.ones(T, bool))
    return made.getvalue()


def pose_table(_: Path) -> bytes:
    head = "index,head_rx,head_ry,head_rz,head_tx,head_ty,head_tz\n"
    return (head + "".join(f"{k},3.1,0.0,0.1,1.5,2.5,600\n" for k in range(T))).encode()


def head_poses(_: Path) -> bytes:
    return (
        "frame,rx,ry,rz,tx,ty,tz\n" + "".join(f"{k},0,0.1,0,1,2,3\n" for k in range(T))
    ).encode()


def markers_csv(_: Path) -> bytes:
    rows = "".join(f"{k / 60},1.5,2.5,3.5,4.5,5.5,6.5\n" for k in range(T))
    return ("time,a_x,a_y,a_z,b_x,b_y,b_z\n" + rows).encode()


def c3d(_: Path) -> bytes:
    import c3d

    writer = c3d.Writer(point_rate=60.0, analog_rate=0)
    writer.set_point_labels(["a", "b"])
    for k in range(T):
        rows = np.array([[1.5 + k, 2, 3, 0, 0], [4, 5, 6, 0, 0]], np.float32)
        writer.add_frames([(rows, np.zeros((0, 0), np.float32))])
    made = io.BytesIO()
    writer.write(made)
    return made.getvalue()


def dots_json(_: Path) -> bytes:
    rows = [
        {"point": "a", "x": 1.5, "y": 2.5, "frame": 0, "view": 1},
        {"point": "b", "x": 1, "y": 2},
    ]
    return json.dumps({"format": "abs_engine.dots", "version": 1, "points": rows}).encode()


def table_json(_: Path) -> bytes:
    told = {
        "groups": {"lips": ["m1", "m2"]}, "visemes": {"ipi": 1, "a": [2, 3]},
        "upper_teeth": ["right", "left", "front"],
    }  # fmt: skip
    return json.dumps(told).encode()


def viseme_pictures(folder: Path) -> bytes:
    (folder / "a.png").write_bytes(b"")
    return b"picture,viseme,rx,ry,rz,tx,ty,tz\na.png,a,3.1,0,0,1,2,640\na.png,ipi,,,,,,\n"


def landmarks_csv(_: Path) -> bytes:
    rows = [f"{t},{k},{100 + 3 * k},{90 + 2 * k},px" for t in range(2) for k in range(68)]
    return ("frame,point,x,y,unit\n" + "\n".join(rows) + "\n").encode()


UNITS = ("jawOpen", *(f"unit{k}" for k in range(51)))


def arkit_csv(_: Path) -> bytes:
    head = ["Timecode", "BlendShapeCount", *UNITS, "HeadYaw", "HeadPitch", "HeadRoll"]
    rows = [",".join([f"10:00:00:{t:02d}.000", "61", *["0.1"] * 52, "0", "0", "0"]) for t in (0, 1)]
    return ("\n".join([",".join(head), *rows]) + "\n").encode()


def textgrid(_: Path) -> bytes:
    return (
        b'File type = "ooTextFile"\nObject class = "TextGrid"\n\nxmin = 0\nxmax = 0.5\n'
        b'tiers? <exists>\nsize = 1\nitem []:\n    item [1]:\n        class = "IntervalTier"\n'
        b'        name = "phones"\n        xmin = 0\n        xmax = 0.5\n'
        b"        intervals: size = 2\n        intervals [1]:\n            xmin = 0\n"
        b'            xmax = 0.2\n            text = "a"\n        intervals [2]:\n'
        b'            xmin = 0.2\n            xmax = 0.5\n            text = "m"\n'
    )


def scene(_: Path) -> bytes:
    from abs_engine.io.assets import shipped

    return shipped("scenes/speech.toml").read_bytes()


def predictors(_: Path) -> bytes:
    return (
        b'format = "abs_engine.predictors"\nversion = 1\n\n[[predictor]]\nname = "jaw1"\n'
        b'points = ["jaw_line"]\ncoordinates = "y"\npositive = "+y"\n'
    )


def video(folder: Path) -> bytes:
    from abs_engine.io.video import VideoWriter

    path, draw = folder / "made.mp4", rng()
    with VideoWriter(path, (32, 32), 25.0, 20) as video:
        for _ in range(6):
            video.write(draw.integers(0, 255, (32, 32, 3), np.uint8))
    content = path.read_bytes()
    path.unlink()
    return content


def png(kind: Any, shape: tuple[int, ...]) -> bytes:
    values = rng().integers(0, 255, shape).astype(kind)
    return cv2.imencode(".png", values)[1].tobytes()


def sums(folder: Path) -> bytes:
    return f"{'0' * 64}  dataset.json\n{'1' * 64}  talk/truth.npz\n".encode()


def noise_arrays() -> dict[str, Any]:
    flat, deep = np.ones((468, 3), np.float16), np.ones((1, 468, 3), np.float16)
    return {
        "noise_bias": flat, "noise_between": deep, "noise_within": deep, "noise_deviation": flat,
        "noise_person_deviation": flat,
    }  # fmt: skip


def correspondence_arrays() -> dict[str, Any]:
    flat = np.ones((468, 3), np.float32)
    return {
        "corners": np.zeros((468, 3), np.int32), "weights": flat / 3, "deviation": flat,
        **noise_arrays(),
    }  # fmt: skip


def correspondence(_: Path) -> bytes:
    return npz("abs_engine.landmarks", 2, **correspondence_arrays())


def head() -> Any:
    """Parts of the head of all files by which it is known."""
    return SimpleNamespace(vertices=VERTICES, faces=FACES, facet_class=np.ones(F, np.uint8))


def speaker_face(_: Path) -> bytes:
    from abs_engine.learn.training import checksum

    draw, size = rng(), (6, 8)
    colour = {f"colours_{name}": value for name, value in colour_arrays().items()}
    return npz(
        "abs_engine.speaker_face", 1, head=checksum(head()), neutral=VERTICES,
        names=np.array(["a", "b"]), lower=-np.ones(2), upper=np.ones(2), steps=np.ones(2),
        seen=np.zeros((1, 2)), bias=np.zeros((468, 2)), deviation=np.ones((468, 3)),
        shift=np.zeros(6), camera_matrix=np.array([[100.0, 0, 3.5], [0, 100.0, 2.5], [0, 0, 1]]),
        camera_distortion=np.zeros(8), camera_size=np.array(size[::-1]),
        cheeks=draw.random((2, 3)), look=np.array([0.5, 0.5, 0.5]),
        view_gray=np.ones((2, *size), np.uint8), view_vertices=np.stack([VERTICES] * 2),
        view_rotation=np.stack([np.eye(3)] * 2), view_translation=np.ones((2, 3)),
        expression_mean=VERTICES, expression_modes=draw.random((2, V, 3), np.float32),
        expression_mixing=draw.random((2, 3)), expression_offset=np.zeros(3),
        expression_variance=np.array([0.5, 0.4]), scale_source="given", scale_pupils=63.0,
        scale_uncertainty=0.01, **colour, **noise_arrays(), **appearance(),
    )  # fmt: skip


def appearance() -> dict[str, Any]:
    """Texture of 4x5 texels and local appearance of three points, by two parameters."""
    draw, flat, points = rng(), (4, 5), 3
    tex = {
        "base": draw.random((*flat, 3), np.float32), "mean": draw.random((*flat, 3), np.float32),
        "modes": draw.random((2, *flat, 3), np.float32), "frames": np.ones(flat, np.int32),
        "explained": 0.5, "spread": np.ones(flat, np.float32),
        "common": draw.random((1, *flat, 3), np.float32),
    }  # fmt: skip
    local = {
        "vertices": np.arange(points), "base": draw.random((points, 8)),
        "modes": draw.random((2, points, 8)), "mean": draw.random((points, 8)),
        "sigma": np.full(points, 2.0), "spread": np.ones((points, 8)),
        "left_out": draw.random((6, points, 8), np.float32), "seen": np.ones(points),
        "facing": np.ones(points), "reach": np.ones(2), "explained": 0.5, "unit": 0.0,
    }  # fmt: skip
    return {
        **{f"tex_lin.{name}": value for name, value in tex.items()},
        **{f"la_lin.{name}": value for name, value in local.items()},
        "la_per_mm": 0.8, "la_own_share": 0.5, "tex_per_mm": 0.4,
        "tex_noise": 0.01, "tex_observations": 9.0,
        "tex_cst_is_constant_tex_lin": True, "la_cst_is_constant_la_lin": True,
    }  # fmt: skip


def talking_face(folder: Path) -> bytes:
    from talkers import learned_face

    from abs_engine.face.talking_file import save_talking

    path = folder / "made.npz"
    save_talking(path, learned_face(), "clara", "0123456789abcdef")
    content = path.read_bytes()
    path.unlink()
    return content


def view_points(_: Path) -> bytes:
    pixels, seen = np.ones((T, 68, 2)), np.ones((T, 68), bool)
    return npz(
        "abs_engine.landmarks", 2, landmark_pixels=pixels, landmark_visible=seen,
        mirror_landmark_pixels=pixels, mirror_landmark_visible=seen, in_picture=np.ones(T, bool),
    )  # fmt: skip


def journal(folder: Path) -> bytes:
    from abs_engine.core.geometry import Pose
    from abs_engine.tracking.frame.clip_setting import FrameResult
    from abs_engine.tracking.frame.frame_state import Memory
    from abs_engine.tracking.results.frame_journal import FrameJournal

    path, pose = folder / "made.journal", Pose(np.eye(3), np.array([0, 0, 600.0]))
    with FrameJournal(path, "basis") as kept:
        for k in range(T):
            found = FrameResult(k, True, np.zeros(8), pose, VERTICES, 50.0, 3.0, 1.0, 0.9, 5, "ok")
            kept.add(found, Memory(np.zeros(8), pose, np.zeros(8), (1.0,)))
    content = path.read_bytes()
    path.unlink()
    return content


def jpeg(shape: tuple[int, ...]) -> bytes:
    return cv2.imencode(".jpg", rng().integers(0, 255, shape).astype(np.uint8))[1].tobytes()


def _gltf(uri: str | None) -> tuple[dict[str, Any], bytes]:
    """A triangle of three vertices that one target moves, with a picture; its numbers."""
    pieces = [
        VERTICES[:3].tobytes(), np.ones((3, 3), np.float32).tobytes(),
        rng().random((3, 2), np.float32).tobytes(), np.arange(4, dtype=np.uint16).tobytes(),
        png(np.uint8, (4, 4, 3)),
    ]  # fmt: skip
    starts = np.cumsum([0, *map(len, pieces)]).tolist()
    content = b"".join(pieces)
    places = {"componentType": 5126, "count": 3}
    told = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [2, 2, 2]}, {"mesh": 0, "translation": [0, 1, 0]}],
        "meshes": [{
            "primitives": [{
                "attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 3, "material": 0,
                "targets": [{"POSITION": 1}],
            }],
            "extras": {"targetNames": ["jawOpen"]},
        }],
        "materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"bufferView": 4}],
        "accessors": [
            {"bufferView": 0, "type": "VEC3", **places},
            {"bufferView": 1, "type": "VEC3", **places},
            {"bufferView": 2, "type": "VEC2", **places},
            {"bufferView": 3, "type": "SCALAR", "componentType": 5123, "count": 3},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": at, "byteLength": len(piece)}
            for at, piece in zip(starts, pieces, strict=False)
        ],
        "buffers": [{"byteLength": len(content)} | ({} if uri is None else {"uri": uri})],
    }  # fmt: skip
    return told, content


def gltf(folder: Path) -> bytes:
    told, content = _gltf("numbers.bin")
    (folder / "numbers.bin").write_bytes(content)
    return json.dumps(told).encode()


def glb(_: Path) -> bytes:
    told, content = _gltf(None)
    text = json.dumps(told).encode()
    parts = (
        (b"JSON", text + b" " * (-len(text) % 4)),
        (b"BIN\0", content + bytes(-len(content) % 4)),
    )
    body = b"".join(len(part).to_bytes(4, "little") + kind + part for kind, part in parts)
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little") + body


def obj(folder: Path) -> bytes:
    places = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 9 9 1\n"
    (folder / "jawOpen.obj").write_text(places.replace("9 9 1", "9 8 1"))
    return f"o head\n{places}vt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 2/2 4/1 -2/3\n".encode()


def ict(folder: Path) -> bytes:
    (folder / "generic_neutral_mesh.obj").write_bytes(obj(folder))
    draw = rng()
    made = io.BytesIO()
    np.savez(
        made, expression_names=np.array(["jawOpen", "mouthClose"]),
        expression_deltas=draw.random((2, 4, 3), np.float32),
        identity_deltas=draw.random((3, 4, 3), np.float32),
    )  # fmt: skip
    return made.getvalue()


HEAD_TABLE = b"""length = "cm"
[units]
jawOpen = [ "open" , "wide" ]
[regions]
Teeth = "teeth"
[landmarks]
outer_lip = [ 0 , 1 , 2 , 3 , 4 , 0 , 1 , 2 , 3 , 4 , 1 , 2 ]
inner_lip = [ 0 , 1 , 2 , 3 , 4 , 0 , 1 , 2 ]
eye_corners = [ 0 , 1 , 2 , 3 ]
nose_tip = 3
chin = [ [ 0.1 , 0.2 , 0.3 ] ]
[people]
mei = "mei.obj"
"""


def npy(_: Path) -> bytes:
    made = io.BytesIO()
    np.save(made, rng().random(5))
    return made.getvalue()


def mouth_labels(folder: Path) -> bytes:
    from abs_engine.tracking.models.worn_labels import COLUMNS

    (folder / "clip.mp4").write_bytes(video(folder))
    mouth = [[3, 12], [20, 12], [7, 10], [7, 14], [11, 9], [11, 15], [16, 10], [16, 14]]
    rows = (np.ravel(mouth) + rng().uniform(-1, 1, (2, len(COLUMNS)))).round(2).tolist()
    lines = [f"clip.mp4,{k},{','.join(map(str, row))}" for k, row in enumerate(rows)]
    return "\n".join([f"video,frame,{','.join(COLUMNS)}", *lines]).encode()
