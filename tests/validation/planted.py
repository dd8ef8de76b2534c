"""Benches that return planted results: what a study makes of numbers whose answer is known."""

import re
from types import SimpleNamespace

import numpy as np
import xarray as xr

from fem_contact import area_error
from validation.measurements.measurement import PATCH_EDGES, STRESS_EDGES

#: Student's factor of 95 % intervals, by number of samples (printed tables).
STUDENT = {2: 12.7062047364, 3: 4.30265272991, 4: 3.18244630528}
#: Edges over cells, times points along a side, of every planted contact.
EDGES = 2.0

SMALL = {"periods": 1.6, "bandwidth": 2.5, "points_per_wave": (4.0, 6.0, 8.0), "seed": 61}

#: Planted over three surfaces: mean 1, standard error 0.01, standard deviation 0.01 sqrt(3).
THREE = 1 + 0.01 * np.sqrt(3) * np.array([-1.0, 0.0, 1.0])


class PlantedBench:
    """A bench that solves nothing: `answer(solve)` is the result of each solve."""

    plan_only = False

    def __init__(self, answer):
        self.answer = answer

    def solve(self, solves):
        return {solve: self.answer(solve) for solve in solves}


def made_of(study, answer, **options):
    """What a study makes of the results that `answer` plants."""
    return study.run(study.Options(**options), bench=PlantedBench(answer))


def located(area, edges, law=area_error.LOCATED):
    """Return the located area, or that of another law, whose mean error, taken out, leaves `area`."""
    value = np.array([area])
    for _ in range(50):
        value = area + area_error.mean_error(law, value, np.array([edges]))
    return float(value[0])


def measurement(solve, area, **planted):
    """What `press_on_grids` leaves of a contact of known area; others by name, of p* and the grid.

    Counting adds .1 per edge and cell, the corrected area is right, and the located one off by what
    such areas are on average: every limit is `area`.
    """
    points = np.array([n for n, _ in solve["grids"]])
    loads = solve["reduced_pressures"] or solve["problem"].load.values
    shape = (points.size, solve["shifts"] ** 2, len(loads))
    dims = ("grid", "shift", "load")

    def over(value):
        rows = [[value(p, n) for p in loads] for n in points]
        return np.broadcast_to(np.array(rows, dtype=float)[:, None, :], shape).copy()

    quantities = {
        "pixel": lambda p, n: area(p) + 0.1 * EDGES / n,
        "perimeter": lambda p, n: area(p),
        "subcell": lambda p, n: located(area(p), EDGES / n),
        "edge_fraction": lambda p, n: EDGES / n,
        "density_at_zero": lambda p, n: 1 / n,
        "patches": lambda p, n: 7.0,
        "patch_size": lambda p, n: 1e-9,
        "cells_per_patch": lambda p, n: 0.01 * n**2,
        "mean_gap": lambda p, n: 1e-6,
        "energy": lambda p, n: 1.0,
        "stiffness": lambda p, n: 2.0,
        "residual": lambda p, n: 1e-9,
        "seconds": lambda p, n: 1e-6 * n**2,
        "peak_bytes": lambda p, n: 120.0 * n**2,
    } | planted
    data = {name: (dims, over(value)) for name, value in quantities.items()}
    # Of what is counted, .4 at a large pressure and .6 at a small one, all in patches of one size.
    stress = np.zeros((points.size, len(loads), STRESS_EDGES.size - 1))
    stress[:, :, 100] = 0.4 * data["pixel"][1][:, 0]
    stress[:, :, 10] = 0.6 * data["pixel"][1][:, 0]
    sizes = np.zeros((points.size, len(loads), PATCH_EDGES.size - 1))
    sizes[:, :, 80] = data["pixel"][1][:, 0]
    for name, values in (
        ("stress", stress),
        ("load", stress / stress.sum(axis=2, keepdims=True)),
        ("patch_area", sizes),
        ("patch_number", sizes),
    ):
        data[f"{name}_profile"] = (("grid", "load", f"{name}_bin"), values)
    waves = solve["problem"].lengths[0] / solve["problem"].shortest
    return xr.Dataset(
        data,
        coords={
            "points": ("grid", points),
            "cells": ("grid", points**2),
            "points_per_wave": ("grid", points / waves),
            "reduced_pressure": ("load", list(loads)),
        },
        attrs={
            "rms_height": 2e-6,
            "rms_gradient": 0.1,
            "nayak": 2.0,
            "contact_modulus": 1.0,
            "full_contact_energy": 4.0,
        },
    )


def realisation(solve):
    """Number of the surface of a solve; +h and -h of a pair follow each other."""
    own = solve["problem"]
    return 2 * own.realisation + own.inverted


def block(**numbers):
    """What `beside_bem` leaves of a block."""
    areas = ("pixel", "perimeter", "pixel_bem", "perimeter_bem", "pixel_layer")
    pressures = ("pressure_half_space", "pressure_layer", "pressure_inside")
    usual = dict.fromkeys((*areas, *pressures, "seconds_bem"), 0.1) | {"gap": 0.0, "residual": 1e-9}
    usual |= {"seconds": 1.0, "peak_bytes": 1e6, "unknowns": 1e4, "converged": 1.0}
    return xr.Dataset({name: ((), float(value)) for name, value in (usual | numbers).items()})


def contact(**fields):
    """A converged result that has what is given."""
    result = SimpleNamespace(**fields)
    result.checked = lambda: result
    return result


def decided(study, data, by):
    """The finding of a study that a number decides."""
    (found,) = (one for one in study.views(data).findings if one.by == by)
    return found


def column(table, title):
    """The cells of a column of a table."""
    k = table.columns.index(title)
    return [row[k] for row in table.rows]


def numbers(text):
    """All numbers of a sentence."""
    return [float(found) for found in re.findall(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", text)]


def edge_data(*, density, slope, contour):
    """What `stress-near-zero` makes of starts of P(sigma), (surface, grid), of 16 to 128 points per wave."""
    from validation.studies import stress_near_zero

    dims = ("method", "surface", "grid")
    values = {"density_at_zero": density, "window_slope": slope, "contour_slope": contour}
    shape = np.broadcast_shapes(*(np.shape(value) for value in values.values()))
    data = {f"{name}_each": (dims, np.broadcast_to(value, shape)[None]) for name, value in values.items()}
    data["patches_each"] = (dims, np.full((1, *shape), 50.0))
    data["small_density_each"] = ((*dims, "bin"), np.ones((1, *shape, 2)))
    coords = {
        "method": ["bem"],
        "surface": np.arange(shape[0]),
        "spacing": (("method", "grid"), 1 / np.array([[16.0, 32.0, 64.0, 128.0]])),
        "stress": ("bin", [0.1, 0.2]),
        "reduced_pressure": 0.05,
    }
    return stress_near_zero.limits(xr.Dataset(data, coords=coords))
