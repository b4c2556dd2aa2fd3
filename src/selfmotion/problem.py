"""What is asked: an arm, a path, and what its motion must respect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import choice, finite_array, integer, read_only
from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.arms import PlanarArm
from selfmotion.domain import AngleDomain
from selfmotion.errors import InvalidInputError
from selfmotion.objectives import OBJECTIVES, Objective, joint_weights
from selfmotion.paths import Path
from selfmotion.quadrature import panel_edges

MAX_SAMPLES = 1_000_000
# A posture given by its joints must have the tool on the path to this part of the reach.
_ON_PATH = 1e-6
# A posture may stand on a limit up to rounding.
_ON_LIMIT = 1e-9
_LOOK_AT = 1001


@dataclass(frozen=True)
class Posture:
    """A posture that a motion starts or ends with.

    Attributes
    ----------
    u : array, shape (n_u,)
        Redundancy vector [rad].
    q : array, shape (n,), or None
        Joint angles, turns included, if they were given.
    branch : int or None
        The branch, if the joints were given.
    """

    u: FloatArray
    q: FloatArray | None = None
    branch: int | None = None


class Problem:
    """A path for the tool of a redundant arm, and what its joint motion must respect.

    Parameters
    ----------
    arm : PlanarArm
        With at least one redundant degree.
    path : Path
    start, end : array_like or mapping, optional
        Posture at r = 0 and r = 1: the redundancy vector, or ``{"u": …}``, or ``{"q": …}`` for joint angles.
    elbow : {"any", "positive", "negative"}
        The IK branches that may be used.
    cyclic : {False, "exact", "modulo"}
        Whether the joint motion along a closed path must close too.
    weights : array_like, shape (n,), optional
        Weight of each joint in the objective; all 1 by default.
    objective : {"joint_travel", "l1", "l2"}
        See :mod:`selfmotion.objectives`.
    samples : int
        Number of samples N of the chord sum and of the trajectory, ends included.

    Raises
    ------
    InvalidInputError
        If something is malformed, contradictory, or no point of the path is in reach.
    """

    def __init__(
        self,
        arm: PlanarArm,
        path: Path,
        start: ArrayLike | Mapping[str, Any] | None = None,
        end: ArrayLike | Mapping[str, Any] | None = None,
        elbow: Literal["any", "positive", "negative"] = "any",
        cyclic: Literal[False, "exact", "modulo"] = False,
        weights: ArrayLike | None = None,
        objective: str = "joint_travel",
        samples: int = 1000,
    ) -> None:
        self.arm = arm
        self.path = path
        if arm.n_u < 1:
            raise InvalidInputError("arm", "has no redundant degree of freedom", "add a joint or free the direction")
        self.samples = integer("samples", samples, 2, MAX_SAMPLES)
        self.elbow = choice("elbow", elbow, ("any", *arm.branches))
        self.cyclic = cyclic if cyclic is False else choice("cyclic", cyclic, ("exact", "modulo"))
        if self.cyclic and not path.is_closed:
            raise InvalidInputError("cyclic", "needs a closed path", "close the path or set cyclic: false", cyclic)
        self.weights = read_only(joint_weights(weights, arm.n))
        self.objective: Objective = OBJECTIVES[choice("objective", objective, OBJECTIVES)]()
        self._check_reach()
        self.start = self._posture("start", start, 0.0)
        self.end = self._posture("end", end, 1.0)

    def __repr__(self) -> str:
        return f"Problem({self.arm!r}, {self.path!r}, elbow={self.elbow!r}, objective={self.objective.kind!r})"

    @property
    def branches(self) -> list[int]:
        """Indices of the branches that may be used throughout."""
        if self.start is not None and self.start.branch is not None:
            return [self.start.branch]
        return [0, 1] if self.elbow == "any" else [self.arm.branches.index(self.elbow)]

    @property
    def grid(self) -> FloatArray:
        """The N sample parameters, shape (samples,)."""
        return np.linspace(0.0, 1.0, self.samples)

    @property
    def rows(self) -> FloatArray:
        """Where a trajectory has rows: the sample grid and every given waypoint, ascending."""
        return np.unique(np.concatenate([self.grid, self.path.waypoints]))

    def _check_reach(self) -> None:
        center, inner, outer = self.arm.annulus
        offsets = self.path(panel_edges(self.path.breaks, _LOOK_AT)) - center
        distance = np.hypot(offsets[:, 0], offsets[:, 1])
        slack = 1e-12 * self.arm.reach
        if ((distance < inner - slack) | (distance > outer + slack)).all():
            raise InvalidInputError(
                "path",
                f"has no point in reach: it runs {distance.min():.6g} to {distance.max():.6g} away from "
                f"{'the base' if self.arm.direction is None else 'the centre of reach'}, "
                f"the arm reaches from {inner:.6g} to {outer:.6g}",
                "are the units of arm and path the same?",
            )

    def _posture(self, name: str, given: ArrayLike | Mapping[str, Any] | None, r: float) -> Posture | None:
        if given is None:
            return None
        entry = given if isinstance(given, Mapping) else {"u": given}
        if set(entry) not in ({"u"}, {"q"}):
            raise InvalidInputError(name, "needs either u or q", "write {u: […]} or {q: […]}", dict(entry))
        if "u" in entry:
            posture = Posture(finite_array(f"{name}.u", entry["u"], 1, self.arm.n_u))
        else:
            posture = self._from_joints(name, finite_array(f"{name}.q", entry["q"], 1, self.arm.n), r)
        self._check_inside(name, posture, r)
        return posture

    def _from_joints(self, name: str, q: FloatArray, r: float) -> Posture:
        arm, target = self.arm, self.path(r)
        miss = float(np.hypot(*(arm.forward(q) - target)))
        if miss > _ON_PATH * arm.reach:
            raise InvalidInputError(
                f"{name}.q",
                f"puts the tool {miss:.6g} away from the path's point {np.round(target, 6).tolist()}",
                "give joint angles that hold the tool on the path, or give u",
                q.tolist(),
            )
        if arm.direction is not None and abs(np.sin((q.sum() - arm.direction) / 2)) > _ON_PATH:
            raise InvalidInputError(f"{name}.q", "turns the last link away from its direction", "give u", q.tolist())
        branch = int(arm.branch_of(q))
        if self.elbow not in ("any", arm.branches[branch]) and abs(np.sin(q[1])) > _ON_LIMIT:
            raise InvalidInputError(
                f"{name}.q", f"has a {arm.branches[branch]} elbow", f"elbow is {self.elbow}", q.tolist()
            )
        return Posture(arm.u_of(q), q, branch)

    def _check_inside(self, name: str, posture: Posture, r: float) -> None:
        """Refuse a posture that no allowed branch can take, saying which constraint forbids it."""
        arm, target = self.arm, self.path(r)
        if posture.q is not None:
            excess = np.maximum(-arm.limits.margin(posture.q), 0.0)
            tried = [(excess, posture.q)]
        else:
            allowed = [0, 1] if self.elbow == "any" else [arm.branches.index(self.elbow)]
            tried = []
            for branch in allowed:
                q, ok = arm.solve(target, posture.u, branch)
                if not ok:
                    raise InvalidInputError(
                        f"{name}.u", f"is out of reach at r = {r:g}", self.feasible_at(r), posture.u.tolist()
                    )
                tried.append((arm.limits.excess(q), q))
        excess, q = min(tried, key=lambda pair: float(pair[0].max()))
        joint = int(np.argmax(excess))
        if excess[joint] > _ON_LIMIT:
            raise InvalidInputError(
                f"{name}.{'u' if posture.q is None else 'q'}",
                f"puts joint {joint + 1} at {q[joint]:.6g}, {excess[joint]:.6g} rad outside its limits",
                self.feasible_at(r),
                (posture.u if posture.q is None else posture.q).tolist(),
            )

    def feasible_at(self, r: float) -> str:
        """Return in words where u may lie at `r`."""
        if self.arm.n_u != 1:
            return "choose another redundancy vector"
        domain = AngleDomain(self.arm.self_motion(), self.path)
        allowed = self.arm.branches if self.elbow == "any" else (self.elbow,)
        parts = [f"{domain(r, branch)} with a {branch} elbow" for branch in allowed if domain(r, branch)]
        return f"u may lie in {' or '.join(parts)}" if parts else "no posture is feasible there"

    def offset_is_feasible(self, u: FloatArray, branch: int) -> bool:
        """Return whether a motion on `branch` may start with redundancy vector `u`."""
        q, ok = self.arm.solve(self.path(0.0), u, branch)
        return bool(ok) and bool((self.arm.limits.excess(q) <= _ON_LIMIT).all())


def same_direction(a: FloatArray, b: FloatArray) -> bool:
    """Return whether two redundancy vectors agree modulo 2π."""
    return bool((np.abs(wrap(a - b)) <= _ON_LIMIT).all())
