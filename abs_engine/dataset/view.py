"""A clip as one camera sees it: the ground truth that evaluations read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.core.geometry import Pose, compose, pose_vectors
from abs_engine.core.kinds import checked_frame
from abs_engine.dataset import codec
from abs_engine.dataset.camera_file import PlacedCamera, load_placed_camera
from abs_engine.dataset.clip import Clip
from abs_engine.dataset.picture import AGAIN, read_picture
from abs_engine.io.arrays import Layout, real, truth
from abs_engine.io.assets import LIPS_OF_68
from abs_engine.io.npz import read_npz
from abs_engine.io.video import read_frames

_POINTS: Layout = {
    "landmark_pixels": real("T", 68, 2),
    "landmark_visible": truth("T", 68),
    "mirror_landmark_pixels": real("T", 68, 2, gaps=True, optional=True),
    "mirror_landmark_visible": truth("T", 68, optional=True),
    "in_picture": truth("T"),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Truth(Clip):
    """Ground truth of every frame that a camera took of a clip; adds to `Clip`:

    Parameters
    ----------
    folder : Path
        That of the camera.
    camera : Camera
    rotations : (T, 3) float64
        Rotation vectors, head to camera, radians. Compare rotations as matrices: near half a
        turn, where faces look into the camera, two opposite vectors mean the same.
    translations : (T, 3) float64, mm, camera frame
    placed : PlacedCamera, optional
        Where the camera stands in the world, and its mirror.

    Notes
    -----
    Pictures and landmark pixels are read from `folder` when they are asked for. Label pictures are
    sampled at pixel centres; the lens distorts vertices and leaves the edges between them straight.
    """  # noqa: D400

    folder: Path
    camera: Camera
    rotations: FloatArray
    translations: FloatArray
    placed: PlacedCamera | None = field(default=None, repr=False)

    def pose(self, frame: int) -> Pose:
        """Head to camera in a frame; `ParameterError` where there is none."""
        frame = checked_frame(frame, len(self))
        return Pose.from_vectors(self.rotations[frame], self.translations[frame])

    def pixels(self, frame: int, vertex: NDArray[np.integer]) -> FloatArray:
        """Places of vertices (N,) in the picture, (N, 2), seen or not."""
        points = self.vertices(frame)[vertex].astype(np.float64)
        return self.camera.project(self.pose(frame).apply(points))

    @property
    def video(self) -> Path:
        """The video of this camera."""
        return self.folder / codec.VIDEO

    @property
    def mirror(self) -> FloatArray | None:
        """Corners (4, 3), mm, camera frame, of the mirror, if there is one."""
        return None if self.placed is None else self.placed.mirror

    def frame_path(self, frame: int) -> Path | None:
        """The picture of a frame before compression, where the dataset keeps it."""
        checked_frame(frame, len(self))
        path = self.folder / codec.FRAMES / codec.frame_name(frame)
        return path if path.is_file() else None

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """The camera's pictures, frame by frame, (H, W, 3) uint8 RGB; best without compression."""
        if (self.folder / codec.FRAMES).is_dir():
            return (self._picture(codec.FRAMES, frame) for frame in range(len(self)))
        return read_frames(self.video)

    def has(self, kind: str) -> bool:
        """Whether the dataset has pictures of a kind: depth, normals, albedo, flow, cover, ..."""
        return (self.folder / kind).is_dir()

    def facet_ids(self, frame: int) -> NDArray[np.uint16]:
        """Facet index + 1 of each pixel, (H, W); 0 where the head is not seen."""
        return self._picture("ids", frame)

    def class_ids(self, frame: int) -> NDArray[np.uint8]:
        """Class id of each pixel, (H, W), an index into `class_names`; 0 is the background.

        Raises
        ------
        ModelFormatError
            If an id names no facet.
        """
        table, ids = np.concatenate([[0], self.facet_class]).astype(np.uint8), self.facet_ids(frame)
        if ids.max() >= len(table):
            raise ModelFormatError(
                f"frame {frame} of {self.folder} shows facet {ids.max() - 1} of {len(table) - 1}",
                AGAIN,
            )
        return np.asarray(table[ids], np.uint8)

    def depth(self, frame: int) -> NDArray[np.float32]:
        """Depth of each pixel, (H, W), mm along the optical axis; 0 where the head is not seen."""
        return codec.decode_depth(self._picture("depth", frame))

    def normals(self, frame: int) -> NDArray[np.float32]:
        """Smooth unit normals, (H, W, 3), camera frame; zero where the head is not seen."""
        return codec.decode_normals(self._picture("normals", frame))

    def albedo(self, frame: int) -> NDArray[np.uint8]:
        """Colour of the texture without light, (H, W, 3); 0 where the head is not seen."""
        return self._picture("albedo", frame)

    def flow(self, frame: int) -> tuple[NDArray[np.float32], BoolArray]:
        """Displacement (H, W, 2), px, into the next frame, and where it is known (H, W)."""
        return codec.decode_flow(self._picture("flow", frame))

    def cover(self, frame: int) -> NDArray[np.uint8]:
        """Labels of what hides the head, (H, W), see `codec.COVER_NAMES`; 0 without occluders."""
        if self.has(codec.COVER):
            return self._picture(codec.COVER, frame)
        checked_frame(frame, len(self))
        return np.zeros(self.camera.size[::-1], np.uint8)

    @property
    def landmark_pixels(self) -> FloatArray:
        """Pixels (T, 68, 2) of the 68 landmarks, seen or not."""
        return self._points["landmark_pixels"]

    @property
    def landmark_visible(self) -> BoolArray:
        """Mask (T, 68) of the landmarks that the camera sees."""
        return self._points["landmark_visible"]

    @property
    def lip_pixels(self) -> FloatArray:
        """Pixels (T, 20, 2) of the landmarks of the lips, seen or not."""
        return self.landmark_pixels[:, LIPS_OF_68]

    @property
    def lip_visible(self) -> BoolArray:
        """Mask (T, 20) of the landmarks of the lips that the camera sees."""
        return self.landmark_visible[:, LIPS_OF_68]

    @property
    def mirror_pixels(self) -> FloatArray | None:
        """Pixels (T, 68, 2) of the landmarks in the mirror, if there is one."""
        return self._points.get("mirror_landmark_pixels")

    @property
    def mirror_visible(self) -> BoolArray | None:
        """Mask (T, 68) of the landmarks that the camera sees in the mirror, if there is one."""
        return self._points.get("mirror_landmark_visible")

    @property
    def in_picture(self) -> BoolArray:
        """Whether any of the head is seen, (T,)."""
        return self._points["in_picture"]

    @cached_property
    def _points(self) -> dict[str, NDArray[Any]]:
        path = self.folder / codec.POINTS
        return read_npz(path, codec.POINTS_FORMAT, codec.VERSION, _POINTS, AGAIN, T=len(self))

    def _picture(self, kind: str, frame: int) -> NDArray[Any]:
        checked_frame(frame, len(self))
        path = self.folder / kind / codec.frame_name(frame)
        return read_picture(path, kind, self.camera.size)


def load_view(clip: Clip, folder: Path) -> Truth:
    """A clip as the camera in `folder` sees it.

    Raises
    ------
    InputFileError
        If ``camera.json`` or the video is missing or cannot be read.
    ModelFormatError
        If the camera's file has another format, or its motion is of other frames.
    """
    placed = load_placed_camera(folder / codec.CAMERA)
    if len(placed.rotations) not in (1, len(clip)):
        raise ModelFormatError(
            f"{folder / codec.CAMERA} has {len(placed.rotations)} poses for {len(clip)} frames",
            AGAIN,
        )
    if not (folder / codec.VIDEO).is_file():
        raise InputFileError(f"{folder / codec.VIDEO} does not exist", AGAIN)
    poses = [compose(placed.pose(t), clip.world_pose(t)) for t in range(len(clip))]
    rotations, translations = pose_vectors(poses)
    shared = {f.name: getattr(clip, f.name) for f in fields(Clip)}
    return Truth(
        folder=folder,
        camera=placed.camera,
        rotations=rotations,
        translations=translations,
        placed=placed,
        **shared,
    )
