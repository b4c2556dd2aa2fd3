"""The scene that an arm works in: obstacles that its links must keep clear of, and the arm itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from selfmotion._checks import number
from selfmotion._types import FloatArray, IntArray
from selfmotion.arms import RedundantArm
from selfmotion.arms.cells import Cells
from selfmotion.constrained.constraint import States
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import PLANE, SPACE
from selfmotion.scene import _capsule_kernels as kernels
from selfmotion.scene.kinds import BOX, CAPSULE, HALF_SPACE, POLYGON, SPHERE
from selfmotion.scene.links import Links
from selfmotion.scene.mesh import MeshObstacle
from selfmotion.scene.obstacle import Obstacle

_TOLERANCE = 1e-9  # of clearance, as a part of the reach
_ROUNDING = 1e-12  # of the size of a ball
_LARGEST = 1e5  # coordinates of obstacles, as parts of it: of larger ones rounding would make more than that


class Scene:
    """Obstacles and links that must keep clear of each other; a :class:`~selfmotion.constrained.Constraint`.

    Parameters
    ----------
    arm : RedundantArm
    obstacles : sequence of Obstacle
        Of the plane for a planar arm, else of space.
    clearance : float
        Least distance between the surfaces of links and obstacles, zero or more, in the unit of length.
    self_collision : bool
        Whether links that are not neighbours must not touch each other.

    Attributes
    ----------
    links : Links

    Raises
    ------
    InvalidInputError
        If the clearance is negative, an obstacle has the wrong dimension, or the arm's links have no known shape.

    Notes
    -----
    Margins are ``d(axis, obstacle) − radius − clearance``, d being the signed distance of the link's axis; of two links
    ``d(axis, axis) − radius − radius``. d changes by no more than points move, which makes what is known of one posture
    known of all nearby.
    """

    check = "clearance"
    unit = ""

    def __init__(
        self, arm: RedundantArm, obstacles: Sequence[Obstacle], clearance: float = 0.0, self_collision: bool = False
    ) -> None:
        self.obstacles = tuple(obstacles)
        for k, obstacle in enumerate(self.obstacles):
            if not isinstance(obstacle, Obstacle):
                remedy = "give one such as sm.CircleObstacle((x, y), radius)"
                raise InvalidInputError(f"obstacles.{k}", f"is a {type(obstacle).__name__}", remedy)
        self.clearance = number("clearance", clearance)
        if self.clearance < 0.0:
            raise InvalidInputError("clearance", "must not be negative", "give a distance, or leave it out", clearance)
        self.self_collision = bool(self_collision)
        dimension = PLANE if arm.dimension == PLANE else SPACE
        for k, obstacle in enumerate(self.obstacles):
            if obstacle.dimension != dimension:
                mine, other = ("a planar", "space") if dimension == PLANE else ("a spatial", "the plane")
                raise InvalidInputError(
                    f"obstacles.{k}", f"is a {obstacle.kind} of {other}, and this is {mine} arm",
                    "give circle, polygon or half_plane" if dimension == PLANE
                    else "give sphere, half_space, box, capsule or mesh",
                )  # fmt: skip
            if _extent(obstacle) > _LARGEST * arm.reach:
                raise InvalidInputError(
                    f"obstacles.{k}", f"is more than {_LARGEST:g} times as large, or as far away, as the arm can reach",
                    "are the units of arm and obstacles the same? A wall is a half-plane or a half-space",
                )  # fmt: skip
        self.links = links = Links.of(arm)
        self.scale = float(arm.reach)
        self.tolerance = _TOLERANCE * self.scale
        self._capsules = kernels.Capsules(
            links.turns, links.shifts, links.first, links.frame, links.ends, links.radius, links.levers
        )
        solid = [k for k, obstacle in enumerate(self.obstacles) if not isinstance(obstacle, MeshObstacle)]
        self._meshes = {k: mesh for k, mesh in enumerate(self.obstacles) if isinstance(mesh, MeshObstacle)}
        forms = [self.obstacles[k].shape() for k in solid]
        self._shapes = kernels.Shapes(
            np.array([kind for kind, _ in forms], np.int64),
            np.cumsum([0, *(len(numbers) for _, numbers in forms)]).astype(np.int64),
            np.concatenate([np.empty(0), *(numbers for _, numbers in forms)]),
        )
        self._balls = np.array([_ball(*form) for form in forms]).reshape(-1, 4)
        moving = np.flatnonzero(links.frame >= 0)
        inner = links.pairs if self_collision else np.empty((0, 2), np.int64)
        against = [(c, k, links.radius[c] + self.clearance) for k in range(len(solid)) for c in moving]
        against += [(c, -1 - d, links.radius[c] + links.radius[d]) for c, d in inner]
        self._pairs = kernels.Pairs(
            np.array([c for c, _, _ in against], np.int64),
            np.array([other for _, other, _ in against], np.int64),
            np.array([needed for _, _, needed in against], float),
        )
        self._solid = solid
        self._of_meshes = [(int(c), k, float(links.radius[c]) + self.clearance) for k in self._meshes for c in moving]

    def __repr__(self) -> str:
        return f"Scene({len(self.obstacles)} obstacles, clearance={self.clearance!r})"

    def margins(self, q: FloatArray) -> FloatArray:
        """Return what is left of the distance that each pair needs, in postures (k, n); shape (k, pairs)."""
        postures = np.ascontiguousarray(q, dtype=float)
        found = np.empty((len(postures), len(self._pairs.link)))
        kernels.margins_all(self._capsules, self._shapes, self._pairs, postures, found)
        if not self._of_meshes:
            return found
        return np.concatenate([found, self._nearest_of_meshes(self._points(postures))[0]], axis=1)

    def least_margins(self, q: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return the least margin of postures (k, n), and which it is; shapes (k,)."""
        postures = np.ascontiguousarray(q, dtype=float)
        found, which = np.empty(len(postures)), np.empty(len(postures), np.int64)
        kernels.least_all(self._capsules, self._shapes, self._pairs, self._balls, postures, found, which)
        if not self._of_meshes:
            return found, which
        points = self._points(postures)
        near = [self._meshes[k].no_more(points[:, c, 0]) - needed for c, k, needed in self._of_meshes]
        margins = self._from_meshes(points, np.minimum(found, np.min(near, axis=0))[:, None])
        mesh = margins.argmin(axis=1)
        nearest = margins[np.arange(len(postures)), mesh]
        return np.minimum(found, nearest), np.where(nearest < found, len(self._pairs.link) + mesh, which)

    def gradients(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the margins of postures (k, n) and their derivatives by the joints, (k, pairs) and (k, pairs, n)."""
        postures = np.ascontiguousarray(q, dtype=float)
        k, p, n = len(postures), len(self._pairs.link), postures.shape[1]
        found, rates = np.empty((k, p)), np.empty((k, p, n))
        kernels.gradients_all(self._capsules, self._shapes, self._pairs, postures, found, rates)
        if not self._of_meshes:
            return found, rates
        margins, at, normal = self._nearest_of_meshes(self._points(postures))
        more = np.zeros((k, len(self._of_meshes), n))
        frames = np.array([self.links.frame[c] for c, _, _ in self._of_meshes], np.int64)
        kernels.rates_at(self._capsules, postures, frames, at, normal, more)
        return np.concatenate([found, margins], axis=1), np.concatenate([rates, more], axis=1)

    def of_cells(self, cells: Cells, forgiven: float = 0.0) -> States:
        """Return what is sure of cells."""
        points, half, rest = self._hulls(len(cells))
        kernels.hulls_of_cells(
            self._capsules, np.ascontiguousarray(cells.a), np.ascontiguousarray(cells.b),
            np.ascontiguousarray(cells.dev), points, half, rest,
        )  # fmt: skip
        return self._of_hulls(points, half, rest, forgiven)

    def of_boxes(self, low: FloatArray, high: FloatArray, places: FloatArray | None = None) -> States:
        """Return what is sure of boxes of joint angles (m, n), or of postures whose links end in `places`, if known."""
        points, half, rest = self._hulls(len(low))
        if places is not None and places.shape[1]:
            points[..., 2], half[..., 2] = 0.0, 0.0
            for end in range(2):  # a planar arm's links go from joint to joint
                here = places[:, end : places.shape[1] - 1 + end]
                points[:, :, end, :2], half[:, :, end, :2] = here[..., :2], here[..., 2:4]
                rest[:, :, end] = here[..., 4]
            return self._of_hulls(points, half, rest, 0.0)
        kernels.hulls_of_boxes(
            self._capsules, np.ascontiguousarray(low), np.ascontiguousarray(high), points, half, rest
        )
        return self._of_hulls(points, half, rest, 0.0)

    def cause(self, k: int) -> str:
        """Return in words what pair k is, such as ``"link 3 against obstacle 2 (clamp)"``."""
        names = self.links.names
        if k >= len(self._pairs.link):
            c, mesh, _ = self._of_meshes[k - len(self._pairs.link)]
            return f"{names[c]} against {self.name(mesh)}"
        c, other = int(self._pairs.link[k]), int(self._pairs.other[k])
        return f"{names[c]} against {names[-1 - other] if other < 0 else self.name(self._solid[other])}"

    def name(self, k: int) -> str:
        """Return what obstacle k is called: its number from 1, and its name if it has one."""
        name = self.obstacles[k].name
        return f"obstacle {k + 1}" + (f" ({name})" if name else "")

    def doubts(self) -> list[str]:
        """Return what is doubtful: units of obstacles, a clearance from nothing, or nothing that links come near to."""
        found = [
            f"{self.name(k)}: {doubt}"
            for k, obstacle in enumerate(self.obstacles) for doubt in obstacle.doubts(self.scale)
        ]  # fmt: skip
        lonely = self._keeps_from_nothing()
        return found if lonely is None else [*found, lonely]

    def _keeps_from_nothing(self) -> str | None:
        if not self.obstacles:
            return "a clearance is asked for, and no obstacle is given" if self.clearance else None
        each = self.margins(np.zeros((1, self.links.levers.shape[-1])))[0]
        of_links = np.append(self._pairs.other < 0, np.zeros(len(self._of_meshes), bool))
        nearest = float(each[~of_links].min(initial=np.inf)) + self.clearance
        if nearest <= 2.0 * self.scale:  # links and obstacles in reach are no farther apart
            return None
        return (
            f"no obstacle is in reach, the nearest being {nearest:.6g} from the arm: are their units those of the arm?"
        )

    def _points(self, q: FloatArray) -> FloatArray:
        points = np.empty((len(q), len(self.links.frame), 2, 3))
        kernels.place_all(self._capsules, q, points)
        return points

    def _hulls(self, m: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        c = len(self.links.frame)
        return np.empty((m, c, 2, 3)), np.empty((m, c, 2, 3)), np.empty((m, c, 2))

    def _of_hulls(self, points: FloatArray, half: FloatArray, rest: FloatArray, forgiven: float) -> States:
        state, by = np.empty(len(points), np.int64), np.empty(len(points), np.int64)
        kernels.verdicts(self._shapes, self._pairs, points, half, rest, self.tolerance, forgiven, state, by)
        if not self._of_meshes:
            return States(state, by)
        open_ = np.flatnonzero(state >= 0)
        moves = (np.linalg.norm(half[open_], axis=-1) + rest[open_]).max(axis=-1)[:, [c for c, _, _ in self._of_meshes]]
        margins = self._from_meshes(points[open_], moves - forgiven)
        short = [self._meshes[k].shortfall for _, k, _ in self._of_meshes]
        lack = margins + moves + self.tolerance + short
        worst = lack.argmin(axis=1)
        blocked = lack[np.arange(len(open_)), worst] < 0.0
        free = (margins + forgiven > moves).all(axis=1)
        first = len(self._pairs.link)
        by[open_] = np.where(blocked, first + worst, np.where(free | (by[open_] >= 0), by[open_], first + worst))
        state[open_] = np.where(blocked, -1, np.minimum(state[open_], free))
        return States(state, by)

    def _from_meshes(self, points: FloatArray, enough: FloatArray) -> FloatArray:
        """Return margins against meshes (k, p); where the mesh's extent alone leaves more than `enough`, that."""
        enough = np.broadcast_to(enough, (len(points), len(self._of_meshes)))
        found = np.empty(enough.shape)
        for column, (c, k, needed) in enumerate(self._of_meshes):
            p, q = points[:, c, 0], points[:, c, 1]
            found[:, column] = self._meshes[k].no_less(p, q) - needed
            near = np.flatnonzero(found[:, column] <= enough[:, column])
            found[near, column] = self._meshes[k].distances(p[near], q[near]) - needed
        return found

    def _nearest_of_meshes(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return margins against meshes (k, p), with the points of the axes concerned and directions (k, p, 3)."""
        k, p = len(points), len(self._of_meshes)
        found, at, normal = np.empty((k, p)), np.empty((k, p, 3)), np.empty((k, p, 3))
        for column, (c, number_of, needed) in enumerate(self._of_meshes):
            nearest = self._meshes[number_of].nearest
            distance, at[:, column], normal[:, column] = nearest(points[:, c, 0], points[:, c, 1])
            found[:, column] = distance - needed
        return found, at, normal


def _ball(kind: int, numbers: FloatArray) -> FloatArray:
    """Return the centre and the radius of a ball that holds a shape, shape (4,); infinite of a half-space."""
    if kind == SPHERE:
        return numbers
    if kind == BOX:
        return np.array([*numbers[:3], (1.0 + _ROUNDING) * np.linalg.norm(numbers[3:6])])
    if kind == CAPSULE:
        ends = numbers[:6].reshape(2, 3)
        return np.array([*ends.mean(axis=0), (1.0 + _ROUNDING) * 0.5 * np.linalg.norm(ends[1] - ends[0]) + numbers[6]])
    if kind == POLYGON:
        corners = numbers[1:].reshape(-1, 2)
        middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        return np.array([*middle, 0.0, (1.0 + _ROUNDING) * np.linalg.norm(corners - middle, axis=1).max()])
    return np.array([0.0, 0.0, 0.0, np.inf])


def _extent(obstacle: Obstacle) -> float:
    """Return the largest of an obstacle's coordinates and sizes; of a half-space, whose distances are exact, none."""
    if isinstance(obstacle, MeshObstacle):
        return float(np.abs(obstacle.vertices).max())
    kind, numbers = obstacle.shape()
    if kind == HALF_SPACE:
        return 0.0
    return float(np.abs(numbers[1:] if kind == POLYGON else numbers).max())
