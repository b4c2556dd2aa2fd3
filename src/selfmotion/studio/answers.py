"""Everything the library answers to the page: a task's name and its function, called with (payload, tell, place)."""

from __future__ import annotations

from selfmotion.studio.cases import examples
from selfmotion.studio.exports import export
from selfmotion.studio.hand import fit
from selfmotion.studio.look import look
from selfmotion.studio.motions import plan
from selfmotion.studio.place import Answer
from selfmotion.studio.texts import read, schema, write

ANSWERS: dict[str, Answer] = {
    "look": look,
    "plan": plan,
    "fit": fit,
    "export": export,
    "read": read,
    "write": write,
    "schema": schema,
    "examples": examples,
}
