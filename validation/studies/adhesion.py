"""How much does adhesion enlarge the contact, by boundary elements and by Persson's theory?

Surfaces of rubber on four dials: the work of adhesion, the load, the waves that are there, and a hardness beside the
adhesion. Areas are limits over two grids, beside the theory with both readings of its elastic energy; the energy of the
whole interface is beside the theory's gamma_eff. The range of the attraction, of which the theory knows nothing, is as
short as the coarser grid resolves.
"""

import itertools
import math
from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from fem_contact.adhesion import CELLS_NEEDED
from validation.effects.adhesion import Adhesion
from validation.effects.base import full_contact_energy
from validation.effects.hardness import Hardness
from validation.measurements.adhesive import Sticking
from validation.measurements.common import base_case
from validation.measurements.limits import straight_limit
from validation.report.estimates import claim, derive, mean, same_of_all
from validation.report.places import gather
from validation.report.views import (
    Figure,
    Finding,
    Line,
    Panel,
    Table,
    Views,
    against,
    finding,
    of_one_surface,
)
from validation.scenes.tables import SolidSpec
from validation.studies._options import Bandwidth, Periods, Positives, Seed, SurfaceOptions, above_one
from validation.studies._study import ABSENT, Bench
from validation.units import Positive, wrong

#: Tire rubber (Persson 2006, Sec. 8.3).
_SOLID = SolidSpec(young=1e7, poisson=0.5)
_LENGTH = 1e-5


class Options(SurfaceOptions):
    """Where the dials stand, and where each of them goes while the others stay."""

    why_no_scene = "it turns load, waves, work and hardness by itself"

    works: Positives = (0.01, 0.03, 0.1, 0.3, 1.0)
    """works of adhesion w over the elastic energy U_full of full contact, per area, rising"""
    reduced_pressure: Positive = 0.05
    """p* = p0 / (E* h'_rms) on every dial but its own"""
    work: Positive = 0.1
    """w / U_full on every dial but its own"""
    reduced_pressures: Positives = (0.01, 0.05, 0.2)
    """p* on its own dial"""
    magnifications: Positives = (1.5, 2.0, 4.0, 8.0)
    """q/q_long of the last wave, above 1, at most the bandwidth"""
    hardnesses: Positives = (0.3, 0.6, 1.2)
    """H / (E* h'_rms)"""
    seed: Seed = 11
    surfaces: int = Field(default=3, ge=1)
    """how many"""
    grids: tuple[int, int] = (256, 384)
    """points along a side, two, rising; the range of the attraction is the shortest that the first resolves"""
    periods: Periods = 2.0
    bandwidth: Bandwidth = 8.0

    @model_validator(mode="after")
    def _possible(self) -> Self:
        above_one(self.magnifications, bandwidth=self.bandwidth)
        if not 2 * self.periods * self.bandwidth < self.grids[0] < self.grids[1]:
            raise wrong(
                f"grids = {self.grids[0]}, {self.grids[1]}: must rise, for a limit, from above "
                f"2 periods bandwidth = {2 * self.periods * self.bandwidth:g}"
            )
        return self


@dataclass(frozen=True, kw_only=True)
class Case:
    """Where the dials stand, and which of them is turned; the hardness is NaN where nothing yields."""

    varied: str
    work_ratio: float
    reduced_pressure: float
    magnification: float
    hardness_ratio: float = math.nan


def design(options: Options) -> dict[tuple[Case, int], Sticking]:
    """Return what is pressed by case and number of the surface."""
    load, pressed = options.reduced_pressure, {}
    at = {"work_ratio": options.work, "reduced_pressure": load, "magnification": options.bandwidth}
    cases = [
        Case(varied=dial, **{**at, name: value})
        for dial, (name, values, _) in _DIALS.items()
        for value in getattr(options, values)
    ]
    surfaces = [options.self_affine(number=k, length=_LENGTH) for k in range(options.surfaces)]
    wholes = [base_case(surface, reduced_pressure=load, solid=_SOLID) for surface in surfaces]
    for case, (k, whole) in itertools.product(cases, enumerate(wholes)):
        unit, modulus = whole.pressure_scale, whole.contact_modulus
        work = case.work_ratio * full_contact_energy(whole.field, modulus=modulus)
        # The shortest range whose process zone spans the cells that are needed, and a little more.
        reach = math.sqrt(1.1 * CELLS_NEEDED * _LENGTH / options.grids[0] * work / modulus)
        surface = options.self_affine(number=k, until=case.magnification, length=_LENGTH)
        limit = case.hardness_ratio * unit
        pressed[case, k] = Sticking(
            problem=base_case(surface, pressure=case.reduced_pressure * unit, solid=_SOLID),
            adhesion=Adhesion(work=work, reach=reach),
            hardness=() if math.isnan(limit) else (Hardness(hardness=limit),),
            grids=options.grids,
        )
    return pressed


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Turn every dial, on two grids.

    Over (case, surface) and their means over the surfaces: A/A0 with adhesion and without, by the theory with both
    readings of its elastic energy, at the realised gradient; energy gained by the whole interface, and the theory's
    gamma_eff, over w; yielded area.
    """
    cases = design(options)
    solved = bench.solve(
        [s for sticking in cases.values() for sticky in (True, False) for s in sticking.solves(sticky=sticky)]
    )
    parts = {place: sticking.measured(solved) for place, sticking in cases.items()}
    data = gather(parts, "case", "surface")
    data = derive(
        straight_limit(data, "area", "area_plain", "area_plastic", most=1.0),
        area_gain_each="area_each / area_plain_each",
        area_gain_improved_each="area_improved_each / area_plain_persson_each",
        area_gain_old_each="area_old_each / area_plain_persson_each",
        area_gain_excess_each="area_gain_each / area_gain_improved_each - 1",
        interface_energy_excess_each="interface_energy_each - interface_energy_improved_each",
    )
    data = mean(data, *_AREAS[:2], "area_plastic", "area_gain", "area_gain_excess", "interface_energy")
    data = same_of_all(mean(data, "interface_energy_excess"), *_THEORY)
    data = claim(data, "area", "area_plain", "area_plastic", "area_gain", "interface_energy", **ABSENT)
    return data.assign_attrs(methods="theory bem", **options.model_dump(include={"work", "reduced_pressure"}))


#: What is drawn along every dial.
_AREAS = ("area", "area_plain", "area_improved", "area_old", "area_plain_persson")
#: What the theory says, told the same gradient of every surface.
_THEORY = (
    *("area_improved", "area_old", "area_plain_persson", "area_plastic_improved", "area_gain_improved"),
    *("area_gain_old", "interface_energy_improved", "interface_energy_old", "attraction_range"),
)
#: Coordinate, option and symbol of each dial.
_DIALS = {
    "work": ("work_ratio", "works", "w/U_full"),
    "load": ("reduced_pressure", "reduced_pressures", "p*"),
    "waves": ("magnification", "magnifications", "zeta"),
    "hardness": ("hardness_ratio", "hardnesses", "H/(E* h'_rms)"),
}


def views(data: xr.Dataset) -> Views:
    """Areas along every dial, the energy of the interface against the work of adhesion, and the yielded area."""
    panels = {dial: _panel(dial, *_AREAS, bottom=0.0) for dial in _DIALS}
    energy = ("interface_energy", "interface_energy_improved", "interface_energy_old")
    gains = ("area_gain", "area_gain_improved", "area_gain_old", "area_gain_excess")
    yields = ("area_plastic", "area_plastic_improved")
    columns = ("varied", *(name for name, *_ in _DIALS.values()), *_AREAS, *gains, *energy, *yields)
    return Views(
        table=Table(("case",), (*columns, "attraction_range")),
        budget=("area", "area_gain"),
        figures=[
            Figure(
                "adhesive-area",
                "Contact area against the work of adhesion (left) and the load (right), with the shortest range of "
                "the attraction that the grid resolves.",
                [panels["work"], panels["load"]],
            ),
            Figure(
                "adhesive-area-waves",
                "The same as waves are added (left) and beside a hardness (right).",
                [panels["waves"], panels["hardness"]],
            ),
            Figure(
                "interface-energy",
                "Left: energy gained by the whole interface over the work of adhesion, law less elastic energy; where it "
                "is negative nothing holds the bodies. Right: yielded area under adhesion (Persson 2006, Sec. 9).",
                [_panel("work", *energy), _panel("hardness", *yields, bottom=0.0)],
            ),
        ],
        findings=[
            *(_gain(data, dial) for dial in _DIALS),
            finding(
                "comparison",
                "The whole interface gains {each}.",
                _ends(data, "work"),
                item="{interface_energy} w at w/U_full = {work_ratio}, {verdict} the theory's {interface_energy_improved:~} w "
                "({interface_energy_old:~} w by Eq. 43)",
                by="interface_energy_excess",
                words={"?": "beside"},
            ),
            *of_one_surface(data),
        ],
    )


def _panel(dial: str, *names: str, bottom: float | None = None) -> Panel:
    grey = {"color": "0.45", "ls": "--"}
    marks = [
        Line(name, where={"varied": dial}, look=grey if name == "area_plain_persson" else {})
        for name in names
    ]
    return against(_DIALS[dial][0], *marks, log="x", bottom=bottom)


def _ends(data: xr.Dataset, dial: str) -> xr.Dataset:
    there = np.flatnonzero(data.varied.values == dial)
    return data.isel(case=sorted({int(there[0]), int(there[-1])}))


def _gain(data: xr.Dataset, dial: str) -> Finding:
    yields = (
        "; A_pl/A0 = {area_plastic}, {area_plastic_improved:~} in the theory" if dial == "hardness" else ""
    )
    name, _, symbol = _DIALS[dial]
    return finding(
        "comparison",
        "Adhesion multiplies the area by {each}.",
        _ends(data, dial),
        item=f"{{area_gain}} at {symbol} = {{{name}}} (A/A0 = {{area}}), {{verdict}} the theory's "
        f"{{area_gain_improved:~}} ({{area_gain_old:~}} by Eq. 43){yields}",
        by="area_gain_excess",
        words={"?": "beside"},
    )
