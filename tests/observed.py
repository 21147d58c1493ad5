"""A head with painted dots before two cameras, or a camera and a mirror, and where its dots are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from abs_engine.capture.board import Board
from abs_engine.capture.dot_annotations import LIPS17
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import FACING, Pose, vertex_normals
from abs_engine.core.scene import Candidates, Scene
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.mirror import Mirror, lines_of_sight
from abs_engine.studio.people import Person, dots, paint
from abs_engine.studio.people.chart import chart_of
from abs_engine.studio.people.dots import INK

SKULL = ("ear_middle", "ear_lower", "forehead_right", "forehead_left", "forehead")
NAMES = (*LIPS17, *SKULL)
_NEAR = ((74.0, 13.0, 13.0), (75.0, -1.0, 10.0), (-23.0, 107.0, 82.0), (23.0, 107.0, 82.0),
         (0.0, 98.0, 89.0))  # fmt: skip
"""mm, head frame: where a dot of the skull is looked for."""
_STILL, _RADIUS, _FINE = 0.35, 0.8, 2.0
"""mm that a face unit may move a dot of the skull; its radius, mm; pixels drawn for one."""
FINER = 2
"""The speaker's texels are up to 0.8 mm wide on the ear, too coarse for a dot."""


@dataclass(frozen=True, eq=False)
class DottedHead:
    """The bundled head with 17 dots of the mouth and nose, and five of the skull."""

    scene: Scene
    vertices: np.ndarray
    painted: np.ndarray

    def dots(self, weights: np.ndarray) -> np.ndarray:
        """True places (..., N, 3), mm, head frame, of the dots for unit weights (..., 52).

        A dot of the mouth or nose is at its vertex. One of the skull is where its texels are, for
        these are as coarse as 0.8 mm on the ear.
        """
        moved = np.tensordot(weights, self.scene.modes[:, self.vertices].astype(float), 1)
        return self.scene.mean[self.vertices] + self.painted + moved


@lru_cache(maxsize=1)
def dotted_head(base: str = "clara", finer: int = FINER) -> DottedHead:
    speaker, person = load_speaker(), Person("dotted", base, beads="lips17")
    rest = speaker.named(base)
    vertices = np.concatenate([dots(speaker, person).vertices, _skull(speaker, rest)])
    texture = paint(speaker, person)
    fine = finer * texture.shape[0]
    chart = chart_of(speaker, fine)
    colour = chart.lift(cv2.resize(texture, (fine, fine), interpolation=cv2.INTER_CUBIC))
    place = np.einsum("tk,tkc->tc", chart.weights, rest[speaker.faces[chart.face]])
    painted = np.zeros((len(vertices), 3))
    for k, vertex in enumerate(vertices[len(LIPS17) :], start=len(LIPS17)):
        away = np.linalg.norm(place - rest[vertex], axis=1)
        share = np.clip((_RADIUS + 0.12 - away) / 0.24, 0, 1)[:, None]
        area = share * chart.area[:, None]
        painted[k] = (area * place).sum(axis=0) / area.sum() - rest[vertex]
        colour = colour + share * (np.array(INK, np.float32) - colour)
    units = speaker.unit_matrix(speaker.unit_names)
    kinds = speaker.facet_class.astype(np.int32)
    scene = Scene(rest, units, speaker.faces, speaker.uv, kinds, chart.lay(colour))
    return DottedHead(scene, vertices, painted)


def _skull(speaker: Speaker, rest: np.ndarray) -> np.ndarray:
    moved = np.linalg.norm(speaker.unit_matrix(speaker.unit_names), axis=2).max(axis=0)
    facing = vertex_normals(rest.astype(float), speaker.faces) @ [0.35, 0.0, 0.94] > 0.45
    skin = np.unique(speaker.faces[speaker.facet_class == speaker.class_id("skin")])
    still = skin[(moved[skin] < _STILL) & facing[skin]]
    return np.array([still[np.linalg.norm(rest[still] - near, axis=1).argmin()] for near in _NEAR])


def two_cameras(yaw: float = 0.42) -> tuple[Camera, tuple[Pose, Pose]]:
    """A kind of camera that stands twice: before the face, and turned by `yaw` to its left."""
    lens = np.array([-0.08, 0.03, 0.0005, -0.0005])
    matrix = np.array([[1800, 0, 319], [0, 1800, 322], [0, 0, 1.0]])
    camera = Camera(matrix, (640, 640), lens)
    turn = Pose.from_vectors([0, yaw, 0], np.zeros(3)).rotation
    middle = np.array([12.0, 0.0, 600.0])
    return camera, (
        Pose(np.eye(3), np.zeros(3)),
        Pose(turn, np.array([0, 0, 600.0]) - turn @ middle),
    )


def mirror_room(focal: float = 2900.0) -> tuple[Camera, Mirror, Pose]:
    """A camera, a mirror to its right, and a head that looks between the two (head to camera)."""
    camera = Camera(np.array([[focal, 0, 1020], [0, focal, 540], [0, 0, 1.0]]), (1920, 1080))
    turned = Pose.from_vectors([0, 0.56, 0], np.zeros(3)).rotation
    pose = Pose(FACING @ turned, np.array([-150.0, 30.0, 770.0]))
    return camera, Mirror.standing((152, 0, 609), -1.07, (260, 300)), pose


def nodding(start: Pose, frames: int, rate: float = 30.0) -> list[Pose]:
    """Head to world: the head turns by up to 6 degrees and goes to and fro by some mm."""
    t, out = np.arange(frames) / rate, []
    turns = np.stack([0.06 * np.sin(2 * t), 0.1 * np.sin(1.3 * t), 0.04 * np.sin(1.7 * t)], axis=1)
    shifts = np.stack([4 * np.sin(t), 3 * np.sin(1.5 * t), 5 * np.sin(0.8 * t)], axis=1)
    for turn, shift in zip(turns, shifts, strict=True):
        turned = Pose.from_vectors(turn, np.zeros(3)).rotation
        out.append(Pose(start.rotation @ turned, start.translation + shift))
    return out


def before_cameras() -> Pose:
    """A head that looks into the first camera from 600 mm, its face in the middle."""
    return Pose(FACING, FACING @ np.array([0.0, -40.0, -90.0]) + [0, 0, 600])


def seen_from(camera_pose: Pose, head: Pose) -> Pose:
    """Head to camera, of head to world and world to camera."""
    return Pose(camera_pose.rotation @ head.rotation, camera_pose.apply(head.translation))


def film(
    head: DottedHead,
    weights: np.ndarray,
    pose: Pose,
    camera: Camera,
    noise: float,
    seed: int,
    mirror: Mirror | None = None,
) -> np.ndarray:
    """A picture (H, W, 3) uint8 with a soft lens and noise (standard deviation, grey values)."""
    seen = pose.apply(head.dots(weights))
    fine = _backdrop(camera)
    if mirror is None:
        _draw(head.scene, weights, pose, camera, camera.whole, fine)
    else:  # only what is around the mouth, for the time that it takes
        mouth = seen[: len(LIPS17)]
        _draw(head.scene, weights, pose, camera, _around(camera, mouth), fine)
        there = _around(camera, mirror.reflect(mouth))
        _mirrored(head.scene, weights, pose, camera, mirror, there, fine)
    noisy = fine + np.random.default_rng(seed).normal(0, noise, fine.shape)
    return np.uint8(np.clip(np.rint(noisy), 0, 255))


def _backdrop(camera: Camera) -> np.ndarray:
    rows = np.linspace(120, 80, camera.size[1], dtype=np.float32)[:, None, None]
    return np.tile(rows, (1, camera.size[0], 3))


def _around(camera: Camera, points: np.ndarray) -> Window:
    at = camera.project(points)
    low, high = np.floor(at.min(axis=0)) - 40, np.ceil(at.max(axis=0)) + 40
    return Window(*low, *(high - low))


def _draw(
    scene: Scene, weights: np.ndarray, pose: Pose, camera: Camera, window: Window, into: np.ndarray
) -> None:
    """Draw the window finely, blur it as a lens does, and lay it into a picture."""
    fine = Window(window.x, window.y, window.width, window.height, _FINE)
    drawn = CpuRenderer().draw(scene, Candidates.one(weights, pose), camera, fine)[0]
    x, y, width, height = (int(v) for v in (window.x, window.y, window.width, window.height))
    behind = cv2.resize(into[y : y + height, x : x + width], drawn.rgb.shape[1::-1])
    sharp = np.where(drawn.covered[..., None], drawn.rgb, behind)
    soft = cv2.GaussianBlur(sharp, (0, 0), 0.5 * _FINE)
    into[y : y + height, x : x + width] = cv2.resize(
        soft, (width, height), interpolation=cv2.INTER_AREA
    )


def _mirrored(
    scene: Scene, weights: np.ndarray, pose: Pose, camera: Camera, mirror: Mirror,
    window: Window, into: np.ndarray,
) -> None:  # fmt: skip
    """The head that stands, reflected, behind the glass; as a scene that does not deform."""
    points = mirror.reflect(pose.apply(scene.vertices(weights)))
    faces = np.ascontiguousarray(scene.faces[:, [0, 2, 1]])  # still counter-clockwise
    still = Scene(
        points, np.zeros((0, *points.shape)), faces, scene.uv, scene.facet_class, scene.texture
    )
    here = Pose(np.eye(3), np.zeros(3))
    _draw(still, np.zeros(0), here, camera, window, into)


def board_picture(
    board: Board, pose: Pose, camera: Camera, mirror: Mirror | None = None, seed: int = 0
) -> np.ndarray:
    """A picture (H, W, 3) of a flat board (board to camera frame), by lines of sight.

    What is seen in the mirror is the board where the line of sight, reflected, meets it.
    """
    sight = _sight(camera)
    grey = _board_seen(board, pose, sight, np.zeros_like(sight))
    if mirror is not None:
        at_glass = sight * (-mirror.distance / (sight @ mirror.normal))[..., None]
        seen = _board_seen(board, pose, mirror.reflect_directions(sight), at_glass)
        grey = np.where(mirror.mask(camera), seen, grey)
    noise = np.random.default_rng(seed).normal(0, 2, grey.shape)
    noisy = cv2.GaussianBlur(grey, (0, 0), 0.6) + noise
    return np.repeat(np.uint8(np.clip(np.rint(noisy), 0, 255))[..., None], 3, axis=2)


_sight = lru_cache(maxsize=4)(lines_of_sight)


def _board_seen(board: Board, pose: Pose, sight: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Grey values (H, W) where lines from `start` along `sight` meet the board's printed side."""
    normal, scale = pose.rotation[:, 2], 8.0  # pixels of the print for a mm
    along = sight @ normal
    far = ((pose.translation - start) @ normal) / along
    hit = (start + sight * far[..., None] - pose.translation) @ pose.rotation
    printed = _printed(board, scale)
    at = (hit[..., :2] * scale - 0.5).astype(np.float32)
    grey = cv2.remap(
        printed, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT,
        borderValue=110,
    )  # fmt: skip
    return np.where((far > 0) & (along > 0), grey, 110.0)


@lru_cache(maxsize=4)
def _printed(board: Board, scale: float) -> np.ndarray:
    """The board as printed, with its upper left corner at the origin, slightly soft."""
    side = round(board.square * scale)
    if board.kind == "charuco":
        kinds = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{board.dictionary}"))
        drawn = cv2.aruco.CharucoBoard(
            (board.columns, board.rows), board.square, board.marker_side, kinds
        ).generateImage((board.columns * side, board.rows * side))
    else:
        y, x = np.mgrid[: board.rows, : board.columns]
        drawn = np.kron(np.uint8(255 * ((x + y) % 2)), np.ones((side, side), np.uint8))
    return cv2.GaussianBlur(drawn, (0, 0), 0.2 * scale)
