"""What plan files are made of: problems and motions as plain data, and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from pydantic import BaseModel

from selfmotion._checks import LARGEST, choice, finite_array
from selfmotion._types import FloatArray
from selfmotion.arms import JointBox, PlanarArm, RedundantArm
from selfmotion.arms.chain import Chain as JointChain
from selfmotion.arms.shapes import Capsule, Shapes
from selfmotion.constrained import unconstrained
from selfmotion.errors import InvalidInputError
from selfmotion.exchange import plan_forms as forms
from selfmotion.exchange.file_path import PathFromFile
from selfmotion.exchange.path_kinds import FILE_PATHS
from selfmotion.exchange.schema import build, build_obstacle, checked, inside
from selfmotion.motion import Curve, JointMotion, Motion
from selfmotion.paths import PATHS, Frame, Path, Section
from selfmotion.planners.chain import Chain, ChainCurve
from selfmotion.planners.moving_base import Wave
from selfmotion.problem import Posture, Problem
from selfmotion.profiles import PROFILES, ProfileCurve
from selfmotion.refinement import ClosedSpline, SplineSpace
from selfmotion.refinement.spline import DEGREE
from selfmotion.scene import MeshObstacle, Obstacle

_REMEDY = "store its trajectory instead"
_DAMAGED = "load the original file"
_MOST_NODES = 10_000_000


def problem_object(problem: Problem) -> dict[str, Any]:
    """Return a problem as plain data, complete: files that it was made from are not needed again.

    Raises
    ------
    InvalidInputError
        If its arm or path is of a class that is not selfmotion's.
    """
    return {
        "arm": _arm_object(unconstrained(problem.arm)),
        "path": _path_object(problem.path),
        "start": _posture_object(problem.start),
        "end": _posture_object(problem.end),
        "elbow": problem.elbow,
        "cyclic": problem.cyclic,
        "weights": problem.weights,
        "objective": problem.objective.kind,
        "samples": problem.samples,
        **_constraints_object(problem),
    }


def _constraints_object(problem: Problem) -> dict[str, Any]:
    """Return what a problem says beyond arm, path and posture: nothing where it says nothing."""
    scene, found = problem.scene, {}
    if scene is not None:
        found = {
            "obstacles": [obstacle.as_mapping() for obstacle in scene.obstacles],
            "clearance": scene.clearance,
            "self_collision": scene.self_collision,
        }
    if problem.least_singular_value is not None:
        found["least_singular_value"] = problem.least_singular_value
    return found


def problem_from_object(data: Any) -> Problem:
    """Return the problem that :func:`problem_object` described."""
    given: Any = checked(forms.ProblemForm, data)
    arm, path = inside("arm", _arm_from, given.arm), inside("path", _path_from, given.path)
    options = given.model_dump(exclude={"arm", "path", "obstacles"})
    obstacles = [inside(f"obstacles.{k}", _obstacle_from, entry) for k, entry in enumerate(given.obstacles)]
    return Problem(arm, path, obstacles=obstacles, **options)


def _obstacle_from(data: Any) -> Obstacle:
    """Return an obstacle as a problem file has it, or a mesh, whose file is not needed again, by its triangles."""
    mesh = data.get("mesh")
    if not isinstance(mesh, dict) or "vertices" not in mesh:
        return build_obstacle(data)
    given: Any = checked(forms.MeshForm, data)
    triangles = given.mesh
    return MeshObstacle.of_triangles(triangles.vertices, triangles.triangles, given.name)


def motion_object(motion: JointMotion) -> dict[str, Any]:
    """Return a motion as plain data.

    Raises
    ------
    InvalidInputError
        If it is of a class that is not selfmotion's, or its curve is anybody's function.
    """
    if type(motion) is ClosedSpline:
        return {
            "kind": "spline",
            "knots": motion.space.knots,
            "coefficients": motion.coefficients,
            "lower": _open(motion.box.lower),
            "upper": _open(motion.box.upper),
        }
    if type(motion) is Motion:
        return {
            "kind": "curve",
            "branch": motion.branch,
            "nodes": motion.nodes,
            "start": motion.start,
            "curve": _curve_object(motion.curve),
        }
    raise InvalidInputError("motion", f"is a {type(motion).__name__}, which a plan file cannot hold", _REMEDY)


def motion_from(data: Any, problem: Problem) -> JointMotion:
    """Return the motion that :func:`motion_object` described."""
    kind = choice("kind", data.get("kind"), ("spline", "curve"))
    return _spline_from(data, problem) if kind == "spline" else _curved_from(data, problem)


def _spline_from(data: Any, problem: Problem) -> ClosedSpline:
    given: Any = checked(forms.SplineForm, data)
    n, knots = problem.arm.n, finite_array("knots", given.knots, 1)
    inner = knots[DEGREE + 1 : -DEGREE - 1]
    space = SplineSpace(inner)
    if not np.array_equal(space.knots, knots) or (np.diff(knots) < 0).any() or inner[:1].min(initial=1.0) <= 0.0:
        raise InvalidInputError("knots", "are not those of a clamped cubic spline over [0, 1]", _DAMAGED)
    coefficients = _table("coefficients", given.coefficients, (n, space.m))
    ends = (_closed(name, getattr(given, name), n, side) for name, side in (("lower", -np.inf), ("upper", np.inf)))
    return ClosedSpline(problem.arm, problem.path, space, coefficients, JointBox(*ends))


def _curved_from(data: Any, problem: Problem) -> Motion:
    given: Any = checked(forms.CurveForm, data)
    arm = problem.arm
    if not 0 <= given.branch < len(arm.branches):
        raise InvalidInputError("branch", "is none of the arm's", _DAMAGED, given.branch)
    if not 1 <= given.nodes <= _MOST_NODES:
        raise InvalidInputError("nodes", f"is not from 1 to {_MOST_NODES}", _DAMAGED, given.nodes)
    start = None if given.start is None else _table("start", given.start, (arm.n,))
    curve = inside("curve", _curve_from, given.curve, problem)
    return Motion(arm, problem.path, curve, given.branch, given.nodes, start)


def _curve_object(curve: Curve) -> dict[str, Any]:
    if isinstance(curve, ProfileCurve) and type(curve.profile) is PROFILES.get(curve.profile.kind):
        profile = curve.profile
        return {"kind": "profile", "family": profile.kind, "settings": profile.settings(), "a": curve.a}
    if isinstance(curve, Wave):
        return {"kind": "wave", **vars(curve)}
    if isinstance(curve, ChainCurve):
        return {
            "kind": "modules",
            "moving_bases": [_path_object(path) for path in curve.moving_bases],
            "motions": [motion_object(motion) for motion in curve.motions],
        }
    reason = "goes by a function of u, which a plan file cannot hold"
    raise InvalidInputError("motion", reason, f"make it of a profile, or {_REMEDY}")


def _curve_from(data: Any, problem: Problem) -> Curve:
    kind = choice("kind", data.get("kind"), ("profile", "wave", "modules"))
    makers: dict[str, tuple[type[BaseModel], Callable[[Any, Problem], Curve]]] = {
        "profile": (forms.ProfileForm, _profile_from),
        "wave": (forms.WaveForm, _wave_from),
        "modules": (forms.ModulesForm, _modules_from),
    }
    form, made = makers[kind]
    return made(checked(form, data), problem)


def _profile_from(given: Any, problem: Problem) -> ProfileCurve:
    family = PROFILES[choice("family", given.family, PROFILES)]
    settings = dict(given.settings)
    if family.kind == "bspline":
        settings["n_u"] = problem.arm.n_u
    try:
        profile = family(**settings)
    except TypeError:
        raise InvalidInputError("settings", f"are not those of {family.kind}", _DAMAGED, settings) from None
    if profile.n_u != problem.arm.n_u:
        raise InvalidInputError("settings", f"are not for {problem.arm.n_u} redundant degrees", _DAMAGED)
    return ProfileCurve(profile, _table("a", given.a, (len(profile.parameter_names),)))


def _wave_from(given: Any, problem: Problem) -> Wave:
    shape = (problem.arm.n_u,)
    names = ("offset", "amplitude", "frequency")
    return Wave(*(_table(name, getattr(given, name), shape) for name in names))


def _modules_from(given: Any, problem: Problem) -> ChainCurve:
    bases = [inside(f"moving_bases.{k}", _path_from, base) for k, base in enumerate(given.moving_bases)]
    modules = Chain(problem, bases).modules
    if len(given.motions) != len(modules):
        raise InvalidInputError("motions", f"are not {len(modules)}", _DAMAGED)
    pairs = enumerate(zip(given.motions, modules, strict=True))
    return ChainCurve(
        tuple(bases), tuple(inside(f"motions.{k}", _curved_from, motion, module) for k, (motion, module) in pairs)
    )


def _arm_object(arm: RedundantArm) -> dict[str, Any]:
    if type(arm) is PlanarArm:
        placement = None if arm.placement is None else arm.placement.as_mapping()
        given = {"links": arm.links, "limits": arm.limits.as_list(), "direction": arm.direction}
        thick = {"thickness": arm.thickness} if arm.thickness.any() else {}
        return {"kind": "planar", **given, "placement": placement, **thick}
    from selfmotion.arms.chain_arm import ChainArm  # compiled kernels, which planar arms do without

    if isinstance(arm, ChainArm):
        chain = arm.chain
        for solved in [name for name, made in _solvers().items() if type(arm) is made]:
            return {
                "kind": "chain",
                "solved": solved,
                "names": chain.names,
                "offsets": chain.offsets,
                "limits": chain.limits.as_list(),
                "velocity": _open(chain.velocity),
                "base": chain.base,
                "tip": chain.tip,
                "locked_joint": getattr(arm, "joint", None),
                "shapes": _shapes_object(chain.shapes),
            }
    raise InvalidInputError("arm", f"is a {type(arm).__name__}, which a plan file cannot hold", _REMEDY)


def _arm_from(data: Any) -> RedundantArm:
    if data.get("kind") != "chain":
        choice("kind", data.get("kind"), ("planar", "chain"))
        arm: RedundantArm = build("arm", data)
        return arm
    given: Any = checked(forms.ChainForm, data)
    velocity = [np.inf if speed is None else speed for speed in given.velocity]
    sizes = {len(row) for matrix in given.offsets for row in matrix} | {len(matrix) for matrix in given.offsets}
    if sizes != {4}:
        raise InvalidInputError("offsets", "are not four by four", _DAMAGED)
    slides = [given.solved == "rail" and joint == 0 for joint in range(len(given.names))]
    shapes = inside("shapes", _shapes_from, given.shapes)
    chain = JointChain(given.names, given.offsets, given.limits, slides, velocity, given.base, given.tip, shapes)
    made = _solvers()[given.solved]
    return made(chain, given.locked_joint) if given.solved == "locked" else made(chain)


def _shapes_object(shapes: Shapes) -> dict[str, Any]:
    capsules = [{field.name: getattr(part, field.name) for field in fields(part)} for part in shapes.capsules]
    return {"capsules": capsules, "unread": dict(shapes.unread), "loose": shapes.loose, "apart": shapes.apart}


def _shapes_from(given: Any) -> Shapes:
    """Return the shapes of links; plans from before there were any have none."""
    if given is None:
        return Shapes()
    capsules = [inside(f"capsules.{k}", Capsule, **dict(part)) for k, part in enumerate(given.capsules)]
    apart = tuple((one, other) for one, other in given.apart)
    return Shapes(tuple(capsules), dict(given.unread), tuple(given.loose), apart)


def _solvers() -> dict[str, Callable[..., Any]]:
    """Return the classes of arms in space; with compiled kernels, which planar arms do without."""
    from selfmotion.arms.locked import LockedArm
    from selfmotion.arms.rail import RailArm
    from selfmotion.arms.roll import RollArm
    from selfmotion.arms.spatial import SpatialArm

    return {"spatial": SpatialArm, "roll": RollArm, "rail": RailArm, "locked": LockedArm}


def _path_object(path: Path) -> dict[str, Any]:
    if type(path) is Section:
        return {"kind": "section", "path": _path_object(path.path), "r_range": path.r_range}
    if isinstance(path, PathFromFile) and type(path) is FILE_PATHS.get(path.kind):
        return _path_object(path.path)  # what was read: another machine has not the file
    if type(path) is not PATHS.get(path.kind):
        raise InvalidInputError("path", f"is a {type(path).__name__}, which a plan file cannot hold", _REMEDY)
    return {"kind": path.kind, **{name: _given(value) for name, value in path.made_from.items()}}


def _given(value: Any) -> Any:
    """Return an argument of a path's constructor as plain data."""
    if isinstance(value, Path):
        return _path_object(value)
    if isinstance(value, Frame):
        return {"translation": value.translation, "quaternion": value.quaternion}
    if isinstance(value, list):
        return [_given(item) for item in value]
    return value


def _path_from(data: Any) -> Path:
    if data.get("kind") != "section":
        path: Path = build("path", data)
        return path
    given: Any = checked(forms.SectionForm, data)
    return Section(inside("path", _path_from, given.path), given.r_range)


def _posture_object(posture: Posture | None) -> dict[str, FloatArray] | None:
    if posture is None:
        return None
    return {"u": posture.u} if posture.q is None else {"q": posture.q}


def _open(ends: FloatArray) -> list[float | None]:
    """Return numbers, None where they are infinite."""
    return [float(end) if np.isfinite(end) else None for end in ends]


def _closed(field: str, ends: list[float | None], n: int, instead: float) -> FloatArray:
    """Undo :func:`_open`."""
    if len(ends) != n:
        raise InvalidInputError(field, f"has {len(ends)} entries for {n} joints", _DAMAGED)
    found = np.array([instead if end is None else end for end in ends])
    if not (np.abs(found[np.isfinite(found)]) <= LARGEST).all():
        raise InvalidInputError(field, f"exceeds {LARGEST:g} in magnitude", _DAMAGED)
    return found


def _table(field: str, rows: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return numbers as an array of the given shape."""
    try:
        found = np.array(rows, dtype=float)
    except (TypeError, ValueError, OverflowError):
        found = np.empty(0)
    if found.shape != shape or not (np.abs(found) <= LARGEST).all():
        raise InvalidInputError(field, f"is not an array of shape {shape} of numbers up to {LARGEST:g}", _DAMAGED)
    return found
