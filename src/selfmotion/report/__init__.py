"""Reports: the seed's study beside its printed results."""

from __future__ import annotations

from selfmotion.report.reproduce import FILES, reproduce

__all__ = ["FILES", "reproduce"]
