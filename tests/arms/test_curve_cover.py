"""Cells of spatial self-motions: nothing feasible is lost, at random and where joints are free, folded or at limits."""

import attack_covers as attack
import numpy as np
import pytest

from selfmotion.arms import _curve_kernels as kernels
from selfmotion.arms.catalogue import CATALOGUE
from selfmotion.arms.cells import Cells
from selfmotion.arms.curve_cover import CurveCover

KINDS = [kind for kind in attack.KINDS if kind not in attack.COSTLY]
SLOW = ("wrist", "wrist ±1e-3", "limit and wrist", "rim")  # of the iiwa: seconds each
CASES = [(name, kind) for name in attack.ARMS for kind in KINDS if name in ("panda", "fr3") or kind not in SLOW]
CASES.append(("iiwa14", "wrist ±1e-3"))
COVERS = {}
ROLLING = ("irb120", "kr6r900", "ur5e", "ur10e")


def setting(name):
    """An arm and its cover."""
    if name not in COVERS:
        arm = attack.load(name)
        COVERS[name] = arm, arm.cover()
    return COVERS[name]


def drawn(name, kind, seed):
    """An arm, its cover, and a posture and a pose of a kind."""
    arm, cover = setting(name)
    rng = np.random.default_rng(seed)
    q = attack.posture(arm, kind, rng)
    return arm, cover, q, arm.forward(q), rng


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_nothing_feasible_is_lost(name, kind):
    spacing = (0.3, 0.1, 0.02)[KINDS.index(kind) % 3]
    arm, cover, q, _, rng = drawn(name, kind, [1, KINDS.index(kind)])
    found = attack.verdict(arm, cover, q, rng, (spacing,), (0.3,), most=500)
    assert found.checked
    assert not found.faults


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_nothing_is_lost_of_random_self_motions(name):
    checked = 0
    for seed in range(4):
        arm, cover, q, _, rng = drawn(name, "any", [2, seed])
        found = attack.verdict(arm, cover, q, rng, (0.1,), (0.5, 0.2), most=500)
        assert not found.faults
        checked += found.checked
    assert checked > 3_000


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
@pytest.mark.parametrize("slack", [1.5, np.inf])
def test_turns_of_wider_limits_and_of_free_joints_are_there(name, slack):
    arm = attack.load(name, slack)
    cover = arm.cover()
    for seed in range(2):
        rng = np.random.default_rng([3, seed])
        q = rng.uniform(np.maximum(arm.limits.lower, -3.0), np.minimum(arm.limits.upper, 3.0))
        x = arm.forward(q)
        sample = attack.sampled(arm, x, q, rng, 4, most=300).q
        turned = sample
        for j in range(7):
            for turn in (-2 * np.pi, 2 * np.pi):
                moved = sample.copy()
                moved[:, j] += turn
                turned = np.concatenate([turned, moved])
        turned = turned[((turned >= arm.limits.lower) & (turned <= arm.limits.upper)).all(axis=1)]
        assert len(turned) > len(sample)
        cells = cover.cells(x, 0.3)
        assert attack.outside(cells, turned, cover.wraps).max() < 1e-9
        assert attack.outside(cover.split(x, cells, np.full(len(cells), 0.1)), turned, cover.wraps).max() < 1e-9


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_of_a_branch_nothing_is_lost(name):
    arm, _ = setting(name)
    for seed in range(3):
        rng = np.random.default_rng([4, seed])
        q = rng.uniform(arm.limits.lower, arm.limits.upper)
        x = arm.forward(q)
        sample = attack.sampled(arm, x, q, rng, 6, most=400).q
        branches = arm.branch_of(sample)
        for k in np.unique(branches):
            cover = CurveCover(arm, arm.branches[k])
            assert attack.outside(cover.cells(x, 0.1), sample[branches == k], cover.wraps).max() < 1e-9


@pytest.mark.parametrize("name", attack.ARMS)
def test_cells_are_few_and_boxes_are_none_away_from_singularities(name):
    many = []
    for seed in range(15):
        _, cover, _, x, _ = drawn(name, "any", [5, seed])
        cells = cover.cells(x, 0.1)
        many.append(len(cells))
    assert np.median(many) < 1000
    assert max(many) < 10_000


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_parabolas_are_left_by_the_cube_of_the_length_and_rest_is_not_much_too_wide(name):
    arm, cover, q, x, rng = drawn(name, "any", [2, 0])
    sample = attack.sampled(arm, x, q, rng, 6, most=400).q
    rest = []
    for spacing in (0.1, 0.05, 0.025):
        cells = cover.cells(x, spacing)
        cells = cover.split(x, cells, np.full(len(cells), spacing))
        length = np.abs(cells.b - cells.a).max(axis=1)
        long = length > 0.5 * spacing
        assert long.any()
        rest.append(np.median(cells.rest[long].max(axis=1) / length[long] ** 2))
    assert rest[2] < 0.7 * rest[0]
    tight = Cells(cells.a, cells.b, cells.dev, cells.pieces, cells.origin, cells.bow, 1e-3 * cells.rest)
    assert attack.outside(tight, sample, cover.wraps).max() > 1e-9


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_a_cell_left_out_is_missed(name):
    arm, cover, q, x, rng = drawn(name, "any", [2, 0])
    sample = attack.sampled(arm, x, q, rng, 6).q
    cells = cover.cells(x, 0.3)
    arrays = cells.a, cells.b, cells.bow, cells.dev, cells.rest, cover.wraps
    holders = np.unique([attack.excess(posture, *arrays)[1] for posture in sample])
    for k in holders[::5]:
        others = cells[np.arange(len(cells)) != k]
        middle = 0.5 * (cells.a[k] + cells.b[k]) + 0.125 * cells.bow[k]
        if np.abs(cells.b[k] - cells.a[k]).max() > 1e-2:
            assert attack.outside(others, middle[None], cover.wraps)[0] > 1e-4


def charted(name, count, seed):
    """Charts at random postures, each with the longest half that can be proved."""
    arm, _ = setting(name)
    rng = np.random.default_rng(seed)
    chart, direction = kernels.chart_for(arm.n), np.empty(arm.n)
    for _ in range(count):
        q = rng.uniform(arm.limits.lower, arm.limits.upper)
        task = arm.task(arm.forward(q))
        if not kernels.null_direction(arm.kernel, task, q, chart, direction):
            continue
        kernels.prepare(arm.kernel, task, q, direction, chart)
        half, far = 0.0, 0.5
        for _ in range(7):
            middle = 0.5 * (half + far)
            half, far = (middle, far) if kernels.enclose_curve(arm.kernel, chart, middle) else (half, middle)
        if half > 1e-3:
            kernels.enclose_curve(arm.kernel, chart, half)
            yield arm, task, q, direction, chart, half


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_curves_stay_in_the_longest_tubes_that_can_be_proved(name):
    spare, seen = kernels.chart_for(7), 0
    for arm, task, q, direction, chart, half in charted(name, 200, 6):
        for s in half * np.array([-0.99, -0.5, 0.5, 0.99]):
            start = q + s * chart.tangent + 0.5 * s * s * chart.curvature
            p = start.copy()
            assert kernels.settle(arm.kernel, task, p, direction, 1.0, spare) >= 0.0
            assert (np.abs(p - start) <= chart.tube + 1e-12).all()
            seen += 1
    assert seen > 600


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_charts_hold_what_they_say(name):
    for arm, _, q, direction, chart, _ in charted(name, 20, 7):
        jacobian = arm.jacobian(q)
        jacobian[3:] = arm.task(arm.forward(q)).rotation.T @ jacobian[3:]
        inverse = np.linalg.inv(np.vstack([jacobian, direction]))
        np.testing.assert_allclose(chart.by_position, np.linalg.norm(inverse[:, :3], axis=1), rtol=1e-6)
        np.testing.assert_allclose(chart.by_rotation, np.linalg.norm(inverse[:, 3:6], axis=1), rtol=1e-6)
        np.testing.assert_allclose(chart.tangent, inverse[:, 6], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", list(CATALOGUE))
def test_nothing_that_the_closed_form_finds_is_lost(name):
    arm = attack.load(name, tool=attack.TORCH if name in ROLLING else None)
    cover = arm.cover()
    checked = 0
    for seed, kind in enumerate(("any", "limit", "any", "wrist ±1e-3" if name in ROLLING else "any")):
        rng = np.random.default_rng([6, seed])
        q = attack.posture(arm, kind, rng)
        found = attack.dense_verdict(arm, cover, q, rng, (0.3, 0.1)[seed % 2], 0.4)
        assert not found.faults
        checked += found.checked
    assert checked > 1000


@pytest.mark.parametrize("name", ["iiwa14", "ur5e"])
def test_postures_of_the_closed_form_outside_cells_are_told(name):
    arm = attack.load(name, tool=attack.TORCH if name in ROLLING else None)
    cover, rng = arm.cover(), np.random.default_rng(7)
    q = attack.posture(arm, "any", rng)
    x = arm.forward(q)
    sample = attack.drawn(arm, x, q, rng, cover.wraps).q
    cells = cover.cells(x, 0.1)
    fewer = cells[np.arange(len(cells)) % 50 > 0]
    most = 0.0
    for these, rest in ((cells, 1e-3 * cells.rest), (fewer, fewer.rest)):
        away = np.empty(len(sample))
        attack.all_held(sample, these.a, these.b, these.bow, these.dev, rest, cover.wraps, away)
        assert (away > attack.allowance(arm, x, sample)).any()
        most = max(most, away.max())
    assert most > 1e-3


def test_where_shoulder_and_wrist_are_singular_at_once_covers_stay_bounded():
    arm, cover = setting("iiwa14")
    q = np.array([-0.9544228026781725, 0.0, -2.9265038144742643, -1.574293043358952, 2.4198698656020086, 0.0, 1.36])
    cells = cover.cells(arm.forward(q), 0.3)
    assert 1000 < len(cells) < 20_000
    assert cells.rest.max() < 0.6
