"""Cubic splines of joint angles: knots, collocation points, quadrature, and what is fixed at the ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray

DEGREE = 3
_CLEAR = 0.25  # of a span, that an even knot keeps away from a corner
Spline = Callable[..., FloatArray]
"""A spline: maps r of shape (k,), and an order, to shape (k, n)."""
_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Ends:
    """What is fixed of a motion at r = 0 and r = 1.

    Attributes
    ----------
    start, end : array, shape (n,), or None
        Joint angles there, turns included; None where they are free.
    closure : array, shape (n,), or None
        ``θ(1) − θ(0)`` of a cyclic motion: zero, or whole turns of joints that may gain them. Excludes `end`.
    """

    start: FloatArray | None = None
    end: FloatArray | None = None
    closure: FloatArray | None = None


class SplineSpace:
    """Clamped cubic splines over [0, 1] on given knots.

    Parameters
    ----------
    inner : array, shape (p,)
        Inner knots, ascending; one that is repeated three times lets the derivative jump there.

    Attributes
    ----------
    knots : array, shape (m + 4,)
    m : int
        Number of coefficients.
    collocation : array, shape (m,)
        Greville's abscissae ``(t_{j+1} + t_{j+2} + t_{j+3})/3``: splines are determined by their values there.
    nodes, weights : array, shape (g,)
        Gauss–Legendre quadrature, four nodes per span.
    """

    def __init__(self, inner: FloatArray) -> None:
        self.knots = np.concatenate([np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)])
        self.m = len(self.knots) - DEGREE - 1
        self.collocation = np.clip(np.stack([self.knots[j : j + self.m] for j in (1, 2, 3)]).mean(axis=0), 0.0, 1.0)
        edges = np.unique(self.knots)
        half, middle = 0.5 * np.diff(edges), 0.5 * (edges[:-1] + edges[1:])
        self.nodes = (middle[:, None] + half[:, None] * _GAUSS_NODES).ravel()
        self.weights = (half[:, None] * _GAUSS_WEIGHTS).ravel()

    @classmethod
    def with_spans(cls, spans: int, corners: FloatArray) -> SplineSpace:
        """Return the space on about `spans` equal spans, with triple knots at `corners` inside (0, 1)."""
        return cls._with_corners(np.linspace(0.0, 1.0, spans + 1), corners)

    @classmethod
    def along(cls, r: FloatArray, q: FloatArray, spans: int, corners: FloatArray) -> SplineSpace:
        """Return the space on about `spans` spans that share out the path and the travel of a sampled motion q (k, n).

        So a motion that moves fast somewhere has short spans there.
        """
        travel = np.abs(np.diff(q, axis=0)).sum(axis=1)
        share = np.diff(r) + travel / max(travel.sum(), 1e-300)
        so_far = np.concatenate([[0.0], np.cumsum(share)])
        return cls._with_corners(np.interp(np.linspace(0.0, so_far[-1], spans + 1), so_far, r), corners)

    @classmethod
    def _with_corners(cls, edges: FloatArray, corners: FloatArray) -> SplineSpace:
        """Return the space with single knots at inner `edges` and triple ones at corners, kept clear of the others."""
        plain = edges[1:-1]
        if len(corners):
            width = 0.5 * (edges[2:] - edges[:-2])
            plain = plain[np.abs(plain[:, None] - corners).min(axis=1) > _CLEAR * width]
        return cls(np.sort(np.concatenate([plain, np.repeat(corners, DEGREE)])))

    @property
    def edges(self) -> FloatArray:
        """Ends of the spans, shape (spans + 1,)."""
        return np.unique(self.knots)

    def bisected(self, which: BoolArray) -> SplineSpace:
        """Return the space with a further knot in the middle of each chosen span; it contains this one."""
        edges = self.edges
        middle = 0.5 * (edges[:-1] + edges[1:])[which]
        return SplineSpace(np.sort(np.concatenate([self.knots[DEGREE + 1 : -DEGREE - 1], middle])))

    def design(self, r: FloatArray, order: int = 0) -> FloatArray:
        """Return the basis functions or their derivatives of `order` at r (k,), shape (k, m)."""
        return np.asarray(self._basis(r, order))

    def spline(self, coefficients: FloatArray) -> Spline:
        """Return the spline with coefficients (n, m), a callable of (r, order)."""
        from scipy.interpolate import BSpline

        return BSpline(self.knots, coefficients.T, DEGREE)

    def interpolating(self, values: FloatArray) -> FloatArray:
        """Return the coefficients (n, m) of the spline with values (m, n) at the collocation points."""
        return np.asarray(np.linalg.solve(self.design(self.collocation), values).T, dtype=float)

    @cached_property
    def _basis(self) -> Spline:
        return self.spline(np.eye(self.m))

    @cached_property
    def local(self) -> tuple[IntArray, FloatArray]:
        """Return the first coefficient of each span (e,) and the derivatives of its basis functions (e, 4, 4).

        The second array is [span, quadrature node, basis function]: what element matrices are made of.
        """
        spans = len(self.nodes) // len(_GAUSS_NODES)
        first = np.searchsorted(self.knots, self.nodes[:: len(_GAUSS_NODES)], side="right") - DEGREE - 1
        slopes = self.design(self.nodes, 1).reshape(spans, len(_GAUSS_NODES), self.m)
        columns = first[:, None] + np.arange(DEGREE + 1)
        return first, np.take_along_axis(slopes, columns[:, None, :], axis=2)
