"""What the page lets people take away: a trajectory, the plan's file, a picture, an animation, the result."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np

from selfmotion._checks import choice
from selfmotion.errors import InvalidInputError
from selfmotion.exchange import trajectory_csv
from selfmotion.exchange.plan_file import plan_bytes, plan_from_text
from selfmotion.paths.base import PLANE
from selfmotion.plans import Plan
from selfmotion.studio.hand import hand_of
from selfmotion.studio.motions import Judged
from selfmotion.studio.place import Place, Tell
from selfmotion.studio.problems import problem_of

TYPES = {
    "csv": ("trajectory.csv", "text/csv"),
    "plan": ("plan.selfmotion.json", "application/json"),
    "json": ("plan.json", "application/json"),
    "png": ("motion.png", "image/png"),
    "gif": ("motion.gif", "image/gif"),
}
"""Per format the name of the file, and its type."""


def export(payload: dict[str, Any], tell: Tell, place: Place) -> dict[str, Any]:
    """Return a ``plan``, given by the text of its file, or a motion by ``hand`` as a file of some ``format``."""
    form = choice("format", payload.get("format"), TYPES)
    plan = exported_plan(payload, place.folder)
    name, kind = TYPES[form]
    return {"name": name, "type": kind, "data": base64.b64encode(plan_as(plan, form)).decode()}


def exported_plan(payload: dict[str, Any], folder: str | None) -> Plan:
    """Return the plan to export.

    Raises
    ------
    InvalidInputError
        If there is none, or the motion by hand does not hold.
    """
    text = payload.get("plan")
    if text is not None:
        if not isinstance(text, str):
            raise InvalidInputError("plan", "is not text", "give the text of a plan file")
        return plan_from_text(text)
    if payload.get("hand") is None:
        raise InvalidInputError("plan", "is missing", "give a plan, or a motion by hand")
    problem = problem_of(payload.get("problem"), folder).problem
    hand = hand_of(problem.arm, payload["hand"])
    judged = Judged.of(problem, hand)
    if judged.wrong:
        first = judged.wrong[0]
        where = f"r = {first.r[0]:.4g}" if first.r[0] == first.r[1] else f"r from {first.r[0]:.4g} to {first.r[1]:.4g}"
        raise InvalidInputError("hand", f"does not hold: {first.text}, at {where}", "move the curve off what is red")
    profile = hand.curve.profile
    parameters = {"elbow": problem.arm.branches[hand.branch], "a": hand.curve.a.tolist(), **profile.settings()}
    return Plan(problem, judged.motion, "hand", parameters)


def plan_as(plan: Plan, form: str) -> bytes:
    """Return a plan as the contents of a file of one of the `TYPES`."""
    if form == "csv":
        return trajectory_csv(plan)
    if form == "plan":
        return plan_bytes(plan)
    if form == "json":
        warned = {"warnings": list(plan.problem.warnings)} if plan.problem.warnings else {}
        return (json.dumps(plan.summary() | warned, indent=2, allow_nan=False) + "\n").encode()
    return _animation(plan) if form == "gif" else _picture(plan)


def _animation(plan: Plan) -> bytes:
    """Return the arm on its path, moving."""
    from selfmotion.plot.animation import Animation

    if plan.problem.arm.dimension != PLANE:
        raise InvalidInputError("format", "gif is for planar arms", "choose png")
    r = np.linspace(0.0, 1.0, max(plan.problem.samples, 400))
    return Animation(plan.problem, r, plan(r)).gif()


def _picture(plan: Plan) -> bytes:
    """Return one picture: postures, the motion in the angle domain if that is told, and joints."""
    from selfmotion.domain import angle_domain
    from selfmotion.plot import draw_domain, draw_joints, draw_optimum, draw_postures, plan_figures
    from selfmotion.plot.style import COLUMN, figure, image_files

    problem = plan.problem
    if problem.arm.dimension != PLANE:
        return plan_figures(plan)["joints.png"]
    with_domain = problem.arm.n_u == 1
    with figure(width=COLUMN * (2 + with_domain), height=3.2, columns=2 + with_domain) as (canvas, axes):
        draw_postures(axes[0], plan)
        draw_joints(axes[1], plan)
        if with_domain and plan.certificate is not None:
            draw_optimum(axes[2], plan)
        elif with_domain:
            r = problem.rows
            on = problem.arm.branch_of(plan(r))
            branch = int(np.bincount(on).argmax())
            u = np.where(on == branch, np.unwrap(plan.u(r)[:, 0]), np.nan)
            draw_domain(axes[2], angle_domain(problem.arm, problem.path), branch, {"motion": (r, u)})
        return image_files("motion", canvas, forms=("png",))["motion.png"]
