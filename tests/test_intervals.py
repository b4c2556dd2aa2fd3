"""Interval algebra obeys its laws, on the line and on the circle, near the seam too."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from selfmotion import IntervalSet, InvalidInputError
from selfmotion.angles import TAU

ends = st.one_of(
    st.floats(-10, 10),
    st.sampled_from([-np.pi, np.pi, 0.0, np.nextafter(np.pi, 4), np.nextafter(-np.pi, -4), TAU, -TAU, 3 * np.pi]),
)
pairs = st.lists(
    st.tuples(ends, st.one_of(st.just(0.0), st.floats(0, 8), st.just(TAU))).map(lambda p: (p[0], p[0] + p[1])),
    max_size=4,
)
PROBES = np.linspace(-10, 10, 401)


def members(intervals, points, period):
    """Membership by definition, shifting each interval by whole periods."""
    inside = np.zeros(len(points), bool)
    for low, high in intervals:
        for k in range(-6, 7) if period else (0,):
            shift = k * (period or 0)
            inside |= (points >= low + shift) & (points <= high + shift)
    return inside


def near_an_end(intervals, points, period):
    near = np.zeros(len(points), bool)
    for end in np.ravel(intervals) if len(intervals) else []:
        gap = points - end
        if period:
            gap -= period * np.rint(gap / period)
        near |= np.abs(gap) < 1e-9
    return near


@pytest.mark.parametrize("period", [None, TAU])
@given(a=pairs, b=pairs)
def test_union_intersection_and_complement_are_those_of_sets(period, a, b):
    one, two = IntervalSet(a, period), IntervalSet(b, period)
    clear = ~near_an_end(a + b, PROBES, period)
    in_a, in_b = members(a, PROBES, period), members(b, PROBES, period)
    np.testing.assert_array_equal((one | two).contains(PROBES)[clear], (in_a | in_b)[clear])
    np.testing.assert_array_equal((one & two).contains(PROBES)[clear], (in_a & in_b)[clear])
    np.testing.assert_array_equal(one.complement(-20, 20).contains(PROBES)[clear], ~in_a[clear])


@given(a=pairs, b=pairs)
def test_de_morgan_on_the_circle(a, b):
    one, two = IntervalSet(a, TAU), IntervalSet(b, TAU)
    left = (one | two).complement()
    right = one.complement() & two.complement()
    clear = ~near_an_end(a + b, PROBES, TAU)
    np.testing.assert_array_equal(left.contains(PROBES)[clear], right.contains(PROBES)[clear])
    assert left.measure == pytest.approx(right.measure, abs=1e-9)
    assert one.measure + one.complement().measure == pytest.approx(TAU, abs=1e-9)


@given(a=pairs)
def test_intervals_are_sorted_disjoint_and_start_in_the_circle(a):
    intervals = IntervalSet(a, TAU).intervals
    assert (intervals[:, 0] >= -np.pi).all()
    assert (intervals[:, 0] <= np.pi).all()
    assert (intervals[:, 1] >= intervals[:, 0]).all()
    assert (intervals[1:, 0] > intervals[:-1, 1]).all()


def test_an_interval_across_the_seam_is_one_interval():
    across = IntervalSet([(3.0, 3.5)], TAU)
    assert len(across) == 1
    np.testing.assert_allclose(across.intervals, [[3.0, 3.5]])
    assert -3.0 in across
    assert 0.0 not in across
    assert len(across.pieces) == 2


def test_a_single_point_is_kept_and_found():
    point = IntervalSet([(1.0, 1.0)], TAU)
    assert point
    assert point.measure == 0
    assert 1.0 in point
    assert point.distance(1.5) == pytest.approx(0.5)


def test_distance_goes_round_the_circle():
    assert IntervalSet([(3.0, 3.1)], TAU).distance(-3.1) == pytest.approx(TAU - 6.2)
    assert IntervalSet([], TAU).distance(0.0) == np.inf
    assert IntervalSet.full().distance_to_ends(1.0) == np.inf


@pytest.mark.parametrize("bad", [[(2.0, 1.0)], [(np.nan, 1.0)], [(0.0, np.inf)], "ab", [(1, 2, 3)]])
def test_bad_intervals_are_refused(bad):
    with pytest.raises(InvalidInputError):
        IntervalSet(bad)


def test_sets_of_different_circles_do_not_mix():
    with pytest.raises(InvalidInputError):
        IntervalSet([(0, 1)], TAU) | IntervalSet([(0, 1)])
