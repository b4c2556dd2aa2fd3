"""Random search: what every optimizer must beat."""

from __future__ import annotations

from selfmotion._types import FloatArray
from selfmotion.optimizers.base import EVALUATE, AskTell, State, uniform


class RandomSearch(AskTell):
    """Independent uniform samples of the box.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`.
    """

    kind = "random"
    steps = (
        "start: x uniform in the box",
        EVALUATE,
        "forget the values; x uniform in the box again",
    )

    def tell(self, state: State, values: FloatArray) -> None:
        """Forget the values and draw again."""
        state.x = uniform(state.rng, state.lower, state.upper, self.population)
