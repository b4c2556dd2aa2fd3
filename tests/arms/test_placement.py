"""A planar arm in space: where its tool is there, what is refused, and that no planner sees any of it."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms import ArmPlacement

LINKS = [0.5, 0.4, 0.3]
H = np.sqrt(0.5)
# The plane's x- and y-axis in space, by every way of saying them.
AXES = {
    "xy": ({}, [1, 0, 0], [0, 1, 0]),
    "named xy": ({"plane": "xy"}, [1, 0, 0], [0, 1, 0]),
    "xz": ({"plane": "xz"}, [1, 0, 0], [0, 0, 1]),
    "yz": ({"plane": "yz"}, [0, 1, 0], [0, 0, 1]),
    "zx": ({"plane": "zx"}, [0, 0, 1], [1, 0, 0]),
    "rpy": ({"rpy": [np.pi / 2, 0, 0]}, [1, 0, 0], [0, 0, 1]),
    "quaternion": ({"quaternion": [H, 0, 0, H]}, [0, 1, 0], [-1, 0, 0]),
    "matrix": ({"matrix": [[0, 0, 1], [1, 0, 0], [0, 1, 0]]}, [0, 1, 0], [0, 0, 1]),
    "axes": ({"x_axis": [0, 0, -2], "y_axis": [3, 0, 1]}, [0, 0, -1], [1, 0, 0]),
}


@pytest.mark.parametrize("name", AXES)
def test_the_tool_is_where_the_plane_s_axes_say(name):
    given, x_axis, y_axis = AXES[name]
    arm = sm.PlanarArm([500, 400, 300], placement={"base": [100, -200, 700], "unit": "mm", **given})
    q = np.random.default_rng(1).uniform(-3, 3, (50, 3))
    x = arm.forward(q)
    wanted = np.array([0.1, -0.2, 0.7]) + 1e-3 * (x[:, :1] * np.array(x_axis) + x[:, 1:] * np.array(y_axis))
    assert arm.placement.to_space(x) == pytest.approx(wanted, abs=1e-14)
    again = ArmPlacement.of("placement", arm.placement.as_mapping(), 3)
    assert again.as_mapping() == arm.placement.as_mapping()
    assert np.array_equal(again.pose, arm.placement.pose)


def test_plans_and_proofs_are_those_of_the_arm_without_it():
    path = sm.Bezier([[0.7, -0.3], [0.9, 0.2], [0.4, 0.5], [0.2, 0.7]])
    plans = []
    for placement in (None, {"base": [1, 2, 3], "plane": "yz", "unit": "inch"}):
        arm = sm.PlanarArm(LINKS, [None, (0, np.pi), None], placement=placement)
        plans.append(sm.plan(sm.Problem(arm, path, samples=100), sm.Global(gap=1e-2)))
    r = np.linspace(0, 1, 501)
    assert plans[0](r).tobytes() == plans[1](r).tobytes()
    assert (plans[0].cost, plans[0].lower_bound) == (plans[1].cost, plans[1].lower_bound)


def test_it_stays_with_an_arm_whose_limits_give():
    arm = sm.PlanarArm(LINKS, placement={"plane": "xz", "joints": ["a", "b", "c"]})
    assert arm.relaxed(0.1).placement.as_mapping() == arm.placement.as_mapping()
    assert sm.PlanarArm(LINKS).placement is None


@pytest.mark.parametrize(
    ("placement", "says"),
    [
        ("xz", "placement: is not a mapping"),
        ({"plain": "xz"}, r"placement.plain: is not a known field; did you mean 'plane'\?"),
        ({"plane": "xx"}, "placement.plane: is not known"),
        ({"plane": "xz", "rpy": [0, 0, 0]}, "placement: says its plane by plane and rpy"),
        ({"base": [0, 0]}, "placement.base: has shape"),
        ({"base": [0, 0, np.nan]}, "placement.base: contains NaN"),
        ({"quaternion": [1, 1, 0, 0]}, "placement.quaternion: is no unit quaternion"),
        ({"matrix": np.diag([1, 1, -1])}, "placement.matrix: is no rotation"),
        ({"x_axis": [1, 0, 0]}, "placement: has one axis of the plane only"),
        ({"x_axis": [1, 0, 0], "y_axis": [-2, 0, 0]}, "placement.y_axis: is along the x_axis"),
        ({"x_axis": [0, 0, 0], "y_axis": [1, 0, 0]}, "placement.x_axis: is zero"),
        ({"unit": "ft"}, "placement.unit: is not known"),
        ({"frame": ""}, "placement.frame: is not a name"),
        ({"frame": "a\nb"}, "placement.frame: is not a name"),
        ({"joints": ["a", "b"]}, "placement.joints: are not 3 names"),
        ({"joints": "abc"}, "placement.joints: are not 3 names"),
        ({"joints": ["a", "b", "a"]}, "placement.joints.2: occurs twice"),
        ({"joints": ["a", 2, "c"]}, "placement.joints.1: is not a name"),
    ],
)
def test_what_is_no_placement_is_refused(placement, says):
    with pytest.raises(sm.InvalidInputError, match=says):
        sm.PlanarArm(LINKS, placement=placement)
