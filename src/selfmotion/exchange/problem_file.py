"""Problem files: YAML (or JSON) in, a problem and its planner out."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

from selfmotion._checks import number
from selfmotion.arms import CATALOGUE, RedundantArm
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.files import read_text
from selfmotion.exchange.path_kinds import FILE_PATHS
from selfmotion.exchange.schema import ProblemForm, build, build_obstacle, checked, inside
from selfmotion.exchange.telling import refuse_no_problem
from selfmotion.exchange.yaml_text import parse_yaml
from selfmotion.planners import Planner
from selfmotion.problem import Problem

_LARGEST = 50_000_000
_LONGEST_YAML = 1_000_000  # which takes about three seconds


class ProblemFile(NamedTuple):
    """What a problem file says.

    Attributes
    ----------
    problem : Problem
    planner : Planner or None
        None if the file names none.
    """

    problem: Problem
    planner: Planner | None


def load_problem(file: str | os.PathLike[str]) -> ProblemFile:
    """Read a problem file.

    Parameters
    ----------
    file : path-like
        YAML or JSON; the fields are those of the contract, see docs/problem-file.

    Returns
    -------
    ProblemFile

    Raises
    ------
    InvalidInputError
        Naming file, field, value and remedy.
    """
    source = os.fspath(file)
    data = _parsed(source)
    try:
        return problem_from(data, os.path.dirname(source))
    except InvalidInputError as error:
        raise error.inside(source=source) from None


def arm_of(name: str) -> RedundantArm:
    """Return the arm of the catalogue that has a name, or the arm of a problem file.

    Raises
    ------
    InvalidInputError
        If there is neither.
    """
    if name in CATALOGUE:
        found: RedundantArm = build("arm", {"kind": "named", "name": name})
        return found
    if not os.path.splitext(name)[1]:
        raise InvalidInputError("--arm", "is neither an arm's name nor a file", "see selfmotion arms", name)
    data = _parsed(name)
    try:
        given = checked(ProblemForm, data)
        arm: RedundantArm = inside("arm", build, "arm", given.model_dump()["arm"], os.path.dirname(name))
    except InvalidInputError as error:
        raise error.inside(source=name) from None
    return arm


def _parsed(source: str) -> Any:
    """Return the data of a problem file; refuse at once what is another one of selfmotion's files."""
    text = read_text(source)
    try:
        refuse_no_problem(text)
    except InvalidInputError as error:
        raise error.inside(source=source) from None
    if len(text) > _LARGEST:
        raise InvalidInputError("", f"is larger than {_LARGEST} bytes", "is it the right file?", source=source)
    return parse_yaml(text, source, _LONGEST_YAML)


def problem_from(data: Any, folder: str = "") -> ProblemFile:
    """Return the problem and planner that parsed data describes; see :func:`load_problem`.

    Relative file names inside are relative to `folder`, by default to the working folder.
    """
    given = checked(ProblemForm, data)
    task, arm_data = dict(data["path"]), dict(data["arm"])
    direction = task.pop("direction", None)
    if direction is not None:
        if arm_data.get("kind") in ("named", "urdf"):
            reason = "is for planar arms; poses hold the tool's direction already"
            raise InvalidInputError("path.direction", reason, "leave it out", direction)
        if arm_data.get("direction") is not None:
            raise InvalidInputError("path.direction", "is given in the arm too", "leave one of the two out", direction)
        arm_data["direction"] = inside("path", number, "direction", direction)
    path = inside("path", build, "path", task, folder)
    arm = inside("arm", build, "arm", arm_data, folder)
    planner = inside("planner", build, "planner", data["planner"], folder) if data.get("planner") is not None else None
    options = given.model_dump(exclude={"arm", "path", "planner"})
    options["obstacles"] = [
        inside(f"obstacles.{k}", build_obstacle, entry, folder) for k, entry in enumerate(options["obstacles"])
    ]
    for name in ("start", "end"):
        if options[name] is not None:
            options[name] = {key: value for key, value in options[name].items() if value is not None}
    branch = options.pop("branch")
    unit = _path_unit(task)
    if "branch" not in given.model_fields_set:
        return ProblemFile(Problem(arm, path, **options).with_path_unit(unit), planner)
    if "elbow" in given.model_fields_set:
        raise InvalidInputError("branch", "is given as elbow too", "leave one of the two out", branch)
    try:
        return ProblemFile(Problem(arm, path, **{**options, "elbow": branch}).with_path_unit(unit), planner)
    except InvalidInputError as error:
        if error.field != "elbow":
            raise
        raise InvalidInputError("branch", error.reason, error.remedy, error.value) from None


def _path_unit(data: Any) -> str | None:
    """Return the unit that a file was converted to; None if there is none, they differ, or the path was scaled."""
    if isinstance(data, list):
        units = {unit for unit in map(_path_unit, data) if unit is not None}
        return units.pop() if len(units) == 1 else None
    if not isinstance(data, dict):
        return None
    if data.get("kind") in FILE_PATHS:
        unit: str = data.get("arm_unit", "m")
        return unit
    return None if data.get("scale", 1.0) != 1.0 else _path_unit(list(data.values()))
