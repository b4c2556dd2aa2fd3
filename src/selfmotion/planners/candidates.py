"""What the candidates of a search cost: for any arm in numpy, for planar arms compiled."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, NamedTuple, Self

import numpy as np

from selfmotion._blocks import in_blocks
from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms import JointLimits, PlanarArm, RedundantArm
from selfmotion.constrained import constraints_of
from selfmotion.optimizers import INFEASIBLE, Judged, Swarm, SwarmState, penalised
from selfmotion.problem import Problem
from selfmotion.profiles import LinearProfile, Profile, SinusoidProfile

if TYPE_CHECKING:
    from selfmotion.planners._candidate_kernels import Family, Panels, Search

Ranking = Literal["integral", "samples"]
RANKINGS: tuple[Ranking, ...] = ("integral", "samples")

# Candidates are evaluated in blocks of about this many joint angles: what stays in the processor's cache.
_BLOCK = 16_000
# A candidate is inside the domain if it leaves it by rounding only: radians, or parts of the reach.
_ROUNDING = 1e-12
# Relative error at which the integral of a candidate that matters is good enough.
_TOLERANCE = 1e-8
# Violation of a candidate that holds at the samples and is out of reach somewhere between them.
_BETWEEN = 1e-9
_FEW = 32  # samples of the chord sum that bounds an integral from below: full vector registers


class Carrier(NamedTuple):
    """What an arm stands on if that turns.

    Attributes
    ----------
    limits : JointLimits
        Of the true joints, the first one measured from the carrier.
    direction : callable
        Direction of the carrier at r (k,) and its derivative: maps r and an order, 0 or 1, to shape (k,) [rad].
    absolute : bool
        Whether the cost counts the first joint as an absolute angle all the same.
    """

    limits: JointLimits
    direction: Callable[[FloatArray, int], FloatArray]
    absolute: bool


class Candidates:
    """The objective of a search on one branch: what a population of coefficient vectors costs.

    Parameters
    ----------
    problem : Problem
    profile : Profile
    branch : int
    carrier : Carrier, optional
        What the arm stands on, if that turns.

    Attributes
    ----------
    r : array, shape (k,)
        The samples.
    x : array, shape (k, 2)
        The path there.
    """

    def __init__(self, problem: Problem, profile: Profile, branch: int, carrier: Carrier | None = None) -> None:
        self.problem = problem
        self.profile = profile
        self.branch = branch
        self.carrier = carrier
        self.r = problem.grid
        self.x = problem.points

    def __call__(self, population: FloatArray) -> FloatArray:
        """Return the values of a population, shape (p, d), as the optimizers rank them.

        The value of a feasible candidate is its chord sum over the samples. One that leaves the angle domain is ranked,
        after all feasible ones, by how far it leaves: by the largest shortfall of reach (in parts of the reach) plus
        each joint's largest overrun of its limits [rad] plus what further constraints lack most, as a part of their
        scale: how deep a link is in an obstacle, say.
        """
        return in_blocks(self.block, population, candidates_at_once(len(self.r) * self.problem.arm.n))

    def block(self, population: FloatArray) -> FloatArray:
        """Return the same for as many candidates as are judged at once."""
        problem, carrier = self.problem, self.carrier
        limits = problem.arm.limits if carrier is None else carrier.limits
        behind = 0.0 if carrier is None else carrier.direction(self.r, 0)
        start = None if problem.start is None else problem.start.q
        u = self.profile(population, self.r)
        q, violation = true_joints(problem.arm, limits, self.x, u, self.branch, behind, start)
        violation += lack(problem.arm, q)
        if carrier is not None and carrier.absolute:
            q[..., 0] += behind
        return penalised(problem.objective.sampled(q, self.r, problem.weights), violation)


class PlanarCandidates(Candidates):
    """The same for a planar arm, compiled; swarms run on it whole.

    Parameters
    ----------
    problem, profile, branch, carrier
        See :class:`Candidates`; the profile a sinusoid or a linear family.
    ranking : {"samples", "integral"}
        What candidates are ranked by: the chord sum over the samples, as in the seed, or the integral that it tends to.

    Notes
    -----
    The integral is that of closed-form joint rates by Gauss panels, halved until the error estimate is 1e-8 of the
    value or the candidate is known to lie above what would change the search: by the estimate, or by the chord sum over
    32 of the samples, which no integral falls below. A candidate is feasible if it is at all samples, as with the chord
    sum, and in reach at every node.
    """

    def __init__(
        self,
        problem: Problem,
        profile: SinusoidProfile | LinearProfile,
        branch: int,
        carrier: Carrier | None = None,
        ranking: Ranking = "samples",
    ) -> None:
        super().__init__(problem, profile, branch, carrier)
        self.profile: SinusoidProfile | LinearProfile = profile
        self.ranking = ranking
        self._search = self._prepared()

    def __call__(self, population: FloatArray) -> FloatArray:
        """Return the values of a population, shape (p, d), as the optimizers rank them; see :class:`Candidates`."""
        return self.judge(population).values

    def judge(self, population: FloatArray, thresholds: FloatArray | float = np.inf) -> Judged:
        """Judge a population.

        Parameters
        ----------
        population : array, shape (p, d)
        thresholds : float or array, shape (p,)
            Values above which a candidate need not be known exactly: a lower bound above the threshold will do.

        Returns
        -------
        Judged
        """
        from selfmotion.planners._run_kernels import judge_all

        rows = np.ascontiguousarray(population, dtype=float)
        values, exact = np.empty(len(rows)), np.empty(len(rows), dtype=bool)
        bars = np.broadcast_to(np.asarray(thresholds, dtype=float), len(rows)).copy()
        judge_all(rows, bars, self._search, values, exact)
        return Judged(rows, values, exact)

    def shifted(self, shift: float) -> Self:
        """Return the same with `shift` added to every coefficient; see :mod:`selfmotion.optimizers.shifted`."""
        other = copy.copy(self)
        family = self._search.family
        other._search = self._search._replace(family=family._replace(origin=family.origin + shift))
        return other

    def run(self, swarm: Swarm, state: SwarmState, generations: int) -> Judged:
        """Run generations of a swarm, changing its state; see :class:`~selfmotion.optimizers.swarm.RunsSwarms`."""
        from selfmotion.planners._run_kernels import run

        shape = (generations, *state.x.shape)
        judged = Judged(np.empty(shape), np.empty(shape[:2]), np.empty(shape[:2], dtype=bool))
        run(swarm.flock(state), swarm.draws(state, generations), state.t, self._search, *judged)
        state.t += generations
        return judged

    def _prepared(self) -> Search:
        from selfmotion.planners._candidate_kernels import Accuracy, Search

        number = np.unique(np.linspace(0, len(self.r) - 1, _FEW).round().astype(int))
        panels, nodes = self._quadrature()
        return Search(
            self._family(),
            self._places(self.r, self.x),
            self._places(self.r[number], self.x[number]),
            nodes,
            number,
            panels,
            Accuracy(self.ranking == "samples", _TOLERANCE, INFEASIBLE, _BETWEEN),
        )

    def _family(self) -> Family:
        from selfmotion._objective_kernels import KINDS
        from selfmotion.planners._candidate_kernels import Family

        problem, profile, carrier = self.problem, self.profile, self.carrier
        arm, variables = problem.arm, len(profile.parameter_names)
        assert isinstance(arm, PlanarArm)
        limits = arm.limits if carrier is None else carrier.limits
        start = np.full(arm.n, np.nan) if problem.start is None or problem.start.q is None else problem.start.q
        return Family(
            objective=KINDS[problem.objective.kind],
            sign=arm.sign(self.branch),
            joints=np.stack([arm.links, problem.weights, limits.lower, limits.upper, start]),
            limited=np.flatnonzero(_may_be_met(limits, arm.sign(self.branch), start)),
            amplitude=profile.amplitude.copy() if isinstance(profile, SinusoidProfile) else np.empty(0),
            origin=np.zeros(variables),
            n_u=arm.n_u,
            functions=variables // arm.n_u if isinstance(profile, LinearProfile) else 0,
            carried=carrier is not None,
            absolute=carrier is not None and carrier.absolute,
            rounding=_ROUNDING,
            reach=arm.reach,
            speed=problem.fastest,
        )

    def _quadrature(self) -> tuple[Panels, FloatArray]:
        from selfmotion.planners._candidate_kernels import Panels

        if self.ranking == "samples":
            return Panels(np.empty(0), 0, np.empty(0)), self._places(np.empty(0), np.empty((0, 2)))
        rule = self.problem.quadrature
        return Panels(rule.half, rule.depth, rule.weights), self._places(rule.nodes, *self.problem.quadrature_points)

    def _places(self, r: FloatArray, x: FloatArray, dx: FloatArray | None = None) -> FloatArray:
        """Return a table of places; see :mod:`selfmotion.planners._candidate_kernels`."""
        arm, profile, carrier, k = self.problem.arm, self.profile, self.carrier, len(r)
        assert isinstance(arm, PlanarArm)
        u, du = np.zeros((arm.n - 2, k)), np.zeros((arm.n - 2, k))
        if arm.direction is not None:
            u[-1] = arm.direction
        functions = np.empty((0, k))
        if isinstance(profile, LinearProfile):
            given = profile.coefficients(np.zeros(len(profile.parameter_names)))
            known, rising = profile.functions(r, 0).T, profile.functions(r, 1).T
            u[: arm.n_u], du[: arm.n_u] = given @ known, given @ rising
            functions = np.vstack([known[profile.free], rising[profile.free]])
        else:
            u[: arm.n_u] = profile.offset[:, None]
        turned = np.zeros((2, k)) if carrier is None else [carrier.direction(r, order) for order in (0, 1)]
        speeds = np.zeros((2, k)) if dx is None else dx.T
        return np.vstack([r, np.diff(r, prepend=r[:1]), x.T, speeds, turned, u, du, functions])


def candidates_of(
    problem: Problem, profile: Profile, branch: int, ranking: Ranking, carrier: Carrier | None = None
) -> Candidates:
    """Return what judges populations on one branch, compiled where that is at hand; a subclass may solve otherwise."""
    if type(problem.arm) is PlanarArm and isinstance(profile, SinusoidProfile | LinearProfile):
        return PlanarCandidates(problem, profile, branch, carrier, ranking)
    return Candidates(problem, profile, branch, carrier)


def candidates_at_once(angles: int) -> int:
    """Return how many candidates of so many joint angles stay in the processor's cache."""
    return max(1, _BLOCK // angles)


def true_joints(
    arm: RedundantArm,
    limits: JointLimits,
    x: FloatArray,
    u: FloatArray,
    branch: int,
    behind: FloatArray | float,
    start: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the true joint angles of sampled motions and how far they leave the angle domain.

    Parameters
    ----------
    arm : RedundantArm
    limits : JointLimits
        Of the true joints.
    x : array, shape (k, 2) or (p, k, 2)
        The path at the samples, as seen from the arm's base.
    u : array, shape (p, k, n_u)
    branch : int
    behind : array, shape (k,) or (p, k), or 0
        Direction of what carries the arm [rad].
    start : array, shape (n,), optional
        Joint angles at the first sample, which fix the turns.

    Returns
    -------
    q : array, shape (p, k, n)
        Continuous along the samples.
    violation : array, shape (p,)
        Zero inside: the largest shortfall of reach, in parts of the reach, plus each joint's overrun [rad].
    """
    q, margin = arm.solve_with_margin(x, u, branch)
    q[..., 0] -= behind
    lifted = limits.lift(q, start)
    short = np.maximum(-(margin / arm.reach).min(axis=1), 0.0)
    violation = np.where(short > _ROUNDING, short, 0.0)
    violation += np.where(lifted.excess > _ROUNDING, lifted.excess, 0.0).sum(axis=1)
    return lifted.q, violation


def lack(arm: RedundantArm, q: FloatArray) -> FloatArray:
    """Return what sampled motions (p, k, n) lack most of further constraints, as parts of their scales, shape (p,)."""
    total = np.zeros(len(q))
    for constraint in constraints_of(arm):
        worst = constraint.least_margins(q.reshape(-1, q.shape[-1]))[0].reshape(q.shape[:2]).min(axis=1)
        total += np.where(worst < -constraint.tolerance, -worst / constraint.scale, 0.0)
    return total


def _may_be_met(limits: JointLimits, sign: float, start: FloatArray) -> BoolArray:
    """Return which limits are no consequence of the elbow, which alone keeps θ2 in [0, π] or [−π, 0]."""
    met = limits.limited.copy()
    low, high = (0.0, np.pi) if sign > 0 else (-np.pi, 0.0)
    if np.isnan(start[1]) and limits.lower[1] <= low and limits.upper[1] >= high:
        met[1] = False
    return met
