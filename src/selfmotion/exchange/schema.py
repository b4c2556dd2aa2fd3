"""The problem file's form, derived from the signatures of the classes it names.

A class that is entered in one of the registries (`PATHS`, `ARMS`, `PLANNERS`, …) can at once be named in a problem
file: its fields are the parameters of its constructor. Types are checked here, by pydantic; what the values mean is
checked by the constructors.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, StrictBool, StrictInt, ValidationError, WithJsonSchema, create_model

from selfmotion._checks import choice
from selfmotion._types import FileName
from selfmotion.arms import ARMS, CATALOGUE
from selfmotion.arms.placement import PLANES
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.path_kinds import FILE_PATHS
from selfmotion.objectives import OBJECTIVES
from selfmotion.optimizers import OPTIMIZERS, Optimizer
from selfmotion.paths import PATHS, Path
from selfmotion.planners import PLANNERS, Planner
from selfmotion.scene.obstacle import Obstacle
from selfmotion.scene.obstacles import OBSTACLES
from selfmotion.units import UNITS

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
PlaneOrSpace = Annotated[list[Number], Field(min_length=2, max_length=3)]
Triple = Annotated[list[Number], Field(min_length=3, max_length=3)]
Quaternion = Annotated[list[Number], Field(min_length=4, max_length=4)]
Matrix = Annotated[list[Triple], Field(min_length=3, max_length=3)]
PoseRow = Annotated[list[Number], Field(min_length=7, max_length=7)]
LimitPair = Annotated[list[Number | None], Field(min_length=2, max_length=2)]


class _Form(BaseModel):
    model_config = ConfigDict(extra="forbid")


class FrameForm(_Form):
    """A rigid motion: a translation, and a rotation in one of four ways."""

    translation: Triple | None = None
    quaternion: Quaternion | None = None
    matrix: Matrix | None = None
    rpy: Triple | None = None
    normal: Triple | None = None
    x_axis: Triple | None = None


class ToolForm(_Form):
    """The tool's frame in that of the arm's tip: a translation, and a rotation in one of three ways."""

    translation: Triple | None = None
    quaternion: Quaternion | None = None
    matrix: Matrix | None = None
    rpy: Triple | None = None


class RailForm(_Form):
    """A rail that the arm's base slides on: its direction in the base's frame, and how far it goes [m]."""

    axis: Triple
    limits: Pair


class FollowForm(_Form):
    """The tool axis along the tangent, and the direction that another one stays near to."""

    axis: Literal["x", "y", "z"]
    up: Triple


class PlacementForm(_Form):
    """Where a planar arm stands: its base, its plane in one of five ways, the unit of links and base, and names."""

    base: Triple | None = None
    plane: Literal[PLANES] | None = None  # type: ignore[valid-type]
    quaternion: Quaternion | None = None
    matrix: Matrix | None = None
    rpy: Triple | None = None
    x_axis: Triple | None = None
    y_axis: Triple | None = None
    unit: Literal[tuple(UNITS)] | None = None  # type: ignore[valid-type]
    frame: str | None = None
    joints: list[str] | None = None


_BY_MARK = {
    "vector": list[Number],
    "point": Pair,
    "points": list[Pair],
    "space_point": Triple,
    "position": PlaneOrSpace,
    "positions": list[PlaneOrSpace],
    "rotation": Quaternion | Matrix,
    "rotations": list[Quaternion],
    "poses": list[PoseRow],
    "frame": FrameForm | None,
    "tool": ToolForm | None,
    "rail": RailForm | None,
    "follow": FollowForm | None,
    "file": str,
    "limits": list[LimitPair | None] | None,
    "box": Pair | list[Pair],
    "placement": PlacementForm | None,
}
SECTIONS: dict[str, Mapping[str, Callable[..., Any]]] = {
    "arm": ARMS,
    "path": {**PATHS, **FILE_PATHS},
    "planner": PLANNERS,
    "optimizer": OPTIMIZERS,
}
"""What each section of a problem file may be, by kind."""
NESTED = {Path: "path", Optimizer: "optimizer", Planner: "planner"}
"""The section that describes a parameter of a type."""


# pydantic's error types in our words: what is wrong, what to do.
_REASONS = {
    "float_type": ("is not a number", "give a finite number"),
    "finite_number": ("is not finite", "give a finite number; an open limit is null"),
    "int_type": ("is not a whole number", "give a whole number"),
    "bool_type": ("is neither true nor false", "write true or false"),
    "string_type": ("is not text", "give a name"),
    "list_type": ("is not a list", "write […]"),
    "dict_type": ("is not a mapping", "write {{kind: …}}"),
    "model_type": ("is not a mapping", "write {{name: value}}"),
    "too_short": ("has too few entries", "give at least {min_length}"),
    "too_long": ("has too many entries", "give at most {max_length}"),
    "literal_error": ("is not known", "choose {expected}"),
}


def _section(name: str) -> Any:
    # A mark, not a $ref: pydantic resolves references itself, and these definitions are ours.
    return Annotated[dict[str, Any], WithJsonSchema({"x-section": name})]


class PostureForm(_Form):
    """``start:`` or ``end:``; one of the two."""

    u: list[Number] | None = None
    q: list[Number] | None = None


class ProblemForm(_Form):
    """A problem file."""

    arm: _section("arm")  # type: ignore[valid-type]
    path: _section("task")  # type: ignore[valid-type]
    start: PostureForm | None = None
    end: PostureForm | None = None
    elbow: str = "any"
    branch: str = "any"
    cyclic: Literal[False, "exact", "modulo"] = False
    weights: list[Number] | None = None
    planner: _section("planner") | None = None  # type: ignore[valid-type]
    objective: Literal[tuple(OBJECTIVES)] = "joint_travel"  # type: ignore[valid-type]
    samples: StrictInt = 1000
    obstacles: list[_section("obstacle")] = []  # type: ignore[valid-type]
    clearance: Number = 0.0
    self_collision: StrictBool = False
    least_singular_value: Number | None = None


def _field_type(hint: Any) -> Any:
    """Return the pydantic type for a constructor's parameter."""
    if get_origin(hint) is Annotated:
        return _BY_MARK[get_args(hint)[1]]
    if hint in NESTED:
        return _section(NESTED[hint])
    if get_origin(hint) is Sequence:
        return list[_field_type(get_args(hint)[0])]  # type: ignore[misc]
    if get_origin(hint) is Literal:
        return hint
    options = get_args(hint)
    if options:  # a union
        result = _field_type(options[0])
        for option in options[1:]:
            result = result | (None if option is type(None) else _field_type(option))
        return result
    return {float: Number, int: StrictInt, bool: StrictBool, str: str}[hint]


@cache
def form(section: str, kind: str) -> type[BaseModel]:
    """Return the pydantic model of one kind in one section, such as ("path", "bezier")."""
    part = SECTIONS[section][kind]
    fields = {"kind": (Literal[kind], ...), **_fields_of(part)}
    return create_model(f"{section}_{kind}", __base__=_Form, __doc__=_summary(part), **fields)


def _fields_of(part: Callable[..., Any]) -> dict[str, Any]:
    """Return types and defaults of a constructor's parameters, by name."""
    hints, fields = hints_of(part), {}
    for name, parameter in inspect.signature(part).parameters.items():
        default = ... if parameter.default is inspect.Parameter.empty else parameter.default
        fields[name] = (_field_type(hints[name]), list(default) if isinstance(default, tuple) else default)
    return fields


@cache
def obstacle_form(kind: str) -> type[BaseModel]:
    """Return the pydantic model of one kind of obstacle: ``{kind: {field: value, …}, name: …}``."""
    part = OBSTACLES[kind]
    fields = {part.fields.get(name, name): field for name, field in _fields_of(part).items()}
    name = fields.pop("name")
    alone = fields.get("")  # a value that stands for all fields
    inner = alone or (create_model(f"{kind}_fields", __base__=_Form, **fields), ...)
    return create_model(f"obstacle_{kind}", __base__=_Form, __doc__=_summary(part), **{kind: inner, "name": name})


def hints_of(part: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of the parameters of a class, or of a function that makes an object."""
    return get_type_hints(part.__init__ if inspect.isclass(part) else part, include_extras=True)


def _summary(part: Callable[..., Any]) -> str:
    """Return the first paragraph of a docstring on one line."""
    return " ".join((inspect.getdoc(part) or "").split("\n\n")[0].split())


def checked(model: type[BaseModel], data: Any) -> BaseModel:
    """Validate `data`; the first error becomes one InvalidInputError that names the field."""
    if not isinstance(data, dict):
        raise InvalidInputError("", "is not a mapping", "write `name: value` lines", data)
    try:
        return model.model_validate(data)
    except ValidationError as error:
        problems = error.errors(include_url=False)
        problem = next((p for p in problems if p["type"] == "extra_forbidden"), problems[0])
        raise _as_ours(model, problem) from None
    except RecursionError:
        raise InvalidInputError("", "is nested too deeply", "write plain data") from None


def _as_ours(model: type[BaseModel], problem: Any) -> InvalidInputError:
    field = ".".join(str(part) for part in problem["loc"] if not _is_union_tag(part))
    for part in problem["loc"][:-1]:
        model = _inner_form(model, part) or model
    known = [name for name in model.model_fields if name != "kind"]
    if problem["type"] == "missing":
        return InvalidInputError(field, "is missing", f"add it; the fields are {', '.join(known)}")
    if problem["type"] == "extra_forbidden":
        near = get_close_matches(str(problem["loc"][-1]), known, 1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        return InvalidInputError(field, "is not a known field", f"{hint}the fields are {', '.join(known)}")
    reason, remedy = _REASONS.get(problem["type"], (str(problem["msg"]).lower(), "see the schema: selfmotion schema"))
    return InvalidInputError(field, reason, remedy.format(**problem.get("ctx", {})), problem["input"])


def _inner_form(model: type[BaseModel], name: Any) -> type[BaseModel] | None:
    """Return the form of a field that has one, such as `frame`."""
    hint = model.model_fields[name].annotation if name in model.model_fields else None
    options = (hint, *get_args(hint))
    return next((option for option in options if inspect.isclass(option) and issubclass(option, BaseModel)), None)


def _is_union_tag(part: Any) -> bool:
    """Return whether pydantic put the name of a union's member, not a field, into a location."""
    return isinstance(part, str) and ("[" in part or part in ("float", "int", "str", "none", "list"))


def build(section: str, data: Any, folder: str = "") -> Any:
    """Make the object that a section of a problem file describes.

    Parameters
    ----------
    section : str
        ``"arm"``, ``"path"``, ``"planner"`` or ``"optimizer"``.
    data : object
        The section as parsed.
    folder : str
        What relative file names are relative to.

    Returns
    -------
    RedundantArm, Path, Planner or Optimizer

    Raises
    ------
    InvalidInputError
        Naming the field inside the section.
    """
    if not isinstance(data, dict):
        raise InvalidInputError("", "is not a mapping", f"write {section}: {{kind: …}}", data)
    registry = SECTIONS[section]
    if "kind" not in data:
        raise InvalidInputError("kind", "is missing", f"choose one of {', '.join(registry)}")
    kind = choice("kind", data["kind"], registry)
    checked(form(section, kind), data)
    given = {name: value for name, value in data.items() if name != "kind"}
    hints = hints_of(registry[kind])
    for name, value in given.items():
        given[name] = _nested(hints[name], name, value, folder)
    return registry[kind](**given)


def build_obstacle(data: Any, folder: str = "") -> Obstacle:
    """Make the obstacle that an entry of a problem file's ``obstacles`` describes.

    Parameters
    ----------
    data : object
        The entry as parsed: one kind with its fields, and a ``name`` if wanted.
    folder : str
        What relative file names are relative to.

    Returns
    -------
    Obstacle

    Raises
    ------
    InvalidInputError
        Naming the field inside the entry.
    """
    if not isinstance(data, dict):
        raise InvalidInputError("", "is not a mapping", "write {circle: {center: [x, y], radius: r}}", data)
    keys = [key for key in data if key != "name"]
    if not keys:
        raise InvalidInputError("", "says no kind", f"choose one of {', '.join(OBSTACLES)}", data)
    if isinstance(data.get("kind"), str) and data["kind"] in OBSTACLES:  # as arms and paths say it
        fields = ", ".join(f"{key}: …" for key in keys if key != "kind")
        raise InvalidInputError("kind", "is no field of an obstacle", f"write {{{data['kind']}: {{{fields}}}}}", data)
    kind = next((key for key in keys if key in OBSTACLES), None) or choice(str(keys[0]), keys[0], OBSTACLES)
    checked(obstacle_form(kind), data)
    part = OBSTACLES[kind]
    parameters = {part.fields.get(name, name): name for name in inspect.signature(part).parameters}
    given = {"": data[kind]} if "" in parameters else data[kind]
    hints = hints_of(part)
    values = {parameters[key]: _nested(hints[parameters[key]], key, value, folder) for key, value in given.items()}
    try:
        return part(**values, name=data.get("name"))
    except InvalidInputError as error:
        if error.field == "name":
            raise
        error.field = part.fields.get(error.field, error.field)
        raise error.inside(kind) from None


def _nested(hint: Any, name: str, value: Any, folder: str) -> Any:
    """Build what is inside a section: an optimizer, a path, a list of paths, the full name of a file."""
    if hint == FileName:
        return os.path.join(folder, value)
    if hint in NESTED:
        return inside(name, build, NESTED[hint], value, folder)
    if get_origin(hint) is Sequence and get_args(hint)[0] in NESTED:
        return [inside(f"{name}.{k}", build, NESTED[get_args(hint)[0]], item, folder) for k, item in enumerate(value)]
    if value is not None and get_args(hint) and get_args(hint)[0] in NESTED:  # one that may be left out
        return inside(name, build, NESTED[get_args(hint)[0]], value, folder)
    return value


def inside(field: str, function: Any, *args: Any, **kwargs: Any) -> Any:
    """Call `function`; an InvalidInputError comes out with `field` before its own."""
    try:
        return function(*args, **kwargs)
    except InvalidInputError as error:
        raise error.inside(field) from None


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of problem files."""
    schema = ProblemForm.model_json_schema()
    definitions = schema.setdefault("$defs", {})
    for section, registry in SECTIONS.items():
        for kind in registry:
            definitions[f"{section}_{kind}"] = _lifted(form(section, kind), definitions)
        definitions[section] = {"oneOf": [{"$ref": f"#/$defs/{section}_{kind}"} for kind in registry]}
    for kind in OBSTACLES:
        definitions[f"obstacle_{kind}"] = _lifted(obstacle_form(kind), definitions)
    definitions["obstacle"] = {"oneOf": [{"$ref": f"#/$defs/obstacle_{kind}"} for kind in OBSTACLES]}
    # The path that the tool follows may also say which direction the last link keeps; paths inside it may not.
    tasks = [
        create_model(f"task_{kind}", __base__=form("path", kind), direction=(Number | None, None))
        for kind in SECTIONS["path"]
    ]
    definitions["task"] = {"oneOf": [_lifted(task, definitions) for task in tasks]}
    definitions["arm_named"]["properties"]["name"]["enum"] = list(CATALOGUE)  # checked with the arm
    schema = _with_references(schema)
    for name in ("elbow", "branch"):
        schema["properties"][name]["enum"] = ["any", *_branch_names()]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "selfmotion problem",
        **{key: value for key, value in schema.items() if key != "title"},
    }


def _branch_names() -> list[str]:
    """Return the names of all arms' branches, which editors shall know; the arm's own are checked with the arm."""
    from selfmotion.arms.closed_forms import FAMILIES  # compiled kernels, which reading a problem does without

    return list(dict.fromkeys(["positive", "negative", *(name for family in FAMILIES for name in family.branches)]))


def _lifted(model: type[BaseModel], definitions: dict[str, Any]) -> dict[str, Any]:
    """Return a form's schema, the forms inside it moved to `definitions`, where references look for them."""
    schema = model.model_json_schema()
    definitions.update(schema.pop("$defs", {}))
    return schema


def _with_references(node: Any) -> Any:
    """Return the schema with the marks of :func:`_section` turned into references."""
    if isinstance(node, dict):
        if "x-section" in node:
            return {"$ref": f"#/$defs/{node['x-section']}"}
        return {key: _with_references(value) for key, value in node.items()}
    return [_with_references(item) for item in node] if isinstance(node, list) else node
