"""Six-axis arms on a rail: the tool keeps its whole pose, and where the base is on the rail is the redundant degree."""

from __future__ import annotations

from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.angles import NEVER
from selfmotion.arms.chain import Chain
from selfmotion.arms.curve_self_motion import CurveSelfMotion
from selfmotion.arms.rail_forms import RAIL_FAMILIES, rail_form_of
from selfmotion.arms.six_axes import SixAxisArm
from selfmotion.errors import InvalidInputError

LONGEST = 1000.0
"""How far a base may get along its rail, either way [m]."""
_ON_LIMIT = 1e-9  # [m]


class RailArm(SixAxisArm):
    """An arm with six revolute joints whose base slides on a rail; the tool keeps its pose.

    Parameters
    ----------
    chain : Chain
        A prismatic joint with limits on both sides, then six revolute ones; the tool frame is the chain's last. Lengths
        in metres.

    Attributes
    ----------
    n, n_u : int
        7, the rail being joint 1, and 1.

    Raises
    ------
    InvalidInputError
        If no closed form solves the six axes, or the rail has no end within 1000 m.

    Notes
    -----
    The redundancy parameter u is the rail's position [m], which is joint 1. Objectives add up joints as they are: one
    metre of the rail counts as one radian of another joint, unless ``weights`` say otherwise. In l1 and l2 the rail's
    weight is in rad/m: how many radians of the other joints a metre of the rail is worth. In joint travel a weight
    multiplies √(1 + (dq/dr)²), in whatever unit q is. Formulas: docs/mathematics.
    """

    families = RAIL_FAMILIES
    recognised = staticmethod(rail_form_of)
    what = "an arm on a rail"
    u_period = NEVER

    def __init__(self, chain: Chain) -> None:
        super().__init__(chain)
        low, high = self.limits.lower[0], self.limits.upper[0]
        if not (np.isfinite(low) and np.isfinite(high)):
            raise InvalidInputError(
                "arm", f"has a joint that slides without end, {chain.names[0]}", "give it a lower and an upper limit"
            )
        if max(abs(low), abs(high)) > LONGEST:
            raise InvalidInputError(
                "arm", f"has a joint that slides farther than {LONGEST:g} m, {chain.names[0]}",
                "give its limits in metres, and count them from nearer by", [float(low), float(high)],
            )  # fmt: skip

    @property
    def reach(self) -> float:
        """Sum of the lengths between the joints, from the base's first one to the tool [m]."""
        return float(self.kernel.levers[1])

    @property
    def parameter_range(self) -> tuple[float, float]:
        """The values of u to look at: the rail's [m]."""
        return float(self.limits.lower[0]) - _ON_LIMIT, float(self.limits.upper[0]) + _ON_LIMIT

    def shortfall(self, x: ArrayLike) -> FloatArray:
        """Return how far tool positions are out of reach wherever on an endless rail the base is, shape (...) [m]."""
        first = self.chain.offsets[0] @ self.chain.offsets[1]
        away, along = np.asarray(x, dtype=float)[..., :3] - first[:3, 3], self.chain.offsets[0][:3, 2]
        across = away - (away @ along)[..., None] * along
        return np.asarray(np.linalg.norm(across, axis=-1) - self.reach)

    def u_of(self, q: ArrayLike) -> FloatArray:
        """Return where on its rail the base of postures is, shape (..., 1) [m]."""
        return self._joints(q)[..., :1].copy()

    def _parameter_gradient(self, q: FloatArray) -> FloatArray:
        return np.broadcast_to(np.arange(self.n) == 0, q.shape).astype(float)

    def solve_with_margin(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> NoReturn:
        """Raise InvalidInputError: profiles are of angles."""
        raise InvalidInputError(
            "planner", "searches for u(r) as an angle, and this arm's u is a length", "use planner global or refine"
        )

    def self_motion(self) -> CurveSelfMotion:
        """Raise InvalidInputError: angle domains are periodic."""
        raise InvalidInputError(
            "arm", "has a length as its redundancy parameter, and an angle domain is of angles",
            "use plan, verify or compare",
        )  # fmt: skip
