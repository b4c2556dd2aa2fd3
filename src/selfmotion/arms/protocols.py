"""All that domains and planners know of an arm, batched on arrays and free of hidden state."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from numpy.typing import ArrayLike

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms.cells import Cover
from selfmotion.arms.limits import JointBox, JointLimits
from selfmotion.arms.slabs import SlabCover
from selfmotion.intervals import IntervalSet

if TYPE_CHECKING:
    from selfmotion.paths import Path


_ANGLES = {0.0: "0", math.pi: "π", 0.5 * math.pi: "π/2", -0.5 * math.pi: "−π/2"}


class Cause(NamedTuple):
    """Why a breakpoint of the self-motion stands where it stands.

    Attributes
    ----------
    kind : str
        ``"fold"`` (two branches meet), ``"lower limit"``, ``"upper limit"``, ``"free"`` (the joint turns while u stands
        still) or ``"marker"`` (nothing happens there in general; a singular posture may).
    joint : int
        The joint concerned, counted from 0; −1 for markers, and for folds that no single joint tells.
    value : float
        Its angle there [rad], NaN for markers, where it is free, and for folds that no single joint tells.
    """

    kind: str
    joint: int
    value: float

    def __str__(self) -> str:
        name = f"θ{self.joint + 1}"
        if self.kind == "fold" and self.joint >= 0:
            return f"fold {name} = {_ANGLES.get(self.value, f'{self.value:.4g}')}"
        if self.kind == "free":
            return f"{name} free"
        return f"{self.kind} of {name}" if self.joint >= 0 else self.kind


class Breakpoints(NamedTuple):
    """Where along a self-motion its feasibility may change, for k poses at once.

    Attributes
    ----------
    u : array, shape (k, m)
        Parameter values [rad], NaN where a column has no solution.
    on_branch : array of bool, shape (k, m, b)
        The branches that the point belongs to; folds belong to several.
    q : array, shape (k, m, n)
        The posture there, exact on the constraint that causes it; NaN where not unique.
    causes : tuple of Cause, length m
        One per column. Columns are the same at all poses only if the self-motion's ``has_structure`` says so.
    """

    u: FloatArray
    on_branch: BoolArray
    q: FloatArray
    causes: tuple[Cause, ...]


class FreeJoint(NamedTuple):
    """Postures at one task point along which one joint turns while u stands still.

    Attributes
    ----------
    joint : int
    u : float
        Where on the self-motion they are [rad].
    angles : IntervalSet
        The angles of the joint that all limits allow, on the circle.
    """

    joint: int
    u: float
    angles: IntervalSet


@runtime_checkable
class SelfMotion(Protocol):
    """An arm with one redundant degree of freedom, seen from its parameter u.

    ``pose`` makes the constants of task points; what is in them is the arm's business. Between the
    breakpoints of a branch every constraint either holds throughout or fails throughout.
    """

    n: int
    branches: tuple[str, ...]
    u_range: tuple[float, float]
    periodic: bool
    limits: JointLimits
    has_structure: bool
    """Whether breakpoints have the same columns at every pose, so that intervals are followed along a path by them."""
    singular: BoolArray
    """Per separator, whether a joint is free where it vanishes; shape (m,)."""

    @property
    def wraps(self) -> BoolArray:
        """Which joints are full turns, shape (n,)."""
        ...

    def pose(self, x: ArrayLike) -> Any:
        """Return the constants of task points `x`, shape (k, dimension)."""
        ...

    def excess(self, q: ArrayLike) -> FloatArray:
        """Return by how much postures (..., n) miss each constraint, whole turns being free, shape (..., c)."""
        ...

    def solve(self, pose: Any, u: ArrayLike, branch: int) -> tuple[FloatArray, BoolArray]:
        """Return postures (k, m, n) and whether they reach, for parameters `u` (k, m)."""
        ...

    def breakpoints(self, pose: Any, exact: bool = False) -> Breakpoints:
        """Return where feasibility may change; at least one finite parameter per pose and branch.

        Constraints that are met up to rounding count as met, unless `exact`.
        """
        ...

    def separators(self, pose: Any) -> FloatArray:
        """Return smooth functions of the pose, shape (k, m), of size 1: outside their zeros the structure is constant.

        An arm that knows none returns shape (k, 0): the structure along a path is then found by comparing samples.
        """
        ...

    def free_joint(self, pose: Any) -> FreeJoint | None:
        """Return the postures at which a joint is free, for one pose where a singular separator vanishes."""
        ...


def u_period(arm: RedundantArm) -> float:
    """Return after which an arm's redundancy parameters are the same again: a full turn, unless it says otherwise.

    Parameters
    ----------
    arm : RedundantArm

    Returns
    -------
    float
        In the unit of u; :data:`~selfmotion.angles.NEVER` of an arm on a rail.
    """
    return float(getattr(arm, "u_period", TAU))


def u_steps(arm: RedundantArm, u: FloatArray, to: FloatArray) -> FloatArray:
    """Return the steps from redundancy parameters to others, the short way round where these are angles.

    Parameters
    ----------
    arm : RedundantArm
    u, to : array, shape (..., n_u)
        [rad; m on a rail].

    Returns
    -------
    array, shape (..., n_u)
        In the same unit.
    """
    return wrap(to - u, u_period(arm))


@runtime_checkable
class RedundantArm(Protocol):
    """An arm with any number of redundant degrees of freedom."""

    n: int
    n_u: int
    dimension: int
    """Numbers of a task point: 2 for a position in the plane, 7 for a pose in space."""
    branches: tuple[str, ...]
    limits: JointLimits
    rigorous: bool
    """Whether :meth:`cover` leaves nothing out: else a bound is an estimate, and missing cells prove nothing."""

    @property
    def has_structure(self) -> bool:
        """Whether the structure of the angle domain along a path is known in closed form."""
        ...

    @property
    def reach(self) -> float:
        """Largest distance of the tool from the base."""
        ...

    def shortfall(self, x: ArrayLike) -> FloatArray:
        """Return how far task points (..., dimension) are out of reach, whatever the joint limits."""
        ...

    def forward(self, q: ArrayLike) -> FloatArray:
        """Return the task point of the tool, shape (..., dimension)."""
        ...

    def joint_positions(self, q: ArrayLike) -> FloatArray:
        """Return the base, every joint and the tool as points, shape (..., n + 1, 2 or 3)."""
        ...

    def task_error(self, q: ArrayLike, x: ArrayLike) -> FloatArray:
        """Return how far postures are from their task, in the unit of length."""
        ...

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the derivative of :meth:`task_residual`, up to its sign, shape (..., tasks, n)."""
        ...

    def jacobian_rate(self, q: ArrayLike, dq: ArrayLike) -> FloatArray:
        """Return the change of :meth:`jacobian` along dq, shape (..., tasks, n)."""
        ...

    def boxes(self, elbow: str = "any", around: ArrayLike | None = None) -> list[JointBox]:
        """Return the joint limits, narrowed to one elbow, in several pieces if it has them."""
        ...

    def task_residual(self, q: ArrayLike, x: ArrayLike) -> FloatArray:
        """Return what postures lack to do their task, shape (..., tasks)."""
        ...

    def task_rate(self, x: ArrayLike, dx: ArrayLike) -> FloatArray:
        """Return how fast the task changes where task points `x` move by `dx`, shape (..., tasks)."""
        ...

    def relaxed(self, slack: ArrayLike, upper: ArrayLike | None = None) -> RedundantArm:
        """Return the same arm with joint limits that give by `slack`, upper ones by `upper` if it is given [rad]."""
        ...

    def solve(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, BoolArray]:
        """Return the posture and whether it reaches."""
        ...

    def solve_with_margin(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, FloatArray]:
        """Return the posture and its signed distance to the limit of reach."""
        ...

    def rates(self, x: ArrayLike, dx: ArrayLike, u: ArrayLike, du: ArrayLike, branch: int | str = 0) -> FloatArray:
        """Return the joint rates that go with the rates of x and u."""
        ...

    def derivative(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, FloatArray]:
        """Return ∂q/∂u and ∂q/∂x."""
        ...

    def margins(self, q: ArrayLike) -> FloatArray:
        """Return the signed distance to every constraint."""
        ...

    def u_of(self, q: ArrayLike) -> FloatArray:
        """Return the redundancy vector of postures."""
        ...

    def branch_of(self, q: ArrayLike) -> IntArray:
        """Return the branch index of postures."""
        ...

    def is_on_branch(self, q: ArrayLike, branch: int | str, tolerance: float) -> BoolArray:
        """Return whether postures are on a branch, or within `tolerance` of its fold."""
        ...

    def line(self, u0: ArrayLike, direction: ArrayLike) -> Any:
        """Return the postures along u0 + s·direction."""
        ...

    def cover(self, elbow: str = "any") -> Cover:
        """Return the cells of the self-motion, for one redundant degree; else raise InvalidInputError."""
        ...

    def slabs(self, path: Path, elbow: str = "any") -> SlabCover:
        """Return boxes of the postures along parts of a path, for one redundant degree."""
        ...

    def self_motion(self) -> SelfMotion:
        """Return the self-motion, for one redundant degree; else raise InvalidInputError."""
        ...


def length_unit(arm: RedundantArm) -> str | None:
    """Return the unit of an arm's lengths: m of arms in space, of planar ones that of their placement, else None.

    Parameters
    ----------
    arm : RedundantArm

    Returns
    -------
    str or None
    """
    if getattr(arm, "chain", None) is not None:
        return "m"
    unit: str | None = getattr(getattr(arm, "placement", None), "unit", None)
    return unit
