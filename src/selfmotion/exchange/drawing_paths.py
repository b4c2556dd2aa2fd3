"""Drawings and programs as paths of a problem file: each what its reader reads, with the reader's own options."""

from __future__ import annotations

from typing import Literal, Unpack

from selfmotion._types import FileName
from selfmotion.exchange.dxf_file import read_dxf
from selfmotion.exchange.file_path import PathFromFile, about_file
from selfmotion.exchange.gcode_file import read_gcode
from selfmotion.exchange.reading import Reading, spelled_out
from selfmotion.exchange.svg_file import read_svg


class SvgPath(PathFromFile):
    """The shapes of an SVG file, y pointing up.

    Parameters
    ----------
    file : str
        See :func:`read_svg`.
    unit : {"m", "mm", "cm", "inch", "px"}, optional
        Of the drawing's user units; needed unless the page has a size in physical units and a viewBox.
    **options
        `arm_unit`, `scale`, `tolerance`, `gaps`, `lift` and `subpath`: see :class:`~.reading.Options`.

    Raises
    ------
    InvalidInputError
        Naming file and line.
    """

    kind = "svg"

    @spelled_out
    def __init__(
        self, file: FileName, unit: Literal["m", "mm", "cm", "inch", "px"] | None = None, **options: Unpack[Reading]
    ) -> None:
        super().__init__(file, about_file(file, lambda: read_svg(file, unit, **options).path))


class DxfPath(PathFromFile):
    """The entities of a DXF file, chained where their ends meet.

    Parameters
    ----------
    file : str
        See :func:`read_dxf`.
    unit : {"m", "mm", "cm", "inch"}, optional
        Of the drawing's numbers; needed unless the file says it by $INSUNITS.
    **options
        `arm_unit`, `scale`, `tolerance`, `gaps`, `lift` and `subpath`: see :class:`~.reading.Options`.

    Raises
    ------
    InvalidInputError
        Naming the file, and the entity by its handle.
    """

    kind = "dxf"

    @spelled_out
    def __init__(
        self, file: FileName, unit: Literal["m", "mm", "cm", "inch"] | None = None, **options: Unpack[Reading]
    ) -> None:
        super().__init__(file, about_file(file, lambda: read_dxf(file, unit, **options).path))


class GcodePath(PathFromFile):
    """The cutting moves of a G-code program; in space its rapid moves lead from one to the next.

    Parameters
    ----------
    file : str
        See :func:`read_gcode`.
    unit : {"mm", "inch"}, optional
        Of the program's numbers; needed if it has neither G20 nor G21.
    dimension : {2, 3}, optional
        2 drops Z, for planar arms; 3 by default if the program moves in Z.
    **options
        `arm_unit`, `scale`, `tolerance`, `gaps`, `lift` and `subpath`: see :class:`~.reading.Options`.
        `gaps` and `lift` are for the plane.

    Raises
    ------
    InvalidInputError
        Naming file and line.
    """

    kind = "gcode"

    @spelled_out
    def __init__(
        self,
        file: FileName,
        unit: Literal["mm", "inch"] | None = None,
        dimension: Literal[2, 3] | None = None,
        **options: Unpack[Reading],
    ) -> None:
        path = about_file(file, lambda: read_gcode(file, unit, dimension=dimension, **options).path)
        super().__init__(file, path)
