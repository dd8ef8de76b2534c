"""Does the gap percolate, how wide is it, and how much leaks through it?

Surfaces are pressed to given contact areas, and to the areas at which the contact begins and the gap ceases to percolate.
Reynolds' equation is solved in the gap, along x and along y, beside Bruggeman's effective medium and the narrowest place
of the widest path; the distribution of gaps stands beside the theory's.
"""

from typing import Annotated

import xarray as xr
from pydantic import AfterValidator, Field

from persson.percolation import SITE_THRESHOLD
from validation.measurements.common import Rising, base_case, in_rising_order
from validation.measurements.flow import GAP_THEORIES, NARROW, flow_of, leaks
from validation.measurements.measurement import grid_for
from validation.report.estimates import claim, derive, mean, same_of_all
from validation.report.places import spread
from validation.report.views import (
    Figure,
    Findings,
    Level,
    Line,
    Table,
    Views,
    against,
    finding,
    panels_along,
)
from validation.studies._options import Periods, SurfaceOptions, Surfaces
from validation.studies._study import ABSENT, Bench, gathered

#: A/A0 of the tire rim as the paper prints it (Sec. 8.3), which it compares with its threshold.
_RIM = 0.44

#: Areas whose distributions of gaps are drawn, at most.
_DRAWN = 4


class Options(SurfaceOptions):
    """What is pressed, and how far."""

    why_no_scene = "it asks about spectra of rising bandwidth, and makes a surface for each"

    areas: Annotated[
        tuple[Annotated[float, Field(gt=0, lt=0.9)], ...],
        Field(min_length=1, max_length=20),
        AfterValidator(in_rising_order),
    ] = (0.1, 0.2, 0.3, 0.4)
    """contact areas A/A0 at which the flow is computed, rising, below 0.9"""
    periods: Periods = 2.0
    bandwidths: Rising = (4.0, 8.0, 16.0)
    """lambda_long / lambda_short, rising"""
    surfaces: Surfaces = 16
    points_per_wave: float = Field(default=6.0, ge=2)
    """grid, as lambda_short/dx"""


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface of every spectrum to its areas and thresholds.

    Conductance, what theories make of the same gap, and whether it is closed over (bandwidth, surface, asked), and
    by axis; both percolation thresholds, as located A/A0, over (bandwidth, surface, phase), and of all bandwidths,
    whose surfaces have common phases, as one sample; P(u), and that of the theory told the load of each surface.
    """
    cases = {}
    for bandwidth in options.bandwidths:
        base = base_case(options.self_affine(bandwidth=bandwidth), reduced_pressure=0.1)
        grid = grid_for(base, options.points_per_wave)
        for k in range(options.surfaces):
            cases[bandwidth, k] = leaks(problem=base.further(k), grid=grid, areas=options.areas)
    data = gathered(bench, cases, lambda d, call: flow_of(d, call["problem"]), "bandwidth", "surface")
    data = derive(data, percolation_area_pooled_each="percolation_area_each.mean('bandwidth', skipna=False)")
    along = ("gap_conductance", "gap_conductance_bruggeman", "gap_conductance_constriction", "closed")
    data = mean(data, *along, "percolation_area", "percolation_area_pooled", "gap_narrow")
    densities = [f"gap_{of}_{name}" for of in ("density", "share", "narrow") for name in GAP_THEORIES]
    data = same_of_all(data, "gap_density", "gap_share", *densities)
    apart = {
        f"gap_distance_{name}": f"abs(gap_share_{name} - gap_share).max('gap_bin')" for name in GAP_THEORIES
    }
    data = claim(data, "gap_conductance", "percolation_area", "percolation_area_pooled", **ABSENT)
    data["percolation_area_paper"], data["area_rim"] = SITE_THRESHOLD, _RIM
    data = derive(
        data,
        gap_conductance_ratio="gap_conductance / gap_conductance_bruggeman",
        percolation_area_excess="percolation_area_pooled - percolation_area_paper",
        rim_excess="area_rim - percolation_area_pooled.sel(phase='gap')",
        **apart,
        **{f"gap_narrow_excess_{name}": f"gap_narrow - gap_narrow_{name}" for name in GAP_THEORIES},
    )
    asked = options.model_dump(include={"hurst", "periods", "points_per_wave"})
    return claim(data, *apart).assign_attrs(methods="theory bem", **asked)


def views(data: xr.Dataset) -> Views:
    """Conductance over the area, the thresholds, and the distribution of gaps."""
    widest = {"bandwidth": data.sizes["bandwidth"] - 1}
    gaps = [Line("gap_density", at=widest, steps=True)]
    gaps += [Line(f"gap_density_{name}", at=widest) for name in GAP_THEORIES]
    panels = panels_along(data, "asked", against("local_gap", *gaps, log="y", bottom=3e-3, top=3.0))
    thresholds = ("percolation_area", Level("percolation_area_paper"))
    conductances = ("gap_conductance", "gap_conductance_bruggeman", "gap_conductance_ratio")
    columns = ("bandwidth", "area_asked", *conductances, "gap_conductance_constriction", "closed")
    narrow = ("gap_narrow", *(f"gap_{of}_{name}" for of in ("narrow", "distance") for name in GAP_THEORIES))
    return Views(
        table=Table(("bandwidth", "asked"), (*columns, *narrow)),
        budget=("percolation_area_pooled", "gap_conductance"),
        figures=[
            Figure(
                "leak",
                "Conductance of the gap over the cube of the mean gap (left), over Bruggeman's effective medium of the "
                "same gaps (middle), and the areas at which the contact begins and the gap ceases to percolate (right).",
                [
                    against("area_asked", "gap_conductance", by="bandwidth", log="y"),
                    against("area_asked", "gap_conductance_ratio", by="bandwidth"),
                    against("bandwidth", *thresholds, by="phase", log="x"),
                ],
            ),
            Figure(
                "gap-distribution",
                "Distribution of the gap per nominal area at given contact areas, the contact left out, widest spectrum; "
                "the theory is told the same loads.",
                panels[:: -(-len(panels) // _DRAWN)],
            ),
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    last = data.isel(bandwidth=-1)
    yield finding(
        "comparison",
        "Along an axis the threshold {each} (located area, all spectra, common phases; where the contact joins up along one axis, "
        "it closes the gap along the other, but for single cells). Persson (2006, Sec. 3.6) has {paper}, Dapp et al. (2012) .42.",
        data,
        item="of the {phase} is A/A0 = {percolation_area_pooled}, {verdict} the paper's",
        by="percolation_area_excess",
        paper=SITE_THRESHOLD,
    )
    form = "By spectrum it is {each}."
    item = "{percolation_area} of the {phase} for lambda_long/lambda_short = {bandwidth}"
    yield finding("value", form, data, item=item)
    yield finding(
        "comparison",
        "Tire rim, A/A0 = {area_rim} with adhesion (Persson 2006, Sec. 8.3, where no leak is concluded from {area_rim} > "
        "{percolation_area_paper}): the gap closes at {percolation_area_pooled}, so {verdict}, if adhesion does not move the "
        "threshold.",
        data.sel(phase="gap"),
        by="rim_excess",
        words={
            "+": "it seals",
            "-": "it leaks",
            "0": "whether it seals is not decided",
            "?": "nothing is decided",
        },
    )
    form = "Conductance over the cube of the mean gap (lambda_long/lambda_short = {bandwidth}): {each}."
    item = "{gap_conductance} at A/A0 = {area_asked}, {gap_conductance_ratio:~} of Bruggeman's, where {closed:~%} of the "
    item += "directions are closed"
    yield finding("value", form, last, item=item)
    yield from (
        finding(
            "comparison",
            f"Gaps below {NARROW:g} h_rms, contact left out, cover {{each}} by theory told the load.",
            last.isel(asked=spread(last, "asked", 2)),
            item=f"{{gap_narrow}} of the nominal area at A/A0 = {{area_asked}}, {{verdict}} {whose} {{gap_narrow_{name}:~}} "
            f"(cumulated shares at most {{gap_distance_{name}:~}} apart)",
            by=f"gap_narrow_excess_{name}",
        )
        for name, whose in zip(GAP_THEORIES, ("Persson's", "Yang and Persson's (2008)"), strict=True)
    )
