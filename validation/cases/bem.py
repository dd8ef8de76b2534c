"""What the boundary-element solver alone is held against: punch, light egg box, energy, area, steps."""

from __future__ import annotations

import math

import numpy as np

from fem_contact.area import subcell_area
from fem_contact.bem import solve, solve_path
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.stress import elastic_energy, loading_work
from fem_contact.surface import HeightField
from validation.cases import Checks, below, case, order, relative
from validation.cases._closed_forms import EGG_BOX_DEPTH, EGG_BOX_FLAT, egg_box
from validation.cases.scorecard.subject import rough

_SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))


@case(
    "bem-punch",
    source="K. L. Johnson, Contact Mechanics, Sec. 13.2; edge half a cell outside the last point",
    tolerance="grid",
)
def _punch() -> Checks:
    """Boundary elements converge to the pressure under periodic flat punches.

    Press a periodic flat punch, half width b: p = p0 cos(pi x) / (sin^2(pi b) - sin^2(pi x))^(1/2).
    """
    # The discrete edge lies half a cell outside the outermost point: at 1/6 of the period on each of these.
    sizes, errors, half_width = (45, 135, 405), [], 1 / 6
    for n in sizes:
        inside = np.abs(np.arange(n) - n // 2) <= n // 6
        surface = HeightField(heights=np.where(inside, 0.0, -1.0)[:, None] * np.ones(3), lengths=(1.0, 3 / n))
        result = solve(surface, _SOFT, mean_pressure=1e-3).checked()
        # The edge leaves an error of alternating sign from point to point, which these weights take out.
        middle, weights = np.arange(-1, 2) / n, (0.25, 0.5, 0.25)
        root = np.sqrt(math.sin(math.pi * half_width) ** 2 - np.sin(math.pi * middle) ** 2)
        exact = np.dot(weights, 1e-3 * np.cos(math.pi * middle) / root)
        smoothed = np.dot(weights, result.pressure[n // 2 - 1 : n // 2 + 2, 0])
        errors.append(abs(float(smoothed / exact) - 1))
    yield below("relative error of the pressure at the middle, finest grid", errors[-1], 3e-3)
    # The singular edge is misplaced by a share of a cell; the next term is of second order, 2/45 of it.
    yield order("its observed order", sizes, errors, expected=1, tolerance=0.05)


@case("bem-egg-box-light", source="[johnson1985]", tolerance="estimate")
def _egg_box_light() -> Checks:
    """An egg box under light load touches like isolated spheres.

    Each peak is a sphere of radius 1 / (4 pi^2 D): two contacts of Hertz in a period.
    """
    for share, allowed in ((2e-3, 0.03), (2e-4, 0.015)):
        result = solve(egg_box(512), _SOFT, mean_pressure=share * EGG_BOX_FLAT).checked()
        curvature = 4 * math.pi**2 * EGG_BOX_DEPTH
        radius = (3 * share * EGG_BOX_FLAT / 2 / (4 * curvature)) ** (1 / 3)
        area = subcell_area(result)
        # Neighbours add to the curvature in the third power of a over their distance, 1/sqrt 2.
        yield relative(f"A/A0 at {share:g} of the flattening load", area, 2 * math.pi * radius**2, allowed)


@case("bem-energy", source="conservation of energy", tolerance="estimate")
def _energy() -> Checks:
    """The work of loading equals the elastic energy, to second order in the steps."""
    misses = []
    for count in (9, 17, 33):
        path = solve_path(rough(96), _SOFT, mean_pressures=np.geomspace(0.02, 0.5, count), tolerance=1e-10)
        stored = elastic_energy(path[-1].checked()) - elastic_energy(path[0])
        misses.append(abs(loading_work(path)[-1] / stored - 1))
    yield below("relative difference in 32 steps", misses[-1], 1e-3)
    yield order("its observed order in the step", (8, 16, 32), misses, expected=2, tolerance=0.3)
