"""YAML as data only: the YAML 1.2 numbers and booleans, no code, no aliases, no repeated keys; read and written."""

from __future__ import annotations

import json
import math
import re
from io import StringIO
from typing import Any

import yaml

from selfmotion.errors import InvalidInputError

_FLOAT = re.compile(
    r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?$|[-+]?\.(?:inf|Inf|INF)$|\.(?:nan|NaN|NAN)$"
)
_INT = re.compile(r"[-+]?[0-9]+$")
_BOOL = re.compile(r"(?:true|True|TRUE|false|False|FALSE)$")
_NULL = re.compile(r"(?:~|null|Null|NULL|)$")

_DEEPEST = 100


def _whole(text: str) -> int | float:
    return int(text) if len(text) <= 400 else float(text)


def _only_yaml(name: str) -> Any:
    raise ValueError(f"{name} is not JSON")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(dict(pairs)) < len(pairs):
        raise ValueError("a key appears twice")
    return dict(pairs)


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader reads YAML 1.1, where 1e-4 is text and `no` is false; this one reads JSON's numbers."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012
    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.events.AliasEvent):
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            raise yaml.MarkedYAMLError(problem="aliases are not read", problem_mark=mark)
        self._depth += 1
        if self._depth > _DEEPEST:  # each level slows the scanner down
            raise RecursionError
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        seen: set[str] = set()
        for key, _ in node.value:
            name = str(key.value)
            if name in seen:
                raise yaml.MarkedYAMLError(problem=f"the key {name!r} appears twice", problem_mark=key.start_mark)
            seen.add(name)
        return super().construct_mapping(node, deep)

    def construct_int(self, node: Any) -> int | float:
        return _whole(self.construct_scalar(node))


for _tag, _pattern, _first in (
    ("tag:yaml.org,2002:bool", _BOOL, "tTfF"),
    ("tag:yaml.org,2002:int", _INT, "-+0123456789"),
    ("tag:yaml.org,2002:float", _FLOAT, "-+.0123456789"),
    ("tag:yaml.org,2002:null", _NULL, ["~", "n", "N", ""]),
):
    _Loader.add_implicit_resolver(_tag, _pattern, list(_first))
_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.construct_int)


def parse_yaml(text: str, source: str, largest: float = math.inf) -> Any:
    """Return the data in YAML (or JSON) text.

    Parameters
    ----------
    text : str
    source : str
        Name of the file, for messages.
    largest : float
        Number of characters of YAML that are read; JSON takes a hundredth of the time, and may be longer.

    Raises
    ------
    InvalidInputError
        If it is not YAML, asks for anything beyond plain data, repeats a key or uses aliases, or is too long.
    """
    remedy = "write plain YAML or JSON data"
    if text.lstrip()[:1] == "{":
        try:
            return json.loads(text, parse_constant=_only_yaml, parse_int=_whole, object_pairs_hook=_unique)
        except (ValueError, RecursionError):  # by YAML's reader, whose messages say where
            pass
    if len(text) > largest:
        advice = "write it as JSON, or keep long lists of points in a file of their own, path kind file"
        raise InvalidInputError("", f"is YAML of more than {largest} characters", advice, source=source)
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = " ".join(str(error.problem or error.context or "it cannot be parsed").split())
        raise InvalidInputError("", f"is not plain YAML: {problem}{where}", remedy, source=source) from None
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())[:120]
        raise InvalidInputError("", f"is not YAML: {reason}", remedy, source=source) from None
    except RecursionError:
        raise InvalidInputError("", "is nested too deeply", remedy, source=source) from None
    except (ValueError, OverflowError) as error:
        raise InvalidInputError("", f"holds a value that cannot be read ({error})", remedy, source=source) from None


_LINE = 100  # what is longer than this is not written on one line
_FOR_PEOPLE = 500_000  # what is longer than this nobody reads, and YAML takes long to write


class _Dumper(yaml.SafeDumper):
    """Writes what `_Loader` reads back: text in quotes where that would take it for a number."""

    yaml_implicit_resolvers = _Loader.yaml_implicit_resolvers

    def ignore_aliases(self, data: Any) -> bool:
        return True


def yaml_text(data: dict[str, Any]) -> str:
    """Return plain data as YAML for people: a line per field, short lists and mappings on one line.

    Parameters
    ----------
    data : dict
        Of what JSON knows.

    Returns
    -------
    str
        :func:`parse_yaml` makes the same data of it.

    Raises
    ------
    InvalidInputError
        If it holds anything else.
    """
    try:
        if len(json.dumps(data)) > _FOR_PEOPLE:
            return _as_json(data)
        for readable in (True, False):  # letters of all scripts as they are, unless YAML reads some of them otherwise
            text = _dumped(data, readable)
            if parse_yaml(text, "") == data:
                return text
    except (yaml.YAMLError, InvalidInputError, RecursionError, TypeError, ValueError):
        pass
    return _as_json(data)


def _as_json(data: dict[str, Any]) -> str:
    """Return data as JSON, which is YAML as well, a line per field."""
    try:
        lines = [f"  {json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in data.items()]
    except (TypeError, ValueError, RecursionError) as error:
        raise InvalidInputError("problem", f"is not plain data: {error}", "give what JSON knows") from None
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _dumped(data: dict[str, Any], readable: bool) -> str:
    dumper = _Dumper(StringIO(), sort_keys=False)
    root: Any = dumper.represent_data(data)
    root.flow_style = not data
    for _, value in root.value:
        _laid_out(value)
    return str(yaml.serialize(root, Dumper=_Dumper, width=math.inf, allow_unicode=readable))


def _laid_out(node: Any) -> int:
    """Write a node on one line if that is short, else its parts each on its own; return about how long it is."""
    if isinstance(node, yaml.ScalarNode):
        return len(node.value)
    parts = [part for item in node.value for part in (item if isinstance(item, tuple) else (item,))]
    length = sum(_laid_out(part) + 2 for part in parts)
    node.flow_style = length <= _LINE
    return length
