"""What a comparison found, in sentences. Every number and every turn of phrase is computed from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from validation.comparison.below import below_findings
from validation.methods import find_method, find_solver
from validation.report.words import significant, with_error

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from fem_contact.extrapolation import Limit
    from validation.comparison.compared import Comparison, CrossCheck, Row

__all__ = ["findings", "layered", "percent", "yielded_row"]


def findings(comparison: Comparison) -> tuple[str, ...]:
    """Return the findings of a comparison, the most asked-for first; those that cannot be decided say so."""
    sentences = [
        *_limit(comparison),
        *_modulus(comparison),
        *_theory(comparison),
        *_yielded(comparison),
        *_passing(comparison),
        *_scatter(comparison),
        *_grids(comparison),
        *_cross(comparison),
        *_pressure_at_zero(comparison),
        *below_findings(comparison),
        *_cost(comparison),
        *_warnings(comparison),
    ]
    return tuple(sentences)


def percent(value: float) -> str:
    """Return a relative number as a percentage with two significant digits.

    >>> percent(0.0312), percent(-0.5), percent(0.00004), percent(float("nan"))
    ('3.1 %', '-50 %', '0.0040 %', 'not determinable')
    """
    if not np.isfinite(value):
        return "not determinable"
    size = abs(100 * value)
    if size == 0:
        return "0 %"
    decimals = max(0, 1 - int(np.floor(np.log10(size))))
    return f"{100 * value:.{decimals}f} %"


def _side(difference: float, above: str = "above", below: str = "below") -> str:
    return f"{percent(abs(difference))} {above if difference > 0 else below}"


def _label(method: str) -> str:
    return find_method(method).label


def _words(c: Comparison, method: str) -> str:
    return find_solver(method).words(c.scene.methods.options(method))


def _grid(row: Row) -> str:
    return f"{row.grid[0]} x {row.grid[1]}"


def _limit(c: Comparison) -> list[str]:
    if c.limit is None:
        return [
            f"The limit of the contact area for vanishing grid spacing is not determinable: {c.no_limit}."
        ]
    if c.limit.value >= 1 - 1e-12:
        return ["Contact is complete: A/A0 = 1 on the resolved grids, and refinement changes nothing."]
    return [
        f"In the limit of vanishing grid spacing A/A0 = {with_error(c.limit.value, c.limit.uncertainty)} "
        f"for this surface ({_how(c.limit)}, {c.limit.grids} solves; one standard error, grid only), "
        f"that is kappa = {_kappa(c, c.limit)} at p* = {c.reduced_pressure:.4g}."
    ]


def layered(c: Comparison) -> bool:
    """Whether the solid has another modulus at its surface than below, so that E* can mean either."""
    return not np.isclose(c.contact_modulus, c.realised.contact_modulus, rtol=1e-9)


def _modulus(c: Comparison) -> list[str]:
    """Say on which modulus p* and kappa stand where there is more than one, and what they are on the others."""
    if not layered(c):
        return []
    below = c.realised.contact_modulus

    def on(modulus: float) -> str:
        load = c.pressure / (modulus * c.rms_gradient)
        kappa = "" if c.limit is None else f" and kappa = {significant(c.limit.value / load)}"
        return f"p* = {significant(load)}{kappa}"

    text = (
        f"p* and kappa stand on E* = {c.contact_modulus:.4g} Pa of the layer at the surface, and are no numbers of a homogeneous "
        f"solid; on E* = {below:.4g} Pa of the solid below {on(below)}"
    )
    if c.theory is None or not c.theory.stress_variance > 0:
        return [text + "."]
    felt = 2 * float(np.sqrt(c.theory.stress_variance)) / c.rms_gradient
    return [
        text
        + f". What the roughness feels lies between: on {felt:.4g} Pa, which gives the stress variance V of full contact, "
        f"{on(felt)}, to be put beside those of homogeneous solids."
    ]


def _kappa(c: Comparison, limit: Limit) -> str:
    return with_error(limit.value / c.reduced_pressure, limit.uncertainty / c.reduced_pressure)


def _how(limit: Limit) -> str:
    if limit.definition == "subcell":
        return "area with the edge located inside the cells, extrapolated by its law of error"
    return "area corrected at its edge, extrapolated by its law of error"


def _theory(c: Comparison) -> list[str]:
    if c.theory is None:
        return []
    if not c.theory.answers:
        return [f"Persson's theory gives {c.theory.note}."]
    text = (
        f"Persson's theory gives A/A0 = {significant(c.theory.area)} with the realised gradient "
        f"h'_rms = {c.rms_gradient:.4g} of this surface"
    )
    if c.theory.ensemble_area is not None:
        text += f", {significant(c.theory.ensemble_area)} from C(q) alone"
    if c.theory.other is not None and np.isfinite(c.theory.other):
        another = "Eqs. 44-49" if c.scene.methods.options("theory").energy == "old" else "Eq. 43"
        text += f", {significant(c.theory.other)} with the elastic energy of {another}"
    if c.theory.note:
        text += f" ({c.theory.note})"
    if c.limit is None:
        return [text + "; without a limit its distance to the simulation is not determinable."]
    difference = c.limit.value / c.theory.area - 1
    error = c.limit.uncertainty / c.theory.area
    if abs(difference) <= max(2 * error, 1e-9):
        return [
            text + ". The limit agrees with it to within twice its uncertainty "
            f"(difference {percent(difference)}, uncertainty {percent(error)})."
        ]
    return [text + f". The limit lies {_side(difference)} it (grid uncertainty {percent(error)})."]


def yielded_row(c: Comparison) -> tuple[Row, ...]:
    """Return the finest resolved row with a yielded area; none without a hardness."""
    rows = [row for row in c.rows if not row.under_resolved and row.plastic is not None]
    return (max(rows, key=lambda row: row.points_per_wave),) if rows else ()


def _yielded(c: Comparison) -> list[str]:
    found = yielded_row(c)
    if not found:
        return []
    (finest,) = found
    assert finest.plastic is not None
    text = f"Yielded, A_pl/A0 = {significant(finest.plastic)} by {_label(finest.method)} on {_grid(finest)} (points counted)"
    if c.theory is None or c.theory.plastic is None:
        return [text + "."]
    distance = ""
    if finest.plastic > 0:
        distance = f", {_side(c.theory.plastic / finest.plastic - 1)} it"
    return [text + f"; {significant(c.theory.plastic)} by the theory{distance}."]


def _passing(c: Comparison) -> list[str]:
    if not c.passing:
        missing = c.scene.quantities is not None and c.scene.quantities.passing
        return (
            ["What passes is not determinable: the points of every method weigh differently."]
            if missing
            else []
        )
    from validation.comparison.passing import sentences

    return list(sentences(c.passing))


def _mean(c: Comparison, reached: Mapping[str, Any]) -> str:
    """Say what the mean over all surfaces of the spectrum is, and how far from the theory."""
    mean, error = reached["mean"], reached["mean_error"]
    how = "located inside the cells" if reached["located"] else "corrected at its edge"
    text = (
        f"Over the surfaces of this spectrum the mean is A/A0 = {mean:.6g} +- {percent(error)} (95 %: surfaces, grid "
        f"and solver; of the limit of the area {how}), from {reached['surfaces']} solved in pairs h, -h; single ones scatter by "
        f"{percent(reached['scatter'])} (standard deviation)"
    )
    theory = c.theory_of_all
    if theory is None:
        return text + "."
    distance = mean / theory - 1
    told = "its interval does not reach" if abs(distance) > error * mean / theory else "its interval holds"
    return f"{text}; it lies {_side(distance)} the theory, which {told}."


def _scatter(c: Comparison) -> list[str]:
    if c.mean is not None:
        return [_mean(c, c.mean)]
    if c.scatter is None and c.scene.ensemble is not None:
        return ["The scatter between realisations is not determinable: not every one of them has a limit."]
    if c.scatter is None:
        return ["One surface proves little: without an ensemble the scatter between realisations is unknown."]
    s = c.scatter
    text = (
        f"Between {len(s.ratios)} realisations of the same spectrum the area scatters by {percent(s.relative)} "
        f"(standard deviation, of which the grids explain {percent(s.grid_error)})"
    )
    if c.theory is None or not c.theory.answers:
        return [text + "."]
    distance = s.mean_ratio - 1
    if s.mean_error == 0:
        return [text + f"; on average the area is {percent(distance)} from the theory."]
    weight = abs(distance) / s.mean_error
    verdict = (
        f"{weight:.0f} standard errors, so it is not an accident of one surface"
        if weight > 3
        else f"{weight:.1f} standard errors, so these surfaces cannot tell it from zero"
    )
    return [text + f"; their mean lies {_side(distance)} the theory (+- {percent(s.mean_error)}): {verdict}."]


def _grids(c: Comparison) -> list[str]:
    if c.limit is None:
        return []
    sentences = []
    for method in c.scene.methods.solvers:
        rows = [row for row in c.rows_of(method) if not row.under_resolved]
        if len(rows) < 2:
            continue
        first, last = rows[0], rows[-1]
        errors = [row.pixel / c.limit.value - 1 for row in (first, last)]
        corrected = first.perimeter / c.limit.value - 1
        if max(abs(error) for error in errors) < 1e-9:
            sentences.append(f"{_label(method)} counting gives the same area on every grid.")
            continue
        word = "overestimates" if errors[0] > 0 else "underestimates"
        sentences.append(
            f"Counting contact cells ({_label(method)}) {word} the limit by {percent(abs(errors[0]))} "
            f"on the {_grid(first)} grid (lambda_short/dx = {first.points_per_wave:.3g}) and is {_side(errors[1])} it "
            f"on {_grid(last)} (lambda_short/dx = {last.points_per_wave:.3g}); the perimeter correction leaves "
            f"{percent(corrected)} on {_grid(first)}."
        )
    return sentences


def _cross(c: Comparison) -> list[str]:
    first, *others = c.scene.methods.solvers
    sentences = []
    for method in others:
        checks = [check for check in c.cross if check.method == method]
        if checks:
            sentences.append(_difference(c, checks))
        elif c.rows_of(method) and c.rows_of(first):
            sentences.append(
                f"{_label(method)} and {_label(first)} share no grid, so their pressures are not compared point by point."
            )
    return sentences


def _difference(c: Comparison, checks: list[CrossCheck]) -> str:
    first, last = checks[0], checks[-1]
    text = (
        f"On the same surface and {last.grid[0]} x {last.grid[1]} grid the {_words(c, last.method)} and the "
        f"{_words(c, last.reference)} differ by {percent(last.pressure)} in pressure (relative L2) and {percent(last.pixel)} in pixel area"
    )
    if first is last:
        return text + "."
    if max(check.pressure for check in checks) < _SAME:
        return text + ", no more than their tolerances leave."
    pressure = _shrinks([check.pressure for check in checks], checks)
    area = _shrinks([abs(check.pixel) for check in checks], checks)
    return (
        text
        + f"; on {first.grid[0]} x {first.grid[1]} by {percent(first.pressure)} and {percent(first.pixel)}: "
        f"with refinement the difference in pressure {pressure} and that in area {area}."
    )


#: Relative difference in pressure of two solvers of one discrete problem, each to its tolerance.
_SAME = 1e-5


def _shrinks(differences: list[float], checks: list[CrossCheck]) -> str:
    """Say whether differences shrink with refinement, and like which power of dx where three grids tell."""
    if differences[-1] >= differences[0]:
        return "does not shrink"
    if len(checks) < 3:
        return "shrinks"
    spacing = np.log([1 / check.points_per_wave for check in checks])
    order = float(np.polyfit(spacing, np.log(differences), 1)[0])
    return f"shrinks like dx^{order:.2f} (fit over {len(checks)} grids)"


def _pressure_at_zero(c: Comparison) -> list[str]:
    if c.adhesive:
        # The pressure passes through zero inside the contact: no edge is at zero, and the density there is finite.
        return []
    rows = [
        row
        for row in c.rows_of(next(iter(c.scene.methods.solvers)))
        if not row.under_resolved
        and row.density_at_zero > 0
        and row.pixel * row.grid[0] * row.grid[1] >= LEAST_CONTACT_POINTS
    ]
    if len(rows) < 3:
        return []
    spacing = np.log([1 / row.points_per_wave for row in rows])
    order = float(np.polyfit(spacing, np.log([row.density_at_zero for row in rows]), 1)[0])
    if order <= 0.1:
        return [f"P(sigma) at sigma = 0 does not fall with refinement (observed exponent of dx {order:.2f})."]
    return [
        f"P(sigma) at sigma -> 0 falls with refinement like dx^{order:.2f} (fit over {len(rows)} grids; 0.5 is expected of an edge "
        "where p grows like the square root of the distance): the finite value on each grid belongs to the grid."
    ]


def _cost(c: Comparison) -> list[str]:
    if c.limit is None or c.limit.value >= 1 - 1e-12:
        return []
    ways = [
        (row.seconds, row, name, getattr(row, name) / c.limit.value - 1)
        for row in c.rows
        for name in ("pixel", "perimeter")
        if not row.under_resolved
    ]
    good = [way for way in ways if abs(way[3]) <= 0.01]
    if not good and c.accurate:
        return []
    if not good:
        return ["No solve of this run is within 1 % of the limit: refine the grids."]
    seconds, row, name, error = min(good, key=lambda way: way[0])
    return [
        f"The cheapest way to within 1 % of the limit was {_label(row.method)} on {_grid(row)} with the {name} area: {seconds:.2g} s "
        f"for {row.solves} solve{'s' if row.solves > 1 else ''}, error {percent(error)}."
    ]


def _warnings(c: Comparison) -> list[str]:
    sentences = []
    coarse = [row for row in c.rows if row.under_resolved]
    if coarse:
        names = ", ".join(f"{_label(row.method)} {_grid(row)}" for row in coarse)
        measured = c.scene.surface.kind == "file"
        why = (
            "the measured heights may hold waves down to two of their own samples, so that only finer grids resolve them"
            if measured
            else "run because the scene asks for it"
        )
        sentences.append(
            f"Under-resolved (lambda_short <= 2 dx) and left out of every limit: {names}; {why}."
        )
    if c.rms_gradient > 0.3:
        sentences.append(
            f"The gradient h'_rms = {c.rms_gradient:.3g} is not small; all methods here assume small slopes."
        )
    return sentences
