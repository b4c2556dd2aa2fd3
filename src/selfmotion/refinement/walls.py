"""Further constraints on postures in Newton's method: a relaxed logarithmic barrier on their margins.

An arm's ``constraints`` say of postures by how much they hold, m(q) ≥ 0. At every collocation point each margin adds

    μ b(m),    b(m) = −log m for m > δ,    b(m) = ½ ((m − 2δ)²/δ² − 1) − log δ below

to φ (Hauser, Saccon 2006): twice continuously differentiable and finite everywhere, so that a start may break a
constraint and is pushed out. δ shrinks with μ, so that what is left of a breach goes to zero too.

Inside, the Hessian has the primal-dual weight z/m in the place of μ/m² (Wächter, Biegler 2006), below δ its own μ/δ²,
and ``−Σ z ∇²m`` by differences of the gradients. As μ → 0 the weights of what the motion touches grow without bound:
these rows are in the metric too, as soft rows (:mod:`selfmotion.refinement.linear`), so that the number of inner steps
does not grow with them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.refinement.collocation import Collocation
from selfmotion.refinement.linear import SoftRows

_FIRM = 1e2  # most of μ/δ: multipliers up to twice that leave no breach, and greater ones one of the order of δ
_FIRM_AT_FIRST = 0.1  # by √μ: the same for starts that break a constraint, by so much perhaps that the push is too hard
_TO_WALL = 0.99  # part of the way to where a margin vanishes that one step may go, to first order
_LOOK, _MOST_LOOKS = 0.05, 8  # changes of a joint [rad] between looks on the way of a step, and how many there are
_MULTIPLIER = 1e8  # times that multipliers may be off their central values, as those of limits
_SOFT_ROWS = 3  # margins of a point that enter the metric; they are few that matter at once
_FELT = 0.1  # part of the mass matrix below which a margin's curvature need not be in the metric
_PULLS = 1e-3  # part of the strongest pull below which a point's margins count as straight
_BROKEN = 1e-4  # of a margin's scale: breaches that are no matter of rounding or of a last step
_STUCK = 100.0  # times δ: breaches whose pull is so much greater than that of margins that hold
_STEP = 1e-6  # of the difference that curvatures of margins are taken by [rad]


class Wall(NamedTuple):
    """The barrier's quadratic model about one motion, with k postures and m margins each.

    Attributes
    ----------
    margins, gradients : array, shape (k, m) and (k, m, n)
    pull : array, shape (k, n)
        Minus its gradient by the postures.
    curvature : array, shape (k, n, n)
        Its Hessian by each posture, primal-dual.
    soft : SoftRows
        What of the latter is for the metric.
    """

    margins: FloatArray
    gradients: FloatArray
    pull: FloatArray
    curvature: FloatArray
    soft: SoftRows


class Walls:
    """The relaxed barrier of the constraints on postures, and their multipliers.

    Parameters
    ----------
    problem : Collocation
    c : array, shape (n, f)
    mu : float
    """

    def __init__(self, problem: Collocation, c: FloatArray, mu: float) -> None:
        self.problem = problem
        margins = self._margins(c)
        self.count = margins.size
        self._gentle = bool((margins < 0.0).any())
        self.z = self._force(margins, mu)

    def relaxed_below(self, mu: float) -> float:
        """Return the δ of a barrier of weight μ."""
        # Through a wide δ a clear motion could slip across what is thin; one that is not clear is to be led out gently.
        return mu / (min(_FIRM, max(1.0, _FIRM_AT_FIRST / np.sqrt(mu))) if self._gentle else _FIRM)

    def value(self, c: FloatArray, mu: float) -> float:
        """Return the barrier at c."""
        m, delta = self._margins(c), self.relaxed_below(mu)
        below = 0.5 * (np.square(m / delta - 2.0) - 1.0) - np.log(delta)
        return mu * float(np.where(m > delta, -np.log(np.maximum(m, delta)), below).sum())

    def at(self, q: FloatArray, mu: float) -> Wall:
        """Return the model about postures q (k, n)."""
        m, gradients = self.problem.margin_gradients(q)
        m -= self.problem.shift
        pull = np.einsum("km,kmn->kn", self._force(m, mu), gradients)
        weights = self._weights(m, mu)
        curvature = np.einsum("km,kma,kmb->kab", weights, gradients, gradients) - self._bend(q, gradients, pull)
        return Wall(m, gradients, pull, curvature, self._soft(weights, gradients))

    def room(self, wall: Wall, c: FloatArray, d: FloatArray, mu: float) -> float:
        """Return the part of a step d from c, at most all of it, that stays clear of what it is clear of now.

        To first order, and as far as looks on the way tell: a step may be longer than an obstacle is thick.
        """
        speed, clear = -self._along(wall, d), wall.margins > self.relaxed_below(mu)
        with np.errstate(divide="ignore", invalid="ignore"):
            to_wall = np.where((speed > 0) & clear, wall.margins / speed, np.inf)
        part = min(1.0, _TO_WALL * float(to_wall.min(initial=np.inf)))
        boldest = float(np.abs(self.problem.values @ d.T).max(initial=0.0)) * part
        looks = min(int(boldest / _LOOK), _MOST_LOOKS)
        for look in range(1, looks + 1):
            if (self._margins(c + part * look / (looks + 1) * d)[clear] <= 0.0).any():
                return part * (look - 0.5) / (looks + 1)
        return part

    def advance(self, wall: Wall, d: FloatArray, after: FloatArray, mu: float) -> None:
        """Move the multipliers along with a step d to the unknowns `after`."""
        m = np.maximum(wall.margins, self.relaxed_below(mu))
        change = self._force(wall.margins, mu) - self.z - self.z / m * self._along(wall, d)
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(change < 0, -self.z / change, np.inf).min(initial=np.inf)
        self.z += min(1.0, _TO_WALL * room) * change
        centred = self._force(self._margins(after), mu)
        self.z = np.clip(self.z, centred / _MULTIPLIER, centred * _MULTIPLIER)

    def broken(self, c: FloatArray) -> bool:
        """Return whether a constraint is broken by more than finer knots could mend."""
        return bool((self._margins(c) < -_BROKEN).any())

    def is_stuck(self, wall: Wall, mu: float) -> bool:
        """Return whether the minimum for a weight μ breaks a constraint although it is pulled at as hard as can be."""
        return bool((wall.margins < -max(_STUCK * self.relaxed_below(mu), _BROKEN)).any())

    def _force(self, m: FloatArray, mu: float) -> FloatArray:
        """Return minus the barrier's derivative by the margins."""
        delta = self.relaxed_below(mu)
        return np.where(m > delta, mu / np.maximum(m, delta), mu * (2.0 * delta - m) / delta**2)

    def _margins(self, c: FloatArray) -> FloatArray:
        """Return by how much the margins at the collocation points exceed the shift, shape (k, m)."""
        return self.problem.margins(self.problem.postures(c)) - self.problem.shift

    def _along(self, wall: Wall, d: FloatArray) -> FloatArray:
        """Return how margins change along d, shape (k, m)."""
        return np.asarray((wall.gradients @ (self.problem.values @ d.T)[:, :, None])[:, :, 0])

    def _weights(self, m: FloatArray, mu: float) -> FloatArray:
        """Return the second derivatives by the margins, shape (k, m): primal-dual, but where the barrier is relaxed."""
        delta = self.relaxed_below(mu)
        return np.where(m > delta, self.z / np.maximum(m, delta), mu / delta**2)

    def _bend(self, q: FloatArray, gradients: FloatArray, pull: FloatArray) -> FloatArray:
        """Return ``Σ z ∇²m`` at each posture, by differences, where it is not small."""
        k, n = q.shape
        bend = np.zeros((k, n, n))
        strength = np.abs(pull).max(axis=1)
        felt = np.flatnonzero(strength > _PULLS * strength.max(initial=0.0))
        if len(felt):
            near = (q[felt, None, :] + _STEP * np.eye(n)).reshape(-1, n)
            there = self.problem.margin_gradients(near)[1].reshape(len(felt), n, -1, n)
            found = np.einsum("km,kjmn->kjn", self.z[felt], there - gradients[felt][:, None]) / _STEP
            bend[felt] = 0.5 * (found + np.swapaxes(found, 1, 2))
        return bend

    def _soft(self, weights: FloatArray, gradients: FloatArray) -> SoftRows:
        """Return the margins of each point that are felt most, for the metric."""
        felt = weights * np.square(gradients).sum(axis=2)
        needed = felt > _FELT * self.problem.share[:, None]
        most = min(_SOFT_ROWS, int(needed.sum(axis=1).max(initial=0)))
        chosen = np.argsort(-felt, axis=1, kind="stable")[:, :most]
        matters = np.take_along_axis(needed, chosen, axis=1)
        rows = np.take_along_axis(gradients, chosen[:, :, None], axis=1)
        return SoftRows(rows, np.where(matters, np.take_along_axis(weights, chosen, axis=1), 0.0))
