"""Arguments and options that several commands have, and what is read of them."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.errors import InvalidInputError

if TYPE_CHECKING:
    from selfmotion.problem import Problem

ProblemArgument = Annotated[str, typer.Argument(metavar="PROBLEM", help="Problem file, YAML or JSON.")]
TrajectoryArgument = Annotated[
    str, typer.Argument(metavar="TRAJECTORY", help="Motion as CSV with columns r, q1, …, qn.")
]
OutOption = Annotated[str | None, typer.Option("--out", metavar="DIR", help="Folder to write results to.")]
SaveOption = Annotated[str | None, typer.Option("--save", metavar="FILE", help="Store the plan, as time reads it.")]
ReportOption = Annotated[
    str | None, typer.Option("--report", metavar="FILE", help="Write one self-contained HTML page to send.")
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace files that selfmotion did not write.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
SeedOption = Annotated[int | None, typer.Option("--seed", metavar="N", help="Seed of the random numbers.")]
MaxStepOption = Annotated[
    float, typer.Option("--max-step", min=0.0, help="Largest joint step between rows [rad; m of a rail].")
]


def planar_only(case: Problem, source: str, what: str) -> None:
    """Refuse an arm in space where only the plane is drawn or searched."""
    from selfmotion.paths.base import PLANE

    if case.arm.dimension != PLANE:
        remedy = "use plan, verify or compare for an arm in space"
        raise InvalidInputError("arm", f"moves in space, and {what} planar arms only", remedy, source=source)


def numbers(option: str, text: str) -> float | list[float]:
    """Return the one number, or the numbers, of an option such as 2,2,1.5."""
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        raise InvalidInputError(option, "is no list of numbers", "write 2 or 2,2,1.5", text) from None
    return values[0] if len(values) == 1 else values


def warn(case: Problem) -> None:
    """Say on stderr what is doubtful about a problem."""
    say_warnings(case.warnings)


def say_warnings(warnings: Iterable[str]) -> None:
    """Print warnings on stderr."""
    for warning in warnings:
        print(f"selfmotion: warning: {warning}", file=sys.stderr)
