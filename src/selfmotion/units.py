"""Units of length that files and placements may say."""

from __future__ import annotations

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
"""Metres in one unit."""
