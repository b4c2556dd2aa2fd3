"""Well-kept optimizers of others behind the same face: scipy's differential evolution and CMA-ES."""

from __future__ import annotations

import warnings

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import MissingExtraError
from selfmotion.optimizers.base import Optimizer, Recorder, uniform


class DifferentialEvolution(Optimizer):
    """``scipy.optimize.differential_evolution`` (Storn, Price 1997) with scipy's own settings, unpolished.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`; a population of at least 5.

    Notes
    -----
    Runs the whole budget: its convergence test is switched off.
    """

    kind = "differential_evolution"
    smallest_population = 5

    def _drive(self, evaluate: Recorder, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> None:
        first = uniform(rng, lower, upper, self.population)
        if self.iterations == 1:
            evaluate(first)
            return
        from scipy.optimize import differential_evolution

        differential_evolution(
            lambda columns: evaluate(columns.T),
            np.column_stack([lower, upper]),
            init=first,
            maxiter=self.iterations - 1,
            updating="deferred",
            vectorized=True,
            polish=False,
            tol=0.0,
            atol=-1.0,
            rng=rng,
        )


class CMAES(Optimizer):
    """CMA-ES (Hansen 2001) from the package ``cma``, extra ``cma``.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`~selfmotion.optimizers.base.Optimizer`; a population of at least 4.

    Notes
    -----
    Starts at the middle of the box with a step of 0.3 of its width. Stops early only when ``cma`` itself says so;
    the rest of the budget is then spent on restarts from uniform points, so that evaluations stay comparable.
    ``cma`` wants two variables: beside a single one it searches another that changes nothing.
    """

    kind = "cma"
    smallest_population = 4

    def _drive(self, evaluate: Recorder, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                import cma
        except ImportError:
            raise MissingExtraError(
                "planner.optimizer.kind", "needs the package cma", "pip install 'selfmotion[cma]'", "cma"
            ) from None
        width = upper - lower
        searched = max(2, len(lower))
        strategy, start = None, np.full(searched, 0.5)
        for _ in range(self.iterations):
            if strategy is None or strategy.stop():
                options = {
                    "bounds": [0.0, 1.0],
                    "popsize": self.population,
                    "seed": np.nan,  # it draws from randn below, never from numpy's global state
                    "randn": lambda *shape: rng.standard_normal(shape),
                    "verbose": -9,
                    "maxiter": np.inf,
                }
                strategy = cma.CMAEvolutionStrategy(start, 0.3, options)
                start = rng.random(searched)
            unit = np.asarray(strategy.ask())
            strategy.tell(unit, evaluate(lower + width * unit[:, : len(lower)]))
