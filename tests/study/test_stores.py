"""Stores: what is committed stays; what is damaged, foreign, locked or full is said."""

import os
import random
import resource
import sqlite3
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from study_tasks import contents, runs, study

from selfmotion.errors import InvalidInputError
from selfmotion.study import Store, run_study
from selfmotion.study.engines import perform
from selfmotion.study.store import BATCH

HERE = str(Path(__file__).parent)


@pytest.fixture
def kept(tmp_path):
    """A store of eight rows, two of which failed."""
    store = Store(tmp_path / "study.sqlite")
    run_study(study(*runs("number", 6), *runs("failing", 2)), store)
    return store


def child(code, **options):
    """Run code in another process, with what this one can import."""
    paths = os.pathsep.join([HERE, *sys.path])
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}, **options,
    )  # fmt: skip


def test_a_store_keeps_everything_of_a_run(kept):
    rows = list(kept.rows())
    assert [row.status for row in rows] == ["done"] * 6 + ["failed"] * 2
    assert rows[3].result == {"status": "solved", "cost": 0.25}
    assert rows[3].history == [0.1, 3]
    assert rows[7].failure["type"] == "ArithmeticError"
    assert rows[7].failure["message"] == "no number for 1"
    assert "study_tasks.py" in rows[7].failure["traceback"]
    assert all(row.seconds >= 0 and row.version and row.finished_at for row in rows)
    connection = sqlite3.connect(kept.file)
    stored = connection.execute("SELECT position, problem, planner, seed, task, specification FROM runs").fetchall()
    assert stored[3] == (3, "problem 3", "number", 3, "study_tasks:number", '{"seed":3}')
    assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    connection.close()


def test_the_same_study_does_nothing_the_second_time(kept):
    before, asked = kept.file.read_bytes(), []
    rows = list(kept.rows())
    run_study(study(*runs("number", 6), *runs("failing", 2)), kept, progress=asked.append)
    assert asked == []
    assert list(kept.rows()) == rows
    assert len(kept.file.read_bytes()) == len(before)


def test_failed_runs_are_done_again_only_when_asked_for(kept, monkeypatch):
    import study_tasks

    case = study(*runs("number", 7), *runs("failing", 2))
    monkeypatch.setattr(study_tasks, "failing", study_tasks.number)
    from selfmotion.study.engines import _task

    _task.cache_clear()
    steps = []
    run_study(case, kept, progress=steps.append, retry=True)
    done = [(step.run.planner, step.run.seed, step.done) for step in steps]
    assert done == [("number", 6, 7), ("failing", 0, 8), ("failing", 1, 9)]
    assert set(kept.states().values()) == {"done"}
    assert len(list(kept.rows())) == 9
    _task.cache_clear()


def test_a_study_that_grew_keeps_what_is_done_and_one_that_shrank_deletes_nothing(kept):
    steps = []
    run_study(study(*runs("number", 9)), kept, progress=steps.append)
    assert [(step.run.seed, step.done, step.total) for step in steps] == [(6, 7, 9), (7, 8, 9), (8, 9, 9)]
    assert len(kept.states()) == 11


def test_the_store_of_another_study_is_refused(kept):
    from selfmotion.study import Study

    other = Study("other", tuple(runs("number", 3, more=1)))
    with pytest.raises(InvalidInputError, match=r"is the store of the study 'tried'; name another file"):
        run_study(other, kept)
    assert len(kept.states()) == 8


def test_a_limit_is_kept():
    store = run_study(study(*runs("number")), limit=3)
    assert len(store.states()) == 3


def test_outcomes_are_committed_soon_though_no_other_comes(tmp_path):
    file = tmp_path / "study.sqlite"
    seen = []

    def look(step):
        if step.run.seed == 0:
            until = time.monotonic() + 10
            while not seen and time.monotonic() < until:
                time.sleep(0.02)
                seen.extend(Store(file).states())

    run_study(study(*runs("number", 2)), Store(file), progress=look)
    assert len(seen) == 1
    assert BATCH <= 0.2


def test_two_writers_at_once_are_one_too_many_and_readers_do_not_wait(tmp_path):
    file, case = tmp_path / "study.sqlite", study(*runs("number", 3))
    refused = []

    def meanwhile(step):
        began = time.monotonic()
        with pytest.raises(InvalidInputError, match="is being written to by another run; wait") as caught:
            run_study(case, Store(file))
        refused.append(caught.value)
        done = child(f"from selfmotion.study import Store; Store({str(file)!r}).writing()")
        assert "is being written to by another run" in done.stderr
        assert isinstance(Store(file).states(), dict)
        assert time.monotonic() - began < 20

    run_study(case, Store(file), progress=meanwhile, limit=1)
    assert len(refused) == 1
    run_study(case, Store(file))  # the lock went with the writer
    assert len(Store(file).states()) == 3


def spoilt(file, how):
    data = file.read_bytes()
    if how == "random bytes":
        data = random.Random(3).randbytes(5000)
    elif how == "truncated":
        data = data[: len(data) // 2]
    elif how == "text":
        data = b"study: small\n" * 100
    elif how == "middle":
        middle = len(data) // 2
        data = data[:middle] + random.Random(4).randbytes(4096) + data[middle + 4096 :]
    elif how == "a cost":
        assert data.count(b'"cost":0.25') == 1
        data = data.replace(b'"cost":0.25', b'"cost":0.35')
    elif how == "a status":
        connection = sqlite3.connect(file)
        connection.execute("PRAGMA ignore_check_constraints = ON")
        connection.execute("UPDATE runs SET status = 'done' WHERE seed = 1 AND status = 'failed'")
        connection.commit()
        connection.close()
        return
    elif how in ("foreign", "later"):
        file.unlink()
        connection = sqlite3.connect(file)
        connection.execute("CREATE TABLE people (name TEXT)")
        if how == "later":
            from selfmotion.study.store import APPLICATION

            connection.execute(f"PRAGMA application_id = {APPLICATION}")
            connection.execute("PRAGMA user_version = 99")
        connection.commit()
        connection.close()
        return
    file.write_bytes(data)


SPOILT = {
    "random bytes": "is no store of a study",
    "text": "is no store of a study",
    "truncated": "is damaged",
    "middle": "is damaged",
    "a cost": "is damaged: the row of run",
    "a status": "is damaged: the row of run",
    "foreign": "is no store of a study, but another program's database",
    "later": "was written by a later version",
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_store_that_is_not_as_it_was_written_is_refused_and_left_alone(kept, how):
    for name in ("-wal", "-shm"):
        Path(f"{kept.file}{name}").unlink(missing_ok=True)
    spoilt(kept.file, how)
    before = kept.file.read_bytes()
    case = study(*runs("number", 9))
    for attempt in (lambda: run_study(case, Store(kept.file)), lambda: Store(kept.file).states(),
                    lambda: list(Store(kept.file).rows())):  # fmt: skip
        with pytest.raises(InvalidInputError, match=SPOILT[how]) as caught:
            attempt()
        assert str(kept.file) in str(caught.value)
        assert caught.value.remedy
    assert kept.file.read_bytes() == before


def test_whatever_bytes_change_nothing_wrong_is_read(kept):
    whole, good = kept.file.read_bytes(), {row.id: row for row in kept.rows()}
    for name in ("-wal", "-shm"):
        Path(f"{kept.file}{name}").unlink(missing_ok=True)
    rng, told = random.Random(1), 0
    for _ in range(300):
        data = bytearray(whole)
        for _ in range(rng.choice((1, 1, 3, 50))):
            data[rng.randrange(len(data))] = rng.randrange(256)
        kept.file.write_bytes(data)
        try:
            rows = list(Store(kept.file).rows())
        except InvalidInputError:
            told += 1
        else:
            assert all(good[row.id] == row for row in rows)
    assert told > 30


def test_an_empty_file_and_one_that_was_hardly_begun_become_stores(tmp_path):
    file = tmp_path / "study.sqlite"
    file.touch()
    assert Store(file).states() == {}
    sqlite3.connect(file).execute("PRAGMA journal_mode = WAL").fetchone()
    assert Store(file).states() == {}
    run_study(study(*runs("number", 2)), Store(file))
    assert len(Store(file).states()) == 2


def test_a_disk_that_is_full_is_said_and_what_was_committed_stays(tmp_path):
    file = tmp_path / "study.sqlite"
    run_study(study(*runs("number", 3)), Store(file))
    size = file.stat().st_size + 60_000
    code = (
        "import resource; from study_tasks import runs, study; from selfmotion.study import Store, run_study\n"
        "from selfmotion.errors import InvalidInputError\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))\n"
        "try:\n"
        f"    run_study(study(*runs('number', 3), *runs('number', 400, filler='x' * 2000)), Store({str(file)!r}))\n"
        "except InvalidInputError as error: print(error)\n"
    )
    done = child(code)
    assert done.returncode == 0, done.stderr
    assert "study.sqlite: cannot be written to" in done.stdout
    assert "run again: what is done is kept" in done.stdout
    rows = list(Store(file).rows())
    assert 3 <= len(rows) < 403
    run_study(study(*runs("number", 3), *runs("number", 400, filler="x" * 2000)), Store(file))
    assert len(Store(file).states()) == 403
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != size


@pytest.mark.parametrize("commits", [False, True])
def test_sqlite_s_own_word_for_a_full_disk_is_ours(tmp_path, commits):
    store = Store(tmp_path / "study.sqlite")
    run_study(study(*runs("number", 1)), store)
    with pytest.raises(InvalidInputError, match=r"the disk is full .*; make room and run again") as caught:
        fill(store, commits)
    assert caught.value.exit_code == 2
    assert len(store.states()) >= (6 if commits else 1)
    run_study(study(*runs("number", 1)), store)


def fill(store, commits):
    """Add rows to a store that may not grow."""
    with store.writing() as writer:
        pages = writer._connection.execute("PRAGMA page_count").fetchone()[0]
        writer._connection.execute(f"PRAGMA max_page_count = {pages + 10}")
        for k, run in enumerate(runs("number", 200, filler="x" * 2000)):
            writer.add(run, k, perform(run.work()))
            if commits and k == 5:
                writer.commit()


def test_a_folder_that_may_not_be_written_to():
    """By a user without rights; the superuser has them everywhere."""
    with tempfile.TemporaryDirectory() as name:
        folder, file = Path(name), Path(name) / "study.sqlite"
        run_study(study(*runs("number", 8)), Store(file))
        (folder / "study.sqlite.lock").unlink()
        code = (
            "import os; from study_tasks import runs, study; from selfmotion.study import Store, run_study\n"
            "from selfmotion.errors import InvalidInputError\n"
            "run_study(study(*runs('number', 1)))\n"
            "if os.geteuid() == 0: os.setgroups([]); os.setgid(65534); os.setuid(65534)\n"
            f"print(len(Store({str(file)!r}).states()))\n"
            f"for name in ({str(file)!r}, {str(folder / 'new.sqlite')!r}):\n"
            "    try: run_study(study(*runs('number')), Store(name))\n"
            "    except InvalidInputError as error: print(error)\n"
        )
        folder.chmod(0o555)
        try:
            done = child(code, cwd="/")
        finally:
            folder.chmod(0o755)
    assert done.returncode == 0, done.stderr
    count, old, new = done.stdout.splitlines()
    assert count == "8"
    for line in (old, new):
        assert "cannot be opened or made" in line or "cannot be written to" in line
        assert "--store" in line


@pytest.mark.parametrize("name", ["", "a\0b"])
def test_no_name_of_a_file(name):
    with pytest.raises(InvalidInputError, match="is no name of a file"):
        Store(name)


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(InvalidInputError, match="cannot be opened or made"):
        run_study(study(*runs("number", 1)), Store(tmp_path / "nowhere" / "study.sqlite"))
    with pytest.raises(InvalidInputError, match="cannot be opened or made"):
        run_study(study(*runs("number", 1)), Store(tmp_path))


def test_a_clock_that_jumps_changes_nothing_but_what_it_says(tmp_path, monkeypatch):
    file, jumps = tmp_path / "study.sqlite", iter([1e9, -1e9, 4e9, 0.0, 1e18] * 100)
    expected = contents(run_study(study(*runs("number"))))
    monkeypatch.setattr(time, "time", lambda: next(jumps))
    monkeypatch.setattr("selfmotion.study.store._time", lambda: next(jumps))
    store = Store(file)
    run_study(study(*runs("number")), store)
    assert contents(store) == expected
    rows = list(store.rows())
    assert all(0.0 <= row.seconds < 60.0 for row in rows)
    assert {"unknown", "2001-09-09T01:46:40+00:00"} <= {row.finished_at for row in rows}
