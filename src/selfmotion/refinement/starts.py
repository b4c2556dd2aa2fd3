"""Many different motions to start a refinement from: random postures and self-motions, led along the path."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.angles import TAU, nearest_turn
from selfmotion.arms import JointBox, JointLimits
from selfmotion.arms.limits import ON_LIMIT
from selfmotion.paths import Reversed
from selfmotion.problem import ANGLE, Posture, Problem, postures_of
from selfmotion.refinement.follow import followed, freed, is_constrained, on_task
from selfmotion.refinement.spline import Ends

_STEPS = 200
_LEAST_POOL = 8  # postures led along the path at once inside one box
_TRIES = 8  # pools that may be drawn before the search for starts is given up
_INSIDE = 0.02  # of a joint's range: where followers start that should start on a limit
_LOCKED = 5e-10  # half-width given to a joint whose limits leave it none [rad]
_DRIFT = 3.0  # standard deviation of the random self-motion, at most [rad along the path]
_MORE = 4  # times as many postures are drawn for arms with further constraints, of which many cannot be freed
_MOST_TURNS = 4
_MOST_POSTURES = 64


@dataclass(frozen=True)
class Start:
    """A motion to start from.

    Attributes
    ----------
    box : JointBox
        Joint limits, narrowed to one elbow if the problem asks for it.
    ends : Ends
    r : array, shape (k,)
    q : array, shape (k, n)
        Joint angles at r, turns included. They need keep neither task nor limits.
    reached : float
        Part of the path along which they do, and the arm's further constraints.
    """

    box: JointBox
    ends: Ends
    r: FloatArray
    q: FloatArray
    reached: float


def random_starts(
    problem: Problem, rng: np.random.Generator, count: int = 64, deadline: float = np.inf
) -> Iterator[Start]:
    """Yield motions to start from, those that could be led along the whole path first.

    Parameters
    ----------
    problem : Problem
    rng : Generator
    count : int
        Postures led along the path at once; more follow when these are used up.
    deadline : float
        As :func:`time.perf_counter` tells it; what is not led along the path by then is among the last.

    Yields
    ------
    Start

    Notes
    -----
    A posture at one end (the given one, or a random one moved onto the task) is led along the path by differential
    inverse kinematics, with a random constant drift of the self-motion; the first by the least joint motion, without
    any. What is asked of the other end is reached by adding a straight line.
    """
    boxes = _boxes(problem)
    ends = [_fixed_ends(problem, box) for box in boxes]
    broken: list[Start] = []
    for pool in range(_TRIES):
        if pool and time.perf_counter() > deadline:
            break
        whole: list[Start] = []
        for box, fixed in zip(boxes, ends, strict=True):
            size = max(count // len(boxes), _LEAST_POOL)
            for start in _pool(problem, rng, box, *fixed, size, pool == 0, deadline):
                (whole if start.reached == 1.0 else broken).append(start)
        yield from (whole[k] for k in _mixed(rng, len(whole)))
    broken.sort(key=lambda start: -start.reached)
    yield from broken


def start_from(problem: Problem, q: FloatArray, r: FloatArray) -> Start:
    """Return the start that a sampled motion is.

    Parameters
    ----------
    problem : Problem
    q : array, shape (k, n)
        Joint angles at r, turns included, on the task and inside the limits.
    r : array, shape (k,)
        Ascending from 0 to 1.

    Returns
    -------
    Start
        In the elbow that the motion is in most, with straight lines added so that it ends where the problem wants it.
    """
    boxes = _boxes(problem)
    excess = [np.maximum(np.maximum(box.lower - q, q - box.upper), 0.0).sum() for box in boxes]
    box = boxes[int(np.argmin(excess))]
    starts, ends = _fixed_ends(problem, box)
    q = problem.arm.limits.continuous(q)
    start, end = _nearest(problem, q[0], starts) if starts else None, _nearest(problem, q[-1], ends) if ends else None
    return _with_ends(problem, box, r, q, 1.0, start, end)


def _boxes(problem: Problem) -> list[JointBox]:
    """Return the joint limits by elbow, each joint with room to move: a locked one is given ±5e-10 rad."""
    ends = [posture for posture in (problem.start, problem.end) if posture is not None and posture.q is not None]
    given = ends[0].q if ends else None
    found = []
    for box in problem.arm.boxes(problem.elbow, given):
        less = np.where(box.upper - box.lower < 2 * _LOCKED, _LOCKED, 0.0)
        found.append(JointBox(box.lower - less, box.upper + less))
    return found


def _mixed(rng: np.random.Generator, count: int) -> IntArray:
    """Return a random order of `count` things, the first one left first."""
    return np.concatenate([np.arange(min(count, 1)), 1 + rng.permutation(max(count - 1, 0))])


def _fixed_ends(problem: Problem, box: JointBox) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return the postures inside a box that a motion may begin and end with; none at an end that is not fixed.

    Those of a cyclic motion are the same, its end being fixed by its start.
    """
    starts = _fixed_postures(problem, problem.start, 0.0, box)
    ends = _fixed_postures(problem, problem.end, 1.0, box)
    if problem.cyclic and problem.start is not None and problem.end is not None:
        limits = problem.arm.limits
        starts = [s for s in starts if any(np.abs(limits.steps(s, e)).max() <= ANGLE for e in ends)]
    return starts, ends


def _fixed_postures(problem: Problem, posture: Posture | None, r: float, box: JointBox) -> list[FloatArray]:
    """Return the joint angles inside a box that a fixed posture may mean, none if it is not fixed.

    Given by its redundancy vector, it has one posture per elbow, and a limited joint may be at it in several turns.
    """
    if posture is None:
        return []
    candidates = list(postures_of(problem, posture, r))
    if posture.q is None:
        candidates = [turned for q in candidates for turned in _turned(problem, q, box)]
    # A free joint's box is a half turn at most, and which one does not matter.
    half_turn = ~problem.arm.limits.limited & np.isfinite(box.lower)
    middle = 0.5 * (np.where(half_turn, box.lower, 0.0) + np.where(half_turn, box.upper, 0.0))
    candidates = [np.where(half_turn, nearest_turn(q, middle), q) for q in candidates]
    inside = [((q >= box.lower - ON_LIMIT) & (q <= box.upper + ON_LIMIT)).all() for q in candidates]
    return [np.clip(q, box.lower, box.upper) for q, ok in zip(candidates, inside, strict=True) if ok]


def _turned(problem: Problem, q: FloatArray, box: JointBox) -> list[FloatArray]:
    """Return q with its limited joints in the turns that a box allows, those nearest to zero first."""
    found = [q]
    for j in np.flatnonzero(problem.arm.limits.limited & ~problem.arm.limits.slides):
        middle = np.rint((np.clip(0.0, box.lower[j], box.upper[j]) - q[j]) / TAU)
        angles = sorted(q[j] + TAU * (middle + np.arange(-_MOST_TURNS, _MOST_TURNS + 1)), key=abs)
        inside = [angle for angle in angles if box.lower[j] - ON_LIMIT <= angle <= box.upper[j] + ON_LIMIT]
        found = [np.concatenate([p[:j], [angle], p[j + 1 :]]) for p in found for angle in inside][:_MOST_POSTURES]
    return found


def _pool(
    problem: Problem,
    rng: np.random.Generator,
    box: JointBox,
    starts: list[FloatArray],
    ends: list[FloatArray],
    count: int,
    first: bool,
    deadline: float,
) -> Iterator[Start]:
    """Yield starts inside one box from many postures; `starts` and `ends` are those that it may begin and end with."""
    if (problem.start is not None and not starts) or (problem.end is not None and not ends):
        return
    arm, backward = problem.arm, bool(ends and not starts)
    path = Reversed(problem.path) if backward else problem.path
    near = ends if backward else starts
    constrained = is_constrained(arm)
    given = (
        np.array([near[k % len(near)] for k in range(count)])
        if near
        else _random_postures(arm.limits, box, rng, (count * (_MORE if constrained else 1), arm.n))
    )
    seeds, ok = on_task(arm, path(0.0), box, _inside(box, given))
    seeds, given = seeds[ok], given[ok]
    if constrained and not near and len(seeds):
        seeds, free = freed(arm, path(0.0), box, seeds, deadline)
        chosen = np.argsort(~free, kind="stable")[:count]  # those that could be freed first
        seeds, given = seeds[chosen], given[chosen]
    if not len(seeds):
        return
    drift = rng.normal(size=seeds.shape) * rng.uniform(0.0, _DRIFT, size=(len(seeds), 1))
    if first:
        drift[: max(len(near), 1)] = 0.0
    r = np.linspace(0.0, 1.0, _STEPS + 1)
    motions, reached = followed(arm, path, box, seeds, drift, r, rng, deadline)
    for q, part, posture in zip(motions, reached, given, strict=True):
        if backward:
            yield _with_ends(problem, box, r, q[::-1], float(part), None, posture)
        else:
            end = _nearest(problem, q[-1], ends) if ends else None
            yield _with_ends(problem, box, r, q, float(part), posture if starts else None, end)


def _nearest(problem: Problem, q: FloatArray, postures: list[FloatArray]) -> FloatArray:
    """Return the posture nearest to q, its free joints in the nearest turns."""
    limits = problem.arm.limits
    near = min(postures, key=lambda posture: float(np.abs(limits.steps(q, posture)).max()))
    return q + limits.steps(q, near)


def _with_ends(
    problem: Problem,
    box: JointBox,
    r: FloatArray,
    q: FloatArray,
    reached: float,
    start: FloatArray | None,
    end: FloatArray | None,
) -> Start:
    """Return a start that begins and ends where it must, by adding a straight line to what was found."""
    first, last = q[0] if start is None else start, q[-1] if end is None else end
    ends = Ends(start, end)
    if problem.cyclic:
        closure = np.zeros(problem.arm.n)
        if problem.cyclic == "modulo":
            closure = np.where(problem.arm.limits.limited, 0.0, TAU * np.rint((last - first) / TAU))
        if start is None and end is not None:
            start = first = end - closure
        last, ends = first + closure, Ends(start, None, closure)
    way = r[:, None]
    return Start(box, ends, r, q + (1 - way) * (first - q[0]) + way * (last - q[-1]), reached)


def _random_postures(
    limits: JointLimits, box: JointBox, rng: np.random.Generator, shape: tuple[int, int]
) -> FloatArray:
    """Return random postures inside a box, from all but straight to curled up, joint 1 anywhere in a turn or two.

    A joint that slides is anywhere too.
    """
    straight = np.clip(0.0, box.lower, box.upper)
    far = np.where(np.isfinite(box.lower) & np.isfinite(box.upper), limits.period, np.pi)
    # What an open side lets a joint turn on is counted from the limit on the other.
    lower = np.maximum(straight - far, box.lower)
    upper = np.minimum(np.maximum(straight, lower) + far, box.upper)
    curl = rng.uniform(0.1, 1.0, size=(shape[0], 1)) ** np.where(np.arange(shape[1]) > 0, 1.0, 0.0)
    return straight + curl * (rng.uniform(lower, upper, size=shape) - straight)


def _inside(box: JointBox, q: FloatArray) -> FloatArray:
    """Return postures moved off the limits, where followers would stick to them."""
    with np.errstate(invalid="ignore"):
        room = np.where(np.isfinite(box.upper - box.lower), box.upper - box.lower, 1.0) * _INSIDE
    return np.clip(q, box.lower + room, box.upper - room)
