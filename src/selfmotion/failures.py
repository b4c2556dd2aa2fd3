"""What went wrong, or could not be, as plain data."""

from __future__ import annotations

from typing import Any

from selfmotion.errors import InfeasibleError, SelfMotionError


def failure_object(error: SelfMotionError) -> dict[str, Any]:
    """Return the result object of a run that ended without a motion."""
    from selfmotion.plans import result_object

    found = _infeasibility(error) if isinstance(error, InfeasibleError) else {}
    return result_object(status=error.status, **found, error=error_object(error))


def error_object(error: SelfMotionError) -> dict[str, Any]:
    """Return what is wrong and what to do, as JSON has it."""
    return {
        "message": error.message,
        "remedy": error.remedy,
        "file": getattr(error, "source", None),
        "field": getattr(error, "field", None) or None,
    }


def blocked_object(part: Any) -> dict[str, Any]:
    """Return a blocked part of a path, and what blocks it, as JSON has it."""
    return {"r": list(part.r), "cause": part.cause, "short_by": part.short_by, "limits": list(part.limits)}


def _infeasibility(error: InfeasibleError) -> dict[str, Any]:
    """Return what is known of a problem without a motion."""
    from dataclasses import asdict

    found: dict[str, Any] = {"blocked": [blocked_object(part) for part in error.blocked]}
    found["needs"] = [asdict(need) for need in error.needs]
    found["proof"] = None if error.proof is None else asdict(error.proof)
    if error.reconfigured is not None:
        breaks = error.reconfigured.breaks
        found["reconfigurations"] = len(breaks)
        found["breaks"] = [{"r": part.r, "r_range": list(part.r_range), "travel": part.travel} for part in breaks]
        found["l1_travel"] = error.reconfigured.l1_travel
    return found
