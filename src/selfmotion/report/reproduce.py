"""``selfmotion reproduce``: the seed's study as a report, printed values beside computed ones."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict
from importlib import resources
from importlib.metadata import version
from typing import Any

from selfmotion._version import __version__
from selfmotion.domain import angle_domain
from selfmotion.optimizers import Progress
from selfmotion.planners import Plan
from selfmotion.plot import (
    draw_domain,
    draw_evolution,
    draw_joints,
    draw_path,
    draw_postures,
    figure,
    image_files,
    rendered,
)
from selfmotion.report import seed_study

_FIGURES = ("path", "domain", "joints", "postures", "evolution")
FILES = ("report.md", "results.json", *(f"{name}.{kind}" for name in _FIGURES for kind in ("png", "svg")))


def reproduce(seed: int, command: str, progress: Progress | None = None) -> dict[str, bytes]:
    """Run the seed's 3R study and return its report.

    Parameters
    ----------
    seed : int
        Seed of every optimizer.
    command : str
        The command that is being run, for the report.
    progress : callable, optional

    Returns
    -------
    dict
        File name to bytes: ``report.md``, ``results.json`` and each figure as PNG and SVG.
    """
    plans = seed_study.run(seed, progress)
    scan = seed_study.dense_scan()
    results = _results(plans, scan, seed, command)
    files = _figures(plans, scan)
    files["results.json"] = (json.dumps(results, indent=1) + "\n").encode()
    files["report.md"] = _report(results).encode()
    return files


def _results(plans: dict[str, Plan], scan: seed_study.DenseScan, seed: int, command: str) -> dict[str, Any]:
    """Return every number of the report."""
    rows = []
    for label, plan in plans.items():
        printed = seed_study.PRINTED.get(label)
        rows.append(
            {
                "label": label,
                "printed": None if printed is None else asdict(printed),
                "computed_at_printed_f": None if printed is None else float(seed_study.fitness(printed.f)[0]),
                **plan.summary(),
            }
        )
    return {
        "command": command,
        "seed": seed,
        "machine": f"{platform.machine()}, {platform.system()}, Python {platform.python_version()}",
        "versions": {name: version(name) for name in ("numpy", "scipy", "matplotlib")} | {"selfmotion": __version__},
        "offset": seed_study.OFFSET,
        "amplitude": seed_study.AMPLITUDE,
        "low": seed_study.BOUNDS[0],
        "high": seed_study.BOUNDS[1],
        "population": seed_study.POPULATION,
        "iterations": seed_study.ITERATIONS,
        "samples": seed_study.SAMPLES,
        "dense_scan": asdict(scan),
        "rows": rows,
    }


def _figures(plans: dict[str, Plan], scan: seed_study.DenseScan) -> dict[str, bytes]:
    case = seed_study.problem()
    domain = angle_domain(case.arm, case.path)
    curves = {
        f"{label}, f = {plan.parameters['f']:.4f}": (case.grid, plan.u(case.grid)[:, 0])
        for label, plan in plans.items()
        if label in seed_study.PRINTED
    }
    best = min(plans.values(), key=lambda plan: plan.cost_sampled)
    files = rendered("path", draw_path, case, height=2.8)
    files |= rendered("domain", draw_domain, domain, 0, curves, height=3.0)
    files |= rendered("joints", draw_joints, best)
    files |= rendered("postures", draw_postures, best, height=3.2)
    histories = {label: plan.history[0] for label, plan in plans.items()}
    with figure(width=7.0, height=2.7, columns=2) as (canvas, (left, right)):
        draw_evolution(left, histories)
        draw_evolution(right, histories, scan.fitness)
        files |= image_files("evolution", canvas)
    return files


def _report(results: dict[str, Any]) -> str:
    """Fill the template; a number that was not computed is a KeyError, never a stale figure."""
    template = resources.files(__package__).joinpath("report.md.in").read_text(encoding="utf-8")
    return template.format(
        **results,
        table="\n".join(_table_row(row, results["dense_scan"]["fitness"]) for row in results["rows"]),
        best=min(results["rows"], key=lambda row: row["cost_sampled"]),
        scan=results["dense_scan"],
        versions_line=", ".join(f"{name} {number}" for name, number in results["versions"].items()),
    )


def _table_row(row: dict[str, Any], optimum: float) -> str:
    printed, cells = row["printed"], ["–", "–", "–"]
    if printed is not None:
        cells = [f"{printed['fitness']:.9g}", f"{printed['f']:.4f}", f"{row['computed_at_printed_f']:.6f}"]
    excess = row["cost_sampled"] - optimum
    above = "< 1e-12" if abs(excess) < 1e-12 else f"{excess:.1e}"
    cells += [f"{row['cost_sampled']:.8f}", f"{row['parameters']['f']:.4f}", above]
    return f"| {row['label']} | " + " | ".join(cells) + " |"
