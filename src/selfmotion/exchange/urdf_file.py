"""Arms as URDF files, which ROS, simulators and :func:`selfmotion.load_chain` read."""

from __future__ import annotations

import os
from collections.abc import Sequence
from xml.etree import ElementTree

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import PlanarArm, RedundantArm
from selfmotion.arms.chain import Chain
from selfmotion.arms.shapes import Capsule, Shapes
from selfmotion.constrained import unconstrained
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.files import write_file
from selfmotion.scene.links import Links

_UNLIMITED = 1e9
"""Written where nothing limits effort or velocity [N m, rad/s]: URDF has no word for that, and wants a number."""
_THICK = 0.04  # of the longest link, that the picture of a link is


def save_urdf(arm: RedundantArm, file: str | os.PathLike[str], force: bool = False) -> None:
    """Write an arm as URDF, whole or not at all.

    Parameters
    ----------
    arm : RedundantArm
        One of the plane needs a placement. Links of the plane have a box each, to be seen by. The capsules of links
        are written as collision shapes: a cylinder and a sphere at either end, which every reader knows.
    file : path-like
    force : bool
        Whether a file that selfmotion did not write may be replaced.

    Raises
    ------
    InvalidInputError
        If a planar arm has no placement, a joint has one limit only, which URDF cannot say, two links would have the
        same name, or the file cannot be written or is somebody else's.
    """
    write_file(file, arm_urdf(arm), force)


def arm_urdf(arm: RedundantArm) -> bytes:
    """Return an arm as URDF; see :func:`save_urdf`."""
    arm = unconstrained(arm)
    if isinstance(arm, PlanarArm):
        placed = planar_chain(arm)
        return chain_urdf(placed, placed.offsets[1:, 0, 3].tolist())
    chain = getattr(arm, "chain", None)
    if chain is None:
        raise InvalidInputError("arm", f"is a {type(arm).__name__}, which is no chain", "give an arm with joints")
    return chain_urdf(chain)


def planar_chain(arm: PlanarArm) -> Chain:
    """Return a planar arm in space as a chain, from its placement's frame to ``tool``, in metres.

    Raises
    ------
    InvalidInputError
        If it has no placement.
    """
    placement = arm.placement
    if placement is None:
        remedy = (
            "say where it stands and what its links are measured in: placement: {base: [0, 0, 0], plane: xz, unit: mm}"
        )
        raise InvalidInputError("arm.placement", "is missing", remedy)
    steps = np.broadcast_to(np.eye(4), (arm.n, 4, 4)).copy()
    steps[:, 0, 3] = placement.metres * arm.links
    names = placement.joints or tuple(f"joint{j}" for j in range(1, arm.n + 1))
    links = Links.of(arm)
    rods = zip(links.names, links.frame, placement.metres * links.ends, placement.metres * links.radius, strict=True)
    shapes = Shapes(tuple(Capsule(name, int(j), ends, radius) for name, j, ends, radius in rods if radius > 0))
    return Chain(names, [placement.pose, *steps], arm.limits, base=placement.frame, tip="tool", shapes=shapes)


def chain_urdf(chain: Chain, lengths: Sequence[float] = ()) -> bytes:
    """Return a chain as URDF; with `lengths` of its links [m], which lie along their x-axes, boxes to see them by."""
    links = [chain.base, *(f"{name}_link" for name in chain.names), chain.tip]
    for j, link in enumerate(links):
        if link in links[:j]:
            raise InvalidInputError("arm", f"has two links named {link!r}", "give base, tip and joints other names")
    robot = ElementTree.Element("robot", name="selfmotion")
    for link, length in zip(links, [None, *lengths, *[None] * (len(links) - 1 - len(lengths))], strict=True):
        element = ElementTree.SubElement(robot, "link", name=link)
        if length is not None:
            thick = repr(_THICK * max(lengths))
            visual = ElementTree.SubElement(element, "visual")
            ElementTree.SubElement(visual, "origin", xyz=f"{0.5 * length!r} 0 0", rpy="0 0 0")
            shape = ElementTree.SubElement(visual, "geometry")
            ElementTree.SubElement(shape, "box", size=f"{length!r} {thick} {thick}")
    for part in chain.shapes.capsules:
        _write_capsule(robot[part.frame + 1], part)
    for j, name in enumerate((*chain.names, "")):
        joint = ElementTree.SubElement(robot, "joint", name=name or f"{chain.tip}_mount")
        ElementTree.SubElement(joint, "parent", link=links[j])
        ElementTree.SubElement(joint, "child", link=links[j + 1])
        ElementTree.SubElement(joint, "origin", xyz=_numbers(chain.offsets[j, :3, 3]), rpy=_numbers(_rpy(chain, j)))
        if not name:
            joint.set("type", "fixed")
            continue
        ElementTree.SubElement(joint, "axis", xyz="0 0 1")
        joint.set("type", _limited(joint, chain, j))
    ElementTree.indent(robot)
    return b'<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(robot, encoding="utf-8") + b"\n"


def _write_capsule(link: ElementTree.Element, part: Capsule) -> None:
    """Write a capsule as the collision shapes of a link: a cylinder along z, and a sphere at either end."""
    axis = part.ends[1] - part.ends[0]
    length, radius = float(np.linalg.norm(axis)), repr(part.radius)
    if length > 0:
        turn = np.array([0.0, np.arctan2(np.hypot(axis[0], axis[1]), axis[2]), np.arctan2(axis[1], axis[0])])
        shape = _collision(link, part.ends.mean(axis=0), turn)
        ElementTree.SubElement(shape, "cylinder", radius=radius, length=repr(length))
    for end in part.ends if length > 0 else part.ends[:1]:
        ElementTree.SubElement(_collision(link, end, np.zeros(3)), "sphere", radius=radius)


def _collision(link: ElementTree.Element, place: FloatArray, turn: FloatArray) -> ElementTree.Element:
    """Write a collision shape with a place and roll, pitch and yaw; return where its geometry goes."""
    collision = ElementTree.SubElement(link, "collision")
    ElementTree.SubElement(collision, "origin", xyz=_numbers(place), rpy=_numbers(turn))
    return ElementTree.SubElement(collision, "geometry")


def _limited(joint: ElementTree.Element, chain: Chain, j: int) -> str:
    """Write the limits of a joint; return its type."""
    ends = np.array([chain.limits.lower[j], chain.limits.upper[j]])
    if np.isfinite(ends).any() and not np.isfinite(ends).all():
        raise InvalidInputError(f"limits.{j}", "has one end only, which URDF cannot say", "give both, or none")
    limited, slides = bool(np.isfinite(ends).all()), bool(chain.prismatic[j])
    if slides and not limited:
        raise InvalidInputError(f"limits.{j}", "are missing, and URDF wants them of joints that slide", "give both")
    speed = float(min(chain.velocity[j], _UNLIMITED))
    given = {"lower": repr(float(ends[0])), "upper": repr(float(ends[1]))} if limited else {}
    ElementTree.SubElement(joint, "limit", {**given, "effort": repr(_UNLIMITED), "velocity": repr(speed)})
    return "prismatic" if slides else "revolute" if limited else "continuous"


def _rpy(chain: Chain, j: int) -> FloatArray:
    """Return roll, pitch and yaw of an offset, ``R = Rz(yaw) Ry(pitch) Rx(roll)``.

    Pitch and roll are taken of ``Rz(−yaw) R``, so that they fit the yaw that was found, wherever roll and yaw are
    about the same axis and each of them is uncertain.
    """
    rotation = chain.offsets[j, :3, :3]
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    cos, sin = np.cos(yaw), np.sin(yaw)
    rest = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ rotation
    return np.array([np.arctan2(-rest[1, 2], rest[1, 1]), np.arctan2(-rest[2, 0], rest[0, 0]), yaw])


def _numbers(values: FloatArray) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)
