"""The algebra of rotations, against scipy's and against itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

import selfmotion as sm
from selfmotion import rotations as rot

RNG = np.random.default_rng(11)
SOME = rot.upper(RNG.normal(size=(200, 4)))
SOME /= np.linalg.norm(SOME, axis=1, keepdims=True)
# Half turns about the axes and between them, the identity, and rotations next to both.
SPECIAL = np.array(
    [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0.6, 0.8, 0], [1, 1e-9, 0, 0], [1e-9, 0, 0, 1]]
)
ALL = np.concatenate([SOME, SPECIAL])


def theirs(q):
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def ours(rotation):
    return np.roll(rotation.as_quat(), 1, axis=-1)


def same(a, b, atol=1e-14):
    np.testing.assert_allclose(np.minimum(np.abs(a - b).max(axis=-1), np.abs(a + b).max(axis=-1)), 0, atol=atol)


def test_products_matrices_and_turned_vectors_are_scipy_s():
    other, v = ALL[::-1], RNG.normal(size=(len(ALL), 3))
    same(rot.product(ALL, other), ours(theirs(ALL) * theirs(other)))
    np.testing.assert_allclose(rot.matrix(ALL), theirs(ALL).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(rot.rotate(ALL, v), theirs(ALL).apply(v), atol=1e-13)
    same(rot.product(ALL, rot.conjugate(ALL)), np.array([1.0, 0, 0, 0]))


def test_matrices_give_their_quaternions_back():
    np.testing.assert_allclose(rot.from_matrix(rot.matrix(ALL)), ALL, atol=1e-14)
    np.testing.assert_array_equal(rot.from_matrix(np.diag([1.0, -1.0, -1.0])), [0, 1, 0, 0])


def test_logarithm_and_exponential_are_scipy_s_and_undo_each_other():
    np.testing.assert_allclose(rot.logarithm(SOME), theirs(SOME).as_rotvec(), atol=1e-13)
    np.testing.assert_allclose(rot.exponential(rot.logarithm(ALL)), ALL, atol=1e-14)
    tiny = np.array([1e-100, -1e-12, 1e-7]) * np.eye(3)
    np.testing.assert_allclose(rot.logarithm(rot.exponential(tiny)), tiny, rtol=1e-12)
    np.testing.assert_array_equal(rot.logarithm(np.array([1.0, 0, 0, 0])), 0)
    # A quaternion of the lower half says the long way round.
    long = rot.logarithm(np.array([np.cos(2.0), np.sin(2.0), 0, 0]))
    np.testing.assert_allclose(long, [4, 0, 0], rtol=1e-15)


def test_slerp_is_scipy_s():
    t = np.linspace(0, 1, 13)
    for a, b in zip(SOME[:50], SOME[50:100], strict=True):
        shorter = rot.continuous(np.stack([a, b]))
        path = Slerp([0, 1], theirs(np.stack([a, b])))(t)
        same(rot.slerp(*shorter, t), ours(path), 1e-13)


def test_slerp_of_the_same_and_of_half_turns():
    identity, half = np.array([1.0, 0, 0, 0]), np.array([0.0, 1.0, 0, 0])
    t = np.array([0.0, 0.5, 1.0])
    np.testing.assert_array_equal(rot.slerp(identity, identity, t), np.tile(identity, (3, 1)))
    np.testing.assert_allclose(rot.slerp(identity, half, t)[1], [np.sqrt(0.5), np.sqrt(0.5), 0, 0], atol=1e-15)
    np.testing.assert_allclose(rot.slerp(identity, -half, t)[1], [np.sqrt(0.5), -np.sqrt(0.5), 0, 0], atol=1e-15)


def test_apart_is_the_angle_between_rotations():
    found = rot.apart(ALL, ALL[::-1])
    np.testing.assert_allclose(found, (theirs(ALL).inv() * theirs(ALL[::-1])).magnitude(), atol=1e-7)
    np.testing.assert_allclose(rot.apart(ALL, -ALL), 0, atol=1e-15)


def test_signs_are_made_continuous_and_half_turns_keep_theirs():
    fine = rot.exponential(np.linspace(0, 20, 100)[:, None] * np.array([0.6, 0, 0.8]))
    random = fine * np.random.default_rng(2).choice([-1.0, 1.0], size=(100, 1))
    found = rot.continuous(random)
    np.testing.assert_array_equal(found, fine if random[0, 0] > 0 else -fine)
    halves = np.array([[1.0, 0, 0, 0], [-1e-17, -1.0, 0, 0], [-1, 0, 0, 0]])
    np.testing.assert_array_equal(rot.continuous(halves), halves)


def test_the_upper_sign():
    q = np.array([[-0.6, 0.8, 0, 0], [0, -1, 0, 0], [-1e-17, 0, 1, 0], [0.0, 0, 0, -1]])
    np.testing.assert_array_equal(rot.upper(q), [[0.6, -0.8, 0, 0], [0, 1, 0, 0], [-1e-17, 0, 1, 0], [0, 0, 0, 1]])


angle = st.floats(-10, 10)


@given(st.tuples(angle, angle, angle))
def test_roll_pitch_yaw_are_scipy_s(rpy):
    same(rot.from_rpy("rpy", rpy), ours(Rotation.from_euler("xyz", rpy)), 1e-13)


def test_nearly_unit_quaternions_are_normalized():
    q = rot.unit_quaternions("q", [[1 + 9e-7, 0, 0, 0], [0.6, 0.8, 0, 0]])
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, rtol=1e-15)
    np.testing.assert_array_equal(rot.rotation("q", np.eye(3)), [1, 0, 0, 0])


C, S = np.cos(0.3), np.sin(0.3)
BAD = {
    "its norm is 1.00001": [1.00001, 0, 0, 0],
    "its norm is 0": [0, 0, 0, 0],
    "is scaled by 2": 2 * np.array([[C, -S, 0], [S, C, 0], [0, 0, 1]]),
    "is a reflection": np.diag([1, 1, -1]),
    "not orthogonal": [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]],
    "equally long": np.diag([1, 1, 1.1]),
    "orthogonal": [[1, 0, 0], [1, 0, 0], [1, 0, 0]],
    "has shape (2, 3)": [[1, 0, 0], [0, 1, 0]],
    "has shape (3,)": [1, 0, 0],
    "NaN": [np.nan, 0, 0, 0],
    "is not made of numbers": ["1", 0, 0, 0],
    "numbers of equal length": [[1, 0], [0]],
}


@pytest.mark.parametrize("reason", BAD)
def test_what_is_no_rotation_is_refused_with_the_reason(reason):
    with pytest.raises(sm.InvalidInputError) as caught:
        rot.rotation("orientation", BAD[reason])
    assert reason in str(caught.value)
    assert caught.value.field == "orientation"
    assert caught.value.remedy


def test_a_row_that_is_no_unit_quaternion_is_named():
    with pytest.raises(sm.InvalidInputError, match=r"q\.1: is no unit quaternion: its norm is 0\.5"):
        rot.unit_quaternions("q", [[1, 0, 0, 0], [0.5, 0, 0, 0]])
