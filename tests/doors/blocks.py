"""Doors of `fem_contact.block`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import fem_contact
from fem_contact import (
    block,
)
from fem_contact import surface as surfaces

Door = tuple[Callable[..., Any], dict[str, Any]]


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
        "block.graded_layers": (block.graded_layers, {"depth": 8.0, "first": 1.0, "growth": 1.2}),
        "block.wave_errors": (
            block.wave_errors,
            plan | mesh | {"wavelengths": [1.0, 0.25], "poisson": 0.3, "element": "Hex1"},
        ),
    }
