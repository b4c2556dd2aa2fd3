"""Random discretised problems: arms of any number of links, paths in their reach, every kind of end."""

import numpy as np

import selfmotion as sm
from selfmotion.objectives import OBJECTIVES
from selfmotion.refinement import Collocation, Ends, SplineSpace

ENDS = ("free", "start", "end", "both", "cyclic", "cyclic from start")


def random_arm(rng, n=None):
    n = int(rng.integers(3, 13)) if n is None else n
    links = rng.uniform(0.3, 2.0, n)
    limits = []
    for _ in range(n):
        low = rng.uniform(-3.0, -0.5)
        limits.append([None, (low, rng.uniform(0.5, 3.0)), (low, None), (None, -low)][rng.integers(0, 4)])
    direction = rng.uniform(-3, 3) if n > 3 and rng.random() < 0.3 else None
    return sm.PlanarArm(links, limits, direction)


def random_path(rng, arm):
    center, inner, outer = arm.annulus
    radius = inner + (outer - inner) * rng.uniform(0.35, 0.65)
    angle = rng.uniform(-np.pi, np.pi)
    middle = center + radius * np.array([np.cos(angle), np.sin(angle)])
    return sm.Bezier(middle + rng.uniform(-0.2, 0.2, (5, 2)) * (outer - inner))


def random_collocation(rng, ends="free", objective="joint_travel", arm=None):
    """A problem with some knots, one of them triple, and coefficients of a spline inside the limits."""
    arm = arm or random_arm(rng)
    path = random_path(rng, arm)
    space = SplineSpace.with_spans(int(rng.integers(5, 12)), np.array([rng.uniform(0.3, 0.7)]))
    box = arm.boxes()[0]
    lower = np.where(np.isfinite(box.lower), box.lower, -1.5)[:, None]
    upper = np.where(np.isfinite(box.upper), box.upper, 1.5)[:, None]
    lower, upper = np.minimum(lower, upper - 0.5), np.maximum(upper, lower + 0.5)
    inside = lower + (upper - lower) * rng.uniform(0.1, 0.9, (arm.n, space.m))
    start, end = inside[:, 0].copy(), inside[:, -1].copy()
    turns = 2 * np.pi * np.where(arm.limits.limited, 0, rng.integers(-1, 2, arm.n))
    fixed = {
        "free": Ends(),
        "start": Ends(start=start),
        "end": Ends(end=end),
        "both": Ends(start, end),
        "cyclic": Ends(closure=turns),
        "cyclic from start": Ends(start=start, closure=turns),
    }[ends]
    weights = rng.uniform(0.5, 2.0, arm.n)
    problem = Collocation(arm, path, OBJECTIVES[objective](), weights, box, space, fixed, 0.3)
    return problem, problem.unknowns(inside)
