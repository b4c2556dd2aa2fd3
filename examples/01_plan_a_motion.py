"""Plan a motion of a 3R arm along a Bezier path.

The arm has three joints, the tool position takes two: one degree of freedom is left, the absolute direction u of the
last link. A sinusoid u(r) is laid through the angle domain and a particle swarm chooses its frequency.
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
print("u may start in", sm.angle_domain(arm, path)(0.0, "positive"))

planner = sm.Sinusoid(offset=[0.3], amplitude=[0.4], optimizer=sm.PSO(bounds=(0, 15), seed=1))
plan = sm.plan(sm.Problem(arm, path), planner)

print(f"joint travel F = {plan.cost:.6f} at f = {plan.parameters['f']:.4f}")
print("half-way: joints", np.round(plan(0.5), 4), "u", np.round(plan.u(0.5), 4))
print(f"tool within {plan.verification.max_tracking_error:.0e} of the path, between the samples too")

with plot.figure(width=7, height=3, columns=2) as (canvas, (left, right)):
    plot.draw_postures(left, plan)
    plot.draw_joints(right, plan)
    canvas.savefig(folder / "01_plan_a_motion.png", dpi=200)
