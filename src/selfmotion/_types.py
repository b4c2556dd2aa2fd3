"""Array types shared by every signature.

The ``Annotated`` aliases are read twice: by people, and by :mod:`selfmotion.exchange.schema`, which
derives the problem file's schema from the constructors' signatures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

Vector = Annotated[ArrayLike, "vector"]
"""Numbers, shape (k,)."""
Point = Annotated[ArrayLike, "point"]
"""One point of the plane, shape (2,)."""
Points = Annotated[ArrayLike, "points"]
"""Points of the plane, shape (k, 2)."""
Limits = Annotated[Sequence[Any] | None, "limits"]
"""Per joint ``None`` or ``(lower, upper)`` in radians; either end may be ``None``."""
Box = Annotated[ArrayLike, "box"]
"""``(lower, upper)`` for every variable, or one such pair per variable."""
