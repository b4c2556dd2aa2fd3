"""The command `studio`: what it refuses at once, what it prints, and what it does not load."""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from selfmotion.studio import server


class Serving:
    """A server that answers nothing and ends when it is told to, or is `over`."""

    def __init__(self, over=lambda: False):
        self.should_exit, self.over, self.addresses = False, over, []

    async def serve(self, sockets):
        self.addresses += [one.getsockname() for one in sockets]
        while not (self.should_exit or self.over()):
            await asyncio.sleep(0.01)


@pytest.fixture(autouse=True)
def serving(monkeypatch):
    """A command that is not refused would serve until it is interrupted."""
    made = Serving()
    monkeypatch.setattr(server, "_server", lambda app, pool: made)
    return made


def test_a_port_in_use_is_2(run):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        code, out, err = run("studio", "--no-browser", "--port", str(port))
    assert (code, out) == (2, "")
    remedy = "choose another, or none for a free one"
    assert err == f"selfmotion: --port: {port} cannot be had (address already in use); {remedy}\n"


@pytest.mark.parametrize("port", ["-1", "65536", "x"])
def test_a_port_that_is_none_is_2(run, port):
    code, out, err = run("studio", "--no-browser", "--port", port)
    assert (code, out) == (2, "")
    assert "--port" in err


@pytest.mark.parametrize("package", ["starlette", "uvicorn"])
def test_what_is_not_installed_is_said(run, monkeypatch, package):
    real = server.find_spec
    monkeypatch.setattr(server, "find_spec", lambda name: None if name == package else real(name))
    code, out, err = run("studio", "--no-browser")
    assert (code, out) == (2, "")
    assert err == f"selfmotion: needs the package {package}; pip install 'selfmotion[studio]'\n"


@pytest.mark.parametrize(("arguments", "says"), [
    (["absent.yaml"], ["absent.yaml", "does not exist"]),
    (["absent/x.yaml"], ["absent/x.yaml", "does not exist"]),
    (["."], ["is a folder"]),
    (["bad.json"], ["bad.json", "path.control_points", "at least two"]),
    (["plan.json"], ["plan.json", "is a stored plan"]),
    (["good.txt"], ["file", "end it in .yaml"]),
    (["good.json", "--folder", "other"], ["--folder", "does not hold the problem file"]),
    (["--folder", "absent"], ["--folder", "is not a folder"]),
    (["--folder", "good.json"], ["--folder", "is not a folder"]),
])  # fmt: skip
def test_bad_input_is_2_in_one_line(run, seed_file, tmp_path, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    seed_file("good.json")
    seed_file("good.txt")
    seed_file("bad.json", path={"kind": "bezier", "control_points": [[50, 0]]})
    (tmp_path / "plan.json").write_text('{"selfmotion_plan": 1}')
    (tmp_path / "other").mkdir()
    code, out, err = run("studio", "--no-browser", *arguments)
    assert code == 2
    assert out == "" or arguments[0] in ("bad.json", "plan.json", "good.txt")  # what is looked into: while it serves
    assert err.count("\n") == 1
    for part in says:
        assert part in err


def test_what_plan_refuses_studio_refuses_in_the_same_words(run, seed_file):
    wrong = seed_file(arm={"kind": "planar", "links": [30, -30, 20]})
    code, out, err = run("studio", "--no-browser", wrong)
    assert (code, err) == (2, run("plan", wrong)[2])
    assert out.startswith("http://127.0.0.1:")  # printed at once


def test_it_serves_a_good_file_and_opens_the_browser_unless_told_not_to(run, seed_file, serving, monkeypatch):
    opened, begun = [], []
    monkeypatch.setattr("webbrowser.open", opened.append)
    serving.over = lambda: bool(opened)
    code, out, err = run("studio", seed_file())
    assert (code, err) == (0, "")
    assert serving.addresses[0] == ("127.0.0.1", int(out.split(":")[2].split("/")[0]))
    assert opened == [out.strip()]
    assert len(out.strip().partition("?token=")[2]) >= 40
    serving.over = lambda: len(begun) > 5 or begun.append(1)
    assert run("studio", "--no-browser", "--port", "0")[0] == 0
    assert len(opened) == 1


def started(*arguments, **options):
    command = [sys.executable, "-m", "selfmotion", "studio", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def test_the_address_is_printed_before_anything_heavy_is_loaded(tmp_path):
    began = time.monotonic()
    with started("--no-browser", cwd=tmp_path) as process:
        address = process.stdout.readline()
        took = time.monotonic() - began
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
    assert address.startswith("http://127.0.0.1:")
    assert took < 5
    assert (out, err) == ("", "")
    assert process.returncode in (0, 130)
    code = (
        "import sys, selfmotion.studio.server as s\n"
        "def server(*args):\n"
        "    heavy = {'numpy', 'numba', 'scipy', 'starlette', 'uvicorn', 'matplotlib'} & set(sys.modules)\n"
        "    sys.exit(str(heavy) if heavy else 0)\n"
        "s.application = lambda *args: None\n"
        "s._server = server\n"
        "s.serve(None, None, False, None)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("http://127.0.0.1:")


def test_help_loads_nothing_of_the_studio():
    code = (
        "import sys\nfrom selfmotion.cli import _run\n_run(['studio', '--help'])\n"
        "heavy = {'numpy', 'starlette', 'uvicorn', 'selfmotion.studio.server'} & set(sys.modules)\n"
        "sys.exit(str(heavy) if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "--no-browser" in done.stdout


def test_the_page_knows_the_file_by_its_name(seed_file, tmp_path):
    import httpx

    file = seed_file("a&<b>.json")
    with started("--no-browser", file, cwd=os.path.dirname(tmp_path)) as process:
        try:
            address = process.stdout.readline().strip()
            page = httpx.get(address, timeout=20).text
            assert '<meta name="selfmotion-file" content="a&amp;&lt;b&gt;.json">' in page
            home, _, token = address.partition("?token=")
            asked = httpx.post(
                f"{home}api/open", json={"file": "a&<b>.json"}, headers={"X-Selfmotion-Token": token}, timeout=60
            )
            with open(file) as text:
                assert json.loads(asked.text.splitlines()[-1])["result"]["problem"] == json.load(text)
        finally:
            process.terminate()
            process.communicate(timeout=20)
