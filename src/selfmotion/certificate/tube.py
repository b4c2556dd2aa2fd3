"""The tube: what is left of the angle domain for a motion cheaper than a threshold, slice by slice, ever finer."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.angles import TAU
from selfmotion.arms.cells import Cells, Cover
from selfmotion.arms.slabs import SlabCover
from selfmotion.certificate import _chord_kernels, _kernels, _proposal_kernels
from selfmotion.certificate._arrays import Arcs, Values
from selfmotion.certificate.connected import groups
from selfmotion.certificate.slices import SAME, Rows, Slice, joint_groups, leading_on, led_parts
from selfmotion.deadline import OutOfTimeError, in_time
from selfmotion.errors import InvalidInputError

_KINDS = {"joint_travel": _chord_kernels.TRAVEL, "l1": _chord_kernels.L1, "l2": _chord_kernels.L2}
_COARSE = 0.3  # spacing at which a new slice is looked at first [rad]
_ABOUT = 1.3  # of their spacing: longer cells are split
_THREADS = 2
_ROUNDING = 1e-12  # of angles [rad]
_FINER = 24.0  # what one look divides the spacing by


class Setting(NamedTuple):
    """All that the bound knows of the problem.

    Attributes
    ----------
    cover : Cover
        The arm.
    task : callable
        The path: maps r to the task point.
    objective : str
        Its kind.
    weights : array, shape (n,)
    breaks : array, shape (k,)
        Where the path is not smooth; slabs are best cut there.
    """

    cover: Cover
    task: Callable[[float], FloatArray]
    objective: str
    weights: FloatArray
    breaks: FloatArray = np.empty(0)

    def cut(self, low: float, high: float) -> float:
        """Return where to halve a slab: at the break nearest its middle, if one is in its middle half."""
        middle = 0.5 * (low + high)
        if not len(self.breaks):
            return middle
        nearest = float(self.breaks[np.abs(self.breaks - middle).argmin()])
        return nearest if abs(nearest - middle) < 0.25 * abs(high - low) else middle


class Tie(NamedTuple):
    """Start and end of a cyclic motion are one posture, near `anchor` (n,); `pull` (n,) are the multipliers of that."""

    anchor: FloatArray
    pull: FloatArray


@dataclass(frozen=True)
class Chain:
    """The cheapest chords through a tube: postures q (slices, n), and what of their values is not proved (slices,)."""

    r: FloatArray
    q: FloatArray
    lost: FloatArray


class Tube:
    """Slices of the angle domain in cells, and the values that are proved on them."""

    def __init__(self, setting: Setting, slices: list[Slice], tie: Tie | None = None) -> None:
        self.setting, self.slices, self.tie = setting, slices, tie

    @property
    def size(self) -> int:
        """Number of cells."""
        return sum(len(part.cells) for part in self.slices)

    @property
    def width(self) -> float:
        """How far apart the cells at the start may be, joint by joint at most [rad]."""
        cells = self.slices[0].cells
        middle = 0.5 * (cells.a + cells.b)
        return float((np.abs(self._apart(middle, middle[0])) + 0.5 * np.abs(cells.b - cells.a)).max())

    @property
    def is_empty(self) -> bool:
        """Whether some slice has no cells left, so that no motion passes."""
        return any(len(part.cells) == 0 for part in self.slices)

    @property
    def r(self) -> FloatArray:
        """The slices' path parameters."""
        return np.array([part.r for part in self.slices])

    def evaluate(self, deadline: float = np.inf) -> float:
        """Prove values from both ends; return the bound on every motion through the tube."""
        self.slices = leading_on(leading_on(self.slices)[::-1])[::-1]
        if self.is_empty:
            return np.inf
        first, last = self.slices[0], self.slices[-1]
        first.forward, last.backward = self._at_end(first, -1.0), self._at_end(last, 1.0)

        def forward() -> None:
            for one, two in pairwise(self.slices):
                two.forward = self._carried(one, one.forward, two, deadline)

        def backward() -> None:
            for one, two in pairwise(self.slices[::-1]):
                two.backward = self._carried(one, one.backward, two, deadline)

        _together([forward, backward])
        bound = 0.0
        for part in self.slices:
            part.least = self._least(part)
            bound = max(bound, float(part.least.min()))
        return bound

    def prune(self, threshold: float) -> None:
        """Drop the cells that no motion cheaper than `threshold` passes."""
        for k, part in enumerate(self.slices):
            assert part.least is not None
            self.slices[k] = part.below(threshold, part.least)

    def connect(self, slabs: SlabCover, deadline: float = np.inf) -> None:
        """Find out between which cells of neighbouring slices motions lead; drop what no motion passes.

        Parameters
        ----------
        slabs : SlabCover
        deadline : float
            Slabs that are not looked at by then stay as they were, as do those that take too many boxes.
        """
        for k in range(len(self.slices) - 1):
            one, two = self.slices[k], self.slices[k + 1]
            if not len(one.cells) or not len(two.cells):
                return
            try:
                after, before = groups(slabs, one.r, two.r, one.cells, two.cells, deadline)
            except OutOfTimeError:
                return
            self.slices[k] = replace(one, after=after).kept(after >= 0)
            self.slices[k + 1] = replace(two, before=before).kept(before >= 0)

    def refined(self, slabs: BoolArray, spacing: FloatArray, threshold: float, deadline: float = np.inf) -> Tube:
        """Return the tube with a new slice about the middle of each chosen slab.

        Parameters
        ----------
        slabs : array of bool, shape (slices − 1,)
        spacing : array, shape (slices,)
            Cells of a slice are no longer; a new slice has the mean of its neighbours' [rad].
        threshold : float
            Cost of motions that need not stay in the tube.
        deadline : float
        """

        def finer(k: int) -> list[Slice]:
            part = self.slices[k]
            mine = part if part.fixed else self._in_cells_of(part, float(spacing[k]))
            mine = replace(mine, after=None, before=None)  # between other slices, and of other cells
            if k == 0 or not slabs[k - 1]:
                return [mine]
            return [
                self._between(self.slices[k - 1], part, 0.5 * float(spacing[k - 1] + spacing[k]), threshold, deadline),
                mine,
            ]

        found: list[list[Slice]] = [[] for _ in self.slices]

        def every(first: int) -> None:
            for k in range(first, len(found), _THREADS):
                found[k] = finer(k)

        _together([partial(every, first) for first in range(_THREADS)])
        return Tube(self.setting, [part for parts in found for part in parts], self.tie)

    def cheapest(self) -> Chain:
        """Return the cheapest chords from the first slice to the last."""
        part = self.slices[-1]
        assert part.forward is not None
        assert part.least is not None
        v = _proved(part.forward).v
        if part.backward is not None:
            v = v + part.backward.v
        cell, end = (int(k) for k in np.unravel_index(int(np.argmin(v)), v.shape))
        wraps = self.setting.cover.wraps
        q, lost = [(part.cells.a if end == 0 else part.cells.b)[cell]], [part.forward.lost[cell]]
        for one, two in zip(self.slices[-2::-1], self.slices[:0:-1], strict=True):
            before, own = joint_groups(one, two)
            rows: Rows = slice(None) if before is None or own is None else np.flatnonzero(before == own[cell])
            assert one.forward is not None
            cells, values = one.cells[rows], one.forward.of(rows)
            cell, s = _proposal_kernels.source_of(
                *self._chord(one, two), wraps, self._arcs(cells), _proved(values), q[-1]
            )  # fmt: skip
            x = cells.a[cell] + s * (cells.b[cell] - cells.a[cell]) + 0.5 * s * (1.0 - s) * cells.bow[cell]
            q.append(x + np.where(wraps, TAU * np.rint((q[-1] - x) / TAU), 0.0))
            lost.append(values.lost[cell])
            cell = cell if isinstance(rows, slice) else int(rows[cell])
        return Chain(self.r, np.array(q[::-1]), np.array(lost[::-1]))

    def _between(self, one: Slice, two: Slice, spacing: float, threshold: float, deadline: float) -> Slice:
        """Return a slice about half-way between two, with the cells that a motion cheaper than `threshold` may pass."""
        now, r = _COARSE, self.setting.cut(one.r, two.r)
        x = self.setting.task(r)
        new = self._slice(r, x, self.setting.cover.cells(x, now))
        while True:
            least = self._by_boxes(one, one.forward, new) + self._by_boxes(two, two.backward, new)
            new = new.below(threshold, least)
            if now <= spacing or len(new.cells) == 0:
                break
            now = max(now / _FINER, spacing)
            new = self._split(new, now)
        new.forward = self._carried(one, one.forward, new, deadline, extended=False)
        new.backward = self._carried(two, two.backward, new, deadline, extended=False)
        return new.below(threshold, self._least(new))

    def _by_boxes(self, one: Slice, values: Values | None, two: Slice) -> FloatArray:
        """Return a cheap bound on the cost of motions that arrive at the cells of a slice from another one."""
        assert values is not None
        least = np.empty(len(two.cells))
        _kernels.least_to(
            *self._chord(one, two),
            self.setting.cover.wraps,
            self._arcs(one.cells),
            values,
            self._arcs(two.cells),
            least,
        )
        return least

    def _in_cells_of(self, part: Slice, spacing: float) -> Slice:
        """Return a slice itself if its cells are about as short as `spacing`, else in shorter ones."""
        longest = np.abs(part.cells.b - part.cells.a).max(initial=0.0)
        return part if longest <= _ABOUT * spacing else self._split(part, spacing)

    def _split(self, part: Slice, spacing: float) -> Slice:
        """Return a slice with its cells split."""
        whole = part.cells
        cells = self.setting.cover.split(part.x, whole, np.full(len(whole), spacing))
        new, of = self._slice(part.r, part.x, cells), cells.origin
        for end, column in ((0, 2), (1, 3)):
            new.severed[:, end] = part.severed[of, end] & (cells.pieces[:, column] == whole.pieces[of, column])
        return new

    def _at_end(self, part: Slice, sign: float) -> Values:
        """Return the values that an end begins with: zero, or the linear ones of a tie."""
        m, n = part.cells.a.shape
        if self.tie is None:
            return Values(np.zeros((m, 2)), np.zeros(m), np.zeros((m, n)), np.zeros(m))
        a, b = part.cells.a, part.cells.b
        middle = self._apart(0.5 * (a + b), self.tie.anchor)
        half = 0.5 * (b - a) @ self.tie.pull
        v = sign * np.column_stack([middle @ self.tie.pull - half, middle @ self.tie.pull + half])
        rounding = _chord_kernels.ROUNDING * (np.abs(a) + np.abs(b) + np.abs(self.tie.anchor)) @ np.abs(self.tie.pull)
        bow = self._arcs(part.cells).bow
        return Values(v, -sign * (bow @ self.tie.pull), np.tile(sign * self.tie.pull, (m, 1)), rounding)

    def _apart(self, q: FloatArray, to: FloatArray) -> FloatArray:
        """Return q − to, free joints modulo 2π."""
        step = q - to
        return np.where(self.setting.cover.wraps, step - TAU * np.rint(step / TAU), step)

    def closed(self) -> Tube:
        """Return the tube without the cells at either end that no cell at the other end meets: for cyclic motions."""
        first, last = self.slices[0], self.slices[-1]
        if self.is_empty:
            return self
        meet = self._meet(first.cells, last.cells)
        slices = [first.kept(np.asarray(meet.any(axis=1))), *self.slices[1:-1], last.kept(np.asarray(meet.any(axis=0)))]
        return Tube(self.setting, slices, self.tie)

    def halves(self, pull: FloatArray) -> list[Tube]:
        """Return two tubes of cyclic motions, each with half of the start and the cells of the end that meet it.

        Parameters
        ----------
        pull : array, shape (n,)
            Any multipliers λ of θ(1) = θ(0): λ·(θ(1) − θ(0)) is added to the cost. The better they are, the less is
            lost for start and end being different postures of the same half.
        """
        first, last = self.slices[0], self.slices[-1]
        found = []
        m = len(first.cells)
        ends = np.flatnonzero(~first.joined[1:]) + 1  # between pieces, which may be far from each other
        cut = int(ends[np.abs(ends - m // 2).argmin()]) if len(ends) else m // 2
        for rows in (np.arange(cut), np.arange(cut, m)):
            mine = np.zeros(m, bool)
            mine[rows] = True
            start = first.kept(mine)
            end = last.kept(np.asarray(self._meet(start.cells, last.cells).any(axis=0)))
            middle = 0.5 * (first.cells.a + first.cells.b)[rows[len(rows) // 2]]
            tie = Tie(middle, pull) if self._is_one_sheet(middle, start.cells, end.cells) else None
            slices = [start, *(replace(part) for part in self.slices[1:-1]), end]
            found.append(Tube(self.setting, slices, tie))
        return found

    def _is_one_sheet(self, anchor: FloatArray, *ends: Cells) -> bool:
        """Return whether all postures are less than half a turn from the anchor: differences to it are one-valued."""
        far = [
            np.abs(self._apart(0.5 * (cells.a + cells.b), anchor)) + 0.5 * np.abs(cells.b - cells.a) + cells.dev
            for cells in ends
        ]
        return all(bool((part[:, self.setting.cover.wraps] < np.pi - _ROUNDING).all()) for part in far)

    def _meet(self, one: Cells, two: Cells) -> BoolArray:
        """Return which cells (m,) and (k,) may share a posture, shape (m, k)."""
        room = 0.5 * (np.abs(one.b - one.a)[:, None] + np.abs(two.b - two.a)) + one.dev[:, None] + two.dev
        middle = 0.5 * (one.a + one.b)[:, None]
        return np.asarray((np.abs(self._apart(0.5 * (two.a + two.b), middle)) <= room + _ROUNDING).all(axis=2))

    def _slice(self, r: float, x: FloatArray, cells: Cells, fixed: bool = False) -> Slice:
        if not np.isfinite(cells.a + cells.b + cells.bow + cells.dev + cells.rest).all():
            # Nothing is proved by comparing with what is not a number.
            raise InvalidInputError(
                "arm", f"its cover at r = {r:g} holds postures that are not numbers", "mend the arm"
            )
        if (cells.dev < (0.125 - _ROUNDING) * np.abs(cells.bow) + cells.rest).any():
            raise InvalidInputError(
                "arm", f"its cover at r = {r:g} has cells that leave their chords by more than dev", "mend the arm"
            )
        joined = np.zeros(len(cells), bool)
        same = (cells.pieces[1:, :2] == cells.pieces[:-1, :2]).all(axis=1) & (
            cells.pieces[1:, 2] == cells.pieces[:-1, 3]
        )
        step = self._apart(cells.a[1:], cells.b[:-1])
        joined[1:] = same & (np.abs(step).max(axis=1, initial=0.0) < SAME)
        severed = np.zeros((len(cells), 2), bool)
        return Slice(r, x, cells, joined, severed, fixed, wraps=self.setting.cover.wraps)

    def _carried(self, one: Slice, values: Values | None, two: Slice, deadline: float, extended: bool = True) -> Values:
        """Carry values from one slice to another."""
        in_time(deadline)
        assert values is not None
        m = len(two.cells)
        found = Values(np.empty((m, 2)), np.empty(m), np.empty((m, self.setting.cover.n)), np.empty(m))
        for mine, theirs in led_parts(one, two):
            part = found.of(theirs)
            _kernels.step_values(
                *self._chord(one, two), self.setting.cover.wraps, self._arcs(one.cells[mine]), values.of(mine),
                one.severed[mine] & extended, self._arcs(two.cells[theirs]), two.joined[theirs], part,
            )  # fmt: skip
            for whole, some in zip(found, part, strict=True):
                whole[theirs] = some
        return found

    def _chord(self, one: Slice, two: Slice) -> tuple[int, float, FloatArray]:
        """Return what chords between two slices cost by: objective, h and weights."""
        return _KINDS[self.setting.objective], abs(two.r - one.r), self.setting.weights

    def _arcs(self, cells: Cells) -> Arcs:
        """Return cells for the kernels: parabolas for joint travel, chords for l1 and l2, as their values are."""
        if self.setting.objective == "joint_travel":
            return Arcs(cells.a, cells.b, cells.bow, cells.dev, cells.rest)
        return Arcs(cells.a, cells.b, np.zeros_like(cells.a), cells.dev, cells.dev)

    def _least(self, part: Slice) -> FloatArray:
        one, two, out = part.forward, part.backward, np.empty(len(part.cells))
        assert one is not None
        assert two is not None
        _kernels.least_through(self._arcs(part.cells), one, two, out)
        return out


def _proved(values: Values) -> Values:
    """Return values less what is not proved of them."""
    return values._replace(v=values.v - values.lost[:, None])


def first_tube(
    setting: Setting, r: FloatArray, spacing: float, start: Cells | None = None, end: Cells | None = None,
    deadline: float = np.inf,
) -> Tube:  # fmt: skip
    """Return the whole angle domain on slices r; `start` and `end` are what alone may be there."""
    tube = Tube(setting, [])
    for k, at in enumerate(r):
        in_time(deadline)
        given = start if k == 0 else end if k == len(r) - 1 else None
        x = setting.task(at)
        cells = setting.cover.cells(x, spacing) if given is None else given
        tube.slices.append(tube._slice(float(at), x, cells, given is not None))
    return tube


def _together(tasks: list[Callable[[], None]]) -> None:
    """Run tasks at the same time; kernels let go of the interpreter."""
    with ThreadPoolExecutor(len(tasks)) as pool:
        for done in [pool.submit(task) for task in tasks]:
            done.result()
