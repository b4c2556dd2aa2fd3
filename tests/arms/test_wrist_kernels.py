"""Six axes with a spherical wrist and a free roll: nothing is missing, and nothing lies outside of its box."""

from types import SimpleNamespace

import numpy as np
import pytest
import roll_checks as checks
from roll_checks import about, along, apart, random_tool, with_tool, wrapped

from selfmotion.arms import _wrist_kernels as kernels
from selfmotion.arms._roots import EMPTY, FOLDED, MERGED, REGULAR, SINGULAR

IRB120 = np.array([0.0, -0.07, 0.0, 0.27, 0.302])
KR6 = np.array([-0.025, 0.035, 0.0, 0.455, -0.42])
WRIST = SimpleNamespace(
    LENGTHS=kernels.LENGTHS, solve=kernels.solve, enclose=kernels.enclose, roll=kernels.roll, home=kernels.home,
    branch_of=kernels.branch_of, turned=kernels.turned, FREE=(0, 3), PARTNER={3: 5},
)  # fmt: skip


def forward(lengths, q):
    """The ortho-parallel basis, from one joint to the next."""
    a1, a2, b, c2, c3 = lengths
    arm = about(2, q[0]) @ along(a1, 0, 0) @ about(1, q[1]) @ along(0, 0, c2) @ about(1, q[2]) @ along(a2, b, c3)
    return arm @ about(2, q[3]) @ about(1, q[4]) @ about(2, q[5])


def random_lengths(rng):
    kind = rng.integers(0, 4)
    if kind < 2:
        return (IRB120, KR6)[kind]
    lengths = rng.uniform([-0.2, -0.2, -0.2, 0.2, 0.2], [0.3, 0.2, 0.2, 0.8, 0.8])
    return lengths * np.array([1, 1, kind - 2, 1, rng.choice([-1, 1])])


def onto_axis(lengths, q, near):
    """Move q3 so that the wrist centre comes to `near` of axis 1, or of where shoulders meet, in the arm's plane."""
    a1, a2, _, c2, c3 = lengths
    k, phi = np.hypot(a2, c3), np.arctan2(a2, c3)
    sine = (near - a1 - c2 * np.sin(q[1])) / k
    if abs(sine) < 1.0:
        q[2] = wrapped(np.arcsin(sine) - q[1] - phi)
    return q


def stretched(lengths):
    return -np.arctan2(lengths[1], lengths[4])


def case(rng, kind):
    """Lengths and a posture: anywhere, or at or close to where branches meet."""
    lengths, q = random_lengths(rng), rng.uniform(-np.pi, np.pi, 6)
    near = rng.choice([0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-4, 1e-2]) * rng.choice([-1, 1])
    if kind in ("elbow", "all"):
        q[2] = wrapped(stretched(lengths) + rng.choice([0.0, np.pi], p=[0.8, 0.2]) + near)
    if kind in ("shoulder", "both"):
        q = onto_axis(lengths, q, near)
    if kind in ("wrist", "both", "all"):
        q[4] = wrapped(rng.choice([0.0, np.pi], p=[0.8, 0.2]) + near * rng.uniform(-1, 1))
    return lengths, q


@pytest.mark.parametrize("u_offset", [0.0, 1.0])
def test_forward_of_inverse_is_the_pose(u_offset):
    rng, counts = np.random.default_rng(0), np.zeros(9, int)
    for _ in range(400):
        lengths, tool, q = random_lengths(rng), random_tool(rng), rng.uniform(-np.pi, np.pi, 6)
        u = rng.uniform(-np.pi, np.pi)
        geometry = with_tool(lengths, tool)
        _, found, ok = checks.check_solutions(WRIST, forward, geometry, tool, q, u * u_offset)
        branch = kernels.branch_of(geometry, q)
        assert ok[branch]
        assert apart(found[branch], q) < 1e-8
        for b in np.flatnonzero(ok):
            assert kernels.branch_of(geometry, found[b]) == b
        counts[ok.sum()] += 1
    assert counts[8] > 150
    assert counts[4] > 50
    assert counts[[4, 8]].sum() == counts.sum()


@pytest.mark.parametrize("kind", ["elbow", "shoulder", "wrist", "both", "all"])
def test_awkward_places(kind):
    rng, worst = np.random.default_rng(1), 0.0
    for _ in range(200):
        (lengths, q), tool = case(rng, kind), random_tool(rng)
        geometry = with_tool(lengths, tool)
        _, found, ok = checks.check_solutions(WRIST, forward, geometry, tool, q, rng.uniform(-3, 3))
        assert ok.any()
        if kind == "elbow":  # the posture itself, but for the root of rounding
            worst = max(worst, apart(found[ok], q).min())
        if kind == "wrist":
            turned = found[ok] - q
            inner = apart(found[ok][:, :3], q[:3])
            sums = abs(wrapped(turned[:, 3] + np.where(np.cos(q[4]) > 0, 1, -1) * turned[:, 5]))
            assert (inner + sums).min() < 1e-7
    assert worst < 1e-6


def test_out_of_reach():
    geometry = with_tool(IRB120, np.eye(4))
    for distance in (0.27 + np.hypot(0.07, 0.302) + 1e-9, np.hypot(0.07, 0.302) - 0.27 - 1e-9, 3.0, 0.0):
        pose = about(1, 0.4) @ np.eye(4)
        pose[:3, 3] = distance * 0.6, distance * 0.48, distance * 0.64
        _, ok = checks.solve(WRIST, geometry, pose, 0.4)
        assert not ok.any()
        *_, state = checks.enclose(WRIST, geometry, checks.ranges(pose), 0.3, 0.5)
        assert (state == EMPTY).all()
    geometry = with_tool(np.array([0.1, 0.1, 0.2, 0.4, 0.4]), np.eye(4))
    pose[:3, 3] = 0.1, 0.1, 0.3  # nearer to axis 1 than b
    assert not checks.solve(WRIST, geometry, pose, 0.4)[1].any()
    assert (checks.enclose(WRIST, geometry, checks.ranges(pose), 0.3, 0.5)[2] == EMPTY).all()


def rival(eaik, lengths):
    """Solutions by subproblems (Ostermeier et al., EAIK), from axes and offsets with all joints at zero."""
    a1, a2, b, c2, c3 = lengths
    axes = np.eye(3)[[2, 1, 1, 2, 1, 2]]
    offsets = np.array([[0, 0, 0], [a1, 0, 0], [0, 0, c2], [a2, b, c3], [0, 0, 0], [0, 0, 0], [0, 0, 0]], float)
    return eaik.HPRobot(axes, offsets)


def compare(eaik, count, seed):
    """Count solutions of ours, of theirs, ours that they lack, and list theirs that we lack."""
    rng = np.random.default_rng(seed)
    ours = theirs = missed = 0
    lacking, robots = [], [(lengths, rival(eaik, lengths)) for lengths in (IRB120, KR6)]
    robots += [(lengths, rival(eaik, lengths)) for lengths in (random_lengths(rng) for _ in range(20))]
    for _ in range(count):
        lengths, robot = robots[rng.integers(0, len(robots))]
        q, tool, u = rng.uniform(-np.pi, np.pi, 6), random_tool(rng), rng.uniform(-np.pi, np.pi)
        geometry = with_tool(lengths, tool)
        pose = forward(lengths, q) @ tool @ about(2, -u)
        found, ok = checks.solve(WRIST, geometry, pose, u)
        target = pose @ about(2, u) @ np.linalg.inv(tool)
        answer = robot.IK(target)
        rows = np.array(answer.Q).reshape(-1, 6)[~np.array(answer.is_LS, bool).ravel()]
        right = [abs(forward(lengths, row) - target).max() < 1e-8 for row in rows]
        rows = rows[np.array(right, bool)]
        ours, theirs = ours + ok.sum(), theirs + len(rows)
        lacking += [(lengths, q, u, row) for row in rows if not ok.any() or apart(found[ok], row).min() > 1e-5]
        missed += sum(not len(rows) or apart(rows, row).min() > 1e-5 for row in found[ok])
    return ours, theirs, missed, lacking


def test_another_solver_finds_the_same():
    eaik = pytest.importorskip("eaik.IK_HP")
    ours, theirs, missed, lacking = compare(eaik, 500, 4)
    assert not lacking
    assert missed <= 0.01 * ours
    assert min(ours, theirs) > 2000


@pytest.mark.parametrize("kind", ["any", "elbow", "shoulder", "wrist", "both", "all"])
@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_enclosures_hold_what_they_say(kind, spread):
    rng, counts = np.random.default_rng(20), np.zeros(5, int)
    for _ in range(250):
        (lengths, q), tool = case(rng, kind), random_tool(rng)
        room = spread * 10.0 ** rng.uniform(-9, -2)
        geometry = with_tool(lengths, tool)
        state = checks.check_interval(WRIST, forward, rng, geometry, tool, q, rng.uniform(-3, 3), room)
        counts += np.bincount(state, minlength=5)
    assert counts[REGULAR] > 500 or kind not in ("any", "wrist")
    assert (counts[FOLDED] > 100 and counts[MERGED] > 200) or kind not in ("elbow", "shoulder")
    assert counts[SINGULAR] > 100 or kind in ("any", "elbow")


def test_boxes_are_tight_and_shrink_in_proportion():
    """Over a narrow interval a box is little more than what the joints sweep."""
    rng, excess = np.random.default_rng(21), []
    for _ in range(300):
        tool, q = random_tool(rng), rng.uniform(-np.pi, np.pi, 6)
        geometry, u0 = with_tool(IRB120, tool), rng.uniform(-3, 3)
        pose = forward(IRB120, q) @ tool @ about(2, -u0)
        box, _, state = checks.enclose(WRIST, geometry, checks.ranges(pose), u0, u0 + 0.01)
        branch = kernels.branch_of(geometry, q)
        if state[branch] != REGULAR:
            continue
        sweep = np.array([checks.solve(WRIST, geometry, pose, u)[0][branch] for u in np.linspace(u0, u0 + 0.01, 9)])
        sweep = sweep[0] + wrapped(sweep - sweep[0])
        excess.append((np.ptp(box[branch], axis=-1) - np.ptp(sweep, axis=0)).max() / 0.01)
    assert len(excess) > 250
    assert np.median(excess) < 0.1


@pytest.mark.parametrize("room", [0.0, 1e-6, 1e-3])
def test_a_free_wrist_is_held_piece_by_piece(room):
    rng, seen, dropped, looked_at = np.random.default_rng(30), 0, 0, 0
    for trial in range(120):
        (lengths, q), tool = case(rng, "wrist"), random_tool(rng)
        if trial % 4 == 0:
            q[4] = 0.0
        others = []
        if q[4] == 0.0:
            others = [q + np.array([0, 0, 0, t, 0, -t]) for t in rng.uniform(-3, 3, 4)]
        geometry = with_tool(lengths, tool)
        far, all_of = checks.check_turned(
            WRIST, forward, rng, geometry, tool, q, rng.uniform(-3, 3), room, 3, others
        )  # fmt: skip
        if far >= 0:
            seen, dropped, looked_at = seen + 1, dropped + far, looked_at + all_of
    assert seen > 60
    assert room > 0.0 or dropped > 0.7 * looked_at > 0


def euler(rotation):
    """Angles of Rz Ry Rz with the middle one positive."""
    return np.array(
        [
            np.arctan2(rotation[1, 2], rotation[0, 2]),
            np.arccos(np.clip(rotation[2, 2], -1, 1)),
            np.arctan2(rotation[2, 1], -rotation[2, 0]),
        ]
    )


@pytest.mark.parametrize("kind", ["shoulder", "both"])
@pytest.mark.parametrize("room", [0.0, 1e-6, 1e-3])
def test_a_free_shoulder_is_held_piece_by_piece(kind, room):
    """With the wrist centre on axis 1, q1 may be anything; q4, q5 and q6 make good for it."""
    rng, seen = np.random.default_rng(31), 0
    for trial in range(120):
        (lengths, q), tool = case(rng, kind), random_tool(rng)
        lengths = lengths * np.array([1, 1, 0, 1, 1])
        others = []
        if trial % 2 == 0:
            q = onto_axis(lengths, q, 0.0)
            rotation = forward(lengths, q)[:3, :3]
            for q1 in rng.uniform(-np.pi, np.pi, 3) if abs(forward(lengths, q)[:2, 3]).max() < 1e-14 else []:
                arm = (about(2, q1) @ about(1, q[1] + q[2]))[:3, :3]
                one = np.array([q1, q[1], q[2], *euler(arm.T @ rotation)])
                assert abs(forward(lengths, one) - forward(lengths, q)).max() < 1e-7
                two = one + np.array([0, 0, 0, np.pi, 0, np.pi])
                two[4] = -one[4]
                others += [o for o in (one, two) if abs(forward(lengths, o) - forward(lengths, q)).max() < 1e-14]
        geometry = with_tool(lengths, tool)
        found = checks.check_turned(WRIST, forward, rng, geometry, tool, q, rng.uniform(-3, 3), room, 0, others)
        seen += found[0] >= 0
    assert seen > 40


def test_a_free_shoulder_given_q1_leaves_little():
    rng, widths = np.random.default_rng(32), []
    for _ in range(300):
        q, tool = onto_axis(IRB120, rng.uniform(-1.5, 1.5, 6), 0.0), random_tool(rng)
        if abs(forward(IRB120, q)[:2, 3]).max() > 1e-14:
            continue
        geometry, u = with_tool(IRB120, tool), rng.uniform(-3, 3)
        pose = checks.ranges(forward(IRB120, q) @ tool @ about(2, -u))
        box, _, state = checks.enclose(WRIST, geometry, pose, u - 1e-4, u + 1e-4)
        mine = kernels.home(state, kernels.branch_of(geometry, q))
        assert state[mine] == SINGULAR
        assert np.ptp(box[mine, 0]) > 6.28
        assert np.ptp(box[mine, [1, 2]], axis=1).max() < 0.1 or abs(np.sin(q[2] - stretched(IRB120))) < 0.1
        piece = box[mine].copy()
        for joint in (0, 3):
            if np.ptp(piece[joint]) > 6.28:
                low = q[joint] - 0.01
                assert kernels.turned(
                    geometry, *checks.halves(pose), u - 1e-4, u + 1e-4, mine, joint, low, low + 0.02, piece
                )  # fmt: skip
        assert checks.is_in(q, piece).all()
        widths.append(np.ptp(piece, axis=1).max())
    assert len(widths) > 100
    assert np.median(widths) < 0.1
