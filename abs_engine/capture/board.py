"""Calibration boards, chessboard and ChArUco, and where their corners are in a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import FloatArray, Image, IntArray
from abs_engine.core.errors import ParameterError

Kind = Literal["chessboard", "charuco"]


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of a board that were found in a picture, K of them.

    Parameters
    ----------
    ids : (K,) int64
        Number of each on the board, from 0.
    pixels : (K, 2) float64
    places : (K, 3) float64, mm, board frame
        z is 0.
    """

    ids: IntArray
    pixels: FloatArray
    places: FloatArray

    def common(self, other: Corners) -> tuple[Corners, Corners]:
        """The corners that both have, in the same order."""
        _, mine, others = np.intersect1d(self.ids, other.ids, return_indices=True)
        return self.at(mine), other.at(others)

    def at(self, which: IntArray) -> Corners:
        """Some of them."""
        return Corners(self.ids[which], self.pixels[which], self.places[which])


@dataclass(frozen=True)
class Board:
    """A flat board.

    Parameters
    ----------
    kind : {"chessboard", "charuco"}
    columns, rows : int
        Squares of the board; a chessboard's inner corners are one fewer each way.
    square : float
        Side of a square, mm.
    marker : float, optional
        Side of a ChArUco's markers, mm; by default 0.75 squares.
    dictionary : str
        Of a ChArUco's markers, as OpenCV names it without ``DICT_``.

    Raises
    ------
    ParameterError
        If there is no such board.
    """

    kind: Kind
    columns: int
    rows: int
    square: float
    marker: float | None = None
    dictionary: str = "4X4_50"

    def __post_init__(self) -> None:
        if self.kind not in get_args(Kind):
            raise ParameterError(
                f"there is no board '{self.kind}'", f"choose one of {', '.join(get_args(Kind))}"
            )
        if min(self.columns, self.rows) < 4 or not 0 < self.square < np.inf:
            raise ParameterError(
                f"a board of {self.columns} x {self.rows} squares of {self.square:g} mm cannot be",
                "give four squares or more each way, and their side",
            )
        if self.kind == "charuco":
            if not 0 < self.marker_side < self.square:
                raise ParameterError("the markers do not fit the squares", "measure them again")
            if not hasattr(cv2.aruco, f"DICT_{self.dictionary}"):
                raise ParameterError(
                    f"there are no markers '{self.dictionary}'",
                    "give one such as 4X4_50 or 5X5_100",
                )
            needed, there = self.columns * self.rows // 2, len(self.markers().bytesList)
            if needed > there:
                raise ParameterError(
                    f"a board of {self.columns} x {self.rows} squares has {needed} markers, "
                    f"{self.dictionary} has only {there}",
                    "give the dictionary that it was printed with, such as 4X4_1000",
                )

    def markers(self) -> cv2.aruco.Dictionary:
        """OpenCV's dictionary of a ChArUco's markers."""
        return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{self.dictionary}"))

    @property
    def marker_side(self) -> float:
        """Side of a marker, mm."""
        return 0.75 * self.square if self.marker is None else self.marker

    @cached_property
    def places(self) -> FloatArray:
        """All inner corners (K, 3), mm, row by row from the top left; z is 0."""
        y, x = np.mgrid[1 : self.rows, 1 : self.columns]
        flat = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
        return np.asarray(flat * self.square, np.float64)

    def find(self, image: Image, mirrored: bool = False) -> Corners | None:
        """The corners of the board in a picture, or None where it is not seen.

        Parameters
        ----------
        mirrored : bool
            Look for the board as a mirror shows it, left and right exchanged. Only a ChArUco,
            whose markers cannot be read the wrong way round, is told apart from its own image.
        """
        grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)
        if not mirrored:
            return self._find(grey)
        found = self._find(np.ascontiguousarray(grey[:, ::-1]))
        if found is not None:
            found.pixels[:, 0] = image.shape[1] - 1 - found.pixels[:, 0]
        return found

    def _find(self, grey: Image) -> Corners | None:
        if self.kind == "chessboard":
            size = self.columns - 1, self.rows - 1
            seen, pixels = cv2.findChessboardCornersSB(
                grey, size, flags=cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE
            )
            if not seen:
                return None
            fine = _refined(grey, np.asarray(pixels, np.float32).reshape(*size[::-1], 2))
            return Corners(np.arange(len(self.places)), fine, self.places)
        for legacy in (False, True):  # boards with an even number of rows, before OpenCV 4.6
            found = self._find_charuco(grey, legacy)
            if found is not None:
                return found
        return None

    def _find_charuco(self, grey: Image, legacy: bool) -> Corners | None:
        kinds = self.markers()
        board = cv2.aruco.CharucoBoard(
            (self.columns, self.rows), self.square, self.marker_side, kinds
        )
        board.setLegacyPattern(legacy)
        corners, ids, _ = cv2.aruco.ArucoDetector(kinds).detectMarkers(grey)
        if not len(corners):
            return None
        corners, ids = _of_one_plane(board, corners, np.asarray(ids, np.int32).reshape(-1, 1))
        if len(ids) < CAPTURE.least_markers:
            return None
        detector = cv2.aruco.CharucoDetector(board)
        pixels, numbers, _, _ = detector.detectBoard(grey, markerCorners=corners, markerIds=ids)
        if numbers is None or len(numbers) < CAPTURE.least_corners:
            return None
        which = np.asarray(numbers, np.int64).ravel()
        return Corners(which, np.array(pixels, np.float64).reshape(-1, 2), self.places[which])


def _refined(grey: Image, pixels: NDArray[np.float32]) -> FloatArray:
    """Corners (rows, columns, 2) moved to the saddles of the grey values; (K, 2).

    What `findChessboardCornersSB` gives on small tilted squares is off by some 0.1 px, not by
    chance: focal lengths came out 1 % too long without this step.
    """
    apart = min(np.linalg.norm(np.diff(pixels, axis=k), axis=2).min() for k in (0, 1))
    half = int(np.clip(apart / 3, *CAPTURE.corner_window))
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-3)
    flat = np.ascontiguousarray(pixels.reshape(-1, 1, 2))
    return np.array(cv2.cornerSubPix(grey, flat, (half, half), (-1, -1), stop), np.float64).reshape(
        -1, 2
    )


def _of_one_plane(
    board: cv2.aruco.CharucoBoard, corners: Sequence[Any], ids: NDArray[np.int32]
) -> tuple[list[Any], NDArray[np.int32]]:
    """The markers that agree on where the board is.

    Beside the board there may be its mirror image, whose markers are at times taken for others.
    """
    known = ids.ravel() < len(board.getIds())
    corners, ids = [c for c, k in zip(corners, known, strict=True) if k], ids[known]
    if len(ids) < CAPTURE.least_markers:
        return [], ids[:0]
    corners_of = np.asarray(board.getObjPoints(), np.float64)
    places = corners_of[ids.ravel(), :, :2].reshape(-1, 2)
    pixels = np.stack([c.reshape(4, 2) for c in corners])
    side = float(np.median(np.linalg.norm(pixels[:, 0] - pixels[:, 1], axis=1)))
    _, mask = cv2.findHomography(
        places, pixels.reshape(-1, 2), cv2.RANSAC, CAPTURE.marker_off * side
    )
    if not np.size(mask):
        return [], ids[:0]
    agreed = np.asarray(np.asarray(mask).reshape(-1, 4).all(axis=1))
    return [c for c, k in zip(corners, agreed, strict=True) if k], ids[agreed]
