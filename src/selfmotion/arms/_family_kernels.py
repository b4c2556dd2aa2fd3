"""The closed forms of spatial arms, as kernels that other kernels are handed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import NamedTuple

import numpy as np
from numba import types

from selfmotion._compiled import Handed
from selfmotion._types import BoolArray, FloatArray, IntArray

PANDA, SRS, WRIST, UR, WRIST_RAIL, UR_RAIL = range(6)
BRANCHES = 8
_MODULES = (
    "_panda_kernels", "_srs_kernels", "_wrist_kernels", "_ur_kernels", "_wrist_rail_kernels", "_ur_rail_kernels",
)  # fmt: skip
_FREE = ((0, -1), (0, 4), (0, 3), (-1, 5), (1, 4), (-1, 6))

_one, _two, _three = (types.Array(types.float64, d, "C") for d in (1, 2, 3))
_flags, _states = types.Array(types.boolean, 1, "C"), types.Array(types.int64, 1, "C")
_number, _index = types.float64, types.int64
SOLVE = types.void(_one, _two, _one, _number, _two, _flags)
ENCLOSE = types.void(_one, _three, _two, _number, _number, _three, _three, _states)
TURNED = types.boolean(_one, _three, _two, _number, _number, _index, _index, _number, _number, _two)
OF_POSTURE = types.int64(_one, _one)
PARAMETER = types.float64(_one, _one)

Solve = Callable[[FloatArray, FloatArray, FloatArray, float, FloatArray, BoolArray], None]
Enclose = Callable[[FloatArray, FloatArray, FloatArray, float, float, FloatArray, FloatArray, IntArray], None]
Turned = Callable[[FloatArray, FloatArray, FloatArray, float, float, int, int, float, float, FloatArray], bool]


class Closed(NamedTuple):
    """The kernels of one family.

    Attributes
    ----------
    solve : callable
        Fill in the posture on every branch (8, n), and which there are.
    enclose : callable
        Enclose the postures of every branch over an interval of u, box and rate (8, n, 2), and say what they are.
    turned : callable
        Narrow the box of a branch whose shoulder or wrist is singular to where one of its joints is in an interval.
    branch_of, parameter_of : callable
        Branch and redundancy parameter of a posture, the latter of arms where it is a matter of the joints alone.
    free : array of int, shape (2,)
        The joints of shoulder and wrist that `turned` can be given, −1 for none.
    """

    solve: Solve
    enclose: Enclose
    turned: Turned
    branch_of: Callable[[FloatArray, FloatArray], int]
    parameter_of: Callable[[FloatArray, FloatArray], float]
    free: IntArray


@cache
def closed(number: int) -> Closed:
    """Return the kernels of a family; those of others are not even imported."""
    module = import_module(f"selfmotion.arms.{_MODULES[number]}")
    return Closed(
        module.solve, module.enclose, module.turned, module.branch_of, module.parameter_of, np.array(_FREE[number])
    )


def _solve_all(
    solve: Solve, geometry: FloatArray, rotations: FloatArray, positions: FloatArray, u: FloatArray, branch: int,
    q: FloatArray, ok: BoolArray,
) -> None:  # fmt: skip
    """Fill in the postures (k, n) on one branch at k poses, and which there are."""
    every, there = np.empty((BRANCHES, q.shape[1])), np.empty(BRANCHES, np.bool_)
    for k in range(len(u)):
        solve(geometry, rotations[k], positions[k], u[k], every, there)
        ok[k] = there[branch]
        if ok[k]:
            q[k] = every[branch]


def _parameter_all(
    parameter_of: Callable[[FloatArray, FloatArray], float], geometry: FloatArray, q: FloatArray, u: FloatArray
) -> None:
    """Fill in the redundancy parameters of postures (k, n)."""
    for k in range(len(q)):
        u[k] = parameter_of(geometry, q[k])


def _branch_all(
    branch_of: Callable[[FloatArray, FloatArray], int], geometry: FloatArray, q: FloatArray, branch: IntArray
) -> None:
    """Fill in the branches of postures (k, n)."""
    for k in range(len(q)):
        branch[k] = branch_of(geometry, q[k])


solve_all = Handed(_solve_all, [SOLVE])
parameter_all = Handed(_parameter_all, [PARAMETER])
branch_all = Handed(_branch_all, [OF_POSTURE])
