"""Tries to find time laws that break a limit, or take longer than they need.

    python tests/timing/attack_laws.py --count 500 --seed 0 --workers 2

Plans are drawn at random, of arms in the plane and in space, with corners and without: profiles, refined and globally
optimal motions. Each is timed under random limits. Velocities and accelerations are looked at many times inside every
cell of the law's grid, and once more without its derivatives, as differences of the joint angles alone, whose mean
values cannot be larger than a limit that holds. The duration is held against those of toppra on a spline through the
same motion, and given its derivatives, where toppra's law keeps the limits. The exit is 1 where a limit is exceeded by
more than 0.1 %, or a law takes 2 % longer than toppra's.
"""

import argparse
import json
import os
import sys
import time
from functools import partial
from itertools import pairwise

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import selfmotion as sm
from selfmotion.motion import Motion
from selfmotion.profiles import BSplineProfile, HarmonicsProfile, ProfileCurve
from selfmotion.study import Processes, Run
from selfmotion.timing.law import Law, loads

EXCEEDED, LONGER = 1.001, 1.02
KEPT = 1.01  # of a limit, that a law of toppra may take between its grid points to be one that is compared
STEEP = 200.0  # rates beyond which a profile passes too near a fold [rad]
KINDS = ("profile", "profile", "refined", "global", "panda", "ur5e")
PARTS = np.array([0.002, *np.linspace(0.02, 0.98, 13), 0.998])  # of a cell
ROWS = 4000  # over the whole motion, of which differences are taken


def planar(rng, links):
    """An arm and a path inside its reach."""
    arm = sm.PlanarArm(rng.uniform(0.3, 1.0, links))
    centre = rng.normal(size=2)
    centre *= rng.uniform(0.3, 0.6) * arm.links.sum() / np.linalg.norm(centre)
    points = centre + rng.uniform(-0.2, 0.2, (int(rng.integers(3, 7)), 2)) * arm.links.sum()
    makers = (
        lambda: sm.Bezier(points),
        lambda: sm.Waypoints(points, "spline"),
        lambda: sm.Waypoints(points),
        lambda: sm.Circle(centre, 0.15 * arm.links.sum()),
        lambda: slot(centre, 0.15 * arm.links.sum(), rng.uniform(0.02, 0.1) * arm.links.sum()),
    )
    return arm, makers[rng.integers(len(makers))]()


def slot(centre, size, radius):
    """Round a square with rounded corners, as drawings have them: curvature jumps, directions do not."""
    parts, side = [], np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    for k, out in enumerate(side):
        along, inner = side[(k + 1) % 4], size - radius
        parts.append(sm.Line(centre + size * out - inner * along, centre + size * out + inner * along))
        parts.append(sm.Arc(centre + inner * (out + along), radius, np.arctan2(out[1], out[0]), np.pi / 2))
    return sm.Concatenation(parts)


def profile(rng):
    """A planar arm with u(r) a random series or spline."""
    arm, path = planar(rng, int(rng.integers(3, 6)))
    family = HarmonicsProfile(rng.uniform(-3, 3, arm.n_u), 3)
    if rng.integers(2):
        family = BSplineProfile(arm.n_u, int(rng.integers(4, 12)), rng.uniform(-3, 3, arm.n_u))
    a = rng.uniform(-0.5, 0.5, len(family.parameter_names))
    if family.kind == "bspline":
        a += np.repeat(family.offset, family.count - 1)
    problem = sm.Problem(arm, path, samples=200)
    plan = sm.Plan(problem, Motion(arm, path, ProfileCurve(family, a), int(rng.integers(2)), 800), "random", {})
    return plan if np.abs(plan.rates(np.linspace(0, 1, 500))).max() < STEEP else None


def refined(rng):
    arm, path = planar(rng, int(rng.integers(3, 7)))
    return sm.plan(sm.Problem(arm, path, samples=200), sm.Refine(starts=1, time_limit=5, seed=int(rng.integers(1000))))


def best(rng):
    """A globally optimal motion, which rides limits and crosses folds."""
    arm, path = planar(rng, 3)
    limits = [None, (0.0, np.pi), None] if rng.integers(2) else [(-2.6, 2.6)] * 3
    return sm.plan(sm.Problem(sm.PlanarArm(arm.links, limits), path, samples=200), sm.Global(gap=3e-2, time_limit=5))


def in_space(rng, name):
    """An arm in space through the poses of some postures near each other."""
    arm = sm.named_arm(name)
    low, high = np.maximum(arm.limits.lower, -2.5), np.minimum(arm.limits.upper, 2.5)
    first = low + (high - low) * rng.uniform(0.25, 0.75, arm.n)
    share = np.linspace(0.0, 1.0, int(rng.integers(3, 7)))[:, None]
    poses = arm.forward(first + share * rng.uniform(-0.4, 0.4, arm.n) * (high - low) / 4)
    path = sm.PoseWaypoints(poses, "spline" if rng.integers(2) else "linear")
    return sm.plan(sm.Problem(arm, path, samples=200), sm.Refine(starts=1, time_limit=5, seed=int(rng.integers(1000))))


def random_plan(rng, kind="profile"):
    """A plan that holds."""
    makers = {"profile": profile, "refined": refined, "global": best}
    make = makers.get(kind, partial(in_space, name=kind))
    while True:
        try:
            plan = make(rng)
        except sm.SelfMotionError:
            continue
        if plan is not None and plan.verification.holds and np.isfinite(plan.cost):
            return plan


def between(law):
    """Times inside every cell of a law's grid, also next to its ends."""
    return (law.t[:-1, None] + law.steps[:, None] * PARTS).ravel()


def exceeded(timed):
    """Largest velocity, acceleration and tool speed, as parts of their limits."""
    plan, limits = timed.plan, timed.limits
    t = between(timed.law)
    _, dq, ddq = timed.states(t)
    moved = timed.law(t)
    tool = np.linalg.norm(plan.problem.path(moved.r, 1)[:, :3], axis=1) * moved.speed / limits.tool_speed
    q, step = timed(np.linspace(0.0, timed.duration, ROWS + 1)), timed.duration / ROWS
    mean = np.diff(q, axis=0) / step
    noise = 1e-11 / step**2  # of joint angles
    bend = np.maximum(np.abs(np.diff(mean, axis=0)) / step - noise, 0.0)
    velocity = max(np.max(np.abs(speed) / limits.velocity) for speed in (dq, mean))
    acceleration = max(np.max(np.abs(part) / limits.acceleration) for part in (ddq, bend))
    return float(velocity), float(acceleration), float(tool.max())


def toppra_s_own(timed):
    """Durations by toppra itself, each with the largest part of a limit that its law takes on the motion.

    On a spline through the motion's joint angles, so that nothing of ours is in it; and given its derivatives, with a
    grid point on either side of where they jump, which no spline through points follows.
    """
    pieces = list(pairwise([0.0, *timed.stops, 1.0]))
    for solve in (by_spline, by_derivatives):
        laws = [solve(timed, a, b) for a, b in pieces]
        if any(speed is None or not np.isfinite(speed).all() for _, speed in laws):
            yield None, np.inf
            continue
        r = np.concatenate([grid[:-1] for grid, _ in laws] + [[1.0]])
        law = Law(r, np.concatenate([speed[:-1] for _, speed in laws] + [[0.0]]))
        moved = law(between(law))
        velocity, acceleration, _ = loads(timed._geometry, timed.limits, *moved)
        yield law.duration, max(np.abs(velocity).max(), np.sqrt(np.abs(acceleration).max()))


def by_spline(timed, a, b):
    """Grid points and dr/dt between two standstills."""
    import toppra

    r = np.linspace(a, b, max(int(2000 * (b - a)), 200) + 1)
    inside = np.clip(r, a + 1e-9 * (a > 0), b - 1e-9 * (b < 1))  # on this side of a corner
    curve = toppra.SplineInterpolator(np.linspace(0.0, 1.0, len(r)), timed.plan(inside))
    grid = np.linspace(0.0, 1.0, max(int(2000 * (b - a)), 200) + 1)
    speed = solved(timed, curve, grid)
    return a + (b - a) * grid, None if speed is None else (b - a) * speed


def by_derivatives(timed, a, b):
    """The same."""
    from toppra.interpolator import AbstractGeometricPath

    inner = timed._geometry.edges[(timed._geometry.edges > a) & (timed._geometry.edges < b)]
    grid = np.linspace(a, b, max(int(2000 * (b - a)), 200) + 1)
    if len(inner):
        grid = grid[np.abs(grid[:, None] - inner).min(axis=1) > 1e-6]
    grid = np.sort(np.concatenate([grid, inner - 1e-7, inner + 1e-7]))
    rates, bends = timed._geometry.derivatives(np.clip(grid, a, b - 1e-9))
    size = b - a

    class Curve(AbstractGeometricPath):
        dof, path_interval, waypoints = rates.shape[1], np.array([0.0, 1.0]), None

        def __call__(self, _, order=0):
            return (rates, rates * size, bends * size**2)[order]

    speed = solved(timed, Curve(), (grid - a) / size)
    return grid, None if speed is None else size * speed


def solved(timed, curve, grid):
    from toppra.algorithm import TOPPRA
    from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

    grid[0], grid[-1] = 0.0, 1.0
    fast = np.minimum(timed.limits.velocity, 1e4)  # toppra wants a number
    constraints = [JointVelocityConstraint(fast), JointAccelerationConstraint(timed.limits.acceleration)]
    own = TOPPRA(constraints, curve, gridpoints=grid, solver_wrapper="seidel")
    own.compute_parameterization(0, 0)
    return own.problem_data.sd_vec


def attack(seed):
    """Draw a plan, time it, and measure; a mapping."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    plan = random_plan(rng, kind)
    arm = plan.problem.arm
    velocity = None if rng.integers(5) == 0 else rng.uniform(0.5, 3, arm.n)
    acceleration = rng.uniform(0.5, 20, arm.n)
    begun = time.perf_counter()
    timed = sm.time_law(plan, acceleration, velocity)
    seconds = time.perf_counter() - begun
    worst = np.array(exceeded(timed))
    if seed // len(KINDS) % 3 == 0:
        speed = rng.uniform(0.05, 0.8) * np.linalg.norm(np.diff(plan.problem.path([0.0, 0.5, 1.0])[:, :3], axis=0))
        even = sm.time_law(plan, acceleration, velocity, max(speed, 1e-3))
        worst = np.maximum(worst, exceeded(even))
    ratios = [timed.duration / own if own is not None and taken < KEPT else None for own, taken in toppra_s_own(timed)]
    return {"seed": seed, "kind": kind, "worst": worst.tolist(), "ratios": ratios, "seconds": seconds}


def task(specification):
    """An attack as a run of a study."""
    return attack(specification["seed"])


def failed(row):
    ratios = [ratio for ratio in row["ratios"] if ratio is not None]
    return max(row["worst"]) > EXCEEDED or max(ratios, default=0.0) > LONGER


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.count)
    rows = []
    work = (Run("attack_laws:task", {"seed": seed}).work() for seed in seeds)
    for outcome in Processes(given.workers).outcomes(work):
        if outcome.failure is not None:
            raise RuntimeError(json.loads(outcome.failure)["traceback"])
        rows.append(json.loads(outcome.result))
        if failed(rows[-1]):
            print("FAILED", rows[-1], flush=True)
    rows.sort(key=lambda row: row["seed"])
    print(
        "largest parts of the limits; durations by those of toppra, on a spline and given the derivatives, and of how"
    )
    print("many plans, since its laws are compared where they keep the limits themselves; time that a law takes")
    print("kind     plans velocity   accel.     tool                  spline             derivatives    time")
    for kind in [*dict.fromkeys(KINDS), "all"]:
        part = [row for row in rows if kind in (row["kind"], "all")]
        if not part:
            continue
        velocity, acceleration, tool = np.max([row["worst"] for row in part], axis=0)
        shown = []
        for ratios in zip(*(row["ratios"] for row in part), strict=True):
            known = [ratio for ratio in ratios if ratio is not None]
            shown.append(f"{min(known):.4f} to {max(known):.4f} of {len(known)}" if known else "none")
        mean = np.mean([row["seconds"] for row in part])
        figures = f"{velocity:8.5f} {acceleration:8.5f} {tool:8.5f} {shown[0]:>23} {shown[1]:>23}"
        print(f"{kind:8} {len(part):5} {figures} {mean:5.2f} s")
    sys.exit(1 if any(map(failed, rows)) else 0)


if __name__ == "__main__":
    main()
