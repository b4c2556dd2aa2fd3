"""Many problems, many seeds: studies that survive whatever ends them, on one machine or a cluster."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from selfmotion.study.engines import Dask, Engine, InProcess, Outcome, Processes, Work
    from selfmotion.study.running import Step, run_study
    from selfmotion.study.runs import Run, Study
    from selfmotion.study.store import Row, Store
    from selfmotion.study.tables import study_table

# Imported when first used: a worker process that needs one task does not wait for the forms of study files.
_HOME = {
    "engines": ("Dask", "Engine", "InProcess", "Outcome", "Processes", "Work"),
    "running": ("Step", "run_study"),
    "runs": ("Run", "Study"),
    "store": ("Row", "Store"),
    "tables": ("study_table",),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__all__ = [
    "Dask",
    "Engine",
    "InProcess",
    "Outcome",
    "Processes",
    "Row",
    "Run",
    "Step",
    "Store",
    "Study",
    "Work",
    "run_study",
    "study_table",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULE:
        raise AttributeError(f"module 'selfmotion.study' has no attribute {name!r}")
    value = getattr(import_module(f"selfmotion.study.{_MODULE[name]}"), name)
    globals()[name] = value
    return value
