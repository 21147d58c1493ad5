"""Requests for inspection pictures, and the choices that go with each kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from abs_engine.core.errors import ParameterError

_BODY = ("person", "units", "speaker", "size")
_LOOK = (*_BODY, "palette", "crop")
_TRUTH = ("truth", "clip", "camera")
_LABEL = (*_BODY, "turn", "crop", "views", "run", *_TRUTH, "frame")

CHOICES: dict[str, tuple[str, ...]] = {
    "portrait": (*_LOOK, "turn", "views"),
    "postures": (*_LOOK, "turn", "rows", "weight"),
    "nomogram": (*_LOOK, "turn", "rows", "modes", "columns", "run"),
    "turntable": (*_LOOK, "views"),
    "overlay": ("run", "speaker", "video", *_TRUTH, "style", "palette", "frame"),
    "ids": _LABEL,
    "classes": _LABEL,
    "depth": (*_LABEL, "limits"),
    "normals": _LABEL,
    "albedo": (*_TRUTH, "speaker", "frame"),
    "flow": (*_TRUTH, "speaker", "frame", "largest"),
    "error": (*_BODY, "values", "run", *_TRUTH, "frame", "largest", "views"),
}
"""Which choices each kind of picture takes, besides file and renderer."""

OF_POSTURES = ("person", "units")
OF_VIEWS = ("turn", "crop", "views", "size")
LABEL_KINDS = ("ids", "classes", "depth", "normals", "albedo", "flow")
"""What choices of the head's posture, and of the view of its labels, are without effect on runs."""

LARGEST = 4096
"""Pixels a side of one picture; multisampled, it takes a gigabyte."""

FLAGS = {"run": "RUN", "units": "--unit", "largest": "--max", "limits": "--range"}
"""How choices are typed whose option has another name."""


@dataclass(frozen=True)
class Request:
    """An inspection picture or film.

    Parameters
    ----------
    kind : str
        A key of `CHOICES`.
    output : Path
        A new ``.png`` or ``.mp4``.
    clip, camera : str, optional
        Names that the truth's path leaves open.
    person : str, optional
        By default the speaker's first.
    units : mapping of str to float
        Posture, weights of face units by name.
    crop : {"head", "mouth"}, optional
        By default the mouth for modes, else the head.
    size : tuple of int, optional
        Width and height of one picture, pixels.
    turn : float
        Degrees to the head's left.
    rows : tuple of str
        Face units that are shown; all where it is empty.
    weight : float
        Of the face unit in a posture.
    modes : int, optional
        Show so many modes of the mouth's shape model instead.
    largest : float, optional
        End of a colour scale.

    Raises
    ------
    ParameterError
        If something was chosen that the kind does not take, or that would be without effect
        beside the rest, or a number is not finite.
    """

    kind: str
    output: Path
    run: Path | None = None
    truth: Path | None = None
    clip: str | None = None
    camera: str | None = None
    video: Path | None = None
    values: Path | None = None
    speaker: Path | None = None
    person: str | None = None
    units: Mapping[str, float] = field(default_factory=dict)
    palette: str | None = None
    crop: str | None = None
    size: tuple[int, int] | None = None
    turn: float = 0.0
    rows: tuple[str, ...] = ()
    weight: float = 1.0
    modes: int | None = None
    columns: int | None = None
    views: int | None = None
    style: str = "wireframe"
    frame: int | None = None
    largest: float | None = None
    limits: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        defaults = Request.__dataclass_fields__
        for name in defaults:
            if name in ("kind", "output", "units"):
                continue
            if getattr(self, name) != defaults[name].default and name not in CHOICES[self.kind]:
                self._refuse(name)
        if self.units and "units" not in CHOICES[self.kind]:
            self._refuse("units")
        self._check_head()
        self._check_effects()
        if self.truth is None and (self.clip is not None or self.camera is not None):
            raise ParameterError("without a dataset there is no clip or camera", "give --truth")
        if not np.isfinite([self.turn, self.weight]).all():
            raise ParameterError("an angle or a weight is NaN or infinite", "give a number")
        if self.size is not None and not (16 <= min(self.size) <= max(self.size) <= LARGEST):
            raise ParameterError(
                "a picture of {}x{} pixels cannot be drawn".format(*self.size),
                f"give 16 to {LARGEST} pixels a side",
            )

    @property
    def shown(self) -> str:
        """Part that is shown: head or mouth."""
        of_modes = self.kind == "nomogram" and (self.modes is not None or self.run is not None)
        return self.crop or ("mouth" if of_modes else "head")

    def _check_head(self) -> None:
        """Refuse choices of a head or a view where a run or a dataset decides them."""
        if self.run is None and self.truth is None:
            return
        decided = (*OF_POSTURES, *(OF_VIEWS if self.kind in LABEL_KINDS else ()))
        for name in decided:
            default = {} if name == "units" else Request.__dataclass_fields__[name].default
            if getattr(self, name) != default:
                flag, by = FLAGS.get(name, f"--{name}"), "RUN" if self.run else "--truth"
                raise ParameterError(f"{flag} does not go with {by}", "leave one of them out")

    def _check_effects(self) -> None:
        """Refuse choices that another one, or a film, leaves without effect."""
        film = self.output.suffix.lower() == ".mp4"
        if self.kind in ("portrait", *LABEL_KINDS) and self.turn and (self.views or film):
            raise ParameterError(
                f"--turn does not go with {'--views' if self.views else 'an MP4'}, "
                "which shows the head from all sides",
                "leave one of them out",
            )
        if self.palette is not None and self.kind == "overlay" and self.style != "blend":
            raise ParameterError(f"a {self.style} has no --palette", "give --style blend with it")
        if self.columns is not None and film:
            raise ParameterError("a film has no --columns", "let the file's name end in .png")

    def _refuse(self, name: str) -> None:
        flag = FLAGS.get(name, f"--{name}")
        takers = ", ".join(kind for kind, names in CHOICES.items() if name in names)
        raise ParameterError(f"'{self.kind}' takes no {flag}", f"it goes with {takers}")
