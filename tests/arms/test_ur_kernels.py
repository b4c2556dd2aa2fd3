"""Arms like Universal Robots' with a free roll: nothing is missing, and nothing lies outside of its box."""

from types import SimpleNamespace

import numpy as np
import pytest
import roll_checks as checks
from roll_checks import about, along, apart, random_tool, with_tool, wrapped

from selfmotion.arms import _ur_kernels as kernels
from selfmotion.arms._roots import EMPTY, FOLDED, MERGED, REGULAR, SINGULAR

UR5E = np.array([0.425, 0.3922, 0.1333, 0.0997])
UR10E = np.array([0.6127, 0.57155, 0.17415, 0.11985])
UR = SimpleNamespace(
    LENGTHS=kernels.LENGTHS, solve=kernels.solve, enclose=kernels.enclose, roll=kernels.roll, home=kernels.home,
    branch_of=kernels.branch_of, turned=kernels.turned, FREE=(5,), PARTNER={5: 3},
)  # fmt: skip
RIGHT = np.pi / 2


def forward(lengths, q):
    """The product of the joint transforms of Denavit and Hartenberg, Rz(q) Tz(d) Tx(a) Rx(α)."""
    a2, a3, d4, d5 = lengths
    pose = np.eye(4)
    table = [(0, 0, RIGHT), (0, a2, 0), (0, a3, 0), (d4, 0, RIGHT), (d5, 0, -RIGHT), (0, 0, 0)]
    for angle, (d, a, alpha) in zip(q, table, strict=True):
        pose = pose @ about(2, angle) @ along(a, 0, d) @ about(0, alpha)
    return pose


def random_lengths(rng):
    kind = rng.integers(0, 3)
    if kind < 2:
        return (UR5E, UR10E)[kind]
    return rng.uniform([0.2, 0.2, -0.3, -0.3], [0.8, 0.8, 0.3, 0.3])


def to_the_fold(lengths, q, near):
    """Move q2 so that the last frame's origin comes to `near` of where shoulders meet, in the arm's plane."""
    a2, a3, _, d5 = lengths
    x = a2 + a3 * np.cos(q[2]) + d5 * np.sin(q[2] + q[3])
    z = a3 * np.sin(q[2]) - d5 * np.cos(q[2] + q[3])
    length = np.hypot(x, z)
    if abs(near) < length:
        q[1] = wrapped(np.arccos(near / length) - np.arctan2(z, x))
    return q


def case(rng, kind):
    """Lengths and a posture: anywhere, or at or close to where branches meet."""
    lengths, q = random_lengths(rng), rng.uniform(-np.pi, np.pi, 6)
    near = rng.choice([0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-4, 1e-2]) * rng.choice([-1, 1])
    if kind in ("elbow", "all"):
        q[2] = wrapped(rng.choice([0.0, np.pi], p=[0.8, 0.2]) + near)
    if kind in ("shoulder", "both"):
        q = to_the_fold(lengths, q, near)
    if kind in ("wrist", "both", "all"):
        q[4] = wrapped(rng.choice([0.0, np.pi], p=[0.8, 0.2]) + near * rng.uniform(-1, 1))
    return lengths, q


def line(lengths, q, six):
    """The postures of the line through a posture with sin q5 = 0 that have q6 = six: both elbows."""
    a2, a3, _, d5 = lengths
    rest = forward(lengths, q)
    phi = q[1] + q[2] + q[3] - np.cos(q[4]) * (six - q[5])
    local = about(0, -RIGHT) @ about(2, -q[0]) @ rest
    x, z = local[0, 3] - d5 * np.sin(phi), local[1, 3] + d5 * np.cos(phi)
    cosine = (x * x + z * z - a2 * a2 - a3 * a3) / (2 * a2 * a3)
    found = []
    for three in np.arccos(cosine) * np.array([1, -1]) if abs(cosine) < 1.0 else []:
        two = np.arctan2(z, x) - np.arctan2(a3 * np.sin(three), a2 + a3 * np.cos(three))
        one = np.array([q[0], two, three, phi - two - three, q[4], six])
        assert abs(forward(lengths, one) - rest).max() < 1e-7
        if abs(forward(lengths, one) - rest).max() < 1e-14:
            found.append(one)
    return found


@pytest.mark.parametrize("u_offset", [0.0, 1.0])
def test_forward_of_inverse_is_the_pose(u_offset):
    rng, counts = np.random.default_rng(0), np.zeros(9, int)
    for _ in range(400):
        lengths, tool, q = random_lengths(rng), random_tool(rng), rng.uniform(-np.pi, np.pi, 6)
        u = rng.uniform(-np.pi, np.pi)
        geometry = with_tool(lengths, tool)
        _, found, ok = checks.check_solutions(UR, forward, geometry, tool, q, u * u_offset)
        branch = kernels.branch_of(geometry, q)
        assert ok[branch]
        assert apart(found[branch], q) < 1e-8
        for b in np.flatnonzero(ok):
            assert kernels.branch_of(geometry, found[b]) == b
        counts[ok.sum()] += 1
    assert counts[8] > 150
    assert counts[[2, 4, 6, 8]].sum() == counts.sum()
    assert counts[4] > 20


@pytest.mark.parametrize("kind", ["elbow", "shoulder", "wrist", "both", "all"])
def test_awkward_places(kind):
    rng, worst, without = np.random.default_rng(1), 0.0, 0
    lost = 0
    for _ in range(200):
        (lengths, q), tool = case(rng, kind), random_tool(rng)
        geometry = with_tool(lengths, tool)
        if np.sin(q[4]) == 0.0 and kind != "elbow":
            q = (line(lengths, q, q[5] + np.cos(q[4]) * (q[1] + q[2] + q[3])) or [None])[0]
            if q is None:  # the posture of that line that is looked for does not exist
                without += 1
                continue
        _, found, ok = checks.check_solutions(UR, forward, geometry, tool, q, rng.uniform(-3, 3))
        if not ok.any():  # next to q5 = 0, what rounding makes of the wrist may be out of the elbow's reach
            assert abs(np.sin(q[4])) < 1e-6
            lost += 1
        if kind == "elbow":  # the posture itself, but for the root of rounding
            worst = max(worst, apart(found[ok], q).min())
    assert worst < 1e-6
    assert without < 20
    assert lost < 70 if kind == "all" else lost == 0


def test_out_of_reach():
    lengths, geometry = UR5E, with_tool(UR5E, np.eye(4))
    pose = about(0, RIGHT)
    far = lengths[0] + lengths[1] + lengths[3]
    for x, y in ((far + 1e-9, -lengths[2]), (3.0, 0.3), (0.0, 0.1), (0.0, 0.0)):
        pose[:3, 3] = x, y, 0.0
        _, ok = checks.solve(UR, geometry, pose, 0.4)
        assert not ok.any()
        *_, state = checks.enclose(UR, geometry, checks.ranges(pose), 0.3, 0.5)
        assert (state == EMPTY).all()


def rival(eaik, lengths):
    """Solutions by subproblems (Ostermeier et al., EAIK), from axes and offsets with all joints at zero."""
    axes, origins, pose = [], [np.zeros(3)], np.eye(4)
    a2, a3, d4, d5 = lengths
    for d, a, alpha in [(0, 0, RIGHT), (0, a2, 0), (0, a3, 0), (d4, 0, RIGHT), (d5, 0, -RIGHT), (0, 0, 0)]:
        axes.append(pose[:3, 2])
        origins.append(pose[:3, 3])
        pose = pose @ along(a, 0, d) @ about(0, alpha)
    origins.append(pose[:3, 3])
    return eaik.HPRobot(np.array(axes), np.diff(origins, axis=0)), pose[:3, :3]


def compare(eaik, count, seed):
    """Count solutions of ours, of theirs, ours that they lack, and list theirs that we lack."""
    rng = np.random.default_rng(seed)
    ours = theirs = missed = 0
    lacking, robots = [], [(lengths, *rival(eaik, lengths)) for lengths in (UR5E, UR10E)]
    robots += [(lengths, *rival(eaik, lengths)) for lengths in (random_lengths(rng) for _ in range(20))]
    for _ in range(count):
        lengths, robot, zero = robots[rng.integers(0, len(robots))]
        q, tool, u = rng.uniform(-np.pi, np.pi, 6), random_tool(rng), rng.uniform(-np.pi, np.pi)
        geometry = with_tool(lengths, tool)
        pose = forward(lengths, q) @ tool @ about(2, -u)
        found, ok = checks.solve(UR, geometry, pose, u)
        target = pose @ about(2, u) @ np.linalg.inv(tool)
        wanted = target.copy()
        wanted[:3, :3] = target[:3, :3] @ zero.T
        answer = robot.IK(wanted)
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
        state = checks.check_interval(UR, forward, rng, geometry, tool, q, rng.uniform(-3, 3), room)
        counts += np.bincount(state, minlength=5)
    assert counts[REGULAR] > 500 or kind not in ("any", "elbow")
    assert (counts[FOLDED] > 100 and counts[MERGED] > 200) or kind not in ("elbow", "shoulder")
    assert counts[SINGULAR] > 100 or kind not in ("wrist", "both", "all")


def test_boxes_are_tight_and_shrink_in_proportion():
    """Over a narrow interval a box is little more than what the joints sweep."""
    rng, excess = np.random.default_rng(21), []
    for _ in range(300):
        tool, q = random_tool(rng), rng.uniform(-np.pi, np.pi, 6)
        geometry, u0 = with_tool(UR5E, tool), rng.uniform(-3, 3)
        pose = forward(UR5E, q) @ tool @ about(2, -u0)
        box, _, state = checks.enclose(UR, geometry, checks.ranges(pose), u0, u0 + 0.01)
        branch = kernels.branch_of(geometry, q)
        if state[branch] != REGULAR:
            continue
        sweep = np.array([checks.solve(UR, geometry, pose, u)[0][branch] for u in np.linspace(u0, u0 + 0.01, 9)])
        sweep = sweep[0] + wrapped(sweep - sweep[0])
        excess.append((np.ptp(box[branch], axis=-1) - np.ptp(sweep, axis=0)).max() / 0.01)
    assert len(excess) > 200
    assert np.median(excess) < 0.3


@pytest.mark.parametrize("kind", ["wrist", "both", "all"])
@pytest.mark.parametrize("room", [0.0, 1e-6, 1e-3])
def test_a_free_wrist_is_held_piece_by_piece(kind, room):
    """With q5 = 0, q6 may be anything that the arm can make good for: q2, q3 and q4 move with it."""
    rng, seen, dropped, looked_at, counted = np.random.default_rng(30), 0, 0, 0, 0
    for trial in range(120):
        (lengths, q), tool = case(rng, kind), random_tool(rng)
        others = []
        if trial % 2 == 0:
            q[4] = 0.0
            mine = np.sin(q[2]) < 0
            for six in rng.uniform(-3, 3, 3):
                others += [one for one in line(lengths, q, six) if (np.sin(one[2]) < 0) == mine]
            counted += len(others)
        geometry = with_tool(lengths, tool)
        far, all_of = checks.check_turned(UR, forward, rng, geometry, tool, q, rng.uniform(-3, 3), room, 5, others)
        if far >= 0:
            seen, dropped, looked_at = seen + 1, dropped + far, looked_at + all_of
    assert seen > 60
    assert counted > 60
    assert room > 0.0 or kind != "wrist" or dropped > 0.6 * looked_at > 0


def test_a_free_wrist_given_q6_leaves_little():
    rng, widths, before = np.random.default_rng(32), [], []
    for _ in range(200):
        q, tool = rng.uniform(-2.5, 2.5, 6), random_tool(rng)
        q[4] = 0.0
        geometry, u = with_tool(UR5E, tool), rng.uniform(-3, 3)
        pose = checks.ranges(forward(UR5E, q) @ tool @ about(2, -u))
        box, _, state = checks.enclose(UR, geometry, pose, u - 1e-4, u + 1e-4)
        mine = kernels.home(state, kernels.branch_of(geometry, q))
        assert state[mine] == SINGULAR
        assert np.ptp(box[mine, [3, 5]], axis=1).min() > 6.28
        piece = box[mine].copy()
        low = q[5] - 0.005
        there = kernels.turned(geometry, *checks.halves(pose), u - 1e-4, u + 1e-4, mine, 5, low, low + 0.01, piece)
        assert there
        assert checks.is_in(q, piece).all()
        before.append(np.ptp(box[mine], axis=1)[1])
        widths.append(np.ptp(piece, axis=1).max())
    assert np.median(widths) < 0.1
    assert np.median(before) > 3 * np.median(widths)
