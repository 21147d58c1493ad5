"""Facets of a scene that carry labels, and the buffers from which OpenGL draws them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from abs_engine.render.layout import Layout


class Labelled:
    """Facets that carry labels; the CPU places their vertices and selects which are drawn.

    Parameters
    ----------
    name : str
        Of what the labels are.
    layout : Layout
    buffer, reserve : callable
        Make a buffer from an array, and an empty one of a number of bytes.
    """

    def __init__(
        self,
        name: str,
        layout: Layout,
        buffer: Callable[[NDArray[Any]], moderngl.Buffer],
        reserve: Callable[[int], moderngl.Buffer],
    ) -> None:
        self.name, self.layout, self._buffer, self._reserve = name, layout, buffer, reserve
        self.positions = np.empty((len(layout.source), 4), np.float32)
        self.kept = np.empty((len(layout.faces), 3), np.int32)

    @cached_property
    def vertex_buffer(self) -> moderngl.Buffer:
        """Clip coordinates of each vertex."""
        return self._reserve(self.positions.nbytes)

    @cached_property
    def kept_buffer(self) -> moderngl.Buffer:
        """Indices of the facets that are submitted."""
        return self._reserve(self.kept.nbytes)

    @cached_property
    def label_buffer(self) -> moderngl.Buffer:
        """Label of each vertex."""
        return self._buffer(self.layout.label)
