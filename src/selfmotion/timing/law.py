"""Time-optimal laws r(t) under joint limits, by TOPP-RA, checked between its grid points and refined there."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import MissingExtraError, SelfMotionError
from selfmotion.timing.geometry import Geometry

_CELLS, _FEWEST, _MOST = 200, 24, 6000  # of the grid: of all the path, of a piece at least, of a piece at most
_ROUNDS = 12
_LEAST = 1e-5  # width of a cell, as a part of its piece; in smaller ones differences of speeds are all rounding
_SIDE = 1e-9  # of a break, in r
_INSIDE = np.array(
    [0.0005, 0.02, 0.05, *np.linspace(0.1, 0.9, 9), 0.95, 0.98, 0.9995]
)  # of a cell: where it is checked
_FINE = 1e-4  # by which a law may be too fast between grid points without being refined
_SETTLED = 5e-3  # change of the duration when all cells are halved, which makes more of it not worth its time
_CAUTION = 5e-5  # slower than what was checked asks for
_UNBOUNDED = 1e3  # times as fast as usual, where hardly any joint moves


@dataclass(frozen=True)
class Limits:
    """What a law keeps.

    Attributes
    ----------
    velocity, acceleration : array, shape (n,)
        Of the joints [rad/s, rad/s²; m/s, m/s² of those that slide]; velocities may be infinite.
    tool_speed : float
        Of the tool's position, in the path's unit of length per second; infinite without one.
    """

    velocity: FloatArray
    acceleration: FloatArray
    tool_speed: float


class Moved(NamedTuple):
    """Where a law is at k times, and how it moves.

    Attributes
    ----------
    r, speed, acceleration : array, shape (k,)
        Path parameter and its derivatives by time [1/s, 1/s²].
    """

    r: FloatArray
    speed: FloatArray
    acceleration: FloatArray


class Law:
    """r(t), with dr/dt linear in time on each cell.

    Parameters
    ----------
    r : array, shape (m + 1,)
        Ends of the cells.
    speed : array, shape (m + 1,)
        dr/dt there, zero where the arm stands still, never in two places on end.
    """

    def __init__(self, r: FloatArray, speed: FloatArray) -> None:
        self.r, self.speed = r, speed
        self.steps = 2.0 * np.diff(r) / (speed[1:] + speed[:-1])
        self.t = np.concatenate([[0.0], np.cumsum(self.steps)])
        self.acceleration = np.diff(speed) / self.steps

    @property
    def duration(self) -> float:
        """From r = 0 to r = 1 [s]."""
        return float(self.t[-1])

    def __call__(self, t: FloatArray) -> Moved:
        """Return where the law is at times (k,), which are taken into [0, duration]."""
        times = np.clip(t, 0.0, self.t[-1])
        cell = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.steps) - 1)
        since = times - self.t[cell]
        r = self.r[cell] + since * (self.speed[cell] + 0.5 * self.acceleration[cell] * since)
        speed = self.speed[cell] + self.acceleration[cell] * since
        r, speed = np.clip(r, self.r[cell], self.r[cell + 1]), np.maximum(speed, 0.0)
        ended = times >= self.t[-1]  # where nothing may be left over from rounding
        return Moved(np.where(ended, self.r[-1], r), np.where(ended, self.speed[-1], speed), self.acceleration[cell])


def fastest(geometry: Geometry, limits: Limits) -> Law:
    """Return the fastest law that keeps the limits.

    Raises
    ------
    MissingExtraError
        If toppra is not installed.
    SelfMotionError
        If toppra finds none.

    Notes
    -----
    Pieces between corners are timed one by one, from rest to rest. H. Pham, Q.-C. Pham, *A new approach to time-optimal
    path parameterization based on reachability analysis* (2018), gives dr/dt at grid points, where alone it looks at
    the limits: here at both ends of each cell, by the derivatives on its side. Cells inside which the law breaks them
    are halved until it hardly does, and what is left is taken away by slowing the piece down as a whole, which keeps
    its shape.
    """
    solver = toppra()
    corners = geometry.edges[geometry.corners]
    laws = [_piece(solver, geometry, limits, a, b) for a, b in pairwise(corners)]
    r = np.concatenate([law[0][:-1] for law in laws] + [[1.0]])
    speed = np.concatenate([law[1][:-1] for law in laws] + [[0.0]])
    return Law(r, speed)


def toppra() -> Any:
    """Return the package toppra.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        for part in ("algorithm", "constraint", "interpolator"):
            importlib.import_module(f"toppra.{part}")
        return importlib.import_module("toppra")
    except ImportError:
        raise MissingExtraError("", "needs the package toppra", "pip install 'selfmotion[time]'") from None


def _piece(solver: Any, geometry: Geometry, limits: Limits, a: float, b: float) -> tuple[FloatArray, FloatArray]:
    """Return grid points and dr/dt there between two corners."""
    grid = _grid(geometry, a, b)
    best: tuple[float, FloatArray, FloatArray] | None = None
    settled = np.inf  # the duration when the grid was halved as a whole
    for _ in range(_ROUNDS):
        squared = _solved(solver, geometry, limits, grid)
        if squared is None:
            halved = np.ones(len(grid) - 1, dtype=bool)
        else:
            too_fast = _overrun(geometry, limits, grid, squared)
            worst, speed = float(too_fast.max()), np.sqrt(squared)
            time = worst * float((2.0 * np.diff(grid) / (speed[1:] + speed[:-1])).sum())
            if best is None or time < best[0]:
                best = time, grid, speed / (worst * (1.0 + _CAUTION))
            halved = too_fast > 1.0 + 0.5 * _FINE
            halved[1:] |= halved[:-1].copy()
            if worst <= 1.0 + _FINE:
                if abs(time - settled) <= _SETTLED * time:
                    break
                halved, settled = np.ones(len(grid) - 1, dtype=bool), time
        halved &= np.diff(grid) > 2 * _LEAST * (b - a)
        if not halved.any() or len(grid) + halved.sum() > _MOST:
            break
        grid = np.sort(np.concatenate([grid, (0.5 * (grid[1:] + grid[:-1]))[halved]]))
    if best is None:
        raise SelfMotionError(f"no time law was found for r in [{a:.6g}, {b:.6g}]", "try other limits")
    return best[1], best[2]


def _grid(geometry: Geometry, a: float, b: float) -> FloatArray:
    """Return the first grid points: at breaks and knots, and evenly apart between."""
    least = _LEAST * (b - a)
    inner = geometry.edges[(geometry.edges > a + least) & (geometry.edges < b - least)]
    cells = max(_FEWEST, int(_CELLS * (b - a)))
    grid = np.concatenate([[a], inner, [b]])
    for more in (geometry.knots[(geometry.knots > a) & (geometry.knots < b)], np.linspace(a, b, cells + 1)):
        apart = more[np.diff(more, prepend=-1.0) > least]
        right = np.clip(np.searchsorted(grid, apart), 1, len(grid) - 1)
        nearest = np.minimum(np.abs(apart - grid[right - 1]), np.abs(apart - grid[right]))
        grid = np.sort(np.concatenate([grid, apart[nearest > 0.9 * least]]))
    return grid


def _solved(solver: Any, geometry: Geometry, limits: Limits, grid: FloatArray) -> FloatArray | None:
    """Return (dr/dt)² at the grid points by toppra, None where it fails."""
    ends = np.clip(grid, grid[0], grid[-1] - _SIDE)
    rates, bends = geometry.derivatives(ends)
    # Of each cell at its end too, from its own side: there accelerations may jump.
    later = [np.concatenate([part, part[-1:]]) for part in geometry.derivatives(grid[1:] - _SIDE)]
    with np.errstate(divide="ignore"):
        most = np.min(limits.velocity / np.abs(rates), axis=1)
        most = np.minimum(most, limits.tool_speed / geometry.tool_speed(ends))
    # How fast accelerations alone let it become, from rest and to rest again, is about this.
    quickest = np.min(2.0 * limits.acceleration / np.maximum(np.abs(rates).max(axis=0), 1e-300))
    swing = float(np.sqrt(quickest * np.ptp(grid)))
    # In units in which the speed is about one, whatever r and the limits are in: toppra's tolerances are absolute.
    unit = min(float(np.median(most)), swing)
    most = np.minimum(most / unit, _UNBOUNDED)
    s = (grid - grid[0]) / unit
    both = np.stack([rates, later[0]]) * unit, np.stack([bends, later[1]]) * unit**2
    return _reachable(solver, s, *both, limits.acceleration, most, unit)


def _reachable(
    solver: Any, s: FloatArray, rates: FloatArray, bends: FloatArray, acceleration: FloatArray, most: FloatArray,
    unit: float,
) -> FloatArray | None:  # fmt: skip
    """Return (dr/dt)², s being r/unit; derivatives of the joints are those at each cell's start, and at its end."""
    points, n = len(s), len(acceleration)

    class Curve(solver.interpolator.AbstractGeometricPath):  # type: ignore[misc]
        """Where the motion begins and ends; nothing else of it is asked for."""

        dof = n
        path_interval = np.array([s[0], s[-1]])
        waypoints = None

        def __call__(self, _: Any, order: int = 0) -> FloatArray:
            return rates[0]

    class Fastest(solver.constraint.LinearConstraint):  # type: ignore[misc]
        """The bound on ds/dt by joints and tool."""

        def compute_constraint_params(self, *_: Any, **__: Any) -> tuple[Any, ...]:
            bound = np.stack([np.zeros_like(most), most**2], axis=1)
            return (None, None, None, None, None, None, bound)

    class Strongest(solver.constraint.LinearConstraint):  # type: ignore[misc]
        """The bounds on accelerations of joints, each in units of its limit, at both ends of a cell.

        Over a cell of width d the square of ds/dt goes from x to x + 2 d u, where u is the acceleration of s.
        """

        def compute_constraint_params(self, *_: Any, **__: Any) -> tuple[Any, ...]:
            width = np.diff(s, append=s[-1])[:, None]
            of_u = np.hstack([rates[0], rates[1] + 2.0 * width * bends[1]]) / np.tile(acceleration, 2)
            of_x = np.hstack([bends[0], bends[1]]) / np.tile(acceleration, 2)
            sides = np.vstack([np.eye(2 * n), -np.eye(2 * n)])
            return of_u, of_x, np.zeros((points, 2 * n)), sides, np.ones(4 * n), None, None

    strongest = Strongest()
    strongest.identical = True  # the same sides at all points
    instance = solver.algorithm.TOPPRA([Fastest(), strongest], Curve(), gridpoints=s, solver_wrapper="seidel")
    instance.compute_parameterization(0.0, 0.0)
    found = instance.problem_data.sd_vec
    if found is None or not np.isfinite(found).all() or (found[1:] + found[:-1] <= 0.0).any():
        return None
    return np.asarray((np.maximum(found, 0.0) * unit) ** 2)


def loads(
    geometry: Geometry, limits: Limits, r: FloatArray, speed: FloatArray, acceleration: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return velocities and accelerations of joints as parts of their limits, (k, n) each, and so the tool's speed."""
    rates, bends = geometry.derivatives(r)
    velocity = rates * speed[:, None] / limits.velocity
    joint = (bends * speed[:, None] ** 2 + rates * acceleration[:, None]) / limits.acceleration
    return velocity, joint, geometry.tool_speed(r) * speed / limits.tool_speed


def _overrun(geometry: Geometry, limits: Limits, grid: FloatArray, squared: FloatArray) -> FloatArray:
    """Return by which factor each cell's law is too fast, one or less where it is not."""
    width = np.diff(grid)
    half = 0.5 * np.diff(squared) / width
    inside = grid[:-1, None] + width[:, None] * _INSIDE
    speed = np.sqrt(np.maximum(squared[:-1, None] + 2.0 * half[:, None] * width[:, None] * _INSIDE, 0.0))
    by_cell = np.broadcast_to(half[:, None], inside.shape).ravel()
    velocity, joint, tool = loads(geometry, limits, inside.ravel(), speed.ravel(), by_cell)
    worst = np.maximum(np.abs(velocity).max(axis=1), np.sqrt(np.abs(joint).max(axis=1)))
    return np.maximum(worst, tool).reshape(inside.shape).max(axis=1)
