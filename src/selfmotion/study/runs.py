"""Runs, each a task and plain data with the identity that follows from both; and studies, which are lists of them."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from selfmotion.study.engines import Work


@dataclass(frozen=True)
class Run:
    """One run of a study.

    Attributes
    ----------
    task : str
        ``"package.module:function"``; see `Work`.
    specification : dict
        Plain data, all that the outcome depends on.
    problem, planner, optimizer : str
        What it is called in tables.
    seed : int or None
        For tables too; it is in the specification as well.
    folder : str
        What file names in the specification are relative to. It is handed to the task as `folder`, and is not part of
        the run's identity: a study that is moved stays the same.
    """

    task: str
    specification: dict[str, Any]
    problem: str = ""
    planner: str = ""
    optimizer: str = ""
    seed: int | None = None
    folder: str = field(default="", compare=False)

    @cached_property
    def text(self) -> str:
        """The specification as JSON, always the same for the same data."""
        return canonical(self.specification)

    @cached_property
    def id(self) -> str:
        """Identity: a hash of task and specification, 32 hexadecimal digits."""
        return hashlib.sha256(f"{self.task}\n{self.text}".encode()).hexdigest()[:32]

    def work(self) -> Work:
        """Return what an engine needs of it."""
        more = {"folder": self.folder} if self.folder else {}
        return Work(self.id, self.task, {**self.specification, **more})


@dataclass(frozen=True)
class Study:
    """A list of runs with a name.

    Attributes
    ----------
    name : str
    runs : tuple of Run
        In the order in which they are begun. Two that are the same are done once.
    text : str
        The file's text, for the store.
    """

    name: str
    runs: tuple[Run, ...]
    text: str = ""

    @classmethod
    def load(cls, file: str | os.PathLike[str]) -> Study:
        """Read a study file.

        Parameters
        ----------
        file : path-like
            YAML or JSON; the fields are described in docs/studies.

        Returns
        -------
        Study

        Raises
        ------
        InvalidInputError
            Naming file, field, value and remedy.
        """
        from selfmotion.study.specification import read_study  # the forms of all parts, which runs do without

        name, runs, text = read_study(file)
        return cls(name, tuple(runs), text)

    def unique(self) -> dict[str, tuple[int, Run]]:
        """Return id to position and run, of runs that are the same the first."""
        found: dict[str, tuple[int, Run]] = {}
        for position, run in enumerate(self.runs):
            found.setdefault(run.id, (position, run))
        return found


def canonical(data: Any) -> str:
    """Return plain data as JSON, keys sorted, without spaces."""
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
