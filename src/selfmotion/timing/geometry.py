"""A motion by its path parameter, with its derivatives: what time laws are made for."""

from __future__ import annotations

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import distance
from selfmotion.plans import Plan

_STEP = 2e-6  # of differences in r: rates are exact to about 1e-12, so that these are to about 1e-6
_BESIDE = 1e-9  # a break, in r
_CORNER = 1e-6  # jump of a joint's rate, as a part of the largest rate, that no moving arm can make


class Geometry:
    """The joint motion of a plan and its tool's speed, by r.

    Parameters
    ----------
    plan : Plan

    Attributes
    ----------
    edges : array, shape (p + 1,)
        0, the breaks of the motion, and 1; between them it is smooth.
    corners : array of bool, shape (p + 1,)
        At which of them the joints' rates jump, so that the arm must stand still there; the ends count as such.
    knots : array, shape (k,)
        Where the third derivative may jump: the second one may have a peak there that is nowhere else near.
    """

    def __init__(self, plan: Plan) -> None:
        self.motion, self.path = plan.motion, plan.problem.path
        breaks = np.asarray(getattr(plan.motion, "breaks", self.path.breaks))
        self.edges = np.unique(np.concatenate([[0.0], breaks, [1.0]]))
        self.corners = self._corners()
        space, curve = getattr(plan.motion, "space", None), getattr(plan.motion, "curve", None)
        splines = [space.edges] if space is not None else [getattr(getattr(curve, "profile", None), "knots", [])]
        self.knots = np.unique(np.concatenate([*splines, self.path.waypoints]))

    def _corners(self) -> BoolArray:
        inner = self.edges[1:-1]
        look = np.linspace(0.0, 1.0, 201)
        scale = np.abs(self._finite(look)).max()
        if not scale > 0.0:
            raise InvalidInputError("plan", "does not move any joint", "there is nothing to time")
        jump = np.abs(self._finite(inner + _BESIDE) - self._finite(inner - _BESIDE)) if len(inner) else np.empty((0, 1))
        return np.concatenate([[True], jump.max(axis=1, initial=0.0) > _CORNER * scale, [True]])

    def _finite(self, r: FloatArray) -> FloatArray:
        """Return the rates dq/dr, shape (k, n)."""
        with np.errstate(all="ignore"):
            rates = self.motion.rates(r)
        wrong = ~np.isfinite(rates).all(axis=1)
        if wrong.any():
            reason = f"moves a joint infinitely fast at r = {r[wrong][0]:.6g}, as motions do that fold the arm by u(r)"
            raise InvalidInputError("plan", reason, "refine it: planner refine or global crosses folds smoothly")
        return rates

    def derivatives(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dq/dr and d²q/dr² at r (k,), shape (k, n) each; at breaks those of the right."""
        piece = np.clip(np.searchsorted(self.edges, r, side="right") - 1, 0, len(self.edges) - 2)
        low, high = self.edges[piece] + _BESIDE, self.edges[piece + 1] - _BESIDE
        before, after = np.clip(r - _STEP, low, high), np.clip(r + _STEP, low, high)
        rates = self._finite(np.concatenate([np.clip(r, low, high), before, after]))
        now, one, two = np.split(rates, 3)
        return now, (two - one) / (after - before)[:, None]

    def tool_speed(self, r: FloatArray) -> FloatArray:
        """Return |dx/dr| of the tool's position, shape (k,)."""
        return distance(self.path(r, 1))
