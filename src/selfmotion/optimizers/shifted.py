"""The same search with its variables moved by a constant: does an optimizer care where the origin lies?"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np

from selfmotion._checks import number
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.optimizers.base import BatchFunction, Judged, Optimizer, Recorder

DEFAULT_SHIFT = 7.5
"""The middle of the default box, which puts the origin there."""


@runtime_checkable
class Shiftable(Protocol):
    """A function that can move its own variables, and stays compiled."""

    def shifted(self, shift: float) -> BatchFunction:
        """Return the function of y that has at y the value of this one at y + shift."""
        ...


class Shifted(Optimizer):
    """Another optimizer on a shifted copy: it searches ``y = x − shift`` in the box moved likewise.

    Parameters
    ----------
    optimizer : Optimizer
        Searches y, with its own population, iterations, bounds on x, and seed.
    shift : float
        What is subtracted from every variable.

    Raises
    ------
    InvalidInputError
        If `optimizer` is none, or `shift` is not finite.

    Notes
    -----
    Everything outside sees x. To an optimizer that does not care where the origin lies, such as PSO, the copy is the
    same problem, and with the same seed it does the same up to rounding; GWO does not.
    """

    kind = "shifted"

    def __init__(self, optimizer: Optimizer, shift: float = DEFAULT_SHIFT) -> None:
        if not isinstance(optimizer, Optimizer):
            raise InvalidInputError("optimizer", "is not an optimizer", "give one, such as GWO(…)", optimizer)
        super().__init__(optimizer.population, optimizer.iterations, optimizer.bounds, optimizer.seed)
        self.optimizer = optimizer
        self.shift = number("shift", shift)

    def settings(self) -> dict[str, Any]:
        """Return what a reader must know to repeat the run."""
        inner = self.optimizer.with_bounds(self.bounds).with_seed(self.seed)
        return {"shift": self.shift, "optimizer": {"kind": inner.kind, **inner.settings()}}

    def _drive(self, evaluate: Recorder, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> None:
        moved = _Moved(evaluate, self.shift, lower, upper)
        self.optimizer._drive(moved, lower - self.shift, upper - self.shift, rng)


class _Moved(Recorder):
    """The objective as the inner optimizer sees it; the books are the outer one's, in x."""

    def __init__(self, outer: Recorder, shift: float, lower: FloatArray, upper: FloatArray) -> None:
        function = outer.function
        super().__init__(function.shifted(shift) if isinstance(function, Shiftable) else self._at, 0)
        self.is_watched = outer.is_watched
        self._outer, self._shift, self._lower, self._upper = outer, shift, lower, upper

    def _back(self, y: FloatArray) -> FloatArray:
        """Return x, inside the box in spite of rounding."""
        return np.asarray(np.clip(y + self._shift, self._lower, self._upper))

    def _at(self, y: FloatArray) -> FloatArray:
        return self._outer.function(self._back(y))

    def book(self, judged: Judged) -> None:
        """Take down generations that were judged, with the candidates moved back."""
        self._outer.book(judged._replace(population=self._back(judged.population)))
