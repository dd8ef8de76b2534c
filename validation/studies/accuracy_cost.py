"""What does each digit of the contact area cost, for which method and which definition, and do the claimed errors hold?"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.measures.block import BlockMeasurement
from validation.measures.common import at_least, base_surface, ladder, measure, solid_of
from validation.measures.measurement import Measurement, area_limits, grid_for
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies._peer_solve import SOLVERS
from validation.studies._peers import PeerMeasurement, installed_peers

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene
    from validation.solves.solve import NumbersSolve

__all__ = ["figures", "findings", "run", "table"]

_TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)
_AREAS = ("pixel", "perimeter", "subcell")
_ELEMENTS = ("Hex1", "Hex2")

#: Of the solver: its error of the area is a tenth to a half of that, far below all that is to be told apart.
_TOLERANCE, _FINE_TOLERANCE = 1e-5, 1e-8


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressure: float = 0.05,
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 8.0,
    surfaces: int = 12,
    points_per_wave: tuple[float, ...] = (3.0, 4.0, 6.0, 8.0, 12.0, 16.0),
    held_out: tuple[float, ...] = (16.0, 24.0, 32.0),
    fem_points_per_wave: tuple[float, ...] = (4.0, 8.0, 16.0),
    peer_points_per_wave: tuple[float, ...] = (4.0, 8.0, 16.0),
    seed: int = 5006,
) -> xr.Dataset:
    """Measure error and time of every way to an area, against limits from grids that no way has seen.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid.
    bench : Bench, optional
        Where and how the cases run. Times are of the processor; use one worker all the same.
    reduced_pressure : float
        p*.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations; their claimed intervals are checked too, for which sixty are better than twelve.
    points_per_wave : tuple of float
        Grids of the boundary elements, as lambda_short/dx, rising.
    held_out : tuple of float
        Finer grids whose limit is the reference.
    fem_points_per_wave : tuple of float
        Grids of the finite elements (exact reduction).
    peer_points_per_wave : tuple of float
        Grids of tamaas and ContactMechanics, where they are installed; none: they are left out.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        error (way, surface), relative to the reference of the surface; seconds and peak_bytes (way); reference_error; for
        the limits over all coarse grids, claimed (surface): the half width of their 95 % interval, relative.

    Notes
    -----
    All run on one thread; seconds are of its processor, which other work on the machine disturbs least. Memory is that of the arrays of a solve; of a peer, by how much its process grew. A peer's
    solver is stopped as soon as the area it counts is within a tenth of its grid error of the converged count: equal
    error, not equal residual.
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    points_per_wave, held_out = ladder("points_per_wave", points_per_wave), ladder("held_out", held_out)
    surface, solid = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed), solid_of(scene)
    codes = installed_peers() if peer_points_per_wave else ()
    solves = _jobs(
        {"surface": surface, "solid": solid},
        reduced_pressure=reduced_pressure,
        surfaces=surfaces,
        grids={
            "coarse": points_per_wave,
            "fine": held_out,
            "fem": fem_points_per_wave,
            "peers": peer_points_per_wave,
        },
        codes=codes,
    )
    results = iter(measure(bench, [solve for part in solves.values() for solve in part]))
    found = {name: list(itertools.islice(results, len(part))) for name, part in solves.items()}
    limits = [area_limits(data) for data in found["fine"]]
    reference = np.array([value[0] for value, _ in limits])
    uncertainty = np.array([error[0] for _, error in limits]) / reference
    ways = [
        *_bem_ways(found["coarse"]),
        *_single_ways(
            found["fem"], [f"FEM {e}" for e in _ELEMENTS], fem_points_per_wave, ("pixel", "perimeter")
        ),
        *_single_ways(found["peers"], codes, peer_points_per_wave, ("pixel",)),
    ]
    claimed, missed = _claims(found["coarse"], reference)
    return xr.Dataset(
        {
            "error": (("way", "surface"), np.array([way.areas / reference - 1 for way in ways])),
            "seconds": ("way", np.array([way.seconds for way in ways]), {"units": "s"}),
            "peak_bytes": ("way", np.array([way.peak_bytes for way in ways]), {"units": "byte"}),
            "reference_error": (
                "surface",
                uncertainty,
                {"long_name": "standard error of the reference, relative"},
            ),
            "claimed": (
                "surface",
                claimed,
                {"long_name": "half width of the claimed 95 % interval, relative"},
            ),
            "missed": (
                "surface",
                missed,
                {"long_name": "distance of the claimed limit from the reference, relative"},
            ),
        },
        coords={"label": ("way", [way.label for way in ways])},
        attrs={
            "study": "accuracy-cost",
            "reduced_pressure": reduced_pressure,
            "peers": " ".join(codes),
            "absent": " ".join(name for name in SOLVERS if name not in codes),
            "methods": "bem fem perimeter",
        },
    )


def _jobs(
    common: dict[str, Any],
    *,
    reduced_pressure: float,
    surfaces: int,
    grids: dict[str, tuple[float, ...]],
    codes: Sequence[str],
) -> dict[str, list[NumbersSolve]]:
    """List the solves of each part: those of a name or element come together, then those of a grid."""
    points = {part: tuple(grid_for(common["surface"], n) for n in some) for part, some in grids.items()}
    solves: dict[str, list[NumbersSolve]] = {
        part: [
            Measurement(
                realisation=k,
                reduced_pressures=(reduced_pressure,),
                grids=points[part],
                tolerance=tolerance,
                **common,
            )
            for k in range(surfaces)
        ]
        for part, tolerance in (("coarse", _TOLERANCE), ("fine", _FINE_TOLERANCE))
    }
    single: dict[str, Any] = {"reduced_pressure": reduced_pressure, **common}
    solves["fem"] = [
        BlockMeasurement(realisation=k, points=grid[0], element=element, **single)
        for element, grid, k in itertools.product(_ELEMENTS, points["fem"], range(surfaces))
    ]
    solves["peers"] = [
        PeerMeasurement(realisation=k, points=grid[0], code=code, **single)
        for code, grid, k in itertools.product(codes, points["peers"], range(surfaces))
    ]
    return solves


@dataclass(frozen=True, kw_only=True)
class _Way:
    """A way to an area: the areas of all surfaces, and what one surface costs on average."""

    label: str
    areas: np.ndarray
    seconds: float
    peak_bytes: float


def _bem_ways(measured: list[xr.Dataset]) -> list[_Way]:
    """List single grids, shifts averaged, limits over two grids, and over three with shifts."""
    ways = []
    per_wave = measured[0].points_per_wave.values
    for i, name in itertools.product(range(per_wave.size), _AREAS):
        values = np.array([d[name][i, :, 0].values for d in measured])
        seconds = float(np.mean([d.seconds[i, :, 0].values for d in measured]))
        size = float(np.max([d.peak_bytes[i, :, 0].values for d in measured]))
        label = f"BEM {name}, {per_wave[i]:g} per wave"
        ways.append(_Way(label=label, areas=values[:, 0], seconds=seconds, peak_bytes=size))
        ways.append(
            _Way(label=f"{label}, 4 shifts", areas=values.mean(axis=1), seconds=4 * seconds, peak_bytes=size)
        )
    for count, shifts in ((2, 1), (3, 4)):
        for i in range(per_wave.size - count + 1):
            parts = [d.isel(grid=slice(i, i + count), shift=slice(shifts)) for d in measured]
            words = f"BEM limit, {per_wave[i]:g} to {per_wave[i + count - 1]:g} per wave"
            ways.append(
                _Way(
                    label=words + (", 4 shifts" if shifts == 4 else ""),
                    areas=np.array([area_limits(part)[0][0] for part in parts]),
                    seconds=float(np.mean([part.seconds.sum() for part in parts])),
                    peak_bytes=float(np.max([part.peak_bytes for part in parts])),
                )
            )
    return ways


def _single_ways(
    measured: list[xr.Dataset],
    names: Sequence[str],
    per_wave: tuple[float, ...],
    areas: tuple[str, ...],
) -> list[_Way]:
    """List single grids of other methods, whose results come by name, grid and surface."""
    ways: list[_Way] = []
    surfaces = len(measured) // max(len(names) * len(per_wave), 1)
    for k, (name, n) in enumerate(itertools.product(names, per_wave)):
        part = measured[k * surfaces : (k + 1) * surfaces]
        ways.extend(
            _Way(
                label=f"{name} {area}, {n:g} per wave",
                areas=np.array([float(d[area]) for d in part]),
                seconds=float(np.mean([float(d.seconds) for d in part])),
                peak_bytes=float(np.max([float(d.peak_bytes) for d in part])),
            )
            for area in areas
        )
    return ways


def _claims(measured: list[xr.Dataset], reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half widths of the 95 % intervals of the limits over all coarse grids, and how far those limits are off."""
    half, missed = [], []
    for data, truth in zip(measured, reference, strict=True):
        (value,), (error,) = area_limits(data)
        half.append(2 * error / truth)
        missed.append(value / truth - 1)
    return np.array(half), np.array(missed)


def root_mean_square(dataset: xr.Dataset) -> np.ndarray:
    """Return the root mean square error over the surfaces of each way, the error of the reference included."""
    return np.asarray(np.sqrt((dataset.error**2).mean("surface")).values)


def front(dataset: xr.Dataset, cost: str = "seconds") -> list[int]:
    """Return the ways no other beats in both error and cost ("seconds" or "peak_bytes"), cheapest first."""
    error, price = root_mean_square(dataset), dataset[cost].values
    best, kept = np.inf, []
    for k in np.lexsort((error, price)):
        if error[k] < best:
            best = error[k]
            kept.append(int(k))
    return kept


def coverage(dataset: xr.Dataset) -> tuple[int, int]:
    """Return how many claimed intervals hold the reference (with its own interval), and of how many."""
    allowed = np.hypot(dataset.claimed.values, 2 * dataset.reference_error.values)
    return int(np.count_nonzero(np.abs(dataset.missed.values) <= allowed)), int(dataset.sizes["surface"])


def table(dataset: xr.Dataset) -> ResultTable:
    """Return the fastest and the leanest way to each accuracy; below the error of the reference it is not determinable."""
    error = root_mean_square(dataset)
    seconds, size = dataset.seconds.values, dataset.peak_bytes.values / 2**20
    floor = float(np.sqrt((dataset.reference_error**2).mean()))
    rows: list[tuple[float | str, ...]] = []
    for target in _TARGETS:
        good = np.flatnonzero(error <= target)
        if target < 2 * floor:
            words = f"not determinable: the reference is known to {100 * floor:.2g} %"
            rows.append((f"{100 * target:g} %", words, *[""] * 6))
        elif not good.size:
            rows.append((f"{100 * target:g} %", "none of the ways tried", *[""] * 6))
        else:
            fast, lean = (
                int(good[np.lexsort((other[good], price[good]))[0]])
                for price, other in ((seconds, size), (size, seconds))
            )
            cells: list[float | str] = [f"{100 * target:g} %"]
            cells += [
                str(dataset.label.values[fast]),
                100 * float(error[fast]),
                float(seconds[fast]),
                float(size[fast]),
            ]
            cells += [str(dataset.label.values[lean]), float(size[lean]), float(seconds[lean])]
            rows.append(tuple(cells))
    columns = ("accuracy of A/A0", "cheapest way", "rms error [%]", "seconds", "MiB")
    return ResultTable.of((*columns, "leanest way", "its MiB", "its seconds"), rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what a digit costs, whether the claimed intervals hold, and what peers need for the same error."""
    sentences = []
    for row in table(dataset).rows:
        if isinstance(row[3], float):
            sentences.append(
                f"{row[0]} costs {row[3]:.2g} s and {row[4]:.2g} MiB: {row[1]} (rms error {row[2]:.2g} %); with least memory "
                f"{row[6]:.2g} MiB and {row[7]:.2g} s: {row[5]}."
            )
        else:
            sentences.append(f"{row[0]}: {row[1]}.")
    held, total = coverage(dataset)
    sentences.append(
        f"The claimed 95 % intervals of the limits over the coarse grids hold the reference on {held} of {total} surfaces "
        f"({100 * held / total:.0f} %); they are {100 * float(dataset.claimed.mean()):.2g} % wide to either side on average."
    )
    sentences.extend(_against_peer(dataset, code) for code in dataset.attrs["peers"].split())
    absent = dataset.attrs["absent"].split()
    if absent:
        sentences.append(
            f"Not compared, because not installed (extra `peers`) or not asked for: {', '.join(absent)}."
        )
    return tuple(sentences)


def _against_peer(dataset: xr.Dataset, code: str) -> str:
    """Say what the most accurate solve of a peer costs, and what the same error costs here."""
    error, labels = root_mean_square(dataset), dataset.label.values.tolist()
    theirs = min((k for k, label in enumerate(labels) if label.startswith(code)), key=lambda k: error[k])
    ours = [k for k, label in enumerate(labels) if label.startswith("BEM") and error[k] <= error[theirs]]
    said = (
        f"{code}: {labels[theirs].removeprefix(code + ' ')} is off by {100 * error[theirs]:.2g} % after "
        f"{float(dataset.seconds[theirs]):.2g} s with {float(dataset.peak_bytes[theirs]) / 2**20:.2g} MiB"
    )
    if not ours:
        return said + "; none of the ways here is as good."
    best = min(ours, key=lambda k: float(dataset.seconds[k]))
    factor = float(dataset.seconds[theirs] / dataset.seconds[best])
    counted = labels[theirs].replace(code, "BEM")
    plain = ""
    if counted in labels:
        same = float(dataset.seconds[theirs] / dataset.seconds[labels.index(counted)])
        plain = f"; counted on the same grid, {_times(same)}"
    return (
        f"{said}; here that error costs {float(dataset.seconds[best]):.2g} s with "
        f"{float(dataset.peak_bytes[best]) / 2**20:.2g} MiB ({labels[best]}): {_times(factor)} time{plain}."
    )


def _times(factor: float) -> str:
    size = float(f"{max(factor, 1 / factor):.2g}")
    return f"{size:g} times {'less' if factor >= 1 else 'more'}"


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw error against time and against memory."""
    from validation.studies import _plots_studies as plots_studies

    fronts = {cost: front(dataset, cost) for cost in ("seconds", "peak_bytes")}
    return (
        Drawing(
            name="accuracy-cost",
            figure=plots_studies.accuracy_cost(dataset, root_mean_square(dataset), fronts),
            data=dataset[["error", "seconds", "peak_bytes"]],
            caption="Root mean square error of the contact area over the surfaces against the processor time of one surface on one thread (left) and against the memory of the arrays of its largest solve (right; of other codes, by how much their process grew), for every method, grid and definition of the area; the lines join the ways that no other beats; grey, the error of the reference.",
        ),
    )
