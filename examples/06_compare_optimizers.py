"""Compare optimizers fairly: the same problem, the same number of evaluations, several seeds.

One run decides nothing, since all of them draw random numbers. So each has five seeds here and is judged by its
median. `selfmotion reproduce` does the same with thirty, and with a copy of the problem whose variable is shifted.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.PlanarArm(links=[30, 30, 20], limits=[None, (0, np.pi), None])
path = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
problem = sm.Problem(arm, path, elbow="positive")
methods = {
    "GA": sm.GA(),
    "PSO seed": sm.PSO(variant="seed"),
    "PSO canonical": sm.PSO(variant="canonical"),
    "GWO": sm.GWO(),
    "random search": sm.RandomSearch(),
}

best = {}  # the least F so far, per method, seed and iteration
for name, optimizer in methods.items():
    planner = sm.Sinusoid(offset=[0.3], amplitude=[0.4], optimizer=optimizer)
    best[name] = np.array([planner.with_seed(seed).plan(problem).history[0].best for seed in range(1, 6)])
least = min(values.min() for values in best.values())

print(f"20 candidates, 100 iterations, 5 seeds; least F of all runs: {least:.9f}")
for name, values in best.items():
    excess = np.maximum(values[:, -1] - least, 1e-12)  # less is rounding
    print(f"{name:14} F − least F: median {np.median(excess):.0e}, worst {excess.max():.0e}")

with plot.figure(width=5, height=3.2) as (canvas, (axes,)):
    plot.draw_evolution(axes, best, optimum=least)
    axes.set_ylabel("median of best F − least F of all runs")
    axes.legend()
    canvas.savefig(folder / "06_compare_optimizers.png", dpi=200)
