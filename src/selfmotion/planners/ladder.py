"""The plain ladder: the cheapest chain of postures on a fixed grid of u, without refinement and without any bound.

It is what many programs do, and is here to be compared with: Bellman's dynamic programming over the path's points,
whose rungs are the inverse kinematics at even values of u on every branch.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from selfmotion._checks import integer
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import JointLimits, RedundantArm
from selfmotion.arms.limits import ON_LIMIT
from selfmotion.arms.protocols import u_period
from selfmotion.constrained import keeps_constraints
from selfmotion.errors import InvalidInputError, NothingFeasibleError
from selfmotion.mending.filling import filled
from selfmotion.problem import Problem, postures_of

MOST_VALUES = 10_000
_AT_ONCE = 2_000_000  # steps between two rungs that are judged at once


@dataclass(frozen=True)
class LadderMotion:
    """The cheapest chain of postures that a ladder found.

    Attributes
    ----------
    r : array, shape (k,)
        The path's given points, or its samples if it has none.
    q : array, shape (k, n)
        Joint angles, those of free joints continuous [rad].
    values : int
        How many values of u were tried on every branch.
    cost_sampled : float
        The objective's chord sum, weighted.
    jumps : tuple of int
        Steps of more than 0.06 rad that no continuous motion explains, by the row before them, counted from 0: halved
        again and again with the tool on the path, they do not get shorter, or a posture half-way is forbidden.
    postures : int
        Of all rungs together.
    seconds : float
    """

    r: FloatArray
    q: FloatArray
    values: int
    cost_sampled: float
    jumps: tuple[int, ...]
    postures: int
    seconds: float


def ladder(problem: Problem, values: int) -> LadderMotion:
    """Return the cheapest chain of postures on a grid of u.

    Parameters
    ----------
    problem : Problem
        Of an arm with one redundant degree. Start, end and branch are kept; that a cyclic motion closes is not.
    values : int
        Number of even values of u on [−π, π), on every branch that may be used.

    Returns
    -------
    LadderMotion
        Of these postures, all of which keep the arm's constraints, the cheapest chain. It need not be a motion: a step
        may jump.

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy, or the number is out of range.
    NothingFeasibleError
        If a rung is empty; with more values it need not be.

    Notes
    -----
    ``V_{i+1}(q') = min_q V_i(q) + c(q' − q, r_{i+1} − r_i)`` over all pairs, c being the objective's chord. Joints that
    can turn all the way round are free in it, and moved into their limits as a whole afterwards, if that can be.
    """
    began = time.perf_counter()
    if problem.arm.n_u != 1:
        reason = f"has {problem.arm.n_u} redundant degrees, and a ladder is for one"
        raise InvalidInputError("arm", reason, "use planner refine")
    count = integer("values", values, 1, MOST_VALUES)
    r = problem.path.waypoints if len(problem.path.waypoints) > 1 else problem.grid
    rungs = _rungs(problem, r, count)
    cheapest, before = np.zeros(len(rungs[0])), []
    for k in range(len(r) - 1):
        cheapest, best = _climbed(problem, cheapest, rungs[k], rungs[k + 1], float(r[k + 1] - r[k]))
        before.append(best)
    at = int(np.argmin(cheapest))
    way = [at]
    for best in reversed(before):
        way.append(int(best[way[-1]]))
    limits = problem.arm.limits
    q = np.array([rung[k] for rung, k in zip(rungs, reversed(way), strict=True)])
    first = None if problem.start is None else problem.start.q
    q = np.where(wide(limits), limits.lift(q[None], first).q[0], q)
    cost = float(problem.objective.sampled(q, r, problem.weights))
    seconds = time.perf_counter() - began
    return LadderMotion(r, q, count, cost, tuple(filled(problem, r, q).broken), sum(map(len, rungs)), seconds)


def _rungs(problem: Problem, r: FloatArray, count: int) -> list[FloatArray]:
    """Return the postures at each of the path parameters, shape (m, n) each."""
    arm, u = problem.arm, _values(problem.arm, count)
    given = {0: problem.start, len(r) - 1: problem.end}
    rungs = []
    for k, x in enumerate(problem.path(r)):
        posture = given.get(k)
        if posture is None:
            solved = [arm.solve(x, u[:, None], branch) for branch in problem.elbow_branches]
            q = np.concatenate([some[ok] for some, ok in solved])
        else:
            q = postures_of(problem, posture, float(r[k]))
        rung = turned(arm.limits, q)
        rung = rung[keeps_constraints(arm, rung)]
        if not len(rung):
            raise NothingFeasibleError(
                f"none of {count} values of u is feasible at r = {r[k]:.6g}", "try more values", count, 1.0
            )
        rungs.append(rung)
    return rungs


def _values(arm: RedundantArm, count: int) -> FloatArray:
    """Return values of u, (count,): all round, or where it is a length between its limits, ends included."""
    if u_period(arm) == TAU:
        return np.linspace(-np.pi, np.pi, count, endpoint=False)
    low, high = arm.limits.lower[arm.limits.slides][0], arm.limits.upper[arm.limits.slides][0]
    return np.linspace(low, high, count)


def wide(limits: JointLimits) -> BoolArray:
    """Return which joints can take every angle modulo 2π, shape (n,): free ones, and those with limits so far apart."""
    return limits.upper - limits.lower >= limits.period


def turned(limits: JointLimits, q: FloatArray) -> FloatArray:
    """Return those of the postures (m, n) that whole turns put inside the limits of joints not wide, so put."""
    for j in np.flatnonzero(~wide(limits)):
        turns = np.ceil((limits.lower[j] - ON_LIMIT - q[:, j]) / limits.period[j])
        q = q + limits.period[j] * turns[:, None] * (np.arange(q.shape[1]) == j)
        q = q[q[:, j] <= limits.upper[j] + ON_LIMIT]
    return q


def _climbed(
    problem: Problem, cheapest: FloatArray, below: FloatArray, above: FloatArray, dr: float
) -> tuple[FloatArray, IntArray]:
    """Return what every posture above costs at least, and from which one below."""
    found, best = np.empty(len(above)), np.empty(len(above), np.intp)
    free = np.flatnonzero(wide(problem.arm.limits))
    block = max(1, _AT_ONCE // (len(below) * problem.arm.n))
    for first in range(0, len(above), block):
        part = above[first : first + block]
        steps = part[:, None] - below[None]
        steps[..., free] = wrap(steps[..., free])
        cost = cheapest + problem.objective.chord(steps, np.full(steps.shape[:2], dr), problem.weights)
        chosen = np.argmin(cost, axis=1)
        best[first : first + block] = chosen
        found[first : first + block] = cost[np.arange(len(part)), chosen]
    return found, best
