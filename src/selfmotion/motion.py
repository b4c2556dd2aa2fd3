"""A continuous joint motion along a path: IK of a curve u(r), with its number of turns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.angles import nearest_turn
from selfmotion.arms import RedundantArm
from selfmotion.paths import Path
from selfmotion.paths.base import path_parameter

Curve = Callable[[FloatArray, int], FloatArray]
"""u(r) or du/dr: maps r of shape (k,) and an order, 0 or 1, to shape (k, n_u)."""


class JointMotion(Protocol):
    """What a plan needs of a continuous motion, however it is represented."""

    def __call__(self, r: ArrayLike) -> FloatArray:
        """Return the joint angles, shape (..., n), turns included [rad]."""
        ...

    def u(self, r: ArrayLike) -> FloatArray:
        """Return the redundancy vector, shape (..., n_u) [rad]."""
        ...

    def rates(self, r: ArrayLike) -> FloatArray:
        """Return dθ/dr, shape (..., n)."""
        ...


class Motion:
    """The joint motion ``θ(r) = IK(x(r), u(r), branch)``.

    Parameters
    ----------
    arm : RedundantArm
    path : Path
    curve : callable
        The redundancy vector along the path; see `Curve`.
    branch : int
    nodes : int
        Number of nodes from which the turns are counted; no joint may move by π between two of them.
    start : array, shape (n,), optional
        Joint angles at r = 0, which fix the turns; else the joint limits do.
    """

    def __init__(
        self, arm: RedundantArm, path: Path, curve: Curve, branch: int, nodes: int, start: FloatArray | None = None
    ) -> None:
        self.arm = arm
        self.path = path
        self.branch = branch
        self.curve = curve
        self.nodes = nodes
        self.start = start
        self._nodes = path.grid(nodes)
        principal = arm.solve(path(self._nodes), curve(self._nodes, 0), branch)[0]
        self._lifted = arm.limits.lift(principal[None], start).q[0]

    @property
    def breaks(self) -> FloatArray:
        """Path parameters inside (0, 1) where a derivative may jump."""
        bases = getattr(self.curve, "moving_bases", ())
        return np.unique(np.concatenate([self.path.breaks, *(base.breaks for base in bases)]))

    def u(self, r: ArrayLike, order: int = 0) -> FloatArray:
        """Return the redundancy vector or its derivative, shape (..., n_u)."""
        values = path_parameter(r)
        return self.curve(values.reshape(-1), order).reshape(*values.shape, self.arm.n_u)

    def __call__(self, r: ArrayLike) -> FloatArray:
        """Return the joint angles, shape (..., n), turns included [rad]."""
        values = np.asarray(r, dtype=float)
        q = self.arm.solve(self.path(values), self.u(values), self.branch)[0]
        near = np.stack([np.interp(values, self._nodes, joint) for joint in self._lifted.T], axis=-1)
        return nearest_turn(q, near, self.arm.limits.period)

    def rates(self, r: ArrayLike) -> FloatArray:
        """Return dθ/dr, shape (..., n); infinite or NaN exactly at a fold."""
        x, dx = self.path(r), self.path(r, 1)
        return self.arm.rates(x, dx, self.u(r), self.u(r, 1), self.branch)
