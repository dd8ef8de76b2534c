"""What cannot be is refused by name, in one line: the function, what it is given, words of the refusal."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from made_results import made_areas, made_contact
from refusing import refused
from surfaces import rough_surface

from fem_contact import HeightField, Solid, adhesion, bem, block, creep, find_patches, measured_lay, slide
from fem_contact.adhesion import path as adhesion_path
from fem_contact.area import subcell_area
from fem_contact.block.elements import element_for
from fem_contact.block.full.assembly import lame
from fem_contact.conductance import frozen_contact
from fem_contact.contact import measure_residuals
from fem_contact.errors import (
    FemContactError,
    InsufficientMemory,
    InvalidInput,
    NotConverged,
    UnsupportedEffect,
)
from fem_contact.export import write_subsurface
from fem_contact.extrapolation import located_limit
from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.hardness import Hardness, press_by_patches
from fem_contact.leak import flow_conductance, percolates
from fem_contact.response import BondedLayer, FreeHalfSpace, GivenResponse, HalfSpace
from fem_contact.settings import Settings
from fem_contact.stress import density_at_zero, gap_distribution, pressure_distribution, von_mises
from fem_contact.subsurface import fields_below, strongest_point
from fem_contact.surface import Patch, random_surface
from fem_contact.viscoelastic import PronySolid, TabulatedSolid

SOLID, JELLY = Solid(young=1.0, poisson=0.3), Solid(young=1.0, poisson=0.5)
HALF, LAYER = HalfSpace(solid=SOLID), BondedLayer(solid=SOLID, thickness=0.2)
LAW = adhesion.Exponential(work=1e-4, reach=np.sqrt(2.5 / 32 * 1e-4))
ROUGH = rough_surface((16, 16), seed=7, waves=6)
FINE = rough_surface((32, 32), seed=11, waves=4, longest=1.9)
FLAT = HeightField(heights=np.zeros((8, 8)), lengths=(1.0, 1.0))
POINT = HeightField(heights=np.zeros((1, 1)), lengths=(1e-3, 1e-3))
AREAS, DIAGONAL = made_areas(0.1, 64, 0.1), np.eye(8, dtype=bool)

given = partial(GivenResponse, contact_modulus=1.0)
layered = partial(LayeredSolid, layers=[SOLID], base=SOLID)
series = partial(PronySolid, relaxed=1.0, poisson=0.3)
table = partial(TabulatedSolid, frequencies=[1.0, 10.0], storage=[1.0, 2.0], loss=[0.0, 0.1], poisson=0.3)
field_of = partial(HeightField, heights=np.zeros((2, 2)), lengths=(1.0, 1.0))
waves = {"spectrum": lambda q: 1e-6 * q**-3.6, "q_short": 15 * np.pi, "lengths": (1.0, 1.0)}
drawn = partial(random_surface, **waves, shape=(16, 16), seed=7)
press = partial(bem.solve, surface=ROUGH, response=HALF, mean_pressure=0.01)
stick = partial(adhesion.solve, FINE, HALF, law=LAW)
follow = partial(adhesion_path.follow, FINE, HALF, law=LAW)
aged = partial(creep, ROUGH, solid=series(moduli=(3.0,), times=(0.1,)), times=[0.0, 1.0], mean_pressure=1e-3)
fields = dict.fromkeys(("pressure", "gap", "heights"), np.ones((6, 4)))
residuals_of = partial(measure_residuals, **fields, lengths=(8, 4), contact_modulus=5.0, rms_gradient=0.2)
meshed = partial(replace, block.plan_mesh((8, 8), (1.0, 1.0)))
plan = partial(block.plan_mesh, (8, 8), lengths=(1.0, 1.0))
path = partial(block.solve_path, ROUGH, SOLID)
press_block = partial(block.solve, ROUGH, solid=SOLID, mean_pressure=1e-3)


class Source:
    poisson = 0.3

    def modulus(self, frequency):
        return np.full(np.shape(frequency), 1 - 0.1j)


def below(depths, response=LAYER):
    return fields_below(bem.solve(ROUGH, LAYER, mean_pressure=0.1), response, depths=depths)


def free_sided():
    heights = -((np.arange(12) / 12 - 0.5) ** 2)[:, None] * np.ones(12)
    patch = Patch(heights=heights, lengths=(1.0, 1.0))
    return strongest_point(bem.solve(patch, FreeHalfSpace(solid=SOLID), mean_pressure=1e-2), HALF)


def weighed():
    return strongest_point(replace(press(response=LAYER), weights=np.ones((16, 16))), LAYER)


def strait(width):
    gap = np.ones((24, 24))
    gap[11] = gap[23] = 0.0
    gap[11, 5] = gap[23, 17] = width
    return gap


def broken_modulus(bad):
    return {"modulus": lambda x, y, z: np.where((x < 0.06) & (y < 0.06) & (z > -0.06), bad, 1.0)}


def vast():
    return field_of(heights=np.zeros((4096, 4096)))


def steep():
    return HeightField(heights=1e29 * np.random.default_rng(3).random((8, 8)), lengths=(1e-115, 1e-115))


def each(function, name, *values, words):
    return ((function, {name: value}, words) for value in values)


NOT_REAL = r"heights = .*: must be real numbers in m"
POISSON = r"poisson = .*: must lie in \(-1, 0.5\]"
PERIODS = r"lengths = \(.*\): must be two positive periods \(Lx, Ly\) in m"

REFUSED = [
    # Solids and what responds like them.
    *each(partial(Solid, young=1e9), "poisson", 0.62, 0.5000001, -1.0, np.nan, np.inf, words=POISSON),
    (given, {"function": float}, "must be a function of qx and qy"),
    (press, {"response": given(function=lambda qx, qy: -1 + 0 * qx)}, "compliance"),
    (press, {"response": given(function=lambda qx, qy: np.ones((2, 2)))}, "compliance is not one positive"),
    (layered, {"thicknesses": [1.0, 2.0]}, "2 thicknesses for 1 layers"),
    *each(layered, "thicknesses", [0.0], [-1.0], [np.nan], [np.inf], words="thicknesses"),
    (partial(ExponentialSolid, surface=SOLID, bulk_young=1.0, depth=1.0), {"sublayers": 3}, "sublayers = 3"),
    *each(Hardness, "pressure", 0.0, -1.0, np.nan, np.inf, np.eye(1, 2)[0], np.array([]), words="pressure: "),
    (partial(Hardness, pressure=1.0), {"length": -1.0}, "length"),
    (series, {"moduli": (1.0, 2.0), "times": (1.0,)}, "must be as many"),
    (series, {"moduli": (-1.0,), "times": (1.0,)}, "no modulus negative"),
    (series, {"moduli": (1.0,), "times": (0.0,)}, "times = 0.0"),
    (table, {"frequencies": [1.0, 1.0]}, "rising"),
    (table, {"storage": [1.0, 1e-320]}, "storage = 1e-320: must be a positive"),
    (table, {"loss": [0.0, -1.0]}, "loss: moduli must not be negative"),
    (table, {"loss": [0.0]}, "must be as many"),
    # Surfaces.
    (field_of, {"heights": np.zeros(4)}, r"heights of shape \(4,\): must be a two-dimensional array \(nx"),
    (field_of, {"heights": np.zeros((0, 3))}, r"heights of shape \(0, 3\): must be"),
    (field_of, {"heights": np.zeros((2, 2, 2))}, r"heights of shape \(2, 2, 2\): must be"),
    (field_of, {"heights": [[0.0, np.nan], [np.inf, 1.0]]}, "2 of 4 heights are NaN or infinite: fill or"),
    *each(field_of, "heights", [[1.0, 2.0], [3.0]], [["a", "b"]], np.eye(2) * 1j, words=NOT_REAL),
    *each(field_of, "lengths", (1.0, 0.0), (-1.0, 1.0), (np.nan, 1.0), (np.inf, 1.0), words=PERIODS),
    *each(field_of, "lengths", (1.0,), (1.0, 1.0, 1.0), words=PERIODS),
    (ROUGH.shifted, {"fraction": (np.nan, 0.0)}, r"fraction = \(nan, 0.0\): must be two finite parts of a"),
    *each(ROUGH.spectral_sum, "weight", lambda q: q * np.nan, lambda q: None, words=r"weight\(q\)"),
    *each(ROUGH.spectral_sum, "weight", lambda q: q[:3], lambda q: "wide", words=r"weight\(q\)"),
    (lambda: FLAT.nayak, {}, "flat surface"),
    (lambda: steep().moments, {}, "curvatures leave the range of the arithmetic"),
    (drawn, {"shape": (16.5, 16)}, r"shape = \(16.5, 16\): must be two positive whole numbers"),
    (drawn, {"shape": (np.nan, 16)}, r"shape = \(nan, 16\): must be two positive whole numbers"),
    (drawn, {"shape": (0, 16)}, r"shape = \(0, 16\): must be"),
    (drawn, {"shape": (16,)}, r"shape = \(16,\): must be"),
    (drawn, {"q_short": 6.0}, r"no wave fits: lambda_short = 1.0472 m exceeds the periods \(1.0, 1.0\)"),
    (drawn, {"seed": -3}, "seed = -3: must be a whole number that is not negative, or a numpy.random.Gen"),
    (drawn, {"seed": 1.5}, "seed = 1.5: must be a whole number"),
    (drawn, {"isotropic": False}, "spectrum = .*: must be a function of qx and qy"),
    *each(drawn, "spectrum", lambda q: q * np.nan, lambda q: q * np.inf, words="spectrum.* not finite"),
    (drawn, {"spectrum": lambda q: np.where(q > 40, -1e-9, 1e-9)}, r"spectrum C\(q\) is negative"),
    (drawn, {"spectrum": lambda q: np.ones(3)}, r"spectrum of shape \(3,\): must be of the shape \(\d+,\)"),
    (drawn, {"spectrum": lambda qx, qy: 1 + 0.1 * np.sign(qx), "isotropic": False}, "its opposite"),
    (measured_lay, {"surface": FLAT}, "no lay"),
    # Settings.
    *(
        (function, {name: value}, f"^{name} = .*: must ")
        for function in (Settings, press)
        for name, values in {"tolerance": [0.11], "max_iterations": [2**63, 10.0], "threads": [1.5]}.items()
        for value in values
    ),
    # Boundary elements.
    (press, {"pressure_bound": np.ones((3, 3))}, "pressure_bound"),
    (press, {"pressure_bound": 1.0, "method": "polonsky-keer"}, "polonsky-keer"),
    (press, {"mean_pressure": 1e306}, r"mean_pressure = 1e\+306"),
    *each(press, "device", "nowhere", 5, None.__class__, [1.0], words="device"),
    (press, {"device": np.zeros(1), "method": "polonsky-keer"}, "runs on no device"),
    (partial(bem.solve_displacement, FLAT, LAYER, offset=-0.1), {"pressure_bound": 0.5}, "prescribe a mean"),
    (lambda: replace(press(), tolerance=None).area_interval, {}, "area_interval"),
    (lambda: frozen_contact(bem.solve(FLAT, HALF, mean_pressure=1.0), HALF), {}, "full contact"),
    # Adhesion and hardness.
    (stick, {}, "exactly one"),
    (stick, {"mean_pressure": 1.0, "offset": 1.0}, "exactly one"),
    (stick, {"offset": 0.0, "start": np.zeros((3, 3))}, "start"),
    (stick, {"offset": -1e-4}, "below the mean height"),
    (partial(adhesion.solve, POINT, HALF, law=LAW), {"mean_pressure": 0.0}, "one point has no waves"),
    (follow, {"offsets": [0.01, -1e-4]}, "below the mean height"),
    (follow, {"offsets": []}, "empty"),
    (stick, {"mean_pressure": 0.01, "hardness": 0.009}, "hardness with mean 0.009 Pa: must be above the"),
    (stick, {"mean_pressure": 0.01, "hardness": np.ones(3)}, "hardness of shape"),
    (stick, {"offset": 0.1, "hardness": 0.1}, "hardness: needs a mean pressure"),
    (partial(press_by_patches, FINE, press=None), {"hardness": 1.0}, "^hardness"),
    (partial(press_by_patches, 1.0, press=None), {"hardness": Hardness(pressure=1.0)}, "^surface"),
    # What changes in time.
    (partial(slide, ROUGH, velocity=1.0, mean_pressure=1e-3), {"solid": Source()}, "E'' not negative"),
    (aged, {"times": [1.0, 0.0]}, "times: must not fall"),
    (aged, {"mean_pressure": [1.0]}, "1 loads for 2 times"),
    (aged, {"mean_pressure": [1.0, 0.0]}, "positive, in Pa"),
    (aged, {"times": []}, "sequence of at least 1"),
    (aged, {"solid": SOLID}, "a `PronySolid`"),
    # What is read off a contact.
    *(
        (partial(made_contact, DIAGONAL), {name: "x"}, rf"^{name} = 'x': must be an? (array|mapping)$")
        for name in ("pressure", "in_contact", "weights", "provenance")
    ),
    *(
        (residuals_of, {name: np.ones((6, 1))}, rf"{name} of shape \(6, 1\): must have the shape \(6, 4\)")
        for name in ("gap", "heights", "at_bound", "weights")
    ),
    (lambda: subcell_area(made_contact(DIAGONAL, lengths=(1.0, 2.0))), {}, "square"),
    (lambda: subcell_area(made_contact(DIAGONAL, weights=np.ones((8, 8)))), {}, "weight"),
    *each(located_limit, "areas", [replace(AREAS, subcell=None)], words="edge located"),
    *each(located_limit, "areas", [], words="0 areas"),
    (partial(find_patches, spacing=(1.0, 1.0)), {"in_contact": np.ones(4, dtype=bool)}, "two-dimensional"),
    (lambda: density_at_zero(bem.solve(FLAT, HALF, mean_pressure=0.1)), {}, "flat"),
    (lambda: pressure_distribution(press(), [1.0, 0.5]), {}, "edges"),
    (lambda: gap_distribution(press(), [0.0]), {}, "edges"),
    (partial(flow_conductance, np.ones(5)), {"lengths": (1.0, 1.0)}, "map"),
    (partial(percolates, DIAGONAL), {"axis": "z"}, "axis"),
    (von_mises, {"tensor": np.ones((4, 3))}, "6 components"),
    (below, {"depths": [0.1, 0.3]}, r"below the base of the layer, at 0\.2 m"),
    (below, {"depths": [0.1, 0.1]}, "must rise"),
    (lambda: write_subsurface("a.vtu", below([0.1])), {}, "at least two"),
    # The block.
    (partial(block.wave_errors, (16, 16), (1.0, 1.0), [0.1]), {"poisson": 0.3}, "wavelength"),
    (lame, {"poisson": 0.5}, r"poisson = 0\.5"),
    *((partial(element_for, name), {"poisson": 0.5}, "element") for name in ("Hex1", "Hex2", "Hex1/P0")),
    (partial(element_for, "Hex7"), {"poisson": 0.3}, "element"),
    (meshed, {"cells": (0, 8)}, r"cells = \(0, 8\): must be"),
    (meshed, {"cells": "x"}, "must be"),
    (meshed, {"aspect": 0.0}, "aspect = 0"),
    (meshed, {"aspect": np.nan}, "aspect = nan"),
    (meshed, {"layers": np.array([1.0, -1.0])}, "the thinnest is -1"),
    (meshed, {"layers": np.array([])}, "at least 1 numbers"),
    (meshed, {"layers": None}, "layers = None"),
    (meshed, {"element": "Hex1"}, "element = 'Hex1': must be an `Element`"),
    (plan, {"first_layer": 1e-300}, "first_layer"),
    (plan, {"first_layer": 1e-12, "growth": 1.0}, "at most 10,000"),
    (plan, {"first_layer": 1e-6, "growth": 1 + 1e-12}, "at most 10,000"),
    (plan, {"depth": 1e300}, "depth"),
    (plan, {"depth": 1e20}, "cell widths"),
    *each(plan, "lengths", (1e30, 1e-30), (1e-118, 1e-118), (0.0, 1.0), "x", words="lengths = "),
    *((press_block, broken_modulus(bad), "modulus: 1 of") for bad in (np.nan, 0.0, -1.0, np.inf)),
    *(
        (press_block, {"method": method} | {name: value}, f"^{name} (=|of shape) ")
        for method in ("full", "reduced")
        for name, value in (
            ("method", np.array([])),
            ("modulus", 2.0),
            ("tolerance", 5e-324),
            ("start", np.ones((3, 3), dtype=bool)),
            ("growth", [1.2]),
            ("first_layer", 10**400),
            ("element", []),
        )
    ),
    (press_block, {"first": 1e-6}, "first = 1e-06: is no option.*first_layer"),
    (press_block, {"solid": JELLY, "method": "full"}, r"poisson = 0\.5.*method = 'reduced'"),
    (press_block, {"solid": Solid(young=1e30, poisson=0.3), "mean_pressure": 1e-35}, "range of the arith"),
    (press_block, {"solid": Solid(young=1e-35, poisson=0.3), "mean_pressure": 1e30}, "range of the arith"),
    *each(press_block, "mean_pressure", 1e-306, 3e38, 1e306, words="mean_pressure = "),
    *each(path, "mean_pressures", [1, 1e-306], [1, 3e38], [1, 1e306], [1, -1.0], words="mean_pressures? = "),
    (partial(block.solve_finite_strain, ROUGH, JELLY), {"mean_pressure": 0.1}, "takes 'Hex1' or 'Hex1/P0'"),
    (partial(block.solve_slopes, ROUGH, SOLID, slopes=(2, 1)), {"mean_pressure": 0.1}, "slopes: must rise"),
]
#: Of another kind.
OTHERS = [
    (NotConverged, lambda: frozen_contact(press(), HALF, max_iterations=2), "2 steps"),
    (NotConverged, lambda: flow_conductance(strait(1e-6), (1.0, 1.0)), "decades"),
    (InsufficientMemory, lambda: block.solve(vast(), SOLID, mean_pressure=1e6, method="full"), "GiB are av"),
    (UnsupportedEffect, lambda: below([0.1], given(function=lambda qx, qy: qx + qy)), "only its surface is"),
    (UnsupportedEffect, weighed, "quadratic elements"),
    (UnsupportedEffect, free_sided, "its sides are free"),
]


@pytest.mark.parametrize(
    ("kind", "call", "words"),
    [*((InvalidInput, partial(function, **given), words) for function, given, words in REFUSED), *OTHERS],
    ids=[f"{k} {words}" for k, (*_, words) in enumerate([*REFUSED, *OTHERS])],
)
def test_what_cannot_be_is_refused_by_name(kind, call, words):
    with refused(kind, words) as caught:
        call()
    assert isinstance(caught.value, FemContactError)
    assert kind is not InvalidInput or isinstance(caught.value, ValueError)
