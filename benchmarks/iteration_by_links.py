"""Time of one Newton iteration of `refine` by the number of links: it should at most double when they do.

The seed's clothoid, scaled to the arm's reach, with the same number of coefficients for every arm. The number of inner
steps differs from search to search, so single rows do; the last line has the exponent p of time ~ nᵖ over all of them.
Run alone, on a quiet machine: ``python benchmarks/iteration_by_links.py``.
"""

import time

import numpy as np
import scipy.linalg  # noqa: F401 (its BLAS must be loaded to be limited)
from threadpoolctl import threadpool_limits

import selfmotion as sm
from selfmotion.refinement import Collocation, SplineSpace, minimise, random_starts

LINKS = (8, 15, 30, 60, 120)
SPANS = 48
SEARCHES = 3


def iteration_time(n):
    """Return the iterations of a few searches and the seconds that each took."""
    clothoid = sm.Clothoid(center=(110, 20), scale=25, coefficients=[0, -4, 0, 0.33], t_range=(-4.712, 0))
    problem = sm.Problem(sm.PlanarArm([180 / n] * n, [(-2.0, 2.0)] * n), clothoid)
    space = SplineSpace.with_spans(SPANS, np.empty(0))
    iterations, seconds = 0, 0.0
    for start, _ in zip(random_starts(problem, np.random.default_rng(1)), range(SEARCHES), strict=False):
        collocation = Collocation(
            problem.arm, problem.path, problem.objective, problem.weights, start.box, space, start.ends, 1.0
        )
        sampled = np.stack([np.interp(space.collocation, start.r, joint) for joint in start.q.T], axis=-1)
        began = time.perf_counter()
        iterations += minimise(collocation, space.interpolating(sampled)).iterations
        seconds += time.perf_counter() - began
    return iterations, seconds / iterations


def main():
    """Print the table."""
    print("links  iterations  ms per iteration")
    with threadpool_limits(1, "blas"):
        rows = [(n, *iteration_time(n)) for n in LINKS]
    for n, iterations, seconds in rows:
        print(f"{n:5d}  {iterations:10d}  {1e3 * seconds:16.2f}")
    exponent = np.polyfit(np.log(LINKS), np.log([seconds for _, _, seconds in rows]), 1)[0]
    print(f"time per iteration ~ links^{exponent:.2f}")


if __name__ == "__main__":
    main()
