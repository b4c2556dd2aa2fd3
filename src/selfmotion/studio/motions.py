"""A motion as plain data, where and why it is wrong, and what a planner makes of a problem."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from selfmotion._checks import finite_array
from selfmotion._types import BoolArray, FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import PlanarArm, RedundantArm
from selfmotion.arms.protocols import length_unit, u_period
from selfmotion.certificate.result import TubeSlice
from selfmotion.certificate.verdict import verdict
from selfmotion.constrained import constraints_of, unconstrained
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.plan_file import plan_bytes
from selfmotion.motion import Motion
from selfmotion.objectives import L1Travel
from selfmotion.paths.base import PLANE, SPACE
from selfmotion.planners import Planner, Sinusoid
from selfmotion.plans import Plan
from selfmotion.plot.optimum import bands, tube_intervals
from selfmotion.problem import Problem
from selfmotion.profiles import ProfileCurve
from selfmotion.studio.hand import Hand
from selfmotion.studio.panels import PanelChart, branch_window
from selfmotion.studio.place import Place, Tell
from selfmotion.studio.problems import MOST_BREAKS, problem_of
from selfmotion.studio.scene import thinned
from selfmotion.studio.wire import finite, packed
from selfmotion.verification import (
    LIMIT,
    Failure,
    Verification,
    closure_failures,
    elbow_failures,
    end_failures,
    verify_motion,
)

MOST_ROWS = 2001
"""Rows of a motion that are shown."""
MOST_WRONG = 200
"""Stretches of it that are told, the longest ones."""
_ROUNDING = 1e-13  # parts of the reach, as the arm itself forgives
_SEEN = 0.02  # gaps in a tube that are too narrow to be seen [rad]


class Wrong(NamedTuple):
    """A stretch of a motion that does not hold.

    Attributes
    ----------
    r : tuple of float
    kind : str
        ``"reach"``, ``"limit"``, or a check of :class:`~selfmotion.verification.Failure`.
    joint : int or None
        Counted from 0.
    by : float or None
        In the unit of what is missed.
    text : str
    """

    r: tuple[float, float]
    kind: str
    joint: int | None
    by: float | None
    text: str

    def plain(self) -> dict[str, Any]:
        """Return it as what JSON knows."""
        return {**self._asdict(), "r": list(self.r), "by": finite(self.by)}


class Sampled(NamedTuple):
    """A motion at the rows of its problem.

    Attributes
    ----------
    r : array, shape (k,)
    u : array, shape (k, n_u)
    q : array, shape (k, n)
        With turns; NaN where there is no posture.
    """

    r: FloatArray
    u: FloatArray
    q: FloatArray


def curve_motion(problem: Problem, hand: Hand) -> Motion:
    """Return the motion along a curve, its turns as a planner counts them."""
    start = None if problem.start is None else problem.start.q
    nodes = max(2 * problem.samples, int(16 * hand.cycles))
    return Motion(problem.arm, problem.path, hand.curve, hand.branch, nodes, start)


def sinusoid_of(problem: Problem, planner: Planner | None, frequency: Any) -> Hand:
    """Return the planner's sinusoid at a frequency, on the first branch that it may start on.

    Raises
    ------
    InvalidInputError
        If the planner searches no sinusoids, or the frequency does not fit.
    """
    if not isinstance(planner, Sinusoid):
        raise InvalidInputError("frequency", "is for planner sinusoid", "leave it out, or move the curve by hand")
    profile = planner.profile_for(problem)
    if profile.n_u != problem.arm.n_u:
        raise InvalidInputError(
            "planner.offset", f"has length {profile.n_u}", f"give {problem.arm.n_u}, one per redundant degree"
        )
    a = finite_array("frequency", frequency, 1)
    if len(a) != profile.n_u:
        raise InvalidInputError("frequency", f"has length {len(a)}", f"give {profile.n_u}", frequency)
    branches = [b for b in problem.start_branches if problem.may_start_at(profile.start, b)]
    return Hand(ProfileCurve(profile, a), (branches or problem.start_branches)[0])


def curve_object(problem: Problem, hand: Hand, kind: str, settled: bool = True) -> dict[str, Any]:
    """Return the motion along a curve as plain data.

    Parameters
    ----------
    problem : Problem
    hand : Hand
    kind : str
        What it is called.
    settled : bool
        False while something is dragged: then what takes long is None.
    """
    judged = Judged.of(problem, hand, settled)
    few = len(problem.path.breaks) <= MOST_BREAKS
    known: dict[str, Any] = {"cost": None, "cost_error": None, "cost_sampled": None, "l1": None}
    if not judged.wrong:
        made = Plan(problem, judged.motion, kind, {})
        known["cost_sampled"] = float(problem.objective.sampled(judged.rows.q, judged.rows.r, problem.weights))
        if settled or (few and problem.arm.dimension == PLANE):
            known |= {"cost": finite(made.cost), "cost_error": finite(made.cost_error)}
        known["l1"] = finite(made.l1_travel) if settled and few else _l1(judged.rows)
    check = judged.check
    return (
        _object(problem, judged.rows, judged.branch, kind, judged.wrong)
        | known
        | {
            "margin": _margin(problem.arm, judged.rows.q) if check is None else check.min_limit_margin,
            "margins": _kept(problem.arm, judged.rows.q) if check is None else check.margins,
            "tool_error": None if check is None else check.max_tracking_error,
            "max_step": _largest_step(judged.rows.q) if check is None else check.max_joint_step,
        }
    )


def plan_motion(plan: Plan) -> dict[str, Any]:
    """Return the motion of a plan as plain data; see :func:`curve_object`."""
    problem = plan.problem
    r = problem.rows
    q, u = plan(r), plan.u(r)
    rows = Sampled(r, np.unwrap(u, axis=0) if u_period(problem.arm) == TAU else u, q)
    check = plan.verification
    wrong = [_of_failure(problem, failure) for failure in check.failures]
    return _object(problem, rows, problem.arm.branch_of(q), plan.planner, wrong) | {
        "cost": finite(plan.cost),
        "cost_error": finite(plan.cost_error),
        "cost_sampled": finite(plan.cost_sampled),
        "l1": finite(plan.l1_travel),
        "margin": check.min_limit_margin,
        "margins": check.margins,
        "tool_error": check.max_tracking_error,
        "max_step": check.max_joint_step,
    }


def _object(problem: Problem, rows: Sampled, branch: Any, kind: str, wrong: list[Wrong]) -> dict[str, Any]:
    """Return what motions of all sorts have, thinned for pictures."""
    branches = np.broadcast_to(np.asarray(branch, dtype=float), rows.r.shape)
    r, u, q, on = (thinned(column, MOST_ROWS) for column in (rows.r, rows.u, rows.q, branches))
    there = np.isfinite(q).all(axis=-1)
    points = np.full((len(r), problem.arm.n + 1, PLANE if problem.arm.dimension == PLANE else SPACE), np.nan)
    points[there] = problem.arm.joint_positions(q[there])
    return {
        "r": packed(r), "u": packed(u), "q": packed(q), "branch": packed(on, "f4"), "points": packed(points, "f4"),
        "kind": kind, "holds": not wrong, "wrong": [part.plain() for part in wrong],
    }  # fmt: skip


class Judged(NamedTuple):
    """A curve with what is wrong with it.

    Attributes
    ----------
    rows : Sampled
    motion : Motion
    branch : int
    wrong : list of Wrong
        Empty if it holds.
    check : Verification or None
        None where that was not asked for, or something was wrong already.
    """

    rows: Sampled
    motion: Motion
    branch: int
    wrong: list[Wrong]
    check: Verification | None

    @classmethod
    def of(cls, problem: Problem, hand: Hand, settled: bool = True) -> Judged:
        """Judge a curve: at the rows of its problem, and between them too if it is settled."""
        arm, r = problem.arm, problem.rows
        u = hand.curve(r, 0)
        principal, reach = _solved(arm, problem.path(r), u, hand.branch)
        there = reach >= 0.0
        motion = curve_motion(problem, hand)
        q = motion(r) if there.all() else _lifted(problem, principal, there)
        rows = Sampled(r, u, q)
        wrong = _out_of_reach(arm, r, reach) + _outside_limits(arm, r, q) + _not_kept(arm, r, q)
        wrong += [_of_failure(problem, failure) for failure in _at_samples(problem, rows)]
        check = None
        if settled and not wrong:
            check = verify_motion(problem, motion)
            wrong += [_of_failure(problem, failure) for failure in check.failures]
        wrong = sorted(wrong, key=lambda part: part.r[0] - part.r[1])[:MOST_WRONG]
        return cls(rows, motion, hand.branch, sorted(wrong, key=lambda part: part.r), check)


def _solved(arm: RedundantArm, x: FloatArray, u: FloatArray, branch: int) -> tuple[FloatArray, FloatArray]:
    """Return postures, and how far inside reach they are: not negative where there is one."""
    if isinstance(unconstrained(arm), PlanarArm):
        q, margin = arm.solve_with_margin(x, u, branch)
        return q, np.where(margin >= -_ROUNDING * arm.reach, np.maximum(margin, 0.0), margin)
    q, ok = arm.solve(x, u, branch)
    return q, np.where(ok, 0.0, -np.inf)


def _lifted(problem: Problem, principal: FloatArray, there: BoolArray) -> FloatArray:
    """Return postures made continuous over what is missing, NaN where there is none."""
    if not there.any():
        return np.full_like(principal, np.nan)
    known = np.flatnonzero(there)
    start = None if problem.start is None or not there[0] else problem.start.q
    lifted = problem.arm.limits.lift(principal[known][None].copy(), start).q[0]
    found = np.full_like(principal, np.nan)
    found[known] = lifted
    return found


def _stretches(wrong: BoolArray) -> list[tuple[int, int]]:
    """Return the first and last row of each run of rows."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], wrong.astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _ends(r: FloatArray, margin: FloatArray, a: int, b: int) -> tuple[float, float]:
    """Return where a stretch of negative margins from row a to row b begins and ends, interpolated."""

    def between(inside: int, outside: int) -> float:
        if not 0 <= inside < len(r) or not np.isfinite(margin[inside]):
            return float(r[outside])
        part = 0.5
        if np.isfinite(margin[outside]):
            part = float(margin[inside] / max(margin[inside] - margin[outside], 1e-300))
        return float(r[inside] + min(max(part, 0.0), 1.0) * (r[outside] - r[inside]))

    return between(a - 1, a), between(b + 1, b)


def _out_of_reach(arm: RedundantArm, r: FloatArray, reach: FloatArray) -> list[Wrong]:
    unit = length_unit(arm)
    found = []
    for a, b in _stretches(reach < 0.0):
        short = -float(reach[a : b + 1].min())
        by = f" by {short:.3g}{'' if unit is None else f' {unit}'}" if np.isfinite(short) else ""
        text = (
            f"the first two links do not reach{by}"
            if isinstance(unconstrained(arm), PlanarArm)
            else "there is no such posture"
        )
        found.append(Wrong(_ends(r, reach, a, b), "reach", None, finite(short), text))
    return found


def _outside_limits(arm: RedundantArm, r: FloatArray, q: FloatArray) -> list[Wrong]:
    limits, found = arm.limits, []
    for j in np.flatnonzero(limits.limited).tolist():
        name, unit = f"{'q' if limits.slides[j] else 'θ'}{j + 1}", limits.units[j]
        for side, margin in (
            ("below its lower", q[:, j] - limits.lower[j]),
            ("above its upper", limits.upper[j] - q[:, j]),
        ):
            with np.errstate(invalid="ignore"):
                outside = margin < -LIMIT
            for a, b in _stretches(outside):
                by = -float(margin[a : b + 1].min())
                text = f"{name} {side} limit by {by:.3g} {unit}"
                found.append(Wrong(_ends(r, margin, a, b), "limit", j, by, text))
    return found


def _not_kept(arm: RedundantArm, r: FloatArray, q: FloatArray) -> list[Wrong]:
    """Return where constraints beyond joint limits are not kept, with what is kept least."""
    found, there = [], np.isfinite(q).all(axis=-1)
    for constraint in constraints_of(arm) if there.any() else ():
        margin, which = np.full(len(r), np.nan), np.zeros(len(r), int)
        margin[there], which[there] = constraint.least_margins(q[there])
        with np.errstate(invalid="ignore"):
            lacking = margin < -constraint.tolerance
        for a, b in _stretches(lacking):
            worst = a + int(margin[a : b + 1].argmin())
            by = -float(margin[worst])
            text = f"{constraint.cause(int(which[worst]))} by {by:.3g}{constraint.unit}"
            found.append(Wrong(_ends(r, margin, a, b), constraint.check, None, by, text))
    return found


def _kept(arm: RedundantArm, q: FloatArray) -> dict[str, float]:
    """Return what is left of each constraint beyond joint limits, by the name of its check."""
    there = q[np.isfinite(q).all(axis=-1)]
    return {part.check: float(part.least_margins(there)[0].min()) for part in constraints_of(arm)} if len(there) else {}


def _at_samples(problem: Problem, rows: Sampled) -> list[Failure]:
    """Return what of elbow, ends and closure does not hold, as far as there are postures."""
    there: BoolArray = np.asarray(np.isfinite(rows.q).all(axis=-1))
    found = elbow_failures(problem, rows.r[there], rows.q[there]) if there.any() else []
    if there[0] and there[-1]:
        found += end_failures(problem, rows.q) + closure_failures(problem, rows.q)
    return found


def _of_failure(problem: Problem, failure: Failure) -> Wrong:
    """Return a failed check as a place that is wrong."""
    joint = None if failure.joint is None else failure.joint - 1
    unit = "" if joint is None else f" {problem.arm.limits.units[joint]}"
    who = "" if joint is None else f"θ{joint + 1} "
    by = failure.value
    kind = failure.check
    if kind == "limits":
        kind, by = "limit", -failure.value
        text = f"{who}outside its limits by {by:.3g}{unit}"
    elif kind in ("elbow", "branch"):
        by, text = 0.0, f"on another branch than {problem.elbow}"
    elif kind == "continuity":
        text = f"{who}jumps by {by:.3g}{unit}"
    elif kind == "tracking":
        text = f"the tool is off the path by {by:.3g}"
    elif kind in ("start", "end"):
        text = f"misses the given {kind} by {by:.3g} {problem.arm.limits.unit}"
    elif kind == "closure":
        text = f"{who}does not close by {by:.3g}{unit}"
    else:
        text = str(failure)
    return Wrong((failure.r, failure.r), kind, joint, by, text)


def _l1(rows: Sampled) -> float:
    ones = np.ones(rows.q.shape[1])
    return float(L1Travel().sampled(rows.q, rows.r, ones))


def _margin(arm: RedundantArm, q: FloatArray) -> float | None:
    there = q[np.isfinite(q).all(axis=-1)]
    return finite(float(arm.margins(there).min())) if len(there) else None


def _largest_step(q: FloatArray) -> float | None:
    steps = np.abs(np.diff(q, axis=0))
    steps = steps[np.isfinite(steps).all(axis=-1)]
    return float(steps.max()) if len(steps) else None


def plan(payload: dict[str, Any], tell: Tell, place: Place) -> dict[str, Any]:
    """Plan the ``problem``; return the motion, what is known of it and proved, and the plan's file."""
    problem, planner = problem_of(payload.get("problem"), place.folder)
    if planner is None:
        raise InvalidInputError("planner", "is missing", "add planner: {kind: sinusoid, …}")
    made = planner.plan(problem, lambda done, total, best: tell(done, total, finite(best)))
    return plan_object(made)


def plan_object(made: Plan) -> dict[str, Any]:
    """Return a plan as plain data: the motion, its summary, how the search went, what was proved, and its file."""
    proof = made.certificate
    return {
        "motion": plan_motion(made),
        "summary": made.summary(),
        "verdict": None if proof is None else verdict(made.cost, made.cost_error, proof.bound, rigorous=proof.rigorous),
        "history": [
            {name: list(map(finite, column)) for name, column in asdict(part).items()} for part in made.history
        ],
        "levels": []
        if proof is None
        else [{name: finite(value) for name, value in level._asdict().items()} for level in proof.levels],
        "tube": [] if proof is None else tube_object(made.problem, proof.tube),
        "plan": plan_bytes(made).decode(),
    }


def tube_object(problem: Problem, tube: tuple[TubeSlice, ...]) -> list[dict[str, Any]]:
    """Return where a better motion could be as polygons of (r, u) per branch, in the windows of the panels."""
    arm, found = problem.arm, []
    if not len(tube) or u_period(arm) != TAU:
        return []
    r = np.array([part.r for part in tube])
    on = [(arm.branch_of(part.a), arm.branch_of(part.b)) for part in tube]
    for branch in np.unique(np.concatenate([column for pair in on for column in pair])).tolist():
        mine = [(a == branch) | (b == branch) for a, b in on]
        slices = tuple(TubeSlice(s.r, s.a[keep], s.b[keep]) for s, keep in zip(tube, mine, strict=True))
        intervals = tube_intervals(PanelChart(branch_window(problem, branch)), arm, slices, _SEEN)
        polygons = bands(intervals, r)
        found.append({"branch": branch, "polygons": packed(np.array(polygons).reshape(-1, 4, 2))})
    return found
