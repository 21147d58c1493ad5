"""Colour classes of a clip: skin, lips, and what shows between parted lips."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ModelFormatError
from abs_engine.face.appearance.colour_features import CLASSES, EACH_LIP
from abs_engine.face.appearance.colour_maps import Palette
from abs_engine.face.appearance.exposure import Exposure
from abs_engine.face.appearance.mixture import Mixture
from abs_engine.face.settings.colour import COLOURS
from abs_engine.io.arrays import Layout, real, truth, whole
from abs_engine.io.npz import read_npz

FORMAT, VERSION = "abs_engine.colours", 2  # 1: not learned from `chroma.matched` pixels
_PARTS: Layout = {
    "weights": real("K", low=0.0),
    "means": real("K", 3),
    "covariances": real("K", 3, 3),
}
LAYOUT: Layout = {
    "priors": real(len(CLASSES), low=0.0), "reference": real(low=0.0, high=255.0),
    "agreement": real(optional=True), "chromatic": truth(optional=True),
    "mixed": whole(optional=True, low=0),
    "saturated": real(optional=True), "luminance": real(optional=True),
    **{f"{name}_separability": real(optional=True) for name in EACH_LIP},
    **{
        f"{name}_{part}": replace(
            kind, shape=(f"{name} components", *kind.shape[1:]), optional=name in EACH_LIP
        )
        for name in (*CLASSES, *EACH_LIP)
        for part, kind in _PARTS.items()
    },
}  # fmt: skip
"""Their arrays in a file."""


@dataclass(frozen=True, eq=False)
class ColourClasses(Palette):
    """Densities of skin, lips, teeth and the dark of the mouth in colour space.

    Of a video they are learned from, and applied to, pixels as `chroma.matched` gives them.

    Parameters
    ----------
    mixtures : mapping of class name to Mixture
        One of each of `CLASSES`.
    priors : (4,) float64
        Prior weight of each class; from a clip, 1 for skin and for lips, while teeth and dark
        share 1.
    reference : float
        Luminance of the skin, 0 to 255.
    chromatic : bool
        Whether the clip is in colour: without it the classes differ in brightness alone.
    mixed : int
        How many of the skin's components, the last ones, are colours in which it mixes with lips; 0
        in files written before this was kept, even where the skin has some.
    separability : mapping of str to float
        How probably a pixel of skin or of a lip is told right by its colour, 0.5 to 1, for each
        of `EACH_LIP`; empty where it was not measured.
    agreement : float
        By how much the aperture that these colours alone give grows where landmarks say that the
        mouth opens: about 1 where both are right; 1 where it was not measured.
    exposure : Exposure
        Of the face in the clip.
    """

    separability: Mapping[str, float] = field(default_factory=dict)
    agreement: float = 1.0
    exposure: Exposure = field(default_factory=Exposure)

    @property
    def poor(self) -> bool:
        """Whether fits by these colours are much less exact than usual."""
        return self.exposure.burnt or not self.chromatic or not shows_lips(self.separability)

    @property
    def blue(self) -> bool:
        """Whether the skin is more blue than red."""
        skin = self.mixtures["skin"]
        red, green = skin.weights @ skin.means[:, :2]
        return bool(1 - red - green > red)

    @property
    def weight(self) -> float:
        """Weight of these colours as evidence, 0 to 1.

        Less where they hardly tell lips from skin, or take what shows in an open mouth for lips.
        """
        told = list(self.separability.values()) or [1.0]
        apart = (float(np.mean(told)) - COLOURS.worthless) / (COLOURS.plain - COLOURS.worthless)
        follows = (self.agreement - COLOURS.deaf) / (COLOURS.following - COLOURS.deaf)
        return float(
            np.prod([np.clip(part, COLOURS.least_weight, 1.0) for part in (apart, follows)])
        )

    @property
    def outdoing(self) -> float:
        """By what factor colours open the mouth farther than landmarks do; 1 where they do not.

        In small pictures landmarks see half of a mouth's opening, and closed lips parted. It is 2
        at most, less where the colours are less sound, and where they open it absurdly far.
        """
        more = np.clip(1 - abs(self.agreement - COLOURS.most_outdone), 0.0, 1.0)
        return 1 + self.weight * float(more)

    def probabilities(self, image: NDArray[np.generic], smoothing: float = 0.0) -> FloatArray:
        """Probability maps (4, H, W) of an image (H, W, 3), RGB 0 to 255: see `ComparedColours`."""
        return self.compared(image).probabilities(smoothing)

    def save(self, path: Path) -> None:
        """Write an ``.npz`` that `load` reads: for each class its weights, means, covariances.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        with Path(path).open("wb") as file:  # given a name, NumPy would append its own suffix
            arrays: dict[str, Any] = self.arrays()
            np.savez_compressed(file, format=FORMAT, version=VERSION, **arrays)

    def arrays(self) -> dict[str, Any]:
        """As they are kept in a file; see `of_arrays`."""
        parts: dict[str, Any] = {
            f"{name}_{part}": getattr(self.mixtures[name], part)
            for name in self.mixtures
            for part in _PARTS
        }
        parts |= {"agreement": self.agreement, "chromatic": self.chromatic, "mixed": self.mixed}
        parts |= asdict(self.exposure)
        parts |= {f"{name}_separability": told for name, told in self.separability.items()}
        return {
            "classes": tuple(self.mixtures), "priors": self.priors, "reference": self.reference,
            **parts,
        }  # fmt: skip

    @classmethod
    def load(cls, path: Path) -> ColourClasses:
        """Read what `save` wrote.

        Raises
        ------
        InputFileError
            If the file is missing or no NPZ archive.
        ModelFormatError
            If it has another format or version, or its arrays do not fit together.
        """
        again = "take the colours.npz of another run"
        data = read_npz(Path(path), FORMAT, VERSION, LAYOUT, again)
        try:
            return cls.of_arrays(data)
        except (KeyError, ValueError) as error:
            raise ModelFormatError(
                f"{path} does not hold a complete set of colour classes", again
            ) from error

    @classmethod
    def of_arrays(cls, data: Mapping[str, NDArray[Any]]) -> ColourClasses:
        """From arrays as `LAYOUT` says; raises `KeyError` or `ValueError` where they do not fit."""
        names = (*CLASSES, *(n for n in EACH_LIP if f"{n}_weights" in data))
        mixtures = {c: Mixture(*(data[f"{c}_{part}"] for part in _PARTS)) for c in names}
        told = {n: float(data[k]) for n in EACH_LIP if (k := f"{n}_separability") in data}
        priors, reference = data["priors"], float(data["reference"])
        agreement = float(data.get("agreement", np.array(1.0)))
        chromatic = bool(data.get("chromatic", np.array(True)))
        known = [part.name for part in fields(Exposure) if part.name in data]
        exposure = Exposure(**{name: float(data[name]) for name in known})
        mixed = int(data.get("mixed", np.array(0)))
        fits = 0 <= mixed < len(mixtures["skin"].weights)
        if not (fits and all(mixture.sound for mixture in mixtures.values())):
            raise ValueError("the colour classes do not fit together")
        return cls(mixtures, priors, reference, chromatic, mixed, told, agreement, exposure)


def usable(classes: ColourClasses | None, chromatic: bool) -> ColourClasses | None:
    """Classes learned before; not those of colours where the video has none."""
    return None if classes is None or classes.chromatic != chromatic else classes


def shows_lips(separability: Mapping[str, float]) -> bool:
    """Whether a clip shows lips: either is told from skin, or that was not measured."""
    return max(separability.values(), default=1.0) >= COLOURS.no_lips
