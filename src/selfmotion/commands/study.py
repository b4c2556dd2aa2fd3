"""Commands for studies: many problems, many seeds."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from selfmotion.commands.options import ForceOption, JsonOption
from selfmotion.commands.printed import json_text, say, table_lines
from selfmotion.errors import InvalidInputError

if TYPE_CHECKING:
    from rich.table import Table

    from selfmotion.study import Engine, Step, Store, Study

studies = typer.Typer(no_args_is_help=True, help="Run many problems with many seeds; whatever ends it, it goes on.")

StudyArgument = Annotated[str, typer.Argument(metavar="STUDY", help="Study file, YAML or JSON.")]
StoreOption = Annotated[
    str | None, typer.Option("--store", metavar="FILE", help="Where outcomes are kept; else beside the study, .sqlite.")
]
_ENGINES = ("process", "in-process", "dask")


def _loaded(study: str, store: str | None) -> tuple[Study, Store]:
    from selfmotion.study import Store, Study

    return Study.load(study), Store(store if store is not None else os.path.splitext(study)[0] + ".sqlite")


@studies.command()
def run(
    study: StudyArgument,
    store: StoreOption = None,
    workers: Annotated[
        int | None, typer.Option("--workers", metavar="N", min=1, max=1024, help="Processes; else one per processor.")
    ] = None,
    engine: Annotated[
        str | None, typer.Option("--engine", metavar="process|in-process|dask", help="Where runs are worked off.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Of a dask cluster, such as tcp://host:8786.")
    ] = None,
    limit: Annotated[int | None, typer.Option("--limit", metavar="N", min=1, help="Do at most N runs now.")] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Do failed runs again.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Do the runs of a study that have no outcome yet; interrupted, it goes on where it was."""
    from selfmotion.study import run_study
    from selfmotion.study.tables import study_status

    chosen = _engine(engine, workers, scheduler)
    case, kept = _loaded(study, store)
    try:
        with _live(case) as progress:
            run_study(case, kept, chosen, progress, limit=limit, retry=retry)
    except KeyboardInterrupt:
        status = study_status(case, kept)
        finished = status["done"] + status["failed"]
        print(
            f"selfmotion: interrupted; {finished} of {status['runs']} runs are kept, run again to go on",
            file=sys.stderr,
        )
        raise typer.Exit(130) from None
    status = study_status(case, kept)
    say(json_text(status) if as_json else "\n".join([_counts(status), f"kept in {kept.file}"]))
    if status["failed"]:
        remedy = "export them to see why, --retry does them again"
        print(f"selfmotion: {status['failed']} runs failed; {remedy}", file=sys.stderr)
        raise typer.Exit(1)


@studies.command()
def status(study: StudyArgument, store: StoreOption = None, as_json: JsonOption = False) -> None:
    """Say how far a study is."""
    from selfmotion.study.tables import study_status

    found = study_status(*_loaded(study, store))
    say(json_text(found) if as_json else "\n".join([_counts(found), *_method_lines(found)]))


@studies.command()
def report(
    study: StudyArgument,
    out: Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write the report to.")],
    store: StoreOption = None,
    force: ForceOption = False,
) -> None:
    """Write what is done of a study as tables with tests, a figure, and rows."""
    from selfmotion.exchange import OutputFolder
    from selfmotion.study.report import FILES, report_files

    folder = OutputFolder(out, force)
    folder.check(FILES)
    files = report_files(*_loaded(study, store))
    folder.write(files, outdated=FILES)
    say(os.path.join(out, "report.md"))


@studies.command()
def export(
    study: StudyArgument,
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="File to write, .csv or .parquet.")],
    store: StoreOption = None,
    force: ForceOption = False,
) -> None:
    """Write the rows of a study as CSV or Parquet."""
    from selfmotion.exchange.files import checked_target, write_file
    from selfmotion.study import study_table
    from selfmotion.study.tables import csv_bytes, parquet_bytes

    forms = {".csv": csv_bytes, ".parquet": parquet_bytes}
    suffix = os.path.splitext(out)[1]
    if suffix not in forms:
        raise InvalidInputError("--out", "is neither a CSV nor a Parquet file", "name one in .csv or .parquet", out)
    checked_target(out, force)
    table = study_table(*_loaded(study, store), histories=True)
    write_file(out, forms[suffix](table), force)
    say(f"{len(table)} rows written to {out}")


def _engine(name: str | None, workers: int | None, scheduler: str | None) -> Engine:
    from selfmotion._checks import choice
    from selfmotion.study import Dask, InProcess, Processes

    name = choice("--engine", name if name is not None else "dask" if scheduler is not None else "process", _ENGINES)
    if scheduler is not None and (name != "dask" or workers is not None):
        other = "--workers" if name == "dask" else "--engine"
        raise InvalidInputError("--scheduler", f"is given with {other}", "leave one of the two out", scheduler)
    if name == "in-process":
        if workers is not None:
            raise InvalidInputError("--workers", "is given with --engine in-process", "leave one out", workers)
        return InProcess()
    count = workers if workers is not None else len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    return Dask(scheduler, count) if name == "dask" else Processes(count)


def _counts(status: dict[str, Any]) -> str:
    others = f"; {status['others']} more of earlier versions of the study" if status["others"] else ""
    return (
        f"{status['study']}: {status['done']} of {status['runs']} runs done, {status['failed']} failed, "
        f"{status['left']} left{others}"
    )


def _method_lines(status: dict[str, Any]) -> list[str]:
    names = ("planner", "optimizer", "done", "failed", "left")
    return table_lines(names, [[str(row[name]) or "–" for name in names] for row in status["methods"]])


@contextmanager
def _live(study: Study) -> Iterator[Callable[[Step], None] | None]:
    """Give a progress callback that draws a table on a terminal; None, and silence, when piped."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.live import Live

    board = _Board(study)
    with Live(get_renderable=board.table, console=Console(stderr=True), refresh_per_second=4, transient=True):
        yield board


class _Board:
    """How far a study is, method by method."""

    def __init__(self, study: Study) -> None:
        import time

        self._clock, self._began = time.monotonic, time.monotonic()
        self._name, self._done, self._total, self._now = study.name, 0, 0, 0
        self._counts: dict[tuple[str, str], Counter[str]] = {}

    def __call__(self, step: Step) -> None:
        import json

        self._done, self._total = step.done, step.total
        self._now += 1
        counts = self._counts.setdefault((step.run.planner, step.run.optimizer), Counter())
        result = step.outcome.result
        counts["failed" if result is None else str(json.loads(result).get("status"))] += 1

    def table(self) -> Table:
        """Return what is to be shown now."""
        from rich.table import Table

        seconds = self._clock() - self._began
        left = (self._total - self._done) * seconds / self._now if self._now else None
        title = f"{self._name}: {self._done} of {self._total or '…'} runs"
        shown = Table(title=title if left is None else f"{title}, {left:.0f} s left")
        names = ("solved", "infeasible", "unknown", "failed")
        for name in ("planner", "optimizer", *names):
            shown.add_column(name, justify="right" if name in names else "left")
        for (planner, optimizer), counts in list(self._counts.items()):
            shown.add_row(planner, optimizer, *(str(counts[name] or "") for name in names))
        return shown
