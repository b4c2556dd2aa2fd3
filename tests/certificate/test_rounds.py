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


def after(excess, slabs):
    """What chords lose when some slabs are halved: a quarter is left of theirs."""
    return excess[~slabs].sum() + 0.25 * excess[slabs].sum()


def test_no_more_slabs_are_halved_than_the_gap_needs():
    """Chords lose 0.7 of it at most then, or a tenth of all is in slabs that stay; and one slab less would not do."""
    rng = np.random.default_rng(1)
    for _ in range(40):
        excess = rng.exponential(size=100) ** 3 * 1e-4
        wanted = excess.sum() * 10.0 ** rng.uniform(-1, 0.5)
        slabs, _ = finer(chain(), np.full(101, 0.01), best(excess), wanted, "joint_travel")
        enough = max(0.7 * wanted, after(excess, np.ones(100, bool)) + 0.75 * 0.1 * excess.sum())
        assert after(excess, slabs) <= enough + 1e-15
        if slabs.any():
            slabs[np.flatnonzero(slabs)[excess[slabs].argmin()]] = False
            assert after(excess, slabs) > enough


def test_wide_slabs_are_halved_in_any_case():
    r = np.array([0.0, 0.2, 0.21, 0.5, 0.515, 1.0])
    still = Chain(r, np.column_stack([r, -r]), 0 * r)
    motion = BestMotion(np.zeros(5), np.diff(still.q, axis=0))
    slabs, _ = finer(still, np.full(6, 1e-3), motion, 1.0, "joint_travel")
    np.testing.assert_array_equal(slabs, [True, False, True, False, True])


def test_what_cells_lose_falls_with_the_cube_of_their_length_to_what_is_allowed():
    """Three tenths of what a slab's chord may lose, on both slices of the slab; no cell gets ten times as short."""
    excess, old = np.full(100, 1e-5), 0.01
    for loss in (1e-5, 1e-4, 1.0):
        lost = np.where(R > 0.605, loss, 0.0)
        slabs, spacing = finer(chain(lost=lost), np.full(101, old), best(excess), 2e-3, "joint_travel")
        if not slabs.any() and loss > excess.sum():  # narrowed first
            assert set(np.round(spacing, 12)) == {old, 0.0035}
            continue
        allowed = after(excess, slabs) / (100 + slabs.sum())
        left = loss * (spacing[60:62] / old) ** 3
        np.testing.assert_allclose(left, np.minimum(loss, np.maximum(0.3 * allowed, 1e-3 * loss)))
        np.testing.assert_array_equal(np.delete(spacing, [60, 61]), old)


def test_a_little_is_allowed_where_chords_lose_nothing():
    lost = np.where(R > 0.605, 1e-4, 0.0)
    lost[:30] -= 1.0  # proposals that are too low for a while have lost nothing
    slabs, spacing = finer(
        chain(lost=np.sort(lost)), np.full(101, 0.01), best(np.full(100, 1e-6)), 1e-2, "joint_travel"
    )
    assert not slabs.any()
    np.testing.assert_allclose(1e-4 * (spacing[60:62] / 0.01) ** 3, 0.3 * 0.3 * 1e-2 / 100)


def test_cells_are_no_longer_than_four_slabs_are_wide():
    """Slabs as they will be, the narrower one beside each slice; for plain travel chords count too."""
    excess = np.where(np.arange(100) < 20, 1e-2, 0.0)
    slabs, spacing = finer(chain(), np.full(101, 1.0), best(excess), 1e-2, "joint_travel")
    width = np.where(slabs, 0.005, 0.01)
    assert slabs.any()
    assert not slabs.all()
    beside = np.minimum(np.append(width, np.inf), np.append(np.inf, width))
    np.testing.assert_allclose(spacing, 4.0 * beside)
    for kind in ("l1", "l2"):
        slabs, spacing = finer(chain(), np.full(101, 1.0), best(excess), 1e-2, kind)
        allowed = after(excess, slabs) / (100 + slabs.sum())
        np.testing.assert_allclose(spacing, np.minimum(4.0 * beside, np.sqrt(3.0 * allowed)))


def test_without_a_motion_cells_get_about_a_third_as_long():
    _, spacing = finer(chain(), 0.1 + R, None, 1.0, "joint_travel")
    np.testing.assert_allclose(spacing, 0.35 * (0.1 + R))


def test_a_jump_is_three_times_what_most_chords_are_long():
    for jump, halved in ((0.008, False), (0.012, True)):  # besides the 0.005 of each chord
        q = 0.5 * R + jump * (R > 0.425)
        slabs, _ = finer(chain(q), np.full(101, 0.01), best(np.zeros(100)), 1.0, "joint_travel")
        assert set(np.flatnonzero(slabs)) == ({42} if halved else set())
