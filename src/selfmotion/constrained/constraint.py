"""What a constraint on postures is: margins for those who search, and enclosures for those who prove."""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from selfmotion._types import FloatArray, IntArray
from selfmotion.arms.cells import Cells

BLOCKED: Final = -1
UNDECIDED: Final = 0
FREE: Final = 1


class States(NamedTuple):
    """What is sure of m cells or boxes.

    Attributes
    ----------
    state : array of int, shape (m,)
        `FREE`: every posture keeps the constraint; `BLOCKED`: none does; `UNDECIDED`: neither is proved.
    by : array of int, shape (m,)
        Of blocked ones, which of the constraint's margins no posture keeps; of undecided ones, the first that may not
        be kept; −1 of free ones.
    """

    state: IntArray
    by: IntArray


class Constraint(Protocol):
    """A constraint on postures, beside joint limits."""

    check: str
    """Name of the check that fails where it is not kept, such as ``"clearance"``."""
    scale: float
    """What margins are to be divided by to be of size 1."""
    tolerance: float
    """Lack that is forgiven of computed motions, a matter of rounding."""
    unit: str

    def margins(self, q: FloatArray) -> FloatArray:
        """Return the margins of postures (k, n), shape (k, m): zero or more where the constraint is kept.

        Positive ones are exact, those of meshes but for 1e-7 of the mesh's size that they are too small by; of negative
        ones only the sign is, and they are no deeper than the truth.
        """
        ...

    def least_margins(self, q: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return the least margin of postures (k, n), and which it is; shapes (k,)."""
        ...

    def gradients(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the margins (k, m) and their derivatives by the joints (k, m, n)."""
        ...

    def of_cells(self, cells: Cells, forgiven: float = 0.0) -> States:
        """Return what is sure of cells; free are those that lack no more than `forgiven`."""
        ...

    def of_boxes(self, low: FloatArray, high: FloatArray, places: FloatArray | None = None) -> States:
        """Return what is sure of boxes of joint angles, (m, n) each; `places` are those of :class:`Boxes`."""
        ...

    def cause(self, k: int) -> str:
        """Return in words what margin k is of, such as ``"link 3 against obstacle 2"``."""
        ...
