"""Plan for a six-axis arm on a rail.

A KUKA KR 6 welds a straight seam of 2 m, longer than it reaches, its torch keeping its orientation. Where the base is
on its rail is the one redundant degree. How much a metre of rail is worth in radians is for the process to say: that is
the weight of joint 1.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
torch = {"translation": [0.0, 0.0, 0.25]}
arm = sm.named_arm("kr6r900", tool=torch, rail={"axis": [0, 1, 0], "limits": [-1.2, 1.2]})
seam = sm.PosePath(sm.Line([0.6, -1.0, 0.3], [0.6, 1.0, 0.3]), [0.0, 0.980067, 0.0, 0.198669])

for worth in (0.1, 0.5, 2.0):  # rad/m
    problem = sm.Problem(arm, seam, objective="l2", weights=[worth, 1, 1, 1, 1, 1, 1])
    plan = sm.plan(problem, sm.Global(gap=1e-3))
    way = np.abs(np.diff(plan(problem.grid)[:, 0])).sum()
    print(f"{worth} rad/m: the rail goes {way:.3f} m; cost {plan.cost:.4f}, none below {plan.lower_bound:.4f}")

short = sm.named_arm("kr6r900", tool=torch, rail={"axis": [0, 1, 0], "limits": [-0.2, 1.2]})
try:
    sm.plan(sm.Problem(short, seam, objective="l2"), sm.Global(gap=1e-3))
except sm.InfeasibleError as error:
    print(error)

with plot.figure(width=7, height=3.4, columns=4, rows=2) as (canvas, panels):
    plot.draw_each_joint(panels[:7], plan)
    plot.draw_parameter(panels[7], plan)
    canvas.supxlabel("path parameter r", fontsize=8)
    canvas.savefig(folder / "13_six_axes_on_a_rail.png", dpi=200)
