"""The rows of a study as tables, CSV and Parquet."""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from collections.abc import Iterable
from typing import Any

from selfmotion.errors import MissingExtraError
from selfmotion.study.runs import Study
from selfmotion.study.store import Store

COLUMNS = (
    "position", "problem", "planner", "optimizer", "seed", "run", "status", "cost", "cost_error", "cost_sampled",
    "lower_bound", "gap", "l1_travel", "l2_travel", "max_tracking_error", "min_limit_margin", "max_joint_step",
    "reconfigurations", "evaluations", "timed_out", "failure", "seconds", "version", "finished_at", "id",
)  # fmt: skip
"""What is told of every run; from ``status`` to ``timed_out`` as in a result object."""
_OF_RESULT = COLUMNS[COLUMNS.index("status") : COLUMNS.index("failure")]


def study_table(study: Study, store: Store, histories: bool = False) -> list[dict[str, Any]]:
    """Return what is known of a study's runs, one dict of `COLUMNS` for each that has an outcome, in their order.

    Parameters
    ----------
    study : Study
    store : Store
    histories : bool
        Whether to add ``history``, the best cost so far of each search, and ``parameters``.

    Returns
    -------
    list of dict

    Raises
    ------
    InvalidInputError
        If the store is none, or damaged.
    """
    rows = {row.id: row for row in store.rows(run.id for run in study.runs)}
    table = []
    for position, run in enumerate(study.runs):
        row = rows.get(run.id)
        if row is None:
            continue
        result = row.result or {}
        values: dict[str, Any] = {
            "position": position, "problem": run.problem, "planner": run.planner, "optimizer": run.optimizer,
            "seed": run.seed, "run": row.status, **{name: result.get(name) for name in _OF_RESULT},
            "failure": row.failure and f"{row.failure['type']}: {row.failure['message']}",
            "seconds": row.seconds, "version": row.version, "finished_at": row.finished_at, "id": row.id,
        }  # fmt: skip
        if histories:
            values |= {"history": row.history, "parameters": result.get("parameters")}
        table.append(values)
    return table


def study_status(study: Study, store: Store) -> dict[str, Any]:
    """Return how far a study is: counts of all, and of every planner with each optimizer."""
    states = store.states()
    unique = study.unique()
    methods: dict[tuple[str, str], Counter[str]] = {}
    for _, run in unique.values():
        methods.setdefault((run.planner, run.optimizer), Counter())[states.get(run.id, "left")] += 1
    total: Counter[str] = sum(methods.values(), Counter())
    return {
        "study": study.name,
        "runs": len(unique),
        **{name: total[name] for name in ("done", "failed", "left")},
        "others": len(states.keys() - unique.keys()),
        "methods": [
            {"planner": planner, "optimizer": optimizer, **{name: part[name] for name in ("done", "failed", "left")}}
            for (planner, optimizer), part in methods.items()
        ],
    }


def csv_bytes(table: list[dict[str, Any]]) -> bytes:
    """Return a table as CSV, numbers in full."""
    return lines_as_csv(COLUMNS, ([row[name] for name in COLUMNS] for row in table))


def lines_as_csv(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> bytes:
    """Return rows as CSV, numbers in full; what is not known, None or NaN, is left empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([None if isinstance(value, float) and math.isnan(value) else value for value in row])
    return text.getvalue().encode()


def parquet_bytes(table: list[dict[str, Any]]) -> bytes:
    """Return a table as Parquet, with ``history``: best cost so far of each search, NaN while there is none.

    Raises
    ------
    MissingExtraError
        If pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        reason, remedy = "needs pyarrow to write Parquet", "pip install 'selfmotion[parquet]', or export CSV"
        raise MissingExtraError("--out", reason, remedy) from None
    kinds = dict.fromkeys(COLUMNS, pyarrow.float64())
    kinds |= dict.fromkeys(("problem", "planner", "optimizer", "run", "status", "failure"), pyarrow.string())
    kinds |= dict.fromkeys(("version", "finished_at", "id"), pyarrow.string())
    kinds |= dict.fromkeys(("position", "seed", "reconfigurations", "evaluations"), pyarrow.int64())
    kinds |= {"timed_out": pyarrow.bool_(), "history": pyarrow.list_(pyarrow.list_(pyarrow.float64()))}
    columns = {name: [row[name] for row in table] for name in COLUMNS}
    columns["history"] = [
        None if row.get("history") is None else [_numbers(part["best"]) for part in row["history"]] for row in table
    ]
    arrays = [pyarrow.array(values, kinds[name]) for name, values in columns.items()]
    sink = io.BytesIO()
    parquet.write_table(pyarrow.table(arrays, names=list(columns)), sink)
    return sink.getvalue()


def _numbers(values: list[float | None]) -> list[float]:
    return [float("nan") if value is None else value for value in values]
