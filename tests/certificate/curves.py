"""Joint motions of planar arms with one redundant degree, written anew: forward and inverse kinematics, cost, checks.

A motion is a curve (r(τ), θ(τ)) with r never falling, so that self-motion in one place is allowed; motions of the
problem come as near to it as one likes, at its cost. Its posture is where a spline through given postures meets the
task: exactly on the path, and moved along the self-motion on to a joint limit wherever the spline oversteps one.
Nothing here is shared with the package but the path itself.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

TAU = 2 * np.pi
TRACKING = 1e-9  # of the reach
ANGLE = 1e-9
_STEP = 0.03  # a motion is looked at so densely that no joint moves more between two looks [rad]
_LOOKS = 6
_MOST_BISECTIONS = 40
_MOST_LOOKS = 200_000
_NEWTON = 12
_GAUSS = np.polynomial.legendre.leggauss(7)


class Found(NamedTuple):
    """A motion that has been checked: its cost, the error of the cost, and dense looks at it."""

    cost: float
    error: float
    r: np.ndarray
    q: np.ndarray


class Task:
    """What a problem asks, in the numbers that the rivals work with.

    A posture is given by its joint angles or by p, the absolute directions of the first three links; the joints are
    `to_joints` @ p plus a constant. Lengths are parts of the reach.
    """

    def __init__(self, problem):
        arm = problem.arm
        self.problem, self.path, self.n = problem, problem.path, arm.n
        self.scale = float(arm.links.sum())
        self.l = arm.links[:3] / self.scale
        self.shift = 0.0 if arm.direction is None else arm.links[3] / self.scale * np.exp(1j * arm.direction)
        self.direction = 0.0 if arm.direction is None else arm.direction
        self.to_joints = np.array([[1.0, 0, 0], [-1, 1, 0], [0, -1, 1], [0, 0, -1]])[: self.n]
        self.lower, self.upper = np.array(arm.limits.lower), np.array(arm.limits.upper)
        self.limited = np.isfinite(self.lower) | np.isfinite(self.upper)
        self.weights = np.array(problem.weights)
        self.kind = problem.objective.kind
        self.sign = {"any": 0, "positive": 1, "negative": -1}[problem.elbow]
        self.start_u, self.end_u = (None if p is None else float(p.u[0]) for p in (problem.start, problem.end))
        self.cyclic = problem.cyclic
        self.breaks = np.array(problem.path.breaks)

    def target(self, r):
        """Where the third link must end, as complex numbers."""
        x = self.path(r)
        return (x[..., 0] + 1j * x[..., 1]) / self.scale - self.shift

    def speed(self, r):
        dx = self.path(r, 1)
        return (dx[..., 0] + 1j * dx[..., 1]) / self.scale

    def cost_of(self, dq, dr):
        """Cost of straight pieces, or a rate of cost: joint changes (..., n) and changes of r (...)."""
        if self.kind == "joint_travel":
            return np.hypot(dq, np.asarray(dr)[..., None]) @ self.weights
        if self.kind == "l1":
            return np.abs(dq) @ self.weights
        return np.sqrt((dq * dq) @ self.weights**2)

    def steps(self, dq):
        """Joint changes, those of free joints the shortest."""
        return np.where(self.limited, dq, np.mod(dq + np.pi, TAU) - np.pi)

    def joints(self, p, offset):
        return p @ self.to_joints.T + offset

    def continuous(self, q):
        """Postures (k, n) with free joints made continuous."""
        return np.where(self.limited, q, np.unwrap(q, axis=0))

    def directions(self, q):
        """p of postures (..., n), and the constant that the joints differ by from `to_joints` @ p."""
        p = np.cumsum(q[..., :3], axis=-1)
        return p, q - p @ self.to_joints.T

    def lacks(self, p, x):
        """What the third link's end lacks of x."""
        return x - np.exp(1j * p) @ self.l

    def rows(self, p):
        """The task's Jacobian in p, its two rows (..., 3) each."""
        return -np.sin(p) * self.l, np.cos(p) * self.l

    def tangents(self, p):
        """Unit directions in p in which the posture moves and the tool does not, shape (..., 3)."""
        null = _cross(*self.rows(p))
        # Where the arm is stretched there is none; any direction will do until a check says what came of it.
        return null / np.maximum(np.linalg.norm(null, axis=-1, keepdims=True), 1e-300)

    def closed(self, p, x, gauge, level):
        """Postures on the task x with gauge · p = level, by Newton's method from p; and whether it got there."""
        shape = p.shape[:-1]
        p, x = np.array(p).reshape(-1, 3), np.broadcast_to(x, shape).ravel()
        gauge, level = np.broadcast_to(gauge, (*shape, 3)).reshape(-1, 3), np.broadcast_to(level, shape).ravel()
        rows = np.arange(len(p))
        for _ in range(_NEWTON):
            here, g = p[rows], gauge[rows]
            lack, off = self.lacks(here, x[rows]), level[rows] - (g * here).sum(axis=-1)
            step = _solved(*self.rows(here), g, lack.real, lack.imag, off)
            p[rows] = here + np.clip(step, -0.5, 0.5)
            rows = rows[~(np.abs(step).max(axis=-1) < 1e-9)]  # what is left is the square of it
            if not len(rows):
                break
        good = np.ones(len(p), bool)
        good[rows] = False
        return p.reshape(*shape, 3), good.reshape(shape)

    def solved(self, x, u, sign):
        """Postures p (..., 3) by intersecting two circles, sign of sin θ2; and by how much they are in reach."""
        l1, l2, l3 = self.l
        wrist = x - l3 * np.exp(1j * u)
        d = np.abs(wrist)
        margin = np.minimum(l1 + l2 - d, d - abs(l1 - l2))
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (l1**2 - l2**2 + d**2) / (2 * d)
            across = np.sqrt(np.maximum((l1 + l2 + d) * (l2 - d + l1) * (l2 + d - l1) * (l1 + d - l2), 0)) / (2 * d)
            elbow = wrist / d * (along - 1j * sign * across)
        u = np.broadcast_to(u, d.shape)
        return np.stack([np.angle(elbow), np.angle(wrist - elbow), u], axis=-1), margin

    def lifts(self, q):
        """Every posture inside the limits that differs from q (n,) by whole turns; a free joint stays."""
        options = []
        for j in range(self.n):
            turns = [0.0]
            if self.limited[j]:
                low = -9 if np.isinf(self.lower[j]) else np.ceil((self.lower[j] - q[j]) / TAU - 1e-13)
                high = 9 if np.isinf(self.upper[j]) else np.floor((self.upper[j] - q[j]) / TAU + 1e-13)
                turns = np.arange(low, high + 1)
                if np.isinf(self.lower[j]) or np.isinf(
                    self.upper[j]
                ):  # one limit alone: the turn next to it is as good
                    turns = turns[:1] if np.isfinite(self.lower[j]) else turns[-1:]
            options.append(q[j] + TAU * np.asarray(turns))
        return np.stack(np.meshgrid(*options, indexing="ij"), axis=-1).reshape(-1, self.n)


def _cross(a, b):
    """The cross product of vectors (..., 3), without the checks that would take most of the time."""
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)


def _solved(a, b, c, f, g, h):
    """Solve rows a, b, c (..., 3) for right-hand sides f, g, h (...)."""
    normal = _cross(a, b)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        sides = _cross(c, f[..., None] * -b + g[..., None] * a) + h[..., None] * normal
        return sides / (normal * c).sum(axis=-1)[..., None]


class Curve:
    """The motion through postures q (k, n) at r (k,), which are on the task and inside the limits.

    Parameters
    ----------
    task : Task
    r, q : array
        Free joints continuous. Equal neighbours in r are self-motion in one place.
    """

    def __init__(self, task, r, q):
        self.task, self.r = task, r
        p, offset = task.directions(q)
        self.p, self.offset = p, offset[0]
        t = task.tangents(p)
        flips = np.cumprod(np.where((t[1:] * t[:-1]).sum(axis=-1) < 0, -1.0, 1.0))
        self.t = t * np.concatenate([[1.0], flips])[:, None]
        self.lower, self.upper = task.lower.copy(), task.upper.copy()
        if task.sign:
            half_turn = np.rint((np.median(q[:, 1]) - 0.5 * np.pi * task.sign) / TAU)
            middle = 0.5 * np.pi * task.sign + TAU * half_turn
            self.lower[1], self.upper[1] = (
                max(self.lower[1], middle - np.pi / 2),
                min(self.upper[1], middle + np.pi / 2),
            )
        dr = np.diff(r)
        self.still = dr <= 0
        self.h = np.where(self.still, np.abs(np.diff(p, axis=0)).max(axis=1) + 1e-12, dr)
        self.tau = np.concatenate([[0.0], np.cumsum(self.h)])
        self.slopes = self._slopes()

    def _slopes(self):
        """Slopes of p at both ends of every interval, Akima's in each run without corners."""
        from scipy.interpolate import Akima1DInterpolator

        chords = np.diff(self.p, axis=0) / self.h[:, None]
        slopes = np.stack([chords, chords], axis=1)
        corner = np.concatenate([[True], np.isin(self.r[1:-1], self.task.breaks), [True]])
        corner[1:-1] |= self.still[1:] != self.still[:-1]
        ends = np.flatnonzero(corner)
        for a, b in pairwise(ends):
            if b - a > 1:
                spline = Akima1DInterpolator(self.tau[a : b + 1], self.p[a : b + 1], method="makima")
                at = spline(self.tau[a : b + 1], 1)
                slopes[a:b, 0], slopes[a:b, 1] = at[:-1], at[1:]
        return slopes

    def __call__(self, tau, rates=False):
        """Return r and joint angles at tau (k,); with `rates` their rates as well, in a tuple of four."""
        task = self.task
        k = np.clip(np.searchsorted(self.tau, tau, side="right") - 1, 0, len(self.h) - 1)
        h = self.h[k][:, None]
        s = np.clip((tau - self.tau[k])[:, None] / h, 0.0, 1.0)
        s[tau >= self.tau[-1]] = 1.0
        p0, p1, m0, m1 = self.p[k], self.p[k + 1], h * self.slopes[k, 0], h * self.slopes[k, 1]
        c2, c3 = 3 * (p1 - p0) - 2 * m0 - m1, 2 * (p0 - p1) + m0 + m1
        y, dy = p0 + s * (m0 + s * (c2 + s * c3)), (m0 + s * (2 * c2 + 3 * s * c3)) / h
        g, dg = (1 - s) * self.t[k] + s * self.t[k + 1], (self.t[k + 1] - self.t[k]) / h
        dr = np.where(self.still[k], 0.0, 1.0)
        r = np.minimum(self.r[k] + s[:, 0] * (self.r[k + 1] - self.r[k]), self.r[k + 1])
        x = task.target(r)
        p, _ = task.closed(y, x, g, (g * y).sum(axis=-1))
        level = (g * dy).sum(axis=-1) + (dg * (y - p)).sum(axis=-1)
        p, g, level = self._clamped(p, x, g, level)
        q = task.joints(p, self.offset)
        if not rates:
            return r, q
        dx = task.speed(r) * dr
        dp = _solved(*task.rows(p), g, dx.real, dx.imag, level)
        return r, q, dr, dp @ task.to_joints.T

    def _clamped(self, p, x, gauge, level):
        """Move postures outside a limit along the self-motion on to it; there the limit holds them."""
        task, gauge, level = self.task, np.array(gauge), np.array(level)
        for _ in range(3):
            q = task.joints(p, self.offset)
            over = np.maximum(self.lower - q, q - self.upper)
            worst = np.argmax(over, axis=1)
            rows = np.flatnonzero(over[np.arange(len(p)), worst] > 1e-14)
            if not len(rows):
                break
            j = worst[rows]
            limit = np.where(q[rows, j] > self.upper[j], self.upper[j], self.lower[j])
            gauge[rows], level[rows] = task.to_joints[j], 0.0
            p[rows] = task.closed(p[rows], x[rows], task.to_joints[j], limit - self.offset[j])[0]
        return p, gauge, level

    def looks(self):
        """Dense looks (r, q) at the motion, denser where joints move fast; the last may still be far apart."""
        parts = np.arange(_LOOKS) / _LOOKS
        tau = np.append((self.tau[:-1, None] + self.h[:, None] * parts).ravel(), self.tau[-1])
        return dense(self, tau)

    def cost(self, tolerance=1e-10):
        """The cost and an estimate of its error."""

        def rate(tau):
            _, _, dr, dq = self(tau, rates=True)
            return self.task.cost_of(dq, dr)

        return integrated(rate, self.tau, tolerance)


def dense(motion, tau):
    """Look at a motion, a callable from tau to (r, q), until no joint moves by more than a step between two looks."""
    r, q = motion(tau)
    for _ in range(_MOST_BISECTIONS):
        wide = np.flatnonzero(~(np.abs(np.diff(q, axis=0)).max(axis=1) <= _STEP))
        if not len(wide) or not np.isfinite(q).all() or len(tau) > _MOST_LOOKS:
            break
        middle = 0.5 * (tau[wide] + tau[wide + 1])
        more_r, more_q = motion(middle)
        tau, r = np.insert(tau, wide + 1, middle), np.insert(r, wide + 1, more_r)
        q = np.insert(q, wide + 1, more_q, axis=0)
    return r, q


def integrated(rate, edges, tolerance):
    """Gauss quadrature on panels that are halved until two halves agree with the whole; value and error estimate."""
    nodes, weights = _GAUSS

    def on(left, right):
        half = 0.5 * (right - left)
        at = 0.5 * (left + right)[:, None] + half[:, None] * nodes
        return half * (rate(at.ravel()).reshape(at.shape) @ weights)

    left, right = edges[:-1], edges[1:]
    whole = on(left, right)
    span, total, error = edges[-1] - edges[0], 0.0, 0.0
    rough = np.abs(whole).sum()
    for k in range(50):
        middle = 0.5 * (left + right)
        first, second = on(left, middle), on(middle, right)
        off = np.abs(first + second - whole)
        done = off <= np.maximum(tolerance * rough * (right - left) / span, 1e-15 * rough)
        if k == 49 or len(left) > 20_000:
            done[:] = True
        total += float((first + second)[done].sum())
        error += float(off[done].sum())
        if done.all():
            break
        go = ~done
        left, right, whole = (
            np.concatenate(pair) for pair in ((left[go], middle[go]), (middle[go], right[go]), (first[go], second[go]))
        )
    return total, error + 1e-14 * abs(total)


def faults(problem, r, q):
    """What is wrong with a motion given by dense looks, from forward kinematics alone; empty if it is a solution."""
    arm, found = problem.arm, []
    if not (np.isfinite(q).all() and r[0] == 0.0 and r[-1] == 1.0 and (np.diff(r) >= 0).all()):
        return ["does not run from 0 to 1"]
    phi = np.cumsum(q, axis=1)
    tool = np.exp(1j * phi) @ arm.links
    x = problem.path(r)
    if np.abs(tool - (x[:, 0] + 1j * x[:, 1])).max() > TRACKING * arm.links.sum():
        found.append("leaves the path")
    if arm.direction is not None and np.abs(np.exp(1j * (phi[:, -1] - arm.direction)) - 1).max() > ANGLE:
        found.append("leaves the direction")
    if max((arm.limits.lower - q).max(), (q - arm.limits.upper).max()) > 1e-12:
        found.append("leaves the limits")
    if np.abs(np.diff(q, axis=0)).max() > _STEP:
        found.append("jumps")
    if problem.elbow != "any" and (np.sin(q[:, 1]) * (1 if problem.elbow == "positive" else -1)).min() < -1e-12:
        found.append("leaves the elbow")
    for name, k in (("start", 0), ("end", -1)):
        posture = getattr(problem, name)
        if posture is not None and abs(np.exp(1j * (phi[k, 2] - posture.u[0])) - 1) > ANGLE:
            found.append(f"has another {name}")
    if problem.cyclic:
        gap = q[-1] - q[0]
        free = np.isinf(arm.limits.lower) & np.isinf(arm.limits.upper)
        if problem.cyclic == "modulo":
            gap = np.where(free, np.mod(gap + np.pi, TAU) - np.pi, gap)
        if np.abs(gap).max() > ANGLE:
            found.append("does not close")
    return found


def chord_sum(task, r, q):
    """The cost of the looks as a polygon, which is below that of the motion."""
    return float(task.cost_of(np.diff(q, axis=0), np.diff(r)).sum())


def checked(task, cost, error, r, q):
    """The motion as `Found` if it holds and its cost is that of its looks, else None."""
    if faults(task.problem, r, q) or not np.isfinite(cost + error):
        return None
    polygon = chord_sum(task, r, q)
    # A polygon of steps this short is nearly as long as the curve, never longer.
    if not polygon <= cost + error + 1e-11 * cost or polygon < (1 - 3e-3) * cost or error > 1e-7 * cost:
        return None
    return Found(cost, error, r, q)


def motion_through(task, r, q):
    """The motion through postures, checked and its cost integrated; None if it does not hold."""
    curve = Curve(task, r, task.continuous(q))
    looks = curve.looks()
    if faults(task.problem, *looks):
        return None
    return checked(task, *curve.cost(), *looks)
