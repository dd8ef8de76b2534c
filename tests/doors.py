"""Every public door of `fem_contact`, with arguments it accepts; of `persson`: doors_of_theory.py."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import fem_contact
from fem_contact import (
    adhesion,
    area,
    bem,
    block,
    conductance,
    extrapolation,
    graded,
    hardness,
    leak,
    patches,
    response,
    settings,
    stress,
    subsurface,
)
from fem_contact import contact as contact_module
from fem_contact import sliding as steady_sliding
from fem_contact import surface as surfaces
from fem_contact import viscoelastic as viscoelastic_solids

Door = tuple[Callable[..., Any], dict[str, Any]]


def solver_doors() -> dict[str, Door]:
    """The doors of `fem_contact` but for those of the block."""
    x = np.arange(12) / 12
    wave = 0.02 * np.cos(2 * np.pi * x)[:, None] * np.cos(4 * np.pi * x)[None, :]
    surface = surfaces.HeightField(heights=wave, lengths=(1.0, 1.0))
    solid = fem_contact.Solid(young=1.0, poisson=0.3)
    half = response.HalfSpace(solid=solid)
    layer = response.BondedLayer(solid=solid, thickness=0.2)
    q = np.array([1.0, 2.0])
    result = bem.solve(surface, half, mean_pressure=0.02)
    path = bem.solve_path(surface, half, mean_pressures=[0.01, 0.02, 0.03])
    yielding = hardness.press_yielding(
        surface, half, hardness=hardness.Hardness(pressure=0.06), mean_pressure=0.02
    )
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
    below = {"contact": result, "response": half, "threads": 1}
    slid = {name: value for name, value in solve.items() if name != "response"}
    prony = {"relaxed": 1.0, "moduli": (2.0,), "times": (1.0,), "poisson": 0.3}
    rubber = viscoelastic_solids.PronySolid(**prony)
    table = {"frequencies": [0.5, 5.0], "storage": [1.0, 2.0], "loss": [0.1, 0.2], "poisson": 0.3}
    grid = extrapolation.PlannedGrid(spacing=(0.01, 0.01), cells=10_000)
    return {
        "Solid": (fem_contact.Solid, {"young": 1.0, "poisson": 0.3}),
        "composite_modulus": (fem_contact.composite_modulus, {"first": solid, "second": solid}),
        "Settings": (
            settings.Settings,
            {"tolerance": 1e-8, "max_iterations": 9, "time_limit": 1.0, "threads": 1},
        ),
        "HeightField": (surfaces.HeightField, {"heights": wave, "lengths": (1.0, 2.0)}),
        "Patch": (surfaces.Patch, {"heights": wave, "lengths": (1.0, 2.0)}),
        "Patch.resampled": (
            surfaces.Patch(heights=wave, lengths=(1.0, 1.0)).resampled,
            {"shape": (6, 7)},
        ),
        "HeightField.resampled": (surface.resampled, {"shape": (6, 7)}),
        "HeightField.shifted": (surface.shifted, {"fraction": (0.5, 0.5)}),
        "HeightField.spectral_sum": (surface.spectral_sum, {"weight": lambda q: q}),
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
        "measured_lay": (surfaces.measured_lay, {"surface": surface}),
        "random_surface with a lay": (
            surfaces.random_surface,
            {
                "spectrum": lambda qx, qy: np.hypot(2 * qx, qy) ** -3.0,
                "q_short": 20.0,
                "lengths": (1.0, 1.0),
                "shape": (12, 12),
                "seed": 5,
                "isotropic": False,
            },
        ),
        "radial_spectrum": (surfaces.radial_spectrum, {"surface": surface}),
        "window_weights": (surfaces.window_weights, {"shape": (8, 8), "window": "tukey", "margin": 0.2}),
        "estimate_spectrum": (
            surfaces.estimate_spectrum,
            {"heights": wave, "lengths": (1.0, 1.0), "window": "hann"},
        ),
        "HalfSpace": (response.HalfSpace, {"solid": solid}),
        "HalfSpace.compliance": (half.compliance, {"qx": q, "qy": q}),
        "BondedLayer": (response.BondedLayer, {"solid": solid, "thickness": 0.2}),
        "BondedLayer.compliance": (layer.compliance, {"qx": q, "qy": q}),
        "FreeHalfSpace": (response.FreeHalfSpace, {"solid": solid}),
        "FrictionlessLayer": (response.FrictionlessLayer, {"solid": solid, "thickness": 0.2}),
        "FrictionlessLayer.compliance": (
            response.FrictionlessLayer(solid=solid, thickness=0.2).compliance,
            {"qx": q, "qy": q},
        ),
        "GivenResponse": (
            response.GivenResponse,
            {"contact_modulus": 1.0, "function": lambda qx, qy: 1 / (1 + np.hypot(qx, qy))},
        ),
        "GivenResponse.compliance": (
            response.GivenResponse(
                contact_modulus=1.0, function=lambda qx, qy: 1 / (1 + np.hypot(qx, qy))
            ).compliance,
            {"qx": q, "qy": q},
        ),
        "LayeredSolid": (graded.LayeredSolid, {"layers": [solid], "thicknesses": [0.1], "base": solid}),
        "LayeredSolid.compliance": (
            graded.LayeredSolid(layers=[solid], thicknesses=[0.1], base=solid).compliance,
            {"qx": q, "qy": q},
        ),
        "ExponentialSolid": (
            graded.ExponentialSolid,
            {"surface": solid, "bulk_young": 2.0, "depth": 0.1, "sublayers": 8},
        ),
        "ExponentialSolid.compliance": (
            graded.ExponentialSolid(surface=solid, bulk_young=2.0, depth=0.1).compliance,
            {"qx": q, "qy": q},
        ),
        "ExponentialSolid.young_at": (
            graded.ExponentialSolid(surface=solid, bulk_young=2.0, depth=0.1).young,
            {"depth": q},
        ),
        "bem.solve": (bem.solve, solve | field | {"mean_pressure": 0.02}),
        "bem.solve of a layer": (bem.solve, solve | {"response": layer, "mean_pressure": 0.02}),
        "bem.solve of a patch": (
            bem.solve,
            solve | {"response": response.FreeHalfSpace(solid=solid), "mean_pressure": 0.02},
        ),
        "bem.solve_displacement": (bem.solve_displacement, solve | {"mean_gap": 0.01, "pressure_bound": 0.2}),
        "bem.solve_displacement of a layer": (
            bem.solve_displacement,
            solve | {"response": layer, "offset": 0.01},
        ),
        "bem.solve_path": (bem.solve_path, solve | {"mean_pressures": [0.01, 0.02], "pressure_bound": 0.2}),
        "Hardness": (hardness.Hardness, {"pressure": 1.0}),
        "press_yielding": (
            hardness.press_yielding,
            solve | {"hardness": hardness.Hardness(pressure=0.06), "mean_pressure": 0.02},
        ),
        "unload": (
            hardness.unload,
            {
                "contact": yielding,
                "response": half,
                "mean_pressures": [0.01],
                "tolerance": 1e-6,
                "threads": 1,
            },
        ),
        "yielded": (hardness.yielded, {"contact": yielding}),
        "Exponential": (adhesion.Exponential, {"work": 1.0, "reach": 1.0}),
        "Exponential.energy": (law.energy, {"gap": wave}),
        "Exponential.traction": (law.traction, {"gap": wave}),
        "Exponential.slope": (law.slope, {"gap": wave}),
        "Exponential.on_grid": (law.on_grid, {"spacing": 0.1, "contact_modulus": 1.0}),
        "Dugdale": (adhesion.Dugdale, {"work": 1.0, "reach": 1.0, "ramp": 0.5}),
        "Dugdale.energy": (dugdale.energy, {"gap": wave}),
        "Dugdale.traction": (dugdale.traction, {"gap": wave}),
        "Dugdale.slope": (dugdale.slope, {"gap": wave}),
        "Dugdale.on_grid": (dugdale.on_grid, {"spacing": 0.1, "contact_modulus": 1.0}),
        "cells_in_process_zone": (
            adhesion.cells_in_process_zone,
            {"law": law, "spacing": 0.1, "contact_modulus": 1.0},
        ),
        "adhesion.solve": (
            adhesion.solve,
            solve | {"law": law, "mean_pressure": 0.01, "hardness": 0.5, "start": wave - wave.min()},
        ),
        "adhesion.solve at an offset": (adhesion.solve, solve | {"law": law, "offset": 0.03}),
        "stability": (adhesion.stability, {"state": state, "response": half, "steps": 10, "seed": 3}),
        "follow": (
            adhesion.follow,
            solve | {"law": law, "offsets": [0.08, 0.06], "resolution": 0.01, "least_jump": 0.5},
        ),
        "follow under loads": (
            adhesion.follow,
            solve | {"law": law, "mean_pressures": [0.01, 0.012], "start": wave - wave.min()},
        ),
        "measure_residuals": (
            contact_module.measure_residuals,
            fields
            | scales
            | {"target_pressure": 0.02, "at_bound": result.at_bound, "weights": np.ones((12, 12))},
        ),
        "contact_areas": (
            area.contact_areas,
            {"result": result, "edge_constant": 0.1, "subcell": True, "edge_map": area.EDGE_MAPS["bem"]},
        ),
        "limit_area": (
            extrapolation.limit_area,
            {"areas": areas, "definition": "pixel", "known_constant": (0.1, 0.01)},
        ),
        "subgrid_shifts": (area.subgrid_shifts, {"per_axis": 2}),
        "mean_areas": (area.mean_areas, {"areas": areas[:1] * 2}),
        "contact_edges": (area.contact_edges, {"result": result}),
        "subcell_area": (area.subcell_area, {"result": result, "edge_map": area.EDGE_MAPS["bem"]}),
        "PlannedGrid": (extrapolation.PlannedGrid, {"spacing": (1.0, 1.0), "cells": 9, "solves": 1}),
        "located_limit": (extrapolation.located_limit, {"areas": areas}),
        "perimeter_limit": (extrapolation.perimeter_limit, {"areas": areas}),
        "too_small": (extrapolation.too_small, {"areas": areas}),
        "predicted_uncertainty": (
            extrapolation.predicted_uncertainty,
            {"coarse": areas[0], "grids": [grid, grid]},
        ),
        "find_patches": (
            patches.find_patches,
            {"in_contact": wave > 0, "spacing": (1.0, 1.0), "diagonal": True},
        ),
        "pressure_distribution": (stress.pressure_distribution, {"result": result, "edges": [0.0, 0.1, 0.2]}),
        "density_at_zero": (stress.density_at_zero, {"result": result, "factor": 0.2}),
        "limit_density": (stress.limit_density, {"densities": densities}),
        "initial_slope": (stress.initial_slope, {"result": result, "window": (0.1, 0.4), "bins": 5}),
        "refined_edges": (stress.refined_edges, {"top": 1.0, "bins": 5, "power": 2.0}),
        "gap_distribution": (stress.gap_distribution, {"result": result, "edges": [0.0, 0.1, 0.2]}),
        "elastic_energy": (stress.elastic_energy, {"result": result}),
        "loading_work": (stress.loading_work, {"results": path}),
        "von_mises": (stress.von_mises, {"tensor": np.ones((4, 6))}),
        "fields_below": (subsurface.fields_below, below | {"depths": [0.0, 0.1]}),
        "planes_below": (subsurface.planes_below, below | {"depths": [0.0, 0.1]}),
        "planes_below, walked": (
            lambda **given: list(subsurface.planes_below(**given)),
            below | {"depths": [0.0, 0.1]},
        ),
        "strongest_point": (subsurface.strongest_point, below | {"depths": [0.05, 0.1]}),
        "default_depths": (subsurface.default_depths, {"contact": result, "response": layer}),
        "ExponentialSolid.sublayer_edges": (
            graded.ExponentialSolid(surface=solid, bulk_young=2.0, depth=0.1).sublayer_edges,
            {"q": q},
        ),
        "contact_stiffness": (stress.contact_stiffness, {"results": path}),
        "frozen_contact": (
            conductance.frozen_contact,
            {"result": result, "response": half, "tolerance": 1e-6, "max_iterations": 99, "threads": 1},
        ),
        "contact_conductance": (
            conductance.contact_conductance,
            {"stiffness": 2.0, "contact_modulus": 1.0, "resistivities": (1.0, 0.0)},
        ),
        "open_gap": (leak.open_gap, {"result": result}),
        "percolates": (leak.percolates, {"open_cells": wave > 0, "axis": "x"}),
        "critical_gap": (leak.critical_gap, {"gap": wave, "axis": "y"}),
        "flow_conductance": (leak.flow_conductance, {"gap": wave, "lengths": (1.0, 2.0), "axis": "y"}),
        "PronySolid": (viscoelastic_solids.PronySolid, prony),
        "PronySolid.standard": (
            viscoelastic_solids.PronySolid.standard,
            {"relaxed": 1.0, "unrelaxed": 3.0, "time": 1.0, "poisson": 0.3},
        ),
        "PronySolid.modulus": (rubber.modulus, {"frequency": q}),
        "TabulatedSolid": (viscoelastic_solids.TabulatedSolid, table),
        "TabulatedSolid.modulus": (viscoelastic_solids.TabulatedSolid(**table).modulus, {"frequency": q}),
        "slide": (
            steady_sliding.slide,
            {
                **slid,
                "solid": rubber,
                "velocity": 0.1,
                "mean_pressure": 0.02,
                "start": np.ones((12, 12)),
            },
        ),
    }


def block_doors() -> dict[str, Door]:
    """The doors of `fem_contact.block`."""
    x = np.arange(12) / 12
    wave = 0.02 * np.cos(2 * np.pi * x)[:, None] * np.cos(4 * np.pi * x)[None, :]
    mesh = {"depth": 1.0, "growth": 1.5, "first_layer": 0.1}
    plan = {"shape": (12, 12), "lengths": (1.0, 1.0)}
    held = {
        "surface": surfaces.HeightField(heights=wave, lengths=(1.0, 1.0)),
        "solid": fem_contact.Solid(young=1.0, poisson=0.3),
        "method": "reduced",
        "modulus": None,
        "tolerance": 1e-6,
        "max_iterations": 50,
        "element": "Hex1",
    } | mesh
    load = {"mean_pressure": 0.01, "pressure_bound": 0.5, "start": wave > 0}
    steep = {name: held[name] for name in ("surface", "solid", "tolerance", "element", *mesh)}
    steep["mean_pressure"] = load["mean_pressure"]
    planned = block.plan_mesh((12, 12), (1.0, 1.0))
    sideways = {
        "modulus": lambda x, y, z: 1 + 0.5 * np.cos(2 * np.pi * x) + 0 * y + 0 * z,
        "growth": 4.0,
        "first_layer": 0.25,
    }
    return {
        "block.solve": (block.solve, held | load),
        "block.solve of the full system": (block.solve, held | load | {"method": "full"}),
        "block.solve of a modulus that varies sideways": (block.solve, held | load | sideways),
        "block.solve of triquadratic cells": (block.solve, held | load | {"element": "Hex2/P1disc"}),
        "block.solve_displacement": (block.solve_displacement, held | {"offset": 0.005}),
        "block.solve_displacement of the full system": (
            block.solve_displacement,
            held | {"method": "full", "offset": 0.005},
        ),
        "block.solve_path": (block.solve_path, held | {"mean_pressures": [0.01, 0.02]}),
        "block.solve_finite_strain": (block.solve_finite_strain, steep),
        "block.solve_slopes": (block.solve_slopes, steep | {"slopes": [0.1]}),
        "block.solve_path, walked": (
            lambda **given: list(block.solve_path(**given)),
            held | {"mean_pressures": [0.01, 0.02]},
        ),
        "block.estimate": (
            block.estimate,
            plan | mesh | {"method": "full", "poisson": 0.3, "element": "Hex1"},
        ),
        "block.plan_mesh": (block.plan_mesh, plan | mesh | {"element": block.ELEMENTS["Hex1"]}),
        "BlockResponse": (
            block.BlockResponse,
            {"mesh": planned, "solid": held["solid"], "width": 0.1, "layer_modulus": np.ones(planned.nz)},
        ),
        "BlockResponse.compliance": (
            block.BlockResponse(mesh=planned, solid=held["solid"], width=1 / 12).compliance,
            {"qx": np.array([1.0, 2.0]), "qy": np.array([1.0, 2.0])},
        ),
        "block.assembled_field": (
            block.assembled_field,
            {"solution": block.solve(**held, mean_pressure=0.01), "tolerance": 1e-8},
        ),
        "block.graded_layers": (block.graded_layers, {"depth": 8.0, "first": 1.0, "growth": 1.2}),
        "block.wave_errors": (
            block.wave_errors,
            plan | mesh | {"wavelengths": [1.0, 0.25], "poisson": 0.3, "element": "Hex1"},
        ),
    }
