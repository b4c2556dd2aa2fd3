"""Descartes, from the Tesseract packages, on the seed's 3R case: tool directions sampled, a ladder over what IK finds.

The arm's tool may turn freely about the plane's normal; Descartes samples that turn, asks the arm's numerical inverse
kinematics for one posture per direction, and takes the way through the rungs with the least sum of squared joint steps.
The solver always starts from zero joint values, where a 3R arm is straight and singular: counted so, it misses a fifth
of the poses within reach at 6 degrees. The model therefore counts joint 2 from the middle of its range [0, pi], where
it misses none; all that is printed counts it as the seed does. The planner's own settings for threads are not bound to
Python, so it runs on one.
"""

import importlib.metadata
import json
import math
import statistics
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import tesseract_robotics
from tesseract_robotics import tesseract_command_language as language
from tesseract_robotics import tesseract_common as common
from tesseract_robotics import tesseract_motion_planners_descartes as planners
from tesseract_robotics.tesseract_environment import Environment
from tesseract_robotics.tesseract_kinematics import KinGroupIKInput
from tesseract_robotics.tesseract_motion_planners import PlannerRequest

LINKS = np.array([30.0, 30.0, 20.0]) / 100.0
CONTROL = np.array([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]) / 100.0
"""Units of 1/100, so that the arm's links are in metres."""

MIDDLE = np.array([0.0, np.pi / 2.0, 0.0])
"""The seed's joint values where the model's are zero."""

PLACES = 200
DIRECTIONS = (60, 240, 960)
ROUNDS = 3
TOLERANCE = 1e-3
BEST = 4.6502
"""Least joint travel with a free start, elbow positive."""

SOLVER = "KDLInvKinChainLMA"
TASK = "DescartesMotionPlannerTask"
PROFILE = "free turn"

URDF = f"""<robot name="arm">
  <link name="base"/><link name="first"/><link name="second"/><link name="third"/><link name="tool0"/>
  <joint name="joint1" type="revolute">
    <parent link="base"/><child link="first"/><axis xyz="0 0 1"/>
    <limit lower="{-2 * np.pi}" upper="{2 * np.pi}" effort="1" velocity="1"/>
  </joint>
  <joint name="joint2" type="revolute">
    <parent link="first"/><child link="second"/><axis xyz="0 0 1"/>
    <origin xyz="{LINKS[0]} 0 0" rpy="0 0 {MIDDLE[1]}"/>
    <limit lower="{-np.pi / 2}" upper="{np.pi / 2}" effort="1" velocity="1"/>
  </joint>
  <joint name="joint3" type="revolute">
    <parent link="second"/><child link="third"/><axis xyz="0 0 1"/><origin xyz="{LINKS[1]} 0 0"/>
    <limit lower="{-2 * np.pi}" upper="{2 * np.pi}" effort="1" velocity="1"/>
  </joint>
  <joint name="flange" type="fixed">
    <parent link="third"/><child link="tool0"/><origin xyz="{LINKS[2]} 0 0"/>
  </joint>
</robot>"""

SRDF = """<robot name="arm" version="1.0.0">
  <group name="arm"><chain base_link="base" tip_link="tool0"/></group>
  <kinematics_plugin_config filename="{plugins}"/>
</robot>"""


def path():
    """Return the tool's places, one a row."""
    r = np.linspace(0.0, 1.0, PLACES)[:, None]
    degree = len(CONTROL) - 1
    return sum(math.comb(degree, i) * r**i * (1.0 - r) ** (degree - i) * p for i, p in enumerate(CONTROL))


def pose(place, direction=0.0):
    """Return the tool's pose at a place of the plane."""
    c, s = np.cos(direction), np.sin(direction)
    return common.Isometry3d(
        np.array([[c, -s, 0.0, place[0]], [s, c, 0.0, place[1]], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    )


def plugins():
    """Return the configuration of the inverse kinematics, with the library that the package ships."""
    package = Path(tesseract_robotics.__file__).parent
    shipped = sorted(package.parent.glob("tesseract_robotics*.libs/*tesseract_kinematics_kdl_factories*"))
    shipped += sorted(package.rglob("*tesseract_kinematics_kdl_factories*"))
    library = shipped[0] if shipped else Path("tesseract_kinematics_kdl_factories")
    plugin = {"class": SOLVER + "Factory", "config": {"base_link": "base", "tip_link": "tool0"}}
    return {
        "kinematic_plugins": {
            "search_paths": [str(library.parent)],
            "search_libraries": [library.name],
            "inv_kin_plugins": {"arm": {"default": SOLVER, "plugins": {SOLVER: plugin}}},
        }
    }


def environment():
    """Return the arm alone in its world."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "plugins.yaml")
        file.write_text(json.dumps(plugins()))
        world = Environment()
        if not world.init(URDF, SRDF.format(plugins=file.as_uri()), common.GeneralResourceLocator()):
            raise RuntimeError("the environment was refused")
    return world


def program():
    """Return the instructions: one Cartesian waypoint a place."""
    arm = common.ManipulatorInfo()
    arm.manipulator, arm.manipulator_ik_solver = "arm", SOLVER
    arm.working_frame, arm.tcp_frame = "base", "tool0"
    whole = language.CompositeInstruction(PROFILE)
    whole.setManipulatorInfo(arm)
    for place in path():
        waypoint = language.CartesianWaypointPoly_wrap_CartesianWaypoint(language.CartesianWaypoint(pose(place)))
        move = language.MoveInstruction(waypoint, language.MoveInstructionType_LINEAR, PROFILE)
        whole.appendMoveInstruction(language.MoveInstructionPoly_wrap_MoveInstruction(move))
    return whole


def profiles(directions):
    """Return the planner's settings: the turn about z sampled, pi not once more as -pi, no collisions."""
    step = 2.0 * np.pi / directions
    settings = planners.DescartesDefaultPlanProfileD()
    settings.target_pose_fixed = False
    settings.target_pose_sample_axis = np.array([0.0, 0.0, 1.0])
    settings.target_pose_sample_min, settings.target_pose_sample_max = -np.pi, np.pi - step
    settings.target_pose_sample_resolution = step
    settings.enable_collision = settings.enable_edge_collision = False
    settings.allow_collision = True
    found = language.ProfileDictionary()
    found.addProfile(TASK, PROFILE, planners.cast_DescartesPlanProfileD(settings))
    return found


def solve(request):
    """Return the planner's answer and the seconds it took."""
    planner = planners.DescartesMotionPlannerD(TASK)
    began = time.perf_counter()
    response = planner.solve(request)
    return response, time.perf_counter() - began


def postures(response):
    """Return the joint values of an answer, one row a waypoint, as the seed counts them."""
    results = response.results
    instructions = results.getInstructions()
    rows = []
    for i in range(len(instructions)):
        # Each step is held by a name: what a wrapper points to dies with the one that it came from.
        instruction = instructions[i]
        move = language.InstructionPoly_as_MoveInstructionPoly(instruction)
        waypoint = move.getWaypoint()
        if not waypoint.isStateWaypoint():
            raise RuntimeError(f"waypoint {i} was left without joint values")
        state = language.WaypointPoly_as_StateWaypointPoly(waypoint)
        rows.append(np.array(state.getPosition(), dtype=float).ravel())
    return np.array(rows) + MIDDLE


def tool(q):
    """Return where the tool is at joint values, one row a posture."""
    angles = np.cumsum(q, axis=-1)
    return np.stack([np.cos(angles) @ LINKS, np.sin(angles) @ LINKS], axis=-1)


def travel(q):
    """Return the joint travel: per step and joint, the length over the path's parameter and the joint's value."""
    return float(np.sqrt((1.0 / (len(q) - 1)) ** 2 + np.diff(q, axis=0) ** 2).sum())


def found_by_kinematics(world, directions):
    """Return how many of the sampled poses inverse kinematics solves, and how many are within reach."""
    group = world.getKinematicGroup("arm", SOLVER)
    solved = reached = 0
    for place in path():
        for direction in 2.0 * np.pi * np.arange(directions) / directions - np.pi:
            wrist = place - LINKS[2] * np.array([np.cos(direction), np.sin(direction)])
            if np.hypot(*wrist) <= LINKS[0] + LINKS[1]:
                reached += 1
                target = KinGroupIKInput(pose(place, direction), "base", "tool0")
                solved += len(group.calcInvKin(target, np.zeros(3))) > 0
    return solved, reached


def peak_memory():
    """Return the peak of this process in MB, None where the system does not tell."""
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((round(int(line.split()[1]) / 1024) for line in lines if line.startswith("VmHWM")), None)


def row(directions):
    """Return what Descartes makes of one resolution; made for a process of its own."""
    common.setLogLevel(common.CONSOLE_BRIDGE_LOG_NONE)
    world = environment()
    request = PlannerRequest()
    request.env, request.instructions, request.profiles = world, program(), profiles(directions)
    seconds = []
    for _ in range(ROUNDS):
        response, took = solve(request)
        seconds.append(took)
    made = _row(directions, seconds=statistics.median(seconds), memory_mb=peak_memory())
    if not response.successful:
        return made | {"note": f"no plan: {response.message}"}
    q = postures(response)
    steps = np.diff(q, axis=0)
    error = float(np.linalg.norm(tool(q) - path(), axis=1).max() / LINKS.sum())
    solved, reached = found_by_kinematics(world, directions)
    notes = [f"inverse kinematics finds {solved} of {reached} poses within reach, one posture each, elbow positive"]
    if error > TOLERANCE:
        notes.append(f"the tool is up to {error:.1e} of the reach off the path")
    if q[:, 1].min() < -TOLERANCE or q[:, 1].max() > np.pi + TOLERANCE:
        notes.append("joint 2 leaves its range")
    return made | {
        "l_joint_travel": travel(q),
        "squares": float((steps**2).sum()),
        "waypoints": len(q),
        "max_step_deg": float(np.degrees(np.abs(steps).max())),
        "tool_error": error,
        "note": "; ".join(notes),
    }


def _row(directions, **known):
    unknown = ("seconds", "l_joint_travel", "squares", "max_step_deg", "tool_error", "memory_mb")
    return {"resolution_deg": 360.0 / directions, **dict.fromkeys(unknown), "waypoints": 0, "note": ""} | known


def run(quick):
    """Return a row per resolution, each from a fresh interpreter, so that its memory is its own."""
    rows = []
    for directions in DIRECTIONS[:1] if quick else DIRECTIONS:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            try:
                rows.append(pool.submit(row, directions).result())
            except Exception as error:  # whatever the bindings raise, and a process that dies
                rows.append(_row(directions, note=f"no plan: {type(error).__name__}: {error}"))
    return rows


def text(rows, version):
    """Return the rows as a table."""
    lines = [
        f"Descartes (tesseract-robotics {version}), on the seed's Bezier with a free start and over {PLACES} places, "
        "takes the least sum of squared joint steps over the sampled directions of the tool; the joint travel of what "
        f"it returns, which could be {BEST} on this elbow, is not what it minimises.",
        "",
        "| resolution, ° | s | joint travel | sum of squares | waypoints | largest step, ° | MB | note |",
        "|---|---|---|---|---|---|---|---|",
    ]
    shown = (
        ("resolution_deg", "g"), ("seconds", ".3f"), ("l_joint_travel", ".6f"), ("squares", ".6f"),
        ("waypoints", "d"), ("max_step_deg", ".2f"), ("memory_mb", "d"), ("note", "s"),
    )  # fmt: skip
    for each in rows:
        cells = ("–" if each[name] is None else format(each[name], form) for name, form in shown)
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    """Print one line of JSON."""
    rows, version = run("--quick" in sys.argv), importlib.metadata.version("tesseract-robotics")
    print(json.dumps({"rows": rows, "version": version, "text": text(rows, version)}))


if __name__ == "__main__":
    main()
