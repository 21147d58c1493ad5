"""The frames of a clip that say most of a head's shape: those in which it faces most differently.

Texture says how deep a head is by how it moves when the head turns, and shape and nodding trade
against each other where it hardly does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.tracking.landmarks import Landmarks


def turned_apart(seen: Sequence[Landmarks], count: int) -> list[int]:
    """Indices of `count` faces, in order, each of which faces farthest from those before it.

    The first is the one that faces most nearly as all do in the median. How a head leans in the
    picture says nothing of its shape and is left out.
    """
    facing = np.array([seen[0].turn_to(one)[:2] for one in seen])
    first = int(np.argmin(np.linalg.norm(facing - np.median(facing, axis=0), axis=1)))
    picked, away = [first], np.full(len(seen), np.inf)
    for _ in range(min(count, len(seen)) - 1):
        away = np.minimum(away, np.linalg.norm(facing - facing[picked[-1]], axis=1))
        away[picked] = -1.0
        picked.append(int(np.argmax(away)))
    return sorted(picked)
