"""The structure of an angle domain as plain data and as lines for people."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from selfmotion.arms import Cause, Radii
from selfmotion.domain import DomainStructure, Event, SampledDomain

_MOST_LINES = 40


def structure_object(structure: DomainStructure, radii: Radii | None) -> dict[str, Any]:
    """Return a structure and the arm's radii as what JSON knows; joints count from 1, unknown values are None."""
    branches, dead_end = structure.self_motion.branches, structure.dead_end
    return {
        "connected": structure.is_connected,
        "dead_end": None if dead_end is None else {"r": dead_end[0], "causes": _causes(dead_end[1])},
        "components": structure.n_components,
        "events": [_event(event, branches) for event in structure.events],
        "sheets": [asdict(sheet) for sheet in structure.sheets],
        "radii": None if radii is None else _radii(radii),
    }


def structure_lines(structure: DomainStructure, radii: Radii | None, file: str) -> list[str]:
    """Return radii, events and whether the ends are connected as lines of text; `file` has what is left out."""
    events = [event.text(structure.self_motion.branches) for event in structure.events]
    more = [f"… and {len(events) - _MOST_LINES} more, see {file}"] if len(events) > _MOST_LINES else []
    return [
        *([] if radii is None else [_radii_line(radii)]),
        f"{len(events)} event{_s(len(events))}, {structure.n_components} connected part{_s(structure.n_components)}",
        *events[:_MOST_LINES],
        *more,
        f"a continuous motion from r = 0 to r = 1 exists: {_connection(structure)}",
    ]


def sampled_object(sampled: SampledDomain) -> dict[str, Any]:
    """Return what was seen of a domain whose structure is not told: r, and per branch intervals and causes."""
    motion = sampled.domain.self_motion
    intervals, ends = {}, {}
    for branch, looks in sampled.runs.items():
        name = motion.branches[branch]
        intervals[name] = [[[run.low, run.high] for run in runs] for runs in looks]
        ends[name] = [[[_causes(causes) for causes in run.causes] for run in runs] for runs in looks]
    return {"r": sampled.r.tolist(), "u": intervals, "ends": ends}


def sampled_lines(sampled: SampledDomain) -> list[str]:
    """Return as lines of text where each branch was seen to be feasible."""
    lines = []
    for branch, looks in sampled.runs.items():
        stretches = sampled.stretches(branch)
        where = " and ".join(f"[{a:.6g}, {b:.6g}]" for a, b in stretches)
        most = max(map(len, looks), default=0)
        widest = max((run.high - run.low for runs in looks for run in runs), default=0.0)
        intervals = f"at most {most} interval{_s(most)}" if widest > 0.0 else "single postures and no interval"
        lines.append(
            f"{sampled.domain.self_motion.branches[branch]}: "
            + (f"feasible for r in {where}, {intervals}" if stretches else "nothing is feasible")
        )
    return lines


def _radii(radii: Radii) -> dict[str, Any]:
    return {
        "center": radii.center.tolist(),
        "outer": radii.outer,
        "nearest": None if math.isnan(radii.nearest) else radii.nearest,
        "coregular": list(radii.coregular),
    }


def _radii_line(radii: Radii) -> str:
    nearest = "none" if math.isnan(radii.nearest) else f"{radii.nearest:.6g}"
    coregular = ", ".join(f"{rho:.6g}" for rho in radii.coregular)
    return f"radii: R_max = {radii.outer:.6g} (9), R*_min = {nearest} (10), co-regular {coregular}"


def _connection(structure: DomainStructure) -> str:
    if (dead_end := structure.dead_end) is None:
        return "yes"
    r, causes = dead_end
    if r <= 0.0:
        return "no, nothing is feasible at r = 0"
    why = f", because of {' and '.join(map(str, causes))}" if causes else ""
    return f"no, the last connected part dies at r = {r:.10f}{why}"


def _event(event: Event, branches: tuple[str, ...]) -> dict[str, Any]:
    return {
        "r": event.r,
        "kind": event.kind,
        "u": event.u,
        "branch": None if event.branch is None else branches[event.branch],
        "causes": _causes(event.causes),
        "instead_of": _causes(event.instead_of),
    }


def _causes(causes: tuple[Cause, ...]) -> list[dict[str, Any]]:
    return [{"kind": cause.kind, "joint": cause.joint + 1, "value": cause.value} for cause in causes]


def _s(count: int) -> str:
    return "" if count == 1 else "s"
