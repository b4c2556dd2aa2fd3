"""The command that serves the studio."""

from __future__ import annotations

from typing import Annotated

import typer


def studio(
    problem: Annotated[str | None, typer.Argument(metavar="[PROBLEM]", help="Problem file to open.")] = None,
    port: Annotated[
        int | None, typer.Option("--port", metavar="N", min=0, max=65535, help="Port on this machine, else a free one.")
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Whether to open the page in the browser.")
    ] = True,
    folder: Annotated[
        str | None,
        typer.Option("--folder", metavar="DIR", help="Where problem files are; else beside PROBLEM."),
    ] = None,
) -> None:
    """Serve a page on which arm, path and motion are seen and moved, and print its address; Ctrl-C ends it."""
    from selfmotion.studio.server import serve

    serve(problem, port, browser, folder)
