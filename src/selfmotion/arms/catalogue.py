"""Arms by name, from the files in ``arms/data``, and arms from anyone's URDF file.

A new arm is one file and one line in `CATALOGUE`. Importing this compiles nothing: closed forms are loaded when used.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from selfmotion._checks import choice, finite_array
from selfmotion._types import FileName, FloatArray, Limits, Rail, ToolFrame
from selfmotion.arms.chain import Chain
from selfmotion.arms.protocols import RedundantArm
from selfmotion.arms.urdf import load_chain, read_chain
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import from_rotation_matrix, from_rpy, matrix, unit_quaternions

if TYPE_CHECKING:
    from selfmotion.arms.locked import LockedArm
    from selfmotion.arms.rail import RailArm
    from selfmotion.arms.spatial import SpatialArm

_POSE = 6  # joints that a pose takes; without its roll one of them is redundant
_TURNS = ("quaternion", "matrix", "rpy")
F = TypeVar("F", bound=Callable[..., object])


class Entry(NamedTuple):
    """An arm of the catalogue.

    Attributes
    ----------
    title, maker : str
    file : str
        In ``arms/data``; its header says what it was checked against.
    base, tip : str
        Frames at both ends; the tip is the tool frame of paths, unless a tool is added.
    source : str
        Where its numbers are from.
    """

    title: str
    maker: str
    file: str
    base: str
    tip: str
    source: str

    def chain(self) -> Chain:
        """Return its joints, frames and limits."""
        return read_chain((files(__package__) / "data" / self.file).read_text("utf-8"), self.base, self.tip)


CATALOGUE: dict[str, Entry] = {
    "panda": Entry(
        "Panda", "Franka Emika", "panda.urdf", "panda_link0", "panda_hand",
        "Denavit-Hartenberg table and limits published by the maker (franka_description)",
    ),
    "fr3": Entry(
        "Research 3", "Franka Robotics", "fr3.urdf", "fr3_link0", "fr3_hand",
        "the Panda's Denavit-Hartenberg table, limits of franka_description",
    ),
    "iiwa7": Entry(
        "LBR iiwa 7 R800", "KUKA", "iiwa7.urdf", "link_0", "link_ee",
        "distances published by the maker, ranges of iiwa_stack",
    ),
    "iiwa14": Entry(
        "LBR iiwa 14 R820", "KUKA", "iiwa14.urdf", "link_0", "link_ee",
        "distances published by the maker, ranges of lbr_fri_ros2_stack",
    ),
    "ur5e": Entry(
        "UR5e", "Universal Robots", "ur5e.urdf", "base_link", "tool0",
        "Denavit-Hartenberg table published by the maker, ranges of its ROS 2 description",
    ),
    "ur10e": Entry(
        "UR10e", "Universal Robots", "ur10e.urdf", "base_link", "tool0",
        "Denavit-Hartenberg table published by the maker, ranges of its ROS 2 description",
    ),
    "irb120": Entry(
        "IRB 120-3/0.6", "ABB", "irb120.urdf", "base_link", "tool0", "abb_experimental",
    ),
    "kr6r900": Entry(
        "KR 6 R900 sixx", "KUKA", "kr6r900.urdf", "base_link", "tool0", "kuka_experimental",
    ),
}  # fmt: skip
"""Every arm that a problem file can name, by that name."""


def _of_kind(kind: str) -> Callable[[F], F]:
    """Give a constructor the ``kind`` by which problem files name it, as the classes of other parts have one."""

    def marked(function: F) -> F:
        vars(function)["kind"] = kind
        return function

    return marked


@_of_kind("named")
def named_arm(name: str, tool: ToolFrame = None, limits: Limits = None, rail: Rail = None) -> RedundantArm:
    """An arm of the catalogue, which ``selfmotion arms`` lists.

    Parameters
    ----------
    name : str
        Such as ``panda``; its tool frame is the catalogue's tip, for the Panda ``panda_hand``: 0.107 m beyond the last
        joint's frame and turned by −45° about z.
    tool : mapping, optional
        The tool's frame in the tip's: ``translation`` [m] and one of ``quaternion`` (w, x, y, z), ``matrix`` and
        ``rpy`` (roll, pitch, yaw about the fixed x-, y-, z-axis [rad]).
    limits : sequence, optional
        Per joint ``None`` (free) or ``(lower, upper)`` [rad], instead of the catalogue's.
    rail : mapping, optional
        What the base of an arm with six joints slides on, the tool keeping its whole pose: ``axis``, its direction in
        the base's frame, and ``limits``, from where to where [m]. It becomes joint 1; its weight in objectives is in
        rad/m: how many radians of other joints a metre is worth, 1 by default.

    Returns
    -------
    RedundantArm
        In closed form if a family of ours has it, else by EAIK with one joint locked.

    Raises
    ------
    InvalidInputError
        If the name is not known, the tool is no frame, limits do not fit, the arm has no redundant joint, or the rail
        has no direction or no ends, or an arm on it that has not six joints.
    """
    entry = CATALOGUE[choice("name", name, CATALOGUE)]
    return _planned("name", _equipped(entry.chain(), tool, limits, rail))


@_of_kind("urdf")
def urdf_arm(
    file: FileName, base: str | None = None, tip: str | None = None, tool: ToolFrame = None, limits: Limits = None,
    rail: Rail = None,
) -> RedundantArm:  # fmt: skip
    """An arm from a URDF file: the joints between two of its links.

    Parameters
    ----------
    file : str
        UTF-8, at most 10 MB; meshes, masses and joints off the way are not looked at.
    base, tip : str, optional
        Names of the links at both ends; by default the root, and the only leaf.
    tool : mapping, optional
        The tool's frame in the tip's: ``translation`` [m] and one of ``quaternion`` (w, x, y, z), ``matrix`` and
        ``rpy`` (roll, pitch, yaw about the fixed x-, y-, z-axis [rad]).
    limits : sequence, optional
        Per joint ``None`` (free) or ``(lower, upper)`` [rad], instead of the file's; [m] for a joint that slides.
    rail : mapping, optional
        What the base of an arm with six joints slides on, the tool keeping its whole pose: ``axis``, its direction in
        the base's frame, and ``limits``, from where to where [m]. It becomes joint 1; its weight in objectives is in
        rad/m: how many radians of other joints a metre is worth, 1 by default.

    Returns
    -------
    RedundantArm
        In closed form if a family of ours has it, else by EAIK with one joint locked.

    Raises
    ------
    InvalidInputError
        If the file cannot be read or is no such robot, the tool is no frame, limits do not fit, nothing solves the
        joints, or the rail has no direction or no ends, or an arm on it that has not six joints.
    """
    try:
        chain = load_chain(file, base, tip)
    except InvalidInputError as error:
        if error.field in ("base", "tip"):
            raise InvalidInputError(error.field, error.reason, error.remedy, error.value) from None
        # The source of what is wrong further out is the problem file.
        where = ", ".join(part for part in (os.fspath(file), error.field) if part)
        raise InvalidInputError("file", f"{where}: {error.reason}", error.remedy, error.value) from None
    return _planned("file", _equipped(chain, tool, limits, rail))


class Solved(NamedTuple):
    """How an arm in space is solved.

    Attributes
    ----------
    joints : int
    parameter : str or None
        What the redundancy parameter u is; None if the arm is not planned for.
    branches : int
        Inverse kinematics' branches at a given u.
    closed_form : bool
        Whether a closed form of ours solves it; else EAIK does, with one joint locked.
    rigorous : bool
        Whether its postures are enclosed with all rounding, so that bounds on every motion are proved, not estimated.
    why_not : str or None
        Why it is not planned for.
    """

    joints: int
    parameter: str | None
    branches: int
    closed_form: bool
    rigorous: bool
    why_not: str | None


def how_solved(name: str) -> Solved:
    """Return how an arm of the catalogue is solved.

    Parameters
    ----------
    name : str
        As in :data:`CATALOGUE`.

    Returns
    -------
    Solved

    Raises
    ------
    InvalidInputError
        If the catalogue has no such arm.
    """
    return _solved(CATALOGUE[choice("name", name, CATALOGUE)].chain())


def how_solved_file(file: FileName, base: str | None = None, tip: str | None = None) -> tuple[Chain, Solved]:
    """Return the chain between two links of a URDF file, see :func:`urdf_arm`, and how it is solved.

    Parameters
    ----------
    file : path-like
    base, tip : str, optional
        As for :func:`~selfmotion.arms.chain.read_chain`.

    Returns
    -------
    tuple of Chain and Solved

    Raises
    ------
    InvalidInputError
        If the file cannot be read, or holds no such chain.
    """
    chain = load_chain(file, base, tip)
    return chain, _solved(chain)


def _solved(chain: Chain) -> Solved:
    try:
        arm = _planned("name", chain)
    except InvalidInputError as error:
        return Solved(chain.n, None, 0, False, False, error.reason)
    return Solved(chain.n, arm.parameter, len(arm.branches), arm.in_closed_form, arm.rigorous, None)


def _planned(field: str, chain: Chain) -> SpatialArm | LockedArm:
    """Return the arm that moves a chain: the one place that knows which chains can be planned for.

    With six joints the tool may turn freely about its z-axis; with seven it keeps its pose. The first of seven may be a
    rail. Seven that turn and are of no family of ours are left to EAIK.
    """
    if chain.n < _POSE:
        raise InvalidInputError(
            field,
            f"has {chain.n} joints, fewer than a position and a direction take besides one that is redundant",
            "give an arm with six joints, whose tool may then roll, or with seven",
        )
    if chain.prismatic.any():
        return _on_rail(field, chain)
    from selfmotion.arms.locked import LockedArm
    from selfmotion.arms.roll import RollArm  # compiled kernels, which planar arms do without
    from selfmotion.arms.spatial import SpatialArm

    try:
        return RollArm(chain) if chain.n == _POSE else SpatialArm(chain)
    except InvalidInputError as error:
        known = error
    if chain.n != _POSE + 1:
        raise InvalidInputError(field, known.reason, known.remedy)
    try:
        return LockedArm(chain)
    except InvalidInputError as error:
        raise InvalidInputError(field, error.reason, f"{error.remedy}, or {known.remedy}") from None


def _on_rail(field: str, chain: Chain) -> RailArm:
    """Return the arm that moves a chain with a joint that slides, if that is a rail under six axes."""
    from selfmotion.arms.rail import RailArm
    from selfmotion.arms.rail_forms import rail_form_of

    if rail_form_of(chain) is None:
        names = ", ".join(name for name, slides in zip(chain.names, chain.prismatic, strict=True) if slides)
        raise InvalidInputError(
            field, f"has joints that slide: {names}",
            "give an arm whose joints all turn, or a rail before six joints with a spherical wrist or like Universal "
            "Robots', or another base or tip",
        )  # fmt: skip
    try:
        return RailArm(chain)
    except InvalidInputError as error:
        raise InvalidInputError(field, error.reason, error.remedy, error.value) from None


def _equipped(chain: Chain, tool: Any, limits: Limits, rail: Any) -> Chain:
    """Return a chain with a tool at its tip, with other limits, and on a rail."""
    if tool is not None:
        chain = chain.with_tool(_transform("tool", tool))
    if limits is not None:
        chain = chain.with_limits(limits)
    return chain if rail is None else _railed(chain, rail)


def _railed(chain: Chain, rail: Any) -> Chain:
    """Return a chain on the rail that a mapping describes."""
    remedy = "write {axis: [0, 1, 0], limits: [-1.0, 1.0]}"
    if not isinstance(rail, Mapping):
        raise InvalidInputError("rail", "is not a mapping", remedy, rail)
    for key in rail:
        if key not in ("axis", "limits"):
            raise InvalidInputError(f"rail.{key}", "is not a known field", remedy)
    for key in ("axis", "limits"):
        if rail.get(key) is None:
            raise InvalidInputError(f"rail.{key}", "is missing", remedy)
    if chain.n != _POSE:
        raise InvalidInputError(
            "rail", f"is under an arm with {chain.n} joints, which would be two redundant degrees or none",
            "give an arm with six joints, or no rail",
        )  # fmt: skip
    name = next(name for name in ("rail", *(f"rail_{k}" for k in range(chain.n + 1))) if name not in chain.names)
    try:
        return chain.on_rail(rail["axis"], rail["limits"], name)
    except InvalidInputError as error:
        raise error.inside("rail") from None


def _transform(field: str, value: Any) -> FloatArray:
    """Return the rigid transform (4, 4) that a mapping describes."""
    remedy = f"write {{translation: […], rpy: […]}}; the fields are translation, {', '.join(_TURNS)}"
    if not isinstance(value, Mapping):
        raise InvalidInputError(field, "is not a mapping", remedy, value)
    given = {key: entry for key, entry in value.items() if entry is not None}
    for key in given:
        if key not in ("translation", *_TURNS):
            raise InvalidInputError(f"{field}.{key}", "is not a known field", remedy)
    ways = [way for way in _TURNS if way in given]
    if len(ways) > 1:
        raise InvalidInputError(field, f"says its rotation by {' and '.join(ways)}", "leave one of them")
    transform = np.eye(4)
    transform[:3, 3] = finite_array(f"{field}.translation", given.get("translation", [0.0, 0.0, 0.0]), 1, 3)
    if ways:
        transform[:3, :3] = matrix(_turn(f"{field}.{ways[0]}", ways[0], given[ways[0]]))
    return transform


def _turn(field: str, way: str, value: Any) -> FloatArray:
    """Return the unit quaternion that is given in one of the ways."""
    if way == "quaternion":
        return unit_quaternions(field, value, 1)
    return from_rotation_matrix(field, value) if way == "matrix" else from_rpy(field, value)
