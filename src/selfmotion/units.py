"""Units of length, and paths whose size says that theirs was mistaken: metres for millimetres, inches for metres."""

from __future__ import annotations

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
"""Metres in one unit of a file's positions, or of an arm's lengths."""
# A path that fits an arm extends over this much of its reach; a workpiece over so many metres.
_FITS = (0.05, 2.0)
_WORKPIECE = (0.01, 3.0)
# Sizes [m] that no drawing of a workpiece is likely to have.
_LEAST, _MOST = 2e-4, 50.0


def too_small(extent: float, length: float, reach: float, arm_unit: str = "") -> str | None:
    """Return what is to be said of a path so small for an arm that its unit is in doubt; None if it is not.

    A path within twice the arm's reach whose metres were taken for millimetres extends over 1/500 of the reach at most.
    That is no proof: such paths exist, and are planned.

    Parameters
    ----------
    extent, length : float
        The largest side of the box around the path, and its length, in the unit of the arm.
    reach : float
    arm_unit : str
        The name of that unit, if it is known.
    """
    # What only turns in one place extends over rounding errors.
    if not 1e-9 * reach < extent < reach * _FITS[1] / 1000:
        return None
    unit = f" {arm_unit}" if arm_unit else ""
    return (
        f"the path extends over {extent:.3g}{unit} (length {length:.3g}{unit}), the arm reaches {reach:.6g}{unit}, "
        f"{reach / extent:.0f} times as far; 1000 times larger, at {1000 * extent:.3g}{unit}, it would fit: "
        "was m taken for mm? unit is that of the file's numbers, arm_unit that of the arm's lengths"
    )


def unlikely(metres: float, unit: float, by: str) -> str | None:
    """Return what is to be said of a drawing of a size that no workpiece is likely to have; None if it may have it.

    Parameters
    ----------
    metres : float
        How far it extends [m].
    unit : float
        Metres in one of its numbers.
    by : str
        The unit, and who says it.
    """
    if not metres > 0 or _LEAST <= metres <= _MOST:
        return None
    others = {name: metres * size / unit for name, size in UNITS.items()}
    fit = [
        f"{size:.3g} m if they are in {name}" for name, size in others.items() if _WORKPIECE[0] <= size <= _WORKPIECE[1]
    ]
    return f"by its numbers in {by} it extends over {metres:.3g} m" + (f", and over {' or '.join(fit)}" if fit else "")
