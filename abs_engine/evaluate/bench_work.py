"""The work of a benchmark: a textured ball that deforms, seen by a camera, and a frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, ColourError, Scene
from abs_engine.render.cpu import CpuRenderer

N_MODES = 7
N_CANDIDATES = 64
RADIUS, DISTANCE = 90.0, 600.0  # mm
WALL = 110.0  # grey behind the ball; against black, pixels at its edge would outweigh all others


@dataclass(frozen=True, eq=False)
class Work:
    """One size of evaluation: deform by seven modes, render textured, compare the colours.

    Parameters
    ----------
    camera : Camera
        Its whole image is drawn.
    """

    scene: Scene
    candidates: Candidates
    camera: Camera
    term: ColourError

    @property
    def name(self) -> str:
        """Facets and pixels, as in '1280x64'."""
        return f"{len(self.scene.faces)}x{self.camera.size[0]}"

    @property
    def singles(self) -> list[Candidates]:
        """Every candidate as a batch of one."""
        c = self.candidates
        return [
            Candidates(c.weights[i : i + 1], c.rotations[i : i + 1], c.translations[i : i + 1])
            for i in range(len(c))
        ]

    def as_arrays(self) -> dict[str, NDArray[np.generic]]:
        """All that another renderer needs to do the same work."""
        scene, candidates = self.scene, self.candidates
        return {
            "mean": scene.mean,
            "modes": scene.modes,
            "faces": scene.faces,
            "uv": scene.uv,
            "texture": scene.texture,
            "weights": candidates.weights,
            "rotations": candidates.rotations,
            "translations": candidates.translations,
            "matrix": self.camera.matrix,
            "size": np.array(self.camera.size),
            "depth_range": np.array([self.camera.near, self.camera.far]),
            "target": self.term.normalised,
        }


def ball_work(subdivisions: int, pixels: int) -> Work:
    """A ball of 20 * 4^subdivisions facets that nearly fills `pixels` squared; always the same.

    Parameters
    ----------
    subdivisions : int
        3 for 1,280 facets, 4 for 5,120.
    """
    rng = np.random.default_rng(0)
    scene = _ball(subdivisions, rng)
    camera = Camera.ideal((pixels, pixels), focal=2.9 * pixels)
    facing = Pose.facing(DISTANCE).rotation_vector
    candidates = Candidates.from_vectors(
        rng.normal(0, 1, (N_CANDIDATES, N_MODES)),
        facing + rng.normal(0, 0.05, (N_CANDIDATES, 3)),
        np.array([0, 0, DISTANCE]) + rng.normal(0, 4.0, (N_CANDIDATES, 3)),
    )
    truth = Candidates.one(np.zeros(N_MODES), Pose.facing(DISTANCE))
    with CpuRenderer() as renderer:
        seen = renderer.draw(scene, truth, camera, camera.whole)[0]
    picture = np.where(seen.covered[..., None], seen.rgb, WALL)
    frame = np.clip(picture + rng.normal(0, 12, picture.shape), 0, 255)
    return Work(scene, candidates, camera, ColourError(frame.astype(np.float32)))


def _ball(subdivisions: int, rng: np.random.Generator) -> Scene:
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions)
    unit = np.asarray(sphere.vertices, np.float64)
    waves = rng.normal(0, 2.0, (N_MODES, 3, 3))
    phase = rng.uniform(0, 2 * np.pi, (N_MODES, 1, 3))
    return Scene(
        mean=np.asarray(RADIUS * unit, np.float32),
        modes=np.asarray(np.sin(unit @ waves + phase), np.float32),  # smooth, about 1 mm
        faces=np.asarray(sphere.faces, np.int32),
        uv=np.asarray(0.5 + 0.45 * unit[:, :2] * [1, -1], np.float32),
        facet_class=np.ones(len(sphere.faces), np.int32),
        texture=_blobs(rng),
    )


def _blobs(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Coloured blobs, (128, 192, 3) uint8."""
    coarse = rng.uniform(30, 225, (8, 12, 3))
    at = np.meshgrid(np.linspace(0, 7, 128), np.linspace(0, 11, 192), indexing="ij")
    fine = [map_coordinates(channel, at, order=1) for channel in coarse.transpose(2, 0, 1)]
    return np.asarray(np.rint(np.stack(fine, axis=2)), np.uint8)
