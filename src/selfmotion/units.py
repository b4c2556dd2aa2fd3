"""Units of length, and paths whose size says that theirs was mistaken: metres for millimetres, inches for metres."""

from __future__ import annotations

from collections.abc import Iterable

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
"""Metres in one unit of a file's positions, or of an arm's lengths."""
# A path that fits an arm extends over this much of its reach; a workpiece over so many metres.
_FITS = (0.05, 2.0)
_WORKPIECE = (0.01, 3.0)
# Reaches that what stands in a cell extends over.
_SOLID = (2e-3, 100.0)
# Sizes [m] that no drawing of a workpiece is likely to have.
_LEAST, _MOST = 2e-4, 50.0
_ARM = (2e-3, 50.0)  # reaches [m] between which those of arms are


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


def too_large(extent: float, reach: float, arm_unit: str = "") -> str | None:
    """Return what is to be said of a path that extends farther than an arm reaches across; None if it does not.

    Parameters
    ----------
    extent : float
        The largest side of the box around the path, in the unit of the arm.
    reach : float
    arm_unit : str
        The name of that unit, if it is known.
    """
    if not extent > _FITS[1] * reach:
        return None
    unit = f" {arm_unit}" if arm_unit else ""
    smaller = extent / 1000
    fits = f"; 1000 times smaller, at {smaller:.3g}{unit}, it would fit: was mm taken for m?"
    return (
        f"the path extends over {extent:.3g}{unit}, the arm reaches {reach:.6g}{unit} from its base, "
        f"{_FITS[1] * reach:.6g}{unit} across: part of the path is out of reach"
        + (fits if _FITS[0] * reach <= smaller <= _FITS[1] * reach else "")
    )


def contradiction(path_unit: str, arm_unit: str, by: str = "") -> str | None:
    """Return what is to be said of a path that was converted to another unit than its arm's; None if it was not.

    Parameters
    ----------
    path_unit, arm_unit : str
    by : str
        The field that says the arm's unit, if one does.
    """
    if path_unit == arm_unit:
        return None
    return f"the path is in {path_unit} (arm_unit) and the arm in {arm_unit}" + (f" ({by})" if by else "")


def unlikely_arm(reach: float, unit: str) -> str | None:
    """Return what is to be said of an arm of a size that none is likely to have; None if it may have it.

    Parameters
    ----------
    reach : float
        How far it reaches [m].
    unit : str
        That of its lengths.
    """
    if _ARM[0] <= reach <= _ARM[1]:
        return None
    others = {name: reach / UNITS[unit] * size for name, size in UNITS.items()}
    fit = [f"{size:.3g} m if they were in {name}" for name, size in others.items() if _WORKPIECE[0] < size < 10]
    said = f"the arm reaches {reach:.3g} m, its links being in {unit} (placement.unit)"
    return said + (f"; it would reach {' or '.join(fit)}" if fit else "")


def unlikely_mesh(extent: float, reach: float) -> str | None:
    """Return what is to be said of a mesh so large or so small for an arm that its unit is in doubt; None if it is not.

    Parameters
    ----------
    extent, reach : float
        The largest side of the box around the mesh, scaled, and how far the arm reaches, in one unit.
    """
    if _SOLID[0] * reach <= extent <= _SOLID[1] * reach:
        return None
    by = 0.001 if extent > reach else 1000.0
    return (
        f"the mesh extends over {extent:.3g}, and the arm reaches {reach:.3g}: was mm taken for m, or m for mm? "
        f"{by:g} times as large it extends over {by * extent:.3g}; scale multiplies the numbers of the file"
    )


def point_text(point: Iterable[float]) -> str:
    """Return a point as short text."""
    return "(" + ", ".join(f"{round(float(value), 12) + 0.0:.6g}" for value in point) + ")"


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
        f"{size:.3g} m if they were in {name}"
        for name, size in others.items()
        if _WORKPIECE[0] <= size <= _WORKPIECE[1]
    ]
    said = f"it extends over {metres:.3g} m, its numbers being in {by}"
    return said + (f"; it would extend over {' or '.join(fit)}" if fit else "")
