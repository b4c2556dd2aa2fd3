"""The angle domain along a path: what is blocked, and from where to where."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.domain import blocked_at, blocked_stretches
from selfmotion.domain.angle_domain import stretches


def test_along_the_seed_s_path(seed_arm, seed_path):
    domain = sm.angle_domain(seed_arm, seed_path)
    assert 0.3 in domain(0.0, "positive")
    assert domain(0.0, "positive") == domain(0.0, 0)
    for r in np.linspace(0, 1, 21):
        assert domain(r, "negative").measure == 0  # 0 ≤ θ2: only the folds are left
    assert domain.empty_stretches(501, [0, 1]) == []
    assert len(domain.empty_stretches(501, [0])) == 0


def test_partly_out_of_reach():
    """Unit 3R, |θ_i| ≤ 2, x = 1.5: reachable only for |y| ≤ √(9 − 2.25) = 2.598."""
    arm = sm.PlanarArm([1, 1, 1], [(-2, 2)] * 3)
    blocked = blocked_stretches(arm, sm.Line([1.5, -3], [1.5, 3.5]), 1000, [0, 1])
    limit = np.sqrt(9 - 2.25)
    assert [part.cause for part in blocked] == ["out of reach", "out of reach"]
    assert blocked[0].r == (0.0, pytest.approx((3 - limit) / 6.5, abs=1e-12))
    assert blocked[1].r == (pytest.approx((3 + limit) / 6.5, abs=1e-12), 1.0)
    assert blocked[1].short_by == pytest.approx(np.hypot(1.5, 3.5) - 3, abs=1e-12)


def test_every_point_reachable_is_not_blocked_pointwise():
    """Unit 3R, |θ_i| ≤ 1.45, the segment x = 1.5: no continuous motion exists, yet no point is empty."""
    arm = sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3)
    assert blocked_stretches(arm, sm.Line([1.5, -2.5], [1.5, 2.5]), 1000, [0, 1]) == []


class Covered:
    """An arm without a structure, of whose covers the one of a branch has cells up to some r."""

    n_u, rigorous, has_structure, reach, branches = 1, True, False, 10.0, ("one", "other")

    def __init__(self, **until):
        self.until = until

    def shortfall(self, x):
        return 0.0 * x[..., 0]

    def cover(self, branch=None):
        until = max(self.until.values()) if branch is None else self.until[branch]

        class Cover:
            @staticmethod
            def cells(x, spacing):
                return [0] if x[0] <= until else []

        return Cover()


def test_without_a_structure_covers_say_what_is_blocked():
    """Where those of all branches that may be used have no cells; of arms that prove nothing, nothing is said."""
    arm, path = Covered(one=0.3, other=0.7), sm.Line([0.0, 0.0], [1.0, 0.0])
    for branches, end in (([0], 0.3), ([1], 0.7), ([0, 1], 0.7)):
        (part,) = blocked_stretches(arm, path, 500, branches)
        assert part.cause == "joint limits"
        assert part.r == (pytest.approx(end, abs=1e-3), 1.0)
        assert not blocked_at(arm, path, end - 1e-9, branches)
        assert blocked_at(arm, path, end + 1e-9, branches)
    for name, value in (("n_u", 2), ("rigorous", False)):
        other = Covered(one=0.3, other=0.7)
        setattr(other, name, value)
        assert blocked_stretches(other, path, 500, [0]) == []
        assert not blocked_at(other, path, 1.0, [0])


def test_joint_limits_block_inside_reach():
    arm = sm.PlanarArm([1, 1, 1], [(-0.5, 0.5)] * 3)
    path = sm.Line([2.9, 0], [0.5, 0])
    blocked = blocked_stretches(arm, path, 1000, [0, 1])
    assert [part.cause for part in blocked] == ["joint limits"]
    low, high = blocked[0].r
    assert high == 1.0
    # Nearest point reached with every |θ| ≤ 0.5, by brute force over the joints.
    grid = np.linspace(-0.5, 0.5, 81)
    q = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 2001), grid, grid, indexing="ij"), axis=-1)
    tip = arm.forward(q[::25])
    reached = np.abs(tip[..., 1]) < 0.02
    nearest = tip[..., 0][reached].min()
    assert 2.9 - 2.4 * low == pytest.approx(nearest, abs=0.02)


@pytest.mark.parametrize(
    "ends",
    [
        [],
        [(0, 1)],
        [(0, 0.03)],
        [(0.97, 1)],
        [(0.22, 0.41), (0.6, 1)],
        [(0, 0.33), (0.55, 0.7), (0.95, 1)],
        [(0.3, 0.5)],
    ],
)
def test_stretches_are_where_the_predicate_holds(ends):
    """Also where it holds at the first or the last place alone."""
    found = stretches(lambda r: np.array([any(a <= x <= b for a, b in ends) for x in r], bool), np.linspace(0, 1, 11))
    assert len(found) == len(ends)
    if ends:
        np.testing.assert_allclose(found, ends, atol=1e-14)


def test_stretches_are_found_to_rounding():
    holds = lambda r: (r > 1 / 3) & (r < 0.5)  # noqa: E731
    ((low, high),) = stretches(holds, np.linspace(0, 1, 50))
    assert low == pytest.approx(1 / 3, abs=1e-14)
    assert high == pytest.approx(0.5, abs=1e-14)
    assert stretches(lambda r: r >= 0, np.linspace(0, 1, 5)) == [(0.0, 1.0)]
    assert stretches(lambda r: r < 0, np.linspace(0, 1, 5)) == []


def test_the_circle_of_a_4r_with_fixed_direction():
    arm = sm.PlanarArm([7, 7, 4, 1.5], direction=-np.pi / 3)
    domain = sm.angle_domain(arm, sm.Circle([6, 4], 4))
    for r in np.linspace(0, 1, 9):
        for branch in (0, 1):
            intervals = domain(r, branch)
            u = np.linspace(-np.pi, np.pi, 721)
            np.testing.assert_array_equal(
                intervals.contains(u), arm.solve(domain.path(r), u[:, None], branch)[1], err_msg=str(r)
            )


@pytest.mark.parametrize("branch", ["left", 7, -1, 0.5, None])
def test_an_unknown_branch_is_refused(seed_arm, seed_path, branch):
    with pytest.raises(sm.InvalidInputError, match="branch"):
        sm.angle_domain(seed_arm, seed_path)(0.5, branch)


TANGENT = {  # feasible throughout, by one posture at each point: only the last moving joint turns
    "two welded joints on the rim": (
        sm.PlanarArm([1, 1, 1], [None, (0, 0), (0, 0)]),
        sm.Arc([0, 0], 3, 0.1, 1.0),
    ),
    "only the third joint turns": (
        sm.PlanarArm([1, 0.8, 0.6], [(0, 0), (0, 0), None]),
        sm.Arc([1.8, 0], 0.6, -1, 2),
    ),
    "stretched, each joint at a limit": (
        sm.PlanarArm(
            [0.9135302824940761, 1.57197812791203, 1.0179343019673892],
            [(2.690832813532672, 4.025421971709287), (0, 1.9719180626020232), (0, 0.9638599715911678)],
        ),
        sm.Arc(
            (0.9135302824940761 + 1.57197812791203) * np.array([np.cos(2.690832813532672), np.sin(2.690832813532672)]),
            1.0179343019673892,
            2.690832813532672,
            0.9638599715911678,
        ),
    ),
    "an arc about the elbow point": (
        sm.PlanarArm([30, 30, 20], [(1.2, 2.2), (0, 0), (0, 1)]),
        sm.Arc(60 * np.array([np.cos(1.2), np.sin(1.2)]), 20, 1.2, 1),
    ),
}


@pytest.mark.parametrize("case", TANGENT)
def test_what_rounding_makes_look_empty_is_not_called_blocked(case):
    arm, path = TANGENT[case]
    for samples in (100, 1001):
        assert blocked_stretches(arm, path, samples, [0, 1]) == []


@pytest.mark.parametrize(("arm", "path"), [
    (sm.PlanarArm([1, 1e-8, 1], [(0, 0), None, None]), sm.Arc([1, 0], 1 + 5e-8, 0.5, 0.5)),
    (sm.PlanarArm([1, 1, 1], [None, (np.pi - 1e-9, np.pi - 1e-9), None]), sm.Arc([0, 0], 1 + 1.5e-7, 0, 1.0)),
])  # fmt: skip
def test_circles_that_nearly_touch_are_no_posture(arm, path):
    """Missed by 4e-8 and 1.5e-7: the domain holds nothing that forward kinematics does not confirm."""
    domain = sm.angle_domain(arm, path)
    for branch in (0, 1):
        assert not domain(0.5, branch)


class JointPath(sm.paths.Path):
    """The tool path of a known joint motion: feasible by construction."""

    kind = "joint"

    def __init__(self, arm, start, change, bend):
        self.arm, self.start, self.change, self.bend = arm, start, change, bend

    def joints(self, r):
        r = np.asarray(r)[..., None]
        return self.start + self.change * r + self.bend * np.sin(3 * r) * r

    def _evaluate(self, r, order):
        assert order == 0
        return self.arm.forward(self.joints(r))


@pytest.mark.parametrize("part", range(3))
def test_a_path_that_a_motion_inside_the_limits_follows_is_never_called_blocked(part):
    """Limits as tight as the motion allows, welded joints, single joints turning, starts stretched or folded."""
    rng = np.random.default_rng(part)
    for _ in range(150):
        links = rng.choice([np.ones(3), rng.uniform(0.3, 2, 3)])
        start, change, bend = rng.uniform(-2, 2, (3, 3)) * [[1], [0.6], [0.3]]
        still = rng.random(3) < rng.choice([0.0, 0.5, 0.7])
        change[still] = bend[still] = 0.0
        start[rng.random(3) < 0.3] = rng.choice([0.0, np.pi])
        path = JointPath(sm.PlanarArm(links), start, change, bend)
        q = path.joints(np.linspace(0, 1, 20_001))
        room = rng.choice([0.0, 1e-9, 0.1], size=3)
        limits = [(low - w, high + w) for low, high, w in zip(q.min(0), q.max(0), room, strict=True)]
        arm = sm.PlanarArm(links, limits)
        assert blocked_stretches(arm, path, 60, [0, 1]) == [], (links, limits, start, change, bend)
