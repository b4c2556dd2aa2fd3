"""Tries to refute plans, bounds and proofs of infeasibility among obstacles: random scenes in the plane and in space.

    python tests/certificate/soundness_scenes.py run --kind planar --count 1000 --out FILE.sqlite
    python tests/certificate/soundness_scenes.py run --kind spatial --count 300 --out FILE.sqlite
    python tests/certificate/soundness_scenes.py report FILE.sqlite

A run is a study: it keeps one row per scene, and interrupted, it goes on where it stopped. Every plan is looked at 100
times as densely as it is sampled, by an oracle that shares nothing with the package (`clearance`); bounds and claims
that there is no motion are held against motions found without them (`scene_rivals`), claims in the plane also against
what dense samples lead to, with everything that forbids postures made larger and smaller by what samples may miss.
A report exits with 1 if a plan, a bound or a claim is refuted, or something failed.
"""

import argparse
import json
import os
import sys
import time
import traceback
from collections import Counter
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "arms"))

import numpy as np
from brute_force import flood, sample
from scene_rivals import climbed, refined
from scenes import planar_scene, spatial_scene

import selfmotion as sm
from clearance import oracle
from selfmotion.errors import InfeasibleError, SelfMotionError
from selfmotion.study import InProcess, Processes, Run, Store, Study, run_study

ROUNDING = 1e-9
DENSER = 100
TRACKING = 1e-9
KINDS = {"planar": planar_scene, "spatial": spatial_scene}
RUNGS = {"planar": 240, "spatial": 60}
WALK, FINE, SLACK = (80, 240), (240, 720), 0.012  # parts of path and self-motion; what all constraints give and take
_LISTED = 20


def record_of(seed, kind, gap, time_limit, rivals):
    """One scene's record: what is claimed of it, how near a plan comes, and what rivals cost."""
    record = {"seed": seed, "kind": kind, "rivals": {}}
    try:
        problem = KINDS[kind](seed)
        if problem is None:
            return {**record, "status": "no problem"}
        truth = oracle(problem)
        record["problem"] = repr(problem)
        record["obstacles"] = [repr(obstacle) for obstacle in truth.obstacles]
        record |= _planned(problem, truth, gap, time_limit)
        for name in rivals:
            began = time.process_time()
            ladder = name == "ladder"
            cost = climbed(problem, truth, RUNGS[kind]) if ladder else refined(problem, truth, seed, time_limit)
            record["rivals"][name] = [cost if np.isfinite(cost) else None, round(time.process_time() - began, 2)]
        if kind == "planar" and not problem.cyclic:
            record["walk"] = walked(problem, truth, record["status"])
    except Exception:  # a run of hours goes on; the report says what failed
        record |= {"status": "failed", "error": traceback.format_exc(limit=-4)}
    return record


def _planned(problem, truth, gap, time_limit):
    """What the global planner says, with the processor's seconds, and how well its plan holds."""
    began, wall = time.process_time(), time.perf_counter()
    found, plan = {"why": ""}, None
    try:
        plan = sm.plan(problem, sm.Global(gap=gap, time_limit=time_limit))
        found |= {"status": "solved", "cost": plan.cost, "cost_error": plan.cost_error, "lower_bound": plan.lower_bound}
    except InfeasibleError as error:
        found |= {"status": "infeasible", "why": str(error)}
    except SelfMotionError as error:
        found |= {"status": type(error).__name__, "why": str(error)}
    found |= {"seconds": time.process_time() - began, "wall": time.perf_counter() - wall}
    if plan is None:
        return found
    r = np.union1d(np.linspace(0.0, 1.0, DENSER * problem.samples), problem.path.breaks)
    q, reach = plan(r), truth.arm.reach
    return found | {
        "left": float(truth.left(q).min() / reach),
        "singular": float(min(truth.singular(q[::7]).min(), 1e300)),
        "off": float(truth.arm.task_error(q, problem.path(r)).max() / reach),
        "excess": float(truth.arm.limits.excess(q).max()),
        "bounded": plan.certificate.rigorous if plan.certificate is not None else None,
        "said": {name: float(margin) for name, margin in plan.verification.margins.items()},
    }


def walked(problem, truth, status):
    """Whether dense samples lead from start to end: "connected" or "blocked" if constraints may give and take, else
    "undecided".
    """

    def leads(parts, slack):
        def poses(r):
            return sample(problem, r, parts[1], slack, truth.allowed)

        return flood(problem, poses(np.linspace(0.0, 1.0, parts[0] + 1)), parts[1], slack, poses, truth.allowed)[0]

    answer = "connected" if leads(WALK, -SLACK) else "undecided" if leads(WALK, SLACK) else "blocked"
    agreed = {"connected": "solved", "blocked": "infeasible"}
    if answer != "undecided" and status in agreed.values() and agreed[answer] != status:  # samples may err: finer
        answer = "connected" if leads(FINE, -SLACK) else "undecided" if leads(FINE, SLACK) else "blocked"
    return answer


def violations(records):
    """(seed, what) of everything that is refuted."""
    found = []
    for record in records:
        seed, costs = record["seed"], {name: cost for name, (cost, _) in record["rivals"].items() if cost is not None}
        if record["status"] == "solved":
            for name, least in (("left", -ROUNDING), ("singular", -ROUNDING)):
                if record[name] < least:
                    found.append((seed, f"plan has {name} {record[name]:.3e}"))
            if record["off"] > TRACKING or record["excess"] > ROUNDING:
                found.append((seed, f"plan is off by {record['off']:.1e}, beyond limits by {record['excess']:.1e}"))
            costs["the planner itself"] = record["cost"] + record["cost_error"]
            bound = record["lower_bound"]
            if bound is not None:
                found += [
                    (seed, f"{name} costs {cost!r}, proved {bound!r}")
                    for name, cost in costs.items() if not cost >= bound * (1 - ROUNDING)
                ]  # fmt: skip
            if record.get("walk") == "blocked":
                found.append((seed, "there is a plan, and dense samples lead nowhere"))
        elif record["status"] == "infeasible":
            found += [(seed, f"{name} costs {cost!r}, and is proved not to be") for name, cost in costs.items()]
            if record.get("walk") == "connected":
                found.append((seed, "dense samples lead on, and that is proved not to be"))
    return found


def task(specification):
    """What a run of the study does."""
    return record_of(**specification)


def read(file):
    """The records of a store; of a run whose process died, that it failed."""
    return [
        {**row.specification, "rivals": {}, "status": "failed", "error": row.failure["message"]}
        if row.failure else row.result
        for row in Store(file).rows()
    ]  # fmt: skip


def run(seeds, file, kind, gap, time_limit, rivals, workers=1):
    """Store the records of all seeds that the file does not have."""
    settings = {"kind": kind, "gap": gap, "time_limit": time_limit, "rivals": list(rivals)}
    runs = [Run("soundness_scenes:task", {"seed": seed, **settings}, f"{kind} {seed}", "global") for seed in seeds]

    def told(step):
        result = json.loads(step.outcome.result or step.outcome.failure)
        print(f"{step.done}/{step.total} {step.run.problem}: {result.get('status', 'failed')}", file=sys.stderr)

    Path(file).parent.mkdir(parents=True, exist_ok=True)
    run_study(Study("scenes", tuple(runs)), Store(file), InProcess() if workers == 1 else Processes(workers), told)


def report(records):
    """What the records say, as text; and whether nothing is refuted and nothing failed."""
    wrong, failed = violations(records), [record for record in records if record["status"] == "failed"]
    counts = Counter(record["status"] for record in records)
    lines = [f"{len(records)} scenes: " + ", ".join(f"{count} {status}" for status, count in counts.most_common())]
    lines += [f"violations: {len(wrong)}", *(f"  seed {seed}: {what}" for seed, what in wrong)]
    lines += [f"failed: {len(failed)}", *(f"  seed {r['seed']}: {r['error'].strip().splitlines()[-1]}" for r in failed)]
    walks = Counter((record["walk"], record["status"]) for record in records if "walk" in record)
    lines += [f"dense samples {walk}, planner {status}: {count}" for (walk, status), count in sorted(walks.items())]
    missed = [
        r["seed"] for r in records
        if r["status"] not in ("solved", "failed", "infeasible")
        and (r.get("walk") == "connected" or any(cost is not None for cost, _ in r["rivals"].values()))
    ]  # fmt: skip
    lines.append(f"a motion exists, and the planner found none: {len(missed)}, seeds {missed[:_LISTED]}")
    told = ("solved", "failed", "infeasible")
    open_ = [r["seed"] for r in records if r["status"] not in told and r["seed"] not in missed]
    lines.append(f"neither is known: {len(open_)}, seeds {open_[:_LISTED]}")
    solved = [record for record in records if record["status"] == "solved"]
    if solved:
        gaps = np.array([1 - (r["lower_bound"] or 0.0) / r["cost"] if r["cost"] > 0 else 0.0 for r in solved])
        marks = (0, 25, 50, 75, 90, 95, 100)
        spread = ", ".join(f"{m} %: {value:.1e}" for m, value in zip(marks, np.percentile(gaps, marks), strict=True))
        lines.append(f"gaps, by share of plans: {spread}")
        lines.append(f"least clearance left over: {min(r['left'] for r in solved):.2e} of the reach")
        beaten = []
        for r in solved:
            best = min([cost for cost, _ in r["rivals"].values() if cost is not None], default=np.inf)
            beaten += [r["seed"]] if best < r["cost"] * (1 - 1e-3) else []
        lines.append(f"planner's motion beaten by over 1e-3: {len(beaten)}, seeds {beaten[:_LISTED]}")
    for name in sorted({name for record in records for name in record["rivals"]}):
        tried = [record["rivals"][name] for record in records if name in record["rivals"]]
        lines.append(f"rival {name}: {sum(cost is not None for cost, _ in tried)} motions of {len(tried)} scenes")
    seconds = np.array([record["seconds"] for record in records if "seconds" in record])
    if len(seconds):
        lines.append(f"processor's seconds per plan: median {np.median(seconds):.2f}, most {seconds.max():.1f}")
    return "\n".join(lines), not wrong and not failed


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("run")
    command.add_argument("--kind", choices=KINDS, default="planar")
    command.add_argument("--count", type=int, default=100)
    command.add_argument("--seed", type=int, default=0, help="first seed")
    command.add_argument("--rivals", default="ladder,refined", help="none, or some of ladder,refined")
    command.add_argument("--out", required=True)
    command.add_argument("--gap", type=float, default=1e-3)
    command.add_argument("--time-limit", type=float, default=30.0)
    command.add_argument("--workers", type=int, default=1)
    commands.add_parser("report").add_argument("file")
    given = parser.parse_args(arguments)
    if given.command == "report":
        text, good = report(read(given.file))
        print(text)
        return 0 if good else 1
    rivals = [] if given.rivals == "none" else given.rivals.split(",")
    seeds = range(given.seed, given.seed + given.count)
    run(seeds, given.out, given.kind, given.gap, given.time_limit, rivals, given.workers)
    return 0


if __name__ == "__main__":
    sys.exit(main())
