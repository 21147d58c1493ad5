"""New evidence: what is drawn as lips should be redder than what is drawn as skin.

Try it: abs-engine track CLIP -o RUN --plugin examples/new_term.py --terms colour+redness
"""

import numpy as np

from abs_engine import TERMS, Candidates, Face, TermKind, View


class Redness:
    """Minus the log-odds of each pixel to be lips or skin by its red alone."""

    def __init__(self, face: Face, view: View) -> None:
        self._draw = lambda many: view.renderer.draw(face.scene, many, view.camera, view.window)
        patch = view.window.sample(view.image).astype(float)
        red = patch[..., 0] / (patch.sum(axis=-1) + 1)
        self._odds = (red - np.median(red)) / (red.std() + 1e-6) / view.window.scale**2
        self._lips = [k for k, shows in enumerate(face.regions) if shows == "lips"]

    def negative_log(self, candidates: Candidates) -> np.ndarray:
        drawn = [np.isin(b.class_id, self._lips) for b in self._draw(candidates)]
        return np.array([-0.05 * self._odds[lips].sum() for lips in drawn])


TERMS.add("redness", TermKind("redness", Redness, learned=False))
