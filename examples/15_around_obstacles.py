"""Keep clear of obstacles.

The seed's arm with links two wide, among three posts, one unit away from each of them. Nothing is sampled away: parts
of the self-motion are surely free, surely blocked or undecided, so the bound holds for every motion that keeps clear,
and the plan keeps clear between its samples too. With a fourth post on the path there is no motion, and it is said why.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None], thickness=2)
path = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
posts = [sm.CircleObstacle([28, -22], 4), sm.CircleObstacle([20, 30], 5), sm.CircleObstacle([40, 24], 4)]

free = sm.plan(sm.Problem(arm, path), sm.Global(gap=1e-3))
print(f"without obstacles {free.cost:.4f}, none below {free.lower_bound:.4f}")

problem = sm.Problem(arm, path, obstacles=posts, clearance=1.0)
plan = sm.plan(problem, sm.Global(gap=1e-3))
print(f"around them {plan.cost:.4f}, none below {plan.lower_bound:.4f}")
print(f"left of the clearance: {plan.verification.margins['clearance']:.1e}")
print("the first one,", sm.judge(problem, problem.grid, free(problem.grid)).failures[0])

wall = sm.CircleObstacle([62, 15], 5, name="wall")
try:
    sm.plan(sm.Problem(arm, path, obstacles=[*posts, wall]), sm.Global(gap=1e-3))
except sm.InfeasibleError as error:
    print(error)

with plot.figure(width=7, height=3.6, columns=2) as (canvas, panels):
    for axes, motion, title in zip(panels, (free, plan), ("as if there were none", "around obstacles"), strict=True):
        plot.draw_postures(axes, sm.Plan(problem, motion.motion, motion.planner, {}))  # either among the posts
        axes.set_title(title)
    canvas.savefig(folder / "15_around_obstacles.png", dpi=200)
