"""Texture that depends linearly on the articulatory parameters (Odisio & Bailly, 3.1, eq. 1)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.arrays import IntArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer, Scene
from abs_engine.face.appearance.atlas import Atlas, warp
from abs_engine.face.appearance.regression import Frames, LinearFits
from abs_engine.face.appearance.residual_covariance import Leftover, leftover, normalised
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.io.arrays import Layout, real, whole

LAYOUT: Layout = {
    **dict.fromkeys(("base", "mean"), real("H", "W", 3, dtype=np.float32)),
    "modes": real("P*", "H", "W", 3, dtype=np.float32),
    "frames": whole("H", "W", dtype=np.int32, low=0),
    "explained": real(),
    "spread": real("H", "W", dtype=np.float32, low=0.0),
    "common": real("Q*", "H", "W", 3, dtype=np.float32),
}
"""Its arrays in a file."""


@dataclass(frozen=True, eq=False)
class TextureModel:
    """I_tex = I_0 + M_I a in the mesh's own texture atlas.

    Parameters
    ----------
    base : (H, W, 3) float32, RGB 0 to 255
        I_0.
    modes : (P, H, W, 3) float32, RGB per unit of parameter
        M_I; P is 0 for a constant texture (`tex_cst`).
    mean : (H, W, 3) float32, RGB 0 to 255
        Each texel's mean over the frames that show it.
    frames : (H, W) int32
        How many training frames show each texel: 0 where the atlas is empty or no frame shows
        it; the colour there is that of the nearest texel seen.
    explained : float
        Share of the RGB variance of the training frames that the model explains, 0 to 1.
    leftover : Leftover
        What the model leaves out of luminance-normalised training frames.

    Raises
    ------
    ParameterError
        If the arrays do not fit together or are not finite, or a spread is negative.
    """

    base: NDArray[np.float32]
    modes: NDArray[np.float32]
    mean: NDArray[np.float32]
    frames: NDArray[np.int32]
    explained: float
    leftover: Leftover

    def __post_init__(self) -> None:
        shape = self.base.shape
        fits = len(shape) == 3 and shape[2] == 3 and self.modes.shape[1:] == shape
        fits = fits and self.mean.shape == shape and self.frames.shape == shape[:2]
        fits = fits and self.leftover.spread.shape == shape[:2]
        fits = fits and self.leftover.common.shape[1:] == shape
        left = self.leftover
        known = (self.base, self.modes, self.mean, left.spread, left.common)
        if not fits or not all(np.isfinite(values).all() for values in known):
            raise ParameterError("texture arrays do not fit or hold NaN", "learn the texture again")
        if (left.spread < 0).any():
            raise ParameterError("a spread of the texture is negative", "learn the texture again")

    def at(self, parameters: ArrayLike) -> NDArray[np.uint8]:
        """The texture at parameters (P,), clipped, (H, W, 3) uint8; a constant one reads none."""
        row = np.asarray(parameters, np.float64)
        if len(self.modes) and row.shape != (len(self.modes),):
            raise ParameterError(
                f"{row.shape} parameters for a texture of {len(self.modes)}", "give one for each"
            )
        values = self.base + np.tensordot(row[: len(self.modes)], self.modes, 1)
        return np.asarray(np.rint(np.clip(values, 0, 255)), np.uint8)

    def nomogram(self, index: int, values: ArrayLike) -> list[NDArray[np.uint8]]:
        """Textures with one parameter at each of some values (sd) and the others at zero (fig. 4).

        Raises `ParameterError` if there is no such parameter.
        """
        if not 0 <= index < len(self.modes):
            raise ParameterError(
                f"the texture has no parameter {index}", f"choose one below {len(self.modes)}"
            )
        rows = np.zeros((np.size(values), len(self.modes)))
        rows[:, index] = np.ravel(values)
        return [self.at(row) for row in rows]

    def constant(self) -> TextureModel:
        """The model with M_I = 0 (`tex_cst`): the mean; what differences are measured by stays."""
        return replace(self, base=self.mean, modes=self.modes[:0], explained=0.0)

    def dress(self, scene: Scene) -> Scene:
        """A scene with this texture; modes of the scene beyond the model's leave it unchanged.

        Raises `ParameterError` if the scene has fewer modes than the texture has parameters.
        """
        spare = scene.n_modes - len(self.modes)
        if spare < 0:
            raise ParameterError(
                f"the texture depends on {len(self.modes)} parameters, the scene has "
                f"{scene.n_modes} modes",
                "learn both from the same parameters",
            )
        varying = len(self.modes) > 0
        extra = np.zeros((spare if varying else 0, *self.base.shape), np.float32)
        return replace(
            scene,
            texture=np.asarray(np.rint(np.clip(self.base, 0, 255)), np.uint8),
            texture_modes=np.concatenate([self.modes, extra]) if varying else None,
        )

    def arrays(self) -> dict[str, Any]:
        """All that it holds, by name, as a file has it; `from_arrays` takes it."""
        own = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "leftover"}
        return own | {"spread": self.leftover.spread, "common": self.leftover.common}

    @classmethod
    def from_arrays(cls, data: Mapping[str, NDArray[np.generic]]) -> TextureModel:
        """The model of a file's arrays; others are not read. Raises as `LocalModel.from_arrays`."""
        base, modes, mean = (np.asarray(data[k], np.float32) for k in ("base", "modes", "mean"))
        frames = np.asarray(data["frames"], np.int32)
        left = Leftover(*(np.asarray(data[k], np.float32) for k in ("spread", "common")))
        return cls(base, modes, mean, frames, float(data["explained"]), left)


def learn_texture(
    sightings: Iterable[Sighting], scene: Scene, atlas: Atlas, camera: Camera, renderer: Renderer
) -> TextureModel:
    """Learn I_0 and M_I by least squares for each texel, from the frames that show it.

    Parameters
    ----------
    sightings : iterable of Sighting
        Read once, one after the other; all of the scene, with the same number of parameters.
    atlas : Atlas
        Of the same mesh; see `lay_atlas` and `fitting_size`.
    renderer : Renderer
        Decides what each frame hides.

    Raises
    ------
    NothingSeenError
        If no texel is visible in any frame.
    PictureError
        If a picture holds NaN or has another size than the camera's.
    ParameterError
        If there are no frames, or shapes or numbers of parameters differ.

    Notes
    -----
    A frame counts for a texel by the cosine between the surface and the line of sight; what is
    hidden, turned away, or beside an outline does not count at all. What the fit leaves over is
    measured without that weight: each frame that shows a texel counts alike, and is off another fit
    than this one. For it the texels of all frames are kept, in float32, so memory grows with the
    number of frames.
    """
    fits, frames = _gathered(sightings, scene, atlas, camera, renderer, None)
    return _solved(fits, frames, APPEARANCE.ridge, atlas)


def learn_shared_texture(
    sightings: Iterable[Sighting],
    scene: Scene,
    atlas: Atlas,
    camera: Camera,
    renderer: Renderer,
    recordings: IntArray | None = None,
) -> tuple[TextureModel, float, float]:
    """Learn the texture that several recordings share, and how far a recording is off it.

    The ridge is that with which recordings foretell others best; without any, as `learn_texture`'s,
    whose errors it has. `recordings` (T,) says which frames were recorded together; by default each
    is a recording of its own.

    Returns
    -------
    TextureModel
    float
        Standard deviation, luminance-normalised, of a frame about what other recordings foretell.
    float
        Number of independent observations that a frame is worth: its sum of squares varies from
        frame to frame as that of so many does (Satterthwaite, Biometrics 1946).
    """
    fits, frames = _gathered(sightings, scene, atlas, camera, renderer, recordings)
    ridge = frames.ridge
    shown = frames.of(np.asarray(frames.seen.any(axis=0)))  # the rest only costs memory
    squared = (shown.left_out(ridge) ** 2).mean(axis=2).sum(axis=1)
    each = squared / np.maximum(frames.seen.sum(axis=1), 1)
    worth = 2 * each.mean() ** 2 / max(each.var(), 1e-300)
    model = _solved(fits, frames, ridge, atlas)
    return model, float(np.sqrt(each.mean())), float(worth)


def _gathered(
    sightings: Iterable[Sighting],
    scene: Scene,
    atlas: Atlas,
    camera: Camera,
    renderer: Renderer,
    recordings: IntArray | None,
) -> tuple[LinearFits, Frames]:
    """Sums of colours for the fits, and all frames' luminance-normalised ones."""
    fits: LinearFits | None = None
    values, seen, parameters = [], [], []
    for sighting in sightings:
        if fits is None:
            fits = LinearFits(len(atlas.texels[0]), 3, len(sighting.parameters))
        colours, weights = warp(sighting, atlas, scene, camera, renderer)
        fits.add(colours, weights, sighting.parameters)
        values.append(normalised(colours.astype(np.float32)))
        seen.append(weights > 0)
        parameters.append(sighting.parameters)
    if fits is None:
        raise ParameterError("there are no frames to learn a texture from", "give some")
    rows = np.array(parameters, np.float64)
    return fits, Frames(np.array(values), np.array(seen), rows, recordings)


def _solved(fits: LinearFits, frames: Frames, ridge: float, atlas: Atlas) -> TextureModel:
    """The model of what was gathered: fits of the atlas' texels, as pictures."""
    found, left = fits.solve(ridge), leftover(frames, ridge, atlas)
    seen = found.frames > 0
    shown = np.zeros(atlas.facet_id.shape, np.int32)
    shown[atlas.texels] = found.frames
    modes = [atlas.picture(mode, seen) for mode in found.modes]
    shape = (0, *atlas.facet_id.shape, 3)
    return TextureModel(
        base=atlas.picture(found.base, seen),
        modes=np.stack(modes) if modes else np.zeros(shape, np.float32),
        mean=atlas.picture(found.mean, seen),
        frames=shown,
        explained=found.explained,
        leftover=left,
    )
