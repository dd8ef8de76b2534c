"""How much does adhesion enlarge the contact, by boundary elements and by Persson's theory?

One surface of rubber on four dials: the work of adhesion, the load, the waves that are there, and a hardness
beside the adhesion. Areas are limits over two grids, beside the theory with both readings of its elastic
energy; the energy of the whole interface is beside the theory's gamma_eff. The range of the attraction, of
which the theory knows nothing, is as short as the coarser grid resolves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fem_contact.adhesion import CELLS_NEEDED
from fem_contact.contact import ContactResult
from persson.adhesion import Interface, solve_adhesion
from persson.elastic import contact_area, stress_variance
from persson.errors import PerssonError
from persson.scale import Scale
from validation.effects.adhesion import Adhesion
from validation.effects.base import full_contact_energy
from validation.effects.hardness import Hardness
from validation.errors import UsageError
from validation.measures.common import truncated_surface
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, SelfAffineSurface, SolidSpec
from validation.scenes.surfaces import reference_field, spectrum_of
from validation.solves.bench import Bench
from validation.solves.press import Press

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing
    from validation.solves.running import Solves

__all__ = ["figures", "findings", "run"]

Array = NDArray[np.float64]

#: Tire rubber (Persson 2006, Sec. 8.3).
_SOLID = SolidSpec(young=1e7, poisson=0.5)
_MODULUS = _SOLID.young / (1 - _SOLID.poisson**2)
_LENGTH, _GRADIENT = 1e-5, 0.1

#: The finer grid has this many times the points of the coarser one along a side.
_FINER = 1.5

#: What is measured or computed along every dial, in words.
_WORDS = {
    "area": "A/A0 with adhesion, limit over grids",
    "area_error": "distance of that limit to the finer grid",
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
    "load": "p* = p0 / (E* h'_rms)",
    "magnification": "q / q_long of the last wave",
    "hardness": "H / (E* h'_rms)",
}


@dataclass(frozen=True, kw_only=True)
class _Case:
    """One surface, load [Pa], work [J/m^2] and range [m], and a hardness [Pa] where there is one."""

    surface: SelfAffineSurface
    pressure: float
    work: float
    reach: float
    hardness: float | None = None

    @cached_property
    def adhesion(self) -> Adhesion:
        return Adhesion(kind="adhesion", work=self.work, reach=self.reach)

    def solve(self, n: int, *, sticky: bool = True) -> Press:
        effects: tuple[Adhesion | Hardness, ...] = (self.adhesion,) if sticky else ()
        if self.hardness is not None:
            effects += (Hardness(kind="hardness", hardness=self.hardness),)
        return Press(
            method="bem",
            grid=(n, n),
            realised=Realised(surface=self.surface, solid=_SOLID, load=Load(pressure=self.pressure)),
            settings=(("tolerance", 1e-8),),
            effects=effects,
        )

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
        """Evaluate the theory with the realised gradient; NaN where it has no answer."""
        field, spectrum = reference_field(self.surface), spectrum_of(self.surface)
        scaled = spectrum.scaled(float(field.rms_gradient**2 / spectrum.m2()))
        variance = stress_variance(field.moments[1], contact_modulus=_MODULUS)
        found = {"persson_plain": float(contact_area(self.pressure, stress_variance=variance))}
        if self.hardness is not None:
            from persson.hardness import constant_hardness

            parts = constant_hardness(self.pressure, stress_variance=variance, yield_stress=self.hardness)
            found["persson_plain"] = float(parts.elastic + parts.plastic)
        for energy, area, whole in (
            ("improved", "improved", "macroscopic"),
            ("old", "old", "macroscopic_old"),
        ):
            try:
                answer = solve_adhesion(
                    Scale(scaled, contact_modulus=_MODULUS),
                    pressure=self.pressure,
                    interface=Interface(work_of_adhesion=self.work, energy=energy),  # type: ignore[arg-type]
                    yield_stress=self.hardness,
                ).checked()
            except PerssonError:
                continue
            found |= {area: answer.real_area, whole: answer.macroscopic_work / self.work}
            if energy == "improved" and self.hardness is not None:
                found["yielded_persson"] = float(answer.area_plastic[-1])
        return found


def run(
    *,
    bench: Bench | None = None,
    works: tuple[float, ...] = (0.01, 0.03, 0.1, 0.3, 1.0),
    pressure: float = 0.05,
    share: float = 0.1,
    loads: tuple[float, ...] = (0.01, 0.05, 0.2),
    magnifications: tuple[float, ...] = (1.5, 2.0, 4.0, 8.0),
    hardnesses: tuple[float, ...] = (0.3, 0.6, 1.2),
    seed: int = 11,
    grid: int = 256,
    hurst: float = 0.8,
    periods: float = 2.0,
    bandwidth: float = 8.0,
) -> xr.Dataset:
    """Turn every dial, on two grids.

    Parameters
    ----------
    bench : Bench, optional
        Where the solves run and are stored; results/solves if not given.
    works : tuple of float
        Works of adhesion over the elastic energy per area of full contact, w / U_full, rising.
    pressure : float
        p* = p0 / (E* h'_rms) on every dial but the load's.
    share : float
        w / U_full on every dial but the work's.
    loads, magnifications, hardnesses : tuple of float
        p*; q/q_long of the last wave, above 1 and at most the bandwidth; H / (E* h'_rms).
    seed, grid : int
        Realisation, points along a side of the coarser grid; the finer has half as many again.
    hurst, periods, bandwidth : float
        H, L / lambda_long, lambda_long / lambda_short.

    Returns
    -------
    xarray.Dataset
        Over `work`, `load`, `magnification` and `hardness`: A/A0 with adhesion and without, and by the theory
        with both readings of its elastic energy, at the realised gradient; energy gained by the whole
        interface, and the theory's gamma_eff, over w; yielded area.

    Raises
    ------
    UsageError
        For magnifications outside the bandwidth.
    """
    import xarray as xr

    if not all(1 < zeta <= bandwidth for zeta in magnifications):
        raise UsageError(f"--magnifications = {magnifications}: must lie above 1, at most {bandwidth:g}")
    bench = bench or Bench.at()
    grids = grid, round(_FINER * grid)

    def surface(until: float) -> SelfAffineSurface:
        shape = {"hurst": hurst, "periods": periods, "bandwidth": bandwidth}
        return truncated_surface(seed, until, length=_LENGTH, gradient=_GRADIENT, **shape)

    whole = surface(bandwidth)
    field = reference_field(whole)
    unit, energy = _MODULUS * field.rms_gradient, full_contact_energy(field, modulus=_MODULUS)

    def case(w: float, p: float, **others: Any) -> _Case:
        # The shortest range whose process zone spans the cells that are needed, and a little more.
        reach = math.sqrt(1.1 * CELLS_NEEDED * _LENGTH / grid * w * energy / _MODULUS)
        return _Case(**({"surface": whole} | others), pressure=p * unit, work=w * energy, reach=reach)

    dials: Mapping[str, list[tuple[float, _Case]]] = {
        "work": [(w, case(w, pressure)) for w in works],
        "load": [(p, case(share, p)) for p in loads],
        "magnification": [(zeta, case(share, pressure, surface=surface(zeta))) for zeta in magnifications],
        "hardness": [(h, case(share, pressure, hardness=h * unit)) for h in hardnesses],
    }
    cases = [one for turns in dials.values() for _, one in turns]
    solved = bench.solve([one.solve(n, sticky=s) for one in cases for n in grids for s in (True, False)])
    columns = {}
    for dial, turns in dials.items():
        found = [one.measured(solved, grids) | one.theory() for _, one in turns]
        for name, words in _WORDS.items():
            if dial == "hardness" or not name.startswith("yielded"):
                values = np.array([row.get(name, math.nan) for row in found])
                columns[_name(name, dial)] = (dial, values, {"units": "1", "long_name": words})
    reaches = np.array([one.reach / field.rms_height for _, one in dials["work"]])
    columns["reach"] = ("work", reaches, {"units": "1", "long_name": "range of the attraction over h_rms"})
    coords = {
        dial: (dial, np.array([value for value, _ in turns]), {"units": "1", "long_name": _DIALS[dial]})
        for dial, turns in dials.items()
    }
    return xr.Dataset(
        columns,
        coords=coords,
        attrs={"methods": "theory bem", "pressure": pressure, "share": share, "grids": list(grids)},
    )


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
    return tuple(
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
                name="adhesive-area" if dial == "work" else f"adhesive-area-{dial}",
                figure=lines_figure(data, x=dial, lines=lines, logarithmic="x"),
                data=data[[*lines, _name("area_error", dial)]],
                caption=f"Contact area against {words}: boundary elements with the shortest range that the "
                "grid resolves, and Persson's theory with two readings of the elastic energy.",
            )
        )
    lines = tuple(_name(name, "hardness") for name in ("yielded", "yielded_persson"))
    drawings.append(
        Drawing(
            name="adhesive-area-yielded",
            figure=lines_figure(data, x="hardness", lines=lines, logarithmic="x"),
            data=data[list(lines)],
            caption="Yielded share of the nominal area under adhesion against the hardness: boundary "
            "elements, and Persson's theory (2006, Sec. 9).",
        )
    )
    lines = ("interface", "macroscopic", "macroscopic_old")
    drawings.append(
        Drawing(
            name="interface-energy",
            figure=lines_figure(data, x="work", lines=lines, logarithmic="x"),
            data=data[[*lines, "reach"]],
            caption="Energy gained by the whole interface over the work of adhesion: law less elastic energy "
            "by boundary elements, gamma_eff(1) by the theory. Where it is negative nothing holds the bodies.",
        )
    )
    return tuple(drawings)
