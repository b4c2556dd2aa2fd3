"""A pool of worker processes: what is asked is done elsewhere, can be given up, and may crash without harm."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import AsyncGenerator, Coroutine, Sequence
from contextlib import aclosing, suppress
from typing import Any

# -P: a json.py in the working folder is not ours.
_COMMAND = (sys.executable, "-P", "-m", "selfmotion.studio.worker")
_LONGEST = 256 * 2**20  # bytes of a line
_GRACE = 0.05  # seconds in which a worker whose page is gone may still finish
_PROGRESS = b'{"progress"'

_ENDED = {
    "message": "the worker process ended before it had an answer",
    "remedy": "try again; if it ends again, ask for less: fewer samples, a smaller population, a wider gap",
}
_LATE = {"message": "this took too long and was given up", "remedy": "ask for less: fewer samples, a shorter path"}
_CLOSING = {"message": "the studio is closing", "remedy": "start it again: selfmotion studio"}
_WAITING = "all workers are busy: this waits for its turn"


def error_line(message: str, remedy: str, field: str | None = None) -> bytes:
    """Return an error as one line of an answer."""
    said = {"status": "error", "message": message, "remedy": remedy, "field": field, "blocked": None, "needs": None}
    return json.dumps({"error": said}).encode() + b"\n"


class Pool:
    """Worker processes, of which one answers at a time.

    Parameters
    ----------
    folder : str
        Where they work.
    most : int
        How many there may be.
    command : sequence of str
        What starts one, before the folder.
    """

    def __init__(self, folder: str, most: int = 3, command: Sequence[str] = _COMMAND) -> None:
        self._command, self._most = (*command, folder), most
        self._idle: list[asyncio.subprocess.Process] = []
        self._alive: set[asyncio.subprocess.Process] = set()
        self._starting = 0
        self._free = asyncio.Condition()
        self._background: set[asyncio.Task[None]] = set()
        self._closed = False

    @property
    def processes(self) -> list[int]:
        """Process ids of those that are there."""
        return [process.pid for process in self._alive]

    def reserve(self) -> None:
        """See to it, in the background, that one more is ready than are busy."""
        if not self._closed and not self._idle and not self._starting and len(self._alive) < self._most:
            self._starting += 1
            self._later(self._reserve())

    async def _reserve(self) -> None:
        try:
            process = await self._start()
        except OSError:  # said to whoever asks
            return
        finally:
            self._starting -= 1
            await self._tell_waiting()
        await self._return(process)

    async def ask(self, task: str, payload: str, seconds: float | None = None) -> AsyncGenerator[bytes, None]:
        """Yield the lines of an answer; when the iterator is closed early, the worker is given up.

        Parameters
        ----------
        task : str
        payload : str
            JSON on one line.
        seconds : float, optional
            After which the task is given up.
        """
        if not self._idle and self._starting + len(self._alive) >= self._most:
            progress = {"done": 0, "total": 0, "best": None, "waiting": _WAITING}
            yield json.dumps({"progress": progress}).encode() + b"\n"
        try:
            process = await self._borrow()
        except OSError as error:
            yield error_line(f"no worker process can be started ({error.strerror})", "close other programs")
            return
        if process is None:
            yield error_line(**_CLOSING)
            return
        whole = False
        try:
            question = f'{{"task":{json.dumps(task)},"payload":{payload}}}\n'.encode()
            lines = self._lines(process, question, seconds)
            async with aclosing(lines):
                async for line in lines:
                    whole = not line.startswith(_PROGRESS) and line.endswith(b"\n")
                    yield line
                    if whole:
                        return
            yield error_line(**(_CLOSING if self._closed else _ENDED))
        except TimeoutError:
            yield error_line(**_LATE)
        finally:
            self._later(self._return(process) if whole else self._give_up(process))

    async def _lines(
        self, process: asyncio.subprocess.Process, question: bytes, seconds: float | None
    ) -> AsyncGenerator[bytes, None]:
        stdin, stdout = process.stdin, process.stdout
        assert stdin is not None
        assert stdout is not None
        loop = asyncio.get_running_loop()
        end = None if seconds is None else loop.time() + seconds
        try:
            stdin.write(question)
            async with asyncio.timeout_at(end):
                await stdin.drain()
            while True:
                async with asyncio.timeout_at(end):
                    line = await stdout.readline()
                if not line.endswith(b"\n"):  # cut off, or nothing: it ended
                    return
                yield line
        except (ConnectionError, ValueError):  # it ended, or the line is longer than any can be
            return

    async def _borrow(self) -> asyncio.subprocess.Process | None:
        """Return an idle worker, or a new one, or wait for one; None when the pool closes."""
        async with self._free:
            while not self._closed:
                while self._idle:
                    process = self._idle.pop()
                    if process.returncode is None:
                        self.reserve()
                        return process
                    self._later(self._end(process))
                if not self._starting and len(self._alive) < self._most:
                    self._starting += 1
                    break
                await self._free.wait()
            else:
                return None
        try:
            process = await self._start()
        finally:
            self._starting -= 1
            self._later(self._tell_waiting())
        self.reserve()
        return process

    async def _start(self) -> asyncio.subprocess.Process:
        """Start a worker, in a session of its own: an interrupt from the terminal is the server's affair."""
        threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        process = await asyncio.create_subprocess_exec(
            *self._command,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            env={**os.environ, **threads},
            limit=_LONGEST,
            start_new_session=True,
        )
        self._alive.add(process)
        if self._closed:
            _kill(process)
        return process

    async def _return(self, process: asyncio.subprocess.Process) -> None:
        if process.returncode is None and not self._closed:
            self._idle.append(process)
            await self._tell_waiting()
        else:
            await self._end(process)

    async def _give_up(self, process: asyncio.subprocess.Process) -> None:
        """End a worker that nobody waits for, unless it is done in a moment, and start another."""
        done = False
        with suppress(TimeoutError, ConnectionError, ValueError):
            async with asyncio.timeout(_GRACE):
                assert process.stdout is not None
                while line := await process.stdout.readline():
                    done = line.endswith(b"\n") and not line.startswith(_PROGRESS)
                    if done:
                        break
        if done:
            await self._return(process)
            return
        await self._end(process)
        self.reserve()

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        await _ended(process)
        self._alive.discard(process)
        await self._tell_waiting()

    async def _tell_waiting(self) -> None:
        async with self._free:
            self._free.notify_all()

    def _later(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.ensure_future(work)
        self._background.add(task)
        task.add_done_callback(self._background.discard)

    async def close(self) -> None:
        """End all workers and whatever is still asked of them."""
        self._closed = True
        await self._tell_waiting()
        for process in list(self._alive):
            _kill(process)
        while self._idle:
            await self._end(self._idle.pop())
        with suppress(TimeoutError):  # whoever has borrowed one notices, and gives it up
            async with asyncio.timeout(2.0), self._free:
                await self._free.wait_for(lambda: not self._alive)
        while self._background:
            await asyncio.wait(self._background)


async def _ended(process: asyncio.subprocess.Process) -> None:
    """End a process and wait until it is gone, and nothing is left of it: no zombie, no open pipe."""
    _kill(process)
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.close()
    with suppress(TimeoutError, ConnectionError):
        async with asyncio.timeout(5.0):
            while await process.stdout.read(1 << 20):
                pass
            await process.wait()
            await process.stdin.wait_closed()


def _kill(process: asyncio.subprocess.Process) -> None:
    """Kill a process and what it started."""
    if process.returncode is not None:
        return
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


__all__ = ["Pool", "error_line"]
