"""selfmotion: continuous joint motions for kinematically redundant robot arms.

>>> import selfmotion as sm
>>> arm = sm.PlanarArm(links=[30, 30, 20], limits=[None, (0, 3.14159), None])
>>> path = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
>>> plan = sm.plan(sm.Problem(arm, path), sm.Sinusoid(offset=[0.3], amplitude=[0.4], optimizer=sm.PSO(seed=1)))
>>> round(plan.cost, 4)
5.2775

Names are imported when they are first used, so ``import selfmotion`` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from selfmotion._version import __version__

if TYPE_CHECKING:
    from selfmotion.arms import PlanarArm, named_arm, urdf_arm
    from selfmotion.arms.chain import Chain
    from selfmotion.arms.locked import LockedArm
    from selfmotion.arms.spatial import SpatialArm
    from selfmotion.arms.urdf import load_chain
    from selfmotion.breaks import connectivity
    from selfmotion.domain import AngleDomain, angle_domain
    from selfmotion.errors import (
        InfeasibleError,
        InvalidInputError,
        NothingFeasibleError,
        SelfMotionError,
        UndecidedError,
        UnrepairableError,
    )
    from selfmotion.exchange import (
        load_obstacles,
        load_plan,
        load_problem,
        load_trajectory,
        read_dxf,
        read_gcode,
        read_svg,
        save_trajectory,
        save_urdf,
    )
    from selfmotion.intervals import IntervalSet
    from selfmotion.judgement import judge
    from selfmotion.mending import repair
    from selfmotion.optimizers import CMAES, GA, GWO, PSO, DifferentialEvolution, RandomSearch, Shifted
    from selfmotion.paths import (
        Arc,
        ArcLength,
        Bezier,
        Circle,
        Clothoid,
        Concatenation,
        Ellipse,
        Line,
        Lissajous,
        Placed,
        PosePath,
        PoseWaypoints,
        Reversed,
        Rose,
        Transformed,
        Waypoints,
    )
    from selfmotion.planners import (
        BSpline,
        Global,
        Harmonics,
        Modules,
        MovingBase,
        Plan,
        Refine,
        Sinusoid,
        Widest,
        distance_from_optimum,
        plan,
    )
    from selfmotion.problem import Problem
    from selfmotion.scene import (
        BoxObstacle,
        CapsuleObstacle,
        CircleObstacle,
        HalfPlaneObstacle,
        HalfSpaceObstacle,
        MeshObstacle,
        PolygonObstacle,
        SphereObstacle,
    )
    from selfmotion.study import Study, run_study
    from selfmotion.timing import time_law

_HOME = {
    "arms": ("PlanarArm", "named_arm", "urdf_arm"),
    "arms.chain": ("Chain",),
    "arms.locked": ("LockedArm",),
    "arms.spatial": ("SpatialArm",),
    "arms.urdf": ("load_chain",),
    "breaks": ("connectivity",),
    "domain": ("AngleDomain", "angle_domain"),
    "errors": (
        "InfeasibleError", "InvalidInputError", "NothingFeasibleError", "SelfMotionError", "UndecidedError",
        "UnrepairableError",
    ),
    "exchange": (
        "load_obstacles", "load_plan", "load_problem", "load_trajectory", "read_dxf", "read_gcode", "read_svg",
        "save_trajectory", "save_urdf",
    ),
    "intervals": ("IntervalSet",),
    "optimizers": ("CMAES", "DifferentialEvolution", "GA", "GWO", "PSO", "RandomSearch", "Shifted"),
    "paths": (
        "Arc", "ArcLength", "Bezier", "Circle", "Clothoid", "Concatenation", "Ellipse", "Line", "Lissajous",
        "Placed", "PosePath", "PoseWaypoints", "Reversed", "Rose", "Transformed", "Waypoints",
    ),
    "planners": (
        "BSpline", "Global", "Harmonics", "Modules", "MovingBase", "Plan", "Refine", "Sinusoid",
        "Widest", "distance_from_optimum", "plan",
    ),
    "problem": ("Problem",),
    "scene": (
        "BoxObstacle", "CapsuleObstacle", "CircleObstacle", "HalfPlaneObstacle", "HalfSpaceObstacle", "MeshObstacle",
        "PolygonObstacle", "SphereObstacle",
    ),
    "study": ("Study", "run_study"),
    "timing": ("time_law",),
    "mending": ("repair",),
    "judgement": ("judge",),
}  # fmt: skip
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__all__ = [  # noqa: PLE0604
    "__version__",
    *sorted(_MODULE),
]


def __getattr__(name: str) -> Any:
    if name not in _MODULE:
        raise AttributeError(f"module 'selfmotion' has no attribute {name!r}")
    value = getattr(import_module(f"selfmotion.{_MODULE[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
