"""Calibrate the edge constant and the edge map of a discretisation, or the edge constant of each element.

Contacts whose edge is known, with many cells across: paraboloids (all directions) and waves in oblique
directions (straight edges), at random places on the grid. Prints the constants that `fem_contact.area` holds.

Run as ``python tests/benchmarks/edge_calibration.py [bem | fem | elements] [cases]``: `fem` are linear
hexahedra; `elements` takes cases for each element and number of nodes per radius (16 gave the constants).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fem_contact import bem, block
from fem_contact.area import contact_areas, contact_edges
from fem_contact.contact import ContactResult
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

sys.path.insert(0, str(Path(__file__).parents[1]))
from surfaces import periodic_paraboloid

#: The constants of finite elements depend on Poisson's ratio, those of boundary elements do not.
SOLID = Solid(young=1.0 - 0.3**2, poisson=0.3)
SOFT = HalfSpace(solid=SOLID)
Array = NDArray[np.float64]


def press(surface: HeightField, load: float, method: str) -> ContactResult:
    """Solve by one of the discretisations; slow grading makes the block a half-space within 1e-3."""
    if method == "bem":
        return bem.solve(surface, SOFT, mean_pressure=load, tolerance=1e-9).checked()
    solution = block.solve(surface, SOLID, mean_pressure=load, tolerance=1e-9, growth=1.1, element="Hex1")
    return solution.contact.checked()


def paraboloid(
    n: int, radius: float, shift: tuple[float, float], method: str
) -> tuple[ContactResult, Array, float]:
    """A Hertzian contact of given radius [period]; the true place of each edge pair, and the true area."""
    surface, load, _ = periodic_paraboloid(n, radius, shift)
    x, y = ((np.arange(n) + part) / n - 0.5 for part in shift)
    result = press(surface, load, method)
    edges = contact_edges(result)
    i, j = np.unravel_index(edges.inside, (n, n))
    along = np.where(edges.axis == 0, x[i], y[j]) * edges.sign
    across = np.where(edges.axis == 0, y[j], x[i])
    chord = np.sqrt(np.maximum(radius**2 - across**2, 0))
    place = np.where(np.abs(across) < 0.995 * radius, (chord - along) * n, np.nan)
    return result, place, float(np.pi * radius**2)


def wave(
    n: int, numbers: tuple[int, int], share: float, phase: float, method: str
) -> tuple[ContactResult, Array, float]:
    """Contact with a sinusoidal profile in an oblique direction (Westergaard), of given contact share."""
    x = np.arange(n) / n
    turns = numbers[0] * x[:, None] + numbers[1] * x[None, :] + phase
    wavelength = 1 / np.hypot(*numbers)
    load = np.pi / wavelength * np.sin(np.pi * share / 2) ** 2
    surface = HeightField(heights=np.cos(2 * np.pi * turns), lengths=(1.0, 1.0))
    result = press(surface, load, method)
    edges = contact_edges(result)
    distance = np.abs((turns.ravel()[edges.inside] + 0.5) % 1 - 0.5)
    pace = np.abs(np.asarray(numbers))[edges.axis] / n
    with np.errstate(divide="ignore"):
        place = np.where(pace > 0, (share / 2 - distance) / pace, np.nan)
    return result, np.where(edges.cosine > 0.1, place, np.nan), share


def elements(places: int) -> None:
    """Print the constant of each element with its standard error, for paraboloids at random places."""
    known = (("Hex1", 0.3), ("Hex1", 0.0), ("Hex1/P0", 0.49), ("Hex2", 0.3), ("Hex2/P1disc", 0.5))
    for (element, poisson), nodes in ((pair, nodes) for pair in known for nodes in (8, 16, 32)):
        solid, n, values = Solid(young=1.0, poisson=poisson), 2 * round(nodes / 0.3), []
        # Quadratic cells repeat every second node.
        for shift in 2 * np.random.default_rng(20060412).random((places, 2)):
            surface, load, _ = periodic_paraboloid(n, nodes / n, tuple(shift), modulus=solid.contact_modulus)
            solution = block.solve(surface, solid, mean_pressure=load, growth=1.05, element=element)
            areas = contact_areas(solution.contact.checked())
            values.append((areas.pixel - np.pi * (nodes / n) ** 2, areas.edge_fraction))
        excess, fraction = np.transpose(values)
        error = (excess / fraction.mean()).std(ddof=1) / np.sqrt(places)
        constant = excess.mean() / fraction.mean()
        print(f"{element:>12} nu = {poisson:<4} a/dx = {nodes:>2}: {constant:.4f} +- {error:.4f}", flush=True)


def main(method: str = "bem", cases: int = 100) -> None:
    """Print constants and the errors they leave; from three cases on there is a wave among them."""
    if cases < 3:
        raise SystemExit(f"{cases} cases: at least 3")
    if method == "elements":
        elements(cases)
        return
    generator = np.random.default_rng(2024)
    features, places, weights = [], [], []
    constants: dict[str, list[tuple[float, float]]] = {"paraboloid": [], "wave": []}
    solves = [("paraboloid", k) for k in range(cases)] + [("wave", k) for k in range(cases // 3)]
    for kind, k in solves:
        if kind == "paraboloid":
            radius = 0.035 + 0.04 * generator.random()
            shift = (float(generator.random()), float(generator.random()))
            case = paraboloid(512 if method == "bem" else 384, radius, shift, method)
        else:
            numbers = [(2, 1), (3, 1), (3, 2), (4, 1), (1, 3), (2, 3), (1, 4), (4, 3)][k % 8]
            case = wave(251, numbers, 0.2 + 0.3 * generator.random(), generator.random(), method)
        result, place, area = case
        areas, edges = contact_areas(result), contact_edges(result)
        constants[kind].append((areas.pixel - area, areas.edge_fraction))
        if kind == "wave":
            continue
        known = np.isfinite(place)
        features.append(edges.features()[known])
        places.append(place[known])
        # Equal weight to every problem, and within it to every piece of edge.
        weight = edges.cosine[known] ** 2
        weights.append(weight / weight.sum())
    for kind, values in constants.items():
        excess, fraction = np.sum(values, axis=0)
        ratios = [e / f for e, f in values]
        error = np.std(ratios) / np.sqrt(len(ratios))
        print(f"{kind}: edge constant {excess / fraction:.4f} +- {error:.4f}")
    design, target, weight = (np.concatenate(column) for column in (features, places, weights))
    root = np.sqrt(weight)
    coefficients, *_ = np.linalg.lstsq(design * root[:, None], target * root)
    rest = target - design @ coefficients
    print("edge map:", ", ".join(f"{value:.5f}" for value in coefficients))
    print(f"scatter about it: {np.sqrt(np.average(rest**2, weights=weight)):.4f} cells")


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((str, int), sys.argv[1:], strict=False)))
