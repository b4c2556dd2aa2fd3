"""n-connectivity: which steps of a sampled motion no continuous motion explains, and why (the seed's Fig. 1)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import BoolArray, FloatArray
from selfmotion.angles import wrap
from selfmotion.constrained import constraints_of
from selfmotion.constrained.between import not_clear
from selfmotion.errors import InvalidInputError
from selfmotion.judgement import Tolerances, measured
from selfmotion.problem import Problem

# A posture whose sin θ2 is nearer to zero is at a fold, where branches meet.
_AT_FOLD = 1e-6
# A jump by whole turns leaves less than this besides [rad].
_BESIDES = 0.1


@dataclass(frozen=True)
class Break:
    """A place where a sampled motion is not connected.

    Attributes
    ----------
    row : int
        Data row, counted from 1; for a step the row before it.
    r : float
    kind : str
        Of a row: ``"off the path"``, ``"outside a limit"``, ``"forbidden"`` (by a further constraint, such as an
        obstacle), ``"wrong elbow"``. Of the step from this row to the next:
        ``"whole turn"``, ``"changes branch"``, ``"another part"`` (of the self-motion, to which none leads),
        ``"jumps"`` (along one and the same part), ``"too coarse"`` (the tool leaves the path between the rows),
        ``"not clear"`` (a further constraint is not surely kept between the rows, the joints on straight lines).
    size : float
        Distance from the path (in the unit of length), overrun of the limit, what a further constraint lacks, or the
        largest joint step, in the unit.
    joint : int or None
        Joint concerned, counted from 1.
    unit : str
        Of overruns and steps: ``"rad"``, or ``"m"`` of a joint that slides.
    cause : str
        Of what is forbidden, in words, such as ``"link 3 against obstacle 2"``.
    """

    row: int
    r: float
    kind: str
    size: float
    joint: int | None = None
    unit: str = "rad"
    cause: str = ""

    @property
    def is_step(self) -> bool:
        """Whether the step to the next row is broken, rather than the row itself."""
        return self.kind not in _ROW_KINDS

    def __str__(self) -> str:
        where = f"data row {self.row}, r = {self.r:.6g}"
        joint = "" if self.joint is None else f"joint {self.joint} "
        return f"{where}: {_WORDS[self.kind].format(joint=joint, size=self.size, unit=self.unit, cause=self.cause)}"


_ROW_KINDS = ("off the path", "outside a limit", "forbidden", "wrong elbow")
_WORDS = {
    "off the path": "the tool misses the path by {size:.3g}",
    "outside a limit": "{joint}is {size:.3g} {unit} outside its limits",
    "forbidden": "{cause} lacks {size:.3g} of what is asked for",
    "wrong elbow": "the elbow is not the one asked for",
    "whole turn": "{joint}jumps by a whole turn to the next row",
    "changes branch": "the elbow changes without passing a fold, {joint}by {size:.3g} {unit}",
    "another part": "the next row lies on another connected part of the self-motion, {joint}jumps by {size:.3g} {unit}",
    "jumps": "{joint}jumps by {size:.3g} {unit} along the self-motion",
    "too coarse": "the tool leaves the path by {size:.3g} before the next row",
    "not clear": "what is asked for beyond limits is not surely kept on the straight way to the next row",
}


@dataclass(frozen=True)
class Connectivity:
    """Where a sampled motion breaks n-connectivity.

    Attributes
    ----------
    breaks : tuple of Break
        In the order of the rows.
    bad_rows : array of bool, shape (k,)
        Rows that are no postures of the problem.
    broken_steps : array of bool, shape (k − 1,)
        Steps that no continuous motion explains; those from and to bad rows included.
    """

    breaks: tuple[Break, ...]
    bad_rows: BoolArray
    broken_steps: BoolArray

    @property
    def holds(self) -> bool:
        """Whether all samples are connected."""
        return not self.breaks


def connectivity(problem: Problem, r: ArrayLike, q: ArrayLike, tolerances: Tolerances | None = None) -> Connectivity:
    """Find the steps of a sampled motion that break its n-connectivity, and why.

    Parameters
    ----------
    problem : Problem
    r : array_like, shape (k,)
        Path parameters, not descending.
    q : array_like, shape (k, n)
        Joint angles [rad]; limited joints as they stand, free ones modulo 2π.
    tolerances : Tolerances, optional
        As for :func:`~selfmotion.judgement.judge`, whose criteria of continuity and tracking these are.

    Returns
    -------
    Connectivity

    Raises
    ------
    InvalidInputError
        If shapes do not fit, r descends or leaves [0, 1], a value is not finite, or no row at all has its tool near the
        path.
    """
    motion = measured(problem, r, q, tolerances)
    r, q, allowed, miss, steps, between = (
        motion.r, motion.q, motion.allowed, motion.miss, motion.steps, motion.between
    )  # fmt: skip
    arm = problem.arm
    excess = np.maximum(-motion.margins, 0.0)
    off = miss > allowed.tracking * arm.reach
    k = int(np.argmin(miss))
    if miss[k] > allowed.between * arm.reach:
        raise InvalidInputError(
            f"row {k + 1}, columns q1…q{arm.n}",
            f"come nearest to the path of all rows, and miss it by {miss[k]:.6g}",
            "is it this arm's motion, in radians, and this path?",
        )
    outside = excess.max(axis=1) > allowed.limit
    wrong = np.zeros(len(r), bool)
    if problem.elbow != "any":
        wrong = ~arm.is_on_branch(q, problem.elbow, _AT_FOLD)
    lacking = [np.zeros(len(r))] + [-c.margins(q).min(axis=1) - c.tolerance for c in constraints_of(arm)]
    lack, by = np.max(lacking, axis=0), np.argmax(lacking, axis=0)
    forbidden = lack > 0.0
    bad = off | outside | forbidden | wrong
    good = ~bad[1:] & ~bad[:-1]
    jumps = good & motion.jumps
    coarse = good & ~jumps & motion.coarse
    breaks = []
    for k in np.flatnonzero(bad).tolist():
        joint = int(np.argmax(excess[k]))
        kind = _kind_of_row(off[k], outside[k], forbidden[k])
        size = float(miss[k] if off[k] else excess[k, joint])
        found = Break(k + 1, float(r[k]), kind, size)
        if kind == "outside a limit":
            found = replace(found, joint=joint + 1, unit=arm.limits.units[joint])
        if kind == "forbidden":
            constraint = constraints_of(arm)[by[k] - 1]
            worst = constraint.margins(q[k : k + 1])[0]
            found = replace(found, size=-float(worst.min()), cause=constraint.cause(int(worst.argmin())))
        breaks.append(found)
    for k in np.flatnonzero(jumps).tolist():
        joint = int(np.argmax(steps[k]))
        size, unit = float(steps[k, joint]), arm.limits.units[joint]
        breaks.append(Break(k + 1, float(r[k]), _why(problem, r, q, k), size, joint + 1, unit))
    breaks += [Break(int(k) + 1, float(r[k]), "too coarse", float(between[k])) for k in np.flatnonzero(coarse)]
    near = good & ~jumps & ~coarse & not_clear(arm, q)
    breaks += [Break(int(k) + 1, float(r[k]), "not clear", float(steps[k].max())) for k in np.flatnonzero(near)]
    return Connectivity(tuple(sorted(breaks, key=lambda found: found.row)), bad, jumps | coarse | near | ~good)


def _kind_of_row(off: bool, outside: bool, forbidden: bool) -> str:
    """Return what is wrong with a row, its first fault."""
    return "off the path" if off else "outside a limit" if outside else "forbidden" if forbidden else "wrong elbow"


def _why(problem: Problem, r: FloatArray, q: FloatArray, k: int) -> str:
    """Return the kind of the break between rows k and k + 1, both of them postures of the problem."""
    arm, step = problem.arm, q[k + 1] - q[k]
    if np.abs(wrap(step, arm.limits.period)).max() < _BESIDES and np.abs(step).max() > np.pi:
        return "whole turn"
    branches = arm.branch_of(q[k : k + 2])
    if arm.n_u == 1:
        structure = problem.structure
        first, second = (
            set(structure.sheet_at(r[j], float(arm.u_of(q[j])[0]), int(branches[j - k]), q=q[j])) for j in (k, k + 1)
        )
        onward = set().union(*(structure.reachable[sheet] for sheet in first)) if first else set()
        if first and second and not onward & second:
            return "another part"
    at_fold = any(arm.is_on_branch(q[j], 0, _AT_FOLD) and arm.is_on_branch(q[j], 1, _AT_FOLD) for j in (k, k + 1))
    return "changes branch" if branches[0] != branches[1] and not at_fold else "jumps"
