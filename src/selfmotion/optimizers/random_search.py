"""Random search: what every optimizer must beat."""

from __future__ import annotations

from selfmotion.optimizers.base import EVALUATE
from selfmotion.optimizers.swarm import DRAW, Swarm


class RandomSearch(Swarm):
    """Independent uniform samples of the box.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`.
    """

    kind = "random"
    code = DRAW
    draws_per_variable = 1
    steps = (
        "start: x uniform in the box",
        EVALUATE,
        "forget the values; x uniform in the box again",
    )

    def remembering(self) -> int:
        """Return how many positions are remembered: the best."""
        return 1
