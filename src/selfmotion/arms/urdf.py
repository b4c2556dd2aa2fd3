"""Arms from URDF files: the chain of joints from one link to another, and the collision shapes of what it moves.

URDF: the robot description format of ROS, its joints said by origin (xyz, and rpy as fixed-axis roll, pitch, yaw), axis
and limits. Meshes, masses, transmissions and all joints off the chain are passed over.
"""

from __future__ import annotations

import os
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from selfmotion._checks import finite_array, is_file_name
from selfmotion._types import FloatArray
from selfmotion.arms.chain import Chain, turn_from_z, turned_to_z
from selfmotion.arms.shapes import BASE, Shapes
from selfmotion.arms.urdf_numbers import written_number, written_numbers, written_pose
from selfmotion.arms.urdf_shapes import Placed, shapes_of
from selfmotion.errors import InvalidInputError

MAX_SIZE = 10_000_000
"""Largest size of a file [bytes]."""

_MOVING = ("revolute", "continuous", "prismatic")
_REFUSED = ("floating", "planar")
_ALIKE = 0.75  # similarity of a misspelt name
_READ: dict[str, dict[str, tuple[str, ...]]] = {
    "robot": {"link": ("name",), "joint": ("type",)},
    "joint": {
        "parent": ("link",),
        "child": ("link",),
        "origin": ("xyz", "rpy"),
        "axis": ("xyz",),
        "limit": ("lower", "upper", "velocity", "effort"),
        "mimic": ("joint",),
    },
}
"""Elements that are read inside of others, and their attributes."""
_SHOWN = 8  # names that a message lists before it says how many more there are


class _Joint(NamedTuple):
    """One <joint> element, its name, and the links it joins."""

    name: str
    kind: str
    parent: str
    child: str
    element: ElementTree.Element

    def field(self, what: str = "") -> str:
        """Return the name of one of its fields in messages."""
        return _field(self.name, what)


def load_chain(file: str | os.PathLike[str], base: str | None = None, tip: str | None = None) -> Chain:
    """Read the chain between two links of a URDF file.

    Parameters
    ----------
    file : path
        A UTF-8 file of at most 10 MB.
    base, tip : str, optional
        As for :func:`read_chain`.

    Returns
    -------
    Chain

    Raises
    ------
    InvalidInputError
        If the file cannot be read, or :func:`read_chain` refuses it.
    """
    source = os.fspath(file)
    try:
        return read_chain(_text(Path(file)), base, tip)
    except InvalidInputError as error:
        raise error.inside(source=source) from None


def read_chain(text: str, base: str | None = None, tip: str | None = None) -> Chain:
    """Read the chain between two links of a URDF robot.

    Parameters
    ----------
    text : str
        The URDF, at most 10 MB; xacro templates must have been expanded.
    base : str, optional
        The link that the chain starts from; the root link by default.
    tip : str, optional
        The link that it ends in, below `base`; the only leaf by default.

    Returns
    -------
    Chain
        Its joints are the revolute, continuous and prismatic ones on the way; fixed ones are part of the offsets.

    Raises
    ------
    InvalidInputError
        If the text is not such a robot; if its links do not form a tree; if base or tip is unknown or must be told;
        if a joint on the way mimics another, floats or moves in a plane, has no limits or wrong ones, or no axis.
        The field of the error is ``urdf.<joint>.<element>``.
    """
    if not isinstance(text, str):
        raise InvalidInputError("urdf", "is not text", "give the file's text", text)
    robot = _parsed(text)
    links, joints = _tree(robot)
    above = _above(links, joints)
    start, end = _ends(links, joints, above, base, tip)
    way = _way(above, start, end)
    chain = _chain(way, start, end)
    return chain.with_shapes(_shapes(robot, joints, way, start))


def _text(path: Path) -> str:
    """Return the text of a file."""
    if not is_file_name(str(path)):
        raise InvalidInputError("", "is no name of a file", "name one")
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_SIZE + 1)
    except FileNotFoundError:
        raise InvalidInputError("", "does not exist", "check the name") from None
    except IsADirectoryError:
        raise InvalidInputError("", "is a folder", "name a file") from None
    except OSError as error:
        raise InvalidInputError("", f"cannot be read ({error.strerror or error})", "check the file") from None
    if len(raw) > MAX_SIZE:
        raise _too_large()
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInputError("", "is not a UTF-8 text file", "is it the right file?") from None


def _too_large() -> InvalidInputError:
    return InvalidInputError("urdf", f"is larger than {MAX_SIZE // 10**6} MB", "is it the right file?")


class _NoDoctype(ElementTree.TreeBuilder):
    """Builds the tree, and refuses a DOCTYPE as soon as one starts: nothing in it is ever expanded or fetched."""

    def doctype(self, *_: str | None) -> None:
        raise InvalidInputError("urdf", "has a DOCTYPE", "remove it: entities are not read")


def _parsed(text: str) -> ElementTree.Element:
    """Return the <robot> element."""
    try:
        size = len(text.encode())
    except UnicodeEncodeError:
        raise InvalidInputError("urdf", "holds characters that are none", "give UTF-8 text") from None
    if size > MAX_SIZE:
        raise _too_large()
    parser = ElementTree.XMLParser(target=_NoDoctype())
    try:
        parser.feed(text)
        robot: ElementTree.Element = parser.close()
    except ElementTree.ParseError as error:
        line = error.position[0]
        why = f"is not well-formed XML (line {line}: {str(error).partition(':')[0]})"
        raise InvalidInputError("urdf", why, "mend that line") from None
    # Some files give the whole robot a namespace of its own, which means nothing here.
    namespace, _, tag = robot.tag.rpartition("}")
    if tag != "robot":
        raise InvalidInputError("urdf", f"is not a robot: its root element is <{tag[:60]}>", "give a URDF file")
    if namespace:
        for element in robot.iter():
            element.tag = element.tag.removeprefix(f"{namespace}}}")
    if any("xacro" in child.tag.partition("}")[0] for child in robot):
        raise InvalidInputError("urdf", "is a xacro template", "expand it with xacro first")
    return robot


def _tree(robot: ElementTree.Element) -> tuple[list[str], list[_Joint]]:
    """Return the names of all links and all joints, each of which joins two links there are."""
    _check_spelling(robot)
    links = [_attribute(link, "name", "urdf", "a link") for link in robot.findall("link")]
    twice = _first_twice(links)
    if twice is not None:
        raise InvalidInputError("urdf", f"has two links named {twice!r}", "give every link its own name")
    if not links:
        raise InvalidInputError("urdf", "has no links", "give a URDF with <link> and <joint> elements")
    joints, known = [], set(links)
    for element in robot.findall("joint"):
        _check_spelling(element)
        name = _attribute(element, "name", "urdf", "a joint")
        ends = []
        for side in ("parent", "child"):
            where = _field(name, side)
            end = element.find(side)
            if end is None:
                raise InvalidInputError(where, "is missing", f'write <{side} link="…"/>')
            link = _attribute(end, "link", where, "it")
            if link not in known:
                raise InvalidInputError(where, "is not a link of this robot", _near(link, links), link)
            ends.append(link)
        joints.append(_Joint(name, element.get("type", ""), ends[0], ends[1], element))
    twice = _first_twice([joint.name for joint in joints])
    if twice is not None:
        raise InvalidInputError(_field(twice), "is the name of two joints", "give every joint its own name")
    return links, joints


def _check_spelling(element: ElementTree.Element) -> None:
    """Refuse what is nearly the name of an element that is read; vendors' own elements are passed over."""
    known = _READ[element.tag]
    for child in element:
        if child.tag in known or "}" in child.tag:
            continue
        near = get_close_matches(child.tag[:60].lower(), known, 1, _ALIKE)
        # What has none of that element's attributes is no misspelt one.
        if near and any(child.get(name) is not None for name in known[near[0]]):
            name = child.get("name") if element.tag == "robot" else element.get("name")
            where = f"<{child.tag[:60]}> of {(name or '')[:60]!r}"
            why = f"has an unknown element {where}, which would not be read"
            raise InvalidInputError("urdf", why, f"did you mean <{near[0]}>?")


def _above(links: list[str], joints: list[_Joint]) -> dict[str, _Joint]:
    """Return the joint above every link but the roots, having made sure that the links form trees."""
    above: dict[str, _Joint] = {}
    for joint in joints:
        other = above.setdefault(joint.child, joint)
        if other is not joint:
            why = f"closes a chain: link {joint.child!r} has two parents, by joints {other.name!r} and {joint.name!r}"
            raise InvalidInputError(joint.field("child"), why, "only open chains are read: cut one of the two")
    rooted: set[str] = set()
    for link in links:
        way: dict[str, None] = {}
        here = link
        while here in above and here not in rooted:
            if here in way:
                why = f"is part of a loop: link {here!r} is below itself"
                raise InvalidInputError(above[here].field(), why, "only open chains are read: cut the loop")
            way[here] = None
            here = above[here].parent
        rooted.update(way)
    return above


def _ends(
    links: list[str], joints: list[_Joint], above: dict[str, _Joint], base: str | None, tip: str | None
) -> tuple[str, str]:
    """Return the links that the chain starts from and ends in."""
    inner = {joint.parent for joint in joints}
    leaves = [link for link in links if link not in inner]
    for field, given in (("base", base), ("tip", tip)):
        if given is not None and given not in links:
            remedy = f"{_near(given, links)}; the tips are {_listed(leaves)}"
            raise InvalidInputError(field, "is not a link of this robot", remedy, given)
    start = base
    if start is None:
        roots = [link for link in links if link not in above]
        if len(roots) > 1 and tip is not None:
            roots = [_ancestors(above, tip)[-1]]
        if len(roots) > 1:
            raise InvalidInputError("base", "is not told, and there are several roots", f"give one of {_listed(roots)}")
        start = roots[0]
    if tip is not None:
        return start, tip
    below = _tips_below(joints, start)
    if not below:
        raise InvalidInputError("base", "has no link below it", "start further up", start)
    if len(below) > 1:
        raise InvalidInputError("tip", "is not told, and the chain branches", f"give tip, such as {_listed(below)}")
    return start, below[0]


def _tips_below(joints: list[_Joint], base: str) -> list[str]:
    """Return the leaves below a link, in the order of a walk through the tree."""
    children: dict[str, list[str]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint.child)
    tips, pending = [], [base]
    while pending:
        below = children.get(pending.pop(), [])
        tips += [link for link in below if link not in children]
        pending += reversed(below)
    return tips


def _ancestors(above: dict[str, _Joint], link: str) -> list[str]:
    """Return `link` and all links above it, the root last."""
    way = [link]
    while way[-1] in above:
        way.append(above[way[-1]].parent)
    return way


def _way(above: dict[str, _Joint], base: str, tip: str) -> list[_Joint]:
    """Return the joints from `base` down to `tip`."""
    links = _ancestors(above, tip)
    if base not in links:
        roots = [_ancestors(above, base)[-1], links[-1]]
        if roots[0] != roots[1]:
            why = f"is not connected with {base!r}: the robot has several roots, {roots[0]!r} above {base!r}"
            remedy = f"add the joint that is missing, or start from one of {_listed(links[1:]) or 'its own links'}"
            raise InvalidInputError("tip", f"{why} and {roots[1]!r} above the tip", remedy, tip)
        why = f"is not below {base!r}"
        raise InvalidInputError("tip", why, f"start from one of {_listed(links[1:]) or 'its own links'}", tip)
    return [above[link] for link in links[: links.index(base)]][::-1]


def _chain(way: list[_Joint], base: str, tip: str) -> Chain:
    """Return the chain of the joints on the way, fixed ones merged into the offsets."""
    names, origins, axes, kinds = [], [], [], []
    limits: list[tuple[float, float] | None] = []
    speeds = []
    pose = np.eye(4)
    for joint in way:
        _check_kind(joint)
        pose = pose @ written_pose(joint.field("origin"), joint.element)
        if joint.kind == "fixed":
            continue
        names.append(joint.name)
        origins.append(pose)
        axes.append(_axis(joint))
        kinds.append(joint.kind == "prismatic")
        limits.append(_limits(joint))
        speeds.append(_speed(joint))
        pose = np.eye(4)
    if not names:
        raise InvalidInputError("tip", f"moves with {base!r}: no joint between them can turn", "name other links", tip)
    return Chain(names, turned_to_z([*origins, pose], axes), limits, kinds, speeds, base, tip)


def _shapes(robot: ElementTree.Element, joints: list[_Joint], way: list[_Joint], base: str) -> Shapes:
    """Return the shapes of all links that move with one on the way."""
    moving = [joint.name for joint in way if joint.kind != "fixed"]
    near: dict[str, list[_Joint]] = {}
    for joint in joints:
        near.setdefault(joint.parent, []).append(joint)
        near.setdefault(joint.child, []).append(joint)
    places, lost = {base: Placed(BASE, np.eye(4))}, {}
    pending = [base]
    while pending:
        link = pending.pop()
        here = places[link]
        for joint in near.get(link, []):
            other = joint.parent if joint.child == link else joint.child
            if other in places:
                continue
            if joint.kind == "fixed":
                try:
                    step = written_pose(joint.field("origin"), joint.element)
                except InvalidInputError as error:  # of a joint off the way, which arms without obstacles do not need
                    lost[other] = f"hangs on a joint that is not read: {error}"
                    continue
                places[other] = Placed(here.frame, here.pose @ (step if joint.parent == link else np.linalg.inv(step)))
            elif joint.name in moving and joint.parent == link:
                places[other] = Placed(moving.index(joint.name), turn_from_z(_axis(joint)).T)
            else:
                continue
            pending.append(other)
    return shapes_of(robot, places, lost)


def _check_kind(joint: _Joint) -> None:
    """Refuse a joint that is no link in a chain of independent one-axis joints."""
    if joint.kind in _REFUSED:
        why = f"is a {joint.kind} joint, which has more than one axis"
        raise InvalidInputError(joint.field("type"), why, "name a base and tip between which there is none")
    if joint.kind not in (*_MOVING, "fixed"):
        known = ", ".join((*_MOVING, "fixed"))
        raise InvalidInputError(joint.field("type"), "is not known", f"write one of {known}", joint.kind)
    mimic = joint.element.find("mimic")
    if mimic is not None and joint.kind != "fixed":
        why = f"follows joint {mimic.get('joint', '')[:60]!r} and cannot move by itself"
        raise InvalidInputError(joint.field("mimic"), why, "name a base and tip between which there is none")


def _axis(joint: _Joint) -> FloatArray:
    """Return the joint's axis, x if none is written, as URDF has it."""
    element = joint.element.find("axis")
    if element is None:
        return np.array([1.0, 0.0, 0.0])
    where = joint.field("axis.xyz")
    axis = finite_array(where, written_numbers(where, element, "xyz", 3, "1 0 0"), 1, 3)
    if not axis.any():
        raise InvalidInputError(where, "is zero", "give the direction of the joint's axis")
    return axis


def _limits(joint: _Joint) -> tuple[float, float] | None:
    """Return the lower and upper limit of a joint; None if it turns freely."""
    if joint.kind == "continuous":
        return None
    element = joint.element.find("limit")
    ends = (None, None) if element is None else (element.get("lower"), element.get("upper"))
    if ends[0] is None or ends[1] is None:
        missing = " and ".join(side for side, end in zip(("lower", "upper"), ends, strict=True) if end is None)
        remedy = f"write {missing} into its <limit>"
        if joint.kind == "revolute":
            remedy += ", or write continuous if it turns freely"
        raise InvalidInputError(joint.field("limit"), "has no limits", remedy)
    lower = written_number(joint.field("limit.lower"), ends[0])
    upper = written_number(joint.field("limit.upper"), ends[1])
    if lower > upper:
        raise InvalidInputError(joint.field("limit"), "is reversed", "lower must not exceed upper", [lower, upper])
    return lower, upper


def _speed(joint: _Joint) -> float:
    """Return the maximal speed of a joint, infinite if none is written."""
    element = joint.element.find("limit")
    text = None if element is None else element.get("velocity")
    if text is None:
        return np.inf
    speed = written_number(joint.field("limit.velocity"), text)
    if not speed > 0:
        remedy = "give the maximal speed, or leave velocity out if there is none"
        raise InvalidInputError(joint.field("limit.velocity"), "must be greater than zero", remedy, speed)
    return speed


def _attribute(element: ElementTree.Element, name: str, field: str, what: str) -> str:
    """Return an attribute that must be there and not be empty."""
    value = element.get(name)
    if not value:
        raise InvalidInputError(
            field, f"is wrong: {what} has no {name}", f'write {name}="…" into every <{element.tag}>'
        )
    return value


def _field(joint: str, what: str = "") -> str:
    """Return the name of a joint's field in messages."""
    return ".".join(part for part in ("urdf", joint[:60], what) if part)


def _first_twice(names: list[str]) -> str | None:
    """Return the first name that was there before."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None


def _near(name: object, links: list[str]) -> str:
    """Return advice on a link's name that is not known."""
    # Thousands of names would take the comparison minutes.
    near = get_close_matches(str(name)[:100], links[:2000], 3)
    return f"did you mean {_listed(near)}?" if near else f"the links are {_listed(links)}"


def _listed(names: list[str]) -> str:
    """Return names in a row, the first few if there are many."""
    shown = ", ".join(name[:60] for name in names[:_SHOWN])
    more = len(names) - _SHOWN
    return f"{shown} and {more} more" if more > 0 else shown
