"""The answer: a motion that has been checked, and what it costs."""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion._version import __version__
from selfmotion.motion import JointMotion
from selfmotion.objectives import L1Travel, L2Travel, Objective
from selfmotion.optimizers import History
from selfmotion.problem import Problem
from selfmotion.quadrature import Integral
from selfmotion.verification import Verification, verify_motion

if TYPE_CHECKING:
    from selfmotion.certificate.result import Certificate

RESULT_FIELDS = (
    "status", "cost", "cost_error", "cost_sampled", "lower_bound", "gap", "l1_travel", "l2_travel",
    "max_tracking_error", "min_limit_margin", "max_joint_step", "reconfigurations", "blocked", "planner",
    "parameters", "evaluations", "wall_time_s", "version",
)  # fmt: skip
"""Keys of every result that the command line prints as JSON, in this order."""


def result_object(**known: Any) -> dict[str, Any]:
    """Return a result with every field of the contract, None where nothing is known; further keys follow."""
    fields = {**dict.fromkeys(RESULT_FIELDS), "version": __version__, **known}
    return {key: _plain(value) for key, value in fields.items()}


def _plain(value: Any) -> Any:
    """Return `value` fit for JSON, which has no infinity: what is not finite is not known."""
    return None if isinstance(value, float) and not np.isfinite(value) else value


class Plan:
    """A joint motion along a path, with its cost and the check of itself.

    Call it with r for the joint angles. Cost, tracking, limits and continuity it computes from the motion and the arm's
    forward kinematics, not from what the planner believed.

    Parameters
    ----------
    problem : Problem
    motion : JointMotion
    planner : str
        Kind of the planner that made it.
    parameters : dict
        What the planner chose, and with which settings.
    evaluations : int
        Candidates that were judged on the way, or iterations that were made.
    wall_time_s : float
    history : tuple of History
        How the search went, one history per branch searched.

    Attributes
    ----------
    lower_bound, gap : float or None
        A proved bound on every motion's cost and the relative distance to it; None for planners without one.
    estimated_bound, estimated_gap : float or None
        The same of an arm whose postures are sampled, not enclosed: nothing of it is proved. None for all others.
    certificate : Certificate or None
        The proof of the bound.
    reconfigurations : int
        Planned breaks of the motion.
    """

    def __init__(
        self,
        problem: Problem,
        motion: JointMotion,
        planner: str,
        parameters: dict[str, Any],
        evaluations: int = 0,
        wall_time_s: float = 0.0,
        history: tuple[History, ...] = (),
    ) -> None:
        self.problem = problem
        self.motion = motion
        self.planner = planner
        self.parameters = parameters
        self.evaluations = evaluations
        self.wall_time_s = wall_time_s
        self.history = history
        self.lower_bound: float | None = None
        self.gap: float | None = None
        self.estimated_bound: float | None = None
        self.estimated_gap: float | None = None
        self.certificate: Certificate | None = None
        self.reconfigurations = 0

    def certify(self, certificate: Certificate) -> None:
        """Take over what was proved of every motion's cost."""
        self.certificate = certificate
        left = self.cost + self.cost_error - certificate.bound
        gap = left / self.cost if self.cost > 0.0 else 0.0 if left <= 0.0 else np.inf
        if certificate.rigorous:
            self.lower_bound, self.gap = certificate.bound, gap
        else:
            self.estimated_bound, self.estimated_gap = certificate.bound, gap

    def __repr__(self) -> str:
        return f"Plan({self.planner}, cost={self.cost:.9g} ± {self.cost_error:.1g})"

    def __call__(self, r: ArrayLike) -> FloatArray:
        """Return the joint angles at path parameters `r`, shape (..., n), turns included [rad]."""
        return self.motion(r)

    def u(self, r: ArrayLike) -> FloatArray:
        """Return the redundancy vector at path parameters `r`, shape (..., n_u) [rad]."""
        return self.motion.u(r)

    def rates(self, r: ArrayLike) -> FloatArray:
        """Return dθ/dr, shape (..., n)."""
        return self.motion.rates(r)

    @cached_property
    def verification(self) -> Verification:
        """Tracking, limits and continuity, recomputed between the samples too."""
        return verify_motion(self.problem, self.motion)

    def _integral(self, objective: Objective, weights: FloatArray) -> Integral:
        edges = self.problem.path.grid(max(64, self.problem.samples // 4))
        return objective.integral(self.motion.rates, edges, weights)

    @cached_property
    def _cost(self) -> Integral:
        value, error = self._integral(self.problem.objective, self.problem.weights)
        # No chord sum exceeds the integral: where it does, the quadrature has missed a spike and knows no error.
        return Integral(value, error if value + error >= self.cost_sampled * (1 - 1e-13) else np.inf)

    @property
    def cost(self) -> float:
        """The objective as an integral."""
        return self._cost.value

    @property
    def cost_error(self) -> float:
        """Estimate of the absolute error of :attr:`cost`, infinite if the chord sum shows the integral to be wrong."""
        return self._cost.error

    @cached_property
    def cost_sampled(self) -> float:
        """The objective as the seed's chord sum over the sample grid, always below the integral."""
        grid = self.problem.grid
        return float(self.problem.objective.sampled(self.motion(grid), grid, self.problem.weights))

    @cached_property
    def l1_travel(self) -> float:
        """``Σ ∫ |θ_i'| dr`` [rad], without weights."""
        return self._integral(L1Travel(), np.ones(self.problem.arm.n)).value

    @cached_property
    def l2_travel(self) -> float:
        """``∫ ‖θ'‖ dr`` [rad], without weights."""
        return self._integral(L2Travel(), np.ones(self.problem.arm.n)).value

    @cached_property
    def l2_waypoints(self) -> float | None:
        """``Σ ‖w∘Δθ‖`` over the points that the path was given by, as others report motions; None if there are none.

        The weights are the problem's. It is a sum of chords from one given point to the next, so it is not above the
        objective l2, and what bounds l2 from below does not bound it.
        """
        r = self.problem.path.waypoints
        if len(r) < 2:
            return None
        return float(L2Travel().sampled(self.motion(r), r, self.problem.weights))

    def save(self, file: str | os.PathLike[str], force: bool = False) -> None:
        """Write the plan as one JSON file, which :func:`selfmotion.load_plan` makes an equal plan of.

        Parameters
        ----------
        file : path-like
        force : bool
            Whether a file that selfmotion did not write may be replaced.

        Raises
        ------
        InvalidInputError
            If the file cannot be written, or arm, path or motion are of classes that are not selfmotion's.
        """
        from selfmotion.exchange.plan_file import save_plan

        save_plan(self, file, force)

    def summary(self) -> dict[str, Any]:
        """Return the result as the command line's ``--json`` prints it.

        ``l2_waypoints``, ``estimated_bound`` and ``estimated_gap`` are there only if they are known, ``margins`` only
        of constraints beyond joint limits.
        """
        check = self.verification
        names = ("l2_waypoints", "estimated_bound", "estimated_gap")
        more = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        if check.margins:
            more["margins"] = check.margins
        return result_object(
            status="solved" if check.holds else "unknown",
            cost=self.cost,
            cost_error=self.cost_error,
            cost_sampled=self.cost_sampled,
            lower_bound=self.lower_bound,
            gap=self.gap,
            l1_travel=self.l1_travel,
            l2_travel=self.l2_travel,
            max_tracking_error=check.max_tracking_error,
            min_limit_margin=check.min_limit_margin,
            max_joint_step=check.max_joint_step,
            reconfigurations=self.reconfigurations,
            planner=self.planner,
            parameters=self.parameters,
            evaluations=self.evaluations,
            wall_time_s=self.wall_time_s,
            **more,
        )
