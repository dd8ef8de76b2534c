"""What each effect costs relative to the plain elastic solve, on the same surface, grid and load.

``python tests/benchmarks/effects_cost.py [points]`` prints seconds and FFT pairs of the second of two solves,
so that compilation is left out, and their ratios to the plain solve beside it.
"""

from __future__ import annotations

import sys

from fem_contact import adhesion, bem
from fem_contact.adhesion.laws import Dugdale, Exponential
from fem_contact.contact import ContactResult
from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.hardness import Hardness, press_yielding
from fem_contact.response import BondedLayer, HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface


def rough(points: int) -> HeightField:
    """Return a surface with lambda_long = L/4, lambda_short = L/32 and gradient 0.1."""
    surface = random_surface(
        lambda q: q**-3.6, q_short=201.0, lengths=(1.0, 1.0), shape=(points, points), seed=8
    )
    return HeightField(heights=surface.heights * (0.1 / surface.rms_gradient), lengths=(1.0, 1.0))


def main(points: int) -> None:
    """Print the table."""
    surface, solid, load = rough(points), Solid(young=1.0, poisson=0.0), 0.005
    half, soft = HalfSpace(solid=solid), Solid(young=0.3, poisson=0.0)
    # Work of adhesion for attraction and repulsion of the same order; the range makes its zone three cells.
    work = 5e-5
    reach = (3 / points * work) ** 0.5
    layer = BondedLayer(solid=solid, thickness=0.1)
    coated = LayeredSolid(layers=[soft], thicknesses=[0.02], base=solid)
    graded = ExponentialSolid(surface=solid, bulk_young=3.0, depth=0.05)

    def sticky(law: adhesion.GapLaw, hardness: float | None = None) -> ContactResult:
        return adhesion.solve(
            surface, half, law=law, hardness=hardness, mean_pressure=load, tolerance=1e-8
        ).contact

    cases = {
        "plain elastic": lambda: bem.solve(surface, half, mean_pressure=load),
        "thickness": lambda: bem.solve(surface, layer, mean_pressure=load),
        "coating": lambda: bem.solve(surface, coated, mean_pressure=load),
        "graded": lambda: bem.solve(surface, graded, mean_pressure=load),
        "hardness 0.06": lambda: press_yielding(
            surface, half, hardness=Hardness(pressure=0.06), mean_pressure=load
        ),
        "adhesion, exponential": lambda: sticky(Exponential(work=work, reach=reach)),
        "adhesion, hardness 0.06": lambda: sticky(Exponential(work=work, reach=reach), 0.06),
        "adhesion, Dugdale": lambda: sticky(Dugdale(work=work, reach=reach)),
    }
    first = (1.0, 1.0)
    print(f"{points} x {points}: effect, seconds, FFT pairs, both over plain elastic, A/A0")
    for name, solve in cases.items():
        solve().checked()
        contact = solve().checked()
        numbers = (contact.cost.wall_seconds, contact.cost.fft_pairs)
        first = numbers if name == "plain elastic" else first
        ratios = [a / b for a, b in zip(numbers, first, strict=True)]
        print(
            f"{name:24s} {numbers[0]:8.3f} {numbers[1]:8.1f} {ratios[0]:8.2f} {ratios[1]:8.2f} "
            f"{contact.in_contact.mean():8.4f}"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 256)
