"""Go from a drawing to what a controller executes.

Three drawings on three arms: a letter on one with three links, the outline of a bracket on the paper's six, a milled
pocket on a Panda. Each becomes a path, the path a plan, the plan a trajectory under joint limits, and that a
`JointTrajectory` of ROS 2 in a bag. What is checked and drawn below is read back from the bag: dots are a twentieth of
a second apart, and crowd where the tool is slow.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
drawings = Path(__file__).parent / "drawings"
letter = sm.read_svg(drawings / "letter.svg", arm_unit="mm", gaps="line")
bracket = sm.read_dxf(drawings / "bracket.dxf", arm_unit="mm", subpath=0)
pocket = sm.read_gcode(drawings / "pocket.nc", dimension=2)  # in metres, as arms in space are
elbow = [None, (0, np.pi), None]
down = [0, 1, 0, 0]  # a half turn about x: the tool's z-axis points down

# Where the drawing lies: scaled and moved in the plane, or put on a table in front of the arm.
three = sm.Problem(sm.PlanarArm([120, 120, 80], elbow), sm.Transformed(letter.path, translation=[130, -60]))
six = sm.Problem(sm.PlanarArm([30] * 6, elbow * 2), sm.Transformed(bracket.path, scale=0.5, translation=[70, -25]))
table = sm.Placed(pocket.path, {"translation": [0.42, -0.06, 0.3]})
panda = sm.Problem(sm.named_arm("panda"), sm.PosePath(table, orientation=down))
plans = {
    "the letter, three links": sm.plan(three, sm.Global(gap=1e-2)),
    "the bracket, six links": sm.plan(six, sm.Refine(starts=4, seed=0)),  # shortest near four random motions
    "the pocket, a Panda": sm.plan(panda, sm.Global(gap=1e-2)),
}

with plot.figure(width=9, height=6, columns=3, rows=2) as (canvas, axes):
    for (name, plan), above, below in zip(plans.items(), axes[:3], axes[3:], strict=True):
        arm, path = plan.problem.arm, plan.problem.path
        # A Panda's velocities are limited by its URDF; these two are ours.
        velocity = 2.0 if arm.dimension == 2 else None
        timed = sm.time_law(plan, max_acceleration=8.0, max_velocity=velocity, rate=200)
        with tempfile.TemporaryDirectory() as bags:
            sm.save_trajectory(timed, Path(bags) / "trajectory.mcap", "mcap")
            back = sm.load_trajectory(Path(bags) / "trajectory.mcap")
        tool = arm.forward(back.q)[:, : min(arm.dimension, 3)]
        drawn = path(np.linspace(0, 1, 2001))[:, : tool.shape[1]]
        off = np.linalg.norm(tool - path(timed.r)[:, : tool.shape[1]], axis=1).max()
        used = np.abs(back.dq).max(axis=0) / timed.limits.velocity, np.abs(back.ddq).max(axis=0) / 8.0
        print(
            f"{name}: joints {back.joint_names[0]} to {back.joint_names[-1]}, {len(back.t)} rows in {back.t[-1]:.2f} s"
        )
        print(f"  velocities up to {used[0].max():.0%} of their limits, accelerations up to {used[1].max():.0%}")
        print(f"  stands still at {len(timed.stops)} corners; tool within 1e-9 of the drawing: {off < 1e-9}")
        above.plot(drawn[:, 0], drawn[:, 1], linewidth=0.8, color="0.6")
        above.plot(tool[::10, 0], tool[::10, 1], "o", markersize=2.5)
        above.set_aspect("equal", adjustable="datalim")
        above.set_title(name)
        above.set_xlabel("x [mm]" if arm.dimension == 2 else "x [m]")
        above.set_ylabel("y [mm]" if arm.dimension == 2 else "y [m]")
        plot.draw_velocities(below, timed)
    canvas.savefig(folder / "14_drawing_to_controller.png", dpi=200)
