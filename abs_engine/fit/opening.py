"""Evidence of a mouth's opening: what is drawn above, within, below and beside the inner lips.

The facet likelihood, whose classes come from local appearance instead of colour. Its borders are
the outlines of the inner lips; closed lips are the border between what is above and below.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.camera import Camera, Window
from abs_engine.core.scene import ClassMaps, Renderer, Scene
from abs_engine.face.appearance.opening import SIDES, MouthSpot, OpeningLooks
from abs_engine.face.base import Face
from abs_engine.face.head import IN_OPEN_MOUTH, MouthModel
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.fit.evidence import Term
from abs_engine.fit.head_frame import likelihood_of, zone
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.fit.terms import TermKind
from abs_engine.fit.view import View

NAME = "opening"


@dataclass(frozen=True, eq=False)
class Opening:
    """Appearance of one clip's mouth: what was learned, and where in the picture it counts."""

    looks: OpeningLooks
    spot: MouthSpot

    def maps(
        self, regions: Sequence[str | None], window: Window, image: NDArray[np.uint8]
    ) -> ClassMaps:
        """Probability maps of every facet class in the window of a frame, 0 outside its zone."""
        found = self.spot.in_window(self.looks.probabilities(image, self.spot), window)
        shown = dict(zip(SIDES, found * zone(window), strict=True))
        zero = np.zeros_like(found[0])
        return ClassMaps(np.stack([zero if r is None else shown[r] for r in regions]))

    def likelihood(
        self,
        renderer: Renderer,
        scene: Scene,
        camera: Camera,
        window: Window,
        maps: ClassMaps,
        regions: Sequence[str | None],
    ) -> FacetLikelihood:
        """Likelihood of a drawn mouth by a frame's maps."""
        names = list(regions)
        seam = (names.index("above"), names.index("below")), names.index("inside")
        return likelihood_of(renderer, scene, camera, window, maps, HEAD_FIT.opening_weight, seam)


def opening_term(face: Face, view: View) -> Term:
    """The facet likelihood of the sides of a mouth's opening."""
    opening: Opening = face.learned(NAME)
    maps = opening.maps(face.regions, view.window, view.image)
    return opening.likelihood(
        view.renderer, face.scene, view.camera, view.window, maps, face.regions
    )


OPENING = TermKind(
    NAME,
    opening_term,
    ("values", "borders"),
    noun="close-up of a mouth",
    remedy="use --worn if the video is one",
)


def sided(model: MouthModel) -> tuple[MouthModel, tuple[str | None, ...]]:
    """The model with skin that is as the lip it lies beside, and what its classes show.

    Skin above the line of the corners is of the upper lip's class, skin below it of the lower
    lip's; what lies left or right of the corners, near that line, stays skin.
    """
    names, scene = model.speaker.class_names, model.scene
    corners = scene.mean[model.rings["corners"]].astype(np.float64)
    centre = scene.mean[scene.faces].astype(np.float64).mean(axis=1)
    middle, half = corners.mean(axis=0), 0.5 * float(np.ptp(corners[:, 0]))
    skin = scene.facet_class == names.index("skin")
    beyond = np.abs(centre[:, 0] - middle[0]) > half
    beside = beyond & (np.abs(centre[:, 1] - middle[1]) < 2 * APPEARANCE.beside * half)
    within = skin & ~beside
    above = centre[:, 1] > middle[1]
    classes = scene.facet_class.copy()
    classes[within & above] = names.index("upper_lip")
    classes[within & ~above] = names.index("lower_lip")
    shows = {"skin": "beside", "upper_lip": "above", "lower_lip": "below"}
    shows |= dict.fromkeys(IN_OPEN_MOUTH, "inside")
    regions = tuple(shows.get(name) for name in names)
    return replace(model, scene=replace(scene, facet_class=classes)), regions
