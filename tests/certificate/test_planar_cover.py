"""Cells of planar self-motions: nothing feasible is lost, nothing is looser than it must be."""

import numpy as np
import pytest

import selfmotion as sm
from oracle import random_arm, random_path
from selfmotion.arms import _cover_kernels as kernels
from selfmotion.arms.planar_cover import PlanarCover

TAU = 2 * np.pi


def inside(cells, q, room=1e-11, dev=1.0):
    """Which postures (k, n) lie in some cell: q = (1 − s) a + s b + e with |e| ≤ dev, free of whole turns."""
    step, found = cells.b - cells.a, []
    for posture in q:
        d = posture - cells.a
        d -= TAU * np.rint((d - 0.5 * step) / TAU)
        around = dev * cells.dev + room
        still = np.abs(step) < 1e-300
        with np.errstate(divide="ignore", invalid="ignore"):
            one, two = (d - around) / step, (d + around) / step
        low = np.where(still, 0.0, np.minimum(one, two)).max(axis=1)
        high = np.where(still, 1.0, np.maximum(one, two)).min(axis=1)
        held = np.where(still, np.abs(d) <= around, True).all(axis=1)
        found.append((held & (np.maximum(low, 0.0) <= np.minimum(high, 1.0) + 1e-9)).any())
    return np.array(found)


def postures(arm, x, rng, count=200, elbow="any"):
    """Random feasible postures at x, and others next to every breakpoint."""
    breaks = arm.self_motion().breakpoints(arm.self_motion().pose(x)).u.ravel()
    near = breaks[np.isfinite(breaks), None] + rng.choice([-1, 1], 8) * 10.0 ** rng.uniform(-14, -1, 8)
    u = np.concatenate([rng.uniform(-np.pi, np.pi, count), near.ravel()])
    found = []
    for branch in range(2) if elbow == "any" else [arm.branches.index(elbow)]:
        q, ok = arm.solve(np.broadcast_to(x, (len(u), 2)), u[:, None], branch)
        found.append(q[ok & (arm.limits.excess(q) <= 0.0).all(axis=1)])
    return np.concatenate(found)


def bowed(cells, q, room=1e-9, rest=1.0):
    """Which postures (k, n) lie in some cell around its parabola, for an s that one joint tells."""
    step, around = cells.b - cells.a, rest * cells.rest + room
    rows, lead = np.arange(len(cells)), (around / np.maximum(np.abs(step), 1e-300)).argmin(axis=1)
    found = []
    for posture in q:
        d = posture - 0.5 * (cells.a + cells.b)
        d += 0.5 * step - TAU * np.rint(d / TAU)  # from end a
        held = np.zeros(len(cells), bool)
        for part in np.linspace(-1.0, 1.0, 9):
            target = (d + part * around)[rows, lead]
            s = np.zeros(len(cells))
            for _ in range(20):
                off = s * step[rows, lead] + 0.5 * s * (1 - s) * cells.bow[rows, lead] - target
                slope = step[rows, lead] + (0.5 - s) * cells.bow[rows, lead]
                s = np.clip(s - off / np.where(slope == 0.0, 1.0, slope), 0.0, 1.0)
            away = np.abs(s[:, None] * step + 0.5 * (s * (1 - s))[:, None] * cells.bow - d)
            held |= (away <= 1.3 * around).all(axis=1)
        found.append(held.any())
    return np.array(found)


@pytest.mark.parametrize("seed", range(40))
def test_nothing_feasible_is_lost(seed):
    rng = np.random.default_rng(seed)
    arm, path = random_arm(rng, widest=9.0), None
    path = random_path(rng, arm)
    elbow = ("any", "positive", "negative")[seed % 3]
    r = rng.uniform()
    cells = PlanarCover(arm, elbow).cells(path(r), 10.0 ** rng.uniform(-2.3, -0.5))
    q = postures(arm, path(r), rng, elbow=elbow)
    assert inside(cells, q).all()
    assert bowed(cells, q[::5]).all()
    assert (cells.dev >= 0.125 * np.abs(cells.bow) + cells.rest).all()


@pytest.mark.parametrize("links", [[1.0, 1.0, 0.7], [1.0, 1.0, 1.0], [0.5, 1.3, 0.9], [3.0, 0.2, 0.1]])
@pytest.mark.parametrize("off", [0.0, 1e-13, -1e-13, 1e-9, 1e-5, -1e-3])
def test_nothing_is_lost_at_singular_radii(links, off):
    # All three links in one line, or the first two folded onto the base: self-motions cross, or a joint is free.
    rng = np.random.default_rng(0)
    arm = sm.PlanarArm(links)
    l1, l2, l3 = links
    for radius in (l1 + l2 - l3, l1 - l2 + l3, -l1 + l2 + l3, l1 + l2 + l3, l3):
        if radius + off <= 1e-3:
            continue
        x = (radius + off) * np.array([np.cos(0.3), np.sin(0.3)])
        cells = PlanarCover(arm).cells(x, 0.1)
        assert inside(cells, postures(arm, x, rng, 60)).all()


def test_cells_are_no_looser_than_they_must_be():
    # A smooth curve leaves its chord by an eighth of its second derivative: half of that is too little.
    rng = np.random.default_rng(1)
    arm, path = sm.PlanarArm([30, 30, 20]), sm.Line([50.0, -10.0], [40.0, 30.0])
    cells = PlanarCover(arm).cells(path(0.3), 0.1)
    q = postures(arm, path(0.3), rng, 2000)
    assert inside(cells, q).all()
    assert not inside(cells, q, dev=0.5).all()
    lengths = np.abs(cells.b - cells.a).max(axis=1, keepdims=True)
    assert (cells.dev <= 0.6 * lengths**2 + 1e-9).all()


def test_parabolas_are_left_by_the_cube_of_the_length():
    rng = np.random.default_rng(1)
    arm, x = sm.PlanarArm([30, 30, 20]), np.array([47.0, 2.0])
    for spacing in (0.1, 0.05, 0.025):
        cells = PlanarCover(arm).cells(x, spacing)
        lengths = np.abs(cells.b - cells.a).max(axis=1, keepdims=True)
        assert (cells.rest <= 1.5 * lengths**3 + 1e-9).all()
        assert bowed(cells, postures(arm, x, rng, 500)).all()
        assert not bowed(cells, postures(arm, x, rng, 500), rest=0.02).all()


def test_a_cell_left_out_is_missed():
    rng = np.random.default_rng(2)
    arm, path = sm.PlanarArm([30, 30, 20], [None, (0.2, 2.5), None]), sm.Line([50.0, -10.0], [40.0, 30.0])
    cells = PlanarCover(arm).cells(path(0.3), 0.3)
    q = postures(arm, path(0.3), rng, 2000)
    lengths = np.abs(cells.b - cells.a).max(axis=1)
    long = np.flatnonzero(lengths > 0.05)
    missed = [not inside(cells[np.arange(len(cells)) != k], q).all() for k in long]
    assert np.mean(missed) > 0.6  # the others lie where two charts overlap


def test_ends_of_cells_are_postures_on_the_task():
    arm, path = sm.PlanarArm([1.0, 0.8, 0.6, 0.3], direction=0.4), sm.Line([1.2, 0.1], [0.9, 0.9])
    cells = PlanarCover(arm).cells(path(0.6), 0.05)
    assert arm.task_error(np.concatenate([cells.a, cells.b]), path(0.6)).max() < 1e-12


def test_splitting_keeps_what_is_feasible_and_turns():
    rng = np.random.default_rng(3)
    arm = sm.PlanarArm([1.0, 0.8, 0.6], [(-4.0, 5.0), (-1.0, 7.0), None])
    path = sm.Line([1.2, 0.1], [0.9, 0.9])
    cover = PlanarCover(arm)
    whole = cover.cells(path(0.2), 0.3)
    parts = cover.split(path(0.2), whole, np.full(len(whole), 0.02))
    assert inside(parts, postures(arm, path(0.2), rng)).all()
    assert (np.abs(parts.b - parts.a).max(axis=1) <= 1.3 * 0.02).all()
    # Every part is near its own whole, turns included.
    middle, room = 0.5 * (whole.a + whole.b)[parts.origin], (np.abs(whole.b - whole.a) + whole.dev)[parts.origin]
    assert (np.abs(0.5 * (parts.a + parts.b) - middle)[:, :2] <= room[:, :2] + 1e-9).all()


def test_all_turns_of_a_limited_joint_are_there():
    arm, path = sm.PlanarArm([1.0, 0.8, 0.6], [(-7.0, 7.0), None, None]), sm.Line([1.2, 0.1], [0.9, 0.9])
    free = PlanarCover(sm.PlanarArm([1.0, 0.8, 0.6])).cells(path(0.2), 0.05)
    turned = PlanarCover(arm).cells(path(0.2), 0.05)
    for q in 0.5 * (free.a + free.b):
        for turn in (-1, 0, 1):
            there = np.abs(turned.a[:, 0] - q[0] - TAU * turn) < 0.1
            assert there.any() == (abs(q[0] + TAU * turn) < 7.0) or abs(abs(q[0] + TAU * turn) - 7.0) < 0.1


@pytest.mark.parametrize("rho", [0.0, 1e-6, 1e-3, 0.05])
def test_boxes_hold_every_posture_of_a_piece(rho):
    rng = np.random.default_rng(7)
    middle, radius, phi = np.empty(3), np.empty(3), np.empty(3)
    seen = 0
    for _ in range(3000):
        links = rng.uniform(0.2, 2.0, 3)
        if rng.random() < 0.3:
            links[1] = links[0]
        x = rng.uniform(-1, 1, 2) * links.sum()
        chart, sign = int(rng.integers(3)), float(rng.choice([-1, 1]))
        low = rng.uniform(-np.pi, np.pi)
        high = low + 10.0 ** rng.uniform(-4, 0.3)
        kind = kernels.enclose(links, *x, rho, chart, sign, low, high, middle, radius)
        for _ in range(6):
            turn, out = rng.uniform(0, TAU), rho * rng.choice([0.0, 1.0])
            near = x + out * np.array([np.cos(turn), np.sin(turn)])
            angle = rng.choice([low, high, rng.uniform(low, high)])
            if kernels.solve(links, *near, chart, sign, angle, phi) < 0:
                assert kind != kernels.REGULAR
                continue
            seen += 1
            assert kind != kernels.DROP
            off = phi - middle
            assert (np.abs(off - TAU * np.rint(off / TAU)) <= radius + 1e-9).all()
    assert seen > 3000
