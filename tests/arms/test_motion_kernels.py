"""The compiled inverse kinematics against the numpy one, which calls libm, near folds and co-regular radii too."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from selfmotion.angles import wrap
from selfmotion.arms._kernels import planar_ik, planar_rates
from selfmotion.arms._lift_kernels import extend, least_overrun, overrun
from selfmotion.arms._motion_kernels import (
    MARGIN,
    U,
    blank_sheet,
    joints_row,
    margins,
    postures,
    rates,
    shortfall,
    turns_row,
)
from selfmotion.arms.limits import JointLimits

K = 21  # neither a multiple of a vector's length nor below it
lengths = st.lists(st.floats(0.2, 3.0), min_size=3, max_size=6)


def targets(links, u, rng, edge):
    """Tool positions whose two-link targets lie in the annulus, half of them `edge` (relative) off one of its ends."""
    inner, outer = abs(links[0] - links[1]), links[0] + links[1]
    d = rng.uniform(inner, outer, u.shape[1])
    d[::4], d[1::4] = outer * (1.0 - edge), inner + edge * outer
    w = d * np.exp(1j * rng.uniform(-np.pi, np.pi, len(d)))
    return w + links[2:] @ np.exp(1j * u)


def sheet_with(links, u, du=None):
    n, k = len(links), u.shape[1]
    sheet = blank_sheet(n)
    sheet[:] = np.nan  # what is read must have been written
    sheet[U : U + n - 2, :k] = u
    if du is not None:
        sheet[turns_row(n) : turns_row(n) + n - 2, :k] = du
    return sheet


@settings(max_examples=60, deadline=None)
@given(
    lengths, st.booleans(), st.sampled_from([1e-2, 1e-6, 1e-12]), st.integers(0, 10**6), st.sampled_from([1.0, -1.0])
)
def test_postures_are_those_of_libm(links, are_equal, edge, seed, sign):
    links, rng = np.array(links), np.random.default_rng(seed)
    links[1] = links[0] if are_equal else links[1]
    n, u = len(links), rng.uniform(-7.0, 7.0, (len(links) - 2, K))
    x = targets(links, u, rng, edge)
    sheet = sheet_with(links, u)
    postures(links, sign, x.real.copy(), x.imag.copy(), K, sheet)
    q, margin = planar_ik(links, np.stack([x.real, x.imag], axis=1), u.T, sign)
    found = sheet[joints_row(n) : joints_row(n) + n, 1 : K + 1]
    inside = margin > 0
    # Near a fold θ2 is a root of what rounding leaves of the target: of |x| eps, not of eps.
    sensitivity = links.sum() ** 2 / (links[0] * links[1] * np.maximum(np.abs(np.sin(q[:, 1])), 1e-8))
    near_base = links.sum() / np.maximum(np.abs(x - links[2:] @ np.exp(1j * u)), 1e-15 * links.sum())
    off = np.abs(wrap(found.T - q)).max(axis=1)
    assert (off[inside] < 1e-15 * (10.0 + 4.0 * sensitivity + 10.0 * near_base)[inside]).all()
    tool = np.cumsum(found, axis=0)
    assert np.abs(links @ np.exp(1j * tool) - x)[inside].max(initial=0.0) < 1e-7 * links.sum()
    # The margin has the sign of the distance, and inside bounds it.
    scaled = sheet[MARGIN, :K] / (2.0 * (links[0] + links[1]))
    clear = np.abs(margin) > 1e-14 * links.sum()
    assert (np.sign(scaled) == np.sign(margin))[clear].all()
    assert (scaled <= margin + 1e-14 * links.sum())[inside].all()


@settings(max_examples=60, deadline=None)
@given(lengths, st.integers(0, 10**6), st.sampled_from([1.0, -1.0]))
def test_rates_are_those_of_libm(links, seed, sign):
    links, rng = np.array(links), np.random.default_rng(seed)
    n, u, du = len(links), *rng.uniform(-7.0, 7.0, (2, len(links) - 2, K))
    x, dx = targets(links, u, rng, 1e-3), rng.normal(size=K) + 1j * rng.normal(size=K)
    sheet = sheet_with(links, u, du)
    rates(links, sign, x.real.copy(), x.imag.copy(), dx.real.copy(), dx.imag.copy(), K, sheet)
    found = sheet[joints_row(n) : joints_row(n) + n, 1 : K + 1].T
    q, _ = planar_ik(links, np.stack([x.real, x.imag], axis=1), u.T, sign)
    wanted = planar_rates(
        links, np.stack([x.real, x.imag], 1), np.stack([dx.real, dx.imag], 1), u.T, du.T, sign
    )  # fmt: skip
    condition = (links.sum() ** 2 / (links[0] * links[1] * np.sin(q[:, 1]) ** 2))[:, None]
    near_base = (links.sum() / np.abs(x - links[2:] @ np.exp(1j * u)))[:, None]
    size = np.abs(wanted).max(axis=1, keepdims=True)
    assert (np.abs(found - wanted) < 1e-15 * (20.0 + 20.0 * condition + 20.0 * near_base) * (size + 1.0)).all()


def test_rates_are_nan_out_of_reach_and_infinite_at_a_fold():
    links = np.array([1.0, 1.0, 1.0])
    x = np.array([3.1, 3.0, 2.0])
    still = np.zeros((1, 3))
    sheet = sheet_with(links, still, still)
    with np.errstate(all="ignore"):  # in the interpreter numpy warns
        rates(links, 1.0, x, np.zeros(3), np.ones(3), np.zeros(3), 3, sheet)
    joint = sheet[joints_row(3) + 1, 1:4]
    assert np.isnan(joint[0])
    assert np.isinf(joint[1])
    assert np.isfinite(joint[2])


@settings(max_examples=60, deadline=None)
@given(lengths, st.integers(0, 10**6))
def test_the_shortfall_is_the_largest_distance_from_the_annulus(links, seed):
    links, rng = np.array(links), np.random.default_rng(seed)
    u = rng.uniform(-7.0, 7.0, (len(links) - 2, K))
    x = targets(links, u, rng, 0.1) * rng.uniform(0.5, 1.6)
    sheet = sheet_with(links, u)
    margins(links, x.real.copy(), x.imag.copy(), K, sheet)
    w = np.abs(x - links[2:] @ np.exp(1j * u))
    wanted = np.maximum(w - links[0] - links[1], abs(links[0] - links[1]) - w).max()
    assert shortfall(links, K, sheet) == pytest.approx(max(wanted, 0.0), abs=1e-14 * links.sum())


def overrun_of(angles, lower, upper, start):
    """The overrun of samples that are taken in two pieces."""
    extent = np.empty(4)
    extend(angles, 8, extent, True)
    extend(angles[8:], K - 8, extent, False)
    return overrun(extent, lower, upper, start)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**6), st.floats(-12.0, 12.0), st.floats(0.0, 14.0), st.booleans())
def test_the_overrun_of_a_joint_is_that_of_its_limits(seed, lower, span, is_started):
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-9.0, 9.0) + np.cumsum(rng.uniform(-2.0, 2.0, K))
    start = angles[0] + 2 * np.pi * rng.integers(-2, 3) if is_started else None
    limits = JointLimits([(lower, lower + span)], 1)
    wanted = limits.lift(wrap(angles)[None, :, None].copy(), None if start is None else [start]).excess[0, 0]
    found = overrun_of(wrap(angles), lower, lower + span, np.nan if start is None else start)
    assert found == pytest.approx(wanted, abs=1e-13)
    some = wrap(angles)[:: rng.integers(1, 9)]
    assert least_overrun(some, len(some), lower, lower + span) <= wanted + 1e-13


@pytest.mark.parametrize("pair", [(None, 1.0), (-1.0, None)])
def test_the_overrun_of_a_limit_on_one_side(pair):
    angles = np.linspace(0.0, 4.0, K)
    lower, upper = (-np.inf if pair[0] is None else pair[0], np.inf if pair[1] is None else pair[1])
    assert overrun_of(wrap(angles), lower, upper, np.nan) == 0.0
    assert least_overrun(wrap(angles), K, lower, upper) == 0.0
    # From a given start the turns are no longer free.
    expected = JointLimits([pair], 1).lift(wrap(angles)[None, :, None].copy(), [0.0]).excess[0, 0]
    assert overrun_of(wrap(angles), lower, upper, 0.0) == pytest.approx(expected, abs=1e-14)
