"""The verdict on a sampled motion that anyone made."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import finite_array, positive
from selfmotion._types import BoolArray, FloatArray
from selfmotion.constrained import constraints_of
from selfmotion.constrained.between import straight, unsure
from selfmotion.errors import InvalidInputError
from selfmotion.problem import Problem
from selfmotion.verification import Failure, closure_failures, elbow_failures, end_failures, finite_or_none


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

    Raises
    ------
    InvalidInputError
        If one of them is not a positive number.
    """

    tracking: float = 1e-6
    between: float = 1e-2
    limit: float = 1e-9
    step: float = 0.5

    def __post_init__(self) -> None:
        for each in fields(self):
            positive(each.name, getattr(self, each.name))

    @classmethod
    def given(cls, tolerances: Tolerances | None) -> Tolerances:
        """Return `tolerances`, or the usual ones if None."""
        if tolerances is not None and not isinstance(tolerances, Tolerances):
            raise InvalidInputError("tolerances", "are none", "give judgement.Tolerances(…)", tolerances)
        return tolerances or cls()


# A step above _ODD_STEP that is _ODD_RATIO times faster than both its neighbours is a jump that rows hide.
_ODD_STEP = 0.02
_ODD_RATIO = 8.0
# Two path parameters that count as the same.
_SAME = 1e-9


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
    margins : dict
        Least margin of each further constraint at the rows, by its check, such as ``"clearance"``.
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
    margins: dict[str, float] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Whether nothing failed."""
        return not self.failures


class Sampled(NamedTuple):
    """A motion under judgement and what is measured on it once.

    Attributes
    ----------
    problem : Problem
    r : array, shape (k,)
        Path parameters of the rows, not descending.
    q : array, shape (k, n)
        Joint angles [rad; m of joints that slide].
    allowed : Tolerances
    miss : array, shape (k,)
        How far the tool is from the path at the rows, in the unit of length.
    between : array, shape (k − 1,)
        The same half-way between rows, joints moving on straight lines.
    margins : array, shape (k, n)
        Distances from the nearer limit, infinite where there is none, as `q`.
    steps : array, shape (k − 1, n)
        Sizes of the joint steps, as `q`.
    """

    problem: Problem
    r: FloatArray
    q: FloatArray
    allowed: Tolerances
    miss: FloatArray
    between: FloatArray
    margins: FloatArray
    steps: FloatArray

    @property
    def jumps(self) -> BoolArray:
        """Which steps no continuous motion explains, shape (k − 1,)."""
        return self.steps.max(axis=1) > steps_allowed(self.r, self.steps, self.allowed.step)

    @property
    def coarse(self) -> BoolArray:
        """Within which steps the tool leaves the path, joints moving on straight lines, shape (k − 1,)."""
        return self.between > self.allowed.between * self.problem.arm.reach

    def failure(self, check: str, row: int, value: float, limit: float, joint: int | None = None) -> Failure:
        """Return a failure at a row, counted from 0, and a joint, counted from 0."""
        row %= len(self.r)
        number = None if joint is None else joint + 1
        return Failure(check, float(self.r[row]), float(value), float(limit), number, int(row) + 1)


def judge(problem: Problem, r: ArrayLike, q: ArrayLike, tolerances: Tolerances | None = None) -> Judgement:
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

    Raises
    ------
    InvalidInputError
        If shapes do not fit, r descends or leaves [0, 1], or a value is not finite.

    Notes
    -----
    Checked are: the tool on the path at the rows and half-way between them, joint limits, the elbow,
    start and end posture, closure of a cyclic motion, the whole of [0, 1] covered, and continuity. A step
    breaks continuity if it exceeds ``step``, or if it is eight times faster in r than the steps before and after it.
    Further constraints must be kept at the rows, and between them with the joints on straight lines, wherever on these.
    """
    motion = measured(problem, r, q, tolerances)
    r, q, allowed = motion.r, motion.q, motion.allowed
    checks = (_coverage, _tracking, _limits, _continuity, _elbow, _ends, _constraints)
    return Judgement(
        max_tracking_error=float(motion.miss.max()),
        max_tracking_error_between=float(motion.between.max()),
        min_limit_margin=finite_or_none(motion.margins.min()),
        max_joint_step=float(motion.steps.max()),
        cost_sampled=float(problem.objective.sampled(q, r, problem.weights)),
        l1_travel=float(motion.steps.sum()),
        l2_travel=float(np.linalg.norm(motion.steps, axis=1).sum()),
        failures=tuple(failure for check in checks for failure in check(motion)),
        tolerances=allowed,
        margins={c.check: float(c.margins(q).min()) for c in constraints_of(problem.arm)},
    )


def measured(problem: Problem, r: ArrayLike, q: ArrayLike, tolerances: Tolerances | None = None) -> Sampled:
    """Measure a sampled motion, free joints made continuous; refuse what is none. See :func:`judge`.

    Parameters
    ----------
    problem : Problem
    r : array_like, shape (k,)
        Path parameters, not descending.
    q : array_like, shape (k, n)
        Joint angles [rad; m of joints that slide].
    tolerances : Tolerances, optional

    Returns
    -------
    Sampled

    Raises
    ------
    InvalidInputError
        If r and q are no motion: their shapes, their number, the order of r.
    """
    arm = problem.arm
    r, q = finite_array("r", r, 1), finite_array("q", q, 2, arm.n)
    if len(r) != len(q) or len(r) < 2 or r.min() < 0 or r.max() > 1 or (np.diff(r) < 0).any():
        raise InvalidInputError("r", "does not run through q inside [0, 1]", "give two rows or more, r not descending")
    q = arm.limits.continuous(q)
    return Sampled(
        problem,
        r,
        q,
        Tolerances.given(tolerances),
        miss=arm.task_error(q, problem.path(r)),
        between=arm.task_error(0.5 * (q[1:] + q[:-1]), problem.path(0.5 * (r[1:] + r[:-1]))),
        margins=arm.margins(q),
        steps=np.abs(np.diff(q, axis=0)),
    )


def _coverage(motion: Sampled) -> Iterator[Failure]:
    for end, row in ((0.0, 0), (1.0, -1)):
        if abs(motion.r[row] - end) > _SAME:
            yield motion.failure("coverage", row, motion.r[row], end)


def _tracking(motion: Sampled) -> Iterator[Failure]:
    reach = motion.problem.arm.reach
    for check, errors, allowed in (
        ("tracking", motion.miss, motion.allowed.tracking),
        ("tracking_between", motion.between, motion.allowed.between),
    ):
        worst = int(np.argmax(errors))
        if errors[worst] > allowed * reach:
            yield motion.failure(check, worst, errors[worst], allowed * reach)


def _limits(motion: Sampled) -> Iterator[Failure]:
    for joint in np.flatnonzero(motion.margins.min(axis=0) < -motion.allowed.limit):
        worst = int(np.argmin(motion.margins[:, joint]))
        yield motion.failure("limits", worst, motion.margins[worst, joint], -motion.allowed.limit, int(joint))


def _continuity(motion: Sampled) -> Iterator[Failure]:
    """One failure at most: the largest step if too large, else the step that stands out most from its neighbours."""
    size, allowed = motion.steps.max(axis=1), steps_allowed(motion.r, motion.steps, motion.allowed.step)
    too_large = size > motion.allowed.step
    k = int(np.argmax(size if too_large.any() else size / allowed))
    if size[k] > allowed[k]:
        yield motion.failure("continuity", k + 1, size[k], allowed[k], int(np.argmax(motion.steps[k])))


def steps_allowed(r: FloatArray, steps: FloatArray, largest: float) -> FloatArray:
    """Return how large each joint step of a continuous motion may be.

    Parameters
    ----------
    r : array, shape (k,)
    steps : array, shape (k − 1, n)
        Absolute joint steps between rows [rad].
    largest : float
        [rad]

    Returns
    -------
    array, shape (k − 1,)
        `largest`, or where a step is eight times faster in r than the steps before and after it, what would not be;
        steps up to 0.02 rad are always allowed.
    """
    size = steps.max(axis=1)
    if len(size) < 3:
        return np.full(len(size), largest)
    speed = size / np.maximum(np.diff(r), _SAME)
    padded = np.concatenate([speed[1:2], speed, speed[-2:-1]])
    usual = _ODD_RATIO * np.maximum(padded[:-2], padded[2:]) * size / speed.clip(1e-300)
    return np.minimum(np.maximum(usual, _ODD_STEP), largest)


def _elbow(motion: Sampled) -> Iterator[Failure]:
    yield from elbow_failures(motion.problem, motion.r, motion.q)


def _ends(motion: Sampled) -> Iterator[Failure]:
    yield from end_failures(motion.problem, motion.q)
    yield from closure_failures(motion.problem, motion.q)


def _constraints(motion: Sampled) -> Iterator[Failure]:
    """One failure per constraint: the worst row, or a place between rows that is not surely clear."""
    r, q = motion.r, motion.q
    for constraint in constraints_of(motion.problem.arm):
        margins = constraint.margins(q)
        row = int(margins.min(axis=1).argmin())
        if margins[row].min() < -constraint.tolerance:
            failure = motion.failure(constraint.check, row, margins[row].min(), -constraint.tolerance)
            yield replace(failure, cause=constraint.cause(int(margins[row].argmin())))
            continue
        rows = np.arange(len(q), dtype=float)  # r may stand still between them
        place = unsure(constraint, straight(rows, q), rows, q)
        if place is not None:
            row, at = int(place.r), float(np.interp(place.r, rows, r))
            failure = motion.failure(constraint.check, row, place.margin, -constraint.tolerance)
            yield replace(failure, r=at, cause=constraint.cause(place.which))
