"""Pictures of searches: medians and quartiles are those of the runs."""

import numpy as np
import pytest

from selfmotion.plot import draw_evolution, draw_spread, figure
from selfmotion.plot.evolution import FLOOR

BEST = np.array([[5.0, 3.0, 1.0], [4.0, 4.0, 4.0], [9.0, 2.0, 2.0], [7.0, 6.0, 1.5], [6.0, 1.0, 1.0]])


def test_one_search_is_a_line_without_a_band():
    with figure() as (_, (axes,)):
        draw_evolution(axes, {"PSO": [3.0, 2.0, 2.0]})
        np.testing.assert_array_equal(axes.lines[0].get_xydata(), [[1, 3], [2, 2], [3, 2]])
        assert not axes.collections
        assert axes.get_yscale() == "linear"


def test_many_searches_are_their_median_between_their_quartiles():
    with figure() as (_, (axes,)):
        draw_evolution(axes, {"PSO": BEST})
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), [6, 3, 1.5])
        vertices = axes.collections[0].get_paths()[0].vertices
        for iteration, low, high in ((1, 5, 7), (2, 2, 4), (3, 1, 2)):
            at = vertices[vertices[:, 0] == iteration, 1]
            assert (at.min(), at.max()) == (low, high)


def test_excess_is_measured_from_the_optimum_and_ends_at_rounding():
    with figure() as (_, (axes,)):
        draw_evolution(axes, {"PSO": BEST}, optimum=1.5, beside={"GA": BEST + 1})
        grey, own = axes.lines
        np.testing.assert_array_equal(own.get_ydata(), [4.5, 1.5, FLOOR])
        np.testing.assert_array_equal(grey.get_ydata(), [5.5, 2.5, 1.0])
        assert axes.get_yscale() == "log"


def test_a_search_without_a_result_yet_ranks_behind_all_others():
    best = BEST.copy()
    best[:3, 0] = best[0, 1] = np.nan
    with figure() as (_, (axes,)):
        draw_evolution(axes, {"PSO": best})
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), [np.nan, 4, 1.5])
        draw_evolution(axes, {"PSO": best}, optimum=1.0)
        np.testing.assert_array_equal(axes.lines[1].get_ydata(), [np.nan, 3, 0.5])


@pytest.mark.parametrize("shape", [(5,), (2,), (1,)])
def test_spread_shows_every_run_and_its_quartiles(shape):
    values = np.geomspace(1e-9, 1e-3, *shape)
    with figure() as (_, (axes,)):
        draw_spread(axes, {"plain": {"GA": values, "PSO": values / 10}, "shifted": {"GA": values, "PSO": 0 * values}})
        runs, bars, marks = axes.lines[0::3], axes.lines[1::3], axes.lines[2::3]
        np.testing.assert_array_equal(runs[0].get_xdata(), values)
        np.testing.assert_allclose(bars[0].get_xdata(), np.percentile(values, [25, 75]))
        assert marks[1].get_xdata()[0] == np.median(values / 10)
        assert (runs[3].get_xdata() == FLOOR).all()
        assert [label.get_text() for label in axes.get_yticklabels()] == ["GA", "PSO"]
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["plain", "shifted"]
        rows = [mark.get_ydata()[0] for mark in marks]
        assert rows[0] < rows[2] < rows[1] < rows[3]  # GA plain, GA shifted, PSO plain, PSO shifted, from the top
        assert np.abs(runs[0].get_ydata() - rows[0]).max() < 0.2
