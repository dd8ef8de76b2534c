"""A run or sweep computed again, case by case: rows, limit, theory, scatter, cross-checks from its fields."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cached_property, partial
from statistics import fmean
from typing import Any, TypeAlias

import numpy as np
from scipy.special import boxcox, erfc, stdtrit

from validation.audit.dataset import Result, Variables
from validation.audit.ledger import Ledger
from validation.audit.limits import LEAST_POINTS, limit_over
from validation.audit.reductions import NORMAL
from validation.audit.stored import Grid, Moments, Pair, Stored
from validation.audit.values import judge_dataset

#: What a solve leaves of the located area, in tolerances (docs/bem.md).
_LEFT = 7.0
#: Rounding differs between two ways to add up, and to fit; a residual of 1e-13 is rounding itself.
_LOOSE = {
    name: how
    for names, how in {
        "residual": {"rtol": 1e-6, "atol": 3e-13},
        "rms_height mean_gap approach nominal_area wave_short": {"atol": 0.0},
        "mean_gap_error approach_error rms_height_spectrum": {"rtol": 1e-6, "atol": 0.0},
        "area_own_error": {"rtol": 1e-5, "atol": 1e-9},
        "accuracy_reached": {"rtol": 1e-4},
        "rms_gradient_spectrum area_ensemble": {"rtol": 1e-6},
        "area_own area_each area_limit": {"rtol": 1e-7},
        "area_pixel_off area_perimeter_off area_located_off": {"atol": 1e-7},
        "scatter": {"rtol": 1e-5},
        "pressure_difference area_pixel_difference area_perimeter_difference": {"atol": 1e-12},
    }.items()
    for name in names.split()
}


def audit_run(result: Result) -> tuple[Ledger, list[Run]]:
    """Compute the dataset of a run or sweep again, case by case; return the runs that its cases are, too."""
    record, ledger, runs, judged = result.record, Ledger(), [], set()
    for scene, at, words in _cases(record["asked"], result, ledger):
        here = {name: variable.isel(at, missing_dims="ignore") for name, variable in result.data.items()}
        run = Run(scene, partial(result.solve, read=Stored), here)
        if run.failed and not run.solves:
            ledger.unread.append(f"{words or 'the run'}: its solves failed")
            continue
        if not run.methods:
            raise LookupError("a scene of the theory alone stores no field")
        if run.measured and "wave_short" in here:  # two points of a file that is not read here
            run.shortest = float(here["wave_short"].values)
        judged |= _judge(run, here, words, ledger, record["asked"].get("accuracy"))
        runs.append(run)
    judged |= {key["name"] for key in record["asked"].get("sweep", {}).get("keys", ())}
    judge_dataset(result, ledger, judged)
    return ledger, runs


def _cases(
    asked: Mapping[str, Any], result: Result, ledger: Ledger
) -> Iterator[tuple[dict[str, Any], dict[str, int], str]]:
    """Yield the scene of each case, its place along the swept dimensions, and words for it.

    Its numbers are those that its place says, which are those that were asked for.
    """
    scene = asked["scene"]
    if "sweep" not in asked:
        yield scene, {}, ""
        return
    if "cases" not in asked:
        raise LookupError("it was swept by an earlier version")
    keys, side_by_side = asked["sweep"]["keys"], asked["sweep"]["mode"] == "zip"
    values = {key["name"]: key["values"] for key in keys}
    cases = zip(*values.values(), strict=True) if side_by_side else itertools.product(*values.values())
    # Along numbers a product is sorted.
    places = {name: v if any(isinstance(x, str) for x in v) else sorted(v) for name, v in values.items()}
    for name, v in values.items():
        if not isinstance(v[0], str):
            expected = np.array(v if side_by_side else places[name], float)
            ledger.number("data.nc", name, result.data[name].values, expected)
    for k, (case, tables) in enumerate(zip(cases, asked["cases"], strict=True)):
        named, here = dict(zip(values, case, strict=True)), {**scene, **tables}
        words = ", ".join(f"{name} = {value}" for name, value in named.items())
        for key, x in zip(keys, case, strict=True):
            if not isinstance(x, str):
                ledger.number("result.json", f"{key['key']} at {words}", x, _said(here, key["key"]))
        at = {"case": k} if side_by_side else {name: places[name].index(x) for name, x in named.items()}
        yield here, at, words


def _said(scene: Any, key: str) -> float:
    """Return the number that a dotted key of a scene has; an effect is named by its kind."""
    for name in key.split("."):
        scene = next(e for e in scene if e["kind"] == name) if isinstance(scene, list) else scene[name]
    return float(np.ravel(scene)[0])


class Run:
    """What the stored solves of one run say.

    Its scene is what was asked for, as result.json has it; the variables of its dataset name its solves,
    which are read from a store that others may share.
    """

    def __init__(self, scene: dict[str, Any], solve: Callable[[str], Stored | None], data: Variables) -> None:
        self.scene = scene
        self.surface: dict[str, Any] = self.scene["surface"]
        self.measured = self.surface["kind"] == "file"
        self.effects: list[dict[str, Any]] = self.scene.get("effects", [])
        methods = self.scene["methods"]
        #: Methods that solve on grids, in the order of the comparison: the first is the reference.
        self.methods = [name for name in methods if "grids" in methods[name]]
        self.options: dict[str, dict[str, Any]] = methods
        #: Stored solves by method, grid, shift and realisation.
        self.solves: dict[tuple[str, Grid, Pair, int], Stored] = {}
        self.realisations = int(scene.get("ensemble", {}).get("realisations", 1))
        self.shortest = float(self.surface.get("lambda_short") or math.nan)
        #: Whether a mean gap or an offset was held in place of a load.
        self.holds_distance = bool({"mean_gap", "offset"} & set(scene["load"]))
        self.kinds = [effect["kind"] for effect in self.effects]
        self.adhesive = "adhesion" in self.kinds
        #: [Pa], where there is one and no other effect.
        single = self.kinds == ["hardness"] and "size_wavelength" not in self.effects[0]
        self.hardness = float(self.effects[0]["hardness"]) if single else None
        keys = (v.values.flat for name, v in data.items() if name == "solve" or name.startswith("solve_"))
        named = " ".join(map(str, itertools.chain.from_iterable(keys)))
        for key in sorted(set(named.split())):
            if (stored := solve(key)) is None:
                raise LookupError(f"no solve {key} in the store")
            if (k := self._realisation(stored.recipe)) is not None:
                self.solves.setdefault((stored.method, stored.grid, stored.shift, k), stored)
        #: Whether some failed, which are rows without numbers.
        self.failed = "failures" in data and bool(str(data["failures"].values))
        if self.failed:
            self.methods = [name for name in self.methods if any(name == key[0] for key in self.solves)]

    def _realisation(self, recipe: dict[str, Any]) -> int | None:
        """Return which realisation of the scene a recipe asks for; None if it is of another scene."""
        surface, solid, load = (
            {key: value for key, value in recipe[of].items() if value is not None}
            for of in ("surface", "solid", "load")
        )
        asked = dict(self.surface)
        # The recipe of a `ContactProblem` holds the digest of a file in place of its path.
        surface |= {key: asked[key] for key in ("path", "second_path") if key in asked and key in surface}
        if self.measured:
            surface = {"spikes": "keep", **surface}  # which it names where they are clipped alone
            for since in ("heights", "clipped"):  # how this version reads a map, whatever is asked
                surface.pop(since, None)
            k = surface.pop("more_paths", 0)  # of several maps which, where the scene lists them
            asked = {"tilt": "keep", "spikes": "keep", **asked}
            asked = {key: value for key, value in asked.items() if key not in ("treatment", "more_paths")}
        else:
            k = surface.pop("seed") - asked.pop("seed")
        said = surface, solid, load, recipe["effects"]
        same = said == (asked, self.scene["solid"], self.scene["load"], self.effects)
        options = self.options.get(recipe["method"], {})
        # A solve of the surface upside down is of a quantity, not of the scene.
        same = same and all(options[key] == v for key, v in recipe["settings"].items() if key in options)
        return k if same and "inverted" not in recipe and k in range(self.realisations) else None

    @cached_property
    def depth(self) -> float | None:
        """Depth [m] at which the solid is bonded to a rigid base: inf of a half-space, None of others."""
        no_layers = ("hardness", "adhesion", "smoothing")
        layers = {effect["kind"]: effect for effect in self.effects if effect["kind"] not in no_layers}
        if list(layers) == ["thickness"] and layers["thickness"].get("base", "bonded") == "bonded":
            return float(layers["thickness"]["thickness"])
        return None if layers else math.inf

    def resolved(self, solve: Stored) -> bool:
        """Whether lambda_short > 2 dx, where there is one."""
        return not self.shortest <= 2 * max(solve.spacing) * (1 + 1e-12)

    def moments(self, k: int = 0) -> Moments:
        """(m0, m2, m4) of one realisation, from its finest grid that resolves it; NaN where none tells."""
        solves = [solve for key, solve in self.solves.items() if key[3] == k and self.resolved(solve)]
        if not solves or self.measured:
            return math.nan, math.nan, math.nan
        return max(solves, key=lambda solve: solve.p.size).roughness

    @cached_property
    def modulus(self) -> float:
        """E* = E / (1 - nu^2) [Pa]."""
        solid = self.scene["solid"]
        compliance = (1 - solid["poisson"] ** 2) / solid["young"]
        if "second_young" in solid:
            compliance += (1 - solid["second_poisson"] ** 2) / solid["second_young"]
        return float(1 / compliance)

    @cached_property
    def surface_modulus(self) -> float:
        """E* [Pa] of the coating where there is one."""
        for effect in self.effects:
            if effect["kind"] == "coating":
                poisson = effect.get("poisson", self.scene["solid"]["poisson"])
                return float(effect["young"] / (1 - poisson**2))
        return self.modulus

    def pressure(self, k: int = 0) -> float:
        """p0 [Pa]: as given, or p* E* h'_rms of that realisation."""
        load = self.scene["load"]
        if "pressure" in load:
            return float(np.ravel(load["pressure"])[0])
        if "force" in load:
            return float(load["force"] / math.prod(self.surface["length"]))
        if self.holds_distance:
            return self.ladder[-1].mean_pressure
        return float(np.ravel(load["reduced_pressure"])[0]) * self.modulus * math.sqrt(self.moments(k)[1])

    @cached_property
    def ladder(self) -> list[Stored]:
        """Solves of the first method, unshifted, coarse to fine: the resolved ones, if there are any."""
        first = self.methods[0]
        keys = [(first, (int(nx), int(ny)), (0.0, 0.0), 0) for nx, ny in self.options[first]["grids"]]
        there = [self.solves[key] for key in keys if key in self.solves]
        resolved = [solve for solve in there if self.resolved(solve)] or there
        return sorted(resolved, key=lambda solve: -max(solve.spacing))

    def reduced_pressure(self, k: int = 0) -> float:
        """p* = p0 / (E* h'_rms) of one realisation, E* of the solid."""
        return self.pressure(k) / (self.modulus * math.sqrt(self.moments(k)[1]))

    def shown(self, method: str, grid: Grid) -> list[Stored]:
        """Solves of the scene's own surface on one grid, of all shifts."""
        return [solve for (*on, _, k), solve in self.solves.items() if (*on, k) == (method, grid, 0)]

    def residual(self, solve: Stored) -> float:
        """Return the largest of the four residuals, of the load, too; NaN where they are not read."""
        pressure = solve.mean_pressure if self.holds_distance else self.pressure()
        residuals = solve.residuals(pressure) or {"": math.nan}
        if self.adhesive or self.holds_distance or math.isnan(pressure):
            return max(residuals.values())
        return max(*residuals.values(), abs(solve.mean_pressure - pressure) / pressure)

    def limit(self, method: str, k: int = 0, grids: Collection[Grid] | None = None) -> Pair:
        """Limit of one realisation over resolved grids of one method, and its standard error.

        Over other grids than those of the comparison it is that of solves without a shift. Where these grids
        tell none it is the area on the finest, whose error is NaN; of too few points on several, NaN, too.
        """
        compared = grids or set(map(tuple, self.options[method]["grids"]))
        solves = [
            solve
            for (name, grid, shift, realisation), solve in self.solves.items()
            if (name, realisation) == (method, k) and grid in compared and (not grids or shift == (0.0, 0.0))
        ]
        solves = (not grids and list(filter(self.resolved, solves))) or solves
        limit, spacings = limit_over(solves), {solve.spacing for solve in solves}
        if len(spacings) > 1 and not math.isnan(limit[0]):
            return limit
        finest = [solve for solve in solves if solve.spacing == min(spacings)]
        if not finest or (len(spacings) > 1 and finest[0].pixel * finest[0].p.size < LEAST_POINTS):
            return math.nan, math.nan
        return fmean(s.subcell if s.located else s.perimeter for s in finest), math.nan

    def theory(self, m2: float, pressure: float) -> Pair:
        """A/A0 and A_pl/A0 with V = E*^2 m2 / 4, elastic or with one hardness; NaN with other effects."""
        if "theory" not in self.options or (self.kinds and self.hardness is None):
            return math.nan, math.nan
        variance = 0.25 * self.modulus**2 * m2
        if self.hardness is not None:
            parts = yielded_areas(pressure, variance=variance, hardness=self.hardness)
            return sum(parts), parts[0]
        return math.erf(pressure / math.sqrt(2 * variance)), math.nan

    def own_theory(self, k: int = 0) -> Pair:
        """A/A0 and A_pl/A0 of one realisation."""
        return self.theory(self.moments(k)[1], self.pressure(k))

    @cached_property
    def spectral_moments(self) -> Pair:
        """(m0, m2): integrals over C(q) ~ q^(-2 - 2 H) between the cut-offs of a sharp spectrum, else NaN."""
        s = self.surface
        if s["kind"] != "self-affine" or s.get("rolloff", "sharp") != "sharp":
            return math.nan, math.nan
        low, ratio = 2 * math.pi / s["lambda_long"], s["lambda_long"] / s["lambda_short"]
        # Of x^(n - 1) from 1 to the ratio: (ratio^n - 1) / n, and its logarithm where n = 0.
        height, slope = (float(boxcox(ratio, n)) for n in (-2 * s["hurst"], 2 - 2 * s["hurst"]))
        # A stretch by g leaves m0, and of m2 the part (1 + 1/g^2)/2.
        per_height = (1 + s.get("stretch", 1.0) ** -2) / 2 * low**2 * slope / height
        m0 = s["rms_height"] ** 2 if "rms_height" in s else s["rms_gradient"] ** 2 / per_height
        return m0, m0 * per_height


#: Read off the fields of one solve, and with which power of the spacing they converge at least.
_READ: Mapping[str, tuple[Callable[[Stored], float], float]] = {
    "mean_gap": (lambda solve: float(np.mean(solve.weights * np.where(solve.bound, 0.0, solve.gap))), 1.5),
    "approach": (lambda solve: -float(solve.attrs["offset"]), 1.5),
    "largest_pressure": (lambda solve: float(np.max(solve.p)), 1.0),
}
#: Name, value, and place along dimensions: positions, or names of solver, grid and source.
Expected: TypeAlias = Iterator[tuple[str, float | None, Mapping[str, int | str]]]


def _judge(
    run: Run, data: Variables, words: str, ledger: Ledger, accurate: Mapping[str, Any] | None
) -> set[str]:
    """Judge every number of one scene that follows from its fields; return which there were."""
    names = {dim: [str(name) for name in data[dim].values] for dim in ("solver", "grid", "source")}
    judged = set()
    parts = (_of_surface(run), _of_solves(run), _of_area(run, accurate), _of_finest(run), _of_theory(run))
    for name, expected, place in itertools.chain(*parts, _of_ensemble(run)):
        if name not in data:
            continue
        where = {d: names[d].index(k) if isinstance(k, str) else k for d, k in place.items()}
        along = map(str, data[name].dims)
        dims = [names[d][where[d]] if d in ("solver", "grid") else f"{d} {where[d]}" for d in along]
        label = f"{name}{' of ' * bool(dims)}{' '.join(dims)}{f' at {words}' * bool(words)}"
        how = _LOOSE.get(name, {}) if accurate is None or name != "area_own_error" else {"rtol": 1e-4}
        if expected is None:
            ledger.unread.append(f"data.nc: {label}")
        else:
            found = data[name].isel(where, missing_dims="ignore").values
            ledger.number("data.nc", label, found.item(), expected, **how)
        judged.add(name)
    return judged


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def _of_surface(run: Run) -> Expected:
    if run.measured:
        return
    m0, m2, m4 = run.moments()
    height, gradient = map(math.sqrt, run.spectral_moments)
    numbers = {
        "nominal_area": math.prod(run.surface["length"]),
        "wave_short": run.shortest,
        "contact_modulus": run.modulus,
        "surface_modulus": run.surface_modulus,
        "pressure": run.pressure(),
        "rms_height": math.sqrt(m0),
        "rms_gradient": math.sqrt(m2),
        "nayak": 1.5 * m0 * m4 / m2**2,
        "rms_height_spectrum": height,
        "rms_gradient_spectrum": gradient,
    }
    yield from ((name, _known(value), {}) for name, value in numbers.items())


def _of_solves(run: Run) -> Expected:
    """Yield the numbers of each method on each grid, over its shifts, and beside those of the first."""
    grids = ((m, grid) for m in run.methods for grid in sorted(map(tuple, run.options[m]["grids"])))
    for method, grid in grids:
        solves, at = run.shown(method, grid), {"solver": method, "grid": f"{grid[0]} x {grid[1]}"}
        if not solves and run.failed:
            continue
        if not solves:
            raise LookupError(f"no stored solve of {method} on {grid[0]} x {grid[1]}")
        density = math.nan if run.adhesive else fmean(s.density_at_zero for s in solves)
        row: dict[str, float | None] = {
            "density_at_zero": density * run.modulus / run.surface_modulus,
            "shifts": len(solves),
            "resolved": float(run.resolved(solves[0])),
            "seconds": math.fsum(solve.cost["wall_seconds"] for solve in solves),
            "unknowns": solves[0].cost["unknowns"],
        }
        if "hardness" in run.kinds:
            row["area_plastic_pixel"] = fmean(solve.plastic for solve in solves)
        if not run.measured:
            load, residual = run.reduced_pressure(), max(run.residual(solve) for solve in solves)
            if run.holds_distance:
                load *= fmean(solve.mean_pressure for solve in solves) / run.pressure()
            row["kappa_perimeter"] = _known(fmean(s.perimeter for s in solves) / load)
            row["points_per_wave"] = run.shortest / max(solves[0].spacing)
            row |= {} if math.isnan(residual) else {"residual": residual}
        first, key = run.methods[0], (grid, (0.0, 0.0), 0)
        if method != first and (first, *key) in run.solves and list(grid) in run.options[first]["grids"]:
            a, b = run.solves[(method, *key)], run.solves[(first, *key)]
            row["pressure_difference"] = math.sqrt(np.sum((a.p - b.p) ** 2) / np.sum(b.p**2))
            row["area_pixel_difference"] = a.pixel / b.pixel - 1
            row["area_perimeter_difference"] = a.perimeter / b.perimeter - 1
        yield from ((name, value, at) for name, value in row.items())


def _of_area(run: Run, accurate: Mapping[str, Any] | None) -> Expected:
    limits = [run.limit(name) for name in run.methods]
    for method, (area, error) in zip(run.methods, limits, strict=True):
        yield "area_limit", math.nan if math.isnan(error) else area, {"solver": method}
    area, error = next((pair for pair in limits if not math.isnan(pair[1])), limits[0])
    yield "area_own", area, {}
    known = not math.isnan(error) and 0 < area < 1 - 1e-12
    for method in run.methods if known else ():
        for grid in map(tuple, run.options[method]["grids"]):
            solves, at = run.shown(method, grid), {"solver": method, "grid": f"{grid[0]} x {grid[1]}"}
            for name, of in {"pixel": "pixel", "perimeter": "perimeter", "located": "subcell"}.items():
                if name != "located" or solves[0].located:
                    off = fmean(getattr(solve, of) for solve in solves) / area - 1
                    yield f"area_{name}_off", off, at
    share, solver = NORMAL * error / area, 0.0
    if accurate is not None:
        solver = _LEFT * accurate["tolerance"]
        share = 2 * error / area + solver
        if accurate["mean"] is None:
            yield "accuracy_reached", share, {}
    yield "area_own_error", math.sqrt(share**2 - solver**2) * area, {"source": "grid"}


def _of_finest(run: Run) -> Expected:
    """Yield what stands on the finest grid of the first method, and its interval from coarser ones."""
    *coarser, finest = run.ladder
    reads = dict(_READ)
    if "hardness" in run.kinds:  # mean over the shifts
        reads["area_plastic"] = lambda s: fmean(x.plastic for x in run.shown(s.method, s.grid)), 1.5
    for name, (read, power) in reads.items():
        yield name, read(finest), {}
        left = [(max(finest.spacing) / max(s.spacing)) ** power * (read(s) - read(finest)) for s in coarser]
        half = stdtrit(len(left), 0.975) * math.hypot(*left) / math.sqrt(len(left) or math.nan)
        yield f"{name}_error", float(half), {"source": "grid"}


def _of_theory(run: Run) -> Expected:
    area, plastic = run.own_theory()
    ensemble = run.theory(run.spectral_moments[1], run.pressure())[0]
    known = {"area_persson_own": area, "area_ensemble": ensemble, "area_plastic_persson": plastic}
    yield from ((name, value, {}) for name, value in known.items() if not math.isnan(value))


def _of_ensemble(run: Run) -> Expected:
    """Yield the areas of the surfaces, over their own theory, their mean and its interval."""
    count, ensemble = run.realisations, run.scene.get("ensemble")
    if ensemble is None:
        return
    grids = set(map(tuple, ensemble["grids"]))
    areas = [run.limit("bem", k, grids)[0] for k in range(count)]
    for k, area in enumerate(areas):
        yield "area_each", area, {"surface": k}
        if not run.holds_distance:
            numbers = {
                "rms_gradient_each": math.sqrt(run.moments(k)[1]),
                "reduced_pressure_each": run.reduced_pressure(k),
                "area_persson_each": run.own_theory(k)[0],
            }
            known = {name: value for name, value in numbers.items() if not math.isnan(value)}
            yield from ((name, value, {"surface": k}) for name, value in known.items())
    mean = fmean(areas)
    yield "scatter", math.sqrt(math.fsum((a - mean) ** 2 for a in areas) / (count - 1)) / mean, {}


def yielded_areas(pressure: float, *, variance: float, hardness: float) -> Pair:
    """A_pl/A0 and A_el/A0 of Persson's theory for one hardness: diffusion between walls at 0 and H.

    What has passed a wall is that of the source and all its images in both, of either sign.
    """
    x, width = pressure / hardness, math.sqrt(2 * variance) / hardness
    walls = 2 * np.arange(2 + math.ceil(4 * np.nan_to_num(width)))  # beyond them nothing has spread
    detached = np.sum(erfc((walls + x) / width) - erfc((walls + 2 - x) / width))
    yielded = np.sum(erfc((walls + 1 - x) / width) - erfc((walls + 1 + x) / width))
    return yielded, 1 - yielded - detached
