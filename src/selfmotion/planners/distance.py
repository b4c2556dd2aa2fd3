"""How far a sampled motion that anyone made is from the best possible one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.certificate.verdict import percent
from selfmotion.constrained import constraints_of
from selfmotion.errors import InfeasibleError, InvalidInputError, SelfMotionError
from selfmotion.judgement import Sampled, Tolerances, judge, measured
from selfmotion.mending.filling import SAME, on_path
from selfmotion.optimizers import Progress
from selfmotion.planners.globally_optimal import Global
from selfmotion.plans import Plan
from selfmotion.problem import Problem

_FEWEST_HALVINGS, _MOST_HALVINGS = 3, 12  # of every step between two rows
_SETTLED = 1e-8  # relative change of the cost at which halving stops
_MOST_ROWS = 50_000  # that are looked between
_MOST_POSTURES = 400_000  # that halving may make of them
_SHRINKS = 0.75  # what two halvings leave at most of the steps of a continuous motion; a quarter is usual
_ROUNDING = 1e-12  # relative


@dataclass(frozen=True)
class Distance:
    """How far a sampled motion is from the best possible one.

    Attributes
    ----------
    cost_sampled : float
        The objective's chord sum over its rows: below the cost of every continuous motion that passes them.
    cost, cost_error : float or None
        The objective along the continuous motion through its rows that is nearest to straight joint lines and has the
        tool on the path between them too, and an estimate of the error; None where there is none.
    lower_bound : float or None
        What every continuous motion that solves the problem costs at least.
    optimum : float or None
        The cost of the best motion found.
    gap : float or None
        ``(cost + cost_error − lower_bound)/cost``: which part of its cost the best possible motion may save, at most.
    gap_sampled : float or None
        ``(cost_sampled − lower_bound)/cost_sampled``, which flatters the motion, the more the fewer its rows; None
        where even the sum is below the bound.
    reason : str or None
        Why something of this is not known, or cannot be compared.
    plan : Plan or None
        The best motion found, with its certificate.
    estimated_bound, estimated_gap : float or None
        Instead of ``lower_bound`` and ``gap`` for an arm that is not rigorous; None for all others.
    """

    cost_sampled: float
    cost: float | None = None
    cost_error: float | None = None
    lower_bound: float | None = None
    optimum: float | None = None
    gap: float | None = None
    gap_sampled: float | None = None
    reason: str | None = None
    plan: Plan | None = None
    estimated_bound: float | None = None
    estimated_gap: float | None = None

    def __str__(self) -> str:
        because = "" if self.reason is None else f" ({self.reason})"
        if self.estimated_bound is not None:
            against = (
                f"best motion found {self.optimum:.6g}, all others estimated at {self.estimated_bound:.6g} at least"
            )
            saved = "distance from the best possible motion: not known"
            if self.estimated_gap is not None:
                saved = f"an estimated {percent(self.estimated_gap)} of its cost {self.cost:.6g} could be saved"
            return f"{saved}: {against}{because}"
        if self.lower_bound is None or self.optimum is None:
            return f"distance from the best possible motion: not known{because}"
        against = f"best motion found {self.optimum:.6g}, none is below {self.lower_bound:.6g}"
        if self.gap is not None:
            return f"at most {percent(self.gap)} of its cost {self.cost:.6g} could be saved: {against}{because}"
        if self.gap_sampled is not None:
            saved = f"at most {percent(self.gap_sampled)} of its chord sum {self.cost_sampled:.6g} could be saved"
            return f"{saved}, and more of its cost, which is above that: {against}{because}"
        return f"distance from the best possible motion: not known; {against}{because}"

    def summary(self) -> dict[str, Any]:
        """Return the distance as ``selfmotion verify --json`` prints it, the chord sum left out."""
        names = ["cost", "cost_error", "lower_bound", "optimum", "gap", "gap_sampled", "reason"]
        if self.estimated_bound is not None:
            names += ["estimated_bound", "estimated_gap"]
        return {name: getattr(self, name) for name in names}


def distance_from_optimum(
    problem: Problem,
    r: ArrayLike,
    q: ArrayLike,
    optimum: Global | Plan | None = None,
    tolerances: Tolerances | None = None,
    progress: Progress | None = None,
) -> Distance:
    """Measure how far a sampled motion that anyone made is from the best possible one.

    Parameters
    ----------
    problem : Problem
    r : array_like, shape (k,)
        Path parameters, not descending.
    q : array_like, shape (k, n)
        Joint angles [rad]; limited joints as they stand, free ones modulo 2π.
    optimum : Global or Plan, optional
        The planner that proves a bound, or a plan of the same problem that holds one; ``Global()`` by default.
    tolerances : Tolerances, optional
        What :func:`~selfmotion.judgement.judge` must accept.
    progress : callable, optional
        As for :func:`~selfmotion.plan`.

    Returns
    -------
    Distance
        With a ``reason`` where no bound can be proved, as for arms with another degree of redundancy than one.

    Raises
    ------
    InvalidInputError
        If the rows are malformed, the motion does not hold, or the plan given is one of another problem or holds no
        bound.

    Notes
    -----
    Rows say nothing of the motion between them, and their chords cut corners: the chord sum over few rows can be below
    the cost of the best possible motion. So the rows are first put on the path, which their tolerance lets them miss,
    and every step is halved again and again, the posture half-way being put on the path inside the limits. What this
    converges to is a motion in its own right, which no bound exceeds. The nested chord sums S_k grow, each time by
    about a quarter of the growth before, so that ``cost = S_k + (S_k − S_{k−1})/3``, with as much for its error.
    """
    judged = judge(problem, r, q, tolerances)
    if not judged.holds:
        raise InvalidInputError("q", f"is no motion that holds: {judged.failures[0]}", "mend it first, as by repair")
    _check(problem, optimum)
    through = _through(measured(problem, r, q, tolerances))
    known: dict[str, Any] = {"cost_sampled": judged.cost_sampled, "cost": through.cost, "cost_error": through.error}
    try:
        plan = optimum if isinstance(optimum, Plan) else (optimum or Global()).plan(problem, progress)
    except InfeasibleError as error:
        return Distance(**known, reason=f"between its rows it can be none: {error.message}")
    except SelfMotionError as error:
        return Distance(**known, reason=getattr(error, "reason", error.message))
    return _compared(plan, known, through.why)


def _check(problem: Problem, optimum: Global | Plan | None) -> None:
    if isinstance(optimum, Plan):
        if optimum.problem is not problem:
            raise InvalidInputError("optimum", "is a plan of another problem", "give one of this very object")
        if optimum.certificate is None:
            raise InvalidInputError("optimum", f"is a plan by {optimum.planner}, which proves no bound", "use Global")
    elif not isinstance(optimum, Global | None):
        raise InvalidInputError("optimum", "is neither Global nor a plan", "give sm.Global(…)", optimum)


def _compared(plan: Plan, known: dict[str, Any], why: str | None) -> Distance:
    """Return the distance of a motion from a plan that holds a bound; `why` it may have no cost."""
    assert plan.certificate is not None
    bound, cost, sampled = plan.certificate.bound, known["cost"], known["cost_sampled"]
    gap = gap_sampled = None
    if sampled >= bound:
        gap_sampled = _part(sampled - bound, sampled)
    elif cost is None:
        why = f"{why}, and its chord sum {sampled:.6g} is below the bound: chords cut corners; give more rows"
    if cost is not None:
        most = cost + known["cost_error"]
        if most >= bound * (1.0 - _ROUNDING):
            gap = max(_part(most - bound, cost), 0.0)
        else:
            why = f"it costs {bound - most:.1e} less than that, which only what the checks tolerate explains"
    if not plan.certificate.rigorous:
        return Distance(
            **known, optimum=plan.cost, reason=why, plan=plan, estimated_bound=bound, estimated_gap=gap
        )  # fmt: skip
    return Distance(
        **known, lower_bound=bound, optimum=plan.cost, gap=gap, gap_sampled=gap_sampled, reason=why, plan=plan
    )


def _part(less: float, whole: float) -> float:
    return less / whole if whole > 0.0 else 0.0


class _Through(NamedTuple):
    """The cost of the motion through some rows and its error, or why there is none."""

    cost: float | None
    error: float | None
    why: str | None


def _through(motion: Sampled) -> _Through:
    """Return the cost of the continuous motion through rows that hold, the tool on the path between them too."""
    problem, k = motion.problem, len(motion.r)
    if k > _MOST_ROWS:
        return _Through(None, None, f"with more than {_MOST_ROWS} rows its chord sum stands for its cost")
    r = np.concatenate([[0.0], motion.r[1:-1], [1.0]])
    q, ok = on_path(problem, r, _with_given_ends(problem, motion.q))
    if not ok.all():
        return _Through(None, None, f"data row {np.argmin(ok) + 1} cannot be put on the path {_where(problem)}")
    sums, largest = [float(problem.objective.sampled(q, r, problem.weights))], [_steps(q, k)]
    while len(sums) <= _MOST_HALVINGS:
        middle_r = 0.5 * (r[1:] + r[:-1])
        middle, ok = on_path(problem, middle_r, 0.5 * (q[1:] + q[:-1]))
        if not ok.all():
            return _broken(~ok.reshape(k - 1, -1).all(axis=1), f" {_where(problem)}")
        r, q = np.insert(r, np.arange(1, len(r)), middle_r), np.insert(q, np.arange(1, len(q)), middle, axis=0)
        sums.append(float(problem.objective.sampled(q, r, problem.weights)))
        largest.append(_steps(q, k))
        settled = sums[-1] - sums[-2] <= _SETTLED * sums[-1]
        if len(sums) > _FEWEST_HALVINGS and (settled or 2 * len(r) > _MOST_POSTURES):
            break
    jumps = largest[-1] > _SHRINKS * largest[-3] + SAME
    if jumps.any():
        return _broken(jumps)
    error = (max(sums[-1] - sums[-2], 0.0) + _ROUNDING * sums[-1]) / 3
    return _Through(sums[-1] + error, error, None)


def _broken(steps: Any, where: str = "") -> _Through:
    row = int(np.argmax(steps)) + 1
    return _Through(
        None, None, f"between data rows {row} and {row + 1} no motion on the path{where} is near straight joint lines"
    )


def _where(problem: Problem) -> str:
    """Return in words where postures are allowed."""
    return f"inside the limits{' and clear of what else is forbidden' * bool(constraints_of(problem.arm))}"


def _steps(q: FloatArray, rows: int) -> FloatArray:
    """Return the largest joint step between given rows, shape (rows − 1,)."""
    return np.asarray(np.abs(np.diff(q, axis=0)).max(axis=1).reshape(rows - 1, -1).max(axis=1))


def _with_given_ends(problem: Problem, q: FloatArray) -> FloatArray:
    """Return rows that begin and end exactly as given, which they need do to a tolerance only."""
    q = q.copy()
    for posture, at, r in ((problem.start, 0, 0.0), (problem.end, -1, 1.0)):
        if posture is None:
            continue
        near = posture.q
        if near is None:
            near = problem.arm.solve(problem.path(r), posture.u, int(problem.arm.branch_of(q[at])))[0]
        q[at] += wrap(near - q[at], problem.arm.limits.period)
    return q
