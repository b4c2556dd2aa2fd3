"""The angle domain as a picture: feasible u against r, what bounds it, and what happens along the path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import Cause
from selfmotion.domain import AngleDomain, Event, SampledDomain
from selfmotion.domain.strips import strips
from selfmotion.plot.holes import fill_holes, in_window
from selfmotion.plot.style import COLORS, DASHES, INK, REGION
from selfmotion.plot.window import Window

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes

_BELOW = -0.42  # where the legend begins, below the axes [inch]
_SMALL, _LARGE = 3.5, 7.5
_HOLLOW: dict[str, Any] = {"markerfacecolor": "white", "markersize": _SMALL}
_FULL: dict[str, Any] = {"markerfacecolor": INK, "markersize": _SMALL}
_RING: dict[str, Any] = {"markerfacecolor": "none", "markersize": _LARGE}
_MARKS: dict[str, tuple[str, dict[str, Any]]] = {
    "opens": ("interval opens", {"marker": "<", **_HOLLOW}),
    "closes": ("interval closes", {"marker": ">", **_HOLLOW}),
    "splits": ("interval splits", {"marker": "<", **_FULL}),
    "merges": ("intervals merge", {"marker": ">", **_FULL}),
    "component appears": ("component appears", {"marker": "o", **_RING}),
    "component dies": ("component dies", {"marker": "s", **_RING}),
    "singular": ("joint free", {"marker": "*", "markerfacecolor": "white", "markersize": 6.0}),
}
"""Marks of events by kind, with their name; a triangle points left where something begins and right where it ends: a
hollow one an interval, a full one a gap."""


def draw_domain(
    axes: Axes,
    domain: AngleDomain,
    branch: int,
    curves: Mapping[str, tuple[FloatArray, FloatArray]] | None = None,
    causes: bool = False,
) -> None:
    """Draw the angle domain of one branch, and motions through it (Fig. 6b and 10b).

    Parameters
    ----------
    axes : Axes
    domain : AngleDomain
        Of an arm with constraints the domain that joint limits leave is drawn, with the holes that constraints make.
    branch : int
    curves : mapping, optional
        Label to (r, u), both of shape (k,).
    causes : bool
        Whether to tell what bounds the domain and what happens along the path. A limit has its joint's colour, a lower
        one long dashes and an upper one short dashes, with one dot fewer between them than its joint's number. Folds
        are solid; where a limit coincides with one, the limit is shown.
    """
    free = domain.unconstrained
    shown = strips(free.structure, branch)
    holes = [] if free is domain else SampledDomain(domain, [branch]).holes(branch)
    window = Window.around(shown)
    values = [np.array([-np.pi, np.pi])] if not shown else []
    for strip in shown:
        for low, high in window.copies(strip):
            values += [low, high]
            if (high > low).any():
                axes.fill_between(strip.r, low, high, where=high > low, color=REGION, linewidth=0.3)
    boundary = window.boundary(shown)
    if causes:
        _draw_causes(axes, boundary)
        _draw_events(axes, free.structure.events, branch, window)
    else:
        for _, r, u in boundary:
            axes.plot(r, u, color=INK, linewidth=0.8)
    for k, (label, (r, u)) in enumerate((curves or {}).items()):
        near = window.near(u)
        values.append(near)
        axes.plot(r, near, color=COLORS[k % len(COLORS)], linestyle=DASHES[k % len(DASHES)], label=label)
    extent = np.concatenate(values)
    margin = 0.06 * max(float(np.ptp(extent)), 1e-3)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(extent.min() - margin, extent.max() + margin)
    fill_holes(axes, [(hole, *in_window(hole, window)) for hole in holes])
    axes.set_xlabel("path parameter r")
    axes.set_ylabel("redundancy parameter u [rad]")
    remark = ": empty" if not shown else "" if axes.collections else ": single postures only"
    axes.set_title(f"angle domain, {domain.self_motion.branches[branch]} elbow{remark}")
    if causes:
        legend_below(axes, 2 if holes else 3)  # names of holes are long
    elif curves:
        axes.legend(loc="best", handlelength=3)


def _draw_causes(axes: Axes, boundary: Sequence[tuple[tuple[Cause, ...], FloatArray, FloatArray]]) -> None:
    """Draw each part of the boundary in the look of its constraint, and name each constraint once."""
    curves: dict[Cause, list[tuple[FloatArray, FloatArray]]] = {}
    for causes, r, u in boundary:
        curves.setdefault(min(causes, key=_order), []).append((r, u))
    for cause in sorted(curves, key=_order):
        label: str | None = str(cause) if cause.kind == "fold" else f"θ{cause.joint + 1} {cause.kind}"
        for r, u in curves[cause]:
            axes.plot(r, u, label=label, **_look(cause))
            label = None


def _order(cause: Cause) -> tuple[bool, int, str, float]:
    return cause.kind == "fold", cause.joint, cause.kind, cause.value


def _look(cause: Cause) -> dict[str, Any]:
    if cause.kind == "fold":
        return {"color": INK, "linewidth": 0.6 if cause.value else 1.2}
    dash = 5.0 if cause.kind == "lower limit" else 2.0
    return {"color": COLORS[cause.joint % len(COLORS)], "linestyle": (0, (dash, 1.2, *(1.0, 1.2) * cause.joint))}


def _draw_events(axes: Axes, events: Sequence[Event], branch: int, window: Window) -> None:
    """Mark what happens on a branch."""
    mine = events_on(events, branch)
    for kind, (name, look) in _MARKS.items():
        places = np.array([(event.r, event.u) for event in mine if event.kind == kind])
        if len(places):
            u = window.wrapped(places[:, 1])
            axes.plot(
                places[:, 0], u, linestyle="none", color=INK, markeredgewidth=0.7, label=name, clip_on=False, zorder=4,
                **look,
            )  # fmt: skip


def events_on(events: Sequence[Event], branch: int) -> list[Event]:
    """Return what happens on a branch, and to parts of several branches where something happens on this one."""
    here = {(event.r, event.u) for event in events if event.branch == branch}
    return [
        event
        for event in events
        if event.branch == branch or (event.branch is None and (event.kind == "singular" or (event.r, event.u) in here))
    ]


def legend_below(axes: Axes, columns: int = 3) -> None:
    """Name lines and marks below the axis label."""
    from matplotlib.transforms import ScaledTranslation

    handles, labels = axes.get_legend_handles_labels()
    if handles:
        below = axes.transAxes + ScaledTranslation(0.0, _BELOW, axes.figure.dpi_scale_trans)
        axes.legend(
            handles, labels, loc="upper center", bbox_to_anchor=(0.43, 0.0), bbox_transform=below, ncols=columns,
            handlelength=2.3, columnspacing=0.8, handletextpad=0.4, borderaxespad=0.0,
        )  # fmt: skip
