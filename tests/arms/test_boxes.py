"""Joint limits narrowed to an elbow: half turns of joint 2, all of them and nothing else."""

import numpy as np
import pytest

import selfmotion as sm


@pytest.mark.parametrize("elbow", ["positive", "negative"])
def test_the_boxes_are_the_angles_inside_the_limits_with_that_elbow(elbow):
    rng = np.random.default_rng(0)
    for _ in range(200):
        low = rng.uniform(-12, 6)
        high = low + rng.choice([0.0, 0.3, 2.0, 3.5, 7.0, 13.0])
        arm = sm.PlanarArm([1, 1, 1], [None, (low, high), (-1, 1)])
        boxes = arm.boxes(elbow)
        angles = rng.uniform(low, high, 400)
        inside = [((angles >= box.lower[1]) & (angles <= box.upper[1])) for box in boxes]
        sign = np.sin(angles) >= 0 if elbow == "positive" else np.sin(angles) <= 0
        assert (np.sum(inside, axis=0) == sign).all() if boxes else not sign.any()
        assert all((box.lower[[0, 2]] == [-np.inf, -1]).all() and box.upper[2] == 1 for box in boxes)
        assert all(low <= box.lower[1] <= box.upper[1] <= high for box in boxes)


@pytest.mark.parametrize("limits", [None, (None, None), (1.0, None), (None, 1.0), (np.pi, None), (-np.pi, None)])
def test_a_joint_that_may_turn_on_is_given_one_whole_half_turn(limits):
    arm = sm.PlanarArm([1, 1, 1], [None, limits, None])
    for elbow, sign in (("positive", 1), ("negative", -1)):
        (box,) = arm.boxes(elbow)
        assert box.upper[1] - box.lower[1] == pytest.approx(np.pi)
        assert sign * np.sin(0.5 * (box.lower[1] + box.upper[1])) == pytest.approx(1.0)
        assert arm.limits.lower[1] <= box.lower[1]
        assert box.upper[1] <= arm.limits.upper[1]


def test_any_elbow_is_the_limits_themselves():
    arm = sm.PlanarArm([1, 1, 1], [None, (-9, 2), None])
    (box,) = arm.boxes()
    assert (box.lower == arm.limits.lower).all()
    assert (box.upper == arm.limits.upper).all()
