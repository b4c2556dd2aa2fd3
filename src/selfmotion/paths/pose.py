"""Paths of poses: a position curve with an orientation, or poses that the tool must pass."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from selfmotion._checks import choice, finite_array, read_only
from selfmotion._types import FloatArray, FollowRule, Poses, Rotation, Rotations, Vector
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import PLANE, POSE, SPACE, Path, distance
from selfmotion.paths.following import UPRIGHT, Following
from selfmotion.paths.orientation import Constant, GreatCircles, Orientation, RotationSpline
from selfmotion.paths.placed import direction
from selfmotion.paths.waypoints import Pieces
from selfmotion.rotations import apart, conjugate, continuous, matrix, product, rotation, unit_quaternions

# Rotations nearer than this are the same [rad].
_SAME = 1e-12


def rotation_matrix(pose: FloatArray) -> FloatArray:
    """Return the rotation matrices of poses (..., 7), shape (..., 3, 3); their columns are the tool's axes.

    Parameters
    ----------
    pose : array, shape (..., 7)
        Position and unit quaternion (w, x, y, z).

    Returns
    -------
    array, shape (..., 3, 3)
    """
    return matrix(pose[..., SPACE:])


def angular_velocity(pose: FloatArray, pose_rate: FloatArray) -> FloatArray:
    """Return the angular velocities ω of poses (..., 7) with derivatives (..., 7), in the base's frame, shape (..., 3).

    ``(0, ω) = 2 q' ⊗ q*``; [rad] per unit of the parameter that the derivatives are with respect to.

    Parameters
    ----------
    pose : array, shape (..., 7)
        Position and unit quaternion (w, x, y, z).
    pose_rate : array, shape (..., 7)
        Its derivative.

    Returns
    -------
    array, shape (..., 3)
    """
    return 2.0 * product(pose_rate[..., SPACE:], conjugate(pose[..., SPACE:]))[..., 1:]


class PosePath(Path):
    """A space curve for the tool's position, with an orientation along it.

    Parameters
    ----------
    position : Path
        A space curve; plane curves become one by kind ``placed``.
    orientation : array_like, shape (4,) or (3, 3), optional
        The same all along: a unit quaternion w, x, y, z, or a rotation matrix whose columns are the tool's axes.
    orientations : array_like, shape (k, 4), optional
        Unit quaternions w, x, y, z to pass, at least two.
    at : array_like, shape (k,), optional
        The r of each of them, ascending from 0 to 1; evenly spaced by default.
    interpolation : {"linear", "spline"}
        Between orientations: turns of constant angular velocity (slerp), or a smooth curve whose angular velocity is
        continuous, and its derivative too unless neighbours are about a half turn apart.
    follow : mapping, optional
        ``{axis: x, up: [0, 0, 1]}``: the tool axis (x, y or z) along the curve's tangent. Of the turn about it, z (x if
        `axis` is z) is as near to `up` as it can be.

    Raises
    ------
    InvalidInputError
        If not exactly one of orientation, orientations and follow is given, one of them is malformed, or the position
        is not a space curve. Where following fails the message names r: at corners and where the tangent is along `up`.

    Notes
    -----
    Of a half turn both ways are equally short; the signs of the quaternions decide.
    """

    kind = "pose"

    dimension = POSE

    def __init__(
        self,
        position: Path,
        orientation: Rotation | None = None,
        orientations: Rotations | None = None,
        at: Vector | None = None,
        interpolation: Literal["linear", "spline"] = "linear",
        follow: FollowRule = None,
    ) -> None:
        if not isinstance(position, Path):
            raise InvalidInputError("position", f"is a {type(position).__name__}", "give a space curve")
        if position.dimension != SPACE:
            remedy = "put it into space by kind placed" if position.dimension == PLANE else "give its positions only"
            kind = "plane" if position.dimension == PLANE else "path of poses"
            raise InvalidInputError("position", f"is no space curve but a {kind} one", remedy)
        self.position = position
        self.interpolation = choice("interpolation", interpolation, ("linear", "spline"))
        given = {"orientation": orientation, "orientations": orientations, "follow": follow}
        names = [name for name, value in given.items() if value is not None]
        if len(names) != 1:
            reason = f"is given by {' and '.join(names)}" if names else "is missing"
            raise InvalidInputError("orientation", reason, f"give one of {', '.join(given)}")
        if at is not None and orientations is None:
            raise InvalidInputError("at", "stands without orientations", "give orientations, or leave it out")
        self._given = np.empty(0)
        self._orientation: Orientation
        if orientation is not None:
            self._orientation = Constant(rotation("orientation", orientation))
        elif orientations is not None:
            self._orientation = self._between(orientations, at)
        else:
            self._orientation = Following(position, *_rule(follow))

    def __repr__(self) -> str:
        return f"PosePath({self.position!r}, {type(self._orientation).__name__})"

    def _between(self, orientations: Rotations, at: Vector | None) -> Orientation:
        q = unit_quaternions("orientations", orientations)
        if len(q) < 2:
            raise InvalidInputError("orientations", f"has {len(q)} rows", "give at least two, or orientation")
        knots = np.linspace(0.0, 1.0, len(q)) if at is None else finite_array("at", at, 1)
        if len(knots) != len(q):
            raise InvalidInputError("at", f"has {len(knots)} numbers for {len(q)} orientations", "give one each", at)
        if knots[0] != 0.0 or knots[-1] != 1.0 or not (np.diff(knots) > 0).all():
            raise InvalidInputError("at", "does not ascend from 0 to 1", "start with 0, ascend, end with 1", at)
        self._given = read_only(knots)
        return _curve(knots, q, self.interpolation, self.position.is_closed)

    @property
    def breaks(self) -> FloatArray:
        """Those of the position and of the orientation."""
        return np.union1d(self.position.breaks, self._orientation.breaks)

    @property
    def waypoints(self) -> FloatArray:
        """Those of the position, and the parameters of given orientations."""
        return np.union1d(self.position.waypoints, self._given)

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return np.hstack([self.position(r, order), self._orientation.evaluate(r, order)])

    def _fastest(self, low: float, high: float) -> float:
        return self.position.fastest(low, high)

    def _bending(self, low: float, high: float) -> float:
        return self.position.bending(low, high)

    def _turning(self, low: float, high: float) -> float:
        return self._orientation.turning(low, high)


class PoseWaypoints(Path):
    """A path through poses.

    Parameters
    ----------
    poses : array_like, shape (k, 7)
        At least two rows x, y, z [m] and the unit quaternion w, x, y, z; neighbours must differ.
    interpolation : {"linear", "spline"}
        ``linear``: straight lines, and turns of constant angular velocity (slerp). ``spline``: the cubic spline of the
        positions, and a smooth curve through the rotations; periodic if the last pose is the first.
    parameter : {"uniform", "length"}
        Whether r is shared evenly among the rows, as a controller gives poses at equal times, or in proportion to the
        distance of the positions; then no two neighbours may turn in place.

    Raises
    ------
    InvalidInputError
        Naming rows, if there are fewer than two, a quaternion is not of unit norm, or neighbours coincide.

    Notes
    -----
    q and −q are the same rotation, and neighbours are joined by the shorter turn. Of a half turn both ways are equally
    short; there the signs decide as given.
    """

    kind = "pose_waypoints"

    dimension = POSE

    def __init__(
        self,
        poses: Poses,
        interpolation: Literal["linear", "spline"] = "linear",
        parameter: Literal["uniform", "length"] = "uniform",
    ) -> None:
        rows = finite_array("poses", poses, 2, POSE)
        self.interpolation = choice("interpolation", interpolation, ("linear", "spline"))
        self.parameter = choice("parameter", parameter, ("uniform", "length"))
        if len(rows) < 2:
            raise InvalidInputError("poses", f"has {len(rows)} row", "give at least two", poses)
        q = unit_quaternions("poses", rows[:, SPACE:])
        points = rows[:, :SPACE]
        chords = distance(np.diff(points, axis=0))
        same = (chords == 0) & (apart(q[:-1], q[1:]) <= _SAME)
        if same.any():
            k = int(np.flatnonzero(same)[0])
            raise InvalidInputError("poses", f"repeats row {k} as row {k + 1}", "drop one of the two")
        self.knots = read_only(self._shared(chords))
        smooth = self.interpolation == "spline"
        extent = float(np.ptp(points, axis=0).max())
        closed = len(rows) > 2 and distance(points[-1] - points[0]) <= 1e-12 * extent and apart(q[-1], q[0]) <= 1e-9
        fitted = points.copy()
        if closed:
            fitted[-1] = fitted[0]
        self._position = Pieces(self.knots, fitted if smooth else points, smooth, bool(closed))
        self._orientation = _curve(self.knots, q, self.interpolation, bool(closed))
        self.poses = read_only(np.hstack([points, continuous(q)]))

    def __repr__(self) -> str:
        return f"PoseWaypoints({self.poses.tolist()}, {self.interpolation!r}, {self.parameter!r})"

    def _shared(self, chords: FloatArray) -> FloatArray:
        """Return the r of every row."""
        if self.parameter == "uniform":
            return np.linspace(0.0, 1.0, len(chords) + 1)
        if not chords.all():
            k = int(np.flatnonzero(chords == 0)[0])
            reason = f"turns in place from row {k} to row {k + 1}, where length shares no r"
            raise InvalidInputError("poses", reason, "use parameter: uniform")
        knots = np.concatenate([[0.0], np.cumsum(chords)]) / chords.sum()
        knots[-1] = 1.0
        if not (np.diff(knots) > 0).all():
            k = int(np.flatnonzero(np.diff(knots) <= 0)[0])
            raise InvalidInputError("poses", f"has rows {k} and {k + 1} too close to tell apart", "drop one of them")
        return knots

    @property
    def breaks(self) -> FloatArray:
        """The inner waypoints."""
        return self.knots[1:-1]

    @property
    def waypoints(self) -> FloatArray:
        """Path parameters of all given poses."""
        return self.knots

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return np.hstack([self._position.evaluate(r, order), self._orientation.evaluate(r, order)])

    def _fastest(self, low: float, high: float) -> float:
        return self._position.fastest(low, high)

    def _bending(self, low: float, high: float) -> float:
        return self._position.bending(low, high)

    def _turning(self, low: float, high: float) -> float:
        return self._orientation.turning(low, high)


def _curve(knots: FloatArray, q: FloatArray, interpolation: str, closed: bool) -> Orientation:
    """Return the curve through rotations; smooth ones close smoothly if the first rotation is the last one too."""
    q = continuous(q)
    if interpolation == "linear":
        return GreatCircles(knots, q)
    return RotationSpline(knots, q, closed and bool(apart(q[0], q[-1]) <= 1e-9))


def _rule(follow: FollowRule) -> tuple[str, FloatArray]:
    """Return axis and up of a rule."""
    remedy = "write {axis: x, up: [0, 0, 1]}"
    if not isinstance(follow, Mapping):
        raise InvalidInputError("follow", "is not a mapping", remedy, follow)
    for name in ("axis", "up"):
        if name not in follow:
            raise InvalidInputError(f"follow.{name}", "is missing", remedy)
    for name in follow:
        if name not in ("axis", "up"):
            raise InvalidInputError(f"follow.{name}", "is not a known field", remedy)
    return choice("follow.axis", follow["axis"], UPRIGHT), direction("follow.up", follow["up"])
