"""Figure 7: trees of phonemes by the faces with which they are said."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.cluster.hierarchy import dendrogram, fcluster
from scipy.spatial.distance import cdist

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.studio.speech import Segment

Faces = Mapping[str, FloatArray]
"""Points (K, N, 3), mm, of the K faces with which each phoneme was said."""

VOWELS, CONSONANTS = "vowels", "consonants"
_LEAST = 2
"""Groups, of which a tree is made."""


@dataclass(frozen=True, eq=False)
class Tree:
    """A hierarchy of phonemes.

    Parameters
    ----------
    names : tuple of str, n
    links : (n - 1, 4) float64
        As `scipy.cluster.hierarchy.linkage` has them: the two groups that are joined (those from
        n on are made by the rows before), their distance in mm, and the size of the new one.
    """

    names: tuple[str, ...]
    links: FloatArray

    def groups(self, count: int) -> tuple[tuple[str, ...], ...]:
        """The tree cut into at most `count` groups, the largest first."""
        label = fcluster(self.links, count, "maxclust")
        found = [
            tuple(n for n, own in zip(self.names, label, strict=True) if own == k)
            for k in np.unique(label)
        ]
        return tuple(sorted(found, key=lambda group: (-len(group), group)))


def hausdorff(distances: FloatArray) -> float:
    """The median-modified Hausdorff distance of two sets.

    max(h(A, B), h(B, A)) with h(A, B) the median over a in A of the distance from a to the nearest
    member of B. Dubuisson and Jain, "A modified Hausdorff distance for object matching", ICPR
    1994, have the mean there, and Hausdorff's own the maximum; the median is the half-ranked one
    of Huttenlocher, Klanderman and Rucklidge, "Comparing images using the Hausdorff distance",
    IEEE PAMI 15(9), 1993.

    Parameters
    ----------
    distances : (A, B) float64
        Of each member of one set from each of the other.
    """
    there, back = distances.min(axis=1), distances.min(axis=0)
    return float(max(np.median(there), np.median(back)))


def phoneme_tree(faces: Faces) -> Tree:
    """Join, again and again, the two nearest groups of phonemes.

    A group holds all faces of its phonemes; two groups are as far apart as `hausdorff` says of
    the root mean square distances of their points. A join that is nearer than one inside of it,
    which this distance allows, is drawn at that one's height.

    Parameters
    ----------
    faces : mapping of str to (K, N, 3) float64, mm

    Raises
    ------
    ParameterError
        If there are fewer than two phonemes, or one has no face.
    """
    names = tuple(faces)
    if len(names) < _LEAST or not all(len(f) for f in faces.values()):
        raise ParameterError(
            f"there are faces of {sum(len(f) > 0 for f in faces.values())} phonemes",
            "track sentences with more phonemes",
        )
    rows = np.concatenate([np.asarray(f, np.float64) for f in faces.values()])
    flat = rows.reshape(len(rows), -1)
    away = cdist(flat, flat) / np.sqrt(rows.shape[1])
    ends = np.cumsum([len(f) for f in faces.values()])
    members = {k: np.arange(end - len(faces[n]), end) for k, (n, end) in
               enumerate(zip(names, ends, strict=True))}  # fmt: skip
    return Tree(names, _joined(members, away))


def _joined(members: dict[int, IntArray], away: FloatArray) -> FloatArray:
    count = len(members)
    height, size = dict.fromkeys(members, 0.0), dict.fromkeys(members, 1)
    apart = {
        (a, b): hausdorff(away[np.ix_(members[a], members[b])])
        for a in members for b in members if a < b
    }  # fmt: skip
    links = np.empty((count - 1, 4))
    for step in range(count - 1):
        (a, b), new = min(apart, key=lambda pair: (apart[pair], pair)), count + step
        height[new] = max(apart[a, b], height[a], height[b])
        size[new] = size[a] + size[b]
        links[step] = a, b, height[new], size[new]
        members[new] = np.concatenate([members.pop(a), members.pop(b)])
        apart = {pair: d for pair, d in apart.items() if not {a, b} & set(pair)}
        apart |= {
            (k, new): hausdorff(away[np.ix_(members[k], members[new])])
            for k in members if k != new
        }  # fmt: skip
    return links


def faces_at_centres(
    said: Iterable[tuple[Sequence[Segment], float, FloatArray]],
) -> dict[str, dict[str, FloatArray]]:
    """The faces in the middle of each phoneme, vowels and consonants apart.

    Parameters
    ----------
    said : iterable of (segments, rate, (T, N, 3) float64)
        Sentences: what is said when, frames per second, and the points of each frame, mm.

    Returns
    -------
    dict of str to dict of str to (K, N, 3) float64
        By `VOWELS` and `CONSONANTS`, then by phoneme, IPA.
    """
    found: dict[str, dict[str, list[FloatArray]]] = {VOWELS: {}, CONSONANTS: {}}
    for segments, rate, points in said:
        for segment in segments:
            if segment.phoneme.manner == "pause":
                continue
            kind = VOWELS if segment.phoneme.is_vowel else CONSONANTS
            frame = min(round(segment.middle * rate), len(points) - 1)
            found[kind].setdefault(segment.phoneme.label, []).append(points[frame])
    return {
        kind: {name: np.array(own[name]) for name in sorted(own)} for kind, own in found.items()
    }


def trees_figure(trees: Mapping[str, Tree]) -> Figure:
    """Figure 7: trees side by side, each with its own scale, mm."""
    widths = [len(tree.names) for tree in trees.values()]
    figure = Figure(figsize=(0.28 * sum(widths) + 1.5, 3.2), layout="constrained")
    row = figure.subplots(1, len(trees), width_ratios=widths, squeeze=False)[0]
    for axes, (kind, tree) in zip(row, trees.items(), strict=True):
        _draw(axes, tree)
        axes.set_title(kind, fontsize=9)
    row[0].set_ylabel("distance of groups (mm)")
    return figure


def _draw(axes: Axes, tree: Tree) -> None:
    plan = dendrogram(tree.links, labels=list(tree.names), no_plot=True)
    for across, up in zip(plan["icoord"], plan["dcoord"], strict=True):
        axes.plot(across, up, color="0.2", lw=1)
    leaves = plan["ivl"]
    axes.set_xticks([5 + 10 * k for k in range(len(leaves))], leaves)
    axes.set(xlim=(0, 10 * len(leaves)), ylim=(0, None))
    for side in ("top", "right", "bottom"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="x", length=0)
