"""What every task-space path is: a curve x(r), r ∈ [0, 1], with derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property, wraps
from inspect import signature
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import finite_array
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.quadrature import integrate
from selfmotion.rotations import apart, upper

PLANE, SPACE, POSE = 2, 3, 7
"""How many numbers a point of a plane curve, a point of a space curve and a pose have."""
_ROUNDING = 1e-12
# A bound that is not finite on a part is asked for on this many halvings of it.
_HALVINGS = 30


class Path(ABC):
    """A curve x(r) over r ∈ [0, 1]: of the plane, of space, or of poses.

    A pose is a row of seven numbers: the position x, y, z, then the unit quaternion w, x, y, z of the orientation.
    Along a path the quaternion is continuous in sign; at r = 0 its w is not negative.

    A subclass sets ``kind`` and implements :meth:`_evaluate`; it overrides :attr:`breaks` where the curve is
    only piecewise smooth, :attr:`waypoints` where points were given, and :meth:`_fastest` to take part in proofs.
    A curve that a tool is to follow with its orientation has `highest_order` 3 and overrides :meth:`_bending`; a path
    of poses overrides :meth:`_turning`.

    Attributes
    ----------
    dimension : {2, 3, 7}
        How many numbers x has: a plane curve's, a space curve's, a pose's.
    highest_order : {2, 3}
        The highest derivative there is.
    made_from : mapping
        What the constructor was given, by name: files that store a path write this.
    """

    kind: ClassVar[str]
    dimension: int = PLANE
    highest_order: int = 2
    made_from: Mapping[str, Any]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if "__init__" in vars(cls):
            cls.__init__ = _remembering(cls.__init__)  # type: ignore[method-assign]

    @abstractmethod
    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return the derivative of `order` 0 to `highest_order` at `r` of shape (k,), as shape (k, dimension).

        The quaternions of poses may have either sign, as long as it is continuous.
        """

    def _fastest(self, low: float, high: float) -> float:
        """Return a bound on ``|x'(r)|`` over [low, high], right but for rounding."""
        raise self._unbounded("speed", "_fastest")

    def _bending(self, low: float, high: float) -> float:
        """Return a bound on ``|x''(r)|`` over [low, high], right but for rounding."""
        raise self._unbounded("second derivative", "_bending")

    def _turning(self, low: float, high: float) -> float:
        """Return a bound on ``|ω(r)|`` over [low, high], right but for rounding."""
        raise self._unbounded("angular speed", "_turning")

    def _unbounded(self, what: str, method: str) -> InvalidInputError:
        reason = f"is a {type(self).__name__}, which bounds its {what} nowhere"
        return InvalidInputError("path", reason, f"implement its method {method}")

    @property
    def breaks(self) -> FloatArray:
        """Path parameters inside (0, 1) where some derivative jumps; there the right-hand one is given."""
        return np.empty(0)

    @property
    def waypoints(self) -> FloatArray:
        """Path parameters of the points that the user gave and that the tool must pass, if any."""
        return np.empty(0)

    def __call__(self, r: ArrayLike, order: int = 0) -> FloatArray:
        """Evaluate the path.

        Parameters
        ----------
        r : array_like, shape (...)
            Path parameter in [0, 1].
        order : {0, 1, 2}
            0 for the position or pose, 1 and 2 for the derivatives with respect to r; 3 where :attr:`highest_order`
            is.

        Returns
        -------
        array, shape (..., dimension)
            In the unit of length of the path; quaternions have none.

        Raises
        ------
        InvalidInputError
            If some r is outside [0, 1] or NaN, the order is none of 0, 1, 2, or the curve has no finite value there.
        """
        values = path_parameter(r)
        if order not in range(self.highest_order + 1):
            orders = "0, 1 or 2" if self.highest_order == 2 else "0, 1, 2 or 3"
            raise InvalidInputError("order", f"must be {orders}", "higher derivatives are not offered", order)
        flat = values.reshape(-1)
        found = self._evaluate(flat, order)
        if not np.isfinite(found).all():
            # Unsaid, NaN would pass for a point that nothing reaches: a proof that there is no motion.
            first = flat[~np.isfinite(found).all(axis=-1)][0]
            name = ("point", "first derivative", "second derivative", "third derivative")[order]
            raise InvalidInputError("path", f"has no finite {name} at r = {first:.6g}", "mend the curve there")
        if self.dimension == POSE and self._downside:
            found = np.concatenate([found[:, :SPACE], -found[:, SPACE:]], axis=1)
        return found.reshape((*values.shape, self.dimension))

    @cached_property
    def _downside(self) -> bool:
        """Whether the quaternion that :meth:`_evaluate` starts with is the negative of the one to give."""
        first = self._evaluate(np.zeros(1), 0)[0, SPACE:]
        return not np.array_equal(upper(first), first)

    def fastest(self, low: float, high: float) -> float:
        """Bound the speed on a part of the path.

        Parameters
        ----------
        low, high : float
            Ends of the part, ``0 ≤ low ≤ high ≤ 1``.

        Returns
        -------
        float
            Not below ``|x'(r)|`` anywhere in [low, high], at breaks on neither side: so
            ``|x(r) − x(s)| ≤ fastest(low, high) |r − s|`` there. The narrower the part the sharper.
            Of a path of poses it is the speed of the position.

        Raises
        ------
        InvalidInputError
            If the part is not one of [0, 1], or the path knows no bound.
        """
        return self._fastest(*part_of_path(low, high)) * (1.0 + _ROUNDING)

    def bending(self, low: float, high: float) -> float:
        """Bound the second derivative of the position on a part of the path.

        Parameters
        ----------
        low, high : float
            Ends of the part, ``0 ≤ low ≤ high ≤ 1``.

        Returns
        -------
        float
            Not below ``|x''(r)|`` anywhere in [low, high], at breaks on neither side.

        Raises
        ------
        InvalidInputError
            If the part is not one of [0, 1], or the path knows no bound.
        """
        return self._bending(*part_of_path(low, high)) * (1.0 + _ROUNDING)

    def turning(self, low: float, high: float) -> float:
        """Bound the angular speed on a part of a path of poses.

        Parameters
        ----------
        low, high : float
            Ends of the part, ``0 ≤ low ≤ high ≤ 1``.

        Returns
        -------
        float
            Not below ``|ω(r)|`` anywhere in [low, high], at breaks on neither side, [rad] per unit of r: so the
            orientations at r and s are at most ``turning(low, high) |r − s|`` apart there. The narrower the part the
            sharper.

        Raises
        ------
        InvalidInputError
            If the path is not one of poses, the part is not one of [0, 1], or the path knows no bound.
        """
        if self.dimension != POSE:
            raise InvalidInputError("path", "has no orientation that could turn", "give a path of poses, kind pose")
        return self._turning(*part_of_path(low, high)) * (1.0 + _ROUNDING)

    def grid(self, parts: int) -> FloatArray:
        """Return a uniform grid of [0, 1] with `parts` parts and every break of the path in it, ascending."""
        return np.unique(np.concatenate([np.linspace(0.0, 1.0, parts + 1), self.breaks]))

    @cached_property
    def length(self) -> float:
        """Arc length ∫|x'(r)| dr of the position, to about ten digits."""
        return self.integrated_length()

    def integrated_length(self) -> float:
        """Return the arc length as an integral, whatever the curve."""
        return integrate(lambda r: distance(self._evaluate(r, 1)), self.grid(16), tolerance=1e-12).value

    @cached_property
    def extent(self) -> float:
        """Largest coordinate extent of the position, the yardstick for tolerances; 0 if the tool turns in place."""
        points = self._evaluate(self.grid(64), 0)
        return float(np.ptp(points[:, :SPACE], axis=0).max())

    @property
    def is_closed(self) -> bool:
        """Whether the last point is the first one, to 1e-9 of :attr:`extent`; the rotation too, to 1e-9 rad."""
        first, last = self._evaluate(np.array([0.0, 1.0]), 0)
        if self.dimension == POSE and apart(first[SPACE:], last[SPACE:]) > 1e-9:
            return False
        return bool(distance(last - first) <= 1e-9 * self.extent)


def _remembering(init: Callable[..., None]) -> Callable[..., None]:
    """Return a constructor that leaves what it was given in ``made_from``.

    What a path makes of it, such as quaternions of unit norm, need not give the same bits when it is made again.
    """
    form = signature(init)

    @wraps(init)
    def remembering(self: Path, *args: Any, **kwargs: Any) -> None:
        if "made_from" not in vars(self):  # else a subclass has been given it
            try:
                given = form.bind(self, *args, **kwargs).arguments
                self.made_from = {name: _kept(value) for name, value in list(given.items())[1:]}
            except TypeError:  # wrong arguments, which the constructor itself refuses best
                pass
        init(self, *args, **kwargs)

    return remembering


def _kept(value: Any) -> Any:
    """Return a copy of arrays, lists and mappings, which their owner may change; paths as they are."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, Mapping):
        return {key: _kept(item) for key, item in value.items()}
    return [_kept(item) for item in value] if isinstance(value, list | tuple) else value


def distance(x: FloatArray) -> FloatArray:
    """Return the lengths of vectors (..., 2) or (..., 3), or of the position part of poses (..., 7)."""
    plane = np.hypot(x[..., 0], x[..., 1])
    return np.asarray(plane if x.shape[-1] == PLANE else np.hypot(plane, x[..., 2]))


def plane_or_space(field: str, value: Any, ndim: int) -> FloatArray:
    """Return `value` as finite points of the plane, of two numbers, or of space, of three."""
    array = finite_array(field, value, ndim)
    if array.shape[-1] not in (PLANE, SPACE):
        k = "" if ndim == 1 else "k, "
        want = f"give finite numbers of shape ({k}2) or ({k}3)".replace("(2)", "(2,)").replace("(3)", "(3,)")
        raise InvalidInputError(field, f"has shape {array.shape}", want, value)
    return array


def same_dimension(field: str, first: Path, second: Path) -> None:
    """Refuse two paths of which one has more numbers than the other."""
    if first.dimension != second.dimension:
        names = {PLANE: "a plane curve", SPACE: "a space curve", POSE: "a path of poses"}
        raise InvalidInputError(
            field, f"mixes {names[first.dimension]} with {names[second.dimension]}", "give paths of one sort"
        )


def part_of_path(low: float, high: float) -> tuple[float, float]:
    """Return the ends of a part of [0, 1], checked."""
    ends = path_parameter([low, high])
    if ends[0] > ends[1]:
        raise InvalidInputError("low", "is beyond high", "give the lower end first", (low, high))
    return float(ends[0]), float(ends[1])


def worst_of_parts(path: Path, low: float, high: float, bound: Callable[[float, float], float], what: str) -> float:
    """Return the largest `bound` over parts of [low, high] that no break of the path divides.

    Parameters
    ----------
    path : Path
    low, high : float
    bound : callable
        Of the ends of a part, the bound there; infinite if it finds none, then the part is halved.
    what : str
        What is bounded, for the message.

    Returns
    -------
    float

    Raises
    ------
    InvalidInputError
        If parts become too narrow without a bound.
    """
    edges = np.concatenate([[0.0], path.breaks, [1.0]])
    parts = []
    for left, right in pairwise(edges):
        if left <= high and low <= right:
            # A part that only touches another piece still needs the values on that side.
            slack = 1e-9 * (right - left)
            first = min(max(low, left), right - slack)
            parts.append((float(first), float(max(min(high, right), first + slack))))
    worst, least = 0.0, 2.0**-_HALVINGS
    while parts:
        first, last = parts.pop()
        found = bound(first, last)
        if np.isfinite(found):
            worst = max(worst, found)
            continue
        middle = 0.5 * (first + last)
        if last - first <= least * max(high - low, 1e-6):
            raise InvalidInputError("path", f"bounds no {what} at r = {middle:.6g}", "move the path or smooth it there")
        parts += [(first, middle), (middle, last)]
    return worst


def largest_cosine(low: float, high: float, negative: bool = False) -> float:
    """Return the maximum of the cosine, or of its negative, over angles [low, high]; rounding never lowers it."""
    shift = np.pi if negative else 0.0
    low, high = low + shift, high + shift
    slack = _ROUNDING * (1.0 + abs(low) + abs(high))
    if np.ceil((low - slack) / (2 * np.pi)) * 2 * np.pi <= high + slack:
        return 1.0
    return min(float(max(np.cos(low), np.cos(high))) + slack, 1.0)


def path_parameter(r: ArrayLike) -> FloatArray:
    """Return `r` as an array inside [0, 1]; more than rounding outside is an InvalidInputError."""
    try:
        values = np.asarray(r, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInputError("r", "is not made of numbers", "give path parameters in [0, 1]", r) from None
    if not ((values >= -_ROUNDING) & (values <= 1 + _ROUNDING)).all():
        raise InvalidInputError("r", "leaves [0, 1]", "stay inside the path's range", r)
    return np.clip(values, 0.0, 1.0)
