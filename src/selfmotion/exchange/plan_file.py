"""Plans on disk: one JSON file that loads back to an equal plan, on other machines and in later versions too."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from selfmotion._checks import finite_array, number
from selfmotion._version import __version__
from selfmotion.certificate.result import Certificate, Level, TubeSlice
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.files import read_text, write_file
from selfmotion.exchange.path_kinds import FILE_PATHS
from selfmotion.exchange.plan_forms import CertificateForm, PlanForm
from selfmotion.exchange.plan_parts import motion_from, motion_object, problem_from_object, problem_object
from selfmotion.exchange.schema import checked, inside
from selfmotion.exchange.telling import PLAN_FORMAT, refuse_result
from selfmotion.optimizers import History
from selfmotion.plans import RESULT_FIELDS, Plan
from selfmotion.problem import Problem

FORMAT = PLAN_FORMAT
VERSION = 1
MIGRATIONS: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {}
"""For each older version of the form: what makes the next one of it. The first version needs none."""

_REMEDY = "load a file that Plan.save wrote"
_CHECKSUM = "checksum"
_MARK = "float"  # JSON has no infinity: {"float": "inf"} stands for it
_NOT_FINITE = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}
_NOT_RESULTS = ("planner", "parameters", "evaluations", "wall_time_s", "version", "blocked")  # said elsewhere
_LOOKED_AT = np.linspace(0.0, 1.0, 65)


def save_plan(plan: Plan, file: str | os.PathLike[str], force: bool = False) -> None:
    """Write a plan as a JSON file; see :meth:`selfmotion.Plan.save`."""
    data = plan_bytes(plan)
    # A file that does not give the motion back is found out now, not when the plan is needed.
    again = _plan_from(_parsed(data.decode()))
    if not np.array_equal(again(_LOOKED_AT), plan(_LOOKED_AT), equal_nan=True):
        raise InvalidInputError("plan", "does not come back the same from its file", "store its trajectory instead")
    write_file(file, data, force)


def check_storable(problem: Problem) -> None:
    """Refuse before it is planned a problem whose plans :func:`save_plan` would refuse.

    Raises
    ------
    InvalidInputError
        If its arm or path is of a class that is not selfmotion's.
    """
    _plain("problem", problem_object(problem))


def load_plan(file: str | os.PathLike[str]) -> Plan:
    """Read a plan that :meth:`selfmotion.Plan.save` wrote.

    Parameters
    ----------
    file : path-like

    Returns
    -------
    Plan
        Its motion, cost, gap and bound are those of the plan that was stored, on the same machine bit by bit. Cost and
        verification are computed anew when they are asked for.

    Raises
    ------
    InvalidInputError
        If the file is no plan file, is incomplete, was changed since it was written, or is of a later version.
    """
    source = os.fspath(file)
    try:
        return _plan_from(_parsed(read_text(file)))
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=source) from None


def plan_from_text(text: str) -> Plan:
    """Return the plan in the text of a plan file; see :func:`load_plan`. No other file is read.

    Raises
    ------
    InvalidInputError
        If it is no plan file, is incomplete, was changed, is of a later version, or its paths are read from files.
    """
    data = _parsed(text)
    refuse_files(data)
    return _plan_from(data)


def refuse_files(data: Any, field: str = "") -> None:
    """Refuse data of a plan whose paths are to be read from files, as no plan that was saved has them."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    if isinstance(data, dict) and data.get("kind") in (*FILE_PATHS, "urdf"):
        raise InvalidInputError(field, "names a file", "load a file that Plan.save wrote", data["kind"])
    for name, item in items:
        if isinstance(item, dict | list):
            refuse_files(item, f"{field}.{name}" if field else str(name))


def plan_bytes(plan: Plan) -> bytes:
    """Return a plan as the text of its file."""
    data = {
        FORMAT: VERSION,
        "version": __version__,
        "problem": problem_object(plan.problem),
        "planner": plan.planner,
        "parameters": plan.parameters,
        "evaluations": plan.evaluations,
        "wall_time_s": plan.wall_time_s,
        "reconfigurations": plan.reconfigurations,
        "history": [asdict(part) for part in plan.history],
        "motion": motion_object(plan.motion),
        "lower_bound": plan.lower_bound,
        "gap": plan.gap,
        "estimated_bound": plan.estimated_bound,
        "estimated_gap": plan.estimated_gap,
        "certificate": None if plan.certificate is None else _certificate_object(plan.certificate),
        "result": _result(plan),
    }
    plain = _plain("plan", data)
    return (json.dumps({**plain, _CHECKSUM: _checksum(plain)}, indent=None, allow_nan=False) + "\n").encode()


def _result(plan: Plan) -> dict[str, Any]:
    """Return the figures of the result, for readers of the file; loading computes them anew."""
    summary = plan.summary()
    return {name: summary[name] for name in RESULT_FIELDS if name not in _NOT_RESULTS}


def _certificate_object(certificate: Certificate) -> dict[str, Any]:
    return {
        "bound": certificate.bound,
        "argument": certificate.argument,
        "rigorous": certificate.rigorous,
        "levels": [list(level) for level in certificate.levels],
        "tube": [[part.r, part.a, part.b] for part in certificate.tube],
    }


def _certificate_from(data: Any, n: int) -> Certificate:
    given: Any = checked(CertificateForm, data)
    tube = []
    for k, (r, a, b) in enumerate(given.tube):
        number(f"tube.{k}", r)
        ends = [finite_array(f"tube.{k}", rows if rows != [] else np.empty((0, n)), 2, n) for rows in (a, b)]
        if len(ends[0]) != len(ends[1]):
            raise InvalidInputError(f"tube.{k}", f"is not made of chords of {n} joints", "load the original file")
        tube.append(TubeSlice(r, *ends))
    levels = tuple(Level(*level) for level in given.levels)
    return Certificate(given.bound, given.argument, levels, tuple(tube), given.rigorous)


def _parsed(text: str) -> dict[str, Any]:
    """Return the data of a plan file in this version's form, the checksum checked."""
    try:
        return _current(text, _REMEDY)
    except RecursionError:
        raise InvalidInputError("", "is nested too deeply", _REMEDY) from None


def _current(text: str, remedy: str) -> dict[str, Any]:
    try:
        data = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        at = f" at line {error.lineno}, column {error.colno}" if isinstance(error, json.JSONDecodeError) else ""
        raise InvalidInputError("", f"is not JSON{at}: it is incomplete or damaged", remedy) from None
    if not isinstance(data, dict) or FORMAT not in data:
        refuse_result(text, "stored plan")
        raise InvalidInputError("", f"is not a plan file: it has no {FORMAT}", remedy)
    version = data[FORMAT]
    if not isinstance(version, int) or isinstance(version, bool):
        raise InvalidInputError(FORMAT, "is not a whole number", remedy, version)
    if version > VERSION:
        wrote = data.get("version")
        reason = f"is {version}, and this version of selfmotion, {__version__}, reads up to {VERSION}"
        raise InvalidInputError(FORMAT, reason, f"use selfmotion {wrote} or later", version)
    checksum = data.pop(_CHECKSUM, None)
    if checksum != _checksum(data):
        reason = "does not fit the rest: the file is incomplete or was changed since it was written"
        raise InvalidInputError(_CHECKSUM, reason, "load the original file, or plan anew")
    while version < VERSION:
        if version not in MIGRATIONS:
            raise InvalidInputError(FORMAT, "is of a version that there never was", remedy, version)
        data = MIGRATIONS[version](data)
        version += 1
    current: dict[str, Any] = _unmarked(data)
    return current


def _plan_from(data: dict[str, Any]) -> Plan:
    """Return the plan that parsed data describes."""
    given: Any = checked(PlanForm, {key: value for key, value in data.items() if key != FORMAT})
    problem = inside("problem", problem_from_object, given.problem)
    motion = inside("motion", motion_from, given.motion, problem)
    history = tuple(History(**part.model_dump()) for part in given.history)
    plan = Plan(
        problem, motion, given.planner, given.parameters, given.evaluations, given.wall_time_s, history
    )  # fmt: skip
    plan.reconfigurations = given.reconfigurations
    plan.lower_bound, plan.gap = given.lower_bound, given.gap
    plan.estimated_bound, plan.estimated_gap = given.estimated_bound, given.estimated_gap
    if given.certificate is not None:
        plan.certificate = inside("certificate", _certificate_from, given.certificate, problem.arm.n)
    return plan


def _checksum(data: Mapping[str, Any]) -> str:
    """Return the checksum of what the file says, however it is laid out."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _plain(field: str, value: Any) -> Any:
    """Return `value` as what JSON knows, numbers bit by bit."""
    value = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
    if isinstance(value, Mapping):
        return {str(key): _plain(f"{field}.{key}", item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(field, item) for item in value]
    if isinstance(value, float):
        if math.isfinite(value):
            return float(value)
        return {_MARK: "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"}
    if value is None or isinstance(value, bool | int | str):
        return value
    remedy = "store the trajectory, and the problem file"
    raise InvalidInputError(field, f"is a {type(value).__name__}, which a plan file cannot hold", remedy)


def _unmarked(value: Any) -> Any:
    """Return data with the numbers that JSON has not."""
    if isinstance(value, dict):
        if set(value) == {_MARK} and value[_MARK] in _NOT_FINITE:
            return _NOT_FINITE[value[_MARK]]
        return {key: _unmarked(item) for key, item in value.items()}
    return [_unmarked(item) for item in value] if isinstance(value, list) else value


def _no_constant(name: str) -> Any:
    raise ValueError(f"{name} is not JSON")
