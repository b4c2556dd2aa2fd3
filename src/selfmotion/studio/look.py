"""What a problem looks like, with a motion made by hand: asked at every move of the mouse."""

from __future__ import annotations

from typing import Any

import numpy as np

from selfmotion._checks import finite_array
from selfmotion.arms.protocols import RedundantArm
from selfmotion.errors import InvalidInputError
from selfmotion.problem import Problem
from selfmotion.studio.hand import Hand, branch_of, hand_of
from selfmotion.studio.motions import curve_object, sinusoid_of
from selfmotion.studio.panels import Around, domain
from selfmotion.studio.place import Place, Tell
from selfmotion.studio.problems import problem_of
from selfmotion.studio.scene import scene
from selfmotion.studio.wire import unpacked

_CURVE = 401


def look(payload: dict[str, Any], tell: Tell, place: Place) -> dict[str, Any]:
    """Return ``scene``, ``domain`` and ``motion`` of a ``problem``, as far as they are wanted.

    The motion is that of ``hand``, else of the planner's sinusoid at ``frequency``, else None. The domain of more than
    one redundant degree is that about the motion, else about ``around``. Where ``settled`` is false, what takes long is
    left out.
    """
    problem, planner = problem_of(payload.get("problem"), place.folder)
    wanted = payload.get("want", ["scene", "domain", "motion"])
    settled = payload.get("settled", True) is not False
    curve, kind = None, "hand"
    if payload.get("hand") is not None:
        curve = hand_of(problem.arm, payload["hand"])
    elif payload.get("frequency") is not None:
        curve, kind = sinusoid_of(problem, planner, payload["frequency"]), "sinusoid"
    found: dict[str, Any] = {}
    if "scene" in wanted:
        found["scene"] = scene(problem, payload["problem"], settled)
    if "domain" in wanted:
        found["domain"] = domain(problem, _around(problem, curve, payload.get("around")), settled)
    if "motion" in wanted:
        found["motion"] = None if curve is None else curve_object(problem, curve, kind, settled)
    return found


def _around(problem: Problem, curve: Hand | None, given: Any) -> Around | None:
    """Return the curve about which components are varied."""
    if problem.arm.n_u == 1:
        return None
    if curve is not None:
        r = np.linspace(0.0, 1.0, _CURVE)
        return Around(r, curve.curve(r, 0), curve.branch)
    return None if given is None else around_of(problem.arm, given)


def around_of(arm: RedundantArm, given: Any) -> Around:
    """Return the curve that ``{r, u, branch}`` describes, on the branch that it begins on.

    Raises
    ------
    InvalidInputError
        If it does not fit the arm.
    """
    if not isinstance(given, dict):
        raise InvalidInputError("around", "is not a mapping", "give r, u and branch")
    r = finite_array("around.r", unpacked("around.r", given.get("r")), 1)
    u = finite_array("around.u", unpacked("around.u", given.get("u")), 2, arm.n_u)
    if len(r) != len(u) or not len(r) or (np.diff(r) < 0).any():
        raise InvalidInputError("around.r", "does not ascend along u", "give one r per row of u, ascending")
    branch = given.get("branch", 0)
    if isinstance(branch, dict | list):  # one for each r
        along = unpacked("around.branch", branch).ravel()
        branch = int(along[0]) if len(along) and np.isfinite(along[0]) else -1
    return Around(r, u, branch_of(arm, branch, "around.branch"))
