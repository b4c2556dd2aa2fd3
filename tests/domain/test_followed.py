"""Intervals followed from look to look, against planted ones: no arm, only where they are and what they are called."""

import numpy as np
import pytest

from selfmotion.angles import TAU
from selfmotion.domain.feasible import Run
from selfmotion.domain.sampled import followed

A, B, C, D = (("a",), ("b",)), (("c",), ("d",)), (("a",), ("e",)), (("e",), ("b",))


def seen(low, high, causes):
    """An interval as looks give it: its lower end in [−π, π)."""
    turn = TAU * np.floor((low + np.pi) / TAU)
    return Run(float(low - turn), float(high - turn), causes)


def test_intervals_are_followed_through_whole_turns():
    """Two that go round the circle several times, one after the other, at steps of less than half a turn."""
    r = np.linspace(0, 1, 60)
    first, second = 20 * r, 20 * r + 3.0
    looks = [[seen(a, a + 1.0, A), seen(b, b + 2.0, B)][:: 1 if k % 2 else -1] for k, (a, b) in
             enumerate(zip(first, second, strict=True))]  # fmt: skip
    found = sorted(followed(r, looks), key=lambda strip: strip.causes)
    assert [strip.causes for strip in found] == [A, B]
    for strip, low, width in zip(found, (first, second), (1.0, 2.0), strict=True):
        np.testing.assert_array_equal(strip.r, r)
        turns = (strip.low - low) / TAU
        np.testing.assert_allclose(turns, np.rint(turns[0]), atol=1e-12)
        np.testing.assert_allclose(strip.high - strip.low, width)
    assert len({end for strip in found for end in strip.ends}) == 4


def test_of_intervals_with_the_same_ends_each_goes_on_as_the_one_it_shares_most_with():
    r = np.linspace(0, 1, 9)
    places = np.array([[0.0, 0.9], [1.0, 1.8], [2.5, 3.5]])
    looks = [[seen(low + 0.2 * k, high + 0.2 * k, A) for low, high in places] for k in range(9)]
    found = followed(r, looks)
    assert len(found) == 3
    for strip, (low, high) in zip(found, places, strict=True):
        np.testing.assert_allclose(strip.low, low + 0.2 * np.arange(9), atol=1e-12)
        np.testing.assert_allclose(strip.high, high + 0.2 * np.arange(9), atol=1e-12)


def test_the_only_one_of_its_ends_goes_on_however_far_it_moves():
    (strip,) = followed(np.array([0.0, 1.0]), [[Run(0.0, 0.1, A)], [Run(1.0, 1.1, A)]])
    np.testing.assert_array_equal(strip.low, [0.0, 1.0])
    # Of two, neither is the only one: what shares nothing with them is another.
    found = followed(np.array([0.0, 1.0]), [[Run(0.0, 0.1, A)], [Run(1.0, 1.1, A), Run(2.0, 2.1, A)]])
    assert sorted(tuple(strip.r) for strip in found) == [(0.0,), (1.0,), (1.0,)]


@pytest.mark.parametrize("turn", [-TAU, 0.0, TAU])
def test_where_one_splits_fillers_hold_what_is_feasible_on_both_sides(turn):
    """Whichever turn the looks after the split are counted in."""
    r = np.linspace(0, 1, 6)
    halves = [Run(-1.0 + turn, 0.2 + turn, C), Run(0.5 + turn, 2.0 + turn, D)]
    found = followed(r, [[Run(-1.0, 2.0, A)]] * 3 + [halves] * 3)
    whole, *after = [strip for strip in found if strip.causes != ((), ())]
    np.testing.assert_array_equal(whole.r, r[:3])
    assert [strip.causes for strip in after] == [C, D]
    for strip in after:
        np.testing.assert_array_equal(strip.r, r[3:])
    fillers = [strip for strip in found if strip.causes == ((), ())]
    for strip in fillers:
        np.testing.assert_array_equal(strip.r, r[2:4])
    np.testing.assert_allclose([(s.low[0], s.high[0]) for s in fillers], [(-1.0, 0.2), (0.5, 2.0)], atol=1e-12)
    np.testing.assert_allclose([(s.low[1], s.high[1]) for s in fillers], [(-1.0, 0.2), (0.5, 2.0)], atol=1e-12)


def test_nothing_is_filled_between_what_shares_nothing():
    found = followed(np.array([0.0, 1.0]), [[Run(0.0, 1.0, A)], [Run(1.5, 2.0, B)]])
    assert [strip.causes for strip in found] == [A, B]


def test_a_full_circle_has_no_ends():
    (strip,) = followed(np.array([0.0, 1.0]), [[Run(-3.0, -3.0 + TAU, ((), ()))], [Run(-2.9, -2.9 + TAU, ((), ()))]])
    assert strip.is_circle
    assert strip.high[1] - strip.low[1] == pytest.approx(TAU)


@pytest.mark.parametrize("onward", [1, -1])
def test_of_two_that_join_in_one_of_the_same_ends_none_goes_on(onward):
    """Nor do two that one parts in: an end that jumped from one to the other would be drawn where there is none."""
    r = np.linspace(0, 1, 6)
    looks = ([[Run(0.0, 1.0, A), Run(1.2, 1.5, A)]] * 3 + [[Run(0.0, 1.5, A)]] * 3)[::onward]
    strips = [strip for strip in followed(r, looks) if strip.causes != ((), ())]
    assert len(strips) == 3
    assert all(np.ptp(strip.low) == np.ptp(strip.high) == 0.0 for strip in strips)
