"""The studio's server as it is started: what it listens on, what hostile and broken clients do to it, how it ends."""

import concurrent.futures
import json
import os
import signal
import socket
import subprocess
import sys
import time

import httpx
import pytest
from served import EXAMPLE, LONG, Studio, children, is_there, until

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio")
    (folder / "good.yaml").write_text(json.dumps(EXAMPLE))
    with Studio(cwd=folder) as served:
        yield served


@pytest.fixture(autouse=True)
def lives_on(request):
    """After each test the server is the same, and answers."""
    yield
    if "studio" in request.fixturenames:
        studio = request.getfixturevalue("studio")
        assert studio.process.poll() is None
        assert studio.ask("files")["result"]["files"] == ["good.yaml"]


def code(answer):
    return int(answer.split(b" ")[1]) if answer.startswith(b"HTTP/1.1 ") else 0


def listening():
    """Return the addresses and inodes of all sockets of this machine that listen."""
    found = {}
    for name in ("/proc/net/tcp", "/proc/net/tcp6"):
        with open(name) as file:
            for fields in map(str.split, list(file)[1:]):
                if fields[3] == "0A":
                    found[fields[9]] = fields[1]
    return found


def test_it_listens_on_loopback_only(studio):
    inodes = set()
    for name in os.listdir(f"/proc/{studio.process.pid}/fd"):
        target = os.readlink(f"/proc/{studio.process.pid}/fd/{name}")
        if target.startswith("socket:["):
            inodes.add(target[8:-1])
    assert [address for inode, address in listening().items() if inode in inodes] == [f"0100007F:{studio.port:04X}"]


def test_it_is_not_reached_by_the_machine_s_other_addresses(studio):
    others = {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:  # which sends nothing
        try:
            probe.connect(("192.0.2.1", 9))
            others.add(probe.getsockname()[0])
        except OSError:
            pass
    others = [address for address in others if not address.startswith("127.")]
    if not others:
        pytest.skip("this machine has no other address")
    for address in others:
        with pytest.raises(OSError, match="refused"):
            socket.create_connection((address, studio.port), 5)


def test_the_page_its_files_and_questions(studio):
    page = httpx.get(studio.address)
    assert page.status_code == 200
    assert studio.token in page.text
    assert "server" not in page.headers
    (name, *_) = sorted(json.loads(page.text.split('"importmap">')[1].split("</script>")[0])["imports"].values())
    assert httpx.get(studio.home + name).headers["content-type"].startswith("text/javascript")
    assert httpx.get(studio.home).status_code == 403
    assert studio.ask("open", file="good.yaml")["result"]["problem"] == EXAMPLE
    found = studio.ask("look", problem=EXAMPLE, want=["scene"], settled=True)["result"]
    assert found["scene"]["links"] == [30, 30, 20]


def test_the_server_itself_loads_nothing_heavy(studio):
    studio.ask("look", problem=EXAMPLE)
    with open(f"/proc/{studio.process.pid}/maps") as file:
        maps = file.read()
    for name in ("numpy", "numba", "llvmlite", "scipy", "matplotlib"):
        assert f"/{name}" not in maps, name


def test_a_problem_that_is_refused_says_field_and_remedy(studio):
    wrong = {**EXAMPLE, "arm": {"kind": "planar", "links": [1, -1, 1]}}
    error = studio.ask("look", problem=wrong)["error"]
    assert error["status"] == "error"
    assert error["field"].startswith("arm.links")
    blocked = {**LONG, "path": {"kind": "line", "start": [50, -10], "end": [90, 10]}}
    error = studio.ask("plan", problem=blocked)["error"]
    assert error["status"] == "infeasible"
    assert error["blocked"][0]["cause"] == "out of reach"


@pytest.mark.parametrize(("lines", "expected"), [
    (["GET / HTTP/1.1"], {400, 421}),
    (["GET / HTTP/1.1", "Host: evil.example"], {421}),
    (["GET / HTTP/1.1", "Host: 127.0.0.1:{port}", "Host: evil.example"], {400}),
    (["GET http://evil.example/?token={token} HTTP/1.1", "Host: evil.example"], {421}),
    (["GET /?token={token} HTTP/1.1", "Host: 127.0.0.1:{port}", "Origin: http://evil.example"], {403}),
    (["GET /static/../server.py HTTP/1.1", "Host: 127.0.0.1:{port}"], {404}),
    (["GET /static/..%2fserver.py HTTP/1.1", "Host: 127.0.0.1:{port}"], {404}),
    (["GET /static/%2e%2e/server.py HTTP/1.1", "Host: 127.0.0.1:{port}"], {404}),
    (["GET /static//etc/passwd HTTP/1.1", "Host: 127.0.0.1:{port}"], {404}),
    (["OPTIONS /api/look HTTP/1.1", "Host: 127.0.0.1:{port}", "Access-Control-Request-Method: POST"], {405}),
    (["CONNECT 127.0.0.1:{port} HTTP/1.1", "Host: 127.0.0.1:{port}"], {404, 405, 400}),
    (["POST /api/look HTTP/1.1", "Host: 127.0.0.1:{port}", "Content-Length: 2"], {403}),
    (["{question}", "Content-Length: 16000001"], {413}),
    (["{question}", "Content-Length: 99999999999999999999999999"], {413, 400}),
    (["{question}", "Content-Length: -5"], {400}),
    (["{question}", "Content-Length: 5", "Content-Length: 6"], {400}),
    (["{question}", "Content-Length: 5", "Transfer-Encoding: chunked"], {400, 0}),
    (["{question}", "Transfer-Encoding: gzip"], {400, 501}),
    (["GET / HTTP/1.1", "Host: 127.0.0.1:{port}", "X: " + "x" * 1_000_000], {400, 431}),
    (["GET / HTTP/9.9", "Host: 127.0.0.1:{port}"], {400, 403, 505}),
    (["nonsense"], {400}),
    (["\x16\x03\x01\x02\x00\x01"], {400}),
    (["GET /?token={token} HTTP/1.1", "Host: 127.0.0.1:{port}", "Sec-Fetch-Site: cross-site"], {403}),
])  # fmt: skip
def test_requests_that_no_page_sends_are_refused(studio, lines, expected):
    question = f"POST /api/look HTTP/1.1\r\nHost: 127.0.0.1:{studio.port}\r\nX-Selfmotion-Token: {studio.token}"
    question += "\r\nContent-Type: application/json"
    places = {"{port}": str(studio.port), "{token}": studio.token, "{question}": question}
    for place, value in places.items():
        lines = [line.replace(place, value) for line in lines]
    answer = studio.raw(*lines, "Connection: close", timeout=3)
    assert code(answer) in expected, answer[:300]
    assert b"Traceback" not in answer
    assert b"root:" not in answer
    assert studio.token.encode() not in answer


def test_a_body_without_length_is_refused_as_it_comes(studio):
    content = (b" " * 1_000_000 for _ in range(300))
    answer = httpx.post(f"{studio.home}/api/look", headers=studio.headers, content=content, timeout=60)
    assert answer.status_code == 413
    with open(f"/proc/{studio.process.pid}/status") as file:
        (largest,) = [int(line.split()[1]) for line in file if line.startswith("VmHWM")]
    assert largest < 200_000  # kB; what came after the first 16 MB was not kept


MALFORMED = [
    b"", b"{", b"[]", b"null", b'{"problem": NaN}', b'{"problem": 1e999}', b"[" * 500_000,
    b'{"a":' * 50_000, b"\xff\xfe", b'"x"',
]  # fmt: skip
REFUSED = [
    {}, {"problem": 1}, {"problem": []}, {"problem": {}}, {"problem": {"arm": 1, "path": 2}}, {"problem": None, "x": 1},
    {"problem": {"arm": {"kind": "named", "name": "../../x"}, "path": {}}}, {"problem": {**EXAMPLE, "samples": 10**30}},
    {"problem": {**EXAMPLE, "arm": {"kind": "planar", "links": [1e308] * 3}}}, {"problem": EXAMPLE, "want": ["x"]},
    {"problem": {**EXAMPLE, "samples": -1}}, {"problem": {**EXAMPLE, "path": {"kind": "file", "file": "/etc/passwd"}}},
    {"problem": {**EXAMPLE, "path": {"kind": "file", "file": "<script>alert(1)</script>"}}},
]  # fmt: skip


def test_malformed_messages_are_refused(studio):
    with httpx.Client(headers=studio.headers, timeout=60) as client:
        for body in MALFORMED:
            answer = client.post(f"{studio.home}/api/look", content=body)
            assert answer.status_code == 400, body[:20]
            assert answer.json()["error"]["message"]
        for payload in REFUSED:
            answer = client.post(f"{studio.home}/api/look", json=payload)
            assert answer.status_code == 200
            (only,) = map(json.loads, answer.text.splitlines())
            assert only["error"]["message"], payload
            assert "Traceback" not in answer.text
            assert "a mistake in selfmotion" not in answer.text, answer.text


def test_a_worker_killed_in_mid_task_is_an_error_and_the_next_question_is_answered(studio):
    with studio.streamed("plan", problem=LONG) as answer:
        lines = answer.iter_lines()
        assert "progress" in json.loads(next(lines))
        os.kill(studio.working(), signal.SIGKILL)
        *_, last = map(json.loads, lines)
    assert last["error"]["status"] == "error"
    assert last["error"]["message"].startswith("the worker process ended")
    assert studio.ask("look", problem=EXAMPLE)["result"]


def test_a_client_that_goes_away_ends_its_plan(studio):
    with studio.streamed("plan", problem=LONG) as answer:
        lines = answer.iter_lines()  # which hangs up when nobody holds it
        assert "progress" in json.loads(next(lines))
        pid = studio.working()
        assert is_there(pid)
    until(lambda: not is_there(pid), 2)
    assert studio.ask("look", problem=EXAMPLE)["result"]


def test_two_clients_at_once(studio):
    with studio.streamed("plan", problem=LONG) as one, studio.streamed("plan", problem=LONG) as other:
        both = one.iter_lines(), other.iter_lines()
        assert all("progress" in json.loads(next(lines)) for lines in both)
        began = time.monotonic()
        assert studio.ask("look", problem=EXAMPLE)["result"]  # a third is there for those who look
        assert time.monotonic() - began < 20
        assert len(studio.workers()) == 3
    with concurrent.futures.ThreadPoolExecutor(8) as threads:
        problems = [{**EXAMPLE, "samples": 50 + k} for k in range(24)]
        found = list(threads.map(lambda problem: studio.ask("look", problem=problem, want=["scene"]), problems))
    assert [one["result"]["scene"]["samples"] for one in found] == [50 + k for k in range(24)]
    assert len(studio.workers()) <= 3


def test_connections_that_say_nothing_do_not_keep_others_out(studio):
    idle = [socket.create_connection(("127.0.0.1", studio.port)) for _ in range(50)]
    try:
        assert studio.ask("files")["result"]
    finally:
        for line in idle:
            line.close()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_everything_quietly(number, tmp_path):
    with Studio(cwd=tmp_path) as studio, studio.streamed("plan", problem=LONG) as answer:
        lines = answer.iter_lines()
        assert "progress" in json.loads(next(lines))
        pids = studio.workers()
        assert pids
        began = time.monotonic()
        assert studio.end(number) == (0, "", "")
        assert time.monotonic() - began < 5
        *_, last = map(json.loads, lines)
        assert "closing" in last["error"]["message"]
    assert not any(map(is_there, pids))


def test_an_interrupt_from_the_terminal_reaches_all_and_nobody_complains(tmp_path):
    code = "import sys; from selfmotion.cli import main; main(['studio', '--no-browser'])"
    with subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    ) as process:
        assert process.stdout.readline()
        until(lambda: children(process.pid))
        pids = children(process.pid)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=20)
        assert (process.returncode, out, err) == (0, b"", b"")
        assert not any(map(is_there, pids))


def test_an_interrupt_at_any_time_ends_it(tmp_path):
    for wait in (0.0, 0.15, 0.3, 0.6):
        with Studio(cwd=tmp_path) as studio:
            time.sleep(wait)
            pids = studio.workers()
            status, out, err = studio.end(signal.SIGINT)
        assert status in (0, 130)
        assert out == ""
        assert "Traceback" not in err
        until(lambda pids=pids: not any(map(is_there, pids)), 3)


def test_workers_are_gone_when_the_server_is_killed(tmp_path):
    with Studio(cwd=tmp_path) as studio, studio.streamed("plan", problem=LONG) as answer:
        lines = answer.iter_lines()
        assert "progress" in json.loads(next(lines))
        pids = studio.workers()
        assert pids
        studio.end(signal.SIGKILL)
    until(lambda: not any(map(is_there, pids)), 3)
