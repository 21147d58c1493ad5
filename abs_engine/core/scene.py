"""A scene: a textured mesh with facet classes that deforms linearly, and its place.

Also the `Renderer` protocol, behind which OpenGL and the CPU rasteriser stand.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.buffers import Buffers, Sums
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import MeshError, ParameterError
from abs_engine.core.geometry import Pose, check_mesh, rotations


@dataclass(frozen=True, eq=False)
class Scene:
    """A linear family of textured meshes, X = mean + weights . modes.

    Parameters
    ----------
    mean : (V, 3) float32, mm, head frame
    modes : (P, V, 3) float32, mm per unit of weight; P may be 0
    faces : (F, 3) int32, counter-clockwise from outside
    uv : (V, 2) float32
        Texture coordinates, u to the right, v DOWN from the top left corner of the texture.
    facet_class : (F,) int32, from 1; 0 is kept for the background
    texture : (H, W, 3) uint8 RGB
    cull : bool
        Whether facets seen from behind are left out.
    texture_modes : (P, H, W, 3) float32, RGB of 0 to 255 per unit of weight, optional
        The texture depends on the weights too: texture + weights . texture_modes, interpolated
        between texels and then clipped to 0 and 255. Of the texture's own size.

    Raises
    ------
    MeshError
        If the arrays do not fit together, one would be rounded or cut off in its type, or the mean
        is not a drawable mesh.
    """

    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    faces: NDArray[np.int32]
    uv: NDArray[np.float32]
    facet_class: NDArray[np.int32]
    texture: NDArray[np.uint8]
    cull: bool = True
    texture_modes: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        for name, kind in _DTYPES.items():
            object.__setattr__(self, name, _as_drawn(name, getattr(self, name), kind))
        check_mesh(self.mean.astype(np.float64), self.faces)
        vertices, facets = len(self.mean), len(self.faces)
        fits = (
            self.modes.shape[1:] == (vertices, 3)
            and self.uv.shape == (vertices, 2)
            and self.facet_class.shape == (facets,)
            and self.texture.ndim == 3
            and self.texture.shape[2] == 3
            and self.texture.size
        )
        if not fits:
            raise MeshError("modes, uv, classes or texture do not fit the mesh", "check shapes")
        if self.facet_class.min() < 1:
            raise MeshError("facet classes start at 1", "keep 0 for the background")
        if not np.isfinite(self.modes).all() or not np.isfinite(self.uv).all():
            raise MeshError("modes or uv hold NaN", "repair the model file")
        if self.texture_modes is not None:
            self._take_texture_modes(self.texture_modes)

    def _take_texture_modes(self, given: NDArray[np.float32]) -> None:
        layers = np.ascontiguousarray(given, np.float32)
        if layers.shape != (self.n_modes, *self.texture.shape) or not np.isfinite(layers).all():
            raise MeshError(
                f"texture modes have shape {layers.shape} or hold NaN",
                f"give one of {self.texture.shape} for each of the {self.n_modes} modes",
            )
        object.__setattr__(self, "texture_modes", layers if len(layers) else None)

    @property
    def n_modes(self) -> int:
        """Number of modes, P."""
        return len(self.modes)

    def at(self, mean: NDArray[np.float32]) -> Scene:
        """The same scene with its mean elsewhere, (V, 3); the mesh is not checked once more."""
        moved = copy(self)
        object.__setattr__(moved, "mean", np.ascontiguousarray(mean, np.float32))
        return moved

    @cached_property
    def highest_class(self) -> int:
        """Largest number of a facet's class."""
        return int(self.facet_class.max())

    @cached_property
    def modes_of_vertices(self) -> NDArray[np.float32]:
        """The modes vertex by vertex, (V, P, 3), for loops over few vertices."""
        return np.ascontiguousarray(self.modes.transpose(1, 0, 2))

    def vertices(self, weights: ArrayLike) -> NDArray[np.float64]:
        """Deformed vertices (V, 3), mm, head frame, for weights (P,)."""
        if np.shape(weights) != (self.n_modes,):
            raise ParameterError(
                f"weights of shape {np.shape(weights)} are given", f"give ({self.n_modes},)"
            )
        moved = np.tensordot(np.asarray(weights, np.float64), self.exact_modes, axes=1)
        return np.asarray(self.mean + moved, np.float64)

    @cached_property
    def exact_modes(self) -> NDArray[np.float64]:
        """The modes (P, V, 3) as they are computed with."""
        return self.modes.astype(np.float64)


_DTYPES: dict[str, type[np.generic]] = {
    "mean": np.float32,
    "modes": np.float32,
    "faces": np.int32,
    "uv": np.float32,
    "facet_class": np.int32,
    "texture": np.uint8,
}


def _as_drawn(name: str, given: ArrayLike, kind: type[np.generic]) -> NDArray[Any]:
    """An array in the type that it is drawn in; else `MeshError`."""
    remedy = f"give an array of {np.dtype(kind)}"
    try:
        array = np.ascontiguousarray(given, kind)
    except (TypeError, ValueError, OverflowError) as error:
        raise MeshError(f"a scene's {name} cannot be read ({error})", remedy) from error
    exact = np.dtype(kind).kind == "f" or np.asarray(given).dtype == kind
    if not (exact or np.array_equal(array, given)):
        raise MeshError(f"a scene's {name} holds fractions, or numbers out of range", remedy)
    return array


@dataclass(frozen=True, eq=False)
class Candidates:
    """A batch of B states to draw: weights of the modes and poses.

    Parameters
    ----------
    weights : (B, P) float64
    rotations : (B, 3, 3) float64, head to camera
    translations : (B, 3) float64, mm, camera frame
    """

    weights: NDArray[np.float64]
    rotations: NDArray[np.float64]
    translations: NDArray[np.float64]

    def __post_init__(self) -> None:
        n = len(self.weights)
        shapes = self.weights.ndim, self.rotations.shape, self.translations.shape
        if shapes != (2, (n, 3, 3), (n, 3)):
            raise ParameterError(
                f"candidate arrays have shapes {self.weights.shape}, {self.rotations.shape}, "
                f"{self.translations.shape}",
                "give (B, P), (B, 3, 3) and (B, 3)",
            )

    @classmethod
    def one(cls, weights: ArrayLike, pose: Pose) -> Candidates:
        """A batch of one."""
        row = np.atleast_2d(np.asarray(weights, np.float64))
        return cls(row, pose.rotation[None], pose.translation[None])

    @classmethod
    def from_vectors(
        cls, weights: ArrayLike, rotation_vectors: ArrayLike, translations: ArrayLike
    ) -> Candidates:
        """From weights (B, P), rotation vectors (B, 3) in radians and translations (B, 3) in mm."""
        vectors = np.asarray(rotation_vectors, np.float64)
        if vectors.ndim != 2 or vectors.shape[1] != 3:
            raise ParameterError(f"rotation vectors have shape {vectors.shape}", "give (B, 3)")
        return cls(
            np.asarray(weights, np.float64), rotations(vectors),
            np.asarray(translations, np.float64),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.weights)


@dataclass(frozen=True, eq=False)
class ClassMaps:
    """Pixel term of the facet likelihood: each drawn pixel adds the map of its class.

    Parameters
    ----------
    maps : (C, H, W) float32, not negative
        One map for each class id, at the drawn resolution; `maps[0]` (background) is not read.
    """

    maps: NDArray[np.float32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "maps", np.ascontiguousarray(self.maps, np.float32))
        if self.maps.ndim != 3 or not np.isfinite(self.maps).all() or self.maps.min() < 0:
            raise ParameterError(
                "class maps must be (C, H, W), finite and not negative", "check them"
            )


@dataclass(frozen=True, eq=False)
class ColourError:
    """Pixel term of the texture comparison: squared difference of luminance-normalised RGB.

    A pixel adds sum_c (a_c - s_c)^2 where a and s are (c + 1) / (R + G + B + 3) of the frame
    and of the drawing, colours 0 to 255 (the offsets define black, where R/(R+G+B) is not).

    Parameters
    ----------
    frame : (H, W, 3) float32, 0 to 255
        The window of the frame at the drawn resolution.
    """

    frame: NDArray[np.float32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "frame", np.ascontiguousarray(self.frame, np.float32))
        if self.frame.ndim != 3 or self.frame.shape[2] != 3:
            raise ParameterError(f"frame has shape {self.frame.shape}", "give (H, W, 3)")

    @cached_property
    def normalised(self) -> NDArray[np.float32]:
        """The frame's luminance-normalised RGB, (H, W, 3) float32; constant over a fit."""
        return np.asarray((self.frame + 1) / (self.frame.sum(axis=2, keepdims=True) + 3))


PixelTerm = ClassMaps | ColourError


class Renderer(Protocol):
    """Draws scenes. `OpenGLRenderer` and `CpuRenderer` stand behind it."""

    @property
    def description(self) -> str:
        """One line that names what draws, for results and notices."""
        ...

    def draw(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Buffers]:
        """Draw every candidate in the window and return its buffers."""
        ...

    def close(self) -> None:
        """Release what the renderer owns; it cannot be used afterwards."""
        ...


class FusedRenderer(Renderer, Protocol):
    """A renderer that can also compare while it draws: an optimisation, see `compare.sums`."""

    def measure(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window, term: PixelTerm
    ) -> Sums:
        """Draw every candidate and sum `term` over its drawn pixels; only numbers come back."""
        ...
