"""Quadrature on many panels at once: adaptive Gauss–Kronrod with an error estimate, and plain Gauss.

The adaptive rule is the (7, 15) pair of QUADPACK (Piessens et al. 1983). The error reported is the plain sum of
``|K15 − G7|`` over the panels, plus what a kink or jump between the outermost nodes and the panel's ends could hide,
plus a rounding allowance. G7 is far less accurate than the K15 that is returned, so on integrands that the panels
resolve this overestimates the error by orders of magnitude. It is an estimate all the same, not a proof: a spike
between nodes is not seen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray, IntArray

_HALF_NODES = [
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
    0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
    0.586087235467691130294144691693013, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.0,
]  # fmt: skip
_HALF_KRONROD = [
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
    0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
    0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714,
]  # fmt: skip
_HALF_GAUSS = [
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
    0.381830050505118944950369775488975, 0.417959183673469387755102040816327,
]  # fmt: skip

_NODES = np.array([-x for x in _HALF_NODES[:-1]] + _HALF_NODES[::-1])
_KRONROD = np.array(_HALF_KRONROD[:-1] + _HALF_KRONROD[::-1])
_ENDS = np.array([-1.0, 1.0])
# The polynomial through the 15 nodes, taken at both ends: what the integrand should be there if it is smooth.
_TO_ENDS = np.polynomial.legendre.legvander(_ENDS, 14) @ np.linalg.inv(np.polynomial.legendre.legvander(_NODES, 14))
_BLIND = 0.5 * (1.0 - _NODES[-1])  # part of a panel beyond its outermost node
_GAUSS = np.zeros(15)
_GAUSS[1::2] = _HALF_GAUSS[:-1] + _HALF_GAUSS[::-1]

GAUSS = 16
"""Nodes of the Gauss rule."""
_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(GAUSS)

_SHARE = 1e-3  # of the error allowed, for any panel: where integrands are steep, narrow ones do not count by width
_MAX_ROUNDS = 60
_MAX_PANELS = 40_000  # smooth integrands take tens; where this many do not help, rounding is all there is to find


class Integral(NamedTuple):
    """An integral and the estimate of its absolute error.

    Attributes
    ----------
    value : float
    error : float
    """

    value: float
    error: float


def integrate(
    function: Callable[[FloatArray], FloatArray], edges: FloatArray, tolerance: float = 1e-11, most: int = _MAX_PANELS
) -> Integral:
    """Integrate `function` from the first to the last of `edges`.

    Parameters
    ----------
    function : callable
        Maps nodes of shape (k,) to values of shape (k,).
    edges : array, shape (p + 1,)
        Ascending panel ends to start from; the integrand may have kinks or jumps at them.
    tolerance : float
        Panels are bisected until the error estimate is below `tolerance` × the integral of ``|f|``, or
        rounding forbids more.
    most : int
        Panels after which no more are bisected.

    Returns
    -------
    Integral
        ``error`` is infinite if the integrand is not finite at some node.
    """
    left, right = edges[:-1], edges[1:]
    total = error = magnitude = 0.0
    span = float(edges[-1] - edges[0])
    panels = 0
    for round_ in range(_MAX_ROUNDS):
        half = 0.5 * (right - left)
        middle = 0.5 * (left + right)
        nodes = middle[:, None] + half[:, None] * np.concatenate([_NODES, 0.999999999 * _ENDS])
        values, ends = np.split(function(nodes.ravel()).reshape(-1, 17), [15], axis=1)
        fine = values @ _KRONROD * half
        rough = np.abs(fine - values @ _GAUSS * half)
        # A kink or jump beyond the outermost nodes shows only at the ends; there, integrands may be infinite.
        surprise = np.abs(ends - values @ _TO_ENDS.T)
        rough += _BLIND * 2 * half * np.where(np.isfinite(surprise), surprise, 0.0).sum(axis=1)
        weight = np.abs(values) @ _KRONROD * half
        panels += len(left)
        allowed = tolerance * max(magnitude + weight.sum(), 1e-300) * np.maximum(2 * half / span, _SHARE)
        floor = 50 * np.finfo(float).eps * weight
        too_small = half <= 4 * np.finfo(float).eps * np.maximum(np.abs(middle), span * 1e-3)
        split = (rough > np.maximum(allowed, floor)) & ~too_small
        if not np.isfinite(fine).all():
            split |= ~np.isfinite(fine) & ~too_small
        if round_ == _MAX_ROUNDS - 1 or panels > most:
            split[:] = False
        total += float(fine[~split].sum())
        error += float(rough[~split].sum())
        magnitude += float(weight[~split].sum())
        if not split.any():
            break
        left, right = (
            np.concatenate([left[split], middle[split]]),
            np.concatenate([middle[split], right[split]]),
        )
    error += 8 * np.finfo(float).eps * magnitude
    return Integral(total, float(error) if np.isfinite(total + error) else np.inf)


def gauss_panels(function: Callable[[FloatArray], FloatArray], start: FloatArray, stop: FloatArray) -> FloatArray:
    """Integrate over many panels at once by 16-point Gauss–Legendre quadrature.

    Parameters
    ----------
    function : callable
        Maps nodes of shape (k, 16) to values of shape (..., k, 16).
    start, stop : array, shape (k,)
        Ends of the panels.

    Returns
    -------
    array, shape (..., k)
    """
    half = 0.5 * (stop - start)
    nodes = 0.5 * (start + stop)[:, None] + half[:, None] * _GAUSS_NODES
    return np.asarray(half * (function(nodes) @ _GAUSS_WEIGHTS))


class DyadicGauss(NamedTuple):
    """The 16-point Gauss rule on panels, on all of their halves, on all of their quarters, and so on.

    Attributes
    ----------
    nodes : array, shape (16 p (2^(depth + 1) − 1),)
        Those of the p panels, then those of their halves, …, each in ascending order.
    half : array, shape (p,)
        Half the width of each panel.
    depth : int
        How often a panel is halved.
    weights : array, shape (16,)
        On [−1, 1].
    """

    nodes: FloatArray
    half: FloatArray
    depth: int
    weights: FloatArray


def dyadic_gauss(edges: FloatArray, depth: int) -> DyadicGauss:
    """Return the rule on the panels between ascending `edges`, shape (p + 1,), halved up to `depth` times.

    Parameters
    ----------
    edges : array, shape (p + 1,)
    depth : int

    Returns
    -------
    DyadicGauss
    """
    nodes = []
    ends = edges
    for _ in range(depth + 1):
        half = 0.5 * np.diff(ends)
        nodes.append(((ends[:-1] + half)[:, None] + half[:, None] * _GAUSS_NODES).ravel())
        finer = np.empty(2 * len(ends) - 1)
        finer[::2], finer[1::2] = ends, ends[:-1] + half
        ends = finer
    return DyadicGauss(np.concatenate(nodes), 0.5 * np.diff(edges), depth, _GAUSS_WEIGHTS)


def panel_of(edges: FloatArray, t: FloatArray) -> IntArray:
    """Return the index of the panel of ascending `edges` that each t lies in, the right one at an edge.

    Parameters
    ----------
    edges : array, shape (p + 1,)
    t : array, shape (...)

    Returns
    -------
    array of int, shape (...)
        The last panel also beyond the last edge, the first before the first.
    """
    return np.clip(np.searchsorted(edges, t, side="right") - 1, 0, len(edges) - 2)
