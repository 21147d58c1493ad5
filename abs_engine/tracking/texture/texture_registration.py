"""The pose of a head whose looks are known, from its texture.

Lips alone say little about depth: a wider mouth farther away draws the same outline. Where the
person's own head and texture are given, brows, nose and freckles fix the pose before the lips are
fitted. The head is drawn and put into the picture's light; where its details are then found in the
picture tells the pose, and the next drawing is nearer. Whether a picture shows the head at all is
told by the texture comparison of Odisio and Bailly (section 4) over the rigid face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.sums import pixel_sums
from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose, rotations, vertex_normals
from abs_engine.core.pose import PoseFrame
from abs_engine.core.scene import Candidates, ColourError, Renderer, Scene
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.region import part
from abs_engine.face.settings.shape import SHAPE
from abs_engine.io.assets import Speaker
from abs_engine.tracking.settings.registration import REGISTRATION
from abs_engine.tracking.texture.feature_matching import Drawn, match, pose_of_matches
from abs_engine.tracking.texture.relighting import Gray, gray, relit, smooth

Level = tuple[float, float]


@dataclass(frozen=True, eq=False)
class _Guess:
    """Guess of a head's pose and expression, and its details' agreement before the last step."""

    pose: Pose
    weights: FloatArray
    agreement: float = -1.0


@dataclass(frozen=True, eq=False)
class KnownHead:
    """A head whose looks are known, found in pictures by its rigid facets.

    Parameters
    ----------
    head : Scene
        The person's head with the person's texture, without modes.
    rigid : (F,) bool
        The facets that are compared.
    motions : (K, V, 3) float32, mm per standard deviation, optional
        How those facets move nevertheless, as brows do; see `face_motions`.
    """

    head: Scene
    rigid: BoolArray
    camera: Camera
    renderer: Renderer
    motions: NDArray[np.float32] | None = None

    @cached_property
    def face(self) -> Scene:
        """The facets that are compared."""
        return part(self.head, self.rigid)[0]

    @cached_property
    def _moving(self) -> Scene:
        return self.head if self.motions is None else replace(self.head, modes=self.motions)

    @cached_property
    def _normals(self) -> FloatArray:
        return vertex_normals(self.head.mean.astype(np.float64), self.head.faces)

    @cached_property
    def _centre(self) -> FloatArray:
        return np.asarray(self.face.mean.astype(np.float64).mean(axis=0))

    def align(self, image: Image, pose: Pose) -> Pose:
        """Refine a first guess of the pose, up to twice as far away as the head is."""
        frame, sight = PoseFrame(pose, self._centre), pose.apply(self._centre)
        starts = [
            frame.pose(np.r_[pitch, yaw, 0, (depth - 1) * sight])
            for pitch, depth, yaw in product(
                REGISTRATION.far_pitch, REGISTRATION.far_depth, REGISTRATION.far_yaw
            )
        ]
        return self._best(image, starts)

    def realign(self, image: Image, pose: Pose) -> Pose:
        """The pose of a head that was at `pose` a moment ago and may have turned since."""
        frame, arm = PoseFrame(pose, self._centre), pose.rotation @ self._centre
        starts = [pose]
        for yaw, swing in product(REGISTRATION.near_yaw, REGISTRATION.near_swing):
            turn = np.array([[0.0, yaw, 0.0]])
            moved = swing * (rotations(turn)[0] @ arm - arm)
            starts.append(frame.pose(np.r_[turn[0], moved]))
        return self._best(image, starts)

    def refine(self, image: Image, pose: Pose) -> Pose:
        """The pose of a head that is known to a few degrees and percent."""
        levels = REGISTRATION.alignment_levels[REGISTRATION.nearly :]
        return self._steps(image, self._guess(pose), levels).pose

    def settle(self, image: Image, pose: Pose) -> Pose:
        """The pose of a head that was followed to `pose`; that itself where too little agrees."""
        found, finest = self._guess(pose), REGISTRATION.alignment_levels[-1:]
        for _ in range(REGISTRATION.settling):
            last, found = found, self._steps(image, found, finest)
            if self._apart(last.pose, found.pose) < REGISTRATION.settled:
                break
        near = found.pose.angle_to(pose) < REGISTRATION.astray
        return found.pose if near and found.agreement >= REGISTRATION.sure else pose

    def _apart(self, one: Pose, other: Pose) -> float:
        """RMS distance, mm, of the face at two poses."""
        points = self.face.mean.astype(np.float64)
        away = one.apply(points) - other.apply(points)
        return float(np.sqrt((away**2).sum(axis=1).mean()))

    def _before(self, pose: Pose) -> bool:
        """Whether the whole face lies before the camera, not nearer than `GENERAL.nearest`."""
        return bool(pose.apply(self.face.mean.astype(np.float64))[:, 2].min() >= GENERAL.nearest)

    def error(self, image: Image, pose: Pose) -> float:
        """Error with which the head at `pose` explains an image: in units of the colour's noise."""
        if not self._before(pose):
            return 1e9
        window = _face_window(self.face, pose, self.camera, REGISTRATION.drawn_face, 1.0)
        term = ColourError(_balanced(np.asarray(window.sample(image), np.float32), self.face))
        one = Candidates.one(np.zeros(self.face.n_modes), pose)
        sums = pixel_sums(self.renderer, self.face, one, self.camera, window, term)
        if sums.pixels[0] < REGISTRATION.least_drawn * window.drawn[0] * window.drawn[1]:
            return 1e9
        mean = float(sums.total[0]) / int(sums.pixels[0])
        return REGISTRATION.observations * mean / (2 * REGISTRATION.chroma_noise**2)

    def _guess(self, pose: Pose) -> _Guess:
        return _Guess(pose, np.zeros(self._moving.n_modes))

    def _best(self, image: Image, starts: list[Pose]) -> Pose:
        """Some steps from each start, and the others from where details then agree best.

        Starts after one that leads to the head are not tried.
        """
        best, tried = self._guess(starts[0]), REGISTRATION.levels_tried
        for pose in starts:
            found = self._steps(image, self._guess(pose), REGISTRATION.alignment_levels[:tried])
            best = max(best, found, key=lambda guess: guess.agreement)
            if best.agreement >= REGISTRATION.sure:
                break
        return self._steps(image, best, REGISTRATION.alignment_levels[tried:]).pose

    def _steps(self, image: Image, guess: _Guess, levels: tuple[Level, ...]) -> _Guess:
        for share, reach in levels:
            guess = self._step(image, guess, share * REGISTRATION.fine_face, reach)
        return guess

    def _step(self, image: Image, guess: _Guess, width: float, reach: float) -> _Guess:
        """Draw, look for what was drawn, and move to where it is."""
        if not self._before(guess.pose):
            return replace(guess, agreement=-1.0)
        window = _face_window(self.face, guess.pose, self.camera, width, GENERAL.finest)
        one = Candidates.one(guess.weights, guess.pose)
        buffers = self.renderer.draw(self._moving, one, self.camera, window)[0]
        seen = gray(window.sample(image.astype(np.float32)))
        drawn = self._drawn(buffers, seen, guess.pose, window)
        found = match(drawn, smooth(seen), reach)
        if len(found.at) < REGISTRATION.least_matches:
            return replace(guess, agreement=found.agreement)
        column, row = found.at.T
        corners = self.head.faces[buffers.facet_id[row, column] - 1]
        held = buffers.barycentrics[row, column].astype(np.float64)
        points = np.einsum("nc,ncd->nd", held, self.head.mean.astype(np.float64)[corners])
        motions = np.einsum("nc,kncd->nkd", held, self._moving.modes[:, corners])
        pose, weights = pose_of_matches(
            points, motions, window.to_image(found.found), found.root * window.scale,
            self.camera, (guess.pose, guess.weights),
        )  # fmt: skip
        if not self._before(pose):
            return replace(guess, agreement=found.agreement)
        return _Guess(pose, weights, found.agreement)

    def _drawn(self, buffers: Buffers, seen: Gray, pose: Pose, window: Window) -> Drawn:
        """Drawing under the picture's light."""
        covered = buffers.covered
        wanted = covered & self.rigid[np.maximum(buffers.facet_id - 1, 0)]
        wanted &= _inside(window, self.camera)
        shown, flat = np.full_like(seen, 128), gray(buffers.rgb)
        across = window.scale * float(np.ptp(_outline(self.face, pose, self.camera)[:, 0]))
        drawn = Drawn(shown, covered, wanted, across)
        near = covered & drawn.near
        corners = self.head.faces[buffers.facet_id[near] - 1]
        normals = np.einsum("nc,ncd->nd", buffers.barycentrics[near], self._normals[corners])
        turned = normals @ pose.rotation.T
        shown[near] = relit(flat[near], seen[near], turned, wanted[near])
        return replace(drawn, gray=smooth(shown))


def face_motions(speaker: Speaker, rigid: BoolArray) -> NDArray[np.float32]:
    """Motions (K, V, 3), mm per standard deviation, of the nearly rigid facets (F,) of a face.

    They are the principal components of its units there.
    """
    units = SHAPE.usual_weight * speaker.unit_matrix(speaker.unit_names).astype(np.float64)
    there = units[:, np.unique(speaker.faces[rigid])].reshape(len(units), -1)
    mixed = np.linalg.svd(there, full_matrices=False)[0][:, : REGISTRATION.motions]
    return np.asarray(np.tensordot(mixed.T, units, 1), np.float32)


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


def _outline(scene: Scene, pose: Pose, camera: Camera) -> FloatArray:
    """Least and greatest column and row (2, 2) of a face in the picture."""
    pixels = camera.project(pose.apply(scene.mean.astype(np.float64)))
    return np.stack([pixels.min(axis=0), pixels.max(axis=0)])


def _face_window(scene: Scene, pose: Pose, camera: Camera, width: float, finest: float) -> Window:
    """A window about a face, drawn `width` wide or `finest` times as finely as the picture is."""
    low, high = _outline(scene, pose, camera)
    margin = REGISTRATION.margin * (high - low)
    size = high - low + 2 * margin
    scale = min(finest, width / float(high[0] - low[0]))
    x, y = low - margin
    return Window(float(x), float(y), float(size[0]), float(size[1]), scale)


def _inside(window: Window, camera: Camera) -> BoolArray:
    """Mask of the drawn pixels of a window that lie in the picture, (H, W)."""
    (x, y), (width, height) = window.places, camera.size
    across, down = (x >= 0) & (x <= width - 1), (y >= 0) & (y <= height - 1)
    return np.asarray(down[:, None] & across)
