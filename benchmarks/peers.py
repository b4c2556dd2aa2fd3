"""Optimizers of others on the seed's case, each with a numpy objective and with our kernel; what is missing is None."""

import warnings

import numpy as np
from measuring import version_of
from seed_case import BOUNDS, GENERATIONS, POPULATION, candidates, in_numpy, population_in_numpy

PACKAGES = {"pygmo": "pygmo", "scipy": "scipy", "cma": "cma", "pymoo": "pymoo"}
"""Packages that are compared, by how messages name them."""

OBJECTIVES = ("numpy", "our kernel")


def all_peers():
    """Return name to a function of a seed that returns the best f, or None where the package is missing."""
    kernel = candidates("integral")
    one = {"numpy": lambda f: in_numpy(f), "our kernel": lambda f: float(kernel(np.array([[f]]))[0])}
    many = {"numpy": population_in_numpy, "our kernel": lambda f: kernel(f[:, None])}
    found = {}
    for objective in OBJECTIVES:
        found[f"pygmo pso, {objective}"] = _or_missing("pygmo", _pygmo, "pso", one[objective], many[objective])
        found[f"pygmo pso_gen in batches, {objective}"] = _or_missing(
            "pygmo", _pygmo, "pso_gen", one[objective], many[objective]
        )
        found[f"pygmo gwo, {objective}"] = _or_missing("pygmo", _pygmo, "gwo", one[objective], many[objective])
        found[f"scipy differential_evolution, {objective}"] = _or_missing(
            "scipy", _differential_evolution, many[objective]
        )
        found[f"cma, {objective}"] = _or_missing("cma", _cma, many[objective])
        found[f"pymoo PSO, {objective}"] = _or_missing("pymoo", _pymoo, many[objective])
    return found


def _or_missing(package, make, *arguments):
    return None if version_of(package) is None else make(*arguments)


def _pygmo(kind, one, many):
    import pygmo

    class Problem:
        def fitness(self, x):
            return (one(x[0]),)

        def batch_fitness(self, x):
            return many(x)

        def get_bounds(self):
            return ([BOUNDS[0]], [BOUNDS[1]])

    def run(seed):
        method = getattr(pygmo, kind)(gen=GENERATIONS)
        if kind == "pso_gen":
            method.set_bfe(pygmo.bfe())
        algorithm = pygmo.algorithm(method)
        algorithm.set_seed(seed + 1)
        population = algorithm.evolve(pygmo.population(pygmo.problem(Problem()), POPULATION, seed=seed + 1))
        return float(population.champion_x[0])

    return run


def _differential_evolution(many):
    from scipy.optimize import differential_evolution

    def run(seed):
        rng = np.random.default_rng(seed)
        first = BOUNDS[0] + (BOUNDS[1] - BOUNDS[0]) * rng.random((POPULATION, 1))
        return float(
            differential_evolution(
                lambda x: many(np.ascontiguousarray(x[0])), [BOUNDS], init=first, maxiter=GENERATIONS - 1,
                updating="deferred", vectorized=True, polish=False, tol=0.0, atol=-1.0, rng=rng,
            ).x[0]
        )  # fmt: skip

    return run


def _cma(many):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import cma

    def run(seed):
        # The package wants two variables: the second one does nothing.
        options = {"popsize": POPULATION, "bounds": [0.0, 1.0], "seed": seed + 1, "verbose": -9, "maxiter": GENERATIONS}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            strategy = cma.CMAEvolutionStrategy([0.5, 0.5], 0.3, options)
            best, least = 0.0, np.inf
            for _ in range(GENERATIONS):
                if strategy.stop():
                    break
                unit = strategy.ask()
                f = BOUNDS[0] + (BOUNDS[1] - BOUNDS[0]) * np.array(unit)[:, 0]
                values = many(f)
                strategy.tell(unit, values)
                if values.min() < least:
                    best, least = float(f[np.argmin(values)]), values.min()
        return best

    return run


def _pymoo(many):
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    class Case(Problem):
        def __init__(self):
            super().__init__(n_var=1, n_obj=1, xl=np.array([BOUNDS[0]]), xu=np.array([BOUNDS[1]]))

        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = many(np.ascontiguousarray(x[:, 0]))[:, None]

    def run(seed):
        return float(minimize(Case(), PSO(pop_size=POPULATION), ("n_gen", GENERATIONS), seed=seed + 1).X[0])

    return run
