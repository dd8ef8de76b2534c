"""Problems at which solvers are known to break, and what else they may be told: an offset, an early end."""

from __future__ import annotations

import math

import numpy as np

from fem_contact.area import subcell_area
from fem_contact.errors import NotConverged
from validation.cases import Checks, below, case, near, relative
from validation.cases._closed_forms import EGG_BOX_DEPTH, EGG_BOX_FLAT, HertzInPeriod, egg_box
from validation.cases.scorecard.elementary import judge_residuals
from validation.cases.scorecard.known import mean_inside, strip
from validation.cases.scorecard.subject import Subject, rough

_LIGHT, _NEAR_FULL = 0.05, 1.6
_FEW = 2


@case("near-full", source="[johnson1985]", tolerance="grid")
def near_full(subject: Subject) -> Checks:
    """Full contact just above and below the flattening load."""
    n = subject.ladder[-1]
    flat = subject.press(egg_box(n), 1.0001 * EGG_BOX_FLAT)
    exact = 1.0001 * EGG_BOX_FLAT + EGG_BOX_FLAT * egg_box(n).heights / EGG_BOX_DEPTH
    # A discretisation of second order errs by (q dx)^2 / 4, and by the tolerance.
    allowed = (2 * math.pi * math.sqrt(2) / n) ** 2 / 4 + subject.pressure_error
    error = (flat.pressure - exact) / EGG_BOX_FLAT
    yield below("error of the pressure over the mean, at 1.0001 of the flattening load", error, allowed)
    yield near("A/A0 at 1.0001 of the flattening load", flat.result.in_contact.mean(), 1.0, 0.0)
    for miss in (0.02, 0.04):
        pressed = subject.press(egg_box(n), (1 - miss) * EGG_BOX_FLAT).result
        open_share = 3 / (2 * math.pi) * miss
        # Two gaps in a period, counted to half a cell along their edges; where edges are located, to a tenth.
        edge = 2 * 2 * math.pi * math.sqrt(open_share / 2 / math.pi) / n
        located = subject.solver.locates_edges
        area = subcell_area(pressed) if located else pressed.in_contact.mean()
        tolerance = (0.1 if located else 0.5) * edge + miss * open_share
        yield near(f"1 - A/A0 at {1 - miss:g} of it", 1 - area, open_share, tolerance)


@case("one-cell", source="exact", tolerance="solver")
def one_cell(subject: Subject) -> Checks:
    """A load that one point carries is carried by one point."""
    n = 2 * subject.points
    load = 0.02 / n
    pressed = subject.press(HertzInPeriod(radius=1e-3).surface(n), load / n**2)
    share = pressed.pressure.max() / load
    yield relative("largest pressure over the load", share, 1.0, 10 * subject.tolerance)
    yield near("points that touch", np.count_nonzero(pressed.result.in_contact), 1.0, 0.0)


@case("elongated", source="[westergaard1939]", tolerance="grid")
def elongated(subject: Subject) -> Checks:
    """Long periods and long cells change nothing."""
    n = 2 * subject.points
    # Cells are four times as long as wide: of second order where they are coarse.
    allowed = 0.02 * max(1.0, (32 / n) ** 2)
    for axis, words in ((0, "1 x 4"), (1, "4 x 1")):
        error = mean_inside(strip(subject, n, across=(n, 4.0), axis=axis)[1])
        yield below(f"mean error of p over the peak, period {words}", error, allowed)


@case("odd-axes", source="definition", tolerance="solver")
def odd_axes(subject: Subject) -> Checks:
    """Odd numbers of points are solved as well."""
    n = 2 * subject.points
    checks = []
    odd = n - n // 4 - 3
    for shape in ((odd, n), (n, odd), (odd, odd)):
        residuals = subject.press(rough(n).resampled(shape), 0.05).result.residuals
        words = f"complementarity, recomputed, on {shape[0]} x {shape[1]} points"
        checks.append(below(words, residuals.complementarity, subject.tolerance))
    return judge_residuals(subject, checks)


def _asked_back(subject: Subject, *, load: float) -> Checks:
    subject.needs(control="offset")
    surface = subject.rough
    by_load = subject.press(surface, load).result
    by_offset = subject.press(surface, None, more={"offset": by_load.offset})
    missed = abs(by_offset.result.offset - by_load.offset) / surface.rms_height
    area = by_load.in_contact.mean()
    # Both answers miss the offset by what the tolerance allows.
    allowed = 2 * 10 * subject.tolerance
    words = f"offset of the returned pressure beside that asked for, over h_rms, A/A0 = {area:.4f}"
    checks = [
        below(words, missed, allowed),
        below("complementarity, recomputed", by_offset.result.residuals.complementarity, subject.tolerance),
        below("solves that say they did not converge, of 1", by_offset.claim.converged is False, 0.5),
    ]
    return judge_residuals(subject, checks)


_UNIQUE = {"source": "uniqueness of the elastic solution", "tolerance": "solver"}


@case("offset", **_UNIQUE)
def offset(subject: Subject) -> Checks:
    """An offset leads to the pressures of the load that it belongs to."""
    return _asked_back(subject, load=_LIGHT)


@case("offset-near-full", **_UNIQUE)
def near_full_offset(subject: Subject) -> Checks:
    """So it does near full contact."""
    return _asked_back(subject, load=_NEAR_FULL)


@case("cut-short", source="definition", tolerance="rounding")
def cut_short(subject: Subject) -> Checks:
    """A solve that ends early says so."""
    subject.needs(control="max_iterations")
    words = f"solves that end after {_FEW} iterations and do not say so, of 1"
    try:
        pressed = subject.press(subject.rough, _LIGHT, more={"max_iterations": _FEW})
    except NotConverged:
        yield below(words, 0.0, 0.5)
        return
    met = pressed.result.residuals.within(subject.tolerance)
    silent = not met and pressed.claim.converged is not False
    yield below(words, silent, 0.5)
