"""Motions among obstacles found without any bound: cheapest ways through dense grids of the self-motion.

Rungs are all allowed postures at places along the path, from inverse kinematics of the arm without constraints, sifted
by an oracle that shares nothing with the package's. The cheapest way is made finer around itself. A way becomes a
motion only where Newton's method puts what is between its rungs onto the path, within limits and clear of everything.
"""

import numpy as np
from brute_force import _with_turns
from soundness_spatial import choose, cost_of, neighbours

import selfmotion as sm
from selfmotion.arms.protocols import u_steps
from selfmotion.errors import SelfMotionError

WIDEST = 0.35  # step of a ladder, joint by joint [rad]
_PARTS = 16  # of a step of a way
_FINER = 3
_NEWTON = 8
_EXACT = 1e-11  # of the reach
_FAR = 0.2  # that a posture may be moved to get onto the path [rad]
_TURN = 2 * np.pi


class Rungs:
    """Allowed postures of a problem at places along its path.

    Parameters
    ----------
    problem : Problem
    oracle : Clearances
    count : int
        Values of the redundancy parameter.
    """

    def __init__(self, problem, oracle, count):
        self.problem, self.oracle = problem, oracle
        self.arm = oracle.arm
        low, high = getattr(self.arm, "parameter_range", (-np.pi, np.pi))
        self.u, self.width = np.linspace(low, high, count, endpoint=False), 2 * (high - low) / count
        limits = self.arm.limits
        self.modulo = ~(np.isfinite(limits.lower) & np.isfinite(limits.upper))

    def at(self, r, u):
        """Allowed postures (k, n) at r whose parameter is one of `u`, or what the problem gives for an end."""
        for name, end in (("start", 0.0), ("end", 1.0)):
            given = getattr(self.problem, name)
            if given is not None and r == end:
                if given.q is not None:
                    return given.q[None]
                u = np.asarray(given.u)
        x, found = np.broadcast_to(self.problem.path(r), (len(u), len(self.problem.path(r)))), []
        for branch in self.problem.elbow_branches:
            q, ok = self.arm.solve(x, u[:, None], branch)
            q, ok, _ = _with_turns(self.arm.limits, 0.0, q, ok)
            found.append(q[ok])
        q = np.concatenate(found)
        return q[self.oracle.allowed(q)]

    def way(self, r, rungs):
        """The cheapest way through rungs, or None."""
        costs, back, problem = np.zeros(len(rungs[0])), [], self.problem
        for k in range(1, len(rungs)):
            if not len(rungs[k]) or not len(rungs[k - 1]):
                return None
            best, where = np.full(len(rungs[k]), np.inf), np.zeros(len(rungs[k]), int)
            pairs = neighbours(rungs[k - 1], rungs[k], self.modulo)
            if len(pairs):
                step = rungs[k][pairs[:, 1]] - rungs[k - 1][pairs[:, 0]]
                step[:, self.modulo] -= _TURN * np.rint(step[:, self.modulo] / _TURN)
                total = problem.objective.chord(step, np.full(len(step), r[k] - r[k - 1]), problem.weights)
                choose(pairs, costs[pairs[:, 0]] + total, best, where)
            costs = best
            back.append(where)
        if not np.isfinite(costs).any():
            return None
        at = int(costs.argmin())
        way = [rungs[-1][at]]
        for k in range(len(back) - 1, -1, -1):
            at = int(back[k][at])
            way.append(rungs[k][at])
        found = np.array(way[::-1])
        found[:, self.modulo] = np.unwrap(found[:, self.modulo], axis=0)
        return found

    def near(self, r, way, width):
        """Rungs about a way."""
        u, found = self.arm.u_of(way)[:, 0], []
        for k, at in enumerate(r):
            near = self.at(at, u[k] + np.linspace(-width, width, 21))
            apart = near - way[k]
            apart[:, self.modulo] -= _TURN * np.rint(apart[:, self.modulo] / _TURN)
            found.append(np.concatenate([near[np.abs(apart).max(axis=1) < 0.5], way[k : k + 1]]))
        return found


def settled(arm, path, q, r):
    """Postures (k, n) put onto the path by Newton's method; None if that fails."""
    x, was = path(r), q
    for _ in range(_NEWTON):
        residual, jacobian = arm.task_residual(q, x), arm.jacobian(q)
        q = q + np.einsum("kij,kj->ki", np.linalg.pinv(jacobian), residual)
    good = arm.task_error(q, x).max() < _EXACT * arm.reach and np.abs(q - was).max() < _FAR
    return q if good else None


def verified(problem, oracle, r, q):
    """What a motion through postures costs at most; infinite if it does not hold."""
    fine = np.interp(np.arange((len(r) - 1) * _PARTS + 1) / _PARTS, np.arange(len(r)), r)
    between = np.stack([np.interp(fine, r, joint) for joint in q.T], axis=-1)
    found = settled(oracle.arm, problem.path, between, fine)
    limits = oracle.arm.limits
    real = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    if found is None or (limits.excess(found)[:, real] > 0).any() or not oracle.allowed(found).all():
        return np.inf
    if problem.elbow != "any" and not oracle.arm.is_on_branch(found, problem.elbow, 1e-9).all():
        return np.inf
    if not _ends(problem, found):
        return np.inf
    cost, more = cost_of(problem, fine, found)
    return cost + more


def _ends(problem, q):
    for given, posture in ((problem.start, q[0]), (problem.end, q[-1])):
        if given is not None and np.abs(u_steps(problem.arm, given.u, problem.arm.u_of(posture))).max() > 1e-9:
            return False
    return True


def climbed(problem, oracle, count, places=61):
    """What the best motion along a ladder costs; infinite without one, or of motions that close."""
    if problem.cyclic:
        return np.inf
    rungs, r = Rungs(problem, oracle, count), np.unique(np.append(np.linspace(0.0, 1.0, places), problem.path.breaks))
    way, best, width = rungs.way(r, [rungs.at(at, rungs.u) for at in r]), np.inf, rungs.width
    for _ in range(_FINER):
        if way is None:
            break
        best = min(best, verified(problem, oracle, r, way))
        way = rungs.way(r, rungs.near(r, way, width))
        width /= 5
    return best if way is None else min(best, verified(problem, oracle, r, way))


def refined(problem, oracle, seed, seconds):
    """What the package's local planner finds, looked at by the oracle."""
    try:
        plan = sm.plan(problem, sm.Refine(starts=3, seed=seed, time_limit=seconds))
    except SelfMotionError:
        return np.inf
    r = problem.path.grid(2000)
    q = plan(r)
    return plan.cost + plan.cost_error if oracle.allowed(q, 1e-9).all() else np.inf
