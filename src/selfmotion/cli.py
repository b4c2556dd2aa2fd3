"""The command line. Everything heavy is imported inside the commands: ``--help`` answers at once."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from selfmotion._printed import _blocked, _compared, _failure, _json, _progress, _say, _table, _verdict, _yes
from selfmotion._version import __version__
from selfmotion.errors import InvalidInputError, SelfMotionError

if TYPE_CHECKING:
    from selfmotion.exchange import OutputFolder
    from selfmotion.problem import Problem

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Plan continuous joint motions for kinematically redundant robot arms.",
)

ProblemArgument = Annotated[str, typer.Argument(metavar="PROBLEM", help="Problem file, YAML or JSON.")]
TrajectoryArgument = Annotated[
    str, typer.Argument(metavar="TRAJECTORY", help="Motion as CSV with columns r, q1, …, qn.")
]
OutOption = Annotated[str | None, typer.Option("--out", metavar="DIR", help="Folder to write results to.")]
SaveOption = Annotated[str | None, typer.Option("--save", metavar="FILE", help="Store the plan, as time reads it.")]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace files that selfmotion did not write.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
SeedOption = Annotated[int | None, typer.Option("--seed", metavar="N", help="Seed of the random numbers.")]
MaxStepOption = Annotated[
    float, typer.Option("--max-step", min=0.0, help="Largest joint step between rows [rad; m of a rail].")
]

_MOST_LINES = 40  # of one kind on the terminal


@app.callback(invoke_without_command=True)
def _top(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    if version:
        _say(__version__)
        raise typer.Exit(0)


@app.command()
def plan(
    problem: ProblemArgument,
    out: OutOption = None,
    as_json: JsonOption = False,
    seed: SeedOption = None,
    force: ForceOption = False,
    save: SaveOption = None,
) -> None:
    """Plan a joint motion; --out writes plan.json, trajectory.csv and figures, --save the plan itself."""
    from selfmotion.exchange import OutputFolder, load_problem, trajectory_csv
    from selfmotion.exchange.files import checked_target

    case, planner = load_problem(problem)
    if planner is None:
        raise InvalidInputError("planner", "is missing", "add planner: {kind: sinusoid, …}", source=problem)
    folder = None if out is None else OutputFolder(out, force)
    if folder is not None:
        from selfmotion.plot import plan_figure_names

        names = ["plan.json", "trajectory.csv", *plan_figure_names(case.arm)]
        folder.check(names)
    stored = None if save is None else checked_target(save, force)
    _warn(case)
    if seed is not None:
        if seed < 0:
            raise InvalidInputError("--seed", "is negative", "give a whole number from 0", seed)
        planner = planner.with_seed(seed)
    try:
        with _progress("planning") as report:
            result = planner.plan(case, report)
    except InvalidInputError as error:
        raise error.inside(source=problem) from None
    except SelfMotionError as error:
        if folder is not None:  # an earlier motion must not stay behind as if it were the answer
            folder.write({"plan.json": _json(_failure(error)).encode()}, outdated=names)
        if stored is not None and os.path.exists(stored[0].path / stored[1]):
            stored[0].write({}, outdated=[stored[1]])
        raise
    summary = result.summary() | ({"warnings": list(case.warnings)} if case.warnings else {})
    if save is not None:
        result.save(save, force)
    if folder is not None:
        from selfmotion.plot import plan_figures

        files = {"plan.json": _json(summary).encode(), "trajectory.csv": trajectory_csv(result)}
        folder.write(files | plan_figures(result))
    _say(_json(summary) if as_json else _verdict(summary, case.arm.limits.unit))
    if out is not None and not as_json:
        _say(f"written to {out}")


@app.command()
def domain(
    problem: ProblemArgument,
    out: Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write the picture to.")],
    as_json: JsonOption = False,
    force: ForceOption = False,
) -> None:
    """Draw the angle domain: every feasible posture along the path, per branch, and say what happens to it."""
    from selfmotion.arms import PlanarArm
    from selfmotion.domain import AngleDomain
    from selfmotion.exchange import OutputFolder, load_problem, structure_lines, structure_object
    from selfmotion.plot import draw_domain, figure, image_files

    case, _ = load_problem(problem)
    folder = OutputFolder(out, force)
    folder.check(["domain.png", "domain.svg", "domain.json"])
    _warn(case)
    if not case.arm.has_structure:
        _sampled_domain(case, problem, folder, out, as_json)
        return
    try:
        feasible = AngleDomain(case.arm.self_motion(), case.path, case.elbow_branches)
    except InvalidInputError as error:
        raise error.inside(source=problem) from None
    structure = feasible.structure
    radii = case.arm.radii() if isinstance(case.arm, PlanarArm) else None
    blocked = case.blocked
    sampled = feasible.sample(case.rows)
    elbows = {
        case.arm.branches[branch]: [sampled[branch].interval_set(k).intervals.tolist() for k in range(len(case.rows))]
        for branch in case.elbow_branches
    }
    with figure(width=3.5 * len(elbows), height=3.6, columns=len(elbows)) as (canvas, axes):
        for branch, one in zip(case.elbow_branches, axes, strict=True):
            draw_domain(one, feasible, branch, causes=True)
        files = image_files("domain", canvas)
    result = {
        "status": "drawn",
        "blocked": [_blocked(part) for part in blocked] or None,
        **structure_object(structure, radii),
        "version": __version__,
    }
    files["domain.json"] = _json({**result, "r": case.rows.tolist(), "u": elbows}).encode()
    folder.write(files)
    lines = [f"angle domain with {' and '.join(elbows)} elbow at {len(case.rows)} places, written to {out}"]
    lines += [f"nothing is feasible for r in [{part.r[0]:.6g}, {part.r[1]:.6g}]: {part.cause}" for part in blocked]
    lines += structure_lines(structure, radii, "domain.json")
    _say(_json(result) if as_json else "\n".join(lines))


@app.command()
def reproduce(
    out: Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write the report to.")] = "out",
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="First seed of every optimizer.", min=0)] = 1,
    seeds: Annotated[
        int, typer.Option("--seeds", metavar="N", help="Number of seeds compared.", min=1, max=10_000)
    ] = 30,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="FIGURE", help="Make only this figure; may be given again.")
    ] = None,
    force: ForceOption = False,
) -> None:
    """Run the paper's study of the 3R and 6R arms; write its tables and figures, printed beside computed."""
    from selfmotion.exchange import OutputFolder
    from selfmotion.report import Study, file_names
    from selfmotion.report import reproduce as run

    folder = OutputFolder(out, force)
    folder.check(file_names(only or ()))
    options = shlex.join(["--out", out, "--seed", str(seed), *([] if seeds == 30 else ["--seeds", str(seeds)])])
    with _progress("reproducing") as report:
        files = run(Study(seed, seeds, os.cpu_count() or 1, report), options, only or ())
    folder.write(files)
    _say("\n".join(f"{os.path.join(out, name)}" for name in files if only or name.startswith("report.")))


@app.command()
def animate(
    problem: ProblemArgument,
    trajectory: TrajectoryArgument,
    out: Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write the animation to.")],
    seconds: Annotated[float, typer.Option("--seconds", metavar="S", help="Duration; r is linear in time.")] = 6.0,
    fps: Annotated[int, typer.Option("--fps", metavar="N", help="Frames per second, at most 50.")] = 25,
    formats: Annotated[
        list[str] | None,
        typer.Option("--format", metavar="gif|mp4", help="May be given twice; without it gif, and mp4 if possible."),
    ] = None,
    force: ForceOption = False,
) -> None:
    """Draw a motion as animation.gif and animation.mp4: the arm on its path, and its way through the angle domain."""
    from selfmotion._checks import choice
    from selfmotion.errors import MissingExtraError
    from selfmotion.exchange import OutputFolder, load_problem, read_trajectory
    from selfmotion.plot.animation import Animation, encoder

    wanted = [choice("--format", kind, ("gif", "mp4")) for kind in formats or ("gif", "mp4")]
    note = ""
    if "mp4" in wanted:
        try:
            encoder()
        except MissingExtraError as error:
            if formats:
                raise
            wanted.remove("mp4")
            note = f"no mp4: it {error.reason}; {error.remedy}"
    case, _ = load_problem(problem)
    _planar_only(case, problem, "animate draws")
    motion = read_trajectory(trajectory, case.arm.n)
    folder = OutputFolder(out, force)
    names = {kind: f"animation.{kind}" for kind in ("gif", "mp4")}
    folder.check(names.values())
    animation = Animation(case, motion.r, motion.q, seconds, fps)
    files = {names[kind]: animation.gif() if kind == "gif" else animation.mp4() for kind in dict.fromkeys(wanted)}
    folder.write(files, outdated=names.values())  # of the same motion, or gone
    _say(f"{animation.count} frames, {' and '.join(files)} written to {out}" + (f"\n{note}" if note else ""))


@app.command()
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
    _planar_only(case, problem, "repair mends motions of")
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
        folder.write({"repair.json": _json(_failure(error)).encode()}, outdated=names)
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
        "version": __version__,
    }
    files = {
        "repaired.csv": motion_csv(case.arm, found.r, found.q, case.arm.u_of(found.q)),
        "repair.json": _json(result).encode(),
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
    _say(_json(result) if as_json else "\n".join(lines))


@app.command()
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
        float, typer.Option("--time-limit", metavar="S", min=0.0, help="Seconds after which it is taken as it is.")
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
        with _progress("proving a bound") as report:
            distance = distance_from_optimum(case, motion.r, motion.q, prover, allowed, report)
    if as_json:
        status = {"status": "holds" if verdict.holds else "broken"}
        more = {**distance.summary(), "rows": len(motion.r), "version": __version__}
        _say(_json({**status, **asdict(verdict), **more}))
    elif verdict.holds:
        _say(f"the motion holds: travel {verdict.cost_sampled:.9g}, tracking {verdict.max_tracking_error:.2g}")
        if optimum:
            _say(f"  {distance}")
    else:
        _say("\n  ".join(["the motion does not hold:", *map(str, verdict.failures)]))
    raise typer.Exit(0 if verdict.holds else 1)


@app.command()
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
        with _progress("planning") as report:
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
    _say(_json(result) if as_json else "\n".join(_compared(result)))


@app.command(name="time")
def time_plan(
    source: Annotated[str, typer.Argument(metavar="FILE", help="Problem file, or a plan that plan --save stored.")],
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="File to write the trajectory to.")],
    max_acceleration: Annotated[
        str,
        typer.Option("--max-acceleration", metavar="X[,X…]", help="Of each joint, or of all [rad/s²; m/s² of a rail]."),
    ],
    max_velocity: Annotated[
        str | None,
        typer.Option("--max-velocity", metavar="X[,X…]", help="The same [rad/s; m/s]; the arm's own limits hold too."),
    ] = None,
    tool_speed: Annotated[
        float | None, typer.Option("--tool-speed", metavar="V", help="Kept wherever the joints can [length/s].")
    ] = None,
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Rows per second.")] = 100.0,
    form: Annotated[str, typer.Option("--format", metavar="csv|json|ros|npz|mcap", help="Form of the file.")] = "csv",
    as_json: JsonOption = False,
    force: ForceOption = False,
) -> None:
    """Give a plan a time law under joint limits and write positions, velocities and accelerations by time."""
    from dataclasses import asdict

    from selfmotion._checks import positive
    from selfmotion.exchange import load_plan, load_problem, save_trajectory
    from selfmotion.exchange.files import checked_target, read_text
    from selfmotion.exchange.plan_file import is_plan_file
    from selfmotion.exchange.timed_file import checked_form
    from selfmotion.timing import time_law
    from selfmotion.timing.law import toppra

    checked_form("--format", form)
    toppra()  # what is not installed is said before the plan is made
    positive("--rate", rate)
    acceleration = _numbers("--max-acceleration", max_acceleration)
    velocity = None if max_velocity is None else _numbers("--max-velocity", max_velocity)
    checked_target(out, force)
    if is_plan_file(read_text(source)):
        plan = load_plan(source)
    else:
        case, planner = load_problem(source)
        if planner is None:
            raise InvalidInputError("planner", "is missing", "add planner: {kind: sinusoid, …}", source=source)
        try:
            with _progress("planning") as report:
                plan = planner.plan(case, report)
        except InvalidInputError as error:
            raise error.inside(source=source) from None
    timed = time_law(plan, acceleration, velocity, tool_speed, rate)
    save_trajectory(timed, out, form, force)
    fast, strong = timed.largest
    result = {
        "status": "timed",
        "duration": timed.duration,
        "rows": len(timed.t),
        "joint_names": list(timed.joint_names),
        "frame_id": timed.frame_id,
        "velocity_used": fast.tolist(),
        "acceleration_used": strong.tolist(),
        "jerk": timed.jerk.tolist(),
        "stops": list(timed.stops),
        "slow": [asdict(part) for part in timed.slow],
        "cost": plan.cost,
        "version": __version__,
    }
    jerk: dict[str, float] = {}
    for unit, most in zip(plan.problem.arm.limits.units, timed.jerk.tolist(), strict=True):
        jerk[unit] = max(most, jerk.get(unit, 0.0))
    lines = [
        f"{timed.duration:.6g} s, {len(timed.t)} rows written to {out}",
        f"  velocities up to {fast.max():.1%} of their limits, accelerations up to {strong.max():.1%}, "
        f"jerk between rows up to {' and '.join(f'{most:.3g} {unit}/s³' for unit, most in jerk.items())}",
    ]
    if timed.stops:
        places = ", ".join(f"{r:.6g}" for r in timed.stops[:_MOST_LINES])
        lines.append(f"  stands still at {len(timed.stops)} corners, r = {places}")
    lines += [f"  slower than asked for at {part}" for part in timed.slow[:_MOST_LINES]]
    _say(_json(result) if as_json else "\n".join(lines))


@app.command()
def arms(
    file: Annotated[str | None, typer.Argument(metavar="[FILE.urdf]", help="Look at this arm instead.")] = None,
    base: Annotated[str | None, typer.Option("--base", metavar="LINK", help="Its first link, else the root.")] = None,
    tip: Annotated[str | None, typer.Option("--tip", metavar="LINK", help="Its last link, else the leaf.")] = None,
    as_json: JsonOption = False,
) -> None:
    """List the arms that a problem file can name, or one of a URDF file, and how each is solved."""
    from selfmotion.arms import CATALOGUE, how_solved, how_solved_file

    listed: list[dict[str, Any]] = []
    if file is not None:
        chain, found = how_solved_file(file, base, tip)
        title = f"{chain.base} to {chain.tip}"
        listed.append({"name": "urdf", "title": title, **found._asdict(), "tip": chain.tip, "source": file})
    for name, entry in CATALOGUE.items() if file is None else ():
        solved = how_solved(name)._asdict()
        listed.append(
            {"name": name, "title": f"{entry.maker} {entry.title}", **solved, "tip": entry.tip, "source": entry.source}
        )
    if as_json:
        _say(_json({"status": "listed", "arms": listed, "version": __version__}))
        return
    header = ("name", "joints", "u", "branches", "closed form", "rigorous", "source")
    rows = [
        (
            row["name"], str(row["joints"]), row["parameter"] or "–", str(row["branches"] or "–"),
            _yes(row["closed_form"]), _yes(row["rigorous"]), f"{row['title']}: {row['source']}",
        )
        for row in listed
    ]  # fmt: skip
    if file is None:
        rows.append(("planar", "3, 4, …", "last links' directions", "2", "yes", "yes", "kind planar: links and limits"))
        rows.append(("urdf", "6 or 7", "as recognised", "8", "yes", "yes", "kind urdf, of a family: file, base, tip"))
        rows.append(("rail", "1 + 6", "the rail's position", "8", "yes", "yes", "six joints of a family, with rail: …"))
        rows.append(("urdf", "7", "a joint's angle", "up to 16", "no", "no", "kind urdf, any other that EAIK solves"))
    lines = _table(header, rows)
    for why in dict.fromkeys(row["why_not"] for row in listed if row["why_not"]):
        lines.append(f"not planned for: {', '.join(row['name'] for row in listed if row['why_not'] == why)}; it {why}")
    _say("\n".join(lines))


@app.command()
def path(
    file: Annotated[str, typer.Argument(metavar="FILE", help="SVG, DXF, G-code, or waypoints as CSV, JSON, NPY.")],
    info: Annotated[bool, typer.Option("--info", help="Say what it was understood as; done in any case.")] = True,
    unit: Annotated[str | None, typer.Option("--unit", metavar="U", help="Of its numbers, if it says none.")] = None,
    arm_unit: Annotated[str, typer.Option("--arm-unit", metavar="U", help="Of the path: m, mm, cm or inch.")] = "m",
    scale: Annotated[float, typer.Option("--scale", metavar="X", help="A further factor.")] = 1.0,
    tolerance: Annotated[
        float | None, typer.Option("--tolerance", metavar="X", help="How far ends that meet may be apart.")
    ] = None,
    gaps: Annotated[str, typer.Option("--gaps", metavar="error|line", help="What joins subpaths apart.")] = "error",
    lift: Annotated[
        float | None, typer.Option("--lift", metavar="H", help="Height at which the path crosses gaps, in space.")
    ] = None,
    subpath: Annotated[int | None, typer.Option("--subpath", metavar="K", help="Only this one, from 0.")] = None,
    dimension: Annotated[int | None, typer.Option("--dimension", metavar="2|3", help="Of G-code: 2 drops Z.")] = None,
    arm: Annotated[
        str | None,
        typer.Option("--arm", metavar="ARM", help="Name of an arm, or a problem file: does it fit?"),
    ] = None,
    out: Annotated[str | None, typer.Option("--out", metavar="PICTURE", help="Picture to draw, .png or .svg.")] = None,
    as_json: JsonOption = False,
    force: ForceOption = False,
) -> None:
    """Say what a drawing, a program or a table of waypoints is understood as, and draw it."""
    from selfmotion.exchange import OutputFolder, arm_of, read_drawing

    name = os.path.basename(out or "")
    stem, suffix = os.path.splitext(name)
    if out is not None and (suffix not in (".png", ".svg") or not stem):
        raise InvalidInputError("--out", "is no name of a picture", "name one that ends in .png or .svg", out)
    folder = None if out is None else OutputFolder(os.path.dirname(out) or ".", force)
    if folder is not None:
        folder.check([name])
    reach = None if arm is None else arm_of(arm).reach
    options: Any = {"arm_unit": arm_unit, "scale": scale, "tolerance": tolerance, "gaps": gaps, "lift": lift}
    with _progress("reading"):
        found = read_drawing(file, unit, dimension=dimension, subpath=subpath, **options)  # type: ignore[arg-type]
    if reach is not None:
        found = found.for_arm(reach)
    if folder is not None:
        from selfmotion.plot import draw_drawing, rendered

        folder.write({name: rendered(stem, draw_drawing, found, forms=[suffix[1:]], width=5.0, height=4.0)[name]})
    result = {"status": "read", **found.summary(), "version": __version__}
    lines = found.lines() + ([] if out is None else [f"written to {out}"])
    _say(_json(result) if as_json else "\n".join(lines))


@app.command()
def urdf(
    problem: ProblemArgument,
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="File to write.")],
    force: ForceOption = False,
) -> None:
    """Write a problem's arm as URDF: one in space as it is, a planar one where its placement says."""
    from selfmotion.exchange import load_problem, save_urdf

    arm = load_problem(problem).problem.arm
    try:
        save_urdf(arm, out, force)
    except InvalidInputError as error:
        raise error if error.field == "--out" else error.inside(source=problem) from None
    _say(f"{arm.n} joints written to {out}")


@app.command()
def schema() -> None:
    """Print the JSON Schema of problem files."""
    from selfmotion.exchange.schema import json_schema

    _say(_json(json_schema()))


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit: 0 solved, 2 bad input, 3 proved infeasible, 4 neither."""
    sys.exit(_run(list(sys.argv[1:] if arguments is None else arguments)))


def _run(arguments: list[str]) -> int:
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed by the caller
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
        elif hasattr(stream, "reconfigure"):  # a name that the terminal cannot show is no reason to stop
            stream.reconfigure(errors="backslashreplace")
    command = typer.main.get_command(app)
    try:
        code = command.main(args=arguments or ["--help"], prog_name="selfmotion", standalone_mode=False)
        return code if isinstance(code, int) else 0
    except SelfMotionError as error:
        return _report_error(error, "--json" in arguments)
    except (KeyboardInterrupt, typer.Abort):
        print("selfmotion: interrupted", file=sys.stderr)
        return 130
    except MemoryError:
        too_large = InvalidInputError("samples", "needs more memory than there is", "lower samples or population")
        return _report_error(too_large, "--json" in arguments)
    except Exception as error:
        # The command line's own usage errors; their class has moved between typer's versions.
        if not hasattr(error, "format_message"):
            raise
        text = " ".join(str(error.format_message()).split()).rstrip(".")
        return _report_error(InvalidInputError("", text, "see selfmotion --help"), "--json" in arguments)


def _sampled_domain(case: Problem, source: str, folder: OutputFolder, out: str, as_json: bool) -> None:
    """Draw the angle domain of an arm whose structure along a path is not told."""
    from selfmotion.domain import AngleDomain, SampledDomain
    from selfmotion.exchange import sampled_lines, sampled_object
    from selfmotion.plot import sampled_domain_figure

    try:
        sampled = SampledDomain(AngleDomain(case.arm.self_motion(), case.path), case.elbow_branches)
    except InvalidInputError as error:
        raise error.inside(source=source) from None
    blocked = case.blocked
    result = {"status": "drawn", "blocked": [_blocked(part) for part in blocked] or None, "version": __version__}
    files = sampled_domain_figure(sampled)
    files["domain.json"] = _json({**result, **sampled_object(sampled)}).encode()
    folder.write(files)
    lines = [f"angle domain on {len(sampled.branches)} branches at {len(sampled.r)} places, written to {out}"]
    lines += [f"nothing is feasible for r in [{part.r[0]:.6g}, {part.r[1]:.6g}]: {part.cause}" for part in blocked]
    _say(_json(result) if as_json else "\n".join(lines + sampled_lines(sampled)))


def _planar_only(case: Problem, source: str, what: str) -> None:
    """Refuse an arm in space where only the plane is drawn or searched."""
    from selfmotion.paths.base import PLANE

    if case.arm.dimension != PLANE:
        remedy = "use plan, verify or compare for an arm in space"
        raise InvalidInputError("arm", f"moves in space, and {what} planar arms only", remedy, source=source)


def _numbers(option: str, text: str) -> float | list[float]:
    """Return the one number, or the numbers, of an option such as 2,2,1.5."""
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        raise InvalidInputError(option, "is no list of numbers", "write 2 or 2,2,1.5", text) from None
    return values[0] if len(values) == 1 else values


def _warn(case: Problem) -> None:
    """Say on stderr what is doubtful about a problem."""
    for warning in case.warnings:
        print(f"selfmotion: warning: {warning}", file=sys.stderr)


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


def _report_error(error: SelfMotionError, as_json: bool) -> int:
    """Print one line on stderr, and with --json the result object; return the exit code."""
    if as_json and getattr(error, "field", None) != "stdout":
        _say(_json(_failure(error)))
    print("selfmotion: " + " ".join(str(error).split()), file=sys.stderr)
    return error.exit_code


__all__ = ["app", "main"]
