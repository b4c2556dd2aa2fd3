"""What constraints beyond joint limits take out of an angle domain: holes, each with what causes it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.arms import Cause, SelfMotion
from selfmotion.constrained.self_motion import ConstrainedSelfMotion
from selfmotion.domain.feasible import FeasibleArcs, Run
from selfmotion.domain.strands import followed
from selfmotion.domain.strips import Strip

_NARROW = 1e-9  # arcs that are not worth a picture [rad]
_MEETS = " against "
_PARTS = 8  # of an arc, in which one looks what is met
_BISECTIONS = 8
_ROOM = 0.3  # of the path, beyond which a place is not more inside a hole


class Hole(NamedTuple):
    """What one obstacle, or one other constraint, takes out of the angle domain of a branch.

    Attributes
    ----------
    by : str
        What it is, such as ``"obstacle 2 (clamp)"``.
    cause : str
        What meets it in the middle, such as ``"link 3 against obstacle 2 (clamp)"``.
    strips : list of Strip
        Where postures would be feasible but for it; they may be in several pieces.
    at : tuple of float
        r and u of a place well inside the largest of them.
    size : float
        Area of all of them [rad].
    """

    by: str
    cause: str
    strips: list[Strip]
    at: tuple[float, float]
    size: float


def taken(self_motion: SelfMotion, x: FloatArray, arcs: FeasibleArcs, branch: int) -> list[list[Run]]:
    """Return at each task point the arcs on which constraints forbid what joint limits allow, with what forbids them.

    Parameters
    ----------
    self_motion : SelfMotion
    x : array, shape (k, dimension)
    arcs : FeasibleArcs
        Of the branch, there.
    branch : int

    Returns
    -------
    list of list of Run
        The cause, the same at both ends, is what is least kept there.
    """
    if not isinstance(self_motion, ConstrainedSelfMotion):
        return [[] for _ in x]
    pose = self_motion.pose(x)
    row, column = np.nonzero(np.isfinite(arcs.low) & ~arcs.inside & (arcs.high - arcs.low > _NARROW))
    low, high = arcs.low[row, column], arcs.high[row, column]
    at = low[:, None] + (high - low)[:, None] * (np.arange(_PARTS) + 0.5) / _PARTS
    least = self_motion.least_kept(pose[row], at, branch)
    groups = _Groups(self_motion)
    turns = _turns(self_motion, pose[row], branch, at, groups.of(least), groups)
    found: list[list[Run]] = [[] for _ in x]
    for k, arc in enumerate(least):
        parted = np.flatnonzero(np.isfinite(turns[k]))
        ends = [float(low[k]), *turns[k, parted].tolist(), float(high[k])]
        firsts = [0, *(parted + 1).tolist()]
        for first, one, two in zip(firsts, ends[:-1], ends[1:], strict=True):
            if arc[first] >= 0:
                _add(found[row[k]], one, two, self_motion.cause(int(arc[first])))
    return found


class _Groups:
    """Causes by what is met, numbered."""

    def __init__(self, self_motion: ConstrainedSelfMotion) -> None:
        self._self_motion = self_motion
        self._names: dict[str, int] = {}

    def of(self, causes: IntArray) -> IntArray:
        """Return what is met in each cause, −1 where there is none."""
        numbers, inverse = np.unique(causes, return_inverse=True)
        names = [
            -1 if k < 0 else self._names.setdefault(met(self._self_motion.cause(int(k))), len(self._names))
            for k in numbers
        ]
        return np.array(names, np.int64)[inverse].reshape(causes.shape)


def _turns(
    self_motion: ConstrainedSelfMotion, pose: Any, branch: int, at: FloatArray, group: IntArray, groups: _Groups
) -> FloatArray:
    """Return the u between places `at` (m, p) where another thing is met, (m, p − 1); NaN where it is the same."""
    found = np.full((len(at), _PARTS - 1), np.nan)
    i, j = np.nonzero(group[:, 1:] != group[:, :-1])
    one, two, before = at[i, j], at[i, j + 1], group[i, j]
    for _ in range(_BISECTIONS if len(i) else 0):
        middle = 0.5 * (one + two)
        same = groups.of(self_motion.least_kept(pose[i], middle[:, None], branch))[:, 0] == before
        one, two = np.where(same, middle, one), np.where(same, two, middle)
    found[i, j] = 0.5 * (one + two)
    return found


def _add(runs: list[Run], low: float, high: float, cause: Cause) -> None:
    """Add an arc, to the last one if that ends where it begins and meets the same."""
    run = Run(low, high, ((cause,), (cause,)))
    if runs and runs[-1].high == low and met(runs[-1].causes[0][0]) == met(cause):
        wider = max(runs[-1], run, key=lambda one: one.high - one.low)
        run = Run(runs.pop().low, high, wider.causes)
    runs.append(run)


def is_contact(cause: Cause) -> bool:
    """Return whether a cause is a constraint beyond joint limits."""
    return cause.joint < 0 and cause.kind not in ("fold", "marker")


def met(cause: Cause | str) -> str:
    """Return what is met: an obstacle, a link, or the whole cause if nothing is."""
    kind = cause if isinstance(cause, str) else cause.kind
    _, _, other = kind.partition(_MEETS)
    return other or kind


def holes_of(r: FloatArray, looks: list[list[Run]], cause_at: Callable[[float, float], Cause | None]) -> list[Hole]:
    """Return the holes that arcs at places along the path make, the largest first.

    Parameters
    ----------
    r : array, shape (k,)
    looks : list of list of Run
        As :func:`taken` tells them.
    cause_at : callable
        Returns what is least kept at r and u, None where nothing is.

    Returns
    -------
    list of Hole
        One per obstacle.
    """
    names = dict.fromkeys(met(run.causes[0][0]) for runs in looks for run in runs)
    found = []
    for name in names:
        same = ((Cause(name, -1, 0.0),),) * 2
        mine = [[Run(*run[:2], same) for run in runs if met(run.causes[0][0]) == name] for runs in looks]
        strips = followed(r, mine)
        place, size = (float("nan"),) * 2, -1.0
        for strip in strips:
            inside = np.minimum(np.minimum(strip.r - strip.r[0], strip.r[-1] - strip.r), _ROOM)
            score = (strip.high - strip.low) * inside
            k = int(score.argmax())
            if score[k] > size:
                place, size = (float(strip.r[k]), 0.5 * float(strip.low[k] + strip.high[k])), float(score[k])
        area = sum(_area(strip) for strip in strips)
        found.append(Hole(name, _named(cause_at(*place), name), strips, place, area))
    return sorted(found, key=lambda hole: -hole.size)


def _named(cause: Cause | None, name: str) -> str:
    """Return a cause in words, what is met if that is all that is known."""
    return name if cause is None or met(cause) != name else cause.kind


def _area(strip: Strip) -> float:
    wide = strip.high - strip.low
    return float(0.5 * ((wide[1:] + wide[:-1]) * np.diff(strip.r)).sum())
