"""Running a study: what is not done yet is handed to an engine, and every outcome is stored."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from typing import NamedTuple

from selfmotion.errors import InvalidInputError
from selfmotion.study.engines import Engine, InProcess, Outcome
from selfmotion.study.runs import Run, Study
from selfmotion.study.store import Store, Writer


class Step(NamedTuple):
    """What a run's end changed.

    Attributes
    ----------
    done, total : int
        Runs of the study that have an outcome, and all.
    run : Run
    outcome : Outcome
    """

    done: int
    total: int
    run: Run
    outcome: Outcome


def run_study(
    study: Study,
    store: Store | None = None,
    engine: Engine | None = None,
    progress: Callable[[Step], None] | None = None,
    *,
    limit: int | None = None,
    retry: bool = False,
) -> Store:
    """Do the runs of a study that have no outcome yet.

    Whatever ends it, every outcome that was stored stays, and the next call goes on from there.

    Parameters
    ----------
    study : Study
    store : Store, optional
        By default one in memory.
    engine : Engine, optional
        By default `InProcess`.
    progress : callable, optional
        Called after each run with a `Step`.
    limit : int, optional
        Largest number of runs to do now.
    retry : bool
        Whether failed runs are done again.

    Returns
    -------
    Store

    Raises
    ------
    InvalidInputError
        If the store is in use, damaged, another study's, or cannot be written to; or the engine cannot be reached.
    """
    store = Store() if store is None else store
    engine = InProcess() if engine is None else engine
    unique = study.unique()
    with store.writing() as writer:
        states = writer.states()
        _refuse_other(study, store, writer, states)
        writer.note(name=study.name, study=study.text)
        settled = {"done"} if retry else {"done", "failed"}
        left = [run for _, run in unique.values() if states.get(run.id) not in settled]
        done = len(unique) - len(left)
        outcomes = engine.outcomes(run.work() for run in islice(left, limit))
        try:
            for outcome in outcomes:
                position, run = unique[outcome.id]
                writer.add(run, position, outcome, retry)
                done += 1
                if progress is not None:
                    progress(Step(done, len(unique), run, outcome))
        finally:
            close = getattr(outcomes, "close", None)  # a generator ends its workers now, not when it is collected
            if close is not None:
                close()
    return store


def _refuse_other(study: Study, store: Store, writer: Writer, states: dict[str, str]) -> None:
    """Refuse the store of another study, with which this one has no run in common."""
    name = writer.known().get("name")
    if states and name not in (None, study.name) and not states.keys() & study.unique().keys():
        reason, remedy = f"is the store of the study {name!r}", "name another file with --store"
        raise InvalidInputError("", reason, remedy, source=str(store.file))
