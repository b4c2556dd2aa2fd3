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
    seen along it, which turns by no more than 1 too: ``n + Σ_i (1 + [i > j])²``. With joints that slide, all that
    counts lengths grows by the reach if that is below 1.

    Where the left singular vector at the middle, u, stays fixed, ``σ(θ + δ) ≤ ‖uᵀJ(θ + δ)‖``, and that is at most
    ``√(σ² + 2σ|∇σ·δ| + ‖Σ_j uᵀ(∂J/∂θ_j) δ_j‖²) + C(Σ_j|δ_j|)²/2``: what is blocked is told by how fast σ does change,
    not by how fast it may. ``C = ‖∂²J/∂θ_j∂θ_k‖_F``, by the same reasons as above ``C² ≤ n``, and ``2n`` where the tool
    keeps a pose.

    σ² is the least eigenvalue of JJᵀ, which is concave: on a straight line of matrices it is least at an end. So along
    a chord ``σ² ≥ min(σ_a², σ_b²) − max‖(JJᵀ)''‖/2``, derivatives being those by the parameter that goes from −1 to 1,
    with ``‖(JJᵀ)''‖ ≤ 2‖J‖‖J''‖ + 2‖J'‖²``. What is free is told by that, also of motions that stay at the margin.

    Neither is used for a tool that may roll: the frame that its Jacobian is given in turns with the tool, as fast as it
    likes where the tool points up. σ does not feel that; its bound by Weyl is all there is.
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
        pose, lever = len(self._rows) == _POSE, max(1.0, 1.0 / arm.reach) if arm.limits.slides.any() else 1.0
        turning = 0 * later if planar else later if pose else (arm.n - later) + 4 * later
        self._fastest = np.sqrt(lever**2 * arm.n + turning)
        self._bend = np.sqrt(arm.n * (lever**2 + (0.0 if planar else 1.0))) if planar or pose else np.inf

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
        values, rows, right = self._fixed(q)
        return values[:, None] - self.least, np.einsum("kji,ki->kj", rows, right)[:, None]

    def of_cells(self, cells: Cells, forgiven: float = 0.0) -> States:
        """Return what is sure of cells."""
        return self._within(0.5 * (cells.a + cells.b), 0.5 * (cells.b - cells.a), cells.dev, forgiven)

    def of_boxes(self, low: FloatArray, high: FloatArray, places: FloatArray | None = None) -> States:
        """Return what is sure of boxes of joint angles (m, n)."""
        return self._within(0.5 * (low + high), np.zeros_like(low), 0.5 * (high - low), 0.0)

    def cause(self, k: int) -> str:
        """Return in words what the margin is of."""
        return f"least singular value {self.least:g}"

    def _jacobian(self, q: FloatArray) -> FloatArray:
        return np.asarray(self._arm.jacobian(q) * self._rows[:, None])

    def _fixed(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return σ (k,), ``uᵀ ∂J/∂θ_j`` (k, joints j, n) with its left singular vector u fixed, and the right one."""
        u, values, v = np.linalg.svd(self._jacobian(q), full_matrices=False)
        left, rows = u[..., -1] * self._rows, np.empty((len(q), self._arm.n, self._arm.n))
        for j in range(self._arm.n):
            turn = np.zeros_like(q)
            turn[:, j] = 1.0
            rows[:, j] = np.einsum("ki,kij->kj", left, self._arm.jacobian_rate(q, turn))
        return values[:, -1], rows, v[..., -1, :]

    def _within(self, q: FloatArray, half: FloatArray, dev: FloatArray, forgiven: float) -> States:
        """Return what is sure of postures ``q + s·half + e`` with ``|s| ≤ 1`` and ``|e| ≤ dev``."""
        margin = self.margins(q)[:, 0]
        change = (np.abs(half) + dev) @ self._fastest + _PAD
        blocked, free = margin < -change - self.tolerance, margin + forgiven > change
        if np.isfinite(self._bend):
            above = np.flatnonzero(~free & half.any(axis=1))
            below = np.flatnonzero(~blocked & (margin < -self.tolerance))
            free[above] = self._no_less(q[above], half[above], dev[above]) > self.least - forgiven + _PAD
            blocked[below] = self._no_more(q[below], half[below], dev[below]) < self.least - self.tolerance - _PAD
        state = np.where(blocked, -1, free.astype(np.int64))
        return States(state, np.where(free, -1, 0))

    def _no_more(self, q: FloatArray, half: FloatArray, dev: FloatArray) -> FloatArray:
        """Return what σ is at most in ``q + s·half + e``, shape (k,)."""
        sigma, rows, right = self._fixed(q)
        along, slopes = np.einsum("kj,kji->ki", half, rows), np.einsum("kji,ki->kj", rows, right)
        slope = np.abs(np.einsum("kj,kj->k", half, slopes)) + np.einsum("kj,kj->k", dev, np.abs(slopes))
        moved = np.linalg.norm(along, axis=1) + np.einsum("kj,kj->k", dev, np.linalg.norm(rows, axis=2))
        second = 0.5 * self._bend * (np.abs(half) + dev).sum(axis=1) ** 2
        return np.asarray(np.sqrt(sigma**2 + 2.0 * sigma * slope + moved**2) + second)

    def _no_less(self, q: FloatArray, half: FloatArray, dev: FloatArray) -> FloatArray:
        """Return what σ is at least in ``q + s·half + e``, shape (k,); 0 where nothing is sure."""
        ends = np.linalg.svd(self._jacobian(np.concatenate([q - half, q + half])), compute_uv=False)
        least, largest = ends[:, -1].reshape(2, -1).min(axis=0), ends[:, 0].reshape(2, -1).max(axis=0)
        speed, bend = np.abs(half) @ self._fastest, self._bend * np.abs(half).sum(axis=1) ** 2
        curvature = 2.0 * (largest + speed) * bend + 2.0 * speed**2
        return np.asarray(np.sqrt(np.maximum(least**2 - 0.5 * curvature, 0.0)) - dev @ self._fastest)
