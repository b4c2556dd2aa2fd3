"""Worker processes: one question each, given up when nobody waits, replaced when they end, gone with their server."""

import asyncio
import json
import math
import os
import signal
import subprocess
import sys
import time
from contextlib import aclosing, asynccontextmanager

import pytest

from selfmotion.errors import Blocked, InfeasibleError, InvalidInputError, Need
from selfmotion.studio import workers
from selfmotion.studio.worker import Progress, _line, refusal
from selfmotion.studio.workers import Pool

FAKE = """
import json, os, sys, time
print("noise", file=sys.stderr)
for line in sys.stdin:
    asked = json.loads(line)
    task, payload = asked["task"], asked["payload"]
    say = lambda **what: print(json.dumps(what), flush=True)
    if task == "sleep":
        say(progress={"done": 1, "total": 2, "best": None})
        time.sleep(payload["seconds"])
    if task == "die":
        os.kill(os.getpid(), payload["signal"])
    if task == "cut":
        sys.stdout.write('{"result": '); sys.stdout.flush(); os._exit(3)
    if task == "child":
        import subprocess
        say(progress={"child": subprocess.Popen(["sleep", "60"]).pid})
        time.sleep(60)
    say(result={"pid": os.getpid(), "cwd": os.getcwd(), "payload": payload if task != "large" else "x" * payload["n"]})
"""
COMMAND = [sys.executable, "-c", FAKE]


@asynccontextmanager
async def pool_of(most=2, command=COMMAND):
    pool = Pool(os.getcwd(), most, command)
    try:
        yield pool
    finally:
        pids = pool.processes
        await asyncio.wait_for(pool.close(), 10)
        assert not any(is_there(pid) for pid in pids)


async def ask(pool, task, limit=None, **payload):
    async with aclosing(pool.ask(task, json.dumps(payload), limit)) as lines:
        return [json.loads(line) async for line in lines]


async def until(true, seconds=10.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it did not come true"
        await asyncio.sleep(0.01)


def is_there(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    try:  # neither is one that nobody waited for
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def run(test, **options):
    async def all_of_it():
        async with pool_of(**options) as pool:
            await test(pool)

    asyncio.run(all_of_it())


def test_an_idle_worker_is_borrowed_again():
    async def test(pool):
        (one,) = await ask(pool, "echo", text="é\n")
        assert one["result"]["payload"] == {"text": "é\n"}
        await until(lambda: len(pool.processes) == 2)
        pids = {(await ask(pool, "echo"))[0]["result"]["pid"] for _ in range(5)}
        assert pids <= set(pool.processes)

    run(test)


def test_one_is_ready_before_anybody_asks():
    async def test(pool):
        pool.reserve()
        pool.reserve()
        await until(lambda: pool.processes)
        (pid,) = pool.processes
        assert (await ask(pool, "echo"))[0]["result"]["pid"] == pid
        await until(lambda: len(pool.processes) == 2)  # and another one while it was busy

    run(test)


def test_one_too_many_is_told_to_wait_and_gets_its_turn():
    async def test(pool):
        busy = [asyncio.ensure_future(ask(pool, "sleep", seconds=0.5)) for _ in range(2)]
        await until(lambda: len(pool.processes) == 2)
        await asyncio.sleep(0.1)
        first, *_, last = await ask(pool, "echo", a=1)
        assert "waits for its turn" in first["progress"]["waiting"]
        assert last["result"]["payload"] == {"a": 1}
        assert all(lines[-1]["result"] for lines in await asyncio.gather(*busy))
        assert len(pool.processes) == 2

    run(test)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV, signal.SIGTERM])
def test_a_worker_that_ends_is_an_error_and_the_next_question_is_answered(number):
    async def test(pool):
        *_, last = await ask(pool, "die", signal=int(number))
        assert last["error"]["status"] == "error"
        assert last["error"]["message"].startswith("the worker process ended")
        assert last["error"]["remedy"]
        for _ in range(3):
            assert (await ask(pool, "echo"))[-1]["result"]

    run(test)


def test_half_an_answer_is_none():
    async def test(pool):
        (only,) = await ask(pool, "cut")
        assert only["error"]["message"].startswith("the worker process ended")

    run(test)


def test_a_worker_killed_while_idle_is_not_borrowed():
    async def test(pool):
        pid = (await ask(pool, "echo"))[0]["result"]["pid"]
        await until(lambda: len(pool.processes) == 2)
        for one in pool.processes:
            os.kill(one, signal.SIGKILL)
        await until(lambda: not is_there(pid))
        await asyncio.sleep(0.2)
        assert (await ask(pool, "echo"))[-1]["result"]["pid"] != pid

    run(test)


def test_what_takes_too_long_is_given_up():
    async def test(pool):
        began = time.monotonic()
        *_, last = await ask(pool, "sleep", limit=1.0, seconds=60)
        assert "too long" in last["error"]["message"]
        assert 0.9 < time.monotonic() - began < 8
        assert (await ask(pool, "echo"))[-1]["result"]

    run(test)


def test_a_worker_that_nobody_waits_for_is_killed_and_replaced():
    async def test(pool):
        lines = pool.ask("sleep", '{"seconds": 60}')
        assert b"progress" in await anext(lines)
        (before,) = pool.processes
        await lines.aclose()
        await until(lambda: not is_there(before), 3)
        await until(lambda: pool.processes and pool.processes != [before])
        assert (await ask(pool, "echo"))[-1]["result"]

    run(test, most=1)


def test_a_cancelled_question_gives_its_worker_up():
    async def test(pool):
        question = asyncio.ensure_future(ask(pool, "sleep", seconds=60))
        await until(lambda: pool.processes)
        await asyncio.sleep(0.3)
        before = set(pool.processes)
        question.cancel()
        await asyncio.gather(question, return_exceptions=True)
        await until(lambda: sum(map(is_there, before)) <= 1, 3)

    run(test)


def test_a_worker_that_is_nearly_done_is_kept(monkeypatch):
    monkeypatch.setattr(workers, "_GRACE", 5.0)

    async def test(pool):
        lines = pool.ask("sleep", '{"seconds": 0.2}')
        await anext(lines)
        before = set(pool.processes)
        await lines.aclose()
        await asyncio.sleep(0.5)
        assert all(is_there(pid) for pid in before)
        assert (await ask(pool, "echo", a=1))[-1]["result"]["payload"] == {"a": 1}  # and not the answer of before

    run(test, most=1)


def test_questions_that_wait_can_be_cancelled():
    async def test(pool):
        busy = asyncio.ensure_future(ask(pool, "sleep", seconds=0.6))
        await until(lambda: pool.processes)
        waiting = [asyncio.ensure_future(ask(pool, "echo")) for _ in range(5)]
        await asyncio.sleep(0.1)
        for one in waiting[:4]:
            one.cancel()
        assert (await waiting[4])[-1]["result"]
        assert (await busy)[-1]["result"]

    run(test, most=1)


def test_what_a_worker_started_is_killed_with_it():
    async def test(pool):
        lines = pool.ask("child", "{}")
        pid = json.loads(await anext(lines))["progress"]["child"]
        assert is_there(pid)
        await lines.aclose()
        await until(lambda: not is_there(pid), 3)

    run(test)


def test_many_questions_at_once_are_all_answered():
    async def test(pool):
        answers = await asyncio.gather(*(ask(pool, "echo", n=n) for n in range(40)))
        assert [lines[-1]["result"]["payload"]["n"] for lines in answers] == list(range(40))
        assert len(pool.processes) <= 3

    run(test, most=3)


def test_long_lines_go_both_ways(monkeypatch):
    async def test(pool):
        *_, last = await ask(pool, "large", n=20_000_000)
        assert len(last["result"]["payload"]) == 20_000_000
        *_, last = await ask(pool, "echo", text="y" * 10_000_000)
        assert len(last["result"]["payload"]["text"]) == 10_000_000

    run(test)
    monkeypatch.setattr(workers, "_LONGEST", 1000)

    async def too_long(pool):
        *_, last = await ask(pool, "large", n=20_000_000)
        assert last["error"]
        assert (await ask(pool, "echo"))[-1]["result"]

    run(too_long)


def test_a_worker_that_cannot_be_started_is_an_error():
    async def test(pool):
        pool.reserve()
        for _ in range(2):
            *_, last = await asyncio.wait_for(ask(pool, "echo"), 10)
            assert last["error"]["message"].startswith("no worker process can be started")

    run(test, command=["/absent/python"])


def test_a_closed_pool_answers_that_it_is_closing():
    async def test(pool):
        busy = asyncio.ensure_future(ask(pool, "sleep", seconds=60))
        waiting = asyncio.ensure_future(ask(pool, "echo"))
        await until(lambda: pool.processes)
        await asyncio.sleep(0.2)
        await asyncio.wait_for(pool.close(), 5)
        for question in (busy, waiting):
            assert "closing" in (await asyncio.wait_for(question, 5))[-1]["error"]["message"]
        assert "closing" in (await ask(pool, "echo"))[-1]["error"]["message"]
        assert not pool.processes

    run(test, most=1)


def started(folder, **options):
    command = [*workers._COMMAND, str(folder)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)


def question(task, **payload):
    return json.dumps({"task": task, "payload": payload}).encode() + b"\n"


def test_the_worker_answers_a_line_each_and_survives_nonsense(tmp_path):
    (tmp_path / "json.py").write_text("raise SystemExit('a module in the folder was imported')")
    with started(tmp_path, cwd=tmp_path) as process:
        asked = [question("files"), b"\n", b"nonsense\n", b"[]\n", b'{"task": "os.system", "payload": {}}\n']
        asked += [question("open", file="../x.yaml"), question("read", text="arm: {}\npath: {}"), question("schema")]
        process.stdin.write(b"".join(asked))
        process.stdin.flush()
        answers = [json.loads(process.stdout.readline()) for _ in asked]
        assert [next(iter(answer)) for answer in answers] == ["result", *["error"] * 5, *["result"] * 2]
        for answer in answers:
            assert set(answer.get("error", {})) <= {"status", "message", "remedy", "field", "blocked", "needs"}
            assert "Traceback" not in json.dumps(answer)
        assert answers[5]["error"]["field"] == "file"
        assert answers[6]["result"] == {"problem": {"arm": {}, "path": {}}}
        process.stdin.close()
        assert process.wait(10) == 0


SPIN = """
import sys, ctypes, selfmotion.studio.worker as worker
def spin(name, payload, folder, tell):
    tell(0, 1, 1.0)
    if payload.get("locked"):  # as compiled code that keeps the interpreter: no other thread runs
        ctypes.PyDLL(None).sleep(60)
    while True:
        pass
worker.answer, worker._WARM, worker._look_once = spin, (), lambda folder: None
worker.main()
"""
PARENT = """
import subprocess, sys, json, time
child = subprocess.Popen([sys.executable, "-c", sys.argv[1], "."], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
child.stdin.write(json.dumps({"task": "x", "payload": {"locked": bool(int(sys.argv[2]))}}).encode() + b"\\n")
child.stdin.flush()
child.stdout.readline()
time.sleep(0.5)
print(child.pid, flush=True)
input()
"""


@pytest.mark.parametrize(
    "locked", [0, pytest.param(1, marks=pytest.mark.skipif(sys.platform != "linux", reason="prctl"))]
)
def test_a_busy_worker_is_gone_when_its_parent_is_killed(locked):
    with subprocess.Popen(
        [sys.executable, "-c", PARENT, SPIN, str(locked)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as parent:
        pid = int(parent.stdout.readline())
        assert is_there(pid)
        parent.kill()
        parent.wait()
        asyncio.run(until(lambda: not is_there(pid), 3))


def test_progress_is_said_not_too_often_and_the_last_word_always():
    said = []
    tell = Progress(said.append)
    for k in range(1000):
        tell(k, 1000, math.inf if k < 500 else 1000.0 - k)
    tell.flush()
    assert 2 <= len(said) < 100
    assert said[0] == {"progress": {"done": 0, "total": 1000, "best": None}}
    assert said[-1] == {"progress": {"done": 999, "total": 1000, "best": 1.0}}
    tell.flush()
    assert said[-1] != said[-2]
    tell(1, 0, None)
    tell.flush()
    assert said[-1]["progress"]["best"] is None
    tell(2, 0, 0.0)
    tell.flush()
    assert said[-1]["progress"]["best"] == 0.0


def test_answers_hold_what_json_knows():
    import numpy as np

    line = _line(
        {"result": {"a": math.nan, "b": [math.inf, np.float64(2.5), np.int32(3)], "c": np.array([1.0, math.nan])}}
    )
    assert json.loads(line, parse_constant=pytest.fail) == {
        "result": {"a": None, "b": [None, 2.5, 3], "c": [1.0, None]}
    }
    assert line.count(b"\n") == 1
    assert _line({"result": "é\n\u2028"}).count(b"\n") == 1


def test_errors_are_said_as_the_page_hears_them(capsys):
    blocked = InfeasibleError(
        [Blocked((0.1, 0.2), "joint limits", None, ("upper limit of θ1",))], [Need(1, "upper", 0.5)]
    )
    assert refusal(blocked) == {
        "status": "infeasible", "message": blocked.message, "remedy": blocked.remedy, "field": None,
        "blocked": [{"r": [0.1, 0.2], "cause": "joint limits", "short_by": None, "limits": ["upper limit of θ1"]}],
        "needs": ["θ1 needs 0.5 rad more above its upper limit"],
    }  # fmt: skip
    wrong = refusal(InvalidInputError("path.start", "is wrong", "right it"))
    assert (wrong["status"], wrong["field"], wrong["remedy"], wrong["blocked"]) == (
        "error",
        "path.start",
        "right it",
        None,
    )
    assert "memory" in refusal(MemoryError())["message"]
    assert "deeply" in refusal(RecursionError())["message"]
    assert capsys.readouterr().err == ""
    ours = refusal(KeyError("x"))
    assert ours["message"] == "a mistake in selfmotion: KeyError: 'x'"
    assert "KeyError" in capsys.readouterr().err  # for whoever reports it
