"""The self-motion at one point: its connected parts with turns counted, against a walk over a fine grid."""

import itertools

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import selfmotion as sm
from oracle import Arms, random_arm
from selfmotion.domain.fibre import fibres

TAU = 2 * np.pi


def walked(arm, x, count=2500):
    """Number of connected parts of {(u, branch, turns)}: neighbours, also across a fold, joined by real angles."""
    u = (np.arange(count) + 0.5) / count * TAU - np.pi
    nodes, angles, places = [], [], []
    for branch, sign in ((0, 1.0), (1, -1.0)):
        arms = Arms([arm], [sign])
        q, reach = arms.joints(np.array([complex(*x)]), u[None])
        q = q[0, :, : arm.n]
        for j in np.flatnonzero(reach[0].min(axis=-1) > 0):
            ranges = []
            for joint in range(arm.n):
                low, high = arm.limits.lower[joint], arm.limits.upper[joint]
                turns = [0] if not np.isfinite(low) else range(-6, 7)
                inside = [k for k in turns if not np.isfinite(low) or low < q[j, joint] + TAU * k < high]
                ranges.append(inside)
            for turns in itertools.product(*ranges):
                nodes.append((branch, j))
                angles.append(q[j] + TAU * np.array(turns))
                places.append(j)
    index = {}
    for k, node in enumerate(nodes):
        index.setdefault(node, []).append(k)
    angles = np.array(angles)
    free = ~np.isfinite(arm.limits.lower)
    links = []
    for (branch, j), mine in index.items():
        near = [(branch, (j + 1) % count)]
        if branch == 0 and ((branch, (j + 1) % count) not in index or (branch, j - 1) not in index):
            near += [(1, j + step) for step in (-1, 0, 1)]
        for other in near:
            for a, b in itertools.product(mine, index.get(other, [])):
                step = angles[a] - angles[b]
                step[free] = np.angle(np.exp(1j * step[free]))
                if np.abs(step).max() < 0.3:
                    links.append((a, b))
    if not nodes:
        return 0
    graph = coo_matrix((np.ones(len(links)), np.array(links).reshape(-1, 2).T), shape=(len(nodes), len(nodes)))
    return connected_components(graph, directed=False)[0]


def test_connected_parts_with_turns_agree_with_a_walk():
    rng = np.random.default_rng(8)
    counts = []
    while len(counts) < 80:
        links = rng.uniform(0.5, 2, 3)
        spans = rng.choice([None, 2.5, TAU, 7.0, 9.0, 12.0], 3)
        lows = np.where(rng.random(3) < 0.4, -np.pi, rng.uniform(-5, 0, 3))  # −π: a seam that lies on a fold
        limits = [None if s is None else (low, low + s) for s, low in zip(spans, lows, strict=True)]
        arm = sm.PlanarArm(links, limits)
        x = rng.uniform(0.2, 0.95) * arm.reach * np.array([1.0, 0.0])
        (fibre,) = fibres(arm.self_motion(), x[None])
        widths = [interval.high - interval.low for interval in fibre.intervals if not interval.is_circle]
        ends = np.sort([end for interval in fibre.intervals for end in (interval.low, interval.high)])
        if min(widths, default=1) < 0.02 or abs(links[0] - links[1]) < 0.1 or (np.diff(np.unique(ends)) < 0.01).any():
            continue  # too thin for the walk's grid
        assert fibre.n_components == walked(arm, x), (links, limits, x)
        counts.append(fibre.n_components)
    assert max(counts) > 8
    assert min(counts) <= 2


def test_a_limit_at_half_a_turn_keeps_the_elbows_apart_at_the_inner_fold():
    """At R between |l1 − l2| ± l3 both elbows meet at θ2 = π, which |θ2| ≤ π does not let pass, but |θ2| ≤ 2π does."""
    x = np.array([[0.5, 0.0]])
    parts = []
    for limit in (None, (-np.pi, np.pi), (-2 * np.pi, 2 * np.pi)):
        (fibre,) = fibres(sm.PlanarArm([2, 1.4, 0.5], [None, limit, None]).self_motion(), x)
        parts.append(fibre.n_components)
    assert parts == [1, 2, 2]  # in the last case one centred at π, one at −π


def test_a_locked_joint_leaves_single_postures():
    arm = sm.PlanarArm([1, 1, 0.5], [(0.3, 0.3), None, None])
    (fibre,) = fibres(arm.self_motion(), np.array([[1.5, -0.5]]))
    assert len(fibre.intervals) == fibre.n_components == 2
    assert all(interval.low == interval.high for interval in fibre.intervals)


def test_both_elbows_hang_together_at_the_folds_only():
    outer, inner = fibres(sm.PlanarArm([30, 30, 20]).self_motion(), np.array([[50.0, -10.0], [35.0, 3.0]]))
    assert outer.component == (0, 0)
    assert inner.component == (0, 1)
    assert all(interval.is_circle for interval in inner.intervals)


def test_names_do_not_depend_on_where_the_base_looks():
    """Rotating the task point renames nothing: no joint that decides is counted from the base's zero."""
    rng = np.random.default_rng(4)
    for _ in range(50):
        arm = random_arm(rng)
        if arm.direction is not None:
            continue
        arm = sm.PlanarArm(arm.links, [None, *arm.limits.as_list()[1:]])
        radius, angles = rng.uniform(0.1, 1) * arm.reach, rng.uniform(-np.pi, np.pi, 6)
        found = fibres(arm.self_motion(), radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1))
        assert len({fibre.names for fibre in found}) == 1
