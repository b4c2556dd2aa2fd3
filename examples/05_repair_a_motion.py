"""Find where a sampled motion breaks, and repair it by self-motion.

The tool is on the path in every row of this motion, yet some postures have the other elbow: the arm jumps to them and
back. The repair keeps the rows that are good and moves the others along the self-motion to where they fit.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.PlanarArm([30, 30, 20])
path = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
problem = sm.Problem(arm, path)

r = np.linspace(0, 1, 81)
positive, negative = (arm.solve(path(r), np.full((81, 1), 0.3), elbow)[0] for elbow in arm.branches)
q = np.where(np.abs(r - 0.5)[:, None] < 0.06, negative, positive)
for fault in sm.connectivity(problem, r, q).breaks:
    print("broken at", fault)

mended = sm.repair(problem, r, q)
print(f"{mended.kept.sum()} of {len(r)} rows kept, {len(mended.r)} rows now")
print("connected?", sm.connectivity(problem, mended.r, mended.q).holds)
print(f"largest joint step {np.abs(np.diff(q, axis=0)).max():.3f} rad before, ", end="")
print(f"{np.abs(np.diff(mended.q, axis=0)).max():.3f} rad after")

with plot.figure(width=7, height=5.6, columns=2, rows=2) as (canvas, (before, angles, after, new_angles)):
    plot.draw_samples(before, problem, r, q, mended.breaks)
    plot.draw_sampled_joints(angles, problem, r, q, mended.breaks)
    plot.draw_samples(after, problem, mended.r, mended.q)
    plot.draw_sampled_joints(new_angles, problem, mended.r, mended.q)
    canvas.savefig(folder / "05_repair_a_motion.png", dpi=200)
