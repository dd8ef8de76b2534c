"""What is shown of a sweep: area, kappa and what has yielded along every swept key, beside the theory."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from validation.arrays import Array
from validation.comparison.run_views import HOW_FAR, HOW_LARGE, ends, how_sure
from validation.comparison.treatment import treatment_findings, treatment_table
from validation.report.estimates import claim_surfaces, derive, mean, power_law, ratio_of_means
from validation.report.findings import Finding, finding, note
from validation.report.quantities import in_shown_range, place_words, quantity_of
from validation.report.views import Band, Card, Column, Figure, Line, Table, Views, against
from validation.solvers import find_method

#: Lines of a figure that can be told apart.
_MOST_LINES = 4
#: Spans of a key and of a result from which on their axes are logarithmic.
_WIDE_X, _WIDE_Y = 3.0, 10.0


def sweep_views(data: xr.Dataset) -> Views:
    """Return what is shown of the dataset of a sweep."""
    keys = _keys(data)
    answer = _answer(data)
    methods = range(data.sizes.get("solver", 0))
    names = "area_perimeter_finest", "area_pixel_finest", "grid_finest"
    return Views(
        table=Table(
            _over(data),
            (
                *keys,
                answer,
                *(("area_own",) if _several(data) else ()),
                "kappa" if answer == "area" else "kappa_ensemble",
                *("area_persson", "area_ratio", "scatter"),
                *(Column("area_plastic_pixel_finest", {"solver": k}) for k in methods),
                *("area_plastic_persson", "area_plastic_ensemble"),
                *(("area_ensemble",) if answer == "area" else ()),
                *(Column(name, {"solver": k}) for k in methods for name in names),
                *("reduced_pressure", "pressure", "electrical_conductance", "thermal_conductance"),
                *("leak_rate_x", "leak_rate_y", "failures"),
            ),
            title="Every case",
            note="A/A0: the mean over the surfaces of an ensemble, else that of one surface; of the "
            "methods on the finest grid that resolves it.",
        ),
        more=tuple(treatment_table(data, *_over(data))),
        budget=(answer,),
        figures=tuple(_figures(data)),
        findings=tuple(_findings(data)),
        cards=tuple(_cards(data)),
    )


def _keys(data: xr.Dataset) -> list[str]:
    return str(data.attrs["keys"]).split()


def _over(data: xr.Dataset) -> tuple[str, ...]:
    return ("case",) if data.attrs["mode"] == "zip" else tuple(_keys(data))


def _answer(data: xr.Dataset) -> str:
    return "area" if "area" in data else "area_ensemble"


def _several(data: xr.Dataset) -> bool:
    return "surfaces" in data and bool((data.surfaces > 1).any())


def _known(data: xr.Dataset, name: str) -> bool:
    return name in data and bool(data[name].notnull().any())


def _numeric(data: xr.Dataset, key: str) -> bool:
    return data[key].dtype.kind in "fiu"


def _varying(data: xr.Dataset) -> list[str]:
    return [key for key in _keys(data) if len(set(data[key].values.tolist())) > 1]


def _cards(data: xr.Dataset) -> Iterator[Card]:
    area = data[_answer(data)]
    if not area.notnull().any():
        return
    basis = "theory alone, from C(q)"
    if "area" in data:
        count = f"{float(data.surfaces.max()):.0f}"
        basis = f"means over {count} surfaces of each spectrum" if _several(data) else "one surface"
    yield Card(HOW_LARGE, in_shown_range(area), basis)
    if "area" in data and (data.area_error > 0).any():
        yield Card("How sure?", *how_sure(data, *_over(data)))
    if "scatter" in data and _several(data):
        what, scatter = "standard deviation of one over their mean", "{low:.2%}[ to {high:.2%}]"
        yield Card("How far is one surface from another?", ends(scatter, data.scatter), what)
    if _known(data, "area_excess"):
        answer = ends("{low:+.3%}[ to {high:+.3%}]", data.area_excess)
        yield Card(HOW_FAR, answer, "area over the theory with the realised gradient, less one")


def _findings(data: xr.Dataset) -> Iterator[Finding]:
    if "failures" in data:
        why = list(filter(None, data.failures.values.ravel().tolist()))
        count = {"failed": float(len(why)), "cases": float(data.failures.size)}
        words = "; ".join(dict.fromkeys(why))
        yield note("In {failed} of {cases} cases solves failed: {why}.", why=words, **count)
    for key in _varying(data):
        yield from _along(data, key)
    if _known(data, "area_excess"):
        excess = data.area_excess
        errors = data.area_excess_error.sel(source=["surfaces", "grid", "solver"])
        half = (errors**2).sum("source", min_count=1) ** 0.5
        judged = float((excess.notnull() & half.notnull()).sum())
        agree = float((abs(excess) <= half).sum()) if judged else math.nan
        form = "The area is {low:+.3%}[ to {high:+.3%}] from Persson's theory[; in {agree} of {count} cases "
        form += "with an interval the two agree within it]."
        yield ends(form, excess, agree=agree, count=judged)
    yield from treatment_findings(data)
    if "no_limit" in data and (why := list(filter(None, data.no_limit.values.ravel().tolist()))):
        count = {"missing": float(len(why)), "cases": float(data.no_limit.size)}
        yield note("In {missing} of {cases} cases the grids tell no limit: {why}.", why=why[0], **count)
    if "area" in data and not _several(data) and not any(_is_seed(data, key) for key in _keys(data)):
        yield note("Every case is one surface: the scatter between surfaces is unknown.")
    if any(data[key].attrs["key"] == "surface.hurst" for key in _varying(data)):
        yield note("Several surfaces for each H, with pairs h and -h and a budget: fem-contact study hurst.")
    moduli = data.contact_modulus, data.get("surface_modulus", data.contact_modulus)
    if not np.allclose(*moduli, rtol=1e-9, equal_nan=True):
        below = "p* and kappa stand on E* of the solid below the coating"
        yield note(f"{below}: they are no numbers of a homogeneous solid.")
    if data.attrs.get("solves"):
        cases, solves, asked = (float(data.attrs[name]) for name in ("cases", "solves", "asked"))
        form = "Cases: {cases}; solves: {solves}"
        form += "[; {shared} more were asked for by several cases and done once]."
        yield finding("cost", form, cases=cases, solves=solves, shared=asked - solves or math.nan)


def _is_seed(data: xr.Dataset, key: str) -> bool:
    return str(data[key].attrs["key"]) == "surface.seed"


def _along(data: xr.Dataset, key: str) -> Iterator[Finding]:
    """Say how the area changes from the first to the last value of a key, the others in the middle."""
    name = _answer(data)
    here, places = data, []
    for other in _over(data):
        if other not in (key, "case"):
            here = here.isel({other: here.sizes[other] // 2})
            places.append(place_words(here, other, here))
    fixed = f" (at {', '.join(places)})" if places else ""
    dim = str(here[key].dims[0])
    if _is_seed(data, key) and _several(data):
        yield note("Ensembles of neighbouring seeds share surfaces: they are no samples of each other.")
        return
    if _is_seed(data, key) and name == "area":
        areas = here.area.rename({dim: "surface"}).drop_vars(key, errors="ignore")
        over = mean(xr.Dataset({"area_each": areas}), "area")
        text = f"Over {{count}} surfaces{fixed} the mean is A/A0 = {{area}}; single ones scatter by "
        text += "{scatter:.2%}."
        scatter = float(areas.std(ddof=1) / areas.mean())
        yield finding("value", text, over, count=float(here.sizes[dim]), scatter=scatter)
        return
    ordered = here.sortby(key) if _numeric(data, key) else here
    known = ordered.isel({dim: np.flatnonzero(ordered[name].notnull().values)})
    if known.sizes[dim] < 2:
        return
    yield from _power(known, name, key, dim)
    parts = {
        f"{name}_{end}{of}": known[f"{name}{of}"].isel({dim: k}, drop=True).reset_coords(drop=True)
        for end, k in (("start", 0), ("end", -1))
        for of in ("", "_error", "_each")
        if f"{name}{of}" in known
    }
    pair = derive(xr.Dataset(parts), change=f"{name}_end / {name}_start - 1")
    if "surface" in pair.dims:
        ratio = ratio_of_means(f"{name}_end_each", f"{name}_start_each", "surface")
        pair = derive(pair, change_each=ratio)
        pair = claim_surfaces(pair, "change", "change_each", of=known[name].attrs)
    if dim == "case":
        known = xr.Dataset(coords={key: ("case", known[key].values, known[key].attrs)})
    first, last = (place_words(known.isel({dim: k}), dim, known) for k in (0, -1))
    where = f"From {first} to {last}{fixed} A/A0 "
    if name == "area_ensemble":
        form = where + f"by the theory goes from {{{name}_start:.4}} to {{{name}_end:.4}}."
        yield finding("value", form, pair)
        return
    form = where + f"{{verdict}} from {{{name}_start}} to {{{name}_end}}, by {{change:+%}}."
    words = {"0": "does not change by more than its interval,"}
    words |= {"?": "goes, by an interval that is not known,"}
    yield finding("trend", form, pair, by="change", words=words)


def _power(known: xr.Dataset, name: str, key: str, dim: str) -> Iterator[Finding]:
    """Say with which power of a scale the area goes, where four values or more tell its interval."""
    scaled = _numeric(known, key) and not quantity_of(known, key).linear and not _is_seed(known, key)
    if scaled and known.sizes[dim] > 3 and (known[key] > 0).all():
        law = power_law(known, "exponent", of=name, x=key, along=[dim])
        words = {"+": "rises as a power of", "-": "falls as a power of"}
        words |= {"0": "goes as no power that its interval supports of"}
        words |= {"?": "goes as a power, of an interval that is not known, of"}
        symbol = quantity_of(known, key).symbol
        form = f"In the mean A/A0 {{verdict}} {symbol}, with the exponent {{exponent}}."
        yield finding("trend", form, law, by="exponent", words=words)


def _figures(data: xr.Dataset) -> Iterator[Figure]:
    answer = _answer(data)
    kappa = "kappa" if answer == "area" else "kappa_ensemble"
    yielded = ("area_plastic_pixel_finest", "area_plastic_persson", "area_plastic_ensemble")
    drawn = {
        "area": ("Contact area", (answer, "area_persson")),
        "kappa": ("Contact area over reduced load", (kappa, "kappa_persson")),
        "plastic": ("Yielded area, points counted", yielded),
    }
    for key, (name, (words, listed)) in itertools.product(_varying(data), drawn.items()):
        if variables := [v for v in listed if _known(data, v)]:
            yield _figure(data, key, variables, name=name, words=words)


def _figure(data: xr.Dataset, key: str, variables: Sequence[str], *, name: str, words: str) -> Figure:
    others = [other for other in _over(data) if other not in (key, "case") and data.sizes[other] > 1]
    at: dict[str, int] = {other: data.sizes[other] // 2 for other in others[1:]}
    marks: list[Line | Band] = []
    along, surfaces = next(iter(others), ""), "mean over surfaces" if _several(data) else "one surface"
    count = data.sizes[along] if along else 1
    shown = np.unique(np.linspace(0, count - 1, min(count, _MOST_LINES)).round().astype(int))
    joined = not _numeric(data, key) or bool(np.all(np.diff(data[key].values) > 0))
    if name == "area" and "area_lowest" in data and not along:
        marks.append(Band("area_lowest", high="area_highest", label="single surfaces", at=at))
    for n, k in enumerate(shown):
        here = {along: int(k)} if along else {}
        where = place_words(data.isel(here), along, data) if along else ""
        for variable in variables:
            # The theory's, or a method's, and of how many surfaces.
            whose = quantity_of(data, variable).which
            if not whose and "solver" in data.coords:
                whose = f"{find_method(str(data.solver.values[0])).label}, {surfaces}"
            look = {"color": f"C{n}"} if along else {}
            label = ", ".join(filter(None, (whose.removesuffix(", finest"), where)))
            place = {**at, **here, "solver": 0}
            marks.append(Line(variable, at=place, look=look, label=label, joined=joined))
    fixed = "".join(f", {place_words(data.isel({other: k}), other, data)}" for other, k in at.items())
    one = "" if _several(data) or "area" not in data else " One surface."
    scaled = _numeric(data, key) and not quantity_of(data, key).linear
    log = "x" * (scaled and _spans(data[key].values, _WIDE_X))
    log += "y" * _spans(np.concatenate([data[v].values.ravel() for v in variables]), _WIDE_Y)
    caption = f"{words} against {quantity_of(data, key).words}{fixed}.{one}"
    panel = against(key, *marks, y=variables[0], log=log)
    return Figure(f"{name}-against-{key.replace('_', '-')}", caption, [panel])


def _spans(values: Array, least: float) -> bool:
    """Whether numbers span enough for a logarithmic axis."""
    return bool(np.nanmin(values) > 0 and np.nanmax(values) >= least * np.nanmin(values))
