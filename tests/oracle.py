"""Inverse kinematics that shares no formula with the package: circles intersected in the complex plane, many at once.

`Arms` holds a batch of 3R arms (4R ones with a fixed direction are 3R arms with a shifted target and θ4 = δ − u). Its
margins say by how much each constraint holds, so that its sign decides and its zero is where a constraint takes hold.
"""

import numpy as np

import selfmotion as sm


def random_arm(rng, widest=6.2):
    """A 3R arm, or a 4R arm with a fixed direction: equal and extreme links, tight, wide and no limits."""
    links = rng.uniform(0.2, 2.0, 3)
    shape = rng.integers(0, 8)
    if shape == 0:
        links[1] = links[0]
    elif shape == 1:
        links *= 10.0 ** rng.uniform(-1, 1, 3)
    direction = None
    if rng.random() < 0.2:
        links, direction = np.append(links, rng.uniform(0.1, 1)), rng.uniform(-np.pi, np.pi)
    limits = []
    for _ in links:
        low = rng.uniform(-np.pi, np.pi)
        span = (None, rng.uniform(0.5, 2), rng.uniform(2, 6), rng.uniform(5, widest))[rng.integers(0, 4)]
        limits.append(None if span is None else (low, low + span))
    return sm.PlanarArm(links, limits, direction)


def random_path(rng, arm):
    """A path of some kind about where the arm can reach."""
    reach, center = arm.links[:3].sum(), arm.annulus[0]
    kind = rng.integers(0, 4)
    if kind == 0:
        return sm.Line(*(center + rng.uniform(-0.9, 0.9, (2, 2)) * reach))
    if kind == 1:
        return sm.Bezier(center + rng.uniform(-1, 1, (rng.integers(3, 7), 2)) * reach)
    if kind == 2:
        return sm.Circle(center + rng.uniform(-0.6, 0.6, 2) * reach, rng.uniform(0.1, 0.6) * reach)
    points = center + rng.uniform(-0.9, 0.9, (rng.integers(3, 6), 2)) * reach
    return sm.Waypoints(points, ("linear", "spline")[rng.integers(0, 2)])


class Arms:
    """A batch of arms, one per row; every method takes arrays of shape (rows, …)."""

    def __init__(self, arms, signs):
        self.links = np.array([arm.links[:3] for arm in arms])
        self.lower, self.upper = (np.full((len(arms), 4), fill) for fill in (-np.inf, np.inf))
        self.shift, self.direction = np.zeros(len(arms), complex), np.zeros(len(arms))
        for k, arm in enumerate(arms):
            self.lower[k, : arm.n], self.upper[k, : arm.n] = arm.limits.lower, arm.limits.upper
            if arm.direction is not None:
                self.shift[k], self.direction[k] = arm.links[3] * np.exp(1j * arm.direction), arm.direction
        self.sign = np.asarray(signs, float)

    def __getitem__(self, rows):
        part = object.__new__(Arms)
        for name, value in vars(self).items():
            setattr(part, name, value[rows])
        return part

    def joints(self, x, u):
        """Joint angles (rows, k, 4) and the reach margins (rows, k, 2) for complex targets (rows,) and u (rows, k)."""
        l1, l2, l3 = (self.links[:, j, None] for j in range(3))
        wrist = (x - self.shift)[:, None] - l3 * np.exp(1j * u)
        d = np.abs(wrist)
        reach = np.stack([l1 + l2 - d, d - np.abs(l1 - l2)], axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (l1**2 - l2**2 + d**2) / (2 * d)
            across = np.sqrt(np.maximum((l1 + l2 + d) * (l2 - d + l1) * (l2 + d - l1) * (l1 + d - l2), 0)) / (2 * d)
            elbow = wrist / d * (along - 1j * self.sign[:, None] * across)
        theta1, phi2 = np.angle(elbow), np.angle(wrist - elbow)
        theta4 = self.direction[:, None] - u
        return np.stack([theta1, phi2 - theta1, u - phi2, theta4], axis=-1), reach

    def joints_by_theta1(self, x, theta1, sign3):
        """Joint angles (rows, k, 4), regular at θ2 = 0 and π, and whether they reach, given θ1 and sign of θ3."""
        l1, l2, l3 = (self.links[:, j, None] for j in range(3))
        rest = (x - self.shift)[:, None] - l1 * np.exp(1j * theta1)
        d = np.abs(rest)
        ok = (d <= l2 + l3) & (d >= np.abs(l2 - l3))
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (l2**2 - l3**2 + d**2) / (2 * d)
            across = np.sqrt(np.maximum(l2**2 - along**2, 0))
            wrist = rest / d * (along - 1j * sign3 * across)
        phi2, u = np.angle(wrist), np.angle(rest - wrist)
        return np.stack([theta1, phi2 - theta1, u - phi2, self.direction[:, None] - u], axis=-1), ok

    def at_fold(self, x, value, side):
        """Joint angles (rows, 4) with θ2 = value (0 or π), by the law of cosines; side ±1 chooses the solution."""
        l1, l2, l3 = self.links.T
        target = x - self.shift
        wrist = np.where(value == 0, l1 + l2, np.abs(l1 - l2))
        radius = np.abs(target)
        cosine = (radius**2 + l3**2 - wrist**2) / (2 * radius * l3)
        u = np.angle(target) + side * np.arccos(np.clip(cosine, -1, 1))
        theta1 = np.angle(target - l3 * np.exp(1j * u)) + np.where((value != 0) & (l1 < l2), np.pi, 0)
        return np.stack([theta1, value, u - value - theta1, self.direction - u], axis=-1), u

    def limit_margins(self, q):
        """Signed distances (…, 8) of joints (rows, …, 4) to lower and upper limits, turns being free."""
        shape = (len(q),) + (1,) * (q.ndim - 2) + (4,)
        lower, upper = self.lower.reshape(shape), self.upper.reshape(shape)
        limited = np.isfinite(lower)
        low, high = np.where(limited, lower, 0), np.where(limited, upper, 0)
        middle, half = 0.5 * (low + high), np.where(limited, 0.5 * (high - low), np.inf)
        off = np.mod(q - middle + np.pi, 2 * np.pi) - np.pi
        return np.concatenate([half + off, half - off], axis=-1)

    def margins(self, x, u):
        """Signed margins (rows, k, 10) of reach (outer, inner) and of the limits (lower θ1…θ4, upper θ1…θ4)."""
        q, reach = self.joints(x, u)
        limits = self.limit_margins(q)
        return np.concatenate([reach / self.links.sum(axis=1)[:, None, None], limits], axis=-1)

    def margin(self, x, u):
        """Least margin, shape (rows, k): positive where feasible."""
        return self.margins(x, u).min(axis=-1)


def column_of(cause):
    """The column of `Arms.margins` that belongs to a cause."""
    if cause.kind == "fold":
        return 0 if cause.value == 0 else 1
    return 2 + cause.joint + (4 if cause.kind == "upper limit" else 0)


def as_complex(points):
    return points[..., 0] + 1j * points[..., 1]
