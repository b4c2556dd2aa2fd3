"""Particle swarm optimization (Kennedy, Eberhart 1995), undamped as in the seed, or as Clerc and Kennedy (2002)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from selfmotion._checks import choice
from selfmotion._types import Box, FloatArray
from selfmotion.optimizers.base import DEFAULT_BOUNDS, EVALUATE
from selfmotion.optimizers.swarm import FLY, Swarm

# (χ, ω, φ1, φ2) of (23). The seed's φ = 3 has no real χ: it runs undamped.
_VARIANTS = {
    "seed": (1.0, 1.0, 1.5, 1.5),
    "canonical": (0.7298437881283576, 1.0, 2.05, 2.05),
}


class PSO(Swarm):
    """Particle swarm, equation (23): ``v ← χ(ωv + φ1 β1 (p − x) + φ2 β2 (g − x))``, ``x ← x + v``.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`.
    variant : {"seed", "canonical"}
        ``seed`` has χ = ω = 1 and φ1 = φ2 = 1.5 as the paper states: the plain, undamped update. ``canonical`` is Clerc
        and Kennedy's φ1 = φ2 = 2.05 with ``χ = 2/|2 − φ − √(φ² − 4φ)| = 0.7298``.
    walls : {"absorb", "clip"}
        A particle that leaves the box is put on its wall; ``absorb`` also stops its velocity across the wall, ``clip``
        keeps it. For the undamped variant this decides the outcome, so it is part of every result.

    Raises
    ------
    InvalidInputError
        If a number is out of its range, or a name is none of these.

    Notes
    -----
    β1, β2 are uniform on [0, 1], fresh for each particle and dimension. Positions start uniform in the box,
    velocities at zero; the best positions p, g are updated after each generation.
    """

    kind = "pso"
    code = FLY
    draws_per_variable = 2
    steps = (
        "start: x uniform in the box, v = 0",
        EVALUATE,
        "p ← x where F(x) < F(p); g ← the best p",
        "draw β1, β2 for every particle and variable;\nv ← χ(ωv + φ1 β1 (p − x) + φ2 β2 (g − x))",
        "x ← x + v; what leaves the box is put on its wall",
        "walls absorb: v ← 0 across the wall; clip: v stays",
    )

    def __init__(
        self,
        population: int = 20,
        iterations: int = 100,
        bounds: Box = DEFAULT_BOUNDS,
        seed: int = 0,
        variant: Literal["seed", "canonical"] = "canonical",
        walls: Literal["absorb", "clip"] = "absorb",
    ) -> None:
        super().__init__(population, iterations, bounds, seed)
        self.variant = choice("variant", variant, _VARIANTS)
        self.walls = choice("walls", walls, ("absorb", "clip"))

    def settings(self) -> dict[str, Any]:
        """Return what a reader must know to repeat the run."""
        return {**super().settings(), "variant": self.variant, "walls": self.walls}

    def remembering(self) -> int:
        """Return how many positions the swarm remembers: each particle its best."""
        return self.population

    def constants(self) -> FloatArray:
        """Return χ, ω, φ1, φ2, and whether walls absorb."""
        return np.array([*_VARIANTS[self.variant], self.walls == "absorb"], dtype=float)
