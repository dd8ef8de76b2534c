"""How does the contact area grow with load, when the whole field of every solve is kept?

Its solves are those of scenes, so that the two share stored solves and it takes every effect. It is the
smallest study, and the one to copy for a new one; `pressure` answers the question in depth, from numbers alone.
"""

import itertools

import numpy as np
import xarray as xr

from validation.arrays import Grid
from validation.measurements.common import Rising, RisingGrids
from validation.measurements.limits import limit_of, resolved_grids
from validation.report.estimates import derive, mean
from validation.report.places import gather, spread
from validation.report.views import Figure, Table, Views, against, finding, note
from validation.studies._options import Bandwidth, Periods, Seed, Surfaces
from validation.studies._scene import PressedOptions
from validation.studies._study import Bench


class Options(PressedOptions):
    """What is pressed, and how often."""

    slots = frozenset({"response", "pressure bound", "gap law"})

    reduced_pressures: Rising = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
    """p* = p0 / (E* h'_rms) with the realised gradient"""
    seed: Seed = 11
    surfaces: Surfaces = 4
    grids: RisingGrids = (64, 96, 128)
    """points along a side, rising, two or more of them with at least 3 points per shortest wave"""
    periods: Periods = 2.0
    bandwidth: Bandwidth = 4.0

    @property
    def ladder(self) -> tuple[Grid, ...]:
        """Grids, coarse first."""
        return tuple((n, n) for n in self.grids) if self.scene is None else self.grids_for(())


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve every surface at every load on every resolved grid: limits of the area, and the theory's."""
    # Under effects the pressure at an edge is not that by which it is located: a limit needs three grids.
    grids = resolved_grids(options.first, options.ladder, located=not options.effects)
    cases = {
        (k, load): [options.press(surface=k, reduced_pressure=load, grid=grid) for grid in grids]
        for k, load in itertools.product(range(options.surfaces), options.reduced_pressures)
    }
    solved = bench.solve([solve for solves in cases.values() for solve in solves])
    known = all(type(effect).has_theory() for effect in options.effects)
    limits = {
        case: limit_of({solve: solved[solve] for solve in solves}).assign(
            area_persson_each=options.predicted(solves[0].problem).area if known else np.nan
        )
        for case, solves in cases.items()
    }
    data = gather(limits, "surface", "reduced_pressure")
    data = derive(
        data,
        kappa_each="area_each / reduced_pressure",
        kappa_persson_each="area_persson_each / reduced_pressure",
        area_excess_each="area_each / area_persson_each - 1",
    )
    names = ("area", "area_persson", "kappa", "kappa_persson", "area_excess")
    # Grids are off to the same side on all surfaces: what they leave does not average out.
    return mean(data, *names, alike=True).assign_attrs(
        methods=" ".join(["theory", "bem", *(effect.kind for effect in options.effects)]),
        left_out=", ".join(f"{nx} x {ny}" for nx, ny in options.ladder if (nx, ny) not in grids),
        **options.spectrum_words,
    )


def views(data: xr.Dataset) -> Views:
    """Area and kappa against load, simulation and theory."""
    area_finding = finding(
        "comparison",
        "The area is {each} (lambda_long/lambda_short = {bandwidth}).",
        data.isel(reduced_pressure=spread(data, "reduced_pressure")),
        item="{verdict} Persson's, {area_excess:+%}, at p* = {reduced_pressure}, where kappa = {kappa}",
        by="area_excess",
    )
    coarse = "Under-resolved, with fewer than 3 points per shortest wave, and left out: {grids}."
    left_out = [note(coarse, grids=data.attrs["left_out"])] if data.attrs["left_out"] else []
    columns = ("reduced_pressure", "area", "area_persson", "area_excess", "kappa", "kappa_persson")
    area = against("reduced_pressure", "area", "area_persson", log="xy")
    kappa = against("reduced_pressure", "kappa", "kappa_persson", log="x")
    return Views(
        table=Table(("reduced_pressure",), columns),
        budget=("area",),
        figures=[
            Figure("area", "Contact area against load, beside Persson's theory.", [area]),
            Figure("kappa", "Area over load: constant where contact grows in proportion to load.", [kappa]),
        ],
        findings=[area_finding, *left_out],
    )
