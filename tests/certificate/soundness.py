"""Tries to refute proved lower bounds: random problems, and rivals that look for motions below the bound.

    python tests/certificate/soundness.py run --count 500 --rivals all --out FILE.sqlite
    python tests/certificate/soundness.py run --kind limit-cut --count 300 --rivals none --out FILE.sqlite
    python tests/certificate/soundness.py report FILE.sqlite

A run is a study: it keeps one row per problem, and interrupted, it goes on where it stopped. A report exits with 1 if a
bound or a claim of infeasibility is refuted, or something failed. Limit-cut problems are sampled densely too, to see
whether any motion passes.
"""

import argparse
import json
import os
import sys
import time
import traceback
from collections import Counter
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.append(str(Path(__file__).parents[1]))

import numpy as np
from brute_force import brute_force_connected, limit_cut_problem
from rivals import RIVALS

import selfmotion as sm
from selfmotion.errors import InfeasibleError, NothingFeasibleError, UndecidedError
from selfmotion.study import InProcess, Processes, Run, Store, Study, run_study
from selfmotion.study.random_problems import random_problem, reachable_problem

ROUNDING = 1e-9
KINDS = {"random": random_problem, "reachable": reachable_problem, "limit-cut": limit_cut_problem}
SAMPLES, SLACK = (400, 600), 1e-3  # parts of the path and of a self-motion; what limits give and take [rad]
CLOSE, SOON = 1e-3, 5.0  # gap and seconds that are counted
_LISTED = 12


class Bound(NamedTuple):
    """What a planner says: "solved" with figures, "infeasible" or "unknown" without."""

    status: str
    cost: float | None
    cost_error: float | None
    lower_bound: float | None
    seconds: float


def bound_of(problem, gap, time_limit):
    """What the global planner proves about a problem."""
    began = time.perf_counter()
    try:
        plan = sm.plan(problem, sm.Global(gap=gap, time_limit=time_limit))
        figures = ("solved", plan.cost, plan.cost_error, plan.lower_bound)
    except InfeasibleError:
        figures = ("infeasible", None, None, None)
    except (NothingFeasibleError, UndecidedError):
        figures = ("unknown", None, None, None)
    return Bound(*figures, time.perf_counter() - began)


def record_of(seed, rivals, gap, time_limit, kind="random"):
    """One problem's record: what is claimed of it, and every rival's (cost, error, seconds)."""
    record = {"seed": seed, "kind": kind}
    try:
        problem = KINDS[kind](seed)
        if problem is None:
            return {**record, "status": "no problem"}
        record["problem"] = repr(problem)
        if kind == "limit-cut":
            record["connected"] = connected(problem)
        record["rivals"] = {}
        for name in rivals:
            began = time.perf_counter()
            found = RIVALS[name](problem, seed)
            seconds = round(time.perf_counter() - began, 3)
            record["rivals"][name] = None if found is None else [found.cost, found.error, seconds]
        bound = bound_of(problem, gap, time_limit)
        record |= bound._asdict()
        record["gap"] = gap_of(bound)
    except Exception:  # a run of hours goes on; the report says what failed
        record |= {"status": "failed", "error": traceback.format_exc(limit=-4)}
    return record


def connected(problem):
    """Whether dense samples lead from start to end; None if that hangs on how much limits give."""
    answers = {brute_force_connected(problem, *SAMPLES, slack)[0] for slack in (-SLACK, SLACK)}
    return answers.pop() if len(answers) == 1 else None


def gap_of(bound):
    """The part of the cost that is not proved, None without a bound."""
    if bound.cost is None or bound.lower_bound is None:
        return None
    return (bound.cost - bound.lower_bound) / bound.cost if bound.cost > 0 else 0.0


def violations(records):
    """(seed, who, cost, lower bound) of motions that cost less than what is proved; the planner's own count too."""
    found = []
    for record in records:
        bound = record.get("lower_bound")
        if bound is None:
            continue
        costs = {"the planner itself": (record["cost"], record["cost_error"]), **_motions(record)}
        for name, (cost, error) in costs.items():
            if not cost + error >= bound * (1 - ROUNDING):
                found.append((record["seed"], name, cost, bound))
    return found


def contradictions(records):
    """(seed, who, cost) where problems are said to be infeasible and are not: the structure knows no cost."""
    found = []
    for record in records:
        if record["status"] == "infeasible":
            found += [(record["seed"], name, cost) for name, (cost, _) in _motions(record).items()]
            if record["kind"] == "reachable":
                found.append((record["seed"], "the structure of the angle domain", None))
            if record.get("connected"):
                found.append((record["seed"], "a walk along dense samples", None))
    return found


def _motions(record):
    return {name: found[:2] for name, found in record.get("rivals", {}).items() if found is not None}


def task(specification):
    """What a run of the study does; infinite errors are large ones, which JSON knows."""
    record = record_of(**specification)
    return {name: 1e300 if value == np.inf else value for name, value in record.items()}


def read(file):
    """The records of a store; of a run whose process died, that it failed."""
    return [
        {**row.specification, "status": "failed", "error": row.failure["message"]} if row.failure else row.result
        for row in Store(file).rows()
    ]


def run(seeds, rivals, file, gap, time_limit, kind="random", workers=1):
    """Store the records of all seeds that the file does not have."""
    settings = {"rivals": list(rivals), "gap": gap, "time_limit": time_limit, "kind": kind}
    runs = [Run("soundness:task", {"seed": seed, **settings}, f"{kind} {seed}", "global") for seed in seeds]

    def told(step):
        result = json.loads(step.outcome.result or step.outcome.failure)
        print(f"{step.done}/{step.total} {step.run.problem}: {result.get('status', 'failed')}", file=sys.stderr)

    Path(file).parent.mkdir(parents=True, exist_ok=True)
    run_study(Study("soundness", tuple(runs)), Store(file), InProcess() if workers == 1 else Processes(workers), told)


def report(records):
    """What the records say, as text; and whether nothing is refuted and nothing failed."""
    lines, refuted = _refuted(records)
    statuses = [record["status"] for record in records]
    lines.append(f"{len(records)} seeds: " + ", ".join(f"{statuses.count(s)} {s}" for s in sorted(set(statuses))))
    for name in RIVALS:
        tried = [record["rivals"][name] for record in records if name in record.get("rivals", {})]
        seconds = [motion[2] for motion in tried if motion is not None]
        if tried:
            median = f", median {np.median(seconds):.2f} s" if seconds else ""
            lines.append(f"rival {name}: {len(seconds)} motions of {len(tried)} problems{median}")
    lines += _walks([record for record in records if "connected" in record])
    lines += _gaps([record for record in records if record.get("gap") is not None])
    unknown = [r["seed"] for r in records if r["status"] == "unknown" and _motions(r)]
    if unknown:
        lines.append(f"unknown, though a rival found a motion: {len(unknown)}, seeds {unknown[:_LISTED]}")
    return "\n".join(lines), not refuted


def _refuted(records):
    lines = []
    below, against = violations(records), contradictions(records)
    failed = [record for record in records if record["status"] == "failed"]
    lines.append(f"violations: {len(below)}")
    lines += [f"  seed {s}: {who} costs {cost!r}, proved {bound!r}" for s, who, cost, bound in below]
    lines.append(f"motions of problems said to be infeasible: {len(against)}")
    lines += [f"  seed {s}: {who} costs {cost!r}" for s, who, cost in against]
    lines.append(f"failed: {len(failed)}")
    lines += [f"  seed {record['seed']}: {record['error'].strip().splitlines()[-1]}" for record in failed]
    return lines, bool(below or against or failed)


def _walks(records):
    """What dense samples say, by what the planner says."""
    counts = Counter((record["connected"], record["status"]) for record in records)
    words = {True: "connected", False: "blocked", None: "undecided"}
    return [f"dense samples {words[walk]}, planner {status}: {count}" for (walk, status), count in counts.items()]


def _gaps(records):
    """How wide gaps are, how soon they were reached, and where they are widest."""
    if not records:
        return ["no bounds"]
    gaps, seconds = (np.array([record[name] for record in records]) for name in ("gap", "seconds"))
    marks = (0, 25, 50, 75, 90, 95, 99, 100)
    spread = ", ".join(f"{m} %: {value:.1e}" for m, value in zip(marks, np.percentile(gaps, marks), strict=True))
    soon = np.mean((gaps <= CLOSE) & (seconds <= SOON))
    best = [min([record["cost"], *(cost for cost, _ in _motions(record).values())]) for record in records]
    beaten = [r["seed"] for r, cost in zip(records, best, strict=True) if cost < r["cost"] * (1 - CLOSE)]
    widest = sorted(records, key=lambda record: -record["gap"])[:_LISTED]
    return [
        f"gaps, by share of problems: {spread}",
        f"gap ≤ {CLOSE:g} within {SOON:g} s: {soon:.1%} of {len(records)}; seconds: median {np.median(seconds):.2f}, "
        f"most {seconds.max():.1f}",
        f"planner's motion beaten by over {CLOSE:g}: {len(beaten)}, seeds {beaten[:_LISTED]}",
        "widest:",
        *(f"  seed {r['seed']}: gap {r['gap']:.2e} in {r['seconds']:.1f} s, {r['problem']}" for r in widest),
    ]


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("run")
    command.add_argument("--count", type=int, default=100)
    command.add_argument("--first", type=int, default=0, help="first seed")
    command.add_argument("--kind", choices=KINDS, default="random")
    command.add_argument("--rivals", default="all", help=f"all, none, or some of {','.join(RIVALS)}")
    command.add_argument("--out", required=True)
    command.add_argument("--gap", type=float, default=1e-4)
    command.add_argument("--time-limit", type=float, default=60.0)
    command.add_argument("--workers", type=int, default=1)
    commands.add_parser("report").add_argument("file")
    given = parser.parse_args(arguments)
    if given.command == "report":
        text, good = report(read(given.file))
        print(text)
        return 0 if good else 1
    rivals = {"all": list(RIVALS), "none": []}.get(given.rivals, given.rivals.split(","))
    if not set(rivals) <= set(RIVALS):
        parser.error(f"rivals are {', '.join(RIVALS)}")
    seeds = range(given.first, given.first + given.count)
    run(seeds, rivals, given.out, given.gap, given.time_limit, given.kind, given.workers)
    return 0


if __name__ == "__main__":
    sys.exit(main())
