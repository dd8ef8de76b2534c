"""What else a solver can be asked than a contact under a load: an offset, and to stop early and say so."""

from __future__ import annotations

from collections.abc import Sequence

from fem_contact.contact import ContactResult
from fem_contact.errors import NotConverged
from validation.cases import Check
from validation.cases.scorecard.subject import Subject, rough

__all__ = ["NEEDED", "cut_short", "offset", "offset_near_full"]

#: Rows and the control that a solver must take.
NEEDED = {"offset": "offset", "offset-near-full": "offset", "cut-short": "max_iterations"}

_LIGHT, _NEAR_FULL = 0.05, 1.6
_FEW = 2


def offset(subject: Subject) -> Sequence[Check]:
    """Ask for the offset that a light load led to."""
    return _asked_back(subject, _LIGHT)


def offset_near_full(subject: Subject) -> Sequence[Check]:
    """Ask for the offset of a load that leaves few points open, where it says least of the load."""
    return _asked_back(subject, _NEAR_FULL)


def _asked_back(subject: Subject, load: float) -> Sequence[Check]:
    surface = rough(2 * subject.points)
    by_load = subject.press(surface, load).result
    found = subject.press(surface, None, more={"offset": by_load.offset})
    missed = abs(found.result.offset - by_load.offset) / surface.rms_height
    residuals, says = found.result.residuals, found.claim.converged
    # Both answers miss the offset by what the tolerance allows.
    allowed = 2 * 10 * subject.tolerance
    words = f"offset of the returned pressure beside that asked for, over h_rms, A/A0 = {_area(by_load):.4f}"
    return [
        Check.below(words, missed, allowed),
        Check.below("complementarity, recomputed", residuals.complementarity, subject.tolerance),
        Check.below("says that it did not converge", 0.0 if says is None else float(not says), 0.0),
    ]


def _area(result: ContactResult) -> float:
    return float(result.in_contact.mean())


def cut_short(subject: Subject) -> Sequence[Check]:
    """Allow so few iterations that it cannot be done: it must say so, or raise."""
    words = f"calls {_FEW} iterations converged, or says nothing"
    surface = rough(2 * subject.points)
    try:
        found = subject.press(surface, _LIGHT, more={"max_iterations": _FEW})
    except NotConverged:
        return [Check.below(words, 0.0, 0.0)]
    met = found.result.residuals.within(subject.tolerance)
    silent = not met and found.claim.converged is not False
    return [Check.below(words, float(silent), 0.0)]
