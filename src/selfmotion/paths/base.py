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
    only piecewise smooth and :attr:`waypoints` where points were given.
    """

    kind: ClassVar[str]

    @abstractmethod
    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return the derivative of `order` 0, 1 or 2 at `r` of shape (k,), as shape (k, 2)."""

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
            If some r is outside [0, 1] or NaN, or the order is none of 0, 1, 2.
        """
        values = path_parameter(r)
        if order not in (0, 1, 2):
            raise InvalidInputError("order", "must be 0, 1 or 2", "higher derivatives are not offered", order)
        return self._evaluate(values.reshape(-1), order).reshape((*values.shape, 2))

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


def path_parameter(r: ArrayLike) -> FloatArray:
    """Return `r` as an array inside [0, 1]; more than rounding outside is an InvalidInputError."""
    try:
        values = np.asarray(r, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInputError("r", "is not made of numbers", "give path parameters in [0, 1]", r) from None
    if not ((values >= -_ROUNDING) & (values <= 1 + _ROUNDING)).all():
        raise InvalidInputError("r", "leaves [0, 1]", "stay inside the path's range", r)
    return np.clip(values, 0.0, 1.0)
