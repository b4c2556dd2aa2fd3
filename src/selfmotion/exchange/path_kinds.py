"""The paths that files describe, by the ``kind`` of a problem file; a new format is one line here."""

from __future__ import annotations

from selfmotion.exchange.drawing_paths import DxfPath, GcodePath, SvgPath
from selfmotion.exchange.file_path import PathFromFile
from selfmotion.exchange.waypoint_file import FilePath

FILE_PATHS: dict[str, type[PathFromFile]] = {path.kind: path for path in (FilePath, SvgPath, DxfPath, GcodePath)}
"""Every path that is read from a file."""
