"""Six joints with a spherical wrist on a rail, the tool keeping its pose: in closed form and enclosed.

Formulas are in the docstrings of ``_wrist_kernels`` and ``_rail_kernels``. Branches are the six-axis family's.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms import _wrist_kernels as six
from selfmotion.arms._rail_kernels import SIX, put_behind, put_boxes_behind, seen_from, sight_from

_LENGTHS = six.LENGTHS
_branch_of, _follow, _size_of, _solve, _turned = (
    six.branch_of, six.follow_frames, six.size_of, six.solve, six.turned_frames,
)  # fmt: skip


@kernel
def solve(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, q: FloatArray, ok: BoolArray
) -> None:
    """Fill in the postures q (8, 7) of all branches with the rail at u, and whether they exist; q is NaN where not."""
    found, there = np.empty((len(ok), SIX)), np.empty(len(ok), np.bool_)
    _solve(geometry, rotation, seen_from(geometry, position, u), 0.0, found, there)
    put_behind(found, there, u, q, ok)


@kernel
def branch_of(geometry: FloatArray, q: FloatArray) -> int:
    """Return the branch of a posture (7,)."""
    return _branch_of(geometry, q[1:])


@kernel
def enclose(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float,
    box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Enclose the postures of all branches, box (8, 7, 2), for the rail in [u0, u1] and the poses in a box of poses.

    Rates and states are as the six-axis family's kernel says, with u for its roll.
    """
    rows, place, motion = np.empty((2, 3, 3, 2)), np.empty((2, 3, 2)), np.empty((3, 2))
    found, speed = np.empty((len(state), SIX, 2)), np.empty((len(state), SIX, 2))
    half = sight_from(geometry, _LENGTHS, rotation, position, _size_of(geometry), u0, u1, rows, place, motion)
    _follow(geometry, np.zeros(3), rows, place, motion, half, found, speed, state)
    put_boxes_behind(found, speed, u0, u1, box, rate)


@kernel
def turned(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, branch: int, joint: int,
    low: float, high: float, box: FloatArray,
) -> bool:  # fmt: skip
    """Narrow the box (7, 2) of a SINGULAR branch as the six-axis family's kernel does; False if nothing is left."""
    rows, place, motion = np.empty((2, 3, 3, 2)), np.empty((2, 3, 2)), np.empty((3, 2))
    sight_from(geometry, _LENGTHS, rotation, position, _size_of(geometry), u0, u1, rows, place, motion)
    return _turned(geometry, rows[1], place[1], branch, joint - 1, low, high, box[1:])


@kernel
def parameter_of(geometry: FloatArray, q: FloatArray) -> float:
    """Return u, which is where the rail is."""
    return float(q[0])
