"""What is proposed: no proof rests on it, but a bound is no sharper. Against dense scans of all cells."""

import numpy as np
import pytest

from selfmotion.certificate import _kernels as kernels
from selfmotion.certificate._arrays import Arcs, Values
from selfmotion.certificate._chord_kernels import L1, L2, TRAVEL
from selfmotion.certificate._proposal_kernels import source_of

KINDS = [TRAVEL, L1, L2]
TAU = 2 * np.pi


def a_slice(rng, m=36, n=3, shift=0.0):
    """Cells along a smooth curve, joined end to end, and values that change slowly along it."""
    tau = np.linspace(0, 2.0, m + 1)
    nodes = np.stack([np.sin((1 + 0.3 * k) * tau + k + shift) for k in range(n)], axis=1)
    a, b = nodes[:-1], nodes[1:].copy()
    middle = np.stack([np.sin((1 + 0.3 * k) * 0.5 * (tau[1:] + tau[:-1]) + k + shift) for k in range(n)], axis=1)
    bow = 8 * (middle - 0.5 * (a + b))
    cells = Arcs(a, b, bow, 0.125 * np.abs(bow) + 1e-6, np.full_like(a, 1e-6))
    v = 0.02 * np.sin(3 * tau) + 0.01 * rng.normal() * tau
    return cells, Values(np.column_stack([v[:-1], v[1:]]), np.zeros(m), 0.01 * rng.normal(size=(m, n)), np.zeros(m))


def scanned(kind, h, w, cells, values, y, wraps):
    """The least value with which postures y (p, n) are reached, over a fine grid on all cells; the cell and its s."""
    s = np.linspace(0, 1, 1001)[:, None, None]
    bow = cells.bow if kind == TRAVEL else 0 * cells.bow
    x = cells.a + s * (cells.b - cells.a) + 0.5 * s * (1 - s) * bow
    value = values.v[:, 0] + s[..., 0] * (values.v[:, 1] - values.v[:, 0])
    found = []
    for one in y:
        d = one - x
        d -= np.where(wraps, TAU * np.rint(d / TAU), 0.0)
        cost = np.hypot(h, d) @ w if kind == TRAVEL else np.abs(d) @ w if kind == L1 else np.linalg.norm(d * w, axis=-1)
        total = value + cost
        at = np.unravel_index(total.argmin(), total.shape)
        found.append((total.min(), at[1], s[at[0], 0, 0]))
    return found


def carried(kind, h, w, wraps, old, values, new, joined, severed=None):
    m, n = new.a.shape
    severed = np.zeros((len(old.a), 2), bool) if severed is None else severed
    found = Values(np.empty((m, 2)), np.empty(m), np.empty((m, n)), np.empty(m))
    if kind != TRAVEL:
        old = old._replace(bow=0 * old.bow, rest=old.dev)
    kernels.step_values(kind, h, w, wraps, old, values, severed, new, joined, found)
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("joined", [False, True])
def test_proposals_are_the_least_values_by_which_ends_are_reached(kind, joined):
    """Also of free joints by whole turns, and of cells that are skipped by their boxes."""
    rng = np.random.default_rng(kind)
    for wraps in (np.zeros(3, bool), np.array([True, False, True])):
        (old, values), (new, _) = a_slice(rng), a_slice(rng, m=30, shift=0.02)
        turns = TAU * wraps * rng.integers(-1, 2, (len(new.a), 1)) if not joined else 0.0
        new = new._replace(a=new.a + turns, b=new.b + turns)
        h, w = 0.03, rng.uniform(0.5, 2.0, 3)
        starts = np.append(False, np.full(len(new.a) - 1, joined))
        found = carried(kind, h, w, wraps, old, values, new, starts)
        for end, y in ((0, new.a), (1, new.b)):
            wanted = [value for value, *_ in scanned(kind, h, w, old, values, y, wraps)]
            assert (found.v[:, end] <= np.array(wanted) + 1e-9).all()
            np.testing.assert_allclose(found.v[:, end], wanted, atol=1e-4)  # the scan misses kinks by that
        for k in range(0, len(new.a), 5):
            (_, cell, s), *_ = scanned(kind, h, w, old, values, new.a[k : k + 1], wraps)
            arcs = old if kind == TRAVEL else old._replace(bow=0 * old.bow)
            at, place = source_of(kind, h, w, wraps, arcs, values, new.a[k])
            assert at + place == pytest.approx(cell + s, abs=0.02)


@pytest.mark.parametrize("kind", [TRAVEL, L2])
def test_slopes_are_those_of_the_values_and_so_is_the_sag(kind):
    """By the envelope theorem the gradient of the least value is that of its chord: both ends' are in the cell's."""
    rng, wraps, step = np.random.default_rng(10 + kind), np.zeros(3, bool), 1e-3
    (old, values), (new, _) = a_slice(rng), a_slice(rng, m=30, shift=0.02)
    h, w = 0.03, rng.uniform(0.5, 2.0, 3)
    found = carried(kind, h, w, wraps, old, values, new, np.append(False, np.ones(29, bool)))

    def slopes(y):
        sides = [
            [scanned(kind, h, w, old, values, y + sign * step * one, wraps) for sign in (1, -1)] for one in np.eye(3)
        ]
        return np.stack([[a[0] - b[0] for a, b in zip(*pair, strict=True)] for pair in sides], axis=-1) / (2 * step)

    inner = slice(6, 24, 6)
    at_a, at_b = slopes(new.a[inner]), slopes(new.b[inner])
    np.testing.assert_allclose(found.g[inner], 0.5 * (at_a + at_b), atol=5e-3 if kind == TRAVEL else 0.05)
    if kind == TRAVEL:
        bend = ((at_b - at_a) * (new.b - new.a)[inner]).sum(axis=1) - (found.g * new.bow).sum(axis=1)[inner]
        np.testing.assert_allclose(found.sag[inner], bend, atol=2e-3 * np.abs(bend).max() + 5e-4)
    else:
        assert (found.sag == 0).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("end", [0, 1])
def test_what_is_cut_off_goes_on_from_its_neighbours(kind, end):
    """Of a tube cut in two: values beyond its severed end are no dearer than a straight line from what is left."""
    rng, wraps = np.random.default_rng(20), np.zeros(3, bool)
    (old, values), (new, _) = a_slice(rng), a_slice(rng, shift=0.002)
    keep = slice(12, None) if end == 0 else slice(None, 24)
    left = Arcs(*(part[keep] for part in old))
    severed = np.zeros((24, 2), bool)
    severed[0 if end == 0 else -1, end] = True
    h, w, starts = 0.003, np.ones(3), np.append(False, np.ones(35, bool))
    whole = carried(kind, h, w, wraps, old, values, new, starts)
    cut, bare = (carried(kind, h, w, wraps, left, values.of(keep), new, starts, s) for s in (severed, None))
    beyond, kept = (slice(0, 10), slice(14, 36)) if end == 0 else (slice(26, 36), slice(0, 22))
    np.testing.assert_allclose(cut.v[kept], whole.v[kept], atol=1e-9)
    far = 0 if end == 0 else -1
    # By the bare end they cost the whole way there.
    assert cut.v[far].min() < bare.v[far].min() - 0.2
    assert np.abs(cut.v - whole.v)[beyond].max() < 0.5 * np.abs(bare.v - whole.v)[beyond].max()
    np.testing.assert_array_equal(cut.v[1:, 0], cut.v[:-1, 1])  # one curve still
