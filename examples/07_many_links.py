"""Plan an arm of six links in three ways, each with more freedom than the one before.

First the paper's way: the arm is two modules of three links, the end of the first follows a given curve, and only two
frequencies are searched. Then that curve, the moving base, is chosen as well. Last the whole arm is one, and its joint
motion is refined. The page on many links explains them.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.PlanarArm([30] * 6, limits=[None, (0, np.pi), None, None, (0, np.pi), None])
path = sm.Clothoid(center=[110, 20], scale=25, coefficients=[0, -4, 0, 0.33], t_range=[-4.712, 0])
problem = sm.Problem(arm, path)

base = sm.Bezier([[80, 30], [70, 30], [70, 10], [80, -21]])
swarm = sm.PSO(bounds=(0, 15), seed=1)
planners = {
    "given moving base": sm.Modules([base], offset=[0.35, 0], amplitude=[0.4, 0.4], optimizer=swarm),
    "chosen moving base": sm.MovingBase(sm.DifferentialEvolution(population=40, iterations=400, seed=1)),
    "the whole arm": sm.Refine(),
}

plans = {}
for name, planner in planners.items():
    plans[name] = plan = sm.plan(problem, planner)
    print(f"{name:18}  F = {plan.cost:7.4f}, plain joint travel {plan.l1_travel:7.4f} rad")
absolute = sum(module["cost"]["absolute"] for module in plans["given moving base"].parameters["modules"])
print(f"The first with its fourth joint counted as an absolute angle, as in the paper: F = {absolute:.4f}")

with plot.figure(width=7.4, height=4.8, columns=3, rows=2) as (canvas, panels):
    for (name, plan), above, below in zip(plans.items(), panels[:3], panels[3:], strict=True):
        plot.draw_postures(above, plan)
        above.set(title=f"{name}: F = {plan.cost:.2f}", xlim=(-15, 165), ylim=(-65, 65))
        plot.draw_joints(below, plan)
        below.set_ylim(-3.5, 3.5)
        below.get_legend().remove()
        below.label_outer()
    canvas.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=6, handlelength=3)
    canvas.savefig(folder / "07_many_links.png", dpi=200)
