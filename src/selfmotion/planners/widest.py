"""The motion that keeps farthest from obstacles, or from singular postures, and a proof that none keeps farther."""

from __future__ import annotations

import time
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple, cast

import numpy as np

from selfmotion._checks import choice, number, positive
from selfmotion._types import FloatArray
from selfmotion.certificate.chains import Chains
from selfmotion.certificate.joined import ends
from selfmotion.constrained import Constraint, SingularityMargin, unconstrained
from selfmotion.deadline import OutOfTimeError
from selfmotion.errors import InfeasibleError, InvalidInputError, NothingFeasibleError, UndecidedError
from selfmotion.optimizers import Progress
from selfmotion.planners.base import Planner
from selfmotion.planners.globally_optimal import Global
from selfmotion.planners.widest_chain import COARSE, FINE, WidestChain, widest_chain
from selfmotion.plans import Plan
from selfmotion.problem import CHECKS, Margin, Problem
from selfmotion.refinement import Optima, start_from

if TYPE_CHECKING:
    from selfmotion.arms.cells import Cover

_PLACES = 65  # along the path that are looked at
_ZOOMS, _WITHIN = 4, 9  # looks nearer and nearer at that place, and places looked at each time
_LOOK = 0.1  # cells whose ends are looked at [rad]
_SPACING = 0.02  # cells by which it is proved that no posture there keeps farther away [rad]
_RELATIVE = 1e-3  # by how much more is tried at first
_UNIT = 1.0  # least singular value that is measured from
_ROUNDING = 1e-9
_HARDLY = 0.3  # of the tolerance, by which less is tried than postures have
_TOLERANCE = 1e-3  # of motions that need not be the shortest
_FIRST_MOTION = 1.0  # gap at which the shortest motion is of no interest
_FOR_PROOFS, _FOR_MOTIONS = 0.4, 0.75  # parts of the time, then the shortest of the widest motions is looked for
_PART = 0.25  # of the time left of its kind that one try may take


class Try(NamedTuple):
    """Whether a motion keeps a margin.

    Attributes
    ----------
    margin : float
    answer : str
        ``"motion"``, ``"none"`` if it is proved that there is none, else ``"unknown"``.
    """

    margin: float
    answer: str


class Widest(Planner):
    """Keeps as far as possible from obstacles, or from singular postures, and proves that no motion keeps farther.

    Parameters
    ----------
    margin : {"least_singular_value", "clearance"}
        What is to be as large as possible where it is least along the motion, by its name in a problem.
    tolerance : float
        Relative distance between the margin that is kept and the one that is proved to be out of reach at which to
        stop.
    gap : float
        The motion is the shortest of those that keep the margin, up to this relative distance; see :class:`Global`.
    time_limit : float
        Seconds after which the widest motion and the best proof so far are the answer.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    Notes
    -----
    The objective is ``max_θ min_r m(θ(r))`` over all continuous motions. ``m`` is a constraint's margin, and whether
    there is a motion with ``m ≥ M`` is what the global planner answers: by a motion, or by a proof that there is none.
    Bisection does the rest, from the narrowest place of the path, where no posture has more than its self-motion
    allows. Where an answer is not found in time, motions below and proofs above are looked for, so both ends of the
    interval that is told, ``parameters["kept"]`` and ``parameters["at_most"]``, stand whatever was left open between
    them. What the problem itself asks for is kept in any case.

    The plan's problem is the one that asks for the margin that is kept. Of all its motions none costs less than
    ``parameters["cost_at_least"]``; ``lower_bound`` is left None, since motions nearer by may cost less.

    For arms with one redundant degree of freedom. Of an arm that is not rigorous nothing is proved, and ``at_most`` is
    None.
    """

    kind = "widest"

    def __init__(
        self,
        margin: Margin = "least_singular_value",
        tolerance: float = 1e-2,
        gap: float = 1e-3,
        time_limit: float = 60.0,
    ) -> None:
        self.margin = cast("Margin", choice("margin", margin, CHECKS))
        self.tolerance = number("tolerance", tolerance, 1e-6, 1.0)
        self.gap = number("gap", gap, 1e-9, 1.0)
        self.time_limit = positive("time_limit", time_limit)

    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion; see :meth:`Planner.plan`."""
        if problem.arm.n_u != 1:
            raise InvalidInputError(
                "planner",
                f"widest needs an arm with one redundant degree of freedom, and this one has {problem.arm.n_u}",
                "use planner refine with the margin as a constraint, or keep the direction of the last link",
            )
        if self.margin == "clearance" and (problem.scene is None or not problem.scene.obstacles):
            raise InvalidInputError("planner.margin", "is clearance, and there is no obstacle", "give obstacles")
        return _Search(self, problem, progress).plan()


class _Search:
    """One run of the planner."""

    def __init__(self, planner: Widest, problem: Problem, progress: Progress | None) -> None:
        self.planner, self.problem, self.progress = planner, problem, progress
        self.began = time.perf_counter()
        asked = problem.scene.clearance if planner.margin == "clearance" and problem.scene else 0.0
        self.low = problem.least_singular_value or 0.0 if planner.margin == "least_singular_value" else asked
        self.high = np.inf
        self.open = problem.without("start").without("end")
        self.tries: list[Try] = []
        self._chain: WidestChain | None = None
        self._grid = np.linspace(0.0, 1.0, _PLACES)
        self.widest: Plan

    @cached_property
    def _measure(self) -> Constraint:
        """What the margin is told by: how far a posture is from what is asked of it."""
        arm, scene = unconstrained(self.problem.arm), self.problem.scene
        if scene is not None and self.planner.margin == "clearance":
            return type(scene)(arm, scene.obstacles)
        return SingularityMargin(arm, _UNIT)

    def plan(self) -> Plan:
        until_proofs, until_motions, deadline = (self._at(part) for part in (_FOR_PROOFS, _FOR_MOTIONS, 1.0))
        self.widest = Global(_FIRST_MOTION, self.planner.time_limit).plan(self.problem)
        self.high = max(self._narrowest(), self.low)  # which a motion keeps
        self._follow_the_chain(until_proofs)
        if self.problem.arm.rigorous:
            self._prove(until_proofs)
        self._look_for_motions(until_motions)
        best = self._shortest(max(deadline - time.perf_counter(), 1e-3))
        settings = {name: getattr(self.planner, name) for name in ("margin", "tolerance", "gap", "time_limit")}
        parameters = {
            "settings": settings,
            "kept": self.low,
            "at_most": self.high if self.problem.arm.rigorous else None,
            "cost_at_least": best.lower_bound,
            "stopped": self._stopped,
            "tries": [each._asdict() for each in self.tries],
        }
        seconds = time.perf_counter() - self.began
        return Plan(best.problem, best.motion, self.planner.kind, parameters, best.evaluations, seconds)

    @property
    def _stopped(self) -> str:
        if not self.problem.arm.rigorous:
            return "nothing is proved of this arm"
        if self.high - self.low <= self._step * (1.0 + _ROUNDING):
            return "to the tolerance asked for"
        return f"until nothing more was decided in the time limit of {self.planner.time_limit:g} s"

    def _at(self, part: float) -> float:
        return self.began + part * self.planner.time_limit

    @property
    def _step(self) -> float:
        """What the margin that is kept may be short of the best."""
        return self.planner.tolerance * max(self.low, self.planner.tolerance * self.high)

    def _follow_the_chain(self, until: float) -> None:
        """Look for a motion that keeps hardly less than the widest chain of postures."""
        try:
            found = (widest_chain(self.problem, self._margins, fineness, until) for fineness in (COARSE, FINE))
            chain = self._chain = next((one for one in found if one is not None), None)
        except OutOfTimeError:
            return
        if chain is not None and self.low < chain.margin < self.high:
            less = chain.margin * (1.0 - _HARDLY * self.planner.tolerance)
            self._try(max(less, 0.5 * (self.low + chain.margin)), self._share(until))

    def _look_for_motions(self, until: float) -> None:
        """Raise the margin that is kept."""
        ceiling = self.high
        while ceiling - self.low > self._step and time.perf_counter() < until:
            wanted = 0.5 * (self.low + ceiling)
            if not self._try(wanted, self._share(until)):
                ceiling = wanted

    def _try(self, margin: float, seconds: float) -> bool:
        """Look for a motion that keeps a margin; return whether there is one, which is the widest from then on."""
        found = self._motion(margin, seconds)
        self._noted(margin, "unknown" if found is None else "motion")
        if found is not None:
            self.low, self.widest = margin, found
        return found is not None

    def _motion(self, margin: float, seconds: float) -> Plan | None:
        """Return a motion that keeps a margin, near the widest so far, near the widest chain, or anywhere."""
        problem, deadline = self._asked(margin), time.perf_counter() + seconds
        if problem is None:
            return None
        starts = [(self.widest(self._grid), self._grid)]
        starts += [] if self._chain is None else [(self._chain.q, self._chain.r)]
        for q, r in starts:
            optima = Optima(problem, _TOLERANCE, deadline)
            optimum = optima.add(start_from(problem, q, r), near=True)
            if optimum is not None and not optimum.check.holds:
                optimum = optima.refined(optimum)
            if optimum is not None and optimum.check.holds:
                return Plan(problem, optimum.motion, self.planner.kind, {}, optima.iterations)
        try:
            return Global(_FIRST_MOTION, max(deadline - time.perf_counter(), 1e-3)).plan(problem)
        except (InfeasibleError, NothingFeasibleError, UndecidedError):
            return None

    def _prove(self, until: float) -> None:
        """Lower what is proved to be out of reach, at first to hardly more than what is kept."""
        floor, wanted = self.low, self.low + self._step
        while self.high - floor > self._step and time.perf_counter() < until:
            if self._is_out_of_reach(wanted, self._share(until)):
                self.high = wanted
            else:
                floor = wanted
            wanted = 0.5 * (floor + self.high)

    def _is_out_of_reach(self, margin: float, seconds: float) -> bool:
        problem = self._asked(margin)
        if problem is None or not problem.has_slabs:
            return False
        slabs, deadline = problem.arm.slabs(problem.path, problem.elbow), time.perf_counter() + seconds
        chains = Chains(slabs, start=ends(problem, "start"), end=ends(problem, "end"), deadline=deadline)
        proved = chains.prove(deadline).proved
        self._noted(margin, "none" if proved else "unknown")
        return proved

    def _asked(self, margin: float) -> Problem | None:
        """Return the problem that asks for a margin, None if what start or end are given as does not keep it."""
        try:
            return self.problem.with_margin(self.planner.margin, margin)
        except InvalidInputError:
            return None

    def _share(self, until: float) -> float:
        return max(_PART * (until - time.perf_counter()), 1e-3)

    def _noted(self, margin: float, answer: str) -> None:
        self.tries.append(Try(float(margin), answer))
        if self.progress is not None:
            self.progress(len(self.tries), 0, self.widest.cost)

    def _shortest(self, seconds: float) -> Plan:
        """Return the shortest motion that keeps the margin, or the one that is known to keep it."""
        try:
            return Global(self.planner.gap, seconds).plan(self.widest.problem)
        except (NothingFeasibleError, UndecidedError):
            return self.widest

    def _narrowest(self) -> float:
        """Return a margin that no posture has at the narrowest place of the path, nor what start and end are given as.

        Where that place is, postures at the ends of cells tell; what is true there, cells that leave nothing out.
        """
        cover, places = self.problem.arm.cover(self.problem.elbow), np.linspace(0.0, 1.0, _PLACES)
        for _ in range(_ZOOMS):
            widths = [self._width(cover, r) for r in places]
            k = int(np.argmin(widths))
            narrowest, width = float(places[k]), widths[k]
            places = np.linspace(places[max(k - 1, 0)], places[min(k + 1, len(places) - 1)], _WITHIN)
        here = self._out_of_reach_at(narrowest, max(width, self.low))
        return min(here, self._width_given("start"), self._width_given("end"))

    def _width(self, cover: Cover, r: float) -> float:
        """Return the largest margin of the postures at r that are looked at."""
        cells = cover.cells(self.problem.path(r), _LOOK)
        return float(self._margins(np.concatenate([cells.a, cells.b])).max(initial=-np.inf))

    def _width_given(self, name: Literal["start", "end"]) -> float:
        """Return the largest margin of what a given posture may be; infinite where that may be anything."""
        q = ends(self.problem, name).q
        if q is None:
            return np.inf
        q = q[np.isfinite(q).all(axis=1)]
        q = q[self.problem.arm.limits.admit(q)]
        return float(self._margins(q).max(initial=-np.inf))

    def _margins(self, q: FloatArray) -> FloatArray:
        """Return the margin of postures (k, n), shape (k,)."""
        least = self._measure.least_margins(q)[0]
        return least + _UNIT if self.planner.margin == "least_singular_value" else least

    def _out_of_reach_at(self, r: float, width: float) -> float:
        """Return a margin that no posture at r has, hardly above the `width` that postures seen there have."""
        x, below, step = self.problem.path(r), width, _RELATIVE * max(width, self._measure.scale * _RELATIVE)
        while not self._is_empty(x, below + step):
            below, step = below + step, 2.0 * step
        above = below + step
        while above - below > 0.1 * self.planner.tolerance * above:
            middle = 0.5 * (below + above)
            below, above = (below, middle) if self._is_empty(x, middle) else (middle, above)
        return above

    def _is_empty(self, x: FloatArray, margin: float) -> bool:
        problem = self.open.with_margin(self.planner.margin, margin)
        return len(problem.arm.cover(problem.elbow).cells(x, _SPACING)) == 0
