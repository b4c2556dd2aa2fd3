"""Hold the tool still and move the arm: all postures at one point.

Without joint limits this self-motion runs from a minimum to a maximum posture. In both the first two links are in line,
θ2 = 0: they belong to both elbows, and the arm may change its elbow there without a jump.
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
domain, r = sm.angle_domain(arm, path), 0.5

radii = arm.radii()
print(f"reach (9): {radii.outer:g}; nearest maximum reachable workspace (10): from {radii.nearest:.4f}")
print(f"the point is at {np.hypot(*path(r)):.4f}; self-motion curves there: {radii.self_motions(np.hypot(*path(r)))}")
for elbow in arm.branches:
    sweep = domain.sweep(r, elbow, count=5)
    print(f"{elbow} elbow: u from {sweep.u[0]:.4f} to {sweep.u[-1]:.4f}")
    for q in sweep.q:
        print("  joints", np.round(q, 4) + 0.0, " tool", np.round(arm.forward(q), 3))

problem = sm.Problem(arm, path)
with plot.figure(width=7, height=3, columns=2) as (canvas, (left, right)):
    plot.draw_extreme_postures(left, problem, r)
    plot.draw_sweep(right, problem, r, "positive")
    canvas.savefig(folder / "04_postures_at_a_point.png", dpi=200)
