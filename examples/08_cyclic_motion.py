"""Come back to the posture that a lap began with.

The tool goes round a circle and is back where it was, but the joints need not be: the cheapest motion from a given
posture ends in another one, and the next lap would not be the same. With `cyclic` the joint motion closes too.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.PlanarArm(links=[1, 1, 1, 1], limits=[None] + [(-2.8, 2.8)] * 3)
circle = sm.Circle(center=[2, 0.5], radius=0.8)

problems = {
    "open": sm.Problem(arm, circle, start=[-1, 1]),
    "closed": sm.Problem(arm, circle, start=[-1, 1], cyclic="exact"),
    "closed, any start": sm.Problem(arm, circle, cyclic="exact"),
}
plans = {name: sm.plan(problem, sm.Refine()) for name, problem in problems.items()}
for name, plan in plans.items():
    gap = np.abs(plan(1.0) - plan(0.0)).max()
    print(f"{name:17}  F = {plan.cost:.4f}, the joints end within {gap:.4f} rad of where they began")

with plot.figure(width=7.4, height=5, columns=3, rows=2) as (canvas, panels):
    for (name, plan), above, below in zip(plans.items(), panels[:3], panels[3:], strict=True):
        plot.draw_postures(above, plan)
        above.set(title=f"{name}: F = {plan.cost:.2f}", xlim=(-0.4, 3.4), ylim=(-2, 2), yticks=range(-2, 3))
        plot.draw_joints(below, plan)
        below.set_ylim(-3, 3)
        below.get_legend().remove()
        below.label_outer()
    canvas.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=4, handlelength=3)
    canvas.savefig(folder / "08_cyclic_motion.png", dpi=200)
