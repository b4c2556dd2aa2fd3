"""Every path of the registry: its derivatives are those of its positions, and it says its length."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.errors import InvalidInputError
from selfmotion.paths import PATHS, Path
from selfmotion.paths.base import distance

SQUARE = [[0, 0], [2, 0], [2, 3], [-1, 3]]
EXAMPLES = {
    "bezier": sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]),
    "clothoid": sm.Clothoid((110, 20), 25, [0, -4, 0, 0.33], (-4.712, 0)),
    "line": sm.Line([1, 2], [5, -1]),
    "arc": sm.Arc([1, 1], 3, 0.4, -2.2),
    "circle": sm.Circle([6, 4], 4),
    "ellipse": sm.Ellipse([1, 2], [3, 1], rotation=0.7, start_angle=-1, sweep=4),
    "lissajous": sm.Lissajous([1, 2], [3, 4], [3, 2], phase=0.5),
    "rose": sm.Rose([0, 1], 2, 3, sweep=np.pi, rotation=0.3),
    "waypoints": sm.Waypoints(SQUARE),
    "reversed": sm.Reversed(sm.Waypoints(SQUARE, "spline")),
    "arc_length": sm.ArcLength(sm.Bezier([[0, 0], [1, 3], [4, 3], [5, 0]])),
    "concatenation": sm.Concatenation([sm.Line([0, 0], [2, 0]), sm.Arc([2, 1], 1, -np.pi / 2, np.pi)]),
    "transformed": sm.Transformed(sm.Rose([0, 1], 2, 2), scale=2.5, rotation=1.1, translation=[3, -4]),
    "placed": sm.Placed(sm.Ellipse([1, 2], [3, 1]), {"translation": [1, 2, 3], "rpy": [0.3, -0.5, 2.0]}),
    "pose": sm.PosePath(
        sm.Bezier([[0, 0, 1], [1, 3, 0], [4, 3, 2]]), orientations=[[1, 0, 0, 0], [0.6, 0, 0.8, 0], [0.6, 0.8, 0, 0]]
    ),
    "pose_waypoints": sm.PoseWaypoints(
        [[0, 0, 0, 1, 0, 0, 0], [2, 0, 1, 0.6, 0, 0.8, 0], [2, 3, 1, 0.6, 0.8, 0, 0], [-1, 3, 0, 0, 1, 0, 0]], "spline"
    ),
}


def test_every_path_has_an_example():
    assert set(EXAMPLES) == set(PATHS)


def away_from_breaks(path, n=400, gap=2e-3):
    r = np.linspace(gap, 1 - gap, n)
    if len(path.breaks):
        r = r[np.abs(r[:, None] - path.breaks).min(axis=1) > gap]
    return r


@pytest.mark.parametrize("kind", EXAMPLES)
@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_are_those_of_the_curve(kind, order):
    path = EXAMPLES[kind]
    r, h = away_from_breaks(path), 1e-4
    # Five-point difference of the next lower derivative: error about h⁴.
    stencil = [(-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12)]
    difference = sum(weight * path(r + k * h, order - 1) for k, weight in stencil) / h
    scale = np.abs(path(r, order)).max() + np.abs(path(r, order - 1)).max()
    np.testing.assert_allclose(path(r, order), difference, atol=3e-7 * scale)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_length_is_that_of_a_fine_polyline(kind):
    path = EXAMPLES[kind]
    r = np.unique(np.concatenate([np.linspace(0, 1, 50_001), path.breaks]))
    polyline = distance(np.diff(path(r), axis=0)).sum()
    assert path.length == pytest.approx(polyline, rel=1e-6)
    assert path.length >= polyline * (1 - 1e-12)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_shapes_follow_the_input(kind):
    path = EXAMPLES[kind]
    assert path(0.5).shape == (path.dimension,)
    assert path(np.zeros((3, 4)), 1).shape == (3, 4, path.dimension)
    np.testing.assert_array_equal(path([0.2, 0.7])[1], path(0.7))


@pytest.mark.parametrize("kind", EXAMPLES)
@pytest.mark.parametrize("bad", [-0.1, 1.1, np.nan, "here"])
def test_outside_the_range_is_refused(kind, bad):
    with pytest.raises(sm.InvalidInputError):
        EXAMPLES[kind]([0.5, bad])


def test_bezier_against_the_bernstein_sum():
    rng = np.random.default_rng(0)
    for degree in (1, 2, 5, 12, 25):
        points = rng.normal(size=(degree + 1, 2))
        r = rng.random(50)
        basis = [float(mpmath.binomial(degree, k)) * r**k * (1 - r) ** (degree - k) for k in range(degree + 1)]
        np.testing.assert_allclose(sm.Bezier(points)(r), np.transpose(basis) @ points, atol=1e-12)


@pytest.mark.parametrize(
    ("coefficients", "t_range", "scale"),
    [
        ([0, -4, 0, 0.33], (-4.712, 0.0), 25.0),
        ([0, -4, 0, 0.33], (-4.712, 4.712), 1e-6),
        ([0.3, 0.2, -1.5, 0.1, 0.05], (2.0, -3.0), 1e6),
        ([1.0], (0.5, 2.5), 3.0),
        ([0, 0, 30.0], (1.0, 4.0), 1.0),
    ],
)
def test_clothoid_position_to_1e10_of_the_scale(coefficients, t_range, scale):
    path = sm.Clothoid((110, 20), scale, coefficients, t_range)
    r = np.array([0.0, 0.137, 0.5, 0.91, 1.0])
    with mpmath.workdps(20):

        def angle(u):
            return sum(mpmath.mpf(c) * u**k for k, c in enumerate(coefficients))

        for position, s in zip(path(r), r, strict=True):
            t = mpmath.mpf(t_range[0]) + mpmath.mpf(s) * (mpmath.mpf(t_range[1]) - mpmath.mpf(t_range[0]))
            nodes = mpmath.linspace(0, t, 40)
            x = 110 + scale * mpmath.quad(lambda u: mpmath.sin(angle(u)), nodes)
            y = 20 + scale * mpmath.quad(lambda u: mpmath.cos(angle(u)), nodes)
            assert abs(position[0] - float(x)) <= 1e-10 * scale + 3e-14
            assert abs(position[1] - float(y)) <= 1e-10 * scale + 3e-14
    assert path.length == pytest.approx(scale * abs(t_range[1] - t_range[0]), rel=1e-10)


def test_clothoid_ends_where_its_range_says():
    path = EXAMPLES["clothoid"]
    np.testing.assert_allclose(path(1.0), [110, 20], atol=1e-12)


@pytest.mark.parametrize("kind", ["bezier", "ellipse", "waypoints", "lissajous", "concatenation"])
def test_arc_length_runs_at_constant_speed(kind):
    original = EXAMPLES[kind]
    path = sm.ArcLength(original)
    r = away_from_breaks(path)
    np.testing.assert_allclose(np.hypot(*path(r, 1).T), original.length, rtol=1e-9)
    np.testing.assert_allclose(path([0.0, 1.0]), original([0.0, 1.0]), atol=1e-9)
    # Where a fine polyline of the original has run through three tenths of its length.
    fine = np.unique(np.concatenate([np.linspace(0, 1, 400_001), original.breaks]))
    run = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(original(fine), axis=0).T))])
    there = np.interp(0.3 * run[-1], run, fine)
    np.testing.assert_allclose(path(0.3), original(there), atol=1e-7 * original.extent)


def test_arc_length_survives_a_point_where_the_path_stops():
    original = sm.Bezier([[0, 0], [0, 0], [1, 0], [1, 1], [1, 1]])
    path = sm.ArcLength(original)
    assert np.isfinite(path(np.linspace(0, 1, 101), 2)).all()
    polyline = np.hypot(*np.diff(original(np.linspace(0, 1, 20_001)), axis=0).T).sum()
    np.testing.assert_allclose(np.hypot(*path([0.0, 0.4, 1.0], 1).T), polyline, rtol=1e-6)


def test_polyline_is_exact_and_says_its_corners():
    path = sm.Waypoints(SQUARE)
    np.testing.assert_array_equal(path(path.waypoints), np.array(SQUARE, float))
    assert len(path.breaks) == 2
    inside = path(np.linspace(0, path.breaks[0], 7))
    np.testing.assert_allclose(inside[:, 1], 0.0, atol=1e-15)


def test_spline_passes_its_points_with_continuous_curvature():
    path = sm.Waypoints(SQUARE, "spline")
    np.testing.assert_allclose(path(path.waypoints), SQUARE, atol=1e-14)
    for order in (1, 2):
        for r in path.breaks:
            np.testing.assert_allclose(path(r - 1e-9, order), path(r + 1e-9, order), atol=1e-4)


def test_a_closed_spline_closes_smoothly():
    points = [*SQUARE, SQUARE[0]]
    path = sm.Waypoints(points, "spline")
    assert path.is_closed
    np.testing.assert_allclose(path(0.0, 1), path(1.0, 1), atol=1e-9)


def test_reversal_and_motion_undo_themselves():
    path = EXAMPLES["waypoints"]
    twice = sm.Reversed(sm.Reversed(path))
    r = away_from_breaks(path)
    np.testing.assert_allclose(twice(r), path(r), atol=1e-14)
    there = sm.Transformed(path, 2.0, 0.5, [1, 2])
    c, s = np.cos(0.5), np.sin(0.5)
    np.testing.assert_allclose(there(r), path(r) @ (2 * np.array([[c, s], [-s, c]])) + [1, 2], atol=1e-13)
    assert there.length == pytest.approx(2 * path.length)


def test_waypoints_of_a_path_made_of_another_are_where_that_one_s_are():
    path, corners = EXAMPLES["waypoints"], np.array(SQUARE, float)
    c, s = np.cos(0.5), np.sin(0.5)
    moved = corners @ (2 * np.array([[c, s], [-s, c]])) + [1, 2]
    for made, wanted in (
        (sm.Reversed(path), corners[::-1]),
        (sm.ArcLength(path), corners),
        (sm.Concatenation([sm.Line([5, 0], [0, 0]), path]), corners),
        (sm.Transformed(path, 2.0, 0.5, [1, 2]), moved),
        (sm.Placed(path, {"translation": [1, 2, 3]}), np.column_stack([np.add(corners, [1, 2]), np.full(4, 3.0)])),
    ):
        np.testing.assert_allclose(made(made.waypoints), wanted, atol=1e-12)


@pytest.mark.parametrize("kind", ["bezier", "clothoid", "line", "lissajous", "rose", "waypoints", "pose_waypoints"])
def test_what_a_path_is_printed_as_makes_it_again(kind):
    path, r = EXAMPLES[kind], np.linspace(0, 1, 21)
    again = eval(repr(path), {made.__name__: made for made in PATHS.values()})
    np.testing.assert_allclose(again(r), path(r), atol=1e-14)


def test_concatenation_shares_r_by_length():
    path = sm.Concatenation([sm.Line([0, 0], [3, 0]), sm.Line([3, 0], [3, 1])])
    np.testing.assert_allclose(path.breaks, [0.75])
    np.testing.assert_allclose(np.hypot(*path([0.2, 0.9], 1).T), 4.0)


@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=2, max_size=6))
def test_any_two_different_points_make_a_bezier_or_a_clear_error(points):
    if len(set(points)) == 1:
        with pytest.raises(sm.InvalidInputError):
            sm.Bezier(points)
    else:
        assert np.isfinite(sm.Bezier(points)(np.linspace(0, 1, 11))).all()


BAD = {
    "one control point": lambda: sm.Bezier([[1, 2]]),
    "no control point": lambda: sm.Bezier([]),
    "coinciding control points": lambda: sm.Bezier([[1, 2], [1, 2]]),
    "too many control points": lambda: sm.Bezier(np.random.default_rng(0).random((1001, 2))),
    "four dimensions": lambda: sm.Bezier([[1, 2, 3, 4], [4, 5, 6, 7]]),
    "one end in space": lambda: sm.Line([1, 2, 3], [4, 5]),
    "NaN": lambda: sm.Bezier([[1, 2], [np.nan, 2]]),
    "huge": lambda: sm.Bezier([[1, 2], [1e300, 2]]),
    "text": lambda: sm.Line(["1", "2"], [3, 4]),
    "no length": lambda: sm.Line([1, 2], [1, 2]),
    "radius": lambda: sm.Circle([0, 0], 0),
    "negative radius": lambda: sm.Ellipse([0, 0], [1, -1]),
    "no sweep": lambda: sm.Arc([0, 0], 1, 0.0, 0.0),
    "nothing oscillates": lambda: sm.Lissajous([0, 0], [1, 1], [0, 0]),
    "repeated waypoint": lambda: sm.Waypoints([[0, 0], [1, 1], [1, 1]]),
    "unknown interpolation": lambda: sm.Waypoints([[0, 0], [1, 1]], "cubic"),
    "gap": lambda: sm.Concatenation([sm.Line([0, 0], [1, 0]), sm.Line([2, 0], [3, 0])]),
    "a part too short for an r": lambda: sm.Concatenation([sm.Line([0, 0], [1e9, 0]), sm.Line([1e9, 0], [1e9, 1e-8])]),
    "one waypoint": lambda: sm.Waypoints([[0, 0]]),
    "waypoints too close": lambda: sm.Waypoints([[0, 0], [1e9, 0], [1e9, 1e-8]]),
    "no parts": lambda: sm.Concatenation([]),
    "clothoid scale": lambda: sm.Clothoid([0, 0], 0, [0, 1], [0, 1]),
    "clothoid range": lambda: sm.Clothoid([0, 0], 1, [0, 1], [1, 1]),
    "clothoid wild": lambda: sm.Clothoid([0, 0], 1, [0, 1e30], [0, 1]),
    "clothoid overflow": lambda: sm.Clothoid([0, 0], 1, [0, 1e99, 1e99, 1e99], [0, 1e99]),
    "clothoid of too many powers": lambda: sm.Clothoid([0, 0], 1, [0.1] * 21, [0, 1]),
    "clothoid empty": lambda: sm.Clothoid([0, 0], 1, [], [0, 1]),
    "negative scale": lambda: sm.Transformed(sm.Circle([0, 0], 1), scale=-1),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_paths_are_refused_by_field(case):
    with pytest.raises(sm.InvalidInputError) as caught:
        BAD[case]()
    assert caught.value.field
    assert caught.value.remedy


def test_derivatives_of_a_high_degree_bezier():
    """Above degree 24 another sum is used; its derivatives are checked against differences of its positions."""
    points = np.random.default_rng(1).normal(size=(41, 2))
    path, r, h = sm.Bezier(points), np.linspace(0.05, 0.95, 50), 1e-5
    slope = (path(r + h) - path(r - h)) / (2 * h)
    np.testing.assert_allclose(path(r, 1), slope, atol=1e-5)
    bend = (path(r + h, 1) - path(r - h, 1)) / (2 * h)
    np.testing.assert_allclose(path(r, 2), bend, atol=1e-4)
    np.testing.assert_allclose(path([0.0, 1.0]), points[[0, -1]], atol=1e-12)


class Torn(Path):
    """A line whose points are no numbers from 0.4 to 0.6, or whose derivatives are not."""

    kind = "torn"

    def __init__(self, order=0):
        self.order = order

    def _evaluate(self, r, order):
        values = sm.Line([0, 0], [1, 0])(r, order)
        return np.where(((r > 0.4) & (r < 0.6) & (order == self.order))[:, None], np.nan, values)


@pytest.mark.parametrize(("order", "name"), [(0, "point"), (1, "first derivative"), (2, "second derivative")])
def test_a_curve_that_is_no_number_somewhere_says_where(order, name):
    path = Torn(order)
    assert np.isfinite(path([0.1, 0.4, 0.6], order)).all()
    with pytest.raises(InvalidInputError, match=f"path: has no finite {name} at r = 0.45"):
        path([0.1, 0.45, 0.5], order)
