"""What the next round of a proof makes finer: which slabs it halves, and how long cells may still be."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.certificate.tube import Chain

_LEFT = 0.1  # part of what chords lose that may be in slabs that are not halved
_ENOUGH = 0.7  # of the gap asked for: what chords need not lose less than
_WIDEST = 1 / 60  # slabs that are halved in any case
_SHARE = 3.0  # square of the spacing, as a part of what a slab's chord may lose, for l1 and l2
_LOSS = 0.3  # loss of the proof per slab for want of shorter cells, as a part of what its chord may lose
_PER_STEP = 4.0  # longest cells, in slab widths [rad]
_WANTED = 0.3  # part of the gap asked for that chords need not lose less than
_NARROWER = 0.1  # what spacing is multiplied by at least, from one round to the next
_AT_ONCE = 0.35  # the same where cells lose more than chords do: the tube gets narrower by that, with fewer cells
_JUMP = 3.0  # chords that are so many times as long as most
_WITHOUT = 0.35  # what spacing is multiplied by where no motion is known


class BestMotion(NamedTuple):
    """What a round wants to know of the best motion, slab by slab.

    Attributes
    ----------
    excess : array, shape (k,)
        By how much it is longer than its chord.
    steps : array, shape (k, n)
    """

    excess: FloatArray
    steps: FloatArray


def finer(
    chain: Chain, spacing: FloatArray, best: BestMotion | None, wanted: float, objective: str
) -> tuple[BoolArray, FloatArray]:
    """Return which slabs to halve (k,), and the spacing of cells on each slice (k + 1,).

    Parameters
    ----------
    chain : Chain
        The cheapest chords.
    spacing : array, shape (k + 1,)
        Of cells so far [rad].
    best : BestMotion or None
        If one is known. Slabs where it is longest beyond its chord are halved, no more of them than `wanted` needs;
        that excess falls to a quarter then. So are those where the cheapest chords jump and it does not. Cells get
        shorter where they lost more than a part of what chords will lose then: that falls with their length's cube.
        Where they should be much shorter at once, they are made somewhat shorter first, and no slab is halved: most of
        them are dropped in between.
    wanted : float
        Cost that may be left unproved.
    objective : str
        Its kind.
    """
    h = np.diff(chain.r)
    if best is None:
        return np.ones(len(h), bool), _WITHOUT * spacing
    excess, steps = best.excess, np.abs(np.diff(chain.q, axis=0)).max(axis=1)
    order = np.argsort(excess)
    slabs = np.ones(len(h), bool)
    enough = (_ENOUGH * wanted - 0.25 * excess.sum()) / 0.75
    slabs[order[np.cumsum(excess[order]) <= max(_LEFT * excess.sum(), enough)]] = False
    slabs |= h > _WIDEST
    apart = np.abs(np.diff(chain.q, axis=0) - best.steps).max(axis=1)
    slabs |= (steps > _JUMP * np.median(steps)) & (apart > 0.5 * steps)
    expected = max(excess[~slabs].sum() + 0.25 * excess[slabs].sum(), _WANTED * wanted)
    allowed = expected / (len(h) + slabs.sum())
    so_far = np.maximum.accumulate(np.maximum(chain.lost, 0.0))  # proposals may be too low for a while
    lost = np.maximum(np.diff(so_far), 1e-300)
    measured = np.cbrt(_LOSS * allowed / np.maximum(np.append(lost, 0.0), np.append(0.0, lost)))
    step = np.where(slabs, 0.5 * h, h)
    most = _PER_STEP * np.minimum(np.append(step, np.inf), np.append(np.inf, step))
    if objective != "joint_travel":  # values are carried as straight lines over cells then
        most = np.minimum(most, np.sqrt(_SHARE * allowed))
    shorter = np.minimum(spacing * np.clip(measured, _NARROWER, 1.0), most)
    if so_far[-1] > excess.sum() and (shorter < _AT_ONCE * spacing).any():
        return np.zeros(len(h), bool), np.maximum(shorter, _AT_ONCE * spacing)
    return slabs, shorter


def with_new(spacing: FloatArray, slabs: BoolArray) -> FloatArray:
    """Return the spacing of a tube's slices after new ones in the middle of some slabs."""
    at = np.flatnonzero(slabs)
    return np.insert(spacing, at + 1, 0.5 * (spacing[at] + spacing[at + 1]))
