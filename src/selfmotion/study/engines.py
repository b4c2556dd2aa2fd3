"""Where runs are worked off: in this process, in several on this machine, or on a dask cluster.

An engine is handed work lazily and gives outcomes in any order. Which one it is changes no bit of them.
"""

from __future__ import annotations

import json
import logging
import os
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import lru_cache
from importlib import import_module
from itertools import islice
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from selfmotion._version import __version__
from selfmotion.errors import InvalidInputError, MissingExtraError

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

_AHEAD = 2  # pieces of work per worker that are handed over: the next one waits there
_PATIENCE = 10  # with a scheduler that does not answer [s]
_MOST_DEATHS = 3  # of worker processes that one run may cost
_WORKER_DIED = "its worker process ended"
_NO_DASHBOARD: dict[str, Any] = {"dashboard_address": "127.0.0.1:0", "scheduler_kwargs": {"dashboard": False}}


class Work(NamedTuple):
    """A run to be done.

    Attributes
    ----------
    id : str
    task : str
        ``"package.module:function"``; the function is called with the specification and returns a dict fit for JSON.
        Its entry ``history``, if there is one, is kept apart.
    specification : dict
    """

    id: str
    task: str
    specification: dict[str, Any]


class Outcome(NamedTuple):
    """What became of a run.

    Attributes
    ----------
    id : str
    result, history, failure : str or None
        JSON: what the task returned, or ``{"type", "message", "traceback"}`` of what it raised.
    seconds : float
        Of a clock that only goes forward.
    version : str
        Of selfmotion, where it was run.
    """

    id: str
    result: str | None
    history: str | None
    failure: str | None
    seconds: float
    version: str


class Engine(Protocol):
    """What works off runs."""

    def outcomes(self, work: Iterable[Work]) -> Iterator[Outcome]:
        """Yield the outcome of every piece of work, in any order; take work only a few pieces ahead."""
        ...


def perform(work: Work) -> Outcome:
    """Do one run; what its task raises is an outcome too."""
    began = time.perf_counter()
    result = history = failure = None
    try:
        with _one_thread:
            found = dict(_task(work.task)(work.specification))
        kept = found.pop("history", None)
        history = None if kept is None else _json(kept)
        result = _json(found)
    except Exception as error:
        text = "".join(traceback.format_exception(error, limit=-8))
        history, failure = None, _json({"type": type(error).__name__, "message": str(error), "traceback": text})
    return Outcome(work.id, result, history, failure, time.perf_counter() - began, __version__)


@lru_cache
def _task(name: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    module, _, function = name.partition(":")
    task: Callable[[dict[str, Any]], dict[str, Any]] = getattr(import_module(module), function)
    return task


def _json(value: Any) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


def _failed(work: Work, message: str) -> Outcome:
    failure = _json({"type": "WorkerDied", "message": message, "traceback": ""})
    return Outcome(work.id, None, None, failure, 0.0, __version__)


class _OneThread:
    """Linear algebra on one thread while anything runs: sums of two would depend on how many there are."""

    def __init__(self) -> None:
        self._lock, self._inside, self._limit = threading.Lock(), 0, None

    def __enter__(self) -> None:
        with self._lock:
            if not self._inside:
                self._limit = _controller().limit(limits=1)
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if not self._inside and self._limit is not None:
                self._limit.restore_original_limits()


_one_thread = _OneThread()


@lru_cache
def _controller() -> ThreadpoolController:
    import scipy.linalg  # noqa: F401 (what is to be limited must be loaded)
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


class InProcess:
    """Runs here, one after the other, or on threads.

    Parameters
    ----------
    threads : int
        Worth more than one where runs spend their time in compiled code that does without the interpreter's lock.
    """

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads

    def outcomes(self, work: Iterable[Work]) -> Iterator[Outcome]:
        """Yield the outcome of every piece of work."""
        if self.threads == 1:
            with _noticed() as interrupted:
                for piece in work:
                    outcome = perform(piece)
                    if interrupted:  # a planner may have made it an answer, cut short
                        raise KeyboardInterrupt
                    yield outcome
            return
        pool = ThreadPoolExecutor(self.threads)
        with _one_thread:  # OpenBLAS takes it from the thread that started it, not from those of the pool
            try:
                for future in _as_done(lambda piece: pool.submit(perform, piece), iter(work), _AHEAD * self.threads):
                    yield future.result()
            finally:
                pool.shutdown(cancel_futures=True)


@contextmanager
def _noticed() -> Iterator[list[int]]:
    """Give a list that has an entry after Ctrl-C, whoever caught what it raised."""
    import signal

    seen: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield seen
        return
    before = signal.getsignal(signal.SIGINT)

    def note(number: int, frame: Any) -> None:
        seen.append(number)
        if callable(before):
            before(number, frame)

    signal.signal(signal.SIGINT, note)
    try:
        yield seen
    finally:
        signal.signal(signal.SIGINT, before)


def _as_done(submit: Callable[[Work], Future[Outcome]], work: Iterator[Work], most: int) -> Iterator[Future[Outcome]]:
    """Yield futures as they are done, with at most `most` of them in flight."""
    flying = {submit(piece) for piece in islice(work, most)}
    while flying:
        done, flying = wait(flying, return_when=FIRST_COMPLETED)
        for future in done:
            flying |= {submit(piece) for piece in islice(work, 1)}
            yield future


class Processes:
    """Runs in worker processes on this machine, each started afresh and on one thread.

    A worker that dies takes nothing with it: what was in flight is tried again, one run at a time, so that it shows
    which of them kills its worker; that one has failed after the third time.

    Parameters
    ----------
    workers : int
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def outcomes(self, work: Iterable[Work]) -> Iterator[Outcome]:
        """Yield the outcome of every piece of work."""
        left = iter(work)
        while True:
            flying: dict[Future[Outcome], Work] = {}
            broken = False
            with _pool(self.workers) as pool:
                try:
                    while True:
                        for piece in islice(left, _AHEAD * self.workers - len(flying)):
                            flying[_submitted(pool, piece)] = piece
                        if not flying:
                            return
                        done, _ = wait(flying, return_when=FIRST_COMPLETED)
                        for future in done:
                            outcome = future.result()
                            del flying[future]
                            yield outcome
                except BrokenProcessPool:
                    broken = True
            if broken:
                yield from map(_alone, flying.values())


def _submitted(pool: ProcessPoolExecutor, piece: Work) -> Future[Outcome]:
    """Hand work to a pool; one that is broken says so in the future, where what it costs is known."""
    try:
        return pool.submit(perform, piece)
    except BrokenProcessPool as error:
        lost: Future[Outcome] = Future()
        lost.set_exception(error)
        return lost


def _alone(work: Work) -> Outcome:
    """Do a run that may have killed its worker, in a worker of its own."""
    for _ in range(_MOST_DEATHS - 1):  # once it was in flight when one died
        with _pool(1) as pool:
            try:
                return pool.submit(perform, work).result()
            except BrokenProcessPool:
                continue
    return _failed(work, _WORKER_DIED)


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Give worker processes that end when this one does, whatever ends it, and at once when they are done with."""
    from multiprocessing import get_context

    context = get_context("spawn")
    theirs, ours = context.Pipe(duplex=False)
    with _single_threaded():
        pool = ProcessPoolExecutor(workers, context, _started, (theirs,))
        try:
            yield pool
        finally:
            ours.close()
            pool.shutdown(cancel_futures=True)
            theirs.close()


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Tell processes that are started to keep to one thread."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _started(pipe: Connection) -> None:
    """Make a worker process deaf to Ctrl-C, which its parent handles, and let it end with its parent."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(pipe,), daemon=True).start()


def _end_with(pipe: Connection) -> None:
    try:
        pipe.recv_bytes()  # nothing ever comes: it returns when the other end is closed
    except (EOFError, OSError):
        os._exit(0)


class Dask:
    """Runs on a dask cluster, which need not be on this machine.

    Parameters
    ----------
    scheduler : str, optional
        Its address, such as ``"tcp://10.0.0.1:8786"``; without it a cluster is started on this machine.
    workers : int
        Of the cluster on this machine.

    Raises
    ------
    MissingExtraError
        If dask.distributed is not installed.
    InvalidInputError
        From `outcomes`, if there is no scheduler at this address, or it goes away.
    """

    def __init__(self, scheduler: str | None = None, workers: int = 2) -> None:
        self.scheduler, self.workers = scheduler, workers
        _distributed()

    def outcomes(self, work: Iterable[Work]) -> Iterator[Outcome]:
        """Yield the outcome of every piece of work."""
        from uuid import uuid4

        distributed = _distributed()
        left = iter(work)
        with self._client() as client:
            most = _AHEAD * max(1, sum(client.nthreads().values()))
            flying: dict[str, Work] = {}
            suspects: list[Work] = []

            def handed(pieces: Iterable[Work]) -> list[Any]:
                named = {f"{piece.id}-{uuid4().hex[:8]}": piece for piece in pieces}
                flying.update(named)
                return [client.submit(perform, piece, key=key, pure=False) for key, piece in named.items()]

            done = distributed.as_completed(handed(islice(left, most)), loop=client.loop, raise_errors=False)
            for future in done:
                outcome = self._outcome(future)
                piece = flying.pop(future.key)
                for other in handed(islice(left, 1)):
                    done.add(other)
                if outcome is None:  # it was with a worker that died, again and again, whichever run was to blame
                    suspects.append(piece)
                else:
                    yield outcome
            for piece in suspects:
                (alone,) = handed([piece])
                yield self._outcome(alone) or _failed(piece, _WORKER_DIED)

    def _outcome(self, future: Any) -> Outcome | None:
        """Return the outcome in a future; None if workers died of it."""
        distributed = _distributed()
        try:
            outcome: Outcome = future.result()
        except distributed.scheduler.KilledWorker:
            return None
        except (distributed.CancelledError, OSError) as error:  # dask's CommClosedError is one
            raise self._gone(error) from None
        finally:
            future.release()
        return outcome

    @contextmanager
    def _client(self) -> Iterator[Any]:
        distributed = _distributed()
        if self.scheduler is not None:
            try:
                client = distributed.Client(self.scheduler, timeout=_PATIENCE, set_as_default=False)
            except (OSError, ValueError) as error:
                raise self._gone(error) from None
            with client:
                yield client
            return
        quiet = logging.CRITICAL  # that a worker died is said of the run, if it matters
        options = {"n_workers": self.workers, "threads_per_worker": 1, "processes": True, "memory_limit": 0}
        with (
            _single_threaded(),
            distributed.LocalCluster(**options, **_NO_DASHBOARD, silence_logs=quiet) as cluster,
            distributed.Client(cluster, set_as_default=False) as client,
        ):
            yield client

    def _gone(self, error: BaseException) -> InvalidInputError:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        remedy = "is it running? what is done is kept: run again to go on"
        return InvalidInputError("--scheduler", f"does not answer ({reason})", remedy, self.scheduler)


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        reason, remedy = "needs dask.distributed", "pip install 'selfmotion[cluster]'"
        raise MissingExtraError("--engine", reason, remedy, "dask") from None
    return distributed
