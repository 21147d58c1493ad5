"""A small whole file for each reader of the package, and what a file that it accepts must hold."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import whole_files as whole
from mutations import Mutation

from abs_engine.core.errors import AbsEngineError
from abs_engine.dataset.offsets import StoredOffsets
from abs_engine.io.inputs import MOST


@dataclass(frozen=True)
class Reader:
    """A reader and a file for it.

    Parameters
    ----------
    name : str
    file : str
        The name that the file gets; what stands before "." is free.
    make : callable
        Gives the content of a whole file, from the folder in which it will lie.
    call : str
        MODULE:FUNCTION, within the package.
    arguments : callable
        From the path of the file to what the function is given; by default the path.
    unread : tuple of str
        Arrays or keys that it does not look at; "*" for all.
    optional : tuple of str
        Arrays or keys that it may lack.
    gaps : tuple of str
        Fields of the result, or arrays, in which NaN says that something is not known.
    free : tuple of str
        Arrays whose length nothing else says, or that may be a single number.
    empty : tuple of str
        Arrays that may be empty.
    """

    name: str
    file: str
    make: Callable[[Path], bytes]
    call: str
    arguments: Callable[[Path], tuple[Any, ...]] = lambda path: (path,)
    unread: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    gaps: tuple[str, ...] = ()
    free: tuple[str, ...] = ()
    empty: tuple[str, ...] = ()

    def put(self, folder: Path) -> tuple[Path, bytes]:
        """Write the whole file into a folder; its path and content."""
        path = folder / self.file
        path.parent.mkdir(exist_ok=True)
        content = self.make(path.parent)
        path.write_bytes(content)
        return path, content

    def read(self, path: Path) -> Any:
        """What the reader makes of a file."""
        module, _, name = self.call.partition(":")
        found: Any = importlib.import_module(f"abs_engine.{module}")
        for part in name.split("."):
            found = getattr(found, part)
        value = found(*self.arguments(path))
        if hasattr(value, "__exit__"):  # a file that is held open, and locked
            value.__exit__(None, None, None)
        return list(value) if hasattr(value, "__next__") else value

    def may_take(self, change: Mutation) -> bool:
        """Whether a file that was changed so may still be one of its kind."""
        part, (what, _, _) = change.part, change.what.partition(":")
        return (
            not change.wrong
            or part in self.unread
            or "*" in self.unread
            or (what in ("missing", *NULLS) and part in self.optional)
            or (what in ("longer", "shorter", "an axis fewer") and part in self.free)
            or (what == "empty" and part in self.empty)
            or (what == "nan" and part in self.gaps)
        )


def came_of(reader: Reader, path: Path, change: Mutation) -> str:
    """What a reader does with a file that was changed: "refused", "accepted", or what is wrong."""
    path.write_bytes(change.content)
    try:
        found = reader.read(path)
    except AbsEngineError as error:
        return "refused" if str(error).isprintable() else "an error of several lines"
    if not reader.may_take(change):
        return f"accepted {change.what}"
    bad = "" if "*" in reader.unread else problem(found, reader.gaps)
    return f"accepted: {bad} ({change.what})" if bad else "accepted"


def problem(value: Any, gaps: tuple[str, ...] = (), where: str = "") -> str:
    """What cannot be in a result that was read: infinity, NaN but in `gaps`, huge numbers."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        found = [problem(v, gaps, str(k) or where) for k, v in value.items()]
        return next(filter(None, found), "")
    if isinstance(value, (tuple, list)) and value and not isinstance(value[0], (int, float)):
        return next(filter(None, (problem(v, gaps, where) for v in value)), "")
    if isinstance(value, (float, int, np.ndarray, np.generic, tuple, list)):
        numbers = np.asarray(value)
        if numbers.dtype.kind not in "fiu":
            return ""
        if numbers.dtype.kind == "f" and where in gaps:
            numbers = numbers[~np.isnan(numbers)]
        if not np.isfinite(numbers).all():
            return f"{where} is not finite"
        if numbers.size and max(abs(float(numbers.min())), abs(float(numbers.max()))) > MOST:
            return f"{where} is {numbers.min()} to {numbers.max()}"
    return ""


def _clip(_: Path) -> tuple[Any, ...]:
    """The clip that results of other systems are held against; a face of 68 points."""
    from abs_engine.evaluate.landmark_csv import Reference

    neutral = whole.rng().normal(size=(70, 3)) * 30
    return (Reference(frames=2, rate=30.0, neutral=neutral, landmark_68=np.arange(68)),)


def _arkit_arguments(path: Path) -> tuple[Any, ...]:
    return path, *_clip(path), whole.UNITS, np.zeros((52, 70, 3)), {"landmark_68": np.arange(68)}


def _head(path: Path) -> SimpleNamespace:
    """A speaker whose folder is that of the file."""
    return SimpleNamespace(folder=path.parent, imported=False, **vars(whole.head()))


def _beside(path: Path) -> tuple[Any, ...]:
    return (_head(path),)


def _folder(path: Path) -> tuple[Any, ...]:
    return (path.parent,)


class _Seen:
    """A clip of `whole.T` frames by a camera, in the folder of the file."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __len__(self) -> int:
        return whole.T


def _imported(path: Path) -> tuple[Any, ...]:
    from abs_engine.io.assets import load_speaker

    return (load_speaker(path),)


def _track(path: Path) -> tuple[Any, ...]:
    from abs_engine.cli.commands.track import track

    return path, track


def _marked(path: Path) -> tuple[Any, ...]:
    from abs_engine.learn.heads.table import read_table

    return read_table(path).landmarks, whole.VERTICES, path.name


RUN_GAPS = (
    *("parameters", "rotation", "translation", "lip_points", "width", "aperture", "value", "score"),
    *("protrusion", "landmark_distance", "landmark_aperture", "term_values", "closed_probability"),
    *(f"{n}_sd" for n in ("width", "aperture", "protrusion", "lip_points", "rotation")),
    *("translation_sd", "evaluations", "value_unit"),
)
RUN_SPARE = (
    *("engine_version", "renderer", "covered", "contradicted", "value_unit", "parameter_names"),
    *("rotation_sd", "translation_sd", "lip_points_sd", "width_sd", "aperture_sd", "protrusion_sd"),
    *("term_names", "term_values", "person_weights", "camera_matrix", "camera_distortion", "rate"),
    *("camera_size", "protrusion", "landmark_distance", "landmark_aperture", "closed_probability"),
)
SEEN = ("points", "error", "score", "rotations", "translations", "rigid_error", "pixels")
MARKERS = ("points", "residual")
MOVED = ("rotations", "translations", "mirror")
CURVES = ("weights", "rotations", "curves", "aperture", "width", "protrusion")
SPEAKER = ("outer_lip", "inner_lip_upper", "inner_lip_lower", "class_names", "nose_tip", "chin")
OWN = ("own_texture", "points_lips", "looks_x")
FACTORS = ("network_noise_between", "network_noise_within")
TALKING = (
    *("lips", "marks", "regions", "scene.texture", "tex_lin.common", "la_lin.left_out"),
    *(f"rings.{name}" for name in ("outer", "upper", "lower", "points", "corners")),
)
TRUE = ("identity_weights", "outer_lip", "outer_lip_20", "class_names")
GLTF = (  # what glTF may lack, or has a usual value for, and what nobody looks at
    *("asset", "version", "scene", "scenes", "name", "children", "scale", "translation", "extras"),
    *("targetNames", "targets", "POSITION", "TEXCOORD_0", "indices", "material", "byteOffset"),
    *("pbrMetallicRoughness", "baseColorTexture", "bufferView", "byteLength", "nodes", "materials"),
)
NULLS = ('"" for number', "null for number", "null for str", "null for list", "null for dict")
FACE = (
    *("seen", "noise_between", "noise_within", "cheeks", "expression_mixing"),
    *("tex_lin.common", "la_lin.left_out"),  # factors, and frames
)

READERS = (
    Reader("head of a speaker", "head.npz", whole.speaker, "io.assets:load_speaker", free=SPEAKER),
    Reader("imported head", "head.face", whole.imported, "io.assets:load_speaker",
           optional=OWN, free=(*SPEAKER, *OWN)),
    Reader("landmarks of an imported head", "head.face", whole.imported_and_seen,
           "tracking.landmark.landmark_correspondence:load_correspondence", _imported,
           optional=OWN, free=(*SPEAKER, *OWN, *FACTORS), empty=FACTORS),
    Reader("mouths of close-ups", "mouths.face", whole.mouths, "tracking.models.worn:load_looks"),
    Reader("points of a head", "points.json", whole.points, "io.assets:load_points",
           lambda path: (path, whole.V, whole.F), optional=("lips", "what"), unread=("what",)),
    Reader("landmarks of a head", "landmarks.npz", whole.correspondence,
           "tracking.landmark.landmark_correspondence:load_correspondence", _beside,
           free=("noise_between", "noise_within"), empty=("noise_between", "noise_within")),
    Reader("face of a speaker", "me.face", whole.speaker_face,
           "tracking.speaker.speaker_face:load_speaker_face", lambda path: (path, _head(path)),
           optional=whole.COLOURS_SPARE, gaps=("cheeks",), free=FACE,
           empty=("look", "seen", "noise_between", "noise_within", "tex_lin.common")),
    Reader("kind of a model", "me.face", whole.speaker_face, "tracking.presets:model_of_file",
           unread=("*",)),
    Reader("talking face", "face.npz", whole.talking_face, "face.talking_file:load_talking",
           free=TALKING,
           empty=("tex_lin.modes", "tex_lin.common", "la_lin.modes")),
    Reader("trained lips", "lips.npz", whole.physics, "face.shape.modal:load_physics",
           empty=("noise_variances",)),
    Reader("articulatory model", "model.npz", whole.articulatory,
           "face.shape.articulatory_model:load_articulatory"),
    Reader("corpus", "corpus.npz", whole.corpus, "capture.corpus:load_corpus", gaps=("points",)),
    Reader("observations", "seen.npz", whole.observations,
           "capture.observations:read_observations", gaps=SEEN, free=("pixels",),
           empty=("pixels",)),
    Reader("colours", "colours.npz", whole.colours, "face.appearance.colour:ColourClasses.load",
           unread=("classes",), optional=("agreement", "chromatic", "mixed")),
    Reader("truth of a clip", "truth.npz", whole.truth, "dataset.clip:load_clip", _folder,
           free=TRUE, empty=("identity_weights",)),
    Reader("offsets of a clip", "vertices/000000.npz", whole.offsets,
           "dataset.offsets:StoredOffsets.__getitem__",
           lambda path: (StoredOffsets(path.parent.parent, whole.T, whole.V), 0)),
    Reader("landmarks of a view", "points.npz", whole.view_points,
           "dataset.view:Truth._points.func", lambda path: (_Seen(path.parent),),
           optional=("mirror_landmark_pixels", "mirror_landmark_visible"),
           gaps=("mirror_landmark_pixels",)),
    Reader("camera", "camera.json", whole.camera, "dataset.camera_file:load_placed_camera",
           optional=MOVED),
    Reader("dataset", "dataset.json", whole.dataset_record, "dataset.dataset:read_record", _folder),
    Reader("checksums", "SHA256SUMS", whole.sums, "dataset.sums:read_sums", _folder),
    Reader("label picture", "ids.png", lambda _: whole.png(np.uint16, (6, 8)),
           "dataset.picture:read_picture", lambda path: (path, "ids", (8, 6))),
    Reader("picture, PNG", "photo.png", lambda _: whole.png(np.uint8, (6, 8, 3)),
           "io.assets:read_image"),
    Reader("picture, JPEG", "photo.jpg", lambda _: whole.jpeg((16, 24, 3)), "io.assets:read_image"),
    Reader("run", "results.npz", whole.run, "tracking.runs.record:load_run", _folder,
           optional=RUN_SPARE, gaps=RUN_GAPS, free=("person_weights",),
           empty=("person_weights",)),
    Reader("mesh of a run", "mesh.npz", whole.mesh, "tracking.results.run_mesh:load_mesh", _folder,
           gaps=("weights",), free=("faces", "weights")),
    Reader("frames of a run", "frames.journal", whole.journal,
           "tracking.results.frame_journal:FrameJournal", lambda path: (path, "basis"),
           unread=("*",)),
    Reader("facts of a run", "run.json", whole.summary, "report.facts:run_facts", _folder,
           unread=("*",)),
    Reader("checksum of a run", "run.json", whole.summary, "evaluate.same_clip:video_sum", _folder,
           unread=("*",)),
    Reader("settings", "settings.toml", lambda _: b'renderer = "cpu"\npupil-distance = 63.4\n',
           "cli.parts.settings:read_settings", _track),
    Reader("poses, NPZ", "poses.npz", whole.pose_arrays, "tracking.runs.poses_file:read_poses",
           optional=("found",), gaps=("rotation", "translation")),
    Reader("poses, CSV", "poses.csv", whole.pose_table, "tracking.runs.poses_file:read_poses"),
    Reader("head poses", "head.csv", whole.head_poses, "capture.head:read_head_poses",
           lambda path: (path, whole.T), gaps=("rotations", "translations", "error")),
    Reader("reference points", "reference.csv", lambda _: b"point,x,y,z\na,1,2,3\nb,4,5,6\n",
           "capture.head:read_reference"),
    Reader("markers, CSV", "m.csv", whole.markers_csv, "capture.markers:read_markers",
           gaps=MARKERS),
    Reader("markers, C3D", "m.c3d", whole.c3d, "capture.markers:read_markers", gaps=MARKERS),
    Reader("dots, CSV", "dots.csv", lambda _: b"frame,view,point,x,y\n0,1,a,1.5,2.5\n0,2,b,3,4\n",
           "capture.dot_annotations:read_marks"),
    Reader("dots, JSON", "dots.json", whole.dots_json, "capture.dot_annotations:read_marks",
           optional=("frame", "view", "x", "y")),
    Reader("table of a corpus, JSON", "table.json", whole.table_json,
           "capture.corpus_table:read_table", optional=("visemes", "upper_teeth", "ipi", "lips"),
           unread=("a",)),
    Reader("table of a corpus, CSV", "table.csv",
           lambda _: b"what,name,value\npoint,m1,lips\nviseme,ipi,1\nviseme,a,2-3\n",
           "capture.corpus_table:read_table"),
    Reader("pictures of visemes", "pictures.csv", whole.viseme_pictures,
           "capture.viseme_pictures:read_viseme_pictures", lambda path: (path, ("a", "ipi"))),
    Reader("landmarks, CSV", "marks.csv", whole.landmarks_csv,
           "evaluate.landmark_csv:read_landmarks", lambda path: (path, *_clip(path)),
           gaps=("pixels", "landmarks", "curves", "aperture")),
    Reader("ARKit, CSV", "arkit.csv", whole.arkit_csv, "evaluate.arkit_csv:read_arkit",
           _arkit_arguments, gaps=CURVES),
    Reader("Live Link", "live.csv", whole.arkit_csv, "studio.speech.livelink:read_livelink"),
    Reader("TextGrid", "speech.TextGrid", whole.textgrid, "studio.speech.textgrid:read_textgrid"),
    Reader("scene", "scene.toml", whole.scene, "studio.scenefile.reader:read_scene"),
    Reader("predictors", "predictors.toml", whole.predictors,
           "report.articulation.predictor_file:read_predictors"),
    Reader("numbers of vertices", "values.npz",
           lambda _: whole.npz("x", 1, values=np.ones(whole.V)),
           "report.inspect.heat:read_values", lambda path: (path, whole.V)),
    Reader("numbers of vertices, NPY", "values.npy", whole.npy, "report.inspect.heat:read_values",
           lambda path: (path, whole.V)),
    Reader("head of another program, GLB", "head.glb", whole.glb, "io.morphs:read_morphs"),
    Reader("head of another program, glTF", "head.gltf", whole.gltf, "io.morphs:read_morphs",
           unread=GLTF),
    Reader("head of another program, OBJ", "head.obj", whole.obj, "io.morphs:read_morphs",
           lambda path: (path, path.parent)),
    Reader("ICT's face model", "ict_face_model.npz", whole.ict, "io.morphs:read_morphs",
           lambda path: (path.parent, None), free=("identity_deltas",), empty=("identity_deltas",)),
    Reader("table of a head", "head.toml", lambda _: whole.HEAD_TABLE,
           "learn.heads.marks:find_marks", _marked),
    Reader("labels of close-ups", "labels.csv", whole.mouth_labels,
           "tracking.models.worn_labels:read_mouths"),
    Reader("video, what it is", "clip.mp4", whole.video, "io.video:probe"),
    Reader("video, its frames", "clip.mp4", whole.video, "io.video:read_frames"),
)  # fmt: skip
