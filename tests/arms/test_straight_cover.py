"""Cells of arms whose tool lies along the last axis: lines, and surfaces where another joint is free as well."""

import attack_covers as attack
import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms.catalogue import named_arm
from selfmotion.arms.straight_cover import StraightCover, is_straight

ARMS = ("irb120", "kr6r900", "ur5e")
KINDS = ("any", "shoulder", "shoulder ±1e-6", "elbow", "wrist", "wrist ±1e-6", "shoulder and wrist", "limit")
STEP = 0.05


def wandered(arm, q, rng, steps=40):
    """Postures reached from q by random steps along all directions in which its tool stands still, within limits."""
    offsets = arm.chain.offsets
    rotation, position = attack.target(arm.forward(q))
    error, jacobian = np.empty(5), np.empty((5, 6))
    found, way, spread = [q], rng.normal(size=6), 0.3
    for _ in range(steps):
        now = found[-1]
        attack.pose_error(offsets, 0, now, rotation, position, error, jacobian)
        _, sizes, vectors = np.linalg.svd(jacobian)
        still = vectors[np.append(sizes, 0.0) < 1e-7]
        way = still.T @ (still @ (way + spread * rng.normal(size=6)))
        now = now + STEP * way / np.linalg.norm(way)
        for _ in range(12):
            attack.pose_error(offsets, 0, now, rotation, position, error, jacobian)
            now = now - np.linalg.pinv(jacobian, 1e-6) @ error
        attack.pose_error(offsets, 0, now, rotation, position, error, jacobian)
        if np.abs(error).max() > 1e-13:  # a way on to first order only
            way, spread = rng.choice([-1.0, 1.0]) * np.eye(6)[5], 0.0
        elif ((now >= arm.limits.lower) & (now <= arm.limits.upper)).all():
            found.append(now)
        else:
            way = rng.normal(size=6)
    return np.array(found)


def away(cells, q, wraps):
    """By how much postures are outside all cells."""
    found = np.empty(len(q))
    attack.all_held(q, cells.a, cells.b, cells.bow, cells.dev, cells.rest, wraps, found)
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ARMS)
def test_no_posture_that_the_tool_allows_is_lost(name, kind):
    arm = attack.load(name)
    cover, rng = arm.cover(), np.random.default_rng([KINDS.index(kind), len(name)])
    assert isinstance(cover, StraightCover)
    reached = 0
    for spacing in (0.3, 0.1):
        q = attack.posture(arm, kind, rng)
        x = arm.forward(q)
        cells = cover.cells(x, spacing)
        shorter = cover.split(x, cells, np.full(len(cells), 0.4 * spacing))
        assert not attack.faults(arm, x, cells)
        for _ in range(10):
            found = wandered(arm, q, rng)
            reached += len(found)
            assert away(cells, found, cover.wraps).max() <= 1e-9
            assert away(shorter, found, cover.wraps).max() <= 1e-9
    assert reached > 20


@pytest.mark.parametrize("name", ARMS)
def test_at_singular_postures_two_joints_wander(name):
    """What the test above is worth: both joints that are free take many values, and cells without room lose them."""
    arm = attack.load(name)
    cover, rng = arm.cover(), np.random.default_rng(5)
    q = np.clip(attack.posture(arm, "wrist", rng), 0.5 * arm.limits.lower, 0.5 * arm.limits.upper)
    found = np.concatenate([wandered(arm, q, rng) for _ in range(10)])
    assert np.ptp(found[:, 3]) > 0.3
    assert np.ptp(found[:, 3] + found[:, 5]) > 0.3
    cells = cover.cells(arm.forward(q), 0.3)
    lines = cells[cells.pieces[:, 1] == 0.0]
    assert away(lines, found, cover.wraps).max() > 0.1


@pytest.mark.parametrize("name", ARMS)
def test_covers_are_no_larger_near_singularities_and_bounded_at_them(name):
    arm = attack.load(name)
    q = np.array([0.3, -0.6, 0.9, 0.4, 0.7, 0.2])
    usual = len(arm.cover().cells(arm.forward(q), 0.1))
    for bent in (1e-2, 1e-4, 1e-6, 1e-8):
        near = arm.cover().cells(arm.forward([*q[:4], bent, q[5]]), 0.1)
        assert len(near) <= 1.5 * usual
        assert near.rest.max() < 2e-12 / bent
    for spacing in (0.1, 0.02, 0.004):
        at = arm.cover().cells(arm.forward([*q[:4], 0.0, q[5]]), spacing)
        assert len(at) < 48 * 48 * 4 + 8 * 2 * 2 * np.pi / spacing


def test_only_a_tool_along_the_last_axis_makes_lines():
    assert is_straight(named_arm("ur5e", tool={"translation": [0.0, 0.0, 0.3], "rpy": [0.0, 0.0, 1.0]}))
    assert is_straight(named_arm("irb120", tool={"translation": [0.0, 0.0, 0.1], "rpy": [np.pi, 0.0, 0.0]}))
    assert not is_straight(named_arm("ur5e", tool={"translation": [1e-9, 0.0, 0.3]}))
    assert not is_straight(named_arm("irb120", tool={"translation": [0.0, 0.0, 0.3], "rpy": [0.0, 1e-9, 0.0]}))


@pytest.mark.parametrize("backwards", [False, True])
def test_plans_of_straight_tools_are_bounded(backwards):
    """A spindle along the last axis, whichever way its frame points: that joint need not move, and does not."""
    tool = {"translation": [0.0, 0.0, 0.1], "rpy": [np.pi * backwards, 0.0, 0.0]}
    arm = named_arm("irb120", tool=tool)
    start = arm.forward([0.3, 0.2, 0.3, 0.4, 0.9, 0.2])
    path = sm.PosePath(sm.Line(start[:3], start[:3] + np.array([0.0, 0.15, 0.05])), orientation=start[3:])
    plan = sm.plan(sm.Problem(arm, path, objective="l2", samples=100), sm.Global(gap=1e-3))
    assert plan.gap <= 1e-3
    assert plan.verification.holds
    assert np.ptp(plan(np.linspace(0.0, 1.0, 50))[:, 5]) < 1e-6


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ARMS)
def test_cells_with_the_last_joint_at_rest_are_few_and_lose_nothing(name, kind):
    arm, rng = attack.load(name), np.random.default_rng([9, KINDS.index(kind)])
    cover = arm.cover_with_an_end_open()
    q = attack.posture(arm, kind, rng)
    x = arm.forward(q)
    cells = cover.cells(x, 0.01)
    assert len(cells) <= 64 or "wrist" in kind or "shoulder" in kind
    assert len(cells) <= 5000
    again = cover.split(x, cells, np.full(len(cells), 0.003))
    assert len(again) == len(cells)
    for _ in range(5):
        found = wandered(arm, q, rng)
        assert away(cells, found, cover.wraps).max() <= 1e-9
        assert away(again, found, cover.wraps).max() <= 1e-9


def test_the_last_joint_moves_where_both_ends_say_so_and_the_bound_knows():
    arm = named_arm("irb120")
    q = np.array([0.3, 0.2, 0.3, 0.4, 0.9, 0.2])
    start = arm.forward(q)
    path = sm.PosePath(sm.Line(start[:3], start[:3] + np.array([0.0, 0.05, 0.0])), orientation=start[3:])
    free = sm.plan(sm.Problem(arm, path, objective="l2", start={"q": q.tolist()}, samples=100), sm.Global(gap=1e-3))
    end = free(1.0) + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.5])
    ends = {"start": {"q": q.tolist()}, "end": {"q": end.tolist()}}
    plan = sm.plan(sm.Problem(arm, path, objective="l2", samples=100, **ends), sm.Global(gap=1e-2))
    assert free.cost < 0.5
    assert plan.gap <= 1e-2
    assert plan.lower_bound >= np.hypot(1.5, 0.9 * free.cost) * 0.98
