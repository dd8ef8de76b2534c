"""What does each digit of the contact area cost, for which method and which definition, and do the claimed errors hold?"""

import itertools
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field

from validation.arrays import Grid
from validation.measurements.common import Ladder, RisingOrNone
from validation.measurements.external_codes import (
    THIS_CODE,
    asked_of,
    code_versions,
    installed_peers,
    known_peers,
)
from validation.measurements.measurement import area_limits, grids_for, press_on_grids
from validation.measurements.ways import AREAS, chosen_ways, covered, way, ways_of_bem
from validation.report.estimates import NORMAL, error_of
from validation.report.places import gather
from validation.report.views import Figure, Finding, Level, Line, Panel, Table, Views, against, finding, note
from validation.studies._options import Methods, ReducedPressure, Seed, Surfaces
from validation.studies._scene import PressedOptions, SolverRequest
from validation.studies._study import Bench, Call, Measured, solved

#: Of the solver: its error of the area is a tenth to a half of that, far below all that is to be told apart.
_TOLERANCE, _FINE_TOLERANCE = 1e-5, 1e-8
#: Part of its grid error that another code may leave in its area.
_SOLVER_SHARE = 0.1


class Options(PressedOptions):
    """Surfaces and grids. Times are of the processor; use one worker all the same."""

    off = ("fem_points_per_wave", "peer_points_per_wave")
    plain = "what a digit costs is asked of the located area, which the bare half-space has"

    methods: Methods = ("bem", "fem")
    reduced_pressure: ReducedPressure = 0.05
    surfaces: Surfaces = Field(
        default=12,
        description="how many; their claimed intervals are checked too, for which sixty are better than twelve",
    )
    seed: Seed = 5006
    points_per_wave: Ladder = (3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
    """grids of the boundary elements, as lambda_short/dx, rising"""
    held_out_points_per_wave: Ladder = (16.0, 24.0, 32.0)
    """finer grids whose limit is the reference"""
    fem_points_per_wave: RisingOrNone = (4.0, 8.0, 16.0)
    """grids of the finite elements (exact reduction)"""
    peer_points_per_wave: RisingOrNone = (4.0, 8.0, 16.0)
    """grids of other codes, where they are installed and no other methods are asked for, at equal error;
    none: they are left out"""
    method_points_per_wave: RisingOrNone = (4.0, 8.0, 16.0)
    """grids of any other of the methods, which are asked for the same tolerance of their residuals"""

    @property
    def peers(self) -> tuple[str, ...]:
        """Codes that are compared at equal error: those that are installed, where nobody names methods; and ours."""
        compared = "methods" not in self.model_fields_set and self.peer_points_per_wave
        installed = installed_peers() if compared else ()
        return (*installed, THIS_CODE) if installed else ()


#: A part of the study, what is told apart in it, and the number of the surface.
_Case = tuple[str, str, int]


def _singles(options: Options) -> Iterator[tuple[str, str, SolverRequest, Grid]]:
    """Yield what gives an area by every definition on a single grid: part, label for a definition, solver, grid."""
    solvers: list[tuple[str, SolverRequest]] = []
    for element in ("Hex1", "Hex2") if "fem" in options.methods else ():
        block = options.block(element, options.fem_points_per_wave, name=f"FEM {element}")
        solvers.append(("FEM", block))
    for code in options.peers:
        grids = grids_for(options.first, options.peer_points_per_wave)
        solvers.append(("peers", SolverRequest(code, *asked_of(code), grids)))
    for solver in options.others(options.method_points_per_wave):
        settings = tuple({"tolerance": _TOLERANCE, **dict(solver.settings)}.items())
        solvers.append(("others", replace(solver, settings=settings)))
    for part, solver in solvers:
        for grid in solver.grids:
            per_wave = options.first.points_per_wave(grid)
            yield part, f"{solver.name} {{}}, {per_wave:g} per wave", solver, grid


def design(options: Options) -> dict[_Case, Call]:
    """Return the solves of each part: reference, boundary and finite elements, other codes."""
    cases: dict[_Case, Call] = {}
    held_out = grids_for(options.first, options.held_out_points_per_wave)
    coarse, tolerance = options.grids_for(options.points_per_wave), options.tolerance(_TOLERANCE)
    for k, problem in enumerate(options.pressed):
        cases["coarse", "", k] = press_on_grids(problem=problem, grids=coarse, tolerance=tolerance)
        cases["fine", "", k] = press_on_grids(problem=problem, grids=held_out, tolerance=_FINE_TOLERANCE)
    for (part, label, solver, grid), (k, problem) in itertools.product(
        _singles(options), enumerate(options.pressed)
    ):
        share = _SOLVER_SHARE if part == "peers" else None
        cases[part, label, k] = solver.beside_bem(problem, grid, grid_share=share)
    return cases


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure error and time of every way to an area, against limits from grids that no way has seen.

    Deviation from the reference (way, surface), its root mean square, seconds and bytes (way); for each accuracy
    the fastest and the leanest way; the coverage of the intervals claimed by the coarse grids.

    Notes
    -----
    All run on one thread; seconds are of its processor. Memory is that of the arrays of a solve; of a peer, by how
    much its process grew, and ours are solved in such a process, too, to be put beside it. The areas of all are
    read off their pressures by one code. A peer's solver is stopped as soon as the area it counts is within a tenth of
    its grid error of the converged count: equal error, not equal residual. A method that is asked for by name is told
    the tolerance that the boundary elements are told.
    """
    measured = solved(bench, design(options))
    surfaces = range(options.surfaces)
    (reference, uncertain), (claimed, claimed_error) = (
        np.array([area_limits(measured[part, "", k]) for k in surfaces])[..., 0].T
        for part in ("fine", "coarse")
    )
    uncertainty = uncertain / reference
    ways = {way_data.attrs["way"]: way_data for way_data in _ways(options, measured)}
    data = gather(ways, "way").set_coords(["kind", "process"])
    data = data.assign_coords(surface=list(surfaces))
    data = data.assign(area_deviation_each=data.area_each / reference - 1).drop_vars("area_each")
    data = data.assign(
        reference_each_error=error_of(xr.DataArray(reference, dims="surface"), grid=NORMAL * uncertainty),
        claimed_each=("surface", NORMAL * claimed_error / reference),
        missed_each=("surface", claimed / reference - 1),
        reference_rms=float(np.sqrt(np.mean(uncertainty**2))),
    )
    data["area_deviation_rms"] = (data.area_deviation_each**2).mean("surface") ** 0.5
    missed = (
        label.split(" {}, ")[0]
        for (part, label, _), result in measured.items()
        if part in ("others", "FEM") and float(result.converged) < 1
    )
    codes, known = options.peers, known_peers()
    others, parts = options.others(options.method_points_per_wave), {part for part, _, _ in measured}
    cited = ["bem", *(["fem"] if "FEM" in parts else []), *(solver.method for solver in others)]
    return chosen_ways(covered(data)).assign_attrs(
        reduced_pressure=options.reduced_pressure,
        peers=" ".join([*codes[:-1], *(solver.name for solver in others)]),
        absent="" if others else ", ".join(code for code in known if code not in codes),
        measured_by=code_versions(codes) if codes else "",
        unsettled=", ".join(f"{name} {count}" for name, count in Counter(missed).items()),
        methods=" ".join([*cited, *(known[code] for code in codes[:-1]), "perimeter"]),
    )


def _ways(options: Options, measured: Measured) -> Iterator[xr.Dataset]:
    surfaces = range(options.surfaces)
    yield from ways_of_bem({k: measured["coarse", "", k] for k in surfaces})
    for part, label, solver, _ in _singles(options):
        solved_by = gather({k: measured[part, label, k] for k in surfaces}, "surface")
        for area in AREAS:
            if solved_by[area].notnull().all():
                yield way(
                    solved_by[area],
                    label=label.format(area),
                    seconds=solved_by.seconds,
                    peak_bytes=solved_by.peak_bytes,
                    process=solver.method not in ("bem", "fem"),
                )


def views(data: xr.Dataset) -> Views:
    """Show what a digit costs, whether claimed intervals hold, and what other codes need for the same error."""
    findings = [
        finding(
            "cost",
            "An area to {accuracy:%} (rms over the surfaces) costs {seconds_fastest:u}: {way_fastest}; with least "
            "memory {peak_bytes_leanest:u}: {way_leanest}.",
            data.sel(target=int(np.argmin(abs(data.accuracy.values - 0.01)))),
        ),
        finding(
            "share",
            "The 95 % intervals claimed by the coarse grids hold the reference on {held} of {all} surfaces, "
            "a share of {coverage}; they are {claimed:%} wide to either side on average.",
            data,
            all=data.sizes["surface"],
        ),
        *(_against_peer(data, code) for code in data.attrs["peers"].split()),
    ]
    findings += [note(form, it=data.attrs[name]) for name, form in _NOTES.items() if data.attrs.get(name)]
    names = [f"{name}_{which}" for which in ("fastest", "leanest") for name in ("way", *_COSTS)]
    return Views(
        table=Table(("target",), ("accuracy", *names)),
        figures=[
            Figure(
                "accuracy-cost",
                "Error of the contact area of every way to it against processor time on one thread (left) and "
                "memory (right) for one surface; lines, ways that no other beats; black, the reference.",
                [_panel(data, cost) for cost in _COSTS[1:]],
            )
        ],
        findings=findings[:6],
    )


_COSTS = ("area_deviation_rms", "seconds", "peak_bytes")
_NOTES = {
    "measured_by": "Other codes and ours are solved alike, each in a process of its own: {it}.",
    "unsettled": "Answers without the residuals that were asked for, counted all the same: {it}.",
    "absent": "Not compared, because not installed (extra `peers`) or not asked for: {it}.",
}


def _panel(data: xr.Dataset, cost: str) -> Panel:
    kinds = list(dict.fromkeys(data.kind.values.tolist()))
    dots = [Line("area_deviation_rms", where={"kind": kind}, joined=False, label=kind) for kind in kinds]
    look = {"color": "black", "marker": "", "lw": 0.8}
    front = Line(f"area_deviation_rms_front_{cost}", x=f"{cost}_front", label="no other is better", look=look)
    floor = Level("reference_rms", look={"color": "black", "ls": ":"}, label="reference")
    return against(cost, *dots, front, floor, y="area_deviation_rms", log="xy")


def _against_peer(data: xr.Dataset, code: str) -> Finding:
    rms, labels = data.area_deviation_rms.values, data.way.values.tolist()
    theirs = min((k for k, way in enumerate(labels) if way.startswith(f"{code} ")), key=lambda k: rms[k])
    ours = [k for k, way in enumerate(labels) if way.startswith("BEM") and rms[k] <= rms[theirs]]
    seconds = data.seconds.values
    text = "{code}: {way} is off by {off:%} after {seconds:.3} s"
    values: dict[str, Any] = {
        "code": code,
        "way": labels[theirs].removeprefix(f"{code} "),
        "off": float(rms[theirs]),
        "seconds": float(seconds[theirs]),
    }
    twin = f"{THIS_CODE} {values['way']}"
    if twin in labels:
        k = labels.index(twin)
        text += "; the same area on the same grid is off by {off_here:%} here and takes {ratio_twin:.3} of the time"
        values |= {"off_here": float(rms[k]), "ratio_twin": float(seconds[k] / seconds[theirs])}
    if not ours:
        return finding("cost", text + "; none of the ways here is as good.", **values)
    best = min(ours, key=lambda k: float(seconds[k]))
    values |= {"best": labels[best], "ratio": float(seconds[best] / seconds[theirs])}
    form = text + "; the cheapest way here to that error takes {ratio:.3} of it ({best})."
    return finding("cost", form, **values)
