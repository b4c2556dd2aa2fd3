"""Reports: the paper's study beside its printed results."""

from __future__ import annotations

from selfmotion.report.reproduce import file_names, reproduce
from selfmotion.report.study import Study

__all__ = ["Study", "file_names", "reproduce"]
