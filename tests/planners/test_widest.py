"""The widest motion against chains of dense samples, which share none of its proofs, and what it is asked in vain."""

import numpy as np
import pytest
from shapely.geometry import LineString, Point

import selfmotion as sm
from selfmotion.planners.widest_chain import widest_chain
from selfmotion.scene import CircleObstacle

DISCS = [((28.0, -22.0), 4.0), ((20.0, 30.0), 5.0), ((40.0, 24.0), 4.0)]


def clearance_of(arm, discs, q):
    """Least distance between links and discs, by shapely, for each posture."""
    phi = np.cumsum(q, axis=1)
    points = np.cumsum(arm.links[:, None] * np.stack([np.cos(phi), np.sin(phi)], axis=-1), axis=1)
    points = np.concatenate([np.zeros((len(q), 1, 2)), points], axis=1)
    bones = [LineString(each) for each in points]
    return np.min([[Point(at).distance(bone) - radius for bone in bones] for at, radius in discs], axis=0)


def singular_of(arm, q):
    return np.linalg.svd(arm.jacobian(q) / arm.reach, compute_uv=False)[:, -1]


def flooded(problem, of, rows, columns):
    """The largest margin up to which dense samples, (rows, columns) on each elbow, lead from end to end.

    Samples are numbered, and joined to their neighbours in r and in u, and across the elbows where these meet; those
    with the largest margins first, until start and end are joined: motions that also go back in r are counted, which
    are none, but may only help.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    arm, r = problem.arm, np.linspace(0.0, 1.0, rows)
    u = np.linspace(-np.pi, np.pi, columns, endpoint=False)
    width = np.full((2, rows, columns), -np.inf)
    q = np.zeros((2, rows, columns, arm.n))
    for branch in (0, 1):
        for k, x in enumerate(problem.path(r)):
            solved, ok = arm.solve(x, u[:, None], branch)
            ok &= (arm.limits.excess(solved) <= 0).all(axis=1)
            q[branch, k] = solved
            width[branch, k, ok] = of(solved[ok])
    number = np.arange(width.size).reshape(width.shape)
    pairs = [(number[:, :-1], number[:, 1:]), (number, np.roll(number, -1, axis=2)), (number[:1], number[1:])]
    pairs += [(number[:, :-1], np.roll(number[:, 1:], shift, axis=2)) for shift in (-1, 1)]
    one, two = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in (0, 1))
    postures, least = q.reshape(-1, arm.n), np.minimum(width.ravel()[one], width.ravel()[two])
    apart = np.abs(np.remainder(postures[one] - postures[two] + np.pi, 2 * np.pi) - np.pi).max(axis=1)
    one, two, least = (each[(apart < 0.25) & np.isfinite(least)] for each in (one, two, least))
    low, high = -np.inf, float(least.max())
    levels = np.unique(least)
    first, last = 0, len(levels) - 1
    while first < last:  # the last level that leads on
        level = levels[(first + last + 1) // 2]
        kept = least >= level
        source = number.size
        start, end = number[:, 0].ravel(), number[:, -1].ravel()
        start = start[width[:, 0].ravel() >= level]
        i = np.concatenate([one[kept], np.full(len(start), source)])
        j = np.concatenate([two[kept], start])
        graph = coo_array((np.ones(len(i)), (i, j)), shape=(source + 1, source + 1)).tocsr()
        seen = breadth_first_order(graph, source, directed=False, return_predecessors=False)
        leads = np.isin(end[width[:, -1].ravel() >= level], seen).any()
        first, last = ((first + last + 1) // 2, last) if leads else (first, (first + last + 1) // 2 - 1)
    del low, high
    return float(levels[first])


@pytest.fixture(scope="module")
def among_discs(seed_arm, seed_path):
    return sm.Problem(seed_arm, seed_path, obstacles=[CircleObstacle(*disc) for disc in DISCS])


@pytest.fixture(scope="module")
def widest(among_discs):
    return {
        margin: sm.plan(among_discs, sm.Widest(margin, tolerance=1e-2, gap=1e-2, time_limit=120.0))
        for margin in ("clearance", "least_singular_value")
    }


@pytest.mark.parametrize("margin", ["clearance", "least_singular_value"])
def test_motion_and_proof_meet(widest, among_discs, margin):
    plan = widest[margin]
    kept, most = plan.parameters["kept"], plan.parameters["at_most"]
    assert 0.0 < kept <= most <= kept / (1 - 1e-2) * (1 + 1e-12)
    assert plan.verification.holds
    assert plan.planner == "widest"
    assert plan.gap <= 1e-2


def test_dense_samples_of_the_motion_keep_the_margin(widest, among_discs):
    r = np.linspace(0.0, 1.0, 20_001)
    arm = among_discs.arm
    plan = widest["clearance"]
    assert clearance_of(arm, DISCS, plan(r)).min() >= plan.parameters["kept"] - 1e-7
    plan = widest["least_singular_value"]
    assert singular_of(arm, plan(r)).min() >= plan.parameters["kept"] - 1e-9
    assert clearance_of(arm, DISCS, plan(r)).min() >= -1e-7


def test_no_chain_of_dense_samples_keeps_farther_than_is_proved(widest, among_discs):
    """Samples find about what is kept, and nothing beyond what is proved but by what lies between two of them."""
    arm = among_discs.arm

    def clear(q):
        return clearance_of(arm, DISCS, q)

    def regular(q):
        return np.where(clear(q) >= 0.0, singular_of(arm, q), -np.inf)

    for margin, of, between in (("clearance", clear, 0.3), ("least_singular_value", regular, 4e-3)):
        found, parameters = flooded(among_discs, of, 101, 180), widest[margin].parameters
        assert parameters["kept"] - between <= found <= parameters["at_most"] + 1e-9
