"""Kernels of serial chains: frames, Jacobians and their rates, for one posture and for many.

A chain is ``T(q) = F_0 Rz(q_1) F_1 … Rz(q_n) F_n``: ``turns`` (n + 1, 3, 3) and ``shifts`` (n + 1, 3) are the fixed F.
Joints before ``first`` slide along z instead: the base does, so that no derivatives but the first know of them.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray


@kernel
def frames(
    turns: FloatArray, shifts: FloatArray, first: int, q: FloatArray, axes: FloatArray, centers: FloatArray,
    rotation: FloatArray, position: FloatArray,
) -> None:  # fmt: skip
    """Fill in the joints' axes and points on them (n, 3), and the tool's rotation (3, 3) and position (3,)."""
    n = len(q)
    r00, r01, r02 = turns[0, 0, 0], turns[0, 0, 1], turns[0, 0, 2]
    r10, r11, r12 = turns[0, 1, 0], turns[0, 1, 1], turns[0, 1, 2]
    r20, r21, r22 = turns[0, 2, 0], turns[0, 2, 1], turns[0, 2, 2]
    x, y, z = shifts[0, 0], shifts[0, 1], shifts[0, 2]
    for j in range(n):
        axes[j, 0], axes[j, 1], axes[j, 2] = r02, r12, r22
        centers[j, 0], centers[j, 1], centers[j, 2] = x, y, z
        if j < first:
            x, y, z = x + r02 * q[j], y + r12 * q[j], z + r22 * q[j]
        else:
            c, s = np.cos(q[j]), np.sin(q[j])
            r00, r01 = c * r00 + s * r01, c * r01 - s * r00
            r10, r11 = c * r10 + s * r11, c * r11 - s * r10
            r20, r21 = c * r20 + s * r21, c * r21 - s * r20
        d, f = shifts[j + 1], turns[j + 1]
        x += r00 * d[0] + r01 * d[1] + r02 * d[2]
        y += r10 * d[0] + r11 * d[1] + r12 * d[2]
        z += r20 * d[0] + r21 * d[1] + r22 * d[2]
        r00, r01, r02 = (
            r00 * f[0, 0] + r01 * f[1, 0] + r02 * f[2, 0],
            r00 * f[0, 1] + r01 * f[1, 1] + r02 * f[2, 1],
            r00 * f[0, 2] + r01 * f[1, 2] + r02 * f[2, 2],
        )
        r10, r11, r12 = (
            r10 * f[0, 0] + r11 * f[1, 0] + r12 * f[2, 0],
            r10 * f[0, 1] + r11 * f[1, 1] + r12 * f[2, 1],
            r10 * f[0, 2] + r11 * f[1, 2] + r12 * f[2, 2],
        )
        r20, r21, r22 = (
            r20 * f[0, 0] + r21 * f[1, 0] + r22 * f[2, 0],
            r20 * f[0, 1] + r21 * f[1, 1] + r22 * f[2, 1],
            r20 * f[0, 2] + r21 * f[1, 2] + r22 * f[2, 2],
        )
    rotation[0, 0], rotation[0, 1], rotation[0, 2] = r00, r01, r02
    rotation[1, 0], rotation[1, 1], rotation[1, 2] = r10, r11, r12
    rotation[2, 0], rotation[2, 1], rotation[2, 2] = r20, r21, r22
    position[0], position[1], position[2] = x, y, z


@kernel
def forward_all(
    turns: FloatArray, shifts: FloatArray, first: int, q: FloatArray, rotations: FloatArray, positions: FloatArray
) -> None:
    """Fill in the tool's rotations (k, 3, 3) and positions (k, 3) for postures (k, n)."""
    axes, centers = np.empty((q.shape[1], 3)), np.empty((q.shape[1], 3))
    for k in range(len(q)):
        frames(turns, shifts, first, q[k], axes, centers, rotations[k], positions[k])


@kernel
def jacobian_all(turns: FloatArray, shifts: FloatArray, first: int, q: FloatArray, jacobian: FloatArray) -> None:
    """Fill in the Jacobians (k, 6, n): the tool's velocity, then its angular velocity, in the base frame."""
    n = q.shape[1]
    axes, centers, rotation, p = np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3)
    for k in range(len(q)):
        frames(turns, shifts, first, q[k], axes, centers, rotation, p)
        for j in range(n):
            z0, z1, z2 = axes[j, 0], axes[j, 1], axes[j, 2]
            if j < first:
                jacobian[k, 0, j], jacobian[k, 1, j], jacobian[k, 2, j] = z0, z1, z2
                jacobian[k, 3:, j] = 0.0
                continue
            d0, d1, d2 = p[0] - centers[j, 0], p[1] - centers[j, 1], p[2] - centers[j, 2]
            jacobian[k, 0, j] = z1 * d2 - z2 * d1
            jacobian[k, 1, j] = z2 * d0 - z0 * d2
            jacobian[k, 2, j] = z0 * d1 - z1 * d0
            jacobian[k, 3, j], jacobian[k, 4, j], jacobian[k, 5, j] = z0, z1, z2


@kernel
def jacobian_rate_all(
    turns: FloatArray, shifts: FloatArray, first: int, q: FloatArray, dq: FloatArray, rate: FloatArray
) -> None:
    """Fill in the change of the Jacobians (k, 6, n) along dq (k, n)."""
    n = q.shape[1]
    axes, centers, rotation, p = np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3)
    spin, drift = np.empty((n, 3)), np.empty((n, 3))
    for k in range(len(q)):
        frames(turns, shifts, first, q[k], axes, centers, rotation, p)
        v = moving(axes, centers, p, first, dq[k], spin, drift)
        bend(axes, centers, p, first, spin, drift, v, rate[k])


@kernel
def moving(
    axes: FloatArray,
    centers: FloatArray,
    p: FloatArray,
    first: int,
    dq: FloatArray,
    spin: FloatArray,
    drift: FloatArray,
) -> tuple[float, float, float]:
    """Fill in how fast each joint's frame turns and its point moves (n, 3); return the tool's velocity."""
    w0, w1, w2, v0, v1, v2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    n = len(dq)
    for j in range(n):
        spin[j, 0], spin[j, 1], spin[j, 2] = w0, w1, w2
        drift[j, 0], drift[j, 1], drift[j, 2] = v0, v1, v2
        if j < first:
            v0, v1, v2 = v0 + dq[j] * axes[j, 0], v1 + dq[j] * axes[j, 1], v2 + dq[j] * axes[j, 2]
            continue
        w0, w1, w2 = w0 + dq[j] * axes[j, 0], w1 + dq[j] * axes[j, 1], w2 + dq[j] * axes[j, 2]
        end = centers[j + 1] if j + 1 < n else p
        d0, d1, d2 = end[0] - centers[j, 0], end[1] - centers[j, 1], end[2] - centers[j, 2]
        v0, v1, v2 = v0 + w1 * d2 - w2 * d1, v1 + w2 * d0 - w0 * d2, v2 + w0 * d1 - w1 * d0
    return v0, v1, v2


@kernel
def bend(
    axes: FloatArray, centers: FloatArray, p: FloatArray, first: int, spin: FloatArray, drift: FloatArray,
    v: tuple[float, float, float], rate: FloatArray,
) -> None:  # fmt: skip
    """Fill in the rate (6, n) of the Jacobian for moving frames; that of joints that slide is zero."""
    for j in range(len(axes)):
        if j < first:
            for i in range(6):
                rate[i, j] = 0.0
            continue
        z0, z1, z2 = axes[j, 0], axes[j, 1], axes[j, 2]
        w0, w1, w2 = spin[j, 0], spin[j, 1], spin[j, 2]
        y0, y1, y2 = w1 * z2 - w2 * z1, w2 * z0 - w0 * z2, w0 * z1 - w1 * z0
        d0, d1, d2 = p[0] - centers[j, 0], p[1] - centers[j, 1], p[2] - centers[j, 2]
        u0, u1, u2 = v[0] - drift[j, 0], v[1] - drift[j, 1], v[2] - drift[j, 2]
        rate[0, j] = y1 * d2 - y2 * d1 + z1 * u2 - z2 * u1
        rate[1, j] = y2 * d0 - y0 * d2 + z2 * u0 - z0 * u2
        rate[2, j] = y0 * d1 - y1 * d0 + z0 * u1 - z1 * u0
        rate[3, j], rate[4, j], rate[5, j] = y0, y1, y2
