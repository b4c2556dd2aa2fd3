"""What the structure of the angle domain says of a problem with given ends: computed with care, but no proof."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Literal

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.arms import RedundantArm
from selfmotion.certificate.chains import Ends
from selfmotion.constrained import unconstrained
from selfmotion.domain.fibre import Fibre, fibres
from selfmotion.paths.base import PLANE
from selfmotion.problem import Posture, Problem

# A posture this near to an interval of the self-motion is on it [rad].
_ON_SHEET = 1e-7
# A given posture is met within this [rad]: near folds joints move by the root of an error of u, 1e-6.
_SAME_POSTURE = 1e-5
_SAME_U = 2e-3
_SINGULAR = 1e-8  # parts of the reach
_QUITE_ANOTHER = 0.1  # [rad]


def with_arm(problem: Problem, arm: RedundantArm) -> Problem:
    """Return the same problem of another arm."""
    other = copy.copy(problem)
    other.arm = arm
    for known in ("structure", "blocked"):
        other.__dict__.pop(known, None)
    return other


def sheets_at_end(problem: Problem, name: Literal["start", "end"]) -> list[int]:
    """Return the sheets that a motion may start on, or end on."""
    structure, posture = problem.structure, getattr(problem, name)
    r = 0.0 if name == "start" else 1.0
    there = [k for k, sheet in enumerate(structure.sheets) if sheet.r[0] <= r <= sheet.r[1]]
    if posture is None:
        return there
    branches = problem.elbow_branches if posture.branches is None else posture.branches
    u = float(posture.u[0])
    on = {sheet for branch in branches for sheet in structure.sheet_at(r, u, branch, _ON_SHEET, posture.q)}
    return [k for k in there if k in on]


def leads_on(problem: Problem) -> bool:
    """Return whether some sheet that a motion may start on leads on to one that it may end on, as far as is known.

    Joint limits alone are regarded: what they leave no way for, an arm's further constraints do not either.
    """
    if not unconstrained(problem.arm).has_structure:
        return True
    reachable, last = problem.structure.reachable, set(sheets_at_end(problem, "end"))
    return any(last & reachable[k] for k in sheets_at_end(problem, "start"))


def earliest(problem: Problem, sheets: Iterable[int]) -> float:
    """Return the least r from which a motion gets to any of `sheets`."""
    structure, wanted = problem.structure, set(sheets)
    return min(
        (s.r[0] for s, onward in zip(structure.sheets, structure.reachable, strict=True) if onward & wanted),
        default=1.0,
    )


def ends(problem: Problem, name: Literal["start", "end"]) -> Ends:
    """Return the postures that the problem asks for at an end of the path, for a proof."""
    posture: Posture | None = getattr(problem, name)
    if posture is None:
        return Ends()
    limits = problem.arm.limits
    if posture.q is not None:
        return Ends(posture.q[None], _SAME_POSTURE, ~(np.isfinite(limits.lower) & np.isfinite(limits.upper)))
    x = problem.path(0.0 if name == "start" else 1.0)
    if len(x) > PLANE:  # which postures u stands for at folds and at singular ones is not known: any is allowed
        return Ends()
    q = np.array([problem.arm.solve(x, posture.u, branch)[0] for branch in problem.elbow_branches])
    if _leaves_a_joint_free(problem, x, posture.u):
        return Ends()
    return Ends(q, _SAME_U, np.ones(problem.arm.n, bool))


def _leaves_a_joint_free(problem: Problem, x: FloatArray, u: FloatArray) -> bool:
    """Return whether u does not say what the posture is: tools a little beside x are held by quite another one."""
    arm = problem.arm
    beside = x + _SINGULAR * arm.reach * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    q = arm.solve(beside, u[None], 0)[0]
    return bool(np.abs(wrap(q - q[0])).max() > _QUITE_ANOTHER)


def parts_at_start(problem: Problem) -> list[tuple[int, FloatArray]]:
    """Return the connected parts of the self-motion at r = 0: the sheet of each and one of its postures (n,)."""
    structure = problem.structure
    (fibre,) = fibres(structure.self_motion, problem.path(np.array([0.0])), problem.elbow_branches)
    wanted = sheets_at_end(problem, "start")
    found: dict[int, FloatArray] = {}
    for interval in fibre.intervals:
        low, high, turns = max(interval.arcs, key=lambda arc: arc[1] - arc[0])
        u = 0.5 * (low + high)
        q = _posture(problem, fibre, u, interval.branch, turns)
        for sheet in structure.sheet_at(0.0, u, interval.branch, _ON_SHEET, q):
            if sheet in wanted:
                found.setdefault(sheet, q)
    return sorted(found.items())


def _posture(problem: Problem, fibre: Fibre, u: float, branch: int, turns: tuple[int, ...]) -> FloatArray:
    """Return the posture at u with these turns of the joints whose turns are counted."""
    arm = problem.arm
    q = arm.solve(problem.path(0.0), [u], branch)[0]
    q = arm.limits.lift(q[None, None].copy()).q[0, 0]
    for joint, start, turn in zip(fibre.turning, fibre.turn_angles(np.array([u]), branch)[0], turns, strict=True):
        q[joint] = start + 2 * np.pi * turn
    return q
