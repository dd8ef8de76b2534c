"""Contacts and areas that nobody solved: what a test names, and nothing else."""

import numpy as np

from fem_contact import ContactAreas, ContactResult, Cost, Residuals, Status


def made_contact(touches, /, **changes):
    """A converged contact on a unit period, of unit pressure wherever it touches."""
    fields = dict.fromkeys(("gap", "displacement", "heights"), np.zeros(touches.shape))
    fields |= {"in_contact": touches, "at_bound": np.zeros_like(touches), "pressure": 1.0 * touches}
    numbers = {"lengths": (1.0, 1.0), "contact_modulus": 1.0, "offset": 0.0, "mean_pressure": 1.0}
    made = {
        "status": Status.CONVERGED,
        "residuals": Residuals(penetration=0.0, tension=0.0, complementarity=0.0, load=0.0),
        "cost": Cost(wall_seconds=0.1, cpu_seconds=0.2, iterations=3, unknowns=12, peak_bytes=1000),
        "provenance": {"method": "boundary elements, by hand"},
    }
    return ContactResult(**(fields | numbers | made | changes))


def made_areas(value, n, fraction, **changes):
    """An area on n x n points of a unit period, counted and located alike, with that many edges."""
    areas = {"pixel": value, "perimeter": value, "subcell": value, "cells": n * n, "spacing": (1 / n, 1 / n)}
    edges = {"edge_length": fraction * n, "edge_fraction": fraction, "edge_constant": 0.1}
    return ContactAreas(**(areas | edges | changes))
