"""What friction has a surface that slides on rubber, and how much of it touches, over the velocity?

A rigid surface slides steadily on a viscoelastic half-space without friction in the interface. The friction coefficient is
computed twice, by the pressure on the slopes and by what the solid loses; their distance is the error of the grid. Beside it
stands Persson's integral with the full energy and with half of it. The solid is a standard solid, a Prony series or a table.
"""

import io
import math
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
import xarray as xr
from pydantic import AfterValidator, Field, model_validator

from fem_contact.area import contact_areas
from fem_contact.errors import InvalidInput
from fem_contact.sliding import slide
from fem_contact.viscoelastic import PronySolid, TabulatedSolid
from persson.sliding import friction_of_waves
from validation.arrays import Grid
from validation.errors import UsageError
from validation.files import read_whole
from validation.measurements.common import RisingSeveral, in_rising_order
from validation.measurements.theory import RANKED, VARIANTS, variant_areas, wave_powers
from validation.report.estimates import claim, derive, mean, same_of_all
from validation.report.places import spread
from validation.report.values import Value
from validation.report.views import Figure, Findings, Table, Views, against, finding
from validation.scenes.problem import ContactProblem
from validation.studies._rubber import RubberOptions
from validation.studies._study import ABSENT, Bench, Call, gathered, measurement
from validation.units import Length, Velocity, wrong

_Velocities = Annotated[tuple[Velocity, ...], Field(min_length=1), AfterValidator(in_rising_order)]

#: Largest file of a modulus [byte].
_LARGEST = 10**7
#: |E| at the frequency of the period over E_0, above which the solid counts as remembering the period before.
_REMEMBERED = 2.0


Rubber = PronySolid | TabulatedSolid

#: Shares g of the full energy that the theory's friction stores at vanishing contact, S = g + (1 - g) P^2.
SHARES = {"full_energy": 1.0, "half_energy": 0.5}
#: What is read off every solve: friction mu / h'_rms by the pressure on the slopes and by what the solid loses, A/A0
#: corrected at its edge, the factor by which a plain step of the solver shrinks the error, and costs. (Where it slides the
#: pressure at the edge is not that by which a located edge is found.)
QUANTITIES = ("friction", "dissipation", "area", "contraction", "steps", "fft_pairs", "residual")


@measurement(
    "slide-{size}",
    kind="SlideSolve",
    words="slide, to",
    version=2,
    # Some three hundred pairs of transforms for each velocity and grid.
    seconds=lambda grids, velocities: len(velocities) * sum(0.03 + 1.2e-5 * nx * ny for nx, ny in grids),
    bytes=600,
)
def slides(
    *, problem: ContactProblem, rubber: Rubber, velocities: tuple[float, ...], grids: tuple[Grid, ...]
) -> xr.Dataset:
    """Let one surface slide under its load at rising velocities, each started from the one before, on nested grids.

    `QUANTITIES` over (grid, velocity), v [m/s] along x; the solid of `problem` is the relaxed one.
    """
    values, gradient = np.empty((len(QUANTITIES), len(grids), len(velocities))), problem.field.rms_gradient
    for i, grid in enumerate(grids):
        heights, start = problem.heights(grid), None
        for k, velocity in enumerate(velocities):
            sliding = slide(
                heights, rubber, velocity=velocity, mean_pressure=problem.pressure, start=start, threads=1
            ).checked()
            contact = sliding.contact
            start = contact.pressure
            friction = sliding.slopes / gradient, sliding.dissipation / gradient
            costs = contact.cost.iterations, contact.cost.fft_pairs, contact.residuals.worst
            values[:, i, k] = *friction, contact_areas(contact).perimeter, sliding.contraction, *costs
    return xr.Dataset({name: (("grid", "velocity"), values[q]) for q, name in enumerate(QUANTITIES)})


def slid_of(measured: xr.Dataset, solve: Call) -> xr.Dataset:
    """Reduce what one of `slides` left to (velocity) on its finest grid, with what each grid gave, and the theory's.

    Drifts are steps from the grid before; of a friction its distance to the other if that is larger, since
    steps change their sign along the velocities. ``_grid_each`` is over (grid, velocity).
    """
    on_grids = {"friction": "friction", "friction_dissipated": "dissipation", "area": "area"}
    fine, before = (measured.isel(grid=k) for k in (-1, -2))
    numbers: dict[str, Any] = {f"{name}_grid_each": measured[of] for name, of in on_grids.items()}
    apart = {"friction": fine.friction - fine.dissipation, "dissipation": fine.dissipation - fine.friction}
    for name, of in on_grids.items():
        step = fine[of] - before[of]
        other = apart.get(of, step)
        numbers |= {f"{name}_each": fine[of], f"{name}_each_drift": step.where(abs(step) > abs(other), other)}
    numbers |= {f"{name}_each": measured[name] for name in QUANTITIES[3:]}
    return xr.Dataset(numbers | _theory(solve["problem"], solve["rubber"], solve["velocities"]))


def _theory(case: ContactProblem, rubber: Rubber, velocities: tuple[float, ...]) -> dict[str, Any]:
    """Friction over h'_rms for either energy, and A/A0 by every variant, (velocity)."""
    field = case.field
    x, y, power = wave_powers(field.heights, field.spacing)
    power[0, 0] = 0
    there = power > 1e-20 * power.max()
    rows: list[dict[str, Any]] = []
    for velocity in velocities:
        told = {
            name: friction_of_waves(
                x[there],
                y[there],
                power=power[there],
                pressure=case.pressure,
                velocity=velocity,
                modulus=rubber.modulus,
                poisson=rubber.poisson,
                energy_ratio=share,
            )
            for name, share in SHARES.items()
        }
        variance = told["full_energy"].stress_variance
        frictions = {f"friction_{name}": each.friction / field.rms_gradient for name, each in told.items()}
        rows.append(frictions | variant_areas(case.pressure, stress_variance=variance))
    return {f"{name}_each": ("velocity", [row[name] for row in rows]) for name in rows[0]}


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
        if self.modulus_table is None:
            return self.prony()
        try:
            text = read_whole(Path(self.modulus_table), most=_LARGEST).decode()
            omega, storage, loss = np.loadtxt(io.StringIO(text), ndmin=2, unpack=True)
            return TabulatedSolid(frequencies=omega, storage=storage, loss=loss, poisson=self.poisson)
        except (OSError, ValueError, InvalidInput) as error:
            raise UsageError(
                f"--modulus-table = {self.modulus_table!r}: must hold lines of omega [1/s], E' [Pa] and E'' [Pa] ({error})"
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
    surface, speeds = options.self_affine(length=options.length), options.velocities
    cases = options.cases(slides, surface, rubber=rubber, relaxed=relaxed, velocities=speeds)
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


def _findings(data: xr.Dataset) -> Findings:
    """Yield the largest friction, what it cost, friction and area beside the theory, and where that ends."""
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
        yield from _beside_theory(fresh)
    if late.size:
        form = "From v = {late} m/s on the solid has not relaxed when the period comes round again (|E| > {remembered} E_0 "
        form += "there): it keeps the mean track of the periods before, more touches than on fresh rubber, and the theory, "
        form += "which knows no track, is no comparison."
        yield finding("threshold", form, late=late[0], remembered=_REMEMBERED)


def _beside_theory(fresh: xr.Dataset) -> Findings:
    """Yield friction and area beside the theory, at velocities at which the solid has relaxed."""
    top = int(fresh.friction.values.argmax())
    for name, energy in zip(SHARES, ("S = 1", "S = 1/2 + P^2 / 2"), strict=True):
        ratio = f"friction_ratio_{name}"
        yield finding(
            "comparison",
            f"Persson's friction with {energy} is {{verdict}} the largest, {{{ratio}}} times it, and {{low}} to {{high}} times that "
            "up to v = {last} m/s.",
            fresh.isel(velocity=top),
            by=f"friction_excess_{name}",
            last=fresh.velocity[-1],
            low=Value(value=float(fresh[ratio].min()), error=math.nan),
            high=Value(value=float(fresh[ratio].max()), error=math.nan),
        )
    item = "{area} at v = {velocity} m/s, {verdict} Persson's {area_persson:~} (Yang, Persson {area_yang_persson:~}, Wang, "
    item += "Müser {area_wang_mueser:~}, Xu et al. {area_xu:~})"
    areas = fresh.isel(velocity=sorted({0, top, fresh.sizes["velocity"] - 1}))
    yield finding("comparison", "A/A0 is {each}.", areas, item=item, by="area_excess")
