"""Arm, path and reach as plain data: what the picture of the scene is drawn from."""

from __future__ import annotations

from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import PlanarArm
from selfmotion.arms.protocols import length_unit, u_period
from selfmotion.constrained import constraints_of, unconstrained
from selfmotion.domain import out_of_reach
from selfmotion.domain.angle_domain import blocked_stretches, stretches
from selfmotion.errors import Blocked
from selfmotion.paths import Path
from selfmotion.paths.base import PLANE, SPACE
from selfmotion.plot.workspace import same_circles
from selfmotion.problem import Problem
from selfmotion.scene import BoxObstacle, MeshObstacle, Obstacle, PolygonObstacle
from selfmotion.studio.problems import MOST_BREAKS
from selfmotion.studio.wire import finite, packed

_POINTS = 400  # of the path's picture
_BESIDE = 1e-4  # where beside a break the path is shown as well
_MOST_POINTS = 4000
_MOST_HANDLES = 60
_MOST_TRIANGLES = 300
_FEW_LOOKS = 201  # for what is blocked while something is dragged
_DRAGGED = {"bezier": ("control_points",), "waypoints": ("points",), "line": ("start", "end")}
OBJECTIVE_NAMES = {
    "joint_travel": "joint travel, Σ w ∫ √(1 + θ′²) dr",
    "l1": "travel of all joints, Σ w ∫ |θ′| dr",
    "l2": "length of the joint path, ∫ ‖w θ′‖ dr",
}
"""What objectives are called."""


def scene(problem: Problem, data: dict[str, Any], settled: bool = True) -> dict[str, Any]:
    """Return arm, path, reach and what is doubtful or blocked.

    Parameters
    ----------
    problem : Problem
    data : dict
        What it was made from.
    settled : bool
        False while something is dragged: then what is blocked is looked for at fewer places.
    """
    arm, path, bare = problem.arm, problem.path, unconstrained(problem.arm)
    return {
        "dimension": PLANE if arm.dimension == PLANE else SPACE,
        "n": arm.n,
        "n_u": arm.n_u,
        "unit": "rad" if u_period(arm) == TAU else "m",
        "length_unit": length_unit(arm),
        "branches": list(arm.branches),
        "allowed": problem.elbow_branches,
        "joints": _joint_names(problem),
        "limits": [[finite(low), finite(high)] for low, high in zip(arm.limits.lower, arm.limits.upper, strict=True)],
        "slides": arm.limits.slides.tolist(),
        "links": bare.links.tolist() if isinstance(bare, PlanarArm) else None,
        "thickness": bare.thickness.tolist() if isinstance(bare, PlanarArm) else None,
        "obstacles": [] if problem.scene is None else [_obstacle(part) for part in problem.scene.obstacles],
        "clearance": 0.0 if problem.scene is None else problem.scene.clearance,
        "path": _path(path) | {"handles": _handles(data.get("path"))},
        "reach": _reach(bare) if isinstance(bare, PlanarArm) else None,
        "direction": bare.direction if isinstance(bare, PlanarArm) else None,
        "objective": problem.objective.kind,
        "objective_name": OBJECTIVE_NAMES.get(problem.objective.kind, problem.objective.kind),
        "samples": problem.samples,
        "start": None if problem.start is None else problem.start.u.tolist(),
        "warnings": list(problem.warnings),
        "blocked": [
            {"r": list(part.r), "cause": part.cause, "text": blocked_text(part)} for part in _blocked(problem, settled)
        ],
    }


def _obstacle(obstacle: Obstacle) -> dict[str, Any]:
    """Return an obstacle as what is drawn: its fields as numbers, of a box its axes, of a mesh its triangles."""
    fields = {name: getattr(obstacle, attribute) for attribute, name in obstacle.fields.items() if name}
    if isinstance(obstacle, PolygonObstacle):
        fields = {"corners": obstacle.corners}
    elif isinstance(obstacle, BoxObstacle):
        fields["rotation"] = obstacle.rotation
    elif isinstance(obstacle, MeshObstacle):
        every = -(-len(obstacle.triangles) // _MOST_TRIANGLES)
        fields = {"triangles": obstacle.vertices[obstacle.triangles[::every]]}
    plain = {name: np.asarray(value).tolist() for name, value in fields.items()}
    return {"kind": obstacle.kind, "name": obstacle.name, **plain}


def _joint_names(problem: Problem) -> list[str]:
    chain = getattr(problem.arm, "chain", None)
    return [f"θ{j + 1}" for j in range(problem.arm.n)] if chain is None else list(chain.names)


def _path(path: Path) -> dict[str, Any]:
    """Return points along the path, closer together where it breaks."""
    breaks = path.breaks
    beside = [breaks - _BESIDE, breaks + _BESIDE] if len(breaks) <= MOST_BREAKS else []
    r = np.unique(np.clip(np.concatenate([path.grid(_POINTS), *beside]), 0.0, 1.0))
    r = thinned(r, _MOST_POINTS)
    x = path(r)[:, : PLANE if path.dimension == PLANE else SPACE]
    return {"r": packed(r), "x": packed(x), "closed": path.is_closed, "length": finite(_length(path, x))}


def _length(path: Path, x: FloatArray) -> float:
    """Return the path's length, of very many pieces as far as points tell."""
    if len(path.breaks) <= MOST_BREAKS:
        return path.length
    points = path(np.union1d(path.breaks, [0.0, 1.0]))[:, : x.shape[1]]
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def thinned(values: FloatArray, most: int) -> FloatArray:
    """Return at most so many rows, evenly chosen, the first and the last among them."""
    if len(values) <= most:
        return values
    return np.asarray(values[np.linspace(0, len(values) - 1, most).round().astype(int)])


def _handles(data: Any) -> list[list[float]] | None:
    """Return the points by which a plane path is dragged, None if it has none or too many."""
    if not isinstance(data, dict):
        return None
    names = _DRAGGED.get(str(data.get("kind")))
    if names is None:
        return None
    found = data[names[0]] if len(names) == 1 else [data[name] for name in names]
    if len(found) > _MOST_HANDLES or any(len(point) != PLANE for point in found):
        return None
    return [[float(value) for value in point] for point in found]


def _reach(arm: PlanarArm) -> dict[str, Any]:
    """Return the annulus of reach, and with one redundant degree its characteristic circles."""
    center, inner, outer = arm.annulus
    circles = []
    if arm.n_u == 1:
        radii = arm.radii()
        named = [("R_max (9)", radii.outer), ("R*_min (10)", radii.nearest)]
        named += [(f"co-regular ρ{k + 1}", rho) for k, rho in enumerate(radii.coregular)]
        circles = [
            {"radius": radius, "name": f"{' = '.join(names)} = {radius:.4g}"} for names, radius in same_circles(named)
        ]
    return {"center": center.tolist(), "inner": inner, "outer": outer, "circles": circles}


def _blocked(problem: Problem, settled: bool) -> list[Blocked]:
    """Return the stretches that no posture reaches.

    While something is dragged, of arms in space or between obstacles, only those out of reach. What obstacles block of
    the path of an arm in space takes as long to tell as a plan, which tells it.
    """
    arm, path = problem.arm, problem.path
    if settled and arm.dimension != PLANE and constraints_of(arm):
        return blocked_stretches(unconstrained(arm), path, problem.samples, problem.elbow_branches)
    if settled:
        return problem.blocked
    if arm.dimension == PLANE and arm.has_structure:
        return blocked_stretches(arm, path, min(problem.samples, _FEW_LOOKS), problem.elbow_branches)
    found = stretches(lambda r: out_of_reach(arm, path(r)), path.grid(_FEW_LOOKS - 1))
    return [Blocked(ends, "out of reach", float(arm.shortfall(path(np.linspace(*ends, 101))).max())) for ends in found]


def blocked_text(part: Blocked) -> str:
    """Return what is blocked in words."""
    by = "" if part.short_by is None else f" by up to {part.short_by:.4g}"
    why = f" ({' and '.join(part.limits)})" if part.limits else ""
    a, b = part.r
    return f"{part.cause}{by}{why} " + (f"at r = {a:.4g}" if a == b else f"for r from {a:.4g} to {b:.4g}")
