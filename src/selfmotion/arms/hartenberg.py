"""Denavit–Hartenberg parameters of chains whose neighbouring joints are perpendicular or parallel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.arms.chain import Chain

SAME = 1e-9  # of lengths [m] and angles [rad]


class Hartenberg(NamedTuple):
    """``T = base · Π Rz(q_j + shift_j) Tz(d_j) Tx(a_j) Rx(α_j) · tool``, without d of the first and a of the last.

    Attributes
    ----------
    base, tool : array, shape (4, 4)
    shift, d, a : array, shape (n,)
    """

    base: FloatArray
    shift: FloatArray
    d: FloatArray
    a: FloatArray
    tool: FloatArray


def hartenberg(chain: Chain, twists: tuple[float, ...]) -> Hartenberg | None:
    """Return the parameters of a chain whose axes are turned by quarter turns about x, or not at all.

    Parameters
    ----------
    chain : Chain
        Of revolute joints.
    twists : tuple of float, length n − 1
        The sines of α_j: 1, −1, or 0 for parallel axes of the same sense.

    Returns
    -------
    Hartenberg or None
        None if neighbouring axes are not at these angles.

    Notes
    -----
    Which sign a quarter turn has is a choice of the sense of x, and a may be negative. Between parallel axes the common
    normal is taken where the first of them has d = 0, and a is not negative; all of d goes to the second, or on to
    where the run of parallel axes ends.
    """
    n = chain.n
    base = chain.offsets[0].copy()
    shift, d, a = np.zeros(n), np.zeros(n), np.zeros(n)
    for j, sign in enumerate(twists):
        rotation, t = chain.offsets[j + 1][:3, :3], chain.offsets[j + 1][:3, 3]
        if sign == 0.0:
            if max(abs(rotation[0, 2]), abs(rotation[1, 2])) > SAME or rotation[2, 2] < 0.0:
                return None
            mu = np.arctan2(t[1], t[0])
            nu = np.arctan2(rotation[1, 0], rotation[0, 0]) - mu
            a[j] = np.hypot(t[0], t[1])
            d[j], d[j + 1] = 0.0, d[j] + t[2]
        else:
            if abs(rotation[2, 2]) > SAME:
                return None
            # Rz(μ) Rx(±π/2) Rz(ν): its last column is where the next joint's axis points.
            axis = rotation[:, 2]
            mu = np.arctan2(sign * axis[0], -sign * axis[1])
            nu = np.arctan2(sign * rotation[2, 0], sign * rotation[2, 1])
            a[j] = t @ np.array([np.cos(mu), np.sin(mu), 0.0])
            d[j] += t[2]
            d[j + 1] += t @ axis
        shift[j] += mu
        shift[j + 1] += nu
    base[:3, 3] += base[:3, :3] @ np.array([0.0, 0.0, d[0]])
    tool = chain.offsets[n].copy()
    turn = np.eye(4)
    c, s = np.cos(-shift[n - 1]), np.sin(-shift[n - 1])
    # What the last joint is turned by to begin with belongs to the tool.
    turn[:2, :2] = [[c, -s], [s, c]]
    tool = np.linalg.inv(turn) @ tool
    tool[2, 3] += d[n - 1]
    shift[n - 1] = 0.0
    d[0] = d[n - 1] = 0.0
    return Hartenberg(base, wrap(shift), d, a, tool)


def vanish(*lengths: float) -> bool:
    """Return whether lengths are zero but for rounding in a file."""
    return max(abs(length) for length in lengths) <= SAME
