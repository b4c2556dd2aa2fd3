"""Random search: what every optimizer must beat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers.base import AskTell, uniform


@dataclass
class _State:
    lower: FloatArray
    upper: FloatArray
    rng: np.random.Generator


class RandomSearch(AskTell):
    """Independent uniform samples of the box.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`.
    """

    kind = "random"

    def start(self, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> _State:
        """Return the box and the generator."""
        return _State(lower, upper, rng)

    def ask(self, state: _State) -> FloatArray:
        """Return fresh uniform samples."""
        return uniform(state.rng, state.lower, state.upper, self.population)

    def tell(self, state: _State, values: FloatArray) -> None:
        """Forget the values."""
