"""Planar arms with any number of links, in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import LARGEST, branch_index, finite_array, number, read_only
from selfmotion._types import ArmPlace, BoolArray, FloatArray, IntArray, Limits, Vector
from selfmotion.angles import TAU, wrap
from selfmotion.arms._kernels import planar_ik, planar_rates
from selfmotion.arms.cells import Cover
from selfmotion.arms.limits import JointBox, JointLimits
from selfmotion.arms.placement import ArmPlacement
from selfmotion.arms.planar_self_motion import PlanarLine, PlanarSelfMotion
from selfmotion.arms.radii import Radii, radii_of
from selfmotion.arms.slabs import SlabCover
from selfmotion.errors import InvalidInputError

if TYPE_CHECKING:
    from selfmotion.paths import Path

MAX_LINKS = 1000
# Beyond this ratio of lengths a link is lost in the rounding of another.
MOST_RATIO = 1e12
# Distance beyond reach that rounding of x alone explains; postures within it are stretched onto the fold.
_REACH_ROUNDING = 1e-13
_SIGNS = (1.0, -1.0)
_MOST_HALF_TURNS = 8  # an arm's joint makes two or three turns; more are not told apart by any task


class PlanarArm:
    """A planar serial arm of revolute joints with its base at the origin.

    Parameters
    ----------
    links : array_like, shape (n,)
        Link lengths, n ≥ 3, all positive, in any one unit of length.
    limits : sequence, optional
        Per joint ``None`` or ``(lower, upper)`` [rad]; see :class:`~selfmotion.arms.limits.JointLimits`.
    direction : float, optional
        Absolute direction that the last link must keep [rad]. It takes one degree of redundancy away, and
        needs n ≥ 4.
    placement : mapping, optional
        Where the arm stands in space, for what is written for others; see :class:`~selfmotion.arms.ArmPlacement`. Tool,
        path and plan stay in the arm's plane.
    thickness : float or array_like, shape (n,)
        Width of the links, of all or of each, in the unit of their lengths: what obstacles are kept clear of are
        capsules of half that radius about the lines from joint to joint.

    Attributes
    ----------
    n : int
        Number of joints.
    n_u : int
        Degree of redundancy, ``n − 2``, one less with a fixed direction.
    branches : tuple of str
        ``("positive", "negative")``: the sign of sin θ2.

    Raises
    ------
    InvalidInputError
        If there are too few links, or one is not a positive number.

    Notes
    -----
    The redundancy vector u holds the absolute directions of links 3…n (of 3…n−1 with a fixed direction).
    ``w = x − Σ_{j≥3} l_j e(u_j)`` is the target of the first two links, which reach it in two ways, and the other
    joints are differences of absolute directions. For n = 3 these are (2)–(7) of the seed's paper with u = θ_g (its
    ``l_1`` in (2) meaning ``l_3``). Formulas: docs/mathematics.
    """

    kind = "planar"
    dimension = 2
    branches: tuple[str, ...] = ("positive", "negative")
    rigorous = True

    def __init__(
        self,
        links: Vector,
        limits: Limits = None,
        direction: float | None = None,
        placement: ArmPlace = None,
        thickness: float | Vector = 0.0,
    ) -> None:
        self.links = read_only(finite_array("links", links, 1))
        self.n = len(self.links)
        least = 3 if direction is None else 4
        if not least <= self.n <= MAX_LINKS:
            why = "" if direction is None else " when the last link keeps a direction"
            raise InvalidInputError("links", f"has {self.n} entries", f"give {least} to {MAX_LINKS}{why}", links)
        for j, length in enumerate(self.links):
            if not length >= 1 / LARGEST:
                reason = "is too small" if length > 0 else "must be greater than zero"
                raise InvalidInputError(f"links.{j}", reason, "give a length", float(length))
        if self.links.max() > MOST_RATIO * self.links.min():
            j = int(np.argmin(self.links))
            raise InvalidInputError(
                f"links.{j}", f"is over {MOST_RATIO:g} times shorter than the longest", "leave it out"
            )
        self.limits = JointLimits(limits, self.n)
        self.direction = None if direction is None else number("direction", direction, -1e3, 1e3)
        self.n_u = self.n - 2 - (self.direction is not None)
        self.placement = ArmPlacement.of("placement", placement, self.n)
        self.thickness = read_only(_thicknesses(thickness, self.n))

    def __repr__(self) -> str:
        extra = "" if self.direction is None else f", direction={self.direction!r}"
        extra += f", thickness={self.thickness.tolist()}" if self.thickness.any() else ""
        return f"PlanarArm(links={self.links.tolist()}, limits={self.limits.as_list()}{extra})"

    @property
    def has_structure(self) -> bool:
        """Whether the structure of the angle domain is known in closed form: with one redundant degree it is."""
        return self.n_u == 1

    @property
    def reach(self) -> float:
        """Sum of the link lengths."""
        return float(self.links.sum())

    def sign(self, branch: int | str) -> float:
        """Return the sign of sin θ2 on a branch."""
        return _SIGNS[branch_index(self.branches, branch)]

    @property
    def annulus(self) -> tuple[FloatArray, float, float]:
        """Centre, inner and outer radius of what the tool can reach when no joint is limited."""
        links, center = self.links, np.zeros(2)
        if self.direction is not None:
            center = links[-1] * np.array([np.cos(self.direction), np.sin(self.direction)])
            links = links[:-1]
        outer = float(links.sum())
        return center, max(0.0, 2 * float(links.max()) - outer), outer

    def shortfall(self, x: ArrayLike) -> FloatArray:
        """Return how far tool positions are out of the links' reach, whatever the joint limits.

        Parameters
        ----------
        x : array_like, shape (..., 2)

        Returns
        -------
        array, shape (...)
            Zero or less inside.
        """
        center, inner, outer = self.annulus
        offset = np.asarray(x, dtype=float) - center
        distance = np.hypot(offset[..., 0], offset[..., 1])
        return np.maximum(distance - outer, inner - distance)

    def forward(self, q: ArrayLike) -> FloatArray:
        """Return the tool position.

        Parameters
        ----------
        q : array_like, shape (..., n)
            Joint angles [rad].

        Returns
        -------
        array, shape (..., 2)
            ``Σ l_i e(θ_1 + … + θ_i)``, equation (1d).
        """
        phi = np.cumsum(self._joints(q), axis=-1)
        return np.stack([np.cos(phi) @ self.links, np.sin(phi) @ self.links], axis=-1)

    def joint_positions(self, q: ArrayLike) -> FloatArray:
        """Return the base, every joint and the tool as points, shape (..., n + 1, 2)."""
        phi = np.cumsum(self._joints(q), axis=-1)
        steps = self.links[:, None] * np.stack([np.cos(phi), np.sin(phi)], axis=-1)
        base = np.zeros((*phi.shape[:-1], 1, 2))
        return np.concatenate([base, np.cumsum(steps, axis=-2)], axis=-2)

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Return ∂x/∂q, shape (..., 2, n); with a fixed direction a third row of ones, ∂(direction)/∂q."""
        points = self.joint_positions(q)
        lever = points[..., -1:, :] - points[..., :-1, :]
        rows = [-lever[..., 1], lever[..., 0]]
        if self.direction is not None:
            rows.append(np.ones_like(lever[..., 0]))
        return np.stack(rows, axis=-2)

    def jacobian_rate(self, q: ArrayLike, dq: ArrayLike) -> FloatArray:
        """Return how :meth:`jacobian` changes along `dq`, ``Σ_j ∂J/∂θ_j dq_j``.

        Parameters
        ----------
        q, dq : array_like, shape (..., n)

        Returns
        -------
        array, shape (..., tasks, n)
            The second derivatives of the task: for any λ, ``λᵀ jacobian_rate(q, v)`` is the Hessian of λᵀx times v.
        """
        phi, spin = np.cumsum(self._joints(q), axis=-1), np.cumsum(self._joints(dq), axis=-1)
        # Column i of the Jacobian is the lever from joint i to the tool, a quarter turn ahead; its rate is theirs.
        along = np.cumsum((self.links * np.cos(phi) * spin)[..., ::-1], axis=-1)[..., ::-1]
        across = np.cumsum((self.links * np.sin(phi) * spin)[..., ::-1], axis=-1)[..., ::-1]
        rows = [-along, -across]
        if self.direction is not None:
            rows.append(np.zeros_like(along))
        return np.stack(rows, axis=-2)

    def manipulability(self, q: ArrayLike) -> FloatArray:
        """Return Yoshikawa's √det(J Jᵀ), shape (...); zero at singular postures."""
        # The product of the singular values; the determinant itself would lose half the digits near zero.
        return np.asarray(np.linalg.svd(self.jacobian(q), compute_uv=False).prod(axis=-1))

    def solve(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, BoolArray]:
        """Solve the inverse kinematics.

        Parameters
        ----------
        x : array_like, shape (..., 2)
            Tool positions.
        u : array_like, shape (..., n_u)
            Redundancy vectors [rad]; leading dimensions broadcast against those of `x`.
        branch : {0, 1, "positive", "negative"}
            Sign of sin θ2.

        Returns
        -------
        q : array, shape (..., n)
            Joint angles in [−π, π]. Out of reach, the first two links point at their target.
        ok : array of bool, shape (...)
            Whether the target is in reach. Joint limits are not looked at.

        Raises
        ------
        InvalidInputError
            If shapes do not fit.
        """
        q, margin = self.solve_with_margin(x, u, branch)
        return q, np.asarray(margin >= -_REACH_ROUNDING * self.reach)

    def solve_with_margin(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, FloatArray]:
        """Like :meth:`solve`, with the signed distance to the limit of reach instead of a verdict."""
        points, directions = self._arrays(x, u)
        return planar_ik(self.links, points, directions, self.sign(branch))

    def reach_margin(self, x: ArrayLike, u: ArrayLike) -> FloatArray:
        """Return the signed distance of ``|w|`` to ``[|l1 − l2|, l1 + l2]``, shape (...); negative out of reach."""
        return self.solve_with_margin(x, u)[1]

    def rates(self, x: ArrayLike, dx: ArrayLike, u: ArrayLike, du: ArrayLike, branch: int | str = 0) -> FloatArray:
        """Return the joint rates that go with the rates of tool and redundancy vector.

        Parameters
        ----------
        x, dx : array_like, shape (..., 2)
        u, du : array_like, shape (..., n_u)
        branch : {0, 1, "positive", "negative"}

        Returns
        -------
        array, shape (..., n)
            Infinite or NaN exactly at a fold, sin θ2 = 0.

        Raises
        ------
        InvalidInputError
            If shapes do not fit.
        """
        points, directions = self._arrays(x, u)
        speeds, turning = self._arrays(dx, du, ("dx", "du"), last=0.0)
        return planar_rates(self.links, points, speeds, directions, turning, self.sign(branch))

    def derivative(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, FloatArray]:
        """Return the partial derivatives of :meth:`solve`.

        Parameters
        ----------
        x : array_like, shape (..., 2)
        u : array_like, shape (..., n_u)
        branch : {0, 1, "positive", "negative"}

        Returns
        -------
        dq_du : array, shape (..., n, n_u)
        dq_dx : array, shape (..., n, 2)
            Infinite or NaN exactly at a fold.
        """
        still_x, still_u = np.zeros(2), np.zeros(self.n_u)
        by_u = [self.rates(x, still_x, u, unit, branch) for unit in np.eye(self.n_u)]
        by_x = [self.rates(x, unit, u, still_u, branch) for unit in np.eye(2)]
        return np.stack(by_u, axis=-1), np.stack(by_x, axis=-1)

    def margins(self, q: ArrayLike) -> FloatArray:
        """Return the signed distance to every constraint, shape (..., n): here the joint limits [rad].

        Parameters
        ----------
        q : array_like, shape (..., n)
        """
        return self.limits.margin(self._joints(q))

    def task_error(self, q: ArrayLike, x: ArrayLike) -> FloatArray:
        """Return how far postures are from their task, in the unit of length.

        Parameters
        ----------
        q : array_like, shape (..., n)
        x : array_like, shape (..., 2)

        Returns
        -------
        array, shape (...)
            Distance of the tool from x; with a fixed direction the larger of this and reach × error of direction [rad].
        """
        miss = np.asarray(np.linalg.norm(self.forward(q) - np.asarray(x, dtype=float), axis=-1))
        if self.direction is None:
            return miss
        return np.maximum(miss, self.reach * np.abs(wrap(self._joints(q).sum(axis=-1) - self.direction)))

    def task_residual(self, q: ArrayLike, x: ArrayLike) -> FloatArray:
        """Return what postures lack to do their task, the right-hand side of a Newton step with :meth:`jacobian`.

        Parameters
        ----------
        q : array_like, shape (..., n)
        x : array_like, shape (..., 2)

        Returns
        -------
        array, shape (..., 2) or (..., 3)
            x minus the tool position, and with a fixed direction what the last link's lacks [rad].
        """
        lack = np.asarray(x, dtype=float) - self.forward(q)
        if self.direction is None:
            return lack
        turn = wrap(self.direction - self._joints(q).sum(axis=-1))
        return np.concatenate([lack, turn[..., None]], axis=-1)

    def task_rate(self, x: ArrayLike, dx: ArrayLike) -> FloatArray:
        """Return how fast the task changes where tool positions `x` (..., 2) move by `dx`, shape (..., tasks)."""
        moving = np.broadcast_arrays(np.asarray(dx, dtype=float), np.asarray(x, dtype=float))[0]
        if self.direction is None:
            return moving
        return np.concatenate([moving, np.zeros((*moving.shape[:-1], 1))], axis=-1)  # a direction that is kept

    def relaxed(self, slack: ArrayLike, upper: ArrayLike | None = None) -> PlanarArm:
        """Return the same arm with joint limits that give.

        Parameters
        ----------
        slack : float or array_like, shape (n,)
            By how much the lower limits give [rad].
        upper : float or array_like, shape (n,), optional
            The same of the upper limits; `slack` by default.
        """
        more = np.asarray(slack if upper is None else upper, dtype=float)
        ends = zip(self.limits.lower - np.asarray(slack, dtype=float), self.limits.upper + more, strict=True)
        return PlanarArm(self.links, list(ends), self.direction, self.placement, self.thickness)

    def u_of(self, q: ArrayLike) -> FloatArray:
        """Return the redundancy vector of a posture, in [−π, π], shape (..., n_u)."""
        phi = np.cumsum(self._joints(q), axis=-1)[..., 2 : 2 + self.n_u]
        return wrap(phi)

    def branch_of(self, q: ArrayLike) -> IntArray:
        """Return the branch index of postures (..., n), shape (...): 0 where sin θ2 ≥ 0."""
        return np.where(np.sin(self._joints(q)[..., 1]) >= 0, 0, 1)

    def is_on_branch(self, q: ArrayLike, branch: int | str, tolerance: float) -> BoolArray:
        """Return whether postures (..., n) are on a branch, or within `tolerance` of its fold in sin θ2."""
        sign = self.sign(branch)
        return np.asarray(sign * np.sin(self._joints(q)[..., 1]) >= -tolerance)

    def boxes(self, elbow: str = "any", around: ArrayLike | None = None) -> list[JointBox]:
        """Return the joint limits, narrowed to one elbow: to half turns of joint 2.

        Parameters
        ----------
        elbow : {"any", "positive", "negative"}
        around : array_like, shape (n,), optional
            Posture near which half turns are wanted, if there are many; else those near zero are returned.

        Returns
        -------
        list of JointBox
            One per half turn inside the limits, the nearest eight, the nearest first; postures in it have the elbow,
            folds included. A free joint 2 has one, as its whole turns do not matter.
        """
        whole = JointBox(self.limits.lower, self.limits.upper)
        if elbow == "any":
            return [whole]
        low, high = whole.lower[1], whole.upper[1]
        middle = 0.5 * np.pi * self.sign(elbow)
        angle = 0.0 if around is None else float(self._joints(around)[1])
        nearest = np.rint((np.clip(angle, low, high) - middle) / TAU)
        count = 1 if np.isinf([low, high]).all() else _MOST_HALF_TURNS
        found = []
        for turn in sorted(nearest + np.arange(-count, count + 1), key=lambda turn: abs(turn - nearest)):
            box = JointBox(whole.lower.copy(), whole.upper.copy())
            box.lower[1] = max(low, middle + TAU * turn - 0.5 * np.pi)
            box.upper[1] = min(high, middle + TAU * turn + 0.5 * np.pi)
            if box.lower[1] <= box.upper[1]:
                found.append(box)
        return found[:count]

    def line(self, u0: ArrayLike, direction: ArrayLike) -> PlanarLine:
        """Return the one-parameter self-motion u(s) = u0 + s·direction.

        Parameters
        ----------
        u0, direction : array_like, shape (n_u,)

        Returns
        -------
        PlanarLine
            Poses and postures, without breakpoints; :meth:`self_motion` has those, for one redundant degree.

        Raises
        ------
        InvalidInputError
            If the shapes do not fit or the direction is zero.
        """
        origin = finite_array("u0", u0, 1, self.n_u)
        along = finite_array("direction", direction, 1, self.n_u)
        if not along.any():
            raise InvalidInputError("direction", "is zero", "say in which direction u moves", direction)
        return PlanarLine(self, origin, along)

    def self_motion(self) -> PlanarSelfMotion:
        """Return the self-motion of an arm with one redundant degree.

        Raises
        ------
        InvalidInputError
            If the arm has another degree of redundancy.
        """
        self._one_redundant_degree("the angle domain needs")
        return PlanarSelfMotion(self)

    def cover(self, elbow: str = "any") -> Cover:
        """Return what covers the self-motion of an arm with one redundant degree by cells.

        Parameters
        ----------
        elbow : {"any", "positive", "negative"}

        Raises
        ------
        InvalidInputError
            If the arm has another degree of redundancy.
        """
        from selfmotion.arms.planar_cover import PlanarCover  # compiled kernels, which few need

        self._one_redundant_degree("a cover needs")
        return PlanarCover(self, elbow)

    def slabs(self, path: Path, elbow: str = "any") -> SlabCover:
        """Return what covers the postures along parts of a path by boxes, for one redundant degree.

        Parameters
        ----------
        path : Path
            One that bounds its speed.
        elbow : {"any", "positive", "negative"}

        Raises
        ------
        InvalidInputError
            If the arm has another degree of redundancy.
        """
        from selfmotion.arms.planar_slabs import PlanarSlabs  # compiled kernels, which few need

        self._one_redundant_degree("slabs need")
        return PlanarSlabs(self, path, elbow)

    def radii(self) -> Radii:
        """Return R_max, R*_min and the co-regular radii of an arm with one redundant degree, (9) and (10).

        Raises
        ------
        InvalidInputError
            If the arm has another degree of redundancy.
        """
        self._one_redundant_degree("these radii need")
        return radii_of(self)

    def _one_redundant_degree(self, what_needs: str) -> None:
        if self.n_u != 1:
            raise InvalidInputError(
                "arm",
                f"has {self.n_u} redundant degrees of freedom; {what_needs} exactly one",
                "use 3 links, or 4 and a fixed direction of the last",
            )

    def _joints(self, q: ArrayLike) -> FloatArray:
        angles = np.asarray(q, dtype=float)
        if angles.ndim < 1 or angles.shape[-1] != self.n:
            raise InvalidInputError("q", f"has shape {angles.shape}", f"give (..., {self.n}), one angle per joint")
        return angles

    def _arrays(
        self, x: ArrayLike, u: ArrayLike, names: tuple[str, str] = ("x", "u"), last: float | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return x (..., 2) and u completed to all links 3…n, (..., n − 2), by the fixed direction or by `last`."""
        points, directions = np.asarray(x, dtype=float), np.asarray(u, dtype=float)
        if points.ndim < 1 or points.shape[-1] != 2:
            raise InvalidInputError(names[0], f"has shape {points.shape}", "give shape (..., 2)")
        if directions.ndim < 1 or directions.shape[-1] != self.n_u:
            raise InvalidInputError(
                names[1], f"has shape {directions.shape}", f"give (..., {self.n_u}), one per redundant degree"
            )
        if self.direction is not None:
            value = self.direction if last is None else last
            directions = np.concatenate([directions, np.full((*directions.shape[:-1], 1), value)], axis=-1)
        return points, directions


def _thicknesses(given: float | Vector, n: int) -> FloatArray:
    """Return the width of each link, shape (n,)."""
    one = np.ndim(given) == 0
    widths = np.full(n, number("thickness", given)) if one else finite_array("thickness", given, 1, n)
    if (widths < 0.0).any():
        j = int(np.argmax(widths < 0.0))
        raise InvalidInputError(
            "thickness" if one else f"thickness.{j}", "must not be negative", "give a width", float(widths[j])
        )
    return widths
