"""How good is Persson's theory, quantity by quantity and range by range, and are its variants better?"""

import numpy as np
import xarray as xr

from validation.measurements.convergence import Ladders, spectral_errors
from validation.measurements.limits import moved_shares
from validation.measurements.measurement import TOLERANCE, TOLERANCES_LEFT
from validation.measurements.statistics import kolmogorov_smirnov
from validation.measurements.theory import RANKED, modes_finding
from validation.report.estimates import claim_shares
from validation.report.views import Figure, Findings, Table, Views, against
from validation.studies import pressure
from validation.studies._study import Bench, solved
from validation.theories import find_theory
from validation.theories.persson_variants import persson_variants
from validation.theories.predicted import COMPARED, NEARLY_FULL, beside, distances, ranked, stress_shares
from validation.units import Positive


class Options(pressure.Options):
    """Those of the study `pressure`, and what else is scored."""

    off = ("ladder_reduced_pressures",)

    ladder_reduced_pressures: tuple[Positive, ...] = (0.05, 0.4)
    """p* at which it is measured how the area moves with bandwidth and sample, for the budget; none to
    leave it out"""
    theory: tuple[str, ...] = ()
    """further theories: bush-gibson-thomas, carbone-bottiglione, greenwood-williamson, or your own,
    my_module:area"""


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Score the theory and its variants on the cases of the study `pressure`.

    That of `pressure.measured_path` beside the theories: simulated over predicted values, told the realised
    surfaces, over (theory, load), their mean distances from 1, and ``stress_distance`` of P(sigma).
    """
    # What is unknown is refused before anything is solved.
    theories = (*persson_variants(), *map(find_theory, options.theory))
    data = pressure.measured_path(options, bench=bench)
    solver = TOLERANCES_LEFT * options.tolerance(TOLERANCE)
    data = claim_shares(data, "area", solver=solver, **_spectral_shares(options, bench))
    data = distances(beside(data, theories, options.pressed))
    pooled = data.stress_share_each.sum("surface").values
    predicted = (stress_shares(theory, options.first, options.reduced_pressures) for theory in theories)
    distant = [kolmogorov_smirnov(pooled, shares) for shares in predicted]
    made = {"reduction": "distance", "of": "stress_share_each"}
    data = moved_shares(data).assign(stress_distance=(("theory", "load"), np.array(distant), made))
    return data.assign_attrs(methods=RANKED)


def _spectral_shares(options: Options, bench: Bench) -> dict[str, xr.DataArray]:
    loads = np.array(options.ladder_reduced_pressures)
    if not loads.size:
        return {}
    shares = []
    for load in loads:
        surfaces = options.model_dump(include={"periods", "seed"})
        ladders = Ladders(hursts=(options.hurst,), reduced_pressure=load, **surfaces)
        reduced = ladders.reduced(solved(bench, ladders.cases))
        spectrum = options.model_dump(include={"hurst", "bandwidth", "periods"})
        shares.append(spectral_errors(reduced, **spectrum))
    near = np.abs(np.log(np.divide.outer(np.array(options.reduced_pressures), loads))).argmin(axis=1)
    return {
        source: xr.DataArray([float(shares[k][source]) for k in near], dims="load")
        for source in ("size", "bandwidth")
    }


def views(data: xr.Dataset) -> Views:
    """Show simulated over predicted values of every theory."""
    columns = ("theory", "reduced_pressure", "area", *(f"{name}_over" for name in COMPARED))
    panels = [
        against("area", *pressure.by_theory("_over", data, name), pressure.AGREEMENT, log="xy")
        for name in COMPARED
    ]
    return Views(
        table=Table(("theory", "load"), (*columns, "stress_distance")),
        budget=("area",),
        figures=[
            Figure(
                "theory-verdict",
                "Simulated over predicted contact area, mean gap, compliance and elastic energy for the theory "
                "and its variants, told the realised surface; 1 is agreement.",
                panels,
            )
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    for name in COMPARED:
        yield ranked(
            f"{pressure.TITLES[name]}, mean |ln| of simulated over predicted values where A/A0 < {NEARLY_FULL}, at "
            f"lambda_long/lambda_short = {data.attrs['bandwidth']:.4g}: {{order}}.",
            data,
            name,
        )
    yield modes_finding(data)
