"""The globally shortest motion of an arm with one redundant degree, and the proof of how far it is from the best."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING, NoReturn, cast

import numpy as np

from selfmotion._checks import number, positive
from selfmotion._types import FloatArray
from selfmotion.arms.protocols import u_steps
from selfmotion.certificate.infeasibility import told, unproved
from selfmotion.certificate.joined import leads_on
from selfmotion.constrained import constraints_of, unconstrained
from selfmotion.deadline import OutOfTimeError
from selfmotion.domain import blocked_by
from selfmotion.errors import InfeasibleError, InvalidInputError, NothingFeasibleError, UndecidedError
from selfmotion.optimizers import Progress
from selfmotion.planners.base import Planner
from selfmotion.planners.reconfiguration import explained
from selfmotion.planners.widest_chain import COARSE, FINE, widest_chain
from selfmotion.plans import Plan
from selfmotion.problem import Posture, Problem, postures_of
from selfmotion.refinement import Optima, Optimum, Start, random_starts, start_from
from selfmotion.verification import Failure

if TYPE_CHECKING:
    from selfmotion.arms.cells import Cells, Cover
    from selfmotion.arms.slabs import SlabCover
    from selfmotion.certificate.result import Certificate, Level
    from selfmotion.certificate.rounds import BestMotion
    from selfmotion.certificate.tube import Chain, Tube

_SLICES = 16  # slabs to begin with …
_FEW, _ROUGH = 8, 0.1  # … and for gaps above the latter
_DENSITY = 4.0  # cells to begin with are this times h^1.5 long, slabs being h wide [rad]
_STARTS = 16  # random starts for a motion where the cheapest chords lead to none
_MARGIN = 1e-12  # relative
_STEEP = 1e5  # |dq/du| beyond which a start given by u leaves joints open
_NEAR = 1e-2  # length of cells then [rad]
_FOR_A_CHAIN = 0.25  # part of the time left in which postures that keep far away are looked for
_FOR_GROUPS = 0.25  # the same in which it is told where motions lead, as long as none is known
_FOR_A_REASON = 0.5  # part of the time left that goes into a proof that there is no motion, where it looks like that
_POLISHED = 0.1  # of the gap asked for, what the motion may cost for want of knots
_POLISHED_FOR_LARGE = 5e-3  # the same of gaps above 1e-2, but no less than 1e-5
_WITHIN = 4  # chords in a slab by which the best motion's length is known
_MANY_BREAKS = 2000  # more of them turn too little each to be looked at
_BACK = 0.05  # how near postures are that lead back to a motion [rad]
_FAST, _LONG = 3.0, 0.05  # steps of chords that may jump a gap: times the usual speed, and [rad]
_TIED = 1.0  # widest start of a cyclic motion in the first round; half as wide in every further one [rad]
_warmed: set[tuple[str, tuple[str, ...], str]] = set()  # arms and objectives whose kernels are loaded

_REFUTED = 1e-9  # relative
_ARGUMENT = "values on cells of the self-motion, pair by pair"
_ESTIMATE = "an estimate, since these cells are not proved to be all"


class Global(Planner):
    """Finds the shortest of all continuous motions and proves a lower bound on every other.

    Parameters
    ----------
    gap : float
        Relative distance (cost − lower bound)/cost at which to stop.
    time_limit : float
        Seconds after which the best motion and the best bound so far are the answer.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    Notes
    -----
    For arms with one redundant degree of freedom. All elbows, all components of the angle domain, folds, self-motion at
    a frozen r and all turns of limited joints are covered by the bound; joints with a limit on one side only count as
    free in it. Method and proof: docs/mathematics. What was proved is in the plan's ``lower_bound``, ``gap`` and
    ``certificate``. Of an arm that is not rigorous the same figures are ``estimated_bound`` and ``estimated_gap``.
    """

    kind = "global"

    def __init__(self, gap: float = 1e-4, time_limit: float = 60.0) -> None:
        self.gap = number("gap", gap, 1e-9, 1.0)
        self.time_limit = positive("time_limit", time_limit)

    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion; see :meth:`Planner.plan`."""
        import scipy.linalg  # noqa: F401 (its BLAS must be loaded to be limited)
        from threadpoolctl import threadpool_limits

        if problem.arm.n_u != 1:
            raise InvalidInputError(
                "planner",
                f"global needs an arm with one redundant degree of freedom, and this one has {problem.arm.n_u}",
                "use planner refine, or keep the direction of the last link",
            )
        with threadpool_limits(1, "blas"):
            _warm(problem)
            return _Search(self, problem, progress).plan()


class _Search:
    """One run of the planner."""

    def __init__(self, planner: Global, problem: Problem, progress: Progress | None) -> None:
        self.planner, self.problem, self.progress = planner, problem, progress
        self.began = time.perf_counter()
        self.deadline = self.began + planner.time_limit
        tolerance = min(max(_POLISHED_FOR_LARGE * planner.gap, 1e-5), _POLISHED * planner.gap)
        self.optima = Optima(problem, tolerance, self.deadline)
        self.best: Optimum | None = None
        self.failed: list[Optimum] = []  # that do not hold on the finest knots either
        self.threshold = np.inf  # motions that cost more need not be in the tube
        self.bound = 0.0
        self.tubes: list[Tube] = []
        self.levels: list[Level] = []
        self.undecided: UndecidedError | None = None  # why there may be no motion
        self.asked_why = False  # whether that was looked for

    def plan(self) -> Plan:
        problem = self.problem
        if not leads_on(problem) or (problem.arm.has_structure and problem.blocked):
            self._explain()
        argument = self._prove()
        self._polish()
        best, failure = (self.best, None) if self.best is not None else self.optima.best()
        if best is None:
            self._give_up(argument, failure)
        seconds = time.perf_counter() - self.began
        settings = {name: getattr(self.planner, name) for name in ("gap", "time_limit")}
        certificate = self._certificate(argument)
        parameters = {"settings": settings, **certificate.summary()}
        plan = Plan(problem, best.motion, self.planner.kind, parameters, self.optima.iterations, seconds)
        plan.certify(certificate)
        return plan

    def _explain(self) -> None:
        """Raise the proof that there is no motion, if one is found; else remember what is known of it."""
        self.asked_why, now = True, time.perf_counter()
        error = explained(self.problem, now + _FOR_A_REASON * (self.deadline - now))
        if isinstance(error, InfeasibleError):
            raise error
        self.undecided = error

    def _prove(self) -> str:
        """Refine the tube until the gap is small enough; return what proved the bound, or why it is not better."""
        from selfmotion.certificate.tube import Setting, first_tube

        problem = self.problem
        cover = self._cover()
        kind, breaks = problem.objective.kind, problem.path.breaks
        setting = Setting(cover, problem.path, kind, problem.weights.copy(), breaks)
        slices = _FEW if self.planner.gap > _ROUGH else _SLICES
        spacing = np.full(slices + 1, _DENSITY / slices**1.5)
        try:
            tube = first_tube(
                setting, _slices(problem.path.breaks, slices), float(spacing[0]),
                self._given(cover, problem.start, 0.0), self._at_end(cover), self.deadline,
            )  # fmt: skip
            if tube.is_empty:
                self._explain()
                at = next(part.r for part in tube.slices if not len(part.cells))
                if not problem.arm.rigorous:
                    raise unproved(f"no posture inside the limits was found at r = {at:.6g}")
                raise InfeasibleError([blocked_by(problem.arm, problem.path, (at, at), problem.elbow_branches)])
            parts = [_Part(tube, spacing)]
            while parts:
                self._look_at(parts)
                if self._gap <= self.planner.gap:
                    return f"{_ARGUMENT}, to the gap asked for"
                parts = [finer for part in parts for finer in self._refined(part)]
        except OutOfTimeError:
            return f"{_ARGUMENT}, until the time limit of {self.planner.time_limit:g} s"
        except KeyboardInterrupt:
            return f"{_ARGUMENT}, until it was interrupted"
        self._leads_nowhere()
        return "no motion cheaper than the best one is left in the tube"

    def _cover(self) -> Cover:
        """Return the arm's cells: fewer of an arm whose redundancy is one joint's alone, if an end is open to it."""
        arm, elbow = self.problem.arm, self.problem.elbow
        with_an_end_open = getattr(arm, "cover_with_an_end_open", None)
        if with_an_end_open is None or (self.problem.start is not None and self.problem.end is not None):
            return arm.cover(elbow)
        return cast("Cover", with_an_end_open(elbow))

    def _look_at(self, parts: list[_Part]) -> None:
        """Prove a bound for each part, look for a better motion near the best chords, and drop what is proved worse."""
        from selfmotion.certificate.result import Level

        cells = sum(part.tube.size for part in parts)
        for part in parts:
            self._evaluate(part)
        parts[:] = [part for part in parts if not part.tube.is_empty]
        if not parts:
            self._leads_nowhere()
            return
        self._improve(min(parts, key=lambda part: part.bound).chain)
        if self.problem.cyclic:
            parts[:] = [small for part in parts for small in self._parted(part)]
            if parts:  # whose chains nearly close, unlike those of the whole
                self._improve(min(parts, key=lambda part: part.bound).chain)
        best = min((part.bound for part in parts), default=np.inf)
        self.bound = max(self.bound, min(best, self._surely))
        for part in parts:
            part.tube.prune(self.threshold)
        parts[:] = [part for part in parts if not part.tube.is_empty]
        self.tubes = [part.tube for part in parts]
        slices = max((len(part.tube.slices) for part in parts), default=0)
        self.levels.append(Level(slices, cells, self.bound, self.threshold, time.perf_counter() - self.began))
        if self.progress is not None:
            self.progress(len(self.levels), 0, self.threshold)

    def _evaluate(self, part: _Part) -> None:
        """Prove a part's bound; where its cheapest chords jump gaps that motions may not cross, without these."""
        part.bound, part.chain = part.tube.evaluate(self.deadline), part.tube.cheapest()
        if constraints_of(self.problem.arm) and self.problem.has_slabs and _jumps(part.chain):
            now = time.perf_counter()
            part.tube.connect(self._slabs, now + (_FOR_GROUPS if self.best is None else 1.0) * (self.deadline - now))
            part.bound = part.tube.evaluate(self.deadline)
            if not part.tube.is_empty:
                part.chain = part.tube.cheapest()

    @property
    def _half_time(self) -> float:
        return 0.5 * (self.began + self.deadline)

    @cached_property
    def _starts(self) -> Iterator[Start]:
        """Random starts, of which each round takes some."""
        return random_starts(self.problem, np.random.default_rng(0), 2 * _STARTS, self._half_time)

    @cached_property
    def _slabs(self) -> SlabCover:
        return self.problem.arm.slabs(self.problem.path, self.problem.elbow)

    def _leads_nowhere(self) -> None:
        """Say so if no motion leads from cell to cell at all; with a motion known, none is cheaper."""
        if self.best is None:
            self._explain()
            if not self.problem.arm.rigorous:
                raise unproved("no motion was found")
            raise InfeasibleError([told(self.problem, (0.0, 1.0))])
        self.bound, self.tubes = max(self.bound, self._surely), []

    def _refined(self, part: _Part) -> list[_Part]:
        """Return a part on more slices in shorter cells, or none if it is empty."""
        from selfmotion.certificate.rounds import finer, with_new

        kind, wanted = self.problem.objective.kind, self.planner.gap * self.threshold
        slabs, spacing = finer(part.chain, part.spacing, self._on_slabs(part.chain.r), wanted, kind)
        tube = part.tube.refined(slabs, spacing, self.threshold, self.deadline)
        return [] if tube.is_empty else [_Part(tube, with_new(spacing, slabs))]

    def _parted(self, part: _Part) -> list[_Part]:
        """Return a part in parts so narrow at the start that start and end of a cyclic motion hardly differ in them."""
        part.tube.prune(self.threshold)
        tube = part.tube.closed()
        if tube.is_empty:
            return []
        narrow = tube.width <= _TIED * 0.5 ** len(self.levels) or len(tube.slices[0].cells) == 1
        if self.best is None or narrow:
            part.tube = tube
            return [part]
        found = []
        for half in tube.halves(self._pull()):
            if not half.is_empty:
                smaller = _Part(half, part.spacing)
                smaller.bound, smaller.chain = max(part.bound, half.evaluate(self.deadline)), half.cheapest()
                found += self._parted(smaller) if smaller.bound < self.threshold else []
        return found

    def _pull(self) -> FloatArray:
        """Return multipliers of closure with which the best motion costs the same, to first order, not closing."""
        assert self.best is not None
        rates = self.best.motion.rates(np.array([0.0, 1.0]))
        weights = self.problem.weights
        return np.asarray(-self.problem.objective.smoothed(rates, weights, 1e-9).gradient.mean(axis=0))

    @property
    def _surely(self) -> float:
        """What the best motion costs at least."""
        return self.threshold * (1.0 - 2.0 * max(_MARGIN, self.optima.uncertainty))

    @property
    def _gap(self) -> float:
        return (self.threshold - self.bound) / self.threshold if np.isfinite(self.threshold) else np.inf

    def _certificate(self, argument: str) -> Certificate:
        from selfmotion.certificate.result import Certificate, TubeSlice

        slices = sorted((part for tube in self.tubes for part in tube.slices), key=lambda part: part.r)
        tube = tuple(TubeSlice(part.r, part.cells.a, part.cells.b) for part in slices)
        if self.problem.arm.rigorous:
            return Certificate(self.bound, argument, tuple(self.levels), tube)
        bound, why = self.bound, _ESTIMATE
        if bound > self.threshold * (1.0 + _REFUTED):  # by a motion through postures that were not seen
            bound, why = 0.0, "its estimate was above the cost of a motion found later, and does not count"
        return Certificate(bound, f"{argument}; {why}", tuple(self.levels), tube, rigorous=False)

    def _on_slabs(self, r: FloatArray) -> BestMotion | None:
        """Return what a round wants to know of the best motion on slabs between r (k + 1,)."""
        from selfmotion.certificate.rounds import BestMotion

        if self.best is None:
            return None
        motion, objective, weights = self.best.motion, self.problem.objective, self.problem.weights
        within = np.linspace(r[:-1], r[1:], _WITHIN, endpoint=False, axis=1).ravel()
        breaks = self.problem.path.breaks
        finer = np.union1d(np.append(within, r[-1]), breaks if len(breaks) <= _MANY_BREAKS else [])
        q, own = motion(finer), np.searchsorted(finer, r)
        lengths = np.append(0.0, np.cumsum(objective.chord(np.diff(q, axis=0), np.diff(finer), weights)))[own]
        steps = np.diff(q[own], axis=0)
        return BestMotion(np.maximum(np.diff(lengths) - objective.chord(steps, np.diff(r), weights), 0.0), steps)

    def _improve(self, chain: Chain) -> None:
        """Look for a better motion near the cheapest chords, and anywhere as long as none is known."""
        start = self.problem.start
        q = self.problem.arm.limits.lift(chain.q[None].copy(), None if start is None else start.q).q[0]
        if not self._is_known(q, chain.r):
            self._add(start_from(self.problem, q, chain.r), near=True)
        if self.best is None and not self.levels and constraints_of(self.problem.arm):
            self._pass_widely()
        if self.best is None:
            for other in islice(self._starts, _STARTS):
                if time.perf_counter() > self._half_time:
                    break
                self._add(other)
        if self.best is None and not self.asked_why:
            self._explain()
        if self.levels:
            self._polish()

    def _pass_widely(self) -> None:
        """Look for a motion where postures keep farthest from what forbids them, however long it be."""
        constraints = constraints_of(self.problem.arm)

        def margins(q: FloatArray) -> FloatArray:
            return np.min([each.least_margins(q)[0] / each.scale for each in constraints], axis=0)

        for fineness in (COARSE, FINE):
            now = time.perf_counter()
            try:
                chain = widest_chain(self.problem, margins, fineness, now + _FOR_A_CHAIN * (self.deadline - now))
            except OutOfTimeError:
                return
            if chain is not None:
                self._add(start_from(self.problem, chain.q, chain.r), near=True)
            if self.best is not None:
                return
            if fineness is COARSE:  # most likely there is no motion, and that is proved sooner than a fine chain found
                self._explain()

    def _add(self, start: Start, near: bool = False) -> None:
        """Refine a start; if it becomes a motion that holds and is better than all before, remember it."""
        optimum = self.optima.add(start, near)
        if optimum is None or any(known.is_same(optimum) for known in self.failed):
            return
        # Rounding off kinks blurs the cost on the coarse level, where a motion may not hold yet either.
        if self._accept(optimum, self.problem.objective.has_kinks) or self.best is not None:
            return
        if not self._accept(optimum, True):
            self.failed.append(optimum)

    def _is_known(self, q: FloatArray, r: FloatArray) -> bool:
        """Return whether postures q (k, n) at r are so near the best motion that they would lead back to it."""
        if self.best is None or not self.best.settled or self.problem.objective.kind == "l1":  # l1 has many optima
            return False
        return bool(np.abs(self.problem.arm.limits.steps(self.best.motion(r), q)).max() <= _BACK)

    def _polish(self) -> None:
        """Have the best motion known on knots as fine as they need be."""
        if self.best is not None and not self.best.settled and not self._accept(self.best, True):
            self.best.settled = True  # it cannot be bettered

    def _accept(self, optimum: Optimum, refined: bool) -> bool:
        if refined:
            optimum = self.optima.refined(optimum)
        cost = optimum.cost if optimum.settled else self.optima.cost_of(optimum.motion)
        cost *= 1.0 + max(_MARGIN, self.optima.uncertainty)
        if cost >= self.threshold or not optimum.check.holds:
            return False
        self.best, self.threshold = optimum, cost
        return True

    def _at_end(self, cover: Cover) -> Cells | None:
        """Return the cells of the end, if it is given: that of a motion that closes is its start's."""
        problem = self.problem
        if problem.cyclic and problem.end is None:
            return self._given(cover, problem.start, 1.0, turned=problem.cyclic == "modulo")
        return self._given(cover, problem.end, 1.0)

    def _given(self, cover: Cover, posture: Posture | None, r: float, turned: bool = False) -> Cells | None:
        """Return the cells that a given posture stands for: given by u, or `turned`, it may have any turns."""
        if posture is None:
            return None
        if posture.q is not None:
            return cover.points(posture.q[None], turned)
        arm, x = self.problem.arm, self.problem.path(r)
        branches = self.problem.elbow_branches
        if not arm.rigorous:  # whose branches are numbers, most of which there are not
            branches = [b for b in branches if arm.solve(x, posture.u, b)[1]]
        if not all((np.abs(arm.derivative(x, posture.u, b)[0]) < _STEEP).all() for b in branches):
            # At a singular posture u does not tell all joints: every posture near it is allowed.
            cells = cover.cells(x, _NEAR)
            room = (0.5 * np.abs(cells.b - cells.a) + cells.dev).sum(axis=1)  # u is a sum of joints
            return cells[np.abs(u_steps(arm, posture.u, arm.u_of(0.5 * (cells.a + cells.b))))[:, 0] <= room + _NEAR]
        return cover.points(postures_of(self.problem, posture, r), turned=True)

    def _give_up(self, argument: str, failure: Failure | None) -> NoReturn:
        if self.undecided is not None:
            raise self.undecided
        raise NothingFeasibleError(
            f"no motion was found, and none was proved not to exist: {argument}"
            + ("" if failure is None else f"; the best candidate does not hold: {failure}"),
            "give more time", self.optima.iterations, 1.0,
        )  # fmt: skip


class _Part:
    """A tube, the spacing of its cells per slice, and what was found in it."""

    def __init__(self, tube: Tube, spacing: FloatArray) -> None:
        self.tube, self.spacing = tube, spacing
        self.bound = 0.0
        self.chain: Chain


def _jumps(chain: Chain) -> bool:
    """Return whether a chain has steps that are much faster than most of them."""
    steps = np.abs(np.diff(chain.q, axis=0)).max(axis=1)
    speeds = steps / np.diff(chain.r)
    return bool(((speeds > _FAST * np.median(speeds)) & (steps > _LONG)).any())


def _warm(problem: Problem) -> None:
    """Have the kernels compiled, or loaded, before the clock starts: once for arms that use the same ones."""
    from selfmotion.certificate.tube import Setting, first_tube

    cover, constraints = problem.arm.cover(), constraints_of(problem.arm)
    names = [type(each).__name__ for each in (unconstrained(problem.arm).cover(), *constraints)]
    kernels = (", ".join(names), problem.arm.branches, problem.objective.kind)
    if kernels in _warmed:
        return
    setting = Setting(cover, problem.path, problem.objective.kind, np.ones(problem.arm.n))
    tube = first_tube(setting, np.array([0.0, 1.0]), 2.0)
    if not tube.is_empty:
        first = tube.slices[0]
        setting.cover.split(first.x, first.cells[:1], np.array([2.0]))
        tube.evaluate()
        tube.cheapest()
    _warmed.add(kernels)


def _slices(breaks: FloatArray, count: int) -> FloatArray:
    """Return the path parameters to begin with: even ones, moved to the path's breaks where these are near."""
    r = np.linspace(0.0, 1.0, count + 1)
    if len(breaks):
        near = breaks[np.abs(breaks[None] - r[1:-1, None]).argmin(axis=1)]
        r[1:-1] = np.where(np.abs(near - r[1:-1]) < 0.5 / count, near, r[1:-1])
    return r
