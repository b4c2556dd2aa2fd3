"""Steps between samples: nothing slips through them that bends either way."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.constrained.between import straight, unsure
from selfmotion.errors import InvalidInputError
from selfmotion.scene import CircleObstacle, HalfPlaneObstacle, PolygonObstacle
from selfmotion.scene.scene import Scene


def scene(*obstacles, thickness=0.0, clearance=0.0):
    return Scene(sm.PlanarArm([1.0, 1.0, 1.0], thickness=thickness), obstacles, clearance)


def swinging(shape):
    """A motion whose first joint goes as `shape` says; the others stand still, the arm stretched out."""
    return lambda r: np.stack([shape(np.asarray(r)), 0.0 * r, 0.0 * r], axis=-1)


AHEAD = CircleObstacle((3.0 * np.cos(0.1), 3.0 * np.sin(0.1)), 0.05)  # at 0.1 rad, where the tip passes


@pytest.mark.parametrize(
    "shape",
    [
        lambda s: 0.12 * np.sin(2 * np.pi * s),  # on its chord half-way
        lambda s: 2.0 * s * (1 - s) * (1 - 2 * s),
        lambda s: 0.5 * s * (1 - s),
        lambda s: 0.2 * s,
        lambda s: np.sqrt(s) * 0.2 - 0.05 * s,
    ],
)
@pytest.mark.parametrize("steps", [1, 2, 3, 100])
def test_a_motion_that_enters_an_obstacle_within_a_step_is_seen(shape, steps):
    r = np.linspace(0.0, 1.0, steps + 1)
    motion = swinging(shape)
    constraint = scene(AHEAD)
    truth = constraint.margins(motion(np.linspace(0.0, 1.0, 5001))).min()
    place = unsure(constraint, motion, r, motion(r))
    if truth < -1e-6:
        assert place is not None
        assert place.margin < 0
        assert 0.0 <= place.r <= 1.0


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_no_polynomial_slips_through(degree):
    """Random polynomials on few steps: what is said to be clear everywhere is clear where one looks closely."""
    rng, clear = np.random.default_rng(degree), 0
    constraint = scene(CircleObstacle((2.0, 1.0), 0.2), PolygonObstacle([(-1.0, 1.0), (0.5, 2.5), (-1.0, 1.5)]))
    dense = np.linspace(0.0, 1.0, 4001)
    for _ in range(150):
        powers = rng.normal(0.0, 1.0, (degree + 1, 3))

        def motion(r, powers=powers):
            return np.stack([np.polynomial.polynomial.polyval(r, column) for column in powers.T], axis=-1)

        r = np.linspace(0.0, 1.0, int(rng.integers(2, 6)))
        if unsure(constraint, motion, r, motion(r)) is None:
            clear += 1
            assert constraint.margins(motion(dense)).min() >= -constraint.tolerance
    assert 10 < clear < 150


def test_straight_steps_past_a_thin_obstacle_are_seen():
    """Both rows are clear, and the link sweeps over a needle between them."""
    needle = PolygonObstacle([(2.5, 0.049), (3.2, 0.05), (2.5, 0.051)])
    rows, q = np.arange(2.0), np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.0]])
    assert scene(needle).margins(q).min() > 0
    assert unsure(scene(needle), straight(rows, q), rows, q) is not None
    away = q - np.array([0.1, 0.0, 0.0])
    assert unsure(scene(needle), straight(rows, away), rows, away) is None


def test_a_link_may_touch_at_the_clearance_asked_for():
    """Along a circle about the base, the tip exactly as far from it as is asked for."""
    inside = CircleObstacle((0.0, 5.0), 1.5)
    q = np.stack([np.linspace(0.0, np.pi, 60), np.zeros(60), np.zeros(60)], axis=-1)
    r = np.linspace(0.0, 1.0, 60)
    assert unsure(scene(inside, clearance=0.5), straight(r, q), r, q) is None
    assert unsure(scene(inside, clearance=0.5 + 1e-6), straight(r, q), r, q) is not None


def test_plans_of_few_samples_are_looked_at_between_them(seed_arm, seed_path):
    """With two samples, a motion that swings in between and comes back is not taken for one that stands still."""
    from selfmotion.verification import verify_motion

    free = sm.plan(sm.Problem(seed_arm, seed_path), sm.Refine(starts=1))
    middle = free(np.array([0.5371]))[0]
    turn = np.cumsum(middle)
    elbow = np.cumsum(seed_arm.links[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1), axis=0)[1]
    small = sm.Problem(seed_arm, seed_path, samples=2, obstacles=[CircleObstacle(elbow, 0.02)])
    check = verify_motion(small, free)
    assert [failure.check for failure in check.failures] == ["clearance"]
    assert check.margins["clearance"] < 0


@pytest.mark.parametrize(
    "obstacle",
    [
        HalfPlaneObstacle((0.0, 0.0), (0.0, 1.0)),
        HalfPlaneObstacle((0.0, -1e-9), (0.0, 1.0)),
        CircleObstacle((0.0, -1.0), 1.0),
        PolygonObstacle([(-1.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 0.0)]),
        PolygonObstacle([(0.0, 0.0), (-0.5, -0.2), (-0.5, -0.5)]),
    ],
)
def test_a_link_whose_base_touches_an_obstacle_is_told_clear(obstacle):
    """The base stands on it, or next to it, however the link turns; and where the link turns into it, it is not."""
    r = np.linspace(0.0, 1.0, 30)
    q = np.stack([np.linspace(0.3, 2.5, 30), np.zeros(30), np.zeros(30)], axis=-1)
    assert unsure(scene(obstacle), straight(r, q), r, q) is None
    into = q - np.array([0.45, 0.0, 0.0])
    if isinstance(obstacle, PolygonObstacle) and len(obstacle.corners) == 3:
        into = q + np.array([1.5, 0.0, 0.0])
    assert unsure(scene(obstacle), straight(r, into), r, into) is not None


def test_obstacles_whose_numbers_rounding_swallows_are_refused():
    with pytest.raises(InvalidInputError, match="100000 times"):
        scene(CircleObstacle((1e12, 0.0), 1e12 - 5.0))
    scene(HalfPlaneObstacle((1e12, 0.0), (-1.0, 0.0)))


def test_where_it_breaks_what_breaks_is_named_and_not_what_is_merely_unsure():
    """The tool passes a disc with room, and later goes through another."""
    beside = CircleObstacle((3.03 * np.cos(0.2), 3.03 * np.sin(0.2)), 0.02)
    both = scene(beside, CircleObstacle((3.0 * np.cos(0.4), 3.0 * np.sin(0.4)), 0.001))
    q, r = np.array([[0.0, 0.0, 0.0], [0.8, 0.0, 0.0]]), np.array([0.0, 1.0])
    place = unsure(both, straight(r, q), r, q)
    assert both.cause(place.which) == "link 3 against obstacle 2"
    assert place.margin == pytest.approx(-0.001, abs=1e-4)
