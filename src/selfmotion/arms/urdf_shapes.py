"""The collision shapes of URDF links as capsules that hold them: spheres, cylinders, boxes and capsules.

``<disable_collisions link1="…" link2="…"/>``, which SRDF has, is read in the URDF itself. Whatever is wrong with a
shape is kept with its link and said when somebody asks for shapes: arms without obstacles do not need them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from selfmotion._checks import positive
from selfmotion._types import FloatArray
from selfmotion.arms.shapes import Capsule, Shapes, without_hidden
from selfmotion.arms.urdf_numbers import written_numbers, written_pose
from selfmotion.errors import InvalidInputError

_SIZES = {"sphere": ("radius",), "cylinder": ("radius", "length"), "capsule": ("radius", "length"), "box": ("size",)}
"""What the shapes are measured by; a box by three numbers in one attribute."""
_MESH = "has a mesh, which is not read"
_MOST_STRIPS = 4  # capsules of one box
_SAME = 1e-9  # [m]


class Placed(NamedTuple):
    """Where a link is: the number of a frame, see :class:`~selfmotion.arms.shapes.Capsule`, and its pose in it."""

    frame: int
    pose: FloatArray


class _Shape(NamedTuple):
    """A collision shape: its kind, the pose of its middle in the frame of the capsules, and its sizes."""

    kind: str
    pose: FloatArray
    size: list[float]


def shapes_of(robot: ElementTree.Element, places: Mapping[str, Placed], lost: Mapping[str, str]) -> Shapes:
    """Return the shapes of a robot's links.

    Parameters
    ----------
    robot : element
        The ``<robot>``.
    places : mapping
        Where the links are that move with the chain.
    lost : mapping
        Links that do so too, but nobody knows where, and why.
    """
    capsules: list[Capsule] = []
    unread: dict[str, str] = {}
    loose: list[str] = []
    for link in robot.findall("link"):
        name = link.get("name", "")
        if link.find("collision") is None:
            continue
        if name in lost:
            unread[name] = lost[name]
        elif name not in places:
            loose.append(name)
        else:
            found, why = _capsules(name, link, places[name])
            capsules += found
            if why is not None:
                unread[name] = why
    apart = [(pair.get("link1", ""), pair.get("link2", "")) for pair in robot.findall("disable_collisions")]
    return Shapes(tuple(capsules), unread, tuple(loose), tuple(apart))


def _capsules(name: str, link: ElementTree.Element, place: Placed) -> tuple[tuple[Capsule, ...], str | None]:
    """Return the capsules that hold the collision shapes of a link, and why some are not read."""
    shapes, why = [], None
    for collision in link.findall("collision"):
        try:
            shape = _shape(name, collision)
        except InvalidInputError as error:
            why = why or f"has a collision shape that is not read: {error}"
            continue
        if shape is None:
            why = why or _MESH
        else:
            shapes.append(shape._replace(pose=place.pose @ shape.pose))
    balls = [(shape.pose[:3, 3], shape.size[0]) for shape in shapes if shape.kind == "sphere"]
    found = [part for shape in shapes for part in _HELD_BY[shape.kind](shape, balls)]
    return without_hidden(Capsule(name, place.frame, ends, radius) for ends, radius in found), why


def _shape(link: str, collision: ElementTree.Element) -> _Shape | None:
    """Return a ``<collision>`` element, sizes being positive; None for a mesh."""
    field = f"urdf.{link[:60]}.collision"
    geometry = collision.find("geometry")
    given = [] if geometry is None else list(geometry)
    if len(given) != 1:
        raise InvalidInputError(field, f"has {len(given)} shapes", "write one inside of <geometry>")
    kind = given[0].tag
    if kind == "mesh":
        return None
    if kind not in _SIZES:
        raise InvalidInputError(field, f"has the unknown shape {kind[:60]!r}", f"write one of {', '.join(_SIZES)}")
    count = 3 if kind == "box" else 1
    size = [
        positive(f"{field}.{name}", value)
        for name in _SIZES[kind]
        for value in written_numbers(f"{field}.{name}", given[0], name, count)
    ]
    return _Shape(kind, written_pose(f"{field}.origin", collision), size)


Balls = Sequence[tuple[FloatArray, float]]
Part = tuple[FloatArray, float]
"""Ends (2, 3) and radius of a capsule."""


def _sphere(shape: _Shape, balls: Balls) -> Iterable[Part]:
    return [_ball(shape.pose[:3, 3], shape.size[0])]


def _capsule(shape: _Shape, balls: Balls) -> Iterable[Part]:
    middle, half = shape.pose[:3, 3], 0.5 * shape.size[1] * shape.pose[:3, 2]
    return [(np.array([middle - half, middle + half]), shape.size[0])]


def _cylinder(shape: _Shape, balls: Balls) -> Iterable[Part]:
    """Hold a cylinder. With a ball at either end it is a capsule, written for those who know none."""
    radius, length = shape.size
    ((ends, _),) = _capsule(shape, balls)

    def rounded(end: FloatArray) -> bool:
        return any(np.abs(center - end).max() <= _SAME and abs(size - radius) <= _SAME for center, size in balls)

    whole = (ends, radius)
    if all(rounded(end) for end in ends):
        return [whole]
    return [_smaller(whole, _ball(shape.pose[:3, 3], float(np.hypot(radius, 0.5 * length))))]


def _box(shape: _Shape, balls: Balls) -> Iterable[Part]:
    """Hold a box by capsules side by side along its longest edges, more of them the flatter it is."""
    order = np.argsort(shape.size, kind="stable")[::-1]
    a, b, c = 0.5 * np.array(shape.size)[order]
    along, aside = a * shape.pose[:3, order[0]], b * shape.pose[:3, order[1]]
    strips = int(np.clip(np.rint(b / c), 1, _MOST_STRIPS))
    for k in range(strips):
        middle = shape.pose[:3, 3] + ((2 * k + 1) / strips - 1.0) * aside
        whole = (np.array([middle - along, middle + along]), float(np.hypot(b / strips, c)))
        yield _smaller(whole, _ball(middle, float(np.sqrt(a**2 + (b / strips) ** 2 + c**2))))


def _ball(middle: FloatArray, radius: float) -> Part:
    return np.array([middle, middle]), radius


def _smaller(one: Part, other: Part) -> Part:
    """Return that of two capsules which has less in it."""
    return min(one, other, key=lambda part: Capsule("", 0, *part).volume)


_HELD_BY = {"sphere": _sphere, "cylinder": _cylinder, "capsule": _capsule, "box": _box}
