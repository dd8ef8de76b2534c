"""What is pressed: layers, graded and yielding solids, and what the effects of a scene make of them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fem_contact import bem
from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.response import BondedLayer, FrictionlessLayer, HalfSpace, Response
from fem_contact.solid import Solid, composite_modulus
from fem_contact.surface import HeightField
from persson.adhesion import Interface, solve_adhesion
from persson.scale import Scale
from validation.cases import Check, below, case, holds, order, relative, within
from validation.effects.adhesion import Adhesion
from validation.effects.base import ContactModel, Roughness, TheoryInputs, full_contact_energy
from validation.effects.coating import Coating
from validation.effects.graded import Graded
from validation.effects.hardness import Hardness
from validation.effects.thickness import Thickness
from validation.scenes.problem import realise
from validation.scenes.scene import Scene
from validation.solvers.theory import TheoryOptions, predict


def _felt(response: Response, q: float) -> float:
    """Return C(q) [m/Pa] along x."""
    return float(response.compliance(np.array([[q]]), np.zeros((1, 1)))[0, 0])


@case(
    "bodies-oblong",
    "Waves along either side of an oblong period are pressed flat by (E* q / 2) h.",
    source="K. L. Johnson, Contact Mechanics, Sec. 13.2",
    tolerance="solver",
)
def _oblong() -> Iterator[Check]:
    solid, lengths, n = Solid(young=2.0, poisson=0.3), (3.0, 0.5), 16
    x = np.cos(2 * math.pi * np.arange(n) / n)
    for axis in (0, 1):
        heights = 0.3 + 1e-3 * (x[:, None] * np.ones(n) if axis == 0 else np.ones(n)[:, None] * x)
        surface = HeightField(heights=heights, lengths=lengths)
        found = bem.solve(surface, HalfSpace(solid=solid), mean_pressure=0.1).checked()
        exact = 2.0 / 0.91 * math.pi / lengths[axis] * 1e-3
        amplitude = float(np.ptp(found.pressure)) / 2
        yield relative(f"amplitude of p, wave along {'xy'[axis]} [Pa]", amplitude, exact, 1e-9)
        # Pressed flat, u = h less its mean: the mean planes are as far apart as the mean height.
        yield relative(f"offset, wave along {'xy'[axis]} [m]", found.offset, 0.3, 1e-9)
    two = composite_modulus(solid, Solid(young=5.0, poisson=0.2))
    yield relative("E* of two bodies [Pa]", two, 1 / (0.91 / 2 + 0.96 / 5), 1e-12)


@case(
    "bodies-layers",
    "Layers give by their compliance: thin ones by their confined modulus, thick ones as half-spaces.",
    source="K. L. Johnson, Contact Mechanics, Sec. 5.8",
)
def _layers() -> Iterator[Check]:
    solid, thickness = Solid(young=2.0, poisson=0.3), 0.1
    confined = 2.0 * 0.7 / (1.3 * 0.4)
    layers: dict[str, Response] = {
        "bonded": BondedLayer(solid=solid, thickness=thickness),
        "frictionless": FrictionlessLayer(solid=solid, thickness=thickness),
    }
    for name, layer in layers.items():
        pressed = bem.solve(
            HeightField(heights=np.zeros((4, 4)), lengths=(1.0, 1.0)), layer, mean_pressure=0.02
        ).checked()
        sunk = float(np.mean(pressed.displacement))
        # A layer that may slide in the wave's own plane is confined across it alone.
        long = thickness / (confined if name == "bonded" else solid.contact_modulus)
        half = 2 / (solid.contact_modulus * 200)
        yield relative(f"displacement under even load, {name} [m]", sunk, 0.02 * thickness / confined, 1e-12)
        yield relative(f"C of a long wave, {name} [m/Pa]", _felt(layer, 1e-3), long, 1e-5)
        yield relative(f"C of a short wave, {name} [m/Pa]", _felt(layer, 200.0), half, 1e-10)
    yield from _pressed_flat()


def _pressed_flat() -> Iterator[Check]:
    """Press a wave flat on a layer: the pressure amplitude is the height over the compliance, exactly."""
    x = np.cos(2 * np.pi * np.arange(48) / 48)
    surface = HeightField(heights=0.01 * x[:, None] * np.ones(4), lengths=(1.0, 1.0))
    for poisson in (0.3, 0.5):
        solid = Solid(young=1.0, poisson=poisson)
        a, k = 2 * math.pi * 0.1, 3 - 4 * poisson
        bonded = (k * math.sinh(2 * a) - 2 * a) / (k * math.cosh(2 * a) + 2 * a**2 + (k**2 + 1) / 2)
        sliding = (math.cosh(2 * a) - 1) / (math.sinh(2 * a) + 2 * a)
        for kind, layer, ratio in (
            ("bonded", BondedLayer(solid=solid, thickness=0.1), bonded),
            ("frictionless", FrictionlessLayer(solid=solid, thickness=0.1), sliding),
        ):
            amplitude = float(np.ptp(bem.solve(surface, layer, mean_pressure=10.0).checked().pressure)) / 2
            exact = 0.01 * math.pi * solid.contact_modulus / ratio
            name = f"pressure amplitude, {kind}, nu = {poisson}"
            yield relative(name, amplitude, exact, 1e-10)


@case(
    "bodies-graded",
    "A modulus that relaxes with depth is that of many thin layers, to second order.",
    source="exact layer matrices",
    tolerance="grid",
)
def _depth() -> Iterator[Check]:
    """Set 400 thin layers beside an exponential profile, which sums 64 that follow the wave."""
    surface = Solid(young=1.0, poisson=0.3)
    edges = np.linspace(0, 12, 401)
    middle = (edges[1:] + edges[:-1]) / 2
    layered = LayeredSolid(
        layers=[Solid(young=5 - 4 * math.exp(-z), poisson=0.3) for z in middle.tolist()],
        thicknesses=np.diff(edges).tolist(),
        base=Solid(young=5.0, poisson=0.3),
    )
    errors = []
    counts = (8, 16, 32, 64)
    for count in counts:
        graded = ExponentialSolid(surface=surface, bulk_young=5.0, depth=1.0, sublayers=count)
        errors.append(max(abs(_felt(graded, q) / _felt(layered, q) - 1) for q in (0.5, 2.0)))
    yield below("error of the usual sublayers at q d = .5 and 2", errors[-1], 3e-4)
    # The last is off by the thin layers that it is held against, too.
    yield order("its observed order", counts[:3], errors[:3], expected=2.0, tolerance=0.3)
    for q, young in ((1e4, 1.0), (1e-5, 5.0)):
        exact = 2 * 0.91 / (young * q)
        name = f"C of a {'short' if q > 1 else 'long'} wave [m/Pa]"
        yield relative(name, _felt(graded, q), exact, 1e-3)


@case(
    "bodies-yield",
    "A load equal to the hardness yields everywhere, with the least indentation.",
    source="exact",
    tolerance="solver",
)
def _yields() -> Iterator[Check]:
    x = np.cos(2 * math.pi * np.arange(24) / 24)
    surface = HeightField(heights=0.01 * x[:, None] * np.ones(8), lengths=(1.0, 1.0))
    body = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    full = bem.solve(surface, body, mean_pressure=0.02, pressure_bound=0.02).checked()
    yield relative("share at the bound", full.at_bound.mean(), 1.0, 0.0)
    # Under even pressure u = 0, and the deepest trough just touches.
    yield relative("offset of least indentation [m]", full.offset, -0.01, 1e-9)
    yield below("largest gap over h_rms", float(full.gap.max()) / surface.rms_height, 1e-9)


_ROUGHNESS = Roughness(
    modulus=1e9, gradient=0.1, curvature=1e5, longest=1e-5, shortest=1e-6, full_energy=0.01
)


@case(
    "effects-slots",
    "Effects of a scene give solver, mesh and theory the solid that they describe.",
    source="Persson 2006, Secs. 5 and 6; K. L. Johnson, Contact Mechanics, Sec. 5.8",
)
def _effects() -> Iterator[Check]:
    """Ask the effects of a scene what they give to solvers, meshes and the theory."""
    solid = Solid(young=2e9, poisson=0.3)
    graded, coating = Graded(bulk_young=8e9, depth=3e-6), Coating(young=6e9, thickness=1e-6)
    hard = Hardness(hardness=1e9, size_wavelength=1e-6, size_exponent=0.5)
    model, told = ContactModel.filled(solid, [graded]), TheoryInputs.by(solid, [graded])
    coated, rising = TheoryInputs.by(solid, [coating]), TheoryInputs.by(solid, [hard])
    assert model.body is not None
    at_depth = 8e9 - 6e9 / math.e
    mesh = float(model.body.modulus(np.zeros(1), np.zeros(1), np.array([-3e-6]))[0]) * 2e9  # type: ignore[misc]
    layers = {
        base: ContactModel.filled(solid, [Thickness(thickness=1e-6, base=base)]).felt_response
        for base in ("bonded", "frictionless")
    }

    def wave(felt: object, q: float) -> float:
        return float(np.squeeze(felt(np.array([q]))))  # type: ignore[operator]

    yield relative("graded, mesh: E at its depth [Pa]", mesh, at_depth, 1e-12)
    yield relative("graded, theory: E~* at q d = 1 [Pa]", wave(told.modulus, 1 / 3e-6), 5e9 / 0.91, 1e-12)
    yield relative(
        "graded, solver: 2 / (q C) of a long wave [Pa]",
        2 / (10 * _felt(model.felt_response, 10.0)),
        8e9 / 0.91,
        1e-3,
    )
    yield relative("coating, theory: short waves [Pa]", wave(coated.modulus, 1e9), 6e9 / 0.91, 1e-6)
    yield relative("coating, theory: long waves [Pa]", wave(coated.modulus, 1e1), 2e9 / 0.91, 1e-3)
    yield relative(
        "hardness at its wavelength [Pa]", wave(rising.hardness, 2e6 * math.pi), 2**0.5 * 1e9, 1e-12
    )
    yield relative("hardness at a third of it [Pa]", wave(rising.hardness, 6e6 * math.pi), 2e9, 1e-12)
    # (cosh 2a - 1) / (sinh 2a + 2a) at a = q d = 1, Johnson's Sec. 5.8.
    slides = (math.cosh(2) - 1) / (math.sinh(2) + 2) * 2 * 0.91 / 2e9 / 1e6
    yield relative("frictionless base: C(q) [m/Pa]", _felt(layers["frictionless"], 1e6), slides, 1e-12)
    for hardness, expected in ((1.9e8, True), (2.1e8, False)):
        # Four deviations of the stress at full contact, E* h'_rms / 2 = 5e7 Pa.
        said = Hardness(hardness=hardness).judge(_ROUGHNESS).matters
        yield holds(f"hardness {hardness:g} Pa matters", bool(said) == expected)
    yield from _judged_adhesion()


def _judged_adhesion() -> Iterator[Check]:
    """Change the units of a judgement: lengths by 2^20, pressures by 2^-30."""
    k, s = 2.0**20, 2.0**-30
    other = Roughness(
        modulus=1e9 * s,
        gradient=0.1,
        curvature=1e5 / k,
        longest=1e-5 * k,
        shortest=1e-6 * k,
        full_energy=0.01 * k * s,
    )
    one = Adhesion(work=0.05, reach=2e-9).judge(_ROUGHNESS).number
    two = Adhesion(work=0.05 * k * s, reach=2e-9 * k).judge(other).number
    yield holds("judgement of adhesion in other units is the same", one == two)


@case(
    "effects-theory",
    "The theory of a scene has its effects in it: contrasts, hardness, and readings of adhesion.",
    source="Persson 2006, Secs. 5, 6 and 8",
)
def _told() -> Iterator[Check]:
    """Ask the theory of a scene about effects, and about their limits."""
    problem = realise(
        Scene.model_validate(
            {
                "name": "case",
                "surface": {
                    "kind": "self-affine",
                    "length": 1e-4,
                    "hurst": 0.8,
                    "lambda_long": 2.5e-5,
                    "lambda_short": 5e-6,
                    "rms_gradient": 0.4,
                    "seed": 3_001,
                },
                "solid": {"young": 2e6, "poisson": 0.3},
                "load": {"reduced_pressure": 0.1},
                "methods": {"theory": {}, "bem": {"grids": [48]}},
            }
        )
    )
    modulus, pressure = problem.contact_modulus, problem.pressure
    plain = math.erf(math.sqrt(2) * 0.1)
    same = predict(problem, [Graded(bulk_young=2e6, depth=1e-6)])
    stiff = predict(problem, [Coating(young=8e6, thickness=1.0)])
    hard = predict(problem, [Hardness(hardness=1e3 * modulus)])
    soft = predict(problem, [Hardness(hardness=1.1 * pressure)])
    sticky = Adhesion(work=0.1 * full_contact_energy(problem.field, modulus=modulus), reach=1e-8)
    scale = Scale(problem.own_spectrum, contact_modulus=modulus)
    found = {
        energy: predict(problem, [sticky], TheoryOptions(energy=energy)) for energy in ("improved", "old")
    }
    flat = predict(problem, [sticky], TheoryOptions(area="projected"))
    yield relative("A/A0, graded without contrast", same.area, plain, 1e-9)
    yield relative("A/A0, coating deeper than all waves", stiff.area, math.erf(math.sqrt(2) * 0.1 / 4), 1e-9)
    yield relative("A/A0 of a hard solid", hard.area, plain, 1e-9)
    yield relative("A/A0 of one that yields everywhere", soft.area, 1 / 1.1, 1e-6)
    yield relative("A_pl/A0 of it", soft.plastic or 0.0, 1 / 1.1, 1e-6)
    for energy, prediction in found.items():
        interface = Interface(work_of_adhesion=sticky.work, energy=energy)  # type: ignore[arg-type]
        exact = solve_adhesion(scale, pressure=pressure, interface=interface).checked().real_area
        other = found["old" if energy == "improved" else "improved"].area
        yield relative(f"A/A0 with adhesion, {energy} energy", prediction.area, exact, 1e-9)
        yield relative(f"the other beside it, {energy} energy", prediction.other or 0.0, other, 1e-9)
    projected = Interface(work_of_adhesion=sticky.work, area="projected")
    exact = solve_adhesion(scale, pressure=pressure, interface=projected).checked().real_area
    yield relative("A/A0 with adhesion, areas projected", flat.area, exact, 1e-9)
    apart = min(abs(found["improved"].area - area) for area in (found["old"].area, flat.area, plain))
    yield within("these readings, apart by at least", apart, 1e-4, 1.0)
