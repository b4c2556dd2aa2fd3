"""Problem files as text: read into plain data, written so that people can read them, and their schema."""

from __future__ import annotations

import json
import math
from typing import Any

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.schema import json_schema
from selfmotion.exchange.telling import refuse_no_problem
from selfmotion.exchange.yaml_text import parse_yaml, yaml_text
from selfmotion.studio.place import Place, Tell

_LARGEST = 50_000_000


def read(payload: dict[str, Any], tell: Tell, place: Place) -> dict[str, Any]:
    """Return the problem in the ``text`` of a file, as plain data."""
    text = payload.get("text")
    if not isinstance(text, str):
        raise InvalidInputError("text", "is not text", "give what is in a problem file")
    return {"problem": problem_in(text)}


def problem_in(text: str, source: str = "the text") -> dict[str, Any]:
    """Return the problem in YAML or JSON text as plain data, checked only to be one that names an arm and a path.

    Raises
    ------
    InvalidInputError
        With line and column, if it is not plain data; if it is no problem; if it holds what JSON has not.
    """
    if len(text) > _LARGEST:
        raise InvalidInputError("", f"is larger than {_LARGEST} bytes", "is it the right file?", source=source)
    try:
        refuse_no_problem(text)
        data = _parsed(text, source)
        if not isinstance(data, dict):
            raise InvalidInputError("", "is not a mapping", "write `name: value` lines")
        for name in ("arm", "path"):
            if not isinstance(data.get(name), dict):
                reason = "is not a mapping" if name in data else "is missing"
                raise InvalidInputError(name, reason, f"write {name}: {{kind: …}}")
        _refuse_what_json_has_not("", data)
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=source) from None
    return data


def _parsed(text: str, source: str) -> Any:
    """Return the data in a text: of JSON fifty times as fast as YAML is read, with the same rules."""
    if text.lstrip()[:1] == "{":
        try:
            return json.loads(text, object_pairs_hook=_without_repeated)
        except (ValueError, RecursionError):
            pass  # it is YAML, or the reader of YAML says what is wrong with it, and where
    return parse_yaml(text, source)


def _without_repeated(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError
    return found


def _refuse_what_json_has_not(field: str, value: Any) -> None:
    if isinstance(value, dict):
        for key, item in value.items():
            if not isinstance(key, str):
                raise InvalidInputError(field, "has a name that is not text", "write it in quotes", key)
            _refuse_what_json_has_not(f"{field}.{key}" if field else key, item)
    elif isinstance(value, list):
        for k, item in enumerate(value):
            _refuse_what_json_has_not(f"{field}.{k}", item)
    elif isinstance(value, float) and not math.isfinite(value):
        raise InvalidInputError(field, "is not finite", "give a finite number; an open limit is null", value)
    elif not (value is None or isinstance(value, bool | int | float | str)):
        raise InvalidInputError(field, f"is a {type(value).__name__}", "write plain YAML or JSON data")


def write(payload: dict[str, Any], tell: Tell, place: Place) -> dict[str, Any]:
    """Return the ``problem`` as the text of a problem file."""
    problem = payload.get("problem")
    if not isinstance(problem, dict):
        raise InvalidInputError("problem", "is not a mapping", "give the data of a problem file")
    return {"text": yaml_text(problem)}


def schema(payload: dict[str, Any], tell: Tell, place: Place) -> dict[str, Any]:
    """Return the JSON Schema of problem files."""
    return json_schema()
