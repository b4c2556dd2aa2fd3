"""The studio's server: one page, its files, and ``/api/…``, on this machine only; it computes nothing itself."""

from __future__ import annotations

import asyncio
import html
import json
import math
import os
import re
import secrets
import signal
import socket
import threading
from collections.abc import AsyncGenerator, Iterator
from contextlib import aclosing, contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from selfmotion._version import __version__
from selfmotion.errors import InvalidInputError, MissingExtraError
from selfmotion.studio.folder import Folder
from selfmotion.studio.tasks import TASKS

if TYPE_CHECKING:
    import uvicorn
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.types import ASGIApp, Receive, Scope, Send

    from selfmotion.studio.workers import Pool

PAGE = Path(__file__).parent / "page"
_TYPES = {
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".ico": "image/x-icon",
    ".woff2": "font/woff2",
}
_PLACEHOLDER = re.compile(r"\{\{(token|importmap|version|file)\}\}")


def serve(problem: str | None, port: int | None, browser: bool, folder: str | None) -> None:
    """Serve the studio until it is interrupted.

    Parameters
    ----------
    problem : str or None
        A problem file to open.
    port : int or None
        None or 0 for a free one.
    browser : bool
        Whether to open the page in the browser.
    folder : str or None
        Where problem files are opened and saved; by default that of the problem file, else the working folder.

    Raises
    ------
    InvalidInputError
        If the port, the folder or the problem file cannot be used.
    MissingExtraError
        If starlette or uvicorn is not installed.
    """
    for package in ("starlette", "uvicorn"):
        if find_spec(package) is None:
            raise MissingExtraError("", f"needs the package {package}", "pip install 'selfmotion[studio]'")
    place = Folder.chosen(problem, folder)
    if problem is not None and not os.path.isfile(problem):
        is_folder = os.path.isdir(problem)
        reason, remedy = ("is a folder", "name a file") if is_folder else ("does not exist", "check the name")
        raise InvalidInputError("", reason, remedy, source=problem)
    file = "" if problem is None else _file_in(place, problem)
    with _listening(port or 0) as listener, suppress(KeyboardInterrupt):
        asyncio.run(_serve(listener, place, file, problem, browser))


def _file_in(place: Folder, problem: str) -> str:
    """Return the name of a problem file in the studio's folder."""
    path = os.path.join(os.path.realpath(os.path.dirname(problem) or "."), os.path.basename(problem))
    if os.path.commonpath([path, place.path]) != place.path:
        raise InvalidInputError("--folder", "does not hold the problem file", "leave it out", place.path)
    return os.path.relpath(path, place.path).replace(os.sep, "/")


def _listening(port: int) -> socket.socket:
    """Return a socket that listens on this machine only.

    Raises
    ------
    InvalidInputError
        If the port cannot be had.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if os.name == "posix":  # elsewhere it would let two programs listen
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", port))
        listener.listen(128)
    except OSError as error:
        listener.close()
        reason = error.strerror or str(error)
        remedy = "choose another, or none for a free one"
        raise InvalidInputError("--port", f"{port} cannot be had ({reason.lower()})", remedy) from None
    return listener


async def _serve(listener: socket.socket, place: Folder, file: str, problem: str | None, browser: bool) -> None:
    """Print the address at once, and serve; a problem file that is none ends it all."""
    from selfmotion.studio.workers import Pool

    pool = Pool(place.path)
    try:
        port = listener.getsockname()[1]
        token = secrets.token_urlsafe(32)
        address = f"http://127.0.0.1:{port}/?token={token}"
        print(address, flush=True)
        server = _server(application(port, token, pool, file), pool)
        serving = asyncio.ensure_future(server.serve(sockets=[listener]))
        try:
            if problem is not None:
                checking = asyncio.ensure_future(_check(pool, os.path.abspath(problem), file, problem))
                await asyncio.wait({serving, checking}, return_when=asyncio.FIRST_COMPLETED)
                if checking.done():
                    checking.result()
                else:
                    checking.cancel()
            if browser and not serving.done():
                threading.Thread(target=_open_browser, args=(address,), daemon=True).start()
            pool.reserve()
            await serving
        finally:
            server.should_exit = True
            await serving
    finally:
        await pool.close()


async def _check(pool: Pool, path: str, file: str, given: str) -> None:
    """Refuse a problem file as `plan` would; a worker looks, and keeps what it loaded for that."""
    async for line in pool.ask("check", json.dumps({"path": path, "file": file}), 120.0):
        error = json.loads(line).get("error")
        if error:
            raise InvalidInputError("", error["message"].replace(path, given), error["remedy"])


def _open_browser(address: str) -> None:
    import webbrowser

    with suppress(Exception):  # the address is printed too
        webbrowser.open(address)


def _server(app: ASGIApp, pool: Pool) -> uvicorn.Server:
    import uvicorn

    class Server(uvicorn.Server):
        """Ends quietly, and what it still computes ends first."""

        @contextmanager
        def capture_signals(self) -> Iterator[None]:
            before = {number: signal.signal(number, self.handle_exit) for number in (signal.SIGINT, signal.SIGTERM)}
            try:
                yield
            finally:
                for number, handler in before.items():
                    signal.signal(number, handler)

        async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
            await pool.close()
            await super().shutdown(sockets)

    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        lifespan="off",
        http="h11",
        ws="none",
        loop="asyncio",
        limit_concurrency=100,
        h11_max_incomplete_event_size=32_768,
        timeout_keep_alive=30,
        timeout_graceful_shutdown=2,
    )
    return Server(config)


def application(port: int, token: str, pool: Pool, file: str = "", page: Path = PAGE) -> ASGIApp:
    """Return the studio as an ASGI application.

    Parameters
    ----------
    port : int
        Which it is served on.
    token : str
        Which its page has.
    pool : Pool
        Who does what it is asked.
    file : str
        The problem file that the page opens, none if empty.
    page : path-like
        The folder of the page.
    """
    from starlette.applications import Starlette
    from starlette.routing import Route

    from selfmotion.studio.guard import Guard, Refusal

    async def index(request: Request) -> Response:
        return _index(page, {"token": token, "version": __version__, "file": file})

    async def static(request: Request) -> Response:
        return _static(page, request.path_params["name"])

    async def api(request: Request) -> Response:
        task = request.path_params["task"]
        payload = _payload(await request.body())
        return _streamed(pool.ask(task, payload, TASKS[task].seconds))

    routes = [
        Route("/", index),
        Route("/static/{name:path}", static),
        Route("/api/{task}", api, methods=["POST"]),
    ]
    handlers = {Refusal: _refused, Exception: _mistaken}
    return Guard(Starlette(routes=routes, exception_handlers=handlers), port, token)


def _index(page: Path, values: dict[str, str]) -> Response:
    from starlette.responses import HTMLResponse

    from selfmotion.studio.guard import policy

    try:
        text = (page / "index.html").read_text(encoding="utf-8")
    except OSError:
        text = _NO_PAGE
    modules = sorted(name for name in _names(page) if name.endswith(".js"))
    imports = {f"selfmotion/{name.removesuffix('.js')}": f"/static/{name}" for name in modules}
    importmap = json.dumps({"imports": imports}).replace("<", "\\u003c")
    filled = {name: html.escape(value) for name, value in values.items()} | {"importmap": importmap}
    answer = _PLACEHOLDER.sub(lambda match: filled[match[1]], text)
    return HTMLResponse(answer, headers={"content-security-policy": policy([importmap])})


_NO_PAGE = """<!DOCTYPE html><html lang="en"><meta charset="utf-8"><meta name="selfmotion-token" content="{{token}}">
<meta name="selfmotion-file" content="{{file}}"><title>selfmotion studio</title>
<script type="importmap">{{importmap}}</script><p>selfmotion {{version}}: the page is missing</p></html>
"""


def _static(page: Path, name: str) -> Response:
    """Return one of the page's files: only names that are in its folder, so that no name leads out of it."""
    from starlette.responses import Response

    from selfmotion.studio.guard import Refusal

    kind = _TYPES.get(os.path.splitext(name)[1])
    if kind is None or name not in _names(page):
        raise Refusal(404, "there is no such file")
    return Response((page / name).read_bytes(), media_type=kind, headers={"cache-control": "no-cache"})


def _names(page: Path) -> set[str]:
    return {entry.name for entry in os.scandir(page) if entry.is_file(follow_symlinks=False)}


def _payload(body: bytes) -> str:
    """Return what a page sent as JSON on one line.

    Raises
    ------
    Refusal
        If it is no JSON object, or holds numbers that are not finite, or is nested too deeply.
    """
    from selfmotion.studio.guard import Refusal

    remedy = "send one JSON object"
    try:
        data = json.loads(body.decode(), parse_constant=_constant, parse_float=_float)
        if not isinstance(data, dict):
            raise Refusal(400, "this is no JSON object", remedy)
        text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
        text.encode()
    except RecursionError:
        raise Refusal(400, "this is nested too deeply", remedy) from None
    except UnicodeError:
        raise Refusal(400, "this is not UTF-8", remedy) from None
    except json.JSONDecodeError as error:
        where = f"{error.msg} at line {error.lineno}, column {error.colno}"
        raise Refusal(400, f"this is not JSON: {where}", remedy) from None
    except ValueError as error:
        raise Refusal(400, f"this is not JSON: {str(error)[:200]}", remedy) from None
    return text


def _constant(name: str) -> Any:
    raise ValueError(f"{name} is no number of JSON")


def _float(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError("a number is too large")
    return value


def _streamed(lines: AsyncGenerator[bytes, None]) -> Response:
    """Return an answer of lines; when the page goes away, so does what makes them."""
    from starlette.responses import Response

    class Lines(Response):
        media_type = "application/x-ndjson"

        async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
            working = asyncio.ensure_future(self._send(send))
            gone = asyncio.ensure_future(_gone(receive))
            try:
                await asyncio.wait({working, gone}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for part in (gone, working):
                    part.cancel()
                await asyncio.wait({working, gone})
            if not working.cancelled() and working.exception() is not None:
                raise working.exception() or RuntimeError

        async def _send(self, send: Send) -> None:
            headers = [(b"content-type", b"application/x-ndjson")]
            async with aclosing(lines):
                await send({"type": "http.response.start", "status": 200, "headers": headers})
                with suppress(OSError):  # the page is gone
                    async for line in lines:
                        await send({"type": "http.response.body", "body": line, "more_body": True})
                    await send({"type": "http.response.body", "body": b"", "more_body": False})

    return Lines()


async def _gone(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass


async def _refused(request: Request, refusal: Exception) -> Response:
    from starlette.responses import Response

    from selfmotion.studio.guard import Refusal

    assert isinstance(refusal, Refusal)
    return Response(refusal.body, refusal.code, media_type="application/json")


async def _mistaken(request: Request, error: Exception) -> Response:
    """Tell the page that the mistake is ours; the traceback goes to the terminal."""
    from starlette.responses import Response

    from selfmotion.studio.workers import error_line

    body = error_line(f"a mistake in the studio: {type(error).__name__}", "please report it")
    return Response(body, 500, media_type="application/json")


__all__ = ["application", "serve"]
