"""A sampled motion, its broken steps marked: the seed's Fig. 1 and, repaired, Fig. 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.breaks import Break
from selfmotion.plot.obstacles import draw_links, in_view
from selfmotion.plot.path import draw_path
from selfmotion.plot.plane import draw_base, draw_chain, frame
from selfmotion.plot.style import COLORS, DASHES, shades
from selfmotion.problem import Problem

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POSTURES = 13
_MOST_MARKED = 6


def draw_samples(axes: Axes, problem: Problem, r: FloatArray, q: FloatArray, breaks: Sequence[Break] = ()) -> None:
    """Draw postures of a sampled motion, light to dark, and in colour those at breaks of n-connectivity (Fig. 1a, 2a).

    Parameters
    ----------
    axes : Axes
    problem : Problem
    r : array, shape (k,)
    q : array, shape (k, n)
    breaks : sequence of Break, optional
        At most six are marked, spread over all: the postures before and after a broken step, or a bad row's own.
    """
    draw_path(axes, problem)
    rows = np.unique(np.searchsorted(r, np.linspace(r[0], r[-1], _POSTURES)).clip(0, len(r) - 1))
    points = problem.arm.joint_positions(q[rows])
    for chain, color in zip(points, shades(len(rows)), strict=True):
        draw_links(axes, problem.arm, chain, color=color)
        draw_chain(axes, chain, color=color)
    chosen = np.linspace(0, len(breaks) - 1, min(len(breaks), _MOST_MARKED)).astype(int)
    marked = [breaks[k] for k in chosen]
    shown = [points.reshape(-1, 2)]
    for found in marked:
        for row, dash in ((found.row - 1, "-"), (found.row, DASHES[1]))[: 2 if found.is_step else 1]:
            chain = problem.arm.joint_positions(q[row])
            draw_chain(axes, chain, color=COLORS[1], linestyle=dash, linewidth=1.3, zorder=4)
            shown.append(chain)
    draw_base(axes)
    frame(axes, np.vstack([*shown, problem.path(np.linspace(0, 1, 201)), in_view(problem.arm)]))
    count = f"{len(breaks)} break{'s' * (len(breaks) > 1)}"
    axes.set_title(
        (count if len(marked) == len(breaks) else f"{count}, {len(marked)} marked") if breaks else "connected"
    )


def draw_sampled_joints(
    axes: Axes, problem: Problem, r: FloatArray, q: FloatArray, breaks: Sequence[Break] = ()
) -> None:
    """Draw the joint angles of a sampled motion, its breaks as bands (Fig. 1b, 2b).

    Parameters
    ----------
    axes : Axes
    problem : Problem
    r : array, shape (k,)
    q : array, shape (k, n)
    breaks : sequence of Break, optional
    """
    q = problem.arm.limits.continuous(q)
    last = len(r) - 1
    for found in breaks:
        low, high = found.row - 1, min(found.row, last)
        half = 0.004  # a step between dense rows must still be seen
        middle = 0.5 * (r[low] + r[high])
        axes.axvspan(min(r[low], middle - half), max(r[high], middle + half), color="#f3d9c9", linewidth=0)
    for joint, series in enumerate(q.T):
        axes.plot(
            r, series, color=COLORS[joint % len(COLORS)], linestyle=DASHES[joint % len(DASHES)], label=f"θ{joint + 1}"
        )
    axes.set_xlim(0, 1)
    axes.margins(y=0.08)
    axes.set_xlabel("path parameter r")
    axes.set_ylabel("joint angle [rad]")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, handlelength=3, borderaxespad=0.2)
