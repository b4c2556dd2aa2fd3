"""Between the collocation points: how far a motion dips below the arm's constraints on postures, span by span."""

from __future__ import annotations

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.refinement.closing import ClosedSpline
from selfmotion.refinement.collocation import Collocation

_LOOKS = 9  # per span, ends included
_ZOOMS = 3  # each about the least of the looks before, to a quarter of their distance
_NEAR = 1e-2  # margins, of their scale, above which a span is not looked at again


def dips(collocation: Collocation, motion: ClosedSpline) -> FloatArray:
    """Return by how much margins fall below zero on each span of a motion's spline, at most.

    Parameters
    ----------
    collocation : Collocation
    motion : ClosedSpline
        On its spline space.

    Returns
    -------
    array, shape (spans, m)
        In the scales of the constraints; zero where they hold.
    """
    edges = collocation.space.edges
    r = np.linspace(edges[:-1], edges[1:], _LOOKS, axis=1)
    seen = _margins(collocation, motion, r)
    least = seen.min(axis=1)
    rise = np.abs(np.diff(seen, axis=1)).max(axis=1)
    span, margin = np.nonzero(least - rise < np.minimum(_NEAR, rise))
    if len(span):
        rows, near, found = np.arange(len(span)), r[span], seen[span, :, margin]
        for _ in range(_ZOOMS):
            k = found.argmin(axis=1)
            low, high = near[rows, np.maximum(k - 1, 0)], near[rows, np.minimum(k + 1, _LOOKS - 1)]
            near = np.linspace(low, high, _LOOKS, axis=1)
            found = _margins(collocation, motion, near)[rows, :, margin]
            least[span, margin] = np.minimum(least[span, margin], found.min(axis=1))
    return np.maximum(-least, 0.0)


def spread(collocation: Collocation, by_span: FloatArray) -> FloatArray:
    """Return what is known by span (spans, m) at the collocation points: the most of the spans that are near a point.

    Those are the points on a span and the next ones on both sides.
    """
    edges, points = collocation.space.edges, collocation.points
    first = np.maximum(np.searchsorted(points, edges[:-1], side="right") - 1, 0)
    last = np.searchsorted(points, edges[1:], side="left")
    found = np.zeros((len(points), by_span.shape[1]))
    for span in np.flatnonzero(by_span.any(axis=1)):
        near = slice(first[span], last[span] + 1)
        found[near] = np.maximum(found[near], by_span[span])
    return found


def _margins(collocation: Collocation, motion: ClosedSpline, r: FloatArray) -> FloatArray:
    """Return the margins at r (a, b), shape (a, b, m)."""
    found = collocation.margins(motion(r.ravel()))
    return found.reshape(*r.shape, found.shape[1])
