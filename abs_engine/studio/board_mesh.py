"""Mesh of a printed calibration board, in the frame that `prop_mesh` describes."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.board import Board
from abs_engine.core.arrays import FloatArray
from abs_engine.studio.prop_mesh import Colour, Prop

_MARGIN = 0.5  # squares of bare paper around the print, without which markers at the edge are lost
_THICK = 2.0  # mm
_INK = (24, 24, 26)
_FINE = 16  # pixels for a cell where OpenCV draws the board
_FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


@lru_cache(maxsize=4)
def printed(board: Board, paper: Colour) -> Prop:
    """A sheet with the board on the side that looks away from the face, and a bare back.

    The origin is the middle of the print; the board's upper left corner is at the subject's upper
    right, so that it reads the right way round before the face. Every cell of the print has four
    vertices of its own, as a shared one would blend the colours of its neighbours.

    Parameters
    ----------
    paper : (3,) int, sRGB
    """
    x, y = (_lines(board, count) for count in (board.columns, board.rows))
    margin = _MARGIN * board.square
    cells = np.pad(_cells(board, x, y), 1, constant_values=255)  # the margin is paper
    x, y = (np.concatenate([[-margin], line, [line[-1] + margin]]) for line in (x, y))
    half = np.array([board.columns, board.rows]) * board.square / 2
    left, right = (np.tile(edge - half[0], len(y) - 1) for edge in (x[:-1], x[1:]))
    upper, lower = (np.repeat(half[1] - edge, len(x) - 1) for edge in (y[:-1], y[1:]))
    front = _quads(left, right, lower, upper)
    reach = half + margin
    back = _quads(*np.array([[reach[0], -reach[0], -reach[1], reach[1]]]).T) - [0, 0, _THICK]
    ink = np.where(cells.reshape(-1, 1) > 127, np.array(paper), np.array(_INK))
    vertices = np.concatenate([front, back])
    faces = (4 * np.arange(len(vertices) // 4)[:, None, None] + _FACES).reshape(-1, 3)
    away = np.repeat([1.0, -1.0], [len(front), len(back)])
    return Prop(
        vertices.astype(np.float32),
        faces.astype(np.int32),
        np.column_stack([0 * away, 0 * away, away]).astype(np.float32),
        np.repeat(np.vstack([ink, paper]), 4, axis=0).astype(np.uint8),
    )


def _lines(board: Board, squares: int) -> FloatArray:
    """Lines along a side at which the colour may change, mm from the print's edge, rising."""
    inner = np.zeros(1)
    if board.kind == "charuco":
        bits = board.markers().markerSize + 2  # a black border of one bit
        edge = (board.square - board.marker_side) / 2
        inner = np.concatenate([inner, edge + board.marker_side / bits * np.arange(bits + 1)])
    lines = (board.square * np.arange(squares)[:, None] + inner).ravel()
    return np.append(lines, board.square * squares)


def _cells(board: Board, x: FloatArray, y: FloatArray) -> NDArray[np.uint8]:
    """Grey value of each cell (len(y) - 1, len(x) - 1) between lines, as `Board.find` wants it."""
    columns, rows = (((a[:-1] + a[1:]) / 2 / board.square) for a in (x, y))
    if board.kind == "chessboard":
        odd = (rows.astype(int)[:, None] + columns.astype(int)) % 2
        return np.asarray(255 * odd, np.uint8)
    kinds = board.markers()
    side = _FINE * (kinds.markerSize + 4)
    drawn = cv2.aruco.CharucoBoard(
        (board.columns, board.rows), board.square, board.marker_side, kinds
    ).generateImage((board.columns * side, board.rows * side))
    at = np.ix_((rows * side).astype(int), (columns * side).astype(int))
    return np.asarray(drawn[at], np.uint8)


def _quads(left: FloatArray, right: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Corners (4 Q, 3) of upright rectangles, counter-clockwise where left is less than right."""
    corners = [(left, lower), (right, lower), (right, upper), (left, upper)]
    flat = np.stack([np.column_stack(corner) for corner in corners], axis=1).reshape(-1, 2)
    return np.column_stack([flat, np.zeros(len(flat))])
