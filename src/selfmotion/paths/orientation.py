"""Orientations q(r), r ∈ [0, 1], as unit quaternions with derivatives: constant, along great circles, or cubic."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.quadrature import panel_of
from selfmotion.rotations import conjugate, exponential, logarithm, product, pure, rotate, turn

# Rates of the cubic are improved until they change by less than this part, or no more.
_SETTLED = 1e-14
_ROUNDS = 60


class Orientation(ABC):
    """A curve of unit quaternions q(r), continuous in sign."""

    @abstractmethod
    def evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return the derivative of `order` 0, 1 or 2 at `r` (k,), shape (k, 4)."""

    @abstractmethod
    def turning(self, low: float, high: float) -> float:
        """Return a bound on ``|ω(r)|`` over [low, high], right but for rounding."""

    @property
    def breaks(self) -> FloatArray:
        """Parameters inside (0, 1) where some derivative jumps."""
        return np.empty(0)


class Constant(Orientation):
    """The same orientation all along.

    Parameters
    ----------
    q : array, shape (4,)
    """

    def __init__(self, q: FloatArray) -> None:
        self.q = q

    def evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return q, or zero."""
        return np.tile(self.q if order == 0 else np.zeros(4), (len(r), 1))

    def turning(self, low: float, high: float) -> float:
        """Return 0."""
        return 0.0


class GreatCircles(Orientation):
    """Orientations joined by turns of constant angular velocity: slerp from each to the next.

    Parameters
    ----------
    knots : array, shape (k,)
        Ascending from 0 to 1.
    q : array, shape (k, 4)
        Continuous in sign.

    Notes
    -----
    On each piece ``q(t) = cos(tΩ) q_i + sin(tΩ) q_i ⊗ n``, Ω half the angle and n the axis of the turn.
    """

    def __init__(self, knots: FloatArray, q: FloatArray) -> None:
        self.knots = knots
        self.q = q
        turns = turn(q[:-1], q[1:])
        angles = np.linalg.norm(turns, axis=1, keepdims=True)
        axes = np.divide(turns, angles, out=np.zeros_like(turns), where=angles > 0)
        self._across = product(q[:-1], pure(axes))
        self._half = 0.5 * angles[:, 0]

    @property
    def breaks(self) -> FloatArray:
        """The inner knots."""
        return self.knots[1:-1]

    def evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return points of the great circles, or derivatives."""
        piece = panel_of(self.knots, r)
        width = self.knots[piece + 1] - self.knots[piece]
        rate = self._half[piece] / width
        angle = rate * (r - self.knots[piece]) + order * np.pi / 2
        return rate[:, None] ** order * (
            np.cos(angle)[:, None] * self.q[piece] + np.sin(angle)[:, None] * self._across[piece]
        )

    def turning(self, low: float, high: float) -> float:
        """Return the angular speed of the fastest turn: exact."""
        pieces = (self.knots[:-1] <= high) & (self.knots[1:] >= low)
        return float((2.0 * self._half / np.diff(self.knots))[pieces].max())


class RotationSpline(Orientation):
    """A smooth curve through orientations: a spherical cubic from each to the next.

    Parameters
    ----------
    knots : array, shape (k,)
        Ascending from 0 to 1, at least two.
    q : array, shape (k, 4)
        Continuous in sign.
    closed : bool
        Whether the last rotation is the first one, and its rates are to be so too.

    Notes
    -----
    On a piece of width h, with t from 0 to 1 (Kim, Kim, Shin 1995),

        ``q(t) = q_i ⊗ exp(ω₁ β₁(t)) ⊗ exp(ω₂ β₂(t)) ⊗ exp(ω₃ β₃(t))``,
        ``β₁ = 1 − (1 − t)³,  β₂ = 3t² − 2t³,  β₃ = t³``,

    ``3 ω₁/h`` and ``3 ω₃/h`` the angular velocities at its ends in the tool's own frame, and ω₂ such that it ends in
    the next orientation. So it is C¹ whatever the velocities are. They are chosen for it to be C²: angular
    accelerations ``6 (ω₂ − ω₁)/h²`` and ``6 (ω₃ − exp(ω₃)⁻¹ ω₂)/h²`` meet at the knots. The equations are solved by
    iterations with the matrix of small turns, which settle to rounding unless neighbouring turns are of the order of a
    half turn. The ends of an open curve have the velocities of the parabola through three orientations.

    As the angular velocity is ``Σ β_j'/h`` times ω_j, each turned by some rotation, its norm is at most
    ``Σ |ω_j| β_j'/h``, a quadratic whose largest value is known. Likewise the norm of its derivative is at most
    ``Σ |ω_j| |β_j''| + Σ_{i<j} |ω_i| |ω_j| β_i' β_j'`` over h², which makes the bound sharp on narrow parts.
    """

    def __init__(self, knots: FloatArray, q: FloatArray, closed: bool = False) -> None:
        self.knots = knots
        self.q = q
        self._width = np.diff(knots)
        self._closed = closed and len(q) > 2
        self._parts = self._controls(self._rates())

    @property
    def breaks(self) -> FloatArray:
        """The inner knots."""
        return self.knots[1:-1]

    def _controls(self, rates: FloatArray) -> FloatArray:
        """Return ω₁, ω₂, ω₃ of every piece, shape (3, k − 1, 3), for angular velocities (k, 3) at the knots."""
        first = rates[:-1] * self._width[:, None] / 3
        third = rates[1:] * self._width[:, None] / 3
        turned = product(conjugate(self.q[:-1]), self.q[1:])
        second = logarithm(product(product(exponential(-first), turned), exponential(-third)))
        return np.stack([first, second, third])

    def _rates(self) -> FloatArray:
        """Return the angular velocities at the knots, shape (k, 3), in the tool's frame."""
        h = self._width[:, None]
        slopes = turn(self.q[:-1], self.q[1:]) / h
        if len(slopes) == 1:
            return np.concatenate([slopes, slopes])
        if self._closed:
            left, right = np.roll(h, 1, axis=0), h
            rates = (right * np.roll(slopes, 1, axis=0) + left * slopes) / (left + right)
            rates = np.concatenate([rates, rates[:1]])
        else:
            inner = (h[1:] * slopes[:-1] + h[:-1] * slopes[1:]) / (h[:-1] + h[1:])
            start = ((2 * h[0] + h[1]) * slopes[0] - h[0] * slopes[1]) / (h[0] + h[1])
            stop = ((2 * h[-1] + h[-2]) * slopes[-1] - h[-1] * slopes[-2]) / (h[-1] + h[-2])
            rates = np.concatenate([start[None], inner, stop[None]])
        solve = self._small_turns()
        best, least = rates, np.inf
        for _ in range(_ROUNDS):
            jumps = self._jumps(rates)
            worst = float(np.abs(jumps).max(initial=0.0))
            if not worst < least:
                break
            best, least = rates, worst
            step = solve(jumps)
            rates = rates + (np.concatenate([step, step[:1]]) if self._closed else np.pad(step, ((1, 1), (0, 0))))
            if np.abs(step).max(initial=0.0) <= _SETTLED * np.abs(rates).max():
                return rates
        return best

    def _jumps(self, rates: FloatArray) -> FloatArray:
        """Return a sixth of the jumps of the angular acceleration at the inner knots, from the first one if closed."""
        first, second, third = self._controls(rates)
        square = self._width[:, None] ** 2
        begin = (second - first) / square
        end = (third - rotate(exponential(-third), second)) / square
        return begin - np.roll(end, 1, axis=0) if self._closed else begin[1:] - end[:-1]

    def _small_turns(self) -> Any:
        """Return the solver of the tridiagonal equations that hold for small turns, cyclic if closed."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        h = self._width
        left, right = (np.roll(h, 1), h) if self._closed else (h[:-1], h[1:])
        n, row = len(left), np.arange(len(left))
        values = [2 * (1 / left + 1 / right) / 3, 1 / (3 * left), 1 / (3 * right)]
        columns = [row, row - 1, row + 1]
        if self._closed:
            columns = [column % n for column in columns]
        entry, at_row, at_column = np.concatenate(values), np.tile(row, 3), np.concatenate(columns)
        inside = (at_column >= 0) & (at_column < n)
        where = (at_row[inside], at_column[inside])
        return splu(csc_array((entry[inside], where), shape=(n, n))).solve

    def evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return the product of the three turns, or its derivatives by the product rule."""
        piece = panel_of(self.knots, r)
        width = self._width[piece]
        blends = _blends((r - self.knots[piece]) / width)
        turns = []
        for omega, blend in zip(self._parts[:, piece], blends.transpose(1, 0, 2), strict=True):
            by, rate, change = blend[:, :, None]
            factor = exponential(omega * by)
            half = 0.5 * omega
            first = product(factor, pure(half))
            square = (half * half).sum(axis=1, keepdims=True)
            turns.append((factor, first * rate, first * change - factor * square * rate**2))
        (a, a1, a2), (b, b1, b2), (c, c1, c2) = turns
        if order == 0:
            total = _triple(a, b, c)
        elif order == 1:
            total = _triple(a1, b, c) + _triple(a, b1, c) + _triple(a, b, c1)
        else:
            total = _triple(a2, b, c) + _triple(a, b2, c) + _triple(a, b, c2)
            total += 2 * (_triple(a1, b1, c) + _triple(a1, b, c1) + _triple(a, b1, c1))
        return product(self.q[piece], total) / width[:, None] ** order

    def turning(self, low: float, high: float) -> float:
        """Return the smaller of two bounds for each piece: by the norms, and from the middle by the acceleration."""
        pieces = np.flatnonzero((self.knots[:-1] <= high) & (self.knots[1:] >= low))
        left, width = self.knots[pieces], self._width[pieces]
        start = (np.clip(low, left, left + width) - left) / width
        stop = (np.clip(high, left, left + width) - left) / width
        sizes = np.linalg.norm(self._parts[:, pieces], axis=2)
        rates = np.stack([3 * (1 - start) ** 2, _largest_hump(start, stop), 3 * stop**2])
        changes = np.stack([6 * (1 - start), np.maximum(np.abs(6 - 12 * start), np.abs(6 - 12 * stop)), 6 * stop])
        # The sum of the norms is a quadratic Bezier curve: so it is on the part, below its three control points.
        by_norms = np.max([_quadratic(sizes, s, e) for s, e in ((start, start), (start, stop), (stop, stop))], axis=0)
        speeds = sizes * rates
        mixed = speeds[0] * speeds[1] + speeds[0] * speeds[2] + speeds[1] * speeds[2]
        acceleration = (sizes * changes).sum(axis=0) + mixed
        middle = self._speed(pieces, 0.5 * (start + stop))
        return float((np.minimum(by_norms, middle + 0.5 * (stop - start) * acceleration) / width).max())

    def _speed(self, piece: IntArray, t: FloatArray) -> FloatArray:
        """Return the angular speeds on pieces (k,) at t (k,) inside them, times their widths."""
        first, second, third = self._parts[:, piece]
        blends = _blends(t)[..., None]
        last = exponential(-third * blends[0, 2])
        inner = first * blends[1, 0]
        inner = rotate(exponential(-second * blends[0, 1]), inner) + second * blends[1, 1]
        return np.asarray(np.linalg.norm(rotate(last, inner) + third * blends[1, 2], axis=1))


def _blends(t: FloatArray) -> FloatArray:
    """Return β₁, β₂, β₃ and their first and second derivatives at t (k,), shape (3 orders, 3, k)."""
    back = 1 - t
    return np.stack(
        [
            np.stack([1 - back**3, t * t * (3 - 2 * t), t**3]),
            np.stack([3 * back**2, 6 * t * back, 3 * t * t]),
            np.stack([-6 * back, 6 - 12 * t, 6 * t]),
        ]
    )


def _quadratic(sizes: FloatArray, s: FloatArray, e: FloatArray) -> FloatArray:
    """Return the polar form of ``Σ sizes_j β_j'`` at (s, e): at (t, t) its value at t."""
    return np.asarray(3 * ((1 - s) * (1 - e) * sizes[0] + (s + e - 2 * s * e) * sizes[1] + s * e * sizes[2]))


def _largest_hump(start: FloatArray, stop: FloatArray) -> FloatArray:
    """Return the maximum of β₂' over [start, stop]."""
    top = np.clip(0.5, start, stop)
    return np.asarray(6 * top * (1 - top))


def _triple(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    return product(product(a, b), c)
