"""The angle domain: the feasible self-motion along a whole path."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.arms import SelfMotion
from selfmotion.domain.feasible import FeasibleArcs, feasible_arcs
from selfmotion.errors import Blocked
from selfmotion.intervals import IntervalSet
from selfmotion.paths import Path
from selfmotion.quadrature import panel_edges

_BISECTIONS = 50


class AngleDomain:
    """The set ``{(r, u, branch)}`` of postures that reach the path and respect every joint limit.

    Parameters
    ----------
    self_motion : SelfMotion
        The arm's one redundant degree.
    path : Path

    Notes
    -----
    For the 3R arm without limits this is the region between the boundary lines of the seed's section IV-C; each joint
    limit cuts it further, and both elbow branches have their own.
    """

    def __init__(self, self_motion: SelfMotion, path: Path) -> None:
        self.self_motion = self_motion
        self.path = path

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
        """
        index = branch if isinstance(branch, int) else self.self_motion.branches.index(branch)
        return self.sample([r])[index].interval_set(0)

    def sample(self, r: ArrayLike) -> tuple[FeasibleArcs, ...]:
        """Return the feasible arcs at path parameters `r`, shape (k,), per branch."""
        return feasible_arcs(self.self_motion, self.path(np.asarray(r, dtype=float)))

    def empty_stretches(self, samples: int, branches: ArrayLike) -> list[tuple[float, float]]:
        """Return where along the path no posture exists at all.

        Parameters
        ----------
        samples : int
            Number of places to look at, besides the path's breaks; the ends found are then bisected.
        branches : array_like of int
            The branches that may be used.

        Returns
        -------
        list of tuple
            First and last r of each stretch, to about 1e-15. Each holds a looked-at r where nothing is feasible.
        """
        allowed = list(np.atleast_1d(np.asarray(branches)))

        def empty(r: FloatArray) -> Any:
            arcs = self.sample(r)
            return np.all([arcs[branch].empty for branch in allowed], axis=0)

        return stretches(empty, panel_edges(self.path.breaks, samples - 1))


def stretches(holds: Any, r: FloatArray) -> list[tuple[float, float]]:
    """Return the r-intervals on which the predicate `holds`, sampled at `r` and bisected at their ends."""
    flags = np.asarray(holds(r))
    change = np.flatnonzero(flags[1:] != flags[:-1])
    out, into = r[change].copy(), r[change + 1].copy()
    for _ in range(_BISECTIONS if len(change) else 0):
        middle = 0.5 * (out + into)
        same = np.asarray(holds(middle)) == flags[change]
        out, into = np.where(same, middle, out), np.where(same, into, middle)
    ends = np.where(flags[change], out, into)
    edges = [float(r[0])] * bool(flags[0]) + ends.tolist() + [float(r[-1])] * bool(flags[-1])
    return list(zip(edges[::2], edges[1::2], strict=True))


def blocked_stretches(arm: Any, path: Path, samples: int, branches: ArrayLike) -> list[Blocked]:
    """Return the stretches of the path that the arm cannot follow, with their cause.

    Parameters
    ----------
    arm : PlanarArm
    path : Path
    samples : int
        Number of places to look at.
    branches : array_like of int
        The branches that may be used.

    Returns
    -------
    list of Blocked
        Out of geometric reach, for any arm; empty because of joint limits, for one redundant degree. In the
        order of the path.
    """
    center, inner, outer = arm.annulus

    def shortfall(r: FloatArray) -> FloatArray:
        distance = np.hypot(*(path(r) - center).T)
        return np.maximum(distance - outer, inner - distance)

    def beyond(r: FloatArray) -> Any:
        return shortfall(r) > 1e-12 * arm.reach

    found = [
        Blocked(ends, "out of reach", float(shortfall(np.linspace(*ends, 101)).max()))
        for ends in stretches(beyond, panel_edges(path.breaks, samples - 1))
    ]
    if arm.n_u == 1:
        domain = AngleDomain(arm.self_motion(), path)
        for low, high in domain.empty_stretches(samples, branches):
            if not any(low <= part.r[1] and part.r[0] <= high for part in found):
                found.append(Blocked((low, high), "joint limits"))
    return sorted(found, key=lambda part: part.r)
