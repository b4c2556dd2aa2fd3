"""Joint angles along the path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion.angles import TAU
from selfmotion.arms.protocols import u_period
from selfmotion.plans import Plan
from selfmotion.plot.style import BEYOND, COLORS, DASHES, GREY, shades

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_TOLD_APART = 8  # joints that have a colour and dashes of their own
_BEYOND = 0.08  # how much of what is beyond a limit is shown, in parts of the range
_NAME_HEIGHT = 8.0  # that a limit's name needs [points]
_NAMED = 5  # of more joints, which are shades from the base to the tool


def draw_joints(axes: Axes, plan: Plan, joints: Sequence[int] | None = None, absolute: Sequence[int] = ()) -> None:
    """Draw joint angles against r between their limits (Fig. 12a, 17a and 17b).

    The axis reaches to every limit within a turn of the motion; joints with others are named below.

    Parameters
    ----------
    axes : Axes
    plan : Plan
    joints : sequence of int, optional
        Which, counted from 0; all of them if it is not given.
    absolute : sequence of int
        Joints of a planar arm that are drawn as the direction of their link: as the sum of all angles up to theirs.
    """
    r = plan.problem.rows
    q = plan(r)
    drawn = list(range(q.shape[1]) if joints is None else joints)
    series = {joint: q[:, : joint + 1].sum(axis=1) if joint in absolute else q[:, joint] for joint in drawn}
    limits = plan.problem.arm.limits
    low, high = (float(end(list(map(end, series.values())))) for end in (min, max))
    shown: dict[float, list[str]] = {}
    beyond: dict[str, None] = {}  # names, in their order
    many = len(drawn) > _MOST_TOLD_APART
    named = {drawn[k] for k in np.linspace(0, len(drawn) - 1, _NAMED).astype(int)} if many else set(drawn)
    greys = dict(zip(drawn, shades(len(drawn)), strict=True))
    for joint, values in series.items():
        name = f"{'q' if limits.slides[joint] else 'θ'}{joint + 1}"
        label = None if joint not in named else f"{name} absolute" if joint in absolute else name
        dashes = DASHES[(joint + joint // len(COLORS)) % len(DASHES)]  # where colours come again, others
        look: dict[str, Any] = {"color": COLORS[joint % len(COLORS)], "linestyle": dashes}
        axes.plot(r, values, label=label, **({"color": greys[joint], "linewidth": 0.8} if many else look))
        for bound in () if joint in absolute else (limits.lower[joint], limits.upper[joint]):
            if low - TAU <= bound <= high + TAU:
                shown.setdefault(float(bound), []).append(name)
            elif np.isfinite(bound):
                beyond[name] = None
    axes.set_xlim(0, 1)
    axes.margins(y=0.08)
    _name_limits(axes, shown)
    names = list(beyond)[:_NAMED] + ["…"] * (len(beyond) > _NAMED)
    axes.set_xlabel("path parameter r" + (f"\nnot shown: limits of {', '.join(names)}" if beyond else ""))
    axes.set_ylabel("joint angle [rad], rail [m]" if limits.slides.any() else "joint angle [rad]")
    layout: dict[str, Any] = {"ncols": 4, "handlelength": 3}
    if many:
        layout = {"ncols": _NAMED, "handlelength": 1.5, "columnspacing": 1.2}
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2, **layout)


def draw_each_joint(panels: Sequence[Axes], plan: Plan) -> None:
    """Draw every joint angle against r in a panel of its own, between its limits, for arms whose limits are many.

    Parameters
    ----------
    panels : sequence of Axes
        One per joint, in their order. The panels of limited joints show their whole range, and grey what is beyond it.
    plan : Plan
    """
    r = plan.problem.rows
    limits = plan.problem.arm.limits
    for joint, (axes, values) in enumerate(zip(panels, plan(r).T, strict=True)):
        axes.plot(r, values, color=COLORS[0])
        axes.set_xlim(0, 1)
        axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
        axes.set_title(f"rail, q{joint + 1} [m]" if limits.slides[joint] else f"θ{joint + 1} [rad]")
        low, high = limits.lower[joint], limits.upper[joint]
        if np.isfinite([low, high]).all():
            margin = _BEYOND * (high - low)
            axes.set_ylim(low - margin, high + margin)
        else:
            axes.margins(y=0.08)
        bottom, top = axes.get_ylim()
        for inner, outer in ((low, bottom), (high, top)):
            if bottom <= inner <= top:
                axes.axhspan(inner, outer, color=BEYOND, linewidth=0)
                axes.axhline(inner, color=GREY, linewidth=0.6)
        axes.set_ylim(bottom, top)


def draw_parameter(axes: Axes, plan: Plan) -> None:
    """Draw the redundancy parameter against r, for one redundant degree.

    Parameters
    ----------
    axes : Axes
    plan : Plan
    """
    r = plan.problem.rows
    axes.plot(r, np.unwrap(plan.u(r)[:, 0], period=u_period(plan.problem.arm)), color=COLORS[1])
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.5, 1], ["0", "0.5", "1"])
    axes.margins(y=0.08)
    form = getattr(plan.problem.arm, "closed_form", None)
    name = "" if form is None else form.family.parameter
    if name.startswith("q"):  # it is a joint
        name = f"θ{name[1:]}"
    unit = "rad" if u_period(plan.problem.arm) == TAU else "m"
    axes.set_title(f"u = {name} [{unit}]" if name else f"u [{unit}]")


def _name_limits(axes: Axes, shown: Mapping[float, Sequence[str]]) -> None:
    """Draw limits as lines and name their joints beside the picture, where no curve is, one name clear of the next."""
    for bound in shown:
        axes.axhline(bound, color=GREY, linewidth=0.6)
    low, high = axes.get_ylim()
    height = 72 / axes.figure.dpi * axes.get_window_extent().height / (high - low)  # points per radian, about
    below = -np.inf
    for bound in sorted(shown):
        raised = max(below + _NAME_HEIGHT - bound * height, 0.0)
        below = bound * height + raised
        axes.annotate(
            "limit" if len(shown[bound]) > 2 else f"limit {', '.join(shown[bound])}", (1.0, bound), xytext=(2, raised),
            va="center", textcoords="offset points", xycoords=("axes fraction", "data"), color=GREY, fontsize=6.5,
        )  # fmt: skip
