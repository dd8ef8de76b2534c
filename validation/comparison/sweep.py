"""Running a sweep: every scene checked before any solve, one store, one dataset, one page."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact import errors as fem_errors
from persson import errors as persson_errors
from validation.comparison import theory_alone
from validation.comparison.compare import compare
from validation.comparison.compared import Comparison, Row
from validation.comparison.explain import Explanation, explain
from validation.comparison.findings import layered
from validation.comparison.sweep_page import sweep_page
from validation.errors import RunFailed, UsageError
from validation.files import prepare_folder, read_record, write_record
from validation.report.page import Page, clear_page, write_page
from validation.scenes.checks import check_scene
from validation.scenes.realised import Realised, Surveyed, realise
from validation.scenes.scene import Scene
from validation.scenes.sweep import Sweep, SweptKey
from validation.solves.attempt import Progress
from validation.solves.cost import transform_seconds
from validation.solves.press import Press, solves_of
from validation.solves.provenance import SOLVES_MADE, made_words
from validation.solves.running import Execution, Solves, solve_all
from validation.solves.store import Store, read_numbers, write_numbers

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "SweepExplanation",
    "SweepOutputs",
    "explain_sweep",
    "is_sweep",
    "realised_cases",
    "report_sweep",
    "run_sweep",
    "solves_of_sweep",
]

_RECORD = "sweep.json"
_FORMAT = "fem-contact sweep 1"
_DATA = "data.nc"
#: What checks of a scene, and making its surface, refuse.
_UNFIT = (UsageError, fem_errors.InvalidInput, persson_errors.InvalidInput)

#: Variables of the dataset, over the swept keys: unit, meaning.
_VARIABLES = {
    "area": ("1", "A/A0, limit over grids"),
    "area_error": ("1", "standard error of the limit, grid only"),
    "kappa": ("1", "kappa = (A/A0) / p*, limit over grids"),
    "kappa_error": ("1", "standard error of kappa, grid only"),
    "theory": ("1", "A/A0, Persson with the realised gradient"),
    "theory_ensemble": ("1", "A/A0, Persson from C(q) alone"),
    "theory_kappa": ("1", "kappa, Persson with the realised gradient"),
    "theory_plastic": ("1", "A_pl/A0, Persson"),
    "scatter": ("1", "standard deviation between surfaces over their mean"),
    "electrical_conductance": ("1/(ohm m^2)", "electrical conductance of the contact"),
    "electrical_conductance_error": ("1/(ohm m^2)", "its change from the grid before"),
    "thermal_conductance": ("W/(m^2 K)", "thermal conductance of the contact"),
    "thermal_conductance_error": ("W/(m^2 K)", "its change from the grid before"),
    "leak_rate_x": ("m^3/s", "leak through one period along x"),
    "leak_rate_x_error": ("m^3/s", "its change from the grid before"),
    "leak_rate_y": ("m^3/s", "leak through one period along y"),
    "leak_rate_y_error": ("m^3/s", "its change from the grid before"),
    "pressure": ("Pa", "p0"),
    "reduced_pressure": ("1", "p* = p0 / (E* h'_rms)"),
    "contact_modulus": ("Pa", "E*"),
    "rms_gradient": ("1", "h'_rms, realised"),
}
#: The same by method, on its finest resolved grid.
_OF_METHODS = {
    "pixel": ("1", "A/A0, points counted on the finest grid"),
    "pixel_error": ("1", "standard error of the counted area over sub-grid shifts"),
    "perimeter": ("1", "A/A0 with the perimeter correction, on the finest grid"),
    "plastic": ("1", "A_pl/A0, points counted on the finest grid"),
    "points_per_wave": ("1", "lambda_short / dx of the finest grid"),
    "residual": ("1", "largest contact residual on the finest grid"),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepOutputs:
    """What a sweep left behind; the report is the first file.

    Attributes
    ----------
    data : xarray.Dataset
        Over the swept keys, or over `case` where they run side by side.
    page : Page
    files : tuple of Path
    solved, reused : int
        Solves done now, and solves found finished.
    """

    data: xr.Dataset
    page: Page
    files: tuple[Path, ...]
    solved: int = 0
    reused: int = 0


def realised_cases(sweep: Sweep, kind: type[Realised] = Realised) -> tuple[Realised, ...]:
    """Return what each scene asks for, each surface made once, and refuse what cannot be run.

    Raises
    ------
    UsageError
        Naming the values at which it cannot.
    """
    made: list[Realised] = []
    surfaces: dict[Any, Realised] = {}
    for k, scene in enumerate(sweep.scenes):
        realised = realise(scene, like=surfaces.get(scene.surface), kind=kind)
        try:
            if len(scene.load.values) > 1:
                key = f"load.{scene.load.key}"
                raise UsageError(f"{key}: lists several loads; move the list to [sweep], as sweep.{key}")
            check_scene(scene, realised)
        except _UNFIT as error:
            raise UsageError(f"{error} ([sweep] at {sweep.words(k)})") from None
        surfaces.setdefault(scene.surface, realised)
        made.append(realised)
    return tuple(made)


def solves_of_sweep(sweep: Sweep, cases: Sequence[Realised]) -> tuple[Press, ...]:
    """List the solves of all scenes; what several of them ask for is listed once."""
    each = zip(sweep.scenes, cases, strict=True)
    return tuple({solve.key: solve for scene, case in each for solve in solves_of(scene, case)}.values())


def run_sweep(
    sweep: Sweep,
    folder: Path,
    *,
    cases: Sequence[Realised] | None = None,
    progress: Progress | None = None,
    execution: Execution | None = None,
    store_folder: Path | None = None,
    report: bool = True,
) -> SweepOutputs:
    """Run every scene of a sweep into one folder; finished solves found in the store are used.

    Parameters
    ----------
    sweep : Sweep
    folder : Path
        For tables, dataset, figures and report.
    cases : sequence of Realised, optional
        What its scenes ask for, where that has been made already.
    progress : Progress, optional
    execution : Execution, optional
        Where the solves run; in this process if not given.
    store_folder : Path, optional
        Where they are kept; `folder`/solves if not given.
    report : bool
        Whether to draw figures and write the report, which `report_sweep` can do later.

    Raises
    ------
    UsageError
        For a scene or folder that cannot be used, before anything is computed.
    RunFailed
        When a solve fails; everything finished is stored.
    """
    cases = cases or realised_cases(sweep)
    prepare_folder(folder)
    store = Store(folder=store_folder or folder / "solves")
    _record(sweep, folder, store)
    solves = solves_of_sweep(sweep, cases)
    results = solve_all(solves, store, progress=progress, execution=execution)
    data = _dataset(sweep, [_case(*pair, results) for pair in zip(sweep.scenes, cases, strict=True)])
    asked = (solves_of(*pair) for pair in zip(sweep.scenes, cases, strict=True))
    data.attrs.update(solves=len(solves), asked=sum(map(len, asked)))
    data.attrs[SOLVES_MADE] = "\n".join(made_words(results.made()))
    write_numbers(folder / _DATA, data, recipe=_said(sweep, folder, store))
    outputs = report_sweep(folder, numbers_only=not report)
    return dataclasses.replace(outputs, solved=results.solved, reused=len(results) - results.solved)


def is_sweep(folder: Path) -> bool:
    """Whether a results folder is that of a sweep."""
    return (folder / _RECORD).exists()


def report_sweep(folder: Path, *, numbers_only: bool = False) -> SweepOutputs:
    """Write tables, figures and report of a sweep again, from its stored dataset alone.

    Raises
    ------
    UsageError
        For a folder that holds no finished sweep of this version.
    """
    try:
        said = read_record(folder / _RECORD)
        if said["format"] != _FORMAT:
            raise ValueError(f"{_RECORD} is not of this version")
        scene = Scene.model_validate(said["scene"])
        keys = tuple(SweptKey(**{**key, "values": tuple(key["values"])}) for key in said["keys"])
        data = read_numbers(folder / _DATA)
    except RunFailed as error:
        raise UsageError(str(error)) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{folder}: holds no finished sweep ({error}); run it again") from None
    page = sweep_page(data, keys, scene, figures=not numbers_only)
    written = write_page(page, folder, numbers_only=numbers_only)
    return SweepOutputs(data=data, page=page, files=(*written, folder / _DATA))


def _record(sweep: Sweep, folder: Path, store: Store) -> None:
    """Write down what the folder is a sweep of; what another run left in it goes."""
    clear_page(folder)
    for other in ("run.json", "study.json", "accuracy.json", _DATA):
        (folder / other).unlink(missing_ok=True)
    for block in (folder / "fields").glob("*.vtu"):
        block.unlink()
    write_record(folder / _RECORD, _said(sweep, folder, store))


def _said(sweep: Sweep, folder: Path, store: Store) -> dict[str, Any]:
    """Return what the folder is a sweep of, and where its solves are."""
    return {
        "format": _FORMAT,
        "mode": sweep.mode,
        "keys": [dataclasses.asdict(key) for key in sweep.keys],
        "scene": sweep.scenes[0].model_dump(mode="json", exclude_none=True),
        "store": os.path.relpath(store.folder.resolve(), folder.resolve()),
    }


@dataclass(frozen=True, kw_only=True)
class _Case:
    """Numbers of one scene: by variable, and by method and variable."""

    numbers: dict[str, float | None]
    methods: dict[str, dict[str, float | None]]
    grids: dict[str, str]
    no_limit: str = ""
    layered: bool = False


def _case(scene: Scene, realised: Realised, results: Solves) -> _Case:
    """Read the stored solves of one scene as its own run does."""
    comparison = None
    if scene.methods.solvers:
        comparison = compare(scene, realised, {solve: results[solve] for solve in solves_of(scene, realised)})
        realised = comparison.realised  # under the load that was found, where a distance is held
    common: dict[str, float | None] = {
        "pressure": realised.pressure,
        "reduced_pressure": realised.reduced_pressure,
        "contact_modulus": realised.contact_modulus,
        "rms_gradient": realised.field.rms_gradient,
    }
    if comparison is None:
        summary = theory_alone.answer_alone(scene, realised).summary()
        (said,) = summary["answers"]
        area = said["area"]
        kappa = None if area is None else area / realised.reduced_pressure if realised.pressure > 0 else None
        said = {"theory_ensemble": area, "theory_plastic": said["plastic"], "theory_kappa": kappa}
        return _Case(numbers={**common, **said}, methods={}, grids={})
    finest = {name: _finest(comparison.rows_of(name)) for name in scene.methods.solvers}
    return _Case(
        # On the modulus of the comparison: with a coating that is not the one of the solid below.
        numbers={
            **common,
            "reduced_pressure": comparison.reduced_pressure,
            "contact_modulus": comparison.contact_modulus,
            **_numbers(comparison),
        },
        methods={
            name: {variable: getattr(row, variable, None) for variable in _OF_METHODS}
            | {"pixel_error": row.pixel_scatter}
            for name, row in finest.items()
        },
        grids={name: f"{row.grid[0]} x {row.grid[1]}" for name, row in finest.items()},
        no_limit=comparison.no_limit,
        layered=layered(comparison),
    )


def _finest(rows: Sequence[Row]) -> Row:
    """Return the finest resolved row of a method; the finest where none resolves."""
    return max(rows, key=lambda row: (not row.under_resolved, row.points_per_wave))


def _numbers(c: Comparison) -> dict[str, float | None]:
    load, limit, theory = c.reduced_pressure, c.limit, c.theory
    answers = theory is not None and theory.answers
    return {
        "area": None if limit is None else limit.value,
        "area_error": None if limit is None else limit.uncertainty,
        "kappa": None if limit is None else limit.value / load,
        "kappa_error": None if limit is None else limit.uncertainty / load,
        "theory": theory.area if theory is not None and answers else None,
        "theory_kappa": theory.area / load if theory is not None and answers else None,
        "theory_ensemble": None if theory is None else theory.ensemble_area,
        "theory_plastic": None if theory is None else theory.plastic,
        "scatter": None if c.scatter is None else c.scatter.relative,
        **{one.name: one.value for one in c.passing},
        **{f"{one.name}_error": one.grid_error for one in c.passing},
    }


def _dataset(sweep: Sweep, cases: Sequence[_Case]) -> xr.Dataset:
    """Lay the numbers of all cases out over the swept keys."""
    import xarray as xr

    first = sweep.scenes[0]
    over = ("case",) if sweep.mode == "zip" else tuple(key.name for key in sweep.keys)
    coordinates: dict[str, Any] = {
        key.name: ("case" if sweep.mode == "zip" else key.name, list(key.values), _attributes(key))
        for key in sweep.keys
    }
    if sweep.mode == "zip":
        coordinates["case"] = ("case", np.arange(1, len(cases) + 1), {"units": "1", "long_name": "case"})
    solvers = list(first.methods.solvers)
    variables: dict[str, Any] = {}
    for name, (unit, words) in _VARIABLES.items():
        values = _laid_out([case.numbers.get(name) for case in cases]).reshape(sweep.shape)
        wanted = name == "area" and solvers
        if name not in coordinates and (wanted or not np.isnan(values).all()):
            variables[name] = (over, values, {"units": unit, "long_name": words})
    if solvers:
        coordinates["solver"] = ("solver", solvers, {"units": "1", "long_name": "method"})
        shape = (len(solvers), *sweep.shape)
        for name, (unit, words) in _OF_METHODS.items():
            values = _laid_out([case.methods[m][name] for m in solvers for case in cases]).reshape(shape)
            if not np.isnan(values).all():
                variables[name] = (("solver", *over), values, {"units": unit, "long_name": words})
        grids = np.array([case.grids[m] for m in solvers for case in cases], dtype=object).reshape(shape)
        variables["grid"] = (("solver", *over), grids, {"units": "1", "long_name": "finest grid"})
    attributes = {
        "title": sweep.title or sweep.name,
        "mode": sweep.mode,
        "methods": " ".join(first.methods.asked),
        "effects": " ".join(effect.kind for effect in first.effects),
        "no_limit": next((case.no_limit for case in cases if case.no_limit), ""),
        "layered": int(any(case.layered for case in cases)),
    }
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


#: How the keys that are swept most stand at an axis.
_AXES = {
    "load.pressure": "p0",
    "load.reduced_pressure": "p* = p0 / (E* h'_rms)",
    "load.force": "force",
    "load.mean_gap": "mean gap",
    "load.offset": "offset",
    "solid.young": "Young's modulus E",
    "solid.poisson": "Poisson ratio",
    "surface.hurst": "Hurst exponent H",
    "surface.seed": "seed",
    "effects.hardness.hardness": "hardness",
    "effects.adhesion.work": "work of adhesion",
}


def _attributes(key: SweptKey) -> dict[str, str]:
    return {"units": key.unit, "long_name": _AXES.get(key.key, key.key), "key": key.key}


def _laid_out(values: Sequence[float | None]) -> Any:
    return np.array([np.nan if value is None else value for value in values], dtype=float)


@dataclass(frozen=True, kw_only=True)
class SweepExplanation:
    """What a sweep runs.

    Attributes
    ----------
    cases : tuple of (str, Explanation)
        The values of each case, and what it runs by itself.
    solves, asked : int
        Solves in all, and the sum over the cases, which share some.
    seconds : float
        Predicted time of all solves, one after the other.
    peak_bytes : int
        Largest memory of any one solve.
    """

    name: str
    mode: str
    keys: tuple[SweptKey, ...]
    cases: tuple[tuple[str, Explanation], ...]
    solves: int
    asked: int
    seconds: float
    peak_bytes: int

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON-ready data."""
        said = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        cases = [{"case": words, **one.summary()} for words, one in self.cases]
        return {**said, "keys": [dataclasses.asdict(key) for key in self.keys], "cases": cases}

    def parts(self) -> Iterator[Any]:
        """Yield what the command line prints, in order: the sum, then the first and the last case."""
        joined = "every combination of" if self.mode == "product" else "side by side"
        named = ", ".join(f"{key.key} ({len(key.values)} values)" for key in self.keys)
        yield f"Sweep of scene {self.name}: {len(self.cases)} cases, {joined} {named}"
        yield (
            f"{self.solves} solves; {self.asked - self.solves} more are shared between cases: about "
            f"{self.seconds:.2g} s one after the other and {self.peak_bytes / 2**20:.3g} MiB at most (meant "
            "to be right within a factor of 2)."
        )
        ends = self.cases[:1] if len(self.cases) == 1 else (self.cases[0], self.cases[-1])
        for words, one in ends:
            yield f"\nCase {words}:"
            yield from one.parts()


def explain_sweep(sweep: Sweep) -> SweepExplanation:
    """Say what a sweep will run and at what cost, without solving anything.

    Raises
    ------
    UsageError
        For a scene that cannot be run, naming the values at which it cannot.
    """
    cases = realised_cases(sweep, Surveyed)
    solves = solves_of_sweep(sweep, cases)
    pair = transform_seconds()
    costs = [solve.predict(pair_seconds=pair) for solve in solves]
    each = [explain(scene, case) for scene, case in zip(sweep.scenes, cases, strict=True)]
    return SweepExplanation(
        name=sweep.name,
        mode=sweep.mode,
        keys=sweep.keys,
        cases=tuple((sweep.words(k), one) for k, one in enumerate(each)),
        solves=len(solves),
        asked=sum(grid.solves for one in each for grid in one.grids),
        seconds=sum(cost.seconds for cost in costs),
        peak_bytes=max((cost.peak_bytes for cost in costs), default=0),
    )
