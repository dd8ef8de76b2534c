"""How much does adhesion enlarge the contact, by boundary elements and by Persson's theory?

Surfaces of rubber on four dials: the work of adhesion, the load, the waves that are there, and a hardness
beside the adhesion. Areas are limits over two grids, beside the theory with both readings of its elastic
energy; the energy of the whole interface is beside the theory's gamma_eff. The range of the attraction, of
which the theory knows nothing, is as short as the coarser grid resolves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from fem_contact.adhesion import CELLS_NEEDED
from fem_contact.contact import ContactResult
from persson.elastic import contact_area, stress_variance
from validation.effects.adhesion import Adhesion
from validation.effects.base import full_contact_energy
from validation.effects.hardness import Hardness
from validation.measures.adhesive import adhesive_theory
from validation.measures.common import named, truncated_surface
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, SelfAffineSurface, SolidSpec
from validation.solves.bench import Bench
from validation.solves.press import Press
from validation.studies._options import Bandwidth, Hurst, Periods
from validation.studies._study import StudyOptions
from validation.units import Positive, wrong

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing
    from validation.solves.running import Solves

__all__ = ["Options", "figures", "findings", "run"]

_Positives = Annotated[tuple[Positive, ...], Field(min_length=1)]

#: Tire rubber (Persson 2006, Sec. 8.3).
_SOLID = SolidSpec(young=1e7, poisson=0.5)
_LENGTH, _GRADIENT = 1e-5, 0.1

#: What is measured or computed along every dial, in words.
_WORDS = {
    "area": "A/A0 with adhesion, limit over grids",
    "area_error": "its standard error, surfaces and grids",
    "plain": "A/A0 without adhesion, limit over grids",
    "improved": "A/A0, Persson, energy of Eqs. 44-49",
    "old": "A/A0, Persson, energy of Eq. 43",
    "persson_plain": "A/A0, Persson without adhesion",
    "interface": "gamma_eff / w of the whole interface",
    "macroscopic": "gamma_eff / w, Persson, Eqs. 44-49",
    "macroscopic_old": "gamma_eff / w, Persson, Eq. 43",
    "yielded": "A_pl/A0 with adhesion, limit over grids",
    "yielded_persson": "A_pl/A0 with adhesion, Persson",
}
_DIALS = {
    "work": "w / U_full",
    "reduced_pressure": "p* = p0 / (E* h'_rms)",
    "magnification": "q / q_long of the last wave",
    "hardness": "H / (E* h'_rms)",
}


class Options(StudyOptions):
    """Where the dials stand, and where each of them goes while the others stay."""

    own = "it turns load, waves, work and hardness by itself"

    works: _Positives = Field(
        default=(0.01, 0.03, 0.1, 0.3, 1.0),
        description="works of adhesion w over the elastic energy U_full of full contact, per area, rising",
    )
    reduced_pressure: Positive = Field(
        default=0.05, description="p* = p0 / (E* h'_rms) on every dial but its own"
    )
    work: Positive = Field(default=0.1, description="w / U_full on every dial but its own")
    reduced_pressures: _Positives = Field(default=(0.01, 0.05, 0.2), description="p* on its own dial")
    magnifications: _Positives = Field(
        default=(1.5, 2.0, 4.0, 8.0), description="q/q_long of the last wave, above 1, at most the bandwidth"
    )
    hardnesses: _Positives = Field(default=(0.3, 0.6, 1.2), description="H / (E* h'_rms)")
    seed: int = Field(default=11, ge=0, description="whole number that names the first surface")
    surfaces: int = Field(default=3, ge=1, le=10_000, description="how many")
    grids: tuple[int, int] = Field(
        default=(256, 384),
        description="points along a side, two, rising; the range of the attraction is the shortest that the first resolves",
    )
    hurst: Hurst = 0.8
    periods: Periods = 2.0
    bandwidth: Bandwidth = 8.0

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if not all(1 < zeta <= self.bandwidth for zeta in self.magnifications):
            values = ", ".join(f"{zeta:g}" for zeta in self.magnifications)
            raise wrong(
                f"magnifications = {values}: must lie above 1, at most bandwidth = {self.bandwidth:g}"
            )
        if not 2 <= self.grids[0] < self.grids[1]:
            raise wrong(f"grids = {self.grids[0]}, {self.grids[1]}: must rise, for a limit")
        return self

    def surface(self, magnification: float | None = None, *, number: int = 0) -> SelfAffineSurface:
        """Return a surface with its waves up to a magnification; all of them if not given."""
        until = self.bandwidth if magnification is None else magnification
        whole = {"length": _LENGTH, "gradient": _GRADIENT, "bandwidth": self.bandwidth}
        return truncated_surface(
            until, seed=self.seed + number, hurst=self.hurst, periods=self.periods, **whole
        )


@dataclass(frozen=True, kw_only=True)
class _Case:
    """Surface and load, work [J/m^2] and range [m] of the attraction, and a hardness [Pa] where there is one."""

    realised: Realised
    work: float
    reach: float
    hardness: float | None = None

    @cached_property
    def adhesion(self) -> Adhesion:
        return Adhesion(work=self.work, reach=self.reach)

    def solve(self, n: int, *, sticky: bool = True) -> Press:
        effects: tuple[Adhesion | Hardness, ...] = (self.adhesion,) if sticky else ()
        if self.hardness is not None:
            effects += (Hardness(hardness=self.hardness),)
        settings = (("tolerance", 1e-8),)
        return Press(method="bem", grid=(n, n), realised=self.realised, settings=settings, effects=effects)

    def measured(self, solved: Solves, grids: tuple[int, int]) -> dict[str, float]:
        """Read areas and energy off the solves."""
        sticky = [solved[self.solve(n)].checked() for n in grids]
        plain = [solved[self.solve(n, sticky=False)].checked() for n in grids]
        area = _limit([float(np.mean(contact.in_contact)) for contact in sticky], grids)
        return {
            "area": area,
            "area_error": abs(area - float(np.mean(sticky[-1].in_contact))),
            "plain": _limit([float(np.mean(contact.in_contact)) for contact in plain], grids),
            "interface": _gained(sticky[-1], self.adhesion) / self.work,
            "yielded": _limit([float(np.mean(contact.at_bound)) for contact in sticky], grids),
        }

    def theory(self) -> dict[str, float]:
        """Evaluate the theory with the realised gradient; what it has no answer to is left out."""
        found = {"persson_plain": self._plain_theory()}
        improved = adhesive_theory(self.realised, work=self.work, energy="improved", hardness=self.hardness)
        if improved is not None:
            found |= {"improved": improved.real_area, "macroscopic": improved.macroscopic_work / self.work}
            if self.hardness is not None:
                found["yielded_persson"] = float(improved.area_plastic[-1])
        old = adhesive_theory(self.realised, work=self.work, energy="old", hardness=self.hardness)
        if old is not None:
            found |= {"old": old.real_area, "macroscopic_old": old.macroscopic_work / self.work}
        return found

    def _plain_theory(self) -> float:
        """A/A0 without adhesion."""
        pressure, modulus = self.realised.pressure, self.realised.contact_modulus
        variance = stress_variance(self.realised.field.moments[1], contact_modulus=modulus)
        if self.hardness is None:
            return float(contact_area(pressure, stress_variance=variance))
        from persson.hardness import constant_hardness

        parts = constant_hardness(pressure, stress_variance=variance, yield_stress=self.hardness)
        return float(parts.elastic + parts.plastic)


#: By dial: the number that is turned, and the case of every surface.
_Dials = Mapping[str, list[tuple[float, tuple[_Case, ...]]]]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Turn every dial, on two grids.

    Returns
    -------
    xarray.Dataset
        Over `work`, `reduced_pressure`, `magnification` and `hardness`: A/A0 with adhesion and without, and by the
        theory with both readings of its elastic energy, at the realised gradient; energy gained by the whole
        interface, and the theory's gamma_eff, over w; yielded area.
    """
    dials = _dials(options)
    cases = [case for turns in dials.values() for _, several in turns for case in several]
    solved = bench.solve(
        [case.solve(n, sticky=sticky) for case in cases for n in options.grids for sticky in (True, False)]
    )
    measured = {
        dial: [
            _mean([case.measured(solved, options.grids) | case.theory() for case in several])
            for _, several in turns
        ]
        for dial, turns in dials.items()
    }
    return _dataset(options, dials, measured)


def _mean(rows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Average over surfaces what all of them have; the area gets the error of surfaces and grids."""
    common = set.intersection(*(set(row) for row in rows))
    found = {name: float(np.mean([row[name] for row in rows])) for name in common}
    areas = np.array([row["area"] for row in rows])
    # The miss of a grid has one sign on every surface: it is not averaged away.
    scatter = float(np.std(areas, ddof=1) / math.sqrt(areas.size)) if areas.size > 1 else 0.0
    return found | {"area_error": math.hypot(found["area_error"], scatter)}


def _dials(options: Options) -> _Dials:
    """List the cases of every dial with the number that is turned."""
    wholes = [
        Realised(
            surface=options.surface(number=k),
            solid=_SOLID,
            load=Load(reduced_pressure=options.reduced_pressure),
        )
        for k in range(options.surfaces)
    ]

    def cases(
        w: float, p: float, *, until: float | None = None, hardness: float | None = None
    ) -> tuple[_Case, ...]:
        return tuple(one(k, w, p, until, hardness) for k in range(options.surfaces))

    def one(k: int, w: float, p: float, until: float | None, hardness: float | None) -> _Case:
        unit, modulus = wholes[k].pressure_scale, wholes[k].contact_modulus
        energy = full_contact_energy(wholes[k].field, modulus=modulus)
        # The shortest range whose process zone spans the cells that are needed, and a little more.
        reach = math.sqrt(1.1 * CELLS_NEEDED * _LENGTH / options.grids[0] * w * energy / modulus)
        surface, load = options.surface(until, number=k), Load(pressure=p * unit)
        realised = Realised(surface=surface, solid=_SOLID, load=load)
        limit = None if hardness is None else hardness * unit
        return _Case(realised=realised, work=w * energy, reach=reach, hardness=limit)

    work, load = options.work, options.reduced_pressure
    return {
        "work": [(w, cases(w, load)) for w in options.works],
        "reduced_pressure": [(p, cases(work, p)) for p in options.reduced_pressures],
        "magnification": [(zeta, cases(work, load, until=zeta)) for zeta in options.magnifications],
        "hardness": [(h, cases(work, load, hardness=h)) for h in options.hardnesses],
    }


def _dataset(
    options: Options, dials: _Dials, measured: Mapping[str, Sequence[Mapping[str, float]]]
) -> xr.Dataset:
    """Lay the numbers of all cases out along the dials; NaN where the theory has no answer."""
    import xarray as xr

    columns: dict[str, Any] = {}
    for dial, rows in measured.items():
        for name, words in _WORDS.items():
            if dial == "hardness" or not name.startswith("yielded"):
                values = np.array([row.get(name, math.nan) for row in rows])
                columns[_name(name, dial)] = named(dial, values, words, unit="1")
    reaches = np.array(
        [np.mean([c.reach / c.realised.field.rms_height for c in several]) for _, several in dials["work"]]
    )
    columns["reach"] = named("work", reaches, "range of the attraction over h_rms", unit="1")
    coords = {
        dial: named(dial, np.array([value for value, _ in turns]), _DIALS[dial], unit="1")
        for dial, turns in dials.items()
    }
    said = {"work": options.work, "reduced_pressure": options.reduced_pressure, "grids": list(options.grids)}
    said["surfaces"] = options.surfaces
    return xr.Dataset(columns, coords=coords, attrs={"methods": "theory bem", **said})


def _name(quantity: str, dial: str) -> str:
    """Name of a variable: those over the first dial carry no suffix."""
    if dial == "work":
        return quantity
    bare = quantity.removesuffix("_error")
    return f"{bare}_{dial}" + quantity[len(bare) :]


def _limit(values: list[float], grids: tuple[int, int]) -> float:
    """Return the limit of something linear in dx, between 0 and 1."""
    ratio = grids[0] / grids[1]
    return min(max((values[1] - ratio * values[0]) / (1 - ratio), 0.0), 1.0)


def _gained(contact: ContactResult, effect: Adhesion) -> float:
    """Energy that the law yields less what the solid stores, per nominal area [J/m^2]."""
    law = effect.gap_law().on_grid(spacing=max(contact.spacing), contact_modulus=contact.contact_modulus)
    pressure, displacement = contact.pressure, contact.displacement
    stored = 0.5 * float(np.mean((pressure - pressure.mean()) * (displacement - displacement.mean())))
    return -float(np.mean(law.energy(np.maximum(contact.gap, 0.0)))) - stored


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say by how much adhesion enlarges the contact along every dial, in both."""
    surfaces = int(data.attrs["surfaces"])
    rests = (
        "Means over "
        f"{surfaces} surfaces; +- is one standard error, that of the surfaces and the step to the limit together."
        if surfaces > 1
        else "These are numbers of one surface: how much another of the same spectrum would differ is unknown."
    )
    return rests, *(
        f"{_DIALS[dial].partition(' =')[0]} = {float(data[dial][k]):.3g}: {_sentence(data, dial, k)}."
        for dial in _DIALS
        for k in range(data.sizes[dial])
    )


def _sentence(data: xr.Dataset, dial: str, k: int) -> str:
    def value(name: str) -> float:
        return float(data[_name(name, dial)][k])

    text = (
        f"adhesion multiplies the area by {value('area') / value('plain'):.3g} by boundary elements "
        f"(A/A0 = {value('area'):.4f} +- {value('area_error'):.4f})"
    )
    for reading in ("improved", "old"):
        if math.isfinite(value(reading)):
            text += f", by {value(reading) / value('persson_plain'):.3g} in the theory ({reading})"
        else:
            text += f"; the theory ({reading}) gives no answer"
    if dial == "hardness":
        text += f"; A_pl/A0 = {value('yielded'):.4f}, {value('yielded_persson'):.4f} in the theory"
    else:
        text += f"; the interface gains {value('interface'):.3g} w, {value('macroscopic'):.3g} in the theory"
        text += f" ({value('macroscopic_old'):.3g}, old)"
    return text


def _over(data: xr.Dataset) -> str:
    surfaces = int(data.attrs["surfaces"])
    return f"mean over {surfaces} surfaces" if surfaces > 1 else "one surface"


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw areas along every dial, and the energy of the interface against the work of adhesion."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure

    drawings = []
    areas = ("area", "plain", "improved", "old", "persson_plain")
    for dial, words in _DIALS.items():
        lines = tuple(_name(name, dial) for name in areas)
        drawings.append(
            Drawing(
                name="adhesive-area" if dial == "work" else f"adhesive-area-{dial.replace('_', '-')}",
                figure=lines_figure(data, x=dial, lines=lines, logarithmic="x"),
                data=data[[*lines, _name("area_error", dial)]],
                caption=f"Contact area against {words}, {_over(data)}: boundary elements with the shortest range "
                "that the grid resolves, and Persson's theory with two readings of the elastic energy.",
            )
        )
    lines = tuple(_name(name, "hardness") for name in ("yielded", "yielded_persson"))
    drawings.append(
        Drawing(
            name="adhesive-area-yielded",
            figure=lines_figure(data, x="hardness", lines=lines, logarithmic="x"),
            data=data[list(lines)],
            caption=f"Yielded share of the nominal area under adhesion against the hardness, {_over(data)}: "
            "boundary elements, and Persson's theory (2006, Sec. 9).",
        )
    )
    lines = ("interface", "macroscopic", "macroscopic_old")
    drawings.append(
        Drawing(
            name="interface-energy",
            figure=lines_figure(data, x="work", lines=lines, logarithmic="x"),
            data=data[[*lines, "reach"]],
            caption=f"Energy gained by the whole interface over the work of adhesion, {_over(data)}: law less "
            "elastic energy by boundary elements, gamma_eff(1) by the theory. Where it is negative nothing holds the bodies.",
        )
    )
    return tuple(drawings)
