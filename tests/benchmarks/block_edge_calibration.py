"""Calibrate the edge constant of the finite-element discretisations.

Paraboloids, whose contact radius in a periodic block is known, at random places on the grid: the constant c
for which pixel area - c edge_fraction is the true area on average, for each element and number of nodes per
radius.

Run as ``python tests/benchmarks/block_edge_calibration.py [places]``.
"""

from __future__ import annotations

import sys

import numpy as np

from fem_contact.area import contact_areas
from fem_contact.block import solve
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

#: Sum of 1/R^3 over the square lattice: what the periodic images add to the curvature of a paraboloid.
LATTICE_CUBE = 9.03362168

#: Contact radius over the period.
RADIUS = 0.15

ELEMENTS = (("Hex1", 0.3), ("Hex1", 0.0), ("Hex1/P0", 0.49), ("Hex2", 0.3), ("Hex2/P1disc", 0.5))


def excess(element: str, poisson: float, nodes: int, shift: np.ndarray) -> tuple[float, float]:
    """Counted minus true area, and the edge fraction, of one paraboloid."""
    solid, n = Solid(young=1.0, poisson=poisson), 2 * round(nodes / RADIUS / 2)
    radius = nodes / n
    load = 4 * solid.contact_modulus * radius**3 / 3
    curvature = 1 - load * LATTICE_CUBE / (2 * np.pi * solid.contact_modulus)
    x, y = ((np.arange(n) + part) / n - 0.5 for part in shift)
    heights = -(x[:, None] ** 2 + y[None, :] ** 2) * curvature / 2
    surface = HeightField(heights=heights, lengths=(1.0, 1.0))
    contact = solve(surface, solid, mean_pressure=load, growth=1.05, element=element).contact.checked()
    areas = contact_areas(contact)
    return areas.pixel - np.pi * radius**2, areas.edge_fraction


def main(places: int) -> None:
    """Print the constants with their standard errors."""
    for element, poisson in ELEMENTS:
        for nodes in (8, 16, 32):
            # Quadratic cells repeat every second node.
            shifts = 2 * np.random.default_rng(20060412).random((places, 2))
            found = np.array([excess(element, poisson, nodes, shift) for shift in shifts])
            constant = found[:, 0].mean() / found[:, 1].mean()
            error = (found[:, 0] / found[:, 1].mean()).std(ddof=1) / np.sqrt(places)
            print(
                f"{element:>12} nu = {poisson:<4} a/dx = {nodes:>2}: {constant:.4f} +- {error:.4f}",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 16)
