"""What is asked: an arm, a path, and what its motion must respect."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import angles, choice, finite_array, integer, number, positive, read_only
from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import RedundantArm
from selfmotion.arms.limits import ON_LIMIT
from selfmotion.arms.protocols import length_unit, u_period, u_steps
from selfmotion.constrained import Constraint, SingularityMargin, constrained, constraints_of, unconstrained
from selfmotion.domain import DomainStructure, angle_domain, blocked_at, blocked_stretches, out_of_reach
from selfmotion.errors import Blocked, InvalidInputError
from selfmotion.objectives import OBJECTIVES, Objective, joint_weights
from selfmotion.paths import Path
from selfmotion.paths.base import PLANE, POSE, SPACE
from selfmotion.quadrature import GAUSS, DyadicGauss, dyadic_gauss
from selfmotion.units import contradiction, too_small

if TYPE_CHECKING:
    from selfmotion.scene import Obstacle, Scene

MAX_SAMPLES = 1_000_000
# A posture given by its joints must have the tool on the path to this part of the reach.
_ON_PATH = 1e-6
Margin = Literal["clearance", "least_singular_value"]
"""What a problem may ask for beyond joint limits, as a distance from where postures are forbidden."""
CHECKS: dict[Margin, str] = {"clearance": "clearance", "least_singular_value": "singularity"}
"""The check that fails where a margin is not kept."""
ANGLE = 1e-6
"""Error of an angle that is still the angle asked for [rad]."""
_LOOK_AT = 1000
# Panels of a quadrature along a path, besides its breaks; nodes of all their halves together.
_PANELS = 4
_MOST_NODES = 5000


@dataclass(frozen=True)
class Posture:
    """A posture that a motion starts or ends with.

    Attributes
    ----------
    u : array, shape (n_u,)
        Redundancy vector [rad].
    q : array, shape (n,), or None
        Joint angles, turns included, if they were given.
    branches : tuple of int or None
        The branches that the joints are on, if those were given; several at a fold.
    """

    u: FloatArray
    q: FloatArray | None = None
    branches: tuple[int, ...] | None = None


class Problem:
    """A path for the tool of a redundant arm, and what its joint motion must respect.

    Parameters
    ----------
    arm : RedundantArm
        With at least one redundant degree.
    path : Path
    start, end : array_like or mapping, optional
        Posture at r = 0 and r = 1: the redundancy vector, shape (n_u,), or ``{"u": …}``, or ``{"q": …}`` for joint
        angles, shape (n,) [rad].
    elbow : str
        The IK branches that may be used: ``"any"`` or one of the arm's, such as ``"positive"``; in problem files
        ``branch`` means the same.
    cyclic : {False, "exact", "modulo"}
        Whether the joint motion along a closed path must close too.
    weights : array_like, shape (n,), optional
        Weight of each joint in the objective; all 1 by default.
    objective : {"joint_travel", "l1", "l2"}
        See :mod:`selfmotion.objectives`.
    samples : int
        Number of samples N of the chord sum and of the trajectory, ends included.
    obstacles : sequence of Obstacle
        What no link may come near, see :mod:`selfmotion.scene`: in the plane of a planar arm, or in the frame of the
        base of an arm in space.
    clearance : float
        Least distance between links and obstacles, in the unit of length.
    self_collision : bool
        Whether links that are not neighbours must not touch each other.
    least_singular_value : float, optional
        Least singular value that the task's Jacobian may have, lengths as parts of the reach: how far from singular
        postures the motion stays.

    Raises
    ------
    InvalidInputError
        If something is malformed, contradictory, or no point of the path is in reach.
    """

    def __init__(
        self,
        arm: RedundantArm,
        path: Path,
        start: ArrayLike | Mapping[str, Any] | None = None,
        end: ArrayLike | Mapping[str, Any] | None = None,
        elbow: str = "any",
        cyclic: Literal[False, "exact", "modulo"] = False,
        weights: ArrayLike | None = None,
        objective: str = "joint_travel",
        samples: int = 1000,
        obstacles: Sequence[Obstacle] = (),
        clearance: float = 0.0,
        self_collision: bool = False,
        least_singular_value: float | None = None,
    ) -> None:
        for name, given, wanted in (("arm", arm, RedundantArm), ("path", path, Path)):
            if not isinstance(given, wanted):
                raise InvalidInputError(name, f"is a {type(given).__name__}", f"give the {name} itself")
        _check_dimensions(arm, path)
        self.scene, constraints = _constraints(arm, obstacles, clearance, self_collision, least_singular_value)
        self.least_singular_value = _least_singular_value((*constraints, *constraints_of(arm)))
        self.arm = constrained(arm, constraints)
        self.path = path
        self.path_unit: str | None = None  # of its lengths, where it was converted to one
        self.samples = integer("samples", samples, 2, MAX_SAMPLES)
        self.elbow = choice("elbow", elbow, ("any", *arm.branches))
        if self.elbow != "any":
            arm.boxes(self.elbow)  # which not every arm has of a branch
        self.cyclic = cyclic if cyclic is False else choice("cyclic", cyclic, ("exact", "modulo"))
        if self.cyclic and not path.is_closed:
            raise InvalidInputError("cyclic", "needs a closed path", "close the path or set cyclic: false", cyclic)
        self.weights = read_only(joint_weights(weights, arm.n))
        self.objective: Objective = OBJECTIVES[choice("objective", objective, OBJECTIVES)]()
        self._check_reach()
        self._check_numbers()
        self.start = self._posture("start", start, 0.0)
        self.end = self._posture("end", end, 1.0)
        self._check_closure()

    def __repr__(self) -> str:
        return f"Problem({self.arm!r}, {self.path!r}, elbow={self.elbow!r}, objective={self.objective.kind!r})"

    def with_path_unit(self, unit: str | None) -> Problem:
        """Return the same problem with the unit of its path told, for :attr:`warnings`."""
        other = copy.copy(self)
        other.path_unit = unit
        return other

    def without(self, constraint: Literal["start", "end", "cyclic"]) -> Problem:
        """Return the same problem without one of the constraints on its ends."""
        other = copy.copy(self)
        setattr(other, constraint, False if constraint == "cyclic" else None)
        return other

    def with_margin(self, margin: Margin, value: float) -> Problem:
        """Return the same problem that asks for another clearance, or another least singular value.

        Parameters
        ----------
        margin : {"clearance", "least_singular_value"}
        value : float

        Returns
        -------
        Problem

        Raises
        ------
        InvalidInputError
            If `value` is not positive, there is no obstacle to keep clear of, or start or end come nearer.
        """
        bare, others = unconstrained(self.arm), [c for c in constraints_of(self.arm) if c.check != CHECKS[margin]]
        other = copy.copy(self)
        if margin == "clearance":
            scene = self.scene
            if scene is None or not scene.obstacles:
                raise InvalidInputError("clearance", "is asked for where no obstacle is", "give obstacles", value)
            other.scene = changed = type(scene)(
                bare, scene.obstacles, positive("clearance", value), scene.self_collision
            )
            other.arm = constrained(bare, [changed, *others])
        else:
            other.arm = constrained(bare, [*others, SingularityMargin(bare, value)])
            other.least_singular_value = value
        other.__dict__.pop("blocked", None)
        for name, posture, r in (("start", self.start, 0.0), ("end", self.end, 1.0)):
            if posture is not None:
                other._check_inside(name, posture, r)
        return other

    @property
    def elbow_branches(self) -> list[int]:
        """Indices of the branches that a motion may use somewhere."""
        names = self.arm.branches
        return list(range(len(names))) if self.elbow == "any" else [names.index(self.elbow)]

    @property
    def start_branches(self) -> list[int]:
        """Indices of the branches that a motion may start on."""
        given = None if self.start is None else self.start.branches
        return self.elbow_branches if given is None else list(given)

    @cached_property
    def grid(self) -> FloatArray:
        """The N sample parameters, shape (samples,)."""
        return read_only(np.linspace(0.0, 1.0, self.samples))

    @cached_property
    def points(self) -> FloatArray:
        """The path at the samples, shape (samples, dimension)."""
        return read_only(self.path(self.grid))

    @cached_property
    def quadrature(self) -> DyadicGauss:
        """Where integrals along the path are taken: on panels between its breaks, halved as often as is cheap."""
        edges = self.path.grid(_PANELS)
        pieces = _MOST_NODES / (GAUSS * (len(edges) - 1))
        return dyadic_gauss(edges, max(1, int(np.log2(pieces + 1.0)) - 1))

    @cached_property
    def quadrature_points(self) -> tuple[FloatArray, FloatArray]:
        """The path and its derivative at the nodes of :attr:`quadrature`, shape (k, dimension) each."""
        nodes = self.quadrature.nodes
        return read_only(self.path(nodes)), read_only(self.path(nodes, 1))

    @cached_property
    def fastest(self) -> float:
        """Bound on the speed ``|x'(r)|`` along the path, infinite if the path bounds it nowhere."""
        try:
            return self.path.fastest(0.0, 1.0)
        except InvalidInputError:
            return np.inf

    @cached_property
    def has_slabs(self) -> bool:
        """Whether boxes can hold all postures along parts of the path: of rigorous arms, where speeds are bounded."""
        try:
            turning = self.path.turning(0.0, 1.0) if self.path.dimension == POSE else 0.0
        except InvalidInputError:
            return False
        return self.arm.rigorous and bool(np.isfinite(self.fastest + turning))

    @property
    def rows(self) -> FloatArray:
        """The sample grid and every given waypoint, ascending; a trajectory has a row at each."""
        return np.unique(np.concatenate([self.grid, self.path.waypoints]))

    @cached_property
    def blocked(self) -> list[Blocked]:
        """The stretches of the path that the arm cannot follow, looked for at the samples, with their cause."""
        return blocked_stretches(self.arm, self.path, self.samples, self.elbow_branches)

    @cached_property
    def structure(self) -> DomainStructure:
        """The structure of the angle domain on the branches that may be used, joint limits alone regarded.

        Further constraints only take postures away: what is not connected here is not connected under them either.

        Raises
        ------
        InvalidInputError
            If the arm has another degree of redundancy than one.
        """
        return DomainStructure(unconstrained(self.arm).self_motion(), self.path, self.elbow_branches)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What is doubtful and yet may be meant: units that contradict each other, sizes that say a mistaken one."""
        points = self.path(self.path.grid(_LOOK_AT))[:, : PLANE if self.path.dimension == PLANE else SPACE]
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        placement, unit = getattr(self.arm, "placement", None), length_unit(self.arm)
        by = "" if placement is None else "placement.unit"
        found = [too_small(float(np.ptp(points, axis=0).max()), length, self.arm.reach)]
        if self.path_unit is not None and unit is not None:
            against = contradiction(self.path_unit, unit, by)
            remedy = "give both the same, that of the arm's lengths" if by else f"give arm_unit: {unit}"
            found.append(None if against is None else f"{against}: {remedy}")
        found += [] if placement is None else placement.doubts(self.arm.reach)
        found += self.arm.limits.doubts()
        found += [] if self.scene is None else self.scene.doubts()
        return tuple(doubt for doubt in found if doubt is not None)

    def _check_reach(self) -> None:
        """Refuse a path that is out of reach everywhere: more often a matter of units than of the arm."""
        points = self.path(self.path.grid(_LOOK_AT))
        if out_of_reach(self.arm, points).all():
            least = float(self.arm.shortfall(points).min())
            raise InvalidInputError(
                "path",
                f"has no point in reach: its nearest point is {least:.6g} outside what the arm, of reach "
                f"{self.arm.reach:.6g}, can get to",
                "are the units of arm and path the same?",
            )

    def _check_numbers(self) -> None:
        """Refuse an arm or a path whose numbers are none: NaN would pass for out of reach, which proves too much."""
        arm, r = self.arm, self.path.grid(_LOOK_AT)
        points = self.path(r)
        self.path(r, 1)
        r, points = r[~out_of_reach(arm, points)], points[~out_of_reach(arm, points)]
        u = np.linspace(-np.pi, np.pi, len(r))[:, None] + np.zeros(arm.n_u)
        for branch in self.elbow_branches:
            q, ok = arm.solve(points, u, branch)
            posture = np.where(ok[:, None], q, 0.0)
            for name, found in (
                ("solve", posture),
                ("task_residual", arm.task_residual(posture, points)),
                ("task_error", arm.task_error(posture, points)[:, None]),
                ("jacobian", arm.jacobian(posture).reshape(len(r), -1)),
            ):
                wrong = ~np.isfinite(found).all(axis=-1)
                if wrong.any():
                    at, method = r[wrong][0], f"{type(arm).__name__}.{name}"
                    raise InvalidInputError("arm", f"gives no finite numbers at r = {at:.6g}", f"mend {method}")

    def _check_closure(self) -> None:
        """Refuse a cyclic motion whose given ends are not the same posture."""
        if not self.cyclic or self.start is None or self.end is None:
            return
        apart = np.abs(u_steps(self.arm, self.start.u, self.end.u)).max()
        if self.start.q is not None and self.end.q is not None:
            steps = self.arm.limits.steps if self.cyclic == "modulo" else np.subtract
            apart = np.abs(steps(self.end.q, self.start.q)).max()
        if apart > ANGLE:
            by = f"{apart:.6g} {self.arm.limits.unit}"
            reason = f"differs from start by {by}, and a cyclic motion ends where it starts"
            raise InvalidInputError("end", reason, "leave one of the two out, or set cyclic: false")

    def _posture(self, name: str, given: ArrayLike | Mapping[str, Any] | None, r: float) -> Posture | None:
        if given is None:
            return None
        entry = given if isinstance(given, Mapping) else {"u": given}
        if set(entry) not in ({"u"}, {"q"}):
            raise InvalidInputError(name, "needs either u or q", "write {u: […]} or {q: […]}", dict(entry))
        if "u" in entry:
            u = finite_array(f"{name}.u", entry["u"], 1, self.arm.n_u)
            posture = Posture(angles(f"{name}.u", u) if u_period(self.arm) == TAU else u)
        else:
            posture = self._from_joints(name, finite_array(f"{name}.q", entry["q"], 1, self.arm.n), r)
        self._check_inside(name, posture, r)
        return posture

    def _from_joints(self, name: str, q: FloatArray, r: float) -> Posture:
        arm, target = self.arm, self.path(r)
        miss = float(arm.task_error(q, target))
        if miss > _ON_PATH * arm.reach:
            raise InvalidInputError(
                f"{name}.q",
                f"misses its task, the tool at {np.round(target, 6).tolist()}, by {miss:.6g}",
                "give joint angles that hold the tool on the path (and in its direction), or give u",
                q.tolist(),
            )
        branches = tuple(b for b in self.elbow_branches if arm.is_on_branch(q, b, ON_LIMIT))
        if not branches:
            reason = f"is not on the {self.elbow} elbow" if _has_elbow(arm) else f"is not on branch {self.elbow}"
            remedy = f"change {'elbow' if _has_elbow(arm) else 'branch'} or q"
            raise InvalidInputError(f"{name}.q", reason, remedy, q.tolist())
        return Posture(arm.u_of(q), q, branches)

    def _check_inside(self, name: str, posture: Posture, r: float) -> None:
        """Refuse a posture that no allowed branch can take, saying which constraint forbids it."""
        arm = self.arm
        if blocked_at(arm, self.path, r, self.elbow_branches):
            return  # the fault is the path's, not the posture's; planners prove it
        if posture.q is not None:
            excess = np.maximum(-arm.limits.margin(posture.q), 0.0)
            tried = [(excess, posture.q)]
        else:
            tried = [(arm.limits.excess(q), q) for q in postures_of(self, posture, r)]
            if not tried:
                raise InvalidInputError(
                    f"{name}.u", f"is out of reach at r = {r:g}", self.feasible_at(r), posture.u.tolist()
                )
        excess, q = min(tried, key=lambda pair: float(pair[0].max()))
        joint = int(np.argmax(excess))
        if excess[joint] > ON_LIMIT:
            by = f"{excess[joint]:.6g} {arm.limits.units[joint]}"
            raise InvalidInputError(
                f"{name}.{'u' if posture.q is None else 'q'}",
                f"puts joint {joint + 1} at {q[joint]:.6g}, {by} outside its limits",
                self.feasible_at(r),
                (posture.u if posture.q is None else posture.q).tolist(),
            )
        self._check_constraints(name, posture, [tried_q for off, tried_q in tried if off.max() <= ON_LIMIT], r)

    def _check_constraints(self, name: str, posture: Posture, found: list[FloatArray], r: float) -> None:
        """Refuse a posture of which all that limits allow, `found`, break another constraint."""
        for constraint in constraints_of(self.arm):
            margins = [constraint.margins(q[None])[0] for q in found]
            best = max(margins, key=lambda each: float(each.min()))
            if best.min() < -constraint.tolerance:
                given = posture.u if posture.q is None else posture.q
                raise InvalidInputError(
                    f"{name}.{'u' if posture.q is None else 'q'}",
                    f"does not keep the {constraint.check} asked for: {constraint.cause(int(best.argmin()))} lacks "
                    f"{-float(best.min()):.6g}{constraint.unit}",
                    self.feasible_at(r), given.tolist(),
                )  # fmt: skip

    def feasible_at(self, r: float) -> str:
        """Return in words where u may lie at `r`."""
        if self.arm.n_u != 1:
            return "choose another redundancy vector"
        try:
            domain = angle_domain(self.arm, self.path)
        except InvalidInputError:  # of this arm it is not told
            return "choose another redundancy parameter"
        form = "{} with a {} elbow" if _has_elbow(self.arm) else "{} on branch {}"
        parts = []
        for branch in self.elbow_branches:
            feasible = domain(r, branch)
            if feasible.measure > 0:
                ends = " and ".join(f"[{low:.6g}, {high:.6g}]" for low, high in feasible.intervals)
                parts.append(form.format(ends, self.arm.branches[branch]))
        return f"u may lie in {' or '.join(parts)}" if parts else "no posture is feasible there"

    def may_start_at(self, u: FloatArray, branch: int) -> bool:
        """Return whether a motion on `branch` may start with redundancy vector `u`."""
        q, ok = self.arm.solve(self.path(0.0), u, branch)
        if not ok or not self.arm.limits.admit(q):
            return False
        return all((c.margins(q[None]) >= -c.tolerance).all() for c in constraints_of(self.arm))


def postures_of(problem: Problem, posture: Posture, r: float) -> FloatArray:
    """Return the joint angles (m, n) that a given posture may have at r: by its u one posture per elbow, at most."""
    if posture.q is not None:
        return posture.q[None]
    solved = [problem.arm.solve(problem.path(r), posture.u, branch) for branch in problem.elbow_branches]
    return np.array([q for q, ok in solved if ok]).reshape(-1, problem.arm.n)


def _constraints(
    arm: RedundantArm, obstacles: Sequence[Obstacle], clearance: float, self_collision: bool, least: float | None
) -> tuple[Scene | None, list[Constraint]]:
    """Return the scene, None if nothing is in it, and all constraints beyond joint limits."""
    if not isinstance(obstacles, Sequence) or isinstance(obstacles, str):
        raise InvalidInputError("obstacles", f"is a {type(obstacles).__name__}", "give a list of obstacles")
    if not isinstance(self_collision, bool | np.bool_):
        raise InvalidInputError("self_collision", "is not true or false", "give True or False", self_collision)
    clearance = number("clearance", clearance)
    own = constraints_of(arm)  # of another problem, whose arm it is
    in_scene = bool(len(obstacles) or self_collision or clearance)
    if own and (in_scene or least is not None):
        reason = "has constraints of its own, and the problem asks for more"
        raise InvalidInputError("arm", reason, "give the arm without them, and all of them to the problem")
    found: list[Constraint] = []
    scene = None
    if own or in_scene:
        from selfmotion.scene import Scene  # compiled kernels, which few need

        if own:
            return next((one for one in own if isinstance(one, Scene)), None), []
        scene = Scene(arm, obstacles, clearance, self_collision)
        found = [scene] if len(obstacles) or self_collision else []
    if least is not None:
        found.append(SingularityMargin(arm, least))
    return scene, found


def _least_singular_value(constraints: Sequence[Constraint]) -> float | None:
    """Return what the constraints ask of it, None if nothing."""
    return next((one.least for one in constraints if isinstance(one, SingularityMargin)), None)


def _check_dimensions(arm: RedundantArm, path: Path) -> None:
    """Refuse a path whose points are no tasks of the arm."""
    if path.dimension == arm.dimension:
        return
    if arm.dimension == PLANE:
        raise InvalidInputError(
            "path", "leaves the plane that a planar arm moves in", "give a plane path, or another arm"
        )
    what = {PLANE: "a curve of the plane", SPACE: "positions without orientation", POSE: "poses"}[path.dimension]
    raise InvalidInputError(
        "path",
        f"is {what}, and this arm's tool keeps poses",
        "give it an orientation: {kind: pose, position: …, orientation: […]}; plane curves first by kind placed",
    )


def _has_elbow(arm: RedundantArm) -> bool:
    """Return whether an arm's branches are the signs of its elbow."""
    return arm.dimension == PLANE
