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


@pytest.mark.parametrize("limits", [None, (None, None)])
def test_a_free_joint_is_given_the_half_turn_that_is_asked_for(limits):
    arm = sm.PlanarArm([1, 1, 1], [None, limits, None])
    for elbow, sign in (("positive", 1), ("negative", -1)):
        for around in (0.0, 1.5, -1.5, 2 * np.pi + 1.5, 40.0):
            (box,) = arm.boxes(elbow, [0, around, 0])
            assert box.upper[1] - box.lower[1] == pytest.approx(np.pi)
            middle = 0.5 * (box.lower[1] + box.upper[1])
            assert sign * np.sin(middle) == pytest.approx(1.0)
            assert abs(middle - around) <= np.pi + 1e-12


@pytest.mark.parametrize("limits", [(1.0, None), (None, 1.0), (np.pi, None), (-np.pi, None), (-1e30, 1e30)])
def test_many_half_turns_are_those_around_an_angle(limits):
    arm = sm.PlanarArm([1, 1, 1], [None, limits, None])
    lower, upper = arm.limits.lower[1], arm.limits.upper[1]
    for elbow, sign in (("positive", 1), ("negative", -1)):
        for around in (np.clip(0.0, lower, upper), np.clip(20.0, lower, upper)):
            boxes = arm.boxes(elbow, [0, around, 0])
            angles = np.linspace(max(lower, around - 9), min(upper, around + 9), 1000)
            inside = [((angles >= box.lower[1]) & (angles <= box.upper[1])) for box in boxes]
            clear = np.abs(np.sin(angles)) > 1e-12
            assert (np.any(inside, axis=0) == (sign * np.sin(angles) >= 0))[clear].all()
            assert len(boxes) <= 8


def test_any_elbow_is_the_limits_themselves():
    arm = sm.PlanarArm([1, 1, 1], [None, (-9, 2), None])
    (box,) = arm.boxes()
    assert (box.lower == arm.limits.lower).all()
    assert (box.upper == arm.limits.upper).all()
