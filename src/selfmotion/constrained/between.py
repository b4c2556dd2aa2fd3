"""Is a constraint kept between samples too? Steps are enclosed, and halved where nothing is sure."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms import RedundantArm
from selfmotion.arms.cells import Cells
from selfmotion.constrained.arm import constraints_of
from selfmotion.constrained.constraint import FREE, Constraint

_HALVINGS = 40
_MOST = 200_000  # steps that may have to be halved at once: a motion that needs more keeps too near
# Times the distances from its chord at the quarters of a step that a motion is granted all along it. What vanishes at
# both ends and is a polynomial of degree four is nowhere more than 1.8602 times the largest of its values there.
_CAUTION = 2.0


class Unsure(NamedTuple):
    """A place where a constraint is not surely kept: r, the least margin there and its number."""

    r: float
    margin: float
    which: int


def unsure(
    constraint: Constraint, motion: Callable[[FloatArray], FloatArray], r: FloatArray, q: FloatArray
) -> Unsure | None:
    """Return where a motion may break a constraint between its samples; None if it surely does nowhere.

    Parameters
    ----------
    constraint : Constraint
    motion : callable
        Maps r (k,) to postures (k, n).
    r : array, shape (k,)
        Ascending.
    q : array, shape (k, n)
        The motion there.

    Notes
    -----
    Within a step the motion is taken to be no farther from its chord, joint by joint, than twice the farthest it is at
    the quarters of the step, which is true of polynomials up to the fourth degree; with that, what is said holds for
    every r. Steps of which nothing is sure are halved, until one of them has a posture that breaks the constraint or is
    too short to be halved.
    """
    low, high, a, b = r[:-1], r[1:], q[:-1], q[1:]
    middle = 0.5 * (low + high)
    half = motion(middle)
    for _ in range(_HALVINGS):
        one, two = motion(np.concatenate([0.5 * (low + middle), 0.5 * (middle + high)])).reshape(2, *a.shape)
        off = [half - 0.5 * (a + b), one - 0.75 * a - 0.25 * b, two - 0.25 * a - 0.75 * b]
        dev = _CAUTION * np.abs(off).max(axis=0)
        state, _ = constraint.of_cells(_cells(a, b, dev), constraint.tolerance)
        left = np.flatnonzero(state != FREE)
        if not len(left):
            return None
        margins, which = constraint.least_margins(half[left])
        worst = int(margins.argmin())
        if margins[worst] < -constraint.tolerance or 2 * len(left) > _MOST:
            return Unsure(float(middle[left][worst]), float(margins[worst]), int(which[worst]))
        # Both halves of each, in turn.
        low, high = _by_turns(low[left], middle[left]), _by_turns(middle[left], high[left])
        a, b, half = _by_turns(a[left], half[left]), _by_turns(half[left], b[left]), _by_turns(one[left], two[left])
        middle = 0.5 * (low + high)
    margins, which = constraint.least_margins(a[:1])
    return Unsure(float(low[0]), float(margins[0]), int(which[0]))


def not_clear(arm: RedundantArm, q: FloatArray) -> BoolArray:
    """Return the steps of a sampled motion on which some constraint is not surely kept, joints moving straight.

    Parameters
    ----------
    arm : RedundantArm
    q : array, shape (k, n)

    Returns
    -------
    array of bool, shape (k − 1,)
        Those whose own ends break it included.
    """
    found = np.zeros(len(q) - 1, bool)
    for constraint in constraints_of(arm):
        step, a, b = np.arange(len(q) - 1), q[:-1], q[1:]
        for _ in range(_HALVINGS):
            half = 0.5 * (a + b)
            state, _ = constraint.of_cells(_cells(a, b, np.zeros_like(a)), constraint.tolerance)
            found[step[constraint.least_margins(half)[0] < -constraint.tolerance]] = True
            left = np.flatnonzero((state != FREE) & ~found[step])
            if 2 * len(left) > _MOST or not len(left):
                break
            step, half, a, b = step[left], half[left], a[left], b[left]
            step, a, b = np.tile(step, 2), np.concatenate([a, half]), np.concatenate([half, b])
        found[step[state != FREE]] = True
    return found


def _by_turns(one: FloatArray, two: FloatArray) -> FloatArray:
    """Return rows of two arrays by turns."""
    return np.stack([one, two], axis=1).reshape(-1, *one.shape[1:])


def straight(r: FloatArray, q: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Return the motion whose joints move on straight lines between samples q (k, n) at r (k,)."""

    def motion(at: FloatArray) -> FloatArray:
        return np.stack([np.interp(at, r, joint) for joint in q.T], axis=-1)

    return motion


def _cells(a: FloatArray, b: FloatArray, dev: FloatArray) -> Cells:
    return Cells(a, b, dev, np.zeros((len(a), 4)), np.arange(len(a)))
