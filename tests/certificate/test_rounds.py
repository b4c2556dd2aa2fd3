"""What the next round of a proof makes finer."""

import numpy as np

from selfmotion.certificate.rounds import BestMotion, finer, with_new
from selfmotion.certificate.tube import Chain

R = np.linspace(0, 1, 101)


def chain(q=0.5 * R, lost=0.0 * R):
    return Chain(R, np.column_stack([q, -q]), lost)


def best(excess):
    return BestMotion(np.array(excess), np.diff(chain().q, axis=0))


def test_without_a_motion_all_is_made_finer():
    slabs, spacing = finer(chain(), np.full(101, 0.1), None, 1.0, "joint_travel")
    assert slabs.all()
    assert (spacing < 0.1).all()


def test_slabs_are_halved_where_the_best_motion_is_longest_beyond_its_chord():
    excess = np.where(np.arange(100) < 20, 1e-2, 1e-6)
    slabs, _ = finer(chain(), np.full(101, 0.01), best(excess), 1e-3, "joint_travel")
    assert not slabs[20:].any()
    assert slabs[:20].sum() >= 15
    # No more than is asked for: half of it may stay.
    slabs, _ = finer(chain(), np.full(101, 0.01), best(excess), 0.2, "joint_travel")
    assert 0 < slabs.sum() < 20


def test_slabs_are_halved_where_only_the_cheapest_chords_jump():
    jump = 0.5 * R + 0.3 * (R > 0.425)
    slabs, _ = finer(chain(jump), np.full(101, 0.01), best(np.zeros(100)), 1.0, "joint_travel")
    np.testing.assert_array_equal(np.flatnonzero(slabs), [42])
    steep = BestMotion(np.zeros(100), np.diff(chain(jump).q, axis=0))
    assert not finer(chain(jump), np.full(101, 0.01), steep, 1.0, "joint_travel")[0].any()


def test_cells_get_shorter_where_they_lost_too_much():
    lost = np.where(R > 0.605, 1.0, 0.0)
    _, spacing = finer(chain(lost=lost), np.full(101, 0.01), best(np.full(100, 1e-5)), 1e-3, "joint_travel")
    assert set(np.flatnonzero(spacing < 0.01)) == {60, 61}


def test_a_tube_is_narrowed_before_cells_get_much_shorter():
    """Halving slabs, or very short cells, would cost most where most of the cells are about to be dropped."""
    lost = np.linspace(0.0, 10.0, 101)
    slabs, spacing = finer(chain(lost=lost), np.full(101, 0.1), best(np.full(100, 1e-3)), 1e-3, "l2")
    assert not slabs.any()
    assert (spacing < 0.1).all()
    assert spacing.min() > 0.3 * 0.1
    # Where chords lose more, slabs are what must be halved.
    slabs, _ = finer(chain(lost=1e-3 * lost), np.full(101, 0.1), best(np.full(100, 1e-3)), 1e-3, "l2")
    assert slabs.any()


def test_new_slices_have_the_spacing_between_their_neighbours():
    np.testing.assert_allclose(with_new(np.array([1.0, 2.0, 4.0]), np.array([False, True])), [1.0, 2.0, 3.0, 4.0])
