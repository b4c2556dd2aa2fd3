"""Chains: forward kinematics against products of exponentials and rotation vectors, which share no formula with it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from selfmotion.arms import JointLimits
from selfmotion.arms.chain import Chain, turned_to_z
from selfmotion.errors import InvalidInputError

AXES = {
    "x": (1, 0, 0),
    "−x": (-1, 0, 0),
    "y": (0, 1, 0),
    "−y": (0, -1, 0),
    "z": (0, 0, 1),
    "−z": (0, 0, -1),
    "oblique": (1, -2, 3),
    "long": (3e90, 4e90, 0),
    "short": (3e-200, 0, -4e-200),
    "near z": (1e-12, 0, 1),
    "near −z": (1e-12, -1e-9, -1),
    "next to −z": (1e-300, 0, -1),
}


def rigid(rotation, translation=(0, 0, 0)):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation.as_matrix(), translation
    return pose


def random_poses(rng, count):
    return np.array([rigid(Rotation.random(rng=rng), rng.uniform(-1, 1, 3)) for _ in range(count)])


def unit(axis):
    axis = np.asarray(axis, dtype=float) / np.abs(axis).max()
    return axis / np.linalg.norm(axis)


def exponential(axis, prismatic, q):
    """The joint's own motion as exp of its twist."""
    twist = np.zeros((4, 4))
    x, y, z = unit(axis)
    if prismatic:
        twist[:3, 3] = x, y, z
    else:
        twist[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return expm(twist * q)


def oracle(origins, axes, prismatic, q):
    pose = origins[0]
    for j, axis in enumerate(axes):
        pose = pose @ exponential(axis, prismatic[j], q[j]) @ origins[j + 1]
    return pose


def random_chain(rng, n):
    origins, axes = random_poses(rng, n + 1), rng.normal(size=(n, 3))
    prismatic = rng.random(n) < 0.3
    names = [f"joint {j}" for j in range(n)]
    limits = [None if rng.random() < 0.3 else (-2 - j, 3 + j) for j in range(n)]
    chain = Chain(names, turned_to_z(origins, axes), limits, prismatic, 1.0 + np.arange(n), "here", "there")
    return chain, origins, axes


def one_joint(axis, prismatic=False):
    origins = random_poses(np.random.default_rng(3), 2)
    return Chain(["a"], turned_to_z(origins, [axis]), prismatic=[prismatic]), origins


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
@pytest.mark.parametrize("prismatic", [False, True])
def test_any_axis_keeps_its_sign(axis, prismatic):
    chain, origins = one_joint(axis, prismatic)
    for q in (0.0, 0.3, -1.2, 2.9, -7.5):
        along = unit(axis) * q
        own = rigid(Rotation.identity(), along) if prismatic else rigid(Rotation.from_rotvec(along))
        np.testing.assert_allclose(chain.forward([q]), origins[0] @ own @ origins[1], atol=1e-14)


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_the_turn_into_the_axis_is_the_smallest(axis):
    turn = turned_to_z([np.eye(4), np.eye(4)], [axis])[0]
    assert turn[:3, 2] == pytest.approx(unit(axis), abs=1e-15)
    angle = np.arctan2(np.hypot(*unit(axis)[:2]), unit(axis)[2])
    assert Rotation.from_matrix(turn[:3, :3]).magnitude() == pytest.approx(angle, abs=1e-9)
    np.testing.assert_allclose(turn.T @ turn, np.eye(4), atol=1e-15)


def test_the_opposite_axis_is_a_half_turn_about_x():
    assert np.diag(turned_to_z([np.eye(4), np.eye(4)], [[0, 0, -2]])[0]).tolist() == [1, -1, -1, 1]


@pytest.mark.parametrize("n", [1, 2, 3, 6, 7, 12])
def test_forward_is_a_product_of_exponentials(n):
    rng = np.random.default_rng(n)
    for _ in range(10):
        chain, origins, axes = random_chain(rng, n)
        q = rng.uniform(-4, 4, (5, n))
        expected = [oracle(origins, axes, chain.prismatic, row) for row in q]
        np.testing.assert_allclose(chain.forward(q), expected, atol=1e-13 * n)


def test_forward_takes_any_leading_shape():
    chain, _, _ = random_chain(np.random.default_rng(1), 4)
    q = np.random.default_rng(2).uniform(-1, 1, (2, 3, 4))
    poses = chain.forward(q)
    assert poses.shape == (2, 3, 4, 4)
    for index in np.ndindex(2, 3):
        np.testing.assert_array_equal(poses[index], chain.forward(q[index]))
    assert chain.forward(np.empty((0, 4))).shape == (0, 4, 4)
    assert chain.forward([0, 0, 0, 0]).shape == (4, 4)


@given(arrays(float, (7,), elements=st.floats(-100, 100)))
def test_what_comes_out_is_rigid(q):
    chain, _, _ = random_chain(np.random.default_rng(7), 7)
    pose = chain.forward(q)
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-13)
    assert pose[3].tolist() == [0, 0, 0, 1]


def test_with_tool_adds_a_transform_at_the_tip():
    rng = np.random.default_rng(4)
    chain, _, _ = random_chain(rng, 5)
    tool = random_poses(rng, 1)[0]
    longer = chain.with_tool(tool)
    q = rng.uniform(-3, 3, (20, 5))
    np.testing.assert_allclose(longer.forward(q), chain.forward(q) @ tool, atol=1e-14)
    assert (longer.names, longer.base, longer.tip) == (chain.names, "here", "there")
    assert longer.limits.as_list() == chain.limits.as_list()
    assert longer.velocity.tolist() == chain.velocity.tolist()


@pytest.mark.parametrize("j", range(5))
def test_locked_holds_one_joint(j):
    rng = np.random.default_rng(j)
    chain, _, _ = random_chain(rng, 5)
    held = chain.locked(j, 0.7)
    q = rng.uniform(-3, 3, (20, 4))
    np.testing.assert_allclose(held.forward(q), chain.forward(np.insert(q, j, 0.7, axis=1)), atol=1e-14)
    others = [i for i in range(5) if i != j]
    assert held.n == 4
    assert held.names == tuple(chain.names[i] for i in others)
    assert held.prismatic.tolist() == chain.prismatic[others].tolist()
    assert held.limits.lower.tolist() == chain.limits.lower[others].tolist()
    assert held.limits.upper.tolist() == chain.limits.upper[others].tolist()
    assert held.velocity.tolist() == chain.velocity[others].tolist()


def test_locking_twice_is_locking_both():
    chain, _, _ = random_chain(np.random.default_rng(9), 4)
    q = np.array([0.1, -0.5])
    pose = chain.locked(1, 0.4).locked(1, -1.1).forward(q)
    np.testing.assert_allclose(pose, chain.forward([0.1, 0.4, -1.1, -0.5]), atol=1e-14)


def test_a_chain_cannot_be_changed_by_accident():
    offsets = random_poses(np.random.default_rng(5), 3)
    chain = Chain(["a", "b"], offsets)
    offsets[0, 0, 3] = 99.0
    assert chain.offsets[0, 0, 3] != 99.0
    for array in (chain.offsets, chain.prismatic, chain.velocity):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert chain.limits.as_list() == [None, None]
    assert np.isinf(chain.velocity).all()
    assert repr(chain) == "Chain('base' to 'tip', joints a, b)"


def test_limits_may_come_ready_made():
    limits = JointLimits([None, (-1, 1)], 2)
    assert Chain(["a", "b"], [np.eye(4)] * 3, limits).limits is limits


def bent(**entries):
    offsets = np.array([np.eye(4)] * 3)
    for place, value in entries.items():
        i, j = map(int, place[1:])
        offsets[1, i, j] = value
    return offsets


def scaled(factor):
    offsets = bent()
    offsets[1, :3, :3] *= factor
    return offsets


@pytest.mark.parametrize(
    ("offsets", "message"),
    [
        (scaled(1.5), r"offsets\.1: is not a rigid transform: its rotation is scaled by 1\.5; give a rotation"),
        (scaled(1 + 1e-8), r"its rotation is scaled by 1\.00000001;"),
        (scaled(-1), r"offsets\.1: is not a rigid transform: its rotation is a mirror image"),
        (scaled(0), r"its rotation is scaled by 0;"),
        (bent(_00=0.0), r"its rotation is not orthonormal, its columns being off by 1;"),
        (bent(_01=1e-3), r"its rotation is not orthonormal, its columns being off by 0\.001;"),
        (bent(_30=1.0), r"offsets\.1: is not a rigid transform: its last row is not 0 0 0 1"),
        (bent(_03=np.nan), "offsets: contains NaN"),
        (bent()[:2], r"offsets: has shape \(2, 4, 4\); give shape \(3, 4, 4\)"),
        (np.eye(4), r"offsets: has shape \(4, 4\)"),
    ],
)
def test_offsets_that_are_not_rigid_are_refused(offsets, message):
    with pytest.raises(InvalidInputError, match=message):
        Chain(["a", "b"], offsets)


def test_rounding_is_no_reason_to_refuse():
    assert Chain(["a", "b"], scaled(1 + 4e-10)).n == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"names": []}, "names: has 0 entries"),
        ({"names": "ab"}, "names: has 0 entries"),
        ({"names": ["a", "a"]}, r"names\.1: occurs twice"),
        ({"names": ["a", ""]}, r"names\.1: is not a name"),
        ({"limits": [None]}, "limits: needs one entry per joint, 2"),
        ({"limits": JointLimits(None, 3)}, "limits: is for 3 joints; give 2"),
        ({"limits": [(1, -1), None]}, r"limits\.0: is reversed"),
        ({"prismatic": [True]}, "prismatic: is not one true or false per joint"),
        ({"prismatic": [0, 1]}, "prismatic: is not one true or false per joint"),
        ({"velocity": [1.0]}, r"velocity: has shape \(1,\)"),
        ({"velocity": [1.0, 0.0]}, r"velocity\.1: must be greater than zero"),
        ({"velocity": [np.nan, 1.0]}, r"velocity\.0: must be greater than zero"),
        ({"velocity": ["fast", 1.0]}, "velocity: is not made of numbers"),
        ({"velocity": [[1.0], 1.0]}, "velocity: is not an array of numbers"),
    ],
)
def test_other_arguments_that_make_no_sense_are_refused(arguments, message):
    with pytest.raises(InvalidInputError, match=message):
        Chain(**{"names": ["a", "b"], "offsets": bent(), **arguments})


def test_calls_that_make_no_sense_are_refused():
    chain = Chain(["a", "b"], bent(), [(-1, 1), None])
    with pytest.raises(InvalidInputError, match=r"q: has shape \(3,\); give shape \(\.\.\., 2\)"):
        chain.forward([0, 0, 0])
    with pytest.raises(InvalidInputError, match=r"q: has shape \(\)"):
        chain.forward(0.0)
    with pytest.raises(InvalidInputError, match=r"transform: is not a rigid transform: its rotation is scaled by 2"):
        chain.with_tool(np.diag([2, 2, 2, 1]))
    with pytest.raises(InvalidInputError, match=r"transform: has shape \(3, 4\)"):
        chain.with_tool(np.eye(4)[:3])
    with pytest.raises(InvalidInputError, match=r"joint_index: is outside \[0, 1\]"):
        chain.locked(2, 0.0)
    with pytest.raises(InvalidInputError, match=r"value: is outside the limits \[-1, 1\] of joint a"):
        chain.locked(0, 1.1)
    with pytest.raises(InvalidInputError, match="joint_index: is the only joint"):
        chain.locked(0, 0.0).locked(0, 0.0)
    with pytest.raises(InvalidInputError, match=r"axes\.0: is zero"):
        turned_to_z([np.eye(4)] * 2, [[0, 0, 0]])
    with pytest.raises(InvalidInputError, match=r"origins: has shape \(3, 4, 4\); give shape \(2, 4, 4\)"):
        turned_to_z([np.eye(4)] * 3, [[0, 0, 1]])
