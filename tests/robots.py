"""Seven-joint arms of no family, as URDF files without meshes."""

import math

from selfmotion.arms.urdf import read_chain

_QUARTER = 0.5 * math.pi
_TURN = 2 * math.pi


def urdf(name, joints, tool=0.0):
    """A chain of revolute joints about z: per joint xyz and roll of its frame, and its limits."""
    links = "".join(f'<link name="link{k}"/>' for k in range(len(joints) + 1))
    parts = [
        f'<joint name="joint{k + 1}" type="revolute"><parent link="link{k}"/><child link="link{k + 1}"/>'
        f'<origin xyz="{" ".join(map(repr, xyz))}" rpy="{roll!r} 0 0"/><axis xyz="0 0 1"/>'
        f'<limit lower="{low!r}" upper="{high!r}" effort="1" velocity="3"/></joint>'
        for k, (xyz, roll, low, high) in enumerate(joints)
    ]
    end = (
        f'<link name="tool"/><joint name="mount" type="fixed"><parent link="link{len(joints)}"/><child link="tool"/>'
        f'<origin xyz="0 0 {tool!r}" rpy="0 0 0"/></joint>'
    )
    return f'<robot name="{name}">{links}{"".join(parts)}{end}</robot>'


# UFACTORY xArm 7: distances and limits of its ROS description. Like a Panda, but axis 5 is turned the other way.
XARM7 = urdf(
    "xarm7",
    [
        ((0.0, 0.0, 0.267), 0.0, -_TURN, _TURN),
        ((0.0, 0.0, 0.0), -_QUARTER, -2.059, 2.0944),
        ((0.0, -0.293, 0.0), _QUARTER, -_TURN, _TURN),
        ((0.0525, 0.0, 0.0), _QUARTER, -0.19198, 3.927),
        ((0.0775, -0.3425, 0.0), _QUARTER, -_TURN, _TURN),
        ((0.0, 0.0, 0.0), _QUARTER, -1.69297, math.pi),
        ((0.076, 0.097, 0.0), -_QUARTER, -_TURN, _TURN),
    ],
)

# Made up: shoulder, elbow and wrist as an iiwa's, but axes 1 and 3 pass each other at 30 mm.
SIDEWAYS = urdf(
    "sideways",
    [
        ((0.0, 0.0, 0.36), 0.0, -2.9, 2.9),
        ((0.0, 0.0, 0.0), -_QUARTER, -2.0, 2.0),
        ((0.0, -0.42, 0.03), _QUARTER, -2.9, 2.9),
        ((0.0, 0.0, 0.0), -_QUARTER, -2.0, 2.0),
        ((0.0, -0.4, 0.0), _QUARTER, -2.9, 2.9),
        ((0.0, 0.0, 0.0), -_QUARTER, -2.0, 2.0),
        ((0.0, 0.0, 0.0), _QUARTER, -3.0, 3.0),
    ],
    0.126,
)

# Made up: no three axes meet, as in a Sawyer.
APART = urdf(
    "apart",
    [
        ((0.0, 0.0, 0.317), 0.0, -3.0, 3.0),
        ((0.081, 0.1925, 0.0), -_QUARTER, -3.0, 2.0),
        ((0.0, -0.4, 0.0), _QUARTER, -3.0, 3.0),
        ((0.0, 0.1685, 0.0), -_QUARTER, -3.0, 3.0),
        ((0.0, -0.4, 0.0), _QUARTER, -3.0, 3.0),
        ((0.0, -0.1363, 0.0), -_QUARTER, -3.0, 3.0),
        ((0.0, 0.13375, 0.0), _QUARTER, -4.0, 4.0),
    ],
)

TEXTS = {"xarm7": XARM7, "sideways": SIDEWAYS, "apart": APART}


def chain(name):
    """The chain of one of them."""
    return read_chain(TEXTS[name])
