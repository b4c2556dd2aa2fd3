"""Who may ask the studio anything: a page of this server in this browser, and nobody else.

Any web page can send requests to 127.0.0.1, and any program of this machine can. Against the others: a token in the
address, which the page sends along; the names this server answers to (against DNS rebinding); where a request comes
from, as browsers say it; sizes, types and methods; and a policy by which the page loads this server's files only.
"""

from __future__ import annotations

import asyncio
import base64
import hashlib
import secrets
from collections.abc import Iterable
from typing import TYPE_CHECKING
from urllib.parse import parse_qs

from selfmotion.studio.tasks import TASKS
from selfmotion.studio.workers import error_line

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

_READ_SECONDS = 60.0
_API, _STATIC = "/api/", "/static/"
_REMEDY = "open the address that selfmotion studio printed"

_SELF = "'self'"

_GO_ON = """
const token = localStorage.getItem("selfmotion-token");
if (token && token !== new URLSearchParams(location.search).get("token"))
  location.replace("/?token=" + encodeURIComponent(token) + location.hash);
"""

_NO_TOKEN = f"""<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>selfmotion studio</title>
<link rel="icon" href="/static/icon.svg">
<h1>This is not the address of the studio</h1>
<p>Open the address that <code>selfmotion studio</code> printed; it ends in <code>?token=…</code></p>
<script>{_GO_ON}</script>
</html>
"""


def source_hash(script: str) -> str:
    """Return the source of a policy that allows one inline script."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"


def policy(scripts: Iterable[str] = ()) -> str:
    """Return the policy of a page: this server's files, and these inline scripts."""
    return (
        f"default-src 'none'; script-src {' '.join([_SELF, *map(source_hash, scripts)])}; "
        "style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )


_ALWAYS = {
    b"content-security-policy": policy().encode(),
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"cross-origin-opener-policy": b"same-origin",
    b"cross-origin-resource-policy": b"same-origin",
    b"cache-control": b"no-store",
}


class Refusal(Exception):
    """A request that is refused.

    Parameters
    ----------
    code : int
        Of HTTP.
    message : str
    remedy : str, optional
    headers : tuple of pairs of bytes, optional
    """

    def __init__(
        self, code: int, message: str, remedy: str = "", headers: tuple[tuple[bytes, bytes], ...] = ()
    ) -> None:
        self.code, self.message, self.remedy, self.headers = code, message, remedy, headers
        super().__init__(message)

    @property
    def body(self) -> bytes:
        """What the page hears."""
        return error_line(self.message, self.remedy)


class Guard:
    """ASGI middleware that refuses what is not from the studio's own page.

    Parameters
    ----------
    app : ASGI application
        Sees requests that are all right, and their whole bodies.
    port : int
        Which the server listens on.
    token : str
    """

    def __init__(self, app: ASGIApp, port: int, token: str) -> None:
        self._app, self._token = app, token
        names = ("127.0.0.1", "localhost")
        self._hosts = {f"{name}:{port}" for name in names} | ({*names} if port == 80 else set())
        self._origins = {f"http://{host}" for host in self._hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse to."""
        if scope["type"] != "http":
            if scope["type"] == "websocket":
                await send({"type": "websocket.close", "code": 1008})
            return
        guarded = _with_headers(send)
        try:
            headers = _headers(scope)
            self._check_source(headers)
            if scope["path"] == "/":
                _check_method(scope, "GET")
                if not self._is_token(_token_of(scope)) or not _is_for_a_tab(headers):
                    await _send(guarded, 403, _NO_TOKEN.encode(), "text/html; charset=utf-8", _page_policy())
                    return
            else:
                _check_fetched_here(headers)
                if scope["path"].startswith(_STATIC):
                    _check_method(scope, "GET")
                else:
                    receive = await self._checked_question(scope, headers, receive)
            await self._app(scope, receive, guarded)
        except Refusal as refusal:
            await _send(guarded, refusal.code, refusal.body, "application/json", refusal.headers)

    def _is_token(self, given: str) -> bool:
        return secrets.compare_digest(given.encode("utf-8", "replace"), self._token.encode())

    def _check_source(self, headers: dict[str, str]) -> None:
        """Refuse other names of this machine, and pages of other servers."""
        if headers.get("host", "").lower() not in self._hosts:
            raise Refusal(421, "this is the studio, by another name", _REMEDY)
        origin = headers.get("origin")
        if origin is not None and origin.lower() not in self._origins:
            raise Refusal(403, "another page may not ask the studio")

    async def _checked_question(self, scope: Scope, headers: dict[str, str], receive: Receive) -> Receive:
        """Refuse what is no question of the page; return its body, read."""
        path = scope["path"]
        if not path.startswith(_API):
            raise Refusal(404, "there is no such page")
        _check_method(scope, "POST")
        if not self._is_token(headers.get("x-selfmotion-token", "")):
            raise Refusal(403, "the token is not that of this studio", _REMEDY)
        task = TASKS.get(path[len(_API) :])
        if task is None:
            raise Refusal(404, "there is no such task", f"there are {', '.join(TASKS)}")
        if headers.get("content-type", "").split(";")[0].strip().lower() != "application/json":
            raise Refusal(415, "the content is not application/json")
        length = headers.get("content-length", "0")
        if not (length.isascii() and length.isdigit()):
            raise Refusal(400, "the length of the content is no number")
        if int(length[:20]) > task.largest:
            raise _too_large(task.largest)
        return _replay(await _read(receive, task.largest), receive)


def _check_fetched_here(headers: dict[str, str]) -> None:
    if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
        raise Refusal(403, "another page may not ask the studio")


def _is_for_a_tab(headers: dict[str, str]) -> bool:
    """Return whether a page is asked for from here, or by whoever follows a link: not as a part of another page."""
    if headers.get("sec-fetch-site", "none") in ("same-origin", "none"):
        return True
    return headers.get("sec-fetch-mode") == "navigate" and headers.get("sec-fetch-dest") == "document"


def _check_method(scope: Scope, allowed: str) -> None:
    if scope["method"] != allowed:
        raise Refusal(405, f"only {allowed} is understood here", headers=((b"allow", allowed.encode()),))


def _headers(scope: Scope) -> dict[str, str]:
    """Return the headers; of one that is there twice, what no check accepts."""
    found: dict[str, str] = {}
    for name, value in scope["headers"]:
        key = name.decode("latin-1").lower()
        found[key] = f"{found[key]}, {value.decode('latin-1')}" if key in found else value.decode("latin-1")
    return found


def _token_of(scope: Scope) -> str:
    try:
        given = parse_qs(scope["query_string"].decode("latin-1"), max_num_fields=10).get("token", [])
    except ValueError:
        return ""
    return given[0] if len(given) == 1 else ""


async def _read(receive: Receive, largest: int) -> bytes:
    """Return the whole body."""
    body = bytearray()
    try:
        async with asyncio.timeout(_READ_SECONDS):
            while True:
                message = await receive()
                if message["type"] == "http.disconnect":
                    raise Refusal(400, "the content was cut off")
                body += message.get("body", b"")
                if len(body) > largest:
                    raise _too_large(largest)
                if not message.get("more_body", False):
                    return bytes(body)
    except TimeoutError:
        raise Refusal(408, "the content does not come") from None


def _replay(body: bytes, receive: Receive) -> Receive:
    told = False

    async def replayed() -> Message:
        nonlocal told
        if told:
            return await receive()
        told = True
        return {"type": "http.request", "body": body, "more_body": False}

    return replayed


def _too_large(largest: int) -> Refusal:
    return Refusal(413, f"this is larger than {largest // 1_000_000} MB", "ask for less: fewer points, fewer samples")


def _page_policy() -> tuple[tuple[bytes, bytes], ...]:
    return ((b"content-security-policy", policy([_GO_ON]).encode()),)


def _with_headers(send: Send) -> Send:
    """Add to every answer the headers that it has not set itself."""

    async def guarded(message: Message) -> None:
        if message["type"] == "http.response.start":
            given = list(message.get("headers", []))
            names = {name.lower() for name, _ in given}
            message = {**message, "headers": given + [pair for pair in _ALWAYS.items() if pair[0] not in names]}
        await send(message)

    return guarded


async def _send(send: Send, code: int, body: bytes, kind: str, headers: Iterable[tuple[bytes, bytes]] = ()) -> None:
    length = str(len(body)).encode()
    given = [(b"content-type", kind.encode()), (b"content-length", length), *headers]
    await send({"type": "http.response.start", "status": code, "headers": given})
    await send({"type": "http.response.body", "body": body})


__all__ = ["Guard", "Refusal", "policy", "source_hash"]
