"""The structure of the angle domain along a path: cells of equal structure, events between them, connected parts.

The self-motion keeps its structure except where the path crosses a zero of the arm's separators. So those places cut
the path into cells; one look inside each tells the structure of all of it. For an arm that knows no separators looks
along the path are compared instead, and changes between two of them bisected.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, pairwise, product
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause, FreeJoint, SelfMotion
from selfmotion.domain.crossings import crossings
from selfmotion.domain.events import Change, Event, changes, joined
from selfmotion.domain.fibre import Fibre, Name, fibres
from selfmotion.intervals import IntervalSet
from selfmotion.paths import Path

# Events nearer to each other than this are one event.
_SAME_EVENT = 1e-8
# Where in a cell its structure is looked at: not in the middle, where symmetric paths touch what they do not cross.
_LOOK = 0.4237
# Distance from an event at which what is beside it is compared; less, in parts of a cell, if cells are short.
_BESIDE = 1e-7
_MOST_BESIDE = 0.25
_PIECES = 16
# Near a singular posture the free joint swings fast; what comes this near to one of its angles touches it [rad].
_NEAR_FREE = 3e-3
_GRID = 400  # looks along the path for an arm without separators
_FINEST = 1e-12


@dataclass(frozen=True)
class Cell:
    """A part of the path on which the self-motion has one structure.

    Attributes
    ----------
    r : tuple of float
    look : float
        Where inside the self-motion was looked at.
    fibre : Fibre
        The self-motion there.
    sheets : tuple of int
        Per component of the fibre, the sheet that it belongs to.
    """

    r: tuple[float, float]
    look: float
    fibre: Fibre
    sheets: tuple[int, ...] = ()


@dataclass(frozen=True)
class Sheet:
    """A connected part of the self-motion, followed along the path as long as it neither joins another nor parts.

    An edge of the Reeb graph of r on the angle domain.

    Attributes
    ----------
    r : tuple of float
    before, after : tuple of int
        The sheets that a motion may come from at its beginning and go on to at its end.
    component : int
        The connected part of the whole angle domain that it belongs to.
    """

    r: tuple[float, float]
    before: tuple[int, ...]
    after: tuple[int, ...]
    component: int


class DomainStructure:
    """The structure of the angle domain along a path.

    Parameters
    ----------
    self_motion : SelfMotion
    path : Path
    branches : sequence of int, optional
        Branches that may be used; all by default.

    Attributes
    ----------
    cells : tuple of Cell
        In the order of the path.
    events : tuple of Event
        In the order of the path.
    sheets : tuple of Sheet
        In the order of their beginning.

    Notes
    -----
    Events are found where they last longer than 1e-8 in r. Where a joint is free at one posture, sheets are joined by
    turning it; where joints' turns are counted as well, that way is left out.
    """

    def __init__(self, self_motion: SelfMotion, path: Path, branches: Sequence[int] | None = None) -> None:
        self.self_motion = self_motion
        self.path = path

        def look(r: FloatArray) -> list[Fibre]:
            return fibres(self_motion, path(r), branches)

        self._look = look
        cells, self._cuts = _cells(self_motion, path, look)
        at = self_motion.breakpoints(self_motion.pose(path(np.array([cut.r for cut in self._cuts])))).u
        beside = _beside(look, cells)
        self._changes = [
            _through_free_joint(cut.free, pair, changes(cut.r, *pair, u))
            for cut, pair, u in zip(self._cuts, beside, at, strict=True)
        ]
        self.sheets, parts = _sheets(cells, self._changes)
        self.cells = tuple(replace(cell, sheets=mine) for cell, mine in zip(cells, parts, strict=True))
        self.events = self._all_events()

    @property
    def n_components(self) -> int:
        """Number of connected parts of the whole angle domain."""
        return len({sheet.component for sheet in self.sheets})

    def cell_at(self, r: float) -> Cell:
        """Return the cell that path parameter `r` lies in."""
        return self.cells[min(int(np.searchsorted([cell.r[1] for cell in self.cells], r)), len(self.cells) - 1)]

    def sheet_at(
        self, r: float, u: float, branch: int, tolerance: float = 1e-9, q: FloatArray | None = None
    ) -> tuple[int, ...]:
        """Return the sheets that a posture lies on.

        Parameters
        ----------
        r, u : float
        branch : int
        tolerance : float
            Distance outside an interval that is forgiven [rad].
        q : array, shape (n,), optional
            The joint angles, whose turns then choose between sheets.

        Returns
        -------
        tuple of int
            Empty where the posture is not feasible; several where joints may have several numbers of turns.
        """
        cell = self.cell_at(r)
        (here,) = self._look(np.array([r]))
        known = {interval.name: k for k, interval in enumerate(cell.fibre.intervals)}
        turns = None if q is None else here.turns_of(q, u, branch)
        found = [
            cell.sheets[cell.fibre.component[known[interval.name]]]
            for interval in here.intervals
            if interval.branch == branch and interval.name in known and interval.contains(u, turns, tolerance)
        ]
        return tuple(dict.fromkeys(found))

    @cached_property
    def reachable(self) -> tuple[frozenset[int], ...]:
        """Per sheet, the sheets that a motion on it can get to as r grows, itself included."""
        onward: dict[int, frozenset[int]] = {}
        for k in sorted(range(len(self.sheets)), key=lambda k: -self.sheets[k].r[0]):
            onward[k] = frozenset({k}).union(*(onward[j] for j in self.sheets[k].after))
        return tuple(onward[k] for k in range(len(self.sheets)))

    @property
    def is_connected(self) -> bool:
        """Whether some sheet at r = 0 leads on to r = 1."""
        last = {k for k, sheet in enumerate(self.sheets) if sheet.r[1] >= 1.0}
        return any(last & self.reachable[k] for k, sheet in enumerate(self.sheets) if sheet.r[0] <= 0.0)

    @property
    def dead_end(self) -> tuple[float, tuple[Cause, ...]] | None:
        """Where the last part that leads on from r = 0 dies, and why; None if it leads to r = 1."""
        if self.is_connected:
            return None
        return self.farthest(k for k, sheet in enumerate(self.sheets) if sheet.r[0] <= 0.0)

    def farthest(self, sheets: Iterable[int]) -> tuple[float, tuple[Cause, ...]]:
        """Return how far along the path a motion gets from any of `sheets`, and what ends it there."""
        r = max((self.sheets[j].r[1] for k in sheets for j in self.reachable[k]), default=0.0)
        dying = [event.causes for event in self.events if event.r == r and event.kind == _ENDINGS[0]]
        return r, tuple(dict.fromkeys(chain.from_iterable(dying)))

    def _all_events(self) -> tuple[Event, ...]:
        events: list[Event] = []
        for k, (r, free) in enumerate(self._cuts):
            here = [event for change in self._changes[k] for event in change.events]
            if free is not None:
                here.append(Event(r, "singular", float(wrap(free.u)), None, ()))
            events += dict.fromkeys(here + self._component_events(k, r))
        return tuple(events)

    def _component_events(self, k: int, r: float) -> list[Event]:
        """Return what happens to connected parts between cells k and k + 1."""
        found = []
        for cell, side in ((self.cells[k + 1], "after"), (self.cells[k], "before")):
            for part, number in enumerate(cell.sheets):
                sheet = self.sheets[number]
                at, others = (sheet.r[0], sheet.before) if side == "after" else (sheet.r[1], sheet.after)
                touching = [
                    event
                    for change in self._changes[k]
                    if any(cell.fibre.component[j] == part for j in getattr(change, side))
                    for event in change.events
                ]
                if at != r or len(others) == 1 or not touching:
                    continue
                kinds = ("component appears", "components join") if side == "after" else _ENDINGS
                causes = tuple(dict.fromkeys(chain.from_iterable(event.causes for event in touching)))
                found.append(Event(r, kinds[bool(others)], touching[0].u, None, causes))
        return found


_ENDINGS = ("component dies", "component parts")
_Look = Callable[[FloatArray], list[Fibre]]
_Node = tuple[int, int]
"""A cell and a component of its fibre."""


class _Cut(NamedTuple):
    """A place where the structure may change, and the joint that is free there, if any."""

    r: float
    free: FreeJoint | None = None


def _cells(self_motion: SelfMotion, path: Path, look: _Look) -> tuple[list[Cell], list[_Cut]]:
    """Return the cells of equal structure, and the cuts between them."""

    def values(r: FloatArray) -> FloatArray:
        return self_motion.separators(self_motion.pose(path(r)))

    if len(self_motion.singular):
        found = crossings(values, path.grid(_PIECES))
        free = [
            self_motion.free_joint(self_motion.pose(path(np.array([r])))) if self_motion.singular[function] else None
            for r, function in zip(found.r, found.function, strict=True)
        ]
        cuts = _clustered([_Cut(float(r), joint) for r, joint in zip(found.r, free, strict=True)])
    else:
        cuts = _compared(look, path.grid(_GRID))
    edges = [0.0, *(cut.r for cut in cuts), 1.0]
    looks = [low + _LOOK * (high - low) for low, high in pairwise(edges)]
    parts = [Cell(*found) for found in zip(pairwise(edges), looks, look(np.array(looks)), strict=True)]
    cells, kept = parts[:1], []
    for cut, part in zip(cuts, parts[1:], strict=True):
        if part.fibre.names == cells[-1].fibre.names and cut.free is None and not len(part.fibre.turning):
            cells[-1] = replace(cells[-1], r=(cells[-1].r[0], part.r[1]))
        else:
            kept.append(cut)
            cells.append(part)
    return cells, kept


def _compared(look: _Look, r: FloatArray) -> list[_Cut]:
    """Return where the structure changes along a grid, bisected."""

    def names(r: FloatArray) -> list[frozenset[Name]]:
        return [fibre.names for fibre in look(r)]

    known = names(r)
    cuts = []
    for k in range(len(r) - 1):
        low, high, at_high = r[k], r[k + 1], known[k + 1]
        at_low = known[k]
        while at_low != at_high and high - low > _FINEST:  # of several changes the first, then the next
            left, right, at_right = low, high, at_high
            while right - left > _FINEST:
                middle = 0.5 * (left + right)
                (here,) = names(np.array([middle]))
                left, right, at_right = (middle, right, at_right) if here == at_low else (left, middle, here)
            cuts.append(_Cut(0.5 * (left + right)))
            low, at_low = right, at_right
    return _clustered(cuts)


def _beside(look: _Look, cells: list[Cell]) -> list[tuple[Fibre, Fibre]]:
    """Return the fibres on both sides of each event, as near to it as they still have their cell's structure."""
    edges = [(cell, at, sign) for pair in pairwise(cells) for cell, at, sign in zip(pair, (1, 0), (-1, 1), strict=True)]
    most = np.array([_MOST_BESIDE * (cell.r[1] - cell.r[0]) for cell, _, _ in edges])
    start = np.array([cell.r[at] for cell, at, _ in edges])
    sign = np.array([sign for _, _, sign in edges])
    found = [cell.fibre for cell, _, _ in edges]
    step, wanted = np.minimum(_BESIDE, most), np.arange(len(edges))
    while len(wanted):
        near = look(start[wanted] + sign[wanted] * step[wanted])
        for k, fibre in zip(wanted, near, strict=True):
            if fibre.names == found[k].names:
                found[k], step[k] = fibre, np.inf
        step *= 10.0
        wanted = np.flatnonzero(step <= most)
    return list(zip(found[::2], found[1::2], strict=True))


def _clustered(cuts: list[_Cut]) -> list[_Cut]:
    """Return `cuts` in order, those that cannot be told apart as one, none at the path's ends."""
    result: list[_Cut] = []
    for cut in sorted(cuts, key=lambda cut: cut.r):
        if result and cut.r - result[-1].r <= _SAME_EVENT:
            result[-1] = _Cut(result[-1].r, result[-1].free or cut.free)
        elif _SAME_EVENT < cut.r < 1 - _SAME_EVENT:
            result.append(cut)
    return result


def _through_free_joint(free: FreeJoint | None, pair: tuple[Fibre, Fibre], found: list[Change]) -> list[Change]:
    """Join what is joined by turning a free joint: the intervals that come near to the same run of its angles."""
    if free is None or any(interval.turns for fibre in pair for interval in fibre.intervals):
        return found
    offsets = np.logspace(-12, -4, 41)
    u = free.u + np.concatenate([-offsets[::-1], offsets])
    together: list[set[int]] = [set() for _ in free.angles.intervals]
    for fibre, side in zip(pair, ("before", "after"), strict=True):
        for j, interval in enumerate(fibre.intervals):
            near = u[[interval.contains(value) for value in u]]
            angles = fibre.joints(near, interval.branch)[:, free.joint]
            (change,) = (k for k, change in enumerate(found) if j in getattr(change, side))
            for run, (low, high) in enumerate(free.angles):
                if IntervalSet([(low, high)], TAU).contains(angles, _NEAR_FREE).any():
                    together[run].add(change)
    return joined(found, [group for group in together if group])


def _sheets(cells: list[Cell], found: list[list[Change]]) -> tuple[tuple[Sheet, ...], list[tuple[int, ...]]]:
    """Follow the fibres' components from cell to cell; return the sheets and, per cell, those of its components."""
    nodes = [(k, part) for k, cell in enumerate(cells) for part in cell.fibre.component]
    onward: dict[_Node, set[_Node]] = {node: set() for node in nodes}
    back: dict[_Node, set[_Node]] = {node: set() for node in onward}
    for k, here in enumerate(found):
        left, right = cells[k].fibre.component, cells[k + 1].fibre.component
        for change in here:
            for one, two in product(change.before, change.after):
                onward[k, left[one]].add((k + 1, right[two]))
                back[k + 1, right[two]].add((k, left[one]))
    runs: list[list[_Node]] = []
    run_of: dict[_Node, int] = {}
    for node in sorted(onward):
        sources = list(back[node])
        if len(sources) == 1 and len(onward[sources[0]]) == 1:
            run_of[node] = run_of[sources[0]]
            runs[run_of[node]].append(node)
        else:
            run_of[node] = len(runs)
            runs.append([node])
    before = [tuple(sorted({run_of[node] for node in back[run[0]]})) for run in runs]
    after = [tuple(sorted({run_of[node] for node in onward[run[-1]]})) for run in runs]
    component = _connected(after)
    sheets = tuple(
        Sheet((cells[run[0][0]].r[0], cells[run[-1][0]].r[1]), before[k], after[k], component[k])
        for k, run in enumerate(runs)
    )
    parts = [tuple(run_of[k, part] for part in range(cell.fibre.n_components)) for k, cell in enumerate(cells)]
    return sheets, parts


def _connected(after: list[tuple[int, ...]]) -> list[int]:
    """Number the connected parts of a graph given by each node's successors."""
    label = list(range(len(after)))
    for node, successors in enumerate(after):
        for other in successors:
            old, new = label[other], label[node]
            label = [new if value == old else value for value in label]
    numbers = {value: k for k, value in enumerate(dict.fromkeys(label))}
    return [numbers[value] for value in label]
