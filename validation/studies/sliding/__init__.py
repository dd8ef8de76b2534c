"""What friction has a surface that slides on rubber, and how much of it touches, over the velocity?

A rigid surface slides steadily on a viscoelastic half-space without friction in the interface. The friction coefficient is
computed twice, by the pressure on the slopes and by what the solid loses; their distance is the error of the grid. Beside it
stands Persson's integral with the full energy and with half of it. The solid is a standard solid, a Prony series or a table.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from fem_contact.errors import InvalidInput
from fem_contact.viscoelastic import PronySolid, TabulatedSolid
from persson.sliding import friction_of_waves
from persson.variants import corrected_contact_area
from validation.arrays import Array
from validation.errors import UsageError
from validation.files import read_whole
from validation.measures.common import (
    Rising,
    base_case,
    base_surface,
    in_rising_order,
    named,
    over_surfaces,
    results_of,
)
from validation.measures.measurement import grid_for
from validation.measures.statistics import Estimate
from validation.measures.theory import VARIANTS
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.scenes.scene import SelfAffineSurface, SolidSpec
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Hurst, Periods, Seed, Surfaces
from validation.studies._study import StudyOptions
from validation.studies.sliding.plots import figure
from validation.studies.sliding.slides import QUANTITIES, REMEMBERED, SHARES, Rubber, SlideSolve
from validation.units import Duration, Length, Positive, Pressure, Velocity, wrong

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Options", "figures", "findings", "run", "table"]

#: Largest file of a modulus [byte].
_LARGEST = 10**7


class Options(StudyOptions):
    """What slides, on what, and how fast."""

    own = "its solid is viscoelastic, which no scene can say, and it makes its own surfaces"

    velocities: Annotated[tuple[Velocity, ...], Field(min_length=1), AfterValidator(in_rising_order)] = Field(
        default=(1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0),
        description='velocities v along x, rising, e.g. "1 mm/s,10 mm/s"',
    )
    relaxed: Pressure = Field(default=1e6, description="E_0, Young's modulus at low frequency")
    unrelaxed: Pressure = Field(default=1e7, description="E_inf of a standard solid, at high frequency")
    time: Duration = Field(default=1e-3, description="retardation time tau of a standard solid")
    moduli: tuple[Pressure, ...] = Field(
        default=(), description="moduli E_k of a Prony series, in place of the standard solid"
    )
    times: tuple[Duration, ...] = Field(default=(), description="relaxation times of the series, as many")
    modulus_table: str | None = Field(
        default=None,
        description="file of a measured modulus, in place of both: lines of omega [1/s], E' [Pa], E'' [Pa]",
    )
    poisson: float = Field(default=0.5, gt=-1, le=0.5, description="Poisson ratio")
    reduced_pressure: Positive = Field(
        default=0.1, description="p* = p0 / (E_0* h'_rms), with the relaxed modulus and the realised gradient"
    )
    length: Length = Field(default=1e-3, description="period of the surface")
    hurst: Hurst = 0.8
    periods: Periods = 2.0
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 6
    points_per_wave: Rising = Field(
        default=(4.0, 8.0, 16.0),
        min_length=2,
        description="grids, as lambda_short/dx; the finest gives the value",
    )
    seed: Seed = 2006

    @model_validator(mode="after")
    def _one_solid(self) -> Self:
        said = self.model_fields_set
        series, table = {"moduli", "times"} & said, self.modulus_table is not None
        standard = {"unrelaxed", "time"} & said
        if (series and standard) or (table and (series or standard or "relaxed" in said)):
            raise wrong(
                "give one solid: relaxed, unrelaxed, time; or relaxed, moduli, times; or modulus_table"
            )
        if len(self.moduli) != len(self.times):
            raise wrong(f"moduli, times: {len(self.moduli)} and {len(self.times)} values: must be as many")
        return self

    def rubber(self) -> Rubber:
        """Return the solid that was asked for."""
        if self.modulus_table is not None:
            return _table_of(Path(self.modulus_table), poisson=self.poisson)
        if self.moduli:
            return PronySolid(
                relaxed=self.relaxed, moduli=self.moduli, times=self.times, poisson=self.poisson
            )
        return PronySolid.standard(
            relaxed=self.relaxed, unrelaxed=self.unrelaxed, time=self.time, poisson=self.poisson
        )

    def surface(self) -> SelfAffineSurface:
        """Return the first surface."""
        return base_surface(
            hurst=self.hurst,
            periods=self.periods,
            bandwidth=self.bandwidth,
            seed=self.seed,
            length=self.length,
        )


def _table_of(path: Path, *, poisson: float) -> TabulatedSolid:
    """Read a modulus: three columns, comments after #."""
    try:
        text = read_whole(path, most=_LARGEST).decode()
        omega, storage, loss = np.loadtxt(io.StringIO(text), ndmin=2, unpack=True)
        return TabulatedSolid(frequencies=omega, storage=storage, loss=loss, poisson=poisson)
    except (OSError, ValueError, InvalidInput) as error:
        raise UsageError(
            f"--modulus-table = {str(path)!r}: must hold lines of omega [1/s], E' [Pa] and E'' [Pa] ({error})"
        ) from None


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Let every surface slide at every velocity, on every grid.

    Returns
    -------
    xarray.Dataset
        `friction` and `dissipation`, mu / h'_rms by slopes and by losses, `area` A/A0 and what the solves took, over
        (surface, grid, velocity); `theory` mu / h'_rms over (share, surface, velocity), `theory_area` over (variant, surface,
        velocity), told the realised waves; `memory` |E(2 pi v / L)| / E_0 over velocity.
    """
    import xarray as xr

    rubber = options.rubber()
    relaxed = float(rubber.modulus(np.zeros(1)).real[0])
    base = base_case(
        options.surface(),
        reduced_pressure=options.reduced_pressure,
        solid=SolidSpec(young=relaxed, poisson=rubber.poisson),
    )
    grids = tuple(grid_for(base, points) for points in options.points_per_wave)
    cases = {
        k: SlideSolve(realised=base.further(k), rubber=rubber, velocities=options.velocities, grids=grids)
        for k in range(options.surfaces)
    }
    found = results_of(bench, cases)
    data: xr.Dataset = xr.concat([found[k] for k in cases], dim="surface").drop_attrs()
    told = [_theory(case.realised, rubber, options.velocities) for case in cases.values()]
    friction, area = (np.array(list(column)).transpose(2, 0, 1) for column in zip(*told, strict=True))
    data["theory"] = named(("share", "surface", "velocity"), friction, "mu / h'_rms of the theory")
    data["theory_area"] = named(("variant", "surface", "velocity"), area, "A/A0 of the theory")
    passing = 2 * np.pi * np.array(options.velocities) / options.length
    data["memory"] = named(
        "velocity", np.abs(rubber.modulus(passing)) / relaxed, "|E| at the frequency of the period, over E_0"
    )
    for name, words in QUANTITIES.items():
        data[name].attrs = {"units": "1", "long_name": words}
    data.attrs = {
        "study": "sliding",
        "methods": "theory bem yang_persson wang_mueser xu",
        "solid": repr(rubber),
        "reduced_pressure": options.reduced_pressure,
    }
    return data.assign_coords(
        v=named("velocity", list(options.velocities), "velocity", unit="m/s"),
        points_per_wave=named("grid", list(options.points_per_wave), "lambda_short/dx"),
        share=list(SHARES),
        variant=list(VARIANTS),
    )


def _theory(case: Realised, rubber: Rubber, velocities: tuple[float, ...]) -> tuple[Array, Array]:
    """Friction over (velocity, share) and area over (velocity, variant), told the realised waves."""
    field = case.field
    waves = np.fft.fft2(field.heights, norm="forward")
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(field.shape, field.spacing, strict=True))
    power = np.abs(waves) ** 2
    power[0, 0] = 0
    there = power > 1e-20 * power.max()
    x, y = (part[there] for part in np.broadcast_arrays(qx[:, None], qy[None, :]))
    friction = np.empty((len(velocities), len(SHARES)))
    area = np.empty((len(velocities), len(VARIANTS)))
    for k, velocity in enumerate(velocities):
        for j, share in enumerate(SHARES):
            said = friction_of_waves(
                x,
                y,
                power=power[there],
                pressure=case.pressure,
                velocity=velocity,
                modulus=rubber.modulus,
                poisson=rubber.poisson,
                energy_ratio=share,
            )
            friction[k, j] = said.friction / field.rms_gradient
        for j, variant in enumerate(VARIANTS):
            area[k, j] = corrected_contact_area(
                case.pressure, stress_variance=said.stress_variance, variant=variant
            )
    return friction, area


@dataclass(frozen=True, kw_only=True)
class _Row:
    """What there is to say of one velocity, on the finest grid."""

    friction: Estimate
    grid: float
    dissipation: float
    area: Estimate
    area_grid: float

    @classmethod
    def of(cls, data: xr.Dataset, k: int) -> _Row:
        fine, before = data.isel(velocity=k, grid=-1), data.isel(velocity=k, grid=-2)

        def over(change: xr.DataArray) -> float:
            """Root mean square over the surfaces: grids are off in common."""
            return float(np.sqrt(np.mean(change.values**2)))

        return cls(
            friction=over_surfaces(fine.friction),
            grid=over(fine.friction - fine.dissipation),
            dissipation=float(fine.dissipation.mean()),
            area=over_surfaces(fine.area),
            area_grid=over(fine.area - before.area),
        )


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each velocity."""
    rows = []
    for k, velocity in enumerate(dataset.v.values):
        row = _Row.of(dataset, k)
        friction, area = (said[:, :, k].mean("surface") for said in (dataset.theory, dataset.theory_area))
        rows.append(
            {
                "v [m/s]": float(velocity),
                "mu/h'_rms": row.friction.value,
                "+- surfaces (95 %)": row.friction.half_width,
                "+- grid": row.grid,
                "by dissipation": row.dissipation,
                **{name: float(friction[j]) for j, name in enumerate(SHARES.values())},
                "A/A0": row.area.value,
                "+- surfaces (95 %) ": row.area.half_width,
                "+- grid ": row.area_grid,
                **{name: float(area[j]) for j, name in enumerate(VARIANTS.values())},
            }
        )
    return ResultTable.of_rows(rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say where friction is largest, how well both ways agree, how far the theory is off, and what it took."""
    rows = [_Row.of(dataset, k) for k in range(dataset.sizes["velocity"])]
    top = int(np.argmax([row.friction.value for row in rows]))
    sentences = [
        f"Friction is largest at v = {float(dataset.v[top]):g} m/s: mu = {rows[top].friction} h'_rms (95 % over "
        f"{rows[top].friction.samples} surfaces; the grid may change it by {rows[top].grid:.2g})."
    ]
    apart = abs(dataset.friction / dataset.dissipation - 1)
    rms = np.sqrt((apart**2).mean(("surface", "velocity"))).values
    listed = ", ".join(
        f"{100 * value:.2g} %" + (f" at {points:g} points per shortest wave" if g == 0 else f" at {points:g}")
        for g, (value, points) in enumerate(zip(rms, dataset.points_per_wave.values, strict=True))
    )
    sentences.append(
        f"By slopes and by losses it differs by {listed} (root mean square over velocities and surfaces)."
    )
    for j, name in enumerate(SHARES.values()):
        ratio = [float(dataset.theory[j, :, k].mean()) / row.friction.value for k, row in enumerate(rows)]
        sentences.append(
            f"{name}: {min(ratio):.2g} to {max(ratio):.2g} times the friction, {ratio[top]:.3g} times the largest."
        )
    last = len(rows) - 1
    for k in sorted({0, top, last}):
        ratios = ", ".join(
            f"{VARIANTS[name]} {float(dataset.theory_area[j, :, k].mean()) / rows[k].area.value:.3g} times that"
            for j, name in enumerate(VARIANTS)
        )
        sentences.append(
            f"v = {float(dataset.v[k]):g} m/s: A/A0 = {rows[k].area} (the grid may change it by "
            f"{rows[k].area_grid:.1g}); {ratios}."
        )
    late = dataset.v.values[dataset.memory.values > REMEMBERED]
    if late.size:
        sentences.append(
            f"From v = {late[0]:g} m/s on the solid has not relaxed when the period comes round again "
            f"(|E| > {REMEMBERED:g} E_0 there): it keeps the mean track of the periods before, more touches than on "
            "fresh rubber, and the theory, which knows no track, is no comparison."
        )
    sentences.append(
        f"The solver took {dataset.steps.values.min():.0f} to {dataset.steps.values.max():.0f} steps, at most "
        f"{dataset.fft_pairs.values.max():.0f} pairs of transforms; plain steps would shrink the error by "
        f"{dataset.contraction.values.max():.2f} each at worst."
    )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw friction and area over the velocity, and how both frictions meet as the grid is refined."""
    return (
        Drawing(
            name="sliding",
            figure=figure(dataset),
            data=dataset,
            caption="A rigid surface sliding on a viscoelastic half-space. Left: friction coefficient over h'_rms by the "
            "pressure on the slopes (filled) and by what the solid loses (open), with Persson's integral told the realised "
            "waves; bars: 95 % over the surfaces and the difference of both. Middle: area of real contact, with the theory and its "
            "variants; grey: the solid remembers the period before. Right: difference of both frictions over the resolution, root mean square over the surfaces.",
        ),
    )
