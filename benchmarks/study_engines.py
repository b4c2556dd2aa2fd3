"""How much faster two workers are than one, and what an engine costs per run.

    python benchmarks/study_engines.py --runs 60 --seconds 0.3 --rounds 3

Runs are plans of one generated problem by searches of the seed's kind with a budget that takes about the time asked
for; each engine is started, works them off into a store in a temporary folder, and is ended. The start of an engine is
measured apart, with one short plan per worker. The cost per run is that of runs that do nothing, beyond the start.
"""

import argparse
import json
import statistics
import tempfile
import time
from pathlib import Path

from selfmotion.study import Dask, InProcess, Processes, Run, Store, Study, run_study

ENGINES = {
    "in-process": lambda: (1, InProcess()),
    "processes, 1 worker": lambda: (1, Processes(1)),
    "processes, 2 workers": lambda: (2, Processes(2)),
    "dask, 1 worker": lambda: (1, Dask(workers=1)),
    "dask, 2 workers": lambda: (2, Dask(workers=2)),
}
NOTHING = "benchmarks of engines"


def nothing(specification):
    """A run that does nothing."""
    return {"seed": specification["seed"]}


def planned(count, iterations):
    """Searches that differ by their seeds."""
    optimizer = {"kind": "pso", "variant": "seed", "population": 20, "iterations": iterations, "bounds": [0, 15]}
    problem = {
        "arm": {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 3.141592653589793], None]},
        "path": {
            "kind": "bezier", "control_points": [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]],
        },
    }  # fmt: skip
    planner = {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4], "optimizer": optimizer}
    common = {"problem": problem, "planner": planner, "history": False}
    return [Run("selfmotion.study.tasks:plan", {**common, "seed": k}, seed=k) for k in range(count)]


def idle(count):
    """Runs that do nothing."""
    return [Run("study_engines:nothing", {"seed": k}, seed=k) for k in range(count)]


def seconds_of(runs, engine):
    """Seconds that an engine takes for runs, its start and end included, and the median of the runs' own."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        store = run_study(Study(NOTHING, tuple(runs)), Store(Path(folder) / "study.sqlite"), engine)
        taken = time.perf_counter() - began
        own = [row.seconds for row in store.rows() if row.status == "done"]
    assert len(own) == len(runs)
    return taken, statistics.median(own)


def budget(seconds):
    """Iterations of a search that takes about so long, here and now."""
    few = 500
    runs = planned(3, few)
    run_study(Study(NOTHING, tuple(runs[:1])))
    store = run_study(Study(NOTHING, tuple(runs)))
    return max(1, int(few * seconds / statistics.median(row.seconds for row in store.rows())))


def main():
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=60)
    parser.add_argument("--seconds", type=float, default=0.3, help="of a run")
    parser.add_argument("--rounds", type=int, default=3, help="of which the median is told")
    parser.add_argument("--json", help="file to write the figures to")
    given = parser.parse_args()
    iterations = budget(given.seconds)
    figures = {}
    rounds = [{} for _ in range(given.rounds)]
    for measured in rounds:  # by turns: what the machine does meanwhile hits all of them alike
        for name, make in ENGINES.items():
            workers, engine = make()
            started, _ = seconds_of(planned(workers, 1), engine)
            few, _ = seconds_of(idle(workers), make()[1])
            many, _ = seconds_of(idle(500), make()[1])
            whole, own = seconds_of(planned(given.runs, iterations), make()[1])
            measured[name] = (started, max(many - few, 0.0) / 500, whole, own)
    print(f"{given.runs} runs of {iterations} iterations, medians of {given.rounds} rounds")
    print("engine                 start      per run   whole   run itself   runs/s without the start   against one")
    alone = None
    for name in ENGINES:
        start, each, whole, own = (statistics.median(one[name][k] for one in rounds) for k in range(4))
        rate = given.runs / max(whole - start, 1e-9)
        alone = rate if name.endswith(("in-process", "1 worker")) else alone
        gain = rate / alone
        figures[name] = {"start": start, "per_run": each, "whole": whole, "run": own, "rate": rate, "gain": gain}
        print(f"{name:21} {start:6.2f} s {1e3 * each:7.2f} ms {whole:6.2f} s {own:8.3f} s {rate:15.2f} {gain:20.2f}")
    if given.json:
        Path(given.json).write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
