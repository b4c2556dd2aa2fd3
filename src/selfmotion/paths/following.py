"""Orientations that follow a curve: a tool axis along the tangent, another as near to a direction as may be."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path, distance, worst_of_parts
from selfmotion.paths.orientation import Orientation
from selfmotion.rotations import from_matrix, product, pure

UPRIGHT = {"x": "z", "y": "z", "z": "x"}
"""Which axis of the tool stays near the reference direction, by the axis that goes along the tangent."""
_AXES = "xyz"
# A tangent this near to the reference direction, or a curve this slow, has no frame [rad, part of the length].
_PARALLEL = 1e-6
_STOPPED = 1e-9
# A tangent that jumps by more is a corner [rad]; the left one is taken this part of a piece before it.
_CORNER = 1e-6
_BEFORE = 1e-9
# Neighbours in the table of signs turn by at most this [rad].
_TABLE = 0.5
_LOOKS = 256


class Following(Orientation):
    """The frame of a space curve and a reference direction.

    Parameters
    ----------
    path : Path
        A space curve without corners that gives its third derivative.
    axis : {"x", "y", "z"}
        The tool axis along the tangent T.
    up : array, shape (3,)
        The direction that another tool axis keeps as near to as it can: z, or x if `axis` is z; a unit vector.

    Raises
    ------
    InvalidInputError
        Naming r, where the tangent is parallel to `up`, jumps, or vanishes.

    Notes
    -----
    With N the part of `up` across T, normalized, the angular velocity is ``T × T'`` and a spin about T; together
    ``|ω| ≤ |T'| / sin α``, α the angle between T and `up`, and ``|T'| ≤ |x''|/|x'|``. On a part of half width h about m
    with ``|x''| ≤ A`` the speed is at least ``|x'(m)| − A h``, and so α changes by at most h times the bound on
    ``|T'|``: which proves the bound wherever it is finite.
    """

    def __init__(self, path: Path, axis: str, up: FloatArray) -> None:
        self.path = path
        self.axis = axis
        self.up = up
        if path.highest_order < 3:
            raise InvalidInputError(
                "follow",
                f"needs the third derivative of the curve, which a {type(path).__name__} does not give",
                "follow the curve itself and change the parameter of the whole path",
            )
        self._check_tangent()
        self._r, self._q = self._table()

    @property
    def breaks(self) -> FloatArray:
        """Those of the curve."""
        return self.path.breaks

    def _check_tangent(self) -> None:
        """Refuse where there is no frame, or two."""
        r = self.path.grid(_LOOKS)
        speed, lean = self._lean(r)
        stopped = speed <= _STOPPED * max(self.path.length, 1e-300)
        if stopped.any():
            reason = f"has no tangent to follow at r = {r[stopped][0]:.6g}: the position stops there"
            raise InvalidInputError("follow", reason, "give a curve that moves, or the orientations themselves")
        self._check_corners()
        for k in range(len(r)):
            # The tangent can pass `up` only next to a sample nearer to it than a few steps.
            near = lean[max(k - 1, 0) : k + 2]
            if lean[k] > near.min() or lean[k] > 4 * np.ptp(near) + _PARALLEL:
                continue
            at = self._nearest_to_parallel(float(r[max(k - 1, 0)]), float(r[min(k + 1, len(r) - 1)]), float(r[k]))
            if self._lean(np.array([at]))[1][0] <= _PARALLEL:
                reason = f"has up along the tangent at r = {at:.6g}, where it leaves the turn about the tangent open"
                raise InvalidInputError("follow", reason, "choose another up", self.up.tolist())

    def _lean(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the speed, and the angle between the tangent's line and `up`, at `r` (k,)."""
        velocity = self.path(r, 1)
        across = distance(np.cross(velocity, self.up))
        return distance(velocity), np.arctan2(across, np.abs(velocity @ self.up))

    def _nearest_to_parallel(self, low: float, high: float, best: float) -> float:
        """Return where in [low, high] the tangent is nearest to `up`, by narrowing about the best of a few places."""
        for _ in range(12):
            r = np.unique(np.append(np.linspace(low, high, 17), best))
            k = int(np.argmin(self._lean(r)[1]))
            best, low, high = float(r[k]), float(r[max(k - 1, 0)]), float(r[min(k + 1, len(r) - 1)])
        return best

    def _check_corners(self) -> None:
        edges = np.concatenate([[0.0], self.path.breaks])
        for before, at in pairwise(edges):
            left, right = self.path([at - _BEFORE * (at - before), at], 1)
            jump = float(np.arctan2(distance(np.cross(left, right)), left @ right))
            if jump > _CORNER:
                reason = f"has a tangent to follow that jumps by {jump:.6g} rad at r = {at:.6g}"
                raise InvalidInputError("follow", reason, "round the corner off, or give the orientations themselves")

    def _table(self) -> tuple[FloatArray, FloatArray]:
        """Return parameters and quaternions, continuous in sign, so close that any in between has one nearer sign."""
        r = self.path.grid(64)
        for _ in range(20):
            q = self._unsigned(r)
            near = 2 * np.arccos(np.clip(np.abs((q[:-1] * q[1:]).sum(axis=1)), 0.0, 1.0))
            wide = near > _TABLE
            if not wide.any() or len(r) > 100_000:
                break
            r = np.sort(np.concatenate([r, 0.5 * (r[:-1] + r[1:])[wide]]))
        flips = np.where((q[:-1] * q[1:]).sum(axis=1) < 0, -1.0, 1.0)
        return r, q * np.concatenate([[1.0], np.cumprod(flips)])[:, None]

    def _frames(self, r: FloatArray, order: int) -> list[FloatArray]:
        """Return the rotation matrices (k, 3, 3) at `r` and their derivatives up to `order`."""
        tangent = normalized([self.path(r, k) for k in range(1, order + 2)])
        across = [self.up - (tangent[0] @ self.up)[:, None] * tangent[0]]
        if order > 0:
            across.append(-_mix(self.up, tangent[1], tangent[0]) - _mix(self.up, tangent[0], tangent[1]))
        if order > 1:
            middle = 2 * _mix(self.up, tangent[1], tangent[1])
            across.append(-_mix(self.up, tangent[2], tangent[0]) - middle - _mix(self.up, tangent[0], tangent[2]))
        upright = normalized(across)
        first, second = _AXES.index(self.axis), _AXES.index(UPRIGHT[self.axis])
        third = 3 - first - second
        sign = 1.0 if (second - first) % 3 == 1 else -1.0
        binomial = ([1], [1, 1], [1, 2, 1])
        frames = []
        for n in range(order + 1):
            side = sum(c * np.cross(tangent[j], upright[n - j]) for j, c in enumerate(binomial[n]))
            columns = {first: tangent[n], second: upright[n], third: sign * side}
            frames.append(np.stack([columns[k] for k in range(3)], axis=-1))
        return frames

    def _unsigned(self, r: FloatArray) -> FloatArray:
        return from_matrix(self._frames(r, 0)[0])

    def evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return the quaternion of the frame, or ``q' = ω q/2``, ``q'' = ω' q/2 − |ω|² q/4``."""
        frames = self._frames(r, order)
        q = from_matrix(frames[0])
        known = self._q[np.clip(np.searchsorted(self._r, r, side="right") - 1, 0, None)]
        q = np.where((q * known).sum(axis=1, keepdims=True) < 0, -q, q)
        if order == 0:
            return q
        omega = 0.5 * np.cross(frames[0], frames[1], axis=1).sum(axis=2)
        if order == 1:
            return 0.5 * product(pure(omega), q)
        change = 0.5 * np.cross(frames[0], frames[2], axis=1).sum(axis=2)
        return 0.5 * product(pure(change), q) - 0.25 * (omega * omega).sum(axis=1, keepdims=True) * q

    def turning(self, low: float, high: float) -> float:
        """Return the proved bound on the angular speed, from bounds on the curve's derivatives."""
        return worst_of_parts(self.path, low, high, self._turning_of_part, "angular speed")

    def _turning_of_part(self, low: float, high: float) -> float:
        half, middle = 0.5 * (high - low), np.array([0.5 * (low + high)])
        bend = self.path.bending(low, high)
        if bend == 0.0:
            return 0.0
        (speed,), (lean,) = self._lean(middle)
        slowest = float(speed) - bend * half
        if slowest <= 0.9 * speed:
            return np.inf
        swing = bend / slowest
        least = float(lean) - swing * half
        return swing / float(np.sin(least)) if least > 0.9 * lean else np.inf


def normalized(v: list[FloatArray]) -> list[FloatArray]:
    """Return the unit vector of v and its derivatives, given v (k, 3) and as many derivatives, at most two."""
    size = np.linalg.norm(v[0], axis=1, keepdims=True)
    unit = [v[0] / size]
    if len(v) > 1:
        growth = (unit[0] * v[1]).sum(axis=1, keepdims=True)
        unit.append((v[1] - growth * unit[0]) / size)
    if len(v) > 2:
        more = (unit[1] * v[1] + unit[0] * v[2]).sum(axis=1, keepdims=True)
        unit.append((v[2] - 2 * growth * unit[1] - more * unit[0]) / size)
    return unit


def _mix(up: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Return (up·a) b."""
    return np.asarray((a @ up)[:, None] * b)
