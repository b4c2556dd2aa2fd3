"""The angle domain: the feasible self-motion along a whole path."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._blocks import in_blocks
from selfmotion._checks import branch_index
from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms import RedundantArm, SelfMotion
from selfmotion.arms.cells import Cover
from selfmotion.constrained import constraints_of, why_empty
from selfmotion.constrained.self_motion import ConstrainedSelfMotion
from selfmotion.domain.feasible import FeasibleArcs, feasible_arcs
from selfmotion.domain.structure import DomainStructure
from selfmotion.domain.sweep import Sweep, sweep
from selfmotion.errors import Blocked, InvalidInputError
from selfmotion.intervals import IntervalSet
from selfmotion.paths import Path

_BISECTIONS = 50
_FEW_BISECTIONS = 20  # where each takes a cover
# Nothing is called empty that limits wider by this would fill [rad]: tangencies know u to about 1e-8 only.
_COARSE = 0.3  # spacing of the cells by which a pose is proved to be out of reach [rad]
_PLACES = 100  # at which poses are looked at where that takes a cover of each
_AT_ONCE = 10_000  # places along the path
_MOST_CAUSES = 4  # that are told of what blocks a pose
_SLACK = 1e-7
# Beyond reach by less than this part of the reach is on its rim.
_ROUNDING = 1e-12


class AngleDomain:
    """The set ``{(r, u, branch)}`` of postures that reach the path and respect every joint limit.

    Parameters
    ----------
    self_motion : SelfMotion
        The arm's one redundant degree.
    path : Path
    branches : sequence of int, optional
        Branches that a motion may use, which decide what is connected; all by default.

    Notes
    -----
    For the 3R arm without limits this is the region between the boundary lines of the seed's section IV-C; each joint
    limit cuts it further, and both elbow branches have their own.
    """

    def __init__(self, self_motion: SelfMotion, path: Path, branches: Sequence[int] | None = None) -> None:
        self.self_motion = self_motion
        self.path = path
        self.branches = branches

    def __call__(self, r: float, branch: int | str = 0) -> IntervalSet:
        """Return the feasible parameters at one point of the path.

        Parameters
        ----------
        r : float
            Path parameter in [0, 1].
        branch : int or str
            Index or name of the IK branch.

        Returns
        -------
        IntervalSet
            On the circle of circumference 2π.

        Raises
        ------
        InvalidInputError
            If r is outside [0, 1] or the branch is not known.
        """
        index = branch_index(self.self_motion.branches, branch)
        return self.sample([r])[index].interval_set(0)

    @cached_property
    def unconstrained(self) -> AngleDomain:
        """The domain without constraints beyond joint limits; the same if there are none."""
        motion = self.self_motion
        return AngleDomain(motion.free, self.path, self.branches) if isinstance(motion, ConstrainedSelfMotion) else self

    @cached_property
    def structure(self) -> DomainStructure:
        """Events along the path, and the connected parts of the domain; InvalidInputError for arms in space."""
        if not self.self_motion.has_structure:
            raise InvalidInputError(
                "arm", "has a self-motion whose structure along a path is not told", "use sample, or call the domain"
            )
        return DomainStructure(self.self_motion, self.path, self.branches)

    def sample(self, r: ArrayLike, slack: float = 0.0) -> tuple[FeasibleArcs, ...]:
        """Return the feasible arcs at path parameters `r`, shape (k,), per branch; for `slack` see `feasible_arcs`."""
        return feasible_arcs(self.self_motion, self.path(np.asarray(r, dtype=float)), slack)

    def sweep(self, r: float, branch: int | str = 0, count: int = 25) -> Sweep:
        """Return the postures at one point of the path, from the minimum to the maximum of each feasible interval.

        Parameters
        ----------
        r : float
            Path parameter in [0, 1].
        branch : int or str
            Index or name of the IK branch.
        count : int
            Number of postures per interval, its ends included.

        Returns
        -------
        Sweep
            See :func:`selfmotion.domain.sweep.sweep`.

        Raises
        ------
        InvalidInputError
            If r is outside [0, 1], `count` is below 2 or the branch is not known.
        """
        return sweep(self.self_motion, self.path(float(r)), branch, count)

    def empty_stretches(self, samples: int, branches: Sequence[int]) -> list[tuple[float, float]]:
        """Return where along the path no posture exists at all.

        Parameters
        ----------
        samples : int
            Number of places to look at, besides the path's breaks; the ends found are then bisected.
        branches : sequence of int
            The branches that may be used.

        Returns
        -------
        list of tuple
            First and last r of each stretch. Each holds a looked-at r where nothing is feasible even if the limits
            give by 1e-7 rad, so that rounding cannot make an emptiness that is none.
        """
        return stretches(lambda r: self.is_empty(r, branches), self.path.grid(samples - 1))

    def is_empty(self, r: FloatArray, branches: Sequence[int]) -> BoolArray:
        """Return whether nothing is feasible at `r`, shape (k,), not even if the limits give by 1e-7 rad."""

        def judge(part: FloatArray) -> BoolArray:
            arcs = self.sample(part, _SLACK)
            return np.asarray(np.all([arcs[branch].empty for branch in branches], axis=0))

        return in_blocks(judge, r, _AT_ONCE)


def angle_domain(arm: RedundantArm, path: Path) -> AngleDomain:
    """Return the angle domain of an arm with one redundant degree along a path.

    Parameters
    ----------
    arm : RedundantArm
    path : Path

    Returns
    -------
    AngleDomain
        Call it with ``(r, branch)`` for an :class:`~selfmotion.intervals.IntervalSet`.

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy, or one of the two is something else.
    """
    for name, given, wanted in (("arm", arm, RedundantArm), ("path", path, Path)):
        if not isinstance(given, wanted):
            raise InvalidInputError(name, f"is a {type(given).__name__}", f"give the {name} itself")
    return AngleDomain(arm.self_motion(), path)


def stretches(
    holds: Callable[[FloatArray], BoolArray], r: FloatArray, bisections: int = _BISECTIONS
) -> list[tuple[float, float]]:
    """Return the r-intervals on which the predicate `holds`, sampled at `r` and bisected at their ends."""
    flags = holds(r)
    change = np.flatnonzero(flags[1:] != flags[:-1])
    out, into = r[change], r[change + 1]
    for _ in range(bisections if len(change) else 0):
        middle = 0.5 * (out + into)
        same = holds(middle) == flags[change]
        out, into = np.where(same, middle, out), np.where(same, into, middle)
    ends = np.where(flags[change], out, into)
    edges = [float(r[0])] * bool(flags[0]) + ends.tolist() + [float(r[-1])] * bool(flags[-1])
    return list(zip(edges[::2], edges[1::2], strict=True))


def out_of_reach(arm: RedundantArm, x: FloatArray) -> BoolArray:
    """Return whether task points `x` (..., 2) are out of geometric reach by more than rounding."""
    return np.asarray(arm.shortfall(x) > _ROUNDING * arm.reach)


def blocked_at(arm: RedundantArm, path: Path, r: float, branches: Sequence[int]) -> bool:
    """Return whether no posture exists at `r`: out of reach, or for one redundant degree by the joint limits.

    Of an arm that is not rigorous, only what is out of reach is told.
    """
    if out_of_reach(arm, path(r)):
        return True
    if not arm.has_structure:
        return arm.n_u == 1 and arm.rigorous and _is_empty(_covers(arm, branches), path(r))
    return bool(angle_domain(arm, path).is_empty(np.array([r]), branches)[0])


def blocked_stretches(arm: RedundantArm, path: Path, samples: int, branches: Sequence[int]) -> list[Blocked]:
    """Return the stretches of the path that the arm cannot follow, with their cause.

    Parameters
    ----------
    arm : RedundantArm
    path : Path
    samples : int
        Number of places to look at.
    branches : sequence of int
        The branches that may be used.

    Returns
    -------
    list of Blocked
        Out of geometric reach, for any arm; empty because of joint limits and other constraints, for one redundant
        degree and a rigorous arm. In the order of the path.
    """
    found = [
        Blocked(ends, "out of reach", float(arm.shortfall(path(np.linspace(*ends, 101))).max()))
        for ends in stretches(lambda r: out_of_reach(arm, path(r)), path.grid(samples - 1))
    ]
    if arm.n_u == 1 and arm.rigorous:
        if arm.has_structure:
            empty = angle_domain(arm, path).empty_stretches(samples, branches)
        else:
            covers = _covers(arm, branches)
            empty = stretches(
                lambda r: np.array([_is_empty(covers, x) for x in path(r)], dtype=bool),
                path.grid(min(samples - 1, _PLACES)), _FEW_BISECTIONS,
            )  # fmt: skip
        for low, high in empty:
            if not any(low <= part.r[1] and part.r[0] <= high for part in found):
                found.append(blocked_by(arm, path, (low, high), branches))
    return sorted(found, key=lambda part: part.r)


def blocked_by(arm: RedundantArm, path: Path, r: tuple[float, float], branches: Sequence[int]) -> Blocked:
    """Return a stretch where no posture exists with what forbids them: limits alone, or other constraints too.

    Parameters
    ----------
    arm : RedundantArm
    path : Path
    r : tuple of float
        First and last path parameter; the middle is looked at.
    branches : sequence of int
        The branches that may be used.

    Returns
    -------
    Blocked
    """
    causes = [cause for cover in _covers(arm, branches) for cause in why_empty(cover, path(0.5 * sum(r)), _COARSE)]
    return Blocked(r, cause_of(arm, causes), limits=tuple(dict.fromkeys(causes))[:_MOST_CAUSES])


def cause_of(arm: RedundantArm, causes: Sequence[str]) -> str:
    """Return what the causes of a blocked stretch have in common.

    Parameters
    ----------
    arm : RedundantArm
    causes : sequence of str
        What constraints beyond joint limits forbid there, in words.

    Returns
    -------
    str
        ``"joint limits"`` without any, ``"singular postures"`` if these are all, else ``"obstacles"``.
    """
    singular = {c.cause(0) for c in constraints_of(arm) if c.check == "singularity"}
    return "joint limits" if not causes else "singular postures" if singular.issuperset(causes) else "obstacles"


def _covers(arm: RedundantArm, branches: Sequence[int]) -> list[Cover]:
    """Return the covers that together hold the postures on some branches."""
    if len(branches) == len(arm.branches):
        return [arm.cover()]
    return [arm.cover(arm.branches[branch]) for branch in branches]


def _is_empty(covers: list[Cover], x: FloatArray) -> bool:
    """Return whether no posture inside the limits does the task at x."""
    return all(len(cover.cells(x, _COARSE)) == 0 for cover in covers)
