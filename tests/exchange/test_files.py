"""Files are written whole or not at all, and never over somebody else's."""

import os

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.exchange import OutputFolder, read_trajectory, trajectory_csv
from selfmotion.exchange.files import MANIFEST


def test_what_selfmotion_wrote_is_replaced(tmp_path):
    out = tmp_path / "a" / "b"
    OutputFolder(out).write({"x.txt": b"1"})
    OutputFolder(out).write({"x.txt": b"2", "y.txt": b"3"})
    assert (out / "x.txt").read_bytes() == b"2"
    assert sorted(os.listdir(out)) == [MANIFEST, "x.txt", "y.txt"]


def test_what_it_did_not_write_is_not(tmp_path):
    (tmp_path / "x.txt").write_bytes(b"mine")
    with pytest.raises(sm.InvalidInputError, match="--force"):
        OutputFolder(tmp_path).write({"a.txt": b"1", "x.txt": b"1"})
    assert sorted(os.listdir(tmp_path)) == ["x.txt"]
    OutputFolder(tmp_path, force=True).write({"x.txt": b"1"})
    assert (tmp_path / "x.txt").read_bytes() == b"1"


def test_a_file_changed_by_hand_is_somebody_else_s(tmp_path):
    OutputFolder(tmp_path).write({"x.txt": b"1"})
    (tmp_path / "x.txt").write_bytes(b"1, with notes")
    with pytest.raises(sm.InvalidInputError, match="--force"):
        OutputFolder(tmp_path).write({"x.txt": b"2"})
    assert (tmp_path / "x.txt").read_bytes() == b"1, with notes"


def test_a_disk_that_refuses_leaves_nothing_half_written(tmp_path, monkeypatch):
    OutputFolder(tmp_path).write({"x.txt": b"old"})
    real, count = os.fsync, iter(range(10))

    def fails_on_the_second(handle):
        if next(count) == 1:
            raise OSError(28, "No space left on device")
        real(handle)

    monkeypatch.setattr(os, "fsync", fails_on_the_second)
    with pytest.raises(sm.InvalidInputError, match="No space left"):
        OutputFolder(tmp_path).write({"x.txt": b"new", "y.txt": b"new"})
    assert (tmp_path / "x.txt").read_bytes() == b"old"
    assert sorted(os.listdir(tmp_path)) == [MANIFEST, "x.txt"]


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_a_folder_that_cannot_be_one_is_refused_early(tmp_path, place):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(sm.InvalidInputError, match="--out"):
        OutputFolder(tmp_path / place).check(["x"])


def test_a_folder_in_a_file_s_place_is_refused(tmp_path):
    (tmp_path / "x.txt").mkdir()
    for force in (False, True):
        with pytest.raises(sm.InvalidInputError, match=r"x\.txt is a folder"):
            OutputFolder(tmp_path, force).write({"x.txt": b"1"})


def test_a_broken_manifest_protects_everything(tmp_path):
    OutputFolder(tmp_path).write({"x.txt": b"1"})
    (tmp_path / MANIFEST).write_text("not json")
    with pytest.raises(sm.InvalidInputError, match="--force"):
        OutputFolder(tmp_path).write({"x.txt": b"2"})


def test_trajectory_round_trip_is_exact(seed_plan, tmp_path):
    file = tmp_path / "t.csv"
    file.write_bytes(trajectory_csv(seed_plan))
    assert file.read_text().splitlines()[0] == "r,q1,q2,q3,u1"
    trajectory = read_trajectory(file, 3)
    np.testing.assert_array_equal(trajectory.r, seed_plan.problem.rows)
    np.testing.assert_array_equal(trajectory.q, seed_plan(trajectory.r))


def test_columns_may_stand_in_any_order(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("\ufeffq2, r,q1,note,q3\n1,0,2,hello,3\n\n4,1,5,,6\n")
    trajectory = read_trajectory(file, 3)
    np.testing.assert_array_equal(trajectory.q, [[2, 1, 3], [5, 4, 6]])


HEAD = "r,q1,q2,q3\n"
BAD = {
    "row 1": "r,q1,q2\n0,1,2\n1,2,3\n",
    "row 1 (too many joints)": "r,q1,q2,q3,q4\n0,1,2,3,4\n1,2,3,4,5\n",
    "row 1 (repeated)": "r,q1,q2,q3,q3\n0,1,2,3,3\n1,2,3,3,3\n",
    "row 1 (binary)": "\x00\x01\x02",
    "row 2": HEAD + "0,1,2,3\n1,2,3\n",
    "row 2, column q2": HEAD + "0,1,2,3\n1,2,x,3\n",
    "row 1, column q3": HEAD + "0,1,2,nan\n1,2,3,3\n",
    "row 1, column q1": HEAD + "0,1e999,2,3\n1,2,3,3\n",
    "row 3, column r": HEAD + "0,1,2,3\n1,2,3,3\n0.5,2,3,3\n",
    "row 2, column r": HEAD + "0,1,2,3\n1.5,2,3,3\n",
    "": HEAD + "0,1,2,3\n",
    " (empty)": "",
}


@pytest.mark.parametrize("case", BAD)
def test_bad_trajectories_name_row_and_column(tmp_path, case):
    file = tmp_path / "t.csv"
    file.write_text(BAD[case])
    with pytest.raises(sm.InvalidInputError) as caught:
        read_trajectory(file, 3)
    expected = "row 1" if case == " (empty)" else case.split(" (")[0]
    assert caught.value.field == expected
    assert caught.value.source == str(file)


def test_a_run_leaves_alone_what_another_one_is_about_to_write(tmp_path):
    (tmp_path / ".selfmotion-abc.tmp").write_bytes(b"of another run")
    OutputFolder(tmp_path).write({"x.txt": b"1"})
    assert sorted(os.listdir(tmp_path)) == [".selfmotion-abc.tmp", MANIFEST, "x.txt"]
