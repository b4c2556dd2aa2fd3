"""``selfmotion reproduce``: the seed's study as a report, printed values beside computed ones."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict
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
        "versions": {name: version(name) for name in ("numpy", "scipy", "numba", "matplotlib")}
        | {"selfmotion": __version__},
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
    scan = results["dense_scan"]
    lines = [
        "# The seed's 3R study, reproduced",
        "",
        "The paper plans a 3R arm (links 30, 30, 20; 0 ≤ θ2 ≤ π) along a fifth-degree Bezier path. Its motion is the sinusoid",
        "θ_g(r) = 0.3 + 0.4 sin(2π f r), and GA, PSO and GWO choose f in [0, 15] so that the joint travel F, equation (1a),",
        f"is least: population {seed_study.POPULATION}, {seed_study.ITERATIONS} iterations, {results['samples']} samples.",
        "",
        "## Table II: printed beside computed",
        "",
        "| | printed F | printed f | F computed at the printed f | computed F | computed f | F − dense scan |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in results["rows"]:
        printed, at_printed = row["printed"], row["computed_at_printed_f"]
        cells = (
            [f"{printed['fitness']:.9g}", f"{printed['f']:.4f}", f"{at_printed:.6f}"] if printed else ["–"] * 3
        )
        cells += [
            f"{row['cost_sampled']:.8f}",
            f"{row['parameters']['f']:.4f}",
            f"{row['cost_sampled'] - scan['fitness']:.1e}",
        ]
        lines.append(f"| {row['label']} | " + " | ".join(cells) + " |")
    best = min(results["rows"], key=lambda row: row["cost_sampled"])
    lines += [
        "",
        f"Dense scan: the least F is **{scan['fitness']:.8f}** at f = {scan['f']:.6f} ({scan['evaluations']} evaluations).",
        "",
        "**The printed values do not follow from the printed data.** At the printed frequencies the printed arm, path, limits,",
        "offset and amplitude give the F of the fourth column, not the printed one, and no frequency gives less than",
        "the dense scan. We changed nothing to make the figures agree. What can be compared is how the optimizers",
        "rank; one seed each, as here, does not settle that.",
        "",
        "PSO is the paper's variant: φ1 = φ2 = 1.5, constriction factor 1, undamped. PSO canonical has φ1 = φ2 = 2.05 and",
        "constriction factor 0.7298. Particles that leave the box stop on its wall.",
        "",
        "## The best motion, checked",
        "",
        f"- {best['label']}: F as an integral {best['cost']:.9f} ± {best['cost_error']:.0e}; the chord sum over the samples, "
        f"always below it, {best['cost_sampled']:.9f}",
        f"- plain joint travel: l1 {best['l1_travel']:.6f} rad, l2 {best['l2_travel']:.6f} rad",
        f"- largest distance of the tool from the path {best['max_tracking_error']:.1e} (links sum to 80), "
        "between the samples too",
        f"- least distance of θ2 to a limit {best['min_limit_margin']:.4f} rad; largest joint step between samples "
        f"{best['max_joint_step']:.4f} rad",
        "",
        "## Figures",
        "",
        "![The path](path.png)",
        "",
        "The traced path (the paper's Fig. 10a).",
        "",
        "![The angle domain](domain.png)",
        "",
        "The angle domain of the positive elbow with the three optimizers' sinusoids (Fig. 10b).",
        "",
        "![Joint angles](joints.png)",
        "",
        f"Joint angles of the best motion found, by {best['label']} (Fig. 12a).",
        "",
        "![Postures](postures.png)",
        "",
        "Its postures (Fig. 12b).",
        "",
        "![Fitness evolution](evolution.png)",
        "",
        "Fitness evolution (Fig. 11), and the same as excess over the dense-scan optimum.",
        "",
        "## How this was made",
        "",
        f"- command: `{results['command']}`; seed of every optimizer: {results['seed']}",
        f"- machine: {results['machine']}",
        "- versions: " + ", ".join(f"{name} {number}" for name, number in results["versions"].items()),
        "- every number above is in `results.json`, written by the same run",
        "",
    ]
    return "\n".join(lines)
