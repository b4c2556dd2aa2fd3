"""The bookkeeping of a tube's slices: what is joined, severed and kept."""

import numpy as np
import pytest

from selfmotion.arms.cells import Cells
from selfmotion.certificate.tube import Setting, Slice


def two_pieces():
    """Cells of one curve: five of a piece on [0, 5], and four of another on [3, 7], which overlap it."""
    start = np.array([0, 1, 2, 3, 4, 3, 4, 5, 6], float)
    a, piece = start[:, None] * [0.1, 0.2], np.repeat([0.0, 1.0], [5, 4])
    b = (start + 1)[:, None] * [0.1, 0.2]
    cells = Cells(a, b, np.full((9, 2), 1e-6), np.column_stack([piece, 0 * piece, start, start + 1]),
                  np.arange(9))  # fmt: skip
    joined = np.array([0, 1, 1, 1, 1, 0, 1, 1, 1], bool)
    return Slice(0.5, np.zeros(2), cells, joined, np.zeros((9, 2), bool), least=np.arange(9.0))


def severed(part):
    return {(int(row), int(end)) for row, end in np.argwhere(part.severed)}


def test_what_is_cut_off_is_severed_and_joined_no_more():
    part = two_pieces().kept(np.array([0, 1, 1, 1, 1, 1, 1, 1, 1], bool))
    assert severed(part) == {(0, 0)}
    np.testing.assert_array_equal(part.joined, [0, 1, 1, 1, 0, 1, 1, 1])
    np.testing.assert_array_equal(part.least, np.arange(1, 9))
    assert severed(part.kept(np.arange(8) < 3)) == {(0, 0), (2, 1)}


@pytest.mark.parametrize(("kept", "ends"), [
    ([1, 1, 1, 1, 1, 0, 0, 0, 0], {(4, 1)}),  # the curve goes on in the other piece, which is gone
    ([1, 1, 1, 1, 1, 0, 1, 1, 1], {(5, 0)}),  # it does, in what is kept
    ([1, 1, 1, 1, 1, 0, 0, 1, 1], {(5, 0)}),
    ([0, 0, 0, 0, 0, 1, 1, 1, 1], {(0, 0)}),
    ([1, 1, 1, 1, 1, 1, 1, 1, 1], set()),  # the ends at 0 and 7 are the curve's own
    ([0, 1, 1, 1, 0, 1, 1, 1, 1], {(0, 0), (2, 1)}),
])  # fmt: skip
def test_ends_that_went_on_in_another_piece_are_severed(kept, ends):
    assert severed(two_pieces().kept(np.array(kept, bool))) == ends


@pytest.mark.parametrize(("wraps", "ends"), [(True, set()), (np.array([False, True]), {(0, 1)})])
def test_what_is_a_turn_away_on_a_rail_is_somewhere_else(wraps, ends):
    """A cell ends where one that is dropped goes on; a third, which is kept, does so but for 2π of the first joint."""
    a = np.array([[0.0, 0.0], [0.1, 0.1], [0.05 + 2 * np.pi, 0.05]])
    b = np.array([[0.1, 0.1], [0.2, 0.2], [0.25 + 2 * np.pi, 0.25]])
    pieces = np.array([[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0], [2.0, 0.0, 0.0, 1.0]])
    cells = Cells(a, b, np.full((3, 2), 1e-6), pieces, np.arange(3))
    part = Slice(0.5, np.zeros(2), cells, np.zeros(3, bool), np.zeros((3, 2), bool), wraps=wraps)
    assert severed(part.kept(np.array([True, False, True]))) == ends


def test_narrow_holes_are_filled():
    part = two_pieces()
    least = np.array([1.0, 3.0, 1.0, 1.0, 3.0, 3.0, 1.0, 1.0, 1.0])
    # The hole in the first piece is one of its own; that between the pieces is none.
    np.testing.assert_array_equal(part.below(2.0, least).least, [0, 1, 2, 3, 6, 7, 8])


def test_slabs_are_cut_at_corners_of_the_path_that_are_near_their_middle():
    setting = Setting(None, None, "l2", np.ones(2), np.array([0.3, 0.62]))
    assert setting.cut(0.2, 0.5) == 0.3
    assert setting.cut(0.5, 0.2) == 0.3
    assert setting.cut(0.28, 0.5) == 0.39  # the corner is beyond the middle half
    assert setting.cut(0.6, 0.8) == 0.7
    assert setting._replace(breaks=np.empty(0)).cut(0.0, 1.0) == 0.5
