"""The findings of a run, read back: each sentence by its form, its numbers and turns from the fields."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from validation.audit.ledger import Ledger
from validation.audit.limits import Limit
from validation.audit.recomputed import Row, Run

__all__ = ["audit_sentences", "label_of", "with_error"]

_PLACE = "sentence"
_N = r"[-+]?[\d.]+(?:e[-+]?\d+)?"
_P = rf"(?:{_N} %|not determinable)"
_ERR = rf"(?:{_N} \+- {_N}|\({_N} \+- {_N}\)e[-+]\d+)"
_GRID = r"\d+ x \d+"


def label_of(method: str) -> str:
    """Return what texts call a method."""
    return method.upper() if method in ("bem", "fem") else method


Reader = Callable[[re.Match[str], Run, Ledger], None]


def audit_sentences(findings: list[str], run: Run, ledger: Ledger) -> None:
    """Read every sentence; one of a form that is not known is listed as unread."""
    for sentence in findings:
        for pattern, reader in _FORMS:
            match = re.fullmatch(pattern, sentence)
            if match is not None:
                reader(match, run, ledger)
                break
        else:
            ledger.unread.append(f"sentence of another form: {sentence}")
    for wanted, why in _expected(run):
        ledger.same(_PLACE, why, any(re.match(wanted, sentence) for sentence in findings), True)


def _expected(run: Run) -> Iterator[tuple[str, str]]:
    """Yield how sentences begin that a run must contain."""
    if run.own_limit is None:
        yield "The limit of the contact area", "says that there is no limit"
    if run.theory() is not None:
        yield "Persson's theory gives A/A0", "says what the theory gives"
    if any(row.under_resolved for row in run.rows):
        yield "Under-resolved", "names the under-resolved grids"
    if run.gradient is not None and run.gradient > 0.3:
        yield "The gradient", "warns of large slopes"
    for method in {found[0] for found in run.cross}:
        yield rf"On the same surface and .*{'finite' if method == 'fem' else ''}", f"compares {method}"


def with_error(ledger: Ledger, name: str, text: str, pair: tuple[float, float]) -> None:
    """Enter a number with its error, printed with as many decimals."""
    inner = re.fullmatch(rf"\(?({_N}) \+- ({_N}|unknown)\)?(e[-+]\d+)?", text)
    if inner is None:
        ledger.same(_PLACE, name, text, f"{pair[0]} +- {pair[1]}")
        return
    power = inner[3] or ""
    ledger.text(_PLACE, name, inner[1] + power, pair[0])
    ledger.text(_PLACE, f"error of {name}", inner[2] + power, pair[1], digits=None if pair[1] == 0 else 2)


def _side(value: float) -> str:
    return "above" if value > 0 else "below"


def _limit(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    limit, load = run.own_limit, run.reduced_pressure
    ledger.same(_PLACE, "there is a limit", True, limit is not None)
    if limit is None:
        return
    with_error(ledger, "A/A0 in the limit", found["limit"], (limit.value, limit.error))
    located = found["how"].startswith("area with the edge located")
    ledger.same(_PLACE, "area that was extrapolated", "subcell" if located else "perimeter", limit.definition)
    ledger.same(_PLACE, "solves of the limit", int(found["solves"]), limit.solves)
    if load is not None:
        with_error(ledger, "kappa of the limit", found["kappa"], (limit.value / load, limit.error / load))
        ledger.text(_PLACE, "p*", found["load"], load, 4)


def _no_limit(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    ledger.same(_PLACE, "there is a limit", False, run.own_limit is not None)


def _complete(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    value = math.nan if run.own_limit is None else run.own_limit.value
    ledger.number(_PLACE, "A/A0 of complete contact", 1.0, value, rtol=1e-12)


def _theory(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    theory, limit = run.theory(), run.own_limit
    if theory is None:
        ledger.unread.append("theory with effects, or of a measured surface")
        return
    ledger.text(_PLACE, "theory, A/A0 of this surface", found["area"], theory, 4)
    ledger.text(_PLACE, "theory, h'_rms", found["gradient"], run.gradient, 4)
    if found["alone"] is not None and run.ensemble_theory is not None:
        ledger.text(_PLACE, "theory, A/A0 from C(q) alone", found["alone"], run.ensemble_theory, 4)
    _distance(re.sub(r"^ \(Persson 2006[^()]*\)", "", found["rest"]), (theory, limit), ledger)


def _distance(rest: str, both: tuple[float, Limit | None], ledger: Ledger) -> None:
    """Judge how far the limit is said to be from the theory."""
    theory, limit = both
    if limit is None:
        ledger.same(_PLACE, "distance is not determinable", rest.startswith("; without a limit"), True)
        return
    difference, error = limit.value / theory - 1, limit.error / theory
    agrees = abs(difference) <= max(2 * error, 1e-9)
    name = "limit and theory agree within twice the uncertainty"
    ledger.same(_PLACE, name, rest.startswith(". The limit agrees"), agrees)
    if agrees:
        match = re.search(rf"difference (?P<d>{_P}), uncertainty (?P<e>{_P})", rest)
    else:
        match = re.search(
            rf"lies (?P<d>{_P}) (?P<side>above|below) it \(grid uncertainty (?P<e>{_P})\)", rest
        )
        difference = _entered_side(match, difference, ledger)
    if match is None:
        ledger.same(_PLACE, name, rest, "a distance")
        return
    ledger.text(_PLACE, "distance of the limit from the theory", match["d"], difference)
    ledger.text(_PLACE, "grid uncertainty over the theory", match["e"], error)


def _entered_side(match: re.Match[str] | None, difference: float, ledger: Ledger) -> float:
    if match is not None:
        ledger.same(_PLACE, "side of the theory", match["side"], _side(difference))
    return abs(difference)


def _alone(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    ledger.same(_PLACE, "there is no ensemble", "ensemble" not in run.scene, True)


def _mean(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    theory = run.theory()
    if found["distance"] is None or theory is None:
        return
    # The mean itself is of areas whose fields are not kept; accuracy.json is told so.
    distance = float(found["mean"]) / theory - 1
    ledger.text(_PLACE, "mean distance from the theory", found["distance"], abs(distance))
    ledger.same(_PLACE, "side of the mean", found["side"], _side(distance))
    half = float(found["error"].removesuffix("%")) / 100 * float(found["mean"]) / theory
    said = "does not reach" if abs(distance) > half else "holds"
    ledger.same(_PLACE, "whether the interval of the mean holds the theory", found["verdict"], said)


def _scatter(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    if run.scatter is None:
        ledger.same(_PLACE, "scatter is determinable", True, False)
        return
    _, ratios, grid = run.scatter
    n, mean = len(ratios), math.fsum(ratios) / len(ratios)
    deviation = math.sqrt(math.fsum((r - mean) ** 2 for r in ratios) / (n - 1))
    error = deviation / math.sqrt(n)
    ledger.same(_PLACE, "number of surfaces", int(found["n"]), n)
    ledger.text(_PLACE, "scatter between surfaces", found["relative"], deviation / mean)
    ledger.text(_PLACE, "scatter that grids explain", found["grid"], grid)
    if found["distance"] is None or run.theory() is None:
        return
    ledger.text(_PLACE, "mean distance from the theory", found["distance"], abs(mean - 1))
    ledger.same(_PLACE, "side of the mean", found["side"], _side(mean - 1))
    ledger.text(_PLACE, "standard error of the mean", found["error"], error)
    weight = abs(mean - 1) / error
    ledger.text(_PLACE, "standard errors from the theory", found["weight"], weight)
    ledger.same(_PLACE, "called no accident", "not an accident" in found["verdict"], weight > 3)


def _row(run: Run, label: str, grid: str) -> Row | None:
    for row in run.rows:
        if label_of(row.method) == label and f"{row.grid[0]} x {row.grid[1]}" == grid:
            return row
    return None


def _counting(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    first, last = _row(run, found["label"], found["g1"]), _row(run, found["label"], found["g2"])
    limit = run.own_limit
    own = [row for row in run.rows if label_of(row.method) == found["label"] and not row.under_resolved]
    ledger.same(_PLACE, "first and last resolved grid", (first, last), (own[0], own[-1]) if own else None)
    if first is None or last is None or limit is None:
        return
    name = f"counting by {found['label']}"
    errors = [row.pixel / limit.value - 1 for row in (first, last)]
    ledger.same(_PLACE, f"{name}, word", found["word"], "over" if errors[0] > 0 else "under")
    ledger.text(_PLACE, f"{name}, first grid", found["e1"], abs(errors[0]))
    ledger.text(_PLACE, f"{name}, last grid", found["e2"], abs(errors[1]))
    ledger.same(_PLACE, f"{name}, side", found["side"], _side(errors[1]))
    ledger.text(_PLACE, f"{name}, corrected", found["c"], first.perimeter / limit.value - 1)
    ledger.same(_PLACE, f"{name}, corrected on", found["g3"], found["g1"])
    if not run.measured:
        ledger.text(_PLACE, f"{name}, lambda_short/dx", found["w1"], first.points_per_wave, 3)
        ledger.text(_PLACE, f"{name}, lambda_short/dx of the last", found["w2"], last.points_per_wave, 3)


def _trend(group: str) -> str:
    """Pattern of what is said of a difference over grids: groups t, o (order), n (grids)."""
    fit = rf"(?: like dx\^(?P<o{group}>{_N}) \(fit over (?P<n{group}>\d+) grids\))?"
    return rf"(?P<t{group}>shrinks{fit}|does not shrink)"


def _cross(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    by = {f"{grid[0]} x {grid[1]}": values for _, grid, *values in run.cross}
    last = by.get(found["g1"])
    ledger.same(_PLACE, "compared on a shared grid", last is not None, True)
    if last is None:
        return
    ledger.text(_PLACE, f"difference in pressure on {found['g1']}", found["p1"], last[0])
    ledger.text(_PLACE, f"difference in pixel area on {found['g1']}", found["a1"], last[1])
    first = by.get(found["g2"] or "")
    if first is None:
        return
    ledger.text(_PLACE, f"difference in pressure on {found['g2']}", found["p2"], first[0])
    ledger.text(_PLACE, f"difference in pixel area on {found['g2']}", found["a2"], first[1])
    method = next(name for name, grid, *_ in run.cross if f"{grid[0]} x {grid[1]}" == found["g1"])
    checks = [check for check in run.cross if check[0] == method]
    pressures, areas = [check[2] for check in checks], [abs(check[3]) for check in checks]
    for name, group, sizes in (("pressure", "1", pressures), ("area", "2", areas)):
        shrinks = sizes[-1] < sizes[0]
        said = found[f"t{group}"].startswith("shrinks")
        ledger.same(_PLACE, f"difference in {name} shrinks", said, shrinks)
        if found[f"o{group}"] is None:
            continue
        order = _slope([1 / check[1][0] for check in checks], sizes)
        ledger.text(_PLACE, f"order in dx of the difference in {name}", found[f"o{group}"], order)
        ledger.same(_PLACE, f"grids of the difference in {name}", int(found[f"n{group}"]), len(checks))


def _slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of ln y over ln x by least squares."""
    u, v = np.log(x), np.log(y)
    return float(np.sum((u - u.mean()) * (v - v.mean())) / np.sum((u - u.mean()) ** 2))


def _at_zero(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    rows = [
        row
        for row in run.rows
        if row.method == run.methods[0]
        and not row.under_resolved
        and row.density_at_zero > 0
        and row.pixel * row.grid[0] * row.grid[1] >= 16
    ]
    if run.measured:
        ledger.unread.append("order of P(0+) of a measured surface")
        return
    slope = _slope([1 / row.points_per_wave for row in rows], [row.density_at_zero for row in rows])
    ledger.text(_PLACE, "order of P(0+) in dx", found["order"], slope)
    ledger.same(_PLACE, "P(0+) falls with refinement", "does not fall" not in found[0], slope > 0.1)
    if "grids" in found.groupdict():
        ledger.same(_PLACE, "grids of P(0+)", int(found["grids"]), len(rows))


def _cheapest(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    limit = run.own_limit
    if limit is None:
        ledger.same(_PLACE, "there is a limit", True, False)
        return
    ways = [
        (row.seconds, row, name, getattr(row, name) / limit.value - 1)
        for row in run.rows
        for name in ("pixel", "perimeter")
        if not row.under_resolved
    ]
    good = [way for way in ways if abs(way[3]) <= 0.01]
    row = _row(run, found["label"], found["grid"])
    if not good:
        ledger.same(_PLACE, "a solve within 1 % of the limit", True, False)
        return
    seconds, best, area, error = min(good, key=lambda way: way[0])
    ledger.same(_PLACE, "cheapest way within 1 %", (row, found["area"]), (best, area))
    ledger.text(_PLACE, "seconds of the cheapest way", found["seconds"], seconds, 2)
    ledger.same(_PLACE, "solves of the cheapest way", int(found["n"]), best.solves)
    ledger.text(_PLACE, "error of the cheapest way", found["error"], error)


def _none_cheap(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    limit = run.own_limit
    if limit is not None:
        errors = [
            getattr(r, n) / limit.value - 1
            for r in run.rows
            for n in ("pixel", "perimeter")
            if not r.under_resolved
        ]
        ledger.same(_PLACE, "a solve within 1 % of the limit", False, min(map(abs, errors)) <= 0.01)


def _coarse(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    names = [f"{label_of(r.method)} {r.grid[0]} x {r.grid[1]}" for r in run.rows if r.under_resolved]
    if not run.measured:
        ledger.same(_PLACE, "under-resolved grids", found["names"].split(", "), names)


def _steep(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    if run.gradient is not None:
        ledger.same(_PLACE, "slopes are large", True, run.gradient > 0.3)
        ledger.text(_PLACE, "large gradient", found["gradient"], run.gradient, 3)


def _no_number(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    """Nothing to recompute."""


def _yielded(found: re.Match[str], run: Run, ledger: Ledger) -> None:
    row = _row(run, found["label"], found["grid"])
    ledger.text(_PLACE, "A_pl/A0", found["area"], None if row is None else row.plastic, 4)
    theory = run.yielded_theory
    if found["rest"] == ".":
        ledger.same(_PLACE, "there is no theory of what yields", theory is None, True)
        return
    said = re.fullmatch(
        rf"; (?P<area>{_N}) by the theory(?:, (?P<off>{_P}) (?P<side>above|below) it)?\.", found["rest"]
    )
    if theory is None or said is None:
        ledger.unread.append("A_pl/A0 by the theory, with several effects")
        return
    ledger.text(_PLACE, "A_pl/A0 by the theory", said["area"], theory, 4)
    if row is not None and row.plastic and said["off"] is not None:
        ledger.text(_PLACE, "theory of what yields against it", said["off"], abs(theory / row.plastic - 1))
        ledger.same(_PLACE, "side of the theory of what yields", said["side"], _side(theory - row.plastic))


_FORMS: tuple[tuple[str, Reader], ...] = (
    (
        rf"In the limit of vanishing grid spacing A/A0 = (?P<limit>{_ERR}|{_N} \+- \w+) for this surface "
        rf"\((?P<how>.+), (?P<solves>\d+) solves; one standard error, grid only\), that is "
        rf"kappa = (?P<kappa>{_ERR}|{_N} \+- \w+) at p\* = (?P<load>{_N})\.",
        _limit,
    ),
    (r"The limit of the contact area for vanishing grid spacing is not determinable: .*", _no_limit),
    (r"Contact is complete: A/A0 = 1 on the resolved grids, .*", _complete),
    (
        rf"Persson's theory gives A/A0 = (?P<area>{_N}) with the realised gradient "
        rf"h'_rms = (?P<gradient>{_N}) of this surface(?:, (?P<alone>{_N}) from C\(q\) alone)?(?P<rest>.*)",
        _theory,
    ),
    (r"One surface proves little: .*", _alone),
    (
        rf"Over the surfaces of this spectrum the mean is A/A0 = (?P<mean>{_N}) \+- (?P<error>{_P}) "
        rf"\(95 %: [^)]*\), from \d+ solved in pairs h, -h; single ones scatter by {_P} "
        rf"\(standard deviation\)"
        rf"(?:\.|; it lies (?P<distance>{_P}) (?P<side>above|below) the theory, which its interval "
        rf"(?P<verdict>does not reach|holds)\.)",
        _mean,
    ),
    (
        rf"Between (?P<n>\d+) realisations of the same spectrum the area scatters by (?P<relative>{_P}) "
        rf"\(standard deviation, of which the grids explain (?P<grid>{_P})\)(?:\.|; their mean lies "
        rf"(?P<distance>{_P}) (?P<side>above|below) the theory \(\+- (?P<error>{_P})\): (?P<weight>{_N}) "
        rf"standard errors, (?P<verdict>.*))",
        _scatter,
    ),
    (
        rf"Counting contact cells \((?P<label>\w+)\) (?P<word>over|under)estimates the limit by (?P<e1>{_P}) "
        rf"on the (?P<g1>{_GRID}) grid \(lambda_short/dx = (?P<w1>{_N})\) and is (?P<e2>{_P}) "
        rf"(?P<side>above|below) it on (?P<g2>{_GRID}) \(lambda_short/dx = (?P<w2>{_N})\); the perimeter "
        rf"correction leaves (?P<c>{_P}) on (?P<g3>{_GRID})\.",
        _counting,
    ),
    (
        rf"On the same surface and (?P<g1>{_GRID}) grid the .+ and the .+ differ by (?P<p1>{_P}) in pressure "
        rf"\(relative L2\) and (?P<a1>{_P}) in pixel area"
        rf"(?:\.|, no more than their tolerances leave\.|; on (?P<g2>{_GRID}) by (?P<p2>{_P}) and "
        rf"(?P<a2>{_P}): with refinement the difference in pressure "
        + _trend("1")
        + " and that in area "
        + _trend("2")
        + r"\.)",
        _cross,
    ),
    (
        rf"P\(sigma\) at sigma -> 0 falls with refinement like dx\^(?P<order>{_N}) \(fit over (?P<grids>\d+) "
        r"grids; .*",
        _at_zero,
    ),
    (
        r"P\(sigma\) at sigma = 0 does not fall with refinement "
        rf"\(observed exponent of dx (?P<order>{_N})\)\.",
        _at_zero,
    ),
    (
        rf"The cheapest way to within 1 % of the limit was (?P<label>\w+) on (?P<grid>{_GRID}) with the "
        rf"(?P<area>\w+) area: (?P<seconds>{_N}) s for (?P<n>\d+) solves?, error (?P<error>{_P})\.",
        _cheapest,
    ),
    (r"No solve of this run is within 1 % of the limit: .*", _none_cheap),
    (r"Under-resolved \(lambda_short <= 2 dx\) and left out of every limit: (?P<names>[^;]+); .*", _coarse),
    (rf"The gradient h'_rms = (?P<gradient>{_N}) is not small; .*", _steep),
    (
        rf"Yielded, A_pl/A0 = (?P<area>{_N}) by (?P<label>\w+) on (?P<grid>{_GRID}) \(points counted\)"
        r"(?P<rest>.*)",
        _yielded,
    ),
    (r"\w+ and \w+ share no grid, .*", _no_number),
    (r"\w+ counting gives the same area on every grid\.", _no_number),
    (r"The scatter between realisations is not determinable: .*", _no_number),
)
