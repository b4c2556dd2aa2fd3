"""Covers of constrained arms leave out no allowed posture, and their boxes neither."""

from itertools import pairwise, product

import numpy as np
import pytest
from small_scenes import planar, spatial

import selfmotion as sm
from selfmotion.arms._cover_kernels import solve
from selfmotion.arms.slabs import Boxes
from selfmotion.constrained.constraint import BLOCKED, FREE, States
from selfmotion.constrained.covers import ConstrainedSlabs
from selfmotion.scene import CircleObstacle, SphereObstacle

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


def postures_of(problem, boxes, rng, low, high):
    """A posture of each box's piece at some r of the slab (m, n), and whether there is one (m,)."""
    arm, phi = problem.arm, np.empty(3)
    found, ok = np.empty((len(boxes), arm.n)), np.empty(len(boxes), bool)
    for k, (chart, sign, start, stop) in enumerate(boxes.pieces):
        x, y = problem.path(rng.choice([low, high, rng.uniform(low, high)]))
        ok[k] = solve(arm.links, x, y, int(chart), sign, rng.uniform(start, stop), phi) >= 0.0
        found[k] = np.diff(phi, prepend=0.0)
    return found, ok


@pytest.mark.parametrize("size", [0.3, 0.05])
def test_what_is_sure_of_boxes_is_true_of_the_postures_that_they_were_made_for(size):
    """Where links are is known better than their joints tell, so that nothing is said of other postures in a box."""
    seen = np.zeros(3, int)
    for seed in range(24):
        problem, rng = planar(seed), np.random.default_rng(seed)
        low = rng.uniform(0.0, 0.9)
        high = low + rng.choice([0.001, 0.02, 0.1])
        bare = problem.arm.bare.slabs(problem.path).boxes(low, high, size)
        sifted = problem.arm.slabs(problem.path).boxes(low, high, size)
        for constraint in problem.arm.constraints:
            states = constraint.of_boxes(bare.low, bare.high, bare.places).state
            for _ in range(20):
                q, ok = postures_of(problem, bare, rng, low, high)
                margin = constraint.margins(q).min(axis=1)
                assert (margin[ok & (states == FREE)] >= -1e-12).all()
                assert (margin[ok & (states == BLOCKED)] < 0.0).all()
            seen[:2] += [(states == FREE).sum(), (states == BLOCKED).sum()]
        clean = sifted[sifted.clean]
        for _ in range(20 if len(clean) else 0):
            q, ok = postures_of(problem, clean, rng, low, high)
            assert ok.all()
            assert (problem.arm.least(q) >= -1e-12).all()
        seen[2] += len(clean)
    assert (seen > 300).all(), seen


def test_what_is_known_of_the_tool_decides_boxes_that_joints_do_not():
    """A box that is a radian wide tells nothing of the last link; that the tool is at a post tells all."""
    arm = sm.PlanarArm([1.0, 1.0, 1.0])
    path = sm.Line([2.0, 0.3], [2.0, 0.31])
    problem = sm.Problem(arm, path, obstacles=[CircleObstacle((2.0, 0.3), 0.2)])
    (scene,) = problem.arm.constraints
    boxes = arm.slabs(path).boxes(0.0, 1.0, 0.5)
    assert (scene.of_boxes(boxes.low, boxes.high, boxes.places).state == BLOCKED).all()
    assert (scene.of_boxes(boxes.low, boxes.high).state != BLOCKED).mean() > 0.5
    assert not len(problem.arm.slabs(path).boxes(0.0, 1.0, 0.5))


class Striped:
    """A constraint on one joint: states by where a box lies, undecided where it is in more than one stripe."""

    def __init__(self, blocked, free):
        self.blocked, self.free = blocked, free

    def of_boxes(self, low, high, places=None):
        def inside(stripe):
            return (low[:, 0] >= stripe[0]) & (high[:, 0] <= stripe[1])

        state = np.where(inside(self.blocked), BLOCKED, np.where(inside(self.free), FREE, 0))
        return States(state, np.zeros(len(low), int))


class Halves:
    """Slabs of one joint in [0, 1]: boxes are halved until they are as small as is asked."""

    n, wraps, one_sided, slabs = 1, np.array([False]), np.array([False]), 1

    def boxes(self, low, high, size):
        whole = np.array([[0.0, 1.0]])
        return self.split(low, high, self.made(whole, np.zeros(1, int)), np.array([size]))

    def split(self, low, high, boxes, size):
        rows, origin = [], []
        for k in range(len(boxes)):
            count = 1 << max(0, int(np.ceil(np.log2((boxes.high - boxes.low)[k, 0] / (2 * size[k]) - 1e-9))))
            edges = np.linspace(boxes.low[k, 0], boxes.high[k, 0], count + 1)
            rows += pairwise(edges)
            origin += [k] * count
        return self.made(np.array(rows), np.array(origin))

    def made(self, ends, origin):
        m = len(ends)
        return Boxes(ends[:, :1], ends[:, 1:], np.ones(m, bool), np.empty((m, 0)), origin, np.empty((m, 0, 5)))


def test_boxes_are_smaller_where_that_tells_more_and_whole_elsewhere():
    cover = ConstrainedSlabs(Halves(), [Striped((0.5, 0.75), (0.8125, 1.0))])
    boxes = cover.boxes(0.0, 0.1, 0.25)
    order = np.argsort(boxes.low[:, 0])
    np.testing.assert_array_equal(boxes.low[order, 0], [0.0, 0.75, 0.8125, 0.875])
    np.testing.assert_array_equal(boxes.high[order, 0], [0.5, 0.8125, 0.875, 1.0])
    np.testing.assert_array_equal(boxes.clean[order], [False, False, True, True])


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
