"""What every task-space path is: a curve x(r), r ∈ [0, 1], with derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.quadrature import integrate

_ROUNDING = 1e-12


class Path(ABC):
    """A plane curve x(r) over r ∈ [0, 1].

    A subclass sets ``kind`` and implements :meth:`_evaluate`; it overrides :attr:`breaks` where the curve is
    only piecewise smooth, :attr:`waypoints` where points were given, and :meth:`_fastest` to take part in proofs.
    """

    kind: ClassVar[str]

    @abstractmethod
    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return the derivative of `order` 0, 1 or 2 at `r` of shape (k,), as shape (k, 2)."""

    def _fastest(self, low: float, high: float) -> float:
        """Return a bound on ``|x'(r)|`` over [low, high], right but for rounding."""
        raise InvalidInputError(
            "path", f"is a {type(self).__name__}, which bounds its speed nowhere", "implement its method _fastest"
        )

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
            0 for the position, 1 and 2 for the derivatives with respect to r.

        Returns
        -------
        array, shape (..., 2)
            In the unit of length of the path.

        Raises
        ------
        InvalidInputError
            If some r is outside [0, 1] or NaN, the order is none of 0, 1, 2, or the curve has no finite value there.
        """
        values = path_parameter(r)
        if order not in (0, 1, 2):
            raise InvalidInputError("order", "must be 0, 1 or 2", "higher derivatives are not offered", order)
        flat = values.reshape(-1)
        found = self._evaluate(flat, order)
        if not np.isfinite(found).all():
            # Unsaid, NaN would pass for a point that nothing reaches: a proof that there is no motion.
            first = flat[~np.isfinite(found).all(axis=-1)][0]
            name = ("point", "first derivative", "second derivative")[order]
            raise InvalidInputError("path", f"has no finite {name} at r = {first:.6g}", "mend the curve there")
        return found.reshape((*values.shape, 2))

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

        Raises
        ------
        InvalidInputError
            If the part is not one of [0, 1], or the path knows no bound.
        """
        ends = path_parameter([low, high])
        if ends[0] > ends[1]:
            raise InvalidInputError("low", "is beyond high", "give the lower end first", (low, high))
        return self._fastest(float(ends[0]), float(ends[1])) * (1.0 + _ROUNDING)

    def grid(self, parts: int) -> FloatArray:
        """Return a uniform grid of [0, 1] with `parts` parts and every break of the path in it, ascending."""
        return np.unique(np.concatenate([np.linspace(0.0, 1.0, parts + 1), self.breaks]))

    @cached_property
    def length(self) -> float:
        """Arc length ∫|x'(r)| dr, to about ten digits."""
        return integrate(lambda r: np.hypot(*self._evaluate(r, 1).T), self.grid(16), tolerance=1e-12).value

    @cached_property
    def extent(self) -> float:
        """Largest coordinate extent of the curve, the yardstick for tolerances."""
        points = self._evaluate(self.grid(64), 0)
        return float(np.ptp(points, axis=0).max())

    @property
    def is_closed(self) -> bool:
        """Whether the last point is the first one, to 1e-9 of :attr:`extent`."""
        first, last = self._evaluate(np.array([0.0, 1.0]), 0)
        return bool(np.hypot(*(last - first)) <= 1e-9 * self.extent)


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
