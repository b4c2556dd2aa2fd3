"""What a time law makes of a plan: joint angles, velocities and accelerations by time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import positive
from selfmotion._types import FloatArray
from selfmotion.arms import RedundantArm
from selfmotion.errors import InvalidInputError
from selfmotion.plans import Plan
from selfmotion.timing.geometry import Geometry
from selfmotion.timing.law import Law, Limits, loads

MOST_ROWS = 5_000_000
_SHORT = 0.003  # part of the path that is no stretch of its own
_SAME = 1e-3  # parts of a step: the last row is at the end, and not in two rows that clocks cannot tell apart


@dataclass(frozen=True)
class Slow:
    """A stretch of the path that the tool goes along more slowly than asked for.

    Attributes
    ----------
    r, t : tuple of float
        From and to: path parameter, time [s].
    slowest : float
        Least speed of the tool there.
    why : str
        The limit that holds it back: ``"velocity"`` or ``"acceleration"``.
    joint : int
        Whose limit that is, counted from 1.
    name : str
        Its name.
    rest : bool
        Whether the arm stands still there: at the start, the end or a corner.
    """

    r: tuple[float, float]
    t: tuple[float, float]
    slowest: float
    why: str
    joint: int
    name: str
    rest: bool

    def __str__(self) -> str:
        least = "from or to rest" if self.rest else f"down to {self.slowest:.4g}"
        return f"r in [{self.r[0]:.4g}, {self.r[1]:.4g}]: {least}, by the {self.why} of {self.name}"


class TimedTrajectory:
    """A plan's motion with a time law, sampled at a rate; call it with t for the joint angles at any time.

    Parameters
    ----------
    plan : Plan
    law : Law
    limits : Limits
    rate : float
        Samples per second.

    Attributes
    ----------
    t : array, shape (k,)
        Times [s]: every multiple of 1/rate, and the end; no step is longer than 1.001/rate.
    r : array, shape (k,)
        Path parameters.
    q, dq, ddq : array, shape (k, n)
        Joint angles [rad], velocities [rad/s] and accelerations [rad/s²]; with m for rad of a joint that slides.
    joint_names : tuple of str
        The arm's, in its order; of planar arms those of their placement, ``joint1``, ``joint2``, … without one.
    frame_id : str
        The frame that the arm stands in: of arms in space the base link's, of planar ones that of their placement.

    Raises
    ------
    InvalidInputError
        If the rate is not positive or makes too many rows.
    """

    def __init__(self, plan: Plan, law: Law, limits: Limits, rate: float = 100.0) -> None:
        self.plan, self.law, self.limits = plan, law, limits
        self.rate = positive("rate", rate)
        self._geometry = Geometry(plan)
        steps = law.duration * self.rate
        if steps > MOST_ROWS:
            raise InvalidInputError("rate", f"makes more than {MOST_ROWS} rows", "give a lower one", rate)
        t = np.arange(int(np.ceil(steps - _SAME)) + 1) / self.rate
        t[-1] = law.duration
        self.t = t
        self.r = law(t).r
        self.q, self.dq, self.ddq = self.states(t)
        self.joint_names, self.frame_id = _named(plan.problem.arm)

    def __repr__(self) -> str:
        return f"TimedTrajectory({self.duration:.6g} s, {len(self.t)} rows)"

    def __call__(self, t: ArrayLike) -> FloatArray:
        """Return the joint angles at times `t`, shape (..., n): the plan's at r(t), bit by bit [rad]."""
        times = self._times(t)
        return self.plan(self.law(times.reshape(-1)).r).reshape(*times.shape, -1)

    def states(self, t: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return joint angles, velocities and accelerations at times `t`, shape (..., n) each."""
        times = self._times(t)
        moved = self.law(times.reshape(-1))
        rates, bends = self._geometry.derivatives(moved.r)
        speed = moved.speed[:, None]
        found = self.plan(moved.r), rates * speed, bends * speed**2 + rates * moved.acceleration[:, None]
        q, dq, ddq = (part.reshape(*times.shape, -1) for part in found)
        return q, dq, ddq

    def at_rate(self, rate: float) -> TimedTrajectory:
        """Return the same at another rate."""
        return TimedTrajectory(self.plan, self.law, self.limits, rate)

    def _times(self, t: ArrayLike) -> FloatArray:
        times = np.asarray(t, dtype=float)
        if not ((times >= 0.0) & (times <= self.duration)).all():
            raise InvalidInputError("t", f"leaves [0, {self.duration:.6g}]", "give times of the motion", t)
        return times

    @property
    def duration(self) -> float:
        """From r = 0 to r = 1 [s]."""
        return self.law.duration

    @cached_property
    def jerk(self) -> FloatArray:
        """Largest change of each joint's acceleration from one row to the next, times the rate, shape (n,) [rad/s³].

        Before the first row and after the last the arm stands still. A fastest law jumps from one acceleration to
        another, so that this grows with the rate without bound.
        """
        rest = np.zeros((1, self.ddq.shape[1]))
        steps = np.abs(np.diff(np.concatenate([rest, self.ddq, rest]), axis=0))
        return np.asarray(steps.max(axis=0) * self.rate)

    @cached_property
    def stops(self) -> tuple[float, ...]:
        """Path parameters inside (0, 1) where the arm must stand still, since the rate of a joint jumps there."""
        inner = self._geometry.edges[self._geometry.corners][1:-1]
        return tuple(inner.tolist())

    @property
    def unlimited(self) -> tuple[str, ...]:
        """Names of the joints whose velocity is not limited."""
        return tuple(
            name for name, limit in zip(self.joint_names, self.limits.velocity, strict=True) if np.isinf(limit)
        )

    @property
    def largest(self) -> tuple[FloatArray, FloatArray]:
        """Largest velocity and acceleration of each joint at the samples, as parts of their limits, (n,) each.

        The velocity of a joint without a limit is no part of any: 0.
        """
        velocity, acceleration = self.limits.velocity, self.limits.acceleration
        return np.abs(self.dq).max(axis=0) / velocity, np.abs(self.ddq).max(axis=0) / acceleration

    @cached_property
    def slow(self) -> tuple[Slow, ...]:
        """Where the tool is slower than asked for, by more than a thousandth; empty if no speed was asked for."""
        wanted = self.limits.tool_speed
        if not np.isfinite(wanted):
            return ()
        t = np.union1d(self.law.t, 0.5 * (self.law.t[1:] + self.law.t[:-1]))
        moved = self.law(t)
        velocity, acceleration, part = loads(self._geometry, self.limits, *moved)
        by_velocity, by_acceleration = np.abs(velocity), np.abs(acceleration)
        n = velocity.shape[1]
        # Which limit is nearest: a joint's acceleration, or its velocity, counted on from n.
        nearest = np.argmax(np.concatenate([by_acceleration, by_velocity], axis=1), axis=1)
        runs: list[tuple[int, list[int]]] = []
        for k in np.flatnonzero(part < 1.0 - 1e-3).tolist():
            goes_on = bool(runs) and runs[-1][1][-1] == k - 1
            if goes_on and (runs[-1][0] == nearest[k] or np.ptp(moved.r[runs[-1][1]]) < _SHORT):
                runs[-1] = int(nearest[k]), [*runs[-1][1], k]
            else:
                runs.append((int(nearest[k]), [k]))
        found: list[Slow] = []
        last = -1  # where the stretch before ends
        for limit, places in runs:
            # To where it is as fast as asked for, or to where another limit takes over.
            low, high = max(places[0] - 1, last, 0), min(places[-1] + 1, len(t) - 1)
            last = high
            ends = (float(moved.r[low]), float(moved.r[high])), (float(t[low]), float(t[high]))
            slowest, rest = float(part[places].min() * wanted), not moved.speed[places].all()
            why, joint = "velocity" if limit >= n else "acceleration", limit % n
            found.append(Slow(*ends, slowest, why, joint + 1, self.joint_names[joint], rest))
        return tuple(found)


def _named(arm: RedundantArm) -> tuple[tuple[str, ...], str]:
    """Return the names of an arm's joints, and of the frame that it stands in."""
    chain, placement = getattr(arm, "chain", None), getattr(arm, "placement", None)
    if chain is not None:
        return chain.names, chain.base
    names = None if placement is None else placement.joints
    return names or tuple(f"joint{j}" for j in range(1, arm.n + 1)), "" if placement is None else placement.frame
