"""The lips' surface beyond the shell's three rings: where it ends inside of the mouth.

The shell begins at the inner contour, where closed lips meet. A mouth that opens shows more of
them: the lip turns inwards at that contour, and its facets end on the other side of it. That is
behind it on the average head (0.4 mm at the middle of the upper lip, 1 to 3 mm elsewhere), but not
everywhere on everybody: at the middle of the upper lip it is up to 0.6 mm before it on three of the
six bundled people, where the lip only turns up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import MeshError
from abs_engine.core.geometry import edges_of
from abs_engine.io.assets import Speaker


def lip_edge(speaker: Speaker, lip: str) -> FloatArray:
    """Edge (K, 3), mm, of a lip inside of the mouth, on the average head.

    From the right corner of the mouth to the left one; `lip` is "upper_lip" or "lower_lip". Raises
    `MeshError` if the lip ends nowhere but at skin and the other lip, or only in closed rings.
    """
    edges, count = _edges(speaker, lip)
    other = "lower_lip" if lip == "upper_lip" else "upper_lip"
    shared = {(a, b) for name in ("skin", other) for a, b in _edges(speaker, name)[0].tolist()}
    ends = [(a, b) for a, b in edges[count == 1].tolist() if (a, b) not in shared]
    at = speaker.vertices.astype(np.float64)
    path = _longest(ends, at)
    if not path:
        raise MeshError(
            f"the facets of class {lip} end in no line inside of the mouth",
            "take a head whose mouth is open behind the lips",
        )
    return at[path if at[path[0], 0] < at[path[-1], 0] else path[::-1]]


def _edges(speaker: Speaker, name: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges of a class's facets, and how many of these each is an edge of."""
    return edges_of(speaker.faces[speaker.facets_of(name)])


def _longest(edges: list[tuple[int, int]], at: FloatArray) -> list[int]:
    """The longest of the open lines that edges join up to, as vertices in order; [] if none is."""
    joined: dict[int, list[int]] = {}
    for a, b in edges:
        joined.setdefault(a, []).append(b)
        joined.setdefault(b, []).append(a)
    lines, left = [], set(joined)
    for end in [k for k, to in joined.items() if len(to) == 1]:
        if end not in left:
            continue
        line = [end]
        while True:
            left.discard(line[-1])
            onward = [k for k in joined[line[-1]] if k in left]
            if not onward:
                break
            line.append(onward[0])
        lines.append(line)
    return max(lines, key=lambda line: float(np.ptp(at[line, 0])), default=[])
