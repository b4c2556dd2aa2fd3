"""What all obstacles have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError

LONGEST_NAME = 200
"""Characters that the name of an obstacle may have."""


class Obstacle(ABC):
    """A solid that links must not touch.

    Parameters
    ----------
    name : str, optional
        What it is called where it is in the way.

    Attributes
    ----------
    kind : str
        Its key in a problem file.
    dimension : {2, 3}
        Whether it stands in the plane, for planar arms, or in space.
    fields : mapping of str to str
        The attributes that say all of it, and what problem files call each of them; the empty name is that of one that
        stands alone.
    name : str or None
    """

    kind: ClassVar[str]
    dimension: ClassVar[int]
    fields: ClassVar[Mapping[str, str]]

    def __init__(self, name: str | None = None) -> None:
        if name is not None and (not isinstance(name, str) or not name.strip() or len(name) > LONGEST_NAME):
            raise InvalidInputError("name", "is no name", f"give up to {LONGEST_NAME} characters, or none", name)
        self.name = name

    def __repr__(self) -> str:
        given = [f"{field}={_plain(getattr(self, field))}" for field in self.fields]
        name = [] if self.name is None else [f"name={self.name!r}"]
        return _bearable(f"{type(self).__name__}({', '.join(given + name)})")

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.as_mapping() == other.as_mapping()

    def __hash__(self) -> int:
        return hash((self.kind, self.name))

    @property
    def label(self) -> str:
        """What to call it: its name, or else its kind."""
        return self.name or self.kind.replace("_", " ")

    def as_mapping(self) -> dict[str, Any]:
        """Return it as a problem file has it, from which it is made again with the same numbers."""
        values = {key: _plain(getattr(self, field)) for field, key in self.fields.items()}
        named = {} if self.name is None else {"name": self.name}
        return {**named, self.kind: values.get("", values)}

    def doubts(self, reach: float) -> list[str]:
        """Return what is doubtful of it and yet may be meant, about an arm of this reach."""
        return []

    @abstractmethod
    def shape(self) -> tuple[int, FloatArray]:
        """Return its kind and numbers for the kernels of distances, shape (k,)."""


def _bearable(text: str) -> str:
    """Return the text of a call as one line of bearable length."""
    return text if len(text) <= 200 else text[:196] + " …)"


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value
