"""Grey wolf optimizer (Mirjalili, Mirjalili, Lewis 2014), in the form of the authors' own listing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers.base import EVALUATE, AskTell, State, uniform


@dataclass
class _State(State):
    leaders: FloatArray  # α, β, δ, shape (3, d)
    leader_values: FloatArray
    t: int = 0


class GWO(AskTell):
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
    steps = (
        "start: X uniform in the box, no leaders, t = 0",
        "clip X to the box",
        EVALUATE,
        "wolf by wolf: X better than α, or else than β,\nor else than δ, takes its place",
        "a = 2 − 2t/T; t ← t + 1",
        "per leader k: A = 2a r1 − a, C = 2 r2,\nD = |C X_leader − X|, X_k = X_leader − A D",
        "X ← mean of X_1, X_2, X_3",
    )

    def start(self, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> _State:
        """Return a uniform pack without leaders."""
        x = uniform(rng, lower, upper, self.population)
        return _State(lower, upper, rng, x, np.zeros((3, len(lower))), np.full(3, np.inf))

    def ask(self, state: _State) -> FloatArray:
        """Return the pack, clipped to the box."""
        state.x = np.clip(state.x, state.lower, state.upper)
        return state.x

    def tell(self, state: _State, values: FloatArray) -> None:
        """Update the leaders wolf by wolf, then move the pack."""
        leaders, best = state.leaders, state.leader_values
        for x, value in zip(state.x, values, strict=True):
            if value < best[0]:
                leaders[0], best[0] = x, value
            elif best[0] < value < best[1]:
                leaders[1], best[1] = x, value
            elif best[1] < value < best[2]:
                leaders[2], best[2] = x, value
        a = 2.0 - 2.0 * state.t / self.iterations
        state.t += 1
        r1, r2 = state.rng.random((2, 3, *state.x.shape))
        big_a, big_c = 2.0 * a * r1 - a, 2.0 * r2
        lead = leaders[:, None, :]
        distance = np.abs(big_c * lead - state.x)
        state.x = (lead - big_a * distance).mean(axis=0)
