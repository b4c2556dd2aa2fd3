"""The angle domain of an arm whose structure is not told, looked at along the path and followed from look to look."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause
from selfmotion.domain.angle_domain import AngleDomain
from selfmotion.domain.feasible import Run
from selfmotion.domain.strips import Strip

LOOKS = 120
_MOST_BREAKS = 50
_PART = 8  # looks that a thread takes at once
_ROUNDS = 6  # in which a change is closed in upon, by half each
_MOVED = 0.15  # by what an end may move from look to look [rad]

_Causes = tuple[tuple[Cause, ...], tuple[Cause, ...]]


class SampledDomain:
    """Feasible intervals at places along the path, closer together where they change.

    Parameters
    ----------
    domain : AngleDomain
    branches : sequence of int
        The branches to look at.
    looks : int
        Number of places to begin with, besides the path's breaks if these are few.

    Attributes
    ----------
    r : array, shape (k,)
    runs : dict
        Per branch the intervals at each r, with what ends them.
    """

    def __init__(self, domain: AngleDomain, branches: Sequence[int], looks: int = LOOKS) -> None:
        self.domain = domain
        self.branches = tuple(branches)
        breaks = domain.path.breaks
        r = np.unique(np.concatenate([np.linspace(0.0, 1.0, looks), breaks if len(breaks) <= _MOST_BREAKS else []]))
        found = self._look(r)
        for _ in range(_ROUNDS):
            changed = [_kinds(a) != _kinds(b) or _moved(a, b) > _MOVED for a, b in pairwise(found)]
            place = np.flatnonzero(changed) + 1
            between = 0.5 * (r[place - 1] + r[place])
            for at, new in zip(place[::-1], self._look(between)[::-1], strict=True):
                found.insert(at, new)
            r = np.insert(r, place, between)
        self.r = r
        self.runs = {branch: [here[k] for here in found] for k, branch in enumerate(self.branches)}

    def stretches(self, branch: int) -> list[tuple[float, float]]:
        """Return the first and last r of each stretch on which the branch was seen to be feasible."""
        some = np.array([bool(runs) for runs in self.runs[branch]], dtype=int)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], some, [0]])))
        return [(float(self.r[a]), float(self.r[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True)]

    def strips(self, branch: int) -> list[Strip]:
        """Return what is feasible on a branch as strips; they stop short of where they change, and fillers go on.

        Returns
        -------
        list of Strip
            Fillers have no causes: they hold what is feasible on both sides of a change.
        """
        return followed(self.r, self.runs[branch])

    def _look(self, r: FloatArray) -> list[list[list[Run]]]:
        """Return at each r (k,) the intervals of each branch."""

        def look(part: FloatArray) -> list[list[list[Run]]]:
            arcs = self.domain.sample(part)
            return [[arcs[branch].runs(k) for branch in self.branches] for k in range(len(part))]

        parts = np.array_split(r, -(-len(r) // _PART)) if len(r) else []
        with ThreadPoolExecutor(os.cpu_count()) as pool:  # most of the time is spent in kernels that do not hinder it
            return [here for found in pool.map(look, parts) for here in found]


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
        See :meth:`SampledDomain.strips`.
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


_UNKNOWN: _Causes = ((), ())


def _kinds(here: list[list[Run]]) -> list[list[_Causes]]:
    """Return what the intervals of every branch are ended by, in an order that does not depend on where u begins."""
    return [[run.causes for run in _by_ends(runs)] for runs in here]


def _by_ends(runs: list[Run]) -> list[Run]:
    """Return runs in an order that does not depend on where u begins, but for those with the same ends."""
    return sorted(runs, key=lambda run: repr(run.causes))


def _moved(before: list[list[Run]], now: list[list[Run]]) -> float:
    """Return how far the ends of the same intervals have moved, at most."""
    pairs = [
        (a, b) for one, two in zip(before, now, strict=True) for a, b in zip(_by_ends(one), _by_ends(two), strict=True)
    ]
    full = [a.high - a.low >= TAU for a, _ in pairs]
    ends = [(b.low - a.low, b.high - a.high) for (a, b), skip in zip(pairs, full, strict=True) if not skip]
    return float(np.abs(wrap(np.array(ends))).max(initial=0.0))


def _partners(before: Sequence[Run], now: Sequence[Run]) -> list[int | None]:
    """Return for each run the one before that it goes on: of the same ends, with most in common or the only one."""
    partner: list[int | None] = [None] * len(now)
    pairs = []
    for i, run in enumerate(now):
        for j, old in enumerate(before):
            if old.causes == run.causes:
                low, high = _shared(old, run)
                pairs.append((high - low, i, j))
    used = set()
    for common, i, j in sorted(pairs, reverse=True):
        alone = sum(i == other for _, other, _ in pairs) == 1 == sum(j == other for _, _, other in pairs)
        if partner[i] is None and j not in used and (common >= 0.0 or alone):
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
