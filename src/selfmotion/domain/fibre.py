"""The self-motion at one task point: intervals per branch, what bounds them, and which of them hang together.

An interval is named by the breakpoints at its ends. While the tool moves these names do not change, until an event. So
intervals are followed along a path by name, not by nearness.

Joints limited on both sides to 2π or more carry their number of turns with them: two postures are on one interval only
if the joint gets from one to the other inside its limits. Joints that are limited to three turns or more, or on one
side only, are taken to be free, as along one path they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations, product

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause, SelfMotion
from selfmotion.domain.feasible import ArcsAtPoint, feasible_arcs

# Constraints on one joint that differ by less, modulo 2π, are one constraint with two names [rad].
_SAME_ANGLE = 1e-12
_MOST_TURNS = 3.0
# Where beside a breakpoint a joint is looked at to count its turns, as a part of the arc.
_BESIDE = 1e-4

Turns = tuple[int, ...]
End = tuple[int, ...]
"""The breakpoints, as indices of columns, that stand at an end of an interval."""
_Angles = Callable[[FloatArray, int], FloatArray]
Name = tuple[int, tuple[End, End], Turns]
"""Branch, ends and turns of an interval: what stays the same between two events."""


@dataclass(frozen=True)
class Interval:
    """Feasible parameters on one branch, as far as one can go inside the limits.

    Attributes
    ----------
    branch : int
    low, high : float
        Ends in u [rad]; ``low`` in [−π, π], ``high ≥ low``, more than a turn away where turns are counted.
    ends : tuple
        What stands at ``low`` and at ``high``: indices of the arm's breakpoints. Empty for the full circle.
    turns : tuple of int
        Turns, at ``low``, of each joint that is limited to 2π or more; a circle begins where they are fewest.
    arcs : tuple
        Per arc between breakpoints its (low, high, turns), in order.
    """

    branch: int
    low: float
    high: float
    ends: tuple[End, End]
    turns: Turns
    arcs: tuple[tuple[float, float, Turns], ...]

    @property
    def name(self) -> Name:
        """What stays the same between two events."""
        return self.branch, self.ends, self.turns

    @property
    def is_circle(self) -> bool:
        """Whether one may go round and round."""
        return not self.ends[0]

    def contains(self, u: float, turns: Turns | None = None, tolerance: float = 0.0) -> bool:
        """Return whether direction `u`, with these turns if given, is inside."""
        for low, high, here in self.arcs:
            lifted = u + TAU * np.ceil((low - tolerance - u) / TAU)
            if lifted <= high + tolerance and (turns is None or turns == here):
                return True
        return False


@dataclass(frozen=True)
class Fibre:
    """The self-motion at one task point.

    Attributes
    ----------
    intervals : tuple of Interval
        In the order of their names.
    component : tuple of int
        Per interval the connected part of the self-motion that it belongs to: intervals on two branches hang together
        where both end at the same fold.
    causes : tuple of Cause
        Per breakpoint index, why it is one.
    u : array, shape (m,)
        Per breakpoint index its parameter, NaN where it has none.
    turning : array of int, shape (t,)
        The joints whose turns are counted.
    joints : callable
        Maps u, shape (...), and a branch to joint angles modulo 2π, shape (..., n).
    turn_angles : callable
        Maps the same to the angles, from its lower limit on, of each joint whose turns are counted [rad]: the real
        angle is this plus 2π times the turns.
    """

    intervals: tuple[Interval, ...]
    component: tuple[int, ...]
    causes: tuple[Cause, ...]
    u: FloatArray
    turning: IntArray
    joints: _Angles = field(repr=False, compare=False)
    turn_angles: _Angles = field(repr=False, compare=False)

    def turns_of(self, q: FloatArray, u: float, branch: int) -> Turns:
        """Return the turns of the posture with joint angles `q`, shape (n,), at direction `u`."""
        start, turning = self.turn_angles(np.array([u]), branch)[0], self.turning
        return tuple(int(k) for k in np.rint((q[turning] - start) / TAU))

    @property
    def n_components(self) -> int:
        """Number of connected parts."""
        return len(set(self.component))

    @property
    def names(self) -> frozenset[Name]:
        """The names of all intervals: equal for two task points with the same structure."""
        return frozenset(interval.name for interval in self.intervals)


def fibres(self_motion: SelfMotion, x: FloatArray, branches: Sequence[int] | None = None) -> list[Fibre]:
    """Return the self-motion at task points.

    Parameters
    ----------
    self_motion : SelfMotion
    x : array, shape (k, 2)
        Task points.
    branches : sequence of int, optional
        Branches that may be used; all by default.

    Returns
    -------
    list of Fibre
        One per task point.
    """
    arcs = feasible_arcs(self_motion, x, exact=True)
    limits = self_motion.limits
    span = limits.upper - limits.lower
    turning = np.flatnonzero((span >= TAU * (1 - 1e-12)) & (span < _MOST_TURNS * TAU))
    lower = limits.lower[turning]

    def at(k: int) -> Fibre:
        def joints(u: FloatArray, branch: int) -> FloatArray:
            q, _ = self_motion.solve(self_motion.pose(x[k : k + 1]), u.reshape(1, -1), branch)
            return q.reshape(*u.shape, self_motion.n)

        def turn_angles(u: FloatArray, branch: int) -> FloatArray:
            return lower + np.mod(joints(u, branch)[..., turning] - lower, TAU)

        mine = {b: arcs[b].at(k) for b in (range(len(arcs)) if branches is None else branches)}
        return _fibre(mine, turning, joints, turn_angles, limits.upper[turning])

    return [at(k) for k in range(len(x))]


def _fibre(
    arcs: dict[int, ArcsAtPoint], turning: IntArray, joints: _Angles, turn_angles: _Angles, upper: FloatArray
) -> Fibre:
    causes = next(iter(arcs.values())).causes
    u = np.full(len(causes), np.nan)
    lines: list[_Line] = []
    points: dict[End, Interval] = {}
    for branch, mine in arcs.items():
        u[mine.columns] = mine.low
        joined = _Branch(branch, mine, turn_angles, upper)
        lines += joined.lines()
        for point in joined.points():  # the same posture may be found on two branches
            points.setdefault(point.ends[0], point)
    at_ends = {column for line in lines for end in line.interval.ends for column in end}
    nothing = np.empty(0)
    alone = [point for end, point in points.items() if not at_ends & set(end)]
    lines += [_Line(point, ((), ()), (nothing, nothing)) for point in alone]
    lines.sort(key=lambda line: line.interval.name)
    return Fibre(tuple(line.interval for line in lines), _components(lines), causes, u, turning, joints, turn_angles)


@dataclass(frozen=True)
class _Line:
    """An interval with the turns at both ends and the angles, seam at the lower limit, that they count from."""

    interval: Interval
    turns: tuple[Turns, Turns]
    angles: tuple[FloatArray, FloatArray]


class _Branch:
    """One branch at one task point, its arcs joined to intervals."""

    def __init__(self, branch: int, arcs: ArcsAtPoint, turn_angles: _Angles, upper: FloatArray) -> None:
        self.branch = branch
        self.arcs = arcs
        self.groups = _groups(arcs)
        self.ends: list[End] = [_end(arcs, group) for group in self.groups]
        last = [group[-1] for group in self.groups]
        self.low, self.high, self.inside = arcs.low[last], arcs.high[last], arcs.inside[last].tolist()
        self.options: list[list[Turns]] = [[()] if inside else [] for inside in self.inside]
        self.angles = np.zeros((len(last), 2, 0))
        self.steps = np.zeros((len(last), 0), dtype=int)
        if len(upper) and any(self.inside):
            self._count_turns(turn_angles, upper)

    def _count_turns(self, turn_angles: _Angles, upper: FloatArray) -> None:
        """Find the turns that each arc allows, and how they go on from arc to arc."""
        parts = np.array([_BESIDE, 0.5, 1 - _BESIDE])
        angle = turn_angles(self.low[:, None] + (self.high - self.low)[:, None] * parts, self.branch)
        most = np.floor((upper - angle[:, 1]) / TAU + 1e-12).astype(int)
        self.options = [
            list(product(*(range(n + 1) for n in row))) if mine else []
            for row, mine in zip(most, self.options, strict=True)
        ]
        self.angles = angle[:, ::2]
        self.steps = np.rint((self.angles[:, 1] - np.roll(self.angles[:, 0], -1, axis=0)) / TAU).astype(int)

    def lines(self) -> Iterator[_Line]:
        """Give the intervals: arcs that follow each other with the same real joint angles."""
        count = len(self.low)
        following = {}
        for arc in range(count):
            for turns in self.options[arc]:
                after = (arc + 1) % count, tuple(int(t + s) for t, s in zip(turns, self.steps[arc], strict=True))
                if after[1] in self.options[after[0]]:
                    following[arc, turns] = after
        nodes = {(arc, turns) for arc in range(count) for turns in self.options[arc]}
        starts = sorted(nodes - set(following.values()))
        while nodes:
            # A circle begins where turns are fewest, so that its name does not depend on u.
            first = starts.pop(0) if starts else min(nodes, key=lambda node: (node[1], node[0]))
            run = [first]
            while run[-1] in following and following[run[-1]] != first:
                run.append(following[run[-1]])
            nodes -= set(run)
            yield self._line(run, circle=following.get(run[-1]) == first)

    def points(self) -> Iterator[Interval]:
        """Give the feasible postures that no feasible arc touches, as intervals of width zero."""
        for k, group in enumerate(self.groups):
            if not self.inside[k] and not self.inside[k - 1] and np.isfinite(self.arcs.points[group]).any():
                u, end = float(self.arcs.low[group[0]]), self.ends[k]
                yield Interval(self.branch, u, u, (end, end), (), ((u, u, ()),))

    def _line(self, run: list[tuple[int, Turns]], circle: bool) -> _Line:
        first, last = run[0], run[-1]
        arcs, high = [], self.low[first[0]]
        for arc, turns in run:
            low = high
            high = low + self.high[arc] - self.low[arc]
            arcs.append((float(low), float(high), turns))
        ends = ((), ()) if circle else (self.ends[first[0]], self.ends[(last[0] + 1) % len(self.low)])
        interval = Interval(self.branch, arcs[0][0], arcs[-1][1], ends, first[1], tuple(arcs))
        return _Line(interval, (first[1], last[1]), (self.angles[first[0], 0], self.angles[last[0], 1]))


def _groups(arcs: ArcsAtPoint) -> list[list[int]]:
    """Return the breakpoints in order, those together that are one solution of a constraint with several names."""
    identity = _identities(arcs.causes)
    groups: list[list[int]] = []
    for k, column in enumerate(arcs.columns.tolist()):
        if groups and identity[arcs.columns[groups[-1][-1]]] == identity[column]:
            groups[-1].append(k)
        else:
            groups.append([k])
    if len(groups) > 1 and identity[arcs.columns[groups[-1][-1]]] == identity[arcs.columns[0]]:
        groups[0] = groups.pop() + groups[0]
    return groups


@lru_cache(maxsize=256)
def _identities(causes: tuple[Cause, ...]) -> list[int]:
    """Number the columns, with one number for the same solution of constraints that are the same modulo 2π."""
    known: list[tuple[Cause, int]] = []
    result = []
    seen: dict[Cause, int] = {}
    for cause in causes:
        solution = seen[cause] = seen.get(cause, -1) + 1
        for k, (other, other_solution) in enumerate(known):
            equal = cause.joint == other.joint and abs(wrap(cause.value - other.value)) <= _SAME_ANGLE
            if equal and solution == other_solution:
                result.append(k)
                break
        else:
            result.append(len(known))
            known.append((cause, solution))
    return result


def _end(arcs: ArcsAtPoint, group: list[int]) -> End:
    """Return the columns of a group without mere markers."""
    return tuple(sorted(column for column in arcs.columns[group].tolist() if arcs.causes[column].joint >= 0))


def _components(lines: list[_Line]) -> tuple[int, ...]:
    """Number the connected parts: two ends at one breakpoint are one posture, if their turns agree too."""
    label = list(range(len(lines)))
    at: dict[int, list[tuple[int, int]]] = {}
    for k, line in enumerate(lines):
        for side in (0, 1):
            for column in line.interval.ends[side]:
                at.setdefault(column, []).append((k, side))
    for meeting in at.values():
        for (a, side_a), (b, side_b) in combinations(meeting, 2):
            if lines[a].interval.branch == lines[b].interval.branch:
                continue
            shift = np.rint((lines[a].angles[side_a] - lines[b].angles[side_b]) / TAU)
            if np.array_equal(np.array(lines[a].turns[side_a]) + shift, np.array(lines[b].turns[side_b])):
                old, new = label[b], label[a]
                label = [new if value == old else value for value in label]
    numbers = {value: k for k, value in enumerate(dict.fromkeys(label))}
    return tuple(numbers[value] for value in label)
