"""Joint limits and winding: a limited joint's angle is a real number, a free joint's an angle modulo 2π.

A joint that slides has a position, not an angle: it is never turned.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import contains_text, number, read_only
from selfmotion._types import BoolArray, FloatArray, IntArray, Limits
from selfmotion.angles import NEVER, TAU, nearest_turn, unwrap, wrap
from selfmotion.errors import InvalidInputError

_MANY_TURNS = 4 * TAU  # that a joint's limits are seldom beyond [rad]
_LONG = 100.0  # that rails seldom are [m]
ON_LIMIT = 1e-9
"""By how much a posture that is given, or solved for, may overrun a limit [rad, or m of joints that slide]."""


class Lifted(NamedTuple):
    """Motions made continuous and moved by whole turns into the limits as far as they go.

    Attributes
    ----------
    q : array, shape (p, k, n)
    excess : array, shape (p, n)
        How far each joint still leaves its limits somewhere on the motion [rad]; zero inside.
    """

    q: FloatArray
    excess: FloatArray


class JointBox(NamedTuple):
    """Lower and upper ends of each joint, shape (n,), infinite where there is none."""

    lower: FloatArray
    upper: FloatArray


class JointLimits:
    """Lower and upper limits of n joints.

    Parameters
    ----------
    limits : sequence or None
        Per joint ``None`` (free) or ``(lower, upper)`` [rad], either of which may be None. They may span more
        than 2π: the multiple of 2π is part of the joint's state and never wrapped away.
    n : int
        Number of joints.
    slides : array of bool, shape (n,), optional
        Which joints slide; none by default. Their limits are lengths [m].

    Attributes
    ----------
    period : array, shape (n,)
        After which a joint's positions are the same again: 2π, or never, see :data:`~selfmotion.angles.NEVER`.

    Raises
    ------
    InvalidInputError
        If the number is wrong, or a pair is reversed or not made of numbers.
    """

    def __init__(self, limits: Limits, n: int, slides: BoolArray | None = None) -> None:
        given = [None] * n if limits is None else limits
        if isinstance(given, str) or not hasattr(given, "__len__") or len(given) != n:
            raise InvalidInputError("limits", f"needs one entry per joint, {n}", "write null for a free joint", limits)
        lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
        for j, pair in enumerate(given):
            if pair is None:
                continue
            field = f"limits.{j}"
            if contains_text(pair) or not hasattr(pair, "__len__") or len(pair) != 2:
                raise InvalidInputError(field, "is not a pair", "write [lower, upper] or null", pair)
            low, high = pair
            lower[j] = -np.inf if low is None or low == -np.inf else number(field, low)
            upper[j] = np.inf if high is None or high == np.inf else number(field, high)
            if lower[j] > upper[j]:
                raise InvalidInputError(field, "is reversed", "write the lower limit first", pair)
        self.lower = read_only(lower)
        self.upper = read_only(upper)
        self.slides = np.zeros(n, bool) if slides is None else np.array(slides, dtype=bool)
        self.slides.flags.writeable = False
        self.period = read_only(np.where(self.slides, NEVER, TAU))

    def __repr__(self) -> str:
        return f"JointLimits({self.as_list()})"

    def as_list(self) -> list[list[float | None] | None]:
        """Return the limits as a problem file writes them."""
        ends = [
            [float(v) if np.isfinite(v) else None for v in pair] for pair in zip(self.lower, self.upper, strict=True)
        ]
        return [None if pair == [None, None] else pair for pair in ends]

    def doubts(self, names: Sequence[str] = ()) -> list[str]:
        """Return what is to be said of limits so wide that they may be in degrees, or millimetres for a rail.

        Parameters
        ----------
        names : sequence of str
            Of the joints; their numbers, from 1, by default.
        """
        doubts = []
        for j, (low, high, slides) in enumerate(zip(self.lower, self.upper, self.slides, strict=True)):
            ends = np.array([low, high])
            largest = float(np.abs(ends[np.isfinite(ends)]).max(initial=0.0))
            if largest <= (_LONG if slides else _MANY_TURNS):
                continue
            name = f"joint {names[j] if names else j + 1}"
            if slides:
                doubts.append(f"{name} may slide from {low:g} to {high:g} m: are its limits in mm? they are in m")
            else:
                turned = f"{largest:g} rad is {np.degrees(largest):.0f}°, more than four turns"
                doubts.append(
                    f"{name} may turn from {low:g} to {high:g} rad, and {turned}: are its limits in degrees? "
                    "they are in radians"
                )
        return doubts

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each joint: ``"rad"``, or ``"m"`` of one that slides."""
        return tuple("m" if slides else "rad" for slides in self.slides)

    @property
    def unit(self) -> str:
        """The unit of what is said of all joints together, such as the largest step of any."""
        return " or ".join(dict.fromkeys(reversed(self.units)))

    @property
    def limited(self) -> BoolArray:
        """Which joints have a limit, shape (n,)."""
        return np.isfinite(self.lower) | np.isfinite(self.upper)

    def margin(self, q: ArrayLike) -> FloatArray:
        """Return the signed distance of each joint to its nearest limit, the angle taken as it stands.

        Parameters
        ----------
        q : array_like, shape (..., n)

        Returns
        -------
        array, shape (..., n)
            Positive inside, infinite for free joints [rad].
        """
        angles = np.asarray(q, dtype=float)
        return np.minimum(angles - self.lower, self.upper - angles)

    def steps(self, q: FloatArray, to: FloatArray) -> FloatArray:
        """Return the joint steps from `q` to `to`, shape (..., n): real for limited joints, modulo 2π for free ones."""
        return np.where(self.limited, to - q, wrap(to - q, self.period))

    def continuous(self, q: FloatArray) -> FloatArray:
        """Return sampled postures (k, n) with free joints made continuous; limited ones stay as they stand."""
        return np.where(self.limited | self.slides, q, np.unwrap(q, axis=0))

    def excess(self, q: ArrayLike) -> FloatArray:
        """Return by how much each joint misses its limits when whole turns are free.

        Parameters
        ----------
        q : array_like, shape (..., n)

        Returns
        -------
        array, shape (..., n)
            Zero where some q + 2πk is inside the limits [rad].
        """
        angles = np.asarray(q, dtype=float)
        both = np.isfinite(self.lower) & np.isfinite(self.upper)
        lower, upper = np.where(both, self.lower, -np.inf), np.where(both, self.upper, np.inf)
        middle = 0.5 * (np.where(both, self.lower, 0.0) + np.where(both, self.upper, 0.0))
        near = nearest_turn(angles, middle, self.period)
        return np.maximum(np.maximum(lower - near, near - upper), 0.0)

    def admit(self, q: ArrayLike) -> BoolArray:
        """Return which postures keep the limits up to rounding when whole turns are free.

        Parameters
        ----------
        q : array_like, shape (..., n)

        Returns
        -------
        array of bool, shape (...)
        """
        return np.asarray((self.excess(q) <= ON_LIMIT).all(axis=-1))

    def lift(self, q: FloatArray, start: ArrayLike | None = None) -> Lifted:
        """Make sampled motions continuous and choose each joint's number of turns.

        Parameters
        ----------
        q : array, shape (p, k, n)
            p motions of k samples with joints modulo 2π; consecutive samples must differ by less than π.
            Changed in place.
        start : array_like, shape (n,), optional
            Posture that the motions start from; without it each limited joint is moved by the number of turns
            that leaves it least outside, the fewest if several do, and a free joint starts in [−π, π].

        Returns
        -------
        Lifted
        """
        unwrap(q, self.period)
        limited = np.flatnonzero(self.limited)
        turns, excess = np.zeros((len(q), q.shape[2])), np.zeros((len(q), q.shape[2]))
        low, high = q[..., limited].min(axis=1), q[..., limited].max(axis=1)
        if start is not None:
            turns = np.rint((np.asarray(start, dtype=float) - q[:, 0]) / self.period)
        else:
            turns[:, limited] = self._turns(low, high, limited)
        if turns.any():
            turned = self.period * turns
            q += turned[:, None, :]
            low += turned[:, limited]
            high += turned[:, limited]
        below, above = self.lower[limited] - low, high - self.upper[limited]
        excess[:, limited] = np.maximum(below, 0.0) + np.maximum(above, 0.0)
        return Lifted(q, excess)

    def _turns(self, low: FloatArray, high: FloatArray, joints: IntArray) -> FloatArray:
        """Return the fewest whole turns that bring the extents [low, high] of `joints` best inside their limits."""
        lower, upper, period = self.lower[joints], self.upper[joints], self.period[joints]
        least, most = np.ceil((lower - low) / period), np.floor((upper - high) / period)
        with np.errstate(invalid="ignore"):
            centred = np.rint((lower + upper - low - high) / (2 * period))
        return np.where(least <= most, np.clip(0.0, least, most), centred)
