"""A problem on a spline: its cost at quadrature nodes, its task at collocation points, its limits at the coefficients.

By the convex hull property a spline stays inside joint limits if its coefficients do.
"""

from __future__ import annotations

import copy
from functools import cached_property
from typing import Self

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import JointBox, RedundantArm
from selfmotion.objectives import Objective, Smoothed
from selfmotion.paths import Path
from selfmotion.refinement.spline import Ends, SplineSpace


class Collocation:
    """The unknowns of a motion and what is asked of them.

    Parameters
    ----------
    arm : RedundantArm
    path : Path
    objective : Objective
    weights : array, shape (n,)
    box : JointBox
        Joint limits, narrowed to one elbow if the problem asks for it.
    space : SplineSpace
    ends : Ends
    width : float
        Rounding of the kinks of objectives that are not smooth; see :meth:`Objective.smoothed`.

    Attributes
    ----------
    points : array, shape (k,)
        Collocation points at which the task must be kept; where a posture is fixed it is kept already.
    values : array, shape (k, f)
        The unknowns' basis functions at these points: joints change by ``values @ d.T`` for a step d (n, f).
    constraints : tuple
        Further constraints on postures, those of the arm; each with its margins, their gradients and their scale.
    shift : array, shape (k, m), or float
        By how much margins at the points must be greater than zero, in their scales.

    Notes
    -----
    The unknowns are the coefficients that the ends leave free, shape (n, f). Everything costs O(n) at a given number of
    coefficients.
    """

    def __init__(
        self,
        arm: RedundantArm,
        path: Path,
        objective: Objective,
        weights: FloatArray,
        box: JointBox,
        space: SplineSpace,
        ends: Ends,
        width: float,
    ) -> None:
        from scipy.sparse import csr_array

        self.arm, self.path, self.objective, self.weights = arm, path, objective, weights
        self.box, self.space, self.ends, self.width = box, space, ends, width
        # What is not unknown is fixed, except that a cyclic motion's last coefficient goes with its first.
        self._wraps = ends.closure is not None and ends.start is None
        last_fixed = ends.end is not None or ends.closure is not None
        self._free = slice(int(ends.start is not None), space.m - int(last_fixed))
        self._offset = np.zeros((arm.n, space.m))
        if ends.start is not None:
            self._offset[:, 0] = ends.start
        if ends.end is not None:
            self._offset[:, -1] = ends.end
        if ends.closure is not None:
            self._offset[:, -1] = self._offset[:, 0] + ends.closure
        self.points = space.collocation[self._free]
        self._targets = path(self.points)
        self.values, self._fixed_values = self._split(space.design(self.points))
        self._slopes, self._fixed_slopes = self._split(space.design(space.nodes, 1))
        self._sparse_values = csr_array(self.values)
        self.constraints = tuple(getattr(arm, "constraints", ()))
        self.shift: FloatArray | float = 0.0
        at_nodes = self._split(space.design(space.nodes))[0]
        self._mass = (at_nodes.T * space.weights) @ at_nodes

    def shifted(self, shift: FloatArray) -> Self:
        """Return the same with margins (k, m) shifted."""
        other = copy.copy(self)
        other.shift = shift
        return other

    @property
    def is_local(self) -> bool:
        """Whether each unknown concerns one part of the path; the first of a cyclic motion is its last too."""
        return not self._wraps

    def _split(self, design: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what unknowns (n, f) are multiplied with for values (k, n), and what is added to them."""
        return self._fold(design), design @ self._offset.T

    def _fold(self, last_axis: FloatArray) -> FloatArray:
        """Return an array (..., m) over the coefficients as one over the unknowns, (..., f)."""
        folded = last_axis[..., self._free].copy()
        if self._wraps:
            folded[..., 0] += last_axis[..., -1]
        return folded

    def unknowns(self, coefficients: FloatArray) -> FloatArray:
        """Return the unknowns (n, f) among the coefficients (n, m) of a spline."""
        return coefficients[:, self._free].copy()

    def coefficients(self, c: FloatArray) -> FloatArray:
        """Return all coefficients (n, m) for unknowns (n, f)."""
        full = self._offset.copy()
        full[:, self._free] += c
        if self._wraps:
            full[:, -1] += c[:, 0]
        return full

    def postures(self, c: FloatArray) -> FloatArray:
        """Return the joint angles at the collocation points, shape (k, n)."""
        return self.values @ c.T + self._fixed_values

    def rates(self, c: FloatArray) -> FloatArray:
        """Return dθ/dr at the quadrature nodes, shape (g, n)."""
        return self._slopes @ c.T + self._fixed_slopes

    def lack(self, q: FloatArray) -> FloatArray:
        """Return what postures (k, n) at the collocation points lack to keep the task, shape (k, tasks)."""
        return self.arm.task_residual(q, self._targets)

    def miss(self, q: FloatArray) -> float:
        """Return the largest tracking error of postures at the collocation points, as a part of the reach."""
        return float(self.arm.task_error(q, self._targets).max(initial=0.0)) / self.arm.reach

    def margins(self, q: FloatArray) -> FloatArray:
        """Return by how much any postures (k, n) keep the constraints, shape (k, m), in their scales."""
        found = [constraint.margins(q) / constraint.scale for constraint in self.constraints]
        return np.concatenate([*found, np.empty((len(q), 0))], axis=1)

    def margin_gradients(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return :meth:`margins` and their gradients by the joints, shape (k, m, n)."""
        found = [(constraint.gradients(q), constraint.scale) for constraint in self.constraints]
        margins = [m / scale for (m, _), scale in found]
        gradients = [g / scale for (_, g), scale in found]
        none = np.empty((len(q), 0, self.arm.n))
        return np.concatenate([*margins, none[..., 0]], axis=1), np.concatenate([*gradients, none], axis=1)

    @cached_property
    def share(self) -> FloatArray:
        """What part of the path is nearest to each collocation point, shape (k,)."""
        middle = 0.5 * (self.points[1:] + self.points[:-1])
        return np.diff(np.concatenate([[0.0], middle, [1.0]]))

    def density(self, c: FloatArray) -> Smoothed:
        """Return the objective at the quadrature nodes, with its derivatives by the rates."""
        return self.objective.smoothed(self.rates(c), self.weights, self.width)

    def cost(self, c: FloatArray) -> float:
        """Return the cost of the spline, by quadrature."""
        return float(self.space.weights @ self.density(c).value)

    def gradient(self, density: Smoothed) -> FloatArray:
        """Return the derivative of :meth:`cost` with respect to the unknowns, shape (n, f)."""
        return self._gather(density.gradient)

    def stiffness(self, diagonal: FloatArray, mass: float) -> FloatArray:
        """Return the matrices ``∫ d_i B'ᵀB' dr + mass ∫ BᵀB dr`` of all joints, shape (n, f, f).

        Parameters
        ----------
        diagonal : array, shape (g, n)
            d at the quadrature nodes.
        mass : float
        """
        first, local = self.space.local
        weighted = (self.space.weights[:, None] * diagonal).reshape(*local.shape[:2], -1)
        element = np.einsum("ega,egi,egb->iabe", local, weighted, local, optimize=True)
        full = np.zeros((self.arm.n, self.space.m, self.space.m))
        for a in range(local.shape[2]):
            for b in range(local.shape[2]):
                full[:, first + a, first + b] += element[:, a, b]
        folded = self._fold(np.swapaxes(self._fold(full), 1, 2))
        return np.swapaxes(folded, 1, 2) + mass * self._mass

    def curvature(self, density: Smoothed, direction: FloatArray, more: FloatArray | float = 0.0) -> FloatArray:
        """Return the Hessian of :meth:`cost` times `direction` (n, f), with `more` (g, n) on the density's diagonal."""
        rates = self._slopes @ direction.T
        return self._gather(density.times(rates) + more * rates)

    def at_points(self, matrices: FloatArray) -> FloatArray:
        """Return ``C M Cᵀ`` for symmetric matrices M (n, f, f), C being :attr:`values`; shape (n, k, k)."""
        # C has a few entries per row; a sparse product from either side leaves the order of the axes as it wants it.
        n, f, _ = matrices.shape
        k = len(self.points)
        half = self._sparse_values @ matrices.transpose(1, 0, 2).reshape(f, n * f)
        whole = self._sparse_values @ half.reshape(k, n, f).transpose(2, 1, 0).reshape(f, n * k)
        return np.asarray(whole).reshape(k, n, k).transpose(1, 0, 2)

    def _gather(self, at_nodes: FloatArray) -> FloatArray:
        return (self.space.weights[:, None] * at_nodes).T @ self._slopes
