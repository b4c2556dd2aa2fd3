"""The links of an arm as capsules, what each joint does to them, and which of them may meet.

Sets of postures are told free or blocked by how far a link moves at most, which `levers` say; everything is in 3-D,
planar arms being in the plane z = 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray, IntArray
from selfmotion.arms.limits import JointLimits
from selfmotion.arms.planar import PlanarArm
from selfmotion.arms.protocols import RedundantArm
from selfmotion.arms.shapes import Shapes
from selfmotion.errors import InvalidInputError

POSTURES = 1000
"""Random postures in every one of which two links touch before they are taken to do so always."""
_BLOCK = 20_000  # ends of capsules that are placed at once
_PAD = 1e-14  # of the arm's size: what rounding does to a lever per joint


@dataclass(frozen=True)
class Links:
    """The capsules of an arm.

    A chain is ``T(q) = F_0 Z(q_1) F_1 … Z(q_n) F_n``, as in :class:`~selfmotion.arms.chain.Chain`; the arm's own joint
    positions q, whatever a closed form counts them from.

    Attributes
    ----------
    frame : array of int, shape (c,)
        Joint j after whose Z(q_j) a capsule's frame is, counted from 0; −1 for the base frame, before F_0.
    ends : array, shape (c, 2, 3)
        Ends of the capsules' segments in those frames, in the arm's unit of length.
    radius : array, shape (c,)
    names : tuple of str
        The links that the capsules are parts of.
    pairs : array of int, shape (p, 2)
        Capsules that may meet: of links with two joints or more between them, but for those said never to meet, and
        those that touch in every one of 1000 random postures, the same each time: capsules are thicker than links.
    turns, shifts : array, shape (n + 1, 3, 3) and (n + 1, 3)
        Rotations and translations of F_0 … F_n.
    first : int
        The first joint that turns; those before it slide.
    levers : array, shape (c, 2, n)
        No end of a capsule moves faster, for a rate of one of a joint, in any posture within the limits: its largest
        distance from the axis of a joint that turns, one for a joint that slides, and zero for joints farther out.
    loose : tuple of str
        Links that have a shape and hang on the arm by joints of their own, such as fingers: they are left out.
    """

    frame: IntArray
    ends: FloatArray
    radius: FloatArray
    names: tuple[str, ...]
    pairs: IntArray
    turns: FloatArray
    shifts: FloatArray
    first: int
    levers: FloatArray
    loose: tuple[str, ...] = ()

    @classmethod
    def of(cls, arm: RedundantArm) -> Self:
        """Return the links of an arm.

        Parameters
        ----------
        arm : RedundantArm
            Links of the plane are as long as they say and as thick as `arm.thickness`; those of arms in space have the
            shapes of their URDF.

        Returns
        -------
        Links

        Raises
        ------
        InvalidInputError
            If nothing is known of the shapes of its links, or of one link; or if a joint slides beyond one that turns.
        """
        return cls._planar(arm) if isinstance(arm, PlanarArm) else cls._spatial(arm)

    @classmethod
    def _planar(cls, arm: PlanarArm) -> Self:
        n, zeros = arm.n, np.zeros(arm.n)
        tips = np.stack([arm.links, zeros, zeros], axis=-1)
        return cls._made(
            frame=np.arange(n),
            ends=np.stack([np.zeros((n, 3)), tips], axis=1),
            radius=0.5 * arm.thickness,
            names=tuple(f"link {j}" for j in range(1, n + 1)),
            turns=np.broadcast_to(np.eye(3), (n + 1, 3, 3)).copy(),
            shifts=np.concatenate([np.zeros((1, 3)), tips]),
            limits=arm.limits,
        )

    @classmethod
    def _spatial(cls, arm: RedundantArm) -> Self:
        chain = getattr(arm, "chain", None)
        shapes: Shapes = Shapes() if chain is None else chain.shapes
        remedy = "give it <collision> spheres, cylinders, boxes or capsules in a URDF file"
        for link, why in shapes.unread.items():
            raise InvalidInputError("arm", f"has a link whose shape is not known: {link} {why}", remedy)
        if chain is None or not shapes.capsules:
            raise InvalidInputError("arm", "has no links with a shape", remedy)
        slides = chain.prismatic
        first = int(slides.sum())
        if slides[first:].any():
            name = chain.names[int(np.nonzero(slides)[0][-1])]
            raise InvalidInputError("arm", f"has joint {name}, which slides beyond one that turns", "leave shapes out")
        parts = shapes.capsules
        return cls._made(
            frame=np.array([part.frame for part in parts]),
            ends=np.array([part.ends for part in parts]),
            radius=np.array([part.radius for part in parts]),
            names=tuple(part.link for part in parts),
            turns=np.ascontiguousarray(chain.offsets[:, :3, :3]),
            shifts=np.ascontiguousarray(chain.offsets[:, :3, 3]),
            limits=chain.limits,
            first=first,
            loose=shapes.loose,
            never={frozenset(pair) for pair in shapes.apart},
        )

    @classmethod
    def _made(
        cls, frame: IntArray, ends: FloatArray, radius: FloatArray, names: tuple[str, ...], turns: FloatArray,
        shifts: FloatArray, limits: JointLimits, first: int = 0, loose: tuple[str, ...] = (),
        never: AbstractSet[frozenset[str]] = frozenset(),
    ) -> Self:  # fmt: skip
        """Return the links with their levers and pairs worked out."""
        levers = _levers(frame, ends, turns, shifts, limits, first)
        one, other = np.triu_indices(len(frame), 1)
        apart = np.abs(frame[one] - frame[other]) >= 2
        if never:
            apart &= [frozenset((names[i], names[k])) not in never for i, k in zip(one, other, strict=True)]
        pairs = np.stack([one[apart], other[apart]], axis=1).astype(np.int64)
        links = cls(frame.astype(np.int64), ends, radius, names, pairs, turns, shifts, first, levers, loose)
        meet = links._meeting(limits)
        for array in (links.frame, ends, radius, turns, shifts, levers, meet):
            array.flags.writeable = False
        return cls(links.frame, ends, radius, names, meet, turns, shifts, first, levers, loose)

    def ends_at(self, q: ArrayLike) -> FloatArray:
        """Return where the ends of the capsules are.

        Parameters
        ----------
        q : array_like, shape (..., n)
            Postures [rad, m].

        Returns
        -------
        array, shape (..., c, 2, 3)
            In the base frame.
        """
        joints = np.asarray(q, dtype=float)
        n = len(self.turns) - 1
        if joints.shape[-1:] != (n,):
            raise InvalidInputError("q", f"has shape {joints.shape}", f"give (..., {n})")
        found = np.empty((*joints.shape[:-1], *self.ends.shape))
        still = self.frame < 0
        found[..., still, :, :] = self.ends[still]
        turn = np.broadcast_to(np.eye(3), (*joints.shape[:-1], 3, 3))
        place = np.zeros((*joints.shape[:-1], 3))
        for j in range(n):
            place = place + turn @ self.shifts[j]
            turn = turn @ self.turns[j]
            value = joints[..., j, None]
            if j < self.first:
                place = place + value * turn[..., 2]
            else:
                cos, sin = np.cos(value), np.sin(value)
                x, y = turn[..., 0], turn[..., 1]
                turn = np.stack([cos * x + sin * y, cos * y - sin * x, turn[..., 2]], axis=-1)
            here = self.frame == j
            if here.any():
                moved = np.einsum("...xy,cky->...ckx", turn, self.ends[here])
                found[..., here, :, :] = moved + place[..., None, None, :]
        return found

    def _meeting(self, limits: JointLimits) -> IntArray:
        """Return the pairs, but for those that touch in all random postures."""
        always = np.ones(len(self.pairs), bool)
        for q in _random_postures(limits, max(1, _BLOCK // len(self.frame))):
            if not always.any():
                break
            one, other = self.pairs[always].T
            ends = self.ends_at(q)
            touch = segment_distances(ends[:, one], ends[:, other]) <= self.radius[one] + self.radius[other]
            always[always] = touch.all(axis=0)
        return self.pairs[~always]


def segment_distances(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the distances between segments (..., 2, 3).

    Notes
    -----
    C. Ericson, Real-Time Collision Detection, 2005, section 5.1.9: the foot on one line, clamped to its segment, then
    the foot of that point on the other, clamped, and back.
    """
    p, u, d, v = one[..., 0, :], other[..., 0, :], one[..., 1, :] - one[..., 0, :], other[..., 1, :] - other[..., 0, :]
    a, e, b = (d * d).sum(-1), (v * v).sum(-1), (d * v).sum(-1)
    r = p - u
    c, f = (d * r).sum(-1), (v * r).sum(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = _part(b * f - c * e, a * e - b * b)
        t = _part(b * s + f, e)
        s = _part(b * t - c, a)
    return np.asarray(np.linalg.norm(r + s[..., None] * d - t[..., None] * v, axis=-1))


def _part(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Return a quotient inside [0, 1]; 0 for segments that are parallel or points."""
    return np.clip(np.where(denominator > 0, numerator / denominator, 0.0), 0.0, 1.0)


def _random_postures(limits: JointLimits, block: int) -> Iterator[FloatArray]:
    """Yield the same random postures each time, in blocks (k, n): one, and then more at once."""
    rng = np.random.default_rng(0)
    low = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    high = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    left, size = POSTURES, 1
    while left > 0:
        yield rng.uniform(low, high, (size, len(low)))
        left -= size
        size = min(block, left, 8 * size)


def _levers(
    frame: IntArray, ends: FloatArray, turns: FloatArray, shifts: FloatArray, limits: JointLimits, first: int
) -> FloatArray:
    """Return the levers, shape (c, 2, n).

    Where an end is, seen from the frame of joint j, is enclosed for all positions of the joints farther out: by a
    cylinder about the axis, ``√(x² + y²) ≤ around`` and ``low ≤ z ≤ high``, and by a ball, ``|p| ≤ far``. Both are
    taken from one frame to the next, outermost first; a joint that turns leaves them as they are.
    """
    n = len(turns) - 1
    points = ends.reshape(-1, 3)
    owner = np.repeat(frame, 2)
    around, low, high, far = (np.zeros(len(points)) for _ in range(4))
    found = np.zeros((len(points), n))
    for j in range(n - 1, -1, -1):
        new = owner == j
        around[new], far[new] = np.hypot(points[new, 0], points[new, 1]), np.linalg.norm(points[new], axis=1)
        low[new] = high[new] = points[new, 2]
        here = owner >= j
        if j < first:
            found[here, j] = 1.0
            continue
        found[here, j] = around[here]
        around, low, high, far = _carried(turns[j], shifts[j], around, low, high, far)
    # Rotations are orthonormal to 1e-9, in the arm's size; the rest is what sums and products round.
    skew = sum(float(np.abs(turn.T @ turn - np.eye(3)).max()) for turn in turns)
    size = np.linalg.norm(shifts, axis=1).sum() + np.linalg.norm(points, axis=1).max(initial=0.0)
    moves = (owner[:, None] >= np.arange(n)) & (np.arange(n) >= first)
    found[moves] += (3.0 * skew + _PAD * (n + 1)) * size
    return found.reshape(len(frame), 2, n)


def _carried(
    turn: FloatArray, shift: FloatArray, around: FloatArray, low: FloatArray, high: FloatArray, far: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the enclosures in the frame in which their own has the pose (turn, shift)."""
    sine, cosine = float(np.hypot(turn[0, 2], turn[1, 2])), float(turn[2, 2])
    along = turn[:2, 2] / sine if sine > 0 else np.array([1.0, 0.0])
    ahead = float(along @ shift[:2])
    beside = abs(float(along[0] * shift[1] - along[1] * shift[0]))
    # The axis' foot in the plane across the new axis; discs about it are seen as ellipses, `cosine` times as long.
    foot = np.maximum(np.abs(ahead + sine * low), np.abs(ahead + sine * high))
    wide = np.hypot(foot + abs(cosine) * around, beside + around)
    wide = np.minimum(wide, np.minimum(np.hypot(foot, beside) + around, np.hypot(*shift[:2]) + far))
    one, other = cosine * low, cosine * high
    lower = shift[2] + np.maximum(np.minimum(one, other) - sine * around, -far)
    upper = shift[2] + np.minimum(np.maximum(one, other) + sine * around, far)
    reach = np.minimum(far + np.linalg.norm(shift), np.hypot(wide, np.maximum(np.abs(lower), np.abs(upper))))
    return wide, lower, upper, reach


__all__ = ["Links", "segment_distances"]
