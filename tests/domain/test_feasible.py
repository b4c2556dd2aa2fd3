"""Closed-form intervals against dense inverse kinematics that shares no formula with them."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.domain import feasible_arcs

ARMS = 10_000
CLEAR = 1e-9  # distance from an interval end beyond which the two must agree
UNDECIDED = 1e-12  # the oracle's own rounding: nearer to a constraint than this it cannot tell


def oracle(links, limits, direction, x, u, sign):
    """Feasible or not, and by which least margin, from the intersection of two circles in the complex plane.

    In extended precision, because the intersection loses digits when one link is much shorter than another.
    """
    l1, l2, l3 = (np.longdouble(length) for length in links[:3])
    tip = np.clongdouble(complex(*x))
    u = u.astype(np.longdouble)
    if direction is not None:
        tip -= links[3] * np.exp(1j * direction)
    wrist = tip - l3 * np.exp(1j * u)
    d = np.abs(wrist)
    reach = np.minimum(l1 + l2 - d, d - abs(l1 - l2))
    along = (l1**2 - l2**2 + d**2) / (2 * d)
    across = np.sqrt(np.maximum((l1 + along) * (l2 - d + l1) * (l2 + d - l1) / (2 * d), 0))
    elbow = wrist / d * (along - 1j * sign * across)
    theta1, phi2 = np.angle(elbow), np.angle(wrist - elbow)
    joints = [theta1, phi2 - theta1, u - phi2]
    if direction is not None:
        joints.append(direction - u)
    margin = reach / (l1 + l2)
    for theta, pair in zip(joints, limits, strict=True):
        if pair is not None:
            turns = np.arange(-4, 5)[:, None]
            inside = np.minimum(theta + 2 * np.pi * turns - pair[0], pair[1] - theta - 2 * np.pi * turns)
            margin = np.minimum(margin, inside.max(axis=0))
    return margin


def random_case(rng):
    links = rng.uniform(0.2, 2.0, 3)
    shape = rng.integers(0, 8)
    if shape == 0:
        links[:] = 1.0
    elif shape == 1:
        links[1] = links[0]
    elif shape == 2:
        links *= 10.0 ** rng.uniform(-2, 2, 3)
    direction = None
    if rng.random() < 0.2:
        links, direction = np.append(links, rng.uniform(0.1, 1)), rng.uniform(-np.pi, np.pi)
    limits = []
    for _ in links:
        kind = rng.integers(0, 6)
        low = rng.uniform(-2 * np.pi, np.pi)
        span = (None, None, rng.uniform(0, 1), rng.uniform(1, 6), rng.uniform(5.5, 14), 10.0 ** rng.uniform(-9, -1))[
            kind
        ]
        limits.append(None if span is None else (low, low + span))
    reach = links[:3].sum()
    radius = reach * rng.uniform(0, 1.02)
    if rng.random() < 0.3:  # co-regular radii and the outer rim
        l1, l2, l3 = links[:3]
        radius = abs(rng.choice([l1 + l2 + l3, l1 + l2 - l3, l1 - l2 + l3, -l1 + l2 + l3, l1]))
    psi = rng.uniform(-np.pi, np.pi)
    x = radius * np.array([np.cos(psi), np.sin(psi)])
    if direction is not None:
        x = x + links[3] * np.array([np.cos(direction), np.sin(direction)])
    return links, limits, direction, x


@pytest.mark.parametrize("part", range(4))
def test_intervals_agree_with_dense_inverse_kinematics(part, share):
    rng = np.random.default_rng(100 + part)
    compared = feasible = 0
    for _ in range(int(share * ARMS / 4)):
        links, limits, direction, x = random_case(rng)
        arm = sm.PlanarArm(links, limits, direction)
        arcs = feasible_arcs(arm.self_motion(), x[None])
        for branch, sign in ((0, 1.0), (1, -1.0)):
            intervals = arcs[branch].interval_set(0)
            ends = intervals.intervals.ravel() if not intervals.is_full else np.empty(0)
            beside = (ends[:, None] + np.array([-1e-4, -1e-6, -1e-8, -2e-9, 2e-9, 1e-8, 1e-6, 1e-4])).ravel()
            u = np.concatenate([rng.uniform(-np.pi, np.pi, 60), np.linspace(-np.pi, np.pi, 61), beside])
            with np.errstate(invalid="ignore", divide="ignore"):
                margin = oracle(links, limits, direction, x, u, sign)
            decided = (intervals.distance_to_ends(u) > CLEAR) & (np.abs(margin) > UNDECIDED)
            said = intervals.contains(u)
            wrong = decided & (said != (margin > 0))
            assert not wrong.any(), (links, limits, direction, x, branch, u[wrong], margin[wrong])
            compared += int(decided.sum())
            feasible += int((decided & said).sum())
    assert compared > 500_000 * share
    assert feasible > 0.05 * compared


def test_without_limits_the_domain_is_the_seed_s_arc():
    """|θ_g − ψ| ≤ arccos((R² + l3² − (l1+l2)²)/(2 R l3)), the interval (14)–(17) of the seed."""
    arm = sm.PlanarArm([30, 30, 20])
    for x in ([60.0, 20.0], [-50.0, 45.0], [50.0, -10.0]):
        radius, psi = np.hypot(*x), np.arctan2(x[1], x[0])
        half = np.arccos((radius**2 + 400 - 3600) / (40 * radius))
        for branch in (0, 1):
            intervals = feasible_arcs(arm.self_motion(), np.array([x]))[branch].interval_set(0)
            assert len(intervals) == 1
            low, high = intervals.intervals[0]
            assert np.cos(low - psi + half) == pytest.approx(1)
            assert np.cos(high - psi - half) == pytest.approx(1)
            assert high - low == pytest.approx(2 * half, abs=1e-14)


def test_boundary_is_theta3_as_mended_not_as_printed():
    """(13) prints θ3 = ±(2π − Δ3); at the start of the seed's path that gives 4.81 where the boundary is at 1.67."""
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])
    high = sm.angle_domain(arm, sm.Line([50, -10], [51, -10]))(0.0, "positive").intervals[0, 1]
    assert high == pytest.approx(1.672, abs=1e-3)


def test_a_limit_of_zero_width_leaves_single_points():
    rng = np.random.default_rng(0)
    for _ in range(200):
        links = rng.uniform(0.5, 2, 3)
        q = rng.uniform(-2.5, 2.5, 3)
        joint = rng.integers(0, 3)
        limits = [(float(q[j]), float(q[j])) if j == joint else None for j in range(3)]
        arm = sm.PlanarArm(links, limits)
        branch = int(arm.branch_of(q))
        intervals = feasible_arcs(arm.self_motion(), arm.forward(q)[None])[branch].interval_set(0)
        assert intervals.measure <= 1e-9
        assert intervals.distance(arm.u_of(q)[0]) < 1e-7


def test_at_the_rim_one_posture_is_left():
    arm = sm.PlanarArm([1, 1, 1])
    for branch in (0, 1):
        intervals = feasible_arcs(arm.self_motion(), np.array([[3.0, 0.0]]))[branch].interval_set(0)
        assert intervals
        assert intervals.measure < 1e-6
        assert feasible_arcs(arm.self_motion(), np.array([[3.0 + 1e-9, 0.0]]))[branch].empty[0]


def test_at_the_base_the_whole_circle_is_feasible_or_nothing_is():
    origin = np.zeros((1, 2))
    for branch in (0, 1):
        assert feasible_arcs(sm.PlanarArm([1, 1, 1]).self_motion(), origin)[branch].interval_set(0).is_full
        assert not feasible_arcs(sm.PlanarArm([3, 1, 1]).self_motion(), origin)[branch].interval_set(0)


def test_breakpoints_stand_exactly_on_their_cause():
    rng = np.random.default_rng(9)
    seen = set()
    for _ in range(300):
        links, limits, direction, x = random_case(rng)
        arm = sm.PlanarArm(links, limits, direction)
        motion = arm.self_motion()
        breaks = motion.breakpoints(motion.pose(x[None]))
        for column, cause in enumerate(breaks.causes):
            q = breaks.q[0, column]
            if not np.isfinite(q).all():
                continue
            seen.add((cause.kind, cause.joint))
            np.testing.assert_allclose(arm.forward(q), x, atol=3e-7 * arm.reach)
            if cause.kind == "fold":
                assert abs(np.sin(q[1])) < 1e-12
            else:
                bound = arm.limits.lower if cause.kind == "lower limit" else arm.limits.upper
                assert abs(np.sin((q[cause.joint] - bound[cause.joint]) / 2)) < 1e-12
    assert {("fold", 1), *((f"{b} limit", j) for b in ("lower", "upper") for j in range(4))} <= seen
