"""Kernels of six-axis arms whose base slides on a rail: what the families of such arms have in common.

The frame after joint 6, seen from the base, is ``T = Trans(−u a) X tool⁻¹``: X is the whole pose, a the rail's
direction in the base's frame, and the parameter u is how far the base is along the rail. A *geometry* is the six-axis
family's, with a after it. Joint 1 is the rail, so that the family's joint k is joint k + 1. As u grows the frame moves
along −a and does not turn: with that the family's own kernels enclose its joints and their rates.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms._jet_kernels import down, up
from selfmotion.arms._range_kernels import exactly, get, less, product, put
from selfmotion.arms._wrist_kernels import PAD, sight

SIX = 6


@kernel
def seen_from(geometry: FloatArray, position: FloatArray, u: float) -> FloatArray:
    """Return a position (3,) as the base at u on its rail sees it."""
    moved, last = np.empty(3), len(geometry) - 3
    for i in range(3):
        moved[i] = position[i] - u * geometry[last + i]
    return moved


@kernel
def put_behind(six: FloatArray, there: BoolArray, u: float, q: FloatArray, ok: BoolArray) -> None:
    """Fill in postures q (8, 7) and which there are, from the family's (8, 6) with the rail at u."""
    for branch in range(len(ok)):
        ok[branch] = there[branch]
        q[branch, 0] = u if there[branch] else np.nan
        for j in range(SIX):
            q[branch, 1 + j] = six[branch, j]


@kernel
def put_boxes_behind(
    six: FloatArray, speed: FloatArray, u0: float, u1: float, box: FloatArray, rate: FloatArray
) -> None:
    """Fill in boxes and rates (8, 7, 2), from the family's (8, 6, 2) with the rail in [u0, u1]."""
    for branch in range(len(box)):
        box[branch, 0, 0], box[branch, 0, 1] = u0, u1
        rate[branch, 0, 0], rate[branch, 0, 1] = 1.0, 1.0
        for j in range(SIX):
            for end in range(2):
                box[branch, 1 + j, end], rate[branch, 1 + j, end] = six[branch, j, end], speed[branch, j, end]


@kernel
def sight_from(
    geometry: FloatArray, lengths: int, rotation: FloatArray, position: FloatArray, size: float, u0: float, u1: float,
    rows: FloatArray, place: FloatArray, motion: FloatArray,
) -> float:  # fmt: skip
    """Do for a base in [u0, u1] on its rail what :func:`sight` does for a roll.

    `lengths` is how many lengths the geometry begins with. The pose does not roll; and rounding grows with how far away
    it and the base are.
    """
    middle = 0.5 * (u0 + u1)
    sight(geometry[lengths:], rotation, position, size, 0.0, 0.0, rows, place, motion)
    last, far = len(geometry) - 3, max(abs(u0), abs(u1))
    for i in range(3):
        far = max(far, abs(position[i, 0]), abs(position[i, 1]))
    for i in range(3):
        along, pad = exactly(geometry[last + i]), PAD * far
        here, all_over = get(place[0], i), get(place[1], i)
        here = less((here[0] - pad, here[1] + pad), product(along, exactly(middle)))
        all_over = less((all_over[0] - pad, all_over[1] + pad), product(along, (u0, u1)))
        put(place[0], i, here)
        put(place[1], i, all_over)
        motion[i, 0], motion[i, 1] = down(-along[0]), up(-along[0])
    return up(max(u1 - middle, middle - u0))
