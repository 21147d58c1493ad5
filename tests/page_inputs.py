"""What the pages of docs/ speak of as their reader's own: clips, recordings, heads, dots, scenes.

All of it is made here, small and short, of the bundled people.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from drawn import lit
from heads import seen_at
from imported import FEW, OUTER_CLASSES, facets_of, table, write_glb, write_obj
from lip_clips import FRONT, LEFT, write_lip_run
from marker_files import write_c3d
from observe_session import Session, authored
from observed import seen_from
from runs import write_kind
from session_files import write_csv

from abs_engine.capture.head import HeadChoice, head_motion
from abs_engine.capture.observations import write_observations
from abs_engine.dataset import camera_json
from abs_engine.face.shape.predictors import PAPER_PREDICTORS
from abs_engine.io.assets import load_speaker
from abs_engine.io.files import png
from abs_engine.io.video import VideoWriter, read_frames
from abs_engine.learn.spoken import SpokenCorpus
from abs_engine.papers.basu1998.experiment import OBSERVED
from abs_engine.papers.basu1998.motion import UNROUNDED, authored_motion, observed_motion
from abs_engine.report.articulation.predictor_file import predictors_text
from abs_engine.studio.corpus import speak_corpus
from abs_engine.studio.corpus.visemes import PAPER_VISEMES

ROOT = Path(__file__).resolve().parents[1]
SCENES = ROOT / "assets" / "scenes"
CLIP = 2
"""Frames of the clip, which is tracked by all pages."""
RECORDED = 6
"""Frames of a speaker's recording."""
DOTTED = 140
"""Frames of dots that `train` learns from."""


def pictures_of(video: Path, count: int) -> list[np.ndarray]:
    """The first pictures of a video."""
    return [image for image, _ in zip(read_frames(video), range(count), strict=False)]


def write_film(path: Path, pictures: list[np.ndarray]) -> None:
    """A film without loss."""
    with VideoWriter(path, pictures[0].shape[1::-1], 25.0, 0) as film:
        for picture in pictures:
            film.write(picture)


def two_faces(folder: Path) -> None:
    """The clip's face, twice in each picture."""
    pictures = pictures_of(folder / "talk.mp4", CLIP)
    write_film(folder / "two.mp4", [np.hstack([one, one]) for one in pictures])


def recordings(folder: Path) -> None:
    """A speaker, who opens and rounds the mouth, on two days."""
    for name, began in (("monday", 0.0), ("tuesday", 3.0)):
        write_kind(folder / f"{name}.mp4", "libx264", list(_recorded(began)))


def _recorded(began: float) -> Iterator[np.ndarray]:
    for time in began + 1.2 * np.arange(RECORDED):
        pose = seen_at([0, 0.1 * np.sin(0.3 * time), 0], [0, 0, 700])
        opened, rounded = 0.35 * np.sin(0.5 * time), 0.8 * np.sin(0.35 * time + 1)
        yield lit("mei", pose, jawOpen=max(0.0, opened), mouthPucker=max(0.0, rounded))


def other_heads(folder: Path) -> None:
    """The bundled head as another program would write it, as GLB and as OBJ."""
    head = load_speaker()
    write_glb(folder / "head.glb")
    (folder / "head.toml").write_text(table(head), encoding="utf-8")
    outer, shapes = facets_of(head, *OUTER_CLASSES), folder / "shapes"
    write_obj(folder / "head.obj", head.vertices, outer)
    shapes.mkdir()
    for name in FEW:
        write_obj(shapes / f"{name}.obj", head.vertices + head.unit_matrix((name,))[0], outer)


def marked_dots(folder: Path) -> None:
    """A head with dots before two calibrated cameras, and where the dots are in frame 0."""
    session = Session(folder, authored(2), finer=1)
    for side, film, place in zip(("left", "right"), session.videos, session.places, strict=True):
        film.rename(folder / f"{side}.mp4")
        file = camera_json(session.camera, [place.rotation_vector], [place.translation])
        (folder / f"{side}.json").write_text(file, encoding="utf-8")
    session.write_points(folder / "dots.csv")


def longer_session(folder: Path) -> None:
    """Dots of as many frames as lips are learned from, in place of those of a few.

    In the frame in which the page observes them: by the nose, as the head does not turn.
    """
    motion = authored_motion(load_speaker(), "clara", frames=DOTTED, sentences=UNROUNDED)
    dots = observed_motion(load_speaker(), motion, noise=OBSERVED, seed=0)
    frame = head_motion(dots.points, dots.names, HeadChoice(unturned="nose"))
    (folder / "dots.npz").unlink()
    write_observations(folder / "dots.npz", replace(dots, points=frame.to_head(dots.points)))


def undotted(folder: Path) -> None:
    """Runs of two cameras at once, and of another day."""
    write_lip_run(folder / "run-front", range(5, 10), FRONT)
    write_lip_run(folder / "run-side", range(5, 10), LEFT)
    write_lip_run(folder / "run-monday", range(12, 17), FRONT)


def recorded_points(folder: Path) -> None:
    """Some visemes of a speaker and some points, what these are, and pictures of the visemes."""
    head = load_speaker()
    visemes = ("rest", *(name for name in PAPER_VISEMES[::3] if name != "rest"))
    spoken = speak_corpus(head, head.named("mei"), visemes)
    names, points = spoken.corpus.names[::4], spoken.corpus.points[:, ::4]
    for name in ("mine", "speech"):
        write_c3d(folder / f"{name}.c3d", names, points)
    groups = spoken.corpus.groups.items()
    rows = [("point", name, group) for group, those in groups for name in those if name in names]
    rows += [("viseme", name, frame) for frame, name in enumerate(visemes)]
    write_csv(folder / "mine.csv", ("what", "name", "value"), rows)
    (folder / "mine.toml").write_text(predictors_text(PAPER_PREDICTORS), encoding="utf-8")
    _viseme_pictures(folder, spoken)


def _viseme_pictures(folder: Path, spoken: SpokenCorpus) -> None:
    """Pictures of visemes, with the pose of the upper teeth."""
    pose, rows = seen_at([0, 0, 0], [0, 0, 700]), []
    teeth = seen_from(pose, spoken.corpus.frame.inverse)
    for name, weights in zip(spoken.corpus.visemes, spoken.weights, strict=True):
        picture = f"{name}.png"
        units = dict(zip(spoken.speaker.unit_names, weights.tolist(), strict=True))
        (folder / picture).write_bytes(png(lit("mei", pose, **units)))
        rows.append((picture, name, *teeth.rotation_vector, *teeth.translation))
    columns = ("picture", "viseme", "rx", "ry", "rz", "tx", "ty", "tz")
    write_csv(folder / "seen.csv", columns, rows)


def short_scene(name: str) -> Callable[[Path], None]:
    """A shipped scene, whose clip is cut to two frames."""

    def write(folder: Path) -> None:
        text = (SCENES / name).read_text(encoding="utf-8")
        text, count = re.subn(r"^frames = \d+", "frames = 2", text, flags=re.MULTILINE)
        (folder / name).write_text(text if count else f"{text}\nframes = 2\n", encoding="utf-8")

    return write


GIVEN: Mapping[str, tuple[Callable[[Path], None], ...]] = {
    "docs/ground-truth.md": (short_scene("short.toml"), short_scene("speech.toml")),
    "docs/import.md": (other_heads,),
    "docs/lips.md": (marked_dots, undotted),
    "docs/speaker.md": (recordings,),
    "docs/talking.md": (recorded_points,),
    "docs/track.md": (two_faces,),
}
"""What a page's reader has, beyond a clip and its camera."""
LATER: Mapping[str, Callable[[Path], None]] = {
    "abs-engine train dots.npz -o lips.npz": longer_session
}
"""What is put there before a command, in place of what a command before it made."""
BEFORE: Mapping[str, tuple[str, ...]] = {
    "docs/parts.md": (
        "abs-engine synth vowels --frames 5 -o vowels",
        "abs-engine track vowels/clip/camera/video.mp4 -o tracked",
    )
}
"""What a page's reader did by other pages."""
