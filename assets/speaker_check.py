"""Check the finished head and say what it measures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import speaker_mesh as sm
from scipy.spatial import cKDTree

MAX_FACES, MAX_BYTES = 16_000, 5_000_000
SOLIDS = (sm.UPPER_TEETH, sm.LOWER_TEETH, sm.TONGUE, sm.EYES)


class SpeakerError(RuntimeError):
    """The head that was made is not fit to be shipped."""


def areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the area of each facet, mm^2."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0


def directed_edges(faces: np.ndarray, weld: np.ndarray) -> np.ndarray:
    """Return the (3 F, 2) directed edges over welded vertices."""
    corners = weld[faces]
    return np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])


def repeated_edges(faces: np.ndarray, weld: np.ndarray) -> int:
    """Count directed edges that two facets share: zero when the orientation is consistent."""
    edges = directed_edges(faces, weld)
    return len(edges) - len(np.unique(edges, axis=0))


def facing_out(vertices: np.ndarray, faces: np.ndarray, kind: np.ndarray) -> dict[str, bool]:
    """Tell, for each solid part, whether most of its front faces forward (positive volume)."""
    result = {}
    for part in SOLIDS:
        a, b, c = vertices[faces[kind == part]].transpose(1, 0, 2)
        middle = np.concatenate([a, b, c]).mean(0)
        volume = np.einsum("fi,fi->", np.cross(a - middle, b - middle), c - middle)
        result[sm.CLASS_NAMES[part]] = bool(volume > 0)
    return result


def mirror_error(vertices: np.ndarray) -> tuple[float, float]:
    """Return the mean and the largest distance (mm) from a mirrored vertex to the nearest one."""
    distance = cKDTree(vertices).query(vertices * [-1, 1, 1])[0]
    return float(distance.mean()), float(distance.max())


def closure(arrays: dict[str, np.ndarray], vertices: np.ndarray) -> tuple[float, float]:
    """Return the smallest and largest height (mm) between the inner lips, off the corners."""
    upper, lower = vertices[arrays["inner_lip_upper"]], vertices[arrays["inner_lip_lower"]]
    order = lower[:, 0].argsort()
    gap = upper[:, 1] - np.interp(upper[:, 0], lower[order, 0], lower[order, 1])
    return float(gap[2:-2].min()), float(gap[2:-2].max())


def check_speaker(arrays: dict[str, np.ndarray], folder: Path) -> str:
    """Return a report on the head.

    Raises
    ------
    SpeakerError
        When a facet is degenerate, the orientation is not consistent, a part is inside out, the
        chart leaves the texture, or the files are too large.
    """
    vertices, faces = arrays["vertices"].astype(float), arrays["faces"]
    weld, kind = arrays["weld"], arrays["facet_class"]
    smallest, repeated = areas(vertices, faces).min(), repeated_edges(faces, weld)
    solid = facing_out(vertices, faces, kind)
    sizes = {p.name: p.stat().st_size for p in sorted(folder.iterdir())}
    good = {
        "a facet is degenerate": smallest > 1e-6,
        "orientation is not consistent": repeated == 0,
        "a part is inside out": all(solid.values()),
        "too many facets": len(faces) <= MAX_FACES,
        "the files are too large": sum(sizes.values()) <= MAX_BYTES,
        "the chart leaves the texture": arrays["uv"].min() >= 0 and arrays["uv"].max() <= 1,
    }
    failed = [text for text, fine in good.items() if not fine]
    if failed:
        raise SpeakerError("; ".join(failed))
    mean, largest = mirror_error(vertices)
    low, high = closure(arrays, vertices)
    counts = np.bincount(kind, minlength=len(sm.CLASS_NAMES))
    lines = [
        f"V {len(vertices)} (welded {weld.max() + 1}), F {len(faces)}",
        "classes " + ", ".join(f"{n} {c}" for n, c in zip(sm.CLASS_NAMES, counts, strict=True)),
        ", ".join(f"{key} {len(arrays[key])}" for key in ("units", "identity", "people")),
        f"smallest facet {smallest:.2e} mm^2, repeated directed edges {repeated}",
        f"mirror error mean {mean:.4f} mm, largest {largest:.3f} mm",
        f"inner lips at rest: height between {low:.2f} and {high:.2f} mm",
        f"bytes {sizes}, total {sum(sizes.values())}",
    ]
    return "\n".join(lines) + "\n"
