"""Random problems with obstacles, each from its seed alone, in the plane and in space.

Obstacles stand anywhere, or where links of feasible postures are, so that they matter. Most leave room for the tool
along the path and for the first link; a few do not, and then there is no motion.
"""

import numpy as np
from soundness_spatial import arm_of, inside, reachable

import selfmotion as sm
from selfmotion.errors import InvalidInputError
from selfmotion.scene import (
    BoxObstacle,
    CapsuleObstacle,
    CircleObstacle,
    HalfPlaneObstacle,
    HalfSpaceObstacle,
    MeshObstacle,
    PolygonObstacle,
    SphereObstacle,
)
from selfmotion.study.random_problems import random_problem

ARMS = ("panda", "iiwa14", "fr3", "panda", "ur5e", "kr6r900")
SAMPLES = (10, 40, 150)
_TRIES = 60
_ALONG = np.linspace(0.0, 1.0, 65)
_FEW = np.linspace(0.0, 1.0, 9)
_CARELESS = 0.04  # obstacles that may be anywhere


def planar_scene(seed):
    """A problem of a planar arm with one redundant degree among one to four obstacles; None if none was drawn."""
    rng = np.random.default_rng([seed, 4713])
    for k in range(_TRIES):
        bare = random_problem(7_000_000 + _TRIES * seed + k)
        if bare is None:
            continue
        arm, path, reach = bare.arm, bare.path, bare.arm.reach
        options = _options(rng, reach)
        thickness = _thickness(rng, arm) * reach
        around = _around_planar(rng, bare)
        needed = options["clearance"] + 0.5 * float(np.max(thickness))
        points = np.concatenate([path(_ALONG), [[0.0, 0.0]]])
        obstacles = [_planar_obstacle(rng, reach, needed, points, around) for _ in range(int(rng.integers(1, 5)))]
        if not np.any(thickness > 0):
            options["self_collision"] = False
        given = {name: {"u": getattr(bare, name).u} for name in ("start", "end") if getattr(bare, name) is not None}
        thick = sm.PlanarArm(arm.links, _limits(arm), arm.direction, thickness=thickness)
        try:
            problem = sm.Problem(
                thick, path, elbow=bare.elbow, cyclic=bare.cyclic, weights=bare.weights, obstacles=obstacles,
                objective=bare.objective.kind, samples=int(rng.choice(SAMPLES)), **given, **options,
            )  # fmt: skip
        except InvalidInputError:
            continue
        if rng.random() < _CARELESS or _has_postures(problem):
            return problem
    return None


def spatial_scene(seed):
    """A problem of an arm in space on a line that it follows without obstacles, among one to four of them."""
    rng = np.random.default_rng([seed, 4714])
    arm = arm_of(ARMS[seed % len(ARMS)], seed % len(ARMS) >= 4)
    path, motion = reachable(arm, str(rng.choice(["constant", "turning"])), rng)
    for _ in range(_TRIES):
        clearance = float(rng.choice([0.0, rng.uniform(0.0, 0.05)]))
        links = sm.Problem(arm, path, obstacles=[SphereObstacle((9.0, 9.0, 9.0), 0.1)]).scene.links
        around = _around_spatial(rng, arm, path, motion, links)
        tool = path(_ALONG)[:, :3]
        obstacles = [_spatial_obstacle(rng, clearance, tool, around) for _ in range(int(rng.integers(1, 5)))]
        try:
            return sm.Problem(
                arm, path, obstacles=obstacles, clearance=clearance, self_collision=bool(rng.random() < 0.4),
                objective=str(rng.choice(["l2", "l2", "joint_travel", "l1"])), samples=int(rng.choice(SAMPLES)),
                least_singular_value=rng.uniform(0.01, 0.06) if rng.random() < 0.1 else None,
            )  # fmt: skip
        except InvalidInputError:
            continue
    return None


def _options(rng, reach):
    return {
        "clearance": float(rng.choice([0.0, rng.uniform(0.0, 0.03) * reach])),
        "self_collision": bool(rng.random() < 0.4),
        "least_singular_value": rng.uniform(0.01, 0.12) if rng.random() < 0.12 else None,
    }


def _thickness(rng, arm):
    kind = rng.choice(["none", "one", "each"], p=[0.4, 0.4, 0.2])
    return {"none": 0.0, "one": rng.uniform(0.0, 0.05), "each": rng.uniform(0.0, 0.05, arm.n)}[str(kind)]


def _limits(arm):
    ends = zip(arm.limits.lower, arm.limits.upper, strict=True)
    return [tuple(float(end) if np.isfinite(end) else None for end in pair) for pair in ends]


def _has_postures(problem):
    """Whether some allowed posture is seen at a few places all along the path."""
    u, ok = np.linspace(-np.pi, np.pi, 90), np.zeros(len(_FEW), bool)
    x = np.repeat(problem.path(_FEW), len(u), axis=0)
    for branch in problem.elbow_branches:
        q, found = problem.arm.solve(x, np.tile(u, len(_FEW))[:, None], branch)
        found &= (problem.arm.limits.excess(q) <= 0).all(axis=-1)
        found[found] = (problem.arm.least(q[found]) >= 0).all(axis=-1)
        ok |= found.reshape(len(_FEW), -1).any(axis=1)
    return ok.all()


def _around_planar(rng, problem):
    """Links of some postures along the path, ends of segments (k, 2, 2)."""
    arm = problem.arm
    found = [np.array([[[0.0, 0.0], [arm.links[0], 0.0]]])]
    for r in rng.uniform(0.0, 1.0, 40):
        q, ok = arm.solve(problem.path(r), [rng.uniform(-np.pi, np.pi)], int(rng.integers(0, 2)))
        if ok and (arm.limits.excess(q) <= 0).all():
            turn = np.cumsum(q)
            points = np.cumsum(arm.links[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1), axis=0)
            points = np.concatenate([[[0.0, 0.0]], points])
            found.append(np.stack([points[:-1], points[1:]], axis=1)[:-1])
    return np.concatenate(found[-8:])


def _planar_obstacle(rng, reach, needed, points, around):
    """An obstacle that keeps from the points, most of the time."""
    while True:
        kind = str(rng.choice(["circle", "polygon", "star", "spike", "half_plane"], p=[0.35, 0.2, 0.2, 0.1, 0.15]))
        size = reach * 10.0 ** rng.uniform(-1.8, -0.6)
        one, other = around[int(rng.integers(len(around)))]
        center = one + (other - one) * rng.uniform(0.1, 1.0) + rng.normal(0.0, 0.4 * size, 2)
        if rng.random() < 0.3:
            center = rng.uniform(-1.0, 1.0, 2) * reach
        free = needed * rng.uniform(1.0, 2.0) if rng.random() > _CARELESS else None
        if kind == "circle":
            if free is None or np.linalg.norm(points - center, axis=1).min() > size + free:
                return CircleObstacle(center, size)
        elif kind == "half_plane":
            angle = rng.uniform(0, 2 * np.pi)
            normal = np.array([np.cos(angle), np.sin(angle)])
            off = (points @ normal).min() - (free or -rng.uniform(0, 0.5) * reach) - rng.uniform(0.0, 0.3) * reach
            return HalfPlaneObstacle(normal * off, normal * rng.uniform(0.1, 10.0))
        else:
            made = _corners(rng, kind, center, size)
            if free is None or _outside(made, points, free):
                return made


def _corners(rng, kind, center, size):
    count = int(rng.integers(3, 9))
    if kind == "spike":  # a needle, or one with a wide foot
        turn, along = rng.uniform(0, 2 * np.pi), size * rng.uniform(2.0, 6.0)
        corners = np.array([[0.0, -0.05 * size], [along, 0.0], [0.0, 0.05 * size], [-0.3 * along, 0.0]])
        corners = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    else:
        angles = np.linspace(0, 2 * np.pi, count, endpoint=False) + rng.uniform(0, 2 * np.pi)
        radii = size * (rng.uniform(0.15, 1.5, count) if kind == "star" else np.ones(count))
        corners = radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return PolygonObstacle(center + corners)


def _outside(polygon, points, free):
    import shapely

    return shapely.distance(shapely.Polygon(polygon.corners), shapely.points(points)).min() > free


def _around_spatial(rng, arm, path, motion, links):
    """Capsules' axes of some postures of motions along the path, (k, 2, 3), without the tool and the first link."""
    found = [motion]
    for _ in range(3):
        r = float(rng.uniform())
        u = np.array([rng.uniform(*arm.parameter_range)])
        q, ok = arm.solve(path(r), u, int(rng.integers(len(arm.branches))))
        if ok and inside(arm, q):
            found.append(q[None])
    postures = np.concatenate(found)[rng.permutation(sum(map(len, found)))[:12]]
    middle = (links.frame >= 1) & (links.frame < arm.n - 2)
    return links.ends_at(postures)[:, middle].reshape(-1, 2, 3)


def _spatial_obstacle(rng, clearance, tool, around):
    """An obstacle that keeps from the tool, and from the foot of the arm, most of the time."""
    while True:
        kind = str(rng.choice(["sphere", "box", "capsule", "half_space", "mesh"], p=[0.3, 0.3, 0.2, 0.12, 0.08]))
        size = rng.uniform(0.03, 0.2)
        one, other = around[int(rng.integers(len(around)))]
        center = one + (other - one) * rng.uniform(0.0, 1.0) + rng.normal(0.0, 0.15, 3)
        if rng.random() < 0.3:
            center = rng.uniform([-0.8, -0.8, 0.0], [0.8, 0.8, 1.2])
        free = clearance + 0.16 if rng.random() > _CARELESS else -1.0
        away = np.linalg.norm(tool - center, axis=1).min()
        foot = np.linalg.norm(np.linspace([0, 0, 0], [0, 0, 0.4], 5) - center, axis=1).min()
        if kind == "half_space":
            if rng.random() < 0.5:
                return HalfSpaceObstacle((0.0, 0.0, min(-0.05, tool[:, 2].min() - free)), (0.0, 0.0, 1.0))
            normal = rng.normal(size=3) * [1, 1, 0.3]
            normal /= np.linalg.norm(normal)
            off = min((tool @ normal).min() - free, -0.25) - rng.uniform(0.0, 0.3)
            return HalfSpaceObstacle(normal * off, normal)
        wide = size * (2.0 if kind == "capsule" else 1.0)
        if min(away, foot) < wide + free:
            continue
        if kind == "sphere":
            return SphereObstacle(center, size)
        if kind == "box":
            return BoxObstacle(center, 2 * size / np.sqrt(3) * rng.uniform(0.3, 1.0, 3), rng.uniform(-3, 3, 3))
        if kind == "capsule":
            along = rng.normal(size=3)
            along *= size / np.linalg.norm(along)
            return CapsuleObstacle(center - along, center + along, size * rng.uniform(0.1, 0.9))
        corners = center + size * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
        return MeshObstacle.of_triangles(corners, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
