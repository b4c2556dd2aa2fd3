"""Arms that EAIK solves with one joint locked: postures, their numbers, and cells beside those that miss nothing."""

import sys

import attack_covers as attack
import numpy as np
import pytest

import robots
import selfmotion as sm
from selfmotion.angles import wrap
from selfmotion.arms import CATALOGUE, RedundantArm, _walk_kernels, how_solved_file
from selfmotion.arms.chain import Chain
from selfmotion.arms.locked import LockedArm
from selfmotion.arms.locked_chain import LockedChain
from selfmotion.arms.spatial import SpatialArm
from selfmotion.arms.traced_cover import VALUES

pytest.importorskip("eaik")

KNOWN = ("panda", "iiwa14")
ARMS = {}


def arm_of(name):
    """An arm with a joint locked, made once."""
    if name not in ARMS:
        ARMS[name] = LockedArm(robots.chain(name) if name in robots.TEXTS else CATALOGUE[name].chain())
    return ARMS[name]


def drawn(arm, count, seed):
    """Postures inside the limits, of joints with a whole turn and more in one turn of it."""
    low, high = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    return np.random.default_rng(seed).uniform(low, high, (count, arm.n))


def on_task(arm, x, q):
    """Postures moved onto a pose by the shortest Newton steps."""
    for _ in range(6):
        q = q + (np.linalg.pinv(arm.jacobian(q)) @ arm.task_residual(q, x)[..., None])[..., 0]
    return q


def points_of(arm, x, cells):
    """Postures on cells that are clearly inside the limits and exactly on the task."""
    curves = cells[cells.pieces[:, 1] != 1.0]
    inner = [(1 - s) * curves.a + s * curves.b + 0.5 * s * (1 - s) * curves.bow for s in (0.0, 0.3, 0.7, 1.0)]
    q = on_task(arm, x, np.concatenate(inner))
    return q[(arm.margins(q) > 1e-6).all(axis=1) & (arm.task_error(q, x) < 1e-12)]


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize(("slack", "count"), [(None, 20), (1.5, 1)])
def test_cells_are_those_of_the_cover_that_leaves_nothing_out(name, slack, count):
    closed, traced = SpatialArm(CATALOGUE[name].chain()), arm_of(name)
    if slack is not None:
        closed, traced = (arm.relaxed(np.full(arm.n, slack)) for arm in (closed, traced))
    one, two = closed.cover(), traced.cover()
    seen = 0
    for q in drawn(closed, count, 3):
        x = closed.forward(q)
        mine, theirs = two.cells(x, 0.1), one.cells(x, 0.1)
        for cells, cover, others in ((mine, one, theirs), (theirs, two, mine)):
            points = points_of(closed, x, cells)
            seen += len(points)
            assert attack.outside(others, points, cover.wraps).max(initial=0.0) < 1e-9
        assert attack.outside(mine, q[None], two.wraps)[0] < 1e-9
    assert seen > 10_000


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("kind", ["any", "limit", "rim", "shoulder ±1e-6", "wrist ±1e-3"])
def test_nothing_that_a_walk_finds_is_missed_and_split_cells_hold_it_too(name, kind):
    arm, rng = attack.load(name), np.random.default_rng([1, attack.KINDS.index(kind)])
    found = attack.verdict(arm, arm_of(name).cover(), attack.posture(arm, kind, rng), rng, (0.1,), (0.3,), most=400)
    assert found.checked
    assert not found.faults


def test_what_two_values_of_u_have_between_them_may_be_missed():
    # A Panda's wrist above its shoulder: joints 1 and 3 turn while q6, which is u, stands still.
    arm, cover = attack.load("panda"), arm_of("panda").cover()
    q = np.array([0.4, 0.0, 0.5, -2.0, 0.3, 1.8, 0.2])
    x = arm.forward(q)
    assert attack.outside(arm.cover().cells(x, 0.3), q[None], cover.wraps)[0] < 1e-9
    assert attack.outside(cover.cells(x, 0.3), q[None], cover.wraps)[0] > 1e-2


def test_where_curves_cross_a_small_box_stands_for_what_is_there():
    arm = arm_of("iiwa14")  # shoulder right below the wrist's axis and its elbow to the side: the Jacobian has rank 5
    q = np.array([0.3, 0.0, 0.5 * np.pi, -1.0, 0.2, 0.8, 0.1])
    assert arm.manipulability(q) < 1e-12
    x, cover = arm.forward(q), arm.cover()
    cells = cover.cells(x, 0.1)
    boxes = cells[cells.pieces[:, 1] == 1.0]
    assert len(boxes)
    assert (boxes.dev < 2e-3).all()
    assert attack.outside(cells, q[None], cover.wraps)[0] < 1e-9
    assert len(cover.split(x, boxes, np.full(len(boxes), 0.1))) == len(boxes)


def test_a_curve_that_is_inside_the_limits_between_two_values_of_u_only_is_found():
    arm = arm_of("panda")
    q = drawn(arm, 1, 5)[0]
    x = arm.forward(q)
    low, high = arm.limits.lower.copy(), arm.limits.upper.copy()
    low[0], high[0] = q[0] - 1e-4, q[0] + 1e-4
    narrow = LockedArm(_with_limits(arm.chain, low, high), arm.joint)
    cover = narrow.cover()
    at = low[arm.joint] + (np.arange(VALUES) + 0.5) * (high[arm.joint] - low[arm.joint]) / VALUES
    sampled, _ = narrow.postures(np.tile(x, (VALUES, 1)), at)
    assert (narrow.limits.excess(sampled).max(axis=1) > 1e-9).all()
    assert attack.outside(cover.cells(x, 0.1), q[None], cover.wraps)[0] < 1e-9


def _with_limits(chain, low, high):
    pairs = list(zip(low, high, strict=True))
    return Chain(chain.names, chain.offsets, pairs, chain.prismatic, chain.velocity, chain.base, chain.tip)


def test_cells_follow_each_other_along_their_curves():
    arm = arm_of("xarm7")
    cells = arm.cover().cells(arm.forward(drawn(arm, 1, 2)[0]), 0.1)
    same = cells.pieces[1:, 0] == cells.pieces[:-1, 0]
    assert same.sum() > 0.9 * len(cells)
    assert np.abs(wrap(cells.a[1:] - cells.b[:-1])[same]).max() < 1e-9
    assert (np.abs(cells.b - cells.a).max(axis=1) <= 0.1 * 1.3).all()


def test_more_cells_than_there_is_room_for_are_found_all_the_same(monkeypatch):
    arm = arm_of("panda")
    x = arm.forward(drawn(arm, 1, 3)[0])
    wanted = arm.cover().cells(x, 0.1)
    monkeypatch.setattr("selfmotion.arms.traced_cover._CELLS", 3)
    found = arm.cover().cells(x, 0.1)
    np.testing.assert_array_equal(found.a, wanted.a)


@pytest.mark.parametrize("name", ["xarm7", "sideways", *KNOWN])
def test_every_posture_is_found_and_nothing_that_is_none(name):
    arm = arm_of(name)
    q = drawn(arm, 200, 4)
    x, u = arm.forward(q), arm.u_of(q)
    found, of = arm.postures(x, u[:, 0])
    assert arm.task_error(found, x[of]).max() <= 1e-9 * arm.reach
    np.testing.assert_allclose(wrap(arm.u_of(found) - u[of]), 0.0, atol=1e-12)
    near = np.abs(wrap(found - q[of])).max(axis=1)
    assert np.array([near[of == k].min() for k in range(len(q))]).max() < 1e-6
    for k in range(20):
        mine = found[of == k]
        apart = np.abs(wrap(mine[:, None] - mine)).max(axis=2) + 10.0 * np.eye(len(mine))
        assert apart.min() > 1e-6


@pytest.mark.parametrize("name", ["xarm7", "sideways"])
def test_branches_are_the_numbers_of_postures_in_ascending_order(name):
    arm = arm_of(name)
    q = drawn(arm, 40, 5)
    x, u = arm.forward(q), arm.u_of(q)
    solved = [arm.solve(x, u, b) for b in range(len(arm.branches))]
    every, there = (np.stack(part, axis=1) for part in zip(*solved, strict=True))
    assert (there[:, :-1] | ~there[:, 1:]).all()
    assert np.isnan(every[~there]).all()
    assert all((np.diff(np.rint(row[ok] / 1e-6)) >= 0).all() for row, ok in zip(every[..., 0], there, strict=True))
    number = arm.branch_of(q)
    assert np.abs(wrap(every[np.arange(40), number] - q)).max() < 1e-6
    assert all(arm.is_on_branch(q[k], int(number[k]), 1e-9) for k in range(40))
    again, ok = arm.solve(x[3], u[3], "1")
    assert ok
    np.testing.assert_array_equal(again, every[3, 0])


def test_answers_that_only_come_near_the_pose_are_left_out():
    arm = arm_of("xarm7")
    x = arm.forward(drawn(arm, 1, 6)[0])
    x[:3] = [0.0, 0.0, 2.0]
    assert arm.shortfall(x) > 0.3
    frame = np.eye(4)
    frame[:3, 3] = x[:3]
    robot = LockedChain(arm.chain)
    raw = robot._robot(robot._axes, robot._steps, np.eye(3), [(arm.joint, 0.3)], True).calculate_IK(frame)
    assert len(raw.Q)
    assert not len(arm.postures(x[None], np.array([0.3]))[0])
    assert not arm.solve(x, np.array([0.3]))[1]
    assert not len(arm.cover().cells(x, 0.3))


def test_answers_that_are_off_are_mended_or_dropped(monkeypatch):
    arm = arm_of("sideways")
    q = drawn(arm, 1, 7)
    x = arm.forward(q)
    exact = LockedChain.postures

    def off(by):
        def postures(self, transforms, joint, values):
            found, of = exact(self, transforms, joint, values)
            return found + by * (np.arange(7) != joint), of

        return postures

    count = len(arm.postures(x, q[:, arm.joint])[0])
    for by, left in ((1e-7, count), (0.5, 0)):
        monkeypatch.setattr(LockedChain, "postures", off(by))
        found, _ = arm.postures(x, q[:, arm.joint])
        assert len(found) == left
        assert (arm.task_error(found, x) <= 1e-9 * arm.reach).all()


def test_postures_are_settled_with_the_locked_joint_still():
    arm = arm_of("sideways")
    q = drawn(arm, 5, 8)
    x = arm.forward(q)
    moved = q + 1e-4 * np.sin(np.arange(35.0)).reshape(5, 7) * (np.arange(7) != arm.joint)
    rotations = np.ascontiguousarray([arm.task(pose).rotation for pose in x])
    _walk_kernels.settle_all(arm.kernel, rotations, np.ascontiguousarray(x[:, :3]), arm.joint, 1e-2, moved)
    np.testing.assert_allclose(moved, q, atol=1e-10)


def test_the_arm_says_what_it_is():
    arm = arm_of("xarm7")
    assert isinstance(arm, RedundantArm)
    assert not arm.rigorous
    assert arm.parameter == f"q{arm.joint + 1}"
    assert all(sm.named_arm(name).rigorous for name in CATALOGUE)
    assert sm.PlanarArm([1, 1, 1]).rigorous
    wider = arm.relaxed(np.full(7, 0.1))
    assert (wider.joint, type(wider)) == (arm.joint, LockedArm)


def test_rates_are_those_of_the_motion_with_u():
    arm = arm_of("sideways")
    q = drawn(arm, 1, 9)[0]
    x, u, branch = arm.forward(q), arm.u_of(q), int(arm.branch_of(q))
    by_u, by_x = arm.derivative(x, u, branch)
    step = 1e-5
    ahead = [arm.solve(x, u + sign * step, branch)[0] for sign in (1, -1)]
    np.testing.assert_allclose(by_u[:, 0], wrap(ahead[0] - ahead[1]) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(arm.jacobian(q) @ by_x, np.eye(6), atol=1e-9)


@pytest.mark.parametrize(("name", "rounded"), [("xarm7", False), ("xarm7", True), ("sideways", False)])
def test_an_arm_of_no_family_comes_from_its_file(tmp_path, name, rounded):
    text = robots.TEXTS[name]
    (tmp_path / "arm.urdf").write_text(text.replace(repr(0.5 * np.pi), "1.5708") if rounded else text)
    arm = sm.urdf_arm(tmp_path / "arm.urdf")
    assert isinstance(arm, LockedArm)
    chain, solved = how_solved_file(tmp_path / "arm.urdf")
    assert (chain.n, solved.parameter, solved.closed_form, solved.rigorous) == (7, arm.parameter, False, False)
    q = drawn(arm, 50, 10)
    found, of = arm.postures(arm.forward(q), q[:, arm.joint])
    near = np.abs(wrap(found - q[of])).max(axis=1)
    assert np.mean([near[of == k].min(initial=9.0) < 1e-6 for k in range(50)]) > 0.9


def test_an_arm_that_nothing_solves_is_refused_with_what_was_tried(tmp_path):
    (tmp_path / "arm.urdf").write_text(robots.APART)
    with pytest.raises(sm.InvalidInputError, match="file: has 7 joints that no closed form solves, nor EAIK") as caught:
        sm.urdf_arm(tmp_path / "arm.urdf")
    assert "panda" in caught.value.remedy
    _, solved = how_solved_file(tmp_path / "arm.urdf")
    assert (solved.parameter, solved.rigorous) == (None, False)
    assert "EAIK" in solved.why_not


def test_an_arm_with_a_joint_that_slides_is_refused_by_its_name(tmp_path):
    (tmp_path / "arm.urdf").write_text(robots.XARM7.replace('"revolute"', '"prismatic"', 1))
    with pytest.raises(sm.InvalidInputError, match="file: has joints that slide: joint1"):
        sm.urdf_arm(tmp_path / "arm.urdf")


def test_pieces_without_end_are_given_up():
    arm = arm_of("iiwa14")  # an elbow that is all but stretched takes ever shorter pieces
    q = np.array([0.3, 0.5, 0.2, 1e-4, 0.4, 0.8, 0.1])
    assert 10_000 < len(arm.cover().cells(arm.forward(q), 0.1)) <= 60_000


def test_without_the_package_only_arms_that_need_it_are_refused(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "eaik", None)
    monkeypatch.setitem(sys.modules, "eaik.pybindings", None)
    assert sm.named_arm("panda").rigorous
    (tmp_path / "arm.urdf").write_text(robots.XARM7)
    with pytest.raises(sm.InvalidInputError, match="the package EAIK is missing") as caught:
        sm.urdf_arm(tmp_path / "arm.urdf")
    assert "pip install 'selfmotion[ik]'" in caught.value.remedy
    assert caught.value.field == "file"


def test_bad_arms_and_what_is_not_known_of_good_ones_are_refused():
    chain, arm = robots.chain("xarm7"), arm_of("xarm7")
    path = sm.Line([0.3, 0.2, 0.4], [0.4, 0.2, 0.4])
    calls = {
        "joint": lambda: LockedArm(chain, 0),
        "arm": lambda: LockedArm(CATALOGUE["ur5e"].chain()),
        "branch": lambda: arm.boxes("3"),
        "planner": lambda: arm.solve_with_margin(arm.forward(np.zeros(7)), [0.0]),
        "u0": lambda: arm.line([0.0], [1.0]),
    }
    for field, call in calls.items():
        with pytest.raises(sm.InvalidInputError) as caught:
            call()
        assert caught.value.field == field
        assert caught.value.remedy
    for call in (lambda: arm.slabs(path), arm.self_motion):
        with pytest.raises(sm.InvalidInputError, match="arm: has") as caught:
            call()
    sliding = Chain(chain.names, chain.offsets, chain.limits, [True] + [False] * 6)
    with pytest.raises(sm.InvalidInputError, match="seven revolute joints"):
        LockedArm(sliding)
