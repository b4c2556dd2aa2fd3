"""Where no continuous motion exists: why, and the motion with the fewest reconfigurations and little travel."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.certificate.infeasibility import explain
from selfmotion.certificate.joined import earliest, leads_on, sheets_at_end
from selfmotion.errors import InfeasibleError, SelfMotionError, UndecidedError
from selfmotion.paths import Section
from selfmotion.planners.refine import Refine
from selfmotion.plans import Plan
from selfmotion.problem import Problem

_TRIED = (0.5, 0.1, 0.9)  # where in its interval a reconfiguration is tried
_MOST_TRIED = 12
_STARTS = 3  # of each piece
_TOLERANCE = 1e-4
_FOR_THE_PROOF = 0.6  # parts of the time
_SHORTEST = 1e-9  # part of the path that is worth a motion


@dataclass(frozen=True)
class Reconfiguration:
    """A planned break of a motion: the tool leaves the path, the arm takes another posture, the tool comes back.

    Attributes
    ----------
    r : float
        Where it was planned.
    r_range : tuple of float
        Where it must be: not before the end can be got to from there with the breaks that follow, not after the place
        that the motion before it gets to at most.
    before, after : array, shape (n,)
        Joint angles [rad].
    travel : float
        ``Σ|Δθ_i|`` from one to the other [rad].
    """

    r: float
    r_range: tuple[float, float]
    before: FloatArray
    after: FloatArray
    travel: float


@dataclass(frozen=True)
class Reconfigured:
    """A motion in several pieces.

    Attributes
    ----------
    plans : tuple of Plan
        One per piece, on its part of the path; each holds by itself.
    breaks : tuple of Reconfiguration
        Between them.
    l1_travel : float
        ``Σ_i ∫|θ_i'| dr`` of all pieces and breaks [rad].
    """

    plans: tuple[Plan, ...]
    breaks: tuple[Reconfiguration, ...]
    l1_travel: float


def explained(problem: Problem, deadline: float) -> InfeasibleError | UndecidedError | None:
    """Prove that a problem has no continuous motion, say why, and plan one with the fewest reconfigurations.

    Parameters
    ----------
    problem : Problem
    deadline : float
        As :func:`time.perf_counter` tells it.

    Returns
    -------
    InfeasibleError, UndecidedError or None
        See :func:`~selfmotion.certificate.infeasibility.explain`; an InfeasibleError with ``reconfigured`` as far as
        postures exist all along the path and time allowed.
    """
    now, part = time.perf_counter(), 1.0 if leads_on(problem) else _FOR_THE_PROOF
    error = explain(problem, now + part * (deadline - now))
    if not isinstance(error, InfeasibleError) or error.proof is None or leads_on(problem):
        return error
    ranges = break_ranges(problem)
    if ranges is not None:
        error.reconfigured = reconfigured(problem, ranges, deadline)
    return error


def break_ranges(problem: Problem) -> list[tuple[float, float]] | None:
    """Return, for the fewest breaks that do, the interval of r that each must be in; None if no number does.

    From the structure of the angle domain: going as far as possible before each break gives the latest places, coming
    back from the end as far as possible the earliest.
    """
    structure = problem.structure
    last = set(sheets_at_end(problem, "end"))

    def alive(r: float, onward: bool) -> list[int]:
        """The sheets at r that go on from there, or come to it."""
        return [k for k, s in enumerate(structure.sheets) if (s.r[0] <= r < s.r[1] if onward else s.r[0] < r <= s.r[1])]

    latest: list[float] = []
    sheets: Iterable[int] = sheets_at_end(problem, "start")
    while not any(last & structure.reachable[k] for k in sheets):
        r = structure.farthest(sheets)[0]
        if latest and r <= latest[-1]:  # no farther than before
            return None
        latest.append(r)
        sheets = alive(r, True) if r < 1.0 else last
        if not sheets:
            return None
    first: list[float] = []
    goal: Iterable[int] = last
    for _ in latest:
        first.append(earliest(problem, goal))
        goal = alive(first[-1], False) if first[-1] > 0.0 else sheets_at_end(problem, "start")
    return [(min(a, b), b) for a, b in zip(first[::-1], latest, strict=True)]


def reconfigured(problem: Problem, ranges: list[tuple[float, float]], deadline: float) -> Reconfigured | None:
    """Plan a motion with breaks in the given intervals, each piece by refinement from several starts.

    Parameters
    ----------
    problem : Problem
    ranges : list of tuple
        See :func:`break_ranges`.
    deadline : float
        As :func:`time.perf_counter` tells it.

    Returns
    -------
    Reconfigured or None
        The one of least travel of those tried; None if there was no time for one, or some piece could not be planned.
    """
    best: Reconfigured | None = None
    pieces: dict[tuple[float, float], Plan | None] = {}
    for parts in list(product(_TRIED, repeat=len(ranges)))[:_MOST_TRIED]:
        places = [low + part * (high - low) for part, (low, high) in zip(parts, ranges, strict=True)]
        edges = [0.0, *np.maximum.accumulate(places).tolist(), 1.0]
        plans = []
        for pair in pairwise(edges):
            if pair not in pieces:
                pieces[pair] = _piece(problem, *pair, deadline)
            plan = pieces[pair]
            if plan is None:
                break
            plans.append(plan)
        if len(plans) == len(ranges) + 1:
            found = _together(problem, plans, edges[1:-1], ranges)
            if best is None or found.l1_travel < best.l1_travel:
                best = found
        if time.perf_counter() > deadline:
            break
    return best


def _piece(problem: Problem, low: float, high: float, deadline: float) -> Plan | None:
    """Plan the motion between two places of the path; None where none was found."""
    if high - low < _SHORTEST:
        return None
    try:
        part = Problem(
            problem.arm, Section(problem.path, (low, high)),
            start=_given(problem, "start") if low <= 0.0 else None, end=_given(problem, "end") if high >= 1.0 else None,
            elbow=problem.elbow, weights=problem.weights, objective=problem.objective.kind, samples=problem.samples,
        )  # fmt: skip
        seconds = max(deadline - time.perf_counter(), 1e-3)
        return Refine(starts=_STARTS, tolerance=_TOLERANCE, time_limit=seconds).plan(part)
    except SelfMotionError:
        return None


def _given(problem: Problem, name: str) -> dict[str, FloatArray] | None:
    posture = getattr(problem, name)
    if posture is None:
        return None
    return {"u": posture.u} if posture.q is None else {"q": posture.q}


def _together(
    problem: Problem, plans: list[Plan], places: list[float], ranges: list[tuple[float, float]]
) -> Reconfigured:
    breaks = []
    for one, two, r, r_range in zip(plans[:-1], plans[1:], places, ranges, strict=True):
        before, after = one(1.0), two(0.0)
        travel = float(np.abs(problem.arm.limits.steps(before, after)).sum())
        breaks.append(Reconfiguration(r, r_range, before, after, travel))
    total = sum(plan.l1_travel for plan in plans) + sum(part.travel for part in breaks)
    return Reconfigured(tuple(plans), tuple(breaks), float(total))
