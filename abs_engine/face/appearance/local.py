"""Local appearance of points of the surface, linear in the parameters (Odisio & Bailly, 3.2)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer, Scene
from abs_engine.face.appearance.descriptors import COMPONENTS, DescriptorMaps
from abs_engine.face.appearance.patches import Patches
from abs_engine.face.appearance.regression import Fitted, Frames, LinearFits
from abs_engine.face.appearance.visibility import Sighting, sighted
from abs_engine.face.appearance.windows import Windows
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.io.arrays import Layout, real, whole

SHARES = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
"""What is tried for `AppearanceSettings.alone` where there are several recordings."""
N_D = len(COMPONENTS)


@dataclass(frozen=True, eq=False)
class LocalModel:
    """d^i = d_0^i + M_D^i a for N points of the surface (eqs. 2 and 3).

    Parameters
    ----------
    vertices : (N,) int64
        Vertices of the scene.
    base : (N, 8) float64
        d_0, in the order of `descriptors.COMPONENTS`.
    modes : (P, N, 8) float64, per unit of parameter
        M_D; P is 0 for constant appearance (`la_cst`).
    mean : (N, 8) float64
        Over the frames that show the point.
    sigma : (N,) float64, drawn pixels
        Scale of each point's filters; all alike in the paper.
    spread : (N, 8) float64
        Standard deviation of what is left out, over the frames that show the point.
    left_out : (T, N, 8) float32
        By how much each training frame's descriptor is off what the other frames foretell; 0
        where the point is hidden.
    seen : (N,) float64
        Share of the training frames that show the point, 0 to 1.
    facing : (N,) float64
        Mean cosine between normal and line of sight in these frames.
    reach : (P,) float64
        Root mean square of each parameter over the training frames.
    explained : float
        Share of the descriptors' variance that the model explains, 0 to 1.
    unit : float, drawn pixels per mm
        0 where the filters' windows are rigid in the picture, as in the paper; else see
        `windows.Windows`.
    """

    vertices: IntArray
    base: FloatArray
    modes: FloatArray
    mean: FloatArray
    sigma: FloatArray
    spread: FloatArray
    left_out: NDArray[np.float32]
    seen: FloatArray
    facing: FloatArray
    reach: FloatArray
    explained: float
    unit: float = 0.0

    def __post_init__(self) -> None:
        n, p = len(self.vertices), len(self.modes)
        fits = all(a.shape == (n,) for a in (self.vertices, self.sigma, self.seen, self.facing))
        fits = fits and all(a.shape == (n, N_D) for a in (self.base, self.mean, self.spread))
        fits = fits and self.left_out.shape[1:] == (n, N_D)
        if n == 0 or not fits or self.modes.shape != (p, n, N_D) or self.reach.shape != (p,):
            raise ParameterError("local appearance arrays do not fit", "learn them again")
        if not (np.isfinite(self.base).all() and np.isfinite(self.modes).all()):
            raise ParameterError("a local appearance model holds NaN", "learn it again")

    def __len__(self) -> int:
        """Return the number of points, N."""
        return len(self.vertices)

    @property
    def inverse(self) -> FloatArray:
        """One over `spread` (N, 8), which counts as a tenth of its median where it is smaller."""
        return _inverse(self.spread)

    @cached_property
    def whitener(self) -> FloatArray:
        """Makes noise of all descriptors together, in units of `spread`, white: (8 N, 8 N).

        What a linear model misses is missed by many points at once: where lips roll in, or light
        falls otherwise, all around them are off alike. The inverse root of the correlation of
        what was left out, drawn by `APPEARANCE.alone` to the identity.
        """
        return self.whitened_by(APPEARANCE.alone)

    def whitened_by(self, alone: float) -> FloatArray:
        """The same with another share, 0 to 1, for `AppearanceSettings.alone`."""
        rows = (self.left_out * self.inverse).reshape(len(self.left_out), -1)
        together = rows.T @ rows / max(len(rows), 1)
        values, axes = np.linalg.eigh((1 - alone) * together + alone * np.eye(len(together)))
        return np.asarray((axes / np.sqrt(np.maximum(values, alone))) @ axes.T)

    def at(self, parameters: ArrayLike) -> FloatArray:
        """Descriptors (..., N, 8) at parameters (..., P); those beyond the model's are not read."""
        given = np.asarray(parameters, np.float64)
        if given.shape[-1] < len(self.modes):
            raise ParameterError(
                f"{given.shape[-1]} parameters for a model of {len(self.modes)}", "give one each"
            )
        return np.asarray(self.base + np.tensordot(given[..., : len(self.modes)], self.modes, 1))

    def constant(self, parameters: ArrayLike | None = None) -> LocalModel:
        """The model with M_D = 0 (`la_cst`): the mean, or the appearance at given parameters.

        All else stays, what differences are measured by too.
        """
        base = self.mean if parameters is None else self.at(parameters)
        return replace(self, base=base, modes=self.modes[:0], reach=self.reach[:0], explained=0.0)

    def only(self, chosen: NDArray[np.integer]) -> LocalModel:
        """The model of some of its points, indices (M,)."""
        kept = {f.name: getattr(self, f.name)[chosen] for f in fields(self) if f.name in _BY_POINT}
        modes, left_out = self.modes[:, chosen], self.left_out[:, chosen]
        return replace(self, modes=modes, left_out=left_out, **kept)

    def within(self, kept: NDArray[np.integer]) -> LocalModel:
        """The model on a part of its scene that has the vertices `kept` (V',), ascending.

        Raises
        ------
        ParameterError
            If a point is not in the part.
        """
        place = np.searchsorted(kept, self.vertices).clip(0, len(kept) - 1)
        if not np.array_equal(kept[place], self.vertices):
            raise ParameterError("points lie outside of the part", "choose them inside of it")
        return replace(self, vertices=place.astype(np.int64))

    def arrays(self) -> dict[str, Any]:
        """All that it holds, by name, as a file has it; `from_arrays` takes it."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @classmethod
    def from_arrays(cls, data: Mapping[str, NDArray[np.generic]]) -> LocalModel:
        """The model of the arrays of a file; others among them are not read.

        Raises
        ------
        KeyError
            If one is missing.
        TypeError, ValueError, ParameterError
            If one is of another kind, or they do not make a model.
        """
        names = [f.name for f in fields(cls) if f.name not in ("vertices", "left_out", *_NUMBERS)]
        arrays = {name: np.asarray(data[name], np.float64) for name in names}
        left_out = np.asarray(data["left_out"], np.float32)
        vertices = np.asarray(data["vertices"], np.int64)
        explained, unit = (float(data[name]) for name in _NUMBERS)
        return cls(vertices=vertices, left_out=left_out, explained=explained, unit=unit, **arrays)


LAYOUT: Layout = {
    "vertices": whole("N", low=0),
    **dict.fromkeys(("base", "mean"), real("N", N_D)),
    "modes": real("P*", "N", N_D),
    "sigma": real("N", low=1e-9),
    "spread": real("N", N_D, low=0.0),
    "left_out": real("Q*", "N", N_D, dtype=np.float32),
    **dict.fromkeys(("seen", "facing"), real("N", low=0.0)),
    "reach": real("P*"),
    **dict.fromkeys(("explained", "unit"), real()),
}
"""Its arrays in a file."""
_BY_POINT = ("vertices", "base", "mean", "sigma", "spread", "seen", "facing")
_NUMBERS = ("explained", "unit")


def learn_local(
    sightings: Iterable[Sighting],
    scene: Scene,
    vertices: NDArray[np.integer],
    camera: Camera,
    renderer: Renderer,
    sigma: float | FloatArray = APPEARANCE.sigma,
    scale: float = 1.0,
    ridge: float = APPEARANCE.ridge,
    unit: float = 0.0,
) -> LocalModel:
    """Learn d_0 and M_D of some points by least squares, from the frames that show them.

    Parameters
    ----------
    sightings : iterable of Sighting
        Read once, one after the other; all with the same number of parameters.
    scene, camera, renderer
        Of the sightings; what is hidden in them is found by drawing.
    vertices : (N,) int
        The points; see `choose.choose_points` for which of them to keep.
    sigma : float or (N,) float64, drawn pixels
        Scale of the filters, one for all or one for each point.
    scale : float
        Drawn pixels per image pixel; frames are compared at the same.
    ridge : float, frames
        See `LinearFits.solve`.
    unit : float, drawn pixels per mm
        0 for the paper's rigid windows; else see `windows.Windows`.

    Raises
    ------
    NothingSeenError
        If no point is visible in any frame.
    PictureError
        If a picture holds NaN or has another size than the camera's.
    ParameterError
        If there are no frames, or shapes or numbers of parameters differ.
    """
    return learn_local_frames(
        sightings, scene, vertices, camera, renderer, sigma, scale, ridge, unit
    )[0]


def learn_local_frames(
    sightings: Iterable[Sighting],
    scene: Scene,
    vertices: NDArray[np.integer],
    camera: Camera,
    renderer: Renderer,
    sigma: float | FloatArray = APPEARANCE.sigma,
    scale: float = 1.0,
    ridge: float = APPEARANCE.ridge,
    unit: float = 0.0,
    recordings: IntArray | None = None,
) -> tuple[LocalModel, Frames, float]:
    """The same with the descriptors that it was learned from, and the ridge.

    Parameters
    ----------
    sightings, scene, vertices, camera, renderer, sigma, scale, ridge, unit
        As of `learn_local`.
    recordings : (T,) int64, optional
        Which frames were recorded together. Then the ridge is that with which recordings foretell
        others best, and what is left out is so by whole recordings.

    Raises
    ------
    NothingSeenError, PictureError, ParameterError
        As `learn_local`.
    """
    patches = Patches.around(scene, vertices)
    windows = Windows(patches, np.full(len(vertices), sigma, np.float64), unit)
    window = Window(0, 0, *camera.size, scale)
    fits: LinearFits | None = None
    rows, shown, values = [], [], []
    facing = np.zeros(len(vertices))
    for sighting in sightings:
        if fits is None:
            fits = LinearFits(len(vertices), N_D, len(sighting.parameters))
        weights, flat = sighted(sighting, patches, scene, camera, window, renderer)
        image = window.sample(np.asarray(sighting.image, np.float32))
        found = windows.read(DescriptorMaps.of(image, windows.scales), flat)
        fits.add(found, (weights > 0).astype(np.float64), sighting.parameters)
        rows.append(sighting.parameters)
        shown.append(weights > 0)
        values.append(found.astype(np.float32))
        facing += weights
    if fits is None:
        raise ParameterError("there are no frames to learn appearance from", "give some")
    frames = Frames(np.stack(values), np.stack(shown), np.stack(rows), recordings)
    ridge = frames.ridge(ridge)
    at = np.asarray(vertices, np.int64)
    return _model(fits.solve(ridge), windows, at, facing, frames, ridge), frames, ridge


def own_share(frames: Frames, ridge: float) -> float:
    """The share for `AppearanceSettings.alone` by which recordings predict others' noise best.

    Parameters
    ----------
    frames : Frames
        Descriptors of the points that are compared, of three recordings and more.
    ridge : float
        Of their fits.
    """
    recordings = np.zeros(len(frames.seen)) if frames.recordings is None else frames.recordings
    missed, gained = frames.left_out(ridge), np.zeros(len(SHARES))
    for name in np.unique(recordings):
        others = frames.recorded(recordings != name)
        off = others.left_out(ridge)
        count = np.maximum(others.seen.sum(axis=0), 1)
        scale = _inverse(np.sqrt((off**2).sum(axis=0) / count[:, None]))
        kept, out = (
            (part * scale).reshape(len(part), -1) for part in (off, missed[recordings == name])
        )
        values, axes = np.linalg.eigh(kept.T @ kept / len(kept))
        along = (out @ axes) ** 2
        for k, share in enumerate(SHARES):
            wide = (1 - share) * np.maximum(values, 0.0) + share
            gained[k] -= 0.5 * float((along / wide + np.log(wide)).sum())
    return SHARES[int(np.argmax(gained))]


def _inverse(spread: FloatArray) -> FloatArray:
    """One over spreads (N, 8), none of which counts as less than a tenth of their median."""
    floor = 0.1 * np.median(spread, axis=0) + 1e-6
    return np.asarray(1 / np.maximum(spread, floor))


def _model(
    fitted: Fitted,
    windows: Windows,
    vertices: IntArray,
    facing: FloatArray,
    frames: Frames,
    ridge: float,
) -> LocalModel:
    """Fits of the points; `facing` is summed over the frames."""
    missed = frames.left_out(ridge)
    count = np.maximum(fitted.frames, 1)
    return LocalModel(
        vertices=vertices,
        base=fitted.base,
        modes=fitted.modes,
        mean=fitted.mean,
        sigma=windows.sigma,
        spread=np.sqrt((missed**2).sum(axis=0) / count[:, None]),
        left_out=missed.astype(np.float32),
        seen=fitted.frames / len(frames.parameters),
        facing=facing / count,
        reach=np.sqrt((frames.parameters**2).mean(axis=0)),
        explained=fitted.explained,
        unit=windows.unit,
    )
