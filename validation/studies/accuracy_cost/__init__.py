"""What does each digit of the contact area cost, for which method and which definition, and do the claimed errors hold?"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from validation.measures.block import BlockMeasurement
from validation.measures.common import Ladder, RisingOrNone, results_of
from validation.measures.measurement import Measurement, area_limits, grid_for
from validation.measures.side_by_side import ByMethod
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies._options import Methods, ReducedPressure, Seed, Surfaces
from validation.studies._scene import Asked, PressedOptions
from validation.studies.accuracy_cost.peer_solve import OWN, SOLVERS
from validation.studies.accuracy_cost.peers import PeerMeasurement, code_words, installed_peers

if TYPE_CHECKING:
    import xarray as xr

    from validation.solves.solve import NumbersSolve

__all__ = [
    "Options",
    "coverage",
    "figures",
    "findings",
    "front",
    "root_mean_square",
    "run",
    "table",
]

_TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)
_AREAS = ("pixel", "perimeter", "subcell")
_ELEMENTS = ("Hex1", "Hex2")

#: Methods of this project by the packages that they call: what is to be cited for them.
_METHODS = {"tamaas": "tamaas", "ContactMechanics": "contact_mechanics"}

#: Of the solver: its error of the area is a tenth to a half of that, far below all that is to be told apart.
_TOLERANCE, _FINE_TOLERANCE = 1e-5, 1e-8


class Options(PressedOptions):
    """Surfaces and grids. Times are of the processor; use one worker all the same."""

    off: ClassVar[Mapping[str, Any]] = {"fem_points_per_wave": (), "peer_points_per_wave": ()}
    plain = "what a digit costs is asked of the located area, which the bare half-space has"

    methods: Methods = ("bem", "fem")
    reduced_pressure: ReducedPressure = 0.05
    surfaces: Annotated[
        Surfaces,
        Field(
            description="how many; their claimed intervals are checked too, for which sixty are better than twelve"
        ),
    ] = 12
    seed: Seed = 5006
    points_per_wave: Ladder = Field(
        default=(3.0, 4.0, 6.0, 8.0, 12.0, 16.0),
        description="grids of the boundary elements, as lambda_short/dx, rising",
    )
    held_out_points_per_wave: Ladder = Field(
        default=(16.0, 24.0, 32.0), description="finer grids whose limit is the reference"
    )
    fem_points_per_wave: RisingOrNone = Field(
        default=(4.0, 8.0, 16.0), description="grids of the finite elements (exact reduction)"
    )
    peer_points_per_wave: RisingOrNone = Field(
        default=(4.0, 8.0, 16.0),
        description="grids of tamaas and ContactMechanics, where they are installed and no other methods are asked for, "
        "at equal error; none: they are left out",
    )
    method_points_per_wave: RisingOrNone = Field(
        default=(4.0, 8.0, 16.0),
        description="grids of any other of the methods, which are asked for the same tolerance of their residuals",
    )

    @property
    def peers(self) -> tuple[str, ...]:
        """Codes that are compared at equal error: those that are installed, where nobody names methods."""
        asked = "methods" not in self.model_fields_set and self.peer_points_per_wave
        return installed_peers() if asked else ()


#: A part of the study, then what is told apart in it: element or code, grid, number of the surface.
_Case = tuple[str | float | int, ...]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure error and time of every way to an area, against limits from grids that no way has seen.

    Returns
    -------
    xarray.Dataset
        error (way, surface), relative to the reference of the surface; seconds and peak_bytes (way); reference_error; for
        the limits over all coarse grids, claimed (surface): the half width of their 95 % interval, relative.

    Notes
    -----
    All run on one thread; seconds are of its processor, which other work on the machine disturbs least. Memory is that
    of the arrays of a solve; of a peer, by how much its process grew, and ours are solved in such a process, too, to be
    put beside it. The areas of all are read off their pressures by one code. A peer's solver is stopped as soon as the area it
    counts is within a tenth of its grid error of the converged count: equal error, not equal residual. A method that is
    asked for by name is told the tolerance that the boundary elements are told.
    """
    own = ("bem",) if options.scene is not None else ("bem", "fem")
    others = options.others(options.method_points_per_wave, without=own)
    return _dataset(results_of(bench, _cases(options, others)), options, others)


def _codes(options: Options) -> tuple[str, ...]:
    """Codes that are solved in a process of their own: the peers, and ours beside them."""
    return (*options.peers, OWN) if options.peers else ()


def _blocks(options: Options) -> tuple[tuple[str, float], ...]:
    """List element and grid of the study's own blocks."""
    asked = options.fem_points_per_wave if "fem" in options.methods else ()
    return tuple(itertools.product(_ELEMENTS, asked))


def _cases(options: Options, others: Sequence[Asked]) -> dict[_Case, NumbersSolve]:
    """List the solves of each part."""
    first, pressed = options.first, dict(enumerate(options.pressed))
    cases: dict[_Case, NumbersSolve] = {}
    held_out = tuple(grid_for(first, n) for n in options.held_out_points_per_wave)
    for part, grids, tolerance in (
        ("coarse", options.grids_for(options.points_per_wave), options.tolerance(_TOLERANCE)),
        ("fine", held_out, _FINE_TOLERANCE),
    ):
        for k, own in pressed.items():
            cases[part, k] = Measurement(realised=own, grids=grids, tolerance=tolerance)
    for (element, n), k in itertools.product(_blocks(options), pressed):
        cases["FEM", element, n, k] = BlockMeasurement(
            realised=pressed[k], grid=grid_for(first, n), element=element
        )
    for code, n, k in itertools.product(_codes(options), options.peer_points_per_wave, pressed):
        cases["peers", code, n, k] = PeerMeasurement(realised=pressed[k], grid=grid_for(first, n), code=code)
    for asked, k in itertools.product(others, pressed):
        told = {"tolerance": _TOLERANCE, **dict(asked.settings)}
        for g, grid in enumerate(asked.grids):
            cases["others", asked.name, g, k] = ByMethod(
                realised=pressed[k], grid=grid, method=asked.method, settings=tuple(told.items())
            )
    return cases


def _dataset(found: Mapping[_Case, xr.Dataset], options: Options, others: Sequence[Asked]) -> xr.Dataset:
    import xarray as xr

    codes = options.peers

    surfaces = range(options.surfaces)
    coarse = [found["coarse", k] for k in surfaces]
    limits = [area_limits(found["fine", k]) for k in surfaces]
    reference = np.array([value[0] for value, _ in limits])
    uncertainty = np.array([error[0] for _, error in limits]) / reference
    ways = _bem_ways(coarse)
    for element, n in _blocks(options):
        part = [found["FEM", element, n, k] for k in surfaces]
        ways += [_single_way(part, area, f"FEM {element}", n) for area in ("pixel", "perimeter")]
    for code, n, area in itertools.product(_codes(options), options.peer_points_per_wave, _AREAS):
        part = [found["peers", code, n, k] for k in surfaces]
        ways.append(_single_way(part, area, code, n, process=True))
    for asked in others:
        for g, grid in enumerate(asked.grids):
            part = [found["others", asked.name, g, k] for k in surfaces]
            per_wave = options.first.points_per_wave(grid)
            ways += [
                _single_way(part, area, asked.name, per_wave, process=asked.method not in ("bem", "fem"))
                for area in _AREAS
                if np.isfinite([float(one[area]) for one in part]).all()
            ]
    claimed, missed = _claims(coarse, reference)
    said = {
        "reference_error": (uncertainty, "standard error of the reference, relative"),
        "claimed": (claimed, "half width of the claimed 95 % interval, relative"),
        "missed": (missed, "distance of the claimed limit from the reference, relative"),
    }
    return xr.Dataset(
        {
            "error": (("way", "surface"), np.array([way.areas / reference - 1 for way in ways])),
            "seconds": ("way", np.array([way.seconds for way in ways]), {"units": "s"}),
            "peak_bytes": ("way", np.array([way.peak_bytes for way in ways]), {"units": "byte"}),
            **{name: ("surface", values, {"long_name": words}) for name, (values, words) in said.items()},
        },
        coords={
            "label": ("way", [way.label for way in ways]),
            "process": ("way", [way.process for way in ways], {"long_name": "memory of a process"}),
        },
        attrs={
            "study": "accuracy-cost",
            "reduced_pressure": options.reduced_pressure,
            "peers": " ".join([*codes, *(asked.name for asked in others)]),
            "absent": " ".join(n for n in SOLVERS if n not in (*codes, OWN)) if not others else "",
            "measured_by": code_words(_codes(options)) if codes else "",
            "unsettled": _unsettled(found),
            "methods": " ".join(
                [
                    *("bem", *(["fem"] if _blocks(options) else [])),
                    *(a.method for a in others),
                    *(_METHODS[code] for code in codes),
                    "perimeter",
                ]
            ),
        },
    )


def _unsettled(found: Mapping[_Case, xr.Dataset]) -> str:
    """Name the methods with answers whose residuals are not what was asked for, and count these."""
    missed: dict[str, int] = {}
    for case, data in found.items():
        if case[0] == "others" and float(data.converged) < 1:
            missed[str(case[1])] = missed.get(str(case[1]), 0) + 1
    return ", ".join(f"{name} {count}" for name, count in missed.items())


@dataclass(frozen=True, kw_only=True)
class _Way:
    """A way to an area: the areas of all surfaces, and what one surface costs on average.

    Memory is that of arrays, or by how much a process grew: the two are not compared.
    """

    label: str
    areas: np.ndarray
    seconds: float
    peak_bytes: float
    process: bool = False


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


def _single_way(
    measured: Sequence[xr.Dataset], area: str, name: str, per_wave: float, *, process: bool = False
) -> _Way:
    """Return the area of another method on one grid of all surfaces."""
    return _Way(
        label=f"{name} {area}, {per_wave:g} per wave",
        areas=np.array([float(d[area]) for d in measured]),
        seconds=float(np.mean([float(d.seconds) for d in measured])),
        peak_bytes=float(np.max([float(d.peak_bytes) for d in measured])),
        process=process,
    )


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


def alike(dataset: xr.Dataset) -> np.ndarray:
    """Tell whose memory is measured alike: by process where other codes are there, else by arrays."""
    process = np.asarray(dataset.process.values, dtype=bool)
    return process if dataset.attrs["peers"] and process.any() else ~process


def front(dataset: xr.Dataset, cost: str = "seconds") -> list[int]:
    """Return the ways no other beats in both error and cost ("seconds" or "peak_bytes"), cheapest first."""
    error, price = root_mean_square(dataset), dataset[cost].values
    compared = alike(dataset) if cost == "peak_bytes" else np.ones(price.size, dtype=bool)
    best, kept = np.inf, []
    for k in np.lexsort((error, price)):
        if error[k] < best and compared[k]:
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
        elif np.all(dataset.process.values[good]):
            rows.append((f"{100 * target:g} %", "none of the ways tried", *[""] * 6))
        else:
            # Arrays and processes are no one measure of memory: the leanest way is one of ours, by its arrays.
            own = good[~np.asarray(dataset.process.values, dtype=bool)[good]]
            fast, lean = (
                int(some[np.lexsort((other[some], price[some]))[0]])
                for some, price, other in ((own, seconds, size), (own, size, seconds))
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
    if dataset.attrs["measured_by"]:
        sentences.append(
            f"Peers and ours are solved alike, each in a process of its own, areas by one code: {dataset.attrs['measured_by']}."
        )
    if dataset.attrs.get("unsettled"):
        sentences.append(
            f"Answers without the residuals that were asked for, counted all the same: {dataset.attrs['unsettled']}."
        )
    absent = dataset.attrs["absent"].split()
    if absent:
        sentences.append(
            f"Not compared, because not installed (extra `peers`) or not asked for: {', '.join(absent)}."
        )
    return tuple(sentences)


def _against_peer(dataset: xr.Dataset, code: str) -> str:
    """Say what the most accurate solve of a peer costs, and what the same error costs here."""
    error, labels = root_mean_square(dataset), dataset.label.values.tolist()
    theirs = min(
        (k for k, label in enumerate(labels) if label.startswith(f"{code} ")), key=lambda k: error[k]
    )
    ours = [k for k, label in enumerate(labels) if label.startswith("BEM") and error[k] <= error[theirs]]
    way = labels[theirs].removeprefix(f"{code} ")
    said = f"{code}: {way} is off by {100 * error[theirs]:.2g} % after {float(dataset.seconds[theirs]):.2g} s"
    twin = f"{OWN} {way}"
    if twin in labels:
        k = labels.index(twin)
        grown = [float(dataset.peak_bytes[j]) / 2**20 for j in (theirs, k)]
        factor = _times(float(dataset.seconds[theirs] / dataset.seconds[k]))
        said += (
            f"; the same area on the same grid is off by {100 * error[k]:.2g} % here, in {factor} time; its process grew by "
            f"{grown[0]:.2g} MiB, ours by {grown[1]:.2g} MiB"
        )
    if not ours:
        return said + "; none of the ways here is as good."
    best = min(ours, key=lambda k: float(dataset.seconds[k]))
    factor = _times(float(dataset.seconds[theirs] / dataset.seconds[best]))
    return f"{said}; the cheapest way here to that error costs {float(dataset.seconds[best]):.2g} s ({labels[best]}): {factor} time."


def _times(factor: float) -> str:
    size = float(f"{max(factor, 1 / factor):.2g}")
    return f"{size:g} times {'less' if factor >= 1 else 'more'}"


def _memory_words(dataset: xr.Dataset) -> str:
    by_process = bool(dataset.process.values[alike(dataset)].all())
    return "by how much its process grew, for those measured so" if by_process else "that of its arrays"


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw error against time and against memory."""
    from validation.studies.accuracy_cost.plots import error_against_cost

    fronts = {cost: front(dataset, cost) for cost in ("seconds", "peak_bytes")}
    return (
        Drawing(
            name="accuracy-cost",
            figure=error_against_cost(dataset, root_mean_square(dataset), fronts, alike=alike(dataset)),
            data=dataset[["error", "seconds", "peak_bytes"]],
            caption="Root mean square error of the contact area over the surfaces against the processor time of one surface "
            f"on one thread (left) and against the memory of its largest solve ({_memory_words(dataset)}, right), for every "
            "method, grid and definition of the area; the lines join the ways that no other beats; grey, the error of the "
            "reference.",
        ),
    )
