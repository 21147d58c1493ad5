"""Faces that `articulate --face` makes of measured points, against the heads that wore them.

Run it by hand. `python tests/points_agreement.py shapes [PERSON...]`: the compared surface over the
visemes of a corpus, of 275 points and of 30 beads; people are bundled ones, or a number to draw
one by chance. `python tests/points_agreement.py tracked PERSON FOLDER`: the same of dots that two
cameras see and that are followed and triangulated, in a new folder or in one that it left; and how
far these are off. `python tests/points_agreement.py film PERSON FOLDER` films visemes and a
sentence, `... faces FOLDER` makes the faces, and `... track FOLDER` tracks the sentence with each.
All of it is in the frame of the upper teeth. Points that are not tracked are off by 0.3 mm.
"""

from __future__ import annotations

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from heads import spoken_heads
from scipy.spatial import cKDTree
from trimesh.triangles import closest_point
from worn_dots import filmed_places

from abs_engine.capture.corpus import Corpus
from abs_engine.capture.viseme_pictures import read_viseme_pictures
from abs_engine.core.camera import Camera
from abs_engine.dataset import load_truth
from abs_engine.face.articulated import FaceShape
from abs_engine.face.talking_file import load_talking, save_talking
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.files import png
from abs_engine.learn.articulated import face_shape
from abs_engine.learn.articulatory import build
from abs_engine.learn.corpus_dots import corpus_dots
from abs_engine.learn.measured.face import measured_face
from abs_engine.learn.spoken import SpokenCorpus, bite_plane_of
from abs_engine.learn.talking import learn_face
from abs_engine.learn.training import checksum
from abs_engine.papers.odisio2004.filmed import SIZE, film_visemes, read_visemes, sightings
from abs_engine.papers.odisio2004.sentences_filmed import plan_sentence
from abs_engine.papers.odisio2004.tracked_beads import tracked_corpus
from abs_engine.render.select import open_renderer
from abs_engine.studio.corpus import PAPER_VISEMES, speak_corpus
from abs_engine.studio.french import QUICK
from abs_engine.studio.make import Crew, Order, make
from abs_engine.studio.people import neutral, random_person
from abs_engine.tracking.models.measured_looks import with_looks
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.results.run_mesh import load_mesh
from abs_engine.tracking.run import track_video

BEADS = (
    *("lip_corner_000", "lip_corner_001"),
    *(f"lip_{lip}_{k:03d}" for lip in ("upper", "lower") for k in (0, 2, 4)),
    "tooth_003",
)
"""Of the 30: points of the lips and a tooth; the rest is thinned from around the lips, the jaw line
and the face."""


def thirty(corpus: Corpus) -> Corpus:
    """The corpus with 30 of its points."""
    of = {
        part: [n for n in corpus.names if n.startswith(part)] for part in ("around", "jaw", "bead")
    }
    kept = [*BEADS, *of["around"][::3], *of["jaw"][::3]]
    kept += of["bead"][: 30 - len(kept)]
    return corpus.without(set(corpus.names) - set(kept))


def say(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def rms(away: np.ndarray) -> float:
    """Root mean square of vectors' lengths."""
    return float(np.sqrt((away**2).sum(axis=-1).mean()))


def off_surface(points: np.ndarray, head: np.ndarray, faces: np.ndarray) -> float:
    """RMS distance of points from a head's surface."""
    triangles, count = head[faces], 24
    near = cKDTree(triangles.mean(axis=1)).query(points, count)[1].ravel()
    wanted = np.repeat(points, count, axis=0)
    away = np.linalg.norm(closest_point(triangles[near], wanted) - wanted, axis=1)
    return float(np.sqrt((away.reshape(-1, count).min(axis=1) ** 2).mean()))


def scored(shape: FaceShape, alpha: np.ndarray, spoken: SpokenCorpus, speaker: Speaker) -> str:
    """How far a face's vertices lie from the true ones over the visemes."""
    heads = spoken.corpus.frame.apply(
        spoken_heads(speaker, spoken.neutral, spoken.weights).astype(np.float64)
    )
    own = shape.frame.apply(np.stack([shape.scene.vertices(row) for row in alpha]).astype(float))
    lips = reds(speaker)
    surface = np.union1d(lips, shape.marks)
    some = zip(own[::6], heads[::6], strict=True)
    apart = [off_surface(a[surface], b, speaker.faces) for a, b in some]
    return (
        f"surface {rms(own[:, surface] - heads[:, surface]):.2f} mm, across it "
        f"{np.sqrt(np.mean(np.square(apart))):.2f}, lips {rms(own[:, lips] - heads[:, lips]):.2f}"
    )


def reds(speaker: Speaker) -> np.ndarray:
    """Vertices of the lips."""
    return speaker.vertices_of("upper_lip", "lower_lip")


def shapes(people: list[str]) -> None:
    """Print a line for each person and corpus."""
    speaker = load_speaker()
    for name in people or list(speaker.people):
        drawn = name.isdigit()
        rng = np.random.default_rng(int(name) if drawn else 0)
        head = neutral(speaker, random_person(speaker, rng)) if drawn else speaker.named(name)
        spoken = speak_corpus(speaker, head)
        whole = build(spoken.corpus)
        texture = next(iter(speaker.people))
        true = face_shape(speaker, spoken, whole, texture)
        say(f"{name} true head: {scored(true, whole.alpha, spoken, speaker)}")
        for points, built in (("275", whole), ("30", build(thirty(spoken.corpus)))):
            made = measured_face(speaker, built)
            line = scored(made.shape, built.alpha, spoken, speaker)
            say(f"{name} {points} points, {made.head.misfit:.2f} mm left: {line}")


def tracked(person: str, folder: Path) -> None:
    """Print how far tracked dots are off, and the face that is made of them."""
    speaker = load_speaker()
    spoken = speak_corpus(speaker, speaker.named(person))
    folder.mkdir(exist_ok=True)
    corpus = tracked_corpus(spoken, person, 0, folder)
    worn = corpus_dots(speaker)
    own = [worn.names.index(name) for name in corpus.names]
    away = corpus.points - filmed_places(spoken, worn.vertices[own])
    seen = np.isfinite(away).all(axis=2)
    moved = away - np.nanmean(away, axis=0)
    say(f"{len(corpus.names)} of {len(worn.names)} dots are seen often enough")
    for name, members in {"all": corpus.names, **corpus.groups}.items():
        at = np.isin(corpus.names, members)
        there = seen & at
        if at.any():
            say(
                f"{name}: {at.sum()} dots, {seen[:, at].mean():.1%} seen, {rms(away[there]):.2f} "
                f"mm off, {rms(moved[there]):.2f} without what all visemes have in common, at most "
                f"{np.linalg.norm(away[there], axis=1).max():.1f}"
            )
    built = build(corpus, missing="impute")
    made = measured_face(speaker, built)
    say(f"{made.head.misfit:.2f} mm left: {scored(made.shape, built.alpha, spoken, speaker)}")


def film(person: str, folder: Path) -> None:
    """Film visemes and a sentence of a bundled person."""
    speaker = load_speaker()
    spoken = speak_corpus(speaker, speaker.named(person))
    folder.mkdir()
    (folder / "person.json").write_text(json.dumps(person))
    film_visemes(speaker, spoken, person, folder / "visemes", size=SIZE, beads=0, seed=0)
    plan = plan_sentence(speaker, person, QUICK[0], Camera.ideal((320, 240)), 5)
    make([plan], 1, folder / "sentence", speaker, Order("", 5, (), keep_frames=False), Crew())


def faces(folder: Path, names: list[str]) -> None:
    """Make the true head's face, and those of points with poses given and estimated."""
    speaker, person = load_speaker(), json.loads((folder / "person.json").read_text())
    spoken = speak_corpus(speaker, speaker.named(person))
    seen = read_visemes(folder / "visemes", PAPER_VISEMES)
    back = spoken.corpus.frame.inverse
    with (folder / "pictures.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["picture", "viseme", "rx", "ry", "rz", "tx", "ty", "tz"])
        for k, viseme in enumerate(seen.visemes):
            (folder / f"{k}.png").write_bytes(png(seen.pictures[k]))
            turn = seen.poses[k].rotation @ back.rotation
            pose = type(back)(turn, seen.poses[k].apply(back.translation[None])[0])
            table.writerow([f"{k}.png", viseme, *pose.rotation_vector, *pose.translation])
    given = read_viseme_pictures(folder / "pictures.csv", PAPER_VISEMES)
    guessed = tuple(replace(picture, pose=None) for picture in given)
    whole, few = build(spoken.corpus), build(thirty(spoken.corpus))
    with open_renderer("cpu") as renderer:
        if not names or "true" in names:
            shape = face_shape(speaker, spoken, whole, person)
            true = learn_face(
                shape,
                sightings(shape, seen.pictures, seen.poses, whole.alpha),
                seen.camera,
                renderer,
            )
            save_talking(folder / "true.face", true, person, checksum(speaker))
        bare = measured_face(speaker, whole)
        if not names or "bare" in names:
            path = folder / "bare.face"
            save_talking(path, bare.shape, "points", checksum(speaker), bare.neutral)
        of = {"275": (whole, given), "275-estimated": (whole, guessed), "30": (few, given)}
        for name, (built, table) in of.items():
            if not names or name in names:
                made = measured_face(speaker, built)
                looks = with_looks(made, built, table, seen.camera, renderer, say)
                path = folder / f"{name}.face"
                save_talking(path, looks, "points", checksum(speaker), made.neutral)


def track(folder: Path, names: list[str]) -> None:
    """Track the sentence with each face, and print how far the lips are off."""
    speaker, person = load_speaker(), json.loads((folder / "person.json").read_text())
    truth, lips = load_truth(folder / "sentence"), reds(speaker)
    frame = bite_plane_of(speaker, speaker.named(person))
    heads = np.stack([truth.vertices(t)[lips] for t in range(len(truth))]).astype(np.float64)
    still = speaker.named(person)[lips].astype(np.float64)
    wanted = frame.apply(heads)
    moved = rms(heads - still)
    say(f"{len(truth)} frames, lips move by {moved:.2f} mm")
    for name in names or ["true", "275", "275-estimated", "30", "bare"]:
        path = folder / f"{name}.face"
        preset = None if name == "bare" else "odisio2004"
        terms = None if name == "bare" else ("texture",)
        options = TrackOptions(preset=preset, model=str(path), camera=truth.camera, terms=terms)
        run = folder / f"run-{name}"
        with open_renderer("cpu") as renderer:
            track_video(truth.video, run, renderer, options)
        mesh, shape = load_mesh(run), load_talking(path).shape
        found = shape.frame.apply(mesh.points(lips))
        there = np.isfinite(found).all(axis=(1, 2))
        off = found[there] - wanted[there]
        constant = off.mean(axis=0)
        say(
            f"{name}: {there.sum()} frames found, lips {rms(off):.2f} mm, without what all frames "
            f"have in common {rms(off - constant):.2f} mm"
        )


if __name__ == "__main__":
    what, *rest = sys.argv[1:]
    if what == "shapes":
        shapes(rest)
    elif what == "tracked":
        tracked(rest[0], Path(rest[1]))
    elif what == "film":
        film(rest[0], Path(rest[1]))
    elif what == "faces":
        faces(Path(rest[0]), rest[1:])
    else:
        track(Path(rest[0]), rest[1:])
