"""What constraints beyond joint limits take out of an angle domain: holes, each with what causes it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import Cause, SelfMotion
from selfmotion.constrained.self_motion import ConstrainedSelfMotion
from selfmotion.domain.feasible import FeasibleArcs, Run
from selfmotion.domain.strands import followed
from selfmotion.domain.strips import Strip

_NARROW = 1e-9  # arcs that are not worth a picture [rad]
_MEETS = " against "
_ROOM = 0.15  # of the path, beyond which a place is not more inside a hole


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
        The cause, the same at both ends, is what is least kept in the middle.
    """
    if not isinstance(self_motion, ConstrainedSelfMotion):
        return [[] for _ in x]
    open_ = np.isfinite(arcs.low) & ~arcs.inside & (arcs.high - arcs.low > _NARROW)
    least = self_motion.least_kept(self_motion.pose(x), np.nan_to_num(0.5 * (arcs.low + arcs.high)), branch)
    found: list[list[Run]] = []
    for k in range(len(x)):
        runs: list[Run] = []
        for m in np.flatnonzero(open_[k] & (least[k] >= 0)):
            cause = (self_motion.cause(int(least[k, m])),)
            run = Run(float(arcs.low[k, m]), float(arcs.high[k, m]), (cause, cause))
            if runs and runs[-1].high == run.low and met(runs[-1].causes[0][0]) == met(cause[0]):
                wider = max(runs[-1], run, key=lambda one: one.high - one.low)
                run = Run(runs.pop().low, run.high, wider.causes)
            runs.append(run)
        found.append(runs)
    return found


def is_contact(cause: Cause) -> bool:
    """Return whether a cause is a constraint beyond joint limits."""
    return cause.joint < 0 and cause.kind not in ("fold", "marker")


def met(cause: Cause | str) -> str:
    """Return what is met: an obstacle, a link, or the whole cause if nothing is."""
    kind = cause if isinstance(cause, str) else cause.kind
    _, _, other = kind.partition(_MEETS)
    return other or kind


def holes_of(r: FloatArray, looks: list[list[Run]]) -> list[Hole]:
    """Return the holes that arcs at places along the path make, the largest first.

    Parameters
    ----------
    r : array, shape (k,)
    looks : list of list of Run
        As :func:`taken` tells them.

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
        found.append(Hole(name, _cause_at(r, looks, name, place), strips, place, area))
    return sorted(found, key=lambda hole: -hole.size)


def _cause_at(r: FloatArray, looks: list[list[Run]], name: str, place: tuple[float, float]) -> str:
    """Return the whole cause of the arc that holds a place."""
    runs = [run for run in looks[int(np.abs(r - place[0]).argmin())] if met(run.causes[0][0]) == name]
    near = min(runs, key=lambda run: abs(np.sin(0.25 * (run.low + run.high) - 0.5 * place[1])))
    return near.causes[0][0].kind


def _area(strip: Strip) -> float:
    wide = strip.high - strip.low
    return float(0.5 * ((wide[1:] + wide[:-1]) * np.diff(strip.r)).sum())
