"""Visemes made of two known movements, for models that should find them again."""

from __future__ import annotations

import numpy as np

NAMES = tuple(f"p{k}" for k in range(12))
GROUPS = {"jaw": NAMES[:4], "lips": NAMES[4:8], "rest": NAMES[8:]}


def directions() -> np.ndarray:
    """Two movements (2, 12, 3): the jaw's takes the lips along, that of the lips leaves the jaw."""
    jaw, lips = np.zeros((2, 12, 3))
    jaw[:4, 1], jaw[4:8, 1], jaw[8:, 2] = -3.0, -1.5, 0.5
    lips[4:8, 2], lips[8:, 0] = 2.0, 0.25
    return np.stack([jaw, lips])


def visemes(count: int = 40, noise: float = 0.0, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Parameters (V, 2), uncorrelated and of unit variance, and the points (V, 12, 3)."""
    rng = np.random.default_rng(seed)
    raw = rng.normal(size=(count, 2))
    alpha = np.linalg.qr(raw - raw.mean(axis=0))[0] * np.sqrt(count - 1)
    mean = rng.normal(size=(12, 3)) * 20
    points = mean + np.tensordot(alpha, directions(), 1)
    return alpha, points + noise * rng.normal(size=points.shape)
