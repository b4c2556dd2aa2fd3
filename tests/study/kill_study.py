"""Kills a study at random moments until it is done, and looks whether a row was lost, doubled or changed.

    python tests/study/kill_study.py --kills 1000

A study of short runs is begun in a process of its own, which is killed (SIGKILL, no chance to tidy up) at a random
moment: while it starts, while it opens its store, in the middle of a commit. It is begun again until it is done; then
its rows are held against those of a study that nobody disturbed. Studies follow one another until there were as many
kills as asked for. The exit is 1 if anything is lost, doubled, different or left behind.
"""

import argparse
import os
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from pathlib import Path

RUNS = 150
ENGINES = ("in-process", "process")


def quick(specification):
    """A task of some milliseconds."""
    time.sleep(specification["seconds"])
    rng = random.Random(specification["seed"])
    if specification["seed"] % 17 == 0:
        raise ArithmeticError(f"seed {specification['seed']}")
    best = sorted((rng.random() for _ in range(20)), reverse=True)
    return {"status": "solved", "cost": best[-1], "history": [{"best": best, "evaluations": list(range(20))}]}


def study(seconds=0.004, count=RUNS):
    from selfmotion.study import Run, Study

    task = "kill_study:quick"
    return Study(
        "quick", tuple(Run(task, {"seed": k, "seconds": seconds}, "none", "quick", "", k) for k in range(count))
    )


def child(file, engine):
    """What is killed."""
    from selfmotion.study import InProcess, Processes, Store, run_study

    run_study(study(), Store(file), InProcess() if engine == "in-process" else Processes(2))


def rows(file):
    """All that must not differ of the rows, in the order of their ids; straight from the database."""
    connection = sqlite3.connect(file)
    try:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        names = "id, position, seed, specification, status, result, failure, history"
        return connection.execute(f"SELECT {names} FROM runs ORDER BY id").fetchall()
    finally:
        connection.close()


def without_lines(found):
    """Rows whose tracebacks are left out: engines call tasks from different places."""
    return [(*row[:6], row[6] and row[6].split('"traceback"')[0], *row[7:]) for row in found]


def killed_until_done(folder, rng, kills, engine):
    """Run a study to its end, with at most `kills` kills; how many there were, and the rows."""
    file, done, longest = Path(folder) / "study.sqlite", 0, 0.3
    command = [sys.executable, __file__, "child", str(file), engine]
    while True:
        with (Path(folder) / "errors.txt").open("wb") as errors:  # no pipe, which what outlives it would keep open
            process = subprocess.Popen(command, start_new_session=True, stderr=errors)
        began = time.monotonic()
        try:
            process.wait(timeout=None if done >= kills else rng.uniform(0.0, longest))
        except subprocess.TimeoutExpired:
            process.kill()  # this one alone: what it started must see to itself
            process.wait()
            done += 1
            longest = min(longest * 1.1, 4.0)  # so that it gets on
            assert ended(process.pid), "worker processes outlived the study"
            continue
        assert process.returncode == 0, (Path(folder) / "errors.txt").read_text()
        assert ended(process.pid)
        assert time.monotonic() - began < 120
        return done, rows(file)


def ended(group, seconds=20.0):
    """Whether no process of a group is left, soon."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.01)
    os.killpg(group, signal.SIGKILL)
    return False


def wrong(found, undisturbed):
    """What is wrong with the rows, as text; empty if nothing is."""
    ids, expected = [row[0] for row in found], [row[0] for row in undisturbed]
    lost, doubled = len(set(expected) - set(ids)), len(ids) - len(set(ids))
    differ = sum(row not in undisturbed for row in found)
    return f"{lost} lost, {doubled} doubled, {differ} different" if lost or doubled or differ else ""


def main(arguments=None):
    if (arguments or sys.argv[1:])[:1] == ["child"]:
        child(*(arguments or sys.argv[1:])[1:])
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--engine", choices=(*ENGINES, "both"), default="both")
    given = parser.parse_args(arguments)
    rng, kills, studies, bad = random.Random(given.seed), 0, 0, []
    with tempfile.TemporaryDirectory() as folder:
        _, undisturbed = killed_until_done(folder, rng, 0, "in-process")
    undisturbed = without_lines(undisturbed)
    while kills < given.kills:
        engine = ENGINES[studies % 2] if given.engine == "both" else given.engine
        with tempfile.TemporaryDirectory() as folder:
            done, found = killed_until_done(folder, rng, given.kills - kills, engine)
        kills, studies = kills + done, studies + 1
        problem = wrong(without_lines(found), undisturbed)
        bad += [problem] * bool(problem)
        print(
            f"study {studies}, {engine}: {done} kills, {kills} in all, {problem or 'all rows there and equal'}",
            flush=True,
        )
    print(f"{kills} kills in {studies} studies of {RUNS} runs: {len(bad)} of them with rows lost, doubled or different")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
