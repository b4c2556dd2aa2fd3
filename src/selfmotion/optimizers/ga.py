"""The continuous genetic algorithm of Haupt & Haupt, Practical Genetic Algorithms (2004)."""

from __future__ import annotations

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers.base import EVALUATE, AskTell, State

SELECTION_RATE = 0.5
MUTATION_RATE = 0.1


class GA(AskTell):
    """Real-coded genetic algorithm with the seed's selection rate 0.5 and mutation rate 0.1.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`; a population of at least 4.

    Notes
    -----
    Each generation is sorted and its better half kept. Parents are drawn from it by rank-weighted roulette,
    ``P_k ∝ K + 1 − k``. Each pair has two children: at one crossover variable they are the blends
    ``x_ma − β(x_ma − x_pa)`` and ``x_pa + β(x_ma − x_pa)``, and the variables to the right of it are exchanged. Then
    ``⌈(population − 1)·d·0.1⌉`` entries, none of them in the best row, are redrawn uniformly.
    """

    kind = "ga"
    smallest_population = 4
    steps = (
        "start: x uniform in the box",
        EVALUATE,
        f"sort x by F; keep the first K = {SELECTION_RATE:g} · population rows",
        "draw pairs ma, pa of these rows, P_k ∝ K + 1 − k",
        "two children of each pair: at one variable\nx_ma − β(x_ma − x_pa) and x_pa + β(x_ma − x_pa),\n"
        "the variables to its right exchanged",
        "the children replace the other rows",
        f"mutate: redraw ⌈(population − 1) · d · {MUTATION_RATE:g}⌉ entries\nuniformly, none in the best row",
    )

    def tell(self, state: State, values: FloatArray) -> None:
        """Select, mate, mutate."""
        rng, (rows, dimension) = state.rng, state.x.shape
        x = state.x[np.argsort(values, kind="stable")]
        kept = int(SELECTION_RATE * rows)
        rank_weights = np.arange(kept, 0, -1) / (kept * (kept + 1) / 2)
        pairs = int(np.ceil((rows - kept) / 2))
        ma, pa = x[rng.choice(kept, size=(2, pairs), p=rank_weights)]
        cross = rng.integers(dimension, size=pairs)
        beta = rng.random(pairs)
        right = np.arange(dimension) > cross[:, None]
        first, second = np.where(right, pa, ma), np.where(right, ma, pa)
        at = (np.arange(pairs), cross)
        step = beta * (ma[at] - pa[at])
        first[at], second[at] = ma[at] - step, pa[at] + step
        x[kept:] = np.stack([first, second], axis=1).reshape(-1, dimension)[: rows - kept]
        mutations = int(np.ceil((rows - 1) * dimension * MUTATION_RATE))
        row, column = rng.integers(1, rows, size=mutations), rng.integers(dimension, size=mutations)
        x[row, column] = state.lower[column] + (state.upper - state.lower)[column] * rng.random(mutations)
        state.x = x
