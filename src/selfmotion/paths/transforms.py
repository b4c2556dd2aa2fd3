"""Paths made from paths: moved, reversed, cut, joined end to end, seen from a moving point, run at constant speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from selfmotion._checks import finite_array, number, positive, read_only
from selfmotion._types import FloatArray, Point
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path
from selfmotion.quadrature import gauss_panels, panel_of

# The length is known better than this part of it.
_LENGTH_ERROR = 1e-9


class Transformed(Path):
    """A path after scaling, rotation about the origin and translation, in that order.

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
        If the scale is not positive.
    """

    kind = "transformed"

    def __init__(self, path: Path, scale: float = 1.0, rotation: float = 0.0, translation: Point = (0.0, 0.0)) -> None:
        self.path = path
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


class Reversed(Path):
    """A path run backwards.

    Parameters
    ----------
    path : Path
    """

    kind = "reversed"

    def __init__(self, path: Path) -> None:
        self.path = path

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
        ends = self._inner(np.array([low, high]))
        return self._width * self.path.fastest(float(ends[0]), float(ends[1]))


class Concatenation(Path):
    """Paths run one after the other, each on a share of r proportional to its length.

    Parameters
    ----------
    parts : sequence of Path
        At least one; each must start where the one before it ends.

    Raises
    ------
    InvalidInputError
        If there is no part, or a gap between two of them exceeds 1e-9 of their extent.
    """

    kind = "concatenation"

    def __init__(self, parts: Sequence[Path]) -> None:
        self.parts = tuple(parts)
        if not self.parts:
            raise InvalidInputError("parts", "is empty", "give at least one path")
        for k, (before, after) in enumerate(zip(self.parts, self.parts[1:], strict=False)):
            gap = float(np.hypot(*(after(0.0) - before(1.0))))
            if gap > 1e-9 * max(before.extent, after.extent):
                raise InvalidInputError(
                    "parts",
                    f"part {k + 1} starts {gap:.6g} away from the end of part {k}",
                    "close the gap, or join them with a line",
                )
        ends = np.cumsum([part.length for part in self.parts])
        self.ends = read_only(np.concatenate([[0.0], ends / ends[-1]]))

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
        result = np.empty((len(r), 2))
        for k, part in enumerate(self.parts):
            mine = which == k
            share = self.ends[k + 1] - self.ends[k]
            local = (r[mine] - self.ends[k]) / share
            result[mine] = part(local, order) / share**order
        return result

    def _fastest(self, low: float, high: float) -> float:
        speeds = []
        for part, first, last in zip(self.parts, self.ends[:-1], self.ends[1:], strict=True):
            if first <= high and low <= last:
                inner = np.clip((np.array([low, high]) - first) / (last - first), 0.0, 1.0)
                speeds.append(part.fastest(float(inner[0]), float(inner[1])) / float(last - first))
        return max(speeds)


class Relative(Path):
    """A path as seen from a point that runs along another one at the same r, its axes parallel to the world's.

    Parameters
    ----------
    path, origin : Path

    Notes
    -----
    ``x(r) − o(r)``, and so are its derivatives. No problem file names it: the tool's path is one of the world.
    """

    kind = "relative"

    def __init__(self, path: Path, origin: Path) -> None:
        self.path = path
        self.origin = origin

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


class ArcLength(Path):
    """A path run at constant speed: r is proportional to the arc length.

    Parameters
    ----------
    path : Path

    Notes
    -----
    With s the arc length and L the total, ``x_r = L x'/|x'|`` and ``x_rr = L² (x'' − T (T·x''))/|x'|²``,
    T the unit tangent. Where the original path stops (``|x'| = 0``, a cusp or a repeated control point) the
    tangent is taken from a neighbouring point. The inverse of s is found by Newton's method, kept in
    its bracket by bisection, to about 1e-14. Arc length of arc length is arc length.
    """

    kind = "arc_length"

    def __init__(self, path: Path) -> None:
        self.path: Path = path.path if isinstance(path, ArcLength) else path
        edges = self._panels()
        steps = self._lengths(edges[:-1], edges[1:])
        self._edges = edges
        self._table = np.concatenate([[0.0], np.cumsum(steps)])
        self._total = float(self._table[-1])
        if not self._total > 0:
            raise InvalidInputError("path", "has no length", "give a path that moves")

    def _speed(self, t: FloatArray) -> FloatArray:
        velocity = self.path(t.ravel(), 1)
        return np.asarray(np.hypot(velocity[:, 0], velocity[:, 1]).reshape(t.shape))

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
        speed = np.hypot(first[:, 0], first[:, 1])
        stopped = speed <= 1e-9 * self._total
        if stopped.any():
            t = np.where(stopped, np.where(t < 0.5, t + 1e-6, t - 1e-6), t)
            first = self.path(t, 1)
            speed = np.hypot(first[:, 0], first[:, 1])
        tangent = first / speed[:, None]
        if order == 1:
            return self._total * tangent
        second = self.path(t, 2)
        normal = second - tangent * (tangent * second).sum(axis=1, keepdims=True)
        return self._total**2 * normal / speed[:, None] ** 2

    def _fastest(self, low: float, high: float) -> float:
        return self._total * (1.0 + _LENGTH_ERROR)
