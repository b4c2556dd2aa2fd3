"""Paths made from paths: moved, reversed, cut, joined end to end, seen from a moving point, run at constant speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from selfmotion._checks import finite_array, number, positive, read_only
from selfmotion._types import FloatArray, Point
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import PLANE, POSE, SPACE, Path, distance, same_dimension, worst_of_parts
from selfmotion.quadrature import gauss_panels, panel_of
from selfmotion.rotations import apart

# The length is known better than this part of it.
_LENGTH_ERROR = 1e-9


class Transformed(Path):
    """A plane path after scaling, rotation about the origin and translation, in that order.

    Parameters
    ----------
    path : Path
    scale : float
        Positive factor.
    rotation : float
        Angle [rad], counter-clockwise.
    translation : array_like, shape (2,)

    Raises
    ------
    InvalidInputError
        If the scale is not positive, or the path is not one of the plane: `placed` moves paths in space.
    """

    kind = "transformed"

    def __init__(self, path: Path, scale: float = 1.0, rotation: float = 0.0, translation: Point = (0.0, 0.0)) -> None:
        self.path = path
        if path.dimension != PLANE:
            raise InvalidInputError("path", "is not one of the plane", "move paths in space by kind placed")
        self.highest_order = path.highest_order
        self.factor = positive("scale", scale)
        self.rotation = number("rotation", rotation, -1e3, 1e3)
        self.translation = read_only(finite_array("translation", translation, 1, 2))
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        self._matrix = self.factor * np.array([[c, s], [-s, c]])

    @property
    def breaks(self) -> FloatArray:
        """Those of the original path."""
        return self.path.breaks

    @property
    def waypoints(self) -> FloatArray:
        """Those of the original path."""
        return self.path.waypoints

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        moved = self.path(r, order) @ self._matrix
        return moved + self.translation if order == 0 else moved

    def _fastest(self, low: float, high: float) -> float:
        return self.factor * self.path.fastest(low, high)

    def _bending(self, low: float, high: float) -> float:
        return self.factor * self.path.bending(low, high)


class Reversed(Path):
    """A path run backwards.

    Parameters
    ----------
    path : Path
    """

    kind = "reversed"

    def __init__(self, path: Path) -> None:
        self.path = path
        self.dimension, self.highest_order = path.dimension, path.highest_order

    @property
    def breaks(self) -> FloatArray:
        """Those of the original path, seen from its end."""
        return 1.0 - self.path.breaks[::-1]

    @property
    def waypoints(self) -> FloatArray:
        """Those of the original path, seen from its end."""
        return 1.0 - self.path.waypoints[::-1]

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return (-1) ** order * self.path(1.0 - r, order)

    def _fastest(self, low: float, high: float) -> float:
        return self.path.fastest(1.0 - high, 1.0 - low)

    def _bending(self, low: float, high: float) -> float:
        return self.path.bending(1.0 - high, 1.0 - low)

    def _turning(self, low: float, high: float) -> float:
        return self.path.turning(1.0 - high, 1.0 - low)


class Section(Path):
    """A part of a path.

    Parameters
    ----------
    path : Path
    r_range : array_like, shape (2,)
        First and last parameter of the part, ascending, inside [0, 1].

    Raises
    ------
    InvalidInputError
        If the range is empty or leaves [0, 1].

    Notes
    -----
    ``x(r) = path(a + (b − a) r)``. No problem file names it: the tool is to follow the whole of its path.
    """

    kind = "section"

    def __init__(self, path: Path, r_range: Point) -> None:
        self.path = path
        self.dimension, self.highest_order = path.dimension, path.highest_order
        self.r_range = read_only(finite_array("r_range", r_range, 1, 2))
        first, last = (float(end) for end in self.r_range)
        if not 0.0 <= first < last <= 1.0:
            raise InvalidInputError("r_range", "is no part of [0, 1]", "give two ascending numbers inside", r_range)
        self._first, self._width = first, last - first

    def _inner(self, r: FloatArray) -> FloatArray:
        return np.minimum(self._first + self._width * r, self.r_range[1])

    def _mapped(self, r: FloatArray) -> FloatArray:
        return (r[(r >= self._first) & (r <= self.r_range[1])] - self._first) / self._width

    @property
    def breaks(self) -> FloatArray:
        """Those of the whole path that are inside."""
        inside = self._mapped(self.path.breaks)
        return inside[(inside > 0.0) & (inside < 1.0)]

    @property
    def waypoints(self) -> FloatArray:
        """Those of the whole path that are in the part."""
        return self._mapped(self.path.waypoints)

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return self._width**order * self.path(self._inner(r), order)

    def _fastest(self, low: float, high: float) -> float:
        first, last = self._inner(np.array([low, high])).tolist()
        return self._width * self.path.fastest(first, last)

    def _bending(self, low: float, high: float) -> float:
        first, last = self._inner(np.array([low, high])).tolist()
        return self._width**2 * self.path.bending(first, last)

    def _turning(self, low: float, high: float) -> float:
        first, last = self._inner(np.array([low, high])).tolist()
        return self._width * self.path.turning(first, last)


class Concatenation(Path):
    """Paths run one after the other, each on a share of r proportional to its length.

    Parameters
    ----------
    parts : sequence of Path
        At least one; each must start where the one before it ends.

    Raises
    ------
    InvalidInputError
        If there is no part, one has no length, or a gap between two of them exceeds 1e-9 of their extent, or of poses
        1e-9 rad.
    """

    kind = "concatenation"

    def __init__(self, parts: Sequence[Path]) -> None:
        self.parts = tuple(parts)
        if not self.parts:
            raise InvalidInputError("parts", "is empty", "give at least one path")
        for k, (before, after) in enumerate(zip(self.parts, self.parts[1:], strict=False)):
            same_dimension("parts", before, after)
            gap = float(distance(after(0.0) - before(1.0)))
            if gap > 1e-9 * max(before.extent, after.extent):
                raise InvalidInputError(
                    "parts",
                    f"part {k + 1} starts {gap:.6g} away from the end of part {k}",
                    "close the gap, or join them with a line",
                )
        self.dimension = self.parts[0].dimension
        self.highest_order = min(part.highest_order for part in self.parts)
        self._signs = self._matched() if self.dimension == POSE else np.ones(len(self.parts))
        ends = np.cumsum([part.length for part in self.parts])
        self.ends = read_only(np.concatenate([[0.0], ends / ends[-1]]))
        lost = np.flatnonzero(np.diff(self.ends) <= 0.0)
        if len(lost):
            reason = f"part {lost[0]} is so short beside the others that no r is left for it"
            raise InvalidInputError("parts", reason, "leave it out")

    def _matched(self) -> FloatArray:
        """Return the signs of the parts' quaternions with which each goes on from the one before it."""
        signs = [1.0]
        for k, (before, after) in enumerate(zip(self.parts, self.parts[1:], strict=False)):
            end, start = before(1.0)[SPACE:], after(0.0)[SPACE:]
            if (gap := float(apart(end, start))) > 1e-9:
                reason = f"part {k + 1} starts turned by {gap:.6g} rad from the end of part {k}"
                raise InvalidInputError("parts", reason, "turn in between, along a path of its own")
            signs.append(signs[-1] * float(np.sign(end @ start)))
        for k, part in enumerate(self.parts):
            if not part.length > 0:
                reason = f"part {k} turns in place and has no length to share r by"
                raise InvalidInputError("parts", reason, "use pose_waypoints for it and its neighbours")
        return np.array(signs)

    def _mapped(self, name: str) -> FloatArray:
        inner = [
            low + (high - low) * getattr(part, name)
            for part, low, high in zip(self.parts, self.ends[:-1], self.ends[1:], strict=True)
        ]
        return np.concatenate(inner)

    @property
    def breaks(self) -> FloatArray:
        """The joints between parts, and the parts' own breaks."""
        return np.unique(np.concatenate([self.ends[1:-1], self._mapped("breaks")]))

    @property
    def waypoints(self) -> FloatArray:
        """Those of the parts."""
        return np.unique(self._mapped("waypoints"))

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        which = panel_of(self.ends, r)
        result = np.empty((len(r), self.dimension))
        for k, part in enumerate(self.parts):
            mine = which == k
            share = self.ends[k + 1] - self.ends[k]
            local = (r[mine] - self.ends[k]) / share
            result[mine] = part(local, order) / share**order
            result[mine, SPACE:] *= self._signs[k]
        return result

    def _fastest(self, low: float, high: float) -> float:
        return max(part.fastest(*inner) / share for part, inner, share in self._cut(low, high))

    def _bending(self, low: float, high: float) -> float:
        return max(part.bending(*inner) / share**2 for part, inner, share in self._cut(low, high))

    def _turning(self, low: float, high: float) -> float:
        return max(part.turning(*inner) / share for part, inner, share in self._cut(low, high))

    def _cut(self, low: float, high: float) -> Iterator[tuple[Path, tuple[float, float], float]]:
        """Yield the parts that [low, high] touches, which range of theirs it covers, and their shares of r."""
        for part, first, last in zip(self.parts, self.ends[:-1], self.ends[1:], strict=True):
            if first <= high and low <= last:
                inner = np.clip((np.array([low, high]) - first) / (last - first), 0.0, 1.0)
                yield part, (float(inner[0]), float(inner[1])), float(last - first)


class Relative(Path):
    """A path as seen from a point that runs along another one at the same r, its axes parallel to the world's.

    Parameters
    ----------
    path, origin : Path
        Both of the plane or both of space.

    Raises
    ------
    InvalidInputError
        If they are not.

    Notes
    -----
    ``x(r) − o(r)``, and so are its derivatives. No problem file names it: the tool's path is one of the world.
    """

    kind = "relative"

    def __init__(self, path: Path, origin: Path) -> None:
        if path.dimension == POSE:
            raise InvalidInputError("path", "is one of poses, of which there is no difference", "give its positions")
        same_dimension("origin", path, origin)
        self.path = path
        self.origin = origin
        self.dimension, self.highest_order = path.dimension, min(path.highest_order, origin.highest_order)

    @property
    def breaks(self) -> FloatArray:
        """Those of either path."""
        return np.union1d(self.path.breaks, self.origin.breaks)

    @property
    def waypoints(self) -> FloatArray:
        """Those of either path."""
        return np.union1d(self.path.waypoints, self.origin.waypoints)

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return self.path(r, order) - self.origin(r, order)

    def _fastest(self, low: float, high: float) -> float:
        return self.path.fastest(low, high) + self.origin.fastest(low, high)

    def _bending(self, low: float, high: float) -> float:
        return self.path.bending(low, high) + self.origin.bending(low, high)


class ArcLength(Path):
    """A path run at constant speed: r is proportional to the arc length.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InvalidInputError
        If the path has no length, or is one of poses whose position stops.

    Notes
    -----
    With s the arc length and L the total, ``x_r = L x'/|x'|`` and ``x_rr = L² (x'' − T (T·x''))/|x'|²``,
    T the unit tangent. Where the original path stops (``|x'| = 0``, a cusp or a repeated control point) the
    tangent is taken from a neighbouring point. The inverse of s is found by Newton's method, kept in
    its bracket by bisection, to about 1e-14. Arc length of arc length is arc length. Of a path of poses it is the
    position's arc length, and the orientation follows: with t(r) the original parameter, ``t_r = L/|x'|``,
    ``q_r = q' t_r`` and ``q_rr = q'' t_r² + q' t_rr``.
    """

    kind = "arc_length"

    def __init__(self, path: Path) -> None:
        self.path: Path = path.path if isinstance(path, ArcLength) else path
        self.dimension = path.dimension
        edges = self._panels()
        steps = self._lengths(edges[:-1], edges[1:])
        self._edges = edges
        self._table = np.concatenate([[0.0], np.cumsum(steps)])
        self._total = float(self._table[-1])
        if not self._total > 0:
            raise InvalidInputError("path", "has no length", "give a path that moves")
        if self.dimension == POSE:
            t = self.path.grid(256)
            still = self._speed(t) <= 1e-9 * self._total
            if still.any():
                reason = f"stops at r = {t[still][0]:.6g}: at constant speed its orientation would jump there"
                raise InvalidInputError("path", reason, "keep its own parameter")

    def _speed(self, t: FloatArray) -> FloatArray:
        velocity = self.path(t.ravel(), 1)
        return distance(velocity).reshape(t.shape)

    def _lengths(self, start: FloatArray, stop: FloatArray) -> FloatArray:
        return gauss_panels(self._speed, start, stop)

    def _panels(self) -> FloatArray:
        """Return panel ends between which 16 Gauss nodes give the length to rounding."""
        edges = self.path.grid(16)
        for _ in range(40):
            left, right = edges[:-1], edges[1:]
            middle = 0.5 * (left + right)
            whole = self._lengths(left, right)
            halves = self._lengths(left, middle) + self._lengths(middle, right)
            rough = np.abs(whole - halves) > 1e-14 * halves.sum()
            if not rough.any() or len(edges) > 100_000:
                break
            edges = np.sort(np.concatenate([edges, middle[rough]]))
        return edges

    def _inverse(self, r: FloatArray) -> FloatArray:
        """Return the parameter of the original path at the fraction `r` of its length."""
        target = r * self._total
        panel = panel_of(self._table, target)
        low, high = self._edges[panel].copy(), self._edges[panel + 1].copy()
        base, goal = low.copy(), target - self._table[panel]
        width = np.maximum(self._table[panel + 1] - self._table[panel], 1e-300)
        t = low + (high - low) * np.clip(goal / width, 0.0, 1.0)
        for _ in range(60):
            miss = self._lengths(base, t) - goal
            low, high = np.where(miss > 0, low, t), np.where(miss > 0, t, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = t - miss / self._speed(t)
            inside = (newton >= low) & (newton <= high)
            step = np.where(inside, newton, 0.5 * (low + high))
            moved = np.abs(step - t).max(initial=0.0)
            t = step
            if moved <= 1e-14:
                break
        return np.where(r == 1.0, 1.0, t)

    @property
    def breaks(self) -> FloatArray:
        """Those of the original path, at their fractions of the length."""
        return self._fraction(self.path.breaks)

    @property
    def waypoints(self) -> FloatArray:
        """Those of the original path, at their fractions of the length."""
        return self._fraction(self.path.waypoints)

    def _fraction(self, t: FloatArray) -> FloatArray:
        panel = panel_of(self._edges, t)
        return (self._table[panel] + self._lengths(self._edges[panel], t)) / self._total

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        t = self._inverse(r)
        if order == 0:
            return self.path(t, 0)
        first = self.path(t, 1)
        speed = distance(first)
        stopped = speed <= 1e-9 * self._total
        if stopped.any():
            t = np.where(stopped, np.where(t < 0.5, t + 1e-6, t - 1e-6), t)
            first = self.path(t, 1)
            speed = distance(first)
        if self.dimension == POSE:
            return self._pose_rates(t, order, first, speed[:, None])
        tangent = first / speed[:, None]
        if order == 1:
            return self._total * tangent
        second = self.path(t, 2)
        normal = second - tangent * (tangent * second).sum(axis=1, keepdims=True)
        return self._total**2 * normal / speed[:, None] ** 2

    def _fastest(self, low: float, high: float) -> float:
        return self._total * (1.0 + _LENGTH_ERROR)

    def _pose_rates(self, t: FloatArray, order: int, first: FloatArray, speed: FloatArray) -> FloatArray:
        rate = self._total / speed
        if order == 1:
            return first * rate
        second = self.path(t, 2)
        along = (first[:, :SPACE] * second[:, :SPACE]).sum(axis=1, keepdims=True)
        return second * rate**2 - first * (rate**2 * along / speed**2)

    def _turning(self, low: float, high: float) -> float:
        first, last = self._inverse(np.array([low, high]))
        first, last = max(float(first) - 1e-12, 0.0), min(float(last) + 1e-12, 1.0)

        def bound(a: float, b: float) -> float:
            speed = float(self._speed(np.array([0.5 * (a + b)]))[0])
            slowest = speed - self.path.bending(a, b) * 0.5 * (b - a)
            return self.path.turning(a, b) / slowest if slowest > 0.9 * speed else np.inf

        return self._total * (1.0 + _LENGTH_ERROR) * worst_of_parts(self.path, first, last, bound, "angular speed")
