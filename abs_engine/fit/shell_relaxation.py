"""Relaxing the modal constraint: the full-rank shell settles on a frame (Basu et al., 6.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Scene
from abs_engine.face.shape.fem import ThinShell
from abs_engine.face.shape.lip_model import LipModel

FloatArray = NDArray[np.float64]
STEPS = 12
_SHORTEST = 0.05


@dataclass(frozen=True, eq=False)
class Settled:
    """A shape that has left the modes.

    Parameters
    ----------
    nodes : (N, 3) float64, mm, head frame
    moved : (N, 3) float64, mm
        From the modal shape.
    before, after : float
        -log posterior with the shell's strain as the prior of what was moved.
    """

    nodes: FloatArray
    moved: FloatArray
    before: float
    after: float


def softness(elastic: ThinShell, typical: float) -> float:
    """T of the prior N(0, T K^-1) under which nodes move by `typical` mm RMS, mm N."""
    rows = elastic.compliance_rows(np.arange(3 * len(elastic.vertices)))
    return float(typical**2 / (np.trace(rows) / len(elastic.vertices)))


def settle(
    model: LipModel,
    colours: FacetLikelihood,
    weights: FloatArray,
    pose: Pose,
    elastic: ThinShell,
    temperature: float,
) -> Settled:
    """Let every node go where the forces and the shell's elasticity balance.

    Parameters
    ----------
    model : LipModel
    colours : FacetLikelihood
        Of the frame, over the model's scene; with a pull.
    weights : (P,) float64
        The modal fit.
    pose : Pose
        Of the head, held.
    elastic : ThinShell
        The shell with its first, unlearned stiffness K.
    temperature : float
        T: how far the shell may strain, see `softness`.

    Returns
    -------
    Settled

    Notes
    -----
    The displacement u from the modal shape has the prior N(0, T K^-1), so the balance is
    K u = T F with F the gradient of log f(O|p): each step moves u towards T K^-1 F(u), as far as
    the posterior rises.
    """
    scene = colours.scene
    start, count = scene.vertices(weights), len(model.shell)
    bare, candidate = _bare(scene, start), Candidates.one(np.zeros(0), pose)

    def value(u: FloatArray) -> tuple[float, FacetLikelihood]:
        at = replace(bare, mean=(start + model.surrounded(u)).astype(np.float32))
        there = replace(colours, scene=at)
        data = float(there.negative_log(candidate)[0])
        return data + elastic.energy(u) / temperature, there

    u, step = np.zeros((count, 3)), 1.0
    before, there = value(u)
    best = before
    for _ in range(STEPS):
        head = model.gathered(there.forces(candidate) @ pose.rotation)
        goal = elastic.displacement(temperature * head)
        while step >= _SHORTEST:
            tried = u + step * (goal - u)
            found = value(tried)
            if found[0] < best:
                break
            step *= 0.5
        else:
            break
        u, (best, there) = tried, found
        step = min(1.0, 1.5 * step)
    return Settled(start[:count] + u, u, before, best)


def _bare(scene: Scene, vertices: FloatArray) -> Scene:
    """The scene with vertices (V, 3), mm, and no modes."""
    none = np.zeros((0, *vertices.shape), np.float32)
    return replace(scene, mean=vertices.astype(np.float32), modes=none)
