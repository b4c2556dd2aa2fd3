"""Does a motion hold? Recomputed from forward kinematics, whoever made the motion, between samples too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms._kernels import TAU
from selfmotion.problem import Problem, same_direction

TRACKING = 1e-9
"""Tracking error allowed of a computed motion, as a part of the reach."""
LIMIT = 1e-9
"""Overrun of a joint limit allowed [rad]."""
JUMP = 1e-3
"""A joint step that stays larger than this however closely one looks is a jump [rad]."""

_BETWEEN = 4  # looks per sample interval
_PLACES = 12  # worst places that are looked at more closely
_ZOOMS = 14
_BISECTIONS = 46


@dataclass(frozen=True)
class Failure:
    """One reason why a motion does not hold.

    Attributes
    ----------
    check : str
        ``"tracking"``, ``"tracking_between"``, ``"limits"``, ``"continuity"``, ``"coverage"``, ``"elbow"``,
        ``"direction"``, ``"start"``, ``"end"`` or ``"closure"``.
    r : float
        Where along the path.
    value, allowed : float
        What was found there and what would have been allowed.
    joint : int or None
        Joint concerned, counted from 1.
    row : int or None
        Data row of a trajectory file, counted from 1.
    """

    check: str
    r: float
    value: float
    allowed: float
    joint: int | None = None
    row: int | None = None

    def __str__(self) -> str:
        place = f"r = {self.r:.6g}" + ("" if self.row is None else f", row {self.row}")
        who = "" if self.joint is None else f" of joint {self.joint}"
        return f"{self.check}{who} at {place}: {self.value:.6g}, allowed {self.allowed:.6g}"


@dataclass(frozen=True)
class Verification:
    """What was measured on a motion.

    Attributes
    ----------
    max_tracking_error : float
        Largest distance of the tool from the path, in the arm's unit of length.
    min_limit_margin : float or None
        Least distance of a joint to one of its limits [rad], None without limits.
    max_joint_step : float
        Largest change of a joint between two rows [rad].
    failures : tuple of Failure
        Empty if the motion holds.
    """

    max_tracking_error: float
    min_limit_margin: float | None
    max_joint_step: float
    failures: tuple[Failure, ...]

    @property
    def holds(self) -> bool:
        """Whether the motion tracks the path continuously within its limits."""
        return not self.failures


def verify_motion(problem: Problem, motion: Callable[[FloatArray], FloatArray]) -> Verification:
    """Measure a continuous motion between its samples.

    Parameters
    ----------
    problem : Problem
    motion : callable
        Maps r of shape (k,) to joint angles of shape (k, n), turns included.

    Returns
    -------
    Verification

    Notes
    -----
    The motion is looked at four times per sample interval; the worst places are then zoomed into, and the largest
    steps bisected: a step that does not shrink is a jump. This finds what a sample misses; it is no proof.
    """
    arm, path = problem.arm, problem.path
    rows = problem.rows
    grid = np.unique(np.concatenate([_refined(rows), path.breaks]))

    def slack(r: FloatArray) -> FloatArray:
        """Column 0: minus the tracking error; the others: the limit margins."""
        q = motion(r)
        miss = np.linalg.norm(arm.forward(q) - path(r), axis=-1)
        return np.column_stack([-miss, arm.margins(q)])

    at, least = _least(slack, grid)
    failures = []
    if -least[0] > TRACKING * arm.reach:
        failures.append(Failure("tracking", at[0], -least[0], TRACKING * arm.reach))
    failures += [
        Failure("limits", at[j], least[j], -LIMIT, joint=j) for j in range(1, arm.n + 1) if least[j] < -LIMIT
    ]
    where, jump, joint = _largest_jump(motion, grid)
    if jump > JUMP:
        failures.append(Failure("continuity", where, jump, JUMP, joint=joint + 1))
    step = float(np.abs(np.diff(motion(rows), axis=0)).max())
    margin = min(least[1:])
    return Verification(float(-least[0]), margin if np.isfinite(margin) else None, step, tuple(failures))


def _refined(rows: FloatArray) -> FloatArray:
    parts = np.arange(_BETWEEN) / _BETWEEN
    inner = rows[:-1, None] + np.diff(rows)[:, None] * parts
    return np.append(inner.ravel(), rows[-1])


def _least(function: Callable[[FloatArray], FloatArray], grid: FloatArray) -> tuple[list[float], list[float]]:
    """Return, per column of `function`, where it is least and how much: grid values, zoomed at the worst."""
    values = function(grid)
    where, least = [], []
    for column in range(values.shape[1]):
        series = values[:, column]
        best = int(np.argmin(series))
        at, value = float(grid[best]), float(series[best])
        if np.isfinite(value):
            worst = np.argsort(series)[:_PLACES]
            low, high = grid[np.maximum(worst - 1, 0)], grid[np.minimum(worst + 1, len(grid) - 1)]
            for _ in range(_ZOOMS):
                r = np.linspace(low, high, 9, axis=1)
                near = function(r.ravel())[:, column].reshape(r.shape)
                k = np.argmin(near, axis=1)
                rows = np.arange(len(r))
                lowest = int(np.argmin(near[rows, k]))
                if near[lowest, k[lowest]] < value:
                    at, value = float(r[lowest, k[lowest]]), float(near[lowest, k[lowest]])
                low, high = r[rows, np.maximum(k - 1, 0)], r[rows, np.minimum(k + 1, 8)]
        where.append(at)
        least.append(value)
    return where, least


def _largest_jump(motion: Callable[[FloatArray], FloatArray], grid: FloatArray) -> tuple[float, float, int]:
    """Bisect the largest steps towards their steeper half; return r, the step that is left, and its joint."""
    q = motion(grid)
    worst = np.argsort(np.abs(np.diff(q, axis=0)).max(axis=1))[-_PLACES:]
    low, high, q_low, q_high = grid[worst], grid[worst + 1], q[worst], q[worst + 1]
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        q_middle = motion(middle)
        first = np.abs(q_middle - q_low).max(axis=1) >= np.abs(q_high - q_middle).max(axis=1)
        low, q_low = np.where(first, low, middle), np.where(first[:, None], q_low, q_middle)
        high, q_high = np.where(first, middle, high), np.where(first[:, None], q_middle, q_high)
    steps = np.abs(q_high - q_low)
    place, joint = np.unravel_index(int(np.argmax(steps)), steps.shape)
    return float(low[place]), float(steps[place, joint]), int(joint)


@dataclass(frozen=True)
class Tolerances:
    """What is allowed of a trajectory that anyone made.

    Attributes
    ----------
    tracking : float
        Distance of the tool from the path at a row, as a part of the reach.
    between : float
        The same half-way between two rows, the joints moving on straight lines, as a controller interpolates.
    limit : float
        Overrun of a joint limit [rad].
    step : float
        Largest joint step between two rows [rad].
    """

    tracking: float = 1e-6
    between: float = 1e-2
    limit: float = 1e-9
    step: float = 0.5


# A step above _ODD_STEP that is _ODD_RATIO times faster than both its neighbours is a jump that rows hide.
_ODD_STEP = 0.02
_ODD_RATIO = 8.0


@dataclass(frozen=True)
class Judgement:
    """The verdict on a sampled trajectory.

    Attributes
    ----------
    max_tracking_error, max_tracking_error_between : float
        At the rows, and half-way between them on straight joint lines.
    min_limit_margin : float or None
    max_joint_step : float
    cost_sampled, l1_travel, l2_travel : float
        The objective's chord sum over the rows, and plain travel.
    failures : tuple of Failure
        The worst of each kind, empty if the motion holds.
    tolerances : Tolerances
    """

    max_tracking_error: float
    max_tracking_error_between: float
    min_limit_margin: float | None
    max_joint_step: float
    cost_sampled: float
    l1_travel: float
    l2_travel: float
    failures: tuple[Failure, ...]
    tolerances: Tolerances

    @property
    def holds(self) -> bool:
        """Whether nothing failed."""
        return not self.failures


def judge(problem: Problem, r: FloatArray, q: FloatArray, tolerances: Tolerances | None = None) -> Judgement:
    """Judge a sampled motion.

    Parameters
    ----------
    problem : Problem
    r : array, shape (k,)
        Path parameters, not descending.
    q : array, shape (k, n)
        Joint angles [rad]; limited joints as they stand, free ones modulo 2π.
    tolerances : Tolerances, optional

    Returns
    -------
    Judgement

    Notes
    -----
    Checked are: the tool on the path at the rows and half-way between them, joint limits, the elbow and the fixed direction,
    start and end posture, closure of a cyclic motion, the whole of [0, 1] covered, and continuity. A step breaks
    continuity if it exceeds ``step``, or if it is eight times faster in r than the steps before and after it.
    """
    allowed = tolerances or Tolerances()
    arm, path = problem.arm, problem.path
    free = ~arm.limits.limited
    q = np.where(free, np.unwrap(q, axis=0), q)
    found: list[Failure] = []

    def report(check: str, k: int, value: float, limit: float, joint: int | None = None) -> None:
        found.append(Failure(check, float(r[k]), float(value), limit, joint, k + 1))

    miss = np.linalg.norm(arm.forward(q) - path(r), axis=-1)
    worst = int(np.argmax(miss))
    if not miss[worst] <= allowed.tracking * arm.reach:
        report("tracking", worst, miss[worst], allowed.tracking * arm.reach)

    half_r, half_q = 0.5 * (r[1:] + r[:-1]), 0.5 * (q[1:] + q[:-1])
    between = np.linalg.norm(arm.forward(half_q) - path(half_r), axis=-1)
    worst = int(np.argmax(between))
    if not between[worst] <= allowed.between * arm.reach:
        report("tracking_between", worst, between[worst], allowed.between * arm.reach)

    margins = arm.margins(q)
    for joint in np.flatnonzero(margins.min(axis=0) < -allowed.limit):
        worst = int(np.argmin(margins[:, joint]))
        report("limits", worst, margins[worst, joint], -allowed.limit, int(joint) + 1)

    steps = np.abs(np.diff(q, axis=0))
    k, joint = np.unravel_index(int(np.argmax(steps)), steps.shape)
    largest = float(steps[k, joint])
    if largest > allowed.step:
        report("continuity", int(k) + 1, largest, allowed.step, int(joint) + 1)
    else:
        _report_odd_step(r, steps, report)

    for end, k in ((0.0, 0), (1.0, -1)):
        if abs(r[k] - end) > 1e-9:
            report("coverage", k % len(r), r[k], end)
    if problem.elbow != "any":
        sine = np.sin(q[:, 1]) * (1 if problem.elbow == "positive" else -1)
        worst = int(np.argmin(sine))
        if sine[worst] < -1e-6:
            report("elbow", worst, sine[worst], -1e-6, 2)
    if arm.direction is not None:
        turned = q.sum(axis=1) - arm.direction
        turned = np.abs(turned - TAU * np.rint(turned / TAU))
        worst = int(np.argmax(turned))
        if turned[worst] > allowed.tracking:
            report("direction", worst, turned[worst], allowed.tracking)
    _report_ends(problem, q, allowed, report)

    l1, l2 = steps.sum(), np.linalg.norm(steps, axis=1).sum()
    margin = float(margins.min())
    return Judgement(
        float(miss.max()),
        float(between.max()),
        margin if np.isfinite(margin) else None,
        largest,
        float(problem.objective.sampled(q, r, problem.weights)),
        float(l1),
        float(l2),
        tuple(found),
        allowed,
    )


def _report_odd_step(r: FloatArray, steps: FloatArray, report: Callable[..., None]) -> None:
    size = steps.max(axis=1)
    speed = size / np.maximum(np.diff(r), 1e-12)
    if len(speed) < 3:
        return
    around = np.maximum(np.append(speed[1:], speed[-2]), np.insert(speed[:-1], 0, speed[1]))
    ratio = np.where(size > _ODD_STEP, speed / np.maximum(around, 1e-300), 0.0)
    k = int(np.argmax(ratio))
    if ratio[k] > _ODD_RATIO:
        report("continuity", k + 1, size[k], float(size[k] * _ODD_RATIO / ratio[k]), int(np.argmax(steps[k])) + 1)


def _report_ends(problem: Problem, q: FloatArray, allowed: Tolerances, report: Callable[..., Any]) -> None:
    arm = problem.arm
    for name, posture, k in (("start", problem.start, 0), ("end", problem.end, len(q) - 1)):
        if posture is None:
            continue
        if posture.q is not None:
            off = q[k] - posture.q
            off = np.where(arm.limits.limited, off, off - TAU * np.rint(off / TAU))
        else:
            off = arm.u_of(q[k]) - posture.u
            off = off - TAU * np.rint(off / TAU)
        if np.abs(off).max() > 1e-6 and not same_direction(off, np.zeros_like(off)):
            report(name, k, float(np.abs(off).max()), 1e-6)
    if problem.cyclic:
        gap = q[-1] - q[0]
        if problem.cyclic == "modulo":
            gap = np.where(arm.limits.limited, gap, gap - TAU * np.rint(gap / TAU))
        if np.abs(gap).max() > 1e-6:
            report("closure", len(q) - 1, float(np.abs(gap).max()), 1e-6, int(np.argmax(np.abs(gap))) + 1)
