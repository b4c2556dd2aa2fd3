"""The two cases of a Franka Panda that planners are compared on: cost, bound and time against the gap asked for."""

import time

import numpy as np

import selfmotion as sm
from selfmotion.arms.catalogue import named_arm

GAPS = (1.0, 1e-2, 1e-3, 1e-4)


def circle():
    """Return 101 poses on a circle, the tool straight down."""
    t = np.linspace(0, 2 * np.pi, 101)
    position = np.column_stack([np.full(101, 0.45), 0.2 * np.cos(t), 0.4 + 0.2 * np.sin(t)])
    return sm.PoseWaypoints(np.column_stack([position, np.tile([0.0, 1.0, 0.0, 0.0], (101, 1))]))


def line():
    """Return 200 poses on a line, the tool's frame that of the base."""
    x = np.linspace(0.45, -0.45, 200)
    position = np.column_stack([x, np.full(200, 0.5422), np.full(200, 0.7885)])
    return sm.PoseWaypoints(np.column_stack([position, np.tile([1.0, 0.0, 0.0, 0.0], (200, 1))]))


def main():
    """Print a table."""
    arm = named_arm("panda")
    sm.Global(gap=1.0).plan(sm.Problem(arm, circle(), objective="l2", samples=200))  # compiles, or loads
    print("| case | objective | gap asked for | seconds | cost | bound | gap | L2 over the poses |")
    print("|---|---|---|---|---|---|---|---|")
    for name, path in (("circle", circle()), ("line", line())):
        for objective in ("l2", "joint_travel", "l1"):
            for gap in GAPS if objective == "l2" else GAPS[1:3]:
                problem = sm.Problem(arm, path, objective=objective, samples=200)
                began = time.perf_counter()
                plan = sm.Global(gap=gap).plan(problem)
                seconds = time.perf_counter() - began
                steps = np.linalg.norm(np.diff(plan(path.waypoints), axis=0), axis=1).sum()
                print(
                    f"| {name} | {objective} | {gap:g} | {seconds:.2f} | {plan.cost:.5f} | {plan.lower_bound:.5f} "
                    f"| {plan.gap:.1e} | {steps:.4f} |"
                )


if __name__ == "__main__":
    main()
