"""A margin from singular postures: the least singular value of the Jacobian must not be too small."""

from __future__ import annotations

import numpy as np

from selfmotion._checks import positive
from selfmotion._types import FloatArray, IntArray
from selfmotion.arms import RedundantArm
from selfmotion.arms.cells import Cells
from selfmotion.constrained.constraint import States
from selfmotion.paths.base import PLANE, SPACE

_TOLERANCE = 1e-9
_PAD = 1e-12
_POSE = 6  # rows of the Jacobian of a tool that keeps a pose


class SingularityMargin:
    """The least singular value of the task's Jacobian is at least so large; a :class:`Constraint`.

    Parameters
    ----------
    arm : RedundantArm
    least : float
        Least singular value allowed, of the Jacobian with lengths as parts of the reach: its size does not depend on
        the unit of length. A stretched-out arm has 0.

    Raises
    ------
    InvalidInputError
        If `least` is not positive.

    Notes
    -----
    σ changes by no more than J does (Weyl). As joint j turns, the tool's velocity by joint i changes by no more than
    the farthest that the tool gets from either, which the reach bounds, and the axis of a later joint by 1:
    ``‖∂J/∂θ_j‖_F² ≤ n + #{i > j}`` with lengths as parts of the reach. For a tool that may roll, axes count as they are
    seen along it, which turns by no more than 1 too: ``n + Σ_i (1 + [i > j])²``.
    """

    check = "singularity"
    unit = ""
    scale = 1.0
    tolerance = _TOLERANCE

    def __init__(self, arm: RedundantArm, least: float) -> None:
        self._arm = arm
        self.least = positive("least_singular_value", least)
        planar = arm.dimension == PLANE
        # Lengths come first, then angles.
        self._rows = np.ones(arm.jacobian(np.zeros((1, arm.n))).shape[1])
        self._rows[: PLANE if planar else SPACE] = 1.0 / arm.reach
        later = np.arange(arm.n)[::-1]
        turning = 0 * later if planar else later if len(self._rows) == _POSE else (arm.n - later) + 4 * later
        self._fastest = np.sqrt(arm.n + turning)

    def __repr__(self) -> str:
        return f"SingularityMargin({self.least!r})"

    def margins(self, q: FloatArray) -> FloatArray:
        """Return the least singular value less what is asked for, shape (k, 1); NaN of postures that are NaN."""
        jacobian = self._jacobian(q)
        known = np.asarray(np.isfinite(jacobian).all(axis=(1, 2), keepdims=True))
        values = np.linalg.svd(np.where(known, jacobian, 0.0), compute_uv=False)
        return np.where(known[:, 0], values[:, -1:], np.nan) - self.least

    def least_margins(self, q: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return the margin and that it is the first, shapes (k,)."""
        return self.margins(q)[:, 0], np.zeros(len(q), np.int64)

    def gradients(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the margins (k, 1) and their derivatives ``uᵀ ∂J/∂θ_j v`` by the joints (k, 1, n)."""
        u, values, v = np.linalg.svd(self._jacobian(q), full_matrices=False)
        left, right = u[..., -1] * self._rows, v[..., -1, :]
        rates = np.empty((len(q), 1, self._arm.n))
        for j in range(self._arm.n):
            turn = np.zeros_like(q)
            turn[:, j] = 1.0
            rates[:, 0, j] = np.einsum("ki,kij,kj->k", left, self._arm.jacobian_rate(q, turn), right)
        return values[:, -1:] - self.least, rates

    def of_cells(self, cells: Cells, forgiven: float = 0.0) -> States:
        """Return what is sure of cells."""
        return self._within(0.5 * (cells.a + cells.b), 0.5 * np.abs(cells.b - cells.a) + cells.dev, forgiven)

    def of_boxes(self, low: FloatArray, high: FloatArray, places: FloatArray | None = None) -> States:
        """Return what is sure of boxes of joint angles (m, n)."""
        return self._within(0.5 * (low + high), 0.5 * (high - low), 0.0)

    def cause(self, k: int) -> str:
        """Return in words what the margin is of."""
        return f"least singular value {self.least:g}"

    def _jacobian(self, q: FloatArray) -> FloatArray:
        return np.asarray(self._arm.jacobian(q) * self._rows[:, None])

    def _within(self, q: FloatArray, radius: FloatArray, forgiven: float) -> States:
        margin = self.margins(q)[:, 0]
        change = radius @ self._fastest + _PAD
        blocked, free = margin < -change - self.tolerance, margin + forgiven > change
        state = np.where(blocked, -1, free.astype(np.int64))
        return States(state, np.where(free, -1, 0))
