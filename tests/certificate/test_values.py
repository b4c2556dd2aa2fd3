"""What is proved of a value function, against exact arithmetic and real pairs of postures."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from selfmotion.certificate import _kernels as kernels
from selfmotion.certificate._arrays import Arcs, Values
from selfmotion.certificate._chord_kernels import L1, L2, TRAVEL
from selfmotion.certificate._proposal_kernels import WORK, best_along

KINDS = [TRAVEL, L1, L2]
TAU = 2 * np.pi


def exact_cost(kind, d, h, w):
    if kind == TRAVEL:
        return mpmath.fsum(mpmath.mpf(a) * mpmath.sqrt(mpmath.mpf(h) ** 2 + b**2) for a, b in zip(w, d, strict=True))
    if kind == L1:
        return mpmath.fsum(mpmath.mpf(a) * abs(b) for a, b in zip(w, d, strict=True))
    return mpmath.sqrt(mpmath.fsum((mpmath.mpf(a) * b) ** 2 for a, b in zip(w, d, strict=True)))


def cell(step, bow=None, rest=None):
    """One cell from zero on, as the kernels take it."""
    step = np.asarray(step, float)[None]
    bow, rest = (np.zeros_like(step) if x is None else np.asarray(x, float)[None] for x in (bow, rest))
    return Arcs(np.zeros_like(step), step, bow, 0.125 * np.abs(bow) + rest, rest)


def values(at_a, at_b, sag, slopes):
    """Values on one cell."""
    return Values(
        np.array([[at_a, at_b]], float), np.array([sag], float), np.asarray(slopes, float)[None].copy(), np.zeros(1)
    )


def random_pair(rng, offset=0.0, bent=True):
    """A pair of cells with values: h, w, d0, old cell and its values, new cell and its values."""
    n = int(rng.integers(1, 5))
    h = 10.0 ** rng.uniform(-4, -1)
    size = 10.0 ** rng.uniform(-4, -0.5)
    w = rng.uniform(0.1, 2.0, n)
    d0, one, two = h * rng.normal(size=n), size * rng.normal(size=n), size * rng.normal(size=n)
    if rng.random() < 0.5:  # two pieces of nearly the same curve, either way round
        two = rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.0) * one + h * size * rng.normal(size=n)
    bow = bent * size**2 * rng.choice([0.0, 0.1, 1.0]) * rng.normal(size=n)
    other = bow * (two @ two) / (one @ one) + bent * size**2 * rng.choice([0.0, 0.1, 1.0]) * rng.normal(size=n)
    va, vb, wa, wb = offset + h * rng.normal(size=4)
    ga, gb = w * rng.uniform(-1, 1, n), w * rng.uniform(-1, 1, n)
    rest = size ** rng.choice([2, 3]) * rng.uniform(0, 1, (2, n))
    # Nothing, what a value would bend over the cell, or as much as a chord does; up or down.
    sag, sagging = rng.choice([0.0, size**2, 0.1 * size**2 / h], 2) * rng.uniform(-0.3, 1, 2)
    return (
        h,
        w,
        d0,
        cell(one, bow, rest[0]),
        values(va, vb, sag, ga),
        cell(two, other, rest[1]),
        values(wa, wb, sagging, gb),
    )


def bound_of(kind, pair):
    h, w, d0, old, at_old, new, at_new = pair
    return kernels.shortfall(kind, h, w, d0, old, at_old, 0, new, at_new, 0, np.inf, np.empty((WORK, len(w))))


def residual(kind, pair, s, t, e, f):
    """The residual in exact arithmetic."""
    h, w, d0, old, at_old, new, at_new = pair

    def number(x):
        part = Fraction(float(x))
        return mpmath.mpf(part.numerator) / part.denominator

    s, t = number(s), number(t)

    def along(arcs, i, s):
        return s * (number(arcs.b[0, i]) - number(arcs.a[0, i])) + s * (1 - s) * number(arcs.bow[0, i]) / 2

    def value(at, s):
        return (1 - s) * number(at.v[0, 0]) + s * number(at.v[0, 1]) - number(at.sag[0]) * s * (1 - s) / 2

    d = [number(d0[i]) + along(new, i, t) + number(f[i]) - along(old, i, s) - number(e[i]) for i in range(len(w))]
    slopes = mpmath.fsum(
        number(at_old.g[0, i]) * number(e[i]) - number(at_new.g[0, i]) * number(f[i]) for i in range(len(w))
    )
    return value(at_old, s) - value(at_new, t) + slopes + exact_cost(kind, d, h, w)


@pytest.mark.parametrize("kind", KINDS)
def test_shortfall_is_below_every_residual(kind):
    rng = np.random.default_rng(kind)
    with mpmath.workdps(40):
        for _ in range(400):
            pair = random_pair(rng)
            bound, n = bound_of(kind, pair), len(pair[1])
            for _ in range(20):
                s, t = rng.choice([0.0, 1.0, rng.uniform()]), rng.choice([0.0, 1.0, rng.uniform()])
                e, f = (arcs.rest[0] * rng.choice([-1.0, 0.0, 1.0], n) for arcs in (pair[3], pair[5]))
                assert residual(kind, pair, s, t, e, f) >= bound


@pytest.mark.parametrize("kind", KINDS)
def test_shortfall_is_sharp(kind):
    # Without deviations it is the least residual itself.
    rng = np.random.default_rng(10 + kind)
    grid = np.linspace(0, 1, 101)
    for _ in range(60):
        h, w, d0, old, at_old, new, at_new = random_pair(rng, bent=False)
        old, new = cell(old.b[0]), cell(new.b[0])
        at_old.sag[0], at_new.sag[0] = 0.0 if kind == L1 else abs(at_old.sag[0]), 0.0
        pair = (h, w, d0, old, at_old, new, at_new)
        s, t = grid[:, None, None], grid[None, :, None]
        d = d0 + t * new.b[0] - s * old.b[0]
        if kind == TRAVEL:
            cost = np.sqrt(h * h + d * d) @ w
        else:
            cost = np.abs(d) @ w if kind == L1 else np.linalg.norm(d * w, axis=-1)
        if kind == L2 and cost.min() < 0.1 * cost.max():
            continue  # a plane through a kink loses first order
        (va, vb), (wa, wb) = at_old.v[0], at_new.v[0]
        found = cost + (va + s * (vb - va) - 0.5 * at_old.sag[0] * s * (1 - s) - wa - t * (wb - wa))[..., 0]
        scale = w @ (np.abs(old.b[0]) + np.abs(new.b[0])) + abs(vb - va) + abs(wb - wa)
        assert found.min() - 0.02 * scale <= bound_of(kind, pair) <= found.min() + 1e-12


def test_what_the_chord_bends_more_than_it_is_carried_on():
    # Chords between equal cells: values that sag by κ do so by about κ after the next chord, and little is lost.
    rng = np.random.default_rng(31)
    for _ in range(60):
        n, h = int(rng.integers(1, 5)), 10.0 ** rng.uniform(-3, -1)
        step, w, nothing = 0.5 * h * rng.normal(size=n), rng.uniform(0.5, 2.0, n), np.zeros(n)
        sag = 0.2 * rng.random() * step @ step
        still, bow = w.sum() * h, rng.choice([0.0, 1.0]) * 0.1 * np.abs(step) * rng.normal(size=n)
        equal = cell(step, bow)
        pair = (h, w, nothing, equal, values(0, 0, sag, nothing), equal, values(still, still, sag, nothing))
        assert -0.12 * sag <= bound_of(TRAVEL, pair) <= 1e-12


@pytest.mark.parametrize("alike", [0.0, 0.1, 1.0])
def test_what_the_chord_bends_makes_up_for_what_is_kept(alike):
    # In second order, from any point of the square: ½ up σ² − ½ kept τ² + ½ |τB − σA + ε|² + loss ≥ 0, for cells of one
    # curve (alike = 0) and of others, and deviations that go as far the wrong way as they may.
    rng = np.random.default_rng(51)
    least = np.inf
    for _ in range(300):
        n = int(rng.integers(1, 4))
        size, beta = 10.0 ** rng.uniform(-3, -0.5), 10.0 ** rng.uniform(-1, 2, n)
        one = size * rng.normal(size=n)
        two = rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 2.0) * one + alike * size * rng.normal(size=n)
        bow = 0.1 * size * rng.normal(size=n)
        other = bow * (two @ two) / (one @ one) + alike * size * rng.normal(size=n)
        rest = rng.choice([0.0, 1e-3, 1e-2]) * size * rng.random((2, n))
        old, new = cell(one, bow, rest[0]), cell(two, other, rest[1])
        up, (s0, t0) = rng.uniform(-0.05, 0.3) * (beta @ one**2), rng.choice([0.0, 1.0, rng.uniform()], 2)
        kept, loss = kernels.kept_sag(up, 10.0 * beta @ two**2, s0, t0, old, 0, new, 0, beta)
        if not np.isfinite(kept):
            continue
        s, t = rng.random((2, 4000, 1))
        t = np.where(rng.random(t.shape) < 0.5, t0 + (s - s0) * rng.choice([-1, 1], s.shape) * rng.uniform(0.3, 3), t)
        s, t = s[(t >= 0) & (t <= 1)][:, None], t[(t >= 0) & (t <= 1)][:, None]

        def along(arcs, s):
            return s * arcs.b[0] + 0.5 * s * (1 - s) * arcs.bow[0]

        z = along(new, t) - along(new, t0) - along(old, s) + along(old, s0)
        z -= np.sign(z) * np.minimum(np.abs(z), rest.sum(axis=0))
        total = 0.5 * (up * (s - s0) ** 2 - kept * (t - t0) ** 2)[:, 0] + 0.5 * z**2 @ beta + loss
        assert (total >= -1e-12 * (beta @ (one**2 + two**2))).all()
        least = min(least, total.min() / (beta @ two**2))
    assert least < 1e-3  # sharp enough to tell


def test_long_cells_of_one_curve_lose_far_less_than_their_chords():
    # Arcs of two circles, the second as far beyond the first from a point in the distance as chords from there go on:
    # values are what chords from that point cost.
    h, origin = 1e-3, np.array([2.0, 3.0])

    def lost(length, bent):
        at = length * np.array([-0.5, 0.0, 0.5])

        def half(grown):
            nodes = origin + grown * (np.column_stack([np.sin(at), np.cos(at)]) - origin)
            bow = 4 * (2 * nodes[1] - nodes[0] - nodes[2])  # of the parabola through all three
            rest = np.full(2, grown * length**3 / 60)
            arcs = cell(nodes[2] - nodes[0], bow, rest) if bent else cell(nodes[2] - nodes[0], rest=np.abs(bow) / 8)
            slopes = ((nodes - origin) / np.hypot(grown, nodes - origin))[[0, 2]]
            ends = slopes @ (nodes[2] - nodes[0]) + bent * np.array([0.5, -0.5]) * (slopes @ bow)
            costs = np.hypot(grown, nodes - origin).sum(axis=1)
            return nodes[0], arcs, values(costs[0], costs[2], ends[1] - ends[0], slopes.mean(axis=0))

        (x, old, at_old), (y, new, at_new) = half(1.0), half(1.0 + h)
        return -bound_of(TRAVEL, (h, np.ones(2), y - x, old, at_old, new, at_new))

    for length in (0.05, 0.025, 0.0125):
        assert lost(length, True) < 0.2 * lost(length, False)


@pytest.mark.parametrize("part", [0.3, 0.99, 1.5, 3.0])
def test_values_that_sag_about_as_much_as_the_chord_bends(part):
    # From one posture to a cell whose values are the chord's at both ends; deviations go along the cell.
    rng = np.random.default_rng(41)
    with mpmath.workdps(40):
        for _ in range(40):
            n, h = int(rng.integers(1, 4)), 10.0 ** rng.uniform(-3, -1)
            w, d0, step = rng.uniform(0.5, 2.0, n), h * rng.normal(size=n), 0.05 * h * rng.normal(size=n)
            d = d0 + np.array([[0.0], [0.5], [1.0]]) * step
            ends, bend = np.sqrt(h * h + d * d) @ w, step**2 @ (w * h * h / (h * h + d[1] ** 2) ** 1.5)
            slope, along, nothing = w * d[1] / np.sqrt(h * h + d[1] ** 2), rng.choice([0.0, 0.01, 0.1]), np.zeros(n)
            pair = (
                h, w, d0, cell(nothing), values(0, 0, 0, nothing),
                cell(step, rest=along * np.abs(step)), values(ends[0], ends[2], part * bend, slope),
            )  # fmt: skip
            bound = bound_of(TRAVEL, pair)
            assert bound >= -bend  # sharp enough to tell
            for t in (0.0, 0.5, 1.0):
                for f in (-along * step, along * step):
                    assert residual(TRAVEL, pair, 0.0, t, nothing, f) >= bound


@pytest.mark.parametrize("kind", KINDS)
def test_rounding_goes_outward(kind):
    # Values so large that their rounding shows: the bound may be low by it, never high.
    rng = np.random.default_rng(20 + kind)
    with mpmath.workdps(40):
        for _ in range(100):
            pair = random_pair(rng, offset=1e7)
            n = len(pair[1])
            h, w, d0, _, at_old, _, at_new = pair
            nothing = np.zeros(n)
            still, va, wa = cell(nothing), at_old.v[0, 0], at_new.v[0, 0]
            pair = (h, w, d0, still, values(va, va, 0, at_old.g[0]), still, values(wa, wa, 0, at_new.g[0]))
            exact = residual(kind, pair, 0.0, 0.0, nothing, nothing)
            assert exact - 1e-5 <= bound_of(kind, pair) < exact


def random_slices(rng, n=3, m=40, wrapped=True):
    """Two slices of cells along curves that lie near each other, with a value function on the first."""
    wraps = rng.random(n) < 0.5 if wrapped else np.zeros(n, bool)
    tau = np.linspace(0, rng.uniform(1, 8), m + 1)

    def curve(shift):
        return np.stack([np.sin(0.7 * tau + k + shift) * 2 + 0.5 * tau * (k == 0) for k in range(n)], axis=1)

    first, second = curve(0.0), curve(0.05)
    for nodes in (first, second):
        nodes[:, wraps] -= TAU * np.rint(nodes[:, wraps] / TAU)

    def cells(nodes):
        a, b = nodes[:-1], nodes[1:].copy()
        b[:, wraps] = a[:, wraps] + (b - a - TAU * np.rint((b - a) / TAU))[:, wraps]
        size = ((b - a) ** 2).max(axis=1, keepdims=True)
        bow, rest = rng.choice([0.0, 0.3]) * size * rng.normal(size=a.shape), 0.1 * size * rng.uniform(0, 1, a.shape)
        return Arcs(a, b, bow, 0.125 * np.abs(bow) + rest, rest)

    v = np.cumsum(np.append(0.0, 0.1 * rng.normal(size=m)))
    return wraps, cells(first), cells(second), np.column_stack([v[:-1], v[1:]])


def nothing_found(m, n):
    return Values(np.empty((m, 2)), np.empty(m), np.empty((m, n)), np.empty(m))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(8))
def test_values_hold_for_every_pair_of_postures(kind, seed):
    # V(y) ≤ V(x) + c(y − x): for all pairs of cells, whatever was skipped.
    rng = np.random.default_rng(100 * kind + seed)
    wraps, old, new, v = random_slices(rng)
    m, n = old.a.shape
    h, w = 10.0 ** rng.uniform(-3, -1), rng.uniform(0.2, 2.0, n)
    known = Values(
        v, rng.choice([0.0, 1e-3, -1e-3], m) * rng.random(m), 0.3 * rng.normal(size=(m, n)), 1e-3 * rng.random(m)
    )
    joined, severed = np.append(False, np.ones(m - 1, bool)), (rng.random((m, 2)) < 0.2) & (seed % 2 == 0)
    found, boxed = nothing_found(m, n), np.empty(m)
    kernels.step_values(kind, h, w, wraps, old, known, severed, new, joined, found)
    kernels.least_to(kind, h, w, wraps, old, known, new, boxed)
    assert np.isfinite(found.lost).all()

    def at(arcs, values, s, e):
        x = arcs.a + s[:, None] * (arcs.b - arcs.a) + 0.5 * (s * (1 - s))[:, None] * arcs.bow + e
        value = values.v[:, 0] + s * (values.v[:, 1] - values.v[:, 0]) - 0.5 * values.sag * s * (1 - s)
        return x, value + (values.g * e).sum(axis=1) - values.lost

    for _ in range(40):
        s, t = rng.choice([0.0, 1.0, rng.uniform()], (2, m))
        x, at_x = at(old, known, s, old.rest * rng.choice([-1, 0, 1], old.rest.shape))
        y, at_y = at(new, found, t, new.rest * rng.choice([-1, 0, 1], new.rest.shape))
        d = y[:, None] - x
        d = np.where(wraps, d - TAU * np.rint(d / TAU), d)
        if kind == TRAVEL:
            cost = np.sqrt(h * h + d * d) @ w
        else:
            cost = np.abs(d) @ w if kind == L1 else np.linalg.norm(d * w, axis=-1)
        assert (at_y[:, None] <= at_x + cost).all()
        assert (boxed[:, None] <= at_x + cost).all()


def test_the_least_through_a_cell_is_below_all_of_it():
    rng = np.random.default_rng(5)
    m, n = 50, 3
    a, bow, rest = rng.normal(size=(m, n)), 1e-2 * rng.normal(size=(m, n)), 1e-3 * rng.random((m, n))
    arcs = Arcs(a, a + 0.1, bow, 0.125 * np.abs(bow) + rest, rest)
    one, two = (
        Values(rng.normal(size=(m, 2)), rng.choice([-2.0, 0.0, 1.0, 5.0], m), rng.normal(size=(m, n)), rng.random(m))
        for _ in range(2)
    )
    out, both = np.empty(m), one.v + two.v
    kernels.least_through(arcs, one, two, out)

    def total(s):
        return (
            both[:, 0] + s * (both[:, 1] - both[:, 0]) - 0.5 * (one.sag + two.sag) * s * (1 - s) - one.lost - two.lost
        )

    for _ in range(50):
        s, e = rng.choice([0.0, 1.0, rng.uniform()], m), rest * rng.choice([-1, 0, 1], rest.shape)
        assert (out <= total(s) + ((one.g + two.g) * e).sum(axis=1)).all()
    least = np.min([total(s) for s in np.linspace(0, 1, 1001)], axis=0)
    assert (out >= least - (np.abs(one.g + two.g) * rest).sum(axis=1) - 1e-5).all()


def straight(a, b):
    """Cells that are their chords."""
    return Arcs(a, b, np.zeros_like(a), np.zeros_like(a), np.zeros_like(a))


def carried(kind, h, wraps, old, known, new):
    """Values carried from some cells to others."""
    m, n = new.a.shape
    found = nothing_found(m, n)
    severed, joined = np.zeros((len(old.a), 2), bool), np.zeros(m, bool)
    kernels.step_values(kind, h, np.ones(n), wraps, old, known, severed, new, joined, found)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_a_free_joint_may_go_either_way_round(kind):
    # The cell's cheap end is more than half a turn away the way that its middle goes.
    old, y = straight(np.array([[0.0, 0.0]]), np.array([[0.8, 0.0]])), np.array([[-np.pi + 0.5, 0.0]])
    found = carried(kind, 1e-3, np.array([True, True]), old, values(2, 0, 0, np.zeros(2)), straight(y, y))
    assert found.v[0, 0] - found.lost[0] <= np.pi - 0.3 + 2e-3


@pytest.mark.parametrize("kind", KINDS)
def test_differences_of_large_angles_are_rounded_outward(kind):
    # Angles near half a turn and values near zero: what a difference of angles is off by is all that shows.
    rng = np.random.default_rng(60 + kind)
    with mpmath.workdps(40):
        for _ in range(300):
            n, h = 3, 1e-4
            a = rng.uniform(2.5, 3.14, n)
            ya = a + rng.uniform(-1e-3, 1e-3, n)
            old, new = (straight(x[None], x[None] + rng.uniform(-1e-3, 1e-3, n)) for x in (a, ya))
            found = carried(kind, h, np.zeros(n, bool), old, values(0.0, 0.01, 0.0, np.zeros(n)), new)
            exact = exact_cost(
                kind, [mpmath.mpf(float(y)) - mpmath.mpf(float(x)) for x, y in zip(a, ya, strict=True)], h, np.ones(n)
            )
            assert mpmath.mpf(found.v[0, 0]) - mpmath.mpf(found.lost[0]) <= exact


def test_an_old_cell_that_stands_still_may_bend_all_the_same():
    old, new = cell([0.0], [1.0]), cell([1.0])
    for sag in (0.4, 0.5, 0.6):
        pair = (1.0, np.ones(1), np.array([-0.375]), old, values(0, 0, 0, [0.0]), new, values(0, 0, sag, [0.0]))
        s, t = np.linspace(0, 1, 201)[:, None], np.linspace(0, 1, 201)
        least = (np.hypot(1.0, -0.375 + t - 0.5 * s * (1 - s)) + 0.5 * sag * t * (1 - t)).min()
        assert bound_of(TRAVEL, pair) <= least


@pytest.mark.parametrize("kind", KINDS)
def test_cells_a_turn_wide_are_boxes(kind):
    # Beside singular postures all that is known of a joint may be a turn wide: the nearest way is none of two then.
    old, y = straight(np.array([[-0.1]]), np.array([[0.1]])), np.array([[0.05]])
    new = Arcs(y, y, 0 * y, y * 0 + TAU, y * 0 + TAU)
    known = values(0.3, 0.0, 0.0, [0.0])
    found = carried(kind, 1e-3, np.ones(1, bool), old, known, new)
    f = np.linspace(-TAU, TAU, 2001)
    at_y = found.v[0, 0] + found.g[0, 0] * f - found.lost[0]
    for s in (0.0, 0.5, 1.0):
        d = y[0, 0] + f - (-0.1 + 0.2 * s)
        d -= TAU * np.rint(d / TAU)
        assert (at_y <= 0.3 * (1 - s) + (np.hypot(1e-3, d) if kind == TRAVEL else np.abs(d))).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("m", [1, 2, 15, 16, 17, 33])
def test_every_cell_counts(kind, m):
    # Whichever cell it is of whose value less is proved, the values carried on say so.
    a = np.column_stack([np.linspace(0, 1, m), np.zeros(m)])
    old, new = straight(a, a + 0.01), straight(np.array([[0.5, 0.3]]), np.array([[0.5, 0.31]]))
    for k in range(m):
        known = Values(np.zeros((m, 2)), np.zeros(m), np.zeros((m, 2)), 5.0 * (np.arange(m) == k))
        found = carried(kind, 0.01, np.zeros(2, bool), old, known, new)
        assert (found.v[0] - found.lost[0] < -3.0).all()


@pytest.mark.parametrize("m", [1, 2, 15, 16, 17, 33])
def test_what_sags_counts(m):
    # Whichever cell it is whose value is low in the middle, the values carried on say so.
    a = np.column_stack([np.linspace(0, 1, m), np.zeros(m)])
    old, new = straight(a, a + 0.01), straight(np.array([[0.5, 0.3]]), np.array([[0.5, 0.31]]))
    for k in range(m):
        one = np.arange(m) == k
        # Either one alone is low, or all are and less of it is proved of one.
        for sag, lost, low in ((np.where(one, 40.0, 0.0), np.zeros(m), -3.0), (np.full(m, 40.0), 5.0 * one, -8.0)):
            known, boxed = Values(np.zeros((m, 2)), sag, np.zeros((m, 2)), lost), np.empty(1)
            found = carried(TRAVEL, 0.01, np.zeros(2, bool), old, known, new)
            assert (found.v[0] - found.lost[0] < low).all()
            kernels.least_to(TRAVEL, 0.01, np.ones(2), np.zeros(2, bool), old, known, new, boxed)
            assert boxed[0] < low


@pytest.mark.parametrize("kind", KINDS)
def test_the_cheap_bound_is_the_chord_over_the_gaps_between_two_boxes(kind):
    rng = np.random.default_rng(80 + kind)
    for _ in range(40):
        m, n, h = 5, 3, 0.1
        a, b, y = rng.uniform(-3, 3, (3, m, n))
        rest, w, wraps = 0.1 * rng.random((m, n)), rng.uniform(0.5, 2.0, n), rng.random(n) < 0.5
        old, new = Arcs(a, a + 0.3 * b, 0 * a, rest, rest), straight(y, y + 0.1)
        known, out = Values(rng.normal(size=(m, 2)), np.zeros(m), np.zeros((m, n)), rng.random(m)), np.empty(m)
        kernels.least_to(kind, h, w, wraps, old, known, new, out)
        apart = (y + 0.05)[:, None] - (a + 0.15 * b)
        apart -= np.where(wraps, TAU * np.rint(apart / TAU), 0.0)
        gap = np.maximum(np.abs(apart) - 0.15 * np.abs(b) - rest - 0.05, 0.0)
        if kind == TRAVEL:
            cost = np.sqrt(h * h + gap * gap) @ w
        else:
            cost = gap @ w if kind == L1 else np.linalg.norm(gap * w, axis=-1)
        np.testing.assert_allclose(out, (known.v.min(axis=1) - known.lost + cost).min(axis=1), atol=1e-12)


def source(step, y, rise, bow=0.0, sag=0.0, last=1.5):
    """Value and place at which y is reached most cheaply, by chords over h = 1, from a cell; and a scan."""
    step, y, n = np.array(step), np.array(y), len(step)
    arcs, at = cell(step, bow + np.zeros(n)), values(0.0, rise, sag, np.zeros(n))
    value, s = best_along(TRAVEL, 1.0, np.ones(n), y, arcs, at, 0, 0.0, last, *np.empty((3, n)))
    grid = np.linspace(0.0, last, 20001)[:, None]
    bump = 0.5 * grid * (1 - grid)
    costs = np.hypot(1.0, y - grid * step - bump * bow).sum(axis=1) + (grid * rise - bump * sag)[:, 0]
    return value, s, costs.min(), grid[costs.argmin(), 0]


def test_sources_are_found():
    rng = np.random.default_rng(61)
    for _ in range(300):
        n = int(rng.integers(1, 4))
        step = np.exp(rng.uniform(-1, 2)) * rng.normal(size=n)
        y = step * rng.uniform(0, 1.5) + np.exp(rng.uniform(-1, 2)) * rng.normal(size=n)
        value, s, least, _ = source(step, y, rng.normal() * np.abs(step).sum(), *rng.choice([0.0, 0.1], 2))
        assert 0.0 <= s <= 1.5
        assert least - 1e-4 <= value <= least + 1e-9


def test_a_source_about_which_newton_s_method_goes_to_and_fro():
    # Between s = 0.56 and 1.49, where the cost is nearly straight, with a bend between; found in a real problem.
    step, y, bow = (2.1164, -3.8707, 2.8369), (1.4109, -3.6622, 5.6621), np.array([0.0, 0.001, 0.0035])
    value, s, least, place = source(step, y, -0.0114, bow, 0.0001, last=1 + 2 / 3.8707)
    assert value == pytest.approx(least, abs=1e-6)
    assert s == pytest.approx(place, abs=1e-3)
