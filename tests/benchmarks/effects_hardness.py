"""Elastic and plastic contact area of a yielding solid: boundary elements on grids against Persson's theory.

``python tests/benchmarks/effects_hardness.py`` prints one line per load and hardness: A_pl and A_el on nested
grids, their limit linear in dx over the two finest, and the theory with the realised gradient.
"""

from __future__ import annotations

import numpy as np

from fem_contact.hardness import Hardness, press_yielding, yielded
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from persson.elastic import stress_variance
from persson.hardness import constant_hardness

GRIDS = (128, 256, 512)


def surface(points: int, seed: int) -> HeightField:
    """Return a self-affine surface, H = 0.8, lambda_long = L/4, lambda_short = L/32, gradient near 0.1."""
    low, high = 4 * 2 * np.pi, 32 * 2 * np.pi
    scale = 0.01 / (2 * np.pi * (high**0.4 - low**0.4) / 0.4)
    return random_surface(
        lambda q: np.where(q >= low * (1 - 1e-9), scale * q ** (-3.6), 0.0),
        q_short=high,
        lengths=(1.0, 1.0),
        shape=(points, points),
        seed=seed,
    )


def main() -> None:
    """Print the table."""
    solid = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    print("p*     H/E*h'  part    " + "".join(f"{n:>9d}" for n in GRIDS) + "    limit  Persson")
    for reduced in (0.02, 0.05, 0.1, 0.2):
        for relative in (0.3, 0.6, 1.0):
            parts: list[list[tuple[float, float]]] = []
            expected = np.zeros(2)
            for seed in (3, 4):
                row = []
                for points in GRIDS:
                    field = surface(points, seed)
                    unit = field.rms_gradient
                    contact = press_yielding(
                        field,
                        solid,
                        hardness=Hardness(pressure=relative * unit),
                        mean_pressure=reduced * unit,
                    )
                    found = yielded(contact.checked())
                    row.append((found.plastic_area, found.elastic_area))
                parts.append(row)
                variance = stress_variance(unit**2, contact_modulus=1.0)
                theory = constant_hardness(
                    reduced * unit, stress_variance=variance, yield_stress=relative * unit
                )
                expected += np.array([float(theory.plastic), float(theory.elastic)]) / 2
            means = np.mean(parts, axis=0)
            limit = 2 * means[-1] - means[-2]
            for k, name in enumerate(("A_pl", "A_el")):
                values = "".join(f"{value:9.4f}" for value in means[:, k])
                print(f"{reduced:<6g} {relative:<7g} {name:7s} {values} {limit[k]:8.4f} {expected[k]:8.4f}")


if __name__ == "__main__":
    main()
