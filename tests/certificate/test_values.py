"""What is proved of a value function, against exact arithmetic and real pairs of postures."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from selfmotion.certificate import _kernels as kernels
from selfmotion.certificate._chord_kernels import L1, L2, TRAVEL

KINDS = [TRAVEL, L1, L2]
TAU = 2 * np.pi


def exact_cost(kind, d, h, w):
    if kind == TRAVEL:
        return mpmath.fsum(mpmath.mpf(a) * mpmath.sqrt(mpmath.mpf(h) ** 2 + b**2) for a, b in zip(w, d, strict=True))
    if kind == L1:
        return mpmath.fsum(mpmath.mpf(a) * abs(b) for a, b in zip(w, d, strict=True))
    return mpmath.sqrt(mpmath.fsum((mpmath.mpf(a) * b) ** 2 for a, b in zip(w, d, strict=True)))


def random_pair(rng, offset=0.0):
    """A pair of cells with values, as `shortfall` takes them."""
    n = int(rng.integers(1, 5))
    h = 10.0 ** rng.uniform(-4, -1)
    size = 10.0 ** rng.uniform(-4, -0.5)
    w = rng.uniform(0.1, 2.0, n)
    d0, stepa, stepb = h * rng.normal(size=n), size * rng.normal(size=n), size * rng.normal(size=n)
    va, vb, wa, wb = offset + h * rng.normal(size=4)
    ga, gb = w * rng.uniform(-1, 1, n), w * rng.uniform(-1, 1, n)
    deva, devb = size**2 * rng.uniform(0, 1, n), size**2 * rng.uniform(0, 1, n)
    # Nothing, what a value would bend over the cell, or as much as a chord does.
    sag, sagging = rng.choice([0.0, size**2, 0.1 * size**2 / h], 2) * rng.random(2)
    return h, w, d0, stepa, stepb, va, vb, sag, wa, wb, sagging, ga, gb, deva, devb


def bound_of(kind, pair):
    n = len(pair[1])
    return kernels.shortfall(kind, *pair, np.inf, np.empty(n), np.empty(n), np.empty(n))


def residual(kind, pair, s, t, e, f):
    """The residual in exact arithmetic."""
    h, w, d0, stepa, stepb, va, vb, sag, wa, wb, sagging, ga, gb, _, _ = pair

    def number(x):
        part = Fraction(float(x))
        return mpmath.mpf(part.numerator) / part.denominator

    s, t = number(s), number(t)
    d = [
        number(d0[i]) + t * number(stepb[i]) + number(f[i]) - s * number(stepa[i]) - number(e[i]) for i in range(len(w))
    ]
    slopes = mpmath.fsum(number(ga[i]) * number(e[i]) - number(gb[i]) * number(f[i]) for i in range(len(w)))
    values = (1 - s) * number(va) + s * number(vb) - (1 - t) * number(wa) - t * number(wb)
    values += (number(sagging) * t * (1 - t) - number(sag) * s * (1 - s)) / 2
    return values + slopes + exact_cost(kind, d, h, w)


@pytest.mark.parametrize("kind", KINDS)
def test_shortfall_is_below_every_residual(kind):
    rng = np.random.default_rng(kind)
    with mpmath.workdps(40):
        for _ in range(300):
            pair = random_pair(rng)
            bound, n = bound_of(kind, pair), len(pair[1])
            for _ in range(20):
                s, t = rng.choice([0.0, 1.0, rng.uniform()]), rng.choice([0.0, 1.0, rng.uniform()])
                e, f = (dev * rng.choice([-1.0, 0.0, 1.0], n) for dev in pair[-2:])
                assert residual(kind, pair, s, t, e, f) >= bound


@pytest.mark.parametrize("kind", KINDS)
def test_shortfall_is_sharp(kind):
    # Without deviations it is the least residual itself.
    rng = np.random.default_rng(10 + kind)
    grid = np.linspace(0, 1, 101)
    for _ in range(60):
        pair = random_pair(rng)
        h, w, d0, stepa, stepb, va, vb, sag, wa, wb = pair[:10]
        nothing, sag = np.zeros(len(w)), 0.0 if kind == L1 else sag
        pair = (*pair[:7], sag, wa, wb, 0.0, *pair[11:13], nothing, nothing)
        s, t = grid[:, None, None], grid[None, :, None]
        d = d0 + t * stepb - s * stepa
        if kind == TRAVEL:
            cost = np.sqrt(h * h + d * d) @ w
        else:
            cost = np.abs(d) @ w if kind == L1 else np.linalg.norm(d * w, axis=-1)
        if kind == L2 and cost.min() < 0.1 * cost.max():
            continue  # a plane through a kink loses first order
        values = cost + (va + s * (vb - va) - 0.5 * sag * s * (1 - s) - wa - t * (wb - wa))[..., 0]
        scale = w @ (np.abs(stepa) + np.abs(stepb)) + abs(vb - va) + abs(wb - wa)
        assert values.min() - 0.02 * scale <= bound_of(kind, pair) <= values.min() + 1e-12


def test_what_the_chord_bends_more_than_it_is_carried_on():
    # Chords between equal cells: values that sag by κ do so by about κ after the next chord, and little is lost.
    rng = np.random.default_rng(31)
    for _ in range(60):
        n, h = int(rng.integers(1, 5)), 10.0 ** rng.uniform(-3, -1)
        step, w, nothing = 0.5 * h * rng.normal(size=n), rng.uniform(0.5, 2.0, n), np.zeros(n)
        sag = 0.2 * rng.random() * step @ step
        still = w.sum() * h
        pair = (h, w, nothing, step, step, 0.0, 0.0, sag, still, still, sag, nothing, nothing, nothing, nothing)
        assert -0.1 * sag <= bound_of(TRAVEL, pair) <= 1e-12


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
                h, w, d0, nothing, step, 0.0, 0.0, 0.0, ends[0], ends[2], part * bend, nothing, slope,
                nothing, along * np.abs(step),
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
            h, w, d0 = pair[0], pair[1], pair[2]
            still, nothing = np.zeros(n), np.zeros(n)
            va = pair[5]
            pair = (h, w, d0, still, still, va, va, 0.0, pair[8], pair[8], 0.0, pair[11], pair[12], nothing, nothing)
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
        return a, b, 0.1 * ((b - a) ** 2).max(axis=1, keepdims=True) * rng.uniform(0, 1, a.shape)

    v = np.cumsum(np.append(0.0, 0.1 * rng.normal(size=m)))
    return wraps, cells(first), cells(second), np.column_stack([v[:-1], v[1:]])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(6))
def test_values_hold_for_every_pair_of_postures(kind, seed):
    # V(y) ≤ V(x) + c(y − x): for all pairs of cells, whatever was skipped.
    rng = np.random.default_rng(100 * kind + seed)
    wraps, (a, b, dev), (ya, yb, ydev), v = random_slices(rng)
    m, n = a.shape
    h, w = 10.0 ** rng.uniform(-3, -1), rng.uniform(0.2, 2.0, n)
    g, lost = 0.3 * rng.normal(size=(m, n)), 1e-3 * rng.random(m)
    sag = rng.choice([0.0, 1e-3], m) * rng.random(m)
    joined, severed = np.append(False, np.ones(m - 1, bool)), rng.random((m, 2)) < 0.2
    out, sagging, slopes, out_lost = np.empty((m, 2)), np.empty(m), np.empty((m, n)), np.empty(m)
    kernels.step_values(
        kind, h, w, wraps, a, b, dev, v, sag, g, lost, severed, seed % 2 == 0,
        ya, yb, ydev, joined, out, sagging, slopes, out_lost,
    )  # fmt: skip
    boxed = np.empty(m)
    kernels.least_to(kind, h, w, wraps, a, b, dev, v, sag, g, lost, ya, yb, ydev, boxed)
    assert np.isfinite(out_lost).all()
    assert (sagging >= 0).all()
    for _ in range(40):
        s, t = rng.choice([0.0, 1.0, rng.uniform()], (2, m))
        e, f = dev * rng.choice([-1, 0, 1], dev.shape), ydev * rng.choice([-1, 0, 1], ydev.shape)
        x, y = a + s[:, None] * (b - a) + e, ya + t[:, None] * (yb - ya) + f
        at_x = v[:, 0] + s * (v[:, 1] - v[:, 0]) - 0.5 * sag * s * (1 - s) + (g * e).sum(axis=1) - lost
        at_y = out[:, 0] + t * (out[:, 1] - out[:, 0]) - 0.5 * sagging * t * (1 - t)
        at_y += (slopes * f).sum(axis=1) - out_lost
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
    dev = 1e-3 * rng.random((m, n))
    v, w, g, k = rng.normal(size=(m, 2)), rng.normal(size=(m, 2)), rng.normal(size=(m, n)), rng.normal(size=(m, n))
    lost, other = rng.random(m), rng.random(m)
    sag, back = rng.choice([0.0, 1.0, 5.0], (2, m))
    out = np.empty(m)
    kernels.least_through(dev, v, sag, g, lost, w, back, k, other, out)
    for _ in range(50):
        s, e = rng.choice([0.0, 1.0, rng.uniform()], m), dev * rng.choice([-1, 0, 1], dev.shape)
        value = (v + w)[:, 0] + s * ((v + w)[:, 1] - (v + w)[:, 0]) + ((g + k) * e).sum(axis=1) - lost - other
        value -= 0.5 * (sag + back) * s * (1 - s)
        assert (out <= value).all()
    s = np.linspace(0, 1, 1001)[:, None]
    value = (v + w)[:, 0] + s * ((v + w)[:, 1] - (v + w)[:, 0]) - 0.5 * (sag + back) * s * (1 - s)
    assert (out >= value.min(axis=0) - lost - other - (np.abs(g + k) * dev).sum(axis=1) - 1e-5).all()


def carried(kind, h, w, wraps, cells, v, new, unproved=None):
    """Values carried from cells (a, b, dev) with values v less what is not proved, without slopes, to new ones."""
    (a, b, dev), (ya, yb, ydev) = cells, new
    m, k = len(a), len(ya)
    out, sagging, slopes, lost = np.empty((k, 2)), np.empty(k), np.empty((k, a.shape[1])), np.empty(k)
    kernels.step_values(
        kind, h, w, wraps, a, b, dev, v, np.zeros(m), np.zeros_like(a), np.zeros(m) if unproved is None else unproved,
        np.zeros((m, 2), bool), True, ya, yb, ydev, np.zeros(k, bool), out, sagging, slopes, lost,
    )  # fmt: skip
    return out, slopes, lost


@pytest.mark.parametrize("kind", KINDS)
def test_a_free_joint_may_go_either_way_round(kind):
    # The cell's cheap end is more than half a turn away the way that its middle goes.
    wraps, w, nothing = np.array([True, True]), np.ones(2), np.zeros((1, 2))
    a, b, y = np.array([[0.0, 0.0]]), np.array([[0.8, 0.0]]), np.array([[-np.pi + 0.5, 0.0]])
    out, _, lost = carried(kind, 1e-3, w, wraps, (a, b, nothing), np.array([[2.0, 0.0]]), (y, y, nothing))
    assert out[0, 0] - lost[0] <= np.pi - 0.3 + 2e-3


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("m", [1, 2, 15, 16, 17, 33])
def test_every_cell_counts(kind, m):
    # Whichever cell it is of whose value less is proved, the values carried on say so.
    a = np.column_stack([np.linspace(0, 1, m), np.zeros(m)])
    cells = (a, a + 0.01, np.zeros((m, 2)))
    new = (np.array([[0.5, 0.3]]), np.array([[0.5, 0.31]]), np.zeros((1, 2)))
    for k in range(m):
        unproved = np.zeros(m)
        unproved[k] = 5.0
        out, _, lost = carried(kind, 0.01, np.ones(2), np.zeros(2, bool), cells, np.zeros((m, 2)), new, unproved)
        assert (out[0] - lost[0] < -3.0).all()


@pytest.mark.parametrize("m", [1, 2, 15, 16, 17, 33])
def test_what_sags_counts(m):
    # Whichever cell it is whose value is low in the middle, the values carried on say so.
    a = np.column_stack([np.linspace(0, 1, m), np.zeros(m)])
    dev, zero, slopes = np.zeros((m, 2)), np.zeros((m, 2)), np.zeros((m, 2))
    ya, yb, ydev = np.array([[0.5, 0.3]]), np.array([[0.5, 0.31]]), np.zeros((1, 2))
    w, wraps = np.ones(2), np.zeros(2, bool)
    for k in range(m):
        one = np.arange(m) == k
        # Either one alone is low, or all are and less of it is proved of one.
        for sag, lost, low in ((np.where(one, 40.0, 0.0), np.zeros(m), -3.0), (np.full(m, 40.0), 5.0 * one, -8.0)):
            out, sagging, g, less = np.empty((1, 2)), np.empty(1), np.empty((1, 2)), np.empty(1)
            cells = (a, a + 0.01, dev, zero, sag, slopes, lost)
            kernels.step_values(
                TRAVEL, 0.01, w, wraps, *cells, np.zeros((m, 2), bool), True,
                ya, yb, ydev, np.zeros(1, bool), out, sagging, g, less,
            )  # fmt: skip
            assert (out[0] - less[0] < low).all()
            boxed = np.empty(1)
            kernels.least_to(TRAVEL, 0.01, w, wraps, *cells, ya, yb, ydev, boxed)
            assert boxed[0] < low
