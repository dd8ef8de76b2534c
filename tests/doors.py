"""Every public door of `fem_contact` and `persson`, each with arguments it accepts."""

from __future__ import annotations

import math
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
from persson import adhesion as theory_adhesion
from persson import (
    archard,
    asperities,
    capillary,
    diffusion,
    elastic,
    elastoplastic_asperities,
    flaw_tolerance,
    gaps,
    heights,
    leakage,
    limits,
    percolation,
    plate,
    scale,
    separation,
    sine,
    sliding,
    soft_structures,
    spectrum,
    spheres,
    squeezed_spheres,
    stretched,
    tabulated,
    tensile,
    variants,
    viscoelastic,
)
from persson import graded as theory_graded
from persson import hardness as theory_hardness

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
        "press": (
            hardness.press,
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


def paper_doors(one: Any, rough: Any, bent: Any, summits: Any, sticky: Any) -> dict[str, Door]:
    """Doors to what the paper says in passing."""
    rubber = {"relaxed": 1e6, "unrelaxed": 1e9, "time": 1e-3}
    sphere = {"force": 1e-4, "radius": 1e-3, "contact_modulus": 1e10}
    told = {"pressure": 1e6, "scale": one, "energy_ratio": 0.5}
    hard = viscoelastic.StandardSolid(**rubber)
    thin = {"young": 1e9, "poisson": 0.3, "thickness": 1e-6}
    smooth = rough.scaled(1e-4)
    return {
        "elastic_energy": (separation.elastic_energy, told | {"energy": "old"}),
        "contact_stiffness": (separation.contact_stiffness, told),
        "gap_distribution": (gaps.gap_distribution, told | {"gap": 1e-8}),
        "macroasperity_pressure": (
            separation.macroasperity_pressure,
            {"spectrum": bent, "pressure": 1e6, "contact_modulus": 1e9, "q_reference": 1e5},
        ),
        "adhesion_load": (
            tensile.adhesion_load,
            {"pressure": 1e5, "stress_variance": 1e12, "tensile_limit": 1e6},
        ),
        "archard_hierarchy": (
            archard.archard_hierarchy,
            {"force": 1.0, "radii": [1e-2, 1e-4], "densities": [1e8], "contact_modulus": 1e9},
        ),
        "height_distribution": (heights.height_distribution, {"height": 1e-9, "rms_height": 1e-9}),
        "yielding_asperities": (
            elastoplastic_asperities.yielding_asperities,
            {"separation": 1e-7, "asperities": summits, "contact_modulus": 1e9, "hardness": 1e8},
        ),
        "percolation_magnification": (
            percolation.percolation_magnification,
            {"scale": one, "pressure": 1e6, "q_reference": 1e5, "threshold": 0.3},
        ),
        "ElasticPlate": (plate.ElasticPlate, thin),
        "ElasticPlate()": (plate.ElasticPlate(**thin), {"wavevector": 1e6}),
        "crack_stress": (
            flaw_tolerance.crack_stress,
            {"work": 0.05, "contact_modulus": 1e9, "length": 1e-9},
        ),
        "flaw_tolerant_gradient": (
            flaw_tolerance.flaw_tolerant_gradient,
            {"work_of_adhesion": 0.05, "ideal_strength": 1e8, "poisson": 0.3, "alpha": 1.0},
        ),
        "optimal_modulus": (
            flaw_tolerance.optimal_modulus,
            {
                "spectrum": smooth,
                "pressure": 0.0,
                "tensile_limit": 1e5,
                "interface": sticky,
                "nodes": 40,
                "tolerance": 1e-3,
            },
        ),
        "StandardSolid": (viscoelastic.StandardSolid, rubber),
        "StandardSolid.loss_compliance": (hard.loss_compliance, {"frequency": 10.0}),
        "crack_dissipation": (
            viscoelastic.crack_dissipation,
            {
                "velocity": 1e-3,
                "loss_compliance": hard.loss_compliance,
                "relaxed": 1e6,
                "tip_radius": 1e-9,
                "contact_size": 1e-5,
            },
        ),
        "foam_modulus": (
            soft_structures.foam_modulus,
            {"young": 1e9, "wall": 1e-7, "cell": 1e-6, "factor": 1.0},
        ),
        "fibre_modulus": (
            soft_structures.fibre_modulus,
            {"young": 1e9, "radius": 1e-6, "length": 1e-4, "density": 1e10, "angle": 0.7},
        ),
        "nominal_shear_stress": (
            sliding.nominal_shear_stress,
            {"area": 0.1, "local_shear_stress": 1e7},
        ),
        "local_shear_stress": (
            sliding.local_shear_stress,
            {"nominal": 1e6, "pressure": 1e7, "hardness": 1e8},
        ),
        "StandardSolid.modulus": (hard.modulus, {"frequency": 1.0}),
        "rubber_friction": (
            sliding.rubber_friction,
            {
                "spectrum": smooth,
                "pressure": 1e6,
                "velocity": 0.1,
                "modulus": hard.modulus,
                "poisson": 0.3,
                "energy_ratio": 0.5,
            },
        ),
        "friction_of_waves": (
            sliding.friction_of_waves,
            {
                "qx": [1e6, -1e6],
                "qy": [0.0, 0.0],
                "power": [1e-18, 1e-18],
                "pressure": 1e6,
                "velocity": 0.1,
                "modulus": hard.modulus,
                "poisson": 0.3,
                "energy_ratio": 0.5,
            },
        ),
        "slip_energy": (sliding.slip_energy, {"shear_stress": 1e7, "slip": 3e-10}),
        "adhesional_pressure": (sliding.adhesional_pressure, {"barrier": 0.016, "lift": 1e-12}),
        "hertz_pressure": (squeezed_spheres.hertz_pressure, sphere),
        "yielded_share": (squeezed_spheres.yielded_share, sphere | {"hardness": 1e9}),
        "yielded_pull_off": (
            squeezed_spheres.yielded_pull_off,
            sphere | {"hardness": 1e9, "work_of_adhesion": 0.05},
        ),
        "roughness_barrier": (
            squeezed_spheres.roughness_barrier,
            {
                "spectrum": smooth,
                "contact_modulus": 1e9,
                "pressure": 1e6,
                "yield_stress": 1e8,
                "interface": sticky,
                "nodes": 40,
            },
        ),
    }


def theory_doors() -> dict[str, Door]:
    """The doors of `persson`."""
    rough = spectrum.SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=1e6)
    bent = spectrum.SelfAffine.from_rms_gradient(
        0.1, hurst=0.8, q_long=1e5, q_short=1e7, rolloff="smooth", q_min=1e4
    )
    table = tabulated.Tabulated(wavevectors=[1e5, 2e5, 1e6], power=[3e-28, 2e-28, 1e-29])
    waves = {
        "temperature": 370.0,
        "surface_tension": 0.04,
        "q_bend": 1.7e9,
        "q_min": 6.28e4,
        "q_short": 7e9,
        "q_gravity": 0.0,
        "multiple": 1.0,
    }
    moments = rough.moments()
    summits = asperities.nayak_asperities(moments)
    one = scale.Scale(rough, contact_modulus=1e9)
    sticky = theory_adhesion.Interface(work_of_adhesion=0.05)
    pressed = theory_adhesion.solve_adhesion(one, pressure=1e6, interface=sticky)
    diffused = diffusion.solve_diffusion([1.0, 4.0], pressure=1.0)
    sines = sine.sine_expansion(1.0, pressure=1.0, tensile_limit=0.5, yield_stress=4.0, modes=20)
    double = spheres.DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    hertz = spheres.hertz(1.0, radius=1e-2, contact_modulus=1e9)
    tabor = asperities.FullerTabor(asperities=summits, contact_modulus=1e9, work_of_adhesion=0.05)
    power = {"hurst": 0.8, "q_long": 1e5, "q_short": 1e6, "rolloff": "smooth", "q_min": 1e4}
    load = {"pressure": 1.0, "stress_variance": 2.0}
    layers = {"bulk": 1e9, "excess": [1e9], "depths": [1e-6], "poisson": 0.3}
    single = {"layer": 1e9, "bulk": 2e9, "thickness": 1e-6, "poisson": 0.3}
    deep = {"young": lambda z: 1e9 * np.exp(0 * z), "poisson": 0.3, "breaks": (1e-6,)}
    doors: dict[str, Door] = {
        "SelfAffine": (spectrum.SelfAffine, power | {"amplitude": 1e-27}),
        "SelfAffine.from_rms_height": (spectrum.SelfAffine.from_rms_height, power | {"rms_height": 1e-6}),
        "SelfAffine.from_rms_gradient": (
            spectrum.SelfAffine.from_rms_gradient,
            power | {"rms_gradient": 0.1},
        ),
        "CapillaryWaves": (capillary.CapillaryWaves, waves),
        "maximum_height": (capillary.maximum_height, {"independent_points": 1e6}),
        "Stretched": (
            stretched.Stretched,
            {"spectrum": spectrum.SelfAffine(**power, amplitude=1.0), "factor": 2.0},
        ),
        "Stretched.directional": (
            stretched.Stretched(spectrum=spectrum.SelfAffine(**power, amplitude=1.0), factor=2.0).directional,
            {"qx": 1e5, "qy": np.array([1e5, 2e5])},
        ),
        "Stretched.m2": (
            stretched.Stretched(spectrum=spectrum.SelfAffine(**power, amplitude=1.0), factor=2.0).m2,
            {"q_upper": 2e5},
        ),
        "Tabulated": (tabulated.Tabulated, {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]}),
        "Tabulated.from_areal_psd": (
            tabulated.Tabulated.from_areal_psd,
            {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]},
        ),
        "smoothed": (
            tabulated.smoothed,
            {
                "spectrum": rough,
                "wavevectors": [1e5, 2e5, 5e5],
                "yielded": [0.0, 0.2, 0.6],
                "form": "gradual",
            },
        ),
        "area_factor": (spectrum.area_factor, {"m2": 0.1}),
        "stress_variance": (elastic.stress_variance, {"m2": 0.1, "contact_modulus": 1e9}),
        "diffusion_parameter": (elastic.diffusion_parameter, load),
        "contact_area": (elastic.contact_area, load),
        "non_contact_area": (elastic.non_contact_area, load),
        "pressure_for_area": (elastic.pressure_for_area, {"area": 0.1, "stress_variance": 1.0}),
        "area_against_magnification": (
            elastic.area_against_magnification,
            {
                "spectrum": rough,
                "pressure": 1e6,
                "contact_modulus": 1e9,
                "magnification": 5.0,
                "q_reference": 1e5,
            },
        ),
        "pressure_distribution": (elastic.pressure_distribution, load | {"stress": 1.0}),
        "initial_slope": (elastic.initial_slope, load),
        "reduced_pressure": (
            elastic.reduced_pressure,
            {"pressure": 1.0, "contact_modulus": 1e3, "rms_gradient": 0.1},
        ),
        "kappa": (elastic.kappa, {"area": 0.1, "reduced_pressure": 0.05}),
        "persson_kappa": (elastic.persson_kappa, {"reduced_pressure": 0.05}),
        "Scale": (scale.Scale, {"spectrum": rough, "contact_modulus": 1e9}),
        "Scale graded": (scale.Scale, {"spectrum": rough, "contact_modulus": lambda q: 1e9 + 0 * q}),
        "Scale.modulus": (one.modulus, {"q": 2e5}),
        "Scale.variance": (one.variance, {"q": 2e5}),
        "Scale.wavevector": (one.wavevector, {"variance": 1e14}),
        "mean_separation": (separation.mean_separation, {"pressure": 1e6, "scale": one, "energy_ratio": 0.5}),
        **paper_doors(one, rough, bent, summits, sticky),
        "macroasperity_magnification": (
            separation.macroasperity_magnification,
            {"spectrum": bent, "pressure": 1e6, "contact_modulus": 1e9, "q_reference": 1e5},
        ),
        "energy_factor": (
            variants.energy_factor,
            {"area": 0.1, "variant": "yang_persson", "energy_ratio": 0.4},
        ),
        "energy_share": (variants.energy_share, load | {"energy": "xu"}),
        "energy_share of Eq. 48": (variants.energy_share, load | {"energy": "improved"}),
        "light_load_kappa": (variants.light_load_kappa, {"variant": "xu", "energy_ratio": 0.4}),
        "corrected_contact_area": (
            variants.corrected_contact_area,
            load | {"variant": "wang_mueser", "energy_ratio": 0.4},
        ),
        "corrected_contact_area of Xu": (
            variants.corrected_contact_area,
            load | {"variant": "xu", "energy_ratio": 0.4},
        ),
        "constant_hardness": (theory_hardness.constant_hardness, load | {"yield_stress": 5.0}),
        "size_dependent_hardness": (
            theory_hardness.size_dependent_hardness,
            {
                "scale": one,
                "pressure": 1e6,
                "yield_stress": lambda q: 1e9 + 0 * q,
                "wavevectors": [2e5, 1e6],
                "tolerance": 1e-4,
            },
        ),
        "nix_gao_hardness": (theory_hardness.nix_gao_hardness, {"depth": 1e-6, "bulk": 1e8, "length": 1e-6}),
        "solve_diffusion": (
            diffusion.solve_diffusion,
            {
                "variance": [1.0, 4.0],
                "pressure": 1.0,
                "tensile_limit": 0.5,
                "yield_stress": 9.0,
                "breaks": (2.0,),
                "tolerance": 1e-4,
                "modes": None,
                "step": None,
            },
        ),
        "solve_diffusion on given steps": (
            diffusion.solve_diffusion,
            {
                "variance": [1.0, 4.0],
                "pressure": 1.0,
                "tensile_limit": lambda v: 0.5 + 0 * v,
                "modes": 30,
                "step": 0.1,
            },
        ),
        "Diffusion.distribution": (diffused.distribution, {"index": 0, "stress": 1.0}),
        "sine_expansion": (
            sine.sine_expansion,
            {
                "variance": 1.0,
                "pressure": 1.0,
                "tensile_limit": 0.5,
                "yield_stress": 4.0,
                "modes": 20,
                "tolerance": 1e-6,
            },
        ),
        "sine_expansion of moving walls": (
            sine.sine_expansion,
            {
                "variance": 1.0,
                "pressure": 1.0,
                "tensile_limit": lambda v: 0.5,
                "yield_stress": lambda v: 4.0,
                "modes": 10,
            },
        ),
        "SineExpansion.distribution": (sines.distribution, {"stress": 1.0}),
        "Interface": (
            theory_adhesion.Interface,
            {"work_of_adhesion": 0.05, "energy": "old", "area": "star", "alpha": 1.0, "ideal_strength": 1e9},
        ),
        "detachment_stress": (
            theory_adhesion.detachment_stress,
            {"work": 0.05, "contact_modulus": 1e9, "wavevector": 1e6, "interface": sticky},
        ),
        "crossover_length": (
            theory_adhesion.crossover_length,
            {"work_of_adhesion": 0.05, "contact_modulus": 1e11, "atomic_distance": 7e-10},
        ),
        "opening_work": (theory_adhesion.opening_work, {"work_of_adhesion": 0.05, "dissipation": 1.0}),
        "closing_work": (theory_adhesion.closing_work, {"work_of_adhesion": 0.05, "dissipation": 1.0}),
        "solve_adhesion": (
            theory_adhesion.solve_adhesion,
            {
                "scale": one,
                "pressure": 1e6,
                "interface": sticky,
                "yield_stress": 1e9,
                "start": pressed,
                "tolerance": 1e-3,
                "rounds": 20,
            },
        ),
        "AdhesiveContact.distribution": (pressed.distribution, {"index": 3, "stress": 1.0}),
        "AdhesiveContact.area_at": (pressed.area_at, {"wavevector": 2e5}),
        "AdhesiveContact.work_at": (pressed.work_at, {"wavevector": 2e5}),
        "effective_medium": (
            leakage.effective_medium,
            {"conductances": [0.0, 1.0, 2.0], "shares": [0.2, 0.5, 0.3]},
        ),
        "pull_off_stress": (limits.pull_off_stress, {"scale": one, "interface": sticky, "tolerance": 0.1}),
        "critical_roughness": (
            limits.critical_roughness,
            {"spectrum": rough, "contact_modulus": 1e6, "interface": sticky, "tolerance": 0.5},
        ),
        "GradedModulus": (theory_graded.GradedModulus, deep),
        "GradedModulus()": (theory_graded.GradedModulus(**deep), {"wavevector": 1e6}),
        "ExponentialLayers": (theory_graded.ExponentialLayers, layers),
        "ExponentialLayers()": (theory_graded.ExponentialLayers(**layers), {"wavevector": 1e6}),
        "ExponentialLayers.young": (theory_graded.ExponentialLayers(**layers).young, {"depth": 1e-6}),
        "SurfaceLayer": (theory_graded.SurfaceLayer, single),
        "SurfaceLayer()": (theory_graded.SurfaceLayer(**single), {"wavevector": 1e6}),
        "Asperities": (asperities.Asperities, {"density": 1e10, "radius": 1e-6, "rms_height": 1e-7}),
        "Asperities.contact": (summits.contact, {"separation": 1e-7, "contact_modulus": 1e9}),
        "Asperities.contact_at": (summits.contact_at, {"pressure": 1e6, "contact_modulus": 1e9}),
        "ring_asperities": (asperities.ring_asperities, {"wavevector": 1e6, "rms_height": 1e-7}),
        "nayak_asperities": (asperities.nayak_asperities, {"moments": moments}),
        "bush_gibson_thomas": (
            asperities.bush_gibson_thomas,
            {"separation": 1e-7, "moments": moments, "contact_modulus": 1e9},
        ),
        "FullerTabor": (
            asperities.FullerTabor,
            {"asperities": summits, "contact_modulus": 1e9, "work_of_adhesion": 0.05},
        ),
        "FullerTabor.pressure": (tabor.pressure, {"separation": 1e-7}),
        "effective_radius": (spheres.effective_radius, {"first": 1.0, "second": 2.0}),
        "hertz": (spheres.hertz, {"force": 1.0, "radius": 1e-2, "contact_modulus": 1e9}),
        "HertzContact.pressure": (hertz.pressure, {"distance": 1e-5}),
        "hertz_pressure_distribution": (
            spheres.hertz_pressure_distribution,
            {"stress": 1.0, "peak_pressure": 2.0},
        ),
        "jkr_load": (
            spheres.jkr_load,
            {"contact_radius": 1e-3, "radius": 1.0, "contact_modulus": 1e6, "work_of_adhesion": 0.05},
        ),
        "jkr_pull_off": (spheres.jkr_pull_off, {"radius": 1.0, "work_of_adhesion": 0.05}),
        "derjaguin_pull_off": (spheres.derjaguin_pull_off, {"radius": 1.0, "work_of_adhesion": 0.05}),
        "tabor_parameter": (
            spheres.tabor_parameter,
            {"radius": 1.0, "contact_modulus": 1e6, "work_of_adhesion": 0.05, "range_": 1e-9},
        ),
        "maugis_pull_off": (spheres.maugis_pull_off, {"tabor": 1.0}),
        "DoubleHertz": (spheres.DoubleHertz, {"peak_pressure": 1.0, "tensile_limit": 0.3, "eta": 1.1}),
        "DoubleHertz.pressure": (double.pressure, {"distance": 0.5}),
        "DoubleHertz.load": (double.load, {"contact_radius": 1.0}),
        "DoubleHertz.contact_force": (double.contact_force, {"contact_radius": 1.0}),
        "DoubleHertz.distribution": (double.distribution, {"stress": 0.5}),
    }
    for name, kind in (
        ("SelfAffine", bent),
        ("CapillaryWaves", capillary.CapillaryWaves(**waves)),
        ("Tabulated", table),
    ):
        doors |= {
            f"{name}()": (kind, {"q": 2e5}),
            f"{name}.truncated": (kind.truncated, {"q_max": math.sqrt(kind.q_long * kind.q_short)}),
            f"{name}.scaled": (kind.scaled, {"factor": 2.0}),
            f"{name}.m0": (kind.m0, {"q_upper": 2e5}),
            f"{name}.m2": (kind.m2, {"q_upper": 2e5}),
            f"{name}.m4": (kind.m4, {"q_upper": 2e5}),
            f"{name}.moments": (kind.moments, {"q_upper": 2e5}),
        }
    return doors
