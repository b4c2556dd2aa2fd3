"""The store of a study: one sqlite file, in which what was committed stays, whatever dies.

One process writes at a time, held by a lock that sqlite takes on a file beside the store, and that ends with the
process. Readers never wait for it (write-ahead log). Every row has a checksum of its own.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import threading
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from time import time as _time
from typing import Any, NamedTuple, Self

from selfmotion._version import __version__
from selfmotion.errors import InvalidInputError
from selfmotion.study.engines import Outcome
from selfmotion.study.runs import Run

SCHEMA = 1
APPLICATION = 0x736D7374  # "smst"
BATCH = 0.2
"""Longest time that an outcome waits to be committed together with others [s]."""
_PATIENCE = 30.0  # with readers that look at the store while it is opened [s]

_TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE runs (
    id TEXT PRIMARY KEY, position INTEGER NOT NULL, problem TEXT NOT NULL, planner TEXT NOT NULL,
    optimizer TEXT NOT NULL, seed INTEGER, task TEXT NOT NULL, specification TEXT NOT NULL,
    status TEXT NOT NULL CHECK (status IN ('done', 'failed')), result TEXT, failure TEXT, history TEXT,
    seconds REAL NOT NULL, version TEXT NOT NULL, finished_at TEXT NOT NULL,
    digest TEXT NOT NULL
);
"""
_COLUMNS = (
    "id", "position", "problem", "planner", "optimizer", "seed", "task", "specification", "status", "result", "failure",
    "history", "seconds", "version", "finished_at", "digest",
)  # fmt: skip
_JSON = ("specification", "result", "failure", "history")
_INSERT = f"INSERT INTO runs ({', '.join(_COLUMNS)}) VALUES ({', '.join('?' * len(_COLUMNS))}) ON CONFLICT (id) DO "
_AGAIN = (
    "UPDATE SET " + ", ".join(f"{name} = excluded.{name}" for name in _COLUMNS[1:]) + " WHERE runs.status = 'failed'"
)
_DAMAGED = "move it away and run the study again, or see what `sqlite3 FILE .recover` can save"
# sqlite's errors in our words: what is wrong, what to do.
_REASONS = {
    "SQLITE_FULL": ("cannot be written to, the disk is full", "make room and run again: what is done is kept"),
    "SQLITE_IOERR": ("cannot be written to or read", "check the disk and run again: what is done is kept"),
    "SQLITE_READONLY": ("cannot be written to", "name another file with --store"),
    "SQLITE_PERM": ("cannot be opened", "name another file with --store"),
    "SQLITE_CANTOPEN": ("cannot be opened or made", "check the name, or name another file with --store"),
    "SQLITE_CORRUPT": ("is damaged", _DAMAGED),
    "SQLITE_NOTADB": ("is no store of a study", "is it the right file? name another with --store"),
    "SQLITE_BUSY": ("is locked by another program", "close that program, or name another file with --store"),
}


class Row(NamedTuple):
    """What is stored of a run; see `Outcome`."""

    id: str
    specification: dict[str, Any]
    status: str
    result: dict[str, Any] | None
    failure: dict[str, Any] | None
    history: Any
    seconds: float
    version: str
    finished_at: str


class Store:
    """The outcomes of a study.

    Parameters
    ----------
    file : path-like, optional
        Made when something is written; without it all is kept in memory, as long as this object.

    Raises
    ------
    InvalidInputError
        If that is no name of a file.
    """

    def __init__(self, file: str | os.PathLike[str] | None = None) -> None:
        if file is not None and (not os.fspath(file) or "\0" in os.fspath(file)):
            raise InvalidInputError("--store", "is no name of a file", "name one", str(file))
        self.file = None if file is None else Path(file)
        self._memory = None
        if file is None:
            self._memory = sqlite3.connect(":memory:", check_same_thread=False, isolation_level=None)
            _make_tables(self._memory)

    def __repr__(self) -> str:
        return f"Store({'' if self.file is None else str(self.file)!r})"

    def states(self) -> dict[str, str]:
        """Return id to ``"done"`` or ``"failed"`` of all runs that have an outcome.

        Raises
        ------
        InvalidInputError
            If the file is no store, damaged, or a later version's. One that is not there has no outcomes.
        """
        with self._reading() as connection:
            return {} if connection is None else _states(connection, self.file)

    def rows(self, ids: Iterable[str] | None = None) -> Iterator[Row]:
        """Yield the rows of some runs, or of all, in the order in which they were stored.

        Raises
        ------
        InvalidInputError
            As `states`, or if a row is not as it was written.
        """
        wanted = None if ids is None else set(ids)
        with self._reading() as connection:
            if connection is None:
                return
            for row in _checked(connection, self.file):
                if wanted is not None and row["id"] not in wanted:
                    continue
                known = {name: row[name] and json.loads(row[name]) for name in _JSON}
                yield Row(**{name: row[name] for name in Row._fields} | known)

    def study(self) -> str | None:
        """Return the text of the study that was run last; None if there was none."""
        with self._reading() as connection:
            return None if connection is None else _meta(connection).get("study")

    @contextmanager
    def _reading(self) -> Iterator[sqlite3.Connection | None]:
        if self._memory is not None:
            yield self._memory
            return
        assert self.file is not None
        if not self.file.exists() or not self.file.stat().st_size:
            yield None
            return
        with _in_our_words(self.file), closing(_reader(self.file)) as connection:
            yield connection if _is_store(connection, self.file) else None

    def writing(self) -> Writer:
        """Return the one writer, a context manager.

        Raises
        ------
        InvalidInputError
            If another process writes, or the file cannot be written to or is not a sound store.
        """
        return Writer(self.file, self._memory)


class Writer:
    """What writes to a store, while nobody else does; see `Store.writing`."""

    def __init__(self, file: Path | None, memory: sqlite3.Connection | None) -> None:
        self._file, self._memory = file, memory
        self._guard = threading.Lock()
        self._timer: threading.Timer | None = None
        self._failure: sqlite3.Error | None = None
        self._lock: sqlite3.Connection | None = None
        if memory is not None:
            self._connection = memory
            return
        assert file is not None
        self._lock = _locked(file)
        try:
            with _in_our_words(file):
                self._connection = _opened(file)
        except BaseException:
            self._lock.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            self.commit()
        except InvalidInputError:
            if kind is None:
                raise
        finally:
            self._close()

    def note(self, **known: str) -> None:
        """Keep texts about the study, such as its file's."""
        with self._told(), self._guard:
            before = _meta(self._connection)
            for key, value in known.items() - before.items():
                self._connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, value))

    def known(self) -> dict[str, str]:
        """Return what was noted."""
        with self._told(), self._guard:
            return _meta(self._connection)

    def states(self) -> dict[str, str]:
        """Return id to status; see `Store.states`."""
        with self._told(), self._guard:
            return _states(self._connection, self._file)

    def add(self, run: Run, position: int, outcome: Outcome, retry: bool = False) -> None:
        """Store an outcome, committed within `BATCH`; one that is there already stays, but for a failure with `retry`.

        Raises
        ------
        InvalidInputError
            If the disk refuses, now or when what came before was committed.
        """
        values = (
            run.id, position, run.problem, run.planner, run.optimizer, run.seed, run.task, run.text,
            "done" if outcome.failure is None else "failed", outcome.result, outcome.failure, outcome.history,
            outcome.seconds, outcome.version, _now(),
        )  # fmt: skip
        with self._told(), self._guard:
            if self._failure is not None:
                raise self._failure
            if not self._connection.in_transaction:
                self._connection.execute("BEGIN IMMEDIATE")
                self._timer = threading.Timer(BATCH, self._commit_later)
                self._timer.daemon = True
                self._timer.start()
            self._connection.execute(_INSERT + (_AGAIN if retry else "NOTHING"), (*values, _digest(values)))

    def commit(self) -> None:
        """Commit what waits for it."""
        with self._told(), self._guard:
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None
            if self._failure is not None:
                raise self._failure
            if self._connection.in_transaction:
                self._connection.execute("COMMIT")

    def _commit_later(self) -> None:
        with self._guard:
            try:
                if self._connection.in_transaction:
                    self._connection.execute("COMMIT")
            except sqlite3.Error as error:  # said to whoever adds the next outcome
                self._failure = error

    @contextmanager
    def _told(self) -> Iterator[None]:
        if self._file is None:
            yield
        else:
            with _in_our_words(self._file):
                yield

    def _close(self) -> None:
        if self._lock is None:
            return
        with self._guard, suppress(sqlite3.Error):
            self._connection.close()
        self._lock.close()


@contextmanager
def _in_our_words(file: Path) -> Iterator[None]:
    """Turn sqlite's errors into ours: which file, what is wrong, what to do."""
    try:
        yield
    except sqlite3.Error as error:
        name = getattr(error, "sqlite_errorname", "")
        kind = next((known for known in _REASONS if name.startswith(known)), "SQLITE_CORRUPT")
        reason, remedy = _REASONS[kind]
        raise InvalidInputError("", f"{reason} ({error})", remedy, source=str(file)) from None
    except UnicodeDecodeError:
        raise InvalidInputError("", "is damaged (text that is none)", _DAMAGED, source=str(file)) from None


def _locked(file: Path) -> sqlite3.Connection:
    """Take the lock of a store, which ends with this process; refuse if another process has it."""
    beside = file.with_name(file.name + ".lock")
    lock = None
    try:
        lock = sqlite3.connect(beside, timeout=0.0, isolation_level=None, check_same_thread=False)
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.Error as error:
        if lock is not None:
            lock.close()
        name = getattr(error, "sqlite_errorname", "")
        if name.startswith("SQLITE_BUSY"):
            remedy = "wait for it to end, or name another file with --store"
            raise InvalidInputError("", "is being written to by another run", remedy, source=str(file)) from None
        with _in_our_words(beside if name.startswith("SQLITE_NOTADB") else file):
            raise error
    return lock


def _opened(file: Path) -> sqlite3.Connection:
    """Open a sound store for writing, or make one."""
    connection = sqlite3.connect(file, timeout=_PATIENCE, isolation_level=None, check_same_thread=False)
    try:
        if not _is_store(connection, file):
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = FULL")
            _make_tables(connection)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        if not os.access(file, os.W_OK):
            raise InvalidInputError("", "cannot be written to", "name another file with --store", source=str(file))
    except BaseException:
        connection.close()
        raise
    return connection


def _reader(file: Path) -> sqlite3.Connection:
    """Open a store for reading only, also where nothing may be written beside it."""
    name = file.absolute().as_uri()
    connection = sqlite3.connect(f"{name}?mode=ro", uri=True, timeout=_PATIENCE, isolation_level=None)
    try:
        connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except sqlite3.OperationalError as error:
        connection.close()
        log = file.with_name(file.name + "-wal")
        if not getattr(error, "sqlite_errorname", "").startswith(("SQLITE_CANTOPEN", "SQLITE_READONLY")) or (
            log.exists() and log.stat().st_size
        ):
            raise
        connection = sqlite3.connect(f"{name}?immutable=1", uri=True, isolation_level=None)
    except BaseException:
        connection.close()
        raise
    return connection


def _make_tables(connection: sqlite3.Connection) -> None:
    """Make an empty store, whole or not at all."""
    made = f"INSERT INTO meta VALUES ('made by', 'selfmotion {__version__}');"
    marks = f"PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {SCHEMA};"
    connection.executescript(f"BEGIN IMMEDIATE; {_TABLES} {made} {marks} COMMIT;")


def _is_store(connection: sqlite3.Connection, file: Path) -> bool:
    """Return whether a database is a store, sound and of a version that is known; False if it is empty."""
    application = connection.execute("PRAGMA application_id").fetchone()[0]
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    if application != APPLICATION:
        if application or version or connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            reason, remedy = _REASONS["SQLITE_NOTADB"]
            raise InvalidInputError("", f"{reason}, but another program's database", remedy, source=str(file))
        return False
    if version > SCHEMA:
        remedy = "use that version, or name another file with --store"
        raise InvalidInputError("", "was written by a later version of selfmotion", remedy, source=str(file))
    found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if found != "ok":
        raise InvalidInputError("", f"is damaged ({' '.join(found.split())[:80]})", _DAMAGED, source=str(file))
    return True


def _checked(connection: sqlite3.Connection, file: Path | None) -> Iterator[dict[str, Any]]:
    """Yield all rows as they were written."""
    for values in connection.execute(f"SELECT {', '.join(_COLUMNS)} FROM runs ORDER BY rowid"):
        row = dict(zip(_COLUMNS, values, strict=True))
        if row["digest"] != _digest(values[:-1]):
            reason = f"is damaged: the row of run {str(row['id'])[:12]} is not as it was written"
            raise InvalidInputError("", reason, _DAMAGED, source=str(file))
        yield row


def _states(connection: sqlite3.Connection, file: Path | None) -> dict[str, str]:
    return {row["id"]: row["status"] for row in _checked(connection, file)}


def _meta(connection: sqlite3.Connection) -> dict[str, str]:
    return dict(connection.execute("SELECT key, value FROM meta"))


def _digest(values: Iterable[Any]) -> str:
    """Return a checksum of a row's other values."""
    return hashlib.blake2b(json.dumps(list(values), default=repr).encode(), digest_size=12).hexdigest()


def _now() -> str:
    """Return the time of day, for reading only; clocks may say anything."""
    try:
        return datetime.fromtimestamp(_time(), UTC).isoformat(timespec="seconds")
    except (OverflowError, ValueError, OSError):
        return "unknown"
