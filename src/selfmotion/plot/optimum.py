"""The shortest motion in the angle domain, and what the proof leaves of that."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.arms import RedundantArm
from selfmotion.certificate.result import Certificate, TubeSlice
from selfmotion.certificate.verdict import percent, proved_within, verdict
from selfmotion.domain import AngleDomain, SampledDomain, angle_domain
from selfmotion.errors import InvalidInputError
from selfmotion.plans import Plan
from selfmotion.plot.domain import legend_below
from selfmotion.plot.holes import Piece, fill_holes
from selfmotion.plot.style import COLORS, DASHES, GREY, INK, REGION
from selfmotion.plot.unfolding import Unfolding

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TUBE = "#f3b73e"
_PLACES = 2001
_STEP = 0.03  # of a joint between two places at which a motion is looked at [rad]
_ROUNDS = 12
_SAME = 1e-6  # chords that are this near to each other touch [rad]
_FAR = 0.6  # between intervals of neighbouring slices that do not follow each other [rad]
_UNSEEN = 0.02  # gaps in the tube that are too narrow to be seen [rad]


def draw_optimum(axes: Axes, plan: Plan, rivals: Mapping[str, Plan] | None = None) -> None:
    """Draw a motion with its proof in the angle domain of all elbows: the motion, and where a better one could be.

    Parameters
    ----------
    axes : Axes
    plan : Plan
        With a certificate, of an arm with one redundant degree.
    rivals : mapping, optional
        Label to other motions of the same arm along the same path. The verdict in the title begins with the cheapest.

    Raises
    ------
    InvalidInputError
        If the plan has no certificate.

    Notes
    -----
    With one feasible elbow the ordinate is u. If both are feasible and meet at folds, where the arm is stretched, the
    domain is unfolded along the self-motion: u = m + a sin s between the folds m ± a, the positive elbow in the middle
    and the negative one beyond the dotted folds, so that motions go on smoothly from one to the other; the dashed top
    and bottom of the picture are the same postures then. Otherwise the negative elbow is put above the positive one.

    The tube is what the last round of the proof has left of the domain: it holds every motion that is cheaper than this
    one, if there is one. It is proved at the slices, and drawn straight between them.
    """
    certificate, arm, rivals = _certificate(plan), plan.problem.arm, rivals or {}
    domain = angle_domain(arm, plan.problem.path)
    chart = Unfolding(domain)
    extent = _draw_domain(axes, chart)
    for k, (label, motion) in enumerate({"shortest known": plan, **rivals}.items()):
        extent.append(_draw_motion(axes, chart, motion, k, label))
    intervals = tube_intervals(chart, arm, certificate.tube, _UNSEEN)
    _draw_bands(axes, certificate.tube, intervals, _room(plan, certificate))
    values = np.concatenate(extent)
    margin = 0.04 * max(float(np.nanmax(values) - np.nanmin(values)), 1e-3)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(np.nanmin(values) - margin, np.nanmax(values) + margin)
    _fill_holes(axes, chart, domain)
    axes.set_xlabel("path parameter r")
    _name_ordinates(axes, chart)
    cheapest = min((rival.cost for rival in rivals.values()), default=None)
    said = verdict(plan.cost, plan.cost_error, certificate.bound, cheapest)
    axes.set_title(f"cost {said}".replace(", ", ",\n", 1))
    legend_below(axes, columns=2)


def _name_ordinates(axes: Axes, chart: Unfolding) -> None:
    """Label the ordinate, and the elbows where there are two."""
    axes.set_ylabel("place on the self-motion, s [rad]" if chart.kind == "around" else "redundancy parameter u [rad]")
    ticks, labels = chart.ticks()
    if labels:
        axes.set_yticks(ticks, labels)
    for y, name in chart.names().items():
        axes.text(
            1.015, y, name, transform=axes.get_yaxis_transform(), rotation=270, ha="left", va="center", fontsize=6.5,
            color=INK,
        )  # fmt: skip


def _draw_domain(axes: Axes, chart: Unfolding) -> list[FloatArray]:
    """Draw the feasible region and its boundary, dashed where it goes on; return what must be in view."""
    extent = []
    for part in chart.parts():
        extent += [part.low, part.high]
        if (part.high > part.low).any():
            axes.fill_between(part.r, part.low, part.high, where=part.high > part.low, color=REGION, linewidth=0.3)
        for edge in part.edges:
            if np.isfinite(edge).any():
                axes.plot(part.r, edge, color=INK, linewidth=0.8)
    if chart.kind == "around":
        for y in (-np.pi, -0.5 * np.pi, 0.5 * np.pi, np.pi):
            seam = abs(y) == np.pi
            axes.axhline(y, color=GREY, linewidth=0.7, linestyle=(0, (5, 3)) if seam else (0, (1, 2)), zorder=1.5)
        extent.append(np.array([-np.pi, np.pi]))
    return extent or [np.array([-np.pi, np.pi])]


def _fill_holes(axes: Axes, chart: Unfolding, domain: AngleDomain) -> None:
    """Fill what constraints beyond joint limits take out of the domain."""
    if domain.unconstrained is domain:
        return
    sampled, found = SampledDomain(domain, chart.used), []
    for branch in chart.used:
        for hole in sampled.holes(branch):
            pieces = [
                Piece(part.r, part.low, part.high, bool(strip.causes[0]))
                for strip in hole.strips for part in chart.placed(strip, branch) if (part.high > part.low).any()
            ]  # fmt: skip
            r, u = (np.array([value]) for value in hole.at)
            found.append((hole, pieces, (hole.at[0], float(chart.ordinate(r, u, np.array([branch]))[0]))))
    fill_holes(axes, found)


def _draw_motion(axes: Axes, chart: Unfolding, plan: Plan, look: int, label: str) -> FloatArray:
    r = np.linspace(0.0, 1.0, _PLACES)
    q = plan(r)
    for _ in range(_ROUNDS):
        far = np.flatnonzero(np.abs(np.diff(q, axis=0)).max(axis=1) > _STEP)
        if not len(far):
            break
        between = 0.5 * (r[far] + r[far + 1])
        r, q = np.insert(r, far + 1, between), np.insert(q, far + 1, plan(between), axis=0)
    arm = plan.problem.arm
    x, y = chart.curve(r, arm.u_of(q)[:, 0], arm.branch_of(q))
    axes.plot(
        x, y, color=COLORS[look % len(COLORS)], linestyle=DASHES[look % len(DASHES)], label=label,
        linewidth=1.3 if look else 0.9, zorder=3.5 if look else 4,
    )  # fmt: skip
    return y


def draw_tube(axes: Axes, plan: Plan) -> None:
    """Draw how far a better motion could be from the best one known: the tube of :func:`draw_optimum`, straightened.

    Parameters
    ----------
    axes : Axes
    plan : Plan
        With a certificate, of an arm with one redundant degree.

    Raises
    ------
    InvalidInputError
        If the plan has no certificate.
    """
    certificate, arm = _certificate(plan), plan.problem.arm
    chart = Unfolding(angle_domain(arm, plan.problem.path))
    r = np.array([part.r for part in certificate.tube])
    q = plan(r)
    middle = chart.ordinate(r, arm.u_of(q)[:, 0], arm.branch_of(q))
    intervals = tube_intervals(chart, arm, certificate.tube)
    moved = [part - y for part, y in zip(intervals, middle, strict=True)]
    _draw_bands(axes, certificate.tube, moved, _room(plan, certificate))
    axes.axhline(0.0, color=COLORS[0], linewidth=1.0, label="shortest known", zorder=4)
    reach = max((float(np.abs(part).max()) for part in moved if len(part)), default=0.0)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-1.1 * max(reach, 1e-6), 1.1 * max(reach, 1e-6))
    axes.set_xlabel("path parameter r")
    axes.set_ylabel(f"{'s' if chart.kind == 'around' else 'u'} beside that of the motion [rad]")
    legend_below(axes, columns=2)


def _certificate(plan: Plan) -> Certificate:
    if plan.certificate is None:
        raise InvalidInputError("plan", "has no certificate", "use planner global")
    return plan.certificate


def _room(plan: Plan, certificate: Certificate) -> str:
    """Return what the tube is called."""
    gap = proved_within(plan.cost, plan.cost_error, certificate.bound)
    within = f",\nby {percent(gap)} at most" if np.isfinite(gap) else ""
    return f"room for a better one{within}"


def _draw_bands(axes: Axes, tube: tuple[TubeSlice, ...], intervals: list[FloatArray], label: str) -> None:
    """Draw what is left at the slices as bands."""
    from matplotlib.collections import PolyCollection

    shapes = bands(intervals, np.array([part.r for part in tube]))
    if shapes:
        patches = PolyCollection(shapes, facecolor=TUBE, edgecolor=TUBE, linewidth=0.3, label=label, zorder=3)
        axes.add_collection(patches, autolim=False)


class Chart(Protocol):
    """What a tube is drawn in: ordinates of postures; see :class:`~selfmotion.plot.unfolding.Unfolding`."""

    def ordinate(self, r: FloatArray, u: FloatArray, branch: IntArray) -> FloatArray:
        """Return the ordinates of postures, all of shape (k,)."""
        ...

    def cut(self, ends: FloatArray) -> FloatArray:
        """Return short intervals between ordinates (k, 2), more than k where the chart cuts one."""
        ...


def tube_intervals(
    chart: Chart, arm: RedundantArm, tube: tuple[TubeSlice, ...], gap: float = _SAME
) -> list[FloatArray]:
    """Return what is left at each slice as intervals of the chart's ordinate, shape (m, 2) each, ascending.

    Intervals with less than `gap` between them are one.
    """
    found = []
    for part in tube:
        r = np.full(len(part.a), part.r)
        ends = np.stack([chart.ordinate(r, arm.u_of(q)[:, 0], arm.branch_of(q)) for q in (part.a, part.b)], axis=1)
        found.append(merged(np.sort(chart.cut(ends), axis=1), gap))
    return found


def merged(intervals: FloatArray, gap: float) -> FloatArray:
    """Return intervals (m, 2) with those joined that have less than `gap` between them."""
    joined: list[list[float]] = []
    for low, high in intervals[np.argsort(intervals[:, 0])].tolist():
        if joined and low <= joined[-1][1] + gap:
            joined[-1][1] = max(joined[-1][1], high)
        else:
            joined.append([low, high])
    return np.array(joined).reshape(-1, 2)


def bands(intervals: list[FloatArray], r: FloatArray) -> list[FloatArray]:
    """Return polygons that join the intervals of neighbouring slices where one follows another; others are steps."""
    shapes = []
    for k in range(len(r) - 1):
        one, other = intervals[k], intervals[k + 1]
        middle, joined = 0.5 * (r[k] + r[k + 1]), _followers(one, other)
        for i, j in joined:
            (a, b), (c, d) = one[i], other[j]
            shapes.append(np.array([[r[k], a], [r[k + 1], c], [r[k + 1], d], [r[k], b]]))
        for part, side, left, right in ((one, 0, r[k], middle), (other, 1, middle, r[k + 1])):
            alone = np.delete(part, [pair[side] for pair in joined], axis=0)
            shapes += [np.array([[left, a], [right, a], [right, b], [left, b]]) for a, b in alone]
    return shapes


def _followers(one: FloatArray, other: FloatArray) -> list[tuple[int, int]]:
    """Return the pairs of intervals that are each other's nearest, by their middles, and not far apart."""
    if not len(one) or not len(other):
        return []
    away = np.abs(one.mean(axis=1)[:, None] - other.mean(axis=1))
    gap = np.maximum(one[:, None, 0] - other[:, 1], other[:, 0] - one[:, None, 1])
    nearest, back = away.argmin(axis=1), away.argmin(axis=0)
    return [(i, int(j)) for i, j in enumerate(nearest) if back[j] == i and gap[i, j] <= _FAR]
