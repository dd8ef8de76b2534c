"""What friction has a surface that slides on rubber, and how much of it touches, over the velocity?

A rigid surface slides steadily on a viscoelastic half-space without friction in the interface. The friction coefficient is
computed twice, by the pressure on the slopes and by what the solid loses; their distance is the error of the grid. Beside it
stands Persson's integral with the full energy and with half of it. The solid is a standard solid, a Prony series or a table.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Self

import numpy as np
import xarray as xr
from pydantic import AfterValidator, Field, model_validator

from fem_contact.errors import InvalidInput
from fem_contact.viscoelastic import TabulatedSolid
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.files import read_whole
from validation.measurements.common import RisingSeveral, base_case, in_rising_order
from validation.measurements.limits import ABSENT
from validation.measurements.measurement import grids_for
from validation.measurements.sliding import SHARES, Rubber, slid_of, slides
from validation.measurements.theory import RANKED, VARIANTS
from validation.report.estimates import claim, derive, mean, same_of_all, spread
from validation.report.values import Value
from validation.report.views import Figure, Finding, Table, Views, against, finding
from validation.scenes.tables import SolidSpec
from validation.studies._rubber import RubberOptions
from validation.studies._study import gathered
from validation.units import Length, Velocity, wrong

_Velocities = Annotated[tuple[Velocity, ...], Field(min_length=1), AfterValidator(in_rising_order)]

#: Largest file of a modulus [byte].
_LARGEST = 10**7
#: |E| at the frequency of the period over E_0, above which the solid counts as remembering the period before.
_REMEMBERED = 2.0


class Options(RubberOptions):
    """What slides, on what, and how fast."""

    velocities: _Velocities = (1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
    """velocities v along x, rising, e.g. "1 mm/s,10 mm/s" """
    modulus_table: str | None = None
    """file of a measured modulus, in place of both: lines of omega [1/s], E' [Pa], E'' [Pa]"""
    length: Length = 1e-3
    """period of the surface"""
    points_per_wave: RisingSeveral = (4.0, 8.0, 16.0)
    """grids, as lambda_short/dx; the finest gives the value"""

    @model_validator(mode="after")
    def _table_alone(self) -> Self:
        series = {"relaxed", "unrelaxed", "time", "moduli", "times"}
        if self.modulus_table is not None and series & self.model_fields_set:
            raise wrong("give one solid: modulus_table leaves no other modulus or time")
        return self

    def rubber(self) -> Rubber:
        """Return the solid that was asked for."""
        if self.modulus_table is not None:
            return _table_of(Path(self.modulus_table), poisson=self.poisson)
        return self.prony()


def _table_of(path: Path, *, poisson: float) -> TabulatedSolid:
    try:
        text = read_whole(path, most=_LARGEST).decode()
        omega, storage, loss = np.loadtxt(io.StringIO(text), ndmin=2, unpack=True)
        return TabulatedSolid(frequencies=omega, storage=storage, loss=loss, poisson=poisson)
    except (OSError, ValueError, InvalidInput) as error:
        raise UsageError(
            f"--modulus-table = {str(path)!r}: must hold lines of omega [1/s], E' [Pa] and E'' [Pa] ({error})"
        ) from None


#: Of the theory: friction with either energy, area by each variant, and both over what is computed.
_FRICTIONS, _AREAS = [f"friction_{name}" for name in SHARES], [f"area_{name}" for name in VARIANTS]
_RATIOS = [
    f"{of}_ratio_{name}" for of, names in (("friction", SHARES), ("area_theory", VARIANTS)) for name in names
]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Let every surface slide at every velocity, on every grid.

    Returns mu / h'_rms by slopes and by losses, A/A0 and what the solves took over (surface, velocity), and over
    (grid); the theory told the realised waves; |E(2 pi v / L)| / E_0 over velocity.
    """
    rubber, velocity = options.rubber(), np.array(options.velocities)
    relaxed = float(rubber.modulus(np.zeros(1)).real[0])
    surface = options.self_affine(length=options.length)
    solid = SolidSpec(young=relaxed, poisson=rubber.poisson)
    base = base_case(surface, reduced_pressure=options.reduced_pressure, solid=solid)
    grids = grids_for(base, options.points_per_wave)
    cases = {
        k: slides(problem=base.further(k), rubber=rubber, velocities=options.velocities, grids=grids)
        for k in range(options.surfaces)
    }
    data = gathered(bench, cases, slid_of, "surface").assign_coords(
        velocity=velocity, points_per_wave=("grid", list(options.points_per_wave))
    )
    passing = np.abs(rubber.modulus(2 * np.pi * velocity / options.length))
    data["modulus_passing"] = ("velocity", passing / relaxed)
    data = derive(
        data,
        friction_difference_each="abs(friction_grid_each / friction_dissipated_grid_each - 1)",
        friction_difference="(friction_difference_each**2).mean('surface')**0.5",
        friction_difference_pooled="(friction_difference_each**2).mean(('surface', 'velocity'))**0.5",
        **{f"friction_ratio_{name}_each": f"friction_{name}_each / friction_each" for name in SHARES},
        **{f"area_theory_ratio_{name}_each": f"area_{name}_each / area_each" for name in VARIANTS},
        area_excess_each="area_each / area_persson_each - 1",
    )
    data = mean(data, "friction", "friction_dissipated", "area", "area_excess", *_RATIOS)
    data = same_of_all(data, *_FRICTIONS, *_AREAS)
    data = derive(data, **{f"friction_excess_{name}": f"friction_ratio_{name} - 1" for name in SHARES})
    data = claim(data, "friction", "friction_dissipated", "area", **ABSENT)
    return data.assign_attrs(methods=RANKED, solid=repr(rubber), reduced_pressure=options.reduced_pressure)


def views(data: xr.Dataset) -> Views:
    """Friction and area over the velocity, and how both frictions meet as the grid is refined."""
    some = {"velocity": spread(data, "velocity", 4)}
    friction, area = ("friction", "friction_dissipated", *_FRICTIONS), ("area", *_AREAS)
    return Views(
        table=Table(("velocity",), ("velocity", "modulus_passing", *friction, *area, *_RATIOS)),
        budget=("friction", "area"),
        figures=[
            Figure(
                "sliding",
                "A rigid surface sliding on a viscoelastic half-space: friction coefficient over h'_rms by the pressure on "
                "the slopes and by what the solid loses (left), area of real contact (middle), and difference of both "
                "frictions over the resolution, root mean square over the surfaces (right).",
                [
                    against("velocity", *friction, log="x", bottom=0.0),
                    against("velocity", *area, log="xy"),
                    against("points_per_wave", "friction_difference", by="velocity", at=some, log="xy"),
                ],
            )
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Iterator[Finding]:
    form = "Friction is largest at v = {velocity} m/s: mu = {friction} h'_rms, {friction_dissipated:~} by losses."
    yield finding("value", form, data.isel(velocity=int(data.friction.values.argmax())))
    yield finding(
        "cost",
        "By slopes and by losses it differs by {each} (root mean square over velocities and surfaces). The solver took "
        "{least} to {most} steps, at most {pairs} pairs of transforms; plain steps would shrink the error by {shrink} each "
        "at worst.",
        data,
        item="{friction_difference_pooled:%} at {points_per_wave} points per shortest wave",
        least=data.steps_each.min(),
        most=data.steps_each.max(),
        pairs=data.fft_pairs_each.max(),
        shrink=data.contraction_each.max(),
    )
    late = data.velocity.values[data.modulus_passing.values > _REMEMBERED]
    fresh = data.isel(velocity=np.flatnonzero(data.modulus_passing.values <= _REMEMBERED))
    if fresh.sizes["velocity"]:
        top = int(fresh.friction.values.argmax())
        yield from (_theory_of(fresh, fresh.isel(velocity=top), name) for name in SHARES)
        form = "A/A0 is {each}."
        item = "{area} at v = {velocity} m/s, {verdict} Persson's {area_persson:~} (Yang, Persson {area_yang_persson:~}, Wang, "
        item += "Müser {area_wang_mueser:~}, Xu et al. {area_xu:~})"
        areas = fresh.isel(velocity=sorted({0, top, fresh.sizes["velocity"] - 1}))
        yield finding("comparison", form, areas, item=item, by="area_excess")
    if late.size:
        form = "From v = {late} m/s on the solid has not relaxed when the period comes round again (|E| > {remembered} E_0 "
        form += "there): it keeps the mean track of the periods before, more touches than on fresh rubber, and the theory, "
        form += "which knows no track, is no comparison."
        yield finding("threshold", form, late=late[0], remembered=_REMEMBERED)


def _theory_of(data: xr.Dataset, largest: xr.Dataset, name: str) -> Finding:
    energy = {"full_energy": "S = 1", "half_energy": "S = 1/2 + P^2 / 2"}[name]
    ratio = f"friction_ratio_{name}"
    return finding(
        "comparison",
        f"Persson's friction with {energy} is {{verdict}} the largest, {{{ratio}}} times it, and {{low}} to {{high}} times that "
        "up to v = {last} m/s.",
        largest,
        by=f"friction_excess_{name}",
        last=data.velocity[-1],
        low=Value(value=float(data[ratio].min()), error=math.nan),
        high=Value(value=float(data[ratio].max()), error=math.nan),
    )
