"""A report's video, and the pictures of each system's worst frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.dataset import Truth
from abs_engine.report import film
from abs_engine.report.data import Film, System, TrueClip, WorstFrame
from abs_engine.report.drawing.colours import TRUTH_ON_PICTURES, picture_colour
from abs_engine.report.quantities import PRIMARY

WORST = 8
_APART_SECONDS = 0.12


def filmed(
    pictures: Iterable[Image], truth: Truth, systems: Sequence[System], true: TrueClip, played: int
) -> tuple[Film, list[System]]:
    """The film, and the systems with pictures of their worst frames."""
    apart = max(1, round(_APART_SECONDS * truth.rate))
    worst = [
        film.worst_frames(_primary(system)[0], WORST, apart) if system.errors else []
        for system in systems
    ]
    wanted = set(chain.from_iterable(worst))
    shown, kept = film.shorten(pictures, truth.rate, played, wanted)
    drawn = []
    for number, (system, frames) in enumerate(zip(systems, worst, strict=True)):
        colour = picture_colour(number)
        drawn.append(
            replace(
                system, worst=tuple(_worst(system, colour, k, kept[k], truth, true) for k in frames)
            )
        )
    return shown, drawn


def _worst(
    system: System, colour: str, frame: int, picture: Image, truth: Truth, true: TrueClip
) -> WorstFrame:
    values, unit = _primary(system)
    loops = [(loop[frame], TRUTH_ON_PICTURES) for loop in true.contours.values()]
    loops += [(loop[frame], colour) for loop in system.contours.values()]
    said = f", /{truth.phonemes[frame]}/" if truth.phonemes else ""
    text = f"frame {frame}, {frame / truth.rate:.2f} s{said}: {values[frame]:.2f} {unit}"
    return WorstFrame(
        frame, film.mouth_picture(picture, loops, true.contours["outer"][frame]), text
    )


def _primary(system: System) -> tuple[FloatArray, str]:
    """The errors by which frames are the worst, and their unit."""
    quantity = next((q for q in PRIMARY if q.key in system.errors), None)
    if quantity is None:
        return np.zeros(0), ""
    return system.errors[quantity.key].values, quantity.unit
