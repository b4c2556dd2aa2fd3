"""What is linear in a step at one iterate of Newton's method: the metric P, the task's A, and projection by both.

``d = argmin ½ dᵀP d − cᵀd`` subject to ``A d = y``, with its multipliers λ, is what all steps are made of. There are
two ways to it. Dense: ``S = A P⁻¹ Aᵀ``, one matrix of the size of the task, whatever the number of joints. Banded: the
optimality conditions ``P d − Aᵀλ = c, A d = y`` with unknowns and multipliers in the order of the path, where a
spline's coefficient meets its neighbours only. The first costs the cube of tasks times knots, the second the square of
joints and tasks, times knots.

*Soft rows* ``½ Σ w (g d(r_k))²`` may be added to P: the barrier's curvature at a collocation point, which couples
joints and grows without bound. They stay out of P itself: with ``y = −w g d(r_k)`` they are rows of A with ``1/w`` on
the diagonal of the multipliers, ``g d(r_k) + y/w = 0``, so that P remains one matrix per joint, and a large w is as
harmless as the task, which is one whose w is infinite.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from typing import NamedTuple, Self

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.refinement.collocation import Collocation
from selfmotion.refinement.spline import DEGREE

_RIDGE = 1e-13  # part of the diagonal of S that is added to it


class SoftRows(NamedTuple):
    """What is added to the metric at the collocation points, a rows at each.

    Attributes
    ----------
    gradients : array, shape (k, a, n)
        g.
    weights : array, shape (k, a)
        w; zero of a row that is not there.
    """

    gradients: FloatArray
    weights: FloatArray


class Linear(ABC):
    """P, A and what follows from them.

    Parameters
    ----------
    problem : Collocation
    q : array, shape (k, n)
        Postures at the collocation points, where the task is linearised.
    matrices : array, shape (n, f, f)
        P, joint by joint.
    soft : SoftRows, optional
        What is added to P.

    Raises
    ------
    LinAlgError
        If a matrix is singular.
    """

    def __init__(self, problem: Collocation, q: FloatArray, matrices: FloatArray, soft: SoftRows | None = None) -> None:
        self.problem, self.matrices = problem, matrices
        self.soft = soft if soft is not None and soft.weights.any() else None
        self._jacobian = problem.arm.jacobian(q)
        self._prepare()
        self._factorise()

    @abstractmethod
    def _prepare(self) -> None:
        """Do what depends on P alone."""

    @abstractmethod
    def _factorise(self) -> None:
        """Factorise what depends on the Jacobian."""

    @abstractmethod
    def _solved(self, c: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return d (n, f) and λ (k, tasks)."""

    def at(self, q: FloatArray) -> Self:
        """Return the same with the task linearised at other postures."""
        other = copy.copy(self)
        other._jacobian = self.problem.arm.jacobian(q)
        other._factorise()
        return other

    def task(self, d: FloatArray) -> FloatArray:
        """Return A d, shape (k, tasks)."""
        return np.asarray((self._jacobian @ (self.problem.values @ d.T)[:, :, None])[:, :, 0])

    def transposed(self, y: FloatArray) -> FloatArray:
        """Return Aᵀ y, shape (n, f)."""
        return np.asarray((self._jacobian * y[:, :, None]).sum(axis=1).T @ self.problem.values)

    def multipliers(self, c: FloatArray) -> FloatArray:
        """Return the λ for which c − Aᵀλ is least in the metric of P⁻¹, shape (k, tasks)."""
        return -self._solved(c, np.zeros(self._jacobian.shape[:2]))[1]

    def tangent(self, c: FloatArray) -> FloatArray:
        """Return P⁻¹ c, projected onto the tangents in the metric of P."""
        return self._solved(c, np.zeros(self._jacobian.shape[:2]))[0]

    def towards(self, lack: FloatArray) -> FloatArray:
        """Return the least step, in the metric of P, that moves the tool by `lack` to first order."""
        return self._solved(np.zeros((len(self.matrices), self.matrices.shape[1])), lack)[0]

    def product(self, a: FloatArray, b: FloatArray) -> float:
        """Return the inner product of P."""
        plain = float((a * (self.matrices @ b[:, :, None])[:, :, 0]).sum())
        return plain if self.soft is None else plain + self._softly(a, b, self.soft)

    def _softly(self, a: FloatArray, b: FloatArray, soft: SoftRows) -> float:
        """Return what soft rows add to the inner product."""
        one, other = ((soft.gradients @ (self.problem.values @ d.T)[:, :, None])[:, :, 0] for d in (a, b))
        return float((soft.weights * one * other).sum())

    def to_edge(self, step: FloatArray, direction: FloatArray, radius: float) -> float:
        """Return the t ≥ 0 at which step + t direction has length `radius`."""
        a, b = self.product(direction, direction), self.product(step, direction)
        c = radius * radius - self.product(step, step)
        return float((-b + np.sqrt(max(b * b + a * c, 0.0))) / a) if a > 0 else 0.0


class DenseLinear(Linear):
    """By the matrix S of the task."""

    def _prepare(self) -> None:
        self._inverse = np.asarray(np.linalg.inv(self.matrices), dtype=float)
        self._spread = self.problem.at_points(self._inverse)

    def _factorise(self) -> None:
        from scipy.linalg import cho_factor

        k, tasks, _ = self._jacobian.shape
        schur = np.empty((k, tasks, k, tasks))
        by_joint = self._jacobian.transpose(1, 2, 0)
        for a in range(tasks):
            for b in range(a, tasks):
                block = np.einsum("ik,ikl,il->kl", by_joint[a], self._spread, by_joint[b])
                schur[:, a, :, b] = block
                schur[:, b, :, a] = block.T
        square = schur.reshape(k * tasks, k * tasks)
        # Where the arm is stretched out the tool cannot move along it: a ridge far below anything that matters.
        square[np.diag_indices(k * tasks)] *= 1 + _RIDGE
        if self.soft is not None:
            square = self._bordered(square, self.soft)
        self._schur = cho_factor(square, overwrite_a=True, check_finite=False)

    def _bordered(self, square: FloatArray, soft: SoftRows) -> FloatArray:
        """Return S with the soft rows below those of the task."""
        tasks = self._jacobian.shape[1]
        point, row = np.nonzero(soft.weights)
        self._soft_at, self._soft_gradients = point, soft.gradients[point, row]
        size, more = len(square), len(point)
        whole = np.empty((size + more, size + more))
        whole[:size, :size] = square
        near = self._spread[:, point, :] * self._soft_gradients.T[:, :, None]
        for a in range(tasks):
            whole[size:, a:size:tasks] = np.einsum("isk,ki->sk", near, self._jacobian[:, a])
        whole[:size, size:] = whole[size:, :size].T
        whole[size:, size:] = np.einsum("ist,ti->st", near[:, :, point], self._soft_gradients)
        more_diagonal = np.arange(size, size + more)
        whole[more_diagonal, more_diagonal] *= 1 + _RIDGE
        whole[more_diagonal, more_diagonal] += 1.0 / soft.weights[point, row]
        return whole

    def _solved(self, c: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        from scipy.linalg import cho_solve

        moved = (self._inverse @ c[:, :, None])[:, :, 0]
        lack = y - self.task(moved)
        if self.soft is not None:
            return self._softly_solved(moved, lack)
        found = np.asarray(cho_solve(self._schur, lack.ravel(), check_finite=False)).reshape(lack.shape)
        return moved + (self._inverse @ self.transposed(found)[:, :, None])[:, :, 0], found

    def _softly_solved(self, moved: FloatArray, lack: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the same as :meth:`_solved`, with soft rows."""
        from scipy.linalg import cho_solve

        values = self.problem.values
        soft = -(self._soft_gradients * (values[self._soft_at] @ moved.T)).sum(axis=1)
        both = cho_solve(self._schur, np.concatenate([lack.ravel(), soft]), check_finite=False)
        found, pull = both[: lack.size].reshape(lack.shape), both[lack.size :]
        pushed = self.transposed(found) + (self._soft_gradients * pull[:, None]).T @ values[self._soft_at]
        return moved + (self._inverse @ pushed[:, :, None])[:, :, 0], found


class BandedLinear(Linear):
    """By the optimality conditions, whose matrix is banded if no coefficient is met at both ends of the path."""

    @property
    def _soft_rows(self) -> int:
        return 0 if self.soft is None else self.soft.weights.shape[1]

    def _prepare(self) -> None:
        n, f, _ = self.matrices.shape
        tasks = self._jacobian.shape[1]
        self._width = n + tasks + self._soft_rows
        self._band = DEGREE * self._width + self._width - 1
        ab = np.zeros((3 * self._band + 1, f * self._width), order="F")
        joints = np.arange(n)
        for off in range(-DEGREE, DEGREE + 1):
            i = np.arange(max(0, -off), min(f, f - off))
            rows, columns = i[:, None] * self._width + joints, (i + off)[:, None] * self._width + joints
            ab[2 * self._band + rows - columns, columns] = self.matrices[:, i, i + off].T
        self._metric = ab

    def _factorise(self) -> None:
        from scipy.linalg.lapack import dgbtrf

        n, f, _ = self.matrices.shape
        tasks, values, width, band = self._jacobian.shape[1], self.problem.values, self._width, self._band
        ab = self._metric.copy(order="F")
        rows_of_a = self._jacobian
        if self.soft is not None:
            there = self.soft.gradients * (self.soft.weights > 0)[:, :, None]
            rows_of_a = np.concatenate([rows_of_a, there], axis=1)
        task, joint = np.arange(rows_of_a.shape[1])[:, None], np.arange(n)[None, :]
        for off in range(-DEGREE, DEGREE + 1):
            i = np.arange(max(0, -off), min(f, f - off))
            block = rows_of_a[i] * values[i, i + off][:, None, None]
            rows = i[:, None, None] * width + n + task + 0 * joint
            columns = (i + off)[:, None, None] * width + joint + 0 * task
            ab[2 * band + rows - columns, columns] = block
            ab[2 * band + columns - rows, rows] = -block
        # The same ridge as the dense way has: where the tool cannot move, multipliers stay what they are.
        ends = np.arange(f)[:, None] * width + n + np.arange(tasks)
        ab[2 * band, ends] = _RIDGE * min(1.0, self.problem.arm.reach**2)  # small lengths have smaller squares
        if self.soft is not None:
            ends = np.arange(f)[:, None] * width + n + tasks + np.arange(self._soft_rows)
            weights = self.soft.weights
            ab[2 * band, ends] = np.where(weights > 0, 1.0 / np.where(weights > 0, weights, 1.0), 1.0)
        self._lu, self._pivots, wrong = dgbtrf(ab, band, band, overwrite_ab=1)
        if wrong:
            raise np.linalg.LinAlgError("singular")

    def _solved(self, c: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        from scipy.linalg.lapack import dgbtrs

        n, f = c.shape
        right = np.concatenate([c.T, y, np.zeros((f, self._soft_rows))], axis=1).ravel()
        found, _ = dgbtrs(self._lu, self._band, self._band, right, self._pivots, overwrite_b=1)
        both = found.reshape(f, self._width)
        return np.ascontiguousarray(both[:, :n].T), both[:, n : n + y.shape[1]]


def linear_at(problem: Collocation, q: FloatArray, matrices: FloatArray, soft: SoftRows | None = None) -> Linear:
    """Return what is linear at postures q (k, n), the cheaper way."""
    k, tasks = len(problem.points), problem.arm.jacobian(q[:1]).shape[1]
    tasks += 0 if soft is None else soft.weights.shape[1]
    band = (DEGREE + 1) * (len(matrices) + tasks)
    banded = problem.is_local and len(problem.points) == matrices.shape[1]
    dense = (k * tasks) ** 3 / 3 + len(matrices) * k**3
    cheaper = 2 * k * (len(matrices) + tasks) * band * 2 * band < dense
    return (BandedLinear if banded and cheaper else DenseLinear)(problem, q, matrices, soft)
