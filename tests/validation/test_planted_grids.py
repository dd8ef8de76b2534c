"""Dependence on the grid that is known in every study: limits, their intervals, and where findings turn."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from gold.asked import STUDIES
from gold.make import options_of
from numpy.testing import assert_allclose
from planted import located

from validation.audit import from_solves
from validation.measurements import limits
from validation.measurements.measurement import areas_of_solve
from validation.report.estimates import NORMAL, SOURCES, claim
from validation.studies import find_study

#: A/A0, mean gap over h_rms and energy over that of full contact, of every surface at every load.
AREA, GAP, ENERGY = 0.2, 0.5, 0.25
#: Standard deviations of the law of located areas, by the power of h beyond the first, at a width of 1.
LAW = {0.0: 0.00011, 1.0: 0.0003, 1.5: 0.00055, 2.0: 0.00015, 3.0: 0.00025}
#: Those that find nothing by an interval are not asked where they take long.
ASKED = [name for name in STUDIES if " " not in name and name not in ("accuracy-cost", "reference")]
#: Studies with limits over grids whose solves keep areas, gaps, energies or fields.
LIMITED = [n for n in ASKED if n.split()[0] in {"area", "energy", "hurst", "magnification", "pressure"}]
LIMITED += [n for n in ASKED if n.split()[0] in {"refinement", "theory-verdict"}]
#: Its solves keep another area on each level of a spectrum.
NOT_PLANTED = ("autopsy",)


class Planted:
    """A bench whose solves return known numbers on grids of spacing h, 1 on the finest.

    Areas A (1 + c_1 h + c_2 h^2 + ...), of `size` in intervals of the law of their errors; mean gap and
    energy a (1 + size h^2).
    """

    plan_only = False

    def __init__(self, bench, size):
        self.bench, self.size = bench, size
        self.found = []  # limit and half width of each solve at each load, by the independent reader

    def solve(self, solves, **how):
        return {solve: self.planted(result) for solve, result in self.bench.solve(solves, **how).items()}

    def planted(self, result):
        if not isinstance(result, xr.Dataset) or not {"subcell", "grid"} <= {*result.variables, *result.dims}:
            return result
        h, edges = result.points[-1] / result.points, result.edge_fraction.mean("shift")
        finest, whole = edges.isel(grid=-1), xr.zeros_like(result.subcell)
        width = finest / (AREA * (1 - AREA) ** 1.25)
        # Independent terms that together reach the end of the interval; of many patches deviations are .8 of
        # the usual.
        terms = sum(0.8 * deviation * finest * h * (width * h) ** power for power, deviation in LAW.items())
        area = AREA + self.size * NORMAL / len(LAW) ** 0.5 * terms + whole
        grown = 1 + self.size * h**2 + whole
        planted = {
            "perimeter": area,
            "subcell": xr.apply_ufunc(located, area, edges + whole, vectorize=True),
            "mean_gap": GAP * result.attrs.get("rms_height", np.nan) * grown,
            "energy": ENERGY * result.attrs.get("full_contact_energy", np.nan) * grown,
        }
        there = {name: value for name, value in planted.items() if name in result}
        made = result.assign({n: v.transpose(*result[n].dims).variable for n, v in there.items()})
        self.found += [(value, NORMAL * error) for value, error in from_solves.limits(made)]
        return made

    def areas(self, solve, result):
        """Areas on every grid alike of a contact whose fields come back."""
        areas = areas_of_solve(solve, result)
        subcell = None if areas.subcell is None else located(AREA, areas.edge_fraction)
        return replace(areas, perimeter=AREA, subcell=subcell)


def limits_of(data, law, *of):
    return [
        (variable, data[f"{name}_error"].sel(source="grid"))
        for name, variable in data.data_vars.items()
        if (variable.attrs.get("reduction"), variable.attrs.get("of")) in {(law, one) for one in of}
        and str(name).endswith("_each")
    ]


@pytest.mark.parametrize(("size", "name"), [*((0.9, n) for n in LIMITED), (0.0, "area"), (0.0, "refinement")])
def test_limits_and_their_intervals_are_what_was_planted(size, name, bench, tmp_path, monkeypatch):
    planted = Planted(bench, size)
    monkeypatch.setattr(limits, "areas_of_solve", planted.areas)
    study, options, _ = options_of(name, tmp_path)
    data = study.compute(options, bench=planted)
    for limit, _ in limits_of(data, "limit", "fields"):
        assert_allclose(limit, AREA, rtol=1e-9)
    for limit, half in limits_of(data, "limit", "subcell"):
        # Complete contact has no edges, and what is planted there is on no law.
        off = abs(limit - AREA).where(half > 0, 0.0)
        assert np.all(off <= (half.fillna(0.0) if size else 1e-9 * AREA)), limit.name
        pairs = np.array(planted.found)
        for pair in np.column_stack([limit.values.ravel(), half.values.ravel()]):
            assert np.isnan(pair).any() or np.isclose(pairs, pair, rtol=1e-6).all(axis=1).any(), limit.name
    drifts = [drift for drift in data.data_vars.values() if drift.attrs.get("reduction") == "drift"]
    assert size or all(np.all(abs(drift.fillna(0.0)) < 1e-9 * AREA) for drift in drifts)
    for base, of in ((GAP, "mean_gap"), (ENERGY, "energy")):
        for limit, half in limits_of(data, "second-order limit", of):
            assert_allclose(limit, base, rtol=1e-9)
            assert_allclose(half, NORMAL * base * abs(size), rtol=1e-9, atol=1e-12)


#: Outcomes by kind, of a half width below and above what decides: that of a value above 0, and below.
TURNS = dict.fromkeys(("comparison", "trend"), (("+", "-"), "0")) | {"agreement": (("differ",) * 2, "agree")}


@pytest.mark.parametrize("name", ASKED)
def test_what_is_found_turns_where_the_share_of_the_grids_reaches_it(name, numbers):
    study, data = find_study(name.partition(" ")[0]), numbers(name)
    every = limits_of(data, "limit", "subcell", "fields") + limits_of(data, "second-order limit", "mean_gap")
    assert bool(every) is (name in LIMITED) or name in NOT_PLANTED
    found = [one for one in study.views(data).findings if f"{one.by}_error" in data]
    assert {one.kind for one in found if one.outcomes} <= {*TURNS, "equivalence"}
    for part in (0.9, 1.1):
        moved = data
        for by, kind in {one.by: one.kind for one in found if one.outcomes}.items():
            far = abs(data[by]) if kind != "equivalence" else abs(1 - abs(data[by]))
            others = dict.fromkeys(set(SOURCES) - {"grid"}, 0.0)
            moved = claim(moved, by, grid=part * far, **others)
        for one in study.views(moved).findings:
            if one.by not in {one.by for one in found}:
                continue
            values = [row[one.by] for row in ([one.values] if one.by in one.values else one.rows)]
            for value, outcome in zip(values, one.outcomes, strict=True):
                if not np.isfinite(value.value) or value.value == 0:
                    continue
                if one.kind == "equivalence":
                    beyond = "beyond" if abs(value.value) > 1 else "within"
                    assert outcome == (beyond if part < 1 else "undecided"), (one.by, part)
                else:
                    signs, none = TURNS[one.kind]
                    assert outcome == (signs[value.value < 0] if part < 1 else none), (one.by, part)
