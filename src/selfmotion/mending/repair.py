"""Repair of a sampled motion by self-motion (the seed's section II, Fig. 2).

Runs of connected rows are kept as they are, others are planned anew. Which runs can follow each other is read off the
structure of the angle domain: a motion may go from one sheet to another only where the sheets join. Of all choices the
one is taken that costs least: joint travel between the kept runs, and a price for what is given up, so that a few
improper postures are replaced and not visited at great expense. Between kept runs the arm moves by self-motion while
the tool goes on along the path or, where the path leaves no room, stands still.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import number
from selfmotion._types import BoolArray, FloatArray
from selfmotion.breaks import Break, connectivity
from selfmotion.constrained import constraints_of, keeps_constraints
from selfmotion.constrained.between import not_clear
from selfmotion.errors import UnrepairableError
from selfmotion.judgement import Judgement, Tolerances, judge, measured
from selfmotion.mending.bridge import PLAN_ANEW, bridge
from selfmotion.mending.filling import on_path, refined
from selfmotion.problem import Posture, Problem

# Nothing is called impossible that limits wider by this would allow [rad].
_SLACK = 1e-7
# A row this near to an end of the path is at it.
_AT_END = 1e-9
# Steps that turn out to be jumps once their neighbours are mended are mended too, in so many rounds.
_ROUNDS = 6


@dataclass(frozen=True)
class Repair:
    """A sampled motion made continuous.

    Attributes
    ----------
    r : array, shape (m,)
        Not descending; a value may stand in several rows, between which the arm moves by self-motion alone.
    q : array, shape (m, n)
    kept : array of bool, shape (k,)
        Which of the given rows are in it as they were.
    breaks : tuple of Break
        What was wrong before.
    judgement : Judgement
        The verdict on the repaired motion; it holds.
    """

    r: FloatArray
    q: FloatArray
    kept: BoolArray
    breaks: tuple[Break, ...]
    judgement: Judgement


class _Piece(NamedTuple):
    """Connected rows on one sheet: indices of the first and last, and the sheet."""

    first: int
    last: int
    sheet: int


def repair(
    problem: Problem, r: ArrayLike, q: ArrayLike, tolerances: Tolerances | None = None, keep: float = 30.0
) -> Repair:
    """Make a sampled motion continuous by self-motion.

    Parameters
    ----------
    problem : Problem
        Of an arm with one redundant degree.
    r : array_like, shape (k,)
        Path parameters, not descending.
    q : array_like, shape (k, n)
        Joint angles [rad]; limited joints as they stand, free ones modulo 2π. Rows that miss the path by up to
        ``tolerances.between`` are first put on it.
    tolerances : Tolerances, optional
        What :func:`~selfmotion.judgement.judge` must accept.
    keep : float
        What the rows are worth: the joint travel ``Σ|Δθ_i|`` [rad] that may be spent to keep a whole motion's, and
        accordingly less for a part of it. Zero keeps only what is on the way, a large number all that can be kept.

    Returns
    -------
    Repair

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy, or the motion is none; see :func:`connectivity`.
    UnrepairableError
        If no continuous motion gets from the path's start to its end, with the place; or, and then it is not proved, if
        none was found or what was found does not pass :func:`judge`.
    """
    allowed = Tolerances.given(tolerances)
    problem.arm.self_motion()  # refuses another degree of redundancy
    worth = number("keep", keep, 0.0)
    r, q = measured(problem, r, q, allowed)[1:3]
    before = connectivity(problem, r, q, allowed).breaks
    on = _put_on_path(problem, r, q, allowed)
    found = _mended(problem, r, on, allowed, worth)
    if problem.cyclic and not judge(problem, found.r, found.q, allowed).holds:
        first = {"q": found.q[0]}  # the motion shall end as it begins
        closed = Problem(problem.arm, problem.path, first, first, elbow=problem.elbow)
        found = _mended(closed, r, on, allowed, worth)
    verdict = judge(problem, found.r, found.q, allowed)
    if not verdict.holds:
        failure = verdict.failures[0]
        raise UnrepairableError(f"the repaired motion does not hold: {failure}", PLAN_ANEW, failure.r, proved=False)
    return Repair(found.r, found.q, found.kept & (on == q).all(axis=1), before, verdict)


class _Mended(NamedTuple):
    """A motion made continuous, and which of the given rows it keeps."""

    r: FloatArray
    q: FloatArray
    kept: BoolArray


def _mended(problem: Problem, r: FloatArray, q: FloatArray, allowed: Tolerances, worth: float) -> _Mended:
    """Mend a motion whose rows are on the path where they can be."""
    found = connectivity(problem, r, q, allowed)
    if found.holds and judge(problem, r, q, allowed).holds:
        return _Mended(r, q, np.ones(len(r), bool))
    rows = _Rows(problem, r, q, found.bad_rows, found.broken_steps)
    for _ in range(_ROUNDS):
        new_r, new_q, kept = _joined(problem, rows, worth)
        new_r, new_q, jumps = refined(problem, new_r, new_q, lambda r, q: _wanting(problem, r, q, allowed))
        if not (jumps and rows.tear(new_r[jumps])):
            break
    return _Mended(new_r, new_q, kept)


def _joined(problem: Problem, rows: _Rows, worth: float) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the motion through the rows worth keeping, or through none of them if obstacles leave no way to them."""
    chain = _chain(problem, rows, worth)
    try:
        return rows.joined(chain)
    except UnrepairableError:
        if not chain or not constraints_of(problem.arm):
            raise
        return rows.joined([])


def _wanting(problem: Problem, r: FloatArray, q: FloatArray, allowed: Tolerances) -> BoolArray:
    """Return the steps that :func:`judge` would not accept."""
    motion = measured(problem, r, q, allowed)
    return motion.jumps | motion.coarse | not_clear(problem.arm, motion.q)


def _put_on_path(problem: Problem, r: FloatArray, q: FloatArray, allowed: Tolerances) -> FloatArray:
    """Return the rows with those that miss the path by little moved onto it."""
    arm, x = problem.arm, problem.path(r)
    miss = arm.task_error(q, x)
    near = (miss > allowed.tracking * arm.reach) & (miss <= allowed.between * arm.reach)
    moved = q.copy()
    moved[near], fits = on_path(problem, r[near], q[near])
    moved[near] = np.where(fits[:, None], moved[near], q[near])
    return moved


class _Rows:
    """The given rows, with the start and end posture that the problem asks for as rows of their own."""

    def __init__(self, problem: Problem, r: FloatArray, q: FloatArray, bad: BoolArray, broken: BoolArray) -> None:
        self.problem = problem
        self.count = len(r)
        starts, ends = (_postures(problem, posture, at) for posture, at in ((problem.start, 0.0), (problem.end, 1.0)))
        self.must_start, self.must_end = len(starts) > 0, len(ends) > 0
        self.before = len(starts[:1])
        self.r = np.concatenate([np.zeros(len(starts[:1])), r, np.ones(len(ends[:1]))])
        self.q = np.concatenate([starts[:1], q, ends[:1]])
        first, last = np.ones(self.before, bool), np.ones(len(ends[:1]), bool)
        self.bad = np.concatenate([~first, bad, ~last])
        self.broken = np.concatenate([first, broken, last])

    def pieces(self) -> list[_Piece]:
        """Return the longest connected rows that lie in one cell of the structure each."""
        structure = self.problem.structure
        cell = np.searchsorted([c.r[1] for c in structure.cells], self.r)
        cut = self.broken | (np.diff(cell) != 0) | self.bad[1:] | self.bad[:-1]
        edges = np.concatenate([[0], np.flatnonzero(cut) + 1, [len(self.r)]])
        pieces = []
        for first, last in zip(edges[:-1].tolist(), (edges[1:] - 1).tolist(), strict=True):
            if self.bad[first]:
                continue
            k = (first + last) // 2
            arm = self.problem.arm
            branches = [b for b in self.problem.elbow_branches if arm.is_on_branch(self.q[k], b, 1e-9)]
            u = float(arm.u_of(self.q[k])[0])
            sheets = [s for b in branches for s in structure.sheet_at(float(self.r[k]), u, b, 1e-7, self.q[k])]
            if sheets:
                pieces.append(_Piece(first, last, sheets[0]))
        return pieces

    def tear(self, r: FloatArray) -> bool:
        """Call the steps that lie across parameters `r` broken; return whether any was not so before."""
        across = [(self.r[:-1] <= at + _AT_END) & (at - _AT_END <= self.r[1:]) for at in r]
        new = np.logical_or.reduce(across) & ~self.broken
        self.broken |= new
        return bool(new.any())

    def joined(self, chain: list[_Piece]) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Return the motion through the pieces of `chain`, and which of the given rows it keeps."""
        kept = np.zeros(len(self.r), bool)
        parts: list[tuple[FloatArray, FloatArray]] = []
        for before, after in pairwise([None, *chain, None]):
            if not self._follows(before, after):
                low, high = -1 if before is None else before.last, len(self.r) if after is None else after.first
                start = (0.0, None) if before is None else (float(self.r[low]), self.q[low])
                end = (1.0, None) if after is None else (float(self.r[high]), self.q[high])
                parts.append(bridge(self.problem, start, end, self.r[low + 1 : high]))
            if after is not None:
                rows = slice(after.first, after.last + 1)
                kept[rows] = True
                parts.append((self.r[rows], self.q[rows]))
        r, q = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        return r, self.problem.arm.limits.continuous(q), kept[self.before : self.before + self.count]

    def _follows(self, before: _Piece | None, after: _Piece | None) -> bool:
        """Return whether nothing is missing between two pieces, or between a piece and an end of the path."""
        if before is None:
            return after is not None and bool(self.r[after.first] <= _AT_END)
        if after is None:
            return bool(self.r[before.last] >= 1 - _AT_END)
        return after.first == before.last + 1 and not self.broken[before.last]


def _postures(problem: Problem, posture: Posture | None, r: float) -> FloatArray:
    """Return the joint angles that a given posture may mean, shape (m, n)."""
    arm = problem.arm
    if posture is None:
        return np.empty((0, arm.n))
    if posture.q is not None:
        return posture.q[None]
    q = np.array([arm.solve(problem.path(r), posture.u, branch)[0] for branch in problem.elbow_branches])
    q = q[arm.limits.admit(q) & keeps_constraints(arm, q)]
    return np.concatenate([arm.limits.lift(one[None, None])[0][0] for one in q]) if len(q) else np.empty((0, arm.n))


def _chain(problem: Problem, rows: _Rows, keep: float) -> list[_Piece]:
    """Return the pieces that the motion shall pass: the cheapest choice that one continuous motion can make."""
    structure, pieces = problem.structure, rows.pieces()
    count = len(structure.sheets)
    onward: BoolArray = np.array(
        [[b in structure.reachable[a] for b in range(count)] for a in range(count)], bool
    ).reshape(count, count)
    first = np.array([sheet.r[0] <= 0.0 for sheet in structure.sheets], bool)
    last = np.array([sheet.r[1] >= 1.0 for sheet in structure.sheets], bool)
    from_start, to_end = np.asarray(onward[first].any(axis=0)), np.asarray(onward[:, last].any(axis=1))
    if not (from_start & to_end).any():
        raise _blocked(problem, np.flatnonzero(from_start).tolist())
    at_first, at_last, sheets = np.array(pieces, int).reshape(-1, 3).T
    begins, ends, entry, leave = rows.r[at_first], rows.r[at_last], rows.q[at_first], rows.q[at_last]
    cost, before = np.full(len(pieces), np.inf), np.full(len(pieces), -1)
    for k in range(len(pieces)):
        if from_start[sheets[k]] and (k == 0 or not rows.must_start):
            cost[k] = keep * begins[k]
        travel = np.abs(problem.arm.limits.steps(leave[:k], entry[k])).sum(axis=-1)
        ways = np.where(onward[sheets[:k], sheets[k]], cost[:k] + travel + keep * (begins[k] - ends[:k]), np.inf)
        if k and ways.min() < cost[k]:
            before[k] = int(np.argmin(ways))
            cost[k] = ways[before[k]]
    total: FloatArray = np.where(to_end[sheets], cost + keep * (1.0 - ends), np.inf)
    if rows.must_end:
        total[:-1] = np.inf
    if not rows.must_start and not rows.must_end and (not len(total) or total.min() >= keep):
        return []
    if not len(total) or not np.isfinite(total.min()):
        raise _blocked(problem, sheets[:1].tolist())
    chain = [int(np.argmin(total))]
    while before[chain[-1]] >= 0:
        chain.append(int(before[chain[-1]]))
    return [pieces[k] for k in reversed(chain)]


def _blocked(problem: Problem, sheets: list[int]) -> UnrepairableError:
    """Return the error that says how far a motion from any of `sheets` gets, and what stops it."""
    r, causes = problem.structure.farthest(sheets)
    if r >= 1.0:  # only the end posture is on another sheet
        message = "no continuous motion joins the start and the end posture"
        return UnrepairableError(message, "ask for another start or end", r, proved=False)
    why = f", where the last part of the self-motion that it can be on ends: {' and '.join(map(str, causes))}"
    message = f"no continuous motion follows the path from its start to its end: it gets to r = {r:.10g}"
    wider = Problem(problem.arm.relaxed(_SLACK), problem.path, elbow=problem.elbow)
    return UnrepairableError(
        message + (why if causes else ""),
        "widen the limits, move the path, or split it there",
        r,
        proved=not wider.structure.is_connected,
    )
