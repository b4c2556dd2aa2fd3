"""What a JSON file is that may be mistaken for another one: a stored plan, or the result object of a run.

It is looked for before anything else reads the file: a YAML reader takes seconds for a large plan.
"""

from __future__ import annotations

import json

from selfmotion.errors import InvalidInputError
from selfmotion.plans import RESULT_FIELDS

PLAN_FORMAT = "selfmotion_plan"
"""The key of a plan file that holds the version of its form."""


def is_plan_file(text: str) -> bool:
    """Return whether text is that of a plan file, whole or not, rather than of a problem file."""
    if text.lstrip()[:1] != "{":
        return False
    return f'"{PLAN_FORMAT}"' in text[:200] or (PLAN_FORMAT in text and PLAN_FORMAT in _keys(text))


def refuse_result(text: str, wanted: str) -> None:
    """Refuse the result object that a run prints and writes, where a `wanted` is to be read.

    Raises
    ------
    InvalidInputError
        If it is one.
    """
    if text.lstrip()[:1] == "{" and RESULT_FIELDS[-1] in text and set(RESULT_FIELDS) <= _keys(text):
        remedy = "give the problem file; plan --save FILE stores a plan, as time and sm.load_plan read it"
        raise InvalidInputError("", f"is the result object of a run, not a {wanted}", remedy)


def refuse_no_problem(text: str) -> None:
    """Refuse a stored plan and a result object, where a problem file is to be read.

    Raises
    ------
    InvalidInputError
        If it is one of them.
    """
    if is_plan_file(text):
        raise InvalidInputError("", "is a stored plan, not a problem file", "time and sm.load_plan read it")
    refuse_result(text, "problem file")


def _keys(text: str) -> set[str]:
    """Return the keys of a JSON object, none of anything else."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return set()
    return set(data) if isinstance(data, dict) else set()
