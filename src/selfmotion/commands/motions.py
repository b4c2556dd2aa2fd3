"""Commands that make motions, mend them and judge them."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion._version import __version__
from selfmotion.commands.options import (
    ForceOption,
    JsonOption,
    MaxStepOption,
    OutOption,
    ProblemArgument,
    ReportOption,
    SaveOption,
    SeedOption,
    TrajectoryArgument,
    planar_only,
    warn,
)
from selfmotion.commands.printed import (
    comparison_lines,
    complain,
    json_text,
    margin_lines,
    plan_lines,
    say,
    shown_progress,
)
from selfmotion.errors import InvalidInputError, SelfMotionError
from selfmotion.failures import error_object, failure_object

if TYPE_CHECKING:
    from selfmotion.exchange import OutputFolder
    from selfmotion.plans import Plan
    from selfmotion.problem import Problem

_MOST_LINES = 40  # of one kind on the terminal


def plan(
    problem: ProblemArgument,
    out: OutOption = None,
    as_json: JsonOption = False,
    seed: SeedOption = None,
    force: ForceOption = False,
    save: SaveOption = None,
    report: ReportOption = None,
) -> None:
    """Plan a joint motion; --out writes plan.json, trajectory.csv and figures, --save the plan, --report a page."""
    from selfmotion.exchange import OutputFolder, load_problem, trajectory_csv

    case, planner = load_problem(problem)
    if planner is None:
        raise InvalidInputError("planner", "is missing", "add planner: {kind: sinusoid, …}", source=problem)
    folder = None if out is None else OutputFolder(out, force)
    if folder is not None:
        from selfmotion.plot import plan_figure_names

        names = ["plan.json", "trajectory.csv", *plan_figure_names(case.arm)]
        folder.check(names)
    stored = [] if save is None else [_target(save, force, case, problem)]
    stored += [] if report is None else [_report_target(report, force)]
    warn(case)
    if seed is not None:
        if seed < 0:
            raise InvalidInputError("--seed", "is negative", "give a whole number from 0", seed)
        planner = planner.with_seed(seed)
    try:
        with shown_progress("planning") as progress:
            result = planner.plan(case, progress)
    except InvalidInputError as error:
        raise error.inside(source=problem) from None
    except SelfMotionError as error:
        if folder is not None:  # an earlier motion must not stay behind as if it were the answer
            folder.write({"plan.json": json_text(failure_object(error)).encode()}, outdated=names)
        _remove_stored(stored)
        raise
    summary = result.summary() | ({"warnings": list(case.warnings)} if case.warnings else {})
    not_stored = None if save is None else _save(result, save, force)
    if folder is not None:
        from selfmotion.plot import plan_figures

        files = {"plan.json": json_text(summary).encode(), "trajectory.csv": trajectory_csv(result)}
        folder.write(files | plan_figures(result))
    if report is not None:
        _write_report(result, problem, report, force)
    if as_json:
        say(json_text(summary if not_stored is None else {**summary, "error": error_object(not_stored)}))
    else:
        stored_line = [f"plan stored in {save}"] if save is not None and not_stored is None else []
        written_lines = [f"written to {place}" for place in (out, report) if place is not None]
        say("\n".join([plan_lines(summary, case.arm.limits.unit), *stored_line, *written_lines]))
    if not_stored is not None:  # the motion, which is good all the same, was not lost
        with suppress(SelfMotionError):  # a disk that refuses to store may refuse to remove
            _remove_stored(stored[:1])
        complain(not_stored)
        raise typer.Exit(not_stored.exit_code)


def _target(file: str, force: bool, case: Problem, source: str) -> tuple[OutputFolder, str]:
    """Return where a plan is to be stored; refuse before planning what could not be."""
    from selfmotion.exchange.files import checked_target
    from selfmotion.exchange.plan_file import check_storable

    target = checked_target(file, force)
    try:
        check_storable(case)
    except InvalidInputError as error:
        raise error.inside(source=source) from None
    return target


def _report_target(file: str, force: bool) -> tuple[OutputFolder, str]:
    """Return where a page is to be written; refuse before planning what could not be."""
    from selfmotion.exchange.files import checked_target

    if not file.lower().endswith((".html", ".htm")):
        raise InvalidInputError("--report", "is no name of a page", "end it in .html", file)
    return checked_target(file, force)


def _save(plan: Plan, file: str, force: bool) -> SelfMotionError | None:
    """Store a plan; return why that failed."""
    try:
        plan.save(file, force)
    except SelfMotionError as error:
        return error
    return None


def _write_report(plan: Plan, source: str, file: str, force: bool) -> None:
    from selfmotion.exchange import read_text, write_file
    from selfmotion.exchange.yaml_text import parse_yaml
    from selfmotion.studio.report_page import report_page

    text = read_text(source)
    write_file(file, report_page(plan, parse_yaml(text, source), text, os.path.basename(source)), force)


def _remove_stored(stored: list[tuple[OutputFolder, str]]) -> None:
    """Remove the plan and the page that an earlier run stored: they must not stay behind as if they were the answer."""
    for folder, name in stored:
        if os.path.exists(folder.path / name):
            folder.write({}, outdated=[name])


def repair(
    problem: ProblemArgument,
    trajectory: TrajectoryArgument,
    out: Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write the repaired motion to.")],
    as_json: JsonOption = False,
    keep: Annotated[
        float, typer.Option("--keep", min=0.0, help="Joint travel [rad] that keeping all given rows may cost.")
    ] = 30.0,
    force: ForceOption = False,
) -> None:
    """Say where a motion breaks n-connectivity and why, and mend it by self-motion."""
    from dataclasses import asdict

    from selfmotion.exchange import OutputFolder, load_problem, motion_csv, read_trajectory
    from selfmotion.mending import repair as mend
    from selfmotion.plot import motion_figures

    case, _ = load_problem(problem)
    planar_only(case, problem, "repair mends motions of")
    motion = read_trajectory(trajectory, case.arm.n)
    folder = OutputFolder(out, force)
    figures = [f"{name}.{suffix}" for name in ("before", "after") for suffix in ("png", "svg")]
    names = ["repaired.csv", "repair.json", *figures]
    folder.check(names)
    try:
        found = mend(case, motion.r, motion.q, keep=keep)
    except InvalidInputError as error:
        raise error.inside(source=trajectory if error.field.startswith("row") else problem) from None
    except SelfMotionError as error:
        folder.write({"repair.json": json_text(failure_object(error)).encode()}, outdated=names)
        raise
    status = "repaired" if found.breaks or not found.kept.all() or len(found.r) > len(motion.r) else "holds"
    result = {
        "status": status,
        "breaks": [{**asdict(part), "text": str(part)} for part in found.breaks],
        "rows_given": len(motion.r),
        "rows_kept": int(found.kept.sum()),
        "rows": len(found.r),
        "l1_travel": found.judgement.l1_travel,
        "max_tracking_error": found.judgement.max_tracking_error,
        "max_joint_step": found.judgement.max_joint_step,
        "min_limit_margin": found.judgement.min_limit_margin,
        **({"margins": found.judgement.margins} if found.judgement.margins else {}),
        "version": __version__,
    }
    files = {
        "repaired.csv": motion_csv(case.arm, found.r, found.q, case.arm.u_of(found.q)),
        "repair.json": json_text(result).encode(),
        **motion_figures("before", case, motion.r, motion.q, found.breaks),
        **motion_figures("after", case, found.r, found.q),
    }
    folder.write(files)
    lines = [str(part) for part in found.breaks[:_MOST_LINES]]
    lines += [f"… and {len(found.breaks) - _MOST_LINES} more, see repair.json"] * (len(found.breaks) > _MOST_LINES)
    lines.append(
        f"{status}: {result['rows_kept']} of {result['rows_given']} rows kept, {result['rows']} rows in all, "
        f"joint travel {result['l1_travel']:.6g} rad, written to {out}"
    )
    say(json_text(result) if as_json else "\n".join(lines))


def verify(
    problem: ProblemArgument,
    trajectory: TrajectoryArgument,
    as_json: JsonOption = False,
    tolerance: Annotated[
        float, typer.Option("--tolerance", min=0.0, help="Tool off the path at a row, in parts of the reach.")
    ] = 1e-6,
    tolerance_between: Annotated[
        float, typer.Option("--tolerance-between", min=0.0, help="The same between rows.")
    ] = 1e-2,
    max_step: MaxStepOption = 0.5,
    optimum: Annotated[
        bool, typer.Option("--optimum/--no-optimum", help="Whether to say how far from the best possible it is.")
    ] = True,
    gap: Annotated[
        float, typer.Option("--gap", min=1e-9, max=1.0, help="How sharp the bound on every motion shall be.")
    ] = 1e-3,
    time_limit: Annotated[
        float, typer.Option("--time-limit", metavar="S", help="Seconds after which it is taken as it is; above 0.")
    ] = 10.0,
) -> None:
    """Judge a motion that anyone made: tracking, limits, continuity, travel, and how far from the best possible it is.

    Exit 0: it holds; 1: it does not.
    """
    from dataclasses import asdict

    from selfmotion.exchange import load_problem, read_trajectory
    from selfmotion.judgement import Tolerances, judge
    from selfmotion.planners import Distance, Global, distance_from_optimum

    allowed = Tolerances(tolerance, tolerance_between, step=max_step)
    prover = Global(gap, time_limit)
    case, _ = load_problem(problem)
    motion = read_trajectory(trajectory, case.arm.n)
    verdict = judge(case, motion.r, motion.q, allowed)
    distance = Distance(verdict.cost_sampled, reason="not asked for" if verdict.holds else "the motion does not hold")
    if verdict.holds and optimum:
        with shown_progress("proving a bound") as report:
            distance = distance_from_optimum(case, motion.r, motion.q, prover, allowed, report)
    if as_json:
        status = {"status": "holds" if verdict.holds else "broken"}
        more = {**distance.summary(), "rows": len(motion.r), "version": __version__}
        say(json_text({**status, **asdict(verdict), **more}))
    elif verdict.holds:
        travel = f"the motion holds: travel {verdict.cost_sampled:.9g}, tracking {verdict.max_tracking_error:.2g}"
        say("\n".join([travel, *margin_lines(verdict.margins)]))
        if optimum:
            say(f"  {distance}")
    else:
        say("\n  ".join(["the motion does not hold:", *map(str, verdict.failures)]))
    raise typer.Exit(0 if verdict.holds else 1)


def compare(
    problem: ProblemArgument,
    trajectories: Annotated[
        list[str] | None, typer.Argument(metavar="[TRAJECTORY]…", help="Motions of others, as for verify.")
    ] = None,
    as_json: JsonOption = False,
    ladder: Annotated[
        str, typer.Option("--ladder", metavar="N,…", help="Values of u per branch of each plain ladder; '' for none.")
    ] = "60,240",
    max_step: MaxStepOption = 0.5,
) -> None:
    """Put our shortest motion with its proof beside plain ladders and the motions of others."""
    from selfmotion.exchange import load_problem, read_trajectory
    from selfmotion.judgement import Tolerances
    from selfmotion.planners import Global, compare_ladder, compare_plan, compare_rows

    sizes = _sizes(ladder)
    allowed = Tolerances(step=max_step)
    case, planner = load_problem(problem)
    given = {file: read_trajectory(file, case.arm.n) for file in trajectories or ()}
    try:
        with shown_progress("planning") as report:
            plan = (planner if isinstance(planner, Global) else Global()).plan(case, report)
    except InvalidInputError as error:
        raise error.inside(source=problem) from None
    rows = [compare_plan(plan), *(compare_ladder(plan, size, allowed) for size in sizes)]
    rows += [compare_rows(file, plan, motion.r, motion.q, allowed) for file, motion in given.items()]
    result = {
        "status": "solved" if rows[0].holds else "unknown",
        "objective": case.objective.kind,
        "lower_bound": plan.lower_bound,
        **({} if plan.estimated_bound is None else {"estimated_bound": plan.estimated_bound}),
        "motions": [row.summary() for row in rows],
        "version": __version__,
    }
    say(json_text(result) if as_json else "\n".join(comparison_lines(result)))


def _sizes(text: str) -> list[int]:
    """Return the numbers of an option such as 60,240."""
    from selfmotion.planners.ladder import MOST_VALUES

    words = [word.strip() for word in text.split(",")] if text.strip() else []
    sizes = [int(word) if word.isascii() and word.isdigit() else 0 for word in words]
    if not all(0 < size <= MOST_VALUES for size in sizes):
        raise InvalidInputError(
            "--ladder", "is no list of numbers", f"write 60,240: each from 1 to {MOST_VALUES}", text
        )
    return sizes
