"""What commands print: verdicts, tables and JSON of results, errors in one line, and progress."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from selfmotion.errors import InvalidInputError, SelfMotionError

if TYPE_CHECKING:
    from selfmotion.optimizers import Progress
    from selfmotion.paths import Path
    from selfmotion.timing import TimedTrajectory

_MOST_LINES = 40  # of one kind on the terminal
_FEW = 5  # of what is listed on one line


def comparison_lines(result: dict[str, Any]) -> list[str]:
    """Return the lines of a comparison."""
    estimated = "estimated_bound" in result
    gap = "estimated_gap" if estimated else "gap"
    header = (
        "motion",
        "holds",
        "cost",
        gap.replace("_", " "),
        "chord sum",
        "l2 waypoints",
        "largest step",
        "jumps",
        "time",
    )

    def shown(value: float | None, form: str = ".6g", unit: str = "") -> str:
        return "–" if value is None else f"{value:{form}}{unit}"

    motions = result["motions"]
    rows = [
        (
            row["name"], yes_or_no(row["holds"]), shown(row["cost"]), shown(row.get(gap), ".2%"),
            shown(row["cost_sampled"]), shown(row["l2_waypoints"]), shown(row["max_joint_step"], ".3g"),
            shown(row["jumps"], "d"), shown(row["seconds"], ".2f", " s"),
        )
        for row in motions
    ]  # fmt: skip
    says = "no motion costs less than" if not estimated else "motions are estimated to cost no less than"
    bound = result["estimated_bound" if estimated else "lower_bound"]
    lines = [f"objective {result['objective']}: {says} {bound:.6g}"]
    lines += table_lines(header, rows)
    return lines + [f"{row['name']}: {row['why_not']}" for row in motions if row["why_not"]]


def table_lines(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table, columns two spaces apart."""
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in (header, *rows)]
    return [line.rstrip() for line in lines]


def yes_or_no(value: bool) -> str:
    """Return a word."""
    return "yes" if value else "no"


def say(text: str) -> None:
    """Print to stdout; a reader that has gone away changes nothing, a full disk is said."""
    try:
        print(text.removesuffix("\n"), flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 (nothing more can be said there)
        raise InvalidInputError("stdout", f"cannot be written to ({error.strerror})", "make room") from None


def complain(error: SelfMotionError) -> None:
    """Print an error on stderr, on one line."""
    print("selfmotion: " + " ".join(str(error).split()), file=sys.stderr)


def plan_lines(summary: dict[str, Any], unit: str) -> str:
    """Return what is said of a plan, steps and margins in the `unit` of its arm's joints."""
    parameters = summary["parameters"]
    chosen = [f"{name} = {value:.6g}" for name, value in parameters.items() if isinstance(value, float)]
    if "kept" in parameters:  # of what, planner widest was told
        chosen.insert(0, parameters["settings"]["margin"].replace("_", " "))
    if "elbow" in parameters:
        elbow = parameters["elbow"]
        chosen.append(f"{elbow} elbow" if elbow in ("positive", "negative") else f"branch {elbow}")
    chosen += [parameters[name] for name in ("stopped", "argument") if name in parameters]
    margin = summary["min_limit_margin"]
    error = "unknown" if summary["cost_error"] is None else f"{summary['cost_error']:.0e}"
    return "\n".join(
        [
            f"solved: cost {summary['cost']:.9g} (error {error}), {summary['cost_sampled']:.9g} as a chord sum",
            *_bound(summary),
            f"  {', '.join([summary['planner'], *chosen])}; "
            f"{_counted('evaluation', summary['evaluations'])} in {summary['wall_time_s']:.2f} s",
            f"  tool within {summary['max_tracking_error']:.1e} of the path, largest joint step "
            f"{summary['max_joint_step']:.3g} {unit}, "
            + ("no joint is limited" if margin is None else f"{margin:.4g} {unit} from the nearest limit"),
            *margin_lines(summary.get("margins", {})),
        ]
    )


def margin_lines(margins: dict[str, float]) -> list[str]:
    """Return what is said of constraints beyond joint limits, one line or none."""
    said = [f"{name} {margin:.3g}" for name, margin in margins.items()]
    return [f"  left beyond what is asked for: {', '.join(said)}"] if said else []


def _bound(summary: dict[str, Any]) -> list[str]:
    """Return the line that says what is proved of every other motion, or estimated, if anything is."""
    from selfmotion.certificate.verdict import verdict

    cost, error = summary["cost"], summary["cost_error"]
    for rigorous, name, gap, says in (
        (True, "lower_bound", "gap", "no motion costs less than"),
        (False, "estimated_bound", "estimated_gap", "motions are estimated to cost no less than"),
    ):
        bound = summary.get(name)
        if bound is not None:
            within = verdict(cost, math.inf if error is None else error, bound, rigorous=rigorous)
            left = "unknown" if summary.get(gap) is None else f"{summary[gap]:.1e}"
            return [f"  cost {within}: {says} {bound:.9g} ({gap.replace('_', ' ')} {left})"]
    return []


def timed_lines(timed: TimedTrajectory) -> list[str]:
    """Return what is said of a time law: how near to limits it gets, where it stops, and where it is slow."""
    units = timed.plan.problem.arm.limits.units
    fast, strong = timed.largest
    jerk: dict[str, float] = {}
    for unit, most in zip(units, timed.jerk.tolist(), strict=True):
        jerk[unit] = max(most, jerk.get(unit, 0.0))
    unlimited = [
        f"{name} up to {abs(speeds).max():.3g} {unit}/s"
        for name, unit, speeds in zip(timed.joint_names, units, timed.dq.T, strict=True)
        if name in timed.unlimited
    ]
    velocities = f"velocities up to {fast.max():.1%} of their limits, " * (len(unlimited) < len(units))
    lines = [
        f"  {velocities}accelerations up to {strong.max():.1%}{'' if velocities else ' of their limits'}, "
        f"jerk between rows up to {' and '.join(f'{most:.3g} {unit}/s³' for unit, most in jerk.items())}"
    ]
    if unlimited:
        lines.append(f"  velocities not limited: {', '.join(unlimited)}; --max-velocity limits them")
    if timed.stops:
        places = ", ".join([*(f"{r:.6g}" for r in timed.stops[:_FEW]), *["…"] * (len(timed.stops) > _FEW)])
        remedy = "; points joined by interpolation: spline have none" * _has_points(timed.plan.problem.path)
        lines.append(f"  stands still at {_counted('corner', len(timed.stops))}, r = {places}{remedy}")
    lines += [f"  slower than asked for at {part}" for part in timed.slow[:_MOST_LINES]]
    more = len(timed.slow) - _MOST_LINES
    return lines + [f"  … and {_counted('more stretch', more, 'es')}, see --json"] * (more > 0)


def _has_points(path: Path) -> bool:
    """Return whether a path, or the one inside it, joins points that were given."""
    from selfmotion.paths import PoseWaypoints, Waypoints

    while not isinstance(path, Waypoints | PoseWaypoints):
        inner = getattr(path, "path", getattr(path, "position", None))
        if inner is None:
            return False
        path = inner
    return True


def _counted(name: str, count: int, plural: str = "s") -> str:
    return f"{count} {name}{plural * (count != 1)}"


def json_text(value: Any) -> str:
    """Return `value` as a JSON text, with null for numbers that are not finite."""
    return json.dumps(_known(value), indent=1, allow_nan=False) + "\n"


def _known(value: Any) -> Any:
    """Return `value` with null for numbers that are not finite, however deep inside: JSON has none."""
    if isinstance(value, dict):
        return {key: _known(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_known(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def shown_progress(title: str) -> Iterator[Progress | None]:
    """Give a progress callback that draws on a terminal; None, and silence, when piped."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bars

    columns = [TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[best]}"), TimeRemainingColumn()]
    with Bars(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None, best="")

        def report(done: int, total: int, best: float) -> None:
            bar.update(task, completed=done, total=total or None, best=f"best {best:.6g}" * math.isfinite(best))

        yield report
