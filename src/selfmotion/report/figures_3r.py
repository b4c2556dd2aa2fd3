"""The figures of the 3R study. A new one is one entry in `FIGURES_3R`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from selfmotion import plot
from selfmotion.arms import PlanarArm
from selfmotion.domain import angle_domain
from selfmotion.plot.style import COLUMN
from selfmotion.report import seed_3r
from selfmotion.report.cases import PAPER
from selfmotion.report.figure import ReportFigure
from selfmotion.report.search_figures import COLUMNS, ROWS, evolution, excess, spread
from selfmotion.report.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def _improper(study: Study, postures: Axes, joints: Axes) -> None:
    breaks = study.three.repaired.breaks
    plot.draw_samples(postures, study.three.free, *study.three.improper, breaks)
    plot.draw_sampled_joints(joints, study.three.free, *study.three.improper, breaks)


def _repaired(study: Study, postures: Axes, joints: Axes) -> None:
    plot.draw_samples(postures, study.three.free, study.three.repaired.r, study.three.repaired.q)
    plot.draw_sampled_joints(joints, study.three.free, study.three.repaired.r, study.three.repaired.q)


def _workspace(study: Study, axes: Axes) -> None:
    free = study.three.free
    assert isinstance(free.arm, PlanarArm)
    plot.draw_workspace(axes, free.arm, free.path)


def _extremes(study: Study, axes: Axes) -> None:
    plot.draw_extreme_postures(axes, study.three.free)


def _interval(study: Study, axes: Axes) -> None:
    plot.draw_posture_interval(axes, study.three.free)


def _sweep(branch: int) -> Callable[[Study, Axes], None]:
    def draw(study: Study, axes: Axes) -> None:
        plot.draw_sweep(axes, study.three.free, branch=branch)

    return draw


def _free_path(study: Study, axes: Axes) -> None:
    plot.draw_path(axes, study.three.free)


def _free_domain(study: Study, axes: Axes) -> None:
    plot.draw_domain(axes, angle_domain(study.three.free.arm, study.three.free.path), 0)


def _causes(study: Study, *panels: Axes) -> None:
    for branch, axes in enumerate(panels):
        plot.draw_domain(axes, study.three.limited, branch, causes=True)


def _path(study: Study, axes: Axes) -> None:
    plot.draw_path(axes, study.three.problem)


def _domain(study: Study, axes: Axes) -> None:
    grid = study.three.problem.grid
    curves = {
        f"{label}, f = {study.three.plans[label].parameters['f']:.4f}": (grid, study.three.plans[label].u(grid)[:, 0])
        for label in PAPER
    }
    plot.draw_domain(axes, study.three.domain, 0, curves)


def _joints(study: Study, axes: Axes) -> None:
    plot.draw_joints(axes, study.three.plans[study.three.best])


def _postures(study: Study, axes: Axes) -> None:
    plot.draw_postures(axes, study.three.plans[study.three.best])


FIGURES_3R = (
    ReportFigure(
        "fig1_improper",
        "Fig. 1",
        "Connectivity failure: the elbow flips to the other side and back. In colour the postures before (solid) "
        "and after (dashed) each broken step, which bands mark in the joint angles.",
        "Left the arm along the path with two flips of its elbow, right its joint angles, which jump twice",
        _improper,
        width=2 * COLUMN,
        height=3.2,
        columns=2,
    ),
    ReportFigure(
        "fig2_repaired",
        "Fig. 2",
        "The same motion repaired by self-motion: the postures in between are replaced.",
        "Left the arm along the path with its elbow on one side, right its joint angles, which are smooth",
        _repaired,
        width=2 * COLUMN,
        height=3.2,
        columns=2,
    ),
    ReportFigure(
        "fig3_workspace",
        "Fig. 3",
        "The nearest maximum reachable workspace (shaded), the co-regular circles (dashed), and the path.",
        "Circles around the base: the rim of the reach, the inner rim of the shaded ring, dashed ones inside it",
        _workspace,
        height=2.8,
    ),
    ReportFigure(
        "fig4_extremes",
        "Fig. 4",
        "The maximum posture A and the minimum posture B of the arm without limits at the start of the path, and "
        "the angles from which they follow.",
        "Two postures of the arm that reach the same point, stretched to either side, with their angles marked",
        _extremes,
        height=3.2,
    ),
    ReportFigure(
        "fig5a_interval",
        "Fig. 5a",
        "Joint angles of both elbows over the whole feasible interval at the start of the path.",
        "Joint angles against the direction of the last link; the curves of the two elbows meet at both ends",
        _interval,
    ),
    ReportFigure(
        "fig5b_sweep",
        "Fig. 5b",
        "Postures of the positive elbow at the start of the path, from the minimum (light) to the maximum (dark).",
        "A fan of postures of the arm that all reach the same point",
        _sweep(0),
        height=3.0,
    ),
    ReportFigure(
        "fig5c_sweep",
        "Fig. 5c",
        "The same for the negative elbow.",
        "A fan of postures of the arm that all reach the same point, its elbow on the other side",
        _sweep(1),
        height=3.0,
    ),
    ReportFigure(
        "fig6a_path",
        "Fig. 6a",
        "A path of the tool.",
        "A smooth curve in the plane that crosses itself once and forms a loop, its start and end marked",
        _free_path,
        height=2.8,
    ),
    ReportFigure(
        "fig6b_domain",
        "Fig. 6b",
        "The angle domain of the arm without limits along this path. Both elbows have the same: folds bound it.",
        "A region between two smooth lines, the least and the largest direction of the last link along the path",
        _free_domain,
    ),
    ReportFigure(
        "domain_causes",
        "",
        "The angle domain of the same arm and path with limits of our own, {limited[limits]}, and what bounds it. "
        "The path has {limited[events]} events: {limited[kinds]}. With both elbows its start and end are "
        "{limited[connected]}; connected parts: {limited[components]}.",
        "For each elbow a region cut by limits, every part of its boundary in its own colour and dash, with marks "
        "where parts open, close, split and merge",
        _causes,
        width=2 * COLUMN,
        height=3.7,
        columns=2,
    ),
    ReportFigure(
        "fig10a_path",
        "Fig. 10a",
        "The fifth-degree Bezier curve that the tool follows.",
        "A smooth curve in the plane that crosses itself once and forms a loop, its start and end marked",
        _path,
        height=2.8,
    ),
    ReportFigure(
        "fig10b_domain",
        "Fig. 10b",
        "The angle domain of the positive elbow, and in it the sinusoids that the paper's three optimizers found "
        "with seed {seed}. Where they found the same frequency, the curves lie on each other.",
        "The region of feasible directions of the last link along the path, with three sinusoids inside it",
        _domain,
        height=3.0,
    ),
    ReportFigure(
        "fig11_evolution",
        "Fig. 11",
        "Fitness evolution on the plain problem: the least F so far, median and quartiles over {seeds} seeds.",
        "A panel per optimizer: the least F falls with the iterations towards the optimum",
        evolution(seed_3r.CASE.name),
        height=4.2,
        columns=COLUMNS,
        rows=ROWS,
    ),
    ReportFigure(
        "fig11_excess",
        "Fig. 11",
        "The same as excess over the dense-scan optimum, on a logarithmic scale, where the optimizers differ. "
        "What is nearer than rounding is drawn at the lower end.",
        "A panel per optimizer: how the excess over the optimum falls with the iterations, on a logarithmic scale",
        excess(seed_3r.CASE.name),
        height=4.2,
        columns=COLUMNS,
        rows=ROWS,
    ),
    ReportFigure(
        "seeds_spread",
        "",
        "How far each optimizer ends from the dense-scan optimum over {seeds} seeds, on the problem (plain) and on "
        "its copy with shifted variable. Mark: median; bar: quartiles; faint dots: single runs. What is nearer "
        "than rounding is drawn at the left end.",
        "Per optimizer the final excess over the optimum of all runs on a logarithmic axis, plain above shifted",
        spread(seed_3r.CASE.name),
        height=3.0,
    ),
    ReportFigure(
        "fig12a_joints",
        "Fig. 12a",
        "Joint angles of the best motion, found by {best}.",
        "Three joint angles against the path parameter",
        _joints,
    ),
    ReportFigure(
        "fig12b_postures",
        "Fig. 12b",
        "Postures of the best motion.",
        "The arm drawn at several places along the path, light at the start and dark at the end",
        _postures,
        height=3.2,
    ),
)
"""In the order of the report."""
