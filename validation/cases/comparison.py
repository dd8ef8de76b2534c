"""The comparison itself: scenes whose every number is known, from the scene to its dataset."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from validation.audit import audit
from validation.cases import Check, below, case, near, relative, within
from validation.cases._closed_forms import westergaard_mean_pressure, westergaard_pressure
from validation.comparison.run import run_scene
from validation.execution.results import read_results
from validation.measurements.convergence import fitted_line
from validation.measurements.statistics import order_of_convergence
from validation.report import estimates, values
from validation.report.table import budget_table
from validation.scenes.scene import Scene

_YOUNG, _POISSON = 1e6, 0.3
_MODULUS = _YOUNG / (1 - _POISSON**2)
#: Excess of the counted area per edge and cell.
_EDGE = {"bem": 0.103, "fem": 0.198}


@dataclass(frozen=True, kw_only=True)
class _Written:
    """What a run left on disk: its dataset, what was found, and how many numbers the audit found wrong."""

    data: xr.Dataset
    findings: tuple[str, ...]
    wrong: int

    def number(self, name: str, *at: str) -> float:
        """Return one number of the dataset, at a method and grid where it has them."""
        return float(self.data[name].sel(dict(zip(("solver", "grid"), at, strict=False))))


def _run(scene: dict[str, Any], folder: Path) -> _Written:
    """Run a scene into a folder and read back what it left."""
    said = {"name": "case", "solid": {"young": _YOUNG, "poisson": _POISSON}, **scene}
    page = run_scene(Scene.model_validate(said), folder / "results", report=False).page
    data = read_results(folder / "results").data
    return _Written(data=data, findings=page.findings, wrong=len(audit(folder / "results").wrong))


_HALF_WIDTH, _AMPLITUDE = 0.3, 1e-3
_WAVE_GRIDS = (64, 128, 256)


@case(
    "comparison-wave",
    "Of a wave pressed as a scene, every number of the dataset is Westergaard's.",
    source="H. M. Westergaard, J. Appl. Mech. 6, 49 (1939); Persson 2006, Eq. 20",
    tolerance="grid",
)
def _wave() -> Iterator[Check]:
    """Press a cosine of period 1 until it touches over 60 %; its file holds 32 x 4 points."""
    load = westergaard_mean_pressure(_AMPLITUDE, half_width=_HALF_WIDTH, contact_modulus=_MODULUS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wave = _AMPLITUDE * np.cos(2 * np.pi * np.arange(32) / 32)[:, None] * np.ones(4)
        np.save(folder / "wave.npy", wave)
        surface = {"kind": "file", "path": str(folder / "wave.npy"), "length": [1.0, 0.125], "unit": 1.0}
        found = _run(
            {
                "surface": surface,
                "load": {"pressure": load},
                "methods": {
                    "theory": {},
                    "bem": {"grids": [[n, n // 8] for n in _WAVE_GRIDS]},
                    "fem": {"grids": [[64, 8]], "method": "reduced"},
                },
            },
            folder,
        )
    gradient = 2 * math.pi * _AMPLITUDE / math.sqrt(2)
    reduced = load / (_MODULUS * gradient)
    theory, area = math.erf(math.sqrt(2) * reduced), 2 * _HALF_WIDTH
    counted = [found.number("area_pixel", method, "64 x 8") for method in ("fem", "bem")]
    error = float(found.data.area_own_error.sel(source="grid"))
    yield relative("E* [Pa]", found.number("contact_modulus"), _MODULUS, 1e-12)
    yield relative("p0 [Pa]", found.number("pressure"), load, 1e-12)
    yield relative("h_rms [m]", found.number("rms_height"), _AMPLITUDE / math.sqrt(2), 1e-12)
    yield relative("h'_rms", found.number("rms_gradient"), gradient, 1e-12)
    yield relative("Nayak parameter of a wave", found.number("nayak"), 1.5, 1e-12)
    yield relative("p*", found.number("reduced_pressure"), reduced, 1e-12)
    yield relative("theory, erf(sqrt 2 p*)", found.number("area_persson"), theory, 1e-12)
    # The law of error counts on edges that fall anywhere between grid points; those of a wave run along
    # the grid, two in all, and are placed to a tenth of a cell.
    yield near("limit of A/A0", found.number("area_own"), area, 0.2 / _WAVE_GRIDS[-1])
    yield below("95 % interval of the limit", error, 0.04 * area)
    yield near(
        "limit over the theory, less one",
        found.number("area_excess"),
        area / theory - 1,
        0.2 / _WAVE_GRIDS[-1] / theory,
    )
    yield relative(
        "FEM / BEM - 1 of the counted area",
        found.number("area_pixel_difference", "fem", "64 x 8"),
        counted[0] / counted[1] - 1,
        1e-9,
    )
    yield below("FEM against BEM in pressure", found.number("pressure_difference", "fem", "64 x 8"), 0.1)
    for n in _WAVE_GRIDS:
        yield from _wave_row(found, "bem", n, reduced)
    yield from _wave_row(found, "fem", 64, reduced)


def _wave_row(found: _Written, method: str, n: int, reduced: float) -> Iterator[Check]:
    """Judge one row of the table: the strip has two edges in every line of n points."""
    grid, name = f"{n} x {n // 8}", f"{method} {n}x{n // 8}"
    pixel, perimeter = (found.number(f"area_{how}", method, grid) for how in ("pixel", "perimeter"))
    # The window of P(0+): 0.2 E* h' (dx / l)^(1/2), with l = 1 the period.
    window = 0.2 / math.sqrt(n)
    x = np.linspace(0, _HALF_WIDTH, 200001)
    p = westergaard_pressure(x, half_width=_HALF_WIDTH, mean_pressure=reduced)
    share = 2 * (_HALF_WIDTH - float(x[np.argmax(p < window)]))
    density = found.number("density_at_zero", method, grid)
    yield near(f"{name}: pixel", pixel, 2 * _HALF_WIDTH, 2 / n)
    yield relative(f"{name}: perimeter", perimeter, pixel - 2 * _EDGE[method] / n, 1e-12)
    yield relative(
        f"{name}: kappa", found.number("kappa_perimeter", method, grid), perimeter / reduced, 1e-12
    )
    # A point more or less on either edge.
    yield near(f"{name}: P(0+)", density, share / window, 2 / n / window)


_ROUGH = {
    "kind": "self-affine",
    "length": 1.0,
    "hurst": 0.7,
    "lambda_long": 0.5,
    "lambda_short": 0.25,
    "rms_gradient": 0.02,
    "seed": 2718,
}


@case(
    "comparison-full-contact",
    "Of a surface in full contact, every number of its table is exact.",
    source="Persson 2006, Eq. 20; exact",
)
def _full() -> Iterator[Check]:
    """Press a rough surface with eight deviations of its full-contact stress."""
    reduced = 4.0
    with tempfile.TemporaryDirectory() as name:
        found = _run(
            {
                "surface": _ROUGH,
                "load": {"reduced_pressure": reduced},
                "methods": {
                    "theory": {},
                    "bem": {"grids": [12, 24, 32]},
                    "fem": {"grids": [12], "method": "reduced"},
                },
            },
            Path(name),
        )
    complete = any("Contact is complete: A/A0 = 1" in text for text in found.findings)
    yield relative("numbers that the audit disagrees with", found.wrong, 0.0, 0.0)
    yield relative("it is said to be complete", complete, 1.0, 0.0)
    yield relative("p*", found.number("reduced_pressure"), reduced, 1e-12)
    yield relative("limit of A/A0", found.number("area_own"), 1.0, 1e-12)
    yield relative("theory", found.number("area_persson"), 1.0, 1e-12)
    yield relative("theory from C(q)", found.number("area_ensemble"), 1.0, 1e-12)
    yield relative(
        "FEM against BEM, counted area", found.number("area_pixel_difference", "fem", "12 x 12"), 0.0, 0.0
    )
    for method, grid in (("bem", "12 x 12"), ("bem", "24 x 24"), ("bem", "32 x 32"), ("fem", "12 x 12")):
        for name, exact in (
            ("area_pixel", 1.0),
            ("area_perimeter", 1.0),
            ("kappa_perimeter", 1 / reduced),
            ("density_at_zero", 0.0),
        ):
            value = found.number(name, method, grid)
            yield relative(f"{method} {grid}: {name}", value, exact, 1e-12)


@case(
    "comparison-ensemble",
    "Each surface of an ensemble is compared with the theory of its own gradient.",
    source="Persson 2006, Eq. 20; exact",
)
def _ensemble() -> Iterator[Check]:
    """Press three surfaces of one spectrum with one pressure: each has its own gradient and theory."""
    with tempfile.TemporaryDirectory() as name:
        found = _run(
            {
                "surface": {**_ROUGH, "amplitudes": "gaussian"},
                "load": {"pressure": 0.1 * 0.02 * _MODULUS},
                "methods": {"theory": {}, "bem": {"grids": [16, 32, 48]}},
                "ensemble": {"realisations": 3, "grids": [16, 32]},
            },
            Path(name),
        )
    data = found.data
    argument = math.sqrt(2) * found.number("reduced_pressure")
    spread = data.area_persson_each.values
    gradients = found.number("rms_gradient") / 0.02
    ratios = data.area_each.values / spread
    deviation = math.sqrt(float(np.sum((ratios - ratios.mean()) ** 2)) / 2)
    yield relative("numbers that the audit disagrees with", found.wrong, 0.0, 0.0)
    yield relative("theory, erf(sqrt 2 p*)", found.number("area_persson_own"), math.erf(argument), 1e-12)
    yield relative(
        "theory from C(q), erf(sqrt 2 p* h' / h'_C)",
        found.number("area_ensemble"),
        math.erf(argument * gradients),
        1e-9,
    )
    yield relative("theory of the first surface", spread[0], math.erf(argument), 1e-9)
    yield within("theories of the others, apart by [%]", 100 * float(np.ptp(spread) / spread[0]), 0.1, 50)
    yield relative("mean above the theory", found.number("area_excess"), float(ratios.mean()) - 1, 1e-12)
    # Student's t of two degrees of freedom, 97.5 %, as tabled.
    yield relative(
        "its 95 % half width",
        data.area_excess_error.sel(source="surfaces"),
        4.3027 * deviation / math.sqrt(3),
        1e-4,
    )


@case(
    "comparison-intervals",
    "Intervals that claim 95 % hold in 95 of 100 trials, and shares of a budget add up.",
    source="Student, Biometrika 6, 1 (1908)",
    tolerance="estimate",
)
def _intervals() -> Iterator[Check]:
    """Plant means and scatters, and see what intervals are claimed and how often they hold."""
    # Student's t of n - 1 degrees of freedom, 97.5 %, as tabled.
    for n, student in ((2, 12.706), (3, 4.303), (5, 2.776), (10, 2.262), (30, 2.045)):
        planted = 5.0 + np.sqrt(np.arange(1, n + 1))
        error = float(np.sqrt(np.sum((planted - planted.mean()) ** 2) / (n - 1) / n))
        _, half = estimates.mean_of(xr.DataArray(planted, dims="surface"))
        yield relative(f"95 % half width of {n} samples", half, student * error, 3e-4)
    rng, trials = np.random.default_rng(314), 2000
    drawn = xr.DataArray(rng.normal(3.0, 0.4, (trials, 4)), dims=("trial", "surface"))
    middle, half = estimates.mean_of(drawn)
    held = int((abs(middle - 3.0) <= half).sum())
    # Four deviations of the binomial; 1.96 in place of Student's 3.18 would hold 86 %.
    yield near("share of 95 % intervals that hold", held / trials, 0.95, 0.02)
    together = values.combined(3.0, 4.0, 12.0)
    yield relative("independent errors of 3, 4 and 12", together, 13.0, 1e-12)
    spacing = np.array([0.4, 0.2, 0.1])
    observed = order_of_convergence(spacing, -0.3 * spacing**1.5)
    yield relative("order of errors like dx^1.5", observed, 1.5, 1e-9)
    rungs = [[2.0 + 0.5 * step**1.4] * 3 for step in spacing]
    ladder = fitted_line(rungs, spacing**1.4, common=True)
    yield relative("limit of a ladder of order 1.4", ladder.limit, 2.0, 1e-9)
    four = xr.Dataset({"kappa_each": ("surface", [2.0] * 4), "kappa_each_drift": ("surface", [0.08] * 4)})
    told = estimates.mean(estimates.claim(four, "kappa_each", grid=0.12), "kappa")
    # .12 / sqrt 4 at random, .08 that does not average, over 2.
    share = float(told.kappa_error.sel(source="grid")) / 2.0
    yield relative("share of the grid in a budget", share, 0.05, 1e-12)
    exact = dict.fromkeys(("size", "depth", "theory"), "nothing here depends on it")
    parts = {"grid": 0.06, "solver": 0.08, "surfaces": 0.24, "bandwidth": 1.68}
    known = estimates.claim(xr.Dataset({"kappa": 2.0}), "kappa", **parts, **exact)
    budget = budget_table(known, ["kappa"])
    row = dict(zip(budget.columns, budget.rows[0], strict=True))
    for name, expected in (("for this spectrum and period [%]", 13.0), ("for any [%]", math.hypot(13, 84))):
        yield relative(name, row[name], expected, 1e-12)
