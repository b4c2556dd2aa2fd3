"""Optimizers whose generations are compiled: candidates that move by arithmetic alone.

A swarm can be driven from Python, generation by generation, for any function; a function that is compiled itself runs
whole stretches of generations without the interpreter (:class:`RunsSwarms`). Both give the same bits.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol, runtime_checkable

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers.base import AskTell, Judged, Recorder, State, uniform

if TYPE_CHECKING:
    from selfmotion.optimizers._kernels import Flock

FLY, HUNT, DRAW = 0, 1, 2
"""The moves that :mod:`selfmotion.optimizers._kernels` knows: of particles, of wolves, and none at all."""
# A run is cut into so many stretches if its progress is watched, and into none of more evaluations in any case: only
# between them is Ctrl-C heard.
_STRETCHES = 20
_MOST_AT_ONCE = 20_000


@dataclass
class SwarmState(State):
    """What a swarm knows between generations.

    Attributes
    ----------
    v : array, shape (population, d)
        Velocities, for those that have them.
    remembered, remembered_values : array, shape (m, d) and (m,)
        Positions that steer the swarm, and their values.
    t : int
        Generations told.
    """

    v: FloatArray
    remembered: FloatArray
    remembered_values: FloatArray
    t: int = 0


@runtime_checkable
class RunsSwarms(Protocol):
    """A function that runs the generations of a swarm itself, by :mod:`selfmotion.optimizers._kernels`."""

    def run(self, swarm: Swarm, state: SwarmState, generations: int) -> Judged:
        """Run generations, changing `state`; return what was judged, shapes (generations, population, …)."""
        ...


class Swarm(AskTell):
    """An ask/tell optimizer with a compiled move.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`.

    Attributes
    ----------
    code : int
        How the swarm moves: `FLY`, `HUNT` or `DRAW`.
    draws_per_variable : int
        Random numbers that a generation takes per candidate and variable.
    """

    code: ClassVar[int]
    draws_per_variable: ClassVar[int]

    def constants(self) -> FloatArray:
        """Return the numbers that the move takes."""
        return np.empty(0)

    @abstractmethod
    def remembering(self) -> int:
        """Return how many positions the swarm remembers."""

    def start(self, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> SwarmState:
        """Return uniform positions at rest, with nothing remembered but where they are."""
        x = uniform(rng, lower, upper, self.population)
        m = self.remembering()
        known = np.resize(x, (m, len(lower)))
        return SwarmState(lower, upper, rng, x, np.zeros_like(x), known, np.full(m, np.inf))

    def flock(self, state: SwarmState) -> Flock:
        """Return the state as kernels see it, sharing its arrays."""
        from selfmotion.optimizers._kernels import Flock

        return Flock(
            self.code, self.constants(), state.lower, state.upper, state.x, state.v, state.remembered,
            state.remembered_values,
        )  # fmt: skip

    def draws(self, state: SwarmState, generations: int) -> FloatArray:
        """Return the random numbers of so many generations, one row each, uniform in [0, 1)."""
        return state.rng.random((generations, self.draws_per_variable * state.x.size))

    def tell(self, state: SwarmState, values: FloatArray) -> None:
        """Take the values of the population last asked for and move on, changing `state`."""
        from selfmotion.optimizers._kernels import tell

        tell(self.flock(state), np.asarray(values, dtype=float), self.draws(state, 1)[0], state.t)
        state.t += 1

    def _drive(self, evaluate: Recorder, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> None:
        if not isinstance(evaluate.function, RunsSwarms):
            super()._drive(evaluate, lower, upper, rng)
            return
        state = self.start(lower, upper, rng)
        stretch = -(-self.iterations // _STRETCHES) if evaluate.is_watched else self.iterations
        stretch = min(stretch, max(1, _MOST_AT_ONCE // self.population))
        for done in range(0, self.iterations, stretch):
            evaluate.book(evaluate.function.run(self, state, min(stretch, self.iterations - done)))
