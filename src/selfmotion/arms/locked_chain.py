"""All postures of a seven-joint chain at a pose with one joint locked, by EAIK: subproblem decomposition of six joints.

EAIK (Ostermeier, Külz, Althoff, "Automatic geometric decomposition for analytical inverse kinematics", 2025) is the
optional package behind it, imported when the first chain needs it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.angles import wrap
from selfmotion.arms.chain import Chain
from selfmotion.errors import InvalidInputError

_PROBES = 32  # postures by which it is found which joints may be locked
_ENOUGH = 0.9  # part of them that must be found
_FOUND = 1e-3  # how near an answer must be to the posture that its pose was made from [rad]
_DIGITS = 5  # of directions and of lengths [m], where a file's own are too rough for axes to meet
_RATE = 1e-6  # step of the difference quotient that self-motions are followed by [rad]


class Lockable(NamedTuple):
    """A joint that may be locked.

    Attributes
    ----------
    joint : int
    passed : float
        How many times, per radian of self-motion, a posture passes through one of 1000 values over the joint's range.
    """

    joint: int
    passed: float


class LockedChain:
    """A chain of seven revolute joints as EAIK sees it.

    Parameters
    ----------
    chain : Chain
    rounded : bool
        Whether directions and points of the axes are rounded first, in the frame of the first joint and at q = 0. In a
        file that says 1.5708 for a right angle no three axes meet, and nothing decomposes that; those who ask must mend
        the answers then.

    Raises
    ------
    InvalidInputError
        If the package EAIK is missing.
    """

    def __init__(self, chain: Chain, rounded: bool = False) -> None:
        self.chain = chain
        self._robot = _eaik().Robot
        frame, axes, points = np.eye(4), [np.array([0.0, 0.0, 1.0])], [np.zeros(3), np.zeros(3)]
        for offset in chain.offsets[1:-1]:
            frame = frame @ offset
            axes.append(frame[:3, 2])
            points.append(frame[:3, 3])
        frame = frame @ chain.offsets[-1]
        points.append(frame[:3, 3])
        directions, steps = np.array(axes), np.diff(np.array(points), axis=0)
        if rounded:
            directions, steps = np.round(directions, _DIGITS), np.round(steps, _DIGITS)
            directions /= np.linalg.norm(directions, axis=1)[:, None]
        self._axes, self._steps = directions.T, steps.T
        self._base, self._turn = np.linalg.inv(chain.offsets[0]), frame[:3, :3]

    def postures(self, transforms: FloatArray, joint: int, values: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return all postures at poses with a joint locked.

        Parameters
        ----------
        transforms : array, shape (k, 4, 4)
        joint : int
        values : array, shape (k,)
            Where it is locked [rad].

        Returns
        -------
        q : array, shape (m, 7)
            In [−π, π], as they come: neither checked nor in an order. Answers that only come near the pose are left
            out.
        of : array of int, shape (m,)
            Which of the poses each is at.
        """
        poses = self._base @ transforms
        poses[:, :3, :3] = poses[:, :3, :3] @ self._turn.T
        found, of = [np.empty((0, self.chain.n))], [np.empty(0, np.int64)]
        for k, value in enumerate(values):
            try:
                robot = self._robot(self._axes, self._steps, np.eye(3), [(joint, float(value))], True)
                if not robot.has_known_decomposition():
                    continue
                answer = robot.calculate_IK(poses[k])
            except RuntimeError:  # raised at single values, where axes become all but parallel
                continue
            q = np.asarray(answer.Q, dtype=float).reshape(-1, self.chain.n)
            q = q[~np.asarray(answer.is_LS, dtype=bool)]
            q = q[np.isfinite(q).all(axis=1)]
            q[:, joint] = value
            found.append(q)
            of.append(np.full(len(q), k))
        return wrap(np.concatenate(found)), np.concatenate(of)

    def lockable(self) -> list[Lockable]:
        """Return the joints that may be locked, the best first.

        Notes
        -----
        A joint may be locked if its answers hold postures drawn inside the limits, always the same ones: nine in ten,
        since near single values there may be none. That there is a decomposition is not enough: the elbow of a
        shoulder-elbow-wrist arm has one, and yet is given by the pose. The best is the one through whose range
        self-motions run fastest, by the mean of |dq/ds| over those postures, so that few of them pass between two
        sampled values.
        """
        chain = self.chain
        low, high = (np.where(np.isfinite(ends), ends, turn) for ends, turn in (
            (chain.limits.lower, -np.pi), (chain.limits.upper, np.pi)
        ))  # fmt: skip
        low, high = np.maximum(low, -np.pi), np.maximum(np.minimum(high, np.pi), np.maximum(low, -np.pi))
        q = np.random.default_rng(0).uniform(low, high, (_PROBES, chain.n))
        poses = chain.forward(q)
        speed = np.array([_tangent(chain, posture) for posture in q])
        found = []
        for j in range(chain.n):
            answers, of = self.postures(poses, j, q[:, j])
            near = np.abs(wrap(answers - q[of])).max(axis=1, initial=0.0) <= _FOUND
            if len(np.unique(of[near])) >= _ENOUGH * _PROBES and high[j] > low[j]:
                found.append(Lockable(j, float(1000.0 * speed[:, j].mean() / (high[j] - low[j]))))
        return sorted(found, key=lambda one: -one.passed)


def _tangent(chain: Chain, q: FloatArray) -> FloatArray:
    """Return by how much each joint moves along the self-motion, shape (n,)."""
    ahead = chain.forward(q + _RATE * np.eye(chain.n)) - chain.forward(q)
    return np.abs(np.linalg.svd(ahead[:, :3].reshape(chain.n, -1).T)[2][-1])


def _eaik() -> Any:
    try:
        from eaik.pybindings import EAIK  # the solver alone: the package's own front ends load meshes and viewers
    except ImportError:
        raise InvalidInputError(
            "arm", "has 7 joints that no closed form solves, and the package EAIK is missing, which may do it",
            "pip install 'selfmotion[ik]'",
        ) from None  # fmt: skip
    return EAIK
