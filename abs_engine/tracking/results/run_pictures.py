"""Pictures of a run: the contact sheet, many mouths on one; and the whole head over a frame."""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray, Image, evenly
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.pose import parted
from abs_engine.core.scene import Candidates, Scene
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.frame.placed_mouths import in_picture
from abs_engine.tracking.results.contours import (
    LEGEND,
    LOST,
    OTHERWISE,
    WHITE,
    LipDrawing,
    write_text,
)
from abs_engine.tracking.results.run_table import closed_frames

MOST_TILES = 80
COLUMNS = 8
TILE = 240, 176
CAPTION = 22
ACROSS = 1.7  # mouth widths in a tile
_CLOSED = (255, 210, 90)
LESS, LESS_EXPLAINED = (255, 140, 0), "explained less than most"
"""Colour of the frame around a doubtful tile, and what it means; see `less_explained`."""
_SIDE = 480  # pixels, height of the picture
_ABOUT = 0.35  # of the head's size, that is shown around it
_LIPS, _INSIDE, _SKIN = (255, 70, 60), (60, 0, 0), (90, 160, 255)
_OPAQUE = 0.55


class ContactSheet:
    """Collects enlarged mouths with their contours; `picture` lays them out.

    Memory does not grow with the clip: tiles are thinned out as they come.
    """

    def __init__(self, setting: ClipSetting) -> None:
        self._drawing = LipDrawing.of(setting)
        self._tiles: list[Image] = []
        self._stride = 1
        self._seen = 0
        self._contradicted = False

    def add(self, image: Image, result: FrameResult) -> None:
        """Take a frame into account."""
        if self._seen % self._stride == 0:
            self._tiles.append(self.tile(image, result))
            if len(self._tiles) > 4 * MOST_TILES:
                self._tiles, self._stride = self._tiles[::2], 2 * self._stride
        self._seen += 1

    def tile(self, image: Image, result: FrameResult) -> Image:
        """One tile: the mouth, and below it frame number, aperture and whether it is closed."""
        width, height = TILE
        tile = np.zeros((height + CAPTION, width, 3), np.uint8)
        at = 6, height + 16
        if result.pose is None:
            write_text(tile, f"#{result.index}   {result.status}", at, LOST)
            return tile
        _, tile[:height] = self._drawing.view(result.pose, TILE, ACROSS).of(image, result)
        if not result.found:
            write_text(tile, f"#{result.index}   {result.status}", at, LOST)
            return tile
        closed = bool(closed_frames(result.aperture))
        text = f"#{result.index}   {result.aperture:.1f} mm{'   closed' if closed else ''}"
        plain = _CLOSED if closed else WHITE
        self._contradicted |= result.contradicted
        write_text(tile, text, at, LOST if result.contradicted else plain)
        return tile

    def picture(self, less: BoolArray | None = None) -> Image:
        """The sheet, (H, W, 3) uint8 RGB: all frames up to 80, else evenly spread ones.

        Tiles of those frames (T,) that are explained less than most are framed. Its last line says
        what the colours mean, and how many of the frames it shows.
        """
        count = len(self._tiles)
        chosen = evenly(count, MOST_TILES)
        rows = -(-len(chosen) // COLUMNS)
        high, wide = TILE[1] + CAPTION, TILE[0]
        sheet = np.full((rows * (high + 2) + CAPTION, COLUMNS * (wide + 2), 3), 40, np.uint8)
        for place, index in enumerate(chosen):
            y, x = (high + 2) * (place // COLUMNS), (wide + 2) * (place % COLUMNS)
            sheet[y : y + high, x : x + wide] = self._tiles[index]
            if less is not None and less[index * self._stride]:
                cv2.rectangle(sheet, (x + 2, y + 2), (x + wide - 3, y + TILE[1] - 3), LESS, 3)
        words = [*LEGEND, (f"{len(chosen)} of {self._seen} frames", WHITE)]
        if self._contradicted:
            words.append((OTHERWISE, LOST))
        if less is not None and less.any():
            words.append((LESS_EXPLAINED, LESS))
        for k, (text, colour) in enumerate(words):
            write_text(sheet, text, (6 + k * (wide + 2), len(sheet) - 6), colour)
        return sheet


def head_picture(setting: ClipSetting, image: Image, result: FrameResult) -> Image:
    """A frame (H, W, 3) RGB with a mouth, and beside it the same with the head drawn over it."""
    pose = result.pose
    if pose is None:
        return image
    scene = _head(setting, result)
    window = _window(scene, pose, setting.camera)
    one = Candidates.one(np.zeros(0), pose)
    buffers = setting.renderer.draw(scene, one, setting.camera, window)[0]
    plain = np.asarray(window.sample(image), np.uint8)
    plain = np.where(in_picture(window, image.shape)[..., None], plain, 0).astype(np.uint8)
    normals = vertex_normals(scene.mean.astype(np.float64), scene.faces)[scene.faces]
    facing = np.einsum("hwc,hwcd->hwd", buffers.barycentrics, normals[buffers.facet_id - 1])
    shade = np.clip(-(facing @ pose.rotation.T)[..., 2], 0.15, 1.0)[..., None]
    ink = _inks(setting)[buffers.class_id] * shade
    drawn = np.where(buffers.covered[..., None], (1 - _OPAQUE) * plain + _OPAQUE * ink, plain)
    return np.hstack([plain, np.asarray(np.rint(drawn), np.uint8)])


def _head(setting: ClipSetting, result: FrameResult) -> Scene:
    body = setting.face.body
    moved = np.tensordot(parted(result.vector)[1], body.modes, 1)
    vertices = np.asarray(body.mean + moved, np.float32)
    none, flat = np.zeros((0, *vertices.shape), np.float32), np.zeros((len(vertices), 2))
    plain = np.zeros((1, 1, 3), np.uint8)
    return Scene(vertices, none, body.faces, flat.astype(np.float32), body.facet_class, plain)


def _window(scene: Scene, pose: Pose, camera: Camera) -> Window:
    pixels = camera.project(pose.apply(scene.mean.astype(np.float64)))
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    size = (1 + 2 * _ABOUT) * (high - low)
    corner = low - _ABOUT * (high - low)
    x, y, width, height = (float(v) for v in (*corner, *size))
    return Window(x, y, width, height, _SIDE / height)


def _inks(setting: ClipSetting) -> FloatArray:
    """A colour for each facet class."""
    shown = {
        "lips": _LIPS,
        "dark": _INSIDE,
        "interior": _INSIDE,
        "teeth": (255, 255, 255),
        None: (255, 255, 255),
    }
    return np.array([shown.get(c, _SKIN) for c in setting.face.body.regions], np.float64)


class HeadKeeper:
    """Keeps the frame for the picture: the first found from half-way on, else the last before.

    Parameters
    ----------
    frames : int
        Number of frames that are expected, 0 where that is not known.
    """

    def __init__(self, setting: ClipSetting, frames: int) -> None:
        self._setting, self._wanted = setting, frames // 2
        self._kept: tuple[Image, FrameResult] | None = None

    def add(self, image: Image, result: FrameResult) -> None:
        """Look at the next frame."""
        if result.found and (self._kept is None or self._kept[1].index < self._wanted):
            self._kept = image, result

    def picture(self) -> Image | None:
        """The picture; None where no mouth was found."""
        return None if self._kept is None else head_picture(self._setting, *self._kept)
