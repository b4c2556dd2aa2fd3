"""Shoulder, elbow, wrist: the closed form against forward kinematics, other solvers, sampling and bisection."""

import numpy as np
import pytest

from selfmotion.arms._roots import EMPTY, FOLDED, MERGED, REGULAR, SINGULAR
from selfmotion.arms._srs_arc_kernels import feasible_arcs
from selfmotion.arms._srs_kernels import arm_angle, branch_of, enclose, solve, solve_one, turned

TAU = 2 * np.pi
LIMITS = np.radians([170, 120, 170, 120, 170, 120, 175])
IIWA = (0.36, 0.42, 0.4)


def about(axis, angle):
    """Rotation about a coordinate axis, by Rodrigues' formula."""
    k = np.cross(np.eye(3)[axis], np.eye(3)).T
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


HALF = np.pi / 2
FRAMES = [
    about(2, yaw) @ about(1, pitch) @ about(0, roll)
    for roll, pitch, yaw in (
        (0, 0, 0), (HALF, 0, np.pi), (HALF, 0, np.pi), (HALF, 0, 0), (-HALF, np.pi, 0), (HALF, 0, 0), (-HALF, np.pi, 0),
    )
]  # fmt: skip


def forward(q, links=IIWA):
    """Rotation and wrist centre by the URDF's chain of fixed frames: origins between joints, z axes throughout."""
    shoulder, upper, fore = links
    shifts = np.zeros((7, 3))
    shifts[:3, 2] = 0.4 * shoulder, 0.6 * shoulder, 0
    shifts[2:6] = (0, 0.5 * upper, 0), (0, 0, 0.5 * upper), (0, 0.45 * fore, 0), (0, 0, 0.55 * fore)
    rotation, point = np.eye(3), np.zeros(3)
    for frame, shift, c, s in zip(FRAMES, shifts, np.cos(q), np.sin(q), strict=True):
        point = point + rotation @ shift
        rotation = rotation @ frame @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return rotation, point


def geometry(v=(0.0, 0.0, 1.0), links=IIWA):
    return np.array([*links, *v], float)


def solve_all(g, rotation, position, u):
    q, ok = np.empty((8, 7)), np.empty(8, bool)
    solve(g, rotation, position, u, q, ok)
    return q, ok


def wrapped(angle):
    return angle - TAU * np.rint(angle / TAU)


def error(g, q, rotation, position):
    again = forward(q, tuple(g[:3]))
    return max(abs(again[0] - rotation).max(), abs(again[1] - position).max())


def random_geometry(rng):
    links = IIWA if rng.random() < 0.5 else (rng.uniform(0, 1), *rng.uniform(0.2, 1.5, 2))
    if rng.random() < 0.1:
        links = (0.3, 0.5, 0.5)
    v = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), rng.normal(size=3)][rng.integers(0, 3)]
    return geometry(v, links)


def ranges(array, width=0.0):
    return np.stack([array - width, array + width], axis=-1)


def run_enclose(g, rotation, position, u0, u1):
    box, rate, state = np.full((8, 7, 2), np.nan), np.full((8, 7, 2), np.nan), np.full(8, -1)
    enclose(g, rotation, position, u0, u1, box, rate, state)
    return box, rate, state


def is_in(q, box, room=1e-11):
    """Whether each joint is in its range, up to whole turns."""
    middle, half = box.mean(axis=-1), np.diff(box, axis=-1)[..., 0] / 2
    return (abs(wrapped(q - middle)) <= half + room) | (half >= np.pi)


def home(branch, state, box):
    """The branch whose box must hold this one: itself, or the one that it was merged into."""
    if state[branch] != MERGED:
        return branch
    master = max(b for b in range(8) if b & branch == b and state[b] != MERGED and b & 4 == branch & 4)
    rest = branch ^ master
    assert state[master] == SINGULAR
    assert not rest & 1 or np.ptp(box[master, 0]) >= TAU
    assert not rest & 2 or np.ptp(box[master, 4]) >= TAU
    return master


def test_forward_of_inverse_is_the_pose():
    rng = np.random.default_rng(0)
    for _ in range(1000):
        g = random_geometry(rng)
        q = rng.uniform(-LIMITS, LIMITS)
        pose = forward(q, tuple(g[:3]))
        u = arm_angle(g, q)
        found, ok = solve_all(g, *pose, u)
        assert ok.all()
        assert abs(found).max() <= np.pi + 1e-15
        for b in range(8):
            assert error(g, found[b], *pose) < 1e-13
            assert branch_of(np.empty(0), found[b]) == b
            assert abs(wrapped(arm_angle(g, found[b]) - u)) < 1e-9
            one = np.empty(7)
            assert solve_one(g, *pose, u, b, one)
            assert (one == found[b]).all()
        assert abs(wrapped(found[branch_of(np.empty(0), q)] - q)).max() < 1e-9


def test_half_the_arm_angles_of_a_circle_differ_from_the_others():
    """Eight branches at one ψ are eight postures, and the elbow goes round the line SW by what ψ does."""
    rng = np.random.default_rng(1)
    g = geometry()
    q = rng.uniform(-LIMITS, LIMITS)
    rotation, wrist = forward(q)
    shoulder = np.array([0, 0, IIWA[0]])
    n = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    elbows = []
    for u in (0.2, 0.9):
        found, _ = solve_all(g, rotation, wrist, u)
        assert min(abs(wrapped(found[i] - found[j])).max() for i in range(8) for j in range(i)) > 1e-3
        # E is d_se along z3, and z3 is W's direction with the forearm gone.
        points = [about(2, f[0]) @ about(1, f[1]) @ np.array([0, 0, IIWA[1]]) for f in found]
        assert np.ptp(points, axis=0).max() < 1e-12
        elbows.append(points[0] - (points[0] @ n) * n)
    one, two = elbows
    turn = np.arctan2(np.cross(one, two) @ n, one @ two)
    assert turn == pytest.approx(0.7, abs=1e-12)


@pytest.mark.parametrize("tiny", [0.0, 1e-12, 1e-9, 1e-7, -1e-7, 1e-4])
def test_awkward_places(tiny):
    rng = np.random.default_rng(2)
    for case in range(60):
        q = rng.uniform(-LIMITS, LIMITS)
        kind = case % 6
        g = geometry((1.0, 0.0, 0.0) if kind == 4 else (0.0, 0.0, 1.0))
        if kind == 0:
            q[1] = tiny
        elif kind == 1:
            q[5] = tiny
        elif kind == 2:
            q[1] = q[5] = tiny
        elif kind == 3:
            q[3] = tiny
        elif kind == 4:  # the wrist on the base axis: q2 = −(angle of SW to the upper arm) with q3 = 0
            bend = np.arctan2(IIWA[2] * np.sin(q[3]), IIWA[1] + IIWA[2] * np.cos(q[3]))
            q[1], q[2] = bend, tiny
        else:
            q[1], q[3], q[5] = tiny, -tiny, tiny
        pose = forward(q)
        u = arm_angle(g, q)
        found, ok = solve_all(g, *pose, u)
        assert ok.all()
        assert max(error(g, f, *pose) for f in found) < 1e-13
        mine = found[branch_of(np.empty(0), q)]
        # At a singular posture one of a line of postures is found; sums of the two joints stay.
        if kind == 0 and tiny == 0.0:
            assert abs(wrapped(mine[0] + mine[2] - q[0] - q[2])) < 1e-9
        elif kind == 1 and tiny == 0.0:
            assert abs(wrapped(mine[4] + mine[6] - q[4] - q[6])) < 1e-9
        elif abs(tiny) >= 1e-7 and kind in (0, 1, 2, 4):
            assert abs(wrapped(mine - q)).max() < 1e-6


def test_out_of_reach():
    g = geometry()
    for distance in (0.82 + 1e-9, 0.02 - 1e-9, 3.0, 0.0):
        position = np.array([distance * 0.6, distance * 0.8, 0.36])
        _, ok = solve_all(g, np.eye(3), position, 0.4)
        assert not ok.any()
        *_, state = run_enclose(g, ranges(np.eye(3)), ranges(position), 0.3, 0.5)
        assert (state == EMPTY).all()


def locked(q, joint):
    """Axes and points of the six joints that are left when one is locked at its angle, and the last frame, at zero."""
    h, p, rotation, point = [], [], np.eye(3), np.zeros(3)
    shifts = [np.array([0, 0, d]) for d in (IIWA[0], 0, IIWA[1], 0, IIWA[2], 0, 0)]
    axes, signs = [2, 1, 2, 1, 2, 1, 2], [1, 1, 1, -1, 1, 1, 1]
    for j in range(7):
        if j == joint:
            rotation = rotation @ about(axes[j], signs[j] * q[j])
        else:
            h.append(rotation[:, axes[j]] * signs[j])
            p.append(point.copy())
        # The joint's link: after joint 1 comes d_bs, after 3 d_se, after 5 d_ew; none of it moves at zero.
        point = point + rotation @ shifts[j]
    return np.array(h), np.array(p), rotation, point


def rival_postures(robot_of, rng, joint):
    """Every posture that another solver finds for a random pose, with one joint locked at a known posture's."""
    q = rng.uniform(-LIMITS, LIMITS)
    rotation, wrist = forward(q)
    found = robot_of(q, joint)(rotation, wrist)
    return q, rotation, wrist, found


def eaik_robot(q, joint):
    from eaik.IK_HP import HPRobot

    h, p, rotation, point = locked(q, joint)
    offsets = np.vstack([p[:1], np.diff(p, axis=0), [point - p[-1]]])
    robot = HPRobot(h, offsets)

    def run(target, wrist):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = target @ rotation.T, wrist
        answer = robot.IK(pose)
        free = np.delete(np.arange(7), joint)
        full = np.tile(q, (len(answer.Q), 1))
        if len(full):
            full[:, free] = np.array(answer.Q)
        return full[~np.array(answer.is_LS, bool)] if len(full) else full

    return run


@pytest.mark.parametrize("joint", [2, 6])
def test_nothing_is_missing_that_another_solver_finds(joint):
    pytest.importorskip("eaik")
    rng, seen = np.random.default_rng(10 + joint), 0
    g = geometry()
    for _ in range(250):
        _, rotation, wrist, found = rival_postures(eaik_robot, rng, joint)
        for q in found:
            if error(g, q, rotation, wrist) > 1e-8:
                continue
            mine, ok = solve_all(g, rotation, wrist, arm_angle(g, wrapped(q)))
            assert ok.all()
            assert abs(wrapped(mine - q)).max(axis=1).min() < 1e-5
            seen += 1
    assert seen > 500


def case(rng, kind):
    """A random geometry and posture: anywhere, or close to a fold, to q2 = 0, to q6 = 0, or to both."""
    g = random_geometry(rng)
    q = rng.uniform(-np.pi, np.pi, 7)
    near = 10.0 ** rng.uniform(-8, -1) * rng.choice([-1, 1])
    if kind == "fold":
        q[3] = rng.choice([0.0, np.pi]) + near
    if kind in ("shoulder", "both"):
        q[1] = rng.choice([0.0, np.pi], p=[0.8, 0.2]) + near
    if kind in ("wrist", "both"):
        q[5] = rng.choice([0.0, np.pi], p=[0.8, 0.2]) + near * rng.uniform(-1, 1)
    return g, wrapped(q)


@pytest.mark.parametrize("kind", ["any", "fold", "shoulder", "wrist", "both"])
@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_enclosures_hold_what_they_say(kind, spread):
    rng = np.random.default_rng(20)
    counts = np.zeros(5, int)
    for _ in range(400):
        g, q = case(rng, kind)
        rotation, wrist = forward(q, tuple(g[:3]))
        u = arm_angle(g, q)
        n = wrist - [0, 0, g[0]]
        if np.linalg.norm(np.cross(n, g[3:] / np.linalg.norm(g[3:]))) < 1e-3:
            continue
        width = 10.0 ** rng.uniform(-6, np.log10(0.5))
        u0 = u - width * rng.random()
        room = spread * 10.0 ** rng.uniform(-9, -1)
        box, rate, state = run_enclose(g, ranges(rotation, room), ranges(wrist, room), u0, u0 + width)
        counts += np.bincount(state, minlength=5)
        held = (state != EMPTY) & (state != MERGED)
        assert (box[held, :, 0] <= box[held, :, 1]).all()
        assert (rate[held, :, 0] <= rate[held, :, 1]).all()
        for trial in range(8):
            moved, point = rotation, wrist
            if room > 0.0 and trial > 0:
                turn = rng.uniform(-1, 1, 3) * room / 3
                moved = rotation @ about(0, turn[0]) @ about(1, turn[1]) @ about(2, turn[2])
                point = wrist + rng.uniform(-room, room, 3)
            v = [u, u0, u0 + width][trial] if trial < 3 else u0 + width * rng.random()
            found, ok = solve_all(g, moved, point, v)
            after, _ = solve_all(g, moved, point, v + 1e-6 * width)
            before, _ = solve_all(g, moved, point, v - 1e-6 * width)
            for b in np.flatnonzero(ok):
                assert state[b] != EMPTY
                master = home(b, state, box)
                # Near a singularity q1 or q5 is known to rounding over the sine only; at a reach's end, to its root.
                sines = np.sin(found[b, [1, 5]])
                rough = 1e-11 + 1e-14 / max(abs(sines).min(), 1e-14) + (3e-7 if kind == "fold" else 0.0)
                assert is_in(found[b], box[master], rough).all()
                if state[b] in (REGULAR, FOLDED) and u0 + 1e-6 * width <= v <= u0 + width * (1 - 1e-6):
                    steep = wrapped(after[b] - before[b]) / (2e-6 * width)
                    fuzz = 1e-14 / (1e-6 * width) / max(abs(sines).min(), 1e-14) + 1e-5 * (1 + abs(steep))
                    assert np.isfinite(rate[b]).all()
                    assert (steep >= rate[b, :, 0] - fuzz).all()
                    assert (steep <= rate[b, :, 1] + fuzz).all()
                assert state[b] != REGULAR or ok[b]
        if REGULAR in state:
            assert ok.all()
        # the posture itself, even where the closed form chooses another of a singular line
        mine = box[home(branch_of(np.empty(0), q), state, box)]
        assert is_in(q, mine, 1e-9 + (3e-7 if kind == "fold" else 0.0)).all()
    assert counts[REGULAR] > 100 or kind == "fold"
    assert kind not in ("shoulder", "wrist", "both") or (counts[SINGULAR] > 100 and counts[MERGED] > 100)
    assert kind != "fold" or counts[FOLDED] > 50


def test_boxes_are_tight_and_shrink_in_proportion():
    """Over a narrow interval a box is little more than what the joints sweep."""
    rng = np.random.default_rng(21)
    g, excess = geometry(), []
    for _ in range(200):
        pose = forward(rng.uniform(-LIMITS, LIMITS))
        u0 = rng.uniform(-3, 3)
        box, _, state = run_enclose(g, ranges(pose[0]), ranges(pose[1]), u0, u0 + 0.01)
        if state[0] != REGULAR:
            continue
        sweep = np.array([solve_all(g, *pose, u)[0][0] for u in np.linspace(u0, u0 + 0.01, 9)])
        sweep = sweep[0] + wrapped(sweep - sweep[0])
        excess.append((np.ptp(box[0], axis=-1) - np.ptp(sweep, axis=0)).max() / 0.01)
    assert len(excess) > 150
    assert np.median(excess) < 0.05


@pytest.mark.parametrize("joint", [0, 4])
@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_singular_lines_are_held_piece_by_piece(joint, spread):
    rng, dropped, missed, kept = np.random.default_rng(30 + joint), 0, 0, 0
    kind = "shoulder" if joint == 0 else "wrist"
    for trial in range(400):
        g, q = case(rng, "both" if trial % 3 == 0 else kind)
        if trial % 5 == 0:
            q[joint + 1] = 0.0
        rotation, wrist = forward(q, tuple(g[:3]))
        u = arm_angle(g, q)
        width = 10.0 ** rng.uniform(-4, np.log10(0.5))
        room = spread * 10.0 ** rng.uniform(-9, -2)
        u0 = u - width * rng.random()
        pose = ranges(rotation, room), ranges(wrist, room)
        box, _, state = run_enclose(g, *pose, u0, u0 + width)
        mine = home(branch_of(np.empty(0), q), state, box)
        if state[mine] != SINGULAR or np.ptp(box[mine, joint]) < TAU:
            continue
        rest = [j for j in range(7) if abs(j - joint) > 2 or j < joint]
        sampled = [solve_all(g, rotation, wrist, v) for v in np.linspace(u0, u0 + width, 7)]
        for low in np.arange(-3.5, 3.5, 0.5):
            piece = box[mine].copy()
            there = turned(g, *pose, u0, u0 + width, mine, joint, low, low + 0.5, piece)
            assert (piece[rest] == box[mine][rest]).all()
            if not there:
                assert not is_in(q[joint], np.array([low, low + 0.5]), -1e-6)
                for found, ok in sampled:
                    for b in np.flatnonzero(ok):
                        if home(b, state, box) == mine and abs(np.sin(found[b, joint + 1])) > 1e-6:
                            assert not is_in(found[b, joint], np.array([low, low + 0.5]), -1e-6)
                continue
            for found, ok in sampled:
                for b in np.flatnonzero(ok):
                    if home(b, state, box) == mine and is_in(found[b, joint], np.array([low, low + 0.5]), -1e-6):
                        assert is_in(found[b], piece, 1e-6).all()
            if is_in(q[joint], np.array([low, low + 0.5]), 0.0):
                kept += 1
                assert is_in(q, piece, 1e-9).all()
                # narrowed again, it still holds what it must
                assert turned(g, *pose, u0, u0 + width, mine, joint, low, low + 0.5, piece)
                assert is_in(q, piece, 1e-9).all()
            elif width < 0.01 and room < 1e-3 and not is_in(q[joint], np.array([low, low + 0.5]), 0.5):
                piece = box[mine].copy()  # where the third joint is known, so is the first
                piece[joint + 2] = q[joint + 2] + np.array([-0.05, 0.05])
                far = not turned(g, *pose, u0, u0 + width, mine, joint, low, low + 0.5, piece)
                dropped, missed = dropped + far, missed + (not far)
    assert kept > 50
    assert dropped > 10 * missed


def test_both_singular_narrowed_one_after_the_other():
    rng, seen = np.random.default_rng(40), 0
    for _ in range(100):
        g = geometry()
        q = rng.uniform(-LIMITS, LIMITS)
        q[1] = q[5] = 0.0
        rotation, wrist = forward(q)
        u = arm_angle(g, q)
        pose = ranges(rotation), ranges(wrist)
        box, _, state = run_enclose(g, *pose, u - 0.01, u + 0.02)
        mine = home(branch_of(np.empty(0), q), state, box)
        assert mine & 3 == 0
        assert np.ptp(box[mine], axis=1)[[0, 4]].min() >= TAU
        piece = box[mine].copy()
        for joint in (0, 4):
            assert turned(g, *pose, u - 0.01, u + 0.02, mine, joint, q[joint] - 0.1, q[joint] + 0.05, piece)
        assert is_in(q, piece, 1e-11).all()
        assert np.ptp(piece, axis=1).max() < 0.5
        seen += 1
    assert seen == 100


def within(q, lower, upper):
    """How far inside its limits the worst joint is, whatever its turns."""
    turns = q[..., None, :] + TAU * np.arange(-2, 3)[:, None]
    return np.minimum(turns - lower, upper - turns).max(axis=-2).min(axis=-1)


def arcs_of(g, pose, lower, upper, branch):
    arcs = np.full((40, 2), np.nan)
    count = feasible_arcs(g, *pose, lower, upper, branch, arcs)
    assert (feasible_arcs(g, *pose, lower, upper, branch, np.empty((0, 2)))) == count
    return arcs[:count]


def test_feasible_arcs_against_sampling_and_bisection():
    rng = np.random.default_rng(50)
    grid = np.linspace(-np.pi, np.pi, 241)[:-1]
    kinds = np.zeros(3, int)
    for _ in range(2000):
        g = random_geometry(rng)
        pose = forward(rng.uniform(-LIMITS, LIMITS), tuple(g[:3]))
        lower, upper = -LIMITS.copy(), LIMITS.copy()
        if rng.random() < 0.5:
            lower, upper = -rng.uniform(0.3, 3.1, 7), rng.uniform(0.3, 3.1, 7)
            if rng.random() < 0.3:
                upper[0], lower[6], upper[6] = 4.0, -np.inf, np.inf
        branch = int(rng.integers(0, 8))

        def slack(u, g=g, pose=pose, branch=branch, lower=lower, upper=upper):
            q = np.empty((*np.shape(u), 7))
            for where in np.ndindex(np.shape(u)):
                assert solve_one(g, *pose, np.asarray(u)[where], branch, q[where])
            return within(q, lower, upper)

        arcs = arcs_of(g, pose, lower, upper, branch)
        assert (np.diff(arcs, axis=1) >= 0).all()
        assert (arcs[:, 0] >= -np.pi).all()
        assert (arcs[1:, 0] >= arcs[:-1, 1]).all()
        assert len(arcs) == 0 or arcs[-1, 1] <= arcs[0, 0] + TAU + 1e-12
        kinds[min(len(arcs), 2)] += 1
        turns = arcs[:, None, :] + TAU * np.array([0, -1])[None, :, None]
        values = slack(grid)
        inside = ((turns[..., 0] <= grid[:, None, None]) & (grid[:, None, None] <= turns[..., 1])).any(axis=(1, 2))
        clear = abs(values) > 1e-9
        assert (inside == (values > 0))[clear].all()
        change = np.flatnonzero((values > 0) != (np.roll(values, -1) > 0))
        if len(change) == 0:
            continue
        a, b, start = grid[change], grid[change] + grid[1] - grid[0], values[change] > 0
        for _ in range(36):
            middle = 0.5 * (a + b)
            same = (slack(middle) > 0) == start
            a, b = np.where(same, middle, a), np.where(same, b, middle)
        assert abs(wrapped(arcs.ravel() - 0.5 * (a + b)[:, None])).min(axis=1).max() < 1e-8
    assert (kinds > 100).all()


@pytest.mark.parametrize("joint", [0, 1, 2, 4, 5, 6])
@pytest.mark.parametrize("side", [-1, 1])
def test_limits_that_are_just_touched(joint, side):
    """A limit at the very extreme of a joint: touched from outside a point is left, from inside all of the circle."""
    rng, seen = np.random.default_rng(60 + joint), 0
    g, q = geometry(), np.empty(7)
    grid = np.linspace(-np.pi, np.pi, 721)
    while seen < 20:
        pose = forward(rng.uniform(-LIMITS, LIMITS))

        def angle(u, pose=pose):
            solve_one(g, *pose, u, 0, q)
            return q[joint]

        values = np.array([angle(u) for u in grid])
        if abs(np.diff(values)).max() > 0.3:
            continue
        best = np.argmax(side * values)
        a, b = grid[best] - 0.01, grid[best] + 0.01
        for _ in range(100):  # golden-like search for the extreme
            c, d = a + 0.4 * (b - a), a + 0.6 * (b - a)
            a, b = (a, d) if side * angle(c) > side * angle(d) else (c, b)
        top = angle(0.5 * (a + b))
        wide = np.full(7, 3.2)
        lower, upper = -wide, wide.copy()
        (upper if side > 0 else lower)[joint] = top
        arcs = arcs_of(g, pose, lower, upper, 0)
        assert np.diff(arcs, axis=1).sum() == pytest.approx(TAU, abs=1e-5)
        lower, upper = -wide, wide.copy()
        (lower if side > 0 else upper)[joint] = top
        (upper if side > 0 else lower)[joint] = top + side * 0.5
        arcs = arcs_of(g, pose, lower, upper, 0)
        assert len(arcs) in (1, 2)
        # A flat extreme is known to the root of rounding over its curvature.
        assert max(abs(angle(u) - top) for u in arcs.ravel()) < 1e-13
        assert abs(wrapped(arcs - 0.5 * (a + b))).max() < 1e-5
        seen += 1


def test_arcs_break_where_the_branch_jumps():
    """Through q2 = 0 the posture of a branch jumps by half a turn of q1 and q3: two arcs that touch."""
    rng = np.random.default_rng(70)
    g = geometry()
    for joint in (1, 5) * 20:
        q = rng.uniform(-LIMITS, LIMITS)
        q[joint] = 0.0
        pose, u = forward(q), arm_angle(g, q)
        wide = np.full(7, 3.2)
        arcs = arcs_of(g, pose, -wide, wide, branch_of(np.empty(0), q))
        assert len(arcs) == 1
        assert arcs[0, 1] == pytest.approx(arcs[0, 0] + TAU)
        assert abs(wrapped(arcs - u)).max() < 1e-9
        # One posture of the singular line only: the arm angle of it is all that is left.
        i, k = joint - 1, joint + 1
        lower, upper = -wide, wide.copy()
        lower[i], upper[i] = wrapped(q[i]) - 1e-4, wrapped(q[i]) + 1e-4
        lower[k], upper[k] = wrapped(q[k]) - 1e-4, wrapped(q[k]) + 1e-4
        arcs = arcs_of(g, pose, lower, upper, branch_of(np.empty(0), q))
        assert (abs(wrapped(arcs - u)).min(axis=1) < 1e-3).any()
