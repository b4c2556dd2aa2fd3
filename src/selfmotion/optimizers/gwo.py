"""Grey wolf optimizer (Mirjalili, Mirjalili, Lewis 2014), in the form of the authors' own listing."""

from __future__ import annotations

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers.base import EVALUATE
from selfmotion.optimizers.swarm import HUNT, Swarm


class GWO(Swarm):
    """Grey wolves, equations (24)–(26) with the paper's misprints mended.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`.

    Notes
    -----
    ``a = 2 − 2t/T``; per leader and dimension ``A = 2a r1 − a``, ``C = 2 r2``, ``D = |C X_leader − X|``,
    ``X_k = X_leader − A D``; the new X is the mean of the three. Leaders persist, and an old α is not demoted to β.
    GWO is not shift-invariant: C stretches the leaders away from zero, so it does better when the optimum
    lies near the origin. Show it a shifted copy of a problem before drawing conclusions.
    """

    kind = "gwo"
    code = HUNT
    draws_per_variable = 6
    steps = (
        "start: X uniform in the box, no leaders, t = 0",
        EVALUATE,
        "wolf by wolf: X better than α, or else than β,\nor else than δ, takes its place",
        "a = 2 − 2t/T; t ← t + 1",
        "per leader k: A = 2a r1 − a, C = 2 r2,\nD = |C X_leader − X|, X_k = X_leader − A D",
        "X ← mean of X_1, X_2, X_3, clipped to the box",
    )

    def remembering(self) -> int:
        """Return how many positions the pack remembers: α, β, δ."""
        return 3

    def constants(self) -> FloatArray:
        """Return T."""
        return np.array([float(self.iterations)])
