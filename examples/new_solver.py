"""A new driver: Powell's method, by SciPy.

Try it: abs-engine track CLIP -o RUN --plugin examples/new_solver.py --driver powell
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, minimize

from abs_engine import DRIVERS, Driver, ParamSpec, Problem, Solution


@dataclass(frozen=True)
class Powell:
    """Minimise along one direction after the other."""

    limit: int = 400

    def minimise(self, problem: Problem, start: np.ndarray, spec: ParamSpec) -> Solution:
        scale, room = spec.scale, Bounds(spec.lower / spec.scale, spec.upper / spec.scale)
        options = {"maxfev": self.limit, "ftol": 1e-4}
        more = {"method": "Powell", "bounds": room, "options": options}
        found = minimize(lambda x: problem(x * scale).value, start / scale, **more)
        return Solution(found.x * scale, found.message, float(found.fun), {}, found.nfev)


DRIVERS.add("powell", Driver(Powell))
