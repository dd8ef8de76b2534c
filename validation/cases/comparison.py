"""The comparison itself: a scene whose every number is known, from the scene to its dataset."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np

from validation.audit import audit
from validation.cases import Checks, below, case, near, relative
from validation.cases._closed_forms import Westergaard
from validation.comparison.run import run_scene
from validation.execution.results import read_results
from validation.scenes.scene import Scene

_YOUNG, _POISSON = 1e6, 0.3
_MODULUS = _YOUNG / (1 - _POISSON**2)
_WAVE = Westergaard(amplitude=1e-3, contact_modulus=_MODULUS)
_HALF_WIDTH, _AMPLITUDE, _LOAD = _WAVE.half_width, _WAVE.amplitude, _WAVE.load
_GRADIENT = 2 * math.pi * _AMPLITUDE / math.sqrt(2)
_REDUCED = _LOAD / (_MODULUS * _GRADIENT)
_GRIDS = (64, 128, 256)
#: Excess of the counted area per edge and cell.
_EDGE = {"bem": 0.103, "fem": 0.198}


@case("comparison-wave", source="[westergaard1939]; Persson 2006, Eq. 20", tolerance="grid")
def _wave() -> Checks:
    """Of a wave pressed as a scene, every number of the dataset is Westergaard's.

    Press a cosine of period 1 until it touches over 60 %; its file holds 32 x 4 points.
    """
    with tempfile.TemporaryDirectory() as name:
        file, results = Path(name) / "wave.npy", Path(name) / "results"
        np.save(file, _AMPLITUDE * np.cos(2 * np.pi * np.arange(32) / 32)[:, None] * np.ones(4))
        scene = {
            "name": "case",
            "surface": {"kind": "file", "path": str(file), "length": [1.0, 0.125], "unit": 1.0},
            "solid": {"young": _YOUNG, "poisson": _POISSON},
            "load": {"pressure": _LOAD},
            "methods": {
                "theory": {},
                "bem": {"grids": [[n, n // 8] for n in _GRIDS]},
                "fem": {"grids": [[64, 8]], "method": "reduced"},
            },
        }
        run_scene(Scene.model_validate(scene), results, report=False)
        data, wrong = read_results(results).data, len(audit(results).wrong)
    theory, area = math.erf(math.sqrt(2) * _REDUCED), 2 * _HALF_WIDTH
    for words, variable, expected in (
        ("E* [Pa]", "contact_modulus", _MODULUS),
        ("p0 [Pa]", "pressure", _LOAD),
        ("h_rms [m]", "rms_height", _AMPLITUDE / math.sqrt(2)),
        ("h'_rms", "rms_gradient", _GRADIENT),
        ("Nayak parameter of a wave", "nayak", 1.5),
        ("p*", "reduced_pressure", _REDUCED),
        ("theory, erf(sqrt 2 p*)", "area_persson", theory),
    ):
        yield relative(words, data[variable], expected, 1e-12)
    # The law of error counts on edges that fall anywhere between grid points; those of a wave run along
    # the grid, two in all, and are placed to a tenth of a cell.
    placed = 0.2 / _GRIDS[-1]
    yield near("limit of A/A0", data.area_own, area, placed)
    yield below("95 % interval of the limit", data.area_own_error.sel(source="grid"), placed)
    yield near("limit over the theory, less one", data.area_excess, area / theory - 1, placed / theory)
    fem, bem = (data.sel(solver=solver, grid="64 x 8") for solver in ("fem", "bem"))
    ratio = float(fem.area_pixel / bem.area_pixel) - 1
    yield relative("FEM / BEM - 1 of the counted area", fem.area_pixel_difference, ratio, 1e-9)
    yield below("FEM against BEM in pressure", fem.pressure_difference, 0.1)
    yield below("numbers that the audit disagrees with", wrong, 0)
    for solver, n in (*(("bem", n) for n in _GRIDS), ("fem", 64)):
        # The strip has two edges in every line of n points; a point more or less lies on either.
        row, name = data.sel(solver=solver, grid=f"{n} x {n // 8}"), f"{solver} {n}x{n // 8}"
        corrected = float(row.area_pixel) - 2 * _EDGE[solver] / n
        # The window of P(0+): 0.2 E* h' (dx / l)^(1/2), with l = 1 the period. No point is so near to an edge
        # that its grid could bring it in or out: less than one on both edges is no difference.
        window, p = 0.2 / math.sqrt(n), _WAVE.pressure((np.arange(n) / n + 0.5) % 1 - 0.5)
        start = np.mean((p > 0) & (p < window * _MODULUS * _GRADIENT)) / window
        yield near(f"{name}: pixel", row.area_pixel, area, 2 / n)
        yield relative(f"{name}: perimeter", row.area_perimeter, corrected, 1e-12)
        yield relative(f"{name}: kappa", row.kappa_perimeter, corrected / _REDUCED, 1e-12)
        yield near(f"{name}: P(0+)", row.density_at_zero, start, 1 / n / window)
