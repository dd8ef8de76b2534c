"""How large are contact area, gap, stiffness and energy of self-affine surfaces, with their total uncertainty?

The table that others can check against. Few pairs of surfaces +h, -h are solved on fine grids, more on coarser ones whose
area follows the fine one from surface to surface, most are only looked at; together they give the mean over all surfaces
of a spectrum (`validation.measures.controlled`). It is made once, shipped, and read by `fem-contact reference`.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fem_contact.contact import ContactResult
from fem_contact.stress import initial_slope
from validation.arrays import Array
from validation.measures.common import Ladder, Rising, RisingOrNone, base_case, base_surface, results_of
from validation.measures.ensemble import QUANTITIES
from validation.measures.flow import StiffMeasurement
from validation.measures.measurement import TOLERANCES_LEFT, grid_for
from validation.measures.without_solve import UnsolvedPairs
from validation.scenes.realised import Realised
from validation.scenes.scene import SelfAffineSurface
from validation.scenes.surfaces import spectrum_of
from validation.solves.bench import Bench
from validation.studies._options import Periods, Seed
from validation.studies._study import StudyOptions
from validation.studies.reference.joining import joined, with_size
from validation.studies.reference.loads import BY_SPECTRUM, LoadedSamples
from validation.studies.reference.shown import figures, findings, table
from validation.units import wrong

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES", "Options", "figures", "findings", "run", "table"]

#: Numbers of pairs are those of the options at this bandwidth, and in proportion to its inverse at others: surfaces with
#: fewer waves scatter more and cost less.
_USUAL_BANDWIDTH = 16.0
#: Of the solver.
_TOLERANCE = 1e-6
#: Grids that a limit takes at least, and pairs that tell a variance.
_LEAST_GRIDS, _LEAST_PAIRS = 3, 4
_GREW = (2, 0, 1)
#: Between the seeds of the table and those of larger samples.
_APART = 1_000_000

#: What is a mean over surfaces, and its meaning.
_WORDS = {**QUANTITIES, BY_SPECTRUM: f"{QUANTITIES['area']}, at p* by the gradient of C(q)"}
_READING = f"{BY_SPECTRUM}_reading"


class Options(StudyOptions):
    """Spectra and loads of the table, and how many surfaces each is a mean over."""

    own = "it makes the table that others are checked against, of surfaces it names"

    hursts: Rising = Field(
        default=(0.1, 0.3, 0.5, 0.8, 1.0), description="Hurst exponents H, rising, at most 1"
    )
    bandwidths: Rising = Field(
        default=(4.0, 8.0, 16.0, 32.0), description="lambda_long / lambda_short, rising"
    )
    reduced_pressures: Rising = Field(
        default=(0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5),
        description="p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising",
    )
    periods: Periods = 4.0
    points_per_wave: Ladder = Field(
        default=(3.0, 6.0, 12.0, 24.0), description="grids, as lambda_short/dx, rising"
    )
    largest: int = Field(
        default=500, ge=2, description="points along a side beyond which a fourth or later grid is left out"
    )
    pairs: Annotated[tuple[Annotated[int, Field(ge=2)], ...], Field(min_length=2)] = Field(
        default=(80, 18, 6, 2),
        description="pairs +h, -h at bandwidth 16 that end with each of the grids, coarsest first; elsewhere in "
        "proportion to 1/bandwidth, at least 4",
    )
    wide_pairs: tuple[Annotated[int, Field(ge=2)], ...] = Field(
        default=(40, 4, 4, 2), description="the same beyond bandwidth 16, as they stand, at least 4"
    )
    unsolved: int = Field(
        default=10,
        ge=1,
        description="pairs that are not solved, only looked at, for each that ends with the coarsest grid",
    )
    gaussian: RisingOrNone = Field(
        default=(0.3, 0.8),
        description="those Hurst exponents at which surfaces with Gaussian amplitudes are solved as well",
    )
    gaussian_bandwidths: RisingOrNone = Field(default=(4.0, 8.0), description="and the bandwidths of these")
    larger: RisingOrNone = Field(
        default=(0.3, 0.8),
        description="those at which samples of twice the periods are solved as well, a quarter as many",
    )
    larger_bandwidths: RisingOrNone = Field(default=(4.0, 8.0), description="and the bandwidths of these")
    shifts: int = Field(default=1, ge=1, le=8, description="sub-grid shifts along each axis")
    seed: Seed = 2006

    @model_validator(mode="after")
    def _pairs_for_each_grid(self) -> Self:
        if len(self.pairs) != len(self.points_per_wave):
            raise wrong(f"pairs has {len(self.pairs)} numbers: needs one for each of points_per_wave")
        if len(self.wide_pairs) < len(self.points_per_wave):
            raise wrong(
                f"wide_pairs has {len(self.wide_pairs)} numbers: needs one for each of points_per_wave"
            )
        return self

    def ladder_of(self, bandwidth: float) -> tuple[float, ...]:
        """Return the points per wave of the grids that are solved: three, and more where they are small."""
        whole = self.points_per_wave
        fits = sum(self.periods * bandwidth * points <= self.largest for points in whole)
        return whole[: max(fits, min(len(whole), _LEAST_GRIDS))]

    def pairs_of(self, bandwidth: float) -> tuple[int, ...]:
        """Return how many pairs end with each grid of the ladder."""
        wide = bandwidth > _USUAL_BANDWIDTH
        counts, more = (self.wide_pairs, 1.0) if wide else (self.pairs, _USUAL_BANDWIDTH / bandwidth)
        counts = counts[: len(self.ladder_of(bandwidth))]
        return tuple(max(_LEAST_PAIRS, int(np.ceil(more * count - 1e-9))) for count in counts)

    def part(self, hursts: tuple[float, ...], bandwidths: tuple[float, ...]) -> Self | None:
        """Return the options of those of its spectra that are among some; None where none is."""
        own = {
            "hursts": tuple(value for value in self.hursts if value in hursts),
            "bandwidths": tuple(value for value in self.bandwidths if value in bandwidths),
        }
        return self.model_copy(update=own) if all(own.values()) else None

    def larger_samples(self) -> Self | None:
        """Return what makes the samples of twice the periods; None where nobody asks for one."""
        part = self.part(self.larger, self.larger_bandwidths)
        return part and part.model_copy(
            update={
                "periods": 2 * self.periods,
                "pairs": tuple(-(-count // 4) for count in self.pairs),
                "wide_pairs": tuple(-(-count // 4) for count in self.wide_pairs),
                "seed": self.seed + _APART,
            }
        )


@dataclass(frozen=True, kw_only=True)
class _Rich(StiffMeasurement):
    """A measurement with stiffness and the initial slope of P(sigma)."""

    frozen_tolerance: ClassVar[float] = 1e-3  # K to 1e-6

    @property
    def quantities(self) -> Mapping[str, tuple[str, str]]:
        return {**super().quantities, "slope": ("1", QUANTITIES["slope"])}

    def read_off(self, result: ContactResult, *, located: bool) -> dict[str, float]:
        return super().read_off(result, located=located) | {"slope": initial_slope(result).reduced}


#: A case: Hurst exponent, bandwidth, its last grid, number of the pair, inverted.
_Case = tuple[float, float, int, int, bool]
#: Statistics without a solve: Hurst exponent, bandwidth, of which pairs.
_Name = tuple[float, float, str]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve all pairs of every spectrum, and take the controlled mean of each quantity.

    Returns
    -------
    xarray.Dataset
        Over (amplitudes, hurst, bandwidth, load), NaN where nobody asked, for each of `QUANTITIES` and for `BY_SPECTRUM`:
        the mean, `_half_width` (95 %, over surfaces), `_grid` (half width of what the grids leave, common to all
        surfaces), `_size` where larger samples were asked for, `_reading` of `BY_SPECTRUM`, and `_error`, the root of
        their squares and the solver's; and `saving`, the time that as many fine surfaces as the same interval takes would
        cost over what was spent.
    """
    made = _means(options, "exact", bench)
    if larger := options.larger_samples():
        made = with_size(made, _means(larger, "exact", bench))
    gaussian = options.part(options.gaussian, options.gaussian_bandwidths)
    return joined([made, _means(gaussian, "gaussian", bench)]) if gaussian else made


def _means(options: Options, amplitudes: str, bench: Bench) -> xr.Dataset:
    """Return the controlled means over the surfaces with such amplitudes."""
    solved = results_of(bench, {**_cases(options, amplitudes), **_unsolved(options, amplitudes)})
    shape = (len(options.hursts), len(options.bandwidths), len(options.reduced_pressures))
    values = {f"{name}{part}": np.empty(shape) for name in _WORDS for part in ("", "_half_width", "_grid")}
    values |= {name: np.empty(shape) for name in ("saving", _READING)}
    for at in np.ndindex(shape[:2]):
        samples = _samples(solved, options, options.hursts[at[0]], options.bandwidths[at[1]])
        for name in _WORDS:
            chains = samples.chains(name)
            found = [chain[-1].estimate for chain in chains]
            values[name][at] = [one.value for one in found]
            values[f"{name}_half_width"][at] = [one.half_width for one in found]
            values[f"{name}_grid"][at] = samples.grid_errors(name)
            if name == "area":
                values["saving"][at] = samples.savings(chains)
        values[_READING][at] = samples.reading_errors()
    return _dataset(options, values).expand_dims(amplitudes=[amplitudes])


def _samples(
    solved: Mapping[_Case | _Name, xr.Dataset], options: Options, hurst: float, bandwidth: float
) -> LoadedSamples:
    """Sort what was solved of one spectrum."""
    own = {name[2:]: data for name, data in solved.items() if name[:2] == (hurst, bandwidth)}
    statistics = {name[0]: data for name, data in own.items() if len(name) == 1}
    return LoadedSamples(
        ending=[
            [data for name, data in own.items() if name[0] == last and len(name) > 1]
            for last in range(len(options.ladder_of(bandwidth)))
        ],
        unsolved=statistics["coarsest"].value.values,
        further=statistics["further"].value.values,
        unsolved_seconds=sum(float(data.attrs["seconds"]) for data in statistics.values()),
        periods=options.periods,
        loads=np.array(options.reduced_pressures),
        gradient=float(spectrum_of(_surface(options, hurst, bandwidth)).m2() ** 0.5),
    )


def _dataset(options: Options, values: dict[str, Array]) -> xr.Dataset:
    """Return all numbers with their names, and how they were made."""
    import xarray as xr

    dims = ("hurst", "bandwidth", "reduced_pressure")
    meanings = {"saving": "time of plain means of the same interval over the time spent"} | _WORDS
    for name in _WORDS:
        parts = [values[f"{name}{part}"] for part in ("_half_width", "_grid")]
        if name == BY_SPECTRUM:
            parts.append(values[_READING])
        values[f"{name}_error"] = np.sqrt(
            sum(part**2 for part in parts) + (TOLERANCES_LEFT * _TOLERANCE * values[name]) ** 2
        )
        for part, what in (
            ("half_width", "over surfaces"),
            ("grid", "of the grid limit"),
            ("reading", "of the interpolation to these loads"),
            ("error", "of all parts"),
        ):
            meanings[f"{name}_{part}"] = f"half of the 95 % interval {what}"
    data: dict[str, Any] = {
        name: (dims, numbers, {"long_name": meanings[name]}) for name, numbers in values.items()
    }
    for name in _WORDS:
        data[name][2]["units"] = "1"
    data["pairs"] = (dims[:2], _pairs_text(options), {"long_name": "pairs +h, -h that end with a grid"})
    axes = {"bandwidth": "lambda_long / lambda_short", "reduced_pressure": "p* = p0 / (E* h'_rms)"}
    return xr.Dataset(
        data,
        coords={"hurst": list(options.hursts)}
        | {
            name: (name, list(getattr(options, f"{name}s")), {"long_name": meaning})
            for name, meaning in axes.items()
        },
        attrs={
            "study": "reference",
            "methods": "bem",
            "periods": options.periods,
            "unsolved": options.unsolved,
            "tolerance": _TOLERANCE,
            "seed": options.seed,
        },
    )


def _pairs_text(options: Options) -> NDArray[np.str_]:
    """Say of each spectrum how many pairs end with which points per wave."""
    texts = [
        ", ".join(
            f"{count} on {points:g}"
            for count, points in zip(options.pairs_of(b), options.ladder_of(b), strict=True)
        )
        for b in options.bandwidths
    ]
    return np.array([texts] * len(options.hursts))


def _surface(options: Options, hurst: float, bandwidth: float) -> SelfAffineSurface:
    return base_surface(hurst=hurst, periods=options.periods, bandwidth=bandwidth, seed=options.seed)


def _base(options: Options, hurst: float, bandwidth: float, amplitudes: str) -> Realised:
    surface = _surface(options, hurst, bandwidth).model_copy(update={"amplitudes": amplitudes})
    return base_case(surface, reduced_pressure=options.reduced_pressures[0])


def _lasts(options: Options, bandwidth: float) -> list[int]:
    """Return the last grid of each pair. They are numbered in the order in which the table grew, which keeps its solves."""
    counts = options.pairs_of(bandwidth)
    order = sorted(range(len(counts)), key=lambda last: _GREW.index(last) if last in _GREW else last)
    return [last for last in order for _ in range(counts[last])]


def _cases(options: Options, amplitudes: str) -> dict[_Case, _Rich]:
    """List all surfaces of all spectra, each with the grids it is solved on."""
    found = {}
    for hurst, bandwidth in itertools.product(options.hursts, options.bandwidths):
        base = _base(options, hurst, bandwidth, amplitudes)
        grids = tuple(grid_for(base, points) for points in options.ladder_of(bandwidth))
        pairs = enumerate(_lasts(options, bandwidth))
        for (k, last), inverted in itertools.product(pairs, (False, True)):
            found[hurst, bandwidth, last, k, inverted] = _Rich(
                realised=replace(base.further(k), inverted=inverted),
                reduced_pressures=options.reduced_pressures,
                grids=grids[: last + 1],
                shifts=options.shifts,
                tolerance=_TOLERANCE,
            )
    return found


def _unsolved(options: Options, amplitudes: str) -> dict[_Name, UnsolvedPairs]:
    """List the statistics without a solve: of the pairs that end with the coarsest grid, and of further ones."""
    found = {}
    for hurst, bandwidth in itertools.product(options.hursts, options.bandwidths):
        base, lasts = _base(options, hurst, bandwidth, amplitudes), _lasts(options, bandwidth)
        grid, coarsest = grid_for(base, options.points_per_wave[0]), lasts.count(0)
        for name, first, count in (
            ("coarsest", lasts.index(0), coarsest),
            ("further", len(lasts), coarsest * options.unsolved),
        ):
            found[hurst, bandwidth, name] = UnsolvedPairs(realised=base, grid=grid, first=first, count=count)
    return found
