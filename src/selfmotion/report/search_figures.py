"""Drawings of the optimizers over many seeds, for any case of the paper."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from selfmotion import plot
from selfmotion.report.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS, ROWS = 2, 3
"""Of the panels of one case: the optimizers, and the key."""


def evolution(case: str) -> Callable[..., None]:
    """Return what draws the least F so far on a case, a panel per optimizer."""

    def draw(study: Study, *panels: Axes) -> None:
        _panels(study, case, panels, None)

    return draw


def excess(case: str) -> Callable[..., None]:
    """Return what draws the same as excess over the dense-scan optimum."""

    def draw(study: Study, *panels: Axes) -> None:
        _panels(study, case, panels, study.cases[case].scan.fitness)

    return draw


def _panels(study: Study, case: str, panels: tuple[Axes, ...], optimum: float | None) -> None:
    """Draw a panel per optimizer, all to one scale, the medians of the others in grey."""
    best = {label: runs.best for label, runs in study.cases[case].runs["plain"].items()}
    for axes, label in zip(panels, best, strict=False):
        others = {other: values for other, values in best.items() if other != label}
        plot.draw_evolution(axes, {label: best[label]}, optimum, others)
        axes.set_title(label)
        if optimum is None:  # most of the way is made in the first few iterations
            axes.set_xscale("log")
            axes.set_xticks([1, 10, 100], ["1", "10", "100"])
    shown = panels[: len(best)]
    extents = [axes.get_ylim() for axes in shown]
    for k, axes in enumerate(shown):
        axes.set_ylim(min(low for low, _ in extents), max(high for _, high in extents))
        axes.label_outer()
        if k + COLUMNS >= len(shown):  # nothing below it
            axes.set_xlabel("iteration")
            axes.tick_params(labelbottom=True)
    for axes in panels[len(best) :]:
        axes.set_axis_off()
        key = f"line: median\nband: quartiles\nof {study.seeds} seeds\ngrey: the others'\nmedians"
        axes.text(0.1, 0.5, key, transform=axes.transAxes, va="center")


def spread(*names: str) -> Callable[..., None]:
    """Return what draws how far the runs end from the optimum, a panel per case."""

    def draw(study: Study, *panels: Axes) -> None:
        for name, axes in zip(names, panels, strict=True):
            case = study.cases[name]
            optimum = case.scan.fitness
            ends = {
                copy: {label: runs.fitness - optimum for label, runs in rows.items()}
                for copy, rows in case.runs.items()
            }
            plot.draw_spread(axes, ends)
            if len(names) > 1:
                axes.set_title(name, loc="right")

    return draw
