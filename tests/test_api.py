"""The API reference is complete: every public name is in it, and says what it takes, returns and raises, with shapes.

What is public is what docs/api.md shows; what packages export beyond that is for the house, and says shapes only.
"""

import ast
import importlib
import inspect
import re
import textwrap
from functools import cache
from pathlib import Path

import pytest
from numpydoc.validate import get_doc_object, validate

import selfmotion as sm
from selfmotion import plot

DIRECTIVES = re.findall(
    r"^\.\. auto(\w+):: (\S+)", (Path(__file__).parents[1] / "docs" / "api.md").read_text(encoding="utf-8"), re.M
)
# No docstring, parameters that are not there, out of order or without a type, nothing said of what comes back.
HELD = {"GL08", "PR02", "PR03", "PR04", "RT01", "YD01"}
ARRAY = re.compile(r"Array|\b(Vector|Points?|Positions?|Direction|Rotations?|Poses)\b")
SHAPE = re.compile(r"\bshapes?\b|\([^()]*, ?[^()]*\)|:class:`|scalar")
UNIT = re.compile(r"\[[^]]*(rad|/s)")
MOVING = {"dq", "ddq", "velocity", "acceleration", "max_velocity", "max_acceleration"}


def found(name):
    """Return what a dotted name stands for; where a function hides the module of its name, what is in the module."""
    thing, parts = importlib.import_module("selfmotion"), name.split(".")[1:]
    for k, part in enumerate(parts):
        if k < len(parts) - 1 and not inspect.isclass(thing):
            thing = importlib.import_module(f"{thing.__name__}.{part}")
        else:
            thing = getattr(thing, part, None) or importlib.import_module(f"{thing.__name__}.{part}")
    return thing


def documentable(things):
    """Return classes and functions of the package by the name of their home."""
    return {
        f"{thing.__module__}.{thing.__qualname__}": thing
        for thing in things
        if (inspect.isclass(thing) or inspect.isfunction(thing)) and thing.__module__.startswith("selfmotion")
    }


def shown():
    """Return every class and function of docs/api.md."""
    for directive, name in DIRECTIVES:
        thing = found(name)
        if directive == "module":
            own = (value for key, value in vars(thing).items() if not key.startswith("_"))
            yield from (value for value in own if getattr(value, "__module__", None) == name)
        else:
            yield thing


def exported():
    """Return what the packages of docs/api.md export."""
    for name in sorted({name.split(".")[1] for _, name in DIRECTIVES if name.count(".") > 1}):
        package = importlib.import_module(f"selfmotion.{name}")
        yield from (getattr(package, key) for key in getattr(package, "__all__", ()))


PUBLIC = documentable(shown())
OTHERS = {name: thing for name, thing in documentable(exported()).items() if name not in PUBLIC}


@pytest.mark.parametrize("package", [sm, plot], ids=lambda package: package.__name__)
def test_every_exported_name_is_in_the_reference(package):
    names = documentable(getattr(package, name) for name in package.__all__)
    assert sorted(set(names) - set(PUBLIC)) == []


@cache
def said(thing):
    """Return what a docstring says of each parameter and attribute, by name, and of what comes back."""
    sections = get_doc_object(thing)
    entries = [entry for title in ("Attributes", "Parameters") for entry in sections[title]]
    texts = {
        name.strip().lstrip("*"): f"{entry.type} {' '.join(entry.desc)}"
        for entry in entries
        for name in entry.name.split(",")
    }
    texts["return"] = " ".join(f"{entry.type} {' '.join(entry.desc)}" for entry in sections["Returns"])
    return texts


def is_elsewhere(text):
    return text.strip().startswith("See :class:")


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_a_public_name_says_what_it_takes_and_returns(name):
    thing = PUBLIC[name]
    texts, wrong = said(thing), []
    known = set(texts) | ({"args", "kwargs"} if getattr(thing, "_is_protocol", False) else set())
    for code, message in validate(get_doc_object(thing))["errors"]:
        quoted = set(re.findall(r"""['"]\**(\w+)['"]""", message))
        if code == "PR01" and "options" not in texts:  # which stand for the options of all readers of drawings
            wrong += sorted(quoted - known)
        elif code in HELD and quoted != {"options"} and not any(is_elsewhere(texts.get(word, "")) for word in quoted):
            wrong.append(message)
    assert wrong == []


@pytest.mark.parametrize("name", sorted(PUBLIC | OTHERS))
def test_arrays_have_shapes_and_velocities_units(name):
    thing = (PUBLIC | OTHERS)[name]
    maker = vars(thing).get("__init__", thing) if inspect.isclass(thing) else thing
    summary, texts, wrong = inspect.getdoc(thing), said(thing), []
    assert summary
    for field, annotation in inspect.get_annotations(maker).items():
        text = texts.get(field) or summary
        if ARRAY.search(str(annotation)) and not field.startswith("_") and not is_elsewhere(text):
            wrong += [f"no shape of {field}"] if not SHAPE.search(text) else []
            wrong += [f"no unit of {field}"] if field in MOVING and not UNIT.search(text) else []
    assert wrong == []


def bodies(thing):
    """Return the syntax trees of what runs when a class or function is called."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(thing))).body
    if not inspect.isclass(thing):
        return [tree]
    return [part for part in tree.body if getattr(part, "name", "") in ("__init__", "__post_init__")]


def raised(thing):
    """Return the errors that a function raises itself, or a check of the input that it calls."""
    names = vars(importlib.import_module(thing.__module__))
    for node in (node for tree in bodies(thing) for node in ast.walk(tree)):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and isinstance(node.exc.func, ast.Name):
            yield node.exc.func.id
        called = names.get(node.func.id) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else None
        if getattr(called, "__module__", "") == "selfmotion._checks":
            yield "InvalidInputError"


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_a_public_name_says_what_it_raises(name):
    says = {entry.type for entry in get_doc_object(PUBLIC[name])["Raises"]}
    assert set(raised(PUBLIC[name])) - says == set()
