"""How far links are from obstacles and from each other, measured without the package's kernels.

Links of the plane are placed by sums of directions and measured by shapely; links in space by products of transforms,
their distances by searching along each for the place where a convex function is least; meshes by coal.
"""

import numpy as np
import shapely

import selfmotion as sm
from selfmotion.scene import (
    BoxObstacle,
    CapsuleObstacle,
    CircleObstacle,
    HalfPlaneObstacle,
    HalfSpaceObstacle,
    MeshObstacle,
    SphereObstacle,
)

_ALONG = np.linspace(0.0, 1.0, 17)  # of what is inside a polygon
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_SECTIONS = 80
_AT_ONCE = 20_000
_COAL = 2e-6  # what coal's distances may be wrong by [m]


def oracle(problem):
    """The oracle of a problem: `Planar` or `Spatial`."""
    return (Planar if isinstance(getattr(problem.arm, "bare", problem.arm), sm.PlanarArm) else Spatial)(problem)


class Clearances:
    """What is left of the clearance that a problem asks for, and of the least singular value.

    Parameters
    ----------
    problem : Problem
        Of an arm with links of known shape.
    """

    def __init__(self, problem):
        self.arm = getattr(problem.arm, "bare", problem.arm)
        self.obstacles = () if problem.scene is None else problem.scene.obstacles
        self.clearance = 0.0 if problem.scene is None else problem.scene.clearance
        self.self_collision = problem.scene is not None and problem.scene.self_collision
        self.pairs = problem.scene.links.pairs if self.self_collision else np.empty((0, 2), int)
        self.least = problem.least_singular_value

    def left(self, q):
        """Least of (distance − what is needed) in postures (k, n), in the unit of length, shape (k,).

        Of polygons that a link without any needed distance enters, minus the depth of some of it inside.
        """
        parts = [self._left(q[first : first + _AT_ONCE]) for first in range(0, len(q), _AT_ONCE)]
        return np.concatenate(parts) if parts else np.empty(0)

    def singular(self, q):
        """What is left of the least singular value, shape (k,); infinite where none is asked for."""
        if self.least is None:
            return np.full(len(q), np.inf)
        jacobian = self.jacobian(q)
        return np.linalg.svd(jacobian, compute_uv=False)[:, -1] - self.least

    def allowed(self, q, give=0.0):
        """Which postures (…, n) lack no more than `give` as a part of the reach, and of the singular value."""
        flat = q.reshape(-1, q.shape[-1])
        ok = self.singular(flat) >= -give
        ok[ok] = self.left(flat[ok]) >= -give * self.arm.reach
        return ok.reshape(q.shape[:-1])


class Planar(Clearances):
    """Of planar arms, by shapely."""

    def __init__(self, problem):
        super().__init__(problem)
        self.radius = 0.5 * np.broadcast_to(self.arm.thickness, self.arm.n)
        self.bodies = [
            shapely.Polygon(obstacle.corners) if obstacle.kind == "polygon" else None for obstacle in self.obstacles
        ]

    def points(self, q):
        """Ends of the links, shape (k, n + 1, 2)."""
        steps = np.stack([np.cos(np.cumsum(q, axis=1)), np.sin(np.cumsum(q, axis=1))], axis=-1)
        ends = np.cumsum(steps * self.arm.links[:, None], axis=1)
        return np.concatenate([np.zeros((len(q), 1, 2)), ends], axis=1)

    def jacobian(self, q):
        """The task's Jacobian with lengths as parts of the reach, shape (k, d, n)."""
        points = self.points(q)
        off = points[:, -1:] - points[:, :-1]
        rows = np.stack([-off[..., 1], off[..., 0]], axis=1) / self.arm.reach
        if self.arm.direction is not None:
            rows = np.concatenate([rows, np.ones((len(q), 1, self.arm.n))], axis=1)
        return rows

    def _left(self, q):
        points = self.points(q)
        left = np.full(len(q), np.inf)
        for j in range(self.arm.n):
            link = shapely.linestrings(points[:, j : j + 2])
            for obstacle, body in zip(self.obstacles, self.bodies, strict=True):
                needed = self.radius[j] + self.clearance
                left = np.minimum(left, self._distance(obstacle, body, link, points[:, j : j + 2], needed) - needed)
            for one, other in self.pairs:
                if other == j:
                    apart = shapely.distance(shapely.linestrings(points[:, one : one + 2]), link)
                    left = np.minimum(left, apart - self.radius[one] - self.radius[j])
        return left

    @staticmethod
    def _distance(obstacle, body, link, ends, needed):
        if isinstance(obstacle, CircleObstacle):
            return shapely.distance(link, shapely.Point(obstacle.center)) - obstacle.radius
        if isinstance(obstacle, HalfPlaneObstacle):
            unit = obstacle.normal / np.linalg.norm(obstacle.normal)
            return ((ends - obstacle.point) @ unit).min(axis=1)
        distance = shapely.distance(link, body)
        for k in np.flatnonzero(distance == 0.0):
            lines = [part for part in shapely.get_parts(shapely.intersection(link[k], body)) if part.length > 0]
            at = shapely.line_interpolate_point(np.array(lines, object)[:, None], _ALONG[None], normalized=True)
            distance[k] = -float(shapely.distance(at, body.boundary).max(initial=0.0))
        return distance


class Spatial(Clearances):
    """Of arms in space, whose links are capsules."""

    def __init__(self, problem):
        super().__init__(problem)
        self.parts = self.arm.chain.shapes.capsules
        self.moving = [k for k, part in enumerate(self.parts) if part.frame >= 0]

    def frames(self, q):
        """Frames after each joint, shape (k, n, 4, 4)."""
        offsets, slides = self.arm.chain.offsets, self.arm.chain.prismatic
        frame, found = np.broadcast_to(offsets[0], (len(q), 4, 4)), []
        for j in range(q.shape[1]):
            move = np.zeros((len(q), 4, 4))
            move[:] = np.eye(4)
            if slides[j]:
                move[:, 2, 3] = q[:, j]
            else:
                move[:, 0, 0] = move[:, 1, 1] = np.cos(q[:, j])
                move[:, 1, 0] = np.sin(q[:, j])
                move[:, 0, 1] = -move[:, 1, 0]
            frame = frame @ move
            found.append(frame)
            frame = frame @ offsets[j + 1]
        return np.stack(found, axis=1)

    def ends(self, q):
        """Ends of the capsules' axes, shape (k, c, 2, 3)."""
        frames, ends = self.frames(q), []
        for part in self.parts:
            if part.frame < 0:
                ends.append(np.broadcast_to(np.asarray(part.ends), (len(q), 2, 3)))
                continue
            frame = frames[:, part.frame]
            ends.append(np.einsum("kij,ej->kei", frame[:, :3, :3], np.asarray(part.ends)) + frame[:, None, :3, 3])
        return np.stack(ends, axis=1)

    def jacobian(self, q):
        """The task's Jacobian, as the arm has it, lengths as parts of the reach."""
        rows = np.array(self.arm.jacobian(q))
        rows[:, :3] /= self.arm.reach
        return rows

    def _left(self, q):
        ends, left = self.ends(q), np.full(len(q), np.inf)
        for obstacle in self.obstacles:
            for c in self.moving:
                distance = _from_obstacle(obstacle, ends[:, c, 0], ends[:, c, 1], self.parts[c].radius)
                left = np.minimum(left, distance - self.parts[c].radius - self.clearance)
        for c, d in self.pairs:
            u, v = ends[:, d, 0], ends[:, d, 1]
            apart = _least_along(lambda p, u=u, v=v: _from_segment(p, u, v), ends[:, c, 0], ends[:, c, 1])
            left = np.minimum(left, apart - self.parts[c].radius - self.parts[d].radius)
        return left


def _least_along(distance, p, q):
    """Least of a convex function of points along segments, by golden sections, ends included."""
    low, high = np.zeros(len(p)), np.ones(len(p))

    def at(t):
        return distance(p + t[:, None] * (q - p))

    one, two = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_one, at_two = at(one), at(two)
    for _ in range(_SECTIONS):
        left = at_one <= at_two
        low, high = np.where(left, low, one), np.where(left, two, high)
        new = np.where(left, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        value = at(new)
        one, two = np.where(left, new, two), np.where(left, one, new)
        at_one, at_two = np.where(left, value, at_two), np.where(left, at_one, value)
    return np.minimum.reduce([at_one, at_two, distance(p), distance(q)])


def _from_segment(p, u, v):
    along = v - u
    square = (along * along).sum(axis=-1)
    t = np.clip(((p - u) * along).sum(axis=-1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.linalg.norm(p - u - t[:, None] * along, axis=-1)


def _from_obstacle(obstacle, p, q, radius):
    """Distance of segments from an obstacle, at most zero where they touch."""
    if isinstance(obstacle, HalfSpaceObstacle):
        unit = obstacle.normal / np.linalg.norm(obstacle.normal)
        return np.minimum((p - obstacle.point) @ unit, (q - obstacle.point) @ unit)
    if isinstance(obstacle, SphereObstacle):
        center = np.broadcast_to(obstacle.center, p.shape)
        return _from_segment(center, p, q) - obstacle.radius
    if isinstance(obstacle, CapsuleObstacle):
        start, end = obstacle.start[None], obstacle.end[None]
        return _least_along(lambda x: _from_segment(x, start, end), p, q) - obstacle.radius
    if isinstance(obstacle, BoxObstacle):

        def distance(x):
            off = np.abs((x - obstacle.center) @ obstacle.rotation) - 0.5 * obstacle.size
            return np.linalg.norm(np.maximum(off, 0.0), axis=-1)

        return _least_along(distance, p, q)
    assert isinstance(obstacle, MeshObstacle)
    return by_coal(obstacle, p, q, radius) + radius + _COAL


def by_coal(obstacle, p, q, radius):
    """Distances of capsules from an obstacle, measured by coal."""
    import coal

    if isinstance(obstacle, MeshObstacle):
        shape, pose = coal.BVHModelOBBRSS(), coal.Transform3s()
        shape.beginModel(len(obstacle.triangles), len(obstacle.vertices))
        shape.addVertices(np.asarray(obstacle.vertices))
        for triangle in obstacle.triangles:
            shape.addTriangle(*(np.asarray(obstacle.vertices[k]) for k in triangle))
        shape.endModel()
    else:
        shape = coal.Box(*obstacle.size)
        pose = coal.Transform3s(np.array(obstacle.rotation), np.array(obstacle.center))
    request, found = coal.DistanceRequest(), np.empty(len(p))
    for k in range(len(p)):
        along = q[k] - p[k]
        length = np.linalg.norm(along)
        turn = np.eye(3)
        if length > 0:
            z = along / length
            x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
            x /= np.linalg.norm(x)
            turn = np.stack([x, np.cross(z, x), z], axis=1)
        result = coal.DistanceResult()
        place = coal.Transform3s(turn, 0.5 * (p[k] + q[k]))
        found[k] = coal.distance(coal.Capsule(float(radius), float(length)), place, shape, pose, request, result)
    return found
