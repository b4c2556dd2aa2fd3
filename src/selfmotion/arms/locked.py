"""Seven-joint arms that no closed form of ours solves: by EAIK, one joint locked at the redundancy parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import branch_index
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import wrap
from selfmotion.arms import _walk_kernels
from selfmotion.arms.cells import Cover
from selfmotion.arms.chain import Chain
from selfmotion.arms.chain_arm import ChainArm
from selfmotion.arms.limits import JointBox
from selfmotion.arms.locked_chain import LockedChain
from selfmotion.arms.protocols import SelfMotion
from selfmotion.arms.slabs import SlabCover
from selfmotion.arms.traced_cover import TracedCover
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import matrix

if TYPE_CHECKING:
    from selfmotion.paths import Path

_MOST = 16  # postures that a pose has with one of seven joints locked: six revolute joints have no more
_MENDED = 1e-3  # by how much answers may be off, for rounding in the file or in themselves [rad]
_EXACT = 1e-9  # of the reach: what a posture may miss its pose by
_SAME = 1e-6  # postures that are nearer to each other than this are one [rad]


class LockedArm(ChainArm):
    """An arm with seven revolute joints that EAIK solves with one of them locked; u is that joint's angle.

    Parameters
    ----------
    chain : Chain
        Its joints, frames and limits; the tool frame is the chain's last. Lengths in metres.
    joint : int, optional
        The joint that is locked, counted from 0; by default the best of those that may be, see
        :meth:`~selfmotion.arms.locked_chain.LockedChain.lockable`.

    Attributes
    ----------
    joint : int
    rigorous : bool
        False: all of its postures are sought at many values of u, not enclosed, so that a bound is an estimate.

    Raises
    ------
    InvalidInputError
        If the package EAIK is missing, or does not solve the chain with this joint locked, or with any.

    Notes
    -----
    Branches are the numbers of the postures at a given u, ascending by the first joint, then by the second and so on,
    in [−π, π] and to 1e-6 rad. They do not go on smoothly while u and the pose move, so that no motion can be asked for
    on one of them. Answers that are least squares are left out; the others are mended by Newton's method with u as it
    is, and whatever then misses its pose by more than 1e-9 of the reach is left out too.
    """

    in_closed_form = False
    rigorous = False

    def __init__(self, chain: Chain, joint: int | None = None) -> None:
        if chain.n != 7 or chain.prismatic.any():
            raise InvalidInputError("arm", "has not seven revolute joints", "give an arm with seven revolute joints")
        self._solver = LockedChain(chain)
        lockable = [found.joint for found in self._solver.lockable()]
        if not lockable:
            self._solver = LockedChain(chain, rounded=True)
            lockable = [found.joint for found in self._solver.lockable()]
        if not lockable:
            raise InvalidInputError(
                "arm", "has 7 joints that no closed form solves, nor EAIK whichever of them is locked",
                "give an arm whose first or last three axes meet in a point",
            )  # fmt: skip
        if joint is not None and joint not in lockable:
            others = " or ".join(map(str, sorted(lockable)))
            raise InvalidInputError("joint", "is none that may be locked", f"give {others}, counted from 0", joint)
        self.joint = joint = lockable[0] if joint is None else joint
        self._last: tuple[bytes, FloatArray, BoolArray] | None = None
        super().__init__(chain, np.zeros(chain.n), tuple(map(str, range(1, _MOST + 1))), f"q{joint + 1}")

    def _of(self, chain: Chain) -> Self:
        return type(self)(chain, self.joint)

    def postures(self, x: FloatArray, u: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return all postures at poses, wherever the joint limits are.

        Parameters
        ----------
        x : array, shape (k, 7)
        u : array, shape (k,)
            [rad]

        Returns
        -------
        q : array, shape (m, n)
            In [−π, π], each of them once, in the order of branches.
        of : array of int, shape (m,)
            Which of the poses each is at, ascending.
        """
        transforms = np.tile(np.eye(4), (len(x), 1, 1))
        transforms[:, :3, :3], transforms[:, :3, 3] = matrix(x[:, 3:]), x[:, :3]
        q, of = self._solver.postures(transforms, self.joint, u)
        rotations, positions = np.ascontiguousarray(transforms[of, :3, :3]), np.ascontiguousarray(x[of, :3])
        _walk_kernels.settle_all(self.kernel, rotations, positions, self.joint, _MENDED, q)
        q = wrap(q)
        there = self.task_error(q, x[of]) <= _EXACT * self.reach
        q, of = q[there], of[there]
        rounded = np.rint(q / _SAME)
        order = np.lexsort((*rounded.T[::-1], of))
        q, of = q[order], of[order]
        again = np.zeros(len(q), bool)
        for back in range(1, _MOST):  # answers of a double root come twice
            twice = np.abs(wrap(q[back:] - q[:-back])).max(axis=1, initial=0.0) <= _SAME
            again[back:] |= twice & (of[back:] == of[:-back])
        return q[~again], of[~again]

    def solve(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, BoolArray]:
        """Solve the inverse kinematics.

        Parameters
        ----------
        x : array_like, shape (..., 7)
            Poses.
        u : array_like, shape (..., 1)
            Angles of the locked joint [rad]; leading dimensions broadcast against those of `x`.
        branch : int or str
            Number of the posture: index from 0, or name from ``"1"``.

        Returns
        -------
        q : array, shape (..., n)
            Joint angles in [−π, π]; NaN where there are fewer postures.
        ok : array of bool, shape (...)
            Whether there is such a posture. Joint limits are not looked at.
        """
        index = branch_index(self.branches, branch)
        pose, parameter = np.asarray(x, dtype=float), np.asarray(u, dtype=float)[..., 0]
        shape = np.broadcast_shapes(pose.shape[:-1], parameter.shape)
        every, there = self._every(
            np.ascontiguousarray(np.broadcast_to(pose, (*shape, 7)).reshape(-1, 7)),
            np.ascontiguousarray(np.broadcast_to(parameter, shape).reshape(-1)),
        )
        return every[:, index].reshape(*shape, self.n).copy(), there[:, index].reshape(shape).copy()

    def _every(self, x: FloatArray, u: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the postures on all branches (k, b, n), and which there are (k, b).

        Branches are asked for one after the other, so the last answer is kept.
        """
        asked = x.tobytes() + u.tobytes()
        if self._last is not None and self._last[0] == asked:
            return self._last[1], self._last[2]
        q, of = self.postures(x, u)
        number = np.arange(len(of)) - np.searchsorted(of, of)
        kept = number < _MOST
        every, there = np.full((len(x), _MOST, self.n), np.nan), np.zeros((len(x), _MOST), bool)
        every[of[kept], number[kept]], there[of[kept], number[kept]] = q[kept], True
        self._last = asked, every, there
        return every, there

    def solve_with_margin(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> NoReturn:
        """Raise InvalidInputError: motions are not searched for on branches that have no more than a number."""
        raise InvalidInputError(
            "planner", "searches for u(r) on a branch, and this arm's branches do not go on along a motion",
            "use planner global or refine",
        )  # fmt: skip

    def _parameter_gradient(self, q: FloatArray) -> FloatArray:
        return np.broadcast_to(np.arange(self.n) == self.joint, q.shape).astype(float)

    def u_of(self, q: ArrayLike) -> FloatArray:
        """Return the locked joint's angle of postures, in [−π, π], shape (..., 1) [rad]."""
        return np.asarray(wrap(self._joints(q)[..., self.joint : self.joint + 1]))

    def branch_of(self, q: ArrayLike) -> IntArray:
        """Return the number of the nearest of the postures with the same pose and u, from 0, shape (...)."""
        joints = self._joints(q)
        flat = joints.reshape(-1, self.n)
        every, there = self._every(self.forward(flat), np.ascontiguousarray(self.u_of(flat)[:, 0]))
        with np.errstate(invalid="ignore"):
            off = np.where(there, np.abs(wrap(every - flat[:, None])).max(axis=2), np.inf)
        return np.asarray(off.argmin(axis=1)).reshape(joints.shape[:-1])

    def is_on_branch(self, q: ArrayLike, branch: int | str, tolerance: float) -> BoolArray:
        """Return whether postures (..., n) have this number, shape (...)."""
        return np.asarray(self.branch_of(q) == branch_index(self.branches, branch))

    def boxes(self, elbow: str = "any", around: ArrayLike | None = None) -> list[JointBox]:
        """Return the joint limits.

        Raises
        ------
        InvalidInputError
            If one branch is asked for: they do not go on along a motion.
        """
        if elbow != "any":
            raise InvalidInputError(
                "branch", "cannot be asked of an arm that EAIK solves, whose branches do not go on along a motion",
                "leave it out, or give a start posture", elbow,
            )  # fmt: skip
        return [JointBox(self.limits.lower, self.limits.upper)]

    def cover(self, elbow: str = "any") -> Cover:
        """Return cells of the self-motion: proved each, but not proved to be all."""
        return TracedCover(self, elbow)

    def slabs(self, path: Path, elbow: str = "any") -> SlabCover:
        """Raise InvalidInputError: postures are not enclosed."""
        raise InvalidInputError(
            "arm", "has postures that nothing encloses, so that no path is proved to have no motion",
            "use an arm that a closed form solves",
        )  # fmt: skip

    def self_motion(self) -> SelfMotion:
        """Raise InvalidInputError: branches that do not go on along a self-motion have no angle domain."""
        raise InvalidInputError(
            "arm", "has branches that do not go on along a self-motion, so that its angle domain is not told",
            "use plan, verify or compare",
        )  # fmt: skip
