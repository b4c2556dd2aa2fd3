"""The studio as a user starts it: a process of its own, asked over its port."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress

import httpx

EXAMPLE = {
    "arm": {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 3.14], None]},
    "path": {"kind": "line", "start": [50, -10], "end": [70, 10]},
    "samples": 100,
}
LONG = {  # takes minutes
    **EXAMPLE,
    "samples": 2000,
    "planner": {
        "kind": "sinusoid",
        "offset": [0.3],
        "amplitude": [0.4],
        "optimizer": {"kind": "pso", "population": 20, "iterations": 1_000_000, "bounds": [0, 15], "seed": 1},
    },
}


class Studio:
    """A studio that runs; `with` ends it."""

    def __init__(self, *arguments, cwd=None):
        self.ended = None
        self.process = subprocess.Popen(
            [sys.executable, "-m", "selfmotion", "studio", "--no-browser", *arguments],
            cwd=cwd, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.address = self.process.stdout.readline().strip()
        self.home, _, self.token = self.address.partition("/?token=")
        self.port = int(self.home.rpartition(":")[2] or 0)
        self.headers = {"X-Selfmotion-Token": self.token, "Content-Type": "application/json"}

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.end()

    def end(self, number=signal.SIGTERM):
        """End it by a signal; return its exit code and what it said on both streams."""
        if self.ended is None:
            if self.process.poll() is None:
                self.process.send_signal(number)
            try:
                out, err = self.process.communicate(timeout=20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.communicate()
                raise
            self.ended = self.process.returncode, out, err
        return self.ended

    def post(self, task, timeout=120, **payload):
        return httpx.post(f"{self.home}/api/{task}", headers=self.headers, json=payload, timeout=timeout)

    def ask(self, task, **payload):
        """Return the last line of an answer."""
        answer = self.post(task, **payload)
        return json.loads(answer.text.splitlines()[-1])

    def streamed(self, task, **payload):
        """Return an answer that is still coming, to be used in `with`."""
        return httpx.stream(
            "POST", f"{self.home}/api/{task}", headers=self.headers, json=payload, timeout=httpx.Timeout(120)
        )

    def raw(self, *lines, body=b"", timeout=20):
        """Send a request as it is written here, and return what comes until the server closes, or nothing comes."""
        with socket.create_connection(("127.0.0.1", self.port), timeout) as line:
            with suppress(OSError):  # refused before it was all sent
                line.sendall("\r\n".join([*lines, "", ""]).encode("latin-1") + body)
            came = b""
            with suppress(TimeoutError, ConnectionError):
                while part := line.recv(65536):
                    came += part
            return came

    def workers(self):
        """Return the process ids of its workers."""
        return children(self.process.pid)

    def working(self):
        """Return the worker that uses the processor, once the others have got warm."""
        end = time.monotonic() + 30
        while time.monotonic() < end:
            before = {pid: ticks(pid) for pid in self.workers()}
            time.sleep(0.5)
            busy = [pid for pid in before if ticks(pid) > before[pid]]
            if len(busy) == 1 and len(before) > 1:
                return busy[0]
        raise AssertionError(f"of the workers {before}, {busy} are busy")


def children(parent):
    found = []
    for name in os.listdir("/proc"):
        if name.isdigit():
            fields = stat(int(name))
            if fields and int(fields[1]) == parent and fields[0] != "Z":
                found.append(int(name))
    return found


def stat(pid):
    """Return the fields of a process from its state on; none if it is gone."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()
    except OSError:
        return []


def ticks(pid):
    fields = stat(pid)
    return int(fields[11]) + int(fields[12]) if fields else -1


def is_there(pid):
    fields = stat(pid)
    return bool(fields) and fields[0] != "Z"


def until(true, seconds=10.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it did not come true"
        time.sleep(0.02)
