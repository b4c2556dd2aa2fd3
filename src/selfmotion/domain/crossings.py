"""Where along a path smooth functions of the task point vanish, none of them missed.

Along each smooth piece of the path every function is represented by its Chebyshev interpolant, pieces being halved
until the coefficients fall to rounding (Trefethen, Approximation Theory and Approximation Practice, 2013, chapters 3
and 18); roots are the eigenvalues of the colleague matrix, then polished on the function itself. Two roots that are d
apart, in half-widths of a piece, are told apart while d² is above the rounding of the coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from selfmotion._types import FloatArray, IntArray

_DEGREE = 16
_HALVINGS = 10
# Zeros of one function nearer to each other than this are one, or a touch.
_SAME = 1e-8
# Coefficients below this part of the largest one are rounding.
_ROUNDING = 1e-13
# A root this far from [−1, 1] is inside it up to rounding, in half-widths of its piece.
_NEARLY = 1e-6
_NEWTON = 4

_EPS = 20 * np.finfo(float).eps

_NODES = np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
_TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, _DEGREE))


class Crossings(NamedTuple):
    """Zeros of functions along a path, ascending.

    Attributes
    ----------
    r : array, shape (k,)
    function : array of int, shape (k,)
        Which function vanishes there.
    """

    r: FloatArray
    function: IntArray


def crossings(values: Callable[[FloatArray], FloatArray], edges: FloatArray) -> Crossings:
    """Return where functions of r change sign.

    Parameters
    ----------
    values : callable
        Maps r of shape (k,) to shape (k, m), of size 1; smooth between neighbouring edges.
    edges : array, shape (p + 1,)
        Ascending; every break of the path is one of them.

    Returns
    -------
    Crossings
        To rounding, which moves a root that lies within d of another by about 1e-16/d.
    """
    left, right = edges[:-1], edges[1:]
    rows: list[tuple[float, float, int]] = []
    for halving in range(_HALVINGS + 1):
        middle, half = 0.5 * (left + right), 0.5 * (right - left)
        nodes = middle[:, None] + half[:, None] * _NODES
        sampled = values(nodes.ravel()).reshape(len(left), _DEGREE + 1, -1)
        coefficients = np.einsum("ij,pjm->pmi", _TO_COEFFICIENTS, sampled)
        size = np.abs(coefficients)
        # What is rounding throughout a piece vanishes all along it: the path stays on the set, and crosses nothing.
        may_vanish = (size[..., 0] <= size[..., 1:].sum(axis=-1)) & (size.max(axis=-1) > _ROUNDING)
        rough = size[..., -2:].max(axis=-1) > np.maximum(_ROUNDING * size.max(axis=-1), _EPS)
        split = (may_vanish & rough).any(axis=1) & (halving < _HALVINGS)
        for piece, function in np.argwhere(may_vanish & ~split[:, None]):
            roots = middle[piece] + half[piece] * _roots(coefficients[piece, function])
            rows += [(min(max(r, left[piece]), right[piece]), half[piece], function) for r in roots.tolist()]
        if not split.any():
            break
        left, right = (
            np.concatenate([left[split], middle[split]]),
            np.concatenate([middle[split], right[split]]),
        )
    if not rows:
        return Crossings(np.empty(0), np.empty(0, int))
    r, width, function = np.array(rows).T
    which = function.astype(int)
    r = _polished(lambda t: values(t)[np.arange(len(t)), which], r, width)
    keep = _changes_sign(values, r, which, edges)
    order = np.argsort(r[keep], kind="stable")
    return Crossings(r[keep][order], which[keep][order])


def _changes_sign(
    values: Callable[[FloatArray], FloatArray], r: FloatArray, which: IntArray, edges: FloatArray
) -> IntArray:
    """Return the indices of those places where a function has different signs half-way to its neighbouring places."""
    order = np.lexsort((r, which))
    apart = (np.diff(r[order]) > _SAME) | (np.diff(which[order]) > 0)
    cluster = np.concatenate([[0], np.cumsum(apart)])
    size = np.abs(values(r[order])[np.arange(len(r)), which[order]])
    best = np.lexsort((size, cluster))[np.searchsorted(cluster, np.arange(cluster[-1] + 1))]
    order = order[best]
    r, which = r[order], which[order]
    first = np.concatenate([[True], np.diff(which) > 0])
    last = np.concatenate([first[1:], [True]])
    before = 0.5 * (r + np.where(first, edges[0], np.roll(r, 1)))
    after = 0.5 * (r + np.where(last, edges[-1], np.roll(r, -1)))
    each = np.arange(len(r))
    return order[np.sign(values(before)[each, which]) != np.sign(values(after)[each, which])]


def _roots(coefficients: FloatArray) -> FloatArray:
    """Return the real roots in [−1, 1], up to rounding."""
    size = np.abs(coefficients)
    last = int(np.flatnonzero(size > 1e-16 * size.max())[-1]) if size.any() else 0
    if last == 0:
        return np.empty(0)
    roots = chebyshev.chebroots(coefficients[: last + 1])
    return np.asarray(roots.real[(np.abs(roots.imag) <= _NEARLY) & (np.abs(roots.real) <= 1 + _NEARLY)])


def _polished(function: Callable[[FloatArray], FloatArray], r: FloatArray, half: FloatArray) -> FloatArray:
    """Return zeros of `function` near `r` by secant steps on the function itself; `r` where there is none near."""
    best = r.copy()
    at = r.copy()
    value = function(at)
    least = np.abs(value)
    step = 1e-7 * half
    for _ in range(_NEWTON):
        slope = (function(np.clip(at + step, 0.0, 1.0)) - function(np.clip(at - step, 0.0, 1.0))) / (2 * step)
        with np.errstate(divide="ignore", invalid="ignore"):
            move = np.nan_to_num(value / slope, nan=0.0, posinf=0.0, neginf=0.0)
        at = np.clip(at - np.clip(move, -1e-2 * half, 1e-2 * half), 0.0, 1.0)
        value = function(at)
        better = np.abs(value) < least
        best, least = np.where(better, at, best), np.where(better, np.abs(value), least)
    return best
