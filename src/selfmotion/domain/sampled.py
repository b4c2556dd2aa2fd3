"""The angle domain of an arm whose structure is not told, looked at along the path and followed from look to look."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause
from selfmotion.constrained.self_motion import ConstrainedSelfMotion
from selfmotion.domain.angle_domain import AngleDomain
from selfmotion.domain.feasible import Run
from selfmotion.domain.holes import Hole, holes_of, met, taken
from selfmotion.domain.strands import Causes, followed
from selfmotion.domain.strips import Strip

LOOKS = 120
_MOST_BREAKS = 50
_PART = 8  # looks that a thread takes at once, where each takes long
_ROUNDS = 6  # in which a change is closed in upon, by half each
_MOVED = 0.15  # by what an end may move from look to look [rad]


class SampledDomain:
    """Feasible intervals at places along the path, closer together where they change.

    Parameters
    ----------
    domain : AngleDomain
    branches : sequence of int
        The branches to look at.
    looks : int
        Number of places to begin with, besides the path's breaks if these are few.
    rounds : int
        How often a change is closed in upon, by half each.

    Attributes
    ----------
    r : array, shape (k,)
    runs : dict
        Per branch the intervals at each r, with what ends them.
    taken : dict
        Per branch what constraints beyond joint limits take at each r; see :func:`~selfmotion.domain.holes.taken`.
    """

    def __init__(self, domain: AngleDomain, branches: Sequence[int], looks: int = LOOKS, rounds: int = _ROUNDS) -> None:
        self.domain = domain
        self.branches = tuple(branches)
        breaks = domain.path.breaks
        r = np.unique(np.concatenate([np.linspace(0.0, 1.0, looks), breaks if len(breaks) <= _MOST_BREAKS else []]))
        found = self._look(r)
        quick = self.domain.unconstrained.self_motion.has_structure
        for _ in range(rounds):
            changed = [
                _kinds(a.runs) != _kinds(b.runs) or (quick and _met(a) != _met(b)) or _moved(a.runs, b.runs) > _MOVED
                for a, b in pairwise(found)
            ]
            place = np.flatnonzero(changed) + 1
            between = 0.5 * (r[place - 1] + r[place])
            for at, new in zip(place[::-1], self._look(between)[::-1], strict=True):
                found.insert(at, new)
            r = np.insert(r, place, between)
        self.r = r
        self.runs = {branch: [here.runs[k] for here in found] for k, branch in enumerate(self.branches)}
        self.taken = {branch: [here.taken[k] for here in found] for k, branch in enumerate(self.branches)}

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

    def holes(self, branch: int) -> list[Hole]:
        """Return what constraints beyond joint limits take of a branch, the largest hole first."""
        motion = self.domain.self_motion

        def cause_at(r: float, u: float) -> Cause | None:
            assert isinstance(motion, ConstrainedSelfMotion)
            number = int(motion.least_kept(motion.pose(self.domain.path([r])), np.array([[u]]), branch)[0, 0])
            return None if number < 0 else motion.cause(number)

        return holes_of(self.r, self.taken[branch], cause_at)

    def _look(self, r: FloatArray) -> list[_Look]:
        """Return at each r (k,) the intervals of each branch, and what is taken."""

        def look(part: FloatArray) -> list[_Look]:
            arcs, x = self.domain.sample(part), self.domain.path(part)
            gone = [taken(self.domain.self_motion, x, arcs[branch], branch) for branch in self.branches]
            return [
                _Look([arcs[branch].runs(k) for branch in self.branches], [mine[k] for mine in gone])
                for k in range(len(part))
            ]

        if self.domain.unconstrained.self_motion.has_structure:  # quick all at once
            return look(r) if len(r) else []
        parts = np.array_split(r, -(-len(r) // _PART)) if len(r) else []
        with ThreadPoolExecutor(os.cpu_count()) as pool:  # most of the time is spent in kernels that do not hinder it
            return [here for found in pool.map(look, parts) for here in found]


class _Look(NamedTuple):
    """What is seen at one place: per branch the intervals, and what constraints beyond joint limits take."""

    runs: list[list[Run]]
    taken: list[list[Run]]


def _met(here: _Look) -> list[list[str]]:
    """Return what is met on every branch."""
    return [sorted(met(run.causes[0][0]) for run in runs) for runs in here.taken]


def _kinds(here: list[list[Run]]) -> list[list[Causes]]:
    """Return what the intervals of every branch are ended by, in an order that does not depend on where u begins."""
    return [[run.causes for run in _by_ends(runs)] for runs in here]


def _by_ends(runs: list[Run]) -> list[Run]:
    """Return runs in an order that does not depend on where u begins, but for those with the same ends."""
    return sorted(runs, key=lambda run: run.causes)


def _moved(before: list[list[Run]], now: list[list[Run]]) -> float:
    """Return how far the ends of the same intervals have moved, at most."""
    pairs = [
        (a, b) for one, two in zip(before, now, strict=True) for a, b in zip(_by_ends(one), _by_ends(two), strict=True)
    ]
    full = [a.high - a.low >= TAU for a, _ in pairs]
    ends = [(b.low - a.low, b.high - a.high) for (a, b), skip in zip(pairs, full, strict=True) if not skip]
    return float(np.abs(wrap(np.array(ends))).max(initial=0.0))
