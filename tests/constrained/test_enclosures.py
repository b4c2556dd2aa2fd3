"""What constraints call free has no forbidden posture in it, and what they call blocked no allowed one."""

import numpy as np
import pytest
from small_scenes import planar, postures, spatial, within

from selfmotion.arms.cells import Cells
from selfmotion.constrained.constraint import BLOCKED, FREE

TORCH = {"translation": [0.05, 0.02, 0.15], "rpy": [0.0, 0.6, 0.0]}
SEEDS = range(24)


def looked_at(problem, sets, draw, rng, times):
    """Counts of free and of blocked sets whose random postures are all as is said."""
    for constraint in problem.arm.constraints:
        states = sets(constraint)
        for _ in range(times):
            least = constraint.margins(draw(rng)).min(axis=1)
            assert (least[states.state == FREE] >= -1e-12 * constraint.scale).all()
            assert (least[states.state == BLOCKED] < 0.0).all()
        assert ((states.by >= 0) | (states.state == FREE)).all()
        yield int((states.state == FREE).sum()), int((states.state == BLOCKED).sum())


def random_cells(problem, rng, size, count=300):
    """Cells anywhere: of about `size`, with deviations."""
    a = postures(problem, rng, count)
    shape = a.shape
    b = a + rng.normal(0.0, size, shape) * rng.choice([0.1, 1.0], (count, 1))
    dev = rng.uniform(0.0, 0.1 * size, shape) * rng.choice([0.0, 1.0], (count, 1))
    return Cells(a, b, dev, np.zeros((count, 4)), np.arange(count))


@pytest.mark.parametrize("size", [0.01, 0.3])
def test_no_cell_in_the_plane_is_called_what_it_is_not(size):
    seen = np.zeros(2, int)
    for seed in SEEDS:
        problem, rng = planar(seed), np.random.default_rng(seed)
        cells = random_cells(problem, rng, size)
        for counts in looked_at(problem, lambda c, k=cells: c.of_cells(k), lambda g, k=cells: within(k, g), rng, 20):
            seen += counts
    assert (seen > 500).all()


@pytest.mark.parametrize("size", [0.01, 0.2])
def test_no_box_in_the_plane_is_called_what_it_is_not(size):
    seen = np.zeros(2, int)
    for seed in SEEDS:
        problem, rng = planar(seed), np.random.default_rng(seed)
        middle = postures(problem, rng, 300)
        half = rng.uniform(0.0, size, middle.shape)
        low, high = middle - half, middle + half

        def draw(g, low=low, high=high):
            t = g.choice([0.0, 1.0, 0.5, g.uniform()], low.shape)
            return low + t * (high - low)

        for counts in looked_at(problem, lambda c, a=low, b=high: c.of_boxes(a, b), draw, rng, 20):
            seen += counts
    assert (seen > 500).all()


@pytest.mark.parametrize(("name", "tool"), [("panda", None), ("iiwa14", None), ("ur5e", TORCH), ("kr6r900", TORCH)])
def test_no_cell_in_space_is_called_what_it_is_not(name, tool):
    problem, rng = spatial(name, tool), np.random.default_rng(5)
    cells = random_cells(problem, rng, 0.05, 400)
    for free, blocked in looked_at(problem, lambda c: c.of_cells(cells), lambda g: within(cells, g), rng, 10):
        assert free > 10
        assert blocked + free > 30
    low, high = np.minimum(cells.a, cells.b), np.maximum(cells.a, cells.b)
    boxes = looked_at(problem, lambda c: c.of_boxes(low, high), lambda g: g.uniform(low, high), rng, 10)
    assert sum(free for free, _ in boxes) > 20


def test_what_is_forgiven_is_no_more_than_that():
    for seed in range(6):
        problem, rng = planar(seed), np.random.default_rng(seed)
        constraint = problem.arm.constraints[0]
        q = postures(problem, rng, 2000)
        points = Cells(q, q, np.zeros_like(q), np.zeros((len(q), 4)), np.arange(len(q)))
        free = constraint.of_cells(points, 0.02).state == FREE
        assert (constraint.margins(q[free]).min(axis=1) >= -0.02 - 1e-12).all()
        assert free.any()
