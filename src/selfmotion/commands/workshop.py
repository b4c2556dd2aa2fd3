"""Commands for the workshop: what a drawing says, when a motion is where, arms for other programs."""

from __future__ import annotations

import os
from typing import Annotated, Any

import typer

from selfmotion._version import __version__
from selfmotion.commands.options import ForceOption, JsonOption, ProblemArgument, numbers, say_warnings, warn
from selfmotion.commands.printed import json_text, say, shown_progress, table_lines, timed_lines, yes_or_no
from selfmotion.errors import InvalidInputError


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
    from selfmotion.arms.protocols import length_unit
    from selfmotion.exchange import OutputFolder, arm_of, read_drawing

    name = os.path.basename(out or "")
    stem, suffix = os.path.splitext(name)
    if out is not None and (suffix not in (".png", ".svg") or not stem):
        raise InvalidInputError("--out", "is no name of a picture", "name one that ends in .png or .svg", out)
    folder = None if out is None else OutputFolder(os.path.dirname(out) or ".", force)
    if folder is not None:
        folder.check([name])
    fit = None if arm is None else arm_of(arm)
    options: Any = {"arm_unit": arm_unit, "scale": scale, "tolerance": tolerance, "gaps": gaps, "lift": lift}
    with shown_progress("reading"):
        found = read_drawing(file, unit, dimension=dimension, subpath=subpath, **options)  # type: ignore[arg-type]
    if fit is not None:
        found = found.for_arm(fit.reach, length_unit(fit))
    if folder is not None:
        from selfmotion.plot import draw_drawing, rendered

        folder.write({name: rendered(stem, draw_drawing, found, forms=[suffix[1:]], width=5.0, height=4.0)[name]})
    result = {"status": "read", **found.summary(), "version": __version__}
    lines = found.lines() + ([] if out is None else [f"written to {out}"])
    say(json_text(result) if as_json else "\n".join(lines))


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
    form: Annotated[
        str | None,
        typer.Option("--format", metavar="csv|json|ros|npz|mcap", help="Form of the file, if its suffix says none."),
    ] = None,
    as_json: JsonOption = False,
    force: ForceOption = False,
) -> None:
    """Give a plan a time law under joint limits and write positions, velocities and accelerations by time."""
    from dataclasses import asdict

    import numpy as np

    from selfmotion._checks import positive
    from selfmotion.exchange import load_plan, load_problem, save_trajectory
    from selfmotion.exchange.files import checked_target, read_text
    from selfmotion.exchange.telling import is_plan_file
    from selfmotion.exchange.timed_file import form_of
    from selfmotion.timing import time_law
    from selfmotion.timing.law import toppra

    form = form_of("--format", form, out)
    toppra()  # what is not installed is said before the plan is made
    positive("--rate", rate)
    acceleration = numbers("--max-acceleration", max_acceleration)
    velocity = None if max_velocity is None else numbers("--max-velocity", max_velocity)
    checked_target(out, force)
    if is_plan_file(read_text(source)):
        plan = load_plan(source)
    else:
        case, planner = load_problem(source)
        if planner is None:
            raise InvalidInputError("planner", "is missing", "add planner: {kind: sinusoid, …}", source=source)
        try:
            with shown_progress("planning") as report:
                plan = planner.plan(case, report)
        except InvalidInputError as error:
            raise error.inside(source=source) from None
    timed = time_law(plan, acceleration, velocity, tool_speed, rate)
    save_trajectory(timed, out, form, force)
    fast, strong = timed.largest
    limited = np.isfinite(timed.limits.velocity).tolist()
    result = {
        "status": "timed",
        "duration": timed.duration,
        "rows": len(timed.t),
        "joint_names": list(timed.joint_names),
        "frame_id": timed.frame_id,
        "velocity_used": [part if known else None for part, known in zip(fast.tolist(), limited, strict=True)],
        "velocity_peak": np.abs(timed.dq).max(axis=0).tolist(),
        "velocity_unlimited": list(timed.unlimited),
        "acceleration_used": strong.tolist(),
        "jerk": timed.jerk.tolist(),
        "stops": list(timed.stops),
        "slow": [asdict(part) for part in timed.slow],
        "cost": plan.cost,
        "version": __version__,
    }
    lines = [f"{timed.duration:.6g} s, {len(timed.t)} rows written to {out}", *timed_lines(timed)]
    say(json_text(result) if as_json else "\n".join(lines))


def arms(
    file: Annotated[str | None, typer.Argument(metavar="[FILE.urdf]", help="Look at this arm instead.")] = None,
    base: Annotated[str | None, typer.Option("--base", metavar="LINK", help="Its first link, else the root.")] = None,
    tip: Annotated[str | None, typer.Option("--tip", metavar="LINK", help="Its last link, else the leaf.")] = None,
    as_json: JsonOption = False,
) -> None:
    """List the arms that a problem file can name, or one of a URDF file, and how each is solved."""
    from selfmotion.arms import CATALOGUE, how_solved, how_solved_file

    listed: list[dict[str, Any]] = []
    doubts: list[str] = []
    if file is not None:
        chain, found = how_solved_file(file, base, tip)
        title = f"{chain.base} to {chain.tip}"
        doubts = chain.limits.doubts(chain.names)
        listed.append({"name": "urdf", "title": title, **found._asdict(), "tip": chain.tip, "source": file})
    for name, entry in CATALOGUE.items() if file is None else ():
        solved = how_solved(name)._asdict()
        listed.append(
            {"name": name, "title": f"{entry.maker} {entry.title}", **solved, "tip": entry.tip, "source": entry.source}
        )
    say_warnings(doubts)
    if as_json:
        say(json_text({"status": "listed", "arms": listed, "warnings": doubts, "version": __version__}))
        return
    header = ("name", "joints", "u", "branches", "closed form", "rigorous", "source")
    rows = [
        (
            row["name"], str(row["joints"]), row["parameter"] or "–", str(row["branches"] or "–"),
            yes_or_no(row["closed_form"]), yes_or_no(row["rigorous"]), f"{row['title']}: {row['source']}",
        )
        for row in listed
    ]  # fmt: skip
    if file is None:
        rows.append(("planar", "3, 4, …", "last links' directions", "2", "yes", "yes", "kind planar: links and limits"))
        rows.append(("urdf", "6 or 7", "as recognised", "8", "yes", "yes", "kind urdf, of a family: file, base, tip"))
        rows.append(("rail", "1 + 6", "the rail's position", "8", "yes", "yes", "six joints of a family, with rail: …"))
        rows.append(("urdf", "7", "a joint's angle", "up to 16", "no", "no", "kind urdf, any other that EAIK solves"))
    lines = table_lines(header, rows)
    for why in dict.fromkeys(row["why_not"] for row in listed if row["why_not"]):
        lines.append(f"not planned for: {', '.join(row['name'] for row in listed if row['why_not'] == why)}; it {why}")
    say("\n".join(lines))


def urdf(
    problem: ProblemArgument,
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="File to write.")],
    as_json: JsonOption = False,
    force: ForceOption = False,
) -> None:
    """Write a problem's arm as URDF: one in space as it is, a planar one where its placement says."""
    from selfmotion.arms import PlanarArm
    from selfmotion.constrained import unconstrained
    from selfmotion.exchange import load_problem, save_urdf
    from selfmotion.exchange.urdf_file import planar_chain
    from selfmotion.units import UNITS, point_text

    case = load_problem(problem).problem
    arm = unconstrained(case.arm)
    warn(case)
    try:
        save_urdf(arm, out, force)
    except InvalidInputError as error:
        raise error if error.field == "--out" else error.inside(source=problem) from None
    planar = arm.placement if isinstance(arm, PlanarArm) else None
    chain = planar_chain(arm) if isinstance(arm, PlanarArm) else arm.chain  # type: ignore[attr-defined]
    reach = arm.reach * (1.0 if planar is None else UNITS[planar.unit])
    base = [0.0, 0.0, 0.0] if planar is None else chain.offsets[0][:3, 3].tolist()
    if as_json:
        result = {"status": "written", "joints": arm.n, "reach": reach, "base": base, "frame": chain.base}
        say(json_text({**result, "warnings": list(case.warnings), "version": __version__}))
        return
    say(f"{arm.n} joints written to {out}\n  reach {reach:.6g} m, base at {point_text(base)} m in {chain.base}")
