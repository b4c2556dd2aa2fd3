"""By how much the nearest joint limit would have to give for a motion to exist."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import Cause
from selfmotion.certificate.chains import Chains
from selfmotion.certificate.joined import ends, leads_on, with_arm
from selfmotion.errors import Need
from selfmotion.problem import Problem

_MOST = 1.0  # no limit is asked to give more [rad] …
_FARTHEST = 10.0  # … nor a rail to be longer by more [m]
_SHARP = 1e-3  # relative error of what a limit is said to need
_JUST_NOT = 0.97  # part of what is needed with which the proof shows where it is needed
_SECONDS = 0.5  # for that proof
_COARSE = 0.3  # spacing of the cells by which a pose is proved to be out of reach [rad]


def needs(problem: Problem, causes: Iterable[Cause], deadline: float = np.inf) -> list[Need]:
    """Return which limits, each widened alone, would let a motion exist.

    Parameters
    ----------
    problem : Problem
        Without a motion.
    causes : sequence of Cause
        What is known to block it: the limits to be tried first.
    deadline : float
        As :func:`time.perf_counter` tells it; what is found by then is returned.

    Returns
    -------
    list of Need
        The one that has to give least, by at most 1 rad or 10 m, with its place on the path; others that were found to
        need as little follow. From the structure of the angle domain, which is computed, not proved.
    """
    sides = [(cause.joint, cause.kind.split()[0]) for cause in causes if cause.kind.endswith("limit")]
    found = _least(problem, sides, lambda *wider: leads_on(widened(problem, *wider)), deadline)
    return [Need(need.joint, need.side, need.by, _place(problem, need, deadline), need.unit) for need in found]


def needs_of_pose(problem: Problem, deadline: float = np.inf) -> list[Need]:
    """Return which limits, each widened alone, would let a posture exist where the path is blocked.

    Parameters
    ----------
    problem : Problem
        Blocked somewhere; the middle of the longest stretch is looked at, where it is likely to need most.
    deadline : float
        As :func:`time.perf_counter` tells it; what is found by then is returned.

    Returns
    -------
    list of Need
        The one that has to give least, by at most 1 rad or 10 m; others that need as little follow. That less does not
        do is proved by a cover without cells; where the problem's own has cells, nothing is said.
    """
    low, high = max((part.r for part in problem.blocked), key=lambda ends: ends[1] - ends[0])
    r = 0.5 * (low + high)

    def opens(joint: int, side: str, by: float) -> bool:
        arm = problem.arm.relaxed(*_slack(problem, joint, side, by))
        return len(arm.cover(problem.elbow).cells(problem.path(r), _COARSE)) > 0

    return [Need(need.joint, need.side, need.by, r, need.unit) for need in _least(problem, (), opens, deadline)]


def _least(
    problem: Problem, first: Iterable[tuple[int, str]], opens: Callable[[int, str, float], bool], deadline: float
) -> list[Need]:
    """Return the limits that have to give least for `opens` (joint, side, by) to hold, those of `first` tried first."""
    limits, best, found = problem.arm.limits, _FARTHEST, []
    if opens(0, "lower", 0.0):  # nothing says that any has to give
        return []
    every = [(joint, side) for joint in range(problem.arm.n) for side in ("lower", "upper")]
    for joint, side in dict.fromkeys([*first, *every]):
        if not np.isfinite((limits.lower if side == "lower" else limits.upper)[joint]):
            continue
        low, high = 0.0, min(best, _FARTHEST if limits.slides[joint] else _MOST)
        if time.perf_counter() > deadline or not opens(joint, side, high):
            continue
        while high - low > _SHARP * high and time.perf_counter() <= deadline:
            middle = 0.5 * (low + high) if low > 0.0 else 0.25 * high
            low, high = (low, middle) if opens(joint, side, middle) else (middle, high)
        best = high
        found.append(Need(joint + 1, side, high, unit=limits.units[joint]))
    found.sort(key=lambda need: need.by)
    return [need for need in found if need.by <= found[0].by * (1 + 2 * _SHARP)]


def widened(problem: Problem, joint: int, side: str, by: float) -> Problem:
    """Return the problem with one limit of a joint, counted from 0, wider by `by` [rad]."""
    return with_arm(problem, problem.arm.relaxed(*_slack(problem, joint, side, by)))


def _slack(problem: Problem, joint: int, side: str, by: float) -> tuple[FloatArray, FloatArray]:
    """Return by how much lower and upper limits give (n,) where one of them does."""
    one = by * (np.arange(problem.arm.n) == joint)
    return (one, 0.0 * one) if side == "lower" else (0.0 * one, one)


def _place(problem: Problem, need: Need, deadline: float) -> float | None:
    """Return where the passage is that opens: a proof for a little less has to look there most closely."""
    nearly = widened(problem, need.joint - 1, need.side, _JUST_NOT * need.by)
    cover = nearly.arm.slabs(nearly.path, nearly.elbow)
    chains = Chains(cover, start=ends(nearly, "start"), end=ends(nearly, "end"))
    if not chains.prove(min(deadline, time.perf_counter() + _SECONDS)).proved:
        return None
    widths = np.array([slab.high - slab.low for slab in chains.slabs[1:-1]])
    middles = np.array([0.5 * (slab.high + slab.low) for slab in chains.slabs[1:-1]])
    return float(np.median(middles[widths <= 1.01 * widths.min()]))
