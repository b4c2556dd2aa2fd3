"""Planar inverse kinematics on plain arrays. Nothing is checked here; :mod:`selfmotion.arms.planar` does."""

from __future__ import annotations

import numpy as np

from selfmotion._jit import kernel
from selfmotion._types import FloatArray

TAU = 2 * np.pi


@kernel
def wrap(angle: float) -> float:
    """Return `angle` modulo 2π, inside [−π, π]."""
    return angle - 2 * np.pi * np.rint(angle / (2 * np.pi))


@kernel
def two_link(l1: float, l2: float, wx: float, wy: float, sign: float):  # type: ignore[no-untyped-def]
    """Solve a two-link arm for its tip (wx, wy); return θ1, θ2, cos θ2, sin θ2, |w|², reach margin.

    θ2 = ±2 atan2(√((l1+l2)² − d²), √(d² − (l1−l2)²)), d = |w|, keeps all digits near both folds, where
    the arc cosine of (3) loses half of them. Beyond reach the arm is stretched or folded towards w and the margin,
    the signed distance of d to [|l1−l2|, l1+l2], is negative.
    """
    d = np.hypot(wx, wy)
    total, rest = l1 + l2, abs(l1 - l2)
    margin = min(total - d, d - rest)
    s = np.sqrt(max((total - d) * (total + d), 0.0))
    c = np.sqrt(max((d - rest) * (d + rest), 0.0))
    norm = s * s + c * c
    sin2 = sign * 2.0 * s * c / norm
    cos2 = (c - s) * (c + s) / norm
    along, across = l1 + l2 * cos2, l2 * sin2
    theta1 = np.arctan2(along * wy - across * wx, along * wx + across * wy)
    return theta1, sign * 2.0 * np.arctan2(s, c), cos2, sin2, d * d, margin


@kernel
def planar_ik(  # type: ignore[no-untyped-def]
    links: FloatArray, x: FloatArray, u: FloatArray, sign: float, q: FloatArray, margin: FloatArray
):
    """Inverse kinematics, (2)–(7) for any number of links.

    links (n,), x (k, 2), u (k, n−2) absolute directions of links 3…n; writes q (k, n), each joint in [−π, π],
    and margin (k,), the signed distance of the two-link target to its annulus.
    """
    n = links.shape[0]
    for i in range(x.shape[0]):
        wx, wy = x[i, 0], x[i, 1]
        for j in range(2, n):
            wx -= links[j] * np.cos(u[i, j - 2])
            wy -= links[j] * np.sin(u[i, j - 2])
        theta1, theta2, _, _, _, room = two_link(links[0], links[1], wx, wy, sign)
        q[i, 0], q[i, 1], margin[i] = theta1, theta2, room
        before = theta1 + theta2
        for j in range(2, n):
            q[i, j] = wrap(u[i, j - 2] - before)
            before = u[i, j - 2]


@kernel
def planar_rates(  # type: ignore[no-untyped-def]
    links: FloatArray, x: FloatArray, dx: FloatArray, u: FloatArray, du: FloatArray, sign: float, dq: FloatArray
):
    """Joint rates dq (k, n) for the rates dx (k, 2) of the tip and du (k, n−2) of the directions; infinite at folds.

    θ2' = −(w·w')/(l1 l2 sin θ2), φ' = (w×w')/|w|², θ1' = φ' − (l2² + l1 l2 cos θ2)/|w|² · θ2'.
    """
    n = links.shape[0]
    l1, l2 = links[0], links[1]
    for i in range(x.shape[0]):
        wx, wy, vx, vy = x[i, 0], x[i, 1], dx[i, 0], dx[i, 1]
        for j in range(2, n):
            c, s = links[j] * np.cos(u[i, j - 2]), links[j] * np.sin(u[i, j - 2])
            wx -= c
            wy -= s
            vx += s * du[i, j - 2]
            vy -= c * du[i, j - 2]
        _, _, cos2, sin2, d2, _ = two_link(l1, l2, wx, wy, sign)
        rate2 = -(wx * vx + wy * vy) / (l1 * l2 * sin2)
        rate1 = (wx * vy - wy * vx) / d2 - (l2 * l2 + l1 * l2 * cos2) / d2 * rate2
        dq[i, 0], dq[i, 1] = rate1, rate2
        before = rate1 + rate2
        for j in range(2, n):
            dq[i, j] = du[i, j - 2] - before
            before = du[i, j - 2]


@kernel
def unwrap(q: FloatArray, low: FloatArray, high: FloatArray):  # type: ignore[no-untyped-def]
    """Make q (p, k, n) continuous along k in place; write each joint's extent to low and high (p, n)."""
    for p in range(q.shape[0]):
        for j in range(q.shape[2]):
            last = q[p, 0, j]
            least = most = last
            for k in range(1, q.shape[1]):
                last += wrap(q[p, k, j] - last)
                q[p, k, j] = last
                least, most = min(least, last), max(most, last)
            low[p, j], high[p, j] = least, most
