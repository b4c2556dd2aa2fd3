"""Cost of the paper's 6R case when its moving base is chosen too, by optimizer and by the size of the box.

Every search judges a population of 60 for 1000 iterations on the case's clothoid, with its joint limits and no given
curve. Costs are the integral (1a) in true joints, over the seeds 1, 2, …; where the package ``cma`` is not installed,
its row is left out. Run as ``python benchmarks/moving_base.py``. With ``--quick`` two seeds get 100 iterations each,
which shows that the script works and says nothing of the optimizers.
"""

import argparse
import statistics
import time

import selfmotion as sm
from selfmotion.errors import MissingExtraError
from selfmotion.report import seed_6r

POPULATION, ITERATIONS, SEEDS = 60, 1000, 8
QUICK_ITERATIONS, QUICK_SEEDS = 100, 2


def differential_evolution(iterations, seed):
    """Return scipy's differential evolution."""
    return sm.DifferentialEvolution(POPULATION, iterations, seed=seed)


def pso(iterations, seed):
    """Return the PSO that converges."""
    return sm.PSO(POPULATION, iterations, seed=seed, variant="canonical")


def cma_es(iterations, seed):
    """Return CMA-ES."""
    return sm.CMAES(POPULATION, iterations, seed=seed)


SEARCHES = (
    ("differential evolution", differential_evolution, {}),
    ("canonical PSO", pso, {}),
    ("CMA-ES", cma_es, {}),
    ("differential evolution", differential_evolution, {"control_points": 6, "frequency": 2.0}),
    ("differential evolution", differential_evolution, {"control_points": 4, "frequency": 2.0}),
)
"""Optimizer, and what the planner's box is where it is not the default one."""


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description="Costs of the 6R case when its moving base is chosen too.")
    parser.add_argument("--quick", action="store_true", help="two seeds of 100 iterations")
    quick = parser.parse_args().quick
    iterations, seeds = (QUICK_ITERATIONS, QUICK_SEEDS) if quick else (ITERATIONS, SEEDS)
    problem = seed_6r.problem()
    print(f"population {POPULATION}, {iterations} iterations, {seeds} seeds")
    print(f"{'optimizer':24}  points  frequency  {'least':>7}  {'median':>7}  {'most':>7}  s per run")
    for label, optimizer, box in SEARCHES:
        began, costs = time.perf_counter(), []
        try:
            for seed in range(1, seeds + 1):
                planner = sm.MovingBase(optimizer(iterations, seed), **box)
                costs.append(sm.plan(problem, planner).cost)
        except MissingExtraError:
            continue
        each = (time.perf_counter() - began) / seeds
        print(
            f"{label:24}  {planner.control_points:6d}  {planner.frequency:9.1f}  {min(costs):7.3f}  "
            f"{statistics.median(costs):7.3f}  {max(costs):7.3f}  {each:9.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
