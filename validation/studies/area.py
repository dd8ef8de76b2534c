"""How does the contact area grow with load, when the whole field of every solve is kept?

Boundary elements on surfaces of several seeds, from light load upwards, each surface and load on a ladder of grids; the
limit over the grids beside Persson's theory with the gradient of the same surface. Its solves are those of scenes, so that
the two share stored solves. It is the smallest study, and the one to copy for a new one; `pressure` answers the question
in depth, from numbers alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fem_contact.area import contact_areas
from fem_contact.extrapolation import located_limit
from persson import elastic
from validation.errors import UsageError
from validation.measures.common import LEAST_POINTS_PER_WAVE
from validation.measures.statistics import combined
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, SelfAffineSurface, SolidSpec
from validation.solves.bench import Bench
from validation.solves.press import Press
from validation.studies._study import StudyOptions
from validation.units import Positive

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing

__all__ = ["Options", "figures", "findings", "run", "solve_of"]

Array = NDArray[np.float64]

_SOLID = SolidSpec(young=1e9, poisson=0.3)


class Options(StudyOptions):
    """What is pressed, and how often."""

    reduced_pressures: Annotated[tuple[Positive, ...], Field(min_length=1)] = Field(
        default=(0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
        description="p* = p0 / (E* h'_rms) with the realised gradient",
    )
    seed: int = Field(default=11, ge=0, description="whole number that names the first surface")
    surfaces: int = Field(default=4, ge=2, description="how many; the standard error is that over surfaces")
    grids: tuple[int, ...] = Field(
        default=(64, 96, 128),
        description="points along a side; at least two with 3 points per shortest wave or more, coarser ones are "
        "run, labelled and left out of the limit",
    )
    hurst: float = Field(default=0.8, ge=0, le=1, description="Hurst exponent H")
    periods: float = Field(default=2.0, ge=1, description="L / lambda_long")
    bandwidth: float = Field(default=4.0, gt=1, description="lambda_long / lambda_short")


def solve_of(options: Options, *, surface: int, reduced_pressure: float, points: int) -> Press:
    """Return one solve: a surface at a load on a grid."""
    length = 1e-4
    rough = SelfAffineSurface(
        kind="self-affine",
        length=(length, length),
        hurst=options.hurst,
        lambda_long=length / options.periods,
        lambda_short=length / options.periods / options.bandwidth,
        rms_gradient=0.1,
        seed=options.seed + surface,
    )
    realised = Realised(surface=rough, solid=_SOLID, load=Load(reduced_pressure=reduced_pressure))
    return Press(method="bem", grid=(points, points), realised=realised)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve every surface at every load on every grid, and take the limit over the grids.

    Returns
    -------
    xarray.Dataset
        Over `reduced_pressure`: mean limit of A/A0 over the surfaces, its standard error (surfaces and grids), the
        uncertainty of a single limit, kappa, and Persson's A/A0; NaN where a contact is too small for a limit.

    Raises
    ------
    UsageError
        For grids that give no limit.
    """
    resolved = _resolved(options.grids, waves=options.periods * options.bandwidth)
    cases = list(itertools.product(options.reduced_pressures, range(options.surfaces)))
    wanted = {
        (load, k, n): solve_of(options, reduced_pressure=load, surface=k, points=n)
        for (load, k), n in itertools.product(cases, options.grids)
    }
    solved = bench.solve(wanted.values())
    area = np.zeros((len(options.reduced_pressures), options.surfaces))
    error, theory = np.zeros_like(area), np.zeros_like(area)
    for position, (load, k) in zip(np.ndindex(area.shape), cases, strict=True):
        own = [wanted[load, k, n] for n in resolved]
        limit = located_limit([contact_areas(solved[solve], subcell=True) for solve in own])
        area[position], error[position] = limit.value, limit.uncertainty
        realised = own[0].realised
        variance = elastic.stress_variance(
            realised.field.moments[1], contact_modulus=realised.contact_modulus
        )
        theory[position] = elastic.contact_area(realised.pressure, stress_variance=variance)
    attributes = {
        "methods": "theory bem",
        "surfaces": options.surfaces,
        "grids": _names(resolved),
        "left_out": _names(n for n in options.grids if n not in resolved),
    }
    return _dataset(area, error, theory, loads=np.asarray(options.reduced_pressures), attributes=attributes)


def _dataset(
    area: Array, error: Array, theory: Array, *, loads: Array, attributes: dict[str, Any]
) -> xr.Dataset:
    """Average over the surfaces, the second axis of all arrays."""
    import xarray as xr

    mean, spread = area.mean(axis=1), area.std(axis=1, ddof=1) / np.sqrt(area.shape[1])
    grid_error = np.sqrt(np.mean(error**2, axis=1))
    # Grids are off to the same side on all surfaces of a spectrum: their error does not average out.
    both = np.array([combined(*pair) for pair in zip(spread, grid_error, strict=True)])
    columns = {
        "area": (mean, "A/A0, limit over grids"),
        "area_error": (both, "standard error: surfaces and grids"),
        "scatter_error": (spread, "standard error over surfaces alone"),
        "grid_error": (grid_error, "uncertainty of one limit, root mean square"),
        "kappa": (mean / loads, "kappa = (A/A0) / p*"),
        "kappa_error": (both / loads, "standard error: surfaces and grids"),
        "persson": (theory.mean(axis=1), "A/A0, Persson with the realised gradient"),
    }
    load = ("reduced_pressure", loads, {"units": "1", "long_name": "p* = p0 / (E* h'_rms)"})
    return xr.Dataset(
        {
            name: ("reduced_pressure", values, {"units": "1", "long_name": words})
            for name, (values, words) in columns.items()
        },
        coords={"reduced_pressure": load},
        attrs=attributes,
    )


def _names(grids: Iterable[int]) -> str:
    return ", ".join(f"{n} x {n}" for n in grids)


def _resolved(grids: Sequence[int], *, waves: float) -> tuple[int, ...]:
    """Return the grids of at least 3 points per shortest wave, of which there are `waves` along a side."""
    found = tuple(dict.fromkeys(n for n in grids if n / waves >= LEAST_POINTS_PER_WAVE * (1 - 1e-9)))
    if len(found) < 2:
        raise UsageError(
            f"grids = {', '.join(map(str, grids))}: a limit needs two grids of at least {LEAST_POINTS_PER_WAVE:g} points per "
            f"shortest wave; here that is {int(np.ceil(LEAST_POINTS_PER_WAVE * waves - 1e-9))} or more along a side"
        )
    return found


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say how kappa and the distance to the theory change from the lightest to the heaviest load."""
    from validation.comparison.findings import percent
    from validation.report.words import with_error

    loads, kappa, error = (data[name].values for name in ("reduced_pressure", "kappa", "kappa_error"))
    share, persson = data["grid_error"].values / data["area"].values, data["persson"].values
    sentences = []
    for k in sorted({0, len(loads) // 2, len(loads) - 1}):
        if not np.isfinite(kappa[k]):
            sentences.append(
                f"At p* = {loads[k]:.3g} kappa is not determinable: a contact has too few points on the finest grid."
            )
            continue
        distance = float(data["area"].values[k] / persson[k] - 1)
        sentences.append(
            f"At p* = {loads[k]:.3g} kappa = {with_error(float(kappa[k]), float(error[k]))} (standard error over "
            f"{data.attrs['surfaces']} surfaces and of the grids, which alone is {percent(float(share[k]))}); the area "
            f"lies {percent(abs(distance))} {'above' if distance > 0 else 'below'} Persson's theory."
        )
    left_out = data.attrs.get("left_out", "")
    if left_out:
        sentences.append(
            f"Under-resolved (fewer than {LEAST_POINTS_PER_WAVE:g} points per shortest wave), run and left out of every "
            f"limit: {left_out}."
        )
    return tuple(sentences)


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area and kappa against load."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure

    with_theory = data.assign(
        persson_kappa=data["persson"] / data["reduced_pressure"],
    )
    with_theory["persson_kappa"].attrs = {
        "units": "1",
        "long_name": "kappa, Persson with the realised gradient",
    }
    return (
        Drawing(
            name="area",
            figure=lines_figure(data, x="reduced_pressure", lines=("area", "persson"), logarithmic="xy"),
            data=data[["area", "area_error", "scatter_error", "grid_error", "persson"]],
            caption="Contact area against load: limit over the grids, mean and standard error (surfaces and "
            "grids), beside Persson's theory for the same surfaces.",
        ),
        Drawing(
            name="kappa",
            figure=lines_figure(
                with_theory, x="reduced_pressure", lines=("kappa", "persson_kappa"), logarithmic="x"
            ),
            data=with_theory[["kappa", "kappa_error", "persson_kappa"]],
            caption="Area over load, kappa: constant where contact grows in proportion to load.",
        ),
    )
