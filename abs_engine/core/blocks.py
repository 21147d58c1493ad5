"""Named blocks of parameters, such as pose and posture; one flat vector only inside a solver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.params import ParamSpec

POSE, POSTURE, IDENTITY = "pose", "posture", "identity"


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of parameters by name, in the order in which they stand in a flat vector."""

    specs: Mapping[str, ParamSpec]

    def __len__(self) -> int:
        """Return the number of parameters of all blocks, N."""
        return self._count

    @cached_property
    def _count(self) -> int:
        return sum(len(spec) for spec in self.specs.values())

    @cached_property
    def places(self) -> dict[str, slice]:
        """Slice of each block in a flat vector."""
        ends = np.cumsum([len(spec) for spec in self.specs.values()])
        starts = np.r_[0, ends[:-1]]
        return {
            name: slice(int(a), int(b)) for name, a, b in zip(self.specs, starts, ends, strict=True)
        }

    @cached_property
    def spec(self) -> ParamSpec:
        """All parameters one after the other."""
        each = self.specs.values()
        return ParamSpec(
            tuple(name for one in each for name in one.names),
            tuple(unit for one in each for unit in one.units),
            *(
                np.concatenate([np.zeros(0), *(getattr(one, part) for one in each)])
                for part in ("scale", "lower", "upper")
            ),
        )

    def part(self, vectors: FloatArray, name: str) -> FloatArray:
        """A block's numbers (..., n) of flat vectors (..., N); none where there is no such one."""
        return vectors[..., self.places.get(name, slice(0, 0))]

    def vector(self, parts: Mapping[str, FloatArray | np.float64]) -> FloatArray:
        """The flat vector (N,) of some blocks' numbers; the others are zero."""
        out = np.zeros(len(self))
        for name, values in parts.items():
            out[self.places[name]] = values
        return out

    def only(self, names: Iterable[str]) -> Blocks:
        """Some of the blocks, in their order here; `ParameterError` if there is none of a name."""
        wanted = set(names)
        unknown = wanted - set(self.specs)
        if unknown:
            raise ParameterError(
                f"there is no block of parameters '{min(unknown)}'",
                f"choose one of {', '.join(self.specs)}",
            )
        if len(wanted) == len(self.specs):
            return self
        return Blocks({name: spec for name, spec in self.specs.items() if name in wanted})

    def indices(self, names: Iterable[str]) -> IntArray:
        """Indices of the parameters of some blocks in a flat vector, (M,)."""
        kept = self.only(names).specs
        return np.concatenate(
            [np.zeros(0, np.int64), *(np.arange(len(self))[self.places[n]] for n in kept)]
        )
