"""The example problems that the page offers; none of them needs a file."""

from __future__ import annotations

import copy
import math
from typing import Any, NamedTuple

from selfmotion.studio.place import Place, Tell


class Case(NamedTuple):
    """An example.

    Attributes
    ----------
    name : str
        Short, without blanks.
    title : str
        What it shows.
    problem : dict
        The data of a problem file.
    """

    name: str
    title: str
    problem: dict[str, Any]


_ARM_3R = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, math.pi], None]}
_PATH_3R = {
    "kind": "bezier",
    "control_points": [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]],
}
_ARM_6R = {"kind": "planar", "links": [30] * 6, "limits": [None, [0, math.pi], None, None, [0, math.pi], None]}
_PATH_6R = {
    "kind": "clothoid", "center": [110, 20], "scale": 25, "coefficients": [0, -4, 0, 0.33], "t_range": [-4.712, 0],
}  # fmt: skip

CASES = (
    Case(
        "seed-3r",
        "3R arm on a Bézier curve: a sinusoid chosen by particle swarm",
        {
            "arm": _ARM_3R,
            "path": _PATH_3R,
            "planner": {
                "kind": "sinusoid",
                "offset": [0.3],
                "amplitude": [0.4],
                "optimizer": {"kind": "pso", "population": 20, "iterations": 100, "bounds": [0, 15], "seed": 1},
            },
        },
    ),
    Case(
        "shortest-3r",
        "The same arm and path: the shortest motion, and the proof of how near it is to the best possible",
        {
            "arm": _ARM_3R,
            "path": _PATH_3R,
            "start": {"u": [0.3]},
            "planner": {"kind": "global", "gap": 1e-4, "time_limit": 60},
        },
    ),
    Case(
        "three-discs",
        "The same arm between three discs: each takes a piece of the angle domain, and the motion goes round them",
        {
            "arm": _ARM_3R,
            "path": _PATH_3R,
            "obstacles": [
                {"name": "post", "circle": {"center": [30, 24], "radius": 4}},
                {"name": "clamp", "circle": {"center": [40, -12], "radius": 4}},
                {"name": "lamp", "circle": {"center": [14, -14], "radius": 3}},
            ],
            "clearance": 0.5,
            "planner": {"kind": "global", "gap": 1e-3, "time_limit": 60},
        },
    ),
    Case(
        "both-elbows",
        "3R arm without limits: the shortest motion changes the elbow, through a fold",
        {
            "arm": {"kind": "planar", "links": [30, 30, 20]},
            "path": {"kind": "bezier", "control_points": [[20, 50], [-35, 15], [-25, 30], [25, -35]]},
            "planner": {"kind": "global", "gap": 1e-3, "time_limit": 60},
        },
    ),
    Case(
        "seed-6r",
        "6R arm in two modules on a clothoid",
        {
            "arm": _ARM_6R,
            "path": _PATH_6R,
            "planner": {
                "kind": "modules",
                "moving_bases": [{"kind": "bezier", "control_points": [[80, 30], [70, 30], [70, 10], [80, -21]]}],
                "offset": [0.35, 0],
                "amplitude": [0.4, 0.4],
                "first_joints": "absolute",
                "optimizer": {
                    "kind": "pso",
                    "variant": "canonical",
                    "population": 20,
                    "iterations": 100,
                    "bounds": [0, 15],
                    "seed": 1,
                },
            },
        },
    ),
    Case(
        "circle-4r",
        "4R arm on a circle: two redundant degrees, refined from many starts",
        {
            "arm": {"kind": "planar", "links": [7, 7, 4, 1.5]},
            "path": {"kind": "circle", "center": [6, 4], "radius": 4},
            "samples": 600,
            "planner": {"kind": "refine", "starts": 12, "seed": 0, "time_limit": 20},
        },
    ),
    Case(
        "panda-circle",
        "Franka Emika Panda, its hand pointing down, on an upright circle: the shortest motion",
        {
            "arm": {"kind": "named", "name": "panda"},
            "path": {
                "kind": "pose",
                "position": {
                    "kind": "placed",
                    "path": {"kind": "circle", "center": [0, 0], "radius": 0.15},
                    "frame": {"translation": [0.5, 0, 0.4], "normal": [1, 0, 0], "x_axis": [0, 1, 0]},
                },
                "orientation": [0, 1, 0, 0],
            },
            "objective": "l2",
            "planner": {"kind": "global", "gap": 1e-2},
        },
    ),
)
"""The examples, in the order in which they are offered."""


def examples(payload: dict[str, Any], tell: Tell, place: Place) -> list[dict[str, Any]]:
    """Return the examples, each with its name, title and problem."""
    return [copy.deepcopy(case._asdict()) for case in CASES]
