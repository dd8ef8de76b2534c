"""Boundary elements: punches, a light egg box, energy, one patch with free surroundings, layered solids."""

from __future__ import annotations

import math

import numpy as np

from fem_contact.area import subcell_area
from fem_contact.bem import solve, solve_path
from fem_contact.conductance import frozen_contact
from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.response import BondedLayer, FreeHalfSpace, FrictionlessLayer, HalfSpace, Response
from fem_contact.solid import Solid
from fem_contact.stress import elastic_energy, loading_work
from fem_contact.surface import HeightField, Patch
from validation.cases import Checks, below, case, order, relative
from validation.cases._closed_forms import EGG_BOX_DEPTH, EGG_BOX_FLAT, HertzInPeriod, egg_box, periodic
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


_FREE = FreeHalfSpace(solid=Solid(young=1.0, poisson=0.3))
#: Side of the patch over the contact radius: little more than the contact itself.
_SIDE = 2.5

#: Capacitance of a square plate over 4 pi eps times its side.
_SQUARE = 0.3667892


@case("free-hertz", source="[hertz1882]; [johnson_book], Sec. 4.2", tolerance="grid")
def _ball() -> Checks:
    """A ball on a patch hardly larger than its contact is Hertz's within .1 %: it has no images.

    Press a ball of radius 1 to a contact of radius .1; no grid point is its apex.
    """
    a, side = 0.1, _SIDE * 0.1
    hertz = HertzInPeriod(radius=a, contact_modulus=_FREE.contact_modulus)
    sizes, approaches, pressures, radii = (32, 64, 128, 256), [], [], []
    for n in sizes:
        x = (np.arange(n) + 0.25) * side / n - side / 2
        r = np.hypot(x[:, None], x[None, :])
        surface = Patch(heights=-(r**2) / 2, lengths=(side, side))
        result = solve(surface, _FREE, mean_pressure=hertz.load / side**2, tolerance=1e-9).checked()
        approaches.append(abs(-result.offset / a**2 - 1))
        off = np.abs(result.pressure - hertz.pressure(r)) / hertz.peak
        pressures.append(np.max(off[r < 0.8 * a]))
        area = subcell_area(result) * side**2
        radii.append(abs(math.sqrt(area / math.pi) / a - 1))
    yield below(f"error of the approach a^2/R at n = {sizes[-1]}", approaches[-1], 1e-3)
    yield below(f"largest error of p(r) over the peak inside .8 a, n = {sizes[-1]}", pressures[-1], 1e-3)
    yield below(f"error of the contact radius, located, at n = {sizes[-1]}", radii[-1], 1e-5)
    yield order("observed order of the approach", sizes, approaches, expected=2, tolerance=0.7)
    yield order("observed order of p(r)", sizes, pressures, expected=2, tolerance=0.7)


@case("free-punch", source="[read1997]: C = .3667892 x 4 pi eps L", tolerance="grid")
def _square_punch() -> Checks:
    """A flat square patch has the stiffness of a punch, that is the capacitance of a square plate.

    Pressures at the edges of a punch are infinite: first order.
    """
    sizes, errors, exact = (16, 32, 64), [], math.pi * _SQUARE * _FREE.contact_modulus
    for n in sizes:
        flat = Patch(heights=np.zeros((n, n)), lengths=(1.0, 1.0))
        result = solve(flat, _FREE, mean_pressure=0.01).checked()
        errors.append(1 - frozen_contact(result, _FREE).stiffness / exact)
    limit = 2 * errors[-1] - errors[-2]
    yield order("observed order of the stiffness", sizes, errors, expected=1, tolerance=0.2)
    yield below("error of its limit over the grids", abs(limit), 2e-3)


def _felt(response: Response, q: float) -> float:
    """Return C(q) [m/Pa] along x."""
    return float(response.compliance(np.array([[q]]), np.zeros((1, 1)))[0, 0])


@case("bodies-layers", source="K. L. Johnson, Contact Mechanics, Sec. 5.8")
def _layers() -> Checks:
    """A wave is pressed flat on a bonded and on a frictionless layer by its height over their compliance."""
    surface = periodic(0.01 * np.cos(2 * np.pi * np.arange(48) / 48)[:, None] * np.ones(4))
    for poisson in (0.3, 0.5):
        solid = Solid(young=1.0, poisson=poisson)
        a, k = 2 * math.pi * 0.1, 3 - 4 * poisson
        bonded = (k * math.sinh(2 * a) - 2 * a) / (k * math.cosh(2 * a) + 2 * a**2 + (k**2 + 1) / 2)
        sliding = (math.cosh(2 * a) - 1) / (math.sinh(2 * a) + 2 * a)
        for kind, layer, ratio in (
            ("bonded", BondedLayer(solid=solid, thickness=0.1), bonded),
            ("frictionless", FrictionlessLayer(solid=solid, thickness=0.1), sliding),
        ):
            amplitude = np.ptp(solve(surface, layer, mean_pressure=10.0).checked().pressure) / 2
            exact = 0.01 * math.pi * solid.contact_modulus / ratio
            yield relative(f"pressure amplitude, {kind}, nu = {poisson}", amplitude, exact, 1e-10)


@case("bodies-graded", source="exact layer matrices", tolerance="grid")
def _depth() -> Checks:
    """A modulus that relaxes with depth is that of many thin layers, to second order.

    Set 400 thin layers beside an exponential profile, which sums 64 that follow the wave.
    """
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
        yield relative(f"C of a {'short' if q > 1 else 'long'} wave [m/Pa]", _felt(graded, q), exact, 1e-3)
