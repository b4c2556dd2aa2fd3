"""What happens to the angle domain along a path: where its intervals open, close, split and merge, and why."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause
from selfmotion.domain.fibre import End, Fibre, Interval

WORDS = {
    "opens": "interval opens",
    "closes": "interval closes",
    "splits": "interval splits",
    "merges": "intervals merge",
    "takes over": "another constraint takes over",
    "branches meet": "branches meet",
    "branches part": "branches part",
    "singular": "a joint is free (singular)",
    "component appears": "component appears",
    "component dies": "component dies",
    "components join": "components join",
    "component parts": "component parts",
}
"""Every kind of event, and how a reader is told."""

# Two ends at one place may differ by what the domain has moved since [rad].
_ASIDE = 1e-3
# Arcs that have less in common lie beside each other, up to rounding: there a joint may be on either side of its seam.
_TOUCH = 1e-12
# Near w = 0 joints swing within no distance of u: one u is one posture only if no joint is this far off [rad].
_SWING = 0.3


@dataclass(frozen=True)
class Event:
    """A change of the angle domain's structure.

    Attributes
    ----------
    r : float
        Where along the path.
    kind : str
        A key of `WORDS`. Of the intervals of a branch: ``opens``, ``closes``, ``splits``, ``merges``; of one end of an
        interval: ``takes over`` (another limit bounds it from there on), ``branches meet`` (a fold does, so that
        branches are joined there) and ``branches part`` (a fold no longer does). Of the connected parts of the
        self-motion, all branches together: ``component appears``, ``component dies``, ``components join``, ``component
        parts``. ``singular``: a joint is free at one posture.
    u : float
        Redundancy parameter there [rad], in [−π, π].
    branch : int or None
        IK branch; None where the event concerns none in particular.
    causes : tuple of Cause
        The constraints that meet there; at an end that changes, those that bound it afterwards.
    instead_of : tuple of Cause
        At an end that changes, the constraints that bounded it before; else empty.
    """

    r: float
    kind: str
    u: float
    branch: int | None
    causes: tuple[Cause, ...]
    instead_of: tuple[Cause, ...] = ()

    @property
    def joints(self) -> tuple[int, ...]:
        """The joints concerned, counted from 0."""
        return tuple(dict.fromkeys(cause.joint for cause in (*self.causes, *self.instead_of)))

    def text(self, branches: tuple[str, ...]) -> str:
        """Return the event as a line for people; `branches` are the arm's names of its branches."""
        where = "" if self.branch is None else f", {branches[self.branch]} elbow"
        why = f": {' and '.join(map(str, self.causes))}" if self.causes else ""
        before = f" instead of {' and '.join(map(str, self.instead_of))}" if self.instead_of else ""
        return f"r = {self.r:.10f}: {WORDS[self.kind]} at u = {self.u:.6f}{where}{why}{before}"


@dataclass(frozen=True)
class Change:
    """What one event does to the intervals before and after it, as indices into their fibres.

    Attributes
    ----------
    before, after : tuple of int
    events : tuple of Event
        Empty where intervals merely go on.
    """

    before: tuple[int, ...]
    after: tuple[int, ...]
    events: tuple[Event, ...] = ()


def changes(r: float, before: Fibre, after: Fibre, u: FloatArray) -> list[Change]:
    """Return how the intervals just before an event go on just after it.

    Parameters
    ----------
    r : float
        Where the event is.
    before, after : Fibre
        The self-motion so close to it that no interval has moved noticeably.
    u : array, shape (m,)
        Per breakpoint index its parameter at r itself, NaN where it has none.

    Returns
    -------
    list of Change
        Each interval is in exactly one.
    """
    # Where a seam comes next to an end, counted turns change number: such intervals are followed by their angles.
    names = [{i.name: k for k, i in enumerate(fibre.intervals) if not i.turns} for fibre in (before, after)]
    result = [Change((k,), (names[1][name],)) for name, k in names[0].items() if name in names[1]]
    left = sorted(set(range(len(before.intervals))) - {change.before[0] for change in result})
    right = sorted(set(range(len(after.intervals))) - {change.after[0] for change in result})
    beside = np.where(np.isfinite(before.u), before.u, after.u)
    u = np.where(np.isfinite(u), u, beside)
    for group_left, group_right in _groups(before, left, after, right):
        gone, come = [before.intervals[k] for k in group_left], [after.intervals[k] for k in group_right]
        result.append(Change(tuple(group_left), tuple(group_right), tuple(_events(r, gone, come, before.causes, u))))
    return _through_folds(result, before, after)


def joined(found: list[Change], together: list[set[int]]) -> list[Change]:
    """Return `found` with the changes of each of the index sets `together` made one."""
    label = list(range(len(found)))
    for group in together:
        names = {label[k] for k in group}
        label = [min(names) if value in names else value for value in label]
    merged = []
    for name in dict.fromkeys(label):
        mine = [change for change, value in zip(found, label, strict=True) if value == name]
        merged.append(
            Change(
                tuple(chain.from_iterable(change.before for change in mine)),
                tuple(chain.from_iterable(change.after for change in mine)),
                tuple(chain.from_iterable(change.events for change in mine)),
            )
        )
    return merged


def _groups(before: Fibre, left: list[int], after: Fibre, right: list[int]) -> list[tuple[list[int], list[int]]]:
    """Group intervals before and after that go on as each other."""
    groups: list[tuple[list[int], list[int]]] = [([k], []) for k in left]
    for k in right:
        mine = [g for g in groups if any(_goes_on(before, j, after, k) for j in g[0])]
        groups = [g for g in groups if g not in mine]
        groups.append(([j for g in mine for j in g[0]], [*(j for g in mine for j in g[1]), k]))
    return groups


def _goes_on(before: Fibre, j: int, after: Fibre, k: int) -> bool:
    """Return whether an interval goes on as another: they share an end, or postures with their number of turns."""
    one, two = before.intervals[j], after.intervals[k]
    if one.branch != two.branch:
        return False
    # A short interval may move by more than its length, but an end that stays says that it is the same one.
    if not one.turns and any(set(a) & set(b) for a, b in zip(one.ends, two.ends, strict=True)):
        return True
    for low, high, turns in one.arcs:
        for other_low, other_high, other_turns in two.arcs:
            shift = TAU * np.rint((low + high - other_low - other_high) / (2 * TAU))
            first, last = max(low, other_low + shift), min(high, other_high + shift)
            if last - first > _TOUCH:
                middle = np.array([0.5 * (first + last)])
                apart = before.turn_angles(middle, one.branch) - after.turn_angles(middle, one.branch)
                swing = wrap(before.joints(middle, one.branch) - after.joints(middle, one.branch))
                same = np.array_equal(np.array(other_turns) - np.array(turns), np.rint(apart[0] / TAU))
                if same and np.abs(swing).max() < _SWING:
                    return True
    return False


def _through_folds(found: list[Change], before: Fibre, after: Fibre) -> list[Change]:
    """Join an interval that closes on one branch with one that opens, at the same posture, on another."""
    closing = [change for change in found if not change.after]
    result = [change for change in found if change.after]
    for change in closing:
        gone = before.intervals[change.before[0]]
        for k, other in enumerate(result):
            if other.before or not other.after:
                continue
            come = after.intervals[other.after[0]]
            if come.branch != gone.branch and set(gone.ends[0]) & set(come.ends[0]):
                result[k] = Change(change.before, other.after, change.events + other.events)
                break
        else:
            result.append(change)
    return result


def _events(
    r: float, gone: list[Interval], come: list[Interval], causes: tuple[Cause, ...], u: FloatArray
) -> list[Event]:
    """Return the events that turn the intervals `gone` into the intervals `come`."""
    if len(gone) == len(come):
        pairs = zip(*(sorted(some, key=lambda interval: interval.low) for some in (gone, come)), strict=True)
        return [event for old, new in pairs for event in _at_ends(r, old, new, causes, u)]
    few, many = sorted((gone, come), key=len)
    if not few:
        kind = "opens" if many is come else "closes"
        ends = [(interval, tuple(end for end in interval.ends if end)) for interval in many]
        return [_event(r, kind, interval.branch, mine, causes, u) for interval, mine in ends if mine]
    kind = "splits" if many is come else "merges"
    pieces = sorted(many, key=lambda piece: piece.low)
    first = next((k for k, piece in enumerate(pieces) if set(piece.ends[0]) & set(few[0].ends[0])), None)
    if first is None:  # the lower end changes too, or there is none: count from where it was
        pieces.sort(key=lambda piece: np.mod(piece.low - few[0].low + _ASIDE, TAU))
    else:
        pieces = pieces[first:] + pieces[:first]
    gaps = list(pairwise(pieces)) + ([(pieces[-1], pieces[0])] if few[0].is_circle else [])
    # At w = 0 a circle may come off an interval: then only one of the two has an end there.
    between = [tuple(end for end in (a.ends[1], b.ends[0]) if end) for a, b in gaps]
    return [_event(r, kind, few[0].branch, ends, causes, u) for ends in between if ends]


def _at_ends(r: float, gone: Interval, come: Interval, causes: tuple[Cause, ...], u: FloatArray) -> list[Event]:
    """Return the events of an interval that goes on with other constraints at its ends."""
    if gone.is_circle and come.is_circle:
        return []
    if gone.is_circle:
        return [_event(r, "splits", come.branch, come.ends, causes, u)]
    if come.is_circle:
        return [_event(r, "merges", gone.branch, gone.ends, causes, u)]
    events = []
    for old, new in zip(gone.ends, come.ends, strict=True):
        if not old or not new:  # within rounding of a touch
            continue
        was, now = _unique(causes, (old,)), _unique(causes, (new,))
        if set(was) == set(now):  # the other solution of the same constraint
            continue
        folds = [any(cause.kind == "fold" for cause in part) for part in (was, now)]
        kind = {(False, True): "branches meet", (True, False): "branches part"}.get((folds[0], folds[1]), "takes over")
        events.append(Event(r, kind, _middle(u[[old[0], new[0]]]), gone.branch, now, was))
    return events


def _event(r: float, kind: str, branch: int, ends: tuple[End, ...], causes: tuple[Cause, ...], u: FloatArray) -> Event:
    return Event(r, kind, _middle(u[[end[0] for end in ends]]), branch, _unique(causes, ends))


def _unique(causes: tuple[Cause, ...], ends: tuple[End, ...]) -> tuple[Cause, ...]:
    return tuple(dict.fromkeys(causes[column] for column in sorted(chain(*ends))))


def _middle(u: FloatArray) -> float:
    """Return the mean direction, in [−π, π]."""
    return float(np.angle(np.exp(1j * u).mean()))
