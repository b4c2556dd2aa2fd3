"""Slab boxes: nothing feasible is lost, for any r of a slab, whatever its thickness and the boxes' size."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms._cover_kernels import solve
from selfmotion.arms.planar_slabs import PlanarSlabs

TAU = 2 * np.pi


def random_case(rng):
    """An arm of equal, common or extreme links with all kinds of limits, maybe a fourth link, and a path in reach."""
    links = [np.ones(3), rng.uniform(0.4, 1.6, 3), 10.0 ** rng.uniform(-0.7, 0.7, 3)][rng.integers(0, 3)]
    limits = []
    for _ in links:
        low = rng.uniform(-3.5, -0.3)
        kinds = [None, (low, rng.uniform(0.3, 3.5)), (low - 4.0, -low + 3.0), (low, None)]
        limits.append(kinds[rng.choice(4, p=[0.2, 0.5, 0.2, 0.1])])
    if rng.random() < 0.3:
        arm = sm.PlanarArm([*links, 0.4], [*limits, (-3.0, 4.0)], direction=rng.uniform(-3, 3))
    else:
        arm = sm.PlanarArm(links, limits)
    center, _, outer = arm.annulus
    points = center + outer * rng.uniform(-0.7, 0.7, (4, 2))
    path = [sm.Bezier(points), sm.Waypoints(points), sm.Line(points[0], points[1])][rng.integers(0, 3)]
    return arm, path, str(rng.choice(["any", "positive", "negative"]))


def feasible_postures(rng, arm, path, elbow, low, high, count):
    """Random feasible postures at random r, ends included, with every number of turns that the limits allow."""
    r = np.append(rng.uniform(low, high, count), [low, high])
    found = []
    for branch in (0, 1) if elbow == "any" else ([0] if elbow == "positive" else [1]):
        u = rng.uniform(-np.pi, np.pi, (len(r), 1))
        q, ok = arm.solve(path(r), u, branch)
        found.append(q[ok])
    q = np.concatenate(found)
    real = np.isfinite(arm.limits.lower) & np.isfinite(arm.limits.upper)
    for j in np.flatnonzero(real):
        turns = TAU * np.arange(-3, 4)
        lifted = q[:, None, :] + turns[None, :, None] * (np.arange(arm.n) == j)
        q = lifted.reshape(-1, arm.n)
        q = q[(q[:, j] >= arm.limits.lower[j]) & (q[:, j] <= arm.limits.upper[j])]
    return q


def are_in(boxes, q, arm, wraps):
    """Whether each posture is in a box; joints limited on one side only count modulo 2π."""
    free = wraps | ~(np.isfinite(arm.limits.lower) & np.isfinite(arm.limits.upper))
    return np.array([boxes.contain(posture, free, 1e-12).any() for posture in q], bool)


@pytest.mark.parametrize("part", range(4))
def test_every_feasible_posture_is_in_a_box(part):
    rng, seen = np.random.default_rng(part), 0
    for _ in range(40):
        arm, path, elbow = random_case(rng)
        cover = PlanarSlabs(arm, path, elbow)
        width = 10.0 ** rng.uniform(-5, -0.5)
        low = rng.uniform(0.0, 1.0 - width)
        high, size = low + width, 10.0 ** rng.uniform(-2, 0)
        boxes = cover.boxes(low, high, size)
        q = feasible_postures(rng, arm, path, elbow, low, high, 60)
        inside = are_in(boxes, q, arm, cover.wraps)
        assert inside.all(), (arm, path, elbow, q[~inside][0])
        middle, seen = 0.5 * (low + high), seen + len(q)
        finer = cover.split(low, middle, boxes, np.full(len(boxes), 0.3 * size))
        q = feasible_postures(rng, arm, path, elbow, low, middle, 60)
        assert are_in(finer, q, arm, cover.wraps).all(), (arm, path, elbow)
        assert finer.origin.max(initial=-1) < len(boxes)
    assert seen > 1000


@pytest.mark.parametrize("part", range(3))
def test_links_end_where_boxes_say(part):
    """Postures of each piece, for task points of the slab, against the places (x, y) ± (Δx, Δy) within rest."""
    rng, seen, known = np.random.default_rng(100 + part), 0, []
    for _ in range(60):
        arm, path, elbow = random_case(rng)
        cover = PlanarSlabs(arm, path, elbow)
        width = 10.0 ** rng.uniform(-6, -0.5)
        low = rng.uniform(0.0, 1.0 - width)
        boxes = cover.boxes(low, low + width, 10.0 ** rng.uniform(-2, 0.3))
        phi, offset = np.empty(3), arm.annulus[0]
        for (chart, sign, start, stop), places in zip(boxes.pieces, boxes.places, strict=True):
            assert places.shape == (arm.n + 1, 5)
            for r in (low, low + width, rng.uniform(low, low + width)):
                tool = path(r)
                x, y = tool - offset
                angle = rng.choice([start, stop, rng.uniform(start, stop)])
                if solve(arm.links[:3], x, y, int(chart), sign, angle, phi) < 0.0:
                    continue
                steps = arm.links[:3, None] * np.stack([np.cos(phi), np.sin(phi)], axis=1)
                ends = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0), tool[None]])[: arm.n + 1]
                off, line = ends - places[:, :2], places[:, 2:4]
                square = (line * line).sum(axis=1)
                along = np.divide((off * line).sum(axis=1), square, out=np.zeros(len(off)), where=square > 0)
                away = np.hypot(*(off - np.clip(along, -1.0, 1.0)[:, None] * line).T)
                assert (away <= places[:, 4] + 1e-14 * arm.reach).all(), (arm, path, elbow, away - places[:, 4])
                seen += 1
        known += [np.median(boxes.places[:, 2, 4]) / arm.reach] if len(boxes) else []
    assert seen > 5000
    assert np.median(known) < 0.1


def test_boxes_keep_inside_the_limits_and_are_small_where_the_slab_is_thin():
    arm = sm.PlanarArm([1, 1, 1], [(-2.2, 2.2)] * 3)
    cover = PlanarSlabs(arm, sm.Line([1.5, -2.5], [1.5, 2.5]))
    boxes = cover.boxes(0.3, 0.3001, 0.01)
    assert (boxes.low >= -2.2 - 1e-8).all()
    assert (boxes.high <= 2.2 + 1e-8).all()
    assert (boxes.high - boxes.low).max() <= 0.02
    assert len(boxes) < 2000
    # The limits are met around the base of the clean boxes only, so that most are not clean near them alone.
    assert boxes.clean.mean() > 0.8


def test_where_the_wrist_reaches_the_shoulder_nothing_is_lost():
    """Equal first links and the tool at the third link's length: the first joint turns freely there."""
    arm = sm.PlanarArm([1, 1, 0.8], None)
    path = sm.Line([0.8, 0.0], [0.8, 0.3])
    cover = PlanarSlabs(arm, path)
    boxes = cover.boxes(0.0, 0.01, 0.05)
    for angle in np.linspace(-3, 3, 50):
        assert boxes.contain(np.array([angle, np.pi, -np.pi - angle]), cover.wraps, 1e-9).any()


def test_limits_of_many_turns_lose_nothing():
    arm = sm.PlanarArm([1, 1, 1], [(-300.0, 300.0), None, (-2, 2)])
    cover = PlanarSlabs(arm, sm.Line([1.5, -0.5], [1.5, 0.5]))
    boxes = cover.boxes(0.4, 0.41, 0.1)
    q, ok = arm.solve([1.5, -0.1], [0.2], 0)
    assert ok
    for angle in q[0] + TAU * np.arange(-46, 47):
        assert boxes.contain(np.array([angle, q[1], q[2]]), cover.wraps, 1e-9).any()
