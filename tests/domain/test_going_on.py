"""Intervals just before and just after an event: what goes on as what, where that is known beforehand."""

from dataclasses import replace

import numpy as np

from oracle import random_arm
from selfmotion.angles import TAU
from selfmotion.domain.events import Change, _goes_on, changes, joined
from selfmotion.domain.fibre import fibres


def turned(interval, turns, named=True):
    """The same interval, counted whole turns further on; without what stands at its ends if not `named`."""
    shift = TAU * turns
    arcs = tuple((low + shift, high + shift, here) for low, high, here in interval.arcs)
    ends = interval.ends if named else ((), ())
    return replace(interval, low=interval.low + shift, high=interval.high + shift, arcs=arcs, ends=ends)


def random_fibres(count, widest):
    rng = np.random.default_rng(9)
    for _ in range(count):
        arm = random_arm(rng, widest=widest)
        center, inner, outer = arm.annulus
        radius, angle = rng.uniform(inner, outer), rng.uniform(-np.pi, np.pi)
        x = center + radius * np.array([np.cos(angle), np.sin(angle)])
        (fibre,) = fibres(arm.self_motion(), x[None])
        yield fibre, rng


def test_an_interval_goes_on_as_itself_whichever_turn_it_is_counted_in():
    """By its postures alone, with its ends hidden: also those that lie on one another and differ in turns only."""
    turning = 0
    for fibre, rng in random_fibres(150, 12.0):
        after = replace(
            fibre, intervals=tuple(turned(one, rng.integers(-3, 4), named=False) for one in fibre.intervals)
        )
        before = replace(fibre, intervals=tuple(turned(one, 0, named=False) for one in fibre.intervals))
        for j, one in enumerate(before.intervals):
            mine = [k for k in range(len(after.intervals)) if _goes_on(before, j, after, k)]
            assert mine == ([j] if one.high > one.low else [])
        turning += any(one.turns for one in fibre.intervals)
    assert turning > 20


def test_where_nothing_happens_every_interval_goes_on_alone():
    for fibre, rng in random_fibres(80, 12.0):
        after = replace(fibre, intervals=tuple(turned(one, rng.integers(-1, 2)) for one in fibre.intervals))
        found = changes(0.5, fibre, after, fibre.u)
        count = len(fibre.intervals)
        assert sorted((change.before, change.after) for change in found) == [((k,), (k,)) for k in range(count)]
        assert not any(change.events for change in found)


def test_changes_are_joined_group_by_group():
    found = [Change((k,), (10 + k,), (f"event {k}",)) for k in range(6)]
    one, two, three = joined(found, [{0, 2}, {4, 5}, {2, 3}])
    assert one == Change((0, 2, 3), (10, 12, 13), ("event 0", "event 2", "event 3"))
    assert two == found[1]
    assert three == Change((4, 5), (14, 15), ("event 4", "event 5"))
    assert joined(found, []) == found
