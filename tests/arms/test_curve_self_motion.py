"""The self-motion of spatial arms seen from u, against dense sampling of the closed form and the closed-form arcs."""

from importlib import resources

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.angles import TAU, wrap
from selfmotion.arms import SelfMotion, _srs_arc_kernels
from selfmotion.arms.catalogue import named_arm
from selfmotion.arms.chain import Chain
from selfmotion.arms.spatial import SpatialArm
from selfmotion.arms.urdf import read_chain
from selfmotion.domain import feasible_arcs
from selfmotion.intervals import IntervalSet

ARMS = ("panda", "iiwa7", "irb120", "ur5e")
TILTED = {"translation": [0.05, 0.0, 0.1], "rpy": [0.0, 0.7, 0.2]}
POSES = 8
GRID = np.linspace(-np.pi, np.pi, 1441)


def arm_of(name):
    if name in ("irb120", "ur5e"):  # the roll of a tool along the last axis would be that joint's angle alone
        return named_arm(name, TILTED)
    return SpatialArm(read_chain((resources.files("selfmotion.arms") / "data" / f"{name}.urdf").read_text()))


def random_postures(arm, count, seed):
    return np.random.default_rng(seed).uniform(arm.limits.lower, arm.limits.upper, (count, arm.n))


def with_limits(arm, joint, low, high):
    chain = arm.chain
    ends = list(zip(arm.limits.lower, arm.limits.upper, strict=True))
    ends[joint] = low, high
    return type(arm)(Chain(chain.names, chain.offsets, ends, chain.prismatic, chain.velocity, chain.base, chain.tip))


def excess(arm, x, u, branch):
    """Return by how much postures leave their limits, infinite where there is none."""
    q, ok = arm.solve(x, np.asarray(u)[..., None], branch)
    return np.where(ok, arm.limits.excess(np.where(ok[..., None], q, 0.0)).max(axis=-1), np.inf)


def whole_jacobian(arm, q):
    """Return how six joints move the tool in all six ways: singular where its roll turns about."""
    turns = np.concatenate([arm.jacobian(q), np.zeros((1, 6))])
    step = 1e-6
    ahead, behind = (arm.u_of(q + s * step * np.eye(6))[:, 0] for s in (1, -1))
    turns[5] = wrap(ahead - behind) / (2 * step)
    return turns


def check_samples(arm, x, branch, found, inside=1e-7, u=GRID):
    out = excess(arm, x, u, branch)
    assert found.distance(u[out == 0.0]).max(initial=0.0) <= 1e-9, (branch, found)
    deep = found.contains(u) & (found.distance_to_ends(u) > inside)
    assert out[deep].max(initial=0.0) <= 1e-9, (branch, found)


def bisected(arm, x, branch, inner, outer):
    """Return where feasibility ends between a feasible and an infeasible u."""
    for _ in range(60):
        middle = 0.5 * (inner + outer)
        if excess(arm, x, middle, branch) <= 1e-12:
            inner = middle
        else:
            outer = middle
    return inner


@pytest.fixture(scope="module", params=ARMS)
def arm(request):
    return arm_of(request.param)


@pytest.fixture(scope="module")
def looked_at(arm):
    x = arm.forward(random_postures(arm, POSES, 7))
    return x, feasible_arcs(arm.self_motion(), x)


def test_it_is_a_self_motion(arm):
    motion = arm.self_motion()
    assert isinstance(motion, SelfMotion)
    assert motion.separators(np.zeros((3, 7))).shape == (3, 0)
    assert motion.free_joint(np.zeros((1, 7))) is None
    assert not motion.has_structure
    with pytest.raises(sm.InvalidInputError, match="self_motion"):
        arm.line([0.0], [1.0])


def test_feasible_samples_are_inside_and_what_is_inside_is_feasible(arm, looked_at):
    x, arcs = looked_at
    for k, branch in np.ndindex(len(x), len(arm.branches)):
        check_samples(arm, x[k], branch, arcs[branch].interval_set(k))


def test_the_posture_that_made_the_pose_is_inside(arm, looked_at):
    _, arcs = looked_at
    for k, q in enumerate(random_postures(arm, POSES, 7)):
        assert arcs[int(arm.branch_of(q))].interval_set(k).contains(arm.u_of(q)[0], 1e-9)


def test_ends_are_where_bisection_finds_them_and_their_cause_holds_there(arm, looked_at):
    x, arcs = looked_at
    ends = 0
    for k, branch in np.ndindex(len(x), len(arm.branches)):
        found = arcs[branch].interval_set(k)
        gaps = found.complement()
        for run in arcs[branch].runs(k):
            for end, inward, causes in ((run.low, 1.0, run.causes[0]), (run.high, -1.0, run.causes[1])):
                step = min(1e-4, 0.4 * (run.high - run.low))
                beyond = 0.4 * min((b - a for a, b in gaps if gaps.contains(end, 1e-12)), default=0.0)
                outer = end - inward * min(1e-4, beyond)
                if excess(arm, x[k], outer, branch) == 0.0:
                    continue  # a gap too narrow for this
                assert abs(bisected(arm, x[k], branch, end + inward * step, outer) - end) <= 1e-8
                q = arm.solve(x[k], [end + inward * 1e-12], branch)[0]
                assert causes
                for cause in causes:
                    if cause.joint >= 0:
                        assert abs(wrap(q[cause.joint] - cause.value)) <= 2e-5  # near folds like a square root
                    else:
                        assert abs(np.linalg.det(whole_jacobian(arm, q))) <= 1e-4
                ends += 1
    assert ends > 50


def test_breakpoints_are_exact(arm, looked_at):
    x, _ = looked_at
    found = arm.self_motion().breakpoints(x)
    known = np.isfinite(found.q).all(axis=-1)
    assert known.any(axis=1).all()
    q, places = found.q[known], np.broadcast_to(np.arange(len(x))[:, None], known.shape)[known]
    assert arm.task_error(q, x[places]).max() <= 1e-12 * arm.reach
    np.testing.assert_allclose(wrap(arm.u_of(q)[:, 0] - found.u[known]), 0.0, atol=1e-14)
    columns = np.broadcast_to(np.arange(known.shape[1]), known.shape)[known]
    for posture, column in zip(q, columns, strict=True):
        cause = found.causes[column]
        if cause.joint >= 0:
            assert abs(wrap(posture[cause.joint] - cause.value)) <= 1e-14
        else:
            assert abs(np.linalg.det(whole_jacobian(arm, posture))) <= 1e-9


def test_s_r_s_intervals_are_those_of_the_closed_form():
    arm = arm_of("iiwa7")
    x = arm.forward(random_postures(arm, 12, 11))
    arcs = feasible_arcs(arm.self_motion(), x)
    ends = np.empty((64, 2))
    for k, branch in np.ndindex(len(x), len(arm.branches)):
        rotation, position = arm._root(x[k])
        shift = arm.closed_form.shift
        count = _srs_arc_kernels.feasible_arcs(
            arm.geometry, rotation, position, arm.limits.lower + shift, arm.limits.upper + shift, branch, ends
        )
        wanted, found = IntervalSet(ends[:count], TAU), arcs[branch].interval_set(k)
        assert len(wanted) == len(found)
        np.testing.assert_allclose(found.intervals, wanted.intervals, atol=1e-11)


@pytest.mark.parametrize("seed", [1, 4])
def test_where_the_shoulder_is_straight_a_joint_is_free(seed):
    arm = arm_of("panda")
    q = random_postures(arm, 1, seed)[0]
    q[1] = 0.0
    x = arm.forward(q)
    arcs = feasible_arcs(arm.self_motion(), x[None])
    at = float(q[6])
    free = {cause for cause in arm.self_motion().breakpoints(x[None]).causes if cause.kind == "free"}
    assert {cause.joint for cause in free} & {0, 2}
    around = at + np.concatenate([np.geomspace(1e-4, 0.5, 200), -np.geomspace(1e-4, 0.5, 200)])
    for branch in range(8):
        found = arcs[branch].interval_set(0)
        check_samples(arm, x, branch, found, 1e-6)
        check_samples(arm, x, branch, found, 1e-6, wrap(around))
    mine = [int(arm.branch_of(q + side * np.eye(7)[1])) for side in (1e-9, -1e-9)]
    assert all(arcs[branch].interval_set(0).contains(at, 1e-9) for branch in mine)


@pytest.mark.parametrize(("joint", "value"), [(4, 0.5 * np.pi), (4, -0.5 * np.pi), (3, -0.466865)])
def test_at_a_fold_two_branches_end_at_the_same_u(joint, value):
    arm = arm_of("panda")
    q = np.array([0.3, 0.5, -0.4, -1.2, 0.6, 1.9, 0.2])
    q[joint] = value
    folds = [c for c in arm.self_motion().causes if c.kind == "fold" and c.joint == joint]
    q[joint] = min((c.value for c in folds), key=lambda v: abs(v - value))
    x = arm.forward(q)
    arcs = feasible_arcs(arm.self_motion(), x[None])
    partners = [b for b in range(8) if arm.is_on_branch(q, b, 1e-9)]
    assert len(partners) == 2
    ends = [arcs[b].interval_set(0).distance_to_ends(q[6]) for b in partners]
    np.testing.assert_allclose(ends, 0.0, atol=1e-12)
    for branch in range(8):
        check_samples(arm, x, branch, arcs[branch].interval_set(0))


def turning_point(arm, x, joint):
    """Return branch, u and value of the largest angle of a joint at a pose, inside an interval."""

    def angle(u, branch):
        values, low = arm.solve(x, np.asarray(u)[..., None], branch)[0][..., joint], arm.limits.lower[joint]
        return values + TAU * np.ceil((low - 1e-9 - values) / TAU)

    arcs = feasible_arcs(arm.self_motion(), x[None])
    for branch in range(8):
        for run in arcs[branch].runs(0):
            u = np.linspace(run.low, run.high, 401)[1:-1]
            values = angle(u, branch)
            k = int(np.argmax(values))
            if 5 < k < len(u) - 6 and np.abs(np.diff(values)).max() < 0.5:
                a, b = u[k - 1], u[k + 1]
                for _ in range(80):
                    c, d = a + 0.382 * (b - a), a + 0.618 * (b - a)
                    a, b = (c, b) if angle(c, branch) < angle(d, branch) else (a, d)
                return branch, 0.5 * (a + b), float(angle(0.5 * (a + b), branch))
    return None


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-9, 1e-6, 1e-3, -1e-9, -1e-6])
def test_limits_touched_or_nearly(arm, offset):
    """A lower limit just above (offset < 0) or below the largest angle leaves nothing, a point, or a short interval."""
    tried = 0
    for k, x in enumerate(arm.forward(random_postures(arm, POSES, 7))):
        joint = 5 if arm.closed_form.family.parameter == "q7" else 1
        found = turning_point(arm, x, joint)
        if found is None or tried >= 2:
            continue
        branch, u, most = found
        narrow = with_limits(arm, joint, most - offset, min(most + 0.5, arm.limits.upper[joint]))
        arcs = feasible_arcs(narrow.self_motion(), x[None])[branch].interval_set(0)
        if offset < 0.0:
            assert arcs.distance(u) > 0.0, k
            continue
        assert arcs.contains(u, 1e-6), k
        length = sum(b - a for a, b in arcs if a - 1e-6 <= u <= b + 1e-6 or a - 1e-6 <= u + TAU <= b + 1e-6)
        assert length <= 1e-6 + 30 * np.sqrt(offset)
        if offset > 0.0:  # else u is known to 1e-8 only
            around = u + np.linspace(-1.0, 1.0, 2001) * 4 * np.sqrt(offset)
            check_samples(narrow, x, branch, arcs, 1e-7, around)
        tried += 1
    assert tried or offset < 0.0


def test_out_of_reach_nothing_is_feasible(arm):
    x = np.array([[5.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    for arcs in feasible_arcs(arm.self_motion(), x):
        assert arcs.empty.all()
        assert len(arcs.interval_set(0)) == 0
        assert arcs.runs(0) == []


def test_without_limits_the_whole_circle_is_feasible():
    arm = arm_of("iiwa7")
    chain = arm.chain
    free = SpatialArm(
        Chain(chain.names, chain.offsets, [None] * 7, chain.prismatic, chain.velocity, chain.base, chain.tip)
    )
    x = arm.forward(random_postures(arm, 1, 3))
    for arcs in feasible_arcs(free.self_motion(), x):
        assert arcs.interval_set(0).is_full
        ((low, high, causes),) = arcs.runs(0)
        assert high - low == pytest.approx(TAU)
        assert causes == ((), ())


def test_one_look_at_many_poses_is_many_looks(arm, looked_at):
    x, arcs = looked_at
    for k in range(3):
        alone = feasible_arcs(arm.self_motion(), x[k : k + 1])
        for one, all_ in zip(alone, arcs, strict=True):
            assert one.interval_set(0) == all_.interval_set(k)
