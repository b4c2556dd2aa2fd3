"""What runs do: functions of plain data, by whose names runs find them."""

from __future__ import annotations

import json
import math
import os
from functools import lru_cache
from typing import Any

from selfmotion.errors import InvalidInputError, SelfMotionError, UndecidedError
from selfmotion.exchange.problem_file import problem_from
from selfmotion.exchange.schema import build
from selfmotion.failures import failure_object
from selfmotion.plans import Plan, result_object
from selfmotion.problem import Problem
from selfmotion.study.random_problems import KINDS
from selfmotion.study.runs import canonical
from selfmotion.study.specification import fingerprint

NOT_KEPT = ("wall_time_s", "seconds", "version")
"""What is no part of a run's result, however deep inside: it differs from time to time."""


def plan(specification: dict[str, Any]) -> dict[str, Any]:
    """Plan a motion.

    Parameters
    ----------
    specification : dict
        ``problem``: as in a problem file, or ``{random: {kind, seed}}``; ``planner``; ``seed`` or None; ``history``:
        whether to keep that of the search; ``files``: name to hash of what the problem is read from besides;
        ``folder``: where those are.

    Returns
    -------
    dict
        The result object without times, with ``timed_out``: whether a time limit was hit, so that another machine may
        say something else; and ``history``, one ``{"best", "evaluations"}`` per search.
    """
    folder = specification.get("folder", "")
    for name, known in specification.get("files", {}).items():
        if fingerprint(os.path.join(folder, name)) != known:
            raise InvalidInputError("files", "has changed since the study was read", "run the study again", name)
    problem = _problem(canonical(specification["problem"]), folder)
    if problem is None:
        return _without_times(result_object(status="unknown", error={"message": "no problem was drawn"}), False)
    planner = build("planner", specification["planner"], folder)
    if specification.get("seed") is not None:
        planner = planner.with_seed(specification["seed"])
    try:
        found: Plan = planner.plan(problem)
        summary = found.summary()
    except InvalidInputError:
        raise
    except SelfMotionError as error:
        budget = isinstance(error, UndecidedError) and error.why == "budget"
        return _without_times(failure_object(error), budget or "time limit" in str(error))
    history = None
    if specification.get("history", True) and found.history:
        history = [
            {"best": [None if math.isnan(best) else best for best in part.best], "evaluations": part.evaluations}
            for part in found.history
        ]
    stopped = [str(found.parameters.get(name, "")) for name in ("stopped", "argument")]
    timed_out = any("time limit" in text for text in stopped)
    return {**_without_times(summary, timed_out), **({"history": history} if history else {})}


@lru_cache(maxsize=4)
def _problem(text: str, folder: str) -> Problem | None:
    """Return the problem that plain data describes; runs of many seeds share one."""
    data = json.loads(text)
    if "random" in data:
        return KINDS[data["random"]["kind"]](data["random"]["seed"])
    return problem_from(data, folder).problem


def _without_times(result: dict[str, Any], timed_out: bool) -> dict[str, Any]:
    kept: dict[str, Any] = _repeatable(result)
    return {**kept, "timed_out": timed_out}


def _repeatable(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _repeatable(item) for key, item in value.items() if key not in NOT_KEPT}
    return [_repeatable(item) for item in value] if isinstance(value, list | tuple) else value
