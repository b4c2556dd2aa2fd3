"""Covers of constrained arms leave out no allowed posture, and their boxes neither."""

from itertools import product

import numpy as np
import pytest
from small_scenes import planar, spatial

import selfmotion as sm
from selfmotion.scene import SphereObstacle

TURN = 2 * np.pi
PAD = 1e-9


def held(cells, q, wraps):
    """Whether some cell holds a posture q (n,), as `Cells` says, to within `PAD`."""
    off = q - cells.a
    off[:, wraps] -= TURN * np.rint((off - 0.5 * (cells.b - cells.a))[:, wraps] / TURN)
    along, room = cells.b - cells.a, cells.dev + PAD
    with np.errstate(divide="ignore", invalid="ignore"):
        one, two = (off - room) / along, (off + room) / along
    low, high = np.minimum(one, two), np.maximum(one, two)
    still = np.abs(along) < 1e-14
    inside = np.where(still, np.abs(off) <= room + 1e-13, True).all(axis=1)
    low, high = np.where(still, 0.0, low).max(axis=1), np.where(still, 1.0, high).min(axis=1)
    return bool((inside & (np.maximum(low, 0.0) <= np.minimum(high, 1.0))).any())


def allowed(problem, x, u):
    """Allowed postures at a task point, of all branches."""
    found = []
    for branch in range(len(problem.arm.branches)):
        q, ok = problem.arm.solve(np.broadcast_to(x, (len(u), len(x))), u[:, None], branch)
        q = q[ok]
        found.append(q[(problem.arm.least(q) >= 0).all(axis=1)] if len(q) else q)
    q, limits = np.concatenate(found), problem.arm.limits
    counted = np.isfinite(limits.lower) | np.isfinite(limits.upper)
    turns = np.array(list(product(*[range(-2, 3) if limited else (0,) for limited in counted])))
    lifted = (q[:, None] + TURN * turns).reshape(-1, q.shape[1])
    return lifted[((lifted >= limits.lower) & (lifted <= limits.upper)).all(axis=1)]


def check_cells(problem, rs, spacing, u):
    count = 0
    cover = problem.arm.cover()
    for r in rs:
        x = problem.path(r)
        cells = cover.cells(x, spacing)
        q = allowed(problem, x, u)
        for posture in q:
            assert held(cells, posture, cover.wraps), (r, posture)
        if len(cells):
            finer = cover.split(x, cells, np.full(len(cells), 0.2 * spacing))
            for posture in q[::5]:
                assert held(finer, posture, cover.wraps), (r, posture)
        count += len(q)
    return count


@pytest.mark.parametrize("spacing", [0.3, 0.02])
def test_cells_in_the_plane_hold_every_allowed_posture(spacing):
    count = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        u = np.sort(rng.uniform(-np.pi, np.pi, 60))
        count += check_cells(planar(seed), rng.uniform(size=3), spacing, u)
    assert count > 300


def test_cells_in_space_hold_every_allowed_posture():
    given, rng = spatial(), np.random.default_rng(0)
    problem = sm.Problem(
        given.arm.bare, given.path, obstacles=[SphereObstacle((0.2, -0.1, 0.5), 0.1)], least_singular_value=0.02
    )
    assert check_cells(problem, [0.3], 0.2, rng.uniform(*problem.arm.parameter_range, 120)) > 20


def test_boxes_in_the_plane_hold_every_allowed_posture():
    count = 0
    for seed in range(12):
        problem, rng = planar(seed), np.random.default_rng(seed)
        slabs = problem.arm.slabs(problem.path)
        for low in rng.uniform(0.0, 0.9, 2):
            high = low + rng.choice([0.01, 0.1])
            boxes = slabs.boxes(low, high, 0.1)
            finer = slabs.split(low, high, boxes, np.full(len(boxes), 0.03)) if len(boxes) else boxes
            for r in rng.uniform(low, high, 4):
                for q in allowed(problem, problem.path(r), rng.uniform(-np.pi, np.pi, 20)):
                    assert boxes.contain(q, slabs.wraps, PAD).any()
                    assert finer.contain(q, slabs.wraps, PAD).any()
                    count += 1
    assert count > 100


def test_clean_boxes_have_no_forbidden_posture():
    count = 0
    for seed in range(12):
        problem, rng = planar(seed), np.random.default_rng(seed)
        boxes = problem.arm.slabs(problem.path).boxes(0.4, 0.42, 0.05)
        clean = boxes[boxes.clean]
        for _ in range(20 if len(clean) else 0):
            q = rng.uniform(clean.low, clean.high)
            assert (problem.arm.least(q) >= -1e-12).all()
        count += len(clean)
    assert count > 50


def test_intervals_are_what_dense_samples_show():
    """Of the self-motion of a constrained arm: what dense samples allow is inside an interval, and nothing else is."""
    from selfmotion.domain import angle_domain

    wrong = total = 0
    u = np.linspace(-np.pi, np.pi, 2000, endpoint=False) + 1e-4
    for seed in range(8):
        problem = planar(seed)
        domain = angle_domain(problem.arm, problem.path)
        for r in (0.2, 0.7):
            for branch in (0, 1):
                x = np.broadcast_to(problem.path(r), (len(u), 2))
                q, ok = problem.arm.solve(x, u[:, None], branch)
                ok &= problem.arm.limits.excess(q).max(axis=-1) <= 0
                ok[ok] = (problem.arm.least(q[ok]) >= 0).all(axis=1)
                inside = np.zeros(len(u), bool)
                for low, high in domain(r, branch).intervals:
                    inside |= np.mod(u - low, TURN) <= high - low
                wrong += int((inside != ok).sum())
                total += int(ok.sum())
    assert total > 2000
    assert wrong <= 1e-3 * total
