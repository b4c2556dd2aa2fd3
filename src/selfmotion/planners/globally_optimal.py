"""The globally shortest motion of an arm with one redundant degree, with a proof of how far it is from the best."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from selfmotion._checks import number, positive
from selfmotion._types import FloatArray
from selfmotion.domain import blocked_stretches
from selfmotion.errors import InfeasibleError, NothingFeasibleError
from selfmotion.optimizers import Progress
from selfmotion.planners.base import Planner
from selfmotion.plans import Plan
from selfmotion.problem import Posture, Problem
from selfmotion.refinement import Optima, Optimum, random_starts, start_from

_SLICES = 24
_DENSITY = 2.5
_FALLBACK = 8


class Global(Planner):
    """Minimises over all continuous motions and proves a lower bound."""

    kind = "global"

    def __init__(self, gap: float = 1e-4, time_limit: float = 60.0) -> None:
        self.gap = number("gap", gap, 1e-9, 1.0)
        self.time_limit = positive("time_limit", time_limit)

    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion; see :meth:`Planner.plan`."""
        import scipy.linalg  # noqa: F401 (its BLAS must be loaded to be limited)
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1, "blas"):
            return _Search(self, problem, progress).plan()


class _Search:
    def __init__(self, planner: Global, problem: Problem, progress: Progress | None) -> None:
        self.planner, self.problem, self.progress = planner, problem, progress
        self.began = time.perf_counter()
        self.deadline = self.began + planner.time_limit
        self.optima = Optima(problem, min(1e-6, 0.01 * planner.gap), self.deadline)
        self.best: Optimum | None = None
        self.threshold = np.inf
        self.bound = 0.0
        self.log: list[dict[str, Any]] = []

    def plan(self) -> Plan:
        from selfmotion.arms.planar_cover import PlanarCover
        from selfmotion.certificate.tube import OutOfTimeError, first_tube

        problem = self.problem
        blocked = blocked_stretches(problem.arm, problem.path, problem.samples, problem.elbow_branches)
        if blocked:
            raise InfeasibleError(blocked)
        cover = PlanarCover(problem.arm, problem.path, problem.elbow)
        h = 1.0 / _SLICES
        stopped = "time"
        try:
            tube = first_tube(
                cover, problem.objective.kind, problem.weights, problem.path.grid(_SLICES), _DENSITY * h**1.5,
                self._given(problem.start, 0.0), self._given(problem.end, 1.0),
            )  # fmt: skip
            while True:
                if tube.is_empty:
                    self.bound = max(self.bound, self.threshold)
                    stopped = "empty"
                    break
                self.bound = max(self.bound, min(tube.evaluate(self.deadline), self.threshold))
                self._improve(tube)
                size = tube.size
                tube.prune(self.threshold)
                self.log.append({"slices": len(tube.slices), "cells": size, "left": tube.size, "bound": self.bound,
                                 "threshold": self.threshold, "t": time.perf_counter() - self.began})
                if self._gap() <= self.planner.gap or time.perf_counter() > self.deadline:
                    stopped = "gap"
                    break
                if tube.is_empty:
                    continue
                h *= 0.5
                tube = tube.refined(_DENSITY * h**1.5, self.threshold, self.deadline)
        except OutOfTimeError:
            pass
        best, failure = self.optima.best()
        if best is None:
            if np.isinf(self.bound):
                raise InfeasibleError([])
            raise NothingFeasibleError(f"no motion: {failure}", "", 0, 1.0)
        seconds = time.perf_counter() - self.began
        plan = Plan(problem, best.motion, self.planner.kind, {"log": self.log, "stopped": stopped}, self.optima.iterations, seconds)
        plan.lower_bound = self.bound
        plan.gap = (plan.cost + plan.cost_error - self.bound) / plan.cost
        return plan

    def _gap(self) -> float:
        return (self.threshold - self.bound) / self.threshold if np.isfinite(self.threshold) else np.inf

    def _improve(self, tube: Any) -> None:
        q = self.problem.arm.limits.continuous(tube.cheapest())
        self._add(start_from(self.problem, q, tube.r))
        if self.best is None:
            for k, start in enumerate(random_starts(self.problem, np.random.default_rng(0), 8)):
                if k >= _FALLBACK:
                    break
                self._add(start)

    def _add(self, start: Any) -> None:
        optimum = self.optima.add(start)
        if optimum is None:
            return
        cost = self.optima.cost_of(optimum.motion)
        if cost < self.threshold:
            self.best, self.threshold = optimum, cost

    def _given(self, posture: Posture | None, r: float) -> FloatArray | None:
        if posture is None:
            return None
        if posture.q is not None:
            return posture.q[None]
        solved = [self.problem.arm.solve(self.problem.path(r), posture.u, b) for b in self.problem.elbow_branches]
        return np.array([q for q, ok in solved if ok]).reshape(-1, self.problem.arm.n)
