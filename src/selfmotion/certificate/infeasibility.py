"""Why no continuous motion exists: the proof, what blocks, and by how much the nearest limit would have to give."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass

import numpy as np

from selfmotion.arms import Cause
from selfmotion.arms.slabs import SlabCover
from selfmotion.certificate.chains import Chains, Ends
from selfmotion.certificate.joined import earliest, ends, leads_on, parts_at_start, sheets_at_end, with_arm
from selfmotion.certificate.needs import needs, needs_of_pose
from selfmotion.constrained import constraints_of, unconstrained
from selfmotion.domain import AngleDomain, blocked_by, cause_of, out_of_reach
from selfmotion.errors import Blocked, InfeasibleError, InvalidInputError, Need, UndecidedError
from selfmotion.problem import Problem

_SLACK = 1e-7  # a motion that limits wider by this allow is a matter of rounding [rad]
_FOR_THE_PROOF = 0.5  # parts of the time that is left
_BEYOND = (1e-4, 1e-3, 1e-2, 0.1)  # how far beyond a part's computed end it is proved to be over
_SECONDS_PER_PART = 0.5
_MOST_PARTS = 8
_CLOSE_LOOKS = 2001  # for where the path leaves the reach for a moment
_LOOKS, _MOST_CAUSES = 9, 4  # at what ends the self-motion of constrained arms where they are blocked


@dataclass(frozen=True)
class Death:
    """Where everything ends that a connected part of the self-motion at r = 0 leads on to.

    Attributes
    ----------
    r : tuple of float
        From where the structure of the angle domain says so, to where it is proved that no motion from that part gets.
    causes : tuple of str
        What ends it, such as ``"upper limit of θ1"``.
    """

    r: tuple[float, float]
    causes: tuple[str, ...]


@dataclass(frozen=True)
class InfeasibilityProof:
    """A proof that no continuous motion exists.

    Attributes
    ----------
    argument : str
    deaths : tuple of Death
        One per connected part at r = 0, or per part that the start asked for may be on.
    blocked : tuple of float
        Where the motion must break: from the first r that the end can be got to from, to the last one that the start
        leads to. Computed.
    proved_within : tuple of float
        What the proof itself says of that: no motion that could lead to the end gets beyond the second, and none that
        could come from the start leads to the end from before the first.
    resolution : float
        Width in r of the narrowest slab that was needed.
    boxes : int
        How many were looked at.
    seconds : float
    """

    argument: str
    deaths: tuple[Death, ...]
    blocked: tuple[float, float]
    proved_within: tuple[float, float]
    resolution: float
    boxes: int
    seconds: float


def explain(problem: Problem, deadline: float) -> InfeasibleError | UndecidedError | None:
    """Prove that a problem has no continuous motion, and say why.

    Parameters
    ----------
    problem : Problem
        Of an arm with one redundant degree. If it is cyclic the proof, if any, is one for motions that need not
        close. Where joint limits alone leave no way it is proved, and told, of them.
    deadline : float
        As :func:`time.perf_counter` tells it; half of the time is for the proof, or all where no structure is known.

    Returns
    -------
    InfeasibleError
        If there is a proof: with the stretch that blocks, the limits that would have to give as far as time allowed,
        and the proof.
    UndecidedError
        If the structure of the angle domain says that there is no motion and the proof was not completed, or if the arm
        is not rigorous, so that there is none.
    None
        If neither says so.
    """
    began = time.perf_counter()
    blocked = problem.blocked
    if blocked:
        limited = all(part.cause == "joint limits" for part in blocked)
        if not limited:
            return InfeasibleError(blocked)
        structured = problem.arm.has_structure
        found = needs(problem, (), deadline) if structured else needs_of_pose(problem, deadline)
        return InfeasibleError(blocked, found)
    if not problem.has_slabs:
        return None if problem.arm.rigorous else unproved("no motion was found")
    if constraints_of(problem.arm) and not leads_on(problem):  # joint limits leave no way, whatever else there is
        return explain(with_arm(problem, unconstrained(problem.arm)), deadline)
    cover = problem.arm.slabs(problem.path, problem.elbow)
    start, end = ends(problem, "start"), ends(problem, "end")
    # What follows the proof is told from the structure of the angle domain.
    until = began + (_FOR_THE_PROOF if problem.arm.has_structure else 1.0) * (deadline - began)
    proof = Chains(cover, start=start, end=end, deadline=until).prove(until)
    if not proof.proved:
        return None if leads_on(problem) else _undecided(problem, proof.stopped)
    if problem.arm.has_structure:
        stretch, causes = _stretch(problem)
        deaths = _deaths(problem, cover, deadline)
    else:  # what the boxes tell is all that is known
        stretch = told(problem, (min(proof.earliest, proof.latest), max(proof.earliest, proof.latest)))
        causes, deaths = (), ()
    result = InfeasibilityProof(
        "no chain of overlapping boxes, which hold all postures of the slabs that the path was cut into",
        deaths, stretch.r, (proof.earliest, proof.latest), proof.resolution, proof.boxes,
        time.perf_counter() - began,
    )  # fmt: skip
    wanted: list[Need] = []
    if not leads_on(problem) and stretch.cause == "joint limits":
        wanted = needs(problem, causes, deadline)
    return InfeasibleError([stretch], wanted, result)


def unproved(what: str) -> UndecidedError:
    """Return the error that says that `what` was found of an arm that is not rigorous, and why it proves nothing."""
    return UndecidedError(
        f"{what}, which proves nothing: this arm is solved at single values of u, and what is between two of them "
        "may be missed",
        "widen the limits, move the path, or use an arm that is solved in closed form",
        "estimate",
    )


def told(problem: Problem, r: tuple[float, float]) -> Blocked:
    """Return the stretch in which a proof found no way on; of constrained arms with what ends the self-motion there."""
    if (outside := _outside(problem, r)) is not None:
        return outside
    if not constraints_of(problem.arm):
        return Blocked(r, "joint limits")
    found = _ended_by(problem, r)
    if not found:  # nothing is left that could end
        return blocked_by(problem.arm, problem.path, r, problem.elbow_branches)
    return Blocked(r, cause_of(problem.arm, found), limits=found)


def _ended_by(problem: Problem, r: tuple[float, float]) -> tuple[str, ...]:
    """Return what constraints end the self-motion most in a stretch; none of arms whose self-motion is not told."""
    try:
        self_motion = problem.arm.self_motion()
    except InvalidInputError:
        return ()
    limiting = ("lower limit", "upper limit", "fold", "marker", "free")
    seen = Counter(
        str(cause)
        for arcs in AngleDomain(self_motion, problem.path).sample(np.linspace(*r, _LOOKS))
        for k in range(_LOOKS) for run in arcs.runs(k) for causes in run.causes for cause in causes
        if cause.kind not in limiting
    )  # fmt: skip
    return tuple(cause for cause, _ in seen.most_common(_MOST_CAUSES))


def _outside(problem: Problem, r: tuple[float, float]) -> Blocked | None:
    """Return where the path leaves the reach in a stretch, if it does, for less than is between two samples."""
    places = np.linspace(*r, _CLOSE_LOOKS)
    points = problem.path(places)
    outside = places[out_of_reach(problem.arm, points)]
    if not len(outside):
        return None
    return Blocked((float(outside[0]), float(outside[-1])), "out of reach", float(problem.arm.shortfall(points).max()))


def _stretch(problem: Problem) -> tuple[Blocked, tuple[Cause, ...]]:
    """Return where the motion must break, and what ends the last part that leads on from the start."""
    last, causes = problem.structure.farthest(sheets_at_end(problem, "start"))
    first = earliest(problem, sheets_at_end(problem, "end"))
    r = (min(first, last), max(first, last))
    limits = any(cause.kind.endswith("limit") for cause in causes)
    cause = "start and end" if problem.structure.is_connected else "joint limits" if limits else "limit of reach"
    return _outside(problem, r) or Blocked(r, cause, None, tuple(map(str, causes))), causes


def _deaths(problem: Problem, cover: SlabCover, deadline: float) -> tuple[Death, ...]:
    """Return where the parts at r = 0 end, and how soon after that it can be proved."""
    found = []
    for sheet, q in parts_at_start(problem)[:_MOST_PARTS]:
        r, causes = problem.structure.farthest([sheet])
        proved = 1.0
        for beyond in _BEYOND:
            until = min(r + beyond, 1.0)
            if until == 1.0:
                break
            limit = min(deadline, time.perf_counter() + _SECONDS_PER_PART)
            chains = Chains(cover, 0.0, until, start=Ends(q[None], _SLACK, cover.one_sided), deadline=limit)
            if chains.prove(limit).proved:
                proved = until
                break
        found.append(Death((r, proved), tuple(map(str, causes))))
    return tuple(found)


def _undecided(problem: Problem, stopped: str) -> UndecidedError:
    """Return the error that says why the proof was not completed."""
    if leads_on(with_arm(problem, problem.arm.relaxed(_SLACK))):
        wider = f"{_SLACK:g} {problem.arm.limits.unit}"
        return UndecidedError(
            f"no motion was found; with limits wider by {wider} there is one, which rounding cannot tell apart",
            "widen the limits a little, or move the path",
            "tangency",
        )
    spent = "time" if stopped == "time" else "the number of boxes that may be looked at"
    message = f"there seems to be no motion, but {spent} ended before it was proved"
    return UndecidedError(message, "give more time", "budget")
