"""Random searches to judge candidates on: arms of 3 to 6 links, limits, weights, directions, every objective."""

import numpy as np

import selfmotion as sm
from selfmotion.profiles import BSplineProfile, HarmonicsProfile, SinusoidProfile


def random_search(seed, families=("sinusoid",)):
    """A problem, a profile family and a branch, at whose start the arm is inside its domain."""
    rng = np.random.default_rng([seed, 1729])
    while True:
        n = int(rng.integers(3, 7))
        links = rng.uniform(0.4, 1.6, n)
        if rng.random() < 0.2:
            links[1] = links[0]
        direction = rng.uniform(-3.0, 3.0) if n > 3 and rng.random() < 0.3 else None
        free = sm.PlanarArm(links, None, direction)
        branch, u = int(rng.integers(2)), rng.uniform(-np.pi, np.pi, free.n_u)
        # The path starts where a posture without a fold puts the tool.
        front = rng.uniform(-np.pi, np.pi) + np.array([0.0, (1, -1)[branch] * rng.uniform(0.5, 2.6)])
        given = u if direction is None else np.append(u, direction)
        start = links @ np.exp(1j * np.append(front, given))
        points = [[start.real, start.imag]]
        points += list(points[0] + rng.normal(size=(3, 2)) * rng.uniform(0.02, 0.3) * links.sum())
        path = sm.Bezier(points) if rng.random() < 0.7 else sm.Waypoints(points, "linear")
        q = free.solve(path(0.0), u, branch)[0]
        limits = [None if rng.random() < 0.7 else (a - rng.uniform(0.3, 4), a + rng.uniform(0.3, 4)) for a in q]
        arm = sm.PlanarArm(links, limits, direction)
        weights = None if rng.random() < 0.6 else rng.uniform(0.1, 2.0, n)
        objective = ("joint_travel", "joint_travel", "l1", "l2")[rng.integers(4)]
        samples = int(rng.choice([60, 200, 501]))
        # A start given by joints fixes their turns: here such that limited joints are inside, free ones anywhere.
        turned = q + 2 * np.pi * np.where(arm.limits.limited, 0, rng.integers(-2, 3, n))
        start = {"q": turned} if rng.random() < 0.3 else None
        try:
            problem = sm.Problem(arm, path, start, weights=weights, objective=objective, samples=samples)
        except sm.InvalidInputError:
            continue
        family = families[rng.integers(len(families))]
        if family == "sinusoid":
            profile = SinusoidProfile(u, rng.uniform(0.02, 0.5, arm.n_u))
        elif family == "harmonics":
            profile = HarmonicsProfile(u, int(rng.integers(1, 5)))
        else:
            profile = BSplineProfile(arm.n_u, int(rng.integers(4, 8)), u)
        return problem, profile, branch


def box_of(profile):
    """Bounds in which some candidates are feasible and some are not."""
    if isinstance(profile, SinusoidProfile):
        return (0.0, 3.0)
    return profile.box(np.full(profile.n_u, 0.4))
