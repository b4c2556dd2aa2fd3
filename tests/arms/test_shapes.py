"""Capsules of links: read from URDF so that they hold what is there, carried along by every change of a chain."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from selfmotion.arms.catalogue import CATALOGUE, named_arm
from selfmotion.arms.chain import Chain
from selfmotion.arms.shapes import Capsule, Shapes, without_hidden
from selfmotion.arms.urdf import read_chain
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.urdf_file import chain_urdf

SIZE = st.floats(0.01, 2.0)
ANGLE = st.floats(-3, 3)


def robot(collisions, joints="", links="", axis="0 0 1"):
    """Return a robot whose link `arm` has collision shapes, one joint from its base."""
    return f"""<robot name="r"><link name="base"/><link name="arm">{collisions}</link>{links}
    <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/>
      <origin xyz="0.1 0.2 0.3" rpy="0.1 -0.2 0.3"/><axis xyz="{axis}"/></joint>{joints}</robot>"""


def collision(geometry, xyz="0 0 0", rpy="0 0 0"):
    return f'<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{geometry}</geometry></collision>'


def fixed(name, parent, child, xyz="0 0 0", kind="fixed"):
    return f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
      <origin xyz="{xyz}"/></joint>"""


def parts_of(text, tip="arm"):
    return read_chain(text, "base", tip).shapes.capsules


def inside(parts, points):
    """Return whether points are in one of the capsules, to rounding."""
    found = np.zeros(len(points), bool)
    for part in parts:
        along = part.ends[1] - part.ends[0]
        square = along @ along
        s = np.clip((points - part.ends[0]) @ along / square, 0, 1) if square > 0 else np.zeros(len(points))
        found |= np.linalg.norm(points - part.ends[0] - s[:, None] * along, axis=1) <= part.radius * (1 + 1e-9)
    return found


def turn(rpy):
    (c1, c2, c3), (s1, s2, s3) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, c1, -s1], [0, s1, c1]])
    about_y = np.array([[c2, 0, s2], [0, 1, 0], [-s2, 0, c2]])
    return np.array([[c3, -s3, 0], [s3, c3, 0], [0, 0, 1]]) @ about_y @ about_x


@settings(max_examples=60, deadline=None)
@given(SIZE, SIZE, ANGLE, ANGLE)
def test_a_cylinder_is_held(radius, length, pitch, yaw):
    text = f'<cylinder radius="{radius!r}" length="{length!r}"/>'
    parts = parts_of(robot(collision(text, "0.1 0 -0.3", f"0.2 {pitch} {yaw}")))
    angle = np.linspace(0, 2 * np.pi, 40)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(40, 0.5 * length)], axis=1)
    points = np.concatenate([rim, rim * [1, 1, -1]]) @ turn([0.2, pitch, yaw]).T + [0.1, 0, -0.3]
    assert inside(parts, points).all()
    assert len(parts) == 1
    # No more than twice what a long one, and four times what any one is.
    volume = np.pi * radius**2 * length
    assert parts[0].volume <= volume + 4 / 3 * np.pi * radius**3 + 1e-12


@settings(max_examples=60, deadline=None)
@given(st.tuples(SIZE, SIZE, SIZE), ANGLE, ANGLE)
def test_a_box_is_held(size, pitch, yaw):
    text = '<box size="{!r} {!r} {!r}"/>'.format(*size)
    parts = parts_of(robot(collision(text, "0.1 0 -0.3", f"0.2 {pitch} {yaw}")))
    part = np.linspace(-0.5, 0.5, 9)
    cube = np.stack(np.meshgrid(part, part, part), axis=-1).reshape(-1, 3)
    points = (cube * size) @ turn([0.2, pitch, yaw]).T + [0.1, 0, -0.3]
    assert inside(parts, points).all()
    assert len(parts) <= 4


def test_flat_boxes_have_several_capsules_and_cubes_one():
    assert len(parts_of(robot(collision('<box size="1 1 1"/>')))) == 1
    flat = parts_of(robot(collision('<box size="0.5 2 0.1"/>')))
    assert len(flat) == 4
    assert all(part.ends[1] - part.ends[0] == pytest.approx([0, 2, 0]) for part in flat)


def test_spheres_and_capsules_are_read_as_they_are():
    (ball,) = parts_of(robot(collision('<sphere radius="0.2"/>', "1 2 3")))
    assert ball == Capsule("arm", 0, [[1, 2, 3], [1, 2, 3]], 0.2)
    (rod,) = parts_of(robot(collision('<capsule radius="0.2" length="2"/>', "1 2 3", "0 0 1")))
    assert (rod.ends == [[1, 2, 2], [1, 2, 4]]).all()
    assert rod.radius == 0.2


def test_a_cylinder_with_a_ball_at_either_end_is_one_capsule():
    shapes = [("<cylinder radius='0.03' length='0.01'/>", "0 0 1"), ("<sphere radius='0.03'/>", "0 0 1.005")]
    both = "".join(collision(*shape) for shape in [*shapes, ("<sphere radius='0.03'/>", "0 0 0.995")])
    (rod,) = parts_of(robot(both))
    assert rod.ends[:, 2] == pytest.approx([0.995, 1.005])
    assert rod.radius == 0.03
    assert len(parts_of(robot("".join(collision(*shape) for shape in shapes)))) == 2


def test_what_is_inside_something_else_is_left_out():
    big, small = Capsule("a", 0, [[0, 0, 0], [0, 0, 1]], 0.5), Capsule("a", 0, [[0, 0.1, 0.2], [0, 0, 1.1]], 0.3)
    assert without_hidden([small, big, small]) == (big,)
    assert without_hidden([big, big]) == (big,)
    out = Capsule("a", 0, [[0, 0.3, 0.2], [0, 0, 1.1]], 0.3)
    assert without_hidden([out, big]) == (out, big)


@pytest.mark.parametrize("axis", ["0 0 1", "1 2 -3", "0 0 -1"])
def test_shapes_of_links_that_are_fixed_to_one_another_move_together(axis):
    ball = collision('<sphere radius="0.1"/>')
    links = f'<link name="mount"/><link name="tool">{ball}</link><link name="wall">{ball}</link>'
    joints = fixed("m", "arm", "mount", "0 0 1") + fixed("t", "mount", "tool", "0.5 0 0") + fixed("w", "wall", "base")
    text = robot(ball, joints, links, axis)
    for tip in ("arm", "tool"):  # whether the way passes them or not
        chain = read_chain(text, "wall", tip)
        frames = {part.link: part.frame for part in chain.shapes.capsules}
        assert frames == {"arm": 0, "tool": 0, "wall": -1}
        where = read_chain(text, "wall", "tool")
        tool = next(part for part in chain.shapes.capsules if part.link == "tool")
        for q in (0.0, 1.3):
            stub = Chain(["turn"], [chain.offsets[0], np.eye(4)])
            pose = stub.forward([q])
            assert pose[:3, :3] @ tool.ends[0] + pose[:3, 3] == pytest.approx(where.forward([q])[:3, 3])


def test_what_is_not_read_is_told_with_its_link_and_does_not_stop_the_kinematics():
    mesh = collision('<mesh filename="part.stl"/>')
    shapes = read_chain(robot(mesh), "base", "arm").shapes
    assert shapes.unread == {"arm": "has a mesh, which is not read"}
    ball = collision('<sphere radius="0.1"/>')
    assert read_chain(robot(ball + mesh), "base", "arm").shapes.unread.keys() == {"arm"}
    off = f'<link name="finger">{mesh}</link><link name="lost">{ball}</link><link name="bare"/>'
    joints = (
        fixed("f", "arm", "finger", kind="revolute") + fixed("l", "arm", "lost", "0 x 0") + fixed("b", "arm", "bare")
    )
    shapes = read_chain(robot(ball, joints, off), "base", "arm").shapes
    assert shapes.loose == ("finger",)
    assert "lost" in shapes.unread
    assert "urdf.l.origin.xyz: is not a number" in shapes.unread["lost"]


@pytest.mark.parametrize(
    ("shape", "says"),
    [
        ('<sphere radius="-1"/>', "radius: must be greater than zero"),
        ('<sphere radius="big"/>', "radius: is not a number"),
        ("<sphere/>", "radius: needs one number and has 0"),
        ('<box size="1 2"/>', "size: needs three numbers and has 2"),
        ('<box size="1 2 0"/>', "size: must be greater than zero"),
        ('<cone radius="1"/>', "has the unknown shape 'cone'"),
        ("", "has 0 shapes"),
        ('<sphere radius="1"/><sphere radius="1"/>', "has 2 shapes"),
    ],
)
def test_a_wrong_shape_is_told_with_its_link(shape, says):
    unread = read_chain(robot(collision(shape)), "base", "arm").shapes.unread
    assert says in unread["arm"]


def test_links_said_never_to_meet_are_read():
    text = robot("").replace("</robot>", '<disable_collisions link1="a" link2="b" reason="Never"/></robot>')
    assert read_chain(text, "base", "arm").shapes.apart == (("a", "b"),)


def placed(chain, q):
    """Return the ends of a chain's capsules in its base frame, by forward kinematics of shorter chains."""
    found = []
    for part in chain.shapes.capsules:
        if part.frame < 0:
            found.append(part.ends)
            continue
        n = part.frame + 1
        stub = Chain(chain.names[:n], [*chain.offsets[:n], np.eye(4)], None, chain.prismatic[:n])
        pose = stub.forward(q[:n])
        found.append(part.ends @ pose[:3, :3].T + pose[:3, 3])
    return np.array(found)


Q = np.array([0.3, -0.5, 0.2, -1.9, 0.4, 1.7, -0.8])


@pytest.mark.parametrize("joint", range(7))
def test_a_locked_joint_leaves_shapes_where_they_were(joint):
    chain = CATALOGUE["panda"].chain()
    held = chain.locked(joint, Q[joint])
    assert np.abs(placed(held, np.delete(Q, joint)) - placed(chain, Q)).max() < 1e-15 * 10
    assert {part.frame for part in held.shapes.capsules} <= set(range(-1, 6))


@pytest.mark.parametrize("axis", [[0, 1, 0], [1, -2, 3], [0, 0, -1]])
def test_a_rail_carries_all_shapes_the_base_s_too(axis):
    chain = CATALOGUE["irb120"].chain()
    rail = chain.on_rail(axis, [-2, 2])
    along = np.array(axis) / np.linalg.norm(axis)
    for slid in (0.0, 0.7):
        moved = placed(rail, np.append(slid, Q[:6]))
        assert np.abs(moved - placed(chain, Q[:6]) - slid * along).max() < 1e-14
    assert min(part.frame for part in rail.shapes.capsules) == 0


def test_tools_limits_and_relaxed_arms_keep_the_shapes():
    plain = named_arm("panda")
    other = named_arm("panda", tool={"translation": [0, 0, 0.1]}, limits=[(-1, 1)] * 7)
    assert plain.chain.shapes.capsules
    assert other.chain.shapes == plain.chain.shapes == other.relaxed(0.1).chain.shapes


@pytest.mark.parametrize("name", sorted(CATALOGUE))
def test_written_shapes_come_back(name):
    chain = CATALOGUE[name].chain()
    again = read_chain(chain_urdf(chain).decode())
    assert len(again.shapes.capsules) == len(chain.shapes.capsules)
    for one in chain.shapes.capsules:
        same = [part for part in again.shapes.capsules if part.frame == one.frame and part.radius == one.radius]
        assert min(np.abs(part.ends - one.ends).max() for part in same) < 1e-12


def test_wrong_capsules_are_refused():
    good = {"link": "a", "frame": 0, "ends": np.zeros((2, 3)), "radius": 1.0}
    for name, value, says in [
        ("radius", 0.0, "must be greater than zero"), ("frame", -2, "outside"),
        ("ends", np.zeros((3, 3)), "has 3 points"),
        ("ends", [[0, 0, np.nan], [0, 0, 0]], "finite"),
    ]:  # fmt: skip
        with pytest.raises(InvalidInputError, match=says):
            Capsule(**{**good, name: value})
    with pytest.raises(InvalidInputError, match="a frame that 1 joints do not have"):
        Chain(["a"], [np.eye(4)] * 2, shapes=Shapes((Capsule("a", 1, np.zeros((2, 3)), 1.0),)))
