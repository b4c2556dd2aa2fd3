"""The paper's study of the 6R arm (section VI-B): two modules of three links, the second one on a moving base."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import PlanarArm
from selfmotion.optimizers import DifferentialEvolution, Progress
from selfmotion.paths import Bezier, Clothoid
from selfmotion.planners import Modules, MovingBase, Plan, Refine, module_problems
from selfmotion.planners.candidates import Carrier, PlanarCandidates
from selfmotion.planners.chain import module_arms
from selfmotion.problem import Problem
from selfmotion.profiles import SinusoidProfile
from selfmotion.report.cases import SAMPLES, Case, Printed, single_runs

OFFSET, AMPLITUDE = (0.35, 0.0), (0.4, 0.4)

PRINTED_FIXED = {
    "GA": Printed(5.1635, 0.5304),
    "PSO": Printed(5.147048672, 0.5524),
    "GWO": Printed(5.147048758, 0.5523),
}
"""Table III, the module on the fixed base, by optimizer."""
PRINTED_MOVING = {
    "GA": Printed(9.6343, 0.1748),
    "PSO": Printed(9.6279, 0.1551),
    "GWO": Printed(9.6279, 0.1551),
}
"""Table III, the module on the moving base, by optimizer."""

READINGS: dict[str, Literal["absolute", "relative"]] = {"absolute": "absolute", "true": "relative"}
"""How the fourth joint may count: as the direction of its link (Fig. 17), or as the angle that it turns."""
NAMES = ("fixed base", "moving base", "moving base, true joints")
"""Of the searches: the first module's, and the second one's in both readings."""


def arm() -> PlanarArm:
    """Return the 6R arm with its limits (30)."""
    module = [None, (0.0, np.pi), None]
    return PlanarArm([30] * 6, module * 2)


def moving_base() -> Bezier:
    """Return the cubic Bezier curve on which the second module's base moves."""
    return Bezier([[80, 30], [70, 30], [70, 10], [80, -21]])


def problem(start: FloatArray | None = None) -> Problem:
    """Return the arm on the generalized clothoid (28) and (29), `start` its first posture if it is given."""
    path = Clothoid(center=[110, 20], scale=25, coefficients=[0, -4, 0, 0.33], t_range=[-4.712, 0])
    return Problem(arm(), path, samples=SAMPLES, start=None if start is None else {"q": start})


def modules() -> tuple[Problem, ...]:
    """Return the problem of each module in the frame of its base."""
    return module_problems(problem(), [moving_base()])


def plans(reading: str, seed: int, progress: Progress | None = None) -> dict[str, Plan]:
    """Return the single run of each optimizer (Table III), by label, in one of the `READINGS`."""
    return single_runs(
        problem(),
        lambda optimizer: Modules([moving_base()], OFFSET, AMPLITUDE, optimizer, READINGS[reading], "samples"),
        seed,
        progress,
    )


class WholeArm(NamedTuple):
    """Motions of the whole arm that are less bound than the modules' on the given base.

    Attributes
    ----------
    moving : Plan
        Sinusoids of the modules on a moving base that is chosen too.
    from_start, free : Plan
        Locally shortest motions without modules, from the modules' start posture and from any.
    """

    moving: Plan
    from_start: Plan
    free: Plan


def whole_arm(start: FloatArray, seed: int, progress: Progress | None = None) -> WholeArm:
    """Plan motions of the whole arm, one of them from the posture `start`, shape (6,)."""
    search = DifferentialEvolution(population=40, iterations=300, seed=seed)
    refine = Refine(seed=seed, time_limit=600.0)  # far more than it takes: a clock must not decide the result
    return WholeArm(
        MovingBase(search).plan(problem(), progress),
        refine.plan(problem(start), progress),
        refine.plan(problem(), progress),
    )


def _profile(module: int) -> SinusoidProfile:
    return SinusoidProfile([OFFSET[module]], [AMPLITUDE[module]])


def _alone(module: int) -> PlanarCandidates:
    return PlanarCandidates(modules()[module], _profile(module), branch=0)


FIXED = Case(NAMES[0], PRINTED_FIXED, lambda: _alone(0))
"""The search of the first module."""
MOVING = Case(NAMES[1], PRINTED_MOVING, lambda: _alone(1))
"""The search of the second module, the fourth joint absolute: what the first one does makes no difference."""


def true_joints(carrier: float) -> Case:
    """Return the search of the second module in true joints, the first one moving with frequency `carrier`."""

    def candidates() -> PlanarCandidates:
        limits = module_arms(arm())[1].limits
        turning = Carrier(limits, lambda r, order: _profile(0)([carrier], r, order)[:, 0], absolute=False)
        return PlanarCandidates(modules()[1], _profile(1), 0, turning)

    return Case(NAMES[2], PRINTED_MOVING, candidates)
