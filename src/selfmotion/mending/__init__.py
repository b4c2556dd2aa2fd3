"""Repair of sampled motions: which rows are kept, and what goes between them."""

from __future__ import annotations

from selfmotion.mending.repair import Repair, repair

__all__ = ["Repair", "repair"]
