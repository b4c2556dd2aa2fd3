"""Six-axis arms on a rail: kinematics, what encloses them, covers, and that a rail is never turned."""

from importlib.resources import files

import attack_covers as attack
import jsonschema
import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms._roots import EMPTY, MERGED, REGULAR
from selfmotion.arms._wrist_kernels import home
from selfmotion.arms.chain import Chain
from selfmotion.arms.limits import JointLimits
from selfmotion.arms.rail import RailArm
from selfmotion.arms.roll import RollArm
from selfmotion.exchange.schema import build, json_schema
from selfmotion.rotations import matrix

NAMES = ("irb120", "kr6r900", "ur5e")
AXIS = np.array([0.2, 1.0, 0.1])
ALONG = AXIS / np.linalg.norm(AXIS)
TORCH = {"translation": [0.05, 0.02, 0.15], "rpy": [0.3, 0.6, -0.2]}
CHEAP = ("any", "elbow", "elbow ±1e-3", "wrist ±1e-3", "limit")
DATA = files("selfmotion.arms") / "data"
MADE = {}


def railed(name, low=-0.4, high=0.7):
    """An arm on a rail with a tool that nothing is parallel to."""
    key = name, low, high
    if key not in MADE:
        MADE[key] = sm.named_arm(name, tool=TORCH, rail={"axis": AXIS, "limits": [low, high]})
    return MADE[key]


def postures(arm, rng, count):
    return rng.uniform(np.maximum(arm.limits.lower, -3), np.minimum(arm.limits.upper, 3), (count, 7))


def apart(one, two):
    """How far postures differ, the six joints that turn up to whole turns."""
    step = one - two
    return np.abs(np.concatenate([step[..., :1], np.angle(np.exp(1j * step[..., 1:]))], axis=-1)).max(axis=-1)


@pytest.mark.parametrize("name", NAMES)
def test_postures_are_found_again_where_their_rail_is(name):
    arm, rng = railed(name), np.random.default_rng(1)
    assert isinstance(arm, RailArm)
    assert (arm.n, arm.n_u, arm.dimension, arm.parameter) == (7, 1, 7, "rail")
    assert arm.rigorous
    q = postures(arm, rng, 400)
    x, branch = arm.forward(q), arm.branch_of(q)
    transforms = arm.chain.forward(q)
    assert np.abs(x[:, :3] - transforms[:, :3, 3]).max() < 1e-12
    assert np.abs(matrix(x[:, 3:]) - transforms[:, :3, :3]).max() < 1e-12
    assert (arm.u_of(q) == q[:, :1]).all()
    for b in range(8):
        mine = branch == b
        found, ok = arm.solve(x[mine], q[mine, :1], b)
        assert ok.all()
        assert np.quantile(apart(found, q[mine]), 0.99) < 1e-9
        found, ok = arm.solve(x, q[:, :1] + 0.3, b)
        assert (found[ok, 0] == q[ok, 0] + 0.3).all()
        assert arm.task_error(found[ok], x[ok]).max(initial=0.0) < 1e-12
        assert np.isnan(found[~ok]).all()
        assert (arm.branch_of(found[ok]) == b).all()


@pytest.mark.parametrize("name", NAMES)
def test_on_its_rail_an_arm_is_the_bare_one_at_the_pose_moved_back(name):
    arm, bare, rng = railed(name), sm.named_arm(name, tool=TORCH), np.random.default_rng(2)
    assert isinstance(bare, RollArm)
    q = postures(arm, rng, 200)
    moved = bare.forward(q[:, 1:])
    moved[:, :3] += q[:, :1] * ALONG
    assert np.abs(arm.forward(q)[:, :3] - moved[:, :3]).max() < 1e-14
    assert (arm.branch_of(q) == bare.branch_of(q[:, 1:])).all()
    for b in range(8):
        here, ok = arm.solve(moved, q[:, :1], b)
        there, there_too = bare.solve(bare.forward(q[:, 1:]), bare.u_of(q[:, 1:]), b)
        assert (ok == there_too).mean() > 0.99  # where branches end, rounding decides
        both = ok & there_too
        assert np.quantile(apart(here[both], np.column_stack([q[both, 0], there[both]])), 0.98) < 1e-9


@pytest.mark.parametrize("name", ["irb120", "ur5e"])
def test_the_task_has_its_derivatives(name):
    arm, rng, h = railed(name), np.random.default_rng(3), 1e-6
    q, dq = postures(arm, rng, 60), rng.normal(size=(60, 7))
    ahead, behind = arm.task_residual(q, arm.forward(q + h * dq)), arm.task_residual(q, arm.forward(q - h * dq))
    assert (ahead - behind) / (2 * h) == pytest.approx((arm.jacobian(q) @ dq[:, :, None])[:, :, 0], abs=1e-6)
    rate = (arm.jacobian(q + h * dq) - arm.jacobian(q - h * dq)) / (2 * h)
    assert rate == pytest.approx(arm.jacobian_rate(q, dq), abs=1e-5)
    assert np.abs(arm.jacobian(q)[:, :, 0] - np.append(ALONG, np.zeros(3))).max() < 1e-15
    by_u = arm.derivative(arm.forward(q), q[:, :1], 0)[0][..., 0]
    assert np.nanmax(np.abs(by_u[:, 0] - 1.0)) < 1e-12


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("room", [0.0, 1e-4, 1e-2])
def test_boxes_hold_postures_and_rates_those_of_smooth_branches(name, room):
    arm, rng = railed(name), np.random.default_rng([4, int(1e4 * room)])
    box, rate, state = np.empty((8, 7, 2)), np.empty((8, 7, 2)), np.empty(8, np.int64)
    smooth = 0
    for q in postures(arm, rng, 150):
        width = 10.0 ** rng.uniform(-5, -0.3)
        u0 = q[0] - width * rng.random()
        u1 = max(u0 + width, q[0])
        rotation, position = arm.root(arm.forward(q))
        wide = room * np.array([-1.0, 1.0])
        arm.closed.enclose(arm.geometry, rotation + wide, position + wide, u0, u1, box, rate, state)
        for trial in range(3):
            turn, place = rotation[..., 0].copy(), position[..., 0].copy()
            if trial:
                spin = rng.uniform(-0.25, 0.25, 3) * room
                cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
                turn = np.linalg.qr(turn @ (np.eye(3) + cross))[0]
                turn *= np.sign((turn * rotation[..., 0]).sum(axis=0))
                place = place + rng.uniform(-0.9, 0.9, 3) * room
            before = None
            for u in np.sort([u0, u1, q[0], *rng.uniform(u0, u1, 2)]):
                found, ok = np.empty((8, 7)), np.empty(8, bool)
                arm.closed.solve(arm.geometry, np.ascontiguousarray(turn), np.ascontiguousarray(place), u, found, ok)
                assert ok[state == REGULAR].all()
                for b in np.flatnonzero(ok):
                    assert state[b] != EMPTY
                    mine = box[home(state, b)]
                    middle, half = mine.mean(axis=1), 0.5 * np.ptp(mine, axis=1)
                    off = found[b] - middle
                    off[1:] -= 2 * np.pi * np.rint(off[1:] / (2 * np.pi))
                    assert ((np.abs(off) <= half + 1e-12) | (half >= np.pi)).all()
                if before is not None and u - before[0] > 1e-5:
                    for b in np.flatnonzero(state == REGULAR):
                        gap, steepest = u - before[0], np.abs(rate[b]).max()
                        if steepest * gap < 3.0:
                            step = found[b] - before[1][b]
                            step[1:] -= 2 * np.pi * np.rint(step[1:] / (2 * np.pi))
                            fuzz = 1e-7 + 1e-13 * (1 + steepest) ** 2 / gap
                            assert (step / gap >= rate[b, :, 0] - fuzz).all()
                            assert (step / gap <= rate[b, :, 1] + fuzz).all()
                            smooth += 1
                before = u, found
        assert state[home(state, int(arm.branch_of(q)))] not in (EMPTY, MERGED)
    assert smooth > 500


@pytest.mark.parametrize("kind", CHEAP)
@pytest.mark.parametrize("name", ["irb120 on a rail", "ur5e on a rail"])
def test_nothing_feasible_is_lost(name, kind):
    arm = attack.load(name)
    rng = np.random.default_rng([5, CHEAP.index(kind)])
    found = attack.verdict(arm, arm.cover(), attack.posture(arm, kind, rng), rng, (0.2,), (0.3,), most=400)
    assert found.checked
    assert not found.faults


def test_a_cell_left_out_is_missed():
    arm = attack.load("irb120 on a rail")
    rng = np.random.default_rng(6)
    q = attack.posture(arm, "any", rng)
    x = arm.forward(q)
    cells, cover = arm.cover().cells(x, 0.2), arm.cover()
    sample = attack.sampled(arm, x, q, rng, 6).q
    arrays = cells.a, cells.b, cells.bow, cells.dev, cells.rest, cover.wraps
    holders = np.unique([attack.excess(posture, *arrays)[1] for posture in sample])
    assert len(holders) > 10
    for k in holders[::5]:
        others, middle = cells[np.arange(len(cells)) != k], 0.5 * (cells.a[k] + cells.b[k]) + 0.125 * cells.bow[k]
        if np.abs(cells.b[k] - cells.a[k]).max() > 1e-2:
            assert attack.outside(others, middle[None], cover.wraps)[0] > 1e-4


@pytest.mark.parametrize("name", ["kr6r900", "ur5e"])
def test_boxes_of_a_slab_hold_the_postures_in_it(name):
    arm, rng = railed(name), np.random.default_rng(7)
    pose = arm.forward(np.array([0.1, 0.3, -1.0, 1.2, 0.4, 0.9, 0.2]))
    t = np.linspace(0, 1, 11)[:, None]
    path = sm.PoseWaypoints(np.hstack([pose[:3] + t * np.array([0.0, 0.4, 0.05]), np.tile(pose[3:], (11, 1))]))
    slabs, held = arm.slabs(path), 0
    for low in (0.0, 0.4):
        boxes = slabs.boxes(low, low + 0.02, 0.1)
        finer = slabs.split(low, low + 0.02, boxes, np.full(len(boxes.low), 0.05))
        for r in rng.uniform(low, low + 0.02, 4):
            for b in range(8):
                u = rng.uniform(*arm.parameter_range, (40, 1))
                q, ok = arm.solve(np.tile(path(r), (40, 1)), u, b)
                for posture in q[ok & (arm.limits.excess(np.nan_to_num(q)) <= 0).all(axis=1)]:
                    turned = posture + 2 * np.pi * np.array([[0] * 7, *np.eye(7)[1:], *-np.eye(7)[1:]])
                    turned = turned[(arm.limits.margin(turned) >= 0).all(axis=1)]
                    for found in (boxes, finer):
                        inside = (found.low[:, None] <= turned + 1e-9) & (turned - 1e-9 <= found.high[:, None])
                        free = slabs.wraps | (found.high - found.low >= 2 * np.pi - 1e-6)[:, None]
                        assert (inside | free).all(axis=2).any(axis=0).all()
                        held += len(turned)
    assert held > 100


def test_on_a_long_rail_nothing_is_a_whole_turn_away():
    """A rail of 30 m has places that differ by 2π, and these are not one."""
    arm = railed("irb120", -15.0, 15.0)
    assert not arm.cover().wraps[0]
    q = np.array([2.0, 0.2, 0.3, 0.1, 0.4, 0.9, 0.2])
    x = arm.forward(q)
    cells = arm.cover().cells(x, 0.2)
    assert np.abs(cells.a[:, 0] - 2.0).max() < 2.0
    assert attack.outside(cells, q[None], arm.cover().wraps)[0] < 1e-9
    away = q + 2 * np.pi * np.eye(7)[0]
    assert attack.outside(cells, away[None], arm.cover().wraps)[0] > 1.0
    assert len(arm.cover().points(q[None], turned=True)) == 1
    for u in (-9.0, 2.0, 14.0):
        far = x.copy()
        far[:3] += (u - 2.0) * ALONG
        found, ok = arm.solve(far, [u], int(arm.branch_of(q)))
        assert ok
        assert found == pytest.approx(np.append(u, q[1:]), abs=1e-9)
        middles = 0.5 * (arm.cover().cells(far, 0.2).a[:, 0] + arm.cover().cells(far, 0.2).b[:, 0])
        assert np.abs(middles - u).max() < 2.0


def test_limits_of_a_joint_that_slides_are_lengths():
    limits = JointLimits([(-1.0, 9.0), (-1.0, 1.0), None], 3, np.array([True, False, False]))
    far = np.array([8.0 + 2 * np.pi, 0.5 + 2 * np.pi, 0.0])
    assert limits.excess(far) == pytest.approx([2 * np.pi - 1.0, 0.0, 0.0])
    assert limits.steps(np.zeros(3), np.array([8.0, 0.1, 7.0])) == pytest.approx([8.0, 0.1, 7.0 - 2 * np.pi])
    motion = np.array([[0.0, 0.0, 0.0], [4.0, 4.0 - 2 * np.pi, 4.0], [8.0, 0.5, 0.5]])
    lifted = limits.lift(motion[None].copy())
    assert lifted.q[0, :, 0] == pytest.approx([0.0, 4.0, 8.0])
    assert limits.continuous(motion)[:, 0] == pytest.approx([0.0, 4.0, 8.0])
    outside = limits.lift(motion[None] + np.array([7.0, 0.0, 0.0]))
    assert outside.q[0, :, 0] == pytest.approx([7.0, 11.0, 15.0])
    assert outside.excess[0, 0] == pytest.approx(6.0)
    chain = Chain(["a", "b"], [np.eye(4)] * 3, JointLimits([(-1, 1), (-1, 1)], 2), [True, False])
    assert chain.limits.slides.tolist() == [True, False]


def test_reach_is_counted_from_the_rail():
    arm = railed("irb120")
    x = arm.forward(np.array([0.0, 0.2, 0.3, 0.1, 0.4, 0.9, 0.2]))
    beside = x.copy()
    beside[:3] += 50.0 * ALONG
    assert arm.shortfall(x) < 0.0
    assert arm.shortfall(beside) == pytest.approx(float(arm.shortfall(x)), abs=1e-12)
    beside[:3] = 2.0 * np.cross(ALONG, [0.0, 0.0, 1.0])
    assert 0.5 < float(arm.shortfall(beside)) < 2.0


def urdf(name, limit='<limit lower="-0.4" upper="0.7" velocity="2" effort="1"/>', kind="prismatic", where="base_link"):
    """The text of an arm's file with a rail under it."""
    text = (DATA / f"{name}.urdf").read_text()
    xyz = " ".join(map(str, AXIS))
    rail = f"""<link name="floor"/><joint name="track" type="{kind}"><parent link="floor"/><child link="{where}"/>
    <axis xyz="{xyz}"/>{limit}</joint></robot>"""
    return text.replace("</robot>", rail)


@pytest.mark.parametrize("name", ["kr6r900", "ur5e"])
def test_a_rail_in_a_file_is_the_one_by_name(name, tmp_path):
    (tmp_path / "robot.urdf").write_text(urdf(name))
    arm = sm.urdf_arm(tmp_path / "robot.urdf", "floor", "tool0", tool=TORCH)
    named = railed(name)
    assert isinstance(arm, RailArm)
    assert arm.chain.names[0] == "track"
    assert arm.branches == named.branches
    q = postures(arm, np.random.default_rng(8), 50)
    assert np.abs(arm.forward(q) - named.forward(q)).max() < 1e-12
    assert arm.limits.as_list()[0] == [-0.4, 0.7]
    rail = {"axis": AXIS.tolist(), "limits": [-0.4, 0.7]}
    (tmp_path / "bare.urdf").write_text((DATA / f"{name}.urdf").read_text())
    data = {"kind": "urdf", "file": "bare.urdf", "base": "base_link", "tip": "tool0", "tool": TORCH, "rail": rail}
    jsonschema.validate({"arm": data, "path": {"kind": "line", "start": [1, 0], "end": [2, 0]}}, json_schema())
    assert np.abs(build("arm", data, str(tmp_path)).forward(q) - named.forward(q)).max() < 1e-12
    shorter = [[-0.1, 0.1], *[[-1.0, 1.0]] * 6]
    assert sm.urdf_arm(tmp_path / "robot.urdf", "floor", "tool0", limits=shorter).limits.as_list() == shorter


def test_six_joints_without_a_rail_still_roll():
    assert isinstance(sm.named_arm("irb120"), RollArm)
    assert isinstance(sm.named_arm("irb120", limits=[[-1, 1]] * 6, rail={"axis": [0, 2, 0], "limits": [0, 1]}), RailArm)


RAIL = {"axis": [0, 1, 0], "limits": [-1, 1]}
BAD = [
    ({**RAIL, "axis": [0, 0, 0]}, r"rail\.axis: is zero"),
    ({**RAIL, "axis": [0, 1]}, r"rail\.axis"),
    ({**RAIL, "axis": [0, float("nan"), 1]}, r"rail\.axis"),
    ({"axis": [0, 1, 0]}, r"rail\.limits: is missing"),
    ({"limits": [0, 1]}, r"rail\.axis: is missing"),
    ({**RAIL, "limits": [1, -1]}, r"rail\.limits: is reversed"),
    ({**RAIL, "limits": [0]}, r"rail\.limits"),
    ({**RAIL, "limits": [0, float("inf")]}, r"rail\.limits"),
    ({**RAIL, "limits": [0, 2000]}, "slides farther than 1000 m"),
    ({**RAIL, "speed": 1}, r"rail\.speed: is not a known field"),
    ([0, 1, 0], "rail: is not a mapping"),
]


@pytest.mark.parametrize(("rail", "words"), BAD)
def test_a_rail_that_is_none_is_refused(rail, words):
    with pytest.raises(sm.InvalidInputError, match=words):
        sm.named_arm("irb120", rail=rail)


def test_a_rail_under_an_arm_that_has_seven_joints_is_refused():
    with pytest.raises(sm.InvalidInputError, match="rail: is under an arm with 7 joints"):
        sm.named_arm("panda", rail=RAIL)


def test_other_joints_that_slide_are_refused_with_what_is_supported(tmp_path):
    (tmp_path / "robot.urdf").write_text(urdf("irb120", limit=""))
    with pytest.raises(sm.InvalidInputError, match=r"urdf\.track\.limit"):
        sm.urdf_arm(tmp_path / "robot.urdf", "floor", "tool0")
    (tmp_path / "robot.urdf").write_text(urdf("irb120", kind="floating"))
    with pytest.raises(sm.InvalidInputError, match="is a floating joint"):
        sm.urdf_arm(tmp_path / "robot.urdf", "floor", "tool0")
    chain = railed("irb120").chain
    free = Chain(chain.names, chain.offsets, [None, *chain.limits.as_list()[1:]], chain.prismatic)
    with pytest.raises(sm.InvalidInputError, match="slides without end, rail"):
        RailArm(free)
    last = [False] * 6 + [True]
    with pytest.raises(sm.InvalidInputError, match="closed form"):
        RailArm(Chain(chain.names, chain.offsets, chain.limits.as_list(), last))
    text = urdf("irb120").replace('name="joint_3" type="revolute"', 'name="joint_3" type="prismatic"')
    assert text != urdf("irb120")
    (tmp_path / "robot.urdf").write_text(text)
    with pytest.raises(sm.InvalidInputError, match="joints that slide: track, joint_3") as caught:
        sm.urdf_arm(tmp_path / "robot.urdf", "floor", "tool0")
    assert "a rail before six joints" in caught.value.remedy


def test_what_is_of_angles_only_is_refused_of_a_rail():
    arm = railed("irb120")
    for call in (
        arm.self_motion,
        lambda: arm.solve_with_margin(np.zeros(7), [0.0]),
        lambda: arm.cover(arm.branches[0]),
    ):
        with pytest.raises(sm.InvalidInputError):
            call()
