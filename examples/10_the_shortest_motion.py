"""Find the shortest motion, and prove it.

A sinusoid is the best of its family, and nothing says how far the family is from the best possible motion. The global
planner looks at all continuous motions at once, and says how much shorter than its own any of them can be.
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
problem = sm.Problem(arm, path, start=[0.3])

sinusoid = sm.plan(problem, sm.Sinusoid(offset=[0.3], amplitude=[0.4], optimizer=sm.PSO(bounds=(0, 15), seed=1)))
shortest = sm.plan(problem, sm.Global(gap=1e-4))
print(f"the best sinusoid costs {sinusoid.cost:.4f}, the shortest motion {shortest.cost:.4f}")
print(f"no motion costs less than {shortest.lower_bound:.4f}: gap {shortest.gap:.0e}")
for level in shortest.certificate.levels:
    print(f"{level.slices:3} slices, {level.cells:5} cells: none below {level.bound:.4f}, one at {level.cost:.4f}")
r = problem.grid
print("the sinusoid:", sm.distance_from_optimum(problem, r, sinusoid(r), shortest))

with plot.figure(width=7, height=3.4) as (canvas, (axes,)):
    plot.draw_optimum(axes, shortest, {"the best sinusoid": sinusoid})
    canvas.savefig(folder / "10_the_shortest_motion.png", dpi=200)
