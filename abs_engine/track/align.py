"""The pose of a head whose looks are known, from its texture.

Lips alone say little about depth: a wider mouth farther away draws the same outline. Where the
person's own head and texture are given, brows, eyes and nose fix the pose before the lips are
fitted. This is the texture comparison of Odisio and Bailly (section 4) over the rigid face.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from abs_engine.appearance.region import part
from abs_engine.camera import Camera, Window
from abs_engine.geometry import Pose, rotations
from abs_engine.objective import Evaluation
from abs_engine.optimise.simplex import Simplex
from abs_engine.scene import ColourError, Renderer, Scene
from abs_engine.track.pose import PoseFrame, pose_spec

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]
DRAWN_FACE = 112.0  # drawn pixels across the rigid face
STARTS = 10  # from which a simplex goes down
CHROMA_NOISE = 0.01  # standard deviation of normalised colour, per pixel
OBSERVATIONS = 500.0  # independent pixels of the face
COARSE_DEPTH = np.arange(-260.0, 161.0, 20.0)  # mm
COARSE_PITCH = np.array([-0.12, -0.06, 0.0, 0.06, 0.12])  # rad; trades with depth: many valleys
COARSE_HEIGHT = np.arange(-15.0, 15.1, 5.0)  # mm
NEAR_YAW = np.arange(-0.5, 0.51, 0.125)  # rad, about where a head was a moment ago
NEAR_PITCH, NEAR_DEPTH = np.array([-0.1, 0.0, 0.1]), np.array([-25.0, 0.0, 25.0])
NEAR_SWING = 0.0, 1.0  # the face turns about its own middle, or is swung about the head's
NEAR_STARTS = 4


@dataclass(frozen=True, eq=False)
class _TextureError:
    """epsilon(p) over the rendered set, in units of its noise."""

    renderer: Renderer
    scene: Scene
    camera: Camera
    window: Window
    term: ColourError
    frame: PoseFrame

    def values(self, vectors: FloatArray) -> FloatArray:
        sums = self.renderer.measure(
            self.scene, self.frame.candidates(vectors), self.camera, self.window, self.term
        )
        mean = sums.total / np.maximum(sums.pixels, 1)
        unseen = sums.pixels < 0.2 * self.window.drawn[0] * self.window.drawn[1]
        scaled = OBSERVATIONS * mean / (2 * CHROMA_NOISE**2)
        return np.asarray(np.where(unseen, 1e9, scaled))

    def __call__(self, x: FloatArray) -> Evaluation:
        value = float(self.values(x[None])[0])
        return Evaluation(value, {"texture": value})


@dataclass(frozen=True, eq=False)
class KnownHead:
    """A head whose looks are known, compared with pictures over its rigid facets.

    Parameters
    ----------
    head : Scene
        The person's head with the person's texture, without modes.
    rigid : (F,) bool
        The facets that are compared.
    camera : Camera
    renderer : Renderer
    """

    head: Scene
    rigid: NDArray[np.bool_]
    camera: Camera
    renderer: Renderer

    @cached_property
    def face(self) -> Scene:
        """The facets that are compared."""
        return part(self.head, self.rigid)[0]

    def align(self, image: Image, pose: Pose) -> Pose:
        """Refine a first guess of the pose, right to about a fifth of the distance.

        Parameters
        ----------
        image : (H, W, 3) uint8 RGB
        pose : Pose
        """
        error = self._error(image, pose)
        places = product(COARSE_PITCH, COARSE_HEIGHT, COARSE_DEPTH)
        grid = np.array([[pitch, 0, 0, 0, y, z] for pitch, y, z in places], np.float64)
        return _lowest(error, grid[_valleys(error.values(grid))])

    def realign(self, image: Image, pose: Pose) -> Pose:
        """The pose of a head that was at `pose` a moment ago and may have turned since."""
        error = self._error(image, pose)
        places = np.array(list(product(NEAR_PITCH, NEAR_YAW, NEAR_DEPTH, NEAR_SWING)))
        pitch, yaw, depth, swing = places.T
        turn = np.stack([pitch, yaw, 0 * yaw], axis=1)
        arm = pose.rotation @ error.frame.pivot
        moved = swing[:, None] * (rotations(turn) @ arm - arm)
        moved[:, 2] += depth
        grid = np.hstack([turn, moved])
        near = grid[np.argsort(error.values(grid))[:NEAR_STARTS]]
        there = error.frame.pose(near[0])  # in a window about it, as the old one may cut it off
        return _lowest(self._error(image, there), near - near[0])

    def error(self, image: Image, pose: Pose) -> float:
        """How badly the head at `pose` explains an image: in units of the colour's noise."""
        return float(self._error(image, pose).values(np.zeros((1, 6)))[0])

    def _error(self, image: Image, pose: Pose) -> _TextureError:
        centre = self.face.mean.astype(np.float64).mean(axis=0)
        window = _face_window(self.face, pose, self.camera)
        term = ColourError(_balanced(np.asarray(window.sample(image), np.float32), self.face))
        frame = PoseFrame(pose, centre)
        return _TextureError(self.renderer, self.face, self.camera, window, term, frame)


def _balanced(patch: NDArray[np.float32], scene: Scene) -> NDArray[np.float32]:
    """A patch with the texture's typical colour: light has a colour, and gloss pales dark skin.

    The middle half of the patch is taken to be face, and its median colour that of its skin.
    """
    height, width = patch.shape[:2]
    middle = patch[height // 4 : -height // 4, width // 4 : -width // 4].reshape(-1, 3)
    size = np.array(scene.texture.shape[1::-1])
    at = np.clip(scene.uv[scene.faces].mean(axis=1) * size, 0, size - 1).astype(int)
    gain = _typical(scene.texture[at[:, 1], at[:, 0]]) / _typical(middle)
    return np.asarray(patch * (gain / gain.mean()), np.float32)


def _typical(colours: NDArray[np.generic]) -> FloatArray:
    """Median luminance-normalised colour (3,) of colours (N, 3), 0 to 255."""
    values = np.asarray(colours, np.float64) + 1
    return np.asarray(np.median(values / values.sum(axis=1, keepdims=True), axis=0))


def _lowest(error: _TextureError, starts: FloatArray) -> Pose:
    """Where a simplex goes down to from the best of several starts."""
    solver, spec = Simplex(tolerance=0.02, limit=300), pose_spec(0)
    found = [solver.minimise(error, start, spec) for start in starts]
    best = min(found, key=lambda solution: solution.value)
    return error.frame.pose(solver.minimise(error, best.x, spec).x)  # again: a fresh simplex


def _valleys(values: FloatArray) -> NDArray[np.int64]:
    """The lowest few grid points, no two of them of one pitch and nearly one depth."""
    shape = len(COARSE_PITCH), len(COARSE_HEIGHT), len(COARSE_DEPTH)
    chosen: list[tuple[int, ...]] = []
    for at in np.argsort(values):
        pitch, height, depth = (int(i) for i in np.unravel_index(at, shape))
        if all(pitch != p or abs(depth - d) > 1 for p, _, d in chosen):
            chosen.append((pitch, height, depth))
        if len(chosen) == STARTS:
            break
    return np.asarray(np.ravel_multi_index(tuple(np.array(chosen).T), shape), np.int64)


def _face_window(scene: Scene, pose: Pose, camera: Camera) -> Window:
    pixels = camera.project(pose.apply(scene.mean.astype(np.float64)))
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    margin = 0.3 * (high - low)
    size = high - low + 2 * margin
    scale = min(1.0, DRAWN_FACE / float(high[0] - low[0]))
    x, y = low - margin
    return Window(float(x), float(y), float(size[0]), float(size[1]), scale)
