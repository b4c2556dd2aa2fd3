"""Chains of overlapping boxes of joint angles, and the least that has to be paid on them, on plain arrays."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray

TAU = 2 * np.pi
# Boxes this near count as overlapping: room for rounding [rad].
_NEAR = 1e-10


@kernel
def overlap(low: FloatArray, high: FloatArray, other_low: FloatArray, other_high: FloatArray, wraps: BoolArray) -> bool:
    """Return whether two boxes (n,) overlap, joints that wrap modulo 2π."""
    for j in range(len(low)):
        apart = 0.5 * (low[j] + high[j] - other_low[j] - other_high[j])
        if wraps[j]:
            apart -= TAU * np.rint(apart / TAU)
        if abs(apart) > 0.5 * (high[j] - low[j] + other_high[j] - other_low[j]) + _NEAR:
            return False
    return True


@kernel
def cross(
    low: FloatArray, high: FloatArray, toll: FloatArray, cost: FloatArray, to_low: FloatArray, to_high: FloatArray,
    to_toll: FloatArray, wraps: BoolArray, found: FloatArray,
) -> None:  # fmt: skip
    """Lower the costs `found` (p,) of the boxes (p, n) to those of chains that come from the boxes (m, n) of a slab.

    Chains have paid `cost` (m,) there, infinite where none comes, and pay half of the toll of either box.
    """
    for k in range(len(to_low)):
        for i in range(len(low)):
            paid = cost[i] + 0.5 * (toll[i] + to_toll[k])
            if paid < found[k] and overlap(low[i], high[i], to_low[k], to_high[k], wraps):
                found[k] = paid


@kernel
def settle(low: FloatArray, high: FloatArray, toll: FloatArray, wraps: BoolArray, cost: FloatArray) -> None:
    """Lower the costs (m,) to those of chains that go on through overlaps among the boxes (m, n): Dijkstra (1959)."""
    waiting, left = np.arange(len(low)), len(low)
    while left > 0:
        best = 0
        for k in range(1, left):
            if cost[waiting[k]] < cost[waiting[best]]:
                best = k
        i = waiting[best]
        if np.isinf(cost[i]):
            return
        left -= 1
        waiting[best] = waiting[left]
        for k in range(left):
            other = waiting[k]
            paid = cost[i] + 0.5 * (toll[i] + toll[other])
            if paid < cost[other] and overlap(low[i], high[i], low[other], high[other], wraps):
                cost[other] = paid


@kernel
def components(low: FloatArray, high: FloatArray, wraps: BoolArray) -> IntArray:
    """Return the numbers (m,) of the connected parts that overlapping boxes (m, n) form."""
    m = len(low)
    label, stack, count = np.full(m, -1), np.empty(m, np.int64), 0
    for k in range(m):
        if label[k] >= 0:
            continue
        label[k], stack[0], depth = count, k, 1
        while depth > 0:
            depth -= 1
            i = stack[depth]
            for other in range(m):
                if label[other] < 0 and overlap(low[i], high[i], low[other], high[other], wraps):
                    label[other], stack[depth] = count, other
                    depth += 1
        count += 1
    return label


@kernel
def meeting(
    low: FloatArray, high: FloatArray, label: IntArray, to_low: FloatArray, to_high: FloatArray, to_label: IntArray,
    wraps: BoolArray, found: BoolArray,
) -> None:  # fmt: skip
    """Mark in `found` which labels of boxes (m, n) meet which of others (p, n) where these overlap."""
    for i in range(len(low)):
        for k in range(len(to_low)):
            if not found[label[i], to_label[k]] and overlap(low[i], high[i], to_low[k], to_high[k], wraps):
                found[label[i], to_label[k]] = True
