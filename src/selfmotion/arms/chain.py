"""Serial chains in space: fixed transforms with a joint about (or along) z between each two."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import contains_text, finite_array, integer, number, read_only
from selfmotion._types import BoolArray, FloatArray, Limits
from selfmotion.arms.limits import JointLimits
from selfmotion.arms.shapes import Shapes
from selfmotion.errors import InvalidInputError

MAX_JOINTS = 1000
# What decimals rounded in a data sheet do to a rotation is far above this, what double precision does far below.
_RIGID = 1e-9
_LAST_ROW = (0.0, 0.0, 0.0, 1.0)


class Chain:
    """A serial chain of revolute and prismatic joints.

    Parameters
    ----------
    names : sequence of str
        Names of the n joints from the base to the tip, n ≥ 1, each once.
    offsets : array_like, shape (n + 1, 4, 4)
        The rigid transforms F_0 … F_n before, between and after the joints; lengths in metres.
    limits : JointLimits or sequence, optional
        Per joint ``None`` or ``(lower, upper)``, in radians, in metres for prismatic joints.
    prismatic : array_like of bool, shape (n,), optional
        Which joints slide along z rather than turn about it; none by default.
    velocity : array_like, shape (n,), optional
        Maximal joint speeds [rad/s, m/s for prismatic joints], infinite where there is none.
    base, tip : str
        Names of the frames at both ends.
    shapes : Shapes, optional
        What its links look like to collision checks; nothing by default.

    Attributes
    ----------
    n : int
        Number of joints.

    Raises
    ------
    InvalidInputError
        If arrays do not fit, a speed is not positive, a capsule has the frame of no joint, or an offset is not a rigid
        transform: its rotation must be orthonormal to 1e-9 and keep handedness.

    Notes
    -----
    ``T(q) = F_0 Z(q_1) F_1 Z(q_2) … Z(q_n) F_n``, Z(q) being the rotation by q about z, or the translation by q along
    z. Other axes are turned into z by :func:`turned_to_z`.
    """

    def __init__(
        self,
        names: Sequence[str],
        offsets: ArrayLike,
        limits: JointLimits | Limits = None,
        prismatic: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        base: str = "base",
        tip: str = "tip",
        shapes: Shapes | None = None,
    ) -> None:
        self.names = _checked_names(names)
        self.n = len(self.names)
        given = finite_array("offsets", offsets, 3, 4)
        if given.shape != (self.n + 1, 4, 4):
            raise InvalidInputError(
                "offsets", f"has shape {given.shape}", f"give shape ({self.n + 1}, 4, 4), one more than joints"
            )
        for j, offset in enumerate(given):
            _check_rigid(f"offsets.{j}", offset)
        self.offsets = read_only(given)
        self.prismatic = _checked_kinds(prismatic, self.n)
        self.limits = limits if isinstance(limits, JointLimits) else JointLimits(limits, self.n, self.prismatic)
        if len(self.limits.lower) != self.n:
            raise InvalidInputError("limits", f"is for {len(self.limits.lower)} joints", f"give {self.n}")
        if (self.limits.slides != self.prismatic).any():
            self.limits = JointLimits(self.limits.as_list(), self.n, self.prismatic)
        self.velocity = _checked_speeds(velocity, self.n)
        self.base, self.tip = base, tip
        self.shapes = Shapes() if shapes is None else shapes
        if any(part.frame >= self.n for part in self.shapes.capsules):
            raise InvalidInputError("shapes", f"has a frame that {self.n} joints do not have", "count joints from 0")

    def __repr__(self) -> str:
        return f"Chain({self.base!r} to {self.tip!r}, joints {', '.join(self.names)})"

    def forward(self, q: ArrayLike) -> FloatArray:
        """Return the pose of the tip in the base's frame.

        Parameters
        ----------
        q : array_like, shape (..., n)
            Joint positions [rad, m]. Joint limits are not looked at.

        Returns
        -------
        array, shape (..., 4, 4)

        Raises
        ------
        InvalidInputError
            If the last dimension is not n.
        """
        joints = np.asarray(q, dtype=float)
        if joints.ndim == 0 or joints.shape[-1] != self.n:
            raise InvalidInputError("q", f"has shape {joints.shape}", f"give shape (..., {self.n})")
        pose = np.broadcast_to(self.offsets[0], (*joints.shape[:-1], 4, 4))
        for j in range(self.n):
            pose = self._moved(pose, j, joints[..., j]) @ self.offsets[j + 1]
        return pose

    def with_tool(self, transform: ArrayLike) -> Chain:
        """Return the chain with a tool at its tip: F_n becomes ``F_n @ transform``.

        Parameters
        ----------
        transform : array_like, shape (4, 4)
            The tool's pose in the frame of the tip; rigid.

        Returns
        -------
        Chain

        Raises
        ------
        InvalidInputError
            If `transform` is not rigid.
        """
        tool = finite_array("transform", transform, 2, 4)
        if len(tool) != 4:
            raise InvalidInputError("transform", f"has shape {tool.shape}", "give shape (4, 4)")
        _check_rigid("transform", tool)
        offsets = np.concatenate([self.offsets[:-1], self.offsets[-1:] @ tool])
        return self._with(offsets, np.arange(self.n), self.shapes)

    def with_limits(self, limits: JointLimits | Limits) -> Chain:
        """Return the chain with other joint limits.

        Parameters
        ----------
        limits : JointLimits or sequence
            Per joint ``None`` or ``(lower, upper)``, in radians, in metres for prismatic joints.

        Returns
        -------
        Chain

        Raises
        ------
        InvalidInputError
            If there are not n of them, or an interval is reversed.
        """
        return Chain(self.names, self.offsets, limits, self.prismatic, self.velocity, self.base, self.tip, self.shapes)

    def on_rail(self, axis: ArrayLike, limits: ArrayLike, name: str = "rail") -> Chain:
        """Return the chain with its base on a rail: a prismatic joint before all others.

        Parameters
        ----------
        axis : array_like, shape (3,)
            Direction of the rail in the frame of the base; of any length, not zero.
        limits : array_like, shape (2,)
            Between which positions the base slides [m]; at 0 it is where it was.
        name : str
            Of the joint.

        Returns
        -------
        Chain
            With n + 1 joints; its base is the rail's, which has the frame that the arm's base has at 0.

        Raises
        ------
        InvalidInputError
            If the axis is zero, or the limits are not two numbers in ascending order.
        """
        along, ends = finite_array("axis", axis, 1, 3), finite_array("limits", limits, 1, 2)
        if not along.any():
            raise InvalidInputError("axis", "is zero", "give the direction of the rail")
        if ends[0] > ends[1]:
            raise InvalidInputError("limits", "is reversed", "write the lower limit first", ends.tolist())
        turn = turn_from_z(along)
        offsets = np.concatenate([turn[None], [turn.T @ self.offsets[0]], self.offsets[1:]])
        return Chain(
            [name, *self.names], offsets, [ends.tolist(), *self.limits.as_list()], np.append(True, self.prismatic),
            np.append(np.inf, self.velocity), self.base, self.tip, self.shapes.on_rail(turn),
        )  # fmt: skip

    def locked(self, joint_index: int, value: float) -> Chain:
        """Return the chain with one joint held still and no longer counted.

        Parameters
        ----------
        joint_index : int
            From 0 to n − 1.
        value : float
            Where it is held [rad, m].

        Returns
        -------
        Chain
            With n − 1 joints; the transform of the held one is part of an offset.

        Raises
        ------
        InvalidInputError
            If there is no such joint, its limits exclude `value`, or it is the only one.
        """
        j = integer("joint_index", joint_index, 0, self.n - 1)
        if self.n == 1:
            raise InvalidInputError("joint_index", "is the only joint", "lock a joint of a chain with two or more")
        held = number("value", value)
        low, high = self.limits.lower[j], self.limits.upper[j]
        if not low <= held <= high:
            why = f"is outside the limits [{low:g}, {high:g}] of joint {self.names[j]}"
            raise InvalidInputError("value", why, "give a number inside", value)
        pose = self._moved(self.offsets[j], j, np.array(held))
        offsets = np.concatenate([self.offsets[:j], (pose @ self.offsets[j + 1])[None], self.offsets[j + 2 :]])
        return self._with(offsets, np.delete(np.arange(self.n), j), self.shapes.locked(j, pose))

    def with_shapes(self, shapes: Shapes) -> Chain:
        """Return the chain with other shapes of its links.

        Parameters
        ----------
        shapes : Shapes

        Returns
        -------
        Chain

        Raises
        ------
        InvalidInputError
            If a capsule has the frame of no joint.
        """
        return self._with(self.offsets, np.arange(self.n), shapes)

    def _with(self, offsets: FloatArray, kept: np.ndarray, shapes: Shapes) -> Chain:
        """Return a chain of the joints `kept` between other offsets."""
        limits = self.limits.as_list()
        return Chain(
            [self.names[j] for j in kept],
            offsets,
            [limits[j] for j in kept],
            self.prismatic[kept],
            self.velocity[kept],
            self.base,
            self.tip,
            shapes,
        )

    def _moved(self, pose: FloatArray, j: int, value: FloatArray) -> FloatArray:
        """Return ``pose @ Z(value)`` for joint j: only the columns that Z changes are worked out."""
        moved = np.array(pose)
        if self.prismatic[j]:
            moved[..., 3] += value[..., None] * pose[..., 2]
            return moved
        cos, sin = np.cos(value)[..., None], np.sin(value)[..., None]
        moved[..., 0] = cos * pose[..., 0] + sin * pose[..., 1]
        moved[..., 1] = cos * pose[..., 1] - sin * pose[..., 0]
        return moved


def turned_to_z(origins: ArrayLike, axes: ArrayLike) -> FloatArray:
    """Return the offsets of a chain whose joints have any axes.

    Parameters
    ----------
    origins : array_like, shape (n + 1, 4, 4)
        Each joint's frame in the frame before it, and the tip's in the last joint's.
    axes : array_like, shape (n, 3)
        The joints' axes in their own frames; of any length, not zero.

    Returns
    -------
    array, shape (n + 1, 4, 4)
        The F_i of :class:`Chain`.

    Raises
    ------
    InvalidInputError
        If shapes do not fit or an axis is zero.

    Notes
    -----
    With R z = a, the joint's own rotation is ``Rot(a, q) = R Z(q) Rᵀ``; R goes into the offset before the joint and Rᵀ
    into the one after it. R is the smallest such rotation; for a = −z, where the smallest is not unique, the half turn
    about x.
    """
    given = finite_array("axes", axes, 2, 3)
    offsets = finite_array("origins", origins, 3, 4)
    if offsets.shape != (len(given) + 1, 4, 4):
        raise InvalidInputError("origins", f"has shape {offsets.shape}", f"give shape ({len(given) + 1}, 4, 4)")
    for j, axis in enumerate(given):
        if not axis.any():
            raise InvalidInputError(f"axes.{j}", "is zero", "give the direction of the joint's axis")
        turn = turn_from_z(axis)
        offsets[j] = offsets[j] @ turn
        offsets[j + 1] = turn.T @ offsets[j + 1]
    return offsets


def turn_from_z(axis: FloatArray) -> FloatArray:
    """Return the smallest rotation that takes z to `axis`, as a 4 × 4 transform."""
    x, y, z = axis
    across = np.hypot(x, y)
    turn = np.eye(4)
    if across == 0:
        if z < 0:
            turn[1, 1] = turn[2, 2] = -1.0
        return turn
    cos, sin = np.array([z, across]) / np.hypot(z, across)
    # Rodrigues' formula about the unit vector n along z × axis, which stays accurate near ±z.
    n = np.array([-y, x, 0.0]) / across
    cross = np.array([[0.0, 0.0, n[1]], [0.0, 0.0, -n[0]], [-n[1], n[0], 0.0]])
    turn[:3, :3] = cos * np.eye(3) + sin * cross + (1 - cos) * np.outer(n, n)
    return turn


def _check_rigid(field: str, transform: FloatArray) -> None:
    """Refuse what is not a rotation and a translation, and say what it does instead."""
    remedy = "give a rotation matrix and a translation, with 0 0 0 1 as the last row"
    if tuple(transform[3]) != _LAST_ROW:
        raise InvalidInputError(field, "is not a rigid transform: its last row is not 0 0 0 1", remedy)
    rotation = transform[:3, :3]
    gram = rotation.T @ rotation
    off = float(np.abs(gram - np.eye(3)).max())
    if off > _RIGID:
        scale = float(np.sqrt(np.trace(gram) / 3))
        # A pure scale, or something that bends angles as well.
        pure = np.abs(gram - scale**2 * np.eye(3)).max() <= 1e-3 * abs(scale**2 - 1)
        what = f"scaled by {scale:.10g}" if pure else f"not orthonormal, its columns being off by {off:.3g}"
        raise InvalidInputError(field, f"is not a rigid transform: its rotation is {what}", remedy)
    if np.linalg.det(rotation) < 0:
        raise InvalidInputError(field, "is not a rigid transform: its rotation is a mirror image", remedy)


def _checked_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return `names` as a tuple of different strings."""
    given = () if isinstance(names, str) else tuple(names)
    if not 1 <= len(given) <= MAX_JOINTS:
        raise InvalidInputError("names", f"has {len(given)} entries", f"give 1 to {MAX_JOINTS} joint names", names)
    seen = set()
    for j, name in enumerate(given):
        if not isinstance(name, str) or not name:
            raise InvalidInputError(f"names.{j}", "is not a name", "give a text", name)
        if name in seen:
            raise InvalidInputError(f"names.{j}", "occurs twice", "give every joint its own name", name)
        seen.add(name)
    return given


def _checked_kinds(prismatic: ArrayLike | None, n: int) -> BoolArray:
    """Return which joints slide, shape (n,)."""
    kinds = np.zeros(n, dtype=bool) if prismatic is None else np.array(prismatic)
    if kinds.dtype != bool or kinds.shape != (n,):
        raise InvalidInputError("prismatic", "is not one true or false per joint", f"give {n} of them", prismatic)
    kinds.flags.writeable = False
    return kinds


def _checked_speeds(velocity: ArrayLike | None, n: int) -> FloatArray:
    """Return maximal speeds, shape (n,), which may be infinite."""
    if velocity is None:
        return read_only(np.full(n, np.inf))
    want = f"give {n} positive numbers, infinite where there is no limit"
    if contains_text(velocity):
        raise InvalidInputError("velocity", "is not made of numbers", want, velocity)
    try:
        speeds = np.array(velocity, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError("velocity", "is not an array of numbers", want, velocity) from None
    if speeds.shape != (n,):
        raise InvalidInputError("velocity", f"has shape {speeds.shape}", want, velocity)
    for j, speed in enumerate(speeds):
        if not speed > 0:
            raise InvalidInputError(f"velocity.{j}", "must be greater than zero", want, float(speed))
    return read_only(speeds)
