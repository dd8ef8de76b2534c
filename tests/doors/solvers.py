"""Doors of `fem_contact` but for those of the block."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

import fem_contact
from fem_contact import (
    adhesion,
    area,
    bem,
    extrapolation,
    graded,
    hardness,
    patches,
    response,
    settings,
    stress,
)
from fem_contact import contact as contact_module
from fem_contact import surface as surfaces

Door = tuple[Callable[..., Any], dict[str, Any]]


def solver_doors() -> dict[str, Door]:
    """Return all of them."""
    given = _solver_given()
    groups = (
        _solver_of_solids,
        _solver_of_surfaces,
        _solver_of_graded,
        _solver_of_pressing,
        _solver_of_adhesion,
        _solver_of_areas,
        _solver_of_stress,
    )
    return {name: door for group in groups for name, door in group(given).items()}


def _solver_given() -> SimpleNamespace:
    """Return what the doors are handed, made once."""
    x = np.arange(12) / 12
    wave = 0.02 * np.cos(2 * np.pi * x)[:, None] * np.cos(4 * np.pi * x)[None, :]
    surface = surfaces.HeightField(heights=wave, lengths=(1.0, 1.0))
    solid = fem_contact.Solid(young=1.0, poisson=0.3)
    half = response.HalfSpace(solid=solid)
    layer = response.BondedLayer(solid=solid, thickness=0.2)
    q = np.array([1.0, 2.0])
    result = bem.solve(surface, half, mean_pressure=0.02)
    path = bem.solve_path(surface, half, mean_pressures=[0.01, 0.02, 0.03])
    yielding = hardness.press(surface, half, hardness=hardness.Hardness(pressure=0.06), mean_pressure=0.02)
    law = adhesion.Exponential(work=1e-4, reach=0.02)
    dugdale = adhesion.Dugdale(work=1e-4, reach=0.02, ramp=0.5)
    state = adhesion.solve(surface, half, law=law, mean_pressure=0.01)
    areas = [
        area.contact_areas(bem.solve(surface.resampled((n, n)), half, mean_pressure=0.02), subcell=True)
        for n in (12, 16, 24, 32)
    ]
    densities = [
        stress.DensityAtZero(density=1.0, reduced=0.5 * dx**0.5, threshold=0.1, points=20, spacing=dx)
        for dx in (1.0, 0.5, 0.25)
    ]
    fields = {"pressure": result.pressure, "gap": result.gap, "heights": wave}
    scales = {"lengths": (1.0, 1.0), "contact_modulus": 1.0, "rms_gradient": 0.3}
    solve = {
        "surface": surface,
        "response": half,
        "tolerance": 1e-6,
        "max_iterations": 200,
        "threads": 1,
        "time_limit": 5.0,
    }
    field = {"pressure_bound": 0.06, "start": np.ones((12, 12)), "method": "preconditioned"}
    grid = extrapolation.PlannedGrid(spacing=(0.01, 0.01), cells=10_000)
    return SimpleNamespace(
        areas=areas,
        densities=densities,
        dugdale=dugdale,
        field=field,
        fields=fields,
        grid=grid,
        half=half,
        law=law,
        layer=layer,
        path=path,
        q=q,
        result=result,
        scales=scales,
        solid=solid,
        solve=solve,
        state=state,
        surface=surface,
        wave=wave,
        x=x,
        yielding=yielding,
    )


def _solver_of_solids(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "Solid": (fem_contact.Solid, {"young": 1.0, "poisson": 0.3}),
        "composite_modulus": (fem_contact.composite_modulus, {"first": given.solid, "second": given.solid}),
        "Settings": (
            settings.Settings,
            {"tolerance": 1e-8, "max_iterations": 9, "time_limit": 1.0, "threads": 1},
        ),
        "HalfSpace": (response.HalfSpace, {"solid": given.solid}),
        "HalfSpace.compliance": (given.half.compliance, {"qx": given.q, "qy": given.q}),
        "BondedLayer": (response.BondedLayer, {"solid": given.solid, "thickness": 0.2}),
        "BondedLayer.compliance": (given.layer.compliance, {"qx": given.q, "qy": given.q}),
        "FrictionlessLayer": (response.FrictionlessLayer, {"solid": given.solid, "thickness": 0.2}),
        "FrictionlessLayer.compliance": (
            response.FrictionlessLayer(solid=given.solid, thickness=0.2).compliance,
            {"qx": given.q, "qy": given.q},
        ),
        "GivenResponse": (
            response.GivenResponse,
            {"contact_modulus": 1.0, "function": lambda qx, qy: 1 / (1 + np.hypot(qx, qy))},
        ),
        "GivenResponse.compliance": (
            response.GivenResponse(
                contact_modulus=1.0, function=lambda qx, qy: 1 / (1 + np.hypot(qx, qy))
            ).compliance,
            {"qx": given.q, "qy": given.q},
        ),
    }


def _solver_of_surfaces(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "HeightField": (surfaces.HeightField, {"heights": given.wave, "lengths": (1.0, 2.0)}),
        "HeightField.resampled": (given.surface.resampled, {"shape": (6, 7)}),
        "HeightField.shifted": (given.surface.shifted, {"fraction": (0.5, 0.5)}),
        "HeightField.spectral_sum": (given.surface.spectral_sum, {"weight": lambda q: q}),
        "resolves": (surfaces.resolves, {"shape": (8, 8), "lengths": (1.0, 1.0), "q_short": 9.0}),
        "random_surface": (
            surfaces.random_surface,
            {
                "spectrum": lambda q: q**-3.0,
                "q_short": 20.0,
                "lengths": (1.0, 1.0),
                "shape": (12, 12),
                "seed": 5,
                "amplitudes": "exact",
                "under_resolved": False,
            },
        ),
        "radial_spectrum": (surfaces.radial_spectrum, {"surface": given.surface}),
        "window_weights": (surfaces.window_weights, {"shape": (8, 8), "window": "tukey", "margin": 0.2}),
        "estimate_spectrum": (
            surfaces.estimate_spectrum,
            {"heights": given.wave, "lengths": (1.0, 1.0), "window": "hann"},
        ),
    }


def _solver_of_graded(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "LayeredSolid": (
            graded.LayeredSolid,
            {"layers": [given.solid], "thicknesses": [0.1], "base": given.solid},
        ),
        "LayeredSolid.compliance": (
            graded.LayeredSolid(layers=[given.solid], thicknesses=[0.1], base=given.solid).compliance,
            {"qx": given.q, "qy": given.q},
        ),
        "ExponentialSolid": (
            graded.ExponentialSolid,
            {"surface": given.solid, "bulk_young": 2.0, "depth": 0.1, "sublayers": 8},
        ),
        "ExponentialSolid.compliance": (
            graded.ExponentialSolid(surface=given.solid, bulk_young=2.0, depth=0.1).compliance,
            {"qx": given.q, "qy": given.q},
        ),
        "ExponentialSolid.young_at": (
            graded.ExponentialSolid(surface=given.solid, bulk_young=2.0, depth=0.1).young,
            {"depth": given.q},
        ),
    }


def _solver_of_pressing(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "bem.solve": (bem.solve, given.solve | given.field | {"mean_pressure": 0.02}),
        "bem.solve of a layer": (bem.solve, given.solve | {"response": given.layer, "mean_pressure": 0.02}),
        "bem.solve_displacement": (
            bem.solve_displacement,
            given.solve | {"mean_gap": 0.01, "pressure_bound": 0.2},
        ),
        "bem.solve_displacement of a layer": (
            bem.solve_displacement,
            given.solve | {"response": given.layer, "offset": 0.01},
        ),
        "bem.solve_path": (
            bem.solve_path,
            given.solve | {"mean_pressures": [0.01, 0.02], "pressure_bound": 0.2},
        ),
        "Hardness": (hardness.Hardness, {"pressure": 1.0}),
        "press": (
            hardness.press,
            given.solve | {"hardness": hardness.Hardness(pressure=0.06), "mean_pressure": 0.02},
        ),
        "unload": (
            hardness.unload,
            {
                "contact": given.yielding,
                "response": given.half,
                "mean_pressures": [0.01],
                "tolerance": 1e-6,
                "threads": 1,
            },
        ),
        "yielded": (hardness.yielded, {"contact": given.yielding}),
    }


def _solver_of_adhesion(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "Exponential": (adhesion.Exponential, {"work": 1.0, "reach": 1.0}),
        "Exponential.energy": (given.law.energy, {"gap": given.wave}),
        "Exponential.traction": (given.law.traction, {"gap": given.wave}),
        "Exponential.slope": (given.law.slope, {"gap": given.wave}),
        "Exponential.on_grid": (given.law.on_grid, {"spacing": 0.1, "contact_modulus": 1.0}),
        "Dugdale": (adhesion.Dugdale, {"work": 1.0, "reach": 1.0, "ramp": 0.5}),
        "Dugdale.energy": (given.dugdale.energy, {"gap": given.wave}),
        "Dugdale.traction": (given.dugdale.traction, {"gap": given.wave}),
        "Dugdale.slope": (given.dugdale.slope, {"gap": given.wave}),
        "Dugdale.on_grid": (given.dugdale.on_grid, {"spacing": 0.1, "contact_modulus": 1.0}),
        "cells_in_process_zone": (
            adhesion.cells_in_process_zone,
            {"law": given.law, "spacing": 0.1, "contact_modulus": 1.0},
        ),
        "adhesion.solve": (
            adhesion.solve,
            given.solve
            | {
                "law": given.law,
                "mean_pressure": 0.01,
                "hardness": 0.5,
                "start": given.wave - given.wave.min(),
            },
        ),
        "adhesion.solve at an offset": (adhesion.solve, given.solve | {"law": given.law, "offset": 0.03}),
        "stability": (
            adhesion.stability,
            {"state": given.state, "response": given.half, "steps": 10, "seed": 3},
        ),
        "follow": (
            adhesion.follow,
            given.solve | {"law": given.law, "offsets": [0.08, 0.06], "resolution": 0.01, "least_jump": 0.5},
        ),
        "follow under loads": (
            adhesion.follow,
            given.solve
            | {"law": given.law, "mean_pressures": [0.01, 0.012], "start": given.wave - given.wave.min()},
        ),
    }


def _solver_of_areas(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "measure_residuals": (
            contact_module.measure_residuals,
            given.fields
            | given.scales
            | {"target_pressure": 0.02, "at_bound": given.result.at_bound, "weights": np.ones((12, 12))},
        ),
        "contact_areas": (
            area.contact_areas,
            {
                "result": given.result,
                "edge_constant": 0.1,
                "subcell": True,
                "edge_map": area.EDGE_MAPS["bem"],
            },
        ),
        "limit_area": (
            area.limit_area,
            {"areas": given.areas, "definition": "pixel", "known_constant": (0.1, 0.01)},
        ),
        "subgrid_shifts": (area.subgrid_shifts, {"per_axis": 2}),
        "mean_areas": (area.mean_areas, {"areas": given.areas[:1] * 2}),
        "contact_edges": (area.contact_edges, {"result": given.result}),
        "subcell_area": (area.subcell_area, {"result": given.result, "edge_map": area.EDGE_MAPS["bem"]}),
        "PlannedGrid": (extrapolation.PlannedGrid, {"spacing": (1.0, 1.0), "cells": 9, "solves": 1}),
        "located_limit": (extrapolation.located_limit, {"areas": given.areas}),
        "counted_limit": (extrapolation.counted_limit, {"areas": given.areas}),
        "too_small": (extrapolation.too_small, {"areas": given.areas}),
        "predicted_uncertainty": (
            extrapolation.predicted_uncertainty,
            {"coarse": given.areas[0], "grids": [given.grid, given.grid]},
        ),
        "find_patches": (
            patches.find_patches,
            {"in_contact": given.wave > 0, "spacing": (1.0, 1.0), "diagonal": True},
        ),
    }


def _solver_of_stress(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "pressure_distribution": (
            stress.pressure_distribution,
            {"result": given.result, "edges": [0.0, 0.1, 0.2]},
        ),
        "density_at_zero": (stress.density_at_zero, {"result": given.result, "factor": 0.2}),
        "limit_density": (stress.limit_density, {"densities": given.densities}),
        "initial_slope": (stress.initial_slope, {"result": given.result, "window": (0.1, 0.4), "bins": 5}),
        "refined_edges": (stress.refined_edges, {"top": 1.0, "bins": 5, "power": 2.0}),
        "gap_distribution": (stress.gap_distribution, {"result": given.result, "edges": [0.0, 0.1, 0.2]}),
        "elastic_energy": (stress.elastic_energy, {"result": given.result}),
        "loading_work": (stress.loading_work, {"results": given.path}),
        "contact_stiffness": (stress.contact_stiffness, {"results": given.path}),
    }
