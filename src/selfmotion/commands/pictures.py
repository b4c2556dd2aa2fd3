"""Commands that draw: the angle domain, the paper's cases, a moving arm."""

from __future__ import annotations

import os
import shlex
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion._version import __version__
from selfmotion.commands.options import ForceOption, JsonOption, ProblemArgument, TrajectoryArgument, planar_only, warn
from selfmotion.commands.printed import json_text, say, shown_progress
from selfmotion.errors import InvalidInputError
from selfmotion.failures import blocked_object

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from selfmotion.domain import AngleDomain
    from selfmotion.errors import Blocked
    from selfmotion.exchange import OutputFolder
    from selfmotion.problem import Problem


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

    case, _ = load_problem(problem)
    folder = OutputFolder(out, force)
    folder.check(["domain.png", "domain.svg", "domain.json"])
    warn(case)
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
    files = _with_causes(feasible, case.elbow_branches)
    result = {
        "status": "drawn",
        "blocked": [blocked_object(part) for part in blocked] or None,
        **structure_object(structure, radii),
        "version": __version__,
    }
    files["domain.json"] = json_text({**result, "r": case.rows.tolist(), "u": elbows}).encode()
    folder.write(files)
    lines = [f"angle domain with {' and '.join(elbows)} elbow at {len(case.rows)} places, written to {out}"]
    lines += _blocked_lines(blocked)
    lines += structure_lines(structure, radii, "domain.json")
    say(json_text(result) if as_json else "\n".join(lines))


def _with_causes(domain: AngleDomain, branches: Sequence[int]) -> dict[str, bytes]:
    """Return the picture of all branches of a domain side by side, with what bounds it."""
    from selfmotion.plot import draw_domain, figure, image_files

    count = len(branches)
    with figure(width=3.5 * count, height=3.6, columns=count) as (canvas, axes):
        for branch, one in zip(branches, axes, strict=True):
            draw_domain(one, domain, branch, causes=True)
        return image_files("domain", canvas)


def _sampled_domain(case: Problem, source: str, folder: OutputFolder, out: str, as_json: bool) -> None:
    """Draw the angle domain of an arm whose structure along a path is not told."""
    from selfmotion.constrained.arm import unconstrained
    from selfmotion.domain import AngleDomain, SampledDomain
    from selfmotion.exchange import sampled_lines, sampled_object
    from selfmotion.plot import sampled_domain_figure

    try:
        feasible = AngleDomain(case.arm.self_motion(), case.path, case.elbow_branches)
        sampled = SampledDomain(feasible, case.elbow_branches)
    except InvalidInputError as error:
        raise error.inside(source=source) from None
    blocked = case.blocked
    result = {"status": "drawn", "blocked": [blocked_object(part) for part in blocked] or None, "version": __version__}
    files = (
        _with_causes(feasible, case.elbow_branches)
        if unconstrained(case.arm).has_structure
        else sampled_domain_figure(sampled)
    )
    files["domain.json"] = json_text({**result, **sampled_object(sampled)}).encode()
    folder.write(files)
    lines = [f"angle domain on {len(sampled.branches)} branches at {len(sampled.r)} places, written to {out}"]
    lines += _blocked_lines(blocked)
    say(json_text(result) if as_json else "\n".join(lines + sampled_lines(sampled)))


def _blocked_lines(blocked: Iterable[Blocked]) -> list[str]:
    """Return what is said of stretches without any posture."""
    return [
        f"nothing is feasible for r in [{part.r[0]:.6g}, {part.r[1]:.6g}]: {part.cause}"
        + (f" ({' and '.join(part.limits)})" if part.limits else "")
        for part in blocked
    ]


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
    with shown_progress("reproducing") as report:
        files = run(Study(seed, seeds, os.cpu_count() or 1, report), options, only or ())
    folder.write(files)
    say("\n".join(f"{os.path.join(out, name)}" for name in files if only or name.startswith("report.")))


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
    planar_only(case, problem, "animate draws")
    motion = read_trajectory(trajectory, case.arm.n)
    folder = OutputFolder(out, force)
    names = {kind: f"animation.{kind}" for kind in ("gif", "mp4")}
    folder.check(names.values())
    animation = Animation(case, motion.r, motion.q, seconds, fps)
    files = {names[kind]: animation.gif() if kind == "gif" else animation.mp4() for kind in dict.fromkeys(wanted)}
    folder.write(files, outdated=names.values())  # of the same motion, or gone
    say(f"{animation.count} frames, {' and '.join(files)} written to {out}" + (f"\n{note}" if note else ""))
