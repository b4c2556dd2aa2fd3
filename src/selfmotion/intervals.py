"""Finite unions of closed intervals, on the line and on the circle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import finite_array, positive
from selfmotion._types import BoolArray, FloatArray
from selfmotion.angles import TAU
from selfmotion.errors import InvalidInputError


class IntervalSet:
    """A finite union of disjoint closed intervals; single points are intervals of length zero.

    Parameters
    ----------
    intervals : array_like, shape (k, 2)
        Pairs ``(lower, upper)``, in any order, overlapping or not. With a period, an interval may start
        anywhere and is read modulo the period; one as long as the period is the whole circle.
    period : float, optional
        Circumference of the circle; without it the set lies on the line.

    Raises
    ------
    InvalidInputError
        If an interval is reversed or not finite.

    Notes
    -----
    Complements are taken up to closure: the complement of ``[a, b]`` contains a and b.
    """

    def __init__(self, intervals: ArrayLike = (), period: float | None = None) -> None:
        pairs = finite_array("intervals", intervals, 2, 2) if np.size(intervals) else np.empty((0, 2))
        if (pairs[:, 0] > pairs[:, 1]).any():
            raise InvalidInputError("intervals", "has lower above upper", "write (lower, upper)", intervals)
        self.period = None if period is None else positive("period", period)
        self._pieces = _merge(pairs if self.period is None else _cut(pairs, self.period))

    @classmethod
    def full(cls, period: float = TAU) -> IntervalSet:
        """Return the whole circle."""
        return cls([(-period / 2, period / 2)], period)

    @property
    def intervals(self) -> FloatArray:
        """The intervals, ascending, shape (k, 2); on the circle ``lower`` lies in [−period/2, period/2)."""
        pieces = self._pieces
        if self.period is None or len(pieces) < 2:
            return pieces.copy()
        half = self.period / 2
        if pieces[0, 0] > -half or pieces[-1, 1] < half:
            return pieces.copy()
        glued = [pieces[-1, 0], pieces[0, 1] + self.period]
        return np.vstack([pieces[1:-1], [glued]])

    @property
    def pieces(self) -> FloatArray:
        """The intervals inside [−period/2, period/2], those across the seam cut in two, shape (k, 2)."""
        return self._pieces.copy()

    @property
    def is_full(self) -> bool:
        """Whether the set is the whole circle."""
        return self.period is not None and self.measure >= self.period * (1 - 1e-15) and len(self._pieces) == 1

    @property
    def measure(self) -> float:
        """Total length."""
        return float((self._pieces[:, 1] - self._pieces[:, 0]).sum())

    def __iter__(self) -> Iterator[tuple[float, float]]:
        return ((float(low), float(high)) for low, high in self.intervals)

    def __len__(self) -> int:
        return len(self.intervals)

    def __bool__(self) -> bool:
        return len(self._pieces) > 0

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, IntervalSet):
            return NotImplemented
        return self.period == other.period and np.array_equal(self._pieces, other._pieces)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        inside = ", ".join(f"[{low:.6g}, {high:.6g}]" for low, high in self)
        return f"IntervalSet({inside or 'empty'}{'' if self.period is None else f'; period {self.period:.6g}'})"

    def contains(self, values: ArrayLike, tolerance: float = 0.0) -> BoolArray:
        """Return for each of `values` whether the set reaches within `tolerance` of it."""
        return np.asarray(self.distance(values) <= tolerance)

    def __contains__(self, value: float) -> bool:
        return bool(self.contains(value))

    def distance(self, values: ArrayLike) -> FloatArray:
        """Return the distance from each of `values` to the set, infinite if the set is empty."""
        points = np.asarray(values, dtype=float)
        pieces = self._pieces
        if not len(pieces):
            return np.full(points.shape, np.inf)
        if self.period is not None:
            points = points - self.period * np.round(points / self.period)
            pieces = np.vstack([pieces[-1:] - self.period, pieces, pieces[:1] + self.period])
        gaps = np.maximum(pieces[:, 0] - points[..., None], points[..., None] - pieces[:, 1])
        return np.asarray(np.maximum(gaps, 0.0).min(axis=-1))

    def distance_to_ends(self, values: ArrayLike) -> FloatArray:
        """Return the distance from each of `values` to the nearest interval end, infinite without ends."""
        points = np.asarray(values, dtype=float)
        ends = np.empty(0) if self.is_full else self.intervals.ravel()
        if not len(ends):
            return np.full(points.shape, np.inf)
        gaps = points[..., None] - ends
        if self.period is not None:
            gaps = gaps - self.period * np.round(gaps / self.period)
        return np.asarray(np.abs(gaps).min(axis=-1))

    def complement(self, low: float | None = None, high: float | None = None) -> IntervalSet:
        """Return the closure of what is missing, on the circle or inside [`low`, `high`] on the line."""
        if self.period is not None:
            low, high = -self.period / 2, self.period / 2
        elif low is None or high is None:
            raise InvalidInputError("low, high", "are needed on the line", "say inside which interval")
        edges = np.concatenate([[low], self._pieces.clip(low, high).ravel(), [high]]).reshape(-1, 2)
        return IntervalSet(edges[edges[:, 0] < edges[:, 1]], self.period)

    def union(self, other: IntervalSet) -> IntervalSet:
        """Return the points of either set."""
        self._same_space(other)
        return IntervalSet(np.vstack([self._pieces, other._pieces]), self.period)

    def intersection(self, other: IntervalSet) -> IntervalSet:
        """Return the points of both sets."""
        self._same_space(other)
        low = np.maximum(self._pieces[:, None, 0], other._pieces[None, :, 0]).ravel()
        high = np.minimum(self._pieces[:, None, 1], other._pieces[None, :, 1]).ravel()
        keep = low <= high
        return IntervalSet(np.column_stack([low[keep], high[keep]]), self.period)

    __or__ = union
    __and__ = intersection

    def _same_space(self, other: Any) -> None:
        if self.period != other.period:
            raise InvalidInputError("period", "differs between the two sets", "use one circle", other.period)


def _merge(pairs: FloatArray) -> FloatArray:
    """Return the union of `pairs` as sorted disjoint intervals."""
    if not len(pairs):
        return pairs.reshape(0, 2)
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    reach = np.maximum.accumulate(pairs[:, 1])
    first = np.concatenate([[True], pairs[1:, 0] > reach[:-1]])
    last = np.concatenate([np.flatnonzero(first)[1:] - 1, [len(pairs) - 1]])
    return np.column_stack([pairs[first, 0], reach[last]])


def _cut(pairs: FloatArray, period: float) -> FloatArray:
    """Return `pairs` moved into [−period/2, period/2], those across the seam cut in two."""
    half = period / 2
    pieces: list[tuple[float, float]] = []
    for low, high in pairs:
        if high - low >= period:
            return np.array([[-half, half]])
        start = low - period * np.floor((low + half) / period)
        start = min(max(start, -half), half)
        end = start + (high - low)
        if end < half:
            pieces.append((start, end))
        else:
            pieces += [(start, half), (-half, end - period)]
    return np.array(pieces).reshape(-1, 2)
