"""The paper's study of the 3R arm (section VI-A): its data, its printed results, and the same computed."""

from __future__ import annotations

import numpy as np

from selfmotion.arms import PlanarArm
from selfmotion.exchange import Trajectory
from selfmotion.optimizers import Progress
from selfmotion.paths import Bezier
from selfmotion.planners import Plan, PlanarCandidates, Sinusoid
from selfmotion.problem import Problem
from selfmotion.profiles import SinusoidProfile
from selfmotion.report.cases import SAMPLES, Case, Printed, single_runs

OFFSET, AMPLITUDE = 0.3, 0.4

PRINTED = {
    "GA": Printed(4.8486, 0.5562),
    "PSO": Printed(4.84829399, 0.5329),
    "GWO": Printed(4.84829414, 0.5330),
}
"""Table II, by optimizer."""

MISPRINTS = (
    ("(2)", "l₁ cos θg", "l₃, the last link"),
    ("(5)(6)", "c₂₁, s₂₁", "c₂, s₂"),
    ("(8)(19)", "θg = θ1 − θ2 − θ3", "θ1 + θ2 + θ3, as (7) says"),
    ("(13)", "θ3 = ±(2π − Δ3)", "±(π − Δ3)"),
    ("(23)", "χ = 2/(2 − φ − √…), negative for φ > 4", "its absolute value"),
    ("(24)", "|X − A·D|", "no absolute value; D has it"),
    ("(25)", "A = 2A·r1 − a", "A = 2a·r1 − a"),
    ("(26)", "D = C·X − X", "|C·X_leader − X|"),
)
"""Where the paper prints one thing and must mean another: equation, printed, meant."""


def arm() -> PlanarArm:
    """Return the 3R arm with its limits (27)."""
    return PlanarArm([30, 30, 20], [None, (0.0, np.pi), None])


def problem() -> Problem:
    """Return the arm on the fifth-degree Bezier path of Table I."""
    path = Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
    return Problem(arm(), path, samples=SAMPLES)


def free_problem() -> Problem:
    """Return the arm without limits on the same path, as sections II and IV look at it."""
    return Problem(PlanarArm(arm().links), problem().path, samples=SAMPLES)


def improper_motion(case: Problem) -> Trajectory:
    """Return postures along the path, the sinusoid at the printed frequency, a tenth of them with the other elbow."""
    r = np.linspace(0.0, 1.0, 121)
    u = SinusoidProfile([OFFSET], [AMPLITUDE])([PRINTED["PSO"].f], r)
    wrong = (r > 0.45) & (r < 0.55)
    positive, negative = (case.arm.solve(case.path(r), u, branch)[0] for branch in (0, 1))
    return Trajectory(r, np.where(wrong[:, None], negative, positive))


def limited_problem() -> Problem:
    """Return the arm with limits of our own on the same path: few, and enough for most kinds of events."""
    return Problem(PlanarArm(arm().links, [(-0.5, 0.8), (-1.0, 2.0), (-2.0, 0.9)]), problem().path, samples=SAMPLES)


def plans(seed: int, progress: Progress | None = None) -> dict[str, Plan]:
    """Return the single run of each optimizer (Table II), by label."""
    return single_runs(
        problem(),
        lambda optimizer: Sinusoid([OFFSET], amplitude=[AMPLITUDE], optimizer=optimizer, ranking="samples"),
        seed,
        progress,
    )


def _candidates() -> PlanarCandidates:
    return PlanarCandidates(problem(), SinusoidProfile([OFFSET], [AMPLITUDE]), branch=0)


CASE = Case("3R", PRINTED, _candidates)
"""The search of Table II."""
