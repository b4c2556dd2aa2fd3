"""The angle domain as strips: together they are the domain, and each follows the ends of one interval."""

import numpy as np
import pytest

import selfmotion as sm
from oracle import random_arm, random_path
from selfmotion.domain.strips import strips

CASES = {
    "four": (
        sm.PlanarArm([7, 7, 4, 1.5], [(-2, 2), None, (-1.6, 1.6), (-1, 2.5)], direction=-np.pi / 3),
        sm.Circle([6, 4], 4),
    ),
    "parted": (sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.Line([1.5, -2.5], [1.5, 2.5])),
    "around": (sm.PlanarArm([30, 30, 20]), sm.Circle([0, 0], 60)),
    "locked": (sm.PlanarArm([30, 30, 20], [None, (1.0, 1.0), None]), sm.Line([50, -10], [60, 10])),
    "corners": (
        sm.PlanarArm([1, 1, 1], [(-2, 2)] * 3),
        sm.Waypoints([[1, 1], [2, 0.5], [0.3, 0.4], [2.9, 0]], "linear"),
    ),
}


def slices(domain, branch, r):
    """What the strips say is feasible at the places nearest to `r` that they know: pairs (r, IntervalSet)."""
    mine = [strip for strip in strips(domain.structure, branch) if strip.r[0] < r < strip.r[-1]]
    if not mine:
        return r, sm.IntervalSet([], 2 * np.pi)
    k = int(np.clip(np.argmin(np.abs(mine[0].r - r)), 1, len(mine[0].r) - 2))
    if any(strip.is_circle for strip in mine):
        return float(mine[0].r[k]), sm.IntervalSet.full()
    return float(mine[0].r[k]), sm.IntervalSet([(strip.low[k], strip.high[k]) for strip in mine], 2 * np.pi)


def assert_strips_are_the_domain(domain, branch, places):
    for place in places:
        r, got = slices(domain, branch, place)
        want = domain(r, branch)
        assert len(got) == len(want), (branch, r)
        np.testing.assert_allclose(got.intervals, want.intervals, atol=1e-9)


@pytest.mark.parametrize("branch", [0, 1])
@pytest.mark.parametrize("name", CASES)
def test_their_edges_are_the_interval_ends(name, branch):
    assert_strips_are_the_domain(sm.angle_domain(*CASES[name]), branch, np.linspace(0.003, 0.997, 60))


def test_their_edges_are_the_interval_ends_on_random_problems():
    """Turns counted or not: 60 arms with limits of every width, their ends in 4 places on both branches."""
    rng = np.random.default_rng(7)
    for _ in range(60):
        arm = random_arm(rng, widest=12.0)
        domain = sm.angle_domain(arm, random_path(rng, arm))
        for branch in (0, 1):
            assert_strips_are_the_domain(domain, branch, rng.uniform(0, 1, 4))


@pytest.mark.parametrize("branch", [0, 1])
@pytest.mark.parametrize("name", CASES)
def test_their_area_is_the_integral_of_the_measure(name, branch):
    domain = sm.angle_domain(*CASES[name])
    area = sum(np.trapezoid(strip.high - strip.low, strip.r) for strip in strips(domain.structure, branch))
    # The composite midpoint rule on every cell, where the measure is smooth but for square roots at the ends.
    total, at = 0.0, 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, 101)))
    for cell in domain.structure.cells:
        r = cell.r[0] + (cell.r[1] - cell.r[0]) * at
        middle = 0.5 * (r[1:] + r[:-1])
        total += np.diff(r) @ [domain(float(one), branch).measure for one in middle]
    assert area == pytest.approx(total, rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("branch", [0, 1])
@pytest.mark.parametrize("name", CASES)
def test_they_are_continuous_and_follow_each_other(name, branch):
    domain = sm.angle_domain(*CASES[name])
    ends = [end for cell in domain.structure.cells for end in cell.r]
    for strip in strips(domain.structure, branch):
        assert strip.r[0] in ends
        assert strip.r[-1] in ends
        assert (np.diff(strip.r) >= 0).all()
        assert (strip.high >= strip.low).all()
        for u in (strip.low, strip.high):
            assert np.abs(np.diff(u)).max() <= 0.05
        sheet = domain.structure.sheets[strip.sheet]
        assert sheet.r[0] <= strip.r[0]
        assert strip.r[-1] <= sheet.r[1]


def test_an_interval_opens_and_closes_in_one_point():
    domain = sm.angle_domain(*CASES["four"])
    (first, *_), (*_, last) = [strips(domain.structure, 0)] * 2
    kinds = {event.kind: event for event in domain.structure.events if event.branch == 0}
    for strip, k, kind in ((first, 0, "opens"), (last, -1, "closes")):
        assert strip.r[k] == kinds[kind].r
        assert strip.high[k] - strip.low[k] < 1e-6
        assert strip.low[k] == pytest.approx(kinds[kind].u, abs=1e-6)
        assert {c for end in strip.causes for c in end} == set(kinds[kind].causes)


def test_intervals_that_differ_in_turns_only_are_one_strip():
    arm = sm.PlanarArm([1, 1, 0.5], [(-9, 9), None, None])
    domain = sm.angle_domain(arm, sm.Line([1.0, 0.1], [1.0, 0.5]))
    for branch in (0, 1):
        names = [interval.ends for interval in domain.structure.cells[0].fibre.intervals if interval.branch == branch]
        assert len(names) > len(set(names))
        at_start = [strip.ends for strip in strips(domain.structure, branch) if strip.r[0] == 0.0]
        assert sorted(at_start) == sorted(set(names))


def test_a_path_that_winds_about_the_base_carries_whole_intervals_with_it(share):
    """Directions turn by several π over one cell: both ends of a strip must be lifted from the same place."""
    rng = np.random.default_rng(0)
    compared = 0
    for _ in range(int(share * 300)):
        arm = random_arm(rng)
        reach = arm.links[:3].sum()
        center = arm.annulus[0] + rng.uniform(-0.1, 0.1, 2) * reach
        path = sm.Ellipse(center, np.array([1, 0.9]) * rng.uniform(0.3, 0.75) * reach, sweep=rng.uniform(6, 20))
        domain = sm.angle_domain(arm, path)
        for branch in (0, 1):
            for strip in strips(domain.structure, branch):
                k = len(strip.r) // 3
                here = domain(float(strip.r[k]), branch)
                if not strip.is_circle and len(here) == 1:
                    assert strip.high[k] - strip.low[k] == pytest.approx(here.measure, abs=1e-6)
                    compared += 1
    assert compared > 300 * share
