"""Where the landmark network sees its points on the bundled head, and how far it is off.

Usage: ``python assets/make_landmarks.py [OUTPUT_FOLDER]``: draws the six people in several postures
from several sides (the CPU rasteriser, a lamp above the camera), lets the network look, and finds
which landmarks are each other's mirror images and the points of the mesh that they show. Then it
draws people who do not exist, under other lights and from other sides, and learns from them what
errors have in common: of heads like the bundled one, and of those that are expected of people. It
writes ``landmarks.npz``, and beside that folder ``landmark_mirror.json`` in ``detector`` and
``landmark_noise.npz`` in ``population``. Nothing but this repository is needed, with
``population/heads.npz`` (``make_population.py``); it takes about fifteen minutes.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from abs_engine.core.camera import Camera
from abs_engine.core.scene import Scene
from abs_engine.face.identity import head_modes, sized_head
from abs_engine.face.shape.mouth import mouth_shape
from abs_engine.face.shape.population import average_person
from abs_engine.face.shape.upper_face import upper_face_modes
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.face_detection import find_face
from abs_engine.tracking.detection.landmarks import landmarks_of
from abs_engine.tracking.landmark.landmark_correspondence import (
    FILE,
    Correspondence,
    Sighting,
    learn_correspondence,
    off_of,
)
from abs_engine.tracking.landmark.landmark_noise import LandmarkNoise, learn_noise
from abs_engine.tracking.landmark.rendered_landmarks import (
    USUAL_LIGHT,
    Light,
    lit_picture,
    pose_of,
    sighting_of,
    sightings_of,
)
from abs_engine.tracking.person.expected_person import NOISE, save_noise

POSTURES: tuple[dict[str, float], ...] = (
    {},
    {"jawOpen": 0.35},
    {"jawOpen": 0.15, "mouthUpperUpLeft": 0.2, "mouthUpperUpRight": 0.2},
    {
        "mouthSmileLeft": 0.6,
        "mouthSmileRight": 0.6,
        "jawOpen": 0.1,
        "mouthUpperUpLeft": 0.3,
        "mouthUpperUpRight": 0.3,
    },
    {"mouthPucker": 0.6, "mouthFunnel": 0.3, "jawOpen": 0.1},
)


def all_sightings(speaker: Speaker) -> Iterator[Sighting]:
    """Every person in every posture from every side."""
    renderer = CpuRenderer()
    for name in speaker.people:
        neutral, texture = speaker.named(name).astype(np.float64), speaker.texture(name)
        for posture in POSTURES:
            units = speaker.unit_matrix(tuple(posture))
            moved = neutral + np.tensordot(np.array(list(posture.values())), units, 1)
            yield from sightings_of(speaker, moved, texture, renderer)


PEOPLE, VIEWS = 200, 6


def strangers(speaker: Speaker, heads: NDArray[np.floating]) -> Iterator[tuple[int, Sighting]]:
    """People who do not exist, numbered: random heads, postures, sides, lights and lenses.

    Heads are a speaker's with random weights of modes (K, V, 3).
    """
    rng, renderer = np.random.default_rng(0), CpuRenderer()
    upper = upper_face_modes(speaker)
    mouth = mouth_shape(speaker, speaker.vertices, 10)
    moves = np.concatenate([mouth.modes, upper]).astype(np.float64)
    textures = [speaker.texture(name) for name in speaker.people]
    for person in range(PEOPLE):
        own = mouth.mean + np.tensordot(rng.normal(size=len(heads)), heads, 1)
        texture = textures[rng.integers(len(textures))]
        for _ in range(VIEWS):
            posture = np.clip(rng.normal(size=len(moves)), -2, 2)
            vertices = np.asarray(own + np.tensordot(posture, moves, 1), np.float64)
            depth = rng.uniform(400, 1100)
            camera = Camera.ideal((400, 400), depth * rng.uniform(1.2, 1.8))
            angles = (0.15 * rng.normal(), rng.uniform(-0.35, 0.3), rng.uniform(-0.7, 0.7))
            place = np.array([*(20 * rng.normal(size=2)), depth])
            lamp, ambient = (
                np.array([*rng.uniform([-1, -1], [1, 0.3]), -1.0]),
                rng.uniform(0.3, 0.7),
            )
            wall, tint = rng.uniform(20, 230), rng.uniform(0.75, 1.1, 3)
            light, coarse = Light(lamp, ambient, 1.1 - ambient, wall, tint), rng.choice([1.0, 2.5])
            pose = pose_of(speaker, vertices, angles, place)
            seen = sighting_of(speaker, vertices, texture, pose, camera, renderer, light, coarse)
            if seen is not None:
                yield person, seen


def learn_mirror(speaker: Speaker) -> list[int]:
    """Which landmark each one is in a mirror image, by drawings and their mirror images."""
    renderer, camera = CpuRenderer(), Camera.ideal((400, 400))
    none = np.zeros((0, *speaker.vertices.shape), np.float32)
    classes, away = speaker.facet_class.astype(np.int32), []
    for name, yaw in product(speaker.people, (-0.3, 0.0, 0.3)):
        vertices = speaker.named(name).astype(np.float64)
        scene = Scene(
            vertices.astype(np.float32), none, speaker.faces, speaker.uv, classes,
            speaker.texture(name),
        )  # fmt: skip
        pose = pose_of(speaker, vertices, (0.0, 0.0, yaw), np.array([0.0, 0.0, 700.0]))
        picture = lit_picture(scene, pose, camera, renderer, USUAL_LIGHT)
        looks = [_plain_look(p) for p in (picture, np.ascontiguousarray(picture[:, ::-1]))]
        looks[1][:, 0] = picture.shape[1] - 1 - looks[1][:, 0]
        away.append(np.linalg.norm(looks[0][:, None] - looks[1][None], axis=2))
    return [int(k) for k in linear_sum_assignment(np.mean(away, axis=0))[1]]


def _plain_look(picture: np.ndarray) -> np.ndarray:
    """Landmarks (468, 2) by one look; the drawings show a face for sure."""
    face = find_face(picture)
    seen = None if face is None else landmarks_of(picture, face, both=False)
    if seen is None:
        raise RuntimeError("the network sees no face in a drawing")
    return seen.pixels.copy()


def _noise(found: Correspondence, speaker: Speaker, heads: NDArray[np.floating]) -> LandmarkNoise:
    """The network's errors on strangers' heads."""
    people, seen = zip(*strangers(speaker, heads), strict=True)
    off = np.stack([off_of(found.corners, found.weights, s) for s in seen])
    return learn_noise(off, np.array(people))


def main() -> int:
    """Learn from the drawings and write the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "output", nargs="?", type=Path, default=Path(__file__).resolve().parent / "speaker"
    )
    folder = parser.parse_args().output
    speaker = load_speaker()
    mirror = learn_mirror(speaker)
    detector = folder.parent / "detector"
    for place in (folder, detector):
        place.mkdir(parents=True, exist_ok=True)
    (detector / "landmark_mirror.json").write_text(json.dumps(mirror, separators=(",", ":")) + "\n")
    found = learn_correspondence(speaker, list(all_sightings(speaker)))
    found = replace(found, noise=_noise(found, speaker, head_modes(speaker)))
    found.save(folder / FILE)
    noise = folder.parent / NOISE
    noise.parent.mkdir(parents=True, exist_ok=True)
    save_noise(noise, _noise(found, *sized_head(average_person(), 1.0)))
    off = ", ".join(f"{mm:.1f}" for mm in np.median(found.deviation, axis=0))
    print(f"{FILE}: landmarks are off by {off} mm (median: across, down, in depth)")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
