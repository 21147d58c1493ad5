"""The look of the set: its light and its dressing."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.studio.appearance.optics import Background, Sensor

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class LightKey:
    """State of a lamp at a moment; what is left out stays as the lamp has it.

    Parameters
    ----------
    time : float
        Seconds.
    """

    time: float
    intensity: float | None = None
    direction: Colour | None = None
    colour: Colour | None = None


@dataclass(frozen=True)
class Light:
    """``[[light]]``: a distant lamp.

    Parameters
    ----------
    name : str
    direction : tuple of float
        In which its light travels, world frame (the head's at rest: x to the subject's left, y
        up, z out of the face); any length.
    intensity : float
        By which the colour is multiplied.
    colour : tuple of float
        Linear RGB.
    keys : tuple of LightKey
        How it changes; between them it changes linearly.
    """

    name: str
    direction: Colour
    intensity: float = 3.0
    colour: Colour = (1.0, 1.0, 1.0)
    keys: tuple[LightKey, ...] = ()

    def check(self, times: NDArray[np.float64]) -> None:
        """Raise `ParameterError` for negative light, keys out of order, or no direction at a time.

        Between keys of opposite directions there is a moment without any.
        """
        rows = np.array([self._row(key) for key in (LightKey(0.0), *self.keys)])
        if rows[:, 3:].min() < 0:
            raise ParameterError(
                f"light '{self.name}' has a negative intensity or colour", "give 0 or more"
            )
        if any(after.time <= before.time for before, after in pairwise(self.keys)):
            raise ParameterError(
                f"the keys of light '{self.name}' are not in order of time", "sort them"
            )
        dark = np.flatnonzero(~self.at(times)[:, :3].any(axis=1))
        if len(dark):
            raise ParameterError(
                f"light '{self.name}' has no direction at {times[dark[0]]:g} s",
                "give the direction in which its light travels; between opposite ones, a third",
            )

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Direction, intensity and RGB at `times` (T,), as (T, 7), world frame."""
        still = np.array([*self.direction, self.intensity, *self.colour], np.float64)
        if not self.keys:
            return np.tile(still, (len(times), 1))
        rows = np.array([self._row(key) for key in self.keys])
        knots = [key.time for key in self.keys]
        return np.column_stack([np.interp(times, knots, column) for column in rows.T])

    def _row(self, key: LightKey) -> list[float]:
        intensity = self.intensity if key.intensity is None else key.intensity
        return [*(key.direction or self.direction), intensity, *(key.colour or self.colour)]


KEY = Light("key", (0.55, -0.55, -1.0), 3.3, (1.0, 0.96, 0.90))
FILL = Light("fill", (-0.90, -0.10, -0.75), 1.0, (0.88, 0.94, 1.0))


@dataclass(frozen=True)
class Look:
    """Light and dress of the set, and its camera.

    Parameters
    ----------
    lights : tuple of Light
        By default a warm key from the upper left of the picture and a cool, weaker fill.
    ambient : float
        Share of the albedo that is seen everywhere.
    roughness : float
        Of the skin, 0 to 1.
    shirt : tuple of float, optional
        Linear RGB of the shirt; None films the head alone.
    """

    lights: tuple[Light, ...] = (KEY, FILL)
    ambient: float = 0.12
    roughness: float = 0.55
    background: Background = field(default_factory=Background)
    shirt: Colour | None = (0.06, 0.09, 0.15)
    sensor: Sensor = field(default_factory=Sensor)
