"""Studies that are killed at random moments; kill_study.py does it a thousand times."""

import random
import tempfile

import kill_study
import pytest


@pytest.fixture(scope="module")
def undisturbed():
    with tempfile.TemporaryDirectory() as folder:
        kills, rows = kill_study.killed_until_done(folder, random.Random(0), 0, "in-process")
    assert kills == 0
    assert len(rows) == kill_study.RUNS
    assert {row[4] for row in rows} == {"done", "failed"}
    return kill_study.without_lines(rows)


@pytest.mark.parametrize(("engine", "kills"), [("in-process", 8), ("process", 7)])
def test_a_study_killed_at_random_moments_loses_and_doubles_nothing(undisturbed, engine, kills, tmp_path):
    done = 0
    for attempt in range(kills):
        (tmp_path / str(attempt)).mkdir()
        some, rows = kill_study.killed_until_done(tmp_path / str(attempt), random.Random(attempt), kills - done, engine)
        done += some
        assert kill_study.wrong(kill_study.without_lines(rows), undisturbed) == ""
        if done >= kills:
            break
    assert done >= kills


def test_what_is_lost_doubled_or_changed_is_noticed(undisturbed):
    changed = [(*undisturbed[0][:5], "{}", *undisturbed[0][6:]), *undisturbed[1:]]
    assert kill_study.wrong(undisturbed, undisturbed) == ""
    assert kill_study.wrong(undisturbed[1:], undisturbed) == "1 lost, 0 doubled, 0 different"
    assert kill_study.wrong([*undisturbed, undisturbed[0]], undisturbed) == "0 lost, 1 doubled, 0 different"
    assert kill_study.wrong(changed, undisturbed) == "0 lost, 0 doubled, 1 different"
