"""The bound on every path's speed, against dense samples of its derivative."""

import numpy as np
import pytest
from test_paths import EXAMPLES, SQUARE

import selfmotion as sm
from selfmotion.paths import Path, Relative, Section
from selfmotion.paths.base import distance

MORE = {
    **EXAMPLES,
    "spline": sm.Waypoints(SQUARE, "spline"),
    "closed spline": sm.Waypoints([*SQUARE, SQUARE[0]], "spline"),
    "Bezier of degree 40": sm.Bezier(np.random.default_rng(1).normal(size=(41, 2))),
    "Bezier that stops": sm.Bezier([[0, 0], [0, 0], [1, 0], [1, 1], [1, 1]]),
    "long ellipse": sm.Ellipse([0, 0], [0.1, 3.0], start_angle=0.2, sweep=-11.0),
    "even rose": sm.Rose([0, 0], 2.0, 0.4, sweep=3.0),
    "still in y": sm.Lissajous([0, 0], [1, 1], [2, 0]),
    "relative": Relative(EXAMPLES["bezier"], EXAMPLES["circle"]),
    "section": Section(EXAMPLES["bezier"], (0.2, 0.55)),
    "section of a spline": Section(sm.Waypoints(SQUARE, "spline"), (0.1, 0.9)),
}
SHARP = [kind for kind in MORE if kind != "relative"]


def fastest_sample(path, low, high):
    r = np.linspace(low, high, 401)
    near = [at + side for at in path.breaks for side in (-1e-12, 0.0, 1e-12)]
    inside = [at for at in near if low <= at <= high]
    return distance(path(np.append(r, inside), 1)).max()


def parts(rng):
    yield 0.0, 1.0
    for width in (0.5, 0.1, 0.01, 1e-4):
        for _ in range(15):
            low = rng.uniform(0.0, 1.0 - width)
            yield low, low + width
    for at in (0.0, 0.3, 1.0):
        yield at, at


@pytest.mark.parametrize("kind", MORE)
def test_no_sample_is_faster_than_the_bound(kind):
    path, rng = MORE[kind], np.random.default_rng(3)
    for low, high in parts(rng):
        assert path.fastest(low, high) >= fastest_sample(path, low, high), (low, high)
    for at in path.breaks:
        assert path.fastest(at, at) >= fastest_sample(path, max(at - 1e-13, 0.0), at)


@pytest.mark.parametrize("kind", SHARP)
def test_the_bound_is_sharp_on_narrow_parts(kind):
    path, rng = MORE[kind], np.random.default_rng(4)
    overall = distance(path(path.grid(500), 1)).max()
    for low, high in parts(rng):
        if 0 < high - low < 0.011 and not ((low <= path.breaks) & (path.breaks <= high)).any():
            assert path.fastest(low, high) <= fastest_sample(path, low, high) + 0.05 * overall


@pytest.mark.parametrize("kind", MORE)
def test_the_tool_stays_within_the_bound_of_the_middle(kind):
    path, rng = MORE[kind], np.random.default_rng(5)
    for low, high in parts(rng):
        away = path(np.linspace(low, high, 101)) - path(0.5 * (low + high))
        assert distance(away).max() <= 0.5 * (high - low) * path.fastest(low, high) + 1e-12 * path.extent


def test_a_part_that_is_none_is_refused():
    path = EXAMPLES["line"]
    for low, high in ((0.5, 0.4), (-0.1, 0.5), (0.5, 1.1), (np.nan, 1.0)):
        with pytest.raises(sm.InvalidInputError):
            path.fastest(low, high)


def test_a_path_without_a_bound_says_so():
    class Still(Path):
        kind = "still"

        def _evaluate(self, r, order):
            return np.zeros((len(r), 2))

    with pytest.raises(sm.InvalidInputError, match="bounds its speed nowhere"):
        Still().fastest(0.0, 1.0)


def test_a_section_is_a_part_of_its_path():
    path = EXAMPLES["concatenation"]
    part, r = Section(path, (0.2, 0.8)), np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(part(r), path(0.2 + 0.6 * r), atol=1e-15)
    h = 1e-6
    inner = r[1:-1][np.abs(r[1:-1, None] - part.breaks).min(axis=1) > 2 * h]
    np.testing.assert_allclose(part(inner, 1), (part(inner + h) - part(inner - h)) / (2 * h), atol=1e-7)
    np.testing.assert_allclose(0.2 + 0.6 * part.breaks, path.breaks)
    for bad in ((0.5, 0.5), (0.6, 0.2), (-0.1, 0.5), (0.5, 1.2)):
        with pytest.raises(sm.InvalidInputError):
            Section(path, bad)
