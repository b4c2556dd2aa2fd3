"""DXF: lines, polylines with bulges, arcs, circles, ellipses and splines, chained where their ends meet."""

from __future__ import annotations

import logging
import os
from typing import Any, Literal, NamedTuple, Unpack

from selfmotion._checks import choice
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.chaining import chained
from selfmotion.exchange.drawing import Drawing, drawing
from selfmotion.exchange.dxf_entities import Entities
from selfmotion.exchange.reading import Options, Reading, about, needs_extra, read_checked, settled_unit, spelled_out
from selfmotion.units import UNITS, point_text

# $INSUNITS: our name of the unit and metres in it.
_INSUNITS = {
    1: ("inch", 0.0254), 2: ("foot", 0.3048), 3: ("mile", 1609.344), 4: ("mm", 1e-3), 5: ("cm", 1e-2), 6: ("m", 1.0),
    7: ("km", 1e3), 8: ("microinch", 2.54e-8), 9: ("mil", 2.54e-5), 10: ("yard", 0.9144), 13: ("micron", 1e-6),
    14: ("dm", 0.1),
}  # fmt: skip
_IMPERIAL = (1, 2, 3, 8, 9, 10)


@spelled_out
def read_dxf(
    file: str | os.PathLike[str],
    unit: Literal["m", "mm", "cm", "inch"] | None = None,
    **options: Unpack[Reading],
) -> Drawing:
    """Read a DXF drawing.

    Parameters
    ----------
    file : path-like
        Text or binary DXF.
    unit : {"m", "mm", "cm", "inch"}, optional
        Of the drawing's numbers. Needed unless the file says it by $INSUNITS.
    **options
        `arm_unit`, `scale`, `tolerance`, `gaps`, `lift` and `subpath`: see :class:`~.reading.Options`.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        Naming the file, and the entity by its handle.
    MissingExtraError
        If the package ezdxf is missing.

    Notes
    -----
    Read is the model space, inserted blocks included, dimensions and other annotations not. Entities are chained where
    their ends meet, whichever way each was drawn; a chain runs as its first entity in the file does, and chains keep
    the order of their first entities. Rational splines are flattened; everything else is exact.
    """
    chosen = Options(**options)
    if unit is not None:
        choice("unit", unit, UNITS)
    with about(file):
        return _read(file, unit, chosen)


class _Header(NamedTuple):
    """What the file says of its unit: name and metres, if anything, and where that contradicts itself."""

    unit: str | None
    metres: float
    warnings: tuple[str, ...]


def _read(file: str | os.PathLike[str], unit: str | None, options: Options) -> Drawing:
    document, header = _document(file)
    named, words = settled_unit(unit, header.unit, "$INSUNITS")
    metres = UNITS[named] if header.unit is None else header.metres
    entities = Entities(options.factor(metres), options.within)
    strokes = list(entities.strokes(document))
    chains, forks = chained(strokes, options.within)
    notes = ["the origin is that of the file"]
    if forks:
        at = point_text(forks[0])
        notes.append(f"more than two ends meet at {len(forks)} points, the first {at}; there the file's order was kept")
    return drawing(
        os.fspath(file), "DXF", words, metres, chains, options,
        ignored=entities.ledger.entries(), notes=notes, warnings=header.warnings, chord_error=entities.chord_error,
    )  # fmt: skip


def _document(file: str | os.PathLike[str]) -> tuple[Any, _Header]:
    try:
        from ezdxf.filemanagement import readfile
    except ImportError:
        raise needs_extra("ezdxf") from None
    # What a file has wrong is said by our errors; without this its log would go to the terminal.
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())
    data = read_checked(file)
    binary = data.startswith(b"AutoCAD Binary DXF")
    if not data.strip():
        raise InvalidInputError("", "is empty", "is it the right file?")
    if not binary and (b"\0" in data or b"SECTION" not in data[:100_000]):
        raise InvalidInputError("", "is not a DXF file", "is it the right file? a DWG is to be saved as DXF first")
    if not binary and data.split()[-1:] != [b"EOF"]:
        raise InvalidInputError("", "does not end with EOF: a part of it is missing", "copy or export it again")
    try:
        document = readfile(os.fspath(file))
        # Of a variable that is not in the file ezdxf has a default; what the file does not say counts for nothing.
        said = {
            name: int(document.header.get(name, 0)) for name in ("$INSUNITS", "$MEASUREMENT") if name.encode() in data
        }
    except Exception as error:  # whatever a broken file makes of a parser
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InvalidInputError("", f"is not a DXF file that can be read ({reason})", "export it again") from None
    return document, _header(said)


def _header(said: dict[str, int]) -> _Header:
    code = said.get("$INSUNITS", 0)
    unit, metres = _INSUNITS.get(code, (None, 1.0))
    warnings = []
    if unit is not None and "$MEASUREMENT" in said and (code in _IMPERIAL) == (said["$MEASUREMENT"] == 1):
        system = "metric" if said["$MEASUREMENT"] == 1 else "imperial"
        warnings.append(f"the file contradicts itself: its unit is {unit} by $INSUNITS, and {system} by $MEASUREMENT")
    return _Header(unit, metres, tuple(warnings))
