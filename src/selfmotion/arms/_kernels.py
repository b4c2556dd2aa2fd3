"""Planar inverse kinematics on plain arrays. Nothing is checked here; :mod:`selfmotion.arms.planar` does."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import wrap


class TwoLink(NamedTuple):
    """Solution of a two-link arm, arrays of one shape each."""

    theta1: FloatArray
    theta2: FloatArray
    cos2: FloatArray
    sin2: FloatArray
    d2: FloatArray
    margin: FloatArray


def two_link(l1: float, l2: float, wx: FloatArray, wy: FloatArray, sign: float) -> TwoLink:
    """Solve a two-link arm for its tip (wx, wy); sign is that of sin θ2, d2 is |w|².

    θ2 = ±2 atan2(√((l1+l2)² − d²), √(d² − (l1−l2)²)), d = |w|, keeps all digits near both folds, where
    the arc cosine of (3) loses half of them. Beyond reach the arm is stretched or folded towards w and the margin,
    the signed distance of d to [|l1−l2|, l1+l2], is negative.
    """
    d2 = wx * wx + wy * wy
    d = np.sqrt(d2)
    total, rest = l1 + l2, abs(l1 - l2)
    short, long = total - d, d - rest
    s = np.sqrt(np.maximum(short * (total + d), 0.0))
    c = np.sqrt(np.maximum(long * (d + rest), 0.0))
    # Zero only where one link is lost in the rounding of the other, so that its angle does not matter.
    scale = 1.0 / np.maximum(s * s + c * c, 1e-300)
    sin2 = (2.0 * sign) * s * c * scale
    cos2 = (c - s) * (c + s) * scale
    along, across = l1 + l2 * cos2, l2 * sin2
    theta1 = np.arctan2(along * wy - across * wx, along * wx + across * wy)
    return TwoLink(theta1, (2.0 * sign) * np.arctan2(s, c), cos2, sin2, d2, np.minimum(short, long))


def _summed(directions: FloatArray, links: FloatArray) -> FloatArray:
    """Return directions (…, k) times links (k,), summed from the left: BLAS sums in an order that goes by the batch."""
    total = np.zeros(directions.shape[:-1])
    for j, length in enumerate(links):
        total = total + directions[..., j] * length
    return total


def planar_ik(links: FloatArray, x: FloatArray, u: FloatArray, sign: float) -> tuple[FloatArray, FloatArray]:
    """Inverse kinematics, (2)–(7) for any number of links.

    links (n,), x (…, 2), u (…, n−2) absolute directions of links 3…n; returns q (…, n), each joint in [−π, π],
    and margin (…), the signed distance of the two-link target to its annulus.
    """
    n = len(links)
    wx = x[..., 0] - _summed(np.cos(u), links[2:])
    wy = x[..., 1] - _summed(np.sin(u), links[2:])
    front = two_link(links[0], links[1], wx, wy, sign)
    q = np.empty((*front.theta1.shape, n))
    q[..., 0], q[..., 1] = front.theta1, front.theta2
    before = front.theta1 + front.theta2
    for j in range(2, n):
        q[..., j] = wrap(u[..., j - 2] - before)
        before = u[..., j - 2]
    return q, front.margin


def planar_rates(
    links: FloatArray, x: FloatArray, dx: FloatArray, u: FloatArray, du: FloatArray, sign: float
) -> FloatArray:
    """Joint rates (…, n) for the rates dx (…, 2) of the tip and du (…, n−2) of the directions; infinite at folds.

    θ2' = −(w·w')/(l1 l2 sin θ2), φ' = (w×w')/|w|², θ1' = φ' − (l2² + l1 l2 cos θ2)/|w|² · θ2'.
    """
    n, (l1, l2), rest = len(links), links[:2], links[2:]
    cosine, sine = np.cos(u), np.sin(u)
    wx, wy = x[..., 0] - cosine @ rest, x[..., 1] - sine @ rest
    vx, vy = dx[..., 0] + (sine * du) @ rest, dx[..., 1] - (cosine * du) @ rest
    front = two_link(l1, l2, wx, wy, sign)
    dq = np.empty((*wx.shape, n))
    with np.errstate(divide="ignore", invalid="ignore"):
        dq[..., 1] = -(wx * vx + wy * vy) / (l1 * l2 * front.sin2)
        dq[..., 0] = (wx * vy - wy * vx - (l2 * l2 + l1 * l2 * front.cos2) * dq[..., 1]) / front.d2
        before = dq[..., 0] + dq[..., 1]
        for j in range(2, n):
            dq[..., j] = du[..., j - 2] - before
            before = du[..., j - 2]
    return dq
