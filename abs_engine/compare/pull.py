"""Forces on the nodes of a drawn surface: widely smoothed maps (Basu et al., eqs. 11, 12)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from abs_engine.compare.forces import border_forces, facet_forces, lifted, node_forces, slopes
from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates, Renderer, Scene

PullRule = Literal["whole", "exact", "sample"]
PULL_RULES: tuple[PullRule, ...] = get_args(PullRule)
"""How forces are found: eq. 12's one sample for a facet; eq. 11 exactly; or the whole derivative of
the score, in which facets grow, too.
"""


def pull_rule(name: str) -> PullRule:
    """The rule of this name; `ParameterError` if there is none."""
    for rule in PULL_RULES:
        if rule == name:
            return rule
    raise ParameterError(f"there is no rule '{name}'", f"choose one of {', '.join(PULL_RULES)}")


@dataclass(frozen=True, eq=False)
class Pull:
    """Widely smoothed maps that pull on the facets.

    Parameters
    ----------
    maps : (C, H, W) float64
        What a pixel gives to a facet of each class; 0 where pixels are not compared.
    slopes : (C, 2, H, W) float64
        Their gradients. Taken before the maps are cut off, or the window's edge would pull.
    rule : str
        One of `PULL_RULES`.
    """

    maps: FloatArray
    slopes: FloatArray
    rule: PullRule = "whole"

    @classmethod
    def within(cls, maps: FloatArray, inside: BoolArray, rule: PullRule = "whole") -> Pull:
        """The pull of maps (C, H, W) of which only some pixels (H, W) are compared."""
        return cls(maps * inside, slopes(maps) * inside, rule)

    def forces(
        self,
        renderer: Renderer,
        scene: Scene,
        candidate: Candidates,
        camera: Camera,
        window: Window,
    ) -> FloatArray:
        """Forces (V, 3), camera frame, on one candidate's vertices."""
        drawn = renderer.draw(scene, candidate, camera, window)[0]
        points = scene.vertices(candidate.weights[0]) @ candidate.rotations[0].T
        points = points + candidate.translations[0]
        if self.rule == "whole":
            flat = border_forces(drawn, self.maps, scene.faces, len(points))
        else:
            flat = facet_forces(drawn, self.slopes, scene.facet_class, self.rule)
            flat = node_forces(flat, scene.faces, len(points))
        return lifted(flat, points, camera, window.scale)
