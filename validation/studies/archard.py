"""Does the contact area become proportional to the load as bumps are put on bumps (Archard 1957)?

A wave in both directions stands for the largest sphere; shorter and lower ones cover it, level by level. Boundary elements
press it, and the power of the load that its area goes with stands beside Archard's 2/3, 8/9, 26/27 (Persson 2006, Sec. 1).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from fem_contact.response import HalfSpace
from fem_contact.surface import HeightField
from persson.archard import archard_hierarchy
from validation.arrays import Array
from validation.measures.common import (
    BASE_SOLID,
    Rising,
    RisingGrids,
    draw_means,
    each,
    means_of,
    named,
    over_surfaces,
    results_of,
)
from validation.measures.flow import located_area
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction
from validation.studies._options import Seed, Surfaces
from validation.studies._study import StudyOptions
from validation.units import Positive, wrong

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Hierarchy", "Options", "figures", "findings", "run", "table"]

#: Amplitude of the largest wave over the period: it scales out.
_SLOPE = 0.01
#: Points of a grid on the shortest wave, fewer than which tell nothing of its bumps.
_LEAST = 4


class Options(StudyOptions):
    """Which bumps on which, and how they are pressed."""

    own = "its surface is a hierarchy of bumps, not one of a spectrum"

    waves: RisingGrids = Field(
        default=(16, 128), description="waves of the second level on a period, of the third, ...; rising"
    )
    heights: Annotated[tuple[Positive, ...], Field(min_length=1)] = Field(
        default=(0.2, 0.08), description="their heights over that of the first level, one for each"
    )
    loads: Rising = Field(
        default=(0.002, 0.004, 0.008, 0.016, 0.032, 0.064),
        min_length=2,
        description="p0 / (E* height of the first level / period), rising",
    )
    surfaces: Surfaces = 4
    grids: Annotated[RisingGrids, Field(min_length=2)] = Field(
        default=(512, 1024),
        description="points along a side, rising; the change from the last but one is the uncertainty of the grid",
    )
    seed: Seed = 2006

    @model_validator(mode="after")
    def _bumps_are_resolved(self) -> Options:
        if len(self.heights) != len(self.waves):
            raise wrong(
                f"--heights: {len(self.heights)} of {len(self.waves)} levels; give one for each of --waves"
            )
        if self.grids[0] < _LEAST * self.waves[-1]:
            raise wrong(
                f"--grids = {self.grids[0]}: {self.waves[-1]} waves take {_LEAST * self.waves[-1]} points or more"
            )
        return self


@dataclass(frozen=True, kw_only=True)
class Hierarchy(NumbersSolve):
    """One hierarchy on one grid along a path of loads.

    Attributes
    ----------
    waves : tuple of int
        Waves of each level on a period, from 1.
    heights : tuple of float
        Of each level, over that of the first.
    places : tuple of (float, float)
        By how much of a period each level is moved.
    loads : tuple of float
        p0 / (E* H_0 / L), rising.
    points : int
        Along a side.
    """

    waves: tuple[int, ...]
    heights: tuple[float, ...]
    places: tuple[tuple[float, float], ...]
    loads: tuple[float, ...]
    points: int

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {
            "waves": list(self.waves),
            "heights": list(self.heights),
            "places": [list(place) for place in self.places],
            "loads": list(self.loads),
            "points": self.points,
            "edges": LOCATED_EDGES,
            "version": 1,
        }

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"archard-{len(self.waves)}-{self.points}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"{len(self.waves)} levels of bumps, {self.points}x{self.points}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost from the number of points."""
        n = self.points**2
        return Prediction(seconds=len(self.loads) * (2e-3 + 8e-7 * n), peak_bytes=120 * n, unknowns=n)

    def field(self) -> HeightField:
        r"""Heights on a period of 1: sum over the levels of H_k / 2 [cos(2 pi n_k x) + cos(2 pi n_k y)]."""
        x = np.arange(self.points) / self.points
        total = np.zeros((self.points, self.points))
        for count, height, (along, across) in zip(self.waves, self.heights, self.places, strict=True):
            first, second = (np.cos(2 * np.pi * count * (x + place)) for place in (along, across))
            total += _SLOPE * height / 2 * (first[:, None] + second[None, :])
        return HeightField(heights=total, lengths=(1.0, 1.0))

    @property
    def radii(self) -> list[float]:
        """Radius of curvature of the tops of each level, on a period of 1: 1 / (2 pi^2 n_k^2 H_k)."""
        return [
            1 / (2 * math.pi**2 * count**2 * _SLOPE * height)
            for count, height in zip(self.waves, self.heights, strict=True)
        ]

    def measure(self) -> xr.Dataset:
        """Press along the path of loads, each from the one before; located A/A0, NaN where too few points touch."""
        import xarray as xr

        from fem_contact import bem

        field, start, areas = self.field(), None, []
        half_space = HalfSpace(solid=BASE_SOLID.elastic)
        for load in self.loads:
            pressure = load * _SLOPE * half_space.contact_modulus
            solved = bem.solve(field, half_space, mean_pressure=pressure, start=start, threads=1).checked()
            start = solved.pressure
            few = np.count_nonzero(solved.in_contact) < LEAST_CONTACT_POINTS
            areas.append(np.nan if few else located_area(solved))
        return xr.Dataset({"area": ("load", areas)})

    def theory(self) -> tuple[Array, float]:
        """A/A0 of Archard's spheres with these radii and densities, and the power of the load."""
        densities = [float(count**2) for count in self.waves[1:]]
        found = archard_hierarchy(
            np.array(self.loads) * _SLOPE, radii=self.radii, densities=densities, contact_modulus=1.0
        )
        return np.asarray(found.area), found.exponent


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press hierarchies of one level, two, and so on, with the levels moved against each other.

    Returns
    -------
    xarray.Dataset
        Located `area` A/A0 over (level, surface, grid, load), where surfaces differ in how the levels are moved; `theory`
        and `theory_exponent` of Archard's spheres; `exponent`, the slope of ln A over ln p0 by least squares.
    """
    import xarray as xr

    cases = _cases(options)
    found = results_of(bench, cases)
    levels, shape = len(options.waves) + 1, (options.surfaces, len(options.grids))
    area = np.array(
        [
            [[found[n, k, g].area.values for g in range(shape[1])] for k in range(shape[0])]
            for n in range(levels)
        ]
    )
    loads = np.array(options.loads)
    theory = [cases[n, 0, 0].theory() for n in range(levels)]
    x = np.log(loads) - np.log(loads).mean()
    slope = np.log(area) @ x / (x @ x)
    return xr.Dataset(
        {
            "area": named(("level", "surface", "grid", "load"), area, "A/A0, located"),
            "exponent": named(("level", "surface", "grid"), slope, "d ln A / d ln p0"),
            "theory": named(("level", "load"), [one[0] for one in theory], "A/A0, Archard"),
            "theory_exponent": named("level", [one[1] for one in theory], "power of the load, Archard"),
        },
        coords={
            "levels": ("level", np.arange(1, levels + 1)),
            "points": ("grid", list(options.grids)),
            "reduced_pressure": named("load", loads, "p0 L / (E* H_0)"),
        },
        attrs={"study": "archard", "methods": "theory bem", "shortest": options.waves[-1]},
    )


def _cases(options: Options) -> dict[tuple[int, int, int], Hierarchy]:
    """List one case for each number of levels, surface and grid; the levels are moved as the seed says."""
    counts, heights = (1, *options.waves), (1.0, *options.heights)
    moved = np.random.default_rng(options.seed).random((options.surfaces, len(counts), 2))
    return {
        (n, k, g): Hierarchy(
            waves=counts[: n + 1],
            heights=heights[: n + 1],
            places=tuple((float(x), float(y)) for x, y in moved[k, : n + 1]),
            loads=options.loads,
            points=points,
        )
        for n, k, (g, points) in itertools.product(
            range(len(counts)), range(options.surfaces), enumerate(options.grids)
        )
    }


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each number of levels and load, on the finest grid."""
    rows = []
    for here in each(dataset.isel(grid=-1), "level", "load"):
        area, theory = over_surfaces(here.area), float(here.theory)
        rows.append(
            {
                "levels": int(here.levels),
                "p0 L / (E* H_0)": float(here.reduced_pressure),
                "A/A0": area.value,
                "+- (95 %)": area.half_width,
                "A/A0 Archard": theory,
                "ratio": area.value / theory,
            }
        )
    return ResultTable.of_rows(rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say which power of the load the area goes with, level by level, and whether it approaches 1."""
    sentences, found = [], []
    for n in range(dataset.sizes["level"]):
        power, grid = over_surfaces(dataset.exponent[n, :, -1]), _grid_share(dataset, n)
        found.append((power.value, float(np.hypot(power.half_width, grid))))
        ratios = (dataset.area[n, :, -1].mean("surface") / dataset.theory[n]).values
        sentences.append(
            f"{int(dataset.levels[n])} level{'s' if n else ''}: A goes with the load to the power {power} (95 % over {power.samples} positions of the levels, "
            f"{int(dataset.points[-1])} points along a side; the grid: {grid:.2g}); Archard {float(dataset.theory_exponent[n]):.4g}. "
            f"A over Archard's is {ratios[0]:.3g} at the lightest and {ratios[-1]:.3g} at the largest load."
        )
    rises = all(
        later - former > np.hypot(error, before)
        for (former, before), (later, error) in itertools.pairwise(found)
    )
    towards = rises and found[-1][0] < 1 + found[-1][1]
    short = ", ".join(f"{1 - value:.2g} +- {error:.2g}" for value, error in found)
    his = ", ".join(f"{1 - float(value):.2g}" for value in dataset.theory_exponent)
    sentences.append(
        f"The power {'rises towards 1 with every level' if towards else 'is not told to rise towards 1 with every level'}: it falls short of it by "
        f"{short} (surfaces and grid), Archard's by {his}."
    )
    return tuple(sentences)


def _grid_share(dataset: xr.Dataset, level: int) -> float:
    """By how much the power changes from the grid before."""
    return abs(float((dataset.exponent[level, :, -1] - dataset.exponent[level, :, -2]).mean()))


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the area over the load, and its local power."""
    return (
        Drawing(
            name="archard",
            figure=_figure(dataset),
            data=dataset,
            caption="Bumps on bumps on a bump. Left: contact area over load, finest grid, mean and 95 % over positions of the levels; lines, Archard's spheres of the "
            "same radii and densities. Right: local power of the load; lines, Archard's 2/3, 8/9, 26/27; open, on the coarsest grid.",
        ),
    )


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import COLOURS, look, new_figure, plain_look

    figure, (left, right) = new_figure(width=9.0, columns=2)
    loads = dataset.reduced_pressure.values
    middles = np.sqrt(loads[1:] * loads[:-1])
    steps = np.diff(np.log(loads))
    for n, level in enumerate(dataset.levels.values):
        label = f"{level} level{'s' if level > 1 else ''}"
        draw_means(left, loads, means_of(dataset.area[n, :, -1]), ls="", label=label, **look(n))
        left.plot(loads, dataset.theory[n], color=COLOURS[n], lw=0.9)
        for g, fill in ((0, "white"), (-1, COLOURS[n])):
            local = np.diff(np.log(dataset.area[n, :, g].values), axis=-1).mean(axis=0) / steps
            right.plot(middles, local, lw=0.6, mfc=fill, **plain_look(n))
        right.axhline(float(dataset.theory_exponent[n]), color=COLOURS[n], lw=0.9, ls="--")
    right.axhline(1.0, color="black", lw=0.8)
    left.set_yscale("log")
    left.set_ylabel(r"$A/A_0$")
    left.legend(fontsize=7)
    right.set_ylabel(r"$d\,\ln A / d\,\ln p_0$")
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_xlabel(r"$p_0 L / (E^* H_0)$")
    return figure
