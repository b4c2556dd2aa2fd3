"""Files in and out: problems, paths, trajectories, and the one place that writes to disk."""

from __future__ import annotations

from selfmotion.exchange.drawing import Drawing, Gap, Subpath
from selfmotion.exchange.drawings import read_drawing
from selfmotion.exchange.dxf_file import read_dxf
from selfmotion.exchange.files import OutputFolder, read_text, write_file
from selfmotion.exchange.gcode_file import read_gcode
from selfmotion.exchange.ledger import Ignored
from selfmotion.exchange.obstacle_file import load_obstacles
from selfmotion.exchange.plan_file import load_plan, save_plan
from selfmotion.exchange.problem_file import ProblemFile, arm_of, load_problem, problem_from
from selfmotion.exchange.structure import sampled_lines, sampled_object, structure_lines, structure_object
from selfmotion.exchange.svg_file import read_svg
from selfmotion.exchange.timed_file import TimedRows, load_trajectory, save_trajectory
from selfmotion.exchange.trajectory import Trajectory, motion_csv, read_trajectory, trajectory_csv
from selfmotion.exchange.urdf_file import save_urdf
from selfmotion.exchange.waypoint_file import load_waypoints

__all__ = [
    "Drawing",
    "Gap",
    "Ignored",
    "OutputFolder",
    "ProblemFile",
    "Subpath",
    "TimedRows",
    "Trajectory",
    "arm_of",
    "load_obstacles",
    "load_plan",
    "load_problem",
    "load_trajectory",
    "load_waypoints",
    "motion_csv",
    "problem_from",
    "read_drawing",
    "read_dxf",
    "read_gcode",
    "read_svg",
    "read_text",
    "read_trajectory",
    "sampled_lines",
    "sampled_object",
    "save_plan",
    "save_trajectory",
    "save_urdf",
    "structure_lines",
    "structure_object",
    "trajectory_csv",
    "write_file",
]
