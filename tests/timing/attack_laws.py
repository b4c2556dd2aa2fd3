"""Tries to find time laws that break a limit, or take longer than they need.

    python tests/timing/attack_laws.py --count 500 --seed 0 --workers 2

Plans are drawn at random, of arms in the plane and in space, with corners and without: profiles, refined and globally
optimal motions. Each is timed under random limits. Velocities and accelerations are looked at many times inside every
cell of the law's grid, and once more without its derivatives, as differences of the joint angles alone, whose mean
values cannot be larger than a limit that holds. The duration is held against that of toppra on a spline through the
same motion. The exit is 1 where a limit is exceeded by more than 0.1 % or the durations are more than 2 % apart.
"""

import argparse
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import pairwise

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import selfmotion as sm
from selfmotion.motion import Motion
from selfmotion.profiles import BSplineProfile, HarmonicsProfile, ProfileCurve

EXCEEDED, APART = 1.001, 0.02
STEEP = 200.0  # rates beyond which a profile passes too near a fold [rad]
KINDS = ("profile", "profile", "refined", "global", "panda", "ur5e")
PARTS = np.array([0.002, *np.linspace(0.01, 0.99, 29), 0.998])  # of a cell
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
    )
    return arm, makers[rng.integers(4)]()


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


def toppra_s_own(plan, velocity, acceleration, stops):
    """Duration by toppra on a spline through the motion, from standstill to standstill; nothing of ours but angles."""
    import toppra
    from toppra.algorithm import TOPPRA
    from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

    total, edges = 0.0, [0.0, *stops, 1.0]
    fast = np.minimum(velocity, 1e4)  # toppra wants a number
    constraints = [JointVelocityConstraint(fast), JointAccelerationConstraint(acceleration)]
    for a, b in pairwise(edges):
        r = np.linspace(a, b, max(int(3000 * (b - a)), 300) + 1)
        inside = np.clip(r, a + 1e-9 * (a > 0), b - 1e-9 * (b < 1))  # on this side of a corner
        curve = toppra.SplineInterpolator(np.linspace(0.0, 1.0, len(r)), plan(inside))
        grid = np.linspace(0.0, 1.0, max(int(4000 * (b - a)), 400) + 1)
        own = TOPPRA(constraints, curve, gridpoints=grid, solver_wrapper="seidel")
        own.compute_parameterization(0, 0)
        speed = own.problem_data.sd_vec
        if speed is None or not np.isfinite(speed).all():
            return None
        total += float((2.0 * np.diff(grid) / (speed[1:] + speed[:-1])).sum())
    return total


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
    own = toppra_s_own(plan, timed.limits.velocity, acceleration, timed.stops)
    ratio = None if own is None else timed.duration / own
    return {"seed": seed, "kind": kind, "worst": worst.tolist(), "ratio": ratio, "seconds": seconds}


def failed(row):
    ratio = row["ratio"]
    return max(row["worst"]) > EXCEEDED or (ratio is not None and abs(ratio - 1.0) > APART)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.count)
    rows = []
    with ProcessPoolExecutor(given.workers) as pool:
        for row in pool.map(attack, seeds):
            rows.append(row)
            if failed(row):
                print("FAILED", row, flush=True)
    print(f"{'kind':10} {'plans':>5} {'velocity':>9} {'accel.':>9} {'tool':>9} {'duration by toppra':>20} {'time':>7}")
    for kind in [*dict.fromkeys(KINDS), "all"]:
        part = [row for row in rows if kind in (row["kind"], "all")]
        if not part:
            continue
        velocity, acceleration, tool = np.max([row["worst"] for row in part], axis=0)
        ratios = [row["ratio"] for row in part if row["ratio"] is not None] or [np.nan]
        durations = f"{min(ratios):.4f} to {max(ratios):.4f}"
        mean = np.mean([row["seconds"] for row in part])
        print(f"{kind:10} {len(part):5} {velocity:9.5f} {acceleration:9.5f} {tool:9.5f} {durations:>20} {mean:5.2f} s")
    without = sum(row["ratio"] is None for row in rows)
    if without:
        print(f"toppra found no law of its own for {without} of them")
    sys.exit(1 if any(map(failed, rows)) else 0)


if __name__ == "__main__":
    main()
