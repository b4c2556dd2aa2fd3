"""Locally shortest motions, each found on coarse knots and refined until its cost no longer changes."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.problem import Problem
from selfmotion.quadrature import integrate
from selfmotion.refinement.closing import ClosedSpline
from selfmotion.refinement.collocation import Collocation
from selfmotion.refinement.dips import dips, spread
from selfmotion.refinement.newton import minimise
from selfmotion.refinement.spline import SplineSpace
from selfmotion.refinement.starts import Start
from selfmotion.verification import Failure, Verification, verify_motion

_COARSE = 48  # spans that starts are compared on
_NEAR = 72  # spans for a start that is near its optimum
_MOST_SPANS = 400
_MOST_CORNERS, _FEW_CORNERS = 128, 48  # the latter if the tolerance is loose
_JUST_BEFORE = 1e-9  # a corner, in r
_TURN = 1e-3  # change of x' at a corner, as a part of the path's length
_LEVELS = 8
_OFF_PATH = 2  # levels on which a spline may leave the path: one that jumps from branch to branch always will
_EXACT = 1e-7  # a cost that two quadratures agree upon to this part needs no finer knots …
_AGREED = 0.1  # … if that is also this part of the tolerance …
_LOOSE, _AGREED_LOOSELY = 1e-4, 0.3  # … nor, if the tolerance is above the former, one to the latter part of it
_MEASURED = 1e-2  # of the tolerance: error of a motion's cost
_MOST_PANELS = 800  # for that, besides spans and breaks
_SURE = 1e-2  # error of a cost, as a part of it, above which a motion jumps or leaves the path somewhere
_ROUGH = 1e-6  # correction [rad] of spans that are bisected, or those corrected by half the largest if that is less
_DIPS = 0.3  # of the tolerance: dips below the arm's constraints, in their scales, whose spans are bisected
_SHIFTS = 8  # times that constraints are shifted by what motions dip below them …
_MORE = 1.1  # … times this …
_A_LITTLE = 1e-7  # … and by so much more of their scale
_MOST_SHIFTED = 60  # iterations after a shift
_COARSE_TOLERANCE = 1e-7  # of Newton's method on the coarse level
_REFINED = 3  # optima that are refined to the end, at most, once one of them holds or time is up
_CAUTION = 10.0  # times as much as refinement changed one cost it may change another
_CAUTION_WITH_KINKS = 0.3  # what rounding off a kink changes, it changes of all costs alike
_COLD, _WARM, _HOT = 1e-2, 1e-5, 1e-7  # first weight of the barrier, far from an optimum, near it and all but there
_MOST_FINE = 100  # iterations on a finer level
_LEAST_WITH_KINKS = 1e-5  # tolerance that is worth its time for objectives with kinks
# Two optima are one if their costs agree to this part and their joints to this angle [rad].
_SAME_COST = 1e-4
_SAME_ANGLE = 0.05
_COMPARED_AT = np.linspace(0.0, 1.0, 65)
# Rounding of the objectives' kinks on the coarse level, as a part of the path's length by the arm's reach, which is
# about how fast joints move; and what each finer level makes of it.
_WIDTH = 0.1
_NARROWER = 0.25
_NARROWEST = 3e-4


@dataclass
class Optimum:
    """A locally shortest motion and how often starts ended in it; `c` are its free coefficients, shape (k,)."""

    problem: Problem
    start: Start
    collocation: Collocation
    c: FloatArray
    cost: float
    found: int
    settled: bool = False
    """Whether its knots are as fine as they need be, or as time allowed."""

    @property
    def coefficients(self) -> FloatArray:
        """Of the spline, shape (n, m)."""
        return self.collocation.coefficients(self.c)

    @cached_property
    def motion(self) -> ClosedSpline:
        """The motion; free joints start in [−π, π], unless the problem says otherwise."""
        arm, ends, coefficients = self.problem.arm, self.collocation.ends, self.coefficients
        if ends.start is None and ends.end is None:
            turns = np.where(arm.limits.limited, 0.0, np.rint(coefficients[:, 0] / TAU))
            coefficients = coefficients - TAU * turns[:, None]
        return ClosedSpline(arm, self.problem.path, self.collocation.space, coefficients, self.collocation.box)

    @cached_property
    def dips(self) -> FloatArray:
        """By how much the motion falls below the arm's constraints on postures, shape (spans, m), in their scales."""
        return dips(self.collocation, self.motion)

    @cached_property
    def check(self) -> Verification:
        """What is found when the motion is measured."""
        return verify_motion(self.problem, self.motion)

    def is_same(self, other: Optimum) -> bool:
        """Return whether both are one motion, but for whole turns."""
        if abs(self.cost - other.cost) > _SAME_COST * abs(self.cost):
            return False
        mine, theirs = (o.collocation.space.spline(o.coefficients)(_COMPARED_AT) for o in (self, other))
        steps = theirs - mine
        # Shifted by whole turns a motion costs the same.
        return bool(np.abs(steps - TAU * np.rint(steps[0] / TAU)).max() <= _SAME_ANGLE)


class Optima:
    """The locally shortest motions that starts ended in.

    Parameters
    ----------
    problem : Problem
    tolerance : float
        Relative change of the cost from one level of knots to the next at which refinement stops.
    deadline : float
        On the clock of ``time.perf_counter``.

    Attributes
    ----------
    found : list of Optimum
    ended, iterations : int
        Starts from which Newton's method converged, and its iterations in all.
    """

    def __init__(self, problem: Problem, tolerance: float, deadline: float) -> None:
        self.problem, self.tolerance, self.deadline = problem, tolerance, deadline
        self.found: list[Optimum] = []
        self.ended = self.iterations = 0
        self._scale = float(problem.weights.max())  # the solver's weights are 1 at most

    @property
    def uncertainty(self) -> float:
        """By how much, as a part of it, a motion's cost may be mistaken."""
        return _MEASURED * self.tolerance

    @cached_property
    def _space(self) -> SplineSpace:
        return SplineSpace.with_spans(_COARSE, self._corners)

    def best(self) -> tuple[Optimum | None, Failure | None]:
        """Refine the optima that could turn out to be the best, and return the best that holds; or why one does not."""
        self.found.sort(key=lambda optimum: optimum.cost)
        best: Optimum | None = None
        failure: Failure | None = None
        shift = 0.0  # what refinement has changed of a cost so far
        caution = _CAUTION_WITH_KINKS if self.problem.objective.has_kinks else _CAUTION
        for k, optimum in enumerate(self.found):
            late = k >= _REFINED and time.perf_counter() > self.deadline
            if late or (best is not None and (k >= _REFINED or optimum.cost - caution * shift > best.cost)):
                break
            finer = self.refined(optimum)
            shift = max(shift, abs(finer.cost - optimum.cost))
            self.found[k] = finer
            if finer.check.holds and (best is None or finer.cost < best.cost):
                best = finer
            elif not finer.check.holds:
                failure = failure or finer.check.failures[0]
        self.found.sort(key=lambda optimum: optimum.cost)
        return best, failure

    @cached_property
    def _corners(self) -> FloatArray:
        """Return where the path turns sharply, so that knots are put there: the sharpest corners if there are many."""
        path, breaks = self.problem.path, self.problem.path.breaks
        if not len(breaks):
            return breaks
        before = np.maximum(breaks - _JUST_BEFORE, 0.0)
        turn = np.linalg.norm(path(breaks, 1) - path(before, 1), axis=1)
        most = _FEW_CORNERS if self.tolerance > _LOOSE else _MOST_CORNERS
        sharp = np.argsort(-turn, kind="stable")[:most]
        return np.sort(breaks[sharp[turn[sharp] > _TURN * path.length]])

    def _collocation(self, start: Start, space: SplineSpace, width: float) -> Collocation:
        problem, weights = self.problem, self.problem.weights / self._scale
        rate = problem.path.length / problem.arm.reach
        return Collocation(
            problem.arm, problem.path, problem.objective, weights, start.box, space, start.ends, width * rate
        )

    def add(self, start: Start, near: bool = False) -> Optimum | None:
        """Refine one start on the coarse level, file the optimum it ends in and return it, if there is one.

        Parameters
        ----------
        start : Start
        near : bool
            Whether the start is thought to be near its optimum: it is then kept near, and knots are where it moves.
        """
        space, mu = self._space, _COLD
        if near:
            space, mu = SplineSpace.along(start.r, start.q, _NEAR, self._corners), _WARM
        collocation = self._collocation(start, space, _WIDTH)
        at = space.collocation
        sampled = np.stack([np.interp(at, start.r, joint) for joint in start.q.T], axis=-1)
        minimum = minimise(collocation, space.interpolating(sampled), _COARSE_TOLERANCE, mu, deadline=self.deadline)
        if minimum is None:
            return None
        self.iterations += minimum.iterations
        self.ended += minimum.converged
        cost = minimum.cost * self._scale
        optimum = Optimum(self.problem, start, collocation, minimum.c, cost, found=int(minimum.converged))
        for k, known in enumerate(self.found):
            if known.is_same(optimum):
                found = known.found + optimum.found
                self.found[k] = replace(optimum if cost < known.cost else known, found=found)
                return self.found[k]
        self.found.append(optimum)
        return optimum

    def refined(self, optimum: Optimum) -> Optimum:
        """Return an optimum on knots so fine that the cost no longer changes, or as fine as time allows."""
        if optimum.settled:
            return optimum
        tolerance, width = self.tolerance, _NARROWEST
        if self.problem.objective.has_kinks:
            tolerance, width = max(tolerance, _LEAST_WITH_KINKS), _WIDTH
        agreed = _AGREED_LOOSELY * tolerance if tolerance > _LOOSE else min(_AGREED * tolerance, _EXACT)
        before, cost, off_path = np.inf, np.inf, 0
        for _ in range(_LEVELS):
            space, motion = optimum.collocation.space, optimum.motion
            cost = self.cost_of(motion)
            off_path += not np.isfinite(cost)
            if time.perf_counter() > self.deadline or off_path > _OFF_PATH:
                break
            blur = abs(cost - optimum.cost)  # by rounding and by what the spline is corrected
            settled = np.isfinite(cost) and (abs(cost - before) <= tolerance * cost or blur <= agreed * cost)
            sharp = width <= _NARROWEST or blur <= tolerance * cost
            correction = _corrections(motion)
            rough = correction > min(_ROUGH, 0.5 * correction.max())
            if optimum.collocation.constraints:
                dipping = optimum.dips.max(axis=1) > _DIPS * tolerance
                rough, settled = rough | dipping, settled and not dipping.any()
            if sharp and (settled or len(rough) + rough.sum() > _MOST_SPANS):
                break
            finer = space.bisected(rough) if len(rough) + rough.sum() <= _MOST_SPANS else space
            before, width = cost, max(_NARROWER * width, _NARROWEST)
            collocation = self._collocation(optimum.start, finer, width)
            coefficients = finer.interpolating(space.spline(optimum.coefficients)(finer.collocation))
            minimum = minimise(collocation, coefficients, 0.01 * tolerance, _WARM, _MOST_FINE, self.deadline)
            if minimum is None:
                break
            self.iterations += minimum.iterations
            optimum = replace(optimum, collocation=collocation, c=minimum.c, cost=minimum.cost * self._scale)
        else:
            cost = self.cost_of(optimum.motion)
        if optimum.collocation.constraints and optimum.dips.any():
            optimum = self._cleared(optimum, 0.01 * tolerance)
            cost = self.cost_of(optimum.motion)
        return replace(optimum, cost=cost, settled=True)

    def _cleared(self, optimum: Optimum, tolerance: float) -> Optimum:
        """Return an optimum with the constraints on postures shifted until it keeps them between the points too."""
        collocation, shift = optimum.collocation, np.asarray(optimum.collocation.shift)
        for _ in range(_SHIFTS):
            deep = spread(collocation, optimum.dips)
            if not deep.any():
                break
            shift = shift + _MORE * deep + _A_LITTLE  # everywhere: else what is pressed down here comes up there
            shifted = collocation.shifted(shift)
            minimum = minimise(shifted, optimum.coefficients, tolerance, _HOT, _MOST_SHIFTED)
            if minimum is None:
                break
            self.iterations += minimum.iterations
            optimum = replace(optimum, collocation=shifted, c=minimum.c)
        return optimum

    def cost_of(self, motion: ClosedSpline) -> float:
        """Return the true cost of a motion, to a small part of the tolerance; infinite if it cannot be measured.

        The quadrature of its spline is not enough: motions may start as steeply as a square root, at singular postures.
        """
        objective, weights = self.problem.objective, self.problem.weights
        if np.isinf(motion.correction(motion.space.nodes)).any():
            return np.inf

        def speed(r: FloatArray) -> FloatArray:
            return objective.chord(motion.rates(r), np.ones(len(r)), weights)

        edges, breaks = motion.space.edges, self.problem.path.breaks
        if len(breaks) <= _MOST_PANELS:  # where rates jump
            edges = np.union1d(edges, breaks)
        found = integrate(speed, edges, self.uncertainty, len(edges) + _MOST_PANELS)
        return found.value if found.error <= _SURE * found.value else np.inf


def _corrections(motion: ClosedSpline) -> FloatArray:
    """Return how much the motion is corrected on each span of its spline, at most [rad]."""
    edges = motion.space.edges
    looked_at = edges[:-1, None] + np.diff(edges)[:, None] * np.linspace(0.0, 1.0, 7)[1:-1]
    return motion.correction(looked_at.ravel()).reshape(looked_at.shape).max(axis=1)
