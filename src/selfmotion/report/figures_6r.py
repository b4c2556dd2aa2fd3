"""The figures of the 6R study. A new one is one entry in `FIGURES_6R`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from selfmotion import plot
from selfmotion.plot.style import COLUMN
from selfmotion.report import seed_6r
from selfmotion.report.cases import PAPER
from selfmotion.report.figure import ReportFigure
from selfmotion.report.search_figures import COLUMNS, ROWS, evolution, excess, spread
from selfmotion.report.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_CASES = (seed_6r.FIXED.name, seed_6r.MOVING.name)


def _modules(study: Study, axes: Axes) -> None:
    plot.draw_modules(axes, study.six.plan, [study.six.base])


def _module_domains(study: Study, *panels: Axes) -> None:
    grid = study.six.problem.grid
    for module, axes in enumerate(panels):
        curves = {}
        for label in PAPER:
            plan = study.six.absolute[label]
            f = plan.parameters["modules"][module]["f"]
            curves[f"{label}, f = {f:.4f}"] = (grid, plan.u(grid)[:, 3 * module])  # the last link of each module
        plot.draw_domain(axes, study.six.domains[module], 0, curves)
        axes.set_title(f"{_CASES[module]}, {study.six.domains[module].self_motion.branches[0]} elbow")


def _module_joints(joints: Sequence[int], absolute: Sequence[int] = ()) -> Callable[[Study, Axes], None]:
    def draw(study: Study, axes: Axes) -> None:
        plot.draw_joints(axes, study.six.plan, joints, absolute)

    return draw


def _postures(study: Study, axes: Axes) -> None:
    plot.draw_postures(axes, study.six.plan)


FIGURES_6R = (
    ReportFigure(
        "fig13_modules",
        "Fig. 13",
        "The arm of two modules on its way along the clothoid, by the motion that {six[best]} found: the second "
        "module is an arm of its own in a frame that moves with its base.",
        "The arm from its base to the clothoid, its two modules in two colours, with axes at the base of each",
        _modules,
        height=2.6,
    ),
    ReportFigure(
        "fig14_domains",
        "Fig. 14a, b",
        "The angle domain of each module in the frame of its base, and in it the sinusoids that the paper's three "
        "optimizers found with seed {seed}.",
        "Two regions of feasible directions of a module's last link along its path, with three sinusoids in each",
        _module_domains,
        width=2 * COLUMN,
        height=3.0,
        columns=2,
    ),
    *(
        figure
        for number, name in zip(("Fig. 15", "Fig. 16"), _CASES, strict=True)
        for figure in (
            ReportFigure(
                f"{number.replace('. ', '').lower()}_evolution",
                number,
                f"Fitness evolution of the module on the {name}: the least F so far, median and quartiles over "
                "{seeds} seeds. A line begins where half of the runs have found something feasible.",
                "A panel per optimizer: the least F falls with the iterations towards the optimum",
                evolution(name),
                height=4.2,
                columns=COLUMNS,
                rows=ROWS,
            ),
            ReportFigure(
                f"{number.replace('. ', '').lower()}_excess",
                number,
                "The same as excess over the dense-scan optimum, on a logarithmic scale. What is nearer than "
                "rounding is drawn at the lower end.",
                "A panel per optimizer: how the excess over the optimum falls with the iterations, on a "
                "logarithmic scale",
                excess(name),
                height=4.2,
                columns=COLUMNS,
                rows=ROWS,
            ),
        )
    ),
    ReportFigure(
        "seeds_spread_modules",
        "",
        "How far each optimizer ends from the dense-scan optimum of each module over {seeds} seeds, drawn as for "
        "the smaller arm.",
        "Per module and optimizer the final excess over the optimum of all runs on a logarithmic axis, plain above "
        "shifted",
        spread(*_CASES),
        width=2 * COLUMN,
        height=3.0,
        columns=2,
    ),
    ReportFigure(
        "fig17a_joints",
        "Fig. 17a",
        "Joint angles of the module on the fixed base, motion found by {six[best]}.",
        "Three joint angles against the path parameter",
        _module_joints(range(3)),
    ),
    ReportFigure(
        "fig17b_joints",
        "Fig. 17b",
        "Joint angles of the module on the moving base, the first of them as the paper has it: absolute, the "
        "direction of the link.",
        "Three joint angles against the path parameter, the first labelled as absolute",
        _module_joints(range(3, 6), [3]),
    ),
    ReportFigure(
        "fig17b_true",
        "Fig. 17b",
        "The same in true joint angles: what the motors turn.",
        "Three joint angles against the path parameter",
        _module_joints(range(3, 6)),
    ),
    ReportFigure(
        "fig17c_postures",
        "Fig. 17c",
        "Postures of the whole arm along the clothoid.",
        "The arm of six links drawn at several places along the path, light at the start and dark at the end",
        _postures,
        height=2.6,
    ),
)
"""In the order of the report."""
