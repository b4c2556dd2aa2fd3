"""Does a motion hold? Tracking, limits and continuity from forward kinematics, between samples too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from selfmotion._blocks import in_blocks
from selfmotion._types import FloatArray, IntArray
from selfmotion.arms.protocols import u_steps
from selfmotion.constrained import constraints_of
from selfmotion.constrained.between import Unsure, unsure
from selfmotion.paths.base import PLANE
from selfmotion.problem import ANGLE, Problem

TRACKING = 1e-9
"""Tracking error allowed of a computed motion, as a part of the reach."""
LIMIT = 1e-9
"""Overrun of a joint limit allowed [rad]."""
JUMP = 1e-3
"""A joint step that stays larger than this however closely one looks is a jump [rad]."""

_BETWEEN = 4  # looks per sample interval …
_FEWEST = 1000  # … or more, where that makes fewer looks
_PLACES = 12  # worst places that are looked at more closely
_MOST_DIPS = 1000
_AT_ONCE = 20_000  # places
_ZOOMS = 14
_BISECTIONS = 46
_NO_JUMP = 1e-3 * JUMP  # steps so short need not be bisected on


@dataclass(frozen=True)
class Failure:
    """One reason why a motion does not hold.

    Attributes
    ----------
    check : str
        ``"tracking"``, ``"limits"``, ``"clearance"``, ``"singularity"``, ``"continuity"``, ``"elbow"``, ``"branch"``,
        ``"start"``, ``"end"`` or ``"closure"``; of a sampled motion also ``"tracking_between"`` or ``"coverage"``.
    r : float
        Where along the path.
    value, allowed : float
        What was found there and what would have been allowed; of branches their indices.
    joint : int or None
        Joint concerned, counted from 1.
    row : int or None
        Data row of a trajectory file, counted from 1; the last one where a motion does not close.
    cause : str
        What is not kept, in words, such as ``"link 3 against obstacle 2"``; empty where check and joint say it.
    """

    check: str
    r: float
    value: float
    allowed: float
    joint: int | None = None
    row: int | None = None
    cause: str = ""

    def __str__(self) -> str:
        place = f"r = {self.r:.6g}" + ("" if self.row is None else f", data row {self.row}")
        who = f" of joint {self.joint}" if self.joint is not None else f" ({self.cause})" if self.cause else ""
        return f"{self.check}{who} at {place}: {self.value:.9g}, allowed {self.allowed:.9g}"


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
    margins : dict
        Least margin of each further constraint by its check, such as ``{"clearance": 0.02}``: what is left of the
        clearance asked for.
    """

    max_tracking_error: float
    min_limit_margin: float | None
    max_joint_step: float
    failures: tuple[Failure, ...]
    margins: dict[str, float] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Whether the motion tracks the path continuously within its limits."""
        return not self.failures


def finite_or_none(margin: float) -> float | None:
    """Return the least limit margin, None where no joint is limited.

    Parameters
    ----------
    margin : float
        Infinite where no joint is limited.

    Returns
    -------
    float or None
    """
    return float(margin) if np.isfinite(margin) else None


class _Jump(NamedTuple):
    """The largest step left where steps were bisected: r, the step and its joint; and where the path was left most."""

    r: float
    step: float
    joint: int
    lost: float
    off: float


def verify_motion(problem: Problem, motion: Callable[[FloatArray], FloatArray]) -> Verification:
    """Measure tracking, limits, continuity, elbow and end postures of a motion, at its samples and between them.

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
    The motion is looked at four times per sample interval, and a thousand times at least; dips that may go deeper in
    between are zoomed into, and the largest steps bisected: a step that does not shrink is a jump, and so is one across
    which the path is left. This finds what a sample misses; it is no proof. Further constraints must surely be kept in
    between, see :func:`~selfmotion.constrained.between.unsure`.
    """
    arm, path, constraints = problem.arm, problem.path, constraints_of(problem.arm)
    rows = problem.rows
    grid = np.union1d(_refined(rows), path.breaks)

    def slack(r: FloatArray, q: FloatArray) -> FloatArray:
        """Column 0: minus the tracking error; then the limit margins, and those of further constraints."""
        further = [constraint.least_margins(q)[0] / constraint.scale for constraint in constraints]
        return np.column_stack([-arm.task_error(q, path(r)), arm.margins(q), *further])

    looked_at = in_blocks(motion, grid, _AT_ONCE)
    seen = in_blocks(lambda k: slack(grid[k], looked_at[k]), np.arange(len(grid)), _AT_ONCE)
    at, least = _least(lambda r: slack(r, motion(r)), grid, seen, TRACKING * arm.reach, arm.n)
    jump = _largest_jump(motion, lambda q, r: arm.task_error(q, path(r)), grid, looked_at)
    if jump.off > -least[0]:
        at[0], least[0] = jump.lost, -jump.off
    failures = []
    if -least[0] > TRACKING * arm.reach:
        failures.append(Failure("tracking", at[0], -least[0], TRACKING * arm.reach))
    failures += [Failure("limits", at[j], least[j], -LIMIT, joint=j) for j in range(1, arm.n + 1) if least[j] < -LIMIT]
    margins = {}
    for k, constraint in enumerate(constraints, arm.n + 1):
        margins[constraint.check] = margin = least[k] * constraint.scale
        if margin >= -constraint.tolerance:
            place = unsure(constraint, motion, grid, looked_at)
        else:
            (which,) = constraint.least_margins(motion(np.array([at[k]])))[1]
            place = Unsure(at[k], margin, int(which))
        if place is not None:
            cause = constraint.cause(place.which)
            failures.append(Failure(constraint.check, place.r, place.margin, -constraint.tolerance, cause=cause))
    found = elbow_failures(problem, grid, looked_at) + end_failures(problem, looked_at)
    found += closure_failures(problem, looked_at)
    failures += [replace(failure, row=None) for failure in found]  # a continuous motion has no rows
    if jump.step > JUMP:
        failures.append(Failure("continuity", jump.r, jump.step, JUMP, joint=jump.joint + 1))
    step = float(np.abs(np.diff(looked_at[np.searchsorted(grid, rows)], axis=0)).max())
    return Verification(-least[0], finite_or_none(min(least[1 : arm.n + 1])), step, tuple(failures), margins)


def elbow_failures(problem: Problem, r: FloatArray, q: FloatArray) -> list[Failure]:
    """Return the first place where postures `q` (k, n) at `r` (k,) leave the branch that the problem asks for.

    Parameters
    ----------
    problem : Problem
    r : array, shape (k,)
        Path parameters.
    q : array, shape (k, n)
        Joint angles [rad; m of joints that slide].

    Returns
    -------
    list of Failure
        One or none.
    """
    if problem.elbow == "any":
        return []
    wrong = ~problem.arm.is_on_branch(q, problem.elbow, ANGLE)
    if not wrong.any():
        return []
    k = int(np.argmax(wrong))
    if problem.arm.dimension == PLANE:
        return [Failure("elbow", float(r[k]), float(np.sin(q[k, 1])), 0.0, joint=2, row=k + 1)]
    on, asked = int(problem.arm.branch_of(q[k])), problem.elbow_branches[0]
    return [Failure("branch", float(r[k]), float(on), float(asked), row=k + 1)]


def end_failures(problem: Problem, q: FloatArray) -> list[Failure]:
    """Return which of the problem's start and end postures the motion `q` (k, n) does not have.

    Parameters
    ----------
    problem : Problem
    q : array, shape (k, n)
        Joint angles [rad; m of joints that slide].

    Returns
    -------
    list of Failure
    """
    arm, failures = problem.arm, []
    for name, posture, r, k in (("start", problem.start, 0.0, 0), ("end", problem.end, 1.0, len(q) - 1)):
        if posture is None:
            continue
        if posture.q is None:
            off = np.abs(u_steps(arm, posture.u, arm.u_of(q[k])))
        else:
            off = np.abs(arm.limits.steps(posture.q, q[k]))
        if off.max() > ANGLE:
            failures.append(Failure(name, r, float(off.max()), ANGLE, row=k + 1))
    return failures


def closure_failures(problem: Problem, q: FloatArray) -> list[Failure]:
    """Return the joint by which a motion `q` (k, n) fails most to close, if the problem wants it to be cyclic.

    Parameters
    ----------
    problem : Problem
    q : array, shape (k, n)
        Joint angles [rad; m of joints that slide].

    Returns
    -------
    list of Failure
        One or none.
    """
    if not problem.cyclic:
        return []
    gap = q[-1] - q[0]
    if problem.cyclic == "modulo":
        gap = problem.arm.limits.steps(q[0], q[-1])
    joint = int(np.argmax(np.abs(gap)))
    if abs(gap[joint]) <= ANGLE:
        return []
    return [Failure("closure", 1.0, float(abs(gap[joint])), ANGLE, joint + 1, row=len(q))]


def _refined(rows: FloatArray) -> FloatArray:
    between = max(_BETWEEN, -(-_FEWEST // (len(rows) - 1)))
    parts = np.arange(between) / between
    inner = rows[:-1, None] + np.diff(rows)[:, None] * parts
    return np.append(inner.ravel(), rows[-1])


def _least(
    slack: Callable[[FloatArray], FloatArray], grid: FloatArray, values: FloatArray, tracking: float, limits: int
) -> tuple[list[float], list[float]]:
    """Return, per column of `slack`, where it is least and how much: `values` on the grid, zoomed where that matters.

    It does where the error may be more than `tracking`, and the margins of `limits` less than allowed or the least of
    all; of further margins the least is wanted in any case.
    """
    margin = max(float(values[:, 1 : limits + 1].min()), -LIMIT)
    where, least = [], []
    for column in range(values.shape[1]):
        series = values[:, column]
        best = int(np.argmin(series))
        at, value = float(grid[best]), float(series[best])
        bar = -tracking if not column else margin if column <= limits else value
        worst = _dips(series, min(value, bar)) if np.isfinite(value) else np.empty(0, int)
        if len(worst):
            low, high = grid[np.maximum(worst - 1, 0)], grid[np.minimum(worst + 1, len(grid) - 1)]
            for _ in range(_ZOOMS):
                r = np.linspace(low, high, 9, axis=1)
                near = slack(r.ravel())[:, column].reshape(r.shape)
                k = np.argmin(near, axis=1)
                rows = np.arange(len(r))
                lowest = int(np.argmin(near[rows, k]))
                if near[lowest, k[lowest]] < value:
                    at, value = float(r[lowest, k[lowest]]), float(near[lowest, k[lowest]])
                low, high = r[rows, np.maximum(k - 1, 0)], r[rows, np.minimum(k + 1, 8)]
        where.append(at)
        least.append(value)
    return where, least


def _dips(series: FloatArray, bar: float) -> IntArray:
    """Return the local minima that could fall to `bar` between the samples: by at most their rise to a neighbour."""
    padded = np.concatenate([[np.inf], series, [np.inf]])
    minima = np.flatnonzero((series <= padded[:-2]) & (series <= padded[2:]))
    rise = np.maximum(
        np.abs(np.diff(series, prepend=series[0]))[minima], np.abs(np.diff(series, append=series[-1]))[minima]
    )
    reachable = series[minima] - rise
    order = np.argsort(reachable)[:_MOST_DIPS]
    return minima[order[reachable[order] <= bar]]


def _largest_jump(
    motion: Callable[[FloatArray], FloatArray], error: Callable[[FloatArray, FloatArray], FloatArray], grid: FloatArray,
    q: FloatArray,
) -> _Jump:  # fmt: skip
    """Bisect the largest steps of `q` on the grid towards their steeper half, looking at the tracking error there."""
    worst = np.argsort(np.abs(np.diff(q, axis=0)).max(axis=1))[-_PLACES:]
    low, high, q_low, q_high = grid[worst], grid[worst + 1], q[worst], q[worst + 1]
    lost, off = float(grid[0]), 0.0
    for _ in range(_BISECTIONS):
        if np.abs(q_high - q_low).max() < _NO_JUMP:
            break
        middle = 0.5 * (low + high)
        q_middle = motion(middle)
        miss = error(q_middle, middle)
        if miss.max() > off:
            lost, off = float(middle[miss.argmax()]), float(miss.max())
        first = np.abs(q_middle - q_low).max(axis=1) >= np.abs(q_high - q_middle).max(axis=1)
        low, q_low = np.where(first, low, middle), np.where(first[:, None], q_low, q_middle)
        high, q_high = np.where(first, middle, high), np.where(first[:, None], q_middle, q_high)
    steps = np.abs(q_high - q_low)
    place, joint = np.unravel_index(int(np.argmax(steps)), steps.shape)
    return _Jump(float(low[place]), float(steps[place, joint]), int(joint), lost, off)
