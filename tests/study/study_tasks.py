"""Tasks that do all that a task may do, for engines to be tried on."""

import json
import os
import signal
import subprocess
import sys
import time

from selfmotion.study import Dask, InProcess, Processes, Run, Study, run_study

SMALL = {
    "study": "small",
    "problems": {
        "arms": {"three": {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 3.141592653589793], None]}},
        "paths": {
            "curve": {
                "kind": "bezier",
                "control_points": [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]],
            },
            "line": {"kind": "line", "start": [50, -10], "end": [60, 20]},
        },
    },
    "options": {"samples": 200, "elbow": "positive"},
    "planners": {
        "sinusoid": {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4]},
        "proof": {"kind": "global", "gap": 1e-2},
    },
    "optimizers": {
        "PSO": {"kind": "pso", "population": 8, "iterations": 10, "bounds": [0, 5]},
        "GWO": {"kind": "gwo", "population": 8, "iterations": 10, "bounds": [0, 5]},
    },
    "seeds": {"first": 1, "count": 3},
}
ENGINES = {
    "in-process": InProcess, "threads": lambda: InProcess(3), "processes": lambda: Processes(2),
    "dask": lambda: Dask(workers=2),
}  # fmt: skip


def number(specification):
    return {"status": "solved", "cost": 1.0 / (1 + specification["seed"]), "history": [0.1, specification["seed"]]}


def failing(specification):
    raise ArithmeticError(f"no number for {specification['seed']}")


def no_json(specification):
    return {"cost": float("nan")}


def deadly(specification):
    """Kills its worker, as long as a file is there; takes it away if told so."""
    file = specification["file"]
    if os.path.exists(file):
        if specification["once"]:
            os.remove(file)
        os.kill(os.getpid(), signal.SIGKILL)
    return number(specification)


def sleeping(specification):
    time.sleep(specification["seconds"])
    return number(specification)


def threads(specification):
    from threadpoolctl import threadpool_info

    return {"threads": max(part["num_threads"] for part in threadpool_info() if part["user_api"] == "blas")}


def runs(task, count=8, **more):
    return [Run(f"study_tasks:{task}", {"seed": k, **more}, f"problem {k}", task, "", k) for k in range(count)]


def study(*some):
    return Study("tried", tuple(some))


def contents(store):
    """All of a store's rows that must not depend on who worked them off."""
    return {
        row.id: (row.status, repr(row.result), repr(row.history), _without_trace(row.failure)) for row in store.rows()
    }


def _without_trace(failure):
    return failure and (failure["type"], failure["message"])


def rows_of(file, engine):
    """The contents of a study file's rows by an engine, in a process of its own.

    One that compiles a kernel itself may round otherwise in the last digit than one that finds it compiled.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-W", "error", __file__, str(file), engine]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    return {key: (*row[:3], row[3] and tuple(row[3])) for key, row in json.loads(done.stdout).items()}


if __name__ == "__main__":
    print(json.dumps(contents(run_study(Study.load(sys.argv[1]), engine=ENGINES[sys.argv[2]]()))))
