"""What is wrong with a solver that fails, in words: read off a few of its answers, or left unsaid.

The full contact of four waves has an answer in closed form, so that what was done to it can be fitted:
turned, moved, scaled, another load, another response. Of a rough surface it is seen whether pressures are
negative, cut off or lifted, and whether residuals fall with the tolerance. What fits nothing has no name.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fem_contact.errors import NotConverged
from validation.arrays import Array
from validation.cases.scorecard import elementary
from validation.cases.scorecard.elementary import WAVES, Transfer, full_contact_transfer, solves
from validation.cases.scorecard.subject import Subject
from validation.report.values import Value

#: What may have been done to the pressures of a square, and in words.
_TURNED: dict[str, Callable[[Array], Array]] = {
    "mirrored in x": lambda p: np.roll(p[::-1], 1, axis=0),
    "mirrored in y": lambda p: np.roll(p[:, ::-1], 1, axis=1),
    "turned by 180 degrees": lambda p: np.roll(p[::-1, ::-1], (1, 1), (0, 1)),
    "transposed": np.transpose,
    "turned by 90 degrees": lambda p: np.roll(np.rot90(p), 1, axis=0),
    "turned by -90 degrees": lambda p: np.roll(np.rot90(p, -1), 1, axis=1),
}
#: Largest part of the pressures that a fit may leave.
_LEFT = 0.03
#: Least part of the points that a cut leaves at one value.
_PLATEAU = 0.005


def diagnose(subject: Subject) -> str:
    """Return what is wrong with a solver, in words; nothing where its answers do not tell.

    Its time may be used up: then only what it answered is read.
    """
    try:
        if not all(np.isfinite(pressed.pressure).all() for _, _, pressed in solves(subject)):
            return "pressures are no finite numbers"
        if not all(check.passed for check in elementary.repeatable.run(subject)):
            return "the same question has different answers"
        transfer = full_contact_transfer(subject)
        cause = _of_full_contact(transfer)
        if cause is None:
            return _of_rough(subject)
        return cause or _of_response(subject, transfer)
    except NotConverged as failure:
        return f"it gives no answer: {failure}"
    except Exception:  # what it raises, or what was not asked of it, a row says
        return ""


# ---- full contact: the answer is known -----------------------------------------------------------------


def _fitted(pressure: Array, pattern: Array) -> tuple[float, float]:
    """Return the factor of a pattern in the fluctuation of the pressure, and the part that it leaves."""
    factor = float(np.vdot(pattern, pressure) / np.vdot(pattern, pattern))
    size = float(np.linalg.norm(pressure))
    return factor, float(np.linalg.norm(pressure - factor * pattern)) / size if size else 1.0


def _of_full_contact(transfer: Transfer) -> str | None:
    """Return what was done to the full contact: None if nothing was, an empty text if nothing fits."""
    pressure, exact = transfer.pressed.pressure, transfer.exact
    load, mean = exact.mean(), pressure.mean()
    off = max(transfer.allowed.max(), _LEFT)
    if np.ptp(pressure) < 1e-6 * np.ptp(exact):
        return "all points have one pressure" if mean else "all pressures are zero"
    moved, pattern = pressure - mean, exact - load
    (factor, left), share = _fitted(moved, pattern), mean / load
    if left < off and transfer.factor is not None:
        return _scaled(factor, share, off=float(transfer.allowed[:2].max()))
    for words, turn in _TURNED.items():
        factor, left = _fitted(moved, turn(pattern))
        if left < off and abs(factor - 1) < off and abs(share - 1) < off:
            return f"the pressures are {words}"
    shift = transfer.shift
    if shift is not None and max(map(abs, shift)) > 0.05 and abs(np.abs(transfer.ratio) - 1).max() < 4 * off:
        along = " and ".join(f"{round(cells, 2) + 0.0:g}" for cells in shift)
        return f"the pressure lies {along} cells beside the heights"
    return ""


def _scaled(factor: float, share: float, *, off: float) -> str | None:
    """Say what scaled the fluctuation of a full contact by `factor`, and its mean by `share`, up to `off`.

    None where both are 1; an empty text where they are not, and no cause fits.
    """
    waved, loaded = abs(factor - 1) < off, abs(share - 1) < off
    if waved:
        return None if loaded else f"the load is {Value(value=share)} times the one asked for"
    if abs(factor + 1) < off:
        upright = "the surface is pressed upside down" if loaded else ""
        return "compression is negative" if abs(share + 1) < off else upright
    if loaded:
        return f"the stiffness is {Value(value=factor)} times that of E*" if factor > 0 else ""
    alike = abs(factor / share - 1) < off
    return f"pressures are {Value(value=share)} times what they should be" if alike else ""


def _of_response(subject: Subject, transfer: Transfer) -> str:
    """Say what stiffness waves are answered with, if each has its own, alone as among others."""
    if not np.all(np.abs(np.angle(transfer.ratio)) < 0.05):
        return ""
    for k in (0, len(WAVES) - 1):
        alone = full_contact_transfer(subject, waves=(WAVES[k],)).ratio[0]
        if abs(alone / transfer.ratio[k] - 1) > 1e-3:
            return ""
    each = ", ".join(f"{Value(value=float(abs(ratio)))}" for ratio in transfer.ratio)
    return f"the response is not that of the half-space: waves are {each} times as stiff, longest first"


# ---- a rough surface -----------------------------------------------------------------------------------


def _of_rough(subject: Subject) -> str:
    """Return what the pressures of a rough surface show; the full contact is right."""
    _, load, pressed = solves(subject)[0]
    pressure = pressed.pressure
    lowest, highest = pressure.min(), pressure.max()
    lifted = np.mean(pressure < lowest + 1e-6 * highest)
    if lowest > 1e-3 * load and lifted > 0.2:
        return "a constant is added to the pressures"
    if lowest < -10 * subject.tolerance:
        return "pressures below zero are allowed"
    shares = np.array([one.pressure.mean() / asked for _, asked, one in solves(subject)])
    if np.abs(shares - 1).max() > 10 * subject.tolerance:
        alike = np.ptp(shares) < 0.1 * np.abs(shares - 1).min()
        return f"the load is {Value(value=float(shares.mean()))} times the one asked for" if alike else ""
    if np.mean(pressure > highest * (1 - 1e-9)) > _PLATEAU:
        return "the highest pressures are cut off"
    if not all(check.passed for check in elementary.honesty.run(subject)):
        return "the iteration ends before its tolerance is met" if elementary.residuals_fall(subject) else ""
    missed = [check for check in elementary.contact_set.run(subject) if not check.passed]
    if missed and all(check.computed > 1 for check in missed):
        return "points are called contact that carry no load"
    if missed and all(check.computed < 1 for check in missed):
        return "points that carry load are not called contact"
    return ""
