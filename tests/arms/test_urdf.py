"""URDF files: what is read, against scipy's rotations; what is refused; the arms that come with the package."""

import re
import sys
from importlib.resources import files
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from selfmotion.arms.urdf import MAX_SIZE, load_chain, read_chain
from selfmotion.errors import InvalidInputError

DATA = files("selfmotion.arms") / "data"
TAU = 2 * np.pi


def joint(name, parent, child, kind="revolute", inside='<limit lower="-1" upper="2" velocity="3"/>'):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def robot(*joints, links="abc"):
    named = [f'<link name="{link}"/>' for link in links]
    return f"<robot>{''.join(named)}{''.join(joints)}</robot>"


def rigid(rotation, translation):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation.as_matrix(), translation
    return pose


def numbers(element, name, default):
    text = default if element is None else element.get(name, default)
    return np.array([float(word) for word in text.split()])


def oracle(text, base, tip, q):
    """The pose of `tip` by walking up the file, each joint a rotation vector about its own axis."""
    above = {element.find("child").get("link"): element for element in ElementTree.fromstring(text).findall("joint")}
    way = []
    while tip != base:
        way.insert(0, above[tip])
        tip = above[tip].find("parent").get("link")
    pose, values = np.eye(4), iter(q)
    for element in way:
        origin = element.find("origin")
        turn = Rotation.from_euler("xyz", numbers(origin, "rpy", "0 0 0"))
        pose = pose @ rigid(turn, numbers(origin, "xyz", "0 0 0"))
        if element.get("type") == "fixed":
            continue
        axis = numbers(element.find("axis"), "xyz", "1 0 0")
        along = axis / np.linalg.norm(axis) * next(values)
        if element.get("type") == "prismatic":
            pose = pose @ rigid(Rotation.identity(), along)
        else:
            pose = pose @ rigid(Rotation.from_rotvec(along), np.zeros(3))
    return pose


def random_robot(rng, count):
    """A chain l0 … of all kinds of joints, with a branch that nobody asks for."""
    kinds = ["revolute", *rng.choice(["revolute", "continuous", "prismatic", "fixed"], count - 1)]
    axes = ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1", "1 -2 3", "0.1 0 -7"]
    joints = []
    for i, kind in enumerate(kinds):
        inside = '<limit lower="-9" upper="9" velocity="1"/>'
        if rng.random() < 0.8:
            xyz, rpy = rng.uniform(-1, 1, 3), rng.uniform(-4, 4, 3)
            inside += f'<origin xyz="{" ".join(map(str, xyz))}" rpy="{" ".join(map(str, rpy))}"/>'
        if rng.random() < 0.9:
            inside += f'<axis xyz="{rng.choice(axes)}"/>'
        joints.append(joint(f"j{i}", f"l{i}", f"l{i + 1}", kind, inside))
    joints.append(joint("side", "l0", "finger", "prismatic", '<mimic joint="j0"/>'))
    rng.shuffle(joints)
    return robot(*joints, links=[f"l{i}" for i in range(count + 1)] + ["finger"]), kinds


@pytest.mark.parametrize("seed", range(20))
def test_forward_kinematics_of_random_robots(seed):
    rng = np.random.default_rng(seed)
    text, kinds = random_robot(rng, int(rng.integers(1, 12)))
    tip = f"l{len(kinds)}"
    chain = read_chain(text, tip=tip)
    moving = [(f"j{i}", kind) for i, kind in enumerate(kinds) if kind != "fixed"]
    assert chain.names == tuple(name for name, _ in moving)
    assert chain.prismatic.tolist() == [kind == "prismatic" for _, kind in moving]
    assert (chain.base, chain.tip) == ("l0", tip)
    q = rng.uniform(-5, 5, (10, chain.n))
    np.testing.assert_allclose(chain.forward(q), [oracle(text, "l0", tip, row) for row in q], atol=1e-12)


def test_positive_angles_turn_the_right_way():
    """About −z a quarter turn takes x to −y; about y it takes z to x."""
    for axis, start, end in (("0 0 -1", (1, 0, 0), (0, -1, 0)), ("0 1 0", (0, 0, 1), (1, 0, 0))):
        inside = f'<limit lower="-2" upper="2"/><axis xyz="{axis}"/>'
        pose = read_chain(robot(joint("j", "a", "b", inside=inside), links="ab")).forward([np.pi / 2])
        np.testing.assert_allclose(pose[:3, :3] @ start, end, atol=1e-15)


def test_limits_and_speeds():
    text = robot(
        joint("turns", "a", "b"),
        joint("spins", "b", "c", "continuous", '<limit velocity="7" lower="0" upper="0"/>'),
        joint("slides", "c", "d", "prismatic", '<limit lower="0" upper="0.5"/><mimic_not/>'),
        joint("goes on", "d", "e", "continuous", ""),
        links="abcde",
    )
    chain = read_chain(text)
    assert chain.limits.as_list() == [[-1, 2], None, [0, 0.5], None]
    assert chain.velocity.tolist() == [3, 7, np.inf, np.inf]
    assert chain.prismatic.tolist() == [False, False, True, False]


def test_limits_may_leave_a_single_position():
    text = robot(joint("j", "a", "b", inside='<limit lower=" 1.5 " upper="15e-1"/>'), links="ab")
    assert read_chain(text).limits.as_list() == [[1.5, 1.5]]


def test_base_and_tip_may_be_inner_links():
    text = robot(joint("1", "a", "b"), joint("2", "b", "c"), joint("3", "c", "d"), joint("4", "c", "e"), links="abcde")
    assert read_chain(text, tip="d").names == ("1", "2", "3")
    assert read_chain(text, "b", "e").names == ("2", "4")
    assert read_chain(text, "a", "c").names == ("1", "2")
    assert read_chain(robot(joint("1", "b", "c"), links="abc"), tip="c").base == "b"


def test_what_is_off_the_chain_is_passed_over():
    off = [
        joint("finger", "b", "c", "prismatic", '<mimic joint="1"/>'),
        joint("wheel", "a", "d", "floating", ""),
        joint("odd", "a", "e", "spherical", '<axis xyz="none"/>'),
        '<transmission><joint name="1"/></transmission><gazebo/><material name="m"/>',
    ]
    assert read_chain(robot(joint("1", "a", "b"), *off, links="abcde"), tip="b").names == ("1",)


LIMIT = '<limit lower="-1" upper="1"/>'


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("", r"urdf\.j\.limit: has no limits; write lower and upper .*, or write continuous if it turns freely"),
        ('<limit velocity="1"/>', r"urdf\.j\.limit: has no limits"),
        ('<limit lower="1"/>', r"urdf\.j\.limit: has no limits; write upper into"),
        ('<limit lower="1" upper="0"/>', r"urdf\.j\.limit: is reversed \(got \[1\.0, 0\.0\]\)"),
        ('<limit lower="nan" upper="0"/>', r"urdf\.j\.limit\.lower: contains NaN or infinity"),
        ('<limit lower="0" upper="inf"/>', r"urdf\.j\.limit\.upper: contains NaN or infinity"),
        ('<limit lower="0" upper="1e999"/>', r"urdf\.j\.limit\.upper: contains NaN or infinity"),
        ('<limit lower="0" upper="1,5"/>', r"urdf\.j\.limit\.upper: is not a number \(got '1,5'\)"),
        ('<limit lower="0" upper="1_5"/>', r"urdf\.j\.limit\.upper: is not a number"),
        ('<limit lower="0" upper="٣"/>', r"urdf\.j\.limit\.upper: is not a number"),
        ('<limit lower="0" upper=""/>', r"urdf\.j\.limit\.upper: is not a number"),
        ('<limit lower="${-pi}" upper="1"/>', r"urdf\.j\.limit\.lower: is not a number .*expand the xacro template"),
        ('<limit lower="0" upper="1" velocity="0"/>', r"urdf\.j\.limit\.velocity: must be greater than zero"),
        ('<limit lower="0" upper="1" velocity="x"/>', r"urdf\.j\.limit\.velocity: is not a number"),
        (f'{LIMIT}<axis xyz="0 0 0"/>', r"urdf\.j\.axis\.xyz: is zero"),
        (f'{LIMIT}<axis xyz="0 1"/>', r"urdf\.j\.axis\.xyz: needs three numbers and has 2 .*; put spaces"),
        (f'{LIMIT}<axis xyz="0 1 nan"/>', r"urdf\.j\.axis\.xyz: contains NaN"),
        (f'{LIMIT}<origin xyz="0 0 one"/>', r"urdf\.j\.origin\.xyz: is not a number \(got 'one'\)"),
        (f'{LIMIT}<origin xyz="0 0 0 0"/>', r"urdf\.j\.origin\.xyz: needs three numbers and has 4"),
        (f'{LIMIT}<origin rpy="0 0 1e4"/>', r"urdf\.j\.origin\.rpy: exceeds 1000 rad"),
        (f'{LIMIT}<origin rpy="0 0 nan"/>', r"urdf\.j\.origin\.rpy: contains NaN"),
        (f'{LIMIT}<mimic joint="other"/>', r"urdf\.j\.mimic: follows joint 'other' and cannot move by itself"),
    ],
)
def test_a_joint_on_the_way_that_is_wrong_is_refused(inside, message):
    with pytest.raises(InvalidInputError, match=message):
        read_chain(robot(joint("j", "a", "b", inside=inside), links="ab"))


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joints_with_several_axes_are_refused(kind):
    message = rf"urdf\.j\.type: is a {kind} joint, which has more than one axis; name a base and tip"
    with pytest.raises(InvalidInputError, match=message):
        read_chain(robot(joint("j", "a", "b", kind), links="ab"))


def test_an_unknown_kind_of_joint_is_refused():
    message = r"urdf\.j\.type: is not known \(got 'screw'\); write one of revolute, continuous, prismatic, fixed"
    with pytest.raises(InvalidInputError, match=message):
        read_chain(robot(joint("j", "a", "b", "screw"), links="ab"))


def test_a_prismatic_joint_without_limits_cannot_be_continuous():
    with pytest.raises(InvalidInputError, match=r"urdf\.j\.limit: has no limits; write lower into its <limit>$"):
        read_chain(robot(joint("j", "a", "b", "prismatic", '<limit upper="0.04"/>'), links="ab"))


NO_CHAIN = [
    (
        robot(joint("1", "a", "c"), joint("2", "b", "c")),
        r"urdf\.2\.child: closes a chain: link 'c' has two parents",
    ),
    (
        robot(joint("1", "a", "b"), joint("2", "b", "c"), joint("3", "c", "a")),
        r"urdf\.3: is part of a loop: link 'a'",
    ),
    (robot(joint("1", "b", "b")), r"urdf\.1: is part of a loop: link 'b' is below itself; only open chains"),
    (
        robot(joint("1", "a", "x")),
        r"urdf\.1\.child: is not a link of this robot \(got 'x'\); the links are a, b, c",
    ),
    (robot(joint("1", "arm1", "b"), links=["arm_1", "b"]), r"urdf\.1\.parent: .*\(got 'arm1'\); did you mean arm_1\?"),
    (robot(joint("1", "a", "b"), joint("1", "b", "c")), r"urdf\.1: is the name of two joints"),
    (robot(links="aa"), "urdf: has two links named 'a'"),
    (robot(links=""), "urdf: has no links"),
    ("<robot><link/></robot>", "urdf: is wrong: a link has no name"),
    ('<robot><link name="a"/><joint type="fixed"/></robot>', "urdf: is wrong: a joint has no name"),
    ('<robot><link name="a"/><joint name="j"/></robot>', r"urdf\.j\.parent: is missing"),
    ('<robot><link name="a"/><joint name="j"><parent/></joint></robot>', r"urdf\.j\.parent: .* no link"),
    ("<sdf/>", "urdf: is not a robot: its root element is <sdf>"),
    ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro/></robot>', "urdf: is a xacro template"),
    ("<robot>\n<link>\n</robot>", r"urdf: is not well-formed XML \(line 3: mismatched tag\)"),
    ("", r"urdf: is not well-formed XML \(line 1: no element found\)"),
    ("<robot/>\n<robot/>", r"urdf: is not well-formed XML \(line 2: junk after document element\)"),
    ("<robot>&x;</robot>", r"urdf: is not well-formed XML \(line 1: undefined entity"),
    ("<!DOCTYPE robot><robot/>", "urdf: has a DOCTYPE; remove it: entities are not read"),
    ('<!DOCTYPE r [<!ENTITY a "b"><!ENTITY c "&a;&a;">]><robot>&c;</robot>', "urdf: has a DOCTYPE"),
    ('<!DOCTYPE r SYSTEM "file:///etc/hostname"><robot/>', "urdf: has a DOCTYPE"),
    ("<robot>\ud800</robot>", "urdf: holds characters that are none"),
    (b"<robot/>", "urdf: is not text"),
    (f"<robot>{' ' * MAX_SIZE}</robot>", "urdf: is larger than 10 MB"),
    ("<a>" * 200_000, "urdf: is not well-formed XML"),
]


@pytest.mark.parametrize(("text", "message"), NO_CHAIN, ids=[message for _, message in NO_CHAIN])
def test_what_is_no_open_chain_is_refused(text, message):
    with pytest.raises(InvalidInputError, match=message):
        read_chain(text)


def test_a_namespace_of_the_whole_robot_means_nothing():
    text = robot(joint("1", "a", "b"), links="ab").replace("<robot>", '<robot xmlns="http://drake.mit.edu">')
    assert read_chain(text).names == ("1",)


def test_a_doctype_in_a_comment_is_none():
    assert read_chain("<!-- <!DOCTYPE x> -->" + robot(joint("1", "a", "b"), links="ab")).n == 1


BRANCHED = robot(
    joint("1", "base_link", "arm"),
    joint("2", "arm", "hand_left"),
    joint("3", "arm", "hand_right"),
    joint("4", "hand_right", "nail", "fixed"),
    links=["base_link", "arm", "hand_left", "hand_right", "nail"],
)


@pytest.mark.parametrize(
    ("base", "tip", "message"),
    [
        (None, None, r"tip: is not told, and the chain branches; give tip, such as hand_left, nail$"),
        ("arm", None, r"tip: is not told, and the chain branches"),
        (
            "base",
            "nail",
            r"base: is not a link.*\(got 'base'\); did you mean base_link\?; the tips are hand_left, nail",
        ),
        (None, "hand_lift", r"tip: is not a link.*; did you mean hand_left.*\?; the tips are hand_left, nail"),
        (None, "0", r"tip: is not a link.*; the links are base_link, arm.*; the tips are hand_left, nail"),
        ("hand_left", "nail", r"tip: is not below 'hand_left' .*; start from one of hand_right, arm, base_link"),
        ("arm", "base_link", r"tip: is not below 'arm'"),
        ("nail", None, r"base: has no link below it"),
        ("arm", "arm", r"tip: moves with 'arm': no joint between them can turn"),
        ("hand_right", "nail", r"tip: moves with 'hand_right'"),
    ],
)
def test_ends_of_the_chain_that_make_no_sense_are_refused(base, tip, message):
    with pytest.raises(InvalidInputError, match=message):
        read_chain(BRANCHED, base, tip)


def test_several_roots_must_be_chosen_from():
    with pytest.raises(InvalidInputError, match=r"base: is not told, and there are several roots; give one of a, c$"):
        read_chain(robot(joint("1", "a", "b"), links="abc"))


def test_a_base_and_a_tip_with_different_roots_name_both():
    text = robot(joint("1", "a", "b"), joint("2", "c", "d"), links="abcd")
    message = r"tip: is not connected with 'b': the robot has several roots, 'a' above 'b' and 'c' above the tip"
    with pytest.raises(InvalidInputError, match=message):
        read_chain(text, "b", "d")


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('<joint name="1"', '<jont name="1"', r"urdf: has an unknown element <jont> of '1'.*did you mean <joint>\?"),
        ('<joint name="1"', '<Joint name="1"', r"did you mean <joint>\?"),
        ('<link name="a"', '<lnik name="a"', r"unknown element <lnik> of 'a'.*did you mean <link>\?"),
        ("<limit", "<limits", r"unknown element <limits> of '1'.*did you mean <limit>\?"),
        ("<origin", "<orign", r"unknown element <orign> of '1'.*did you mean <origin>\?"),
    ],
)
def test_a_misspelt_element_is_not_passed_over(right, wrong, message):
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><joint name="1" type="revolute"><parent link="a"/>'
        '<child link="b"/><origin xyz="0 0 1"/><limit lower="0" upper="1"/></joint></robot>'
    )
    assert read_chain(text).n == 1
    wrong_end = text.replace(right, wrong, 1)
    if right.startswith("<joint"):
        wrong_end = wrong_end.replace("</joint>", f"</{wrong[1:].split()[0]}>")
    with pytest.raises(InvalidInputError, match=message):
        read_chain(wrong_end)


def test_elements_of_vendors_are_passed_over():
    more = (
        '<gazebo reference="a"/><transmission name="t" type="x"/><ros2_control name="c" type="system"/>'
        '<material name="m"/><loop_joint name="l" link1="a"/><point name="p" x="1"/><sensor name="s" type="t"/>'
    )
    text = robot(joint("1", "a", "b"), links="ab").replace("<robot>", f"<robot>{more}")
    assert read_chain(text).n == 1


def test_long_lists_of_names_are_cut_short():
    links = ["a", *[f"b{i}" for i in range(30)]]
    text = robot(*[joint(f"j{i}", "a", f"b{i}") for i in range(30)], links=links)
    with pytest.raises(InvalidInputError, match=r"such as b0, b1, b2, b3, b4, b5, b6, b7 and 22 more$"):
        read_chain(text)


def test_load_chain_names_the_file(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text("\ufeff" + robot(joint("1", "a", "b"), links="ab"), encoding="utf-8")
    assert load_chain(file).names == ("1",)
    assert load_chain(str(file), "a", "b").names == ("1",)
    with pytest.raises(InvalidInputError, match=r"arm\.urdf: tip: is not a link"):
        load_chain(file, tip="c")
    with pytest.raises(InvalidInputError, match=r"none\.urdf: does not exist"):
        load_chain(tmp_path / "none.urdf")
    with pytest.raises(InvalidInputError, match="is a folder"):
        load_chain(tmp_path)
    with pytest.raises(InvalidInputError, match="is no name of a file"):
        load_chain("a\0b")
    file.write_bytes(b"\xff\xfe\xff")
    with pytest.raises(InvalidInputError, match="is not a UTF-8 text file"):
        load_chain(file)
    file.write_bytes(b" " * (MAX_SIZE + 1))
    with pytest.raises(InvalidInputError, match=r"arm\.urdf: urdf: is larger than 10 MB"):
        load_chain(file)


# What comes with the package.

DEGREES = np.pi / 180
IIWA_LIMITS = np.array([170, 120, 170, 120, 170, 120, 175]) * DEGREES
PANDA_LOWER = [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]
PANDA_UPPER = [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]
FR3_LOWER = [-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159]
FR3_UPPER = [2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159]
UR_LIMITS = np.array([TAU, TAU, np.pi, TAU, TAU, TAU])

# file: lower, upper, speeds
SHIPPED = {
    "panda": (PANDA_LOWER, PANDA_UPPER, [2.175] * 4 + [2.61] * 3),
    "fr3": (FR3_LOWER, FR3_UPPER, [2.62] * 4 + [5.26, 4.18, 5.26]),
    "iiwa7": (-IIWA_LIMITS, IIWA_LIMITS, np.array([98, 98, 100, 130, 140, 180, 180]) * DEGREES),
    "iiwa14": (-IIWA_LIMITS, IIWA_LIMITS, np.array([85, 85, 100, 75, 130, 135, 135]) * DEGREES),
    "ur5e": (-UR_LIMITS, UR_LIMITS, [np.pi] * 6),
    "ur10e": (-UR_LIMITS, UR_LIMITS, np.array([120, 120, 180, 180, 180, 180]) * DEGREES),
    "irb120": (
        np.array([-165, -110, -110, -160, -120, -400]) * DEGREES,
        np.array([165, 110, 70, 160, 120, 400]) * DEGREES,
        np.array([250, 250, 250, 320, 320, 420]) * DEGREES,
    ),
    "kr6r900": (
        np.array([-170, -190, -120, -185, -120, -350]) * DEGREES,
        np.array([170, 45, 156, 185, 120, 350]) * DEGREES,
        np.array([360, 300, 360, 381, 388, 615]) * DEGREES,
    ),
}


def test_every_shipped_arm_is_tested():
    assert {Path(str(entry)).stem for entry in DATA.iterdir()} == set(SHIPPED)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_arm_loads_with_its_limits(name):
    lower, upper, speeds = SHIPPED[name]
    chain = load_chain(DATA / f"{name}.urdf")
    np.testing.assert_allclose(chain.limits.lower, lower, rtol=1e-15)
    np.testing.assert_allclose(chain.limits.upper, upper, rtol=1e-15)
    np.testing.assert_allclose(chain.velocity, speeds, rtol=1e-15)
    assert not chain.prismatic.any()
    text = (DATA / f"{name}.urdf").read_text(encoding="utf-8")
    assert "Source:" in text
    assert "Checked:" in text
    q = np.random.default_rng(1).uniform(lower, upper, (20, chain.n))
    expected = [oracle(text, chain.base, chain.tip, row) for row in q]
    np.testing.assert_allclose(chain.forward(q), expected, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "base", "wrist", "reach"),
    [
        ("iiwa7", "link_2", "link_6", 0.8),
        ("iiwa14", "link_2", "link_6", 0.82),
        ("irb120", "link_2", "link_5", 0.58),
        ("kr6r900", "link_1", "link_5", 0.9015),
        ("ur5e", "upper_arm_link", "wrist_1_link", 0.425 + 0.3922),
        ("ur10e", "upper_arm_link", "wrist_1_link", 0.6127 + 0.57155),
    ],
)
def test_reach_from_shoulder_to_wrist(name, base, wrist, reach):
    """The published reach; for the Universal Robots the sum of both long links."""
    chain = load_chain(DATA / f"{name}.urdf", base, wrist)
    q = np.zeros((20_001, chain.n))
    # The elbow decides, and with it, for the arm whose shoulder is off axis 1, the joint that points it outward.
    elbow = {"link_1": 1, "link_2": 1 if name.startswith("iiwa") else 0, "upper_arm_link": 0}[base]
    q[:, elbow] = np.linspace(-np.pi, np.pi, len(q))
    points = chain.forward(q)[:, :3, 3]
    if base == "link_1":
        shoulder = load_chain(DATA / f"{name}.urdf", "base_link", "link_2").forward([0, 0])[:3, 3]
        offset = shoulder[0]
        arm = load_chain(DATA / f"{name}.urdf", "link_2", "link_5").forward(q[:, 1:])[:, :3, 3]
        distance = offset + np.linalg.norm(arm, axis=1)
    else:
        distance = np.linalg.norm(points, axis=1)
    assert distance.max() == pytest.approx(reach, abs=5e-5)


def classic(theta, d, a, alpha):
    """Denavit–Hartenberg, Rz(θ) Tz(d) Tx(a) Rx(α)."""
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]])


def modified(theta, d, a, alpha):
    """Craig's convention, Rx(α) Tx(a) Rz(θ) Tz(d)."""
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[ct, -st, 0, a], [st * ca, ct * ca, -sa, -d * sa], [st * sa, ct * sa, ca, d * ca], [0, 0, 0, 1]])


H = np.pi / 2
# rows: d, a, α, and the angle added to the joint's
FRANKA = [
    (0.333, 0, 0, 0),
    (0, 0, -H, 0),
    (0.316, 0, H, 0),
    (0, 0.0825, H, 0),
    (0.384, -0.0825, -H, 0),
    (0, 0, H, 0),
    (0, 0.088, H, 0),
    (0.107, 0, 0, None),
]


def lbr(d1, d3, d5, d7):
    alphas = [-H, H, H, -H, -H, H, 0]
    return [(d, 0, alpha, 0) for d, alpha in zip([d1, 0, d3, 0, d5, 0, d7], alphas, strict=True)]


def universal(d1, a2, a3, d4, d5, d6):
    return [(d1, 0, H, 0), (0, a2, 0, 0), (0, a3, 0, 0), (d4, 0, H, 0), (d5, 0, -H, 0), (d6, 0, 0, 0)]


ABB = [(0.29, 0, -H, 0), (0, 0.27, 0, -H), (0, 0.07, -H, 0), (0.302, 0, H, 0), (0, 0, -H, 0), (0.072, 0, 0, np.pi)]

TABLES = {
    "panda": (modified, FRANKA, "panda_link0", "panda_link8"),
    "fr3": (modified, FRANKA, "fr3_link0", "fr3_link8"),
    "iiwa7": (classic, lbr(0.34, 0.4, 0.4, 0.126), "link_0", "link_ee"),
    "iiwa14": (classic, lbr(0.36, 0.42, 0.4, 0.126), "link_0", "link_ee"),
    "ur5e": (classic, universal(0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996), "base", "tool0"),
    "ur10e": (classic, universal(0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655), "base", "tool0"),
    "irb120": (classic, ABB, "base_link", "tool0"),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_shipped_arm_against_its_denavit_hartenberg_table(name):
    transform, table, base, tip = TABLES[name]
    chain = load_chain(DATA / f"{name}.urdf", base, tip)
    for q in np.random.default_rng(2).uniform(-3, 3, (200, chain.n)):
        pose = np.eye(4)
        for row, (d, a, alpha, added) in enumerate(table):
            theta = 0.0 if added is None else q[row] + added
            pose = pose @ transform(theta, d, a, alpha)
        np.testing.assert_allclose(chain.forward(q), pose, atol=1e-14)


def test_the_hand_sits_at_the_flange_turned_back():
    for name, start in (("panda", "panda"), ("fr3", "fr3")):
        flange, hand = (load_chain(DATA / f"{name}.urdf", tip=f"{start}_{tip}") for tip in ("link8", "hand"))
        q = np.random.default_rng(3).uniform(-1, 1, 7)
        between = np.linalg.inv(flange.forward(q)) @ hand.forward(q)
        np.testing.assert_allclose(between, rigid(Rotation.from_euler("z", -45, degrees=True), [0, 0, 0]), atol=1e-15)


def test_the_agilus_against_a_product_of_exponentials():
    """Axes and points on them at zero, in the base's frame: T = exp(ξ1 q1) … exp(ξ6 q6) T(0)."""
    axes = np.array([[0, 0, -1], [0, 1, 0], [0, 1, 0], [-1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    points = np.array([[0, 0, 0], [0.025, 0, 0.4], [0.48, 0, 0.4], [0, 0, 0.435], [0.9, 0, 0.435], [0, 0, 0.435]])
    home = rigid(Rotation.from_euler("y", 90, degrees=True), [0.98, 0, 0.435])
    chain = load_chain(DATA / "kr6r900.urdf")
    for q in np.random.default_rng(4).uniform(-3, 3, (50, 6)):
        pose = np.eye(4)
        for w, p, angle in zip(axes, points, q, strict=True):
            twist = np.zeros((4, 4))
            twist[:3, :3] = np.cross(np.eye(3), w)
            twist[:3, 3] = np.cross(p, w)
            pose = pose @ expm(twist * angle)
        np.testing.assert_allclose(chain.forward(q), pose @ home, atol=1e-13)


def test_the_research_3_is_a_panda_with_other_limits():
    panda, other = load_chain(DATA / "panda.urdf"), load_chain(DATA / "fr3.urdf")
    np.testing.assert_array_equal(panda.offsets, other.offsets)


def test_a_spherical_wrist_and_shoulder_stay_where_they_are():
    """Axes 1–3 of an iiwa meet in the shoulder, axes 5–7 in the wrist, whatever the joints do."""
    q = np.random.default_rng(5).uniform(-2, 2, (100, 7))
    for name, height in (("iiwa7", 0.34), ("iiwa14", 0.36)):
        pose = load_chain(DATA / f"{name}.urdf").forward(q)
        still = load_chain(DATA / f"{name}.urdf", "link_0", "link_3").forward(q[:, :3])
        np.testing.assert_allclose(still[:, :3, 3], np.tile([0, 0, height], (100, 1)), atol=1e-15)
        wrist = pose[:, :3, 3] - 0.126 * pose[:, :3, 2]
        behind = load_chain(DATA / f"{name}.urdf", "link_0", "link_6").forward(q[:, :6])[:, :3, 3]
        np.testing.assert_allclose(wrist, behind, atol=1e-15)


# Descriptions of the same arms in other packages, where those happen to be installed.
COMPAS = "compas_fab/data/robot_library"
CMEEL = "cmeel.prefix/share/example-robot-data/robots"
KUKA = "rtbdata/xacro/kuka_description"
PANDA_FILE = f"{CMEEL}/panda_description/urdf/panda.urdf"
IIWA_FILE = "pybullet_data/kuka_iiwa/model.urdf"
AGILUS_FILE = f"{KUKA}/kuka_kr6/urdf/kr6r900sixx_macro.xacro"

# our arm, their file, their base and tip, what they lack at the tip, how far they are rounded, whether they have the
# same limits and the same speeds
OTHERS = [
    ("panda", PANDA_FILE, "panda_link0", "panda_hand", 0, 1e-14, True, True),
    ("panda", f"{COMPAS}/panda/urdf/robot_description.urdf", "panda_link0", "panda_hand", 0, 1e-14, True, True),
    ("panda", "pybullet_data/franka_panda/panda.urdf", "panda_link0", "panda_hand", 0, 2e-11, False, True),
    ("iiwa14", IIWA_FILE, "lbr_iiwa_link_0", "lbr_iiwa_link_7", 0.045, 1e-10, True, False),
    ("iiwa14", f"{KUKA}/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf", "base_link", "tool0", 0, 1e-3, True, True),
    ("ur10e", f"{COMPAS}/ur10e_robot/urdf/robot_description.urdf", "base_link", "tool0", 0, 1e-8, True, True),
    ("irb120", f"{COMPAS}/abb_irb120_3_58/urdf/robot_description.urdf", "base_link", "tool0", 0, 1e-14, True, True),
    ("kr6r900", AGILUS_FILE, "base_link", "tool0", 0, 1e-14, True, True),
]


def installed(file):
    """The text of an installed package's file, found without importing it."""
    for folder in sys.path:
        found = Path(folder) / file
        if found.is_file():
            return found.read_text(encoding="utf-8")
    return None


def expanded(text):
    """A xacro macro as URDF, as far as these files need it: no prefix, and degrees."""
    text = re.sub("<xacro:[^>]*/>", "", text.replace("${prefix}", ""))
    number = re.compile(r"\$\{(-?)DEG2RAD \* ([0-9.]+)\}")
    text = number.sub(lambda match: f"{match[1]}{np.radians(float(match[2]))!s}", text)
    inner = re.search(r"<xacro:macro[^>]*>(.*)</xacro:macro>", text, re.DOTALL)
    return text if inner is None else f"<robot>{inner[1]}</robot>"


@pytest.mark.parametrize(
    ("name", "file", "base", "tip", "flange", "rounding", "same_limits", "same_speeds"),
    OTHERS,
    ids=[f"{row[0]} {row[1].split('/')[0]}" for row in OTHERS],
)
def test_a_shipped_arm_against_another_description(name, file, base, tip, flange, rounding, same_limits, same_speeds):
    text = installed(file)
    if text is None:
        pytest.skip(f"{file} is not installed")
    text = expanded(text)
    chain, other = load_chain(DATA / f"{name}.urdf"), read_chain(text, base, tip)
    end = rigid(Rotation.identity(), [0, 0, flange])
    q = np.random.default_rng(6).uniform(chain.limits.lower, chain.limits.upper, (300, chain.n))
    expected = np.array([oracle(text, base, tip, row) @ end for row in q])
    np.testing.assert_allclose(chain.forward(q), expected, atol=rounding)
    np.testing.assert_allclose(other.with_tool(end).forward(q), expected, atol=1e-14)
    if same_limits:
        np.testing.assert_allclose(chain.limits.lower, other.limits.lower, atol=5e-4)
        np.testing.assert_allclose(chain.limits.upper, other.limits.upper, atol=5e-4)
    if same_speeds:
        np.testing.assert_allclose(chain.velocity, other.velocity, atol=5e-4)
