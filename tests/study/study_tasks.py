"""Tasks that do all that a task may do, for engines to be tried on."""

import os
import signal
import time

from selfmotion.study import Run, Study


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
