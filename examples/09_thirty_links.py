"""Plan an arm of thirty links.

The same clothoid as for six links, five times as large, as the arm is, and no joint but the first may bend by more than
one radian. The planner refines the whole arm as one. Four starts show whether they agree.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.PlanarArm([30] * 30, limits=[None] + [(-1, 1)] * 29)
clothoid = sm.Clothoid(center=[110, 20], scale=25, coefficients=[0, -4, 0, 0.33], t_range=[-4.712, 0])
problem = sm.Problem(arm, sm.Transformed(clothoid, scale=5))

plan = sm.plan(problem, sm.Refine(starts=4))
print(f"F = {plan.cost:.4f}, {plan.cost - arm.n:.4f} above its floor of one per joint")
print(f"plain joint travel {plan.l1_travel:.4f} rad, the busiest joint", end=" ")
print(f"{np.abs(np.diff(plan(problem.grid), axis=0)).sum(axis=0).max():.4f} rad")
print(f"tool within {plan.verification.max_tracking_error:.0e} of the path, in {plan.wall_time_s:.1f} s")
for optimum in plan.parameters["optima"]:
    print(f"{optimum['found']} of {plan.parameters['starts']} starts ended at F = {optimum['cost']:.4f}")

with plot.figure(width=7, height=3, columns=2) as (canvas, (left, right)):
    plot.draw_postures(left, plan)
    plot.draw_joints(right, plan)
    canvas.savefig(folder / "09_thirty_links.png", dpi=200)
