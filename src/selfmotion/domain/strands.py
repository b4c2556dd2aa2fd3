"""Intervals that are known at places along a path, followed from place to place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import Cause
from selfmotion.domain.feasible import Run
from selfmotion.domain.strips import Strip

_HELD = 0.5  # part of the shorter of two intervals that is a large one
Causes = tuple[tuple[Cause, ...], tuple[Cause, ...]]


def followed(r: FloatArray, looks: Sequence[Sequence[Run]]) -> list[Strip]:
    """Return intervals at places along a path as strips, each followed from place to place.

    Parameters
    ----------
    r : array, shape (k,)
        Ascending.
    looks : sequence of sequence of Run
        The intervals at each r.

    Returns
    -------
    list of Strip
        They stop short of where they change; fillers, without causes, hold what is on both sides of a change.
    """
    strands: list[_Strand] = []
    going: list[_Strand] = []
    for k, runs in enumerate(looks):
        before = [strand.runs[-1] for strand in going]
        partner = _partners(before, runs)
        now = []
        for run, other in zip(runs, partner, strict=True):
            if other is not None:
                going[other].runs.append(_beside(run, before[other]))
                now.append(going[other])
                continue
            now.append(_Strand(k, [run]))
            strands.append(now[-1])
            for old in before:
                low, high = _shared(old, run)
                if low <= high:
                    strands.append(_Strand(k - 1, [Run(low, high, _UNKNOWN)] * 2))
        going = now
    return [_strip(r, strand, number) for number, strand in enumerate(strands)]


def _strip(r: FloatArray, strand: _Strand, number: int) -> Strip:
    runs, causes = strand.runs, strand.runs[0].causes
    ends = ((), ()) if runs[0].high - runs[0].low >= TAU else ((2 * number,), (2 * number + 1,))
    low, high = (np.array([getattr(run, end) for run in runs]) for end in ("low", "high"))
    return Strip(r[strand.first : strand.first + len(runs)], low, high, ends, causes, 0)


class _Strand:
    """An interval followed from look to look: its runs, from look `first` on."""

    def __init__(self, first: int, runs: list[Run]) -> None:
        self.first, self.runs = first, runs


_UNKNOWN: Causes = ((), ())


def _partners(before: Sequence[Run], now: Sequence[Run]) -> list[int | None]:
    """Return for each run the one before that it goes on: of the same ends, with most in common or the only one.

    Where one run has a large part of two on the other side these join, or part, and none goes on.
    """
    partner: list[int | None] = [None] * len(now)
    pairs, held = [], []
    for i, run in enumerate(now):
        for j, old in enumerate(before):
            if old.causes == run.causes:
                low, high = _shared(old, run)
                pairs.append((high - low, i, j))
                if high - low > _HELD * min(run.high - run.low, old.high - old.low):
                    held.append((i, j))
    used = set()
    for common, i, j in sorted(pairs, reverse=True):
        alone = sum(i == other for _, other, _ in pairs) == 1 == sum(j == other for _, _, other in pairs)
        join = any((i == one) != (j == two) for one, two in held) and (i, j) in held
        if partner[i] is None and j not in used and (common >= 0.0 or alone) and not join:
            partner[i] = j
            used.add(j)
    return partner


def _beside(run: Run, old: Run) -> Run:
    """Return a run moved by whole turns to where the one before is."""
    turn = TAU * float(np.rint((old.low + old.high - run.low - run.high) / (2 * TAU)))
    return Run(run.low + turn, run.high + turn, run.causes)


def _shared(old: Run, run: Run) -> tuple[float, float]:
    """Return what two runs have most in common, in the turn of the old one; low > high if nothing."""
    near = _beside(run, old)
    found = [(max(old.low, near.low + turn), min(old.high, near.high + turn)) for turn in (-TAU, 0.0, TAU)]
    return max(found, key=lambda ends: ends[1] - ends[0])
