"""Small scenes to test constraints on, each from its seed alone."""

import numpy as np

import selfmotion as sm
from selfmotion.scene import (
    BoxObstacle,
    CapsuleObstacle,
    CircleObstacle,
    HalfPlaneObstacle,
    HalfSpaceObstacle,
    PolygonObstacle,
    SphereObstacle,
)


def planar(seed):
    """A problem of a planar arm among obstacles of all kinds; in one of three also kept from singular postures."""
    rng = np.random.default_rng([seed, 99])
    links = rng.uniform(0.5, 1.5, 3)
    limits = [None if rng.random() < 0.4 else tuple(sorted(rng.uniform(-5.0, 5.0, 2))) for _ in links]
    arm = sm.PlanarArm(links, limits, thickness=float(rng.choice([0.0, 0.1])))
    points = rng.uniform(-0.5, 0.5, (4, 2)) * arm.reach + rng.uniform(-0.2, 0.2, 2) * arm.reach
    sides = int(rng.integers(4, 9))
    angles = 2 * np.pi * np.arange(sides) / sides
    star = rng.uniform(0.1, 0.8, sides)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    normal = rng.normal(size=2)
    obstacles = [
        CircleObstacle(rng.uniform(-2.0, 2.0, 2), rng.uniform(0.05, 0.5)),
        PolygonObstacle(star + rng.uniform(-2.0, 2.0, 2)),
        HalfPlaneObstacle(-1.2 * normal / np.linalg.norm(normal), normal),
    ]
    keep = rng.permutation(3)[: int(rng.integers(1, 4))]
    return sm.Problem(
        arm, sm.Bezier(points), obstacles=[obstacles[k] for k in keep], clearance=float(rng.choice([0.0, 0.05])),
        self_collision=bool(arm.thickness.any()), least_singular_value=0.05 if seed % 3 == 0 else None,
    )  # fmt: skip


def spatial(name="panda", tool=None):
    """A problem of an arm in space among obstacles of every kind that kernels know."""
    arm = sm.named_arm(name, tool=tool)
    x = arm.forward(0.5 * (arm.limits.lower + arm.limits.upper) + 0.3)
    obstacles = [
        BoxObstacle((0.3, 0.3, 0.5), (0.2, 0.3, 0.4), (0.3, 0.2, -0.5)),
        SphereObstacle((-0.3, 0.3, 0.8), 0.15),
        CapsuleObstacle((0.4, -0.4, 0.1), (0.5, -0.1, 0.7), 0.07),
        HalfSpaceObstacle((0.0, 0.0, -0.02), (0.0, 0.1, 1.0)),
    ]
    path = sm.PosePath(sm.Line(x[:3], x[:3] + 0.05), orientation=x[3:])
    return sm.Problem(arm, path, obstacles=obstacles, clearance=0.01, self_collision=True, least_singular_value=0.03)


def postures(problem, rng, count):
    """Random postures (count, n) within limits, free joints anywhere."""
    limits = problem.arm.limits
    low, high = (np.where(np.isfinite(end), end, by * np.pi) for end, by in ((limits.lower, -1), (limits.upper, 1)))
    return rng.uniform(np.minimum(low, high), np.maximum(low, high), (count, len(low)))


def within(cells, rng):
    """A random posture of each cell, shape (m, n)."""
    s = rng.choice([0.0, 1.0, 0.5], (len(cells), 1)) + rng.normal(0.0, 0.2, (len(cells), 1))
    s = np.clip(s, 0.0, 1.0)
    off = np.where(rng.random(cells.dev.shape) < 0.5, np.sign(rng.normal(size=cells.dev.shape)), rng.uniform(-1, 1))
    return (1 - s) * cells.a + s * cells.b + off * cells.dev
