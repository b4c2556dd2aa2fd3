"""What both families of arms with a free roll are held to: each is a module of kernels, and a forward product."""

import numpy as np

from selfmotion.arms._roots import EMPTY, FOLDED, MERGED, REGULAR, SINGULAR

TAU = 2 * np.pi
CROSS = np.array([np.cross(axis, np.eye(3)).T for axis in np.eye(3)])
CROSS_TWICE = CROSS @ CROSS


def about(axis, angle):
    """Turn about a coordinate axis, by Rodrigues' formula, as a 4 × 4 transform."""
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * CROSS[axis] + (1 - np.cos(angle)) * CROSS_TWICE[axis]
    return pose


def along(x, y, z):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def random_tool(rng):
    """A tool in any rotation, shifted by centimetres; sometimes one whose axis is that of joint 6, or none at all."""
    kind = rng.integers(0, 4)
    if kind == 0:
        return about(2, rng.uniform(-3, 3)) @ along(0, 0, rng.uniform(-0.2, 0.2))
    turns = about(0, rng.uniform(-3, 3)) @ about(1, rng.uniform(-3, 3)) @ about(2, rng.uniform(-3, 3))
    return turns @ along(*(rng.uniform(-0.3, 0.3, 3) * (kind > 1)))


def with_tool(lengths, tool):
    back = np.linalg.inv(tool)
    return np.concatenate([lengths, back[:3, :3].ravel(), back[:3, 3]])


def wrapped(angle):
    return angle - TAU * np.rint(angle / TAU)


def ranges(array, width=0.0):
    return np.stack([array - width, array + width], axis=-1)


def halves(pose):
    return np.ascontiguousarray(pose[:3, :3]), np.ascontiguousarray(pose[:3, 3])


def solve(family, geometry, pose, u):
    q, ok = np.full((8, 6), 7.0), np.empty(8, bool)
    family.solve(geometry, *halves(pose), u, q, ok)
    assert np.isnan(q[~ok]).all()
    return q, ok


def enclose(family, geometry, pose, u0, u1):
    """Boxes, rates and states for a box of poses (4, 4, 2)."""
    box, rate, state = np.full((8, 6, 2), np.nan), np.full((8, 6, 2), np.nan), np.full(8, -1)
    family.enclose(geometry, *halves(pose), u0, u1, box, rate, state)
    return box, rate, state


def is_in(q, box, room=1e-12):
    """Whether each joint is in its range, up to whole turns."""
    middle, half = box.mean(axis=-1), np.diff(box, axis=-1)[..., 0] / 2
    return (abs(wrapped(q - middle)) <= half + room) | (half >= np.pi)


def apart(one, two):
    return abs(wrapped(one - two)).max(axis=-1)


def check_solutions(family, forward, geometry, tool, q, u, exact=1e-13):
    """Check all solutions at the pose from which posture q has turned its tool by u; return them: there may be none."""
    lengths = geometry[: family.LENGTHS]
    pose = forward(lengths, q) @ tool @ about(2, -u)
    found, ok = solve(family, geometry, pose, u)
    for b in np.flatnonzero(ok):
        assert abs(found[b]).max() <= np.pi + 1e-15
        again = forward(lengths, found[b]) @ tool
        assert abs(again - pose @ about(2, u)).max() < exact
        assert abs(wrapped(family.roll(geometry, halves(pose)[0], found[b]) - u)) < 1e-13
    return pose, found, ok


def nearby(rng, pose, room):
    """A pose whose entries differ by at most `room`."""
    turn = rng.uniform(-1, 1, 3) * room / 4
    moved = pose @ about(0, turn[0]) @ about(1, turn[1]) @ about(2, turn[2])
    moved[:3, 3] += rng.uniform(-room, room, 3) * 0.9
    return moved


def check_interval(family, forward, rng, geometry, tool, q, u, room):
    """Check what `enclose` claims of a random interval around u against sampled solutions; return the states.

    What solutions miss the pose by is less than the pose is widened by, so that next to no room is needed.
    """
    pose = forward(geometry[: family.LENGTHS], q) @ tool @ about(2, -u)
    width = 10.0 ** rng.uniform(-6, np.log10(0.5))
    u0 = u - width * rng.random()
    u1 = max(u, u0 + width)
    box, rate, state = enclose(family, geometry, ranges(pose, room), u0, u1)
    for b in range(8):
        held = state[b] not in (EMPTY, MERGED)
        assert not (held and np.isnan(box[b]).any())
        if held:
            assert (box[b, :, 0] <= box[b, :, 1]).all()
            assert (rate[b, :, 0] <= rate[b, :, 1]).all()
            assert state[b] != REGULAR or np.isfinite(rate[b]).all()
        home = family.home(state, b)
        assert (home == b) == (state[b] != MERGED)
        assert state[home] != MERGED
        assert state[b] != MERGED or state[home] in (FOLDED, SINGULAR)
    for trial in range(4):
        moved = nearby(rng, pose, room) if room > 0.0 and trial > 0 else pose
        before = None
        for v in np.sort([u0, u1, u, *rng.uniform(u0, u1, 2)]):
            found, ok = solve(family, geometry, moved, v)
            for b in np.flatnonzero(ok):
                assert state[b] != EMPTY
                assert is_in(found[b], box[family.home(state, b)]).all()
            assert ok[state == REGULAR].all()
            gap = v - before[0] if before else 0.0
            for b in np.flatnonzero(state == REGULAR) if gap > 1e-5 else []:
                steepest = abs(rate[b]).max()
                if steepest * gap < 3.0:  # otherwise it is not known how many turns there were
                    slope, fuzz = wrapped(found[b] - before[1][b]) / gap, 1e-7 + 1e-13 * (1 + steepest) ** 2 / gap
                    assert (slope >= rate[b, :, 0] - fuzz).all()
                    assert (slope <= rate[b, :, 1] + fuzz).all()
            before = v, found
    mine = family.home(state, family.branch_of(geometry, q))
    assert state[mine] not in (EMPTY, MERGED)
    assert is_in(q, box[mine]).all()
    return state


def check_turned(family, forward, rng, geometry, tool, q, u, room, joint, others):
    """Check that what `turned` leaves of a box holds the solutions, and `others` at this pose; return what was dropped.

    (−1, −1) if the branch of q is not singular in this joint.
    """
    pose = forward(geometry[: family.LENGTHS], q) @ tool @ about(2, -u)
    width = 10.0 ** rng.uniform(-4, np.log10(0.3))
    u0 = u - width * rng.random()
    u1 = max(u, u0 + width)
    poses = ranges(pose, room)
    box, _, state = enclose(family, geometry, poses, u0, u1)
    mine = family.home(state, family.branch_of(geometry, q))
    if state[mine] != SINGULAR or np.ptp(box[mine, joint]) < 6.28:
        return -1, -1
    there = [q, *others]
    for v in np.linspace(u0, u1, 5):
        found, ok = solve(family, geometry, nearby(rng, pose, room), v)
        there.extend(found[b] for b in np.flatnonzero(ok) if family.home(state, b) == mine)
    for posture in there:
        piece = box[mine].copy()
        low = posture[joint] - rng.uniform(0.001, 0.499)
        assert family.turned(geometry, *halves(poses), u0, u1, mine, joint, low, low + 0.5, piece)
        assert is_in(posture, piece).all()
        assert np.ptp(piece[joint]) < 0.5 + 1e-9
        # Narrowed again it still holds what it must; by another joint that is free, as well.
        assert family.turned(geometry, *halves(poses), u0, u1, mine, joint, low, low + 0.5, piece)
        for other in range(6):
            if np.ptp(piece[other]) >= 6.28 and other in family.FREE:
                low = posture[other] - rng.uniform(0.001, 0.499)
                assert family.turned(geometry, *halves(poses), u0, u1, mine, other, low, low + 0.5, piece)
        assert is_in(posture, piece).all()
    dropped = looked_at = 0
    if width < 0.01 and room < 1e-3 and joint in family.PARTNER:
        partner = family.PARTNER[joint]
        for low in np.arange(-3.0, 3.0, 0.25):
            piece = box[mine].copy()  # with the partner known, so is the joint
            piece[partner] = q[partner] + np.array([-0.02, 0.02])
            left = family.turned(geometry, *halves(poses), u0, u1, mine, joint, low, low + 0.25, piece)
            looked_at, dropped = looked_at + 1, dropped + (not left)
    return dropped, looked_at
