"""The command line. Everything heavy is imported inside the commands: ``--help`` answers at once."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, NoReturn

import typer

from selfmotion._version import __version__
from selfmotion.commands import motions, pictures, studio, workshop
from selfmotion.commands.printed import complain, json_text, say
from selfmotion.commands.study import studies
from selfmotion.errors import InvalidInputError, SelfMotionError
from selfmotion.failures import failure_object

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Plan continuous joint motions for kinematically redundant robot arms.",
)


@app.callback(invoke_without_command=True)
def _top(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    if version:
        say(__version__)
        raise typer.Exit(0)


_COMMANDS: dict[str, Callable[..., None]] = {
    "plan": motions.plan,
    "domain": pictures.domain,
    "reproduce": pictures.reproduce,
    "animate": pictures.animate,
    "repair": motions.repair,
    "verify": motions.verify,
    "compare": motions.compare,
    "time": workshop.time_plan,
    "arms": workshop.arms,
    "path": workshop.path,
    "urdf": workshop.urdf,
    "studio": studio.studio,
}
for _name, _command in _COMMANDS.items():
    app.command(name=_name)(_command)
app.add_typer(studies, name="study")


@app.command()
def schema() -> None:
    """Print the JSON Schema of problem files."""
    from selfmotion.exchange.schema import json_schema

    say(json_text(json_schema()))


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


def _report_error(error: SelfMotionError, as_json: bool) -> int:
    """Print one line on stderr, and with --json the result object; return the exit code."""
    if as_json and getattr(error, "field", None) != "stdout":
        say(json_text(failure_object(error)))
    complain(error)
    return error.exit_code


__all__ = ["app", "main"]
