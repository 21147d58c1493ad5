"""A plugin's evidence tried on a drawing of the average head, before a clip is prepared for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.errors import AbsEngineError, TermError
from abs_engine.core.foreign import own
from abs_engine.core.geometry import FACING, Pose
from abs_engine.core.pose import PoseFrame, at_base
from abs_engine.core.scene import Renderer
from abs_engine.face.head import MouthModel
from abs_engine.face.held_head import held_head
from abs_engine.fit.evidence import Term, check_given, valued
from abs_engine.fit.head_frame import mouth_window
from abs_engine.fit.terms import TermKind, bound
from abs_engine.fit.view import View
from abs_engine.tracking.frame.mouth_place import mouth_place

_DISTANCE = 700.0  # mm, of a head whose mouth is in the middle of the picture
_BEHIND = 90  # level of what lies beside the head


@dataclass(frozen=True, eq=False)
class Trial:
    """A drawing of the average head in which evidence is tried.

    Parameters
    ----------
    model : MouthModel
        Of the average head.
    """

    model: MouthModel
    camera: Camera
    renderer: Renderer

    def check(self, kinds: Mapping[str, TermKind]) -> None:
        """Try the evidence that is not the engine's own and needs nothing that is learned.

        What refuses this picture, or needs something of the clip after all, is not judged.

        Raises
        ------
        TermError
            If evidence fails, is not finite, or lacks what it says that it gives.
        """
        for name, kind in kinds.items():
            if not own(kind.bind) and not kind.learned:
                self._try(name, kind)

    def _try(self, name: str, kind: TermKind) -> None:
        model = self.model
        view, face = self._view(), held_head(model, np.zeros(model.n_person))
        some = view.frame.candidates(at_base(model.prototypes[:2]))
        try:
            term: Term = bound({name: kind}, face, view)[name]
            valued(name, term, some)
            check_given(name, term, kind.gives)
        except TermError:
            raise
        except AbsEngineError:
            return

    def _view(self) -> View:
        model, start = self.model, at_base(self.model.prototypes[0])
        pose = Pose(FACING, np.array([0.0, 0.0, _DISTANCE]) - FACING @ model.pivot)
        base = PoseFrame(pose, model.pivot)
        person = np.zeros(model.n_person)
        window = mouth_window(model, pose, self.camera, person)
        place = mouth_place(model, base, self.camera, window, person, start)
        candidate = base.candidates(start[None])
        drawn = self.renderer.draw(model.held(person), candidate, self.camera, self.camera.whole)[0]
        rgb = np.clip(np.rint(drawn.rgb), 0, 255)
        image = np.where(drawn.covered[..., None], rgb, _BEHIND).astype(np.uint8)
        return View(image, self.camera, self.renderer, base, window, start, place)
