"""Who may ask the studio anything: every rule, with a request that keeps it and one that breaks it."""

import asyncio
import json
import re
from itertools import pairwise

import httpx
import pytest

from selfmotion.studio import guard
from selfmotion.studio.server import application
from selfmotion.studio.tasks import TASKS

PORT = 4321
TOKEN = "t0ken-of_this-studio"
HOME = f"http://127.0.0.1:{PORT}"
GOOD = {"X-Selfmotion-Token": TOKEN, "Content-Type": "application/json"}
ELSEWHERE = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}


class Echo:
    """In the place of the worker processes: answers with what it was asked."""

    def __init__(self):
        self.asked = []

    async def ask(self, task, payload, seconds=None):
        self.asked.append(task)
        yield (
            json.dumps({"result": {"task": task, "payload": json.loads(payload), "seconds": seconds}}).encode() + b"\n"
        )


def request(method, path, headers=None, content=None, file="", page=None, pool=None):
    more = {} if page is None else {"page": page}
    app = application(PORT, TOKEN, pool or Echo(), file, **more)

    async def ask():
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url=HOME) as client:
            return await client.request(method, path, headers=headers, content=content)

    return asyncio.run(ask())


def post(task="read", content=b"{}", **headers):
    return request(
        "POST", f"/api/{task}", {**GOOD, **{name.replace("_", "-"): value for name, value in headers.items()}}, content
    )


@pytest.fixture
def page(tmp_path):
    (tmp_path / "index.html").write_text(
        '<script type="importmap">{{importmap}}</script><meta content="{{token}}">{{version}}|{{file}}|{{other}}'
    )
    (tmp_path / "main.js").write_text("main()")
    (tmp_path / "studio.css").write_text("css")
    (tmp_path / "secret.txt").write_text("secret")
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "deep.js").write_text("deep")
    (tmp_path / "link.js").symlink_to(tmp_path / "secret.txt")
    return tmp_path


def test_a_question_with_the_token_is_answered():
    answer = post("plan", b'{"a": [1.5, "\xc3\xa9\\n"]}')
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/x-ndjson"
    assert answer.json() == {"result": {"task": "plan", "payload": {"a": [1.5, "é\n"]}, "seconds": None}}
    assert post("look").json()["result"]["seconds"] == 120


@pytest.mark.parametrize("token", ["", "t0ken-of_this-studi", TOKEN + "x", TOKEN.upper(), "é"])
def test_a_question_with_another_token_is_refused(token):
    pool = Echo()
    answer = request("POST", "/api/files", {**GOOD, "X-Selfmotion-Token": token.encode()}, b"{}", pool=pool)
    assert answer.status_code == 403
    assert "token" in answer.json()["error"]["message"]
    assert not pool.asked


def test_a_question_without_a_token_or_with_it_in_the_address_is_refused():
    assert request("POST", f"/api/files?token={TOKEN}", {"Content-Type": "application/json"}, b"{}").status_code == 403
    twice = [("X-Selfmotion-Token", TOKEN), ("X-Selfmotion-Token", TOKEN), ("Content-Type", "application/json")]
    assert request("POST", "/api/files", twice, b"{}").status_code == 403


def test_tokens_are_compared_in_constant_time(monkeypatch):
    compared = []
    real = guard.secrets.compare_digest
    monkeypatch.setattr(guard.secrets, "compare_digest", lambda a, b: compared.append((a, b)) or real(a, b))
    assert post().status_code == 200
    assert request("GET", f"/?token={TOKEN}").status_code == 200
    assert compared == [(TOKEN.encode(), TOKEN.encode())] * 2


@pytest.mark.parametrize(
    "host", ["evil.example", f"evil.example:{PORT}", "127.0.0.1", "127.0.0.1:80", f"127.0.0.1:{PORT}.evil.example", ""]
)
@pytest.mark.parametrize("path", [f"/?token={TOKEN}", "/static/main.js", "/api/files"])
def test_another_name_of_this_machine_is_refused(host, path, page):
    method = "POST" if "api" in path else "GET"
    answer = request(method, path, {**GOOD, "Host": host}, b"{}" if method == "POST" else None, page=page)
    assert answer.status_code == 421
    assert TOKEN not in answer.text


@pytest.mark.parametrize("host", [f"localhost:{PORT}", f"127.0.0.1:{PORT}", f"LocalHost:{PORT}"])
def test_both_names_of_the_studio_are_fine(host):
    assert post(Host=host, Origin=f"http://{host}").status_code == 200


@pytest.mark.parametrize(
    "origin",
    [
        "null",
        "http://evil.example",
        f"https://127.0.0.1:{PORT}",
        "http://127.0.0.1:1",
        f"{HOME}.evil.example",
        HOME + "/",
    ],
)
@pytest.mark.parametrize("path", [f"/?token={TOKEN}", "/static/main.js", "/api/files"])
def test_another_origin_is_refused(origin, path, page):
    method = "POST" if "api" in path else "GET"
    answer = request(method, path, {**GOOD, "Origin": origin}, b"{}" if method == "POST" else None, page=page)
    assert answer.status_code == 403
    assert TOKEN not in answer.text
    assert "another page" in answer.json()["error"]["message"]


@pytest.mark.parametrize("site", ["cross-site", "same-site", "other"])
def test_what_another_site_fetches_is_refused(site, page):
    assert post(Sec_Fetch_Site=site).status_code == 403
    assert request("GET", "/static/main.js", {"Sec-Fetch-Site": site}, page=page).status_code == 403
    fetched = request("GET", f"/?token={TOKEN}", {"Sec-Fetch-Site": site, "Sec-Fetch-Mode": "cors"}, page=page)
    assert fetched.status_code == 403
    framed = {"Sec-Fetch-Site": site, "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe"}
    assert request("GET", f"/?token={TOKEN}", framed, page=page).status_code == 403


def test_a_link_on_another_site_opens_the_page_if_it_has_the_token(page):
    assert TOKEN in request("GET", f"/?token={TOKEN}", ELSEWHERE, page=page).text
    refused = request("GET", "/", ELSEWHERE, page=page)
    assert refused.status_code == 403
    assert "<script>" in refused.text  # which goes on with the token of an earlier visit


@pytest.mark.parametrize("site", ["same-origin", "none"])
def test_what_the_page_itself_fetches_is_fine(site, page):
    assert post(Sec_Fetch_Site=site, Origin=HOME).status_code == 200
    assert request("GET", "/static/main.js", {"Sec-Fetch-Site": site}, page=page).text == "main()"


@pytest.mark.parametrize(
    "query", ["", "?token=", "?token=wrong", f"?Token={TOKEN}", f"?token={TOKEN}&token=x", "?token=%00%ff"]
)
def test_the_page_without_its_token_says_what_to_open_and_tells_nothing(query, page):
    answer = request("GET", f"/{query}", page=page)
    assert answer.status_code == 403
    assert "selfmotion studio" in answer.text
    assert TOKEN not in answer.text
    (script,) = re.findall(r"<script>(.*?)</script>", answer.text, re.DOTALL)
    assert guard.source_hash(script) in answer.headers["content-security-policy"]
    assert "selfmotion-token" in script
    assert "location.hash" in script


def test_the_page_has_token_version_modules_and_the_file_by_name(page):
    answer = request("GET", f"/?token={TOKEN}", page=page, file='a"><script>alert(1)</script>{{token}}.yaml')
    assert answer.status_code == 200
    (importmap,) = re.findall(r'<script type="importmap">(.*?)</script>', answer.text)
    assert json.loads(importmap) == {"imports": {"selfmotion/main": "/static/main.js"}}
    assert guard.source_hash(importmap) in answer.headers["content-security-policy"]
    assert f'content="{TOKEN}"' in answer.text
    assert "<script>alert" not in answer.text
    assert answer.text.endswith("|a&quot;&gt;&lt;script&gt;alert(1)&lt;/script&gt;{{token}}.yaml|{{other}}")


def test_a_module_may_be_named_after_the_end_of_a_script(page):
    (page / "<!--<script>.js").write_text("")
    answer = request("GET", f"/?token={TOKEN}", page=page)
    assert "<!--<script>" not in answer.text


@pytest.mark.parametrize(("method", "path", "allowed"), [
    *((method, "/", "GET") for method in ("POST", "PUT", "DELETE", "OPTIONS", "HEAD", "PATCH", "TRACE")),
    *((method, "/static/main.js", "GET") for method in ("POST", "PUT", "DELETE", "OPTIONS", "HEAD")),
    *((method, "/api/files", "POST") for method in ("GET", "PUT", "DELETE", "OPTIONS", "HEAD")),
])  # fmt: skip
def test_other_methods_are_refused(method, path, allowed, page):
    answer = request(method, f"{path}?token={TOKEN}", GOOD, page=page)
    assert answer.status_code == 405
    assert answer.headers["allow"] == allowed


@pytest.mark.parametrize(
    "kind", ["", "text/plain", "application/x-www-form-urlencoded", "multipart/form-data", "text/json"]
)
def test_what_a_form_of_another_page_can_send_is_refused(kind):
    assert post(Content_Type=kind).status_code == 415
    assert post(Content_Type="application/json; charset=utf-8").status_code == 200


@pytest.mark.parametrize(
    "path", ["/api/", "/api/nothing", "/api/check", "/api/files/", "/api/../files", "/api/__class__"]
)
def test_there_is_no_such_task(path):
    answer = request("POST", path, GOOD, b"{}")
    assert answer.status_code == 404
    assert answer.json()["error"]["status"] == "error"


@pytest.mark.parametrize("path", ["/x", "/api", "/index.html", "/static", "/docs", "/openapi.json", "/favicon.ico"])
def test_there_is_no_such_page(path, page):
    assert request("GET", path, GOOD, page=page).status_code == 404


@pytest.mark.parametrize("name", [
    "secret.txt", "index.html", "absent.js", "below/deep.js", "link.js", "..", "../secret.txt", "%2e%2e/secret.txt",
    "..%2fsecret.txt", "..%5csecret.txt", "%2fetc/passwd", "/etc/passwd", "main.js%00", "main.js/", "", "MAIN.JS",
])  # fmt: skip
def test_only_the_page_s_own_files_are_served(name, page):
    answer = request("GET", f"/static/{name}", page=page)
    assert answer.status_code == (403 if name == ".." else 404)  # which is the page, without a token
    assert "secret" not in answer.text
    assert "root:" not in answer.text


def test_the_page_s_files_have_their_types(page):
    assert request("GET", "/static/main.js", page=page).headers["content-type"] == "text/javascript; charset=utf-8"
    assert request("GET", "/static/studio.css", page=page).headers["content-type"] == "text/css; charset=utf-8"


def sized(task, size, stated):
    """Send a body in pieces, with its length or without."""
    pieces = [b" " * (1 << 20)] * (size >> 20) + [b" " * (size & ((1 << 20) - 1)), b"{}"]

    async def content():
        for piece in pieces:
            yield piece

    headers = {**GOOD, **({"Content-Length": str(sum(map(len, pieces)))} if stated else {})}
    return request("POST", f"/api/{task}", headers, content())


@pytest.mark.parametrize("stated", [True, False])
def test_what_is_too_large_is_refused(stated):
    assert sized("look", 15_900_000, stated).status_code == 200
    assert sized("look", 16_000_000, stated).status_code == 413
    assert sized("export", 16_000_000, stated).status_code == 200
    assert sized("export", 64_000_000, stated).status_code == 413


@pytest.mark.parametrize(("length", "code"), [("-1", 400), ("1e3", 400), ("²", 400), ("9" * 5000, 413)])
def test_a_length_that_is_none_is_refused(length, code):
    assert request("POST", "/api/look", {**GOOD, "Content-Length": length.encode()}, b"{}").status_code == code


def test_a_body_is_refused_before_all_of_it_has_come():
    came = []

    async def content():
        for _ in range(100):
            came.append(1)
            yield b" " * 1_000_000

    assert request("POST", "/api/look", GOOD, content()).status_code == 413
    assert len(came) <= 18


def test_a_body_that_does_not_come_is_given_up(monkeypatch):
    monkeypatch.setattr(guard, "_READ_SECONDS", 0.05)

    async def content():
        yield b"{"
        await asyncio.sleep(5)

    assert request("POST", "/api/look", GOOD, content()).status_code == 408


@pytest.mark.parametrize(("content", "says"), [
    (b"", "not JSON"),
    (b"{", "not JSON: Expecting property name"),
    (b"{} {}", "Extra data"),
    (b"[]", "no JSON object"),
    (b"null", "no JSON object"),
    (b'{"a": NaN}', "NaN"),
    (b'{"a": -Infinity}', "Infinity"),
    (b'{"a": 1e999}', "too large"),
    (b'{"a": ' + b"9" * 5000 + b"}", "not JSON"),
    (b'{"a":' * 100_000, "nested too deeply"),
    (b"[" * 1_000_000, "nested too deeply"),
    (b'{"a": "\xff"}', "not UTF-8"),
    (b'{"a": "\\ud800"}', "not UTF-8"),
    (b'{"a": "\n"}', "not JSON"),
    ('{"a": 1}'.encode("utf-16"), "not UTF-8"),
])  # fmt: skip
def test_what_is_no_json_object_is_refused(content, says):
    answer = post(content=content)
    assert answer.status_code == 400
    assert says in answer.json()["error"]["message"]
    assert "Traceback" not in answer.text


def test_every_answer_has_the_headers(page):
    answers = [
        request("GET", f"/?token={TOKEN}", page=page),
        request("GET", "/", page=page),
        request("GET", "/static/main.js", page=page),
        request("GET", "/static/absent.js", page=page),
        request("GET", "/absent", page=page),
        request("GET", "/", {"Host": "evil.example"}, page=page),
        post(),
        post("nothing"),
        post(content=b"["),
        post(X_Selfmotion_Token="x"),
        post("read", b"{}", Origin="null"),
    ]
    assert len({answer.status_code for answer in answers}) > 4
    for answer in answers:
        policies = answer.headers["content-security-policy"]
        assert policies.startswith("default-src 'none'; script-src 'self'")
        for part in ("style-src 'self';", "img-src 'self' blob: data:;", "connect-src 'self';", "base-uri 'none';"):
            assert part in policies
        assert policies.endswith("form-action 'none'; frame-ancestors 'none'")
        assert "unsafe" not in policies
        assert "*" not in policies
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["cross-origin-opener-policy"] == "same-origin"
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"
        assert answer.headers["cache-control"] == ("no-cache" if answer.text == "main()" else "no-store")
        assert "access-control-allow-origin" not in answer.headers
        assert "server" not in answer.headers


def test_a_mistake_in_the_studio_is_said_without_a_traceback():
    class Broken:
        def ask(self, task, payload, seconds):
            raise ZeroDivisionError("secret place")

    app = application(PORT, TOKEN, Broken())

    async def ask():
        transport = httpx.ASGITransport(app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url=HOME) as client:
            return await client.post("/api/look", headers=GOOD, content=b"{}")

    answer = asyncio.run(ask())
    assert answer.status_code == 500
    assert answer.json()["error"]["message"] == "a mistake in the studio: ZeroDivisionError"
    assert "secret" not in answer.text


def test_websockets_are_closed():
    sent = []

    async def send(message):
        sent.append(message)

    app = application(PORT, TOKEN, Echo())
    asyncio.run(app({"type": "websocket", "path": "/api/look", "headers": []}, None, send))
    assert sent == [{"type": "websocket.close", "code": 1008}]


def test_the_policy_of_a_page_allows_no_other_inline_script():
    hashes = re.findall("'sha256-[^']+'", guard.policy(["a", "b"]))
    assert hashes == [guard.source_hash("a"), guard.source_hash("b")]
    assert all(one != other for one, other in pairwise(hashes))
    assert guard.source_hash("") == "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"


def test_every_task_has_a_form():
    from selfmotion.studio.forms import FORMS

    assert set(FORMS) == {*TASKS, "check"}
