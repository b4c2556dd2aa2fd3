"""Proofs that no continuous motion exists: boxes through which every motion would have to pass, and no chain of them.

The path is cut into slabs, and all feasible postures of a slab are in boxes of joint angles. A motion inside a slab
goes on from box to box where they overlap, since boxes are closed and cover it; where it leaves the slab it is in a box
of either side. So every motion from one end to the other follows a chain of overlapping boxes with r never descending.
A box on no such chain is of no use to any motion and is dropped; where none is left it is proved that none exists.

What is looked at more closely is where chains pay least: a box with something outside the limits in it costs its
radius, others nothing, and going on along the path costs no more than what is usual for slabs of that width. So the
cheapest chains cross a forbidden strip where the boxes are still too large to see it, and there alone slabs are halved
and boxes split. That is a choice of where to look, not a part of the proof.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms.slabs import Boxes, SlabCover

_SIZE = 0.3  # radius of boxes at the beginning [rad]
_FINER = 0.5  # what a look multiplies the radius by
_NEAR_LEAST = 0.25  # radii of a box by which the chains through it may be dearer than the cheapest to be looked at
_CLEAR = (
    0.03  # boxes without anything outside the limits, this small, overlap because their postures are connected [rad]
)
_FINEST = 1e-9  # narrowest slab, and smallest box where no slab is narrower [rad]
_MOST_BOXES = 3_000_000


@dataclass(frozen=True)
class Ends:
    """What a motion may begin or end with: any posture, or the postures `q` (m, n) within `tolerance` [rad].

    Joints of which `modulo` (n,) is true may have any number of turns.
    """

    q: FloatArray | None = None
    tolerance: float = 0.0
    modulo: BoolArray | None = None

    def among(self, boxes: Boxes, wraps: BoolArray) -> BoolArray:
        """Return which boxes hold one of the postures, shape (m,)."""
        found = np.full(len(boxes), self.q is None)
        wraps = wraps if self.modulo is None else wraps | self.modulo
        for posture in () if self.q is None else self.q:
            found |= boxes.contain(posture, wraps, self.tolerance)
        return found


@dataclass
class Slab:
    """Boxes that a motion may still pass while r is in [low, high], and what chains from either end pay to get there.

    Attributes
    ----------
    low, high : float
    boxes : Boxes
    forward, backward : array, shape (m,)
        Least cost of a chain from the start and from the end; infinite where there is none.
    """

    low: float
    high: float
    boxes: Boxes
    forward: FloatArray = field(default_factory=lambda: np.empty(0))
    backward: FloatArray = field(default_factory=lambda: np.empty(0))

    @cached_property
    def radius(self) -> FloatArray:
        """The boxes' largest radii, shape (m,) [rad]."""
        return np.asarray(0.5 * (self.boxes.high - self.boxes.low).max(axis=1, initial=0.0))

    @cached_property
    def toll(self) -> FloatArray:
        """What chains pay to get from box to box: the radius of those with something that may be outside the limits."""
        return np.where(self.boxes.clean, 0.0, self.radius)

    @property
    def through(self) -> FloatArray:
        """Least cost of a chain from start to end through each box."""
        return self.forward + self.backward

    def kept(self) -> Slab:
        """Return the slab with the boxes only that chains from start to end pass."""
        rows = np.isfinite(self.forward + self.backward)
        return Slab(self.low, self.high, self.boxes[rows], self.forward[rows], self.backward[rows])


@dataclass(frozen=True)
class ChainProof:
    """What became of an attempt to prove that no motion exists.

    Attributes
    ----------
    proved : bool
    stopped : str
        ``"proved"``, ``"time"``, ``"budget"``, or ``"clear"``: chains are left whose boxes are small and have nothing
        outside the limits, so that a motion most likely exists.
    latest, earliest : float
        If proved: of the boxes that are left those beyond `latest` have no chain from the start, those before
        `earliest` none to the end.
    resolution : float
        Width of the narrowest slab.
    boxes : int
        How many were looked at.
    rounds : int
        How often.
    """

    proved: bool
    stopped: str
    latest: float
    earliest: float
    resolution: float
    boxes: int
    rounds: int


class Chains:
    """The slabs between two places of the path, and the boxes that motions between them may pass.

    Parameters
    ----------
    cover : SlabCover
    low, high : float
        The part of the path that is looked at.
    start, end : Ends, optional
        What motions may begin and end with there; anything by default.
    deadline : float
        As :func:`time.perf_counter` tells it; what is not covered by then never is.
    """

    def __init__(
        self,
        cover: SlabCover,
        low: float = 0.0,
        high: float = 1.0,
        start: Ends | None = None,
        end: Ends | None = None,
        deadline: float = np.inf,
    ) -> None:
        self.cover, self.start, self.end = cover, start or Ends(), end or Ends()
        self.looked_at, self.rounds, self.calm = 0, 0, _SIZE
        self._begun_with = cover.slabs
        edges = np.linspace(low, high, self._begun_with + 1)
        # At the ends there are slabs without thickness: what a motion begins and ends with.
        pairs = [(low, low), *zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True), (high, high)]
        self.slabs: list[Slab] = []
        self.covered = True
        for pair in pairs:
            self.covered = self.covered and time.perf_counter() <= deadline
            if self.covered:
                self.slabs.append(self._slab(*pair, cover.boxes(*pair, _SIZE)))

    def prove(self, deadline: float = np.inf, budget: int = _MOST_BOXES) -> ChainProof:
        """Look ever more closely until no chain is left, or time or budget are spent.

        Parameters
        ----------
        deadline : float
            As :func:`time.perf_counter` tells it.
        budget : int
            Boxes to be looked at.

        Returns
        -------
        ChainProof
        """
        if not self.covered:
            return ChainProof(False, "time", 1.0, 0.0, 1.0 / self._begun_with, self.looked_at, 0)
        while True:
            self._measure()
            kept = [slab.kept() for slab in self.slabs]
            if not all(len(slab.boxes) for slab in kept):
                return self._result("proved")
            self.slabs = kept
            least = min(float(slab.through.min()) for slab in kept)
            if least == 0.0 and self.calm < _CLEAR:
                return self._result("clear")
            if time.perf_counter() > deadline:
                return self._result("time")
            if self.looked_at > budget or not self._refine(least):
                return self._result("budget")

    def _result(self, stopped: str) -> ChainProof:
        latest = max((slab.high for slab in self.slabs if np.isfinite(slab.forward).any()), default=self.slabs[0].low)
        earliest = min(
            (slab.low for slab in self.slabs if np.isfinite(slab.backward).any()), default=self.slabs[-1].high
        )
        narrowest = min(slab.high - slab.low for slab in self.slabs[1:-1])
        return ChainProof(stopped == "proved", stopped, latest, earliest, narrowest, self.looked_at, self.rounds)

    def _slab(self, low: float, high: float, boxes: Boxes) -> Slab:
        self.looked_at += len(boxes)
        return Slab(low, high, boxes)

    def _usual(self, slab: Slab) -> float:
        """Return the radius of boxes that is usual in slabs of this width."""
        return _SIZE * self._begun_with * (slab.high - slab.low) / (self.slabs[-1].high - self.slabs[0].low)

    def _measure(self) -> None:
        """Find what chains from either end pay to get to each box."""
        from selfmotion.certificate._chain_kernels import cross, settle  # compiled: only where used

        wraps = self.cover.wraps
        for slabs, name, ends in ((self.slabs, "forward", self.start), (self.slabs[::-1], "backward", self.end)):
            before: Slab | None = None
            for slab in slabs:
                boxes, toll = slab.boxes, slab.toll
                if before is None:
                    cost = np.where(ends.among(boxes, wraps), 0.0, np.inf)
                else:
                    cost, other = np.full(len(boxes), np.inf), before.boxes
                    fee, to_fee = (np.minimum(part.toll, self._usual(part)) for part in (before, slab))
                    paid: FloatArray = getattr(before, name)
                    cross(other.low, other.high, fee, paid, boxes.low, boxes.high, to_fee, wraps, cost)
                settle(boxes.low, boxes.high, toll, wraps, cost)
                setattr(slab, name, cost)
                before = slab

    def _refine(self, least: float) -> bool:
        """Look more closely at what the cheapest chains pass; return whether anything could be."""
        self.rounds += 1
        if least == 0.0:
            self.calm *= _FINER
        slabs: list[Slab] = []
        refined = False
        for slab in self.slabs:
            radius, clean = slab.radius, slab.boxes.clean
            hot = slab.through <= least + _NEAR_LEAST * np.minimum(slab.toll, self._usual(slab))
            hot &= clean & (radius > self.calm) if least == 0.0 else ~clean
            if slab.high == slab.low:  # an end of the path: boxes alone can be smaller
                hot &= radius > _FINEST
            if not hot.any() or 0.0 < slab.high - slab.low < _FINEST:
                slabs.append(slab)
                continue
            refined = True
            size = np.where(hot, _FINER * radius, 2.0 * radius)
            middle = 0.5 * (slab.low + slab.high)
            pairs = [(slab.low, middle), (middle, slab.high)] if slab.high > slab.low else [(slab.low, slab.high)]
            slabs += [self._slab(*pair, self.cover.split(*pair, slab.boxes, size)) for pair in pairs]
        self.slabs = slabs
        return refined
