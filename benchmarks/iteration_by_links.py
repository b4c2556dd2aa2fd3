"""Time of one Newton iteration of `refine` by the number of links: it should double when they do.

The seed's clothoid, scaled to the arm's reach, with the same number of coefficients for every arm. Each figure is the
median over the iterations of one search; the last column is the exponent p of time ~ nᵖ from one row to the next.
Run alone, on a quiet machine: ``python benchmarks/iteration_by_links.py``.
"""

import itertools
import statistics
import time

import numpy as np
import scipy.linalg  # noqa: F401 (its BLAS must be loaded to be limited)
from threadpoolctl import threadpool_limits

import selfmotion as sm
from selfmotion.refinement import Collocation, SplineSpace, newton
from selfmotion.refinement.starts import random_starts

LINKS = (8, 15, 30, 60, 120)
SPANS = 48


def iteration_times(n):
    """Return the seconds that each iteration of one search took."""
    clothoid = sm.Clothoid(center=(110, 20), scale=25, coefficients=[0, -4, 0, 0.33], t_range=(-4.712, 0))
    problem = sm.Problem(sm.PlanarArm([180 / n] * n, [(-2.0, 2.0)] * n), clothoid)
    start = next(random_starts(problem, np.random.default_rng(1)))
    space = SplineSpace.with_spans(SPANS, np.empty(0))
    collocation = Collocation(
        problem.arm, problem.path, problem.objective, problem.weights, start.box, space, start.ends, 1.0
    )
    sampled = np.stack([np.interp(space.collocation, start.r, joint) for joint in start.q.T], axis=-1)
    times = []
    iterate = newton._Iterate

    def timed(*args):
        times.append(time.perf_counter())
        return iterate(*args)

    newton._Iterate = timed
    try:
        newton.minimise(collocation, space.interpolating(sampled))
    finally:
        newton._Iterate = iterate
    return [after - before for before, after in itertools.pairwise(times)]


def main():
    """Print the table."""
    print("links  iterations  ms per iteration  exponent")
    before = None
    with threadpool_limits(1, "blas"):
        for n in LINKS:
            times = iteration_times(n)
            median = 1e3 * statistics.median(times)
            exponent = "" if before is None else f"{np.log(median / before[1]) / np.log(n / before[0]):8.2f}"
            print(f"{n:5d}  {len(times):10d}  {median:16.2f}  {exponent}")
            before = (n, median)


if __name__ == "__main__":
    main()
