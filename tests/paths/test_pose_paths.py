"""Paths of poses: exact derivatives, unit quaternions, proved bounds, and every way to get one wrong."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp
from test_paths import EXAMPLES
from test_speed_bounds import MORE, parts

import selfmotion as sm
from selfmotion.paths import PATHS, Path, Section, angular_velocity, rotation_matrix
from selfmotion.paths.base import distance
from selfmotion.paths.orientation import GreatCircles, RotationSpline
from selfmotion.rotations import apart, continuous, exponential, from_matrix, product, rotate

RNG = np.random.default_rng(8)
IDENTITY = [1.0, 0, 0, 0]
LINE = sm.Line([0.45, 0.5422, 0.7885], [-0.45, 0.5422, 0.7885])
CURVE = sm.Bezier([[0, 0, 0], [1, 0, 0.2], [1, 1, 0.4], [2, 1, -0.4], [3, 0, 0.1]])
ROUND = sm.Placed(sm.Circle([0, 0], 0.2), {"translation": [0.45, 0, 0.4], "normal": [1, 0, 0], "x_axis": [0, 1, 0]})
WAVE = sm.Waypoints([[0, 0, 0], [1, 0.3, 0.2], [2, -0.4, 0.1], [3, 0.2, -0.3]], "spline")
SEAM = sm.Concatenation(
    [sm.Line([0, -1, 0], [1, -1, 0]), sm.Placed(sm.Arc([1, 0], 1, -np.pi / 2, np.pi)), sm.Line([1, 1, 0], [0, 1, 0])]
)


def wandering(k, step=0.6, seed=3):
    rng = np.random.default_rng(seed)
    q = [np.array(IDENTITY)]
    for _ in range(k - 1):
        q.append(product(q[-1], exponential(step * rng.normal(size=3))))
    return np.array(q) * rng.choice([-1.0, 1.0], size=(k, 1))


def rows(k=9, step=0.6, seed=3):
    return np.hstack([np.random.default_rng(seed).normal(size=(k, 3)), wandering(k, step, seed)])


CLOSED = rows(6)
CLOSED[-1] = CLOSED[0] * [1, 1, 1, -1, -1, -1, -1]
UPPER = [[1, 0, 0, 0], [0.6, 0, 0.8, 0], [0, 0.6, 0.8, 0], [0, 0.6, 0, 0.8]]
POSES = {
    "constant": sm.PosePath(CURVE, orientation=[0, 1, 0, 0]),
    "slerp": sm.PosePath(CURVE, orientations=UPPER, at=[0, 0.2, 0.7, 1]),
    "spline": sm.PosePath(CURVE, orientations=wandering(12), interpolation="spline"),
    "following x": sm.PosePath(CURVE, follow={"axis": "x", "up": [0, 0, 1]}),
    "following y": sm.PosePath(CURVE, follow={"axis": "y", "up": [0, 0.3, -1]}),
    "following z": sm.PosePath(WAVE, follow={"axis": "z", "up": [0.1, 0, 1]}),
    "round": sm.PosePath(ROUND, follow={"axis": "x", "up": [1, 0, 0]}),
    "seam": sm.PosePath(SEAM, follow={"axis": "x", "up": [0, 0, -1]}),
    "waypoints": sm.PoseWaypoints(rows()),
    "waypoints by length": sm.PoseWaypoints(rows(), parameter="length"),
    "smooth waypoints": sm.PoseWaypoints(rows(), "spline", "length"),
    "closed waypoints": sm.PoseWaypoints(CLOSED, "spline"),
    "two poses": sm.PoseWaypoints(rows(2), "spline"),
    "three poses": sm.PoseWaypoints(rows(3), "spline"),
    "large turns": sm.PoseWaypoints(rows(20, step=1.4), "spline"),
    "turning in place": sm.PoseWaypoints([[1, 2, 3, *IDENTITY], [1, 2, 3, 0, 1, 0, 0], [1, 2, 3, 0, 0, 1, 0]]),
}
POSES |= {
    "reversed": sm.Reversed(POSES["slerp"]),
    "section": Section(POSES["smooth waypoints"], (0.3, 0.8)),
    "arc length": sm.ArcLength(POSES["following x"]),
    "arc length of slerp": sm.ArcLength(POSES["slerp"]),
    "concatenation": sm.Concatenation([POSES["slerp"], sm.Reversed(POSES["slerp"])]),
    "placed": sm.Placed(
        POSES["smooth waypoints"],
        {"translation": [1, 2, 3], "rpy": [0.3, -0.7, 2.9]},
        {"translation": [0.1, -0.2, 0.3], "quaternion": [0.6, 0, 0, 0.8]},
    ),
    "placed twice": sm.Placed(sm.Placed(POSES["following x"], {"rpy": [1, 2, 3]}), tool={"translation": [0, 0, 0.2]}),
}


def inner(path, n=300, gap=2e-3):
    r = np.linspace(gap, 1 - gap, n)
    return r[np.abs(r[:, None] - path.breaks).min(axis=1, initial=1.0) > gap] if len(path.breaks) else r


@pytest.mark.parametrize("name", POSES)
def test_derivatives_are_those_of_the_pose(name):
    path = POSES[name]
    r, h = inner(path), 1e-4
    stencil = [(-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12)]
    for order in (1, 2):
        difference = sum(weight * path(r + k * h, order - 1) for k, weight in stencil) / h
        scale = np.abs(path(r, order)).max() + np.abs(path(r, order - 1)).max()
        np.testing.assert_allclose(path(r, order), difference, atol=2e-6 * scale)


@pytest.mark.parametrize("name", POSES)
def test_quaternions_are_unit_and_continuous_in_sign(name):
    path = POSES[name]
    r = path.grid(2000)
    q, q1, q2 = (path(r, order)[:, 3:] for order in range(3))
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, atol=1e-14)
    assert ((q[1:] * q[:-1]).sum(axis=1) > 0.9).all()
    assert path(0.0)[3] >= -1e-12
    # The derivatives of |q|² vanish.
    speed = 1 + (q1 * q1).sum(axis=1)
    np.testing.assert_allclose((q * q1).sum(axis=1) / speed, 0, atol=1e-12)
    np.testing.assert_allclose(((q * q2).sum(axis=1) + (q1 * q1).sum(axis=1)) / speed, 0, atol=1e-11)


@pytest.mark.parametrize("name", POSES)
def test_angular_velocity_is_that_of_the_rotation_matrix(name):
    path = POSES[name]
    r, h = inner(path, 100), 1e-6
    omega = angular_velocity(path(r), path(r, 1))
    rate = (rotation_matrix(path(r + h)) - rotation_matrix(path(r - h))) / (2 * h)
    skew = rate @ np.swapaxes(rotation_matrix(path(r)), 1, 2)
    found = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    np.testing.assert_allclose(omega, found, atol=1e-6 * (1 + np.abs(omega).max()))


def quickest_sample(path, low, high, values):
    r = np.linspace(low, high, 201)
    near = [at + side for at in path.breaks for side in (-1e-12, 0.0, 1e-12)]
    return float(values(path, np.append(r, [at for at in near if low <= at <= high])).max())


def turns(path, r):
    return distance(angular_velocity(path(r), path(r, 1)))


def speeds(path, r):
    return distance(path(r, 1))


def bends(path, r):
    return distance(path(r, 2))


@pytest.mark.parametrize("name", POSES)
def test_no_sample_turns_or_moves_faster_than_the_bounds(name):
    path, rng = POSES[name], np.random.default_rng(3)
    for low, high in parts(rng):
        # Samples round too, at most by this.
        slack = 1 - 1e-13
        assert path.turning(low, high) >= quickest_sample(path, low, high, turns) * slack - 1e-13, (low, high)
        assert path.fastest(low, high) >= quickest_sample(path, low, high, speeds) * slack, (low, high)
    for at in path.breaks:
        assert path.turning(at, at) >= turns(path, np.array([at, max(at - 1e-13, 0.0)])).max() * slack - 1e-9


@pytest.mark.parametrize("name", [name for name in POSES if name != "placed"])
def test_the_bound_on_turning_is_sharp_on_narrow_parts(name):
    path, rng = POSES[name], np.random.default_rng(4)
    overall = turns(path, path.grid(500)).max()
    for low, high in parts(rng):
        if 0 < high - low < 2e-3 and not ((low <= path.breaks) & (path.breaks <= high)).any():
            # Following bounds |T'| by the whole of x'', along the tangent too.
            factor = 3.0 if "following" in name or name in ("arc length", "placed twice", "seam") else 1.0
            assert path.turning(low, high) <= factor * quickest_sample(path, low, high, turns) + 0.15 * overall


@pytest.mark.parametrize("name", ["slerp", "waypoints", "turning in place"])
def test_the_bound_of_slerp_is_exact(name):
    path = POSES[name]
    np.testing.assert_allclose(path.turning(0, 1), turns(path, path.grid(50)).max(), rtol=1e-11)


@pytest.mark.parametrize("kind", [kind for kind in MORE if kind not in ("arc_length",)])
def test_no_second_derivative_exceeds_its_bound(kind):
    path, rng = MORE[kind], np.random.default_rng(6)
    for low, high in parts(rng):
        most = quickest_sample(path, low, high, bends)
        assert path.bending(low, high) >= most * (1 - 1e-12) - 1e-9 * (1 + path.bending(0, 1)), (low, high)


@pytest.mark.parametrize("kind", [kind for kind in MORE if MORE[kind].highest_order == 3])
def test_third_derivatives_are_those_of_the_second(kind):
    path, h = MORE[kind], 1e-5
    r = inner(path, 100)
    slope = (path(r + h, 2) - path(r - h, 2)) / (2 * h)
    np.testing.assert_allclose(path(r, 3), slope, atol=1e-5 * (1 + np.abs(slope).max()))
    with pytest.raises(sm.InvalidInputError, match="must be 0, 1, 2 or 3"):
        path(r, 4)


@given(st.integers(2, 8), st.floats(0.01, 1.5), st.integers(0, 10**6), st.sampled_from(["linear", "spline"]))
def test_any_waypoints_are_passed_by_unit_quaternions_within_their_bounds(k, step, seed, interpolation):
    given_rows = rows(k, step, seed)
    path = sm.PoseWaypoints(given_rows, interpolation)
    found = path(path.waypoints)
    np.testing.assert_allclose(found[:, :3], given_rows[:, :3], atol=1e-13)
    np.testing.assert_allclose(apart(found[:, 3:], given_rows[:, 3:]), 0, atol=1e-13)
    r = np.linspace(0, 1, 101)
    assert np.abs(np.linalg.norm(path(r)[:, 3:], axis=1) - 1).max() < 1e-13
    for low, high in ((0.0, 1.0), (0.2, 0.35), (0.5, 0.5)):
        samples = np.linspace(low, high, 41)
        assert path.turning(low, high) >= turns(path, samples).max() * (1 - 1e-12) - 1e-13
        assert path.fastest(low, high) >= speeds(path, samples).max() * (1 - 1e-12)
    # What the bound is for.
    assert apart(path(0.2)[3:], path(0.35)[3:]) <= 0.15 * path.turning(0.2, 0.35) + 1e-12


def test_slerp_is_scipy_s():
    path, given_rows = POSES["waypoints"], rows()
    r = np.linspace(0, 1, 401)
    slerp = Slerp(path.waypoints, Rotation.from_quat(np.roll(given_rows[:, 3:], -1, axis=1)))(r)
    np.testing.assert_allclose(rotation_matrix(path(r)), slerp.as_matrix(), atol=1e-13)


@pytest.mark.parametrize("name", ["spline", "smooth waypoints", "closed waypoints", "large turns", "three poses"])
def test_smooth_rotations_are_continuous_in_angular_velocity(name):
    path = POSES[name]
    for at in path.breaks:
        before, after = (angular_velocity(path(r), path(r, 1)) for r in (at - 1e-9, at))
        np.testing.assert_allclose(before, after, atol=1e-5 * path.turning(0, 1))


@pytest.mark.parametrize("name", ["spline", "smooth waypoints", "closed waypoints", "three poses"])
def test_smooth_rotations_are_continuous_in_angular_acceleration(name):
    path = POSES[name]
    scale = np.abs(path(path.grid(200), 2)).max()
    for at in path.breaks:
        np.testing.assert_allclose(path(at - 1e-11, 2), path(at, 2), atol=1e-7 * scale)


def test_a_closed_smooth_path_closes_smoothly():
    path = POSES["closed waypoints"]
    assert path.is_closed
    start, end = path([0.0, 1.0], 1)
    np.testing.assert_allclose(start[:3], end[:3], atol=1e-9)
    first, last = path([0.0, 1.0])
    np.testing.assert_allclose(angular_velocity(first, start), angular_velocity(last, end), atol=1e-9)


def test_turns_about_one_axis_are_the_cubic_spline_of_the_angle():
    """For a fixed axis the smooth curve is scipy's clamped spline of the angle."""
    from scipy.interpolate import CubicSpline

    knots, angles = np.array([0, 0.2, 0.5, 0.6, 1.0]), np.array([0.0, 0.9, 0.4, 1.5, 3.0])
    curve = RotationSpline(knots, exponential(angles[:, None] * np.array([0, 0.6, 0.8])))
    r = np.linspace(0, 1, 201)
    first, last = (
        2 * product(curve.evaluate(np.array([at]), 1), curve.evaluate(np.array([at]), 0) * [1, -1, -1, -1])[0]
        for at in (0.0, 1.0)
    )
    ends = [omega[1:] @ [0, 0.6, 0.8] for omega in (first, last)]
    spline = CubicSpline(knots, angles, bc_type=((1, ends[0]), (1, ends[1])))
    found = 2 * np.arctan2(curve.evaluate(r, 0)[:, 1:] @ [0, 0.6, 0.8], curve.evaluate(r, 0)[:, 0])
    np.testing.assert_allclose(found, spline(r), atol=1e-12)


def test_the_case_of_the_circle():
    t = np.linspace(0, 2 * np.pi, 101)
    poses = np.zeros((101, 7))
    poses[:, 0], poses[:, 1], poses[:, 2] = 0.45, 0.2 * np.cos(t), 0.40 + 0.2 * np.sin(t)
    poses[:, 3:] = from_matrix(np.diag([1.0, -1, -1]))
    made = sm.PosePath(ROUND, orientation=np.diag([1, -1, -1]))
    np.testing.assert_allclose(made(np.linspace(0, 1, 101)), poses, atol=2e-16)
    assert made.length == pytest.approx(0.4 * np.pi, rel=1e-12)
    assert made.extent == pytest.approx(0.4, rel=1e-3)
    for interpolation in ("linear", "spline"):
        read = sm.PoseWaypoints(poses, interpolation)
        np.testing.assert_allclose(read(read.waypoints), poses, atol=1e-15)
        assert read.is_closed
        assert read.turning(0, 1) == 0
    assert made.is_closed
    np.testing.assert_allclose(read(np.linspace(0, 1, 999)), made(np.linspace(0, 1, 999)), atol=1e-7)


def test_the_case_of_the_line():
    made = sm.PosePath(LINE, orientation=IDENTITY)
    expected = np.zeros((200, 7))
    expected[:, 0], expected[:, 1], expected[:, 2], expected[:, 3] = np.linspace(0.45, -0.45, 200), 0.5422, 0.7885, 1
    np.testing.assert_allclose(made(np.linspace(0, 1, 200)), expected, atol=2e-16)
    assert not made.is_closed
    read = sm.PoseWaypoints(expected)
    np.testing.assert_allclose(read(np.linspace(0, 1, 333)), made(np.linspace(0, 1, 333)), atol=1e-14)


def test_orientations_that_close_only_in_sign_are_closed():
    round_ = sm.PosePath(ROUND, orientations=[IDENTITY, [0, 0, 0, 1], [-1, 0, 0, 0]])
    assert round_.is_closed
    np.testing.assert_allclose(round_(1.0)[3:], [-1, 0, 0, 0], atol=1e-15)
    assert not sm.PosePath(ROUND, orientations=[IDENTITY, [0, 0, 0, 1]]).is_closed


def test_following_puts_the_axes_where_it_says():
    up = np.array([0.0, 0.3, -1]) / np.hypot(0.3, 1)
    r = np.linspace(0, 1, 50)
    tangent = CURVE(r, 1) / distance(CURVE(r, 1))[:, None]
    for axis, second in (("x", 2), ("y", 2), ("z", 0)):
        frames = rotation_matrix(sm.PosePath(CURVE, follow={"axis": axis, "up": up})(r))
        np.testing.assert_allclose(frames[:, :, "xyz".index(axis)], tangent, atol=1e-14)
        across = up - (tangent @ up)[:, None] * tangent
        np.testing.assert_allclose(frames[:, :, second], across / distance(across)[:, None], atol=1e-13)
        np.testing.assert_allclose(np.linalg.det(frames), 1, atol=1e-13)


def test_following_a_circle_turns_once():
    path = POSES["round"]
    assert path.is_closed
    np.testing.assert_allclose(turns(path, np.linspace(0, 1, 50)), 2 * np.pi, rtol=1e-12)
    assert path.turning(0, 1) <= 2 * np.pi * 1.12
    np.testing.assert_allclose(path(1.0)[3:], -path(0.0)[3:], atol=1e-14)


def test_placing_is_the_product_of_the_motions():
    frame = {"translation": [1, 2, 3], "rpy": [0.3, -0.7, 2.9]}
    tool = {"translation": [0.1, -0.2, 0.3], "matrix": Rotation.from_rotvec([1, 2, -1]).as_matrix()}
    path = POSES["smooth waypoints"]
    r = np.linspace(0, 1, 30)

    def motion(rotation, shift):
        found = np.tile(np.eye(4), (*np.shape(shift)[:-1], 1, 1))
        found[..., :3, :3], found[..., :3, 3] = rotation, shift
        return found

    left = motion(Rotation.from_euler("xyz", frame["rpy"]).as_matrix(), frame["translation"])
    right = motion(tool["matrix"], tool["translation"])
    expected = left @ motion(rotation_matrix(path(r)), path(r)[:, :3]) @ right
    found = sm.Placed(path, frame, tool)(r)
    np.testing.assert_allclose(motion(rotation_matrix(found), found[:, :3]), expected, atol=1e-13)


@pytest.mark.parametrize("kind", [kind for kind in EXAMPLES if EXAMPLES[kind].dimension == 2])
def test_every_plane_curve_can_be_put_into_space(kind):
    path = EXAMPLES[kind]
    placed = sm.Placed(path, {"translation": [1, 2, 3], "normal": [0, -1, 0], "x_axis": [1, 5, 0]})
    r = np.linspace(0, 1, 20)
    x, y = path(r).T
    np.testing.assert_allclose(placed(r), np.stack([1 + x, np.full(20, 2.0), 3 + y], axis=1), atol=1e-12)
    assert placed.length == pytest.approx(path.length)
    assert placed.dimension == 3


def test_curves_in_space_are_their_plane_ones_in_planes():
    r = np.linspace(0, 1, 40)
    for make in (sm.Bezier, sm.Waypoints, lambda p: sm.Waypoints(p, "spline"), lambda p: sm.Line(p[0], p[1])):
        flat = make([[0, 0], [2, 0], [2, 3], [-1, 3]])
        deep = make([[0, 0, 7], [2, 0, 7], [2, 3, 7], [-1, 3, 7]])
        for order in range(3):
            np.testing.assert_array_equal(deep(r, order)[:, :2], flat(r, order))
        np.testing.assert_allclose(deep(r)[:, 2], 7, rtol=1e-15)
        assert deep.fastest(0.1, 0.6) == pytest.approx(flat.fastest(0.1, 0.6), rel=1e-14)
        assert deep.length == pytest.approx(flat.length)


def test_arc_length_keeps_the_orientation_with_the_position():
    original, path = POSES["slerp"], POSES["arc length of slerp"]
    np.testing.assert_allclose(speeds(path, np.linspace(0, 1, 50)), original.length, rtol=1e-9)
    # Where along the original the positions are, there the orientations are too.
    fine = original(np.linspace(0, 1, 20_001))
    for pose in path([0.13, 0.5, 0.77]):
        k = int(np.argmin(distance(fine - pose)))
        assert apart(fine[k, 3:], pose[3:]) < 1e-3


def test_a_path_that_turns_in_place_has_no_extent_but_is_planned_like_any():
    path = POSES["turning in place"]
    assert path.extent == path.length == path.fastest(0, 1) == 0
    assert path.turning(0, 1) == pytest.approx(2 * np.pi)


class Bare(Path):
    kind = "bare"
    dimension = 3

    def _evaluate(self, r, order):
        return LINE(r, order)


class BarePose(Bare):
    dimension = 7

    def _evaluate(self, r, order):
        return POSES["constant"](r, order)


NORTH = sm.Bezier([[0, 0, 0], [0, 0, 1], [1, 0, 1]])
BAD = {
    "position: is no space curve but a plane one": lambda: sm.PosePath(sm.Circle([0, 0], 1), IDENTITY),
    "position: is no space curve but a path of poses": lambda: sm.PosePath(POSES["slerp"], IDENTITY),
    "position: is a list": lambda: sm.PosePath([1, 2], IDENTITY),
    "orientation: is missing": lambda: sm.PosePath(LINE),
    "orientation: is given by orientation and follow": lambda: sm.PosePath(LINE, IDENTITY, follow={}),
    "at: stands without orientations": lambda: sm.PosePath(LINE, IDENTITY, at=[0, 1]),
    "its norm is 2": lambda: sm.PosePath(LINE, [2, 0, 0, 0]),
    "orientations.1: is no unit quaternion: its norm is 0.9": lambda: sm.PosePath(
        LINE, orientations=[IDENTITY, [0.9, 0, 0, 0]]
    ),
    "orientations: has 1 rows": lambda: sm.PosePath(LINE, orientations=[IDENTITY]),
    "at: has 3 numbers for 2": lambda: sm.PosePath(LINE, orientations=[IDENTITY, IDENTITY], at=[0, 0.5, 1]),
    "at: does not ascend": lambda: sm.PosePath(LINE, orientations=[IDENTITY, IDENTITY], at=[0, 0.5]),
    "interpolation: is not known": lambda: sm.PosePath(LINE, IDENTITY, interpolation="cubic"),
    "follow: is not a mapping": lambda: sm.PosePath(LINE, follow="x"),
    "follow.up: is missing": lambda: sm.PosePath(LINE, follow={"axis": "x"}),
    "follow.down: is not a known field": lambda: sm.PosePath(LINE, follow={"axis": "x", "up": [0, 0, 1], "down": 1}),
    "follow.axis: is not known": lambda: sm.PosePath(LINE, follow={"axis": "-x", "up": [0, 0, 1]}),
    "follow.up: is zero": lambda: sm.PosePath(LINE, follow={"axis": "x", "up": [0, 0, 0]}),
    "follow: has up along the tangent at r = 0,": lambda: sm.PosePath(NORTH, follow={"axis": "x", "up": [0, 0, 1]}),
    "follow: has up along the tangent at r = 0.25": lambda: sm.PosePath(ROUND, follow={"axis": "z", "up": [0, 1, 0]}),
    "follow: has a tangent to follow that jumps by 1.5708 rad at r = 0.5": lambda: sm.PosePath(
        sm.Waypoints([[0, 0, 0], [1, 0, 0], [1, 1, 0]]), follow={"axis": "x", "up": [0, 0, 1]}
    ),
    "follow: has no tangent to follow at r = 0:": lambda: sm.PosePath(
        sm.Bezier([[0, 0, 0], [0, 0, 0], [1, 0, 0]]), follow={"axis": "x", "up": [0, 0, 1]}
    ),
    "follow: needs the third derivative": lambda: sm.PosePath(
        sm.ArcLength(CURVE), follow={"axis": "x", "up": [0, 0, 1]}
    ),
    "poses: has 1 row": lambda: sm.PoseWaypoints([[0, 0, 0, *IDENTITY]]),
    "poses: repeats row 1 as row 2": lambda: sm.PoseWaypoints(
        [[0, 0, 0, *IDENTITY], [1, 0, 0, *IDENTITY], [1, 0, 0, -1, 0, 0, 0]]
    ),
    "poses: turns in place from row 0 to row 1": lambda: sm.PoseWaypoints(
        [[0, 0, 0, *IDENTITY], [0, 0, 0, 0, 1, 0, 0]], parameter="length"
    ),
    "too close to tell apart": lambda: sm.PoseWaypoints(
        [[1, 0, 0, *IDENTITY], [0, 0, 0, *IDENTITY], [1e-30, 0, 0, *IDENTITY], [2, 0, 0, *IDENTITY]], parameter="length"
    ),
    "poses: has shape (2, 6)": lambda: sm.PoseWaypoints(np.zeros((2, 6))),
    "poses.1: is no unit quaternion: its norm is 0": lambda: sm.PoseWaypoints([[0, 0, 0, *IDENTITY], [1] + 6 * [0]]),
    "parameter: is not known": lambda: sm.PoseWaypoints(rows(), parameter="time"),
    "frame: is not a mapping": lambda: sm.Placed(LINE, [1, 2, 3]),
    "frame.shift: is not a known field": lambda: sm.Placed(LINE, {"shift": [1, 2, 3]}),
    "did you mean 'translation'": lambda: sm.Placed(LINE, {"translate": [1, 2, 3]}),
    "frame: says its rotation by quaternion and rpy": lambda: sm.Placed(
        LINE, {"rpy": [0, 0, 0], "quaternion": IDENTITY}
    ),
    "frame.matrix: is no rotation: it is a reflection": lambda: sm.Placed(LINE, {"matrix": -np.eye(3)}),
    "frame.matrix: has shape (4,)": lambda: sm.Placed(LINE, {"matrix": IDENTITY}),
    "frame.x_axis: is missing": lambda: sm.Placed(LINE, {"normal": [0, 0, 1]}),
    "frame.x_axis: is along the normal": lambda: sm.Placed(LINE, {"normal": [0, 0, 1], "x_axis": [0, 0, -2]}),
    "frame.x_axis: stands without a normal": lambda: sm.Placed(LINE, {"x_axis": [0, 0, 1]}),
    "tool: needs a path of poses": lambda: sm.Placed(LINE, tool={"translation": [0, 0, 1]}),
    "path: is not one of the plane": lambda: sm.Transformed(LINE),
    "parts: mixes a space curve with a path of poses": lambda: sm.Concatenation([LINE, POSES["slerp"]]),
    "part 1 starts turned by 3.14159 rad": lambda: sm.Concatenation(
        [sm.PosePath(LINE, IDENTITY), sm.PosePath(sm.Reversed(LINE), [0, 1, 0, 0])]
    ),
    "part 0 turns in place": lambda: sm.Concatenation([POSES["turning in place"]]),
    "path: has no length": lambda: sm.ArcLength(POSES["turning in place"]),
    "path: stops at r = 0.25": lambda: sm.ArcLength(
        sm.PoseWaypoints(
            [
                [0, 0, 0, *IDENTITY],
                [1, 0, 0, *IDENTITY],
                [1, 0, 0, 0, 1, 0, 0],
                [2, 0, 0, 0, 1, 0, 0],
                [3, 0, 0, 0, 1, 0, 0],
            ]
        )
    ),
    "has no orientation that could turn": lambda: LINE.turning(0, 1),
    "low: is beyond high": lambda: POSES["slerp"].turning(0.5, 0.4),
    "bounds its angular speed nowhere": lambda: BarePose().turning(0, 1),
    "bounds its second derivative nowhere": lambda: Bare().bending(0, 1),
    "is one of poses, of which there is no difference": lambda: PATHS and sm.paths.Relative(POSES["slerp"], LINE),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_poses_are_refused_and_say_why(message):
    with pytest.raises(sm.InvalidInputError) as caught:
        BAD[message]()
    assert message in str(caught.value)
    assert caught.value.field
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


def test_a_tangent_that_comes_near_to_up_is_bounded_all_the_same():
    """The circle leans out of the plane of `up` by a thousandth: the frame turns by half a turn within that."""
    lean = sm.Placed(sm.Circle([0, 0], 1), {"rpy": [0, 1e-3, 0]})
    path = sm.PosePath(lean, follow={"axis": "x", "up": [1, 0, 0]})
    near = np.linspace(0.74, 0.76, 4001)
    assert path.turning(0, 1) >= turns(path, near).max()
    assert ((path(near)[1:, 3:] * path(near)[:-1, 3:]).sum(axis=1) > 0).all()


def test_quaternions_against_the_definition_of_the_blend():
    """The smooth curve against its formula, in extended precision."""
    import mpmath

    knots, q = np.array([0.0, 0.4, 1.0]), continuous(wandering(3))
    curve = RotationSpline(knots, q)

    def times(a, b):
        w = a[0] * b[0] - sum(x * y for x, y in zip(a[1:], b[1:], strict=True))
        cross = [a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1]]
        return [w, *(a[0] * b[k + 1] + a[k + 1] * b[0] + cross[k] for k in range(3))]

    def power(v, by):
        size = mpmath.sqrt(sum(mpmath.mpf(x) ** 2 for x in v))
        return [mpmath.cos(size * by / 2), *(mpmath.sin(size * by / 2) * x / size for x in v)]

    def curve_at(r, piece):
        t = (r - mpmath.mpf(knots[piece])) / (mpmath.mpf(knots[piece + 1]) - mpmath.mpf(knots[piece]))
        found = [mpmath.mpf(x) for x in q[piece]]
        for omega, by in zip(curve._parts[:, piece], (1 - (1 - t) ** 3, 3 * t**2 - 2 * t**3, t**3), strict=True):
            found = times(found, power([mpmath.mpf(x) for x in omega], by))
        return found

    with mpmath.workdps(40):
        for r, piece in ((0.13, 0), (0.77, 1)):
            for order in range(3):
                exact = [
                    float(mpmath.diff(lambda s, j=j, p=piece: curve_at(s, p)[j], mpmath.mpf(r), order))
                    for j in range(4)
                ]
                np.testing.assert_allclose(curve.evaluate(np.array([r]), order)[0], exact, rtol=1e-11, atol=1e-11)


def test_a_great_circle_turns_vectors_evenly():
    curve = GreatCircles(np.array([0.0, 1.0]), np.array([IDENTITY, [np.cos(0.5), 0, 0, np.sin(0.5)]]))
    found = rotate(curve.evaluate(np.linspace(0, 1, 5), 0), np.array([1.0, 0, 0]))
    np.testing.assert_allclose(np.arctan2(found[:, 1], found[:, 0]), np.linspace(0, 1, 5), atol=1e-15)
