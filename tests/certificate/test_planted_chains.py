"""Proofs by chains of boxes where what is feasible is planted: rectangles in r and one joint angle."""

import time
from itertools import pairwise

import numpy as np
import pytest

from selfmotion.arms.slabs import Boxes
from selfmotion.certificate.chains import Chains, Ends, Slab


class Planted:
    """Covers rectangles (r0, r1, q0, q1) by a grid of boxes, as blurred as they are large."""

    n, slabs = 1, 4
    wraps = one_sided = np.array([False])

    def __init__(self, *rectangles):
        self.rectangles = rectangles

    def boxes(self, low, high, size):
        return self._gridded(low, high, [(-8.0, 8.0)], [size])

    def split(self, low, high, boxes, size):
        return self._gridded(low, high, np.column_stack([boxes.low, boxes.high]), size)

    def _gridded(self, low, high, parts, sizes):
        rows = []
        for origin, ((first, last), size) in enumerate(zip(parts, sizes, strict=True)):
            count = max(1, int(np.ceil((last - first) / (2 * size) - 1e-9)))
            edges = np.linspace(first, last, count + 1)
            for a, b in pairwise(edges):
                near = [one for one in self.rectangles if one[0] <= high and low <= one[1]
                        and one[2] - 0.5 * size <= b and a <= one[3] + 0.5 * size]  # fmt: skip
                if near:
                    rows.append((a, b, any(q0 <= a and b <= q1 and r0 <= low and high <= r1 for r0, r1, q0, q1 in near),
                                 origin))  # fmt: skip
        a, b, clean, origin = (np.array(column) for column in zip(*rows, strict=True)) if rows else np.empty((4, 0))
        return Boxes(a[:, None], b[:, None], clean.astype(bool), np.empty((len(a), 0)), origin.astype(int),
                     np.empty((len(a), 0, 5)))  # fmt: skip


def proof(*rectangles, **options):
    return Chains(Planted(*rectangles), **options).prove(time.perf_counter() + 5.0)


@pytest.mark.parametrize("at", [0.25, 0.5, 0.6])
@pytest.mark.parametrize("gap", [0.5, 0.05, 0.004])
def test_a_step_aside_blocks_where_it_is(at, gap):
    """The finer the step, the finer the proof; what is left says where it is, to a slab that the path began with."""
    found = proof((0.0, at, 0.0, 1.0), (at, 1.0, 1.0 + gap, 2.0))
    assert found.proved
    assert abs(found.latest - at) <= 0.25
    assert abs(found.earliest - at) <= 0.25
    parts = 1.0 / found.resolution
    assert parts == 4 * 2 ** round(np.log2(parts / 4))
    assert 1 <= found.rounds <= 24


def test_finer_steps_need_finer_boxes_and_slabs_only_there():
    coarse, fine = (proof((0.0, 0.3, 0.0, 1.0), (0.3, 1.0, 1.0 + gap, 2.0)) for gap in (0.3, 0.002))
    assert fine.resolution < coarse.resolution
    assert coarse.boxes < fine.boxes < 20 * coarse.boxes  # and not 300 times 150 as many


@pytest.mark.parametrize("overlap", [0.5, 0.02])
def test_what_hangs_together_is_clear(overlap):
    found = proof((0.0, 0.6, 0.0, 1.0), (0.5, 1.0, 1.0 - overlap, 2.0))
    assert not found.proved
    assert found.stopped == "clear"


def test_what_never_comes_back_does_not_lead_on():
    """There is a way round only if r may descend."""
    hook = (
        (0.0, 0.7, 0.0, 1.0),
        (0.6, 0.7, 1.0, 2.0),
        (0.2, 0.7, 2.0, 3.0),
        (0.2, 0.3, 3.0, 4.0),
        (0.2, 1.0, 4.0, 5.0),
    )
    assert proof(*hook).proved
    step = (0.2, 0.7, 3.0, 4.0)
    assert not proof(*hook[:3], step, hook[4]).proved


def test_ends_are_what_is_asked_for():
    """Two corridors side by side: from one to the other there is no way."""
    both = (0.0, 1.0, 0.0, 1.0), (0.0, 1.0, 2.0, 3.0)
    one, other = Ends(np.array([[0.5]])), Ends(np.array([[2.5]]))
    assert proof(*both, start=one, end=other).proved
    assert proof(*both, start=other, end=one).proved
    for ends in ((one, one), (other, other), (one, Ends()), (Ends(), other), (Ends(np.array([[0.5], [2.5]])), other)):
        assert not proof(*both, start=ends[0], end=ends[1]).proved
    # Turns count unless they need not.
    turned = np.array([[0.5 + 2 * np.pi]])
    assert proof(*both, start=Ends(turned)).proved
    assert not proof(*both, start=Ends(turned, 0.0, np.array([True]))).proved


def test_only_the_part_that_is_asked_for_is_looked_at():
    parts = (0.0, 0.5, 0.0, 1.0), (0.5, 1.0, 2.0, 3.0)
    assert proof(*parts).proved
    assert not proof(*parts, high=0.45).proved
    assert not proof(*parts, low=0.55).proved
    found = proof(*parts, low=0.4, high=0.6)
    assert found.proved
    assert found.resolution <= 0.05
    assert 0.4 <= found.earliest <= 0.5 <= found.latest <= 0.6


def test_time_and_budget_end_it():
    step = Planted((0.0, 0.5, 0.0, 1.0), (0.5, 1.0, 1.1, 2.0))
    late = Chains(step, deadline=time.perf_counter() - 1.0)
    assert not late.covered
    assert late.prove().stopped == "time"
    assert (late.prove().latest, late.prove().earliest) == (1.0, 0.0)
    assert Chains(step).prove(time.perf_counter() - 1.0).stopped == "time"
    spent = Chains(step)
    assert spent.prove(budget=spent.looked_at).stopped == "budget"
    assert Chains(step).prove(time.perf_counter() + 20.0).proved


def test_a_slab_keeps_what_both_ends_lead_to():
    boxes = Boxes(np.zeros((3, 2)), np.array([[0.2, 0.4], [0.1, 0.1], [1.0, 0.0]]), np.array([False, True, False]),
                  np.empty((3, 0)), np.arange(3), np.empty((3, 0, 5)))  # fmt: skip
    slab = Slab(0.2, 0.3, boxes, np.array([1.0, np.inf, 2.0]), np.array([0.5, 0.0, 3.0]))
    np.testing.assert_array_equal(slab.radius, [0.2, 0.05, 0.5])
    np.testing.assert_array_equal(slab.toll, [0.2, 0.0, 0.5])  # nothing for those with nothing outside the limits
    np.testing.assert_array_equal(slab.through, [1.5, np.inf, 5.0])
    kept = slab.kept()
    np.testing.assert_array_equal(kept.boxes.origin, [0, 2])
    np.testing.assert_array_equal(kept.through, [1.5, 5.0])
    assert (kept.low, kept.high) == (0.2, 0.3)


def test_boxes_as_large_as_the_first_are_usual_in_slabs_as_wide_as_the_first():
    whole = Chains(Planted((0.0, 1.0, 0.0, 1.0)), low=0.2, high=0.6)
    assert [slab.high - slab.low for slab in whole.slabs] == pytest.approx([0.0, 0.1, 0.1, 0.1, 0.1, 0.0])
    sizes = [whole._usual(slab) for slab in whole.slabs]
    assert sizes == pytest.approx([0.0, 0.3, 0.3, 0.3, 0.3, 0.0])
    assert whole._usual(Slab(0.3, 0.325, whole.slabs[1].boxes)) == pytest.approx(0.3 / 4)
