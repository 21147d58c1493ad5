"""How the set is lit and dressed."""

from __future__ import annotations

from dataclasses import dataclass, field

from abs_engine.synth.optics import Sensor


@dataclass(frozen=True)
class Light:
    """A distant lamp.

    Parameters
    ----------
    direction : tuple of float
        In which its light travels, camera frame (x right, y down, z forward); any length.
    intensity : float
    colour : tuple of float
        Linear RGB.
    """

    direction: tuple[float, float, float]
    intensity: float
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Look:
    """How the set is lit and dressed, and what films it.

    Parameters
    ----------
    lights : tuple of Light
        By default a warm key from the upper left of the picture and a cool, weaker fill.
    ambient : float
        Share of the albedo that is seen everywhere.
    roughness : float
        Of the skin, 0 to 1.
    top, bottom : tuple of float
        Colours of the background, 0 to 255.
    shirt : tuple of float, optional
        Linear RGB of the shirt; None films the head alone.
    sensor : Sensor
    """

    lights: tuple[Light, ...] = (
        Light((0.55, 0.55, 1.0), 3.3, (1.0, 0.96, 0.90)),
        Light((-0.90, 0.10, 0.75), 1.0, (0.88, 0.94, 1.0)),
    )
    ambient: float = 0.12
    roughness: float = 0.55
    top: tuple[float, float, float] = (118.0, 128.0, 134.0)
    bottom: tuple[float, float, float] = (74.0, 82.0, 90.0)
    shirt: tuple[float, float, float] | None = (0.06, 0.09, 0.15)
    sensor: Sensor = field(default_factory=Sensor)
