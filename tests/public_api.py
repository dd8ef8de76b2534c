"""Every public door of `fem_contact`, with arguments it accepts; of `persson`: public_api_of_theory.py."""

import inspect

import numpy as np

import fem_contact
from fem_contact import (
    adhesion,
    area,
    bem,
    block,
    conductance,
    contact,
    creeping,
    extrapolation,
    graded,
    hardness,
    leak,
    patches,
    response,
    settings,
    sliding,
    stress,
    subsurface,
    surface,
    viscoelastic,
)

X = np.arange(12) / 12
WAVE = 0.02 * np.cos(2 * np.pi * X)[:, None] * np.cos(4 * np.pi * X)[None, :]
MESH = {"depth": 1.0, "growth": 1.5, "first_layer": 0.1}


def doors_with(common, *functions):
    """Doors by name: what a function is given beside those of the common arguments that it has."""
    doors = {}
    for entry in functions:
        function, own = entry if isinstance(entry, tuple) else (entry, {})
        parameters = inspect.signature(function).parameters
        known = set(parameters)
        if any(one.kind is one.VAR_KEYWORD for one in parameters.values()):  # options of a mesh
            known |= {*MESH, "element"}
        name = getattr(function, "__qualname__", f"{type(function).__name__}()")
        if name in doors:
            name += f" ({sum(key.startswith(name) for key in doors) + 1})"
        doors[name] = function, {key: value for key, value in common.items() if key in known} | own
    return doors


def solver_doors():
    """The public functions of `fem_contact` but for those of the block."""
    field = surface.HeightField(heights=WAVE, lengths=(1.0, 1.0))
    solid = fem_contact.Solid(young=1.0, poisson=0.3)
    half = response.HalfSpace(solid=solid)
    layer = response.BondedLayer(solid=solid, thickness=0.2)
    given = response.GivenResponse(contact_modulus=1.0, function=lambda qx, qy: 1 / (1 + np.hypot(qx, qy)))
    layered = graded.LayeredSolid(layers=[solid], thicknesses=[0.1], base=solid)
    exponential = graded.ExponentialSolid(surface=solid, bulk_young=2.0, depth=0.1)
    q = np.array([1.0, 2.0])
    result = bem.solve(field, half, mean_pressure=0.02)
    path = bem.solve_path(field, half, mean_pressures=[0.01, 0.02, 0.03])
    hard = hardness.Hardness(pressure=0.06)
    yielding = hardness.press_yielding(field, half, hardness=hard, mean_pressure=0.02)
    law = adhesion.Exponential(work=1e-4, reach=0.02)
    dugdale = adhesion.Dugdale(work=1e-4, reach=0.02, ramp=0.5)
    above = WAVE - WAVE.min()
    pressed = [bem.solve(field.resampled((n, n)), half, mean_pressure=0.02) for n in (12, 16, 24, 32)]
    areas, ones = [area.contact_areas(one, subcell=True) for one in pressed], np.ones((12, 12))
    below = {"contact": result, "response": half, "threads": 1, "depths": [0.0, 0.1]}
    prony = {"relaxed": 1.0, "moduli": (2.0,), "times": (1.0,)}
    rubber = viscoelastic.PronySolid(**prony, poisson=0.3)
    table = {"frequencies": [0.5, 5.0], "storage": [1.0, 2.0], "loss": [0.1, 0.2]}
    rough = {"q_short": 20.0, "seed": 5, "lengths": (1.0, 1.0)}
    exact = {"amplitudes": "exact", "under_resolved": False}
    grid = extrapolation.PlannedGrid(spacing=(0.01, 0.01), cells=10_000)
    common = {
        **{"surface": field, "solid": solid, "response": half, "result": result, "results": path},
        **{"heights": WAVE, "lengths": (1.0, 2.0), "shape": (12, 12), "young": 1.0, "poisson": 0.3},
        **{"contact_modulus": 1.0, "thickness": 0.2, "qx": q, "qy": q, "frequency": q, "areas": areas},
        **{"tolerance": 1e-6, "max_iterations": 200, "threads": 1, "time_limit": 5.0, "law": law},
        **{"spacing": 0.1, "gap": WAVE, "axis": "y", "depths": [0.05, 0.1], "contact": result},
    }
    return doors_with(
        common,
        fem_contact.Solid,
        (fem_contact.composite_modulus, {"first": solid, "second": solid}),
        settings.Settings,
        *(surface.HeightField, surface.Patch, surface.Patch(heights=WAVE, lengths=(1.0, 1.0)).resampled),
        *(field.resampled, (field.shifted, {"fraction": (0.5, 0.5)})),
        (field.spectral_sum, {"weight": lambda q: q}),
        (surface.resolves, {"q_short": 9.0}),
        (surface.random_surface, rough | exact | {"spectrum": lambda q: q**-3.0}),
        (surface.random_surface, rough | {"spectrum": lambda x, y: np.exp(-x * x), "isotropic": False}),
        *(surface.measured_lay, surface.radial_spectrum),
        (surface.window_weights, {"window": "tukey", "margin": 0.2}),
        (surface.estimate_spectrum, {"window": "hann"}),
        *(response.HalfSpace, response.BondedLayer, response.FreeHalfSpace, response.FrictionlessLayer),
        *(half.compliance, layer.compliance, given.compliance, layered.compliance, exponential.compliance),
        response.FrictionlessLayer(solid=solid, thickness=0.2).compliance,
        (response.GivenResponse, {"function": given.function}),
        (graded.LayeredSolid, {"layers": [solid], "thicknesses": [0.1], "base": solid}),
        (graded.ExponentialSolid, {"surface": solid, "bulk_young": 2.0, "depth": 0.1, "sublayers": 8}),
        (exponential.young, {"depth": q}),
        (bem.solve, {"mean_pressure": 0.02, "pressure_bound": 0.06, "method": "double", "start": ones}),
        (bem.solve, {"response": layer, "mean_pressure": 0.02}),
        (bem.solve, {"response": response.FreeHalfSpace(solid=solid), "mean_pressure": 0.02}),
        (bem.solve_displacement, {"mean_gap": 0.01, "pressure_bound": 0.2}),
        (bem.solve_displacement, {"response": layer, "offset": 0.01}),
        (bem.solve_path, {"mean_pressures": [0.01, 0.02], "pressure_bound": 0.2}),
        (hardness.Hardness, {"pressure": 1.0, "length": 0.1, "exponent": 0.5}),
        (hardness.press_yielding, {"hardness": hard, "mean_pressure": 0.02}),
        (hardness.yielded, {"contact": yielding}),
        (adhesion.Exponential, {"work": 1.0, "reach": 1.0}),
        (adhesion.Dugdale, {"work": 1.0, "reach": 1.0, "ramp": 0.5}),
        *(getattr(law, name) for name in ("energy", "traction", "slope", "on_grid")),
        *(getattr(dugdale, name) for name in ("energy", "traction", "slope", "on_grid")),
        adhesion.cells_in_process_zone,
        (adhesion.solve, {"mean_pressure": 0.01, "hardness": 0.5, "start": above}),
        (adhesion.solve, {"offset": 0.03}),
        (adhesion.stability, {"state": adhesion.solve(field, half, law=law, mean_pressure=0.01)}),
        (adhesion.follow, {"offsets": [0.08, 0.06], "resolution": 0.01, "least_jump": 0.5}),
        (adhesion.follow, {"mean_pressures": [0.01, 0.012], "start": above}),
        (
            contact.measure_residuals,
            {"pressure": result.pressure, "gap": result.gap, "lengths": (1.0, 1.0), "rms_gradient": 0.3}
            | {"target_pressure": 0.02, "at_bound": result.at_bound, "weights": ones},
        ),
        (area.contact_areas, {"edge_constant": 0.1, "subcell": True, "edge_map": area.EDGE_MAPS["bem"]}),
        (area.subgrid_shifts, {"per_axis": 2}),
        (area.mean_areas, {"areas": areas[:1] * 2}),
        area.contact_edges,
        (area.subcell_area, {"edge_map": area.EDGE_MAPS["bem"]}),
        (extrapolation.PlannedGrid, {"spacing": (1.0, 1.0), "cells": 9, "solves": 1}),
        *(extrapolation.located_limit, extrapolation.perimeter_limit, extrapolation.too_small),
        (extrapolation.predicted_uncertainty, {"coarse": areas[0], "grids": [grid, grid]}),
        (patches.find_patches, {"in_contact": WAVE > 0, "spacing": (1.0, 1.0)}),
        (stress.pressure_distribution, {"edges": [0.0, 0.1, 0.2]}),
        (stress.gap_distribution, {"edges": [0.0, 0.1, 0.2]}),
        (stress.density_at_zero, {}),
        (stress.window_slope, {"window": (0.1, 0.4), "bins": 5}),
        *(stress.elastic_energy, stress.loading_work, stress.contact_stiffness),
        (stress.von_mises, {"tensor": np.ones((4, 6))}),
        *(subsurface.fields_below, subsurface.planes_below, subsurface.strongest_point),
        (lambda **told: list(subsurface.planes_below(**told)), below),
        (subsurface.default_depths, {"response": layer}),
        conductance.frozen_contact,
        (conductance.contact_conductance, {"stiffness": 2.0, "resistivities": (1.0, 0.0)}),
        *(leak.open_gap, leak.critical_gap, leak.flow_conductance),
        (leak.percolates, {"open_cells": WAVE > 0, "axis": "x"}),
        (viscoelastic.PronySolid, prony),
        (viscoelastic.PronySolid.standard, {"relaxed": 1.0, "unrelaxed": 3.0, "time": 1.0}),
        *(rubber.modulus, (rubber.creep_compliance, {"time": 1.0})),
        (viscoelastic.TabulatedSolid, table),
        viscoelastic.TabulatedSolid(**table, poisson=0.3).modulus,
        (sliding.slide, {"solid": rubber, "velocity": 0.1, "mean_pressure": 0.02, "start": ones}),
        (creeping.creep, {"solid": rubber, "times": (0.0, 1.0), "mean_pressure": 0.02}),
    )


def block_doors():
    """The public functions of `fem_contact.block`."""
    solid = fem_contact.Solid(young=1.0, poisson=0.3)
    common = MESH | {
        **{"surface": surface.HeightField(heights=WAVE, lengths=(1.0, 1.0)), "solid": solid},
        **{"method": "reduced", "modulus": None, "tolerance": 1e-6, "max_iterations": 50, "element": "Hex1"},
        **{"shape": (12, 12), "lengths": (1.0, 1.0), "poisson": 0.3},
    }
    load = {"mean_pressure": 0.01, "pressure_bound": 0.5, "start": WAVE > 0}
    planned = block.plan_mesh((12, 12), (1.0, 1.0))
    sideways = {"modulus": lambda x, y, z: 1 + 0.5 * np.cos(2 * np.pi * x) + 0 * y + 0 * z}
    held = {name: common[name] for name in ("surface", "solid", "tolerance", "element", *MESH)}
    waves = {"qx": np.array([1.0, 2.0]), "qy": np.array([1.0, 2.0])}
    return doors_with(
        common,
        *((block.solve, load), (block.solve, load | {"method": "full"})),
        (block.solve, load | sideways | {"growth": 4.0, "first_layer": 0.25}),
        (block.solve, load | {"element": "Hex2/P1disc"}),
        *((block.solve_displacement, {"offset": 0.005, "method": name}) for name in ("reduced", "full")),
        (block.solve_path, {"mean_pressures": [0.01, 0.02]}),
        (lambda **told: list(block.solve_path(**told)), held | {"mean_pressures": [0.01, 0.02]}),
        (block.solve_finite_strain, {"mean_pressure": 0.01}),
        (block.solve_slopes, {"mean_pressure": 0.01, "slopes": [0.1]}),
        (block.estimate, {"method": "full"}),
        (block.plan_mesh, {"element": block.ELEMENTS["Hex1"]}),
        (block.BlockResponse, {"mesh": planned, "width": 0.1, "layer_modulus": np.ones(planned.nz)}),
        (block.BlockResponse(mesh=planned, solid=solid, width=1 / 12).compliance, waves),
        (block.assembled_field, {"solution": block.solve(**held, mean_pressure=0.01), "tolerance": 1e-8}),
        (block.graded_layers, {"depth": 8.0, "first": 1.0, "growth": 1.2}),
        (block.wave_errors, {"wavelengths": [1.0, 0.25]}),
    )
