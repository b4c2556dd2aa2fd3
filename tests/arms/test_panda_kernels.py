"""Panda-like arms: every solution is found, and nothing that exists lies outside of its box."""

import itertools

import numpy as np
import pytest

from selfmotion.arms import _panda_kernels as panda

TAU = 2 * np.pi
PANDA = np.array([0.333, 0.316, 0.0825, 0.384, -0.0825, 0.088])
LOWER = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973])
UPPER = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973])
EMPTY, REGULAR, FOLDED, SINGULAR, MERGED = panda.EMPTY, panda.REGULAR, panda.FOLDED, panda.SINGULAR, panda.MERGED


def forward(q, geometry=PANDA):
    """The product of the seven joint transforms."""
    d1, d3, a4, d5, a5, a7 = geometry
    right = np.pi / 2
    table = [
        (0, d1, 0),
        (0, 0, -right),
        (0, d3, right),
        (a4, 0, right),
        (a5, d5, -right),
        (0, 0, right),
        (a7, 0, right),
    ]
    pose = np.eye(4)
    for (a, d, alpha), angle in zip(table, q, strict=True):
        ca, sa, c, s = np.cos(alpha), np.sin(alpha), np.cos(angle), np.sin(angle)
        pose = pose @ [[c, -s, 0, a], [s * ca, c * ca, -sa, -d * sa], [s * sa, c * sa, ca, d * ca], [0, 0, 0, 1]]
    return pose


def solve(pose, u, geometry=PANDA):
    q, ok = np.empty((8, 7)), np.empty(8, bool)
    panda.solve(geometry, pose[:3, :3].copy(), pose[:3, 3].copy(), u, q, ok)
    return q, ok


def enclose(low, high, u0, u1, geometry=PANDA):
    """Boxes, rates and states for the poses between two."""
    pose = np.stack([low, high], -1)
    box, rate, state = np.full((8, 7, 2), np.nan), np.full((8, 7, 2), np.nan), np.empty(8, np.int64)
    panda.enclose(geometry, pose[:3, :3].copy(), pose[:3, 3].copy(), u0, u1, box, rate, state)
    return box, rate, state


def apart(one, two):
    """The largest difference between joints, modulo 2π; infinite with NaN."""
    difference = np.asarray(one) - two
    return np.nan_to_num(np.abs(difference - TAU * np.rint(difference / TAU)).max(-1), nan=np.inf)


def stretched(geometry=PANDA):
    return np.arctan2(geometry[1], geometry[2]) - np.arctan2(geometry[3], geometry[4])


def offset(q, geometry=PANDA):
    """How far the shoulder is from axis 5."""
    return geometry[4] + geometry[2] * np.cos(q[3]) + geometry[1] * np.sin(q[3])


def random_geometry(rng):
    return PANDA * rng.uniform(0.6, 1.6, 6) * np.where(np.arange(6) == 4, rng.choice([-1, 1]), 1)


def awkward(rng, q, geometry=PANDA):
    """Move a posture to, or next to, where branches meet."""
    near = rng.choice([0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-4]) * rng.choice([-1, 1])
    for kind in rng.choice(5, rng.integers(1, 3), replace=False):
        if kind == 0:
            q[4] = rng.choice([-1, 1]) * np.pi / 2 + near
        elif kind == 1:
            q[3] = stretched(geometry) + near
        elif kind == 2:
            q[1] = near
        elif kind == 3:
            q[3] = stretched(geometry) + np.pi + near
        else:
            q[3] = near  # axis 5 through the shoulder, where a4 = −a5
    return q


def test_stretched_angle_of_the_panda():
    assert stretched() == pytest.approx(-0.467, abs=1e-3)


@pytest.mark.parametrize("size", ["panda", "any"])
def test_solutions_reach_the_pose_and_the_posture_is_among_them(size):
    rng = np.random.default_rng(1)
    for _ in range(3000):
        geometry = PANDA if size == "panda" else random_geometry(rng)
        q = rng.uniform(LOWER, UPPER) if size == "panda" else rng.uniform(-np.pi, np.pi, 7)
        pose = forward(q, geometry)
        found, ok = solve(pose, q[6], geometry)
        branch = panda.branch_of(geometry, q)
        assert ok[branch]
        clear = min(abs(np.cos(q[4])), abs(np.sin(q[1])), abs(np.sin(q[3] - stretched(geometry))))
        assert apart(found[branch], q) < 1e-8 if clear > 1e-4 else 1e-3
        assert np.isnan(found[~ok]).all()
        for b in np.flatnonzero(ok):
            assert np.abs(forward(found[b], geometry) - pose).max() < 1e-13
            assert np.abs(found[b, :6]).max() <= np.pi
            assert found[b, 6] == q[6]
            assert panda.branch_of(geometry, found[b]) == b
        for one, two in itertools.combinations(np.flatnonzero(ok), 2):
            assert apart(found[one], found[two]) > 1e-9


@pytest.mark.parametrize("size", ["panda", "any"])
def test_nothing_is_lost_where_branches_meet(size):
    rng = np.random.default_rng(2)
    for _ in range(3000):
        geometry = PANDA if size == "panda" else random_geometry(rng)
        q = awkward(rng, rng.uniform(LOWER, UPPER), geometry)
        pose = forward(q, geometry)
        found, ok = solve(pose, q[6], geometry)
        assert ok.any()
        worst = max(np.abs(forward(found[b], geometry) - pose).max() for b in np.flatnonzero(ok))
        assert worst < 2e-13
        # The posture itself, up to the fourth root of rounding where elbows and wrists meet; with axes 1 and 3 in line,
        # or the shoulder on axis 5, it is one of a line of them.
        if min(abs(np.sin(q[1])), abs(offset(q, geometry))) > 1e-3:
            assert apart(found[ok], q).min() < 1e-2


def test_shoulder_in_line():
    rng = np.random.default_rng(3)
    for near in (0.0, 1e-300, 1e-16, 1e-7, -1e-7):
        q = rng.uniform(LOWER, UPPER)
        q[1] = near
        found, ok = solve(forward(q), q[6])
        mine = found[panda.branch_of(PANDA, q) & 6]
        assert ok[panda.branch_of(PANDA, q)]
        assert apart(mine[0] + mine[2], q[0] + q[2]) < 1e-9
        assert apart(mine[3:], q[3:]) < 1e-12


def test_unreachable_poses_have_no_solution():
    pose = np.eye(4)
    pose[:3, 3] = 2.0, 0.0, 0.5
    found, ok = solve(pose, 0.3)
    assert not ok.any()
    assert np.isnan(found).all()
    assert (enclose(pose, pose, -3.0, 3.0)[2] == EMPTY).all()


def other_solver(eaik, u, geometry=PANDA):
    """Solutions by subproblems (Ostermeier et al., EAIK), from axes and offsets with all joints at zero."""
    d1, d3, a4, d5, a5, a7 = geometry
    axes, origins, pose = [], [np.zeros(3)], np.eye(4)
    right = np.pi / 2
    for a, d, alpha in [
        (0, d1, 0),
        (0, 0, -right),
        (0, d3, right),
        (a4, 0, right),
        (a5, d5, -right),
        (0, 0, right),
        (a7, 0, right),
    ]:
        c, s = round(np.cos(alpha)), round(np.sin(alpha))
        pose = pose @ [[1, 0, 0, a], [0, c, -s, -d * s], [0, s, c, d * c], [0, 0, 0, 1]]
        axes.append(pose[:3, 2])
        origins.append(pose[:3, 3])
    origins.append(origins[-1])
    robot = eaik.HPRobot(np.array(axes), np.diff(origins, axis=0), [(6, u)])

    def solutions(target):
        wanted = target.copy()
        wanted[:3, :3] = target[:3, :3] @ pose[:3, :3].T
        answer = robot.IK(wanted)
        q = np.array(answer.Q).reshape(-1, np.shape(answer.Q)[-1] if len(answer.Q) else 6)
        keep = ~np.array(answer.is_LS, bool).ravel()
        q = np.array([np.append(row[:6], u) for row in q[keep]]).reshape(-1, 7)
        right = [np.abs(forward(row, geometry) - target).max() < 1e-8 for row in q]
        return q[np.array(right, bool)]

    return solutions


def compare(eaik, count, seed):
    """Count poses, solutions of ours, solutions of theirs, ours that they lack, and list theirs that we lack."""
    rng = np.random.default_rng(seed)
    ours = theirs = missed = 0
    lacking = []
    for _ in range(count):
        q = rng.uniform(LOWER, UPPER)
        pose, u = forward(q), float(rng.choice([q[6], rng.uniform(-np.pi, np.pi)]))
        found, ok = solve(pose, u)
        others = other_solver(eaik, u)(pose)
        ours, theirs = ours + ok.sum(), theirs + len(others)
        for row in others:
            if not ok.any() or apart(found[ok], row).min() > 1e-5:
                lacking.append((q, u, row))
        for row in found[ok]:
            missed += not len(others) or apart(others, row).min() > 1e-5
    return ours, theirs, missed, lacking


def test_another_solver_finds_the_same():
    eaik = pytest.importorskip("eaik.IK_HP")
    ours, theirs, missed, lacking = compare(eaik, 500, 4)
    assert not lacking
    assert missed <= 0.01 * ours
    assert min(ours, theirs) > 1500


def inside(box, q):
    """Whether a posture is in a box, joint by joint modulo 2π."""
    middle = box.mean(-1)
    near = q + TAU * np.rint((middle - q) / TAU)
    ways = near[:, None] + TAU * np.array([-1, 0, 1])
    return bool(((ways >= box[:, :1]) & (ways <= box[:, 1:])).any(1)[:6].all() and box[6, 0] <= q[6] <= box[6, 1])


def poses_near(rng, q, geometry, size, count):
    """Poses next to that of a posture."""
    poses = [forward(q, geometry)]
    for _ in range(count if size > 0 else 0):
        v = rng.normal(size=3)
        angle, (x, y, z) = size * rng.random(), v / np.linalg.norm(v)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        pose = poses[0].copy()
        pose[:3, :3] = (np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross) @ pose[:3, :3]
        pose[:3, 3] += size * rng.uniform(-1, 1, 3)
        poses.append(pose)
    return np.array(poses)


def check_interval(rng, poses, u0, u1, geometry):
    """Check all that `enclose` claims on samples; return the states and how much wider than those the boxes are."""
    box, rate, state = enclose(poses.min(0), poses.max(0), u0, u1, geometry)
    us = np.unique(np.clip(np.append(rng.uniform(u0, u1, 5), [u0, 0.5 * (u0 + u1), u1]), u0, u1))
    seen = {}
    for pose in poses:
        before = None
        for u in us:
            q, ok = solve(pose, u, geometry)
            for b in np.flatnonzero(ok):
                assert state[b] != EMPTY, (b, u)
                home = panda.home(state, b)
                assert state[home] not in (EMPTY, MERGED)
                assert (home == b) == (state[b] != MERGED)
                assert inside(box[home], q[b]), (b, home, state, u)
                seen.setdefault(b, []).append(q[b])
            for b in np.flatnonzero(state == REGULAR):
                assert ok[b]
                assert np.isfinite(rate[b]).all()
                if before is not None and u - before[0] > 1e-8:
                    step = q[b] - before[1][b]
                    slope = (step - TAU * np.rint(step / TAU)) / (u - before[0])
                    room = 1e-7 + 1e-12 * (1 + np.abs(rate[b]).max()) / (u - before[0])
                    assert (slope >= rate[b, :, 0] - room).all()
                    assert (slope <= rate[b, :, 1] + room).all()
            before = u, q
    ratios = []
    for b in np.flatnonzero(state == REGULAR):
        q = np.unwrap(np.array(seen[b]), axis=0)
        ratios.append(((box[b, :, 1] - box[b, :, 0]) / (np.ptp(q, axis=0) + 1e-9 + 1e-3 * (u1 - u0))).max())
    return state, ratios


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-4, 1e-2])
@pytest.mark.parametrize("kind", ["usual", "awkward", "any"])
def test_every_solution_is_in_its_box_and_every_rate_in_its_range(kind, size):
    rng, states = np.random.default_rng(int(1e9 * size) % 97), []
    tight = []
    for _ in range(600 if size == 0.0 else 150):
        geometry = random_geometry(rng) if kind == "any" else PANDA
        q = rng.uniform(LOWER, UPPER)
        if kind == "awkward":
            q = awkward(rng, q)
        elif kind == "any":
            q = rng.uniform(-np.pi, np.pi, 7)
        width = 10.0 ** rng.uniform(-6, np.log10(0.3))
        u0 = q[6] - width * rng.choice([0.0, 1.0, rng.random()])
        poses, u1 = poses_near(rng, q, geometry, size, 3), max(u0 + width, q[6])
        state, ratios = check_interval(rng, poses, u0, u1, geometry)
        box, _, _ = enclose(poses.min(0), poses.max(0), u0, u1, geometry)
        assert inside(box[panda.home(state, panda.branch_of(geometry, q))], q)
        states.extend(state)
        if width < 1e-3:
            tight.extend(ratios)
    counts = np.bincount(states, minlength=5)
    assert (counts > 0).all()
    if kind != "awkward":
        assert counts[REGULAR] > (0.3 if size < 1e-3 else 0.05) * len(states)
        assert size > 0.0 or np.median(tight) < 1.5


def test_boxes_of_single_angles_hold_their_solutions():
    rng = np.random.default_rng(11)
    for _ in range(500):
        q = rng.uniform(LOWER, UPPER)
        state, _ = check_interval(rng, forward(q)[None], q[6], q[6], PANDA)
        assert state[panda.branch_of(PANDA, q)] != EMPTY


def test_intervals_without_solutions_are_proved_empty():
    """Not only are solutions never contradicted: of small intervals well out of reach there is nothing left."""
    rng, empty = np.random.default_rng(12), 0
    for _ in range(500):
        pose = forward(rng.uniform(LOWER, UPPER))
        u = rng.uniform(-np.pi, np.pi)
        _, ok = solve(pose, u)
        state = enclose(pose, pose, u, u + 1e-9)[2]
        assert ((state == EMPTY) == ~ok).all() or (state == FOLDED).any()
        empty += (state == EMPTY).sum()
    assert empty > 300


@pytest.mark.parametrize("size", [0.0, 1e-3])
def test_shoulder_boxes_given_q1(size):
    """Where q1 is free: the solutions with q1 in a window, the whole line of them where axes 1 and 3 coincide."""
    rng, singular = np.random.default_rng(13), 0
    for _ in range(100):
        q = rng.uniform(LOWER, UPPER)
        q[1] = rng.choice([0.0, 1e-9, -1e-4, 1e-2])
        if rng.random() < 0.2:
            q[4] = np.pi / 2
        width = 10.0 ** rng.uniform(-6, -1)
        u0 = q[6] - width * rng.random()
        u1 = max(u0 + width, q[6])
        poses = poses_near(rng, q, PANDA, size, 2)
        low, high = np.stack([poses.min(0), poses.max(0)])
        state = enclose(low, high, u0, u1)[2]
        turned = [q + np.array([t, 0, -t, 0, 0, 0, 0]) for t in rng.uniform(-4, 4, 4)] if q[1] == 0.0 else [q]
        for pose, u in itertools.product(poses, np.append(rng.uniform(u0, u1, 2), q[6])):
            found, ok = solve(pose, u)
            turned.extend(found[ok])
        rotation, position = np.stack([low, high], -1)[:3, :3].copy(), np.stack([low, high], -1)[:3, 3].copy()
        for posture in turned:
            b = panda.home(state, panda.branch_of(PANDA, posture))
            if state[b] != SINGULAR:
                continue
            singular += 1
            b = rng.choice([b, panda.branch_of(PANDA, posture)])
            start = posture[0] - 0.5 * rng.random()
            box = np.empty((7, 2))
            assert panda.shoulder(PANDA, rotation, position, u0, u1, b, start, start + 0.5, box)
            assert inside(box, posture)
    assert singular > 300


def test_shoulder_refuses_a_q1_that_cannot_be():
    rng, refused, kept = np.random.default_rng(14), 0, 0
    for _ in range(300):
        q = rng.uniform(LOWER, UPPER)
        b, pose = panda.branch_of(PANDA, q), np.stack([forward(q)] * 2, -1)
        start, box = rng.uniform(-np.pi, np.pi), np.empty((7, 2))
        near = start <= q[0] <= start + 0.2
        known = panda.shoulder(PANDA, pose[:3, :3].copy(), pose[:3, 3].copy(), q[6], q[6], b, start, start + 0.2, box)
        assert known or not near
        kept += known and not near
        refused += not known
    assert refused > 200
    assert kept < 30


def test_the_line_of_postures_with_the_shoulder_on_axis_five():
    """Joint 5 turns and the shoulder takes it back: all of them are in one box."""
    rng = np.random.default_rng(15)
    for _ in range(200):
        q = rng.uniform(LOWER, UPPER)
        q[3] = 0.0
        pose = forward(q)
        width = rng.choice([0.0, 1e-3])
        box, _, state = enclose(pose, pose, q[6] - width, q[6] + width)
        for turn in rng.uniform(-np.pi, np.pi, 5):
            other = np.append([0.0, 0.0, 0.0, q[3], q[4] + turn], q[5:])
            r = pose[:3, :3] @ forward(other)[:3, :3].T
            other[:3] = np.arctan2(r[1, 2], r[0, 2]), np.arccos(r[2, 2]), np.arctan2(r[2, 1], -r[2, 0])
            assert np.abs(forward(other) - pose).max() < 1e-12
            home = panda.home(state, panda.branch_of(PANDA, other))
            assert state[home] in (FOLDED, SINGULAR)
            assert inside(box[home], other)
