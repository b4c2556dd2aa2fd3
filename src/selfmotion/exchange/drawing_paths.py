"""Drawings and programs as paths of a problem file."""

from __future__ import annotations

import os
from typing import Literal

from selfmotion._types import FileName
from selfmotion.exchange.dxf_file import read_dxf
from selfmotion.exchange.file_path import PathFromFile, about_file
from selfmotion.exchange.gcode_file import read_gcode
from selfmotion.exchange.svg_file import read_svg


class SvgPath(PathFromFile):
    """The shapes of an SVG file, y pointing up.

    Parameters
    ----------
    file : str
        See :func:`read_svg`.
    unit : {"m", "mm", "cm", "inch", "px"}, optional
        Of the drawing's user units; needed unless the page has a size in physical units and a viewBox.
    arm_unit : {"m", "mm", "cm", "inch"}
        Of the arm's lengths, and so of the path.
    scale : float
    tolerance : float, optional
        How far apart ends may be that meet, in `arm_unit`; 0.1 mm on the drawing by default.
    gaps : {"error", "line"}
        Whether straight lines join what does not meet.
    lift : float, optional
        Height at which a space curve crosses gaps, in `arm_unit`.
    subpath : int, optional
        Only this one, from 0.

    Raises
    ------
    InvalidInputError
        Naming file and line.
    """

    kind = "svg"

    def __init__(
        self,
        file: FileName,
        unit: Literal["m", "mm", "cm", "inch", "px"] | None = None,
        arm_unit: Literal["m", "mm", "cm", "inch"] = "m",
        scale: float = 1.0,
        tolerance: float | None = None,
        gaps: Literal["error", "line"] = "error",
        lift: float | None = None,
        subpath: int | None = None,
    ) -> None:
        name = os.fspath(file)
        more = {"arm_unit": arm_unit, "scale": scale, "tolerance": tolerance}
        choices = {"gaps": gaps, "lift": lift, "subpath": subpath}
        path = about_file(name, lambda: read_svg(file, unit, **more, **choices).path)  # type: ignore[arg-type]
        super().__init__(name, path)


class DxfPath(PathFromFile):
    """The entities of a DXF file, chained where their ends meet.

    Parameters
    ----------
    file : str
        See :func:`read_dxf`.
    unit : {"m", "mm", "cm", "inch"}, optional
        Of the drawing's numbers; needed unless the file says it by $INSUNITS.
    arm_unit : {"m", "mm", "cm", "inch"}
        Of the arm's lengths, and so of the path.
    scale : float
    tolerance : float, optional
        How far apart ends may be that meet, and flattened splines may stray, in `arm_unit`; 0.1 mm on the drawing by
        default.
    gaps : {"error", "line"}
        Whether straight lines join what does not meet.
    lift : float, optional
        Height at which a space curve crosses gaps, in `arm_unit`.
    subpath : int, optional
        Only this one, from 0.

    Raises
    ------
    InvalidInputError
        Naming the file, and the entity by its handle.
    """

    kind = "dxf"

    def __init__(
        self,
        file: FileName,
        unit: Literal["m", "mm", "cm", "inch"] | None = None,
        arm_unit: Literal["m", "mm", "cm", "inch"] = "m",
        scale: float = 1.0,
        tolerance: float | None = None,
        gaps: Literal["error", "line"] = "error",
        lift: float | None = None,
        subpath: int | None = None,
    ) -> None:
        name = os.fspath(file)
        more = {"arm_unit": arm_unit, "scale": scale, "tolerance": tolerance}
        choices = {"gaps": gaps, "lift": lift, "subpath": subpath}
        path = about_file(name, lambda: read_dxf(file, unit, **more, **choices).path)  # type: ignore[arg-type]
        super().__init__(name, path)


class GcodePath(PathFromFile):
    """The cutting moves of a G-code program; in space its rapid moves lead from one to the next.

    Parameters
    ----------
    file : str
        See :func:`read_gcode`.
    unit : {"mm", "inch"}, optional
        Of the program's numbers; needed if it has neither G20 nor G21.
    arm_unit : {"m", "mm", "cm", "inch"}
        Of the arm's lengths, and so of the path.
    scale : float
    tolerance : float, optional
        By how much the two radii of an arc may differ, and helices may stray, in `arm_unit`; 0.1 mm on the drawing by
        default.
    dimension : {2, 3}, optional
        2 drops Z, for planar arms; 3 by default if the program moves in Z.
    gaps : {"error", "line"}
        Of dimension 2: whether straight lines join what rapid moves part.
    subpath : int, optional
        Only this one, from 0.

    Raises
    ------
    InvalidInputError
        Naming file and line.
    """

    kind = "gcode"

    def __init__(
        self,
        file: FileName,
        unit: Literal["mm", "inch"] | None = None,
        arm_unit: Literal["m", "mm", "cm", "inch"] = "m",
        scale: float = 1.0,
        tolerance: float | None = None,
        dimension: Literal[2, 3] | None = None,
        gaps: Literal["error", "line"] = "error",
        subpath: int | None = None,
    ) -> None:
        name = os.fspath(file)
        more = {"arm_unit": arm_unit, "scale": scale, "tolerance": tolerance}
        choices = {"dimension": dimension, "gaps": gaps, "subpath": subpath}
        path = about_file(name, lambda: read_gcode(file, unit, **more, **choices).path)  # type: ignore[arg-type]
        super().__init__(name, path)
