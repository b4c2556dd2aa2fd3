"""Plan for an arm with seven joints.

A Panda draws an upright circle with its hand pointing down. Six joints would do for that; with seven there is a whole
curve of postures at every pose, on up to eight branches, and the angle u of the last joint says which. The global
planner looks at all of them, inside all joint limits.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.named_arm("panda")
t = np.linspace(0, 2 * np.pi, 101)
poses = np.zeros((101, 7))  # x, y, z [m] and the quaternion w, x, y, z
poses[:, 0], poses[:, 1], poses[:, 2] = 0.45, 0.2 * np.cos(t), 0.40 + 0.2 * np.sin(t)
poses[:, 4] = 1.0  # a half turn about x: the tool's z-axis points down
path = sm.PoseWaypoints(poses)

first, right = arm.solve(path(0.0), np.linspace(-np.pi, np.pi, 721)[:, None], "q4- q5in q2+")
inside = right & (arm.margins(first).min(axis=-1) >= 0)
print(f"on one branch {right.mean():.0%} of all u reach the first pose, {inside.mean():.0%} inside the joint limits")

plan = sm.plan(sm.Problem(arm, path, objective="l2"), sm.Global(gap=1e-2))
print(f"the joints travel {plan.cost:.4f} rad; no motion does with less than {plan.lower_bound:.4f}")
print(f"from pose to pose they travel {plan.l2_waypoints:.4f} rad, as others count it")
print(f"the nearest joint limit is {plan.verification.min_limit_margin:.3f} rad away")
used = {arm.branches[branch] for branch in arm.branch_of(plan(plan.problem.grid))}
print("branches used:", ", ".join(sorted(used)))

with plot.figure(width=7, height=3.4, columns=4, rows=2) as (canvas, panels):
    plot.draw_each_joint(panels[:7], plan)
    plot.draw_parameter(panels[7], plan)
    canvas.supxlabel("path parameter r", fontsize=8)
    canvas.savefig(folder / "11_seven_axis_arm.png", dpi=200)
