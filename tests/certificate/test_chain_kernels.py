"""What chains of boxes pay, against shortest paths in scipy's graphs; overlap, against postures that two share."""

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from selfmotion.certificate._chain_kernels import cross, overlap, settle

TAU = 2 * np.pi


def random_boxes(rng, m, n, size=0.6):
    low = rng.uniform(-3, 3, (m, n))
    return low, low + rng.uniform(0, size, (m, n))


def test_boxes_overlap_where_they_share_a_posture():
    """One joint: intervals, on the line or on the circle; in several joints all must."""
    rng, counts = np.random.default_rng(0), np.zeros(2, int)
    for _ in range(400):
        n = int(rng.integers(1, 3))
        wraps = rng.random(n) < 0.5
        (low,), (high,) = random_boxes(rng, 1, n, 3.0)
        (other_low,), (other_high,) = random_boxes(rng, 1, n, 3.0)
        turns = TAU * rng.integers(-2, 3, n)
        shared = [
            any(max(a, c + t) <= min(b, d + t) for t in (TAU * np.arange(-3, 4) if wrapped else [0.0]))
            for a, b, c, d, wrapped in zip(low, high, other_low + turns, other_high + turns, wraps, strict=True)
        ]
        found = overlap(low, high, other_low + turns, other_high + turns, wraps)
        assert found == all(shared)
        assert found == overlap(other_low + turns, other_high + turns, low, high, wraps)
        counts[int(found)] += 1
    assert counts.min() > 50


@pytest.mark.parametrize(("gap", "touches"), [(0.0, True), (3e-11, True), (1e-9, False), (1e-3, False)])
def test_boxes_that_touch_overlap_up_to_rounding(gap, touches):
    low, high, wraps = np.array([0.1]), np.array([0.4]), np.array([False])
    assert overlap(low, high, high + gap, high + 1.0, wraps) == touches
    assert overlap(low, high, low - 1.0, low - gap, wraps) == touches


def graph(low, high, toll, wraps):
    """What going on from box to box costs (m, m); 0 where it cannot be done, as dense graphs have it."""
    m = len(low)
    fee = 0.5 * (toll[:, None] + toll)
    fits = [[overlap(low[i], high[i], low[k], high[k], wraps) for k in range(m)] for i in range(m)]
    return np.where(np.array(fits) & ~np.eye(m, dtype=bool), fee, 0.0)


@pytest.mark.parametrize("seed", range(6))
def test_inside_a_slab_chains_pay_what_the_shortest_path_does(seed):
    rng = np.random.default_rng(seed)
    m, wraps = 40, np.array([False, True])
    low, high = random_boxes(rng, m, 2, 1.2)
    toll = rng.uniform(0.1, 1.0, m)
    cost = np.where(rng.random(m) < 0.1, rng.uniform(0, 1, m), np.inf)
    cost[0] = 0.3
    # A node before all others, from which each is reached at the cost that it begins with.
    edges = np.zeros((m + 1, m + 1))
    edges[:m, :m] = graph(low, high, toll, wraps)
    edges[m, :m] = np.where(np.isfinite(cost), cost + 1.0, 0.0)
    wanted = dijkstra(edges, indices=m)[:m] - 1.0
    settle(low, high, toll, wraps, cost)
    np.testing.assert_allclose(cost, wanted, atol=1e-12)
    assert 1 < np.isfinite(cost).sum() < m


@pytest.mark.parametrize("seed", range(4))
def test_between_slabs_chains_take_the_cheapest_step(seed):
    rng = np.random.default_rng(seed)
    wraps = np.array([True, False])
    (low, high), (to_low, to_high) = random_boxes(rng, 30, 2, 2.0), random_boxes(rng, 25, 2, 2.0)
    toll, to_toll, cost = rng.random(30), rng.random(25), np.where(rng.random(30) < 0.5, rng.random(30), np.inf)
    found = np.where(rng.random(25) < 0.5, 0.9, np.inf)
    wanted = found.copy()
    for k in range(25):
        for i in range(30):
            if overlap(low[i], high[i], to_low[k], to_high[k], wraps):
                wanted[k] = min(wanted[k], cost[i] + 0.5 * (toll[i] + to_toll[k]))
    cross(low, high, toll, cost, to_low, to_high, to_toll, wraps, found)
    np.testing.assert_array_equal(found, wanted)
    assert np.isfinite(found).sum() > 0
