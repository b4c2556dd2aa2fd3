"""Newton's method on the motions that keep the task: interior point, preconditioned conjugate gradients, trust region.

Let c be the unknowns, f(c) the tool at the collocation points, F the cost. With a logarithmic barrier for the limits,

    φ(c) = F(c) − μ Σ log(c − lower) − μ Σ log(upper − c),    f(c) = x,

every iterate keeps f(c) = x: a step d is tangent, ``A d = 0`` with A = ∂f/∂c, and is then carried back to the task.
It minimises ``gᵀd + ½ dᵀHd``, H being the Hessian of the Lagrangian ``φ − λᵀ(f − x)`` with the barrier's part
replaced by the primal-dual one (Wächter, Biegler 2006), by the conjugate gradients of Steihaug (1983) projected onto
the tangents (Gould, Hribar, Nocedal 2001). The preconditioner P is H without the curvature of the task, plus the mass
matrix, which makes it regular: one matrix per joint, coupled by the task alone (:mod:`selfmotion.refinement.linear`).
Further constraints on postures, m(q) ≥ 0, enter φ at the collocation points by a relaxed barrier; their curvature,
primal-dual too, is in H, and in P as soft rows (:mod:`selfmotion.refinement.walls`).
What P leaves out is of order zero where P is of order two in d/dr; so the number of inner steps
does not grow with the number of knots, and an iteration costs O(n). Densities with kinks have a part of their majorant
added to H and P.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.refinement.collocation import Collocation
from selfmotion.refinement.linear import Linear, linear_at
from selfmotion.refinement.walls import Wall, Walls

_ON_TASK = 1e-13  # tracking at the collocation points, as a part of the reach: rounding of some links' sum
_LOST = 1e-10  # tracking beyond which a start is given up
_AT_LIMIT = 1e-100  # square of a distance from a limit that is as good as none
_TO_LIMIT = 0.99  # part of the way to a limit that one step may go; all of it would end on the barrier's pole
_TOWARDS_LIMIT = 0.9  # the same of steps towards the task, whose barrier is only there to keep clear of limits
_BOLDEST = 0.5  # largest change of a joint in one step towards the task [rad]: beyond, sines are far from linear
_MOST_TO_TASK = 60  # such steps; ten are usual
_DAMPING = 0.1  # part of the majorant of a density with kinks that its Hessian is given; none and all are slower
_MASS = 1.0  # of the mass matrix in P, for weights of 1: about as much as the task's curvature, which P leaves out
_INNER = 80  # conjugate gradient steps; fewer than ten are usual
_WANTED = 0.1  # part of the first residual's square at which they stop, times at most …
_WANTED_FAR = 1e-2  # … this far from the minimum, and less near it, so that Newton's steps converge superlinearly
_CORRECTIONS = 12  # steps back to the task; it is reached in three or too far
_SHRINK = 0.15  # of μ, whenever its minimum is reached to a tenth of it
_NOISE = 1e-14  # part of the cost that is rounding
_STUCK = 1e-9  # radius of the trust region below which nothing more is gained
_MULTIPLIER = 1e8  # times that limits' multipliers may be off their central values (Wächter, Biegler 2006)
# The trust region (Conn, Gould, Toint 2000, 6.1.1): parts of what the model promised at which a step is taken at all,
# at which the region shrinks and at which it grows, and how it does.
_ACCEPT, _POOR, _GOOD = 0.05, 0.25, 0.75
_GROW, _LESS, _AFTER_FAILURE = 2.5, 0.4, 0.3
_EDGE = 1e-3  # a start that leaves the limits is moved inside by this part of their width
_LEAST_EDGE = 1e-10  # but by no less than this, unless they leave less room [rad]


class Minimum(NamedTuple):
    """Where the search ended.

    Attributes
    ----------
    c : array, shape (n, f)
        Unknowns.
    cost : float
    iterations : int
    converged : bool
        Whether the Newton decrement is below what was asked for; else iterations or time ran out, nothing was gained
        any more, a constraint on postures cannot be kept, or matrices became singular.
    """

    c: FloatArray
    cost: float
    iterations: int
    converged: bool


class _Barrier:
    """Distances of the unknowns to their limits, the multipliers of the limits, and the walls, if there are any."""

    def __init__(self, problem: Collocation, c: FloatArray, mu: float) -> None:
        self.lower, self.upper = problem.box.lower[:, None], problem.box.upper[:, None]
        finite = np.isfinite(np.stack([self.lower, self.upper]))
        self.walls = Walls(problem, c, mu) if problem.constraints else None
        self.count = int(finite.sum()) * c.shape[1] + (0 if self.walls is None else self.walls.count)
        self.z = np.where(finite, mu / self.distances(c), 0.0)

    def distances(self, c: FloatArray) -> FloatArray:
        """Return how far the unknowns are from the lower and the upper limits, shape (2, n, f); infinite if free."""
        return np.stack([c - self.lower, self.upper - c])

    def value(self, c: FloatArray, mu: float) -> float:
        """Return the barrier at c, infinite outside."""
        a = self.distances(c)
        if not (a > 0).all():
            return np.inf
        limits = -mu * float(np.log(a[np.isfinite(a)]).sum())
        return limits if self.walls is None else limits + self.walls.value(c, mu)

    def gradient(self, c: FloatArray, mu: float) -> FloatArray:
        """Return the derivative of :meth:`value`, without the walls."""
        a = mu / self.distances(c)
        return np.asarray(a[1] - a[0])

    def curvature(self, c: FloatArray) -> FloatArray:
        """Return the primal-dual diagonal, shape (n, f)."""
        return np.asarray((self.z / self.distances(c)).sum(axis=0))

    def room(self, c: FloatArray, d: FloatArray) -> float:
        """Return the largest t for which c + t d is inside."""
        speed = np.stack([-d, d])
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(np.where(speed > 0, self.distances(c) / speed, np.inf).min())

    def part(self, c: FloatArray, d: FloatArray, wall: Wall | None, mu: float) -> float:
        """Return what part of a step d may be gone, at most all of it."""
        part = min(1.0, _TO_LIMIT * self.room(c, d))
        return part if self.walls is None or wall is None else min(part, self.walls.room(wall, c, d, mu))

    def is_stuck(self, wall: Wall | None, mu: float) -> bool:
        """Return whether a constraint on postures cannot be kept."""
        return self.walls is not None and wall is not None and self.walls.is_stuck(wall, mu)

    def advance(self, c: FloatArray, d: FloatArray, after: FloatArray, wall: Wall | None, mu: float) -> None:
        """Move the multipliers along with a step d from c to `after`."""
        if self.walls is not None and wall is not None:
            self.walls.advance(wall, d, after, mu)
        a = self.distances(c)
        change = mu / a - self.z - self.z / a * np.stack([d, -d])
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(change < 0, -self.z / change, np.inf).min(initial=np.inf)
        self.z += min(1.0, _TO_LIMIT * room) * change
        centred = mu / self.distances(after)
        self.z = np.clip(self.z, centred / _MULTIPLIER, centred * _MULTIPLIER)


class _Iterate:
    """The quadratic model of φ on the motions that keep the task, at c."""

    def __init__(self, problem: Collocation, barrier: _Barrier, c: FloatArray, mu: float) -> None:
        self.problem = problem
        self._density = problem.density(c)
        # Beside a kink the density is all but linear: Newton's steps would be far too long there.
        self._damping = _DAMPING * self._density.majorant if problem.objective.has_kinks else np.zeros(1)
        self._limits = barrier.curvature(c)
        self._q = problem.postures(c)
        stiff = problem.stiffness(self._density.diagonal + self._damping, _MASS * float(problem.weights.max()))
        self.wall = None if barrier.walls is None else barrier.walls.at(self._q, mu)
        soft = None if self.wall is None else self.wall.soft
        self.linear = linear_at(problem, self._q, _with_diagonal(stiff, self._limits), soft)
        slope = problem.gradient(self._density) + barrier.gradient(c, mu)
        if self.wall is not None:
            slope -= self.wall.pull.T @ problem.values
        self._multipliers = self.linear.multipliers(slope)
        self.gradient = slope - self.linear.transposed(self._multipliers)
        self.decrement = float((self.gradient * self.linear.tangent(self.gradient)).sum())

    def hessian(self, d: FloatArray) -> FloatArray:
        """Return H d."""
        values = self.problem.values
        moved = values @ d.T
        bent = self.problem.arm.jacobian_rate(self._q, moved)
        task = (bent * self._multipliers[:, :, None]).sum(axis=1).T @ values
        if self.wall is not None:
            task -= (self.wall.curvature @ moved[:, :, None])[:, :, 0].T @ values
        return self.problem.curvature(self._density, d, self._damping) + self._limits * d - task

    def promised(self, step: FloatArray) -> float:
        """Return by how much the model falls along `step`."""
        return -float((self.gradient * step).sum() + 0.5 * (step * self.hessian(step)).sum())

    def step(self, radius: float) -> tuple[FloatArray, bool]:
        """Return the tangent step that minimises the model within `radius`, and whether it ends on the edge."""
        linear = self.linear
        step, residual = np.zeros_like(self.gradient), self.gradient.copy()
        steepest = linear.tangent(residual)
        direction = -steepest
        product = float((residual * steepest).sum())
        wanted = _WANTED * product * min(_WANTED_FAR, np.sqrt(product))
        for _ in range(_INNER):
            bent = self.hessian(direction)
            curvature = float((direction * bent).sum())
            length = product / curvature if curvature > 0 else np.inf
            room = linear.to_edge(step, direction, radius)
            if length >= room:
                return step + room * direction, True
            step = step + length * direction
            residual = residual + length * bent
            steepest = linear.tangent(residual)
            product, before = float((residual * steepest).sum()), product
            if product <= wanted:
                break
            direction = product / before * direction - steepest
        return step, False


def minimise(
    problem: Collocation,
    coefficients: FloatArray,
    tolerance: float = 1e-10,
    mu: float = 1e-2,
    most: int = 200,
    deadline: float = np.inf,
) -> Minimum | None:
    """Find the motion of least cost near a given one.

    Parameters
    ----------
    problem : Collocation
    coefficients : array, shape (n, m)
        Spline to start from. It need keep neither task nor limits; it is moved to both first. Nor need it keep further
        constraints.
    tolerance : float
        Part of the cost by which the answer may exceed the local minimum of the discretised problem.
    mu : float
        First weight of the barrier.
    most : int
        Largest number of iterations.
    deadline : float
        Time of :func:`time.perf_counter` after which no further iteration is begun.

    Returns
    -------
    Minimum or None
        None if no motion near the given one keeps task, limits and further constraints at the collocation points.
    """
    c = _to_task(problem, _inside(problem, problem.unknowns(coefficients)), mu)
    if c is None:
        return None
    barrier = _Barrier(problem, c, mu)
    floor = tolerance * max(problem.cost(c), 1e-300)
    least = floor / barrier.count if barrier.count else mu
    radius, iteration, converged = 1.0, 0, False
    while iteration < most and time.perf_counter() < deadline:
        try:
            iterate = _Iterate(problem, barrier, c, mu)
        except np.linalg.LinAlgError:  # beyond what doubles can tell apart: the last motion stands
            break
        if iterate.decrement <= max(floor, 0.1 * mu if barrier.count else 0.0):
            converged = mu <= least
            if converged or barrier.is_stuck(iterate.wall, mu):
                break
            mu = max(_SHRINK * mu, least)
            continue
        iteration += 1
        step, at_edge = iterate.step(radius)
        step *= barrier.part(c, step, iterate.wall, mu)
        before, promised = problem.cost(c) + barrier.value(c, mu), iterate.promised(step)
        after = _carried(problem, iterate.linear, c + step)
        gained = -np.inf if after is None else before - problem.cost(after) - barrier.value(after, mu)
        if after is not None and (gained > _ACCEPT * promised or abs(gained) <= _NOISE * abs(before)):
            barrier.advance(c, step, after, iterate.wall, mu)
            c = after
            if at_edge and gained > _GOOD * promised:
                radius *= _GROW
            elif gained < _POOR * promised:
                radius *= _LESS
        else:
            radius = _AFTER_FAILURE * min(radius, np.sqrt(iterate.linear.product(step, step)))
            if radius < _STUCK:
                break
    broken = barrier.walls is not None and barrier.walls.broken(c)
    return None if broken else Minimum(c, problem.cost(c), iteration, converged)


def _with_diagonal(matrices: FloatArray, diagonal: FloatArray) -> FloatArray:
    index = np.arange(diagonal.shape[1])
    matrices[:, index, index] += diagonal
    return matrices


def _inside(problem: Collocation, c: FloatArray) -> FloatArray:
    """Return unknowns moved strictly inside the limits."""
    lower, upper = problem.box.lower[:, None], problem.box.upper[:, None]
    with np.errstate(invalid="ignore"):
        width = np.where(np.isfinite(upper - lower), upper - lower, 1.0)
    edge = np.minimum(0.5 * width, np.maximum(_EDGE * width, _LEAST_EDGE))
    return np.clip(c, lower + edge, upper - edge)


def _to_task(problem: Collocation, c: FloatArray, mu: float) -> FloatArray | None:
    """Return motion c moved onto the task inside the limits, by Newton steps that are short near the limits."""
    nodes = np.ones((len(problem.space.nodes), problem.arm.n))
    plain, barrier = problem.stiffness(nodes, 1.0), _Barrier(problem, c, mu)
    for _ in range(_MOST_TO_TASK):
        q = problem.postures(c)
        if problem.miss(q) <= _ON_TASK:
            return c
        near = mu / np.maximum(np.square(barrier.distances(c)).min(axis=0), _AT_LIMIT)
        try:
            linear = linear_at(problem, q, _with_diagonal(plain.copy(), near))
        except np.linalg.LinAlgError:
            return None
        step = linear.towards(problem.lack(q))
        boldest = np.abs(problem.values @ step.T).max(initial=1e-300)
        c = c + min(1.0, _TOWARDS_LIMIT * barrier.room(c, step), _BOLDEST / boldest) * step
    return c if problem.miss(problem.postures(c)) <= _LOST else None


def _carried(problem: Collocation, linear: Linear, c: FloatArray) -> FloatArray | None:
    """Return c carried back onto the task by least steps in the metric of the last iterate; None if it is too far."""
    before = np.inf
    for _ in range(_CORRECTIONS):
        q = problem.postures(c)
        miss = problem.miss(q)
        if miss <= _ON_TASK:
            return c
        if miss > 0.5 * before:
            if before <= 100 * _ON_TASK:
                return c
            break
        if miss > 0.05 * before:  # the old linearisation has done its duty
            try:
                linear = linear.at(q)
            except np.linalg.LinAlgError:
                break
        before = miss
        c = c + linear.towards(problem.lack(q))
    return None
